use super::panels::{
    N_POINTS, RINGED, SpectrumView, largest_power, mean_power, mean_spectrum, peaks, points_panel,
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
/// Ends of the low frequency region: a quarter of the frequency 1/spacing of a square lattice, and
/// a half, its Nyquist frequency.
const REGION_ENDS: [(&str, f64); 2] = [("a quarter", 0.25), ("a half", 0.5)];

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
            // Those of the regular grid.
            let rings = peaks(spectrum, RINGED * N_POINTS as f64);
            for (part, view, title) in [
                ("spectrum", SpectrumView::WHOLE, "mean power"),
                ("heat", SpectrumView::HEAT, "mean power, heat map"),
            ] {
                figure.panel(
                    &format!("{}-{part}", pattern.name()),
                    format!("{}, N = {N_POINTS}: {title}", pattern.label()),
                    view.field(spectrum, &rings),
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
    let (power, stderr) = mean_power(disks, 0.0..0.125);
    figure.claims.push(
        Claim::number(
            "Poisson disk: mean power for omega below 0.125",
            Stated::AtLeast(ZERO),
            Quantity::with_stderr(power, stderr),
        )
        .because("\"not zero or tending towards zero value, near the DC peak\", read as a hundredth of white noise"),
    );
    figure.claims.push(flatness(disks));
}

/// Compares the halves of the low frequency region, whose end the thesis does not state.
fn flatness(disks: &PlaneSpectrum) -> Claim {
    let options = REGION_ENDS.map(|(name, end)| {
        let [inner, outer] =
            [0.0..0.5 * end, 0.5 * end..end].map(|range| mean_power(disks, range));
        let ratio = outer.0 / inner.0;
        let claim = Claim::number(
            "Poisson disk: mean power in the outer half of the low frequency region, over the inner half",
            Stated::About { value: 1.0, tolerance: SAME },
            Quantity::with_stderr(ratio, ratio * (outer.1 / outer.0).hypot(inner.1 / inner.0)),
        );
        let because = "\"almost same power over the whole low frequency region around the DC peak\", read as within a fifth";
        (name, claim.because(because))
    });
    Claim::over_choice("omega at the end of the low frequency region", options.into())
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
