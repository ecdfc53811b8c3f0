use crate::{Profile, ProfileShape};

/// The bounds that the thesis draws for the spectrum of one sampler.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThesisBound {
    /// The name of the sampler in the command.
    pub sampler: &'static str,
    /// The profile below the spectrum.
    pub lower: Profile,
    /// The profile above the spectrum.
    pub upper: Profile,
}

/// Returns the four pairs of bounds of the thesis, in its order.
///
/// | sampler | lower | upper |
/// |---|---|---|
/// | `white-noise` | constant 0.7 | constant 1.3 |
/// | `poisson-disk` | constant 0.055 | constant 1.8 |
/// | `jittered` | quadratic, alpha = sqrt 0.6, gamma = 0.4 | quadratic, alpha = 0.2, gamma = 1 |
/// | `ccvt` | quadratic, alpha = sqrt 2.85, gamma = 0.05 | quadratic, alpha = sqrt 0.05, gamma = 2 |
///
/// Those of `white-noise`, `poisson-disk` and `jittered` hold for the mean spectrum. Those of
/// `ccvt` hold only for a range of capacities m: with random mass points the offset 1/m violates
/// the upper one at the lowest degrees once `N > 40 m`, and for m >= 1024 both are violated, the
/// lower one also with ideal mass points.
///
/// # Examples
///
/// ```
/// let jittered = sphvar_bounds::thesis_bounds()[2];
/// assert_eq!(jittered.sampler, "jittered");
/// assert!(jittered.lower.power(30, 4096) < jittered.upper.power(30, 4096));
/// ```
///
/// # References
///
/// G. Singh 2015, figure 7.4. The constants of `alpha` in constant profiles are only units of the
/// axis.
#[must_use]
pub fn thesis_bounds() -> [ThesisBound; 4] {
    let pair = |sampler,
                shape,
                (alpha_low, gamma_low): (f64, f64),
                (alpha_high, gamma_high): (f64, f64)| ThesisBound {
        sampler,
        lower: Profile::trusted(shape, alpha_low, gamma_low),
        upper: Profile::trusted(shape, alpha_high, gamma_high),
    };
    let quadratic = ProfileShape::Polynomial { exponent: 2.0 };
    let disk_axis = 2.75_f64.sqrt();
    [
        pair("white-noise", ProfileShape::Constant, (1.0, 0.7), (1.0, 1.3)),
        pair("poisson-disk", ProfileShape::Constant, (disk_axis, 0.055), (disk_axis, 1.8)),
        pair("jittered", quadratic, (0.6_f64.sqrt(), 0.4), (0.2, 1.0)),
        pair("ccvt", quadratic, (2.85_f64.sqrt(), 0.05), (0.05_f64.sqrt(), 2.0)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean power of jittered patterns, N = 3888, by quadrature, at omega = l / sqrt N (three
    /// degrees averaged).
    const JITTERED: [(f64, f64); 11] = [
        (0.125, 0.0196),
        (0.25, 0.0719),
        (0.5, 0.2533),
        (0.75, 0.4839),
        (1.0, 0.6993),
        (1.25, 0.8573),
        (1.5, 0.9478),
        (1.75, 0.9847),
        (2.0, 0.9912),
        (2.5, 0.9845),
        (3.0, 0.9907),
    ];
    /// The same for Poisson disk patterns of exactly 4096 points.
    const POISSON_DISK: [(f64, f64); 11] = [
        (0.125, 0.0596),
        (0.25, 0.0623),
        (0.5, 0.0694),
        (0.75, 0.0854),
        (1.0, 0.1249),
        (1.25, 0.2571),
        (1.5, 0.667),
        (1.75, 1.347),
        (2.0, 1.701),
        (2.5, 1.085),
        (3.0, 0.682),
    ];

    #[test]
    fn profiles_are_valid() {
        for bound in thesis_bounds() {
            for p in [bound.lower, bound.upper] {
                assert_eq!(
                    Profile::new(p.shape(), p.alpha(), p.gamma()),
                    Ok(p),
                    "{}",
                    bound.sampler
                );
            }
        }
    }

    #[test]
    fn measured_spectra_lie_between_the_bounds() {
        for (which, n_points, spectrum) in [(1, 4096, POISSON_DISK), (2, 4096, JITTERED)] {
            let bound = thesis_bounds()[which];
            for (omega, power) in spectrum {
                // With 4096 points sqrt N = 64, and each of these omega is an integer degree.
                let l = (0..256).find(|&l| l as f64 >= omega * 64.0).unwrap_or(0);
                let (low, high) = (bound.lower.power(l, n_points), bound.upper.power(l, n_points));
                assert!(
                    low < power && power < high,
                    "{}: omega {omega}: {low} {power} {high}",
                    bound.sampler
                );
            }
        }
        // The tightest place of the lower bound of jittered patterns: ratio 1.29 at omega = 0.75.
        let ratio = 0.4839 / thesis_bounds()[2].lower.power(48, 4096);
        assert!((ratio - 1.29).abs() < 0.005, "ratio {ratio}");
    }
}
