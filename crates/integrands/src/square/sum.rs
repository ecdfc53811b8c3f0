use std::fmt;
use std::sync::OnceLock;

use sphvar_sh::Frequencies;

use super::doubling::SquareEstimate;
use crate::{Energy, Error, Expression, IntegrandResolver, SquareIntegrand, SquareTerm, Sum, Wave};

/// A weighted sum of products of integrands on the square.
///
/// A single integrand times a weight has the energies of that integrand times the square of the
/// weight. The energies of others follow from their values, as those of an
/// [`AdaptiveSquareFunction`](crate::AdaptiveSquareFunction), with values enough for the narrowest
/// of their features: they are exact to rounding for smooth functions, otherwise they have errors.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{NoFiles, SquareExpression, SquareIntegrand};
/// use sphvar_sh::Frequencies;
///
/// let expression: SquareExpression = "2 * exponential:a=1,b=0 - wave:k1=1,k2=0".parse()?;
/// let sum = expression.build(&NoFiles)?;
/// assert!((sum.exact().unwrap() - 2.0 * 1f64.exp_m1()).abs() < 1e-14);
/// assert!(sum.energy(&Frequencies::new(8)?)?.errors().is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Default)]
pub struct SquareSum {
    terms: Vec<(f64, Vec<Box<dyn SquareIntegrand>>)>,
    estimate: OnceLock<Result<SquareEstimate, Error>>,
}

/// A sum of products of named integrands on the square, such as
/// `zone-plate * disk:radius=0.3 + 0.5 * gaussian:width=0.1`.
pub type SquareExpression = Expression<SquareTerm>;

impl SquareSum {
    /// The relative error of the energies at which the doubling stops.
    const RELATIVE: f64 = 1e-8;
    /// The values at which it stops unless narrow features need more.
    const VALUES: usize = 1 << 22;
    /// The values beyond which narrow features are not resolved.
    const MAX_VALUES: usize = 1 << 24;

    /// Returns this sum with a further term, the product of a weight and functions.
    ///
    /// # Errors
    ///
    /// [`Error::Weight`] unless the weight is 0 or [`Sum::MIN_WEIGHT`] to [`Sum::MAX_WEIGHT`] in
    /// magnitude.
    pub fn plus(
        mut self,
        weight: f64,
        factors: Vec<Box<dyn SquareIntegrand>>,
    ) -> Result<Self, Error> {
        Sum::check_weight(weight)?;
        self.terms.push((weight, factors));
        Ok(Self { terms: self.terms, estimate: OnceLock::new() })
    }

    /// Returns the weight and the integrand, if there is a single one.
    fn single(&self) -> Option<(f64, &dyn SquareIntegrand)> {
        match &self.terms[..] {
            [(weight, factors)] => match &factors[..] {
                [only] => Some((*weight, only)),
                _ => None,
            },
            _ => None,
        }
    }

    fn estimate(&self) -> Result<&SquareEstimate, Error> {
        self.estimate.get_or_init(|| self.doubled()).as_ref().map_err(Error::clone)
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, and brought into range"
    )]
    fn doubled(&self) -> Result<SquareEstimate, Error> {
        let per_side = self.feature_size().map_or(0.0, |size| 2.0 / size);
        let min = (per_side * per_side).min(1e18) as usize;
        if min > Self::MAX_VALUES {
            return Err(Error::NoEnergy {
                reason: "features narrower than 1/2048 of the square may be missed by the values of \
                         a sum or product; take wider ones",
            });
        }
        SquareEstimate::new(self, Self::RELATIVE, [min, min.max(Self::VALUES)])
    }
}

impl fmt::Debug for SquareSum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.terms.iter().map(|(weight, _)| weight)).finish()
    }
}

impl SquareIntegrand for SquareSum {
    fn eval(&self, point: [f64; 2]) -> f64 {
        let product = |(weight, factors): &(f64, Vec<Box<dyn SquareIntegrand>>)| {
            weight * factors.iter().map(|f| f.eval(point)).product::<f64>()
        };
        self.terms.iter().map(product).sum()
    }

    fn eval_into(&self, points: &[[f64; 2]], values: &mut [f64]) -> Result<(), Error> {
        // The initial value of a floating-point sum.
        values.fill(-0.0);
        let (mut product, mut of_factor) = (vec![0.0; values.len()], vec![0.0; values.len()]);
        for (weight, factors) in &self.terms {
            product.fill(1.0);
            for factor in factors {
                factor.eval_into(points, &mut of_factor)?;
                product.iter_mut().zip(&of_factor).for_each(|(product, x)| *product *= x);
            }
            values.iter_mut().zip(&product).for_each(|(sum, x)| *sum += weight * x);
        }
        Ok(())
    }

    /// Returns the sum of the integrals, or that of a product that its values resolve.
    fn exact(&self) -> Option<f64> {
        let of_term = |(weight, factors): &(f64, Vec<Box<dyn SquareIntegrand>>)| match &factors[..]
        {
            [] => Some(*weight),
            [only] => Some(weight * only.exact()?),
            _ => None,
        };
        self.terms.iter().map(of_term).sum::<Option<f64>>().or_else(|| {
            let estimate = self.estimate().ok()?;
            estimate.is_exact().then_some(estimate.integral.0)
        })
    }

    fn integral_estimate(&self) -> Option<(f64, f64)> {
        match self.exact() {
            Some(exact) => Some((exact, 0.0)),
            None => self.estimate().ok().map(|estimate| estimate.integral),
        }
    }

    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        match self.single() {
            Some((weight, only)) => Ok(only.energy(frequencies)?.of_multiple(weight)),
            None => self.estimate()?.energy(frequencies),
        }
    }

    fn kurtosis(&self) -> Option<f64> {
        match self.single() {
            Some((weight, only)) => only.kurtosis().filter(|_| weight != 0.0),
            None => self.estimate().ok()?.kurtosis,
        }
    }

    fn band_limit(&self) -> Option<usize> {
        self.single()?.1.band_limit()
    }

    fn feature_size(&self) -> Option<f64> {
        let factors = self.terms.iter().flat_map(|(_, factors)| factors);
        factors.map(|f| f.feature_size()).try_fold(1.0, |least, size| Some(size?.min(least)))
    }

    fn variation(&self) -> Option<f64> {
        let (weight, only) = self.single()?;
        Some(weight.abs() * only.variation()?)
    }
}

impl SquareExpression {
    /// Returns the function; `files` reads the files that it names.
    ///
    /// # Errors
    ///
    /// [`Error::OfTerm`] with the text of the term and the reason, [`Error::File`] if `files` cannot
    /// read a file.
    pub fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn SquareIntegrand>, Error> {
        let mut sum = SquareSum::default();
        for summand in &self.summands {
            let factors = summand.factors.iter().map(|term| term.build(files));
            let mut factors = factors.collect::<Result<Vec<_>, _>>()?;
            if let [_] = &*self.summands
                && summand.weight.to_bits() == 1f64.to_bits()
                && factors.len() == 1
            {
                // A single integrand without a weight is returned unchanged.
                return Ok(factors.remove(0));
            }
            if factors.is_empty() {
                // A product of numbers alone is a constant function.
                factors.push(Box::new(Wave::new([0, 0])?));
            }
            let with_term = sum.plus(summand.weight, factors);
            sum = with_term.map_err(|error| Error::OfTerm {
                text: self.to_string(),
                reason: Box::new(error),
            })?;
        }
        Ok(Box::new(sum))
    }
}

impl From<SquareTerm> for SquareExpression {
    fn from(term: SquareTerm) -> Self {
        Self { summands: vec![crate::Summand { weight: 1.0, factors: vec![term] }] }
    }
}
