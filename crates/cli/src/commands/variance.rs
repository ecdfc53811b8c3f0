//! `sphvar variance`: predicted and measured variance of patterns on one integrand.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::rows::{self, Case, EffortArgs, RowRecord};
use crate::error::CliError;
use crate::global::Global;
use crate::integrands::{FORMS, parse_integrand};
use crate::patterns::parse_patterns;
use crate::report::{
    Provenance, check_result, csv, is_stdout, print, print_json, table, write_result,
};

pub(crate) const EXAMPLES: &str = "Example:
  sphvar variance jittered,white-noise -n 192,768 --integrand cap:degrees=60 -m 2000

Columns: the variance that the spectra predict and the one measured on independent, uniformly
rotated realizations, each with its standard error; z is their difference in standard errors.";

#[derive(Debug, Args)]
pub(crate) struct VarianceArgs {
    /// Samplers, separated by commas
    pub(crate) samplers: String,
    /// Numbers of points, separated by commas
    #[arg(short = 'n', long = "points", value_delimiter = ',', required = true, value_name = "N")]
    pub(crate) points: Vec<usize>,
    #[arg(long, help = format!("Integrand: {FORMS}"))]
    pub(crate) integrand: String,
    #[command(flatten)]
    pub(crate) effort: EffortArgs,
    /// Take the nearest number of points that a pattern has
    #[arg(long)]
    pub(crate) nearest: bool,
    /// Write the rows to a file, .csv or .json
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// The document of `--json`.
#[derive(Debug, Serialize)]
struct Document<'a> {
    rows: &'a [RowRecord],
    provenance: &'a Provenance,
}

pub(crate) fn run(args: &VarianceArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out {
        check_result(path, false)?;
    }
    let integrand = parse_integrand(&args.integrand)?;
    let domain = super::domain(args.effort.hemisphere);
    let mut cases = Vec::new();
    for pattern in parse_patterns(&args.samplers)? {
        for &n in &args.points {
            cases.push(Case::new(pattern.clone(), n, domain, args.nearest)?);
        }
    }
    let plan = args.effort.plan(&integrand, global, false)?;
    let (rows, _) = rows::run(&plan, &cases)?;
    let records: Vec<RowRecord> = rows.iter().map(|row| RowRecord::new(row, &plan)).collect();
    let provenance = Provenance::new(global.seed);
    let document = Document { rows: &records, provenance: &provenance };
    if let Some(path) = &args.out
        && !(global.json && is_stdout(path))
    {
        let cells: Vec<_> = records.iter().map(RowRecord::record).collect();
        write_result(path, &document, &|| csv(&provenance, RowRecord::COLUMNS, &cells))?;
    }
    if global.json {
        print_json(&document)
    } else if args.out.as_ref().is_some_and(|path| is_stdout(path)) {
        Ok(())
    } else {
        let cells = records.iter().map(RowRecord::cells).collect();
        print(&table(&RowRecord::HEADING, cells, 1))
    }
}
