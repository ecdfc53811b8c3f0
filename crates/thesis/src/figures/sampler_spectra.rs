use sphvar_samplers::{Domain, Pattern};
use sphvar_spectrum::Spectrum;

use super::Recipe;
use super::bound_claims::no_power;
use super::disk_placement::with_dart_throwing;
use super::mass_points::{NOTE, with_both_kinds};
use super::patterns::ThesisPattern;
use super::point_panel::{hemisphere_points, sphere_points};
use super::spectra::{
    LMAX, N_POINTS, mean_power, mean_spectrum, omega_axis, realizations, spectrum_curve,
};
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Mark, Quantity, Results, Setting, Stated,
    ThesisEnsemble,
};

/// Figure 4.14: the mean spectra of the random patterns on the sphere and on the hemisphere.
pub(crate) struct SamplerSpectra;

/// The patterns of the sphere.
const SPHERE: [ThesisPattern; 5] = [
    ThesisPattern::WhiteNoise,
    ThesisPattern::Jittered,
    ThesisPattern::PoissonDisk,
    ThesisPattern::CcvtRandom,
    ThesisPattern::CcvtFibonacci,
];
/// The patterns of the hemisphere, whose number of points the thesis does not state.
const HEMISPHERE: [ThesisPattern; 4] = [SPHERE[0], SPHERE[1], SPHERE[2], SPHERE[3]];
/// The patterns whose hemisphere sets are visible halves of sphere sets in the thesis.
const CUT: [ThesisPattern; 3] = [SPHERE[1], SPHERE[2], SPHERE[3]];
/// The number of points of a hemisphere, half of that of the sphere.
const N_HALF: usize = N_POINTS / 2;
/// The number of points of the pictures.
const N_SHOWN: usize = 1024;
/// The number of points of spectra that reach far, to omega = 8, for the limit.
const N_FAR: usize = 1024;
/// The last of the low degrees of the hemisphere: omega = 0.35.
const LAST_LOW: usize = 16;
/// Numbers of points of halves whose power of degree 2 gives a rate.
const N_RATE: [usize; 2] = [1536, 6144];

/// The construction of hemisphere sets.
#[derive(Clone, Copy)]
enum Half {
    /// The upper points of sphere sets, as in the thesis.
    Kept,
    /// The antipodal pattern.
    Own,
}

fn hemisphere_spectrum(pattern: ThesisPattern, half: Half, setting: Setting) -> Job {
    let ensemble = match (half, pattern) {
        // The thesis generates white noise directly on the hemisphere.
        (
            Half::Kept,
            ThesisPattern::Jittered | ThesisPattern::PoissonDisk | ThesisPattern::CcvtRandom,
        ) => ThesisEnsemble::visible_half(pattern.pattern(), N_HALF),
        _ => ThesisEnsemble::hemisphere(pattern.pattern(), N_HALF),
    };
    Job::Spectrum {
        ensemble,
        domain: Domain::Hemisphere,
        lmax: LMAX,
        sets: realizations(pattern, setting),
    }
}

/// Sphere sets of few points to a high omega.
pub(super) fn far_spectrum(pattern: ThesisPattern, setting: Setting) -> Job {
    Job::Spectrum {
        ensemble: ThesisEnsemble::sphere(pattern.pattern(), N_FAR),
        domain: Domain::Sphere,
        lmax: LMAX,
        sets: setting.scale.pick(100, 400),
    }
}

/// Degree 2 of visible halves of jittered sets.
fn seam(n_points: usize, setting: Setting) -> Job {
    Job::Spectrum {
        ensemble: ThesisEnsemble::visible_half(Pattern::Jittered, n_points),
        domain: Domain::Hemisphere,
        lmax: 2,
        sets: setting.scale.pick(1000, 4000),
    }
}

impl Recipe for SamplerSpectra {
    fn title(&self) -> &'static str {
        "Mean spectra of random patterns on the sphere and the hemisphere"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        let sphere = SPHERE
            .into_iter()
            .flat_map(|pattern| [mean_spectrum(pattern, setting), far_spectrum(pattern, setting)]);
        let hemisphere = HEMISPHERE.into_iter().flat_map(|pattern| {
            [Half::Kept, Half::Own].map(|half| hemisphere_spectrum(pattern, half, setting))
        });
        sphere.chain(hemisphere).chain(N_RATE.map(|n| seam(n, setting))).collect()
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let sphere = |pattern| results.spectrum(&mean_spectrum(pattern, setting));
        let half = |pattern, half| results.spectrum(&hemisphere_spectrum(pattern, half, setting));
        spectra_panel(figure, "sphere", "Sphere", &SPHERE, sphere)?;
        let far = |pattern| results.spectrum(&far_spectrum(pattern, setting));
        spectra_panel(figure, "far", "Sphere, fewer points and higher frequencies", &SPHERE, far)?;
        spectra_panel(
            figure,
            "half",
            "Hemisphere: halves of sphere sets, as in the thesis",
            &HEMISPHERE,
            |p| half(p, Half::Kept),
        )?;
        spectra_panel(figure, "hemisphere", "Hemisphere: antipodal patterns", &HEMISPHERE, |p| {
            half(p, Half::Own)
        })?;
        let mut low = Vec::new();
        for pattern in HEMISPHERE {
            for (how, mark, made) in
                [("halves", Mark::Markers, Half::Kept), ("own", Mark::Line, Half::Own)]
            {
                let label = format!("{}, {how}", pattern.label());
                let mut curve = spectrum_curve(label, pattern.colour(), half(pattern, made)?);
                curve.points.retain(|p| p[0] < 1.0);
                curve.mark = mark;
                low.push(curve);
            }
        }
        figure.panel(
            "seam",
            "What the cut at the equator adds at low degrees",
            Curves { x: omega_axis(), y: Axis::log("mean angular power P"), curves: low },
        );
        insets(setting, figure)?;

        for pattern in [ThesisPattern::WhiteNoise, ThesisPattern::Jittered] {
            figure.claims.push(limit(pattern, far(pattern)?));
        }
        let disks = ThesisPattern::PoissonDisk;
        figure.claims.push(with_dart_throwing(limit(disks, far(disks)?)));
        figure.claims.push(with_both_kinds(None, |kind| Ok(limit(kind, far(kind)?)))?);
        let low = with_both_kinds(Some(40), |kind| Ok(no_power(kind, sphere(kind)?)))?;
        figure.claims.push(low);
        for pattern in CUT {
            let (kept, own) = (half(pattern, Half::Kept)?, half(pattern, Half::Own)?);
            figure.note(seam_power(pattern, kept, own));
        }
        let [few, many] = N_RATE.map(|n| results.spectrum(&seam(n, setting)));
        figure.note(seam_rate(few?, many?));
        notes(setting, figure);
        Ok(())
    }
}

fn spectra_panel<'a>(
    figure: &mut Figure,
    name: &str,
    title: &str,
    patterns: &[ThesisPattern],
    spectrum: impl Fn(ThesisPattern) -> Result<&'a Spectrum, Error>,
) -> Result<(), Error> {
    let curve = |&pattern: &ThesisPattern| -> Result<Curve, Error> {
        let spectrum = spectrum(pattern)?;
        let label = format!("{}, N = {}", pattern.label(), spectrum.n_points());
        Ok(spectrum_curve(label, pattern.colour(), spectrum))
    };
    let curves: Result<Vec<Curve>, Error> = patterns.iter().map(curve).collect();
    let y = Axis::linear("mean angular power P");
    figure.panel(name, title, Curves { x: omega_axis(), y, curves: curves? });
    Ok(())
}

/// A set of each pattern, with fewer points than the spectra have.
fn insets(setting: Setting, figure: &mut Figure) -> Result<(), Error> {
    for pattern in HEMISPHERE {
        let sphere = ThesisEnsemble::sphere(pattern.pattern(), N_SHOWN);
        figure.panel(
            &format!("{}-sphere", pattern.name()),
            format!("{}, N = {}", pattern.label(), sphere.n_points),
            sphere_points(sphere.set(setting.seed, 0)?),
        );
        let half = match pattern {
            ThesisPattern::WhiteNoise => ThesisEnsemble::hemisphere(pattern.pattern(), N_SHOWN / 2),
            _ => ThesisEnsemble::visible_half(pattern.pattern(), N_SHOWN / 2),
        };
        let points = half.set(setting.seed, 0)?;
        figure.panel(
            &format!("{}-half", pattern.name()),
            format!("{}, {} points", pattern.label(), points.len()),
            hemisphere_points(points),
        );
    }
    Ok(())
}

/// "The power of any sampling pattern converges to 1": over two units of omega, about a period of
/// the remaining oscillations.
fn limit(pattern: ThesisPattern, spectrum: &Spectrum) -> Claim {
    /// omega = 6 at 1024 points.
    const FIRST: usize = 192;
    let (mean, stderr) = mean_power(spectrum, |l| (FIRST..=LMAX).contains(&l));
    Claim::number(
        format!("{}: limit of the power, mean for omega from 6 to 8", pattern.subject()),
        Stated::About { value: 1.0, tolerance: 0.01 },
        Quantity::with_stderr(mean, stderr),
    )
    .because(format!("N = {}, weighted by 2l+1; for lattices see Figure 4.10", spectrum.n_points()))
}

/// Returns the effect of the cut at the equator: the ratio of the mean power of the low degrees of
/// halves to that of antipodal patterns. Section 4.3 uses halves of sphere sets as a procedure and
/// makes no claim about them.
fn seam_power(pattern: ThesisPattern, kept: &Spectrum, own: &Spectrum) -> String {
    let low = |l| (2..=LAST_LOW).contains(&l);
    let (kept_mean, kept_error) = mean_power(kept, low);
    let (own_mean, own_error) = mean_power(own, low);
    let ratio = kept_mean / own_mean;
    let stderr = ratio * (kept_error / kept_mean).hypot(own_error / own_mean);
    format!(
        "Halves of sphere sets, {}: in degrees 2 to {LAST_LOW} they have {ratio:.3} +- {stderr:.3} times the power of the \
         antipodal pattern ({kept_mean:.4} against {own_mean:.4}; at l = 2 {:.4} against {:.4}), because the \
         cut at the equator is a seam (erratum 13).",
        pattern.label(),
        kept.power()[2],
        own.power()[2]
    )
}

/// Returns the exponent of N of the power of degree 2 of halves, which is -1 for jitter of the
/// sphere.
fn seam_rate(few: &Spectrum, many: &Spectrum) -> String {
    let [a, b] = [few, many].map(|s| (s.n_points() as f64, s.power()[2], s.stderr()[2]));
    let steps = (b.0 / a.0).ln();
    let exponent = (b.1 / a.1).ln() / steps;
    let stderr = (a.2 / a.1).hypot(b.2 / b.1) / steps;
    format!(
        "Halves of jittered sphere sets: P(2) falls as N^({exponent:.2} +- {stderr:.2}) between {} and {} points. On the \
         sphere it falls as N^-1; the part of the seam falls as N^-1/2.",
        a.0, b.0
    )
}

fn notes(setting: Setting, figure: &mut Figure) {
    figure.note(format!(
        "{} realizations, {} of CCVT. HEALPix strata exist for 12 nside^2 points on the sphere and 6 nside^2 on the \
         hemisphere.",
        realizations(ThesisPattern::WhiteNoise, setting),
        realizations(ThesisPattern::CcvtRandom, setting)
    ));
    figure.note(
        "Poisson disk sets have exactly N points and the chord 2.893/sqrt(N) of the author's program. The hemisphere is \
         shown with random mass points of CCVT only.",
    );
    figure.note(NOTE);
    figure.note(
        "On the hemisphere N counts the points above and only even degrees exist; at equal density omega is sqrt(2) times \
         that of the sphere. The thesis makes white noise on the hemisphere itself.",
    );
}
