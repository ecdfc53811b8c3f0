use super::panels::{
    N_POINTS, SpectrumView, largest_power, mean_power, mean_spectrum, peaks_and_zero, points_panel,
    realizations,
};
use crate::figures::Recipe;
use crate::figures::square_patterns::PlanePattern;
use crate::{
    Claim, Error, Figure, Job, PlaneSpectrum, Quantity, Results, Setting, Stated, Verdict,
};

/// Figure 4.5: point sets, mean spectra and heat maps of white noise, jittered, Poisson disk and
/// regular patterns.
pub(crate) struct MeanSpectra;

const PATTERNS: [PlanePattern; 4] = [
    PlanePattern::WhiteNoise,
    PlanePattern::Jittered,
    PlanePattern::PoissonDisk,
    PlanePattern::Regular,
];
/// "Zero" and "not zero" are separated by a hundredth of white noise.
const ZERO: f64 = 0.01;
/// "Almost same power" is read as a change by at most a fifth.
const SAME: f64 = 0.2;

impl Recipe for MeanSpectra {
    fn title(&self) -> &'static str {
        "Point sets of the square and their mean power spectra"
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
            let spectrum = &results.plane(&mean_spectrum(pattern, setting))?.spectrum;
            // The DC peak, and the peaks of the regular grid.
            let rings = peaks_and_zero(spectrum, 0.5 * N_POINTS as f64);
            for (part, view, title) in [
                ("spectrum", SpectrumView::WHOLE, "mean power"),
                ("heat", SpectrumView::HEAT, "mean power, heat map"),
            ] {
                figure.panel(
                    &format!("{}-{part}", pattern.name()),
                    format!("{}, N = {N_POINTS}: {title}", pattern.label()),
                    view.field(spectrum, rings.clone()),
                );
            }
        }
        let plane = |pattern| results.plane(&mean_spectrum(pattern, setting));
        claim_disks(plane(PlanePattern::PoissonDisk)?, figure);
        claim_jitter(plane(PlanePattern::Jittered)?, figure);
        claim_regular(plane(PlanePattern::Regular)?, figure);
        figure.note(format!(
            "Means over {} sets; one set of the regular pattern. The DC peak P(0) = N is left out and has a ring.",
            realizations(setting)
        ));
        Ok(())
    }
}

fn claim_disks(disks: &PlaneSpectrum, figure: &mut Figure) {
    let [low, next] = [0.0..0.125, 0.125..0.25].map(|range| mean_power(disks, range));
    figure.claims.push(
        Claim::number(
            "Poisson disk: mean power for omega below 0.125",
            Stated::AtLeast(ZERO),
            Quantity::with_stderr(low.0, low.1),
        )
        .because("\"not zero or tending towards zero value, near the DC peak\", read as a hundredth of white noise"),
    );
    let ratio = next.0 / low.0;
    figure.claims.push(
        Claim::number(
            "Poisson disk: mean power for omega from 0.125 to 0.25, over that below 0.125",
            Stated::About { value: 1.0, tolerance: SAME },
            Quantity::with_stderr(ratio, ratio * (next.1 / next.0).hypot(low.1 / low.0)),
        )
        .because(
            "\"almost same power over the whole low frequency region around the DC peak\", read as omega to 0.25 and as within a \
             fifth; from there the power rises",
        ),
    );
}

fn claim_jitter(jittered: &PlaneSpectrum, figure: &mut Figure) {
    // The power at small omega is proportional to omega^2.
    let (power, stderr) = mean_power(jittered, 0.0..0.05);
    figure.claims.push(
        Claim::number(
            "jittered: mean power for omega below 0.05",
            Stated::AtMost(ZERO),
            Quantity::with_stderr(power, stderr),
        )
        .because("\"appears to be zero for frequencies going to zero\", read as a hundredth of white noise"),
    );
}

fn claim_regular(regular: &PlaneSpectrum, figure: &mut Figure) {
    let n = regular.spectrum.n_points() as f64;
    // Frequencies between the peaks have roundings only.
    let level = 1e-6;
    let rows = || regular.spectrum.rows().filter(|row| row.0 > 0);
    let others = rows().filter(|row| row.1 > level && row.1 < (1.0 - level) * n).count();
    let peaks = rows().filter(|row| row.1 >= (1.0 - level) * n).count();
    let verdict = if peaks > 0 && others == 0 { Verdict::Holds } else { Verdict::Wrong };
    figure.claims.push(
        Claim::words("regular: power besides the DC peak", "a set of high energy peaks", verdict)
            .measured(Quantity::exact(largest_power(&regular.spectrum)))
            .because(format!("{peaks} pairs of frequencies have N, all others 0"))
            .by_construction(),
    );
}
