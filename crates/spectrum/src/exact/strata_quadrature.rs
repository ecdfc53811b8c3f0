use glam::DVec3;
use sphvar_healpix::{Cell, Nside};
use sphvar_samplers::{Domain, Region, Strata};

use super::partition::StratumShape;
use crate::Error;

/// Quadrature rules on the strata of a stratified pattern, one stratum at a time.
///
/// A pattern with one uniform point in each stratum has, without rotation, the variance
/// `(area/N)^2 sum_k Var_k F`, where `Var_k` is the variance of F at a uniform point of stratum k:
/// the points are independent.
///
/// # Examples
///
/// ```
/// use sphvar_samplers::{Domain, Pattern, SetDistribution};
/// use sphvar_spectrum::StrataQuadrature;
///
/// let jittered = Pattern::Jittered.build(48, Domain::Sphere)?;
/// let SetDistribution::Stratified(strata) = jittered.distribution() else { unreachable!() };
/// let strata = StrataQuadrature::new(strata, Domain::Sphere).unwrap();
/// // The mean of z over each of 48 cells adds up to 0.
/// let mean = |k| {
///     let (points, weights) = strata.rule(k, 4)?;
///     Ok::<f64, sphvar_spectrum::Error>(points.iter().zip(weights).map(|(p, w)| w * p.z).sum())
/// };
/// let sum = (0..48).map(mean).sum::<Result<f64, _>>()?;
/// assert!(strata.count() == 48 && sum.abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct StrataQuadrature {
    strata: List,
}

#[derive(Clone, Debug)]
enum List {
    /// The cells of the first base faces.
    Healpix {
        nside: Nside,
        faces: usize,
    },
    Regions(Vec<Region>),
}

impl StrataQuadrature {
    /// Returns the rules on the strata of a pattern on this domain, in the order of its points;
    /// `None` for unknown kinds of strata.
    #[must_use]
    pub fn new(strata: Strata<'_>, domain: Domain) -> Option<Self> {
        let strata = match strata {
            Strata::Healpix(nside) => {
                // The first six faces have one of each pair of antipodal cells.
                let faces = if domain == Domain::Sphere { 12 } else { 6 };
                List::Healpix { nside, faces }
            }
            Strata::EqualArea(regions) => List::Regions(regions.regions().collect()),
            // Kinds of strata added later need their rules here.
            _ => return None,
        };
        Some(Self { strata })
    }

    /// Returns the number of strata.
    #[must_use]
    pub fn count(&self) -> usize {
        match &self.strata {
            List::Healpix { nside, faces } => faces * (nside.value() as usize).pow(2),
            List::Regions(regions) => regions.len(),
        }
    }

    /// Returns nodes and weights, with sum 1, for the mean over the stratum `index` of functions
    /// that are smooth there, to rounding for harmonics up to `degree`. On the hemisphere some
    /// nodes have z < 0; their antipodes represent the same lines.
    ///
    /// # Errors
    ///
    /// [`Error::Transform`] if the rule has too many nodes.
    ///
    /// # Panics
    ///
    /// Panics if `index` is not below [`count`](Self::count).
    pub fn rule(&self, index: usize, degree: usize) -> Result<(Vec<DVec3>, Vec<f64>), Error> {
        let shape = match &self.strata {
            List::Healpix { nside, .. } => StratumShape::of_cell(nth_cell(*nside, index)?),
            List::Regions(regions) => StratumShape::Region(regions[index]),
        };
        let rule = shape.quadrature(degree)?;
        Ok((rule.points, rule.weights))
    }
}

/// Returns the cell of this number, face by face.
fn nth_cell(nside: Nside, index: usize) -> Result<Cell, Error> {
    let n = nside.value() as usize;
    let (face, within) = (index / (n * n), index % (n * n));
    let narrow = |x: usize| u32::try_from(x).unwrap_or(u32::MAX);
    let cell = Cell::new(
        nside,
        u8::try_from(face).unwrap_or(u8::MAX),
        narrow(within % n),
        narrow(within / n),
    );
    Ok(cell.expect("the index is below the number of strata"))
}
