//! The colours of noise of section 2.1.1, on the sphere.

use sphvar_samplers::{Domain, NoiseColour, Pattern, PowerProfile, ProfileParameters};
use sphvar_spectrum::Spectrum;

use super::patterns::{OTHER_COLOUR, ThesisPattern};
use super::spectra::{omega_axis, spectrum_curve};
use crate::{
    Axis, Claim, Curves, Error, Figure, Job, Quantity, Results, Setting, Stated, ThesisEnsemble,
    Verdict,
};

/// The number of points.
const N_POINTS: usize = 1024;
/// The last degree, omega = 4.
const LMAX: usize = 128;
/// The displayed powers; pink noise has more at low degrees.
const MAX_POWER: f64 = 2.5;

pub(crate) fn jobs(setting: Setting) -> Vec<Job> {
    let all = std::iter::once(Pattern::WhiteNoise).chain(NoiseColour::ALL.map(pattern));
    all.map(|pattern| spectrum(pattern, setting)).collect()
}

fn pattern(colour: NoiseColour) -> Pattern {
    Pattern::Profile(ProfileParameters { profile: PowerProfile::Colour(colour), core: 0.0 })
}

fn spectrum(pattern: Pattern, setting: Setting) -> Job {
    Job::Spectrum {
        ensemble: ThesisEnsemble::sphere(pattern, N_POINTS),
        domain: Domain::Sphere,
        lmax: LMAX,
        sets: setting.scale.pick(10, 100),
    }
}

/// Adds the spectra of white, pink, green and blue noise, and the statements about them.
pub(crate) fn compose(
    setting: Setting,
    results: &Results,
    figure: &mut Figure,
) -> Result<(), Error> {
    let of = |pattern| results.spectrum(&spectrum(pattern, setting));
    let mut curves = Vec::new();
    for (name, pattern, colour) in [
        ("white", Pattern::WhiteNoise, OTHER_COLOUR),
        ("pink", pattern(NoiseColour::Pink), ThesisPattern::CcvtRandom.colour()),
        ("green", pattern(NoiseColour::Green), ThesisPattern::PoissonDisk.colour()),
        ("blue", pattern(NoiseColour::Blue), ThesisPattern::WhiteNoise.colour()),
    ] {
        curves.push(spectrum_curve(name, colour, of(pattern)?));
    }
    figure.panel(
        "colours",
        format!("Colours of noise, N = {N_POINTS}"),
        Curves {
            x: omega_axis(),
            y: Axis::linear("mean angular power P").over(0.0, MAX_POWER),
            curves,
        },
    );
    let [pink, green, blue] = NoiseColour::ALL.map(|colour| of(pattern(colour)));
    let (pink, green, blue) = (pink?, green?, blue?);
    figure.claims.push(
        Claim::number(
            "pink noise: exponent of the power over the frequency",
            Stated::About { value: -1.0, tolerance: 1e-3 },
            Quantity::exact(exponent(pink)),
        )
        .because(format!(
            "\"inversely proportional to the frequency\": between the first degree and omega = {}, to which the pattern \
             {} prescribes it",
            NoiseColour::Pink.end(),
            pattern(NoiseColour::Pink)
        ))
        .by_construction(),
    );
    let [pink, green, blue] =
        [(NoiseColour::Pink, pink), (NoiseColour::Green, green), (NoiseColour::Blue, blue)]
            .map(|(colour, spectrum)| peak(spectrum, colour.end()));
    let verdict = if pink < green && green < blue { Verdict::Holds } else { Verdict::Wrong };
    figure.claims.push(
        Claim::words(
            "green noise: frequency of the largest power, between those of pink and blue noise",
            "primarily mid-range frequencies",
            verdict,
        )
        .measured(Quantity::exact(green))
        .because(format!("pink {pink:.2}, blue {blue:.2}; omega = l/sqrt(N)"))
        .by_construction(),
    );
    figure.note(format!(
        "Colours of noise: sets of the sphere with a prescribed power at every degree up to omega = {}, {} and {} (pink, \
         green, blue); beyond, all tend to white noise, as every point set does. The thesis describes them for signals.",
        NoiseColour::Pink.end(),
        NoiseColour::Green.end(),
        NoiseColour::Blue.end()
    ));
    Ok(())
}

/// Returns the exponent between degree 1 and the last one of the target of pink noise.
fn exponent(spectrum: &Spectrum) -> f64 {
    let [first, .., last] = target_of(spectrum, NoiseColour::Pink.end())[..] else {
        return f64::NAN;
    };
    (last.1 / first.1).ln() / (last.0 / first.0).ln()
}

/// Returns omega of the largest power to `end`.
fn peak(spectrum: &Spectrum, end: f64) -> f64 {
    let rows = target_of(spectrum, end);
    rows.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(f64::NAN, |row| row.0)
}

/// Returns omega and power of the degrees from 1 to omega = `end`.
fn target_of(spectrum: &Spectrum, end: f64) -> Vec<(f64, f64)> {
    let root = (spectrum.n_points() as f64).sqrt();
    let rows = spectrum.rows().map(|(l, power, _)| (l as f64 / root, power));
    rows.filter(|row| row.0 > 0.0 && row.0 <= end).collect()
}
