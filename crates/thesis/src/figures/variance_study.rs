use sphvar_bounds::{Profile, variance_bound};
use sphvar_integrands::Energy;
use sphvar_samplers::Domain;
use sphvar_spectrum::{Resolution, Spectrum};
use sphvar_variance::{VariancePoint, predict};

use super::patterns::ThesisPattern;
use crate::{Error, Job, Results, Setting, TestIntegrand, ThesisEnsemble};

/// The variance of both test integrands over the number of points, for one pattern: measured,
/// predicted, bounded.
#[derive(Clone, Copy)]
pub(crate) struct VarianceStudy {
    pub(crate) pattern: ThesisPattern,
    pub(crate) setting: Setting,
}

/// Numbers of points for patterns that are valid at any N, in addition to those of HEALPix.
const FEW_POINTS: [usize; 3] = [1, 3, 6];
/// HEALPix resolutions, as evenly spaced in the logarithm as possible.
const NSIDES: [usize; 15] = [1, 2, 3, 4, 5, 6, 8, 11, 16, 23, 32, 45, 64, 80, 100];
/// The minimum and the maximum number of trials, as in the thesis.
const TRIALS: (u64, u64) = (200, 1000);
/// The minimum and the maximum number of realizations of a spectrum for predictions. Where sets are
/// expensive, they take half the time of trials, because powers of many degrees scatter less than
/// estimates.
const REALIZATIONS: (u64, u64) = (100, 1000);
/// The last degree of energies, beyond that of all spectra.
const LAST_DEGREE: usize = 2048;

impl VarianceStudy {
    /// Every number of points.
    pub(crate) fn counts(self) -> Vec<usize> {
        let max = match self.pattern {
            ThesisPattern::CcvtRandom | ThesisPattern::CcvtFibonacci => {
                self.setting.scale.pick(1452, 6348)
            }
            ThesisPattern::PoissonDisk => self.setting.scale.pick(12_288, 76_800),
            _ => self.setting.scale.pick(12_288, 120_000),
        };
        let any = !matches!(self.pattern, ThesisPattern::Jittered | ThesisPattern::Healpix);
        let few = FEW_POINTS.into_iter().filter(|_| any);
        few.chain(NSIDES.map(|nside| 12 * nside * nside)).filter(|&n| n <= max).collect()
    }

    /// Returns the jobs of measured variances.
    pub(crate) fn trials(self) -> Vec<Job> {
        self.counts().into_iter().map(|n| self.trial(n)).collect()
    }

    /// Returns the jobs of predicted variances: the spectra of other sets. That of white noise is
    /// known.
    pub(crate) fn spectra(self) -> Vec<Job> {
        if self.pattern == ThesisPattern::WhiteNoise {
            return Vec::new();
        }
        self.counts().into_iter().map(|n| self.spectrum(n)).collect()
    }

    /// Returns the measured variances.
    pub(crate) fn measured(
        self,
        results: &Results,
        integrand: TestIntegrand,
    ) -> Result<Vec<VariancePoint>, Error> {
        let point = |n: usize| {
            let measurement = &results.trials(&self.trial(n))?[integrand as usize];
            // The jackknife's error is the larger one where few trials carry the variance.
            let relative =
                measurement.relative_stderr().max(measurement.jackknife_relative_stderr());
            let variance = measurement.variance();
            Ok(VariancePoint { n_points: n as f64, variance, stderr: relative * variance })
        };
        self.counts().into_iter().map(point).collect()
    }

    /// Returns the variances that the spectra predict.
    pub(crate) fn predicted(
        self,
        results: &Results,
        integrand: TestIntegrand,
    ) -> Result<Vec<VariancePoint>, Error> {
        let energy = energy(integrand)?;
        let point = |n: usize| {
            let prediction = if self.pattern == ThesisPattern::WhiteNoise {
                predict(
                    &Spectrum::exact(
                        Domain::Sphere,
                        n,
                        vec![1.0; Resolution::natural_degree(n) + 1],
                    ),
                    &energy,
                )
            } else {
                predict(results.spectrum(&self.spectrum(n))?, &energy)
            };
            Ok(VariancePoint {
                n_points: n as f64,
                variance: prediction.variance,
                stderr: prediction.total_stderr(),
            })
        };
        self.counts().into_iter().map(point).collect()
    }

    /// Returns the number of trials for a number of points.
    pub(crate) fn n_trials(self, n_points: usize) -> u64 {
        self.trial(n_points).sets()
    }

    fn ensemble(self, n_points: usize) -> ThesisEnsemble {
        ThesisEnsemble::sphere(self.pattern.pattern(), n_points)
    }

    fn trial(self, n_points: usize) -> Job {
        let of = |sets| Job::Trials { ensemble: self.ensemble(n_points), sets };
        of(affordable(&of(1), self.setting.scale.pick(2.5e7, 3.3e8), TRIALS))
    }

    fn spectrum(self, n_points: usize) -> Job {
        let of = |sets| Job::Spectrum {
            ensemble: self.ensemble(n_points),
            domain: Domain::Sphere,
            lmax: Resolution::natural_degree(n_points),
            sets,
        };
        of(affordable(&of(1), self.setting.scale.pick(1.25e7, 1.7e8), REALIZATIONS))
    }
}

/// Returns the number of sets of a job that take about the given nominal work, within limits.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a positive number, and too large ones become the largest"
)]
fn affordable(job: &Job, work: f64, (min, max): (u64, u64)) -> u64 {
    ((work / job.work_of_set()) as u64).clamp(min, max)
}

/// Returns the energies of a test integrand.
pub(crate) fn energy(integrand: TestIntegrand) -> Result<Energy, Error> {
    Ok(integrand.function()?.energy(Domain::Sphere, LAST_DEGREE)?)
}

/// Returns the variance that a profile allows, at its larger end.
pub(crate) fn bound(profile: &Profile, n_points: usize, energy: &Energy) -> Result<f64, Error> {
    let tail = energy.beyond(energy.lmax());
    Ok(variance_bound(profile, n_points, Domain::Sphere, energy.per_band(), tail)?.upper)
}
