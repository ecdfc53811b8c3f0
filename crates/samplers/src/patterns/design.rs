use std::fmt;
use std::sync::OnceLock;

use glam::DVec3;
use rand::Rng;
use sphvar_grammar::{Declaration, Parametric};

use crate::definition::Definition;
use crate::optimization::design::{
    DesignEquations, default_count, design_points, equations_by_count, equations_of, expected_work,
    valid_counts,
};
use crate::{
    CostOrder, Domain, Error, PatternFacts, PointSet, Progress, Rate, Sampler, SetDistribution,
    ValidCounts, count,
};

/// A spherical design: N points whose mean is that of the sphere for every polynomial up to a degree
/// t (Delsarte, Goethals and Seidel 1977), so that no realization has power at the degrees 1 to t.
///
/// Designs have about `(t + 1)^2/2` points, the number at which there are as many degrees of freedom
/// as equations. Symmetric designs consist of pairs of antipodes and have an odd degree; they take
/// about `(t^2 + t)/2` points and have no power at any odd degree. On the hemisphere, points stand
/// for such pairs.
///
/// Designs of degrees up to 32 are stored at their default number of points. Others are computed,
/// always with the same result and once for each sampler, by Levenberg-Marquardt steps with dense
/// matrices or by conjugate gradients on fast transforms, whichever is expected to take less time.
/// Near the default number of points the time grows as t^6, to minutes at t = 64; with 10 % more
/// points little faster than N.
///
/// ```
/// use sphvar_samplers::{Design, Domain, Purpose, Sampler, Streams};
/// let icosahedron = Design::new(12, Domain::Sphere, Some(5), false)?;
/// assert_eq!(icosahedron.last_empty_degree(), Some(5));
/// let set = icosahedron.sample(&mut Streams::new(0, Purpose::Pattern, 12).realization(0))?;
/// // The mean of z^4 is 1/5.
/// let mean = set.points.iter().map(|p| p.z.powi(4)).sum::<f64>() / 12.0;
/// assert!((mean - 0.2).abs() < 1e-14);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
///
/// # References
///
/// Hardin and Sloane 1996, doi:10.1007/BF02711518, for the numbers of points of small designs;
/// Womersley 2018, doi:10.1007/978-3-319-72456-0_57, for designs to degree 325.
#[derive(Clone)]
pub struct Design {
    n: u32,
    domain: Domain,
    equations: DesignEquations,
    /// The points that are computed, after the first call that needs them.
    points: OnceLock<Vec<DVec3>>,
}

impl fmt::Debug for Design {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { n, domain, equations, .. } = self;
        write!(f, "Design {{ n: {n}, domain: {domain:?}, equations: {equations:?} }}")
    }
}

impl Design {
    /// Returns the design of a degree; if not given, the degree follows from the number of points:
    /// the largest one up to degree 12 and for the stored designs, otherwise the largest for which
    /// at most nine tenths of the 2N coordinates are constrained.
    ///
    /// The points are pairs of antipodes if `is_symmetric`, and also where other sets with this
    /// number of points have no such degree. `is_symmetric` has no effect on the hemisphere.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`; [`Error::Infeasible`] with
    /// valid numbers of points if no design is available, or none of an odd number of points in
    /// pairs.
    pub fn new(
        n_points: usize,
        domain: Domain,
        degree: Option<usize>,
        is_symmetric: bool,
    ) -> Result<Self, Error> {
        let n = count::checked(n_points)?;
        let infeasible = |reason| Error::Infeasible { pattern: "design", n_points, reason };
        if is_symmetric && domain == Domain::Sphere && n_points % 2 == 1 {
            return Err(infeasible("pairs of antipodes have an even number of points".to_owned()));
        }
        let equations = match degree {
            Some(degree) => equations_of(degree, n_points, domain, is_symmetric),
            None => equations_by_count(n_points, domain, is_symmetric),
        };
        let equations = equations.ok_or_else(|| {
            let degree = degree.unwrap_or_default();
            let counts = valid_counts(degree, domain, is_symmetric);
            infeasible(format!("no design of degree {degree} is available; N must be {counts}"))
        })?;
        Ok(Self { n, domain, equations, points: OnceLock::new() })
    }

    /// Returns whether the points are pairs of antipodes of the sphere.
    fn is_in_pairs(&self) -> bool {
        self.domain == Domain::Sphere && self.equations.is_symmetric
    }

    /// Returns the number of points that are computed.
    fn n_unknown(&self) -> usize {
        if self.is_in_pairs() { self.n_points() / 2 } else { self.n_points() }
    }
}

impl Sampler for Design {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        SetDistribution::Fixed
    }

    fn last_empty_degree(&self) -> Option<usize> {
        let DesignEquations { degree, is_symmetric } = self.equations;
        Some(match self.domain {
            Domain::Hemisphere => degree - degree % 2,
            // Pairs of antipodes have no power at odd degrees.
            Domain::Sphere if is_symmetric => degree | 1,
            Domain::Sphere => degree,
        })
    }

    fn nominal_work(&self) -> f64 {
        expected_work(self.equations, self.n_unknown())
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        _: &mut dyn Rng,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        progress.tick(0.0)?;
        let points = set.start();
        let computed = match self.points.get() {
            Some(computed) => computed,
            None => {
                let computed = design_points(self.equations, self.n_unknown(), progress)?;
                // Another thread may have computed the same points.
                self.points.get_or_init(|| computed)
            }
        };
        points.extend_from_slice(computed);
        if self.is_in_pairs() {
            points.extend_from_within(..);
            points[self.n_unknown()..].iter_mut().for_each(|p| *p = -*p);
        }
        for p in points {
            *p = self.domain.representative(*p);
        }
        Ok(())
    }
}

/// Parameters of the pattern [`Design`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DesignParameters {
    /// The degree; if not given, it follows from the number of points.
    pub degree: Option<u32>,
    /// Whether the points are pairs of antipodes.
    pub is_symmetric: bool,
}

impl DesignParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { degree: None, is_symmetric: false };

    /// The largest degree: its points and their coordinates stay within the index of transforms.
    const MAX_DEGREE: i64 = 4_000;

    /// Returns the degree, if it is given.
    fn given_degree(self) -> Option<usize> {
        self.degree.map(|degree| degree as usize)
    }

    /// Returns the number of points of the stored or otherwise smallest set without special
    /// symmetry, if the degree is given.
    fn own_count(self, domain: Domain) -> Option<usize> {
        let is_symmetric = self.is_symmetric || domain == Domain::Hemisphere;
        let n = default_count(DesignEquations { degree: self.given_degree()?, is_symmetric });
        Some(if self.is_symmetric && domain == Domain::Sphere { 2 * n } else { n })
    }
}

impl Default for DesignParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for DesignParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "degree to which polynomials are integrated exactly";
        d.optional_integer("t", [1, Self::MAX_DEGREE], summary, "by N", &mut self.degree);
        d.choice("symmetric", "whether points are pairs of antipodes", &mut self.is_symmetric);
    }
}

impl Definition for DesignParameters {
    fn facts(&self) -> PatternFacts {
        let exponent = if self.is_symmetric { 1.15 } else { 1.09 };
        PatternFacts {
            // The expected work between 10^3 and 10^6 points where they determine the degree; stored
            // designs take hardly any time.
            cost: CostOrder { exponent, logarithm: 0.0, factor: "" },
            low_degrees: "0 for l to about 1.3 sqrt(N)",
            smooth_rate: Rate::Exact,
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Delsarte, Goethals and Seidel 1977; Womersley 2018",
        }
    }

    fn valid_counts(&self, domain: Domain) -> ValidCounts {
        match self.given_degree() {
            Some(degree) => valid_counts(degree, domain, self.is_symmetric),
            None if self.is_symmetric && domain == Domain::Sphere => {
                ValidCounts::AtLeast { first: 2, step: 2 }
            }
            None => ValidCounts::Any,
        }
    }

    fn default_count(&self, domain: Domain) -> Option<usize> {
        self.own_count(domain)
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let degree = self.given_degree();
        Ok(Box::new(Design::new(n_points, domain, degree, self.is_symmetric)?))
    }
}
