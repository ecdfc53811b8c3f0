use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use glam::DQuat;
use sphvar_grammar::split_outside;
use sphvar_warps::{Oriented, Warp};

use super::WarpTerm;
use super::env::{EnvironmentWarpParameters, angle_about_pole};
use crate::functions::rotation_to_angles;
use crate::named_terms::of_term;
use crate::{Domain, Error, Expression, Factor, IntegrandResolver, Strategy, Summand};

/// A named warp after some rotations.
pub type WarpFactor = Factor<WarpTerm>;

/// One or several densities from which an integral is sampled, such as `vmf:kappa=50 @ 40/10` or
/// `0.3 * cosine + 0.7 * env:sky.exr`.
///
/// A sum is several strategies (multiple importance sampling), each with its own points; the numbers
/// are their shares of the points, in proportion, and equal by default. A product is a map times the
/// cosine about its pole, `env:FILE * cosine`. The grammar is that of [`Expression`].
///
/// On the hemisphere, `cylinder`, `octahedral`, `cap` and maps are those of z >= 0. Warps after rotations that
/// move +z are those of the sphere; integrands count as 0 below the horizon.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{Domain, NoFiles, WarpExpression};
///
/// let expression: WarpExpression = "1 * cosine + 3 * vmf:kappa=50 @ 40/10".parse()?;
/// let strategies = expression.strategies(Domain::Sphere, &NoFiles)?;
/// assert_eq!(strategies[1].share, 0.75);
/// assert!(strategies[1].warp.map([0.0, 0.0]).z > 0.7);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct WarpExpression {
    /// The weights are the shares, in proportion; 1 for a single warp.
    sum: Expression<WarpFactor>,
}

impl WarpExpression {
    /// The maximum number of warps in a sum: each is evaluated at the points of all others.
    pub const MAX_STRATEGIES: usize = 64;

    /// Returns the number of warps, each of which has its own points.
    #[must_use]
    pub fn n_strategies(&self) -> usize {
        self.sum.summands.len()
    }

    /// Returns all named warps.
    pub fn terms(&self) -> impl Iterator<Item = &WarpTerm> {
        self.sum.summands.iter().flat_map(|summand| &summand.factors).map(|factor| &factor.term)
    }

    /// Returns the shares of the points, which sum to 1.
    #[must_use]
    pub fn shares(&self) -> Vec<f64> {
        let weights = || self.sum.summands.iter().map(|summand| summand.weight);
        // Scaled first, because the sum may overflow.
        let max = weights().fold(0.0, f64::max);
        let total: f64 = weights().map(|weight| weight / max).sum();
        weights().map(|weight| weight / max / total).collect()
    }

    /// Returns the same warps with other shares of the points, of any sum.
    ///
    /// # Errors
    ///
    /// [`Error::Shares`] unless there is a positive number for every warp.
    pub fn with_shares(&self, shares: &[f64]) -> Result<Self, Error> {
        if shares.len() != self.n_strategies() {
            let reason =
                format!("{} shares given, but it has {}", shares.len(), self.n_strategies());
            return Err(Error::Shares { text: self.to_string(), reason });
        }
        let mut sum = self.sum.clone();
        for (summand, &share) in sum.summands.iter_mut().zip(shares) {
            summand.weight = share;
        }
        if let [single] = &mut *sum.summands {
            single.weight = 1.0;
        }
        Self::new(sum)
    }

    /// Returns the sum of all warps of several expressions, with equal shares.
    ///
    /// # Errors
    ///
    /// [`Error::Shares`] if there are none, or more than [`MAX_STRATEGIES`](Self::MAX_STRATEGIES).
    pub fn combined(expressions: &[Self]) -> Result<Self, Error> {
        let summands = expressions.iter().flat_map(|expression| &expression.sum.summands);
        let summands = summands.map(|summand| Summand { weight: 1.0, ..summand.clone() });
        Self::new(Expression { summands: summands.collect() })
    }

    /// Returns the expression with the names of files without their folders, for tables and plots.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_integrands::WarpExpression;
    ///
    /// let expression: WarpExpression = "env:maps/sky.exr,floor=0.1 * cosine".parse()?;
    /// assert_eq!(expression.shortened().to_string(), "env:sky.exr,floor=0.1 * cosine");
    /// # Ok::<(), sphvar_integrands::Error>(())
    /// ```
    #[must_use]
    pub fn shortened(&self) -> Self {
        let mut sum = self.sum.clone();
        for factor in sum.summands.iter_mut().flat_map(|summand| &mut summand.factors) {
            if let WarpTerm::Environment(map) = &mut factor.term
                && let Some(name) = map.environment.file.file_name()
            {
                map.environment.file = name.into();
            }
        }
        Self { sum }
    }

    /// Returns whether the density has the text of an integrand apart from a constant factor and the
    /// order of factors. The density is then proportional to the integrand's magnitude.
    #[must_use]
    pub fn is_density_of(&self, integrand: &Expression) -> bool {
        fn texts<F: fmt::Display>(factors: &[F]) -> Vec<String> {
            let mut texts: Vec<String> = factors.iter().map(F::to_string).collect();
            texts.sort();
            texts
        }
        match (&*self.sum.summands, &*integrand.summands) {
            ([own], [of]) => texts(&own.factors) == texts(&of.factors),
            _ => false,
        }
    }

    /// Returns the warps with their shares of the points, for an integral over a domain; `files` reads
    /// the files that they name.
    ///
    /// # Errors
    ///
    /// [`Error::OfTerm`] with the text of a warp and the reason, [`Error::File`] if `files` cannot
    /// read a file.
    pub fn strategies(
        &self,
        domain: Domain,
        files: &dyn IntegrandResolver,
    ) -> Result<Vec<Strategy>, Error> {
        let shares = self.shares().into_iter();
        let strategies = self.sum.summands.iter().zip(shares);
        strategies
            .map(|(summand, share)| Ok(Strategy { warp: summand.warp(domain, files)?, share }))
            .collect()
    }

    /// Returns one warp, a factor or a map times the cosine.
    pub(super) fn product(factors: Vec<WarpFactor>) -> Self {
        Self { sum: Expression { summands: vec![Summand { weight: 1.0, factors }] } }
    }

    /// Returns the sum after checks of all shares and products.
    fn new(sum: Expression<WarpFactor>) -> Result<Self, Error> {
        let wrong = |reason| Error::Shares { text: sum.to_string(), reason };
        if sum.summands.is_empty() || sum.summands.len() > Self::MAX_STRATEGIES {
            let (max, got) = (Self::MAX_STRATEGIES, sum.summands.len());
            return Err(wrong(format!("a sum has 1 to {max} warps, not {got}")));
        }
        for Summand { weight, factors } in &sum.summands {
            if !(*weight > 0.0 && weight.is_finite()) {
                let reason =
                    format!("a share of the points must be a positive number, got {weight}");
                return Err(wrong(reason));
            }
            match &**factors {
                [] => return Err(wrong(format!("the share {weight} has no warp"))),
                [_] => {}
                factors => _ = map_and_cosine(factors)?,
            }
        }
        Ok(Self { sum })
    }
}

impl Summand<WarpFactor> {
    fn warp(&self, domain: Domain, files: &dyn IntegrandResolver) -> Result<Arc<dyn Warp>, Error> {
        if let [single] = &*self.factors {
            return single.warp(domain, files);
        }
        let (map, rotation, cosine) = map_and_cosine(&self.factors)?;
        let product = || product_text(&self.factors);
        let warp = map.times_cosine(rotation, cosine, files);
        let warp = warp.map_err(|error| of_term(&product(), error))?;
        Ok(warp.ok_or_else(|| Error::CosineAxis { text: product() })?.into())
    }
}

/// Returns the map of a product with its rotation, and the rotation of the cosine.
fn map_and_cosine(
    factors: &[WarpFactor],
) -> Result<(&EnvironmentWarpParameters, DQuat, DQuat), Error> {
    if let [a, b] = factors {
        for (map, cosine) in [(a, b), (b, a)] {
            if let (WarpTerm::Environment(map_parameters), WarpTerm::Cosine) =
                (&map.term, &cosine.term)
            {
                return Ok((map_parameters, map.rotation(), cosine.rotation()));
            }
        }
    }
    Err(Error::NoWarp { text: product_text(factors) })
}

fn product_text(factors: &[WarpFactor]) -> String {
    factors.iter().map(WarpFactor::to_string).collect::<Vec<_>>().join(" * ")
}

impl WarpFactor {
    /// Returns the product of all rotations.
    pub(super) fn rotation(&self) -> DQuat {
        let rotations = self.rotations.iter().map(|angles| angles.map(f64::to_radians));
        rotations.fold(DQuat::IDENTITY, |before, [theta, phi, psi]| {
            (rotation_to_angles(theta, phi, psi) * before).normalize()
        })
    }

    fn warp(&self, domain: Domain, files: &dyn IntegrandResolver) -> Result<Arc<dyn Warp>, Error> {
        let rotation = self.rotation();
        if let WarpTerm::Environment(map) = &self.term {
            let warp = map.rotated(rotation, domain, files);
            return Ok(warp.map_err(|error| of_term(self, error))?.into());
        }
        // A rotation that moves +z moves the hemisphere too.
        let domain = if angle_about_pole(rotation).is_some() { domain } else { Domain::Sphere };
        let warp: Arc<dyn Warp> = self.term.build(domain, files)?.into();
        let is_rotated = !self.rotations.is_empty();
        Ok(if is_rotated { Arc::new(Oriented::new(warp, rotation)) } else { warp })
    }
}

impl FromStr for WarpExpression {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let sum: Expression<WarpFactor> = text.parse()?;
        let expression = Self::new(sum)?;
        let is_number = |factor: &str| factor.trim().parse::<f64>().is_ok();
        let has_number = |term: &str| split_outside(term, " * ").into_iter().any(is_number);
        let terms = split_outside(text, " + ");
        let n_shares = terms.iter().filter(|term| has_number(term)).count();
        let reason = match n_shares {
            0 => return Ok(expression),
            _ if terms.len() == 1 => "a single warp samples all points; remove the number",
            n if n < terms.len() => "give every warp a share of the points, or none",
            _ => return Ok(expression),
        };
        Err(Error::Shares { text: text.to_owned(), reason: reason.to_owned() })
    }
}

/// The shares are all or none, for equal ones.
impl fmt::Display for WarpExpression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let has_shares = self.sum.summands.iter().any(|s| s.weight.to_bits() != 1f64.to_bits());
        for (i, Summand { weight, factors }) in self.sum.summands.iter().enumerate() {
            f.write_str(if i > 0 { " + " } else { "" })?;
            if has_shares {
                write!(f, "{weight} * ")?;
            }
            f.write_str(&product_text(factors))?;
        }
        Ok(())
    }
}
