use sphvar_sh::{Bands, ByParity, Domain};

use crate::Error;

/// The energy of a function per band, on the sphere per degree, `E(l) = sum_m |F_lm|^2`, and its total over all bands.
///
/// `P_F(l) = E(l)/(2l+1)`. For an integrand on the hemisphere F is the even extension to the
/// sphere, so odd degrees are 0 and the total is twice the hemisphere's `int f^2`.
///
/// The total is known apart for the mean (band 0), the even bands beyond it and the odd bands: a point set may have
/// another mean power at high even degrees than at high odd ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Energy<B = Domain> {
    bands: B,
    per_band: Vec<f64>,
    centred: ByParity,
}

impl<B: Bands> Energy<B> {
    /// From the energies of the bands from 0 on (at least band 0), and the totals of even bands from 1 on and of odd
    /// bands, `int (F - mean)^2` of the even and of the odd part of F.
    ///
    /// # Panics
    ///
    /// If `per_band` is empty.
    #[must_use]
    pub fn new(bands: B, per_band: Vec<f64>, centred: ByParity) -> Self {
        assert!(!per_band.is_empty(), "the energy of band 0 is always there");
        Self { bands, per_band, centred }
    }

    /// The bands that energies are known of, from band 0 on.
    #[must_use]
    pub fn bands(&self) -> &B {
        &self.bands
    }

    /// The energies by band from 0: E(l).
    #[must_use]
    pub fn per_band(&self) -> &[f64] {
        &self.per_band
    }

    /// The last band given, inclusive: the largest degree.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.per_band.len() - 1
    }

    /// `int F^2`, the energy of all bands.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.per_band[0] + self.centred.sum()
    }

    /// `int (F - mean)^2`, the energy of all even bands from 1 on and of all odd bands.
    #[must_use]
    pub fn centred(&self) -> ByParity {
        self.centred
    }

    /// The energy beyond degree `lmax` (or beyond what is given, if that is less), never negative; that of degrees from 1
    /// on for lmax = 0.
    #[must_use]
    pub fn beyond(&self, lmax: usize) -> f64 {
        self.beyond_by_parity(lmax).sum()
    }

    /// The energy beyond degree `lmax` by parity of the degree.
    ///
    /// The difference of two nearly equal numbers: what is within the rounding of the sum,
    /// `4 EPSILON sqrt(lmax + 1) int (F - mean)^2`, is taken for the 0 that it may be.
    #[must_use]
    pub fn beyond_by_parity(&self, lmax: usize) -> ByParity {
        let known = &self.per_band[..self.per_band.len().min(lmax.saturating_add(1))];
        let mut sums = ByParity::both(0.0);
        for (band, e) in known.iter().enumerate().skip(1) {
            *sums.at_mut(self.bands.is_even(band)) += e;
        }
        // Each coefficient of the sum and the sum itself round by some EPSILON of the total.
        let rounding = 4.0 * f64::EPSILON * self.centred.sum() * (known.len() as f64).sqrt();
        self.centred.zip(sums).map(|(total, sum)| {
            let tail = total - sum;
            if tail > rounding { tail } else { 0.0 }
        })
    }
}

impl Energy {
    /// The range of root mean squares of functions whose variances are computed with all digits: beyond it variances
    /// or their errors leave the range of numbers.
    pub const MAGNITUDES: [f64; 2] = [1e-151, 1e151];

    /// The domain of the integrand.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.bands
    }

    /// The variance that is no more than rounding of a prediction: power and energies are squares of sums whose terms have
    /// the size of the integrand less its mean.
    #[must_use]
    pub fn prediction_rounding(&self) -> f64 {
        (4.0 * f64::EPSILON).powi(2) * self.bands.area() * self.centred.sum()
    }

    /// Checks that the function's root mean square is 0 or within [`MAGNITUDES`](Self::MAGNITUDES).
    ///
    /// # Errors
    ///
    /// [`Error::Magnitude`] if it is not.
    pub fn check_magnitude(&self) -> Result<(), Error> {
        let size = (self.total() / self.bands.area()).sqrt();
        let [least, most] = Self::MAGNITUDES;
        if size == 0.0 || (least..=most).contains(&size) {
            Ok(())
        } else {
            Err(Error::Magnitude { got: size })
        }
    }
}
