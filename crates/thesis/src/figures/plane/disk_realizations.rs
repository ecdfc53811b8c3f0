use sphvar_spectrum::RadialSpectrum;

use super::panels::{
    N_POINTS, SpectrumView, mean_spectrum, points_of, realizations, single_spectrum,
};
use crate::figures::Recipe;
use crate::figures::square_patterns::PlanePattern;
use crate::{Claim, Error, Figure, Job, Quantity, Results, Setting, Stated};

/// Figure 4.4: realizations of Poisson disk sets, their spectra, and the mean spectrum.
pub(crate) struct DiskRealizations;

const PATTERN: PlanePattern = PlanePattern::PoissonDisk;
/// The number of realizations shown.
const SHOWN: u64 = 3;
/// The rings whose noise is compared, omega from 2 to 2.4: the power hardly changes over a ring.
const RINGS: std::ops::Range<usize> = 128..154;

impl Recipe for DiskRealizations {
    fn title(&self) -> &'static str {
        "Realizations of Poisson disks and their mean power spectrum"
    }

    fn jobs(&self, setting: Setting) -> Vec<Job> {
        vec![mean_spectrum(PATTERN, setting)]
    }

    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error> {
        let mut noise = Vec::new();
        for index in 0..SHOWN {
            let number = index + 1;
            figure.panel(
                &format!("points-{number}"),
                format!("Poisson disk, realization {number}"),
                points_of(PATTERN, setting, index)?,
            );
            let spectrum = single_spectrum(PATTERN, setting, index)?;
            figure.panel(
                &format!("spectrum-{number}"),
                format!("Power of realization {number}, N = {N_POINTS}"),
                SpectrumView::WHOLE.field(&spectrum, &[]),
            );
            noise.push(relative_variance(&RadialSpectrum::of(&spectrum)));
        }
        let mean = results.plane(&mean_spectrum(PATTERN, setting))?;
        let sets = realizations(setting);
        figure.panel(
            "mean",
            format!("Mean power over {sets} realizations"),
            SpectrumView::WHOLE.field(&mean.spectrum, &[]),
        );
        let single = noise.iter().sum::<f64>() / noise.len() as f64;
        let ratio = relative_variance(&mean.radial) / single;
        figure.claims.push(
            Claim::number(
                "relative variance over rings, mean of M realizations over single ones, times M",
                Stated::About { value: 1.0, tolerance: 0.2 },
                // Every ring has some 400 pairs of frequencies, of exponential power.
                Quantity::with_stderr(
                    ratio * sets as f64,
                    ratio * sets as f64 * (8.0 / (400.0 * (RINGS.len() as u64 * SHOWN) as f64)).sqrt(),
                ),
            )
            .because(format!(
                "\"to obtain a neat power spectrum\" by the mean over realizations; {single:.3} for one, omega from 2 to 2.4"
            )),
        );
        figure.note(format!(
            "Frequencies of a realization have independent powers with an exponential distribution, to a good approximation: \
             their relative variance is 1, and 1/M in the mean over M = {sets}. The DC peak P(0) = N is left out and has a \
             ring.",
        ));
        Ok(())
    }
}

/// Returns the mean over [`RINGS`] of the relative variance of the power in a ring.
fn relative_variance(radial: &RadialSpectrum) -> f64 {
    // Rings are counted from radius 1.
    let rings = &radial.anisotropy()[RINGS.start - 1..RINGS.end - 1];
    rings.iter().sum::<f64>() / rings.len() as f64
}
