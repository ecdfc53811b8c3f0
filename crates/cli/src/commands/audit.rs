//! `sphvar audit`: whether an ensemble is rotation-invariant, as the variance formula assumes.

mod chart;
pub(crate) mod report;

use std::path::PathBuf;

use clap::Args;
use glam::DMat3;
use sphvar_samplers::{
    Domain, Pattern, PointSet, Purpose, Realizations, Sampler, SetDistribution, Streams,
};
use sphvar_spectrum::{
    AuditSettings, Ensemble as PointEnsemble, HomogeneityAccumulator, HomogeneityAudit, Resolution,
    accumulate,
};

use self::report::{AuditBody, AuditRecord, Ensemble};
use super::sets_args::SetsArgs;
use crate::counts::{parse_number, parse_one_count, parse_realizations};
use crate::error::CliError;
use crate::global::Global;
use crate::memory::{check_degree, check_memory, check_transform};
use crate::patterns;
use crate::point_sets::{FileSets, RotatedSets, WeightSums};
use crate::progress::Progress;
use crate::report::{Forms, Provenance, check_result, emit};
use crate::session::Session;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar audit jittered -n 768 -m 2000
  sphvar audit --points sets.npy --lmax 6

The variance formula holds for ensembles whose distribution is invariant under rotations. The audit \
tests the coefficients of degrees 1 to --lmax (on the hemisphere the even ones):
  means        E S_lm = 0: no bias (value: the mean in units of sqrt(P(l)))
  phases       arg S_lm and its double uniform for m >= 1; S_l0 is real (mean resultant length)
  orders       the same power for all orders of a degree (P(l,m)/P(l))
  covariances  different coefficients uncorrelated, degrees up to 4 (correlation)
  rotations    the mean of the random rotations is 0 (entry of the mean)
Degrees without power, such as odd ones of antipodal sets, are not tested. Each p-value comes from \
copies of the ensemble in which every set is randomly rotated once more; all tests together \
reject a homogeneous ensemble with probability --alpha at most. A sampler is audited both as drawn \
and after uniform random rotations. The exit status is 0 whatever the outcome.";

/// The minimum number of realizations for a verdict.
const MIN_REALIZATIONS: u64 = 30;
/// The default number of realizations.
const REALIZATIONS: u64 = 2000;

#[derive(Debug, Args)]
pub(crate) struct AuditArgs {
    #[command(flatten)]
    pub(crate) sets: SetsArgs,
    #[arg(
        help = format!(
            "Number of realizations, at least {MIN_REALIZATIONS} [default: {REALIZATIONS}; of a file with several sets, each set once]"
        ),
        short = 'm',
        long,
        value_name = "M",
        value_parser = parse_realizations,
        conflicts_with = "points_from"
    )]
    pub(crate) realizations: Option<u64>,
    /// Maximum degree, inclusive
    #[arg(long, value_name = "L", default_value = "8", value_parser = parse_one_count)]
    pub(crate) lmax: usize,
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.01,
        value_parser = parse_number,
        help = format!(
            "Probability of rejecting a homogeneous ensemble, from {:e} to {}",
            AuditSettings::MIN_ALPHA,
            AuditSettings::MAX_ALPHA
        )
    )]
    pub(crate) alpha: f64,
    /// Relative error of the variance that the audit must be able to detect for the verdict yes
    #[arg(long, value_name = "E", default_value_t = 0.2, value_parser = parse_number)]
    pub(crate) tolerance: f64,
    /// Audit the sampler as drawn only, not after uniform random rotations
    #[arg(long, conflicts_with = "points_from")]
    pub(crate) unrotated: bool,
    /// Write the results to a file: .csv or .json, or a plot of the error of every spherical harmonic as .svg or .png
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// The source of the point sets.
enum Source {
    Sampler { name: String, sampler: Box<dyn Sampler>, streams: Streams },
    Files(FileSets),
}

impl Source {
    /// Returns the sets of a pattern from a file, if each is to be taken once.
    fn given_sets(&self, realizations: Option<u64>) -> Option<&[PointSet]> {
        let Self::Sampler { sampler, .. } = self else { return None };
        match sampler.distribution() {
            SetDistribution::OneOf(sets) if sets.len() > 1 && realizations.is_none() => Some(sets),
            _ => None,
        }
    }
}

pub(crate) fn run(args: &AuditArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out {
        check_result(path, true)?;
    }
    let domain = args.sets.domain.domain();
    let settings =
        AuditSettings { alpha: args.alpha, tolerance: args.tolerance, seed: global.seed };
    check_settings(args, domain)?;
    let source = source(args, domain, global)?;
    let given = source.given_sets(args.realizations);
    let (name, n_points, count) = match &source {
        Source::Sampler { name, sampler, .. } => {
            let default = given.map_or(REALIZATIONS, |sets| sets.len() as u64);
            (&**name, sampler.n_points(), args.realizations.unwrap_or(default))
        }
        Source::Files(sets) => (sets.name(), sets.mean_size(), sets.count()),
    };
    let plan = Plan { domain, settings, count, resolution: Resolution::new(args.lmax, n_points) };
    plan.check_memory()?;
    let weights = match &source {
        Source::Sampler { sampler, .. } => WeightSums::of_sampler(&**sampler)?,
        Source::Files(sets) => WeightSums::of_sets(sets.sets().sets()),
    };
    let audits = plan.audits(&source, given, args.unrotated, &global.session)?;

    let provenance = Provenance::new(&global.session, global.seed);
    let records =
        audits.iter().map(|(ensemble, audit)| AuditRecord::new(*ensemble, audit, &settings));
    let body = AuditBody {
        sampler: name.to_owned(),
        domain: domain.name(),
        n: n_points,
        n_effective: weights.map(|weights| weights.n_effective),
        realizations: count,
        lmax: args.lmax,
        alpha: args.alpha,
        tolerance: args.tolerance,
        copies: settings.replicates(),
        audits: records.collect(),
    };
    let chart = || Ok(chart::chart(name, n_points, args.alpha, &audits));
    let forms =
        Forms { csv: &|| body.csv(&provenance), chart: Some(&chart), text: &|| body.text() };
    emit(args.out.as_deref(), global, &provenance, &body, &forms)
}

/// Rejects settings that the library would reject only after the work.
fn check_settings(args: &AuditArgs, domain: Domain) -> Result<(), CliError> {
    check_degree("--lmax", args.lmax)?;
    let min_lmax = domain.degree_step();
    if args.lmax < min_lmax {
        return Err(CliError::Usage(format!(
            "--lmax must be at least {min_lmax} on the {domain}, got {}",
            args.lmax
        )));
    }
    let (min, max, got) = (AuditSettings::MIN_ALPHA, AuditSettings::MAX_ALPHA, args.alpha);
    if !(min..=max).contains(&got) {
        return Err(CliError::Usage(format!("--alpha must be in [{min:e}, {max}], got {got}")));
    }
    if !(args.tolerance > 0.0 && args.tolerance.is_finite()) {
        let got = args.tolerance;
        return Err(CliError::Usage(format!("--tolerance must be above 0 and finite, got {got}")));
    }
    if let Some(got) = args.realizations.filter(|&count| count < MIN_REALIZATIONS) {
        return Err(CliError::Usage(format!(
            "-m must be at least {MIN_REALIZATIONS} for an audit, got {got}"
        )));
    }
    Ok(())
}

fn source(args: &AuditArgs, domain: Domain, global: &Global) -> Result<Source, CliError> {
    let Some(name) = &args.sets.sampler.sampler else {
        let sets = FileSets::read(&args.sets.files, domain, &global.session)?;
        check_sets(sets.name(), sets.count())?;
        return Ok(Source::Files(sets));
    };
    let (n, nearest) = (args.sets.count.count, args.sets.nearest.nearest);
    let (pattern, sampler) =
        patterns::sampler_of::<Pattern, _>(name, n, domain, nearest, &global.session)?;
    // A single set is a pattern that is not random; a few are not the ensemble that they come from.
    if let SetDistribution::OneOf(sets) = sampler.distribution()
        && sets.len() > 1
    {
        check_sets(&pattern.label(), sets.len() as u64)?;
    }
    let group = pattern.stream_group(sampler.n_points());
    let streams = Streams::new(global.seed, Purpose::Pattern, group);
    Ok(Source::Sampler { name: pattern.to_string(), sampler, streams })
}

/// Rejects a file with too few sets.
fn check_sets(name: &str, count: u64) -> Result<(), CliError> {
    if count < MIN_REALIZATIONS {
        return Err(CliError::Failed(format!(
            "an audit needs at least {MIN_REALIZATIONS} sets, each a realization; {name} has {count}"
        )));
    }
    Ok(())
}

/// The settings that all audits of a run share.
struct Plan {
    domain: Domain,
    settings: AuditSettings,
    count: u64,
    resolution: Resolution,
}

impl Plan {
    fn check_memory(&self) -> Result<(), CliError> {
        check_transform(self.resolution, self.count)?;
        let components = ((self.resolution.lmax + 1) as f64).powi(2);
        // The coefficients twice, the sums of the copies, and the matrices of the rotation by 90
        // degrees.
        let numbers = 2.0 * components * self.count as f64
            + 4.0 * components * self.settings.replicates() as f64
            + components * self.resolution.lmax as f64;
        check_memory("an audit to degree --lmax of -m realizations", 8.0 * numbers)
    }

    fn audits(
        &self,
        source: &Source,
        given: Option<&[PointSet]>,
        unrotated: bool,
        session: &Session,
    ) -> Result<Vec<(Ensemble, HomogeneityAudit)>, CliError> {
        let rounds = match source {
            Source::Sampler { .. } if !unrotated => 2.0,
            _ => 1.0,
        };
        let (name, set_work) = match source {
            Source::Sampler { name, sampler, .. } if given.is_none() => {
                (&**name, sampler.nominal_work())
            }
            Source::Sampler { name, .. } => (&**name, 0.0),
            Source::Files(sets) => (sets.name(), 0.0),
        };
        let progress = Progress::new(rounds * self.work(set_work), session);
        let audit = |ensemble: Ensemble, sets: &dyn PointEnsemble, used: Option<&[DMat3]>| {
            progress.stage(&format!("{name} {}", ensemble.name()));
            self.audit(sets, used, &progress).map(|audit| (ensemble, audit))
        };
        match source {
            Source::Files(sets) => Ok(vec![audit(Ensemble::FromFiles, sets.sets(), None)?]),
            Source::Sampler { sampler, streams, .. } => {
                let drawn = Ensemble::AsDrawn { random: sampler.is_random() };
                let sets = Realizations::unrotated(&**sampler, *streams);
                let sets: &dyn PointEnsemble = match &given {
                    Some(given) => given,
                    None => &sets,
                };
                let mut audits = vec![audit(drawn, sets, None)?];
                if !unrotated {
                    let sets = Realizations::rotated(&**sampler, *streams);
                    let used: Vec<DMat3> = (0..self.count).map(|i| sets.rotation(i)).collect();
                    let given = given.map(|given| RotatedSets { sets: given, rotations: sets });
                    let sets: &dyn PointEnsemble = match &given {
                        Some(given) => given,
                        None => &sets,
                    };
                    audits.push(audit(Ensemble::Rotated, sets, Some(&used))?);
                }
                Ok(audits)
            }
        }
    }

    /// Runs one audit; `used` are the rotations applied to the sets, none if they are unknown.
    fn audit(
        &self,
        sets: &dyn PointEnsemble,
        used: Option<&[DMat3]>,
        progress: &Progress,
    ) -> Result<HomogeneityAudit, CliError> {
        let empty = HomogeneityAccumulator::new(self.domain, self.resolution.lmax)?;
        let coefficients = accumulate(sets, self.resolution, 0..self.count, &empty, progress)?;
        Ok(coefficients.audit(&self.settings, used, progress)?)
    }

    /// Returns the nominal work of an audit of sets that take `set_work` each.
    fn work(&self, set_work: f64) -> f64 {
        let Resolution { lmax, n_points, method, .. } = self.resolution;
        self.count as f64 * (set_work + method.nominal_work(n_points, lmax))
            + HomogeneityAccumulator::audit_work(&self.settings, self.count, lmax)
    }
}
