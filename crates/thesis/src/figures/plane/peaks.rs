use super::panels::{SpectrumView, largest_power, peaks, points_panel, single_spectrum};
use crate::figures::Recipe;
use crate::figures::square_patterns::PlanePattern;
use crate::{Claim, Error, Figure, Job, Quantity, Results, Setting, Stated};

/// Figure 4.2: jittered and regular sets, and their power spectra.
pub(crate) struct Peaks;

const PATTERNS: [PlanePattern; 2] = [PlanePattern::Jittered, PlanePattern::Regular];
/// A power of a single set above this part of N counts as a high-energy peak. Among the 4e4
/// frequencies of a set of white noise the largest is about ln 4e4 = 11.
const PEAK: f64 = 0.01;

impl Recipe for Peaks {
    fn title(&self) -> &'static str {
        "Jittered and regular points and their power spectra"
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        Vec::new()
    }

    fn compose(&self, setting: Setting, _: &Results, figure: &mut Figure) -> Result<(), Error> {
        for pattern in PATTERNS {
            points_panel(pattern, setting, figure)?;
            let spectrum = &single_spectrum(pattern, setting, 0)?;
            let n = spectrum.n_points() as f64;
            let rings = peaks(spectrum, PEAK * n);
            figure.panel(
                &format!("{}-spectrum", pattern.name()),
                format!("{}, N = {n}: power of one set, peaks in rings", pattern.label()),
                SpectrumView::WHOLE.field(spectrum, &rings),
            );
            let largest = Quantity::exact(largest_power(spectrum) / n);
            let what = format!("{}: largest power besides the DC peak, over N", pattern.label());
            figure.claims.push(if pattern == PlanePattern::Regular {
                Claim::number(what, Stated::AtLeast(PEAK), largest)
                    .because("\"contains high energy peaks\": N at the multiples of sqrt(N) in each direction")
                    .by_construction()
            } else {
                Claim::number(what, Stated::AtMost(PEAK), largest).because(format!(
                    "\"no visible high energy peaks\", read as at most {PEAK} of the DC peak in one set"
                ))
            });
        }
        figure.note(
            "The caption calls (a) jittered and (b) its spectrum, the text (b) regular; here as in the caption. The DC peak \
             P(0) = N is left out and has a ring.",
        );
        Ok(())
    }
}
