use std::f64::consts::PI;

use sphvar_samplers::Domain;
use sphvar_spectrum::Spectrum;

use super::Recipe;
use super::disk_placement::with_dart_throwing;
use super::mass_points::{NOTE, with_both_kinds};
use super::noise_colours;
use super::order_grid::{OrderGrid, Style};
use super::patterns::{OTHER_COLOUR, ThesisPattern};
use super::sampler_spectra::far_spectrum;
use super::spectra::{mean_power, mean_spectrum, omega_axis, spectrum_curve};
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Palette, Quantity, Results, Setting, Stated,
    ThesisEnsemble,
};

/// Figure 2.2: how powers of single frequencies become a radial average, and the features of blue
/// noise in it. The thesis shows the plane; here the average over the orders of a degree replaces
/// the one over a circle.
pub(crate) struct RadialAverage;

/// The number of points of the triangle.
const N_POINTS: usize = 1024;
/// Its last degree, omega = 3.
const LMAX: usize = 96;
/// The patterns that the thesis calls blue noise (sections 6.2.2 and 7.4).
const BLUE: [ThesisPattern; 3] =
    [ThesisPattern::PoissonDisk, ThesisPattern::CcvtRandom, ThesisPattern::CcvtFibonacci];
/// "Little or no energy" is read as at most this part of white noise.
const LITTLE: f64 = 0.1;
/// The tolerance of the power of "high-frequency white noise" around 1.
const FLAT: f64 = 0.1;
/// Tolerance: the powers of a degree and the average of its orders come from one transform and
/// differ by some roundings.
const ROUNDING: f64 = 1e-12;

/// omega of the mean distance of neighbours in a square lattice, sqrt(4 pi/N):
/// `l = 2 pi/distance = sqrt(pi N)`.
fn principal() -> f64 {
    PI.sqrt()
}

fn ensemble() -> ThesisEnsemble {
    ThesisEnsemble::sphere(ThesisPattern::PoissonDisk.pattern(), N_POINTS)
}

fn orders(setting: Setting) -> Job {
    Job::Orders { ensemble: ensemble(), lmax: LMAX, sets: setting.scale.pick(50, 200) }
}

fn averages(setting: Setting) -> Job {
    let sets = orders(setting).sets();
    Job::Spectrum { ensemble: ensemble(), domain: Domain::Sphere, lmax: LMAX, sets }
}

impl Recipe for RadialAverage {
    fn title(&self) -> &'static str {
        "From the powers of orders to a radial average, and the colours of noise"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        let spectra =
            BLUE.map(|pattern| [mean_spectrum(pattern, setting), far_spectrum(pattern, setting)]);
        [orders(setting), averages(setting)]
            .into_iter()
            .chain(spectra.into_iter().flatten())
            .chain(noise_colours::jobs(setting))
            .collect()
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let grid = OrderGrid::new(results.orders(&orders(setting))?);
        let power = Style { label: "power", palette: Palette::Heat };
        figure.panel(
            "orders",
            format!("Poisson disk, N = {N_POINTS}: mean power of every order"),
            grid.triangle(&power, |p| p),
        );
        let spectrum = |pattern| results.spectrum(&mean_spectrum(pattern, setting));
        let mut curves = vec![ideal()];
        for pattern in BLUE {
            curves.push(spectrum_curve(pattern.label(), pattern.colour(), spectrum(pattern)?));
        }
        figure.panel(
            "average",
            "Averages over the orders of each degree",
            Curves { x: omega_axis(), y: Axis::linear("mean angular power P"), curves },
        );
        figure.claims.push(average(&grid, results.spectrum(&averages(setting))?));
        let features = [peak, empty, flat];
        for (feature, job) in features.into_iter().zip([mean_spectrum, mean_spectrum, far_spectrum])
        {
            let claim = |pattern| Ok(feature(pattern, results.spectrum(&job(pattern, setting))?));
            figure.claims.push(with_dart_throwing(claim(ThesisPattern::PoissonDisk)?));
            figure.claims.push(with_both_kinds(None, claim)?);
        }
        figure.note(format!(
            "The thesis shows a sketch of the plane, after Ulichney. The principal frequency, that of the mean distance \
             between neighbours, is sqrt(pi N) on the sphere: omega = {:.3}.",
            principal()
        ));
        figure.note(NOTE);
        noise_colours::compose(setting, results, figure)
    }
}

/// No energy below the principal frequency and that of white noise above it.
fn ideal() -> Curve {
    let (edge, end) = (principal(), 4.0);
    let points = [(0.0, 0.0), (edge, 0.0), (edge * (1.0 + f64::EPSILON), 1.0), (end, 1.0)];
    Curve::line("transition of ideal blue noise", OTHER_COLOUR, points)
}

/// "Taking the radial average over different values over the radial circle at each frequency."
fn average(grid: &OrderGrid<'_>, spectrum: &Spectrum) -> Claim {
    let difference = |l: usize| (grid.power(l) / spectrum.power()[l] - 1.0).abs();
    Claim::number(
        "mean over the orders of a degree against its mean angular power, largest relative difference",
        Stated::About { value: 0.0, tolerance: ROUNDING },
        Quantity::exact((1..=grid.lmax()).map(difference).fold(0.0, f64::max)),
    )
    .because("equation 4.2 defines one as the other")
    .by_construction()
}

fn peak(pattern: ThesisPattern, spectrum: &Spectrum) -> Claim {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a degree below that of the spectrum"
    )]
    let l = (principal() * (spectrum.n_points() as f64).sqrt()).round() as usize;
    Claim::number(
        format!("{}: power at the principal frequency", pattern.subject()),
        Stated::AtLeast(1.0),
        Quantity::with_stderr(spectrum.power()[l], spectrum.stderr()[l]),
    )
    .because(format!(
        "\"its peak should be at the principal frequency\": above white noise there; l = {l}"
    ))
}

fn empty(pattern: ThesisPattern, spectrum: &Spectrum) -> Claim {
    let edge = 0.5 * principal() * (spectrum.n_points() as f64).sqrt();
    let (power, stderr) = mean_power(spectrum, |l| l > 0 && l as f64 <= edge);
    Claim::number(
        format!("{}: mean power below half the principal frequency", pattern.subject()),
        Stated::AtMost(LITTLE),
        Quantity::with_stderr(power, stderr),
    )
    .because("\"a sharp transition level below which little or no energy exists\", read as a tenth of white noise")
}

fn flat(pattern: ThesisPattern, spectrum: &Spectrum) -> Claim {
    let first = 6.0 * (spectrum.n_points() as f64).sqrt();
    let far = spectrum.rows().filter(|row| row.0 as f64 >= first);
    let largest = far
        .map(|(_, power, stderr)| ((power - 1.0).abs(), stderr))
        .fold((0.0, f64::NAN), |a, b| if b.0 > a.0 { b } else { a });
    Claim::number(
        format!("{}: largest |P - 1| for omega from 6 to 8", pattern.subject()),
        Stated::AtMost(FLAT),
        Quantity::with_stderr(largest.0, largest.1),
    )
    .because("\"uncorrelated high-frequency fluctuations are characterized by high-frequency white noise\", read to a tenth")
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::Domain;
    use sphvar_spectrum::Spectrum;

    use super::{ThesisPattern, empty, flat, peak, principal};
    use crate::Verdict;

    /// Spectra of 1024 points to omega = 8 that are 0 below an edge and constant above.
    fn step(edge: f64, above: f64) -> Spectrum {
        let power =
            (0..=256).map(|l| if f64::from(l) / 32.0 < edge { 0.0 } else { above }).collect();
        Spectrum::exact(Domain::Sphere, 1024, power)
    }

    #[test]
    fn features_are_detected_at_their_positions() {
        for (edge, above, expected) in [
            (principal() - 0.1, 1.05, [Verdict::Holds, Verdict::Holds, Verdict::Holds]),
            (principal() + 0.1, 1.05, [Verdict::Wrong, Verdict::Holds, Verdict::Holds]),
            (0.0, 1.2, [Verdict::Holds, Verdict::Wrong, Verdict::Wrong]),
        ] {
            let spectrum = step(edge, above);
            let got = [peak, empty, flat].map(|f| f(ThesisPattern::PoissonDisk, &spectrum).verdict);
            assert_eq!(got, expected, "{edge}, {above}");
        }
    }
}
