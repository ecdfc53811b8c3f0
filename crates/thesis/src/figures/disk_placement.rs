use sphvar_samplers::{DiskMode, DiskPlacement, Domain, Pattern, PoissonDiskParameters};

use super::patterns::ThesisPattern;
use super::spectra::{LMAX, N_POINTS, mean_spectrum, realizations};
use crate::{Claim, Error, Job, Setting, ThesisEnsemble};

/// The reason why the sets generated here cannot contradict a claim about Poisson disk sets; see
/// Figure 7.2.
const WHY: &str = "undecided: the sets come from dart throwing, those of the thesis are close to boundary sampling";

/// Returns a claim about the Poisson disk sets of the thesis, checked with sets from dart throwing
/// only, which cannot contradict it.
pub(crate) fn with_dart_throwing(claim: Claim) -> Claim {
    claim.on_substitute(WHY)
}

/// Returns a claim about the Poisson disk sets of the thesis, checked with the mean spectra of sets
/// from dart throwing and from boundary sampling.
///
/// The thesis states that its sets are close to boundary sampling, not how close. A claim that holds
/// with one kind depends on that; one that is wrong with both is wrong.
pub(crate) fn with_both_placements(
    claim: impl Fn(&Job) -> Result<Claim, Error>,
    setting: Setting,
) -> Result<Claim, Error> {
    let options = vec![
        ("dart throwing", claim(&mean_spectrum(ThesisPattern::PoissonDisk, setting))?),
        ("boundary sampling", claim(&boundary_spectrum(setting))?),
    ];
    Ok(Claim::over_choice("the placement of Poisson disks", options))
}

/// Returns the job of the mean spectrum of Poisson disks by boundary sampling, saturated with about
/// [`N_POINTS`] points.
pub(crate) fn boundary_spectrum(setting: Setting) -> Job {
    let pattern = Pattern::PoissonDisk(PoissonDiskParameters {
        mode: DiskMode::Saturated,
        placement: DiskPlacement::Boundary,
        ..PoissonDiskParameters::DEFAULT
    });
    Job::Spectrum {
        ensemble: ThesisEnsemble::sphere(pattern, N_POINTS),
        domain: Domain::Sphere,
        lmax: LMAX,
        sets: realizations(ThesisPattern::PoissonDisk, setting),
    }
}

#[cfg(test)]
mod tests {
    use super::{boundary_spectrum, with_both_placements};
    use crate::{Claim, Quantity, Scale, Setting, Stated, Verdict};

    #[test]
    fn the_placement_decides_or_does_not() {
        let setting = Setting { scale: Scale::Quick, seed: 0 };
        for (thrown, boundary, verdict) in [
            (0.06, 0.04, Verdict::Depends),
            (0.04, 0.03, Verdict::Wrong),
            (0.06, 0.07, Verdict::Holds),
        ] {
            let claim = |job: &_| {
                let value = if *job == boundary_spectrum(setting) { boundary } else { thrown };
                Ok(Claim::number("", Stated::AtLeast(0.05), Quantity::exact(value)))
            };
            let got = with_both_placements(claim, setting).unwrap();
            assert_eq!(got.verdict, verdict, "{thrown}, {boundary}");
        }
    }
}
