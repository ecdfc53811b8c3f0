use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};

use libm::erfc;

use crate::Error;

/// Powers below this are 0: targets are met to this accuracy, and where they are 0 to 1e-20.
const NEGLIGIBLE: f64 = 1e-6;

/// The default pair correlation at distance 0 with white noise beyond the target.
const DEFAULT_CORRELATION: f64 = 0.1;

/// Single-peak blue noise (Heck, Schloemer and Deussen 2013): a step with a peak at its edge, both
/// smoothed by a Gaussian,
///
/// ```text
/// P(omega) = peak exp(-x^2/2)/(sqrt(2 pi) width) + Phi(x),   x = (omega - edge)/width,
/// ```
///
/// where Phi is the normal distribution function. Beyond the peak there are no oscillations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SinglePeak {
    /// The position of the step and of the peak, in units of `sqrt(N)`.
    pub edge: f64,
    /// The integral of the peak over omega. If not given, the smallest for which the pair
    /// correlation at distance 0 is 0.1.
    pub peak: Option<f64>,
    /// The standard deviation of the Gaussian.
    pub width: f64,
    /// The omega at which the target ends.
    pub to: f64,
}

impl SinglePeak {
    /// The profile of the sphere with defaults: no power to omega = 0.72, a peak of 1.5.
    pub const DEFAULT: Self = Self { edge: 1.2, peak: None, width: 0.1, to: 2.0 };

    /// Returns the power as a function of omega, where the number of harmonics or frequencies up to
    /// omega is `density omega^2 N`: 1 on the sphere, pi on the square.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless edge and width are positive and the peak is at least 0.
    pub(super) fn power(self, density: f64) -> Result<impl Fn(f64) -> f64 + use<>, Error> {
        let Self { edge, width, .. } = self;
        let peak = self.peak.unwrap_or_else(|| self.default_peak(density));
        for (name, range, got, is_valid) in [
            ("edge", "finite and above 0", edge, edge > 0.0),
            ("width", "finite and above 0", width, width > 0.0),
            ("peak", "finite and at least 0", peak, peak >= 0.0),
        ] {
            if !(is_valid && got.is_finite()) {
                return Err(Error::Parameter { name, range, got });
            }
        }
        Ok(move |omega: f64| {
            let x = (omega - edge) / width;
            let at_peak = peak * (-0.5 * x * x).exp() / (SQRT_2 * PI.sqrt() * width);
            let power = at_peak + 0.5 * erfc(-x * FRAC_1_SQRT_2);
            if power < NEGLIGIBLE { 0.0 } else { power }
        })
    }

    /// Returns the peak with the default pair correlation at distance 0,
    ///
    /// ```text
    /// g2(0) = 1 + int 2 density omega (P - 1) = 1 + density (2 peak edge - edge^2 - width^2).
    /// ```
    fn default_peak(self, density: f64) -> f64 {
        let Self { edge, width, .. } = self;
        let missing = edge * edge + width * width - (1.0 - DEFAULT_CORRELATION) / density;
        (missing / (2.0 * edge)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::SinglePeak;

    /// Returns `1 + int 2 density omega (P - 1)` to twice the edge by the midpoint rule.
    fn pair_correlation_at_0(profile: SinglePeak, density: f64) -> f64 {
        const STEPS: u32 = 20_000;
        let power = profile.power(density).unwrap();
        let step = 2.0 * profile.edge / f64::from(STEPS);
        let terms = (0..STEPS).map(|i| {
            let omega = (f64::from(i) + 0.5) * step;
            2.0 * density * omega * (power(omega) - 1.0) * step
        });
        1.0 + terms.sum::<f64>()
    }

    #[test]
    fn default_peaks_give_the_stated_pair_correlation() {
        for (edge, density) in [(1.0, 1.0), (1.2, 1.0), (1.3, 1.0), (0.6, PI), (0.7, PI)] {
            let profile = SinglePeak { edge, width: 0.05, ..SinglePeak::DEFAULT };
            let got = pair_correlation_at_0(profile, density);
            // Powers that count as 0 change it by less than 2 density edge^2 1e-6.
            assert!((got - 0.1).abs() < 1e-5, "{edge}: {got}");
        }
        // No peak is needed for a small step.
        let small = SinglePeak { edge: 0.5, ..SinglePeak::DEFAULT };
        assert!(pair_correlation_at_0(small, 1.0) > 0.7);
    }

    #[test]
    fn there_is_one_peak() {
        for profile in [SinglePeak::DEFAULT, SinglePeak { peak: Some(0.5), ..SinglePeak::DEFAULT }]
        {
            let power = profile.power(1.0).unwrap();
            let values: Vec<f64> = (0..400).map(|i| power(f64::from(i) * 0.005)).collect();
            assert!(values[0].abs() < f64::MIN_POSITIVE && (values[399] - 1.0).abs() < 1e-9);
            let signs: Vec<bool> = values
                .windows(2)
                .filter(|pair| (pair[1] - pair[0]).abs() > 1e-12)
                .map(|pair| pair[1] > pair[0])
                .collect();
            assert_eq!(signs.windows(2).filter(|pair| pair[0] != pair[1]).count(), 1);
        }
    }

    #[test]
    fn invalid_parameters_are_rejected() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(SinglePeak { edge: bad, ..SinglePeak::DEFAULT }.power(1.0).is_err(), "{bad}");
            assert!(SinglePeak { width: bad, ..SinglePeak::DEFAULT }.power(1.0).is_err(), "{bad}");
            let peak = SinglePeak { peak: Some(bad), ..SinglePeak::DEFAULT };
            assert_eq!(peak.power(1.0).is_err(), bad.to_bits() != 0.0_f64.to_bits(), "{bad}");
        }
    }
}
