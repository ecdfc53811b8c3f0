use super::panels::{SpectrumView, mean_spectrum, points_panel, realizations, single_spectrum};
use crate::figures::Recipe;
use crate::figures::square_patterns::PlanePattern;
use crate::{Claim, Error, Figure, Job, PlaneSpectrum, Quantity, Results, Setting, Stated};

/// Figure 4.3: Poisson disks with plain and with toroidal distances.
pub(crate) struct WrappedDisks;

const PATTERNS: [PlanePattern; 2] = [PlanePattern::UnwrappedDisk, PlanePattern::PoissonDisk];
/// "Large magnitude peaks" on an axis are read as at least this multiple of the power off the axes.
const LARGE: f64 = 2.0;
/// "No such peaks" allows this difference from the power off the axes.
const NONE: f64 = 0.1;

impl Recipe for WrappedDisks {
    fn title(&self) -> &'static str {
        "Poisson disks with plain and toroidal distances"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        PATTERNS.map(|pattern| mean_spectrum(pattern, setting)).into()
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        for pattern in PATTERNS {
            points_panel(pattern, setting, figure)?;
            let single = &single_spectrum(pattern, setting, 0)?;
            let mean = results.plane(&mean_spectrum(pattern, setting))?;
            let n = single.n_points();
            for (part, view, spectrum, title) in [
                ("spectrum", SpectrumView::WHOLE, single, "power of one set"),
                ("low", SpectrumView::LOW, single, "low frequencies of one set"),
                ("low-mean", SpectrumView::LOW, &mean.spectrum, "low frequencies, mean"),
            ] {
                figure.panel(
                    &format!("{}-{part}", pattern.name()),
                    format!("{}, N = {n}: {title}", pattern.label()),
                    view.field(spectrum, &[]),
                );
            }
            claim_axes(pattern, mean, figure);
        }
        figure.note(format!(
            "Sets from dart throwing with exactly N points. The power on an axis, (k, 0) or (0, k), is compared with that of \
             the other frequencies over 0 < |k| <= sqrt(N)/4, omega to 1/4; means over {} sets. The DC peak P(0) = N is left out and has a ring.",
            realizations(setting)
        ));
        Ok(())
    }
}

fn claim_axes(pattern: PlanePattern, mean: &PlaneSpectrum, figure: &mut Figure) {
    let (stated, because) = match pattern {
        PlanePattern::UnwrappedDisk => (
            Stated::AtLeast(LARGE),
            "\"a set of large magnitude peaks visible in the low frequency zone\", read as twice the power off the axes",
        ),
        _ => (
            Stated::About { value: 1.0, tolerance: NONE },
            "\"no such peaks in the low frequency region\", read as the power off the axes within a tenth",
        ),
    };
    for (axis, name) in ["horizontal", "vertical"].into_iter().enumerate() {
        let ratio = Quantity::with_stderr(mean.axes.ratio[axis], mean.axes.stderr[axis]);
        figure.claims.push(
            Claim::number(
                format!(
                    "{}: power on the {name} axis near 0, over that off the axes",
                    pattern.label()
                ),
                stated.clone(),
                ratio,
            )
            .because(format!("{because} ({:.4})", mean.axes.off_axes)),
        );
    }
}
