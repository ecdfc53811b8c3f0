use std::ops::Range;

use sphvar_sh::Frequencies;

use crate::error::check_equal;
use crate::{Accumulator, Error, Moments, Realization, Spectrum};

/// Radial mean of a spectrum of the square, and its anisotropy.
///
/// ```text
/// P(rho) = mean of P(k) over rho - 1/2 <= |k| < rho + 1/2,   rho = 1, 2, ..., kmax - 1
/// A(rho) = s^2(rho)/P(rho)^2,   s^2(rho) = sum (P(k) - P(rho))^2/(n - 1)
/// ```
///
/// The n frequencies of a ring count as pairs {k, -k}. The anisotropy is the relative variance of
/// the mean power over a ring (Ulichney 1987). A spectrum averaged over M realizations of white
/// noise has the anisotropy 1/M, -10 log10 M decibels, because the power of a realization has an
/// exponential distribution; a spectrum in closed form has that of the pattern alone. It is NaN
/// where the radial mean is 0.
///
/// # References
///
/// Ulichney 1987, Digital Halftoning, section 3.2.
#[derive(Clone, Debug, PartialEq)]
pub struct RadialSpectrum {
    power: Vec<f64>,
    stderr: Vec<f64>,
    anisotropy: Vec<f64>,
}

impl RadialSpectrum {
    /// Returns the radial mean of a spectrum. The standard errors treat those of different
    /// frequencies as independent; see [`Self::with_errors`]. Rings beyond the last band of the
    /// spectrum are left out.
    #[must_use]
    pub fn of(spectrum: &Spectrum<Frequencies>) -> Self {
        let mut radial = Self { power: vec![], stderr: vec![], anisotropy: vec![] };
        for ring in rings(spectrum.bands()).take_while(|ring| ring.end <= spectrum.power().len()) {
            let powers = &spectrum.power()[ring.clone()];
            let n = powers.len() as f64;
            let mean = powers.iter().sum::<f64>() / n;
            let squares: f64 = powers.iter().map(|p| (p - mean).powi(2)).sum();
            let variance = spectrum.stderr()[ring].iter().map(|e| e * e).sum::<f64>();
            radial.power.push(mean);
            radial.stderr.push(variance.sqrt() / n);
            radial.anisotropy.push(squares / (n - 1.0) / (mean * mean));
        }
        radial
    }

    /// Returns the same means with the standard errors of the realizations, which include the
    /// covariance of different frequencies.
    ///
    /// # Errors
    ///
    /// [`Error::Mismatch`] if the accumulator is for other frequencies.
    pub fn with_errors(mut self, accumulator: &RadialAccumulator) -> Result<Self, Error> {
        check_equal("numbers of rings", &self.power.len(), &accumulator.rings.len())?;
        self.stderr = accumulator.rings.iter().map(Moments::standard_error).collect();
        Ok(self)
    }

    /// Returns the rows of the radii from 1: radius, mean power, its standard error and the
    /// anisotropy.
    pub fn rows(&self) -> impl Iterator<Item = (usize, f64, f64, f64)> {
        let values = self.power.iter().zip(&self.stderr).zip(&self.anisotropy);
        values.enumerate().map(|(i, ((p, e), a))| (i + 1, *p, *e, *a))
    }

    /// Returns the mean power of the radii from 1.
    #[must_use]
    pub fn power(&self) -> &[f64] {
        &self.power
    }

    /// Returns the standard errors of the mean power of the radii from 1.
    #[must_use]
    pub fn stderr(&self) -> &[f64] {
        &self.stderr
    }

    /// Returns the anisotropy of the radii from 1, a ratio of variances; `10 log10` of it is in
    /// decibels.
    #[must_use]
    pub fn anisotropy(&self) -> &[f64] {
        &self.anisotropy
    }
}

/// Returns the bands of the complete rings, from radius 1 to kmax - 1.
fn rings(frequencies: &Frequencies) -> impl Iterator<Item = Range<usize>> {
    let norm = |band: usize| {
        let [k1, k2] = frequencies.frequency(band).map(i64::from);
        k1 * k1 + k2 * k2
    };
    let kmax = i64::try_from(frequencies.kmax()).unwrap_or(i64::MAX);
    // |k| >= rho - 1/2 for the integer |k|^2 >= rho^2 - rho + 1.
    let first = move |rho: i64| {
        let (mut low, mut high) = (0, frequencies.len());
        while low < high {
            let middle = low.midpoint(high);
            if norm(middle) < rho * rho - rho + 1 {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    };
    (1..kmax).map(move |rho| first(rho)..first(rho + 1))
}

/// Accumulates the radial means of realizations, for the standard errors of a [`RadialSpectrum`].
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RadialAccumulator {
    frequencies: Frequencies,
    rings: Vec<Moments>,
}

impl RadialAccumulator {
    /// Returns an empty accumulator.
    #[must_use]
    pub fn new(frequencies: Frequencies) -> Self {
        let rings = rings(&frequencies).map(|_| Moments::default()).collect();
        Self { frequencies, rings }
    }

    /// Adds the realizations of another accumulator exactly.
    ///
    /// # Errors
    ///
    /// [`Error::Mismatch`] if the accumulators differ in the frequencies.
    pub fn try_merge(&mut self, other: &Self) -> Result<(), Error> {
        let (kmax, other_kmax) = (self.frequencies.kmax(), other.frequencies.kmax());
        check_equal("maximum frequencies (kmax)", &kmax, &other_kmax)?;
        check_equal("frequencies", &self.frequencies, &other.frequencies)?;
        check_equal("numbers of rings", &self.rings.len(), &other.rings.len())?;
        Accumulator::merge(self, other);
        Ok(())
    }

    /// Returns the number of realizations added; `None` if it differs between the rings, which is
    /// possible only for deserialized accumulators, or if there are no rings.
    #[must_use]
    pub fn realizations(&self) -> Option<u64> {
        let count = self.rings.first()?.count();
        self.rings.iter().all(|ring| ring.count() == count).then_some(count)
    }

    /// Returns the frequencies of the powers.
    #[must_use]
    pub fn frequencies(&self) -> &Frequencies {
        &self.frequencies
    }

    fn push_powers(&mut self, powers: &[f64]) {
        for (moments, ring) in self.rings.iter_mut().zip(rings(&self.frequencies)) {
            let n = ring.len() as f64;
            moments.push(powers[ring].iter().sum::<f64>() / n);
        }
    }
}

impl Accumulator<Frequencies> for RadialAccumulator {
    fn push(&mut self, realization: &Realization<'_, Frequencies>) {
        self.push_powers(&realization.power().collect::<Vec<f64>>());
    }

    fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.rings.iter_mut().zip(&other.rings) {
            mine.merge(theirs);
        }
    }
}

#[cfg(test)]
mod tests {
    use sphvar_sh::{Bands, Frequencies};

    use super::{RadialSpectrum, rings};
    use crate::{Spectrum, SpectrumAccumulator};

    #[test]
    fn rings_are_those_of_the_definition() {
        for (kmax, axis_max) in [(0, 3), (1, 1), (2, 2), (9, 30), (40, 40)] {
            let bands = Frequencies::new(kmax).unwrap().with_axes(axis_max).unwrap();
            let all: Vec<_> = rings(&bands).collect();
            assert_eq!(all.len(), kmax.saturating_sub(1));
            for (i, ring) in all.into_iter().enumerate() {
                let rho = (i + 1) as f64;
                let is_in = |band: &usize| (-0.5..0.5).contains(&(bands.radius(*band) - rho));
                let expected: Vec<usize> = (0..bands.len()).filter(is_in).collect();
                assert_eq!(ring.collect::<Vec<_>>(), expected, "kmax {kmax}, {rho}");
            }
        }
    }

    /// The power (k1/|k|)^2 has the mean 1/2 and the variance 1/8 over an angle.
    #[test]
    fn anisotropy_is_the_relative_variance_of_a_ring() {
        let bands = Frequencies::new(60).unwrap();
        let power = |band: usize| {
            let [k1, _] = bands.frequency(band);
            (f64::from(k1) / bands.radius(band)).powi(2)
        };
        let mut sums = SpectrumAccumulator::of_square(bands.clone(), 4).unwrap();
        for factor in [0.5, 1.5] {
            let powers = (0..bands.len()).map(|band| factor * power(band));
            sums.push_powers(4.0, powers, sphvar_sh::ByAxis::default());
        }
        let radial = RadialSpectrum::of(&sums.finish().unwrap());
        let mut average = 0.0;
        for (rho, mean, stderr, anisotropy) in radial.rows().skip(30) {
            assert!((mean - 0.5).abs() < 1e-12, "{rho}: {mean}");
            assert!((anisotropy - 0.5).abs() < 0.1, "{rho}: {anisotropy}");
            average += anisotropy / 29.0;
            // Every band has the error power/2, and there are n = pi rho of them.
            let expected = 0.5 * (0.375 / (std::f64::consts::PI * rho as f64)).sqrt();
            assert!((stderr / expected - 1.0).abs() < 0.1, "{rho}: {stderr}, {expected}");
        }
        assert!((average - 0.5).abs() < 0.01, "{average}");
        let nothing = Spectrum::exact(bands.clone(), 1, vec![0.0; bands.len()]);
        let radial = RadialSpectrum::of(&nothing);
        assert!(radial.anisotropy().iter().all(|a| a.is_nan()) && radial.power().len() == 59);
    }
}
