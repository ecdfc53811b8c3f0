use sphvar_sh::{Bands, Domain, Frequencies, TailClasses};

use crate::{EnergyErrors, Error};

/// The energy of a function per band (on the sphere per degree, `E(l) = sum_m |F_lm|^2`) and in
/// total.
///
/// `P_F(l) = E(l)/(2l+1)`. For an integrand on the hemisphere F is the even extension to the
/// sphere, so odd degrees are 0 and the total is twice the hemisphere's `int f^2`.
///
/// The total is stored separately for the mean (band 0) and for each class of the other bands
/// ([`Bands::Tail`]; on the sphere, even and odd degrees), because the mean power of a point set may
/// differ between classes at high degrees.
///
/// Energies are exact to rounding unless they carry [`errors`](Self::errors), which predictions add
/// to their standard error.
#[derive(Clone, Debug, PartialEq)]
pub struct Energy<B: Bands = Domain> {
    bands: B,
    per_band: Vec<f64>,
    centred: B::Tail,
    errors: Option<EnergyErrors<B::Tail>>,
}

impl<B: Bands> Energy<B> {
    /// Returns the energy from that of the bands from 0 (at least band 0) and the totals of the
    /// bands from 1 by class; on the sphere, `int (F - mean)^2` of the even and of the odd part of
    /// F.
    ///
    /// # Panics
    ///
    /// Panics if `per_band` is empty.
    #[must_use]
    pub fn new(bands: B, per_band: Vec<f64>, centred: B::Tail) -> Self {
        assert!(!per_band.is_empty(), "the energy of band 0 is always there");
        Self { bands, per_band, centred, errors: None }
    }

    /// Returns the energy with the standard errors of the bands from 0, which are independent, and
    /// those of the totals of the bands from 1 by class, `sqrt(sum e^2)` over all bands of the
    /// class.
    ///
    /// # Panics
    ///
    /// Panics if there are not as many errors as bands.
    #[must_use]
    pub fn with_stderr(self, per_band: Vec<f64>, centred: B::Tail) -> Self {
        assert_eq!(per_band.len(), self.per_band.len(), "every band needs an error");
        let errors = EnergyErrors::independent(&self.bands, per_band, centred);
        Self { errors: Some(errors), ..self }
    }

    /// Returns the energy with other estimates of the same energies, such as those of coarser
    /// quadratures: the error of any sum of energies is the largest deviation of theirs.
    ///
    /// # Panics
    ///
    /// Panics if there is no other estimate or one has fewer bands.
    #[must_use]
    pub fn with_estimates(self, others: &[Self]) -> Self {
        let n_bands = self.per_band.len();
        let are_complete = others.iter().all(|other| other.per_band.len() >= n_bands);
        assert!(are_complete && !others.is_empty(), "every estimate needs all bands");
        let errors = EnergyErrors::of_estimates(&self, others);
        Self { errors: Some(errors), ..self }
    }

    /// Returns the errors of estimated energies; `None` if the energies are exact to rounding.
    #[must_use]
    pub fn errors(&self) -> Option<&EnergyErrors<B::Tail>> {
        self.errors.as_ref()
    }

    /// Returns the errors of the bands from 0, if the energies are estimated.
    #[must_use]
    pub fn per_band_stderr(&self) -> Option<&[f64]> {
        self.errors.as_ref().map(EnergyErrors::per_band)
    }

    /// Returns the errors of the totals, 0 if they are exact to rounding.
    #[must_use]
    pub fn centred_stderr(&self) -> B::Tail {
        self.errors.as_ref().map_or(B::Tail::all(0.0), EnergyErrors::centred)
    }

    /// Returns the energy of the function times a factor, with its errors.
    #[must_use]
    pub fn of_multiple(&self, factor: f64) -> Self {
        let square = factor * factor;
        Self {
            bands: self.bands.clone(),
            per_band: self.per_band.iter().map(|e| square * e).collect(),
            centred: self.centred.map(|e| square * e),
            errors: self.errors.as_ref().map(|errors| errors.scaled(square)),
        }
    }

    /// Returns the energy with the bands to `lmax` alone, and the same totals.
    #[must_use]
    pub fn truncated(&self, lmax: usize) -> Self {
        let n_bands = self.per_band.len().min(lmax.saturating_add(1));
        let errors = self.errors.as_ref().map(|errors| errors.truncated(n_bands));
        let per_band = self.per_band[..n_bands].to_vec();
        Self { bands: self.bands.clone(), per_band, centred: self.centred, errors }
    }

    /// Returns the bands whose energies are known, from band 0.
    #[must_use]
    pub fn bands(&self) -> &B {
        &self.bands
    }

    /// Returns the energies E(l) by band from 0.
    #[must_use]
    pub fn per_band(&self) -> &[f64] {
        &self.per_band
    }

    /// Returns the last known band, inclusive: the largest degree.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.per_band.len() - 1
    }

    /// Returns `int F^2`, the energy of all bands.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.per_band[0] + self.centred.sum()
    }

    /// Returns `int (F - mean)^2`, the energy of all bands from 1 by class.
    #[must_use]
    pub fn centred(&self) -> B::Tail {
        self.centred
    }

    /// Returns the nonnegative energy beyond degree `lmax` (or beyond the last known band, if that
    /// is smaller); for lmax = 0, that of all degrees from 1.
    #[must_use]
    pub fn beyond(&self, lmax: usize) -> f64 {
        self.beyond_by_class(lmax).sum()
    }

    /// Returns the energy beyond band number `lmax`, the degree on the sphere, by class of the band.
    ///
    /// It is the difference of two nearly equal numbers. A result within the rounding of the sum,
    /// `4 EPSILON sqrt(lmax + 1) int (F - mean)^2`, is replaced by 0.
    #[must_use]
    pub fn beyond_by_class(&self, lmax: usize) -> B::Tail {
        let known = &self.per_band[..self.per_band.len().min(lmax.saturating_add(1))];
        let mut sums = vec![0.0; B::Tail::COUNT];
        for (band, e) in known.iter().enumerate().skip(1) {
            sums[self.bands.tail_class(band)] += e;
        }
        // Each coefficient and the sum itself are rounded by some EPSILON of the total.
        let rounding = 4.0 * f64::EPSILON * self.centred.sum() * (known.len() as f64).sqrt();
        B::Tail::from_fn(|class| {
            let tail = self.centred.get(class) - sums[class];
            if tail > rounding { tail } else { 0.0 }
        })
    }
}

impl Energy {
    /// The range of root mean squares for which variances are computed to full precision: beyond it
    /// variances or their errors overflow or underflow.
    pub const MAGNITUDES: [f64; 2] = [1e-151, 1e151];

    /// Returns the domain of the integrand.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.bands
    }
}

impl Energy<Frequencies> {
    /// Returns the energy of the function plus a constant, given the mean of this sum and its error.
    pub(crate) fn with_mean(mut self, mean: f64, error: f64) -> Self {
        self.per_band[0] = mean * mean;
        if let Some(errors) = &mut self.errors {
            errors.set_of_mean(error * (2.0 * mean.abs() + error));
        }
        self
    }
}

impl<B: Bands> Energy<B> {
    /// Returns the variance below which a prediction is rounding only: power and energies are
    /// squares of sums whose terms have the size of the integrand minus its mean.
    #[must_use]
    pub fn prediction_rounding(&self) -> f64 {
        (4.0 * f64::EPSILON).powi(2) * self.bands.area() * self.centred.sum()
    }

    /// Checks that the root mean square of the function is 0 or within
    /// [`MAGNITUDES`](Energy::MAGNITUDES).
    ///
    /// A total whose terms all underflow is 0, so functions of given values or coefficients are
    /// checked before these are squared.
    ///
    /// # Errors
    ///
    /// [`Error::Magnitude`] if it is not.
    pub fn check_magnitude(&self) -> Result<(), Error> {
        check_size((self.total() / self.bands.area()).sqrt())
    }
}

/// Checks that a root mean square is 0 or within [`Energy::MAGNITUDES`].
///
/// # Errors
///
/// [`Error::Magnitude`] if it is not.
pub(crate) fn check_size(size: f64) -> Result<(), Error> {
    let [min, max] = Energy::MAGNITUDES;
    if size == 0.0 || (min..=max).contains(&size) {
        Ok(())
    } else {
        Err(Error::Magnitude { got: size })
    }
}

/// Returns `sqrt(sum x^2)`, whose squares neither overflow nor underflow.
pub(crate) fn norm(numbers: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = numbers.clone().fold(0.0, |max: f64, x| max.max(x.abs()));
    if largest == 0.0 || largest == f64::INFINITY {
        return largest;
    }
    largest * numbers.map(|x| (x / largest).powi(2)).sum::<f64>().sqrt()
}
