//! `sphvar audit`: whether the variance formula may be used for an ensemble.

use std::path::PathBuf;

use clap::Args;
use glam::DMat3;
use serde::Serialize;
use sphvar_samplers::{Domain, Purpose, Realizations, Sampler, Streams, uniform_rotation};
use sphvar_spectrum::{
    AuditFamily, AuditSettings, AuditVerdict, Finding, HomogeneityAccumulator, HomogeneityAudit,
    PointSets, Resolution, TurnedSets, accumulate,
};

use crate::error::CliError;
use crate::global::Global;
use crate::memory::{check_degree, check_memory, check_transform};
use crate::patterns;
use crate::point_sets::FileSets;
use crate::progress::Progress;
use crate::report::{
    Provenance, check_result, csv, full, is_stdout, print, print_json, say, short, table,
    write_result,
};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar audit jittered -n 768 -m 2000
  sphvar audit --points sets.npy --lmax 6

The variance formula holds for ensembles whose law no rotation changes. Tested on the coefficients of
degrees 1 to --lmax (on the hemisphere the even ones):
  means        E S_lm = 0: no bias (value: the mean in units of sqrt(P(l)))
  phases       arg S_lm and its double uniform for m >= 1; S_l0 is real (mean resultant length)
  orders       the same power for all orders of a degree (P(l,m)/P(l))
  covariances  different coefficients uncorrelated, degrees up to 4 (correlation)
  rotations    the mean of the rotations that were used is 0 (entry of the mean)
Degrees without power, such as odd ones of antipodal sets, are left out. Each p-value comes from
copies of the ensemble in which every set is turned anew by a uniform rotation; all tests together
object to a homogeneous ensemble with probability --alpha at most. A sampler is audited as it draws
and as turned by uniform rotations. The exit status is 0 whatever the verdict.";

/// Fewer realizations say too little to be judged.
const LEAST: u64 = 30;

#[derive(Debug, Args)]
pub(crate) struct AuditArgs {
    /// The sampler
    #[arg(required_unless_present = "points_from", conflicts_with = "points_from")]
    pub(crate) sampler: Option<String>,
    /// Read points from these files (.csv, .npy, .ply; - is standard input); each set in them is a
    /// realization, at least 30 are needed
    #[arg(long = "points", num_args = 1.., value_name = "FILE", id = "points_from")]
    pub(crate) files: Vec<PathBuf>,
    /// Number of points
    #[arg(
        short = 'n',
        long = "n-points",
        value_name = "N",
        required_unless_present = "points_from"
    )]
    pub(crate) n: Option<usize>,
    /// Number of realizations, at least 30
    #[arg(short = 'm', long, default_value_t = 2000, value_name = "M")]
    pub(crate) realizations: u64,
    /// Largest degree that is looked at, inclusive
    #[arg(long, default_value_t = 8)]
    pub(crate) lmax: usize,
    /// Probability that a homogeneous ensemble is objected to, [1e-4, 0.5]
    #[arg(long, default_value_t = 0.01)]
    pub(crate) alpha: f64,
    /// Relative error of a variance that must be within sight for the answer yes
    #[arg(long, default_value_t = 0.2)]
    pub(crate) tolerance: f64,
    /// Audit the sampler only as it draws, not as turned by uniform rotations
    #[arg(long, conflicts_with = "points_from")]
    pub(crate) unrotated: bool,
    /// Points on the hemisphere z >= 0; only even degrees exist
    #[arg(long)]
    pub(crate) hemisphere: bool,
    /// Take the nearest number of points that the pattern has
    #[arg(long)]
    pub(crate) nearest: bool,
    /// Names of the columns in point files without a header, or to choose among those of a header
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub(crate) columns: Option<Vec<String>>,
    /// Write the findings to a file, .csv or .json
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// The document of `--json`.
#[derive(Debug, Serialize)]
struct Document<'a> {
    sampler: &'a str,
    domain: &'static str,
    n: usize,
    realizations: u64,
    lmax: usize,
    alpha: f64,
    tolerance: f64,
    copies: u64,
    audits: Vec<AuditRecord>,
    provenance: &'a Provenance,
}

/// One audit as scripts see it.
#[derive(Debug, Serialize)]
struct AuditRecord {
    ensemble: &'static str,
    verdict: &'static str,
    conclusion: String,
    /// Infinite where nothing can be seen, which is null in JSON.
    detectable: f64,
    vanishing: Vec<usize>,
    tests: Vec<TestRecord>,
    ratios: Vec<RatioRecord>,
    bias: Option<BiasRecord>,
}

#[derive(Debug, Serialize)]
struct TestRecord {
    test: &'static str,
    compared: usize,
    statistic: f64,
    p_value: f64,
    adjusted: f64,
    rejected: bool,
    worst: String,
    value: f64,
}

#[derive(Debug, Serialize)]
struct RatioRecord {
    l: usize,
    m: usize,
    ratio: f64,
    stderr: f64,
    low: f64,
    high: f64,
}

#[derive(Debug, Serialize)]
struct BiasRecord {
    l: usize,
    m: usize,
    share: f64,
}

/// What is known of the rotations of an ensemble.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ensemble {
    AsDrawn { random: bool },
    Rotated,
    FromFiles,
}

impl Ensemble {
    fn name(self) -> &'static str {
        match self {
            Self::AsDrawn { .. } => "as drawn",
            Self::Rotated => "rotated",
            Self::FromFiles => "from files",
        }
    }
}

/// Where the point sets come from.
enum Source {
    Sampler { name: String, sampler: Box<dyn Sampler>, streams: Streams },
    Files(FileSets),
}

pub(crate) fn run(args: &AuditArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out {
        check_result(path, false)?;
    }
    let domain = super::domain(args.hemisphere);
    let settings =
        AuditSettings { alpha: args.alpha, tolerance: args.tolerance, seed: global.seed };
    check_settings(args, domain)?;
    let source = source(args, domain, global)?;
    let (name, n_points, count) = match &source {
        Source::Sampler { name, sampler, .. } => (&**name, sampler.n_points(), args.realizations),
        Source::Files(sets) => (sets.name(), sets.mean_size(), sets.count()),
    };
    let plan = Plan { domain, settings, count, resolution: Resolution::new(args.lmax, n_points) };
    plan.check_memory()?;
    let audits = plan.audits(&source, name, args.unrotated, global.quiet)?;

    let provenance = Provenance::new(global.seed);
    let records = audits.iter().map(|(ensemble, audit)| record(*ensemble, audit, &settings));
    let document = Document {
        sampler: name,
        domain: domain.name(),
        n: n_points,
        realizations: count,
        lmax: args.lmax,
        alpha: args.alpha,
        tolerance: args.tolerance,
        copies: settings.replicates(),
        audits: records.collect(),
        provenance: &provenance,
    };
    emit(args, global, &document)
}

/// Refuses what the library would refuse after the work.
fn check_settings(args: &AuditArgs, domain: Domain) -> Result<(), CliError> {
    check_degree("--lmax", args.lmax)?;
    let least = domain.degree_step();
    if args.lmax < least {
        return Err(CliError::Usage(format!(
            "--lmax must be at least {least} on the {domain}, got {}",
            args.lmax
        )));
    }
    if !(1e-4..=0.5).contains(&args.alpha) {
        let got = args.alpha;
        return Err(CliError::Usage(format!("--alpha must be in [1e-4, 0.5], got {got}")));
    }
    if !(args.tolerance > 0.0 && args.tolerance.is_finite()) {
        let got = args.tolerance;
        return Err(CliError::Usage(format!("--tolerance must be above 0 and finite, got {got}")));
    }
    if args.files.is_empty() && args.realizations < LEAST {
        return Err(CliError::Usage(format!(
            "-m must be at least {LEAST} for an audit, got {}",
            args.realizations
        )));
    }
    Ok(())
}

fn source(args: &AuditArgs, domain: Domain, global: &Global) -> Result<Source, CliError> {
    let (Some(name), Some(n)) = (&args.sampler, args.n) else {
        let sets = FileSets::read(&args.files, args.columns.as_deref(), domain, global.quiet)?;
        if sets.count() < LEAST {
            return Err(CliError::Failed(format!(
                "an audit needs at least {LEAST} sets, each a realization; {} has {}",
                sets.name(),
                sets.count()
            )));
        }
        return Ok(Source::Files(sets));
    };
    let pattern = patterns::parse_pattern(name)?;
    let sampler = patterns::build(&pattern, n, domain, args.nearest)?;
    if sampler.n_points() != n {
        let got = sampler.n_points();
        say(global.quiet, &format!("{pattern}: {got} points, the nearest to the {n} asked for"));
    }
    let group = pattern.stream_group(sampler.n_points());
    let streams = Streams::new(global.seed, Purpose::Pattern, group);
    Ok(Source::Sampler { name: pattern.to_string(), sampler, streams })
}

/// What every audit of a run has in common.
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
        // The coefficients twice, the sums of the copies, and the matrices of the quarter turn.
        let numbers = 2.0 * components * self.count as f64
            + 4.0 * components * self.settings.replicates() as f64
            + components * self.resolution.lmax as f64;
        check_memory("an audit to degree --lmax of -m realizations", 8.0 * numbers)
    }

    fn audits(
        &self,
        source: &Source,
        name: &str,
        unrotated: bool,
        quiet: bool,
    ) -> Result<Vec<(Ensemble, HomogeneityAudit)>, CliError> {
        let rounds = match source {
            Source::Sampler { .. } if !unrotated => 2.0,
            _ => 1.0,
        };
        let progress = Progress::new(rounds * self.seconds(), quiet);
        let audit = |ensemble: Ensemble, sets: &dyn PointSets, used: &dyn Fn() -> Vec<DMat3>| {
            progress.stage(&format!("{name} {}", ensemble.name()));
            self.audit(sets, used, &progress).map(|audit| (ensemble, audit))
        };
        match source {
            Source::Files(sets) => Ok(vec![audit(Ensemble::FromFiles, sets, &Vec::new)?]),
            Source::Sampler { sampler, streams, .. } => {
                let drawn = Ensemble::AsDrawn { random: sampler.is_random() };
                let sets = Realizations::unrotated(&**sampler, *streams);
                let mut audits = vec![audit(drawn, &sets, &Vec::new)?];
                if !unrotated {
                    let count = usize::try_from(self.count).map_err(CliError::failed)?;
                    let sets = TurnedSets::new(&**sampler, *streams, count, uniform_rotation);
                    audits.push(audit(Ensemble::Rotated, &sets, &|| sets.rotations())?);
                }
                Ok(audits)
            }
        }
    }

    /// One audit; `used` are the rotations that turned the sets, none if they are not known.
    fn audit(
        &self,
        sets: &dyn PointSets,
        used: &dyn Fn() -> Vec<DMat3>,
        progress: &Progress,
    ) -> Result<HomogeneityAudit, CliError> {
        let empty = HomogeneityAccumulator::new(self.domain, self.resolution.lmax)?;
        let done = || progress.advance(self.seconds_of_set());
        let coefficients = accumulate(sets, self.resolution, 0..self.count, &empty, &done)?;
        let done = || progress.advance(self.seconds_of_copy());
        let used = used();
        let rotations = (!used.is_empty()).then_some(&*used);
        Ok(coefficients.audit(&self.settings, rotations, &done)?)
    }

    fn seconds(&self) -> f64 {
        self.count as f64 * self.seconds_of_set()
            + self.settings.replicates() as f64 * self.seconds_of_copy()
    }

    /// About what drawing and transforming a set takes: 50 ns a point and 1 ns a coefficient of it.
    fn seconds_of_set(&self) -> f64 {
        let coefficients = ((self.resolution.lmax + 1) as f64).powi(2);
        self.resolution.n_points as f64 * (5e-8 + 1e-9 * coefficients)
    }

    /// About what a turned copy takes: 2 microseconds and 5 ns lmax^3/8 for each realization.
    fn seconds_of_copy(&self) -> f64 {
        self.count as f64 * (2e-6 + 6e-10 * (self.resolution.lmax as f64).powi(3))
    }
}

fn record(ensemble: Ensemble, audit: &HomogeneityAudit, settings: &AuditSettings) -> AuditRecord {
    let test = |f: &Finding| TestRecord {
        test: f.family.name(),
        compared: f.comparisons,
        statistic: f.statistic,
        p_value: f.p_value,
        adjusted: f.adjusted,
        rejected: f.rejected,
        worst: f.worst.clone(),
        value: f.value,
    };
    let ratios = audit.ratios.iter().map(|r| RatioRecord {
        l: r.l,
        m: r.m,
        ratio: r.ratio,
        stderr: r.stderr,
        low: r.low,
        high: r.high,
    });
    AuditRecord {
        ensemble: ensemble.name(),
        verdict: match audit.verdict {
            AuditVerdict::Homogeneous => "yes",
            AuditVerdict::Inhomogeneous => "no",
            AuditVerdict::Undecided => "undecided",
        },
        conclusion: conclusion(ensemble, audit, settings),
        detectable: audit.detectable,
        vanishing: audit.vanishing.clone(),
        tests: audit.findings.iter().map(test).collect(),
        ratios: ratios.collect(),
        bias: audit.bias.map(|b| BiasRecord { l: b.l, m: b.m, share: b.share }),
    }
}

/// What the findings mean, in a sentence or three.
fn conclusion(ensemble: Ensemble, audit: &HomogeneityAudit, settings: &AuditSettings) -> String {
    let seen = format!(
        "an error of {} of the variance of any Y_lm, l <= {}, would have been seen in 9 of 10 audits",
        percent(audit.detectable),
        audit.lmax
    );
    match audit.verdict {
        AuditVerdict::Homogeneous => format!("The variance formula may be used: {seen}."),
        AuditVerdict::Undecided if audit.ratios.is_empty() => {
            "Not enough to tell: no degree that was looked at has any power.".to_owned()
        }
        AuditVerdict::Undecided => {
            let factor = (audit.detectable / settings.tolerance).powi(2);
            let needed = (factor * audit.realizations as f64 / 100.0).ceil() * 100.0;
            format!(
                "Not enough realizations to tell: only {seen}; for {} take about {needed} of them.",
                percent(settings.tolerance)
            )
        }
        AuditVerdict::Inhomogeneous => objection(ensemble, audit),
    }
}

fn objection(ensemble: Ensemble, audit: &HomogeneityAudit) -> String {
    let rejected = |family| audit.finding(family).is_some_and(|f| f.rejected);
    let mut text = match ensemble {
        Ensemble::AsDrawn { random: false } => {
            "The variance formula may not be used: this is one fixed set, so the error is no chance \
             at all; turn every realization by a uniform rotation."
        }
        Ensemble::AsDrawn { random: true } => {
            "The variance formula may not be used: turn every realization by a uniform rotation."
        }
        Ensemble::Rotated => "The variance formula may not be used: the rotations are not uniform.",
        Ensemble::FromFiles => {
            "The variance formula may not be used, unless these sets are turned by uniform rotations."
        }
    }
    .to_owned();
    if let Some(w) = audit.worst_ratio() {
        let (l, m) = (w.l, w.m);
        text += &format!(
            " Worst factor of the mean squared error: {:.3} for Y_{l},{m} ({:.3} to {:.3}, all orders \
             together at 1 - alpha).",
            w.ratio, w.low, w.high
        );
    }
    if rejected(AuditFamily::Means)
        && let Some(b) = audit.bias
    {
        let (l, m) = (b.l, b.m);
        text += &format!(" Bias: {} of the formula's variance for Y_{l},{m}.", percent(b.share));
    }
    if rejected(AuditFamily::Covariances) {
        text += " Integrands of several coefficients have cross terms besides.";
    }
    text
}

/// A share in percent, to two digits.
fn percent(x: f64) -> String {
    let percent = 100.0 * x;
    if percent >= 10.0 { format!("{percent:.0} %") } else { format!("{percent:.1} %") }
}

fn emit(args: &AuditArgs, global: &Global, document: &Document<'_>) -> Result<(), CliError> {
    if let Some(path) = &args.out
        && !(global.json && is_stdout(path))
    {
        let rows = document.audits.iter().flat_map(|audit| {
            audit.tests.iter().map(|t| {
                vec![
                    audit.ensemble.to_owned(),
                    t.test.to_owned(),
                    t.compared.to_string(),
                    full(t.statistic),
                    full(t.p_value),
                    full(t.adjusted),
                    t.rejected.to_string(),
                    t.worst.clone(),
                    full(t.value),
                    audit.verdict.to_owned(),
                ]
            })
        });
        let rows: Vec<_> = rows.collect();
        write_result(path, document, &|| csv(document.provenance, COLUMNS, &rows))?;
    }
    if global.json {
        return print_json(document);
    }
    if args.out.as_ref().is_some_and(|path| is_stdout(path)) {
        return Ok(());
    }
    let parts: Vec<String> = document.audits.iter().map(|audit| text(document, audit)).collect();
    print(&parts.join("\n"))
}

const COLUMNS: &str =
    "ensemble,test,compared,statistic,p_value,adjusted,rejected,worst,value,verdict";

/// The report on one ensemble for people.
fn text(document: &Document<'_>, audit: &AuditRecord) -> String {
    let Document { sampler, n, realizations, lmax, copies, .. } = document;
    let mut text = format!(
        "{sampler}, N = {n}, {}: {realizations} realizations, degrees to {lmax}, {copies} turned copies\n",
        audit.ensemble
    );
    let cells = audit.tests.iter().map(|t| {
        let verdict = match (t.compared, t.rejected) {
            (0, _) => "nothing to test",
            (_, true) => "objects",
            (_, false) => "no objection",
        };
        vec![
            t.test.to_owned(),
            t.compared.to_string(),
            if t.compared > 0 { format!("{:.2}", t.statistic) } else { "-".to_owned() },
            short(t.p_value),
            t.worst.clone(),
            if t.value.is_finite() { format!("{:.4}", t.value) } else { "-".to_owned() },
            verdict.to_owned(),
        ]
    });
    let heading = ["test", "compared", "largest score", "p", "where", "value", "verdict"];
    text += &table(&heading, cells.collect(), 1);
    if !audit.tests.iter().any(|t| t.test == AuditFamily::Rotations.name()) {
        text += match audit.ensemble {
            "from files" => "rotations: not known of points from files\n",
            _ => "rotations: none were used\n",
        };
    }
    if !audit.vanishing.is_empty() {
        let degrees: Vec<String> = audit.vanishing.iter().map(ToString::to_string).collect();
        text += &format!("left out, without power: l = {}\n", degrees.join(", "));
    }
    text + &audit.conclusion + "\n"
}
