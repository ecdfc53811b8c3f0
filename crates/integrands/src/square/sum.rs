use std::fmt;
use std::sync::OnceLock;

use sphvar_sh::{ByAxis, Frequencies};

use super::doubling::SquareEstimate;
use super::energy::energy_of_coefficients;
use crate::{
    Energy, Error, Expression, IntegrandResolver, SquareIntegrand, SquareTerm, Sum, Summand,
};

/// A weighted sum of products of integrands on the square.
///
/// Constants change no energy but that of the mean, and are apart from the other terms: integrands
/// with a band limit of 0 and a known integral, products of them, and terms without a factor. A
/// single integrand times a weight has the energies of that integrand times the square of the
/// weight. The energies of others follow from their values, as those of an
/// [`AdaptiveSquareFunction`](crate::AdaptiveSquareFunction), with values enough for the narrowest
/// of their features: they are exact to rounding for smooth functions, otherwise they have errors.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{NoFiles, SquareExpression, SquareIntegrand};
/// use sphvar_sh::{ByAxis, Frequencies};
///
/// let expression: SquareExpression = "2 * exponential:a=1,b=0 - wave:k1=1,k2=0".parse()?;
/// let sum = expression.build(&NoFiles)?;
/// assert!((sum.exact().unwrap() - 2.0 * 1f64.exp_m1()).abs() < 1e-14);
/// assert!(sum.energy(&Frequencies::new(8)?)?.errors().is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Default)]
pub struct SquareSum {
    constant: f64,
    varying: Products,
    estimate: OnceLock<Result<SquareEstimate, Error>>,
}

/// A weighted sum of products, none of which is known to be constant.
#[derive(Default)]
struct Products {
    terms: Vec<(f64, Vec<Box<dyn SquareIntegrand>>)>,
}

/// Returns the value of a function that is known to be constant.
fn constant(function: &dyn SquareIntegrand) -> Option<f64> {
    (function.band_limit()? == 0).then(|| function.exact())?
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
    /// [`Error::Weight`] unless the weight, also times the constant factors, is 0 or
    /// [`Sum::MIN_WEIGHT`] to [`Sum::MAX_WEIGHT`] in magnitude.
    pub fn plus(
        mut self,
        weight: f64,
        factors: Vec<Box<dyn SquareIntegrand>>,
    ) -> Result<Self, Error> {
        Sum::check_weight(weight)?;
        let (mut scale, mut varying) = (weight, Vec::new());
        for factor in factors {
            match constant(&factor) {
                Some(constant) => scale *= constant,
                None => varying.push(factor),
            }
        }
        Sum::check_weight(scale)?;
        // A product with 0 is 0.
        if varying.is_empty() {
            self.constant += scale;
        } else if scale != 0.0 {
            self.varying.terms.push((scale, varying));
        }
        Ok(Self { estimate: OnceLock::new(), ..self })
    }

    /// Returns the estimate of the sum without its constant.
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
        SquareEstimate::new(&self.varying, Self::RELATIVE, [min, min.max(Self::VALUES)])
    }
}

impl Products {
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

    /// Returns the sum of the integrals and of their errors, which `of` returns for every function, if
    /// all are known and there are no products of several functions.
    fn integral(
        &self,
        of: impl Fn(&dyn SquareIntegrand) -> Option<(f64, f64)>,
    ) -> Option<(f64, f64)> {
        let of_term = |(weight, factors): &(f64, Vec<Box<dyn SquareIntegrand>>)| {
            let [only] = &factors[..] else { return None };
            let (integral, error) = of(only)?;
            Some((weight * integral, weight.abs() * error))
        };
        let sum = |(a, b): (f64, f64), (c, d)| (a + c, b + d);
        self.terms.iter().try_fold((0.0, 0.0), |total, term| Some(sum(total, of_term(term)?)))
    }
}

impl fmt::Debug for SquareSum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let weights = self.varying.terms.iter().map(|(weight, _)| weight);
        f.debug_list().entry(&self.constant).entries(weights).finish()
    }
}

impl SquareIntegrand for Products {
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
}

impl SquareIntegrand for SquareSum {
    fn eval(&self, point: [f64; 2]) -> f64 {
        self.varying.eval(point) + self.constant
    }

    fn eval_into(&self, points: &[[f64; 2]], values: &mut [f64]) -> Result<(), Error> {
        self.varying.eval_into(points, values)?;
        values.iter_mut().for_each(|value| *value += self.constant);
        Ok(())
    }

    /// Returns the sum of the integrals, or that of a product that its values resolve.
    fn exact(&self) -> Option<f64> {
        let sum = self.varying.integral(|f| f.exact().map(|exact| (exact, 0.0))).or_else(|| {
            let estimate = self.estimate().ok()?;
            estimate.is_exact().then_some(estimate.integral)
        });
        sum.map(|(integral, _)| self.constant + integral)
    }

    fn integral_estimate(&self) -> Option<(f64, f64)> {
        let of_estimate = || self.estimate().ok().map(|estimate| estimate.integral);
        let (integral, error) =
            self.varying.integral(|f| f.integral_estimate()).or_else(of_estimate)?;
        Some((self.constant + integral, error))
    }

    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        let varying = match self.varying.single() {
            _ if self.varying.terms.is_empty() => {
                energy_of_coefficients(frequencies, 0.0, ByAxis::default(), |_| 0.0)?
            }
            Some((weight, only)) => {
                let energy = only.energy(frequencies)?.of_multiple(weight);
                if self.constant == 0.0 {
                    return Ok(energy);
                }
                energy
            }
            None => self.estimate()?.energy(frequencies)?,
        };
        let (mean, error) = self.integral_estimate().ok_or(Error::NoEnergy {
            reason: "the integral of a term is not known; implement \
                     `SquareIntegrand::integral_estimate`",
        })?;
        Ok(varying.with_mean(mean, error))
    }

    fn kurtosis(&self) -> Option<f64> {
        match self.varying.single() {
            _ if self.varying.terms.is_empty() => None,
            Some((_, only)) => only.kurtosis(),
            None => self.estimate().ok()?.kurtosis,
        }
    }

    /// Returns the largest one of the terms, that of a product being the sum of those of its
    /// factors.
    fn band_limit(&self) -> Option<usize> {
        let of_product = |factors: &[Box<dyn SquareIntegrand>]| {
            factors.iter().try_fold(0usize, |sum, f| sum.checked_add(f.band_limit()?))
        };
        let terms = self.varying.terms.iter();
        terms.map(|(_, factors)| of_product(factors)).try_fold(0, |max, x| Some(x?.max(max)))
    }

    fn feature_size(&self) -> Option<f64> {
        let factors = self.varying.terms.iter().flat_map(|(_, factors)| factors);
        factors.map(|f| f.feature_size()).try_fold(1.0, |least, size| Some(size?.min(least)))
    }

    fn variation(&self) -> Option<f64> {
        if self.varying.terms.is_empty() {
            return Some(0.0);
        }
        let (weight, only) = self.varying.single()?;
        Some(weight.abs() * only.variation()?)
    }
}

impl SquareExpression {
    /// Returns the summands, of which those with the same factors in any order are one with the sum
    /// of their weights.
    fn merged(&self) -> Vec<Summand<SquareTerm>> {
        let mut merged: Vec<Summand<SquareTerm>> = Vec::new();
        for summand in &self.summands {
            match merged.iter_mut().find(|other| are_permutations(&other.factors, &summand.factors))
            {
                Some(other) => other.weight += summand.weight,
                None => merged.push(summand.clone()),
            }
        }
        merged
    }

    /// Returns the function; `files` reads the files that it names.
    ///
    /// Terms that appear more than once are merged.
    ///
    /// # Errors
    ///
    /// [`Error::OfTerm`] with the text of the term and the reason, [`Error::File`] if `files` cannot
    /// read a file.
    pub fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn SquareIntegrand>, Error> {
        let of_sum = |error| Error::OfTerm { text: self.to_string(), reason: Box::new(error) };
        for summand in &self.summands {
            Sum::check_weight(summand.weight).map_err(of_sum)?;
        }
        let mut sum = SquareSum::default();
        let merged = self.merged();
        for summand in &merged {
            let factors = summand.factors.iter().map(|term| term.build(files));
            let mut factors = factors.collect::<Result<Vec<_>, _>>()?;
            if merged.len() == 1 && summand.weight.to_bits() == 1f64.to_bits() && factors.len() == 1
            {
                // A single integrand without a weight is returned unchanged.
                return Ok(factors.remove(0));
            }
            sum = sum.plus(summand.weight, factors).map_err(of_sum)?;
        }
        Ok(Box::new(sum))
    }
}

/// Returns whether two lists have the same items, in any order.
fn are_permutations<T: PartialEq>(a: &[T], b: &[T]) -> bool {
    let mut rest: Vec<&T> = b.iter().collect();
    let mut take = |item: &T| {
        rest.iter().position(|other| *other == item).map(|i| rest.swap_remove(i)).is_some()
    };
    a.len() == b.len() && a.iter().all(&mut take)
}

impl From<SquareTerm> for SquareExpression {
    fn from(term: SquareTerm) -> Self {
        Self { summands: vec![Summand { weight: 1.0, factors: vec![term] }] }
    }
}
