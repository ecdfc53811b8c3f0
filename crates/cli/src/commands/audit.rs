//! `sphvar audit`: whether an ensemble is rotation-invariant, as the variance formula assumes.

mod chart;
pub(crate) mod report;

use std::path::PathBuf;

use clap::Args;
use glam::DMat3;
use sphvar_samplers::{
    Domain, Pattern, PointSet, Progress as _, Purpose, Realizations, Sampler, SetDistribution,
    Streams,
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
use crate::shards::{Divided, ShardArgs, Tasks};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar audit jittered -n 768 -m 2000
  sphvar audit --points sets.npy --lmax 6
  sphvar audit poisson-disk -n 768 -m 2000 --shard 3/16 --save third.shard

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
and after uniform random rotations. The exit status is 0 whatever the outcome.

--shard divides the coefficients of the realizations; sphvar merge makes the copies, which takes about 3 ms of one \
core for each realization of each audit at the default --lmax and --alpha.";

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
    #[command(flatten)]
    pub(crate) sharding: ShardArgs,
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
    let session = &global.session;
    plan.check_memory(session.tasks())?;
    let audits = plan.audits(&source, given, args.unrotated, session)?;
    if session.tasks().is_part() {
        return Ok(());
    }
    if audits.is_empty() {
        return Err(CliError::File(format!("the given parts have no realizations of {name}")));
    }
    let weights = match &source {
        Source::Sampler { sampler, .. } => WeightSums::of_sampler(&**sampler)?,
        Source::Files(sets) => WeightSums::of_sets(sets.sets().sets()),
    };

    let provenance = Provenance::new(session, global.seed);
    let records =
        audits.iter().map(|(ensemble, audit)| AuditRecord::new(*ensemble, audit, &settings));
    let body = AuditBody {
        sampler: name.to_owned(),
        domain: domain.name(),
        n: n_points,
        n_effective: weights.map(|weights| weights.n_effective),
        realizations: audits.iter().map(|(_, a)| a.realizations as u64).min().unwrap_or(0),
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
    fn check_memory(&self, tasks: &Tasks) -> Result<(), CliError> {
        let parts = tasks.part().parts;
        let count = self.count.div_ceil(parts);
        check_transform(self.resolution, count)?;
        let components = ((self.resolution.lmax + 1) as f64).powi(2);
        // The coefficients twice and, unless this is a part, the sums of the copies and the matrices
        // of the rotation by 90 degrees.
        let of_copies = 4.0 * components * self.settings.replicates() as f64
            + components * self.resolution.lmax as f64;
        let numbers = 2.0 * components * count as f64 + if parts == 1 { of_copies } else { 0.0 };
        check_memory("an audit to degree --lmax of -m realizations", 8.0 * numbers)
    }

    /// Returns the audits whose results are known: all unless this run keeps only a part or a merge
    /// is partial.
    fn audits(
        &self,
        source: &Source,
        given: Option<&[PointSet]>,
        unrotated: bool,
        session: &Session,
    ) -> Result<Vec<(Ensemble, HomogeneityAudit)>, CliError> {
        let tasks = session.tasks();
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
        let Resolution { lmax, n_points, method, .. } = self.resolution;
        let work = set_work + method.nominal_work(n_points, lmax);
        let progress = Progress::new(rounds * self.count as f64 * work, session);
        if !tasks.is_part() {
            let each = HomogeneityAccumulator::audit_work(&self.settings, self.count, lmax);
            progress.expect(rounds * each);
        }
        let run = Run { plan: self, name, work, tasks, progress: &progress };
        let mut audits = Vec::new();
        match source {
            Source::Files(sets) => {
                audits.extend(run.audit(Ensemble::FromFiles, sets.sets(), None)?);
            }
            Source::Sampler { sampler, streams, .. } => {
                let drawn = Ensemble::AsDrawn { random: sampler.is_random() };
                let sets = Realizations::unrotated(&**sampler, *streams);
                let sets: &dyn PointEnsemble = match &given {
                    Some(given) => given,
                    None => &sets,
                };
                audits.extend(run.audit(drawn, sets, None)?);
                if !unrotated {
                    let sets = Realizations::rotated(&**sampler, *streams);
                    let rotation = |i: u64| sets.rotation(i);
                    let given = given.map(|given| RotatedSets { sets: given, rotations: sets });
                    let ensemble: &dyn PointEnsemble = match &given {
                        Some(given) => given,
                        None => &sets,
                    };
                    audits.extend(run.audit(Ensemble::Rotated, ensemble, Some(&rotation))?);
                }
            }
        }
        Ok(audits)
    }
}

/// What the audits of a run share.
struct Run<'a> {
    plan: &'a Plan,
    name: &'a str,
    /// The nominal work of the coefficients of a realization.
    work: f64,
    tasks: &'a Tasks,
    progress: &'a Progress,
}

impl Run<'_> {
    /// Runs one audit; `rotation` returns the rotation applied to a set, if it is known. `None` if
    /// the run keeps only a part, or if a partial merge has no realization of it.
    fn audit(
        &self,
        ensemble: Ensemble,
        sets: &dyn PointEnsemble,
        rotation: Option<&dyn Fn(u64) -> DMat3>,
    ) -> Result<Option<(Ensemble, HomogeneityAudit)>, CliError> {
        let Plan { domain, settings, count, resolution } = *self.plan;
        let progress = self.progress;
        let name = format!("{} {}", self.name, ensemble.name());
        progress.stage(&name);
        let empty = HomogeneityAccumulator::new(domain, resolution.lmax)?;
        let append = |all: &mut HomogeneityAccumulator, others: HomogeneityAccumulator| {
            all.try_merge(&others).map_err(|error| CliError::File(error.to_string()))
        };
        let task = Divided { name: &name, count, work: self.work };
        let coefficients = self.tasks.divided(task, progress, append, |range| {
            Ok(accumulate(sets, resolution, range, &empty, progress)?)
        })?;
        let Some(coefficients) = coefficients else { return Ok(None) };
        let indices = coefficients.indices();
        check_sets(&name, indices.len() as u64)?;
        let used: Option<Vec<DMat3>> =
            rotation.map(|rotation| indices.into_iter().map(rotation).collect());
        let audit = coefficients.audit(&settings, used.as_deref(), progress)?;
        Ok(Some((ensemble, audit)))
    }
}
