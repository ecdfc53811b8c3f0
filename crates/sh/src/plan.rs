use core::f64::consts::{E, PI};

use crate::{
    Colatitude, Error, LmIndex, Scaled, Step, recurrence::fill_column, sectoral::sectoral,
};

/// Evaluates all `lambda_lm`, `0 <= m <= l <= lmax`, at a sequence of colatitudes.
///
/// The values are bit-identical to those of [`lambda`](crate::lambda).
///
/// # Performance
///
/// The recurrence coefficients are computed on the fly. They do not depend on the values, so most
/// of this work overlaps with the recurrence: columns take about a third longer than with stored
/// coefficients, which [`Recurrence`](crate::Recurrence) keeps for one order. A table for all
/// orders would take `12 lmax^2` bytes, 4.8 GB for `lmax = 20000`. The plan stores only the
/// constants of the sectoral functions: `O(lmax)` time to build, `8 (lmax + 1)` bytes. The measured
/// time on a shared machine is 6 ns per value.
///
/// # Examples
///
/// ```
/// use sphvar_sh::{Colatitude, LegendrePlan, lambda};
///
/// let plan = LegendrePlan::new(20)?;
/// let c = Colatitude::from_theta(2.5)?;
/// let values = plan.eval(c);
/// assert_eq!(values[plan.index().at(17, 3)], lambda(17, 3, c));
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct LegendrePlan {
    index: LmIndex,
    sectoral: Box<[f64]>,
}

impl LegendrePlan {
    /// Returns a plan for degrees `0..=lmax`.
    ///
    /// # Errors
    ///
    /// [`Error::DegreeTooLarge`] from [`LmIndex::new`].
    pub fn new(lmax: usize) -> Result<Self, Error> {
        let index = LmIndex::new(lmax)?;
        Ok(Self { index, sectoral: (0..=lmax).map(sectoral).collect() })
    }

    /// Returns the layout of the output.
    #[must_use]
    pub const fn index(&self) -> LmIndex {
        self.index
    }

    /// Returns the maximum degree, inclusive.
    #[must_use]
    pub const fn lmax(&self) -> usize {
        self.index.lmax()
    }

    /// Writes all `lambda_lm` to `out` in [`LmIndex`] order.
    ///
    /// The cost is `O(lmax^2)`. Near the poles, columns of high order that are entirely below the
    /// range of `f64` are set to zero without computation.
    ///
    /// # Panics
    ///
    /// Panics if `out` does not have `index().len()` entries.
    pub fn eval_into(&self, colatitude: Colatitude, out: &mut [f64]) {
        assert_eq!(out.len(), self.index.len(), "lmax = {}", self.lmax());
        for m in 0..=self.lmax() {
            if vanishes(m, self.lmax(), colatitude.sin()) {
                out[self.index.at(m, m)..].fill(0.0);
                return;
            }
            self.column_into(m, colatitude, &mut out[self.index.column(m)]);
        }
    }

    /// Returns all `lambda_lm` in [`LmIndex`] order.
    ///
    /// # Panics
    ///
    /// Panics if allocation of `4 (lmax + 1)(lmax + 2)` bytes fails.
    #[must_use]
    pub fn eval(&self, colatitude: Colatitude) -> Vec<f64> {
        let mut out = vec![0.0; self.index.len()];
        self.eval_into(colatitude, &mut out);
        out
    }

    /// Writes `lambda_lm` for `l = m..=lmax` at one order to `out`.
    ///
    /// The cost is `O(lmax - m + log m)`.
    ///
    /// # Panics
    ///
    /// Panics if `m > lmax` or `out` does not have `lmax - m + 1` entries.
    pub fn column_into(&self, m: usize, colatitude: Colatitude, out: &mut [f64]) {
        assert_eq!(out.len(), self.index.column(m).len(), "m = {m}, lmax = {}", self.lmax());
        let start = Scaled::new(colatitude.sin(), 0).power(m) * self.sectoral[m];
        fill_column(start, (m..).map(|l| Step::new(l, m)), colatitude, out);
    }
}

/// Returns whether every `|lambda_{l m'}|` with `l <= lmax`, `m' >= m` rounds to zero.
///
/// The Gegenbauer polynomial is at most its value at `x = 1`, hence
///
/// ```text
/// |lambda_lm| <= sqrt((2l + 1)/(4 pi) (l + m)!/(l - m)!) sin^m / (2^m m!)
///             <= sqrt((2l + 1)/(4 pi)) (e (l + 1/2) sin / (2m))^m
/// ```
///
/// by `(l + k)(l + 1 - k) <= (l + 1/2)^2` and `m! >= (m/e)^m`. Where the bracket is below 1 the
/// bound decreases with `m`, so one test is sufficient for all higher orders.
fn vanishes(m: usize, lmax: usize, sin: f64) -> bool {
    /// Half the smallest `f64` is `2^-1075`; the margin covers the rounding of this estimate.
    const LOG2_LIMIT: f64 = -1100.0;
    let half_integer = lmax as f64 + 0.5;
    let amplitude = 0.5 * (half_integer / (2.0 * PI)).log2();
    let m = m as f64;
    m > 0.0 && amplitude + m * (0.5 * E * half_integer * sin / m).log2() < LOG2_LIMIT
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lambda_scaled;

    #[test]
    fn skipped_columns_round_to_zero() {
        let lmax = 2000;
        for theta in [0.0, 5e-324, 1e-300, 1e-6, 0.01, 0.1, 0.5, 3.0] {
            let c = Colatitude::from_theta(theta).unwrap();
            let Some(first) = (0..=lmax).find(|&m| vanishes(m, lmax, c.sin())) else {
                assert!(theta > 0.4, "theta = {theta}: some columns are below the range of f64");
                continue;
            };
            for m in (first..=lmax).step_by(7) {
                let top = lambda_scaled(lmax, m, c);
                assert!(
                    top == Scaled::ZERO || top.exponent < -1080,
                    "theta = {theta}, m = {m}, first = {first}: {top:?}"
                );
                assert!(vanishes(m, lmax, c.sin()), "theta = {theta}: not monotonic at m = {m}");
            }
        }
    }

    #[test]
    #[should_panic(expected = "lmax = 3")]
    fn wrong_length_panics() {
        LegendrePlan::new(3)
            .unwrap()
            .eval_into(Colatitude::from_theta(1.0).unwrap(), &mut [0.0; 9]);
    }
}
