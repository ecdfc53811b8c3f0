use sphvar_bounds::{Profile, ThesisBound, thesis_bounds};
use sphvar_spectrum::Spectrum;

use super::Recipe;
use super::bound_claims::within_bounds;
use super::bounded_column::BoundedColumn;
use super::disk_placement::{boundary_spectrum, with_both_placements, with_dart_throwing};
use super::mass_points::{NOTE, with_both_kinds};
use super::patterns::{BOUND_COLOUR, ThesisPattern};
use super::spectra::{LMAX, N_POINTS, mean_spectrum, omega_axis, spectrum_curve};
use super::variance_study::VarianceStudy;
use crate::{
    Axis, Claim, Curve, Curves, Error, Figure, Job, Quantity, Results, Setting, Stated,
    TestIntegrand, Verdict,
};

/// Figure 7.4: mean spectra and variances of four samplers, within the thesis's bounds.
pub(crate) struct BoundedVariance;

/// The rows of the figure, each with the index of its bounds in [`thesis_bounds`].
const ROWS: [(ThesisPattern, usize); 5] = [
    (ThesisPattern::WhiteNoise, 0),
    (ThesisPattern::PoissonDisk, 1),
    (ThesisPattern::Jittered, 2),
    (ThesisPattern::CcvtRandom, 3),
    (ThesisPattern::CcvtFibonacci, 3),
];

impl Recipe for BoundedVariance {
    fn title(&self) -> &'static str {
        "Bounds on mean spectra and on the variance of two integrands"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        let row = |(pattern, _)| {
            let study = VarianceStudy { pattern, setting };
            let spectrum = std::iter::once(mean_spectrum(pattern, setting));
            spectrum.chain(study.trials()).chain(study.spectra())
        };
        ROWS.into_iter().flat_map(row).chain([boundary_spectrum(setting)]).collect()
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let bounds = thesis_bounds();
        let (mut claims, mut of_kinds) = (Vec::new(), Vec::new());
        for (pattern, index) in ROWS {
            let row = Row { pattern, bounds: bounds[index], setting, results };
            row.panels(figure)?;
            match pattern {
                ThesisPattern::CcvtRandom | ThesisPattern::CcvtFibonacci => {
                    of_kinds.push((pattern, row.claims()?));
                }
                ThesisPattern::PoissonDisk => {
                    // The bounds of the spectrum are checked with both placements.
                    let of_variances = row.claims()?.split_off(2);
                    for i in 0..2 {
                        let bound = |job: &Job| {
                            let spectrum = results.spectrum(job)?;
                            Ok(within_bounds(pattern, &bounds[index], spectrum)?[i].clone())
                        };
                        claims.push(with_both_placements(bound, setting)?);
                    }
                    claims.extend(of_variances.into_iter().map(with_dart_throwing));
                }
                _ => claims.extend(row.claims()?),
            }
            if pattern == ThesisPattern::Jittered {
                claims.push(count(results.spectrum(&mean_spectrum(pattern, setting))?.n_points()));
            }
        }
        figure.claims = claims;
        for i in 0..of_kinds.iter().map(|(_, claims)| claims.len()).min().unwrap_or(0) {
            let claim = |kind| {
                let of = of_kinds.iter().find(|(pattern, _)| *pattern == kind);
                of.map(|(_, claims)| claims[i].clone())
                    .ok_or_else(|| Error::Missing { key: "a kind of CCVT".to_owned() })
            };
            figure.claims.push(with_both_kinds(Some(40), claim)?);
        }
        let max_count = |pattern| VarianceStudy { pattern, setting }.counts().last().copied();
        for (pattern, _) in ROWS {
            let Some(n) = max_count(pattern) else { continue };
            let trials = VarianceStudy { pattern, setting }.n_trials(n);
            figure
                .note(format!("{}: N to {n}, {trials} trials or more at each N.", pattern.label()));
        }
        figure.note(
            "Variances are those of the integral, not divided by their value for N = 1 as in the thesis. The harmonic has \
             norm 1 (erratum 31), the energy of the cap is that of orthonormal harmonics (erratum 33).",
        );
        figure.note(
            "Bounds are those of the thesis; omega is l/sqrt(N) in all rows, because alpha is a parameter of a profile \
             without effect on constant ones (errata 8 and 41).",
        );
        figure.note(NOTE);
        figure.note("Jittered sets have 12 nside^2 points: 3888 in the spectrum (erratum 38).");
        Ok(())
    }
}

/// A pattern of the figure with its bounds.
struct Row<'a> {
    pattern: ThesisPattern,
    bounds: ThesisBound,
    setting: Setting,
    results: &'a Results,
}

impl Row<'_> {
    fn column(&self, integrand: TestIntegrand) -> Result<BoundedColumn, Error> {
        BoundedColumn::new(self.pattern, self.bounds, integrand, self.setting, self.results)
    }

    /// Adds the spectrum and both variances.
    fn panels(&self, figure: &mut Figure) -> Result<(), Error> {
        let job = mean_spectrum(self.pattern, self.setting);
        let spectrum = self.results.spectrum(&job)?;
        spectrum_panel(self.pattern, &self.bounds, spectrum, job.sets(), figure);
        for integrand in TestIntegrand::ALL {
            figure.panel(
                &format!("{}-{}", self.pattern.name(), short(integrand)),
                format!("{}: variance of the {}", self.pattern.label(), integrand.name()),
                self.column(integrand)?.curves()?,
            );
        }
        Ok(())
    }

    /// Returns the claims about the spectrum, then those about the variances.
    fn claims(&self) -> Result<Vec<Claim>, Error> {
        let spectrum = self.results.spectrum(&mean_spectrum(self.pattern, self.setting))?;
        let mut claims = within_bounds(self.pattern, &self.bounds, spectrum)?.to_vec();
        for integrand in TestIntegrand::ALL {
            claims.extend(self.column(integrand)?.claims()?);
        }
        Ok(claims)
    }
}

/// "We plot power spectra for N = 4096", for which no strata exist.
fn count(n_points: usize) -> Claim {
    Claim::number(
        "jittered: number of points of the spectrum",
        Stated::About { value: N_POINTS as f64, tolerance: 0.0 },
        Quantity::exact(n_points as f64),
    )
    .erratum_if(Verdict::Wrong, 38)
    .because("there are 12 nside^2 HEALPix cells; this is the nearest such number")
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
