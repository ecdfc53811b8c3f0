use sphvar_spectrum::Spectrum;
use sphvar_variance::{VariancePoint, fit_rate};

use super::Recipe;
use super::disk_placement::{boundary_spectrum, with_both_placements};
use super::patterns::{BOUND_COLOUR, OTHER_COLOUR, ThesisPattern};
use super::spectra::{mean_spectrum, omega_axis, spectrum_curve};
use crate::{Axis, Claim, Curve, Curves, Error, Figure, Job, Quantity, Results, Setting, Stated};

/// Figure 7.10: the low degrees of Poisson disk and jittered patterns.
pub(crate) struct LowFrequencies;

const PATTERNS: [ThesisPattern; 2] = [ThesisPattern::PoissonDisk, ThesisPattern::Jittered];
/// The thesis's offset of Poisson disk patterns.
const OFFSET: f64 = 0.055;
/// The power follows `P0 + c x^2` for degrees to x = 0.5, with `x^2 = l(l+1)/N`.
const PARABOLA_END: f64 = 0.5;
/// Those of jitter to 0.25 are quadratic within 2 %.
const QUADRATIC: f64 = 0.25;

impl Recipe for LowFrequencies {
    fn title(&self) -> &'static str {
        "Low degrees of Poisson disk and jittered patterns"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        let mut jobs: Vec<Job> = PATTERNS.map(|pattern| mean_spectrum(pattern, setting)).into();
        jobs.push(boundary_spectrum(setting));
        jobs
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let spectrum = |pattern| results.spectrum(&mean_spectrum(pattern, setting));
        for (name, pattern) in [("a", PATTERNS[0]), ("b", PATTERNS[1])] {
            let curve = spectrum_curve(pattern.label(), pattern.colour(), spectrum(pattern)?);
            let title = format!("{}, all degrees", pattern.label());
            figure.panel(name, title, axes(vec![curve]));
        }
        for (name, pattern) in [("c", PATTERNS[0]), ("d", PATTERNS[1])] {
            let mut whole = spectrum_curve(pattern.label(), pattern.colour(), spectrum(pattern)?);
            whole.points.retain(|p| p[0] <= 1.0);
            let mut curves = vec![whole];
            if pattern == ThesisPattern::PoissonDisk {
                let level = Curve::line("0.055", BOUND_COLOUR, [(0.0, OFFSET), (1.0, OFFSET)]);
                let boundary = results.spectrum(&boundary_spectrum(setting))?;
                let label = "Poisson disk, boundary sampling";
                let mut boundary = spectrum_curve(label, OTHER_COLOUR, boundary);
                boundary.points.retain(|p| p[0] <= 1.0);
                curves.splice(0..0, [level, boundary]);
            }
            figure.panel(name, format!("{}, omega in ]0, 1[", pattern.label()), axes(curves));
        }
        claim_offset(results, setting, figure)?;
        claim_rise(spectrum(ThesisPattern::Jittered)?, figure);
        for pattern in PATTERNS {
            let (n, sets) = (spectrum(pattern)?.n_points(), mean_spectrum(pattern, setting).sets());
            figure.note(format!("{}: N = {n}, {sets} sets.", pattern.label()));
        }
        Ok(())
    }
}

fn claim_offset(results: &Results, setting: Setting, figure: &mut Figure) -> Result<(), Error> {
    let about = Stated::About { value: OFFSET, tolerance: 0.0005 };
    for (what, stated, window, remark) in [
        (
            "offset of Poisson disk, omega to 0",
            about.clone(),
            PARABOLA_END,
            format!("P0 of P0 + c l(l+1)/N, fitted to omega = {PARABOLA_END}"),
        ),
        (
            "the same, fitted over omega in ]0, 1[",
            about,
            1.0,
            "the power is no parabola there: a window as wide as that of the figure returns less than the limit with dart-throwing \
             sets and more with boundary sampling, both nearer to 0.055"
                .to_owned(),
        ),
        (
            "offset of Poisson disk and 1/20",
            Stated::AtLeast(0.05),
            PARABOLA_END,
            "1/20 is the bound of section 6.2.2".to_owned(),
        ),
    ] {
        let claim = |job: &Job| {
            let (offset, stderr) = parabola(low(results.spectrum(job)?, window));
            let measured = Quantity::with_stderr(offset, stderr);
            Ok(Claim::number(what, stated.clone(), measured).because(remark.clone()))
        };
        figure.claims.push(with_both_placements(claim, setting)?.erratum(30));
    }
    figure.note(
        "Poisson disks by dart throwing have exactly 4096 points and the chord 2.893/sqrt(N). Those by boundary sampling \
         (Dunbar and Humphreys 2006; the boundary of a random point is filled before that of the next) are saturated, \
         with 4096 points on average and the chord 3.276/sqrt(N); their \
         power at l = 1 is higher, because a set grows from one point.",
    );
    Ok(())
}

fn claim_rise(jittered: &Spectrum, figure: &mut Figure) {
    let (at_zero, stderr) = parabola(low(jittered, QUADRATIC));
    figure.claims.push(
        Claim::number(
            "power of jittered, omega to 0",
            Stated::AtMost(1e-3),
            Quantity::with_stderr(at_zero, stderr),
        )
        .because("it is said to approach zero, which is read as a thousandth of white noise"),
    );
    let n = jittered.n_points() as f64;
    let points: Vec<VariancePoint> = low(jittered, QUADRATIC)
        // The same straight line through logarithms, of power over x.
        .map(|(x2, power, stderr)| VariancePoint {
            n_points: (x2 * n).sqrt(),
            variance: power,
            stderr,
        })
        .collect();
    let (slope, interval) =
        fit_rate(&points).map_or((f64::NAN, (f64::NAN, f64::NAN)), |fit| (fit.slope, fit.interval));
    figure.claims.push(
        Claim::number(
            "low-frequency exponent of jittered",
            Stated::About { value: 2.0, tolerance: 0.05 },
            Quantity { value: slope, interval },
        )
        .because(format!(
            "of the power over sqrt(l(l+1)), to omega = {QUADRATIC}; over l it seems to be smaller"
        )),
    );
}

/// `x^2 = l(l+1)/N`, power and standard error of the degrees to x.
fn low(spectrum: &Spectrum, to: f64) -> impl Iterator<Item = (f64, f64, f64)> {
    let n = spectrum.n_points() as f64;
    let rows = spectrum.rows().filter(|row| row.0 > 0);
    rows.map(move |(l, power, stderr)| ((l * (l + 1)) as f64 / n, power, stderr))
        .filter(move |row| row.0 <= to * to)
}

/// `P0` and its standard error from the weighted fit of `P0 + c x^2` to rows of [`low`].
fn parabola(rows: impl Iterator<Item = (f64, f64, f64)>) -> (f64, f64) {
    let rows: Vec<_> = rows.map(|(x2, power, stderr)| (x2, power, stderr.powi(-2))).collect();
    let sum = |f: &dyn Fn(f64, f64) -> f64| rows.iter().map(|r| r.2 * f(r.0, r.1)).sum::<f64>();
    let weight = sum(&|_, _| 1.0);
    let (x0, y0) = (sum(&|x, _| x) / weight, sum(&|_, y| y) / weight);
    let spread = sum(&|x, _| (x - x0).powi(2));
    let c = sum(&|x, y| (x - x0) * (y - y0)) / spread;
    (y0 - c * x0, (1.0 / weight + x0 * x0 / spread).sqrt())
}

fn axes(curves: Vec<Curve>) -> Curves {
    Curves { x: omega_axis(), y: Axis::linear("power P(l)"), curves }
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::Domain;

    use super::{PARABOLA_END, Spectrum, low, parabola};

    #[test]
    fn an_offset_is_recovered() {
        let power = (0..=40).map(|l| 0.06 + 0.04 * f64::from(l * (l + 1)) / 400.0).collect();
        let exact = Spectrum::exact(Domain::Sphere, 400, power);
        // l = 9 is the last degree with l(l+1) <= 0.25 * 400. Errors are unequal, to test the
        // weights.
        let rows = || low(&exact, PARABOLA_END).map(|(x2, power, _)| (x2, power, 0.01 + x2));
        assert_eq!(rows().count(), 9);
        let (offset, _) = parabola(rows());
        // Some tens of roundings of numbers below 1, through a fit that magnifies them tenfold.
        assert!((offset - 0.06).abs() < 1e3 * f64::EPSILON, "{offset}");
    }

    #[test]
    fn its_error_matches_the_textbook_formula() {
        // x^2 = 0, 1, 2 with errors 1: variance of the intercept 1/3 + 1/2.
        let (offset, stderr) =
            parabola([(0.0, 1.0, 1.0), (1.0, 3.0, 1.0), (2.0, 5.0, 1.0)].into_iter());
        assert!((offset - 1.0).abs() < 8.0 * f64::EPSILON, "{offset}");
        assert!((stderr - (5.0_f64 / 6.0).sqrt()).abs() < 8.0 * f64::EPSILON, "{stderr}");
    }
}
