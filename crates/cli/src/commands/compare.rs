//! `sphvar compare`, the main command: which pattern integrates a function best, and why.

mod charts;
mod curve;
pub(crate) mod record;
mod result_folder;
mod text;

use std::path::{Path, PathBuf};

use clap::Args;
use sphvar_samplers::Square;

pub(super) use self::charts::variance_chart;
use self::charts::{integrand_chart, spectra_chart};
pub(super) use self::curve::Curve;
use self::record::{ComparisonBody, DegreeRecord, SamplerRecord};
use self::result_folder::{RECORD, ResultFolder};
use self::text::text;
use super::cases::{Case, DirectionCase};
use super::crossovers::crossovers;
use super::effort::EffortArgs;
use super::row_record::RowRecord;
use super::rows::{self, Row, ShownEnergy};
use super::square_rows;
use crate::error::CliError;
use crate::flags::{
    CountsArgs, IntegrandArgs, ProjectArgs, SamplersArgs, integrand_help_with_square,
};
use crate::global::Global;
use crate::integrands::{
    self, Integrals, parse_integrands, parse_square_integrand, with_integrals,
};
use crate::patterns::{parse_patterns, parse_samplers};
use crate::report::{Document, Provenance, csv_of, csv_of_present, is_stdout, write_text};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar compare
  sphvar compare jittered,fibonacci -n 100,1000 --integrand cap:degrees=60 -o cap
  sphvar compare --hemisphere --integrand cosine -o cosine
  sphvar compare jittered-square,sobol --square -n 16,64 --integrand disk:radius=0.3 -o disk
  sphvar compare fibonacci,sobol:warp=cosine --hemisphere -n 64,256 --integrand phong:n=5 -o density
  sphvar compare poisson-disk,jittered -n 1024 -m 20000 --shard 1/16 --save first.shard

Without arguments it compares the patterns of Singh's thesis on a photographed light probe, which is built in, within a minute \
on two cores. Every sampler takes its valid number of points nearest to N. The output folder receives \
comparison.csv and .json, spectra.csv, and the plots spectra, variance and integrand as .svg and .png. \
With env:FILE,channel=rgb or --project 2 (see variance) the table has rows for all channels or coefficients; rates, \
crossovers and plots are those of luminance, or of the irradiance. With --square it compares patterns of the unit square, by \
default on the indicator of a disk; spectra are radial means. Patterns with warp= (see variance), which sample a density, \
have no angular spectrum; they are not in the plot of spectra. Running the same command again replaces its own files; the results of another command are overwritten only \
with --force. Two runs cannot write to one folder at the same time.

--shard I/K --save FILE computes one of K parts of the work and leaves the folder alone; merge writes it.";

/// The patterns that the thesis compares.
const SAMPLERS: &str = "white-noise,jittered,poisson-disk,ccvt,healpix,fibonacci,step";
/// Valid point counts of HEALPix with which the comparison takes less than a minute on two cores.
const COUNTS: &str = "48,108,192,432,768,1728";

/// The defaults with `--square`.
const SQUARE_SAMPLERS: &str =
    "white-square,jittered-square,regular-square,latin-hypercube,fibonacci-lattice,sobol,pmj02";
const SQUARE_COUNTS: &str = "16,64,256,1024";
const SQUARE_INTEGRAND: &str = "disk:radius=0.3";

#[derive(Debug, Args)]
#[command(
    mut_arg("positional_samplers", |samplers| {
        samplers
            .help(SamplersArgs::help_with_warps())
            .default_value(SAMPLERS)
            .default_value_if("square", "true", SQUARE_SAMPLERS)
    }),
    mut_arg("counts", |counts| {
        counts.default_value(COUNTS).default_value_if("square", "true", SQUARE_COUNTS)
    }),
    mut_arg("integrand", |integrand| {
        integrand
            .help(integrand_help_with_square())
            .default_value(integrands::CITY)
            .default_value_if("square", "true", SQUARE_INTEGRAND)
    })
)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(crate) samplers: SamplersArgs,
    #[command(flatten)]
    pub(crate) counts: CountsArgs,
    #[command(flatten)]
    pub(crate) integrand: IntegrandArgs,
    #[command(flatten)]
    pub(crate) project: ProjectArgs,
    #[command(flatten)]
    pub(crate) effort: EffortArgs,
    /// Folder for tables and plots
    #[arg(short, long, default_value = "out", value_name = "FOLDER")]
    pub(crate) out: PathBuf,
    /// Overwrite the results of another run in the folder
    #[arg(long)]
    pub(crate) force: bool,
}

pub(crate) fn run(args: &CompareArgs, global: &Global) -> Result<(), CliError> {
    if is_stdout(&args.out) {
        return Err(CliError::Usage(
            "-o must name a folder, not - (the table goes to standard output, with --json as JSON)"
                .to_owned(),
        ));
    }
    if args.effort.square.square {
        return run_square(args, global);
    }
    let functions = parse_integrands(args.integrand.required()?, &global.session)?;
    with_integrals(&functions, args.project.project, |integrals| {
        run_integrals(args, global, integrals)
    })
}

fn run_integrals(
    args: &CompareArgs,
    global: &Global,
    integrals: &Integrals<'_>,
) -> Result<(), CliError> {
    let domain = args.effort.domain.domain();
    let samplers = parse_samplers(&args.samplers.required()?, &global.session)?;
    let cases = DirectionCase::all(&samplers, args.counts.list(), domain, true)?;
    let plan = args.effort.plan(integrals, global, true)?;
    rows::check(&plan, &cases)?;
    let output = Output::open(args, global)?;
    let Some((rows, energy)) = rows::run(&plan, &cases)? else {
        return global.session.tasks().without_results();
    };
    let subject = Subject { text: plan.subject(), integrand: &plan.integrand.name };
    output.write(&rows, &energy, &subject)
}

/// Compares patterns of the unit square.
fn run_square(args: &CompareArgs, global: &Global) -> Result<(), CliError> {
    let effort = square_rows::settings(&args.effort, args.project, &[], global, true)?;
    let integrand = parse_square_integrand(args.integrand.required()?, &global.session)?;
    let patterns = parse_patterns(&args.samplers.required()?, &global.session)?;
    let cases = Case::all(&patterns, args.counts.list(), Square, true)?;
    let output = Output::open(args, global)?;
    let Some((rows, energy)) = square_rows::run(&integrand, &effort, &cases)? else {
        return Ok(());
    };
    let subject = Subject { text: integrand.subject(), integrand: &integrand.name };
    output.write(&rows, &energy, &subject)
}

/// What is integrated, for titles.
struct Subject<'a> {
    text: String,
    integrand: &'a str,
}

/// The place of the results.
struct Output<'a> {
    args: &'a CompareArgs,
    global: &'a Global,
    provenance: Provenance,
    /// The folder; inside another program, and by a part of a run, results are not written.
    folder: Option<ResultFolder>,
}

impl<'a> Output<'a> {
    /// Reserves the folder before the work starts.
    fn open(args: &'a CompareArgs, global: &'a Global) -> Result<Self, CliError> {
        let provenance = Provenance::new(&global.session, global.seed);
        let folder = match global.session.is_embedded() || global.session.tasks().is_part() {
            true => None,
            false => Some(ResultFolder::open(&args.out, &provenance, args.force)?),
        };
        Ok(Self { args, global, provenance, folder })
    }

    /// Writes the results into the folder and prints the tables.
    fn write(
        self,
        rows: &[Row],
        energy: &ShownEnergy,
        subject: &Subject<'_>,
    ) -> Result<(), CliError> {
        let Self { args, global, provenance, folder } = self;
        let curves = Curve::all(rows);
        let samplers: Vec<SamplerRecord> = curves.iter().filter_map(Curve::summary).collect();
        let best: Vec<_> = curves.iter().map(|c| (c.sampler.clone(), c.best())).collect();
        let crossovers = crossovers(&best, global.seed);
        let records: Vec<RowRecord> = rows.iter().map(RowRecord::new).collect();
        let body = ComparisonBody { rows: records, samplers, crossovers };
        if let Some(folder) = folder {
            let written = Written { body: &body, rows, curves: &curves, energy, subject };
            folder.write(|folder| written.to(folder, &provenance))?;
        }
        if global.json {
            return Document::new(&body, &provenance).print(&global.session);
        }
        global.session.print(&text(&body, &subject.text))?;
        global.session.say(&format!("Tables and plots are in {}", args.out.display()));
        Ok(())
    }
}

/// The contents of the result folder.
struct Written<'a> {
    body: &'a ComparisonBody,
    rows: &'a [Row],
    curves: &'a [Curve<'a>],
    energy: &'a ShownEnergy,
    subject: &'a Subject<'a>,
}

impl Written<'_> {
    fn to(&self, folder: &Path, provenance: &Provenance) -> Result<(), CliError> {
        write_text(&folder.join("comparison.csv"), &csv_of_present(provenance, &self.body.rows)?)?;
        write_text(&folder.join("spectra.csv"), &csv_of(provenance, &degrees(self.rows))?)?;
        let mut charts = vec![
            ("variance", variance_chart(self.curves, &self.subject.text)),
            ("integrand", integrand_chart(self.energy, self.subject.integrand)),
        ];
        if self.rows.iter().any(|row| !row.is_warped()) {
            charts.push(("spectra", spectra_chart(self.curves, self.energy.texts)));
        } else {
            // Those of an earlier run would not belong to this record.
            result_folder::remove(folder, &["spectra.svg", "spectra.png"]);
        }
        for (name, chart) in charts {
            let chart = chart.with_note(provenance.line());
            chart.render(&folder.join(format!("{name}.svg")))?;
            chart.render(&folder.join(format!("{name}.png")))?;
        }
        let document = Document::new(self.body, provenance);
        let json = serde_json::to_string_pretty(&document).map_err(CliError::failed)?;
        write_text(&folder.join(RECORD), &(json + "\n"))
    }
}

/// Returns the power by degree, or by radius, of all spectra.
fn degrees(rows: &[Row]) -> Vec<DegreeRecord> {
    let degrees = |row: &Row| {
        let (sampler, n) = (row.sampler.text.clone(), row.comparison.n_points);
        let record = move |&(l, power, stderr): &(usize, f64, f64)| {
            let omega = l as f64 / (n as f64).sqrt();
            DegreeRecord { sampler: sampler.clone(), n, l, omega, power, stderr }
        };
        row.power.iter().map(record).collect::<Vec<_>>()
    };
    // Other integrals of the same sets have the same spectra.
    rows.iter().filter(|row| row.is_main).flat_map(degrees).collect()
}
