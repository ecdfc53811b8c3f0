//! `sphvar variance`: predicted and measured variance of patterns on one integrand.

use std::path::PathBuf;

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::Pattern;

use super::compare::{Curve, variance_chart};
use super::cut_sphere::{self, Cut, CutRecord};
use super::row_record::RowRecord;
use super::rows::{self, Case, EffortArgs};
use crate::counts::Counts;
use crate::error::CliError;
use crate::global::Global;
use crate::integrands::{FORMS, parse_integrand};
use crate::patterns::parse_patterns;
use crate::report::{Forms, Provenance, check_result, csv_of, emit, is_stdout, table_of};
use crate::spec::argument;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar variance jittered,white-noise -n 192,768 --integrand cap:degrees=60 -m 2000
  sphvar variance jittered -n 192 --integrand cap:degrees=60 -m 100 --until-rel 10%
  sphvar variance jittered,fibonacci -n 48..768 --nearest --integrand cap:degrees=60 -o v.svg

Columns: the variance that the spectra predict and the one measured on independent, uniformly \
rotated realizations, each with its standard error (that of the prediction with the error of the \
degrees beyond the spectrum); ratio is measured/predicted, z their difference in standard errors, \
bias z that of the mean estimate and the exact integral. 95 % intervals are in files and --json. \
Where too few trials see the integrand there is no error, ratio or z of the measured variance, and where \
all trials agree an upper limit only.";

#[derive(Debug, Args)]
pub(crate) struct VarianceArgs {
    /// Samplers, separated by commas, or all
    pub(crate) samplers: String,
    /// Numbers of points: 192,768 or 16..1024 for doubling
    #[arg(short = 'n', long = "points", required = true, value_name = "N")]
    pub(crate) points: Counts,
    #[arg(long, allow_hyphen_values = true, value_parser = argument(), help = format!("Integrand: {FORMS}"))]
    pub(crate) integrand: String,
    #[command(flatten)]
    pub(crate) effort: EffortArgs,
    /// Take the nearest number of points that a pattern has
    #[arg(long)]
    pub(crate) nearest: bool,
    /// Cut sphere sets of twice the points in half as well, with both estimators that are in use
    #[arg(long, value_name = "AXIS", num_args = 0..=1, require_equals = true,
        default_missing_value = "random", requires = "hemisphere")]
    pub(crate) cut_sphere: Option<Cut>,
    /// Write the rows to a file, .csv or .json, or a plot of the variances against N as .svg or .png
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// Predicted and measured variances: `variance --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct VarianceBody {
    /// Every sampler at every number of points.
    rows: Vec<RowRecord>,
    /// Sphere sets cut in half, with `--cut-sphere` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    cut_sphere: Option<Vec<CutRecord>>,
}

pub(crate) fn run(args: &VarianceArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out {
        check_result(path, true)?;
        let is_json = path.extension().is_some_and(|e| e == "json");
        if args.cut_sphere.is_some() && !is_json && !(global.json && is_stdout(path)) {
            let message =
                "--cut-sphere has rows of two kinds: write them with --json or to a .json file";
            return Err(CliError::Usage(message.to_owned()));
        }
    }
    let integrand = parse_integrand(&args.integrand, global.quiet)?;
    let domain = super::domain(args.effort.hemisphere);
    let mut cases = Vec::new();
    for pattern in parse_patterns(&args.samplers)? {
        for &n in args.points.all() {
            cases.push(Case::new(pattern.clone(), n, domain, args.nearest)?);
        }
    }
    let plan = args.effort.plan(&integrand, global, false)?;
    let (rows, _) = rows::run(&plan, &cases)?;
    let records: Vec<RowRecord> = rows.iter().map(|row| RowRecord::new(row, &plan)).collect();
    let provenance = Provenance::new(global.seed);
    let cut = match args.cut_sphere {
        Some(cut) => Some(cut_sphere::run(&plan, cut, &cases, &rows)?),
        None => None,
    };
    let body = VarianceBody { rows: records, cut_sphere: cut };
    let chart = || {
        let mut patterns: Vec<&Pattern> = Vec::new();
        for row in &rows {
            if !patterns.contains(&&row.pattern) {
                patterns.push(&row.pattern);
            }
        }
        let curves: Vec<_> = patterns.iter().map(|p| Curve::new(p, &rows)).collect();
        Ok(variance_chart(&curves, &plan))
    };
    let forms = Forms {
        csv: &|| csv_of(&provenance, &body.rows),
        chart: Some(&chart),
        text: &|| text(&body),
    };
    emit(args.out.as_deref(), global, &provenance, &body, &forms)
}

fn text(body: &VarianceBody) -> String {
    let mut text = table_of(&RowRecord::columns(), &body.rows);
    text += &RowRecord::remarks(&body.rows);
    if let Some(cut) = &body.cut_sphere {
        text.push('\n');
        text += &table_of(&CutRecord::columns(), cut);
    }
    text
}
