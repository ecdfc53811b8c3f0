use std::f64::consts::PI;

use sphvar_bounds::{IntegrandClass, Profile, hurwitz_zeta};
use sphvar_samplers::Domain;

use super::Recipe;
use super::patterns::{OTHER_COLOUR, ThesisPattern};
use super::profile_rates::{FAR, rate_claim};
use super::spectra::{mean_spectrum, omega_axis, spectrum_curve};
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Quantity, Results, Setting, Stated, Verdict,
};

/// Figures 6.2 and 6.3: a profile of the low degrees, the patterns that have it, and the variance
/// that follows.
pub(crate) enum ProfileShapes {
    /// Figure 6.2.
    Step,
    /// Figure 6.3.
    Quadratic,
}

/// The break and the plateau of the profile.
const ALPHA: f64 = 1.0;
const GAMMA: f64 = 1.0;
/// The last degree of the best case, as in Figure 6.1.
const BAND: usize = 16;
/// Numbers of points of the variances that are shown.
const COUNTS: [usize; 13] = [4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384];
/// omega of the last value of a profile, and the values in a unit of omega.
const LAST_OMEGA: usize = 3;
const PER_UNIT: usize = 100;
/// The largest power that is shown: peaks of HEALPix are higher.
const SHOWN: f64 = 4.0;
/// Degrees of the polynomial profile for which closed forms are compared with sums.
const EXPONENTS: [f64; 6] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.7];
/// Numbers of points for that, with breaks below and above the band.
const SUM_COUNTS: [usize; 3] = [100, 1000, 10_000];
/// A closed form is accepted if it differs from the sum by at most the rounding of some thousand
/// terms.
const ROUNDING: f64 = 1e-11;

impl ProfileShapes {
    fn profile(&self) -> Result<Profile, Error> {
        Ok(match self {
            Self::Step => Profile::step(ALPHA, GAMMA)?,
            Self::Quadratic => Profile::quadratic(ALPHA, GAMMA)?,
        })
    }

    /// Returns the pattern that is shown beside the profile: section 6.2.2 describes its low
    /// degrees so.
    fn pattern(&self) -> ThesisPattern {
        match self {
            Self::Step => ThesisPattern::Healpix,
            Self::Quadratic => ThesisPattern::Jittered,
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Step => "step profile",
            Self::Quadratic => "quadratic profile",
        }
    }
}

impl Recipe for ProfileShapes {
    fn title(&self) -> &'static str {
        match self {
            Self::Step => "The step profile",
            Self::Quadratic => "The quadratic profile",
        }
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        vec![mean_spectrum(self.pattern(), setting)]
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let profile = self.profile()?;
        figure.panel("profile", self.name(), spectra(vec![curve(self.name(), &profile)]));
        let pattern = self.pattern();
        let spectrum = results.spectrum(&mean_spectrum(pattern, setting))?;
        let mut measured = spectrum_curve(pattern.label(), pattern.colour(), spectrum);
        measured.points.retain(|p| p[0] <= LAST_OMEGA as f64 && p[1] <= SHOWN);
        figure.panel(
            "pattern",
            format!("{} beside {}", self.name(), pattern.label()),
            spectra(vec![curve(self.name(), &profile), measured]),
        );
        let best = IntegrandClass::band_limited(1.0, BAND)?;
        let worst = IntegrandClass::power_law(1.0, 2.0)?;
        figure.panel(
            "variance",
            "Variance of the best and the worst case",
            variances(&profile, best, worst),
        );
        match self {
            Self::Step => {
                figure.claims.push(rate_claim(
                    "step profile, worst case",
                    worst,
                    &profile,
                    -1.5,
                    25,
                ));
                figure.claims.push(zero_variance(&profile, best));
            }
            Self::Quadratic => {
                let claims = [
                    rate_claim("quadratic profile, best case", best, &profile, -2.0, 22),
                    rate_claim("quadratic profile, worst case", worst, &profile, -1.5, 28),
                    printed_break(),
                    solvable(largest_difference()?),
                ];
                figure.claims.extend(claims);
            }
        }
        figure.note(format!(
            "alpha = {ALPHA}, gamma = {GAMMA}; the best case is band-limited to degree {BAND}, the worst case has the energy \
             l^-2. Powers above {SHOWN} of the measured spectrum are not shown."
        ));
        Ok(())
    }
}

fn spectra(curves: Vec<Curve>) -> Curves {
    Curves { x: omega_axis(), y: Axis::linear("power P"), curves }
}

/// Returns the profile over omega, by its values for a number of points at which degrees are dense.
fn curve(label: &str, profile: &Profile) -> Curve {
    let points = (1..=LAST_OMEGA * PER_UNIT)
        .map(|l| (l as f64 / PER_UNIT as f64, profile.power(l, PER_UNIT * PER_UNIT)));
    Curve::line(label, OTHER_COLOUR + 1, points)
}

fn variances(profile: &Profile, best: IntegrandClass, worst: IntegrandClass) -> Curves {
    let line = |label, colour, class: IntegrandClass| {
        let points = COUNTS
            .map(|n| (n as f64, class.variance(profile, n, Domain::Sphere)))
            .into_iter()
            // The best case under a step is 0 if its break is beyond the band.
            .filter(|point| point.1 > 0.0);
        Curve::line(label, colour, points)
    };
    Curves {
        x: Axis::log("number of points N"),
        y: Axis::log("variance of the integral"),
        curves: vec![
            line("best case", OTHER_COLOUR, best),
            line("worst case", OTHER_COLOUR + 1, worst),
        ],
    }
}

fn zero_variance(profile: &Profile, best: IntegrandClass) -> Claim {
    Claim::number(
        "variance of the step profile, best case, beyond N = (l0/alpha)^2",
        Stated::About { value: 0.0, tolerance: 0.0 },
        Quantity::exact(best.variance(profile, FAR[0], Domain::Sphere)),
    )
    .erratum(24)
    .because("closed form at N = 1e6; the thesis writes l for l0")
}

/// Returns the break of 6.5 with its b-th root beside the d-th root of section 6.2, d = 2, which is
/// correct.
fn printed_break() -> Claim {
    const B: f64 = 4.0;
    let n = FAR[0] as f64;
    Claim::number(
        format!("break of 6.5 as printed over alpha sqrt(N), b = {B}"),
        Stated::About { value: 1.0, tolerance: 0.0 },
        Quantity::exact(n.powf(1.0 / B) / n.sqrt()),
    )
    .erratum_if(Verdict::Wrong, 26)
    .because("at N = 1e6; 6.5 prints the b-th root of N, section 6.2 the d-th; both agree for b = 2 only")
}

/// "Cannot be symbolically solved for an unknown degree b": contradicted by closed forms that equal
/// the sums.
fn solvable(difference: f64) -> Claim {
    let verdict = if difference <= ROUNDING { Verdict::Wrong } else { Verdict::Undecided };
    Claim::words(
        "6.1 and 6.2 with the profile 6.5: largest relative difference of closed forms and sums",
        "cannot be symbolically solved for an unknown degree b",
        verdict,
    )
    .measured(Quantity::exact(difference))
    .erratum_if(Verdict::Wrong, 27)
    .because(format!(
        "closed forms without sums, b from {} to {}; a difference of at most {ROUNDING:e} is rounding",
        EXPONENTS[0],
        EXPONENTS[EXPONENTS.len() - 1]
    ))
}

/// Returns the largest relative difference of closed forms and sums, best and worst case.
fn largest_difference() -> Result<f64, Error> {
    let best = IntegrandClass::band_limited(1.0, BAND)?;
    let worst = IntegrandClass::power_law(1.0, 2.0)?;
    let mut largest = 0.0_f64;
    for b in EXPONENTS {
        let profile = Profile::polynomial(b, ALPHA, GAMMA)?;
        for n in SUM_COUNTS {
            let factor = 4.0 * PI / n as f64;
            let power = |l: usize| profile.power(l, n);
            let sum: f64 = (1..=BAND).map(|l| (2 * l + 1) as f64 * power(l)).sum();
            // Beyond the break, ALPHA sqrt(n), the profile is its plateau.
            let last = n.isqrt() + 1;
            let head: f64 = (1..=last).map(|l| power(l) / (l * l) as f64).sum();
            let tail = GAMMA * hurwitz_zeta(2.0, last as f64 + 1.0);
            for (class, sum) in [(best, sum), (worst, head + tail)] {
                let closed = class.variance(&profile, n, Domain::Sphere);
                largest = largest.max((closed / (factor * sum) - 1.0).abs());
            }
        }
    }
    Ok(largest)
}

#[cfg(test)]
mod tests {
    use super::{ROUNDING, solvable};
    use crate::Verdict;

    #[test]
    fn only_closed_forms_contradict() {
        for (difference, expected) in [
            (0.0, Verdict::Wrong),
            (2.0 * ROUNDING, Verdict::Undecided),
            (f64::NAN, Verdict::Undecided),
        ] {
            assert_eq!(solvable(difference).verdict, expected, "{difference}");
        }
    }
}
