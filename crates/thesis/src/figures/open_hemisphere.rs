use sphvar_samplers::Domain;
use sphvar_sh::legendre_p;
use sphvar_spectrum::Spectrum;

use super::Recipe;
use super::order_grid::{OrderGrid, Style};
use super::patterns::{OTHER_COLOUR, ThesisPattern};
use super::point_panel::hemisphere_points;
use super::spectra::{omega_axis, spectrum_curve};
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Mark, Palette, Quantity, Results, Setting,
    ThesisEnsemble, Verdict,
};

/// Figure 4.15: hemisphere sets read as sets of the sphere.
pub(crate) struct OpenHemisphere;

const PATTERNS: [ThesisPattern; 3] =
    [ThesisPattern::WhiteNoise, ThesisPattern::Jittered, ThesisPattern::Fibonacci];
/// The number of points of a hemisphere, which the thesis does not state.
const N_POINTS: usize = 1024;
/// The last degree of the squares.
const LMAX_ORDERS: usize = 64;
/// The last degree of the spectra, omega = 4.
const LMAX: usize = 128;
/// Minimum ratio of a peak to the power of white noise.
const PEAK: f64 = 10.0;

/// Sets as in the thesis, without rotation.
fn ensemble(pattern: ThesisPattern) -> ThesisEnsemble {
    match pattern {
        ThesisPattern::Jittered => ThesisEnsemble::visible_half(pattern.pattern(), N_POINTS),
        _ => ThesisEnsemble::hemisphere(pattern.pattern(), N_POINTS),
    }
    .unrotated()
}

fn sets(pattern: ThesisPattern, setting: Setting) -> u64 {
    match pattern {
        ThesisPattern::Fibonacci => 1,
        _ => setting.scale.pick(200, 1000),
    }
}

fn orders(pattern: ThesisPattern, setting: Setting) -> Job {
    let (ensemble, sets) = (ensemble(pattern), sets(pattern, setting));
    Job::Orders { ensemble, lmax: LMAX_ORDERS, sets }
}

fn spectrum(pattern: ThesisPattern, setting: Setting) -> Job {
    let (ensemble, sets) = (ensemble(pattern), sets(pattern, setting));
    Job::Spectrum { ensemble, domain: Domain::Sphere, lmax: LMAX, sets }
}

impl Recipe for OpenHemisphere {
    fn title(&self) -> &'static str {
        "Hemisphere sets read as sets of the sphere"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        PATTERNS.iter().flat_map(|&p| [orders(p, setting), spectrum(p, setting)]).collect()
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        for pattern in PATTERNS {
            let (name, label) = (pattern.name(), pattern.label());
            let points = ensemble(pattern).set(setting.seed, 0)?;
            figure.panel(
                &format!("{name}-points"),
                format!("{label}, {} points", points.len()),
                hemisphere_points(points),
            );
            let grid = OrderGrid::new(results.orders(&orders(pattern, setting))?);
            let style = Style { label: "square root of power", palette: Palette::Heat };
            figure.panel(
                &format!("{name}-square"),
                format!("{label}, square-shaped"),
                grid.square(&style, 1, f64::sqrt),
            );
            let spectrum = results.spectrum(&spectrum(pattern, setting))?;
            let curves = vec![
                uniform_density(spectrum.n_points())?,
                spectrum_curve(label, pattern.colour(), spectrum),
            ];
            figure.panel(
                &format!("{name}-spectrum"),
                label,
                Curves { x: omega_axis(), y: Axis::log("mean angular power P"), curves },
            );
            figure.claims.push(peaks(pattern, spectrum)?);
        }
        figure.note(format!(
            "N = {N_POINTS} points of the hemisphere, for jitter the upper half of 2028; the thesis states no numbers. Sets are not \
             rotated. The squares omit degree 0 and show square roots, which make more than the peaks visible."
        ));
        figure.note(
            "A uniform density on the upper half alone has P(l) = N (int_0^1 P_l dz)^2 in odd degrees and nothing in even \
             ones: the peaks belong to the domain, not to the pattern.",
        );
        Ok(())
    }
}

/// `int_0^1 P_l(z) dz = (P_(l-1)(0) - P_(l+1)(0))/(2l+1)`, for l >= 1: the mean of `P_l` over a
/// hemisphere.
fn mean_legendre(l: usize) -> Result<f64, Error> {
    Ok((legendre_p(l - 1, 0.0)? - legendre_p(l + 1, 0.0)?) / (2 * l + 1) as f64)
}

/// Returns the power that white noise of the hemisphere has on the sphere,
/// `1 + (N-1) (int_0^1 P_l dz)^2`, at odd degrees.
fn uniform_density(n_points: usize) -> Result<Curve, Error> {
    let n = n_points as f64;
    let point = |l: usize| -> Result<[f64; 3], Error> {
        Ok([l as f64 / n.sqrt(), white_noise(n, l)?, 0.0])
    };
    let points: Result<Vec<_>, Error> = (1..=LMAX).step_by(2).map(point).collect();
    Ok(Curve::new("white noise, odd degrees, closed form", OTHER_COLOUR, Mark::Markers, points?))
}

fn white_noise(n: f64, l: usize) -> Result<f64, Error> {
    Ok(1.0 + (n - 1.0) * mean_legendre(l)?.powi(2))
}

fn peaks(pattern: ThesisPattern, spectrum: &Spectrum) -> Result<Claim, Error> {
    let found = Quantity::with_stderr(spectrum.power()[1], spectrum.stderr()[1]);
    let (low, high) = found.interval;
    let verdict = if low > PEAK {
        Verdict::Holds
    } else if high < PEAK {
        Verdict::Wrong
    } else {
        Verdict::Undecided
    };
    let closed = white_noise(spectrum.n_points() as f64, 1)?;
    Ok(Claim::words(
        format!("{}: P(1) of the hemisphere's points on the sphere", pattern.label()),
        "high energy peaks near l = 0",
        verdict,
    )
    .measured(found)
    .because(format!(
        "white noise has 1 + (N-1)/4 = {closed:.2}, and 1 in every even degree; here P(2) = {:.3}, P(3) = {:.2}",
        spectrum.power()[2],
        spectrum.power()[3]
    )))
}
