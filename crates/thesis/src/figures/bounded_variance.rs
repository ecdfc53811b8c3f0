use sphvar_bounds::{Profile, ThesisBound, thesis_bounds};
use sphvar_spectrum::Spectrum;

use super::Recipe;
use super::bound_claims::{claim_bounds, no_power};
use super::bounded_column::BoundedColumn;
use super::patterns::{BOUND_COLOUR, ThesisPattern};
use super::spectra::{LMAX, N_POINTS, mean_spectrum, omega_axis, spectrum_curve};
use super::variance_study::VarianceStudy;
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Quantity, Results, Setting, Stated,
    TestIntegrand,
};

/// Figure 7.4: mean spectra and variances of four samplers, within the thesis's bounds.
pub(crate) struct BoundedVariance;

/// The rows of the figure, in the order of [`thesis_bounds`] as well.
const ROWS: [ThesisPattern; 4] = [
    ThesisPattern::WhiteNoise,
    ThesisPattern::PoissonDisk,
    ThesisPattern::Jittered,
    ThesisPattern::Ccvt,
];
impl Recipe for BoundedVariance {
    fn title(&self) -> &'static str {
        "Bounds on mean spectra and on the variance of two integrands"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        let row = |pattern| {
            let study = VarianceStudy { pattern, setting };
            let spectrum = std::iter::once(mean_spectrum(pattern, setting));
            spectrum.chain(study.trials()).chain(study.spectra())
        };
        ROWS.into_iter().flat_map(row).collect()
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let mut columns = Vec::new();
        for (pattern, bounds) in ROWS.into_iter().zip(thesis_bounds()) {
            let job = mean_spectrum(pattern, setting);
            let spectrum = results.spectrum(&job)?;
            spectrum_panel(pattern, &bounds, spectrum, job.sets(), figure);
            claim_bounds(pattern, &bounds, spectrum, figure)?;
            match pattern {
                ThesisPattern::Ccvt => figure.claims.push(no_power(spectrum)),
                ThesisPattern::Jittered => claim_count(spectrum.n_points(), figure),
                _ => {}
            }
            for integrand in TestIntegrand::ALL {
                let column = BoundedColumn::new(pattern, bounds, integrand, setting, results)?;
                figure.panel(
                    &format!("{}-{}", pattern.name(), short(integrand)),
                    format!("{}: variance of the {}", pattern.label(), integrand.name()),
                    column.curves()?,
                );
                columns.push(column);
            }
        }
        for column in columns {
            column.claim(figure)?;
        }
        let most = |pattern| VarianceStudy { pattern, setting }.counts().last().copied();
        for pattern in ROWS {
            let Some(n) = most(pattern) else { continue };
            let trials = VarianceStudy { pattern, setting }.n_trials(n);
            figure
                .note(format!("{}: N to {n}, {trials} trials or more at each N.", pattern.label()));
        }
        figure.note(
            "Variances are those of the integral, not divided by their value for N = 1 as in the thesis. The harmonic has \
             norm 1 (erratum 31), the energy of the cap is that of orthonormal harmonics (erratum 33).",
        );
        figure.note(
            "Bounds are those of the thesis; omega is l/sqrt(N) in all rows, its alpha being part of a profile and of no \
             effect on constant ones (errata 8 and 41).",
        );
        figure.note(
            "CCVT has capacity 64 and random mass points; the thesis gives neither (erratum 39). Jittered sets have \
             12 nside^2 points: 3888 in the spectrum (erratum 38).",
        );
        Ok(())
    }
}

/// "We plot power spectra for N = 4096", of which there are no strata.
fn claim_count(n_points: usize, figure: &mut Figure) {
    figure.claims.push(
        Claim::number(
            "jittered: number of points of the spectrum",
            Stated::About { value: N_POINTS as f64, tolerance: 0.0 },
            Quantity::exact(n_points as f64),
        )
        .erratum(38)
        .because("there are 12 nside^2 HEALPix cells; found is the nearest such number"),
    );
}

fn spectrum_panel(
    pattern: ThesisPattern,
    bounds: &ThesisBound,
    spectrum: &Spectrum,
    sets: u64,
    figure: &mut Figure,
) {
    let n = spectrum.n_points();
    let root = (n as f64).sqrt();
    let line = |label, profile: &Profile| {
        let points = (1..=LMAX).map(|l| (l as f64 / root, profile.power(l, n)));
        Curve::line(label, BOUND_COLOUR, points)
    };
    let curves = vec![
        line("upper bound", &bounds.upper),
        line("lower bound", &bounds.lower),
        spectrum_curve(pattern.label(), pattern.colour(), spectrum),
    ];
    figure.panel(
        &format!("{}-spectrum", pattern.name()),
        format!("{}: mean power of {sets} sets, N = {n}", pattern.label()),
        Curves { x: omega_axis(), y: Axis::linear("power P(l)"), curves },
    );
}

fn short(integrand: TestIntegrand) -> &'static str {
    match integrand {
        TestIntegrand::Harmonic => "harmonic",
        TestIntegrand::Cap => "cap",
    }
}
