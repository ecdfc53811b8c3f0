use sphvar_sh::{Bands, Frequencies};

use crate::{Accumulator, Error, Moments, Realization};

/// Mean power on both axes relative to that off the axes, at low frequencies: 1 for patterns
/// without preferred directions, larger where points keep distances to the edges of the square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisRatio {
    /// The ratio of the frequencies (k, 0) and of (0, k).
    pub ratio: [f64; 2],
    /// Its standard errors; NaN for a single realization.
    pub stderr: [f64; 2],
    /// The mean power off the axes.
    pub off_axes: f64,
}

/// Accumulates the power on the axes and off them over `0 < |k| <= radius`.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AxisRatioAccumulator {
    frequencies: Frequencies,
    radius: usize,
    /// Of the mean power off the axes, and of those of (k, 0) and (0, k).
    means: [Moments; 3],
    /// Of the sums of the power on either axis and off the axes, for the covariance.
    sums: [Moments; 2],
}

impl AxisRatioAccumulator {
    /// Returns an empty accumulator.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if `radius` is not from 2, the first with frequencies off the axes, to
    /// kmax.
    pub fn new(frequencies: Frequencies, radius: usize) -> Result<Self, Error> {
        if !(2..=frequencies.kmax()).contains(&radius) {
            return Err(Error::Setting {
                what: "radius of the ratio of axes",
                expected: "from 2 to kmax",
                got: radius as f64,
            });
        }
        Ok(Self { frequencies, radius, means: Default::default(), sums: Default::default() })
    }

    /// Returns the frequencies of the powers.
    #[must_use]
    pub fn frequencies(&self) -> &Frequencies {
        &self.frequencies
    }

    /// Returns the largest norm of the frequencies that count, inclusive.
    #[must_use]
    pub fn radius(&self) -> usize {
        self.radius
    }

    /// Returns the number of realizations added; `None` if the counts of the powers differ, which
    /// is possible only for deserialized accumulators.
    #[must_use]
    pub fn realizations(&self) -> Option<u64> {
        let count = self.means[0].count();
        self.means.iter().chain(&self.sums).all(|m| m.count() == count).then_some(count)
    }

    /// Returns the ratio of the means over realizations. Its error is that of the linearized ratio,
    /// from the variances and covariances of the powers.
    ///
    /// # Errors
    ///
    /// [`Error::NoRealizations`] if nothing was accumulated.
    pub fn finish(&self) -> Result<AxisRatio, Error> {
        let [off, on @ ..] = &self.means;
        if off.count() == 0 {
            return Err(Error::NoRealizations);
        }
        let ratio = on.each_ref().map(|on| on.mean() / off.mean());
        let stderr = [0, 1].map(|axis: usize| {
            let [on, off, sum] = [&on[axis], off, &self.sums[axis]].map(Moments::variance);
            let covariance = 0.5 * (sum - on - off);
            let r = ratio[axis];
            // Rounding can leave a negative variance where both powers are proportional.
            let variance = on + r * r * off - 2.0 * r * covariance;
            let variance = if variance < 0.0 { 0.0 } else { variance };
            (variance / self.means[0].count() as f64).sqrt() / self.means[0].mean()
        });
        Ok(AxisRatio { ratio, stderr, off_axes: off.mean() })
    }

    fn push_powers(&mut self, powers: &[f64]) {
        let mut totals = [(0.0, 0.0); 3];
        let radius = self.radius as f64;
        let within = (1..powers.len()).take_while(|band| self.frequencies.radius(*band) <= radius);
        for band in within {
            let (sum, count) = &mut totals[self.frequencies.tail_class(band)];
            *sum += powers[band];
            *count += 1.0;
        }
        let [off, u, v] = totals.map(|(sum, count)| sum / count);
        self.means.iter_mut().zip([off, u, v]).for_each(|(mean, p)| mean.push(p));
        self.sums.iter_mut().zip([u, v]).for_each(|(sum, on)| sum.push(on + off));
    }
}

impl Accumulator<Frequencies> for AxisRatioAccumulator {
    fn push(&mut self, realization: &Realization<'_, Frequencies>) {
        self.push_powers(&realization.power().collect::<Vec<f64>>());
    }

    fn merge(&mut self, other: &Self) {
        self.means.iter_mut().zip(&other.means).for_each(|(mine, theirs)| mine.merge(theirs));
        self.sums.iter_mut().zip(&other.sums).for_each(|(mine, theirs)| mine.merge(theirs));
    }
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::{Purpose, Streams};
    use sphvar_sh::{Bands, Frequencies};

    use super::AxisRatioAccumulator;
    use rand::RngExt;

    /// The standard deviation of the ratios of 400 ensembles is the mean of the stated errors. The
    /// standard deviation of a standard deviation over 400 is 3.5 %; the bounds of 18 % fail a
    /// correct program for 3e-7 of seeds.
    #[test]
    fn the_error_is_the_standard_deviation_of_ratios() {
        let bands = Frequencies::new(6).unwrap();
        let (mut ratios, mut stated) = (Vec::new(), 0.0);
        for ensemble in 0..400 {
            let mut sums = AxisRatioAccumulator::new(bands.clone(), 4).unwrap();
            let rng = &mut Streams::new(1, Purpose::Pattern, 0).realization(ensemble);
            for _ in 0..40 {
                // A common factor correlates axes and the other frequencies.
                let common: f64 = rng.random_range(0.5..1.5);
                let power = |band: usize, x: f64| {
                    let on_axis = bands.tail_class(band) == 1;
                    common * if on_axis { 3.0 * x } else { 0.5 + x }
                };
                let powers: Vec<f64> =
                    (0..bands.len()).map(|band| power(band, rng.random())).collect();
                sums.push_powers(&powers);
            }
            let got = sums.finish().unwrap();
            ratios.push(got.ratio[0]);
            stated += got.stderr[0] / 400.0;
            assert!((got.off_axes - 1.0).abs() < 0.4, "{got:?}");
        }
        let mean = ratios.iter().sum::<f64>() / 400.0;
        let variance = ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / 399.0;
        assert!((mean - 1.5).abs() < 0.02, "{mean}");
        let sigma = variance.sqrt();
        assert!((stated / sigma - 1.0).abs() < 0.18, "{stated} and {sigma}");
    }

    #[test]
    fn radii_are_checked() {
        let bands = Frequencies::new(6).unwrap();
        for radius in [0, 1, 7, usize::MAX] {
            assert!(AxisRatioAccumulator::new(bands.clone(), radius).is_err(), "{radius}");
        }
        assert!(AxisRatioAccumulator::new(bands, 6).unwrap().finish().is_err());
    }
}
