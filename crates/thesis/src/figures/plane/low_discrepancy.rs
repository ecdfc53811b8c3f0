use sphvar_samplers::toroidal_separation;
use sphvar_sh::Frequencies;
use sphvar_spectrum::Spectrum;

use super::panels::{N_POINTS, RINGED, SpectrumView, peaks, points_panel, single_spectrum};
use crate::figures::Recipe;
use crate::figures::square_patterns::PlanePattern;
use crate::{Claim, Error, Figure, Job, Quantity, Results, Setting, Stated, Verdict};

/// Figure 4.7: Halton, Hammersley and Fibonacci points, their spectra and heat maps.
pub(crate) struct LowDiscrepancy;

const PATTERNS: [PlanePattern; 3] =
    [PlanePattern::Halton, PlanePattern::Hammersley, PlanePattern::Fibonacci];
/// A frequency of one set is a peak if its power is at least 10, ten times that of white noise: one
/// of 2e4 frequencies of independent points is.
const PEAK: f64 = 10.0;
/// "A number of high energy peaks" is read as at least half of the power in peaks.
const HALF: f64 = 0.5;
/// "Close points" are read as a separation of at most half that of a square lattice, 1/sqrt(N).
const CLOSE: f64 = 0.5;

impl Recipe for LowDiscrepancy {
    fn title(&self) -> &'static str {
        "Low-discrepancy points and their power spectra"
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        Vec::new()
    }

    fn compose(&self, setting: Setting, _: &Results, figure: &mut Figure) -> Result<(), Error> {
        let mut shares = Vec::new();
        for pattern in PATTERNS {
            points_panel(pattern, setting, figure)?;
            let spectrum = single_spectrum(pattern, setting, 0)?;
            let rings = peaks(&spectrum, RINGED * spectrum.n_points() as f64);
            for (part, view, title) in [
                ("spectrum", SpectrumView::WHOLE, "power"),
                ("heat", SpectrumView::HEAT, "power, heat map"),
            ] {
                figure.panel(
                    &format!("{}-{part}", pattern.name()),
                    format!("{}, N = {}: {title}", pattern.label(), spectrum.n_points()),
                    view.field(&spectrum, &rings),
                );
            }
            shares.push(share_of_peaks(&spectrum));
        }
        let [halton, hammersley, fibonacci] = shares[..] else {
            return Err(Error::Missing { key: "a spectrum".to_owned() });
        };
        let spread = halton < hammersley.min(fibonacci);
        figure.claims.push(
            Claim::words(
                "Halton: share of the power in peaks, below those of Hammersley and Fibonacci",
                "the power spectrum energy is more spread out",
                if spread { Verdict::Holds } else { Verdict::Wrong },
            )
            .measured(Quantity::exact(halton))
            .because(format!("Hammersley {hammersley:.3}, Fibonacci {fibonacci:.3}; a peak has a power of at least {PEAK}")),
        );
        figure.claims.push(
            Claim::number(
                "Hammersley: share of the power in peaks",
                Stated::AtLeast(HALF),
                Quantity::exact(hammersley),
            )
            .because("\"a number of high energy Fourier peaks\", read as half of the power"),
        );
        figure.claims.push(close_points(setting)?);
        figure.claims.push(
            Claim::number(
                "Fibonacci lattice: share of the power in peaks",
                Stated::AtLeast(HALF),
                Quantity::exact(fibonacci),
            )
            .because("\"a sea of high energy peaks\": the frequencies of the dual lattice have N, all others 0")
            .by_construction(),
        );
        figure.note(format!(
            "Halton in bases 2 and 3, Hammersley in base 2. About {N_POINTS} points, which the thesis does not state; Fibonacci \
             lattices have Fibonacci numbers of points. Frequencies with a power of \
             at least N/10 have rings.",
        ));
        Ok(())
    }
}

/// Returns the share of the power of all frequencies but 0 that is in peaks.
fn share_of_peaks(spectrum: &Spectrum<Frequencies>) -> f64 {
    let powers = || spectrum.power().iter().skip(1);
    powers().filter(|p| **p >= PEAK).sum::<f64>() / powers().sum::<f64>()
}

fn close_points(setting: Setting) -> Result<Claim, Error> {
    let points = PlanePattern::Hammersley.ensemble(N_POINTS).set(setting.seed, 0)?;
    let separation = toroidal_separation(&points, &()).map_err(sphvar_samplers::Error::from)?;
    let separation = separation.unwrap_or(f64::NAN) * (points.len() as f64).sqrt();
    Ok(Claim::number(
        "Hammersley: toroidal separation times sqrt(N)",
        Stated::AtMost(CLOSE),
        Quantity::exact(separation),
    )
    .because("\"some unavoidable close points\", read as half the distance in a square lattice"))
}
