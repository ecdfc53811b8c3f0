//! `sphvar reproduce`: the figures of the thesis, with a page that shows them all.

mod data;
mod drawing;
mod folder;
mod markdown;
mod numbers;
mod page;
mod pieces;
mod record;
mod summary;
mod tables;

use std::collections::{BTreeMap, HashSet};
use std::path::PathBuf;

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_thesis::{Figure, FigureId, Job, Results, Scale, Setting, Verdict, work};

use self::folder::{OutFolder, TABLES};
use self::markdown::markdown;
use self::pieces::Pieces;
use self::record::{VerdictRecord, records};
use self::summary::Summary;
use self::tables::{CSV_HEADING, csv_rows, plain_table};
use crate::error::CliError;
use crate::global::Global;
use crate::progress::Progress;
use crate::report::{Document, Provenance, csv};
use crate::shards::ShardArgs;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar reproduce all --quick -o out
  sphvar reproduce 4.14 7.4 --full -o out
  sphvar reproduce all --quick -o out --shard 3/16 --save third.shard

The folder receives index.html, one page with the summary, the errata, and every figure with its stated and measured \
numbers; claims.csv and claims.md, the table alone; figures/, every panel as SVG or PNG with its numbers as CSV; and \
pieces/, finished parts of the work. An interrupted run resumes where it stopped when started again, with the same \
result. Full figures reuse the parts of quick ones, and figures share their ensembles. A run with --shard I/K computes \
every K-th piece and leaves the folder alone; with --save, pieces of earlier runs in the folder are not used.";

#[derive(Debug, Args)]
pub(crate) struct ReproduceArgs {
    /// Figures of the thesis: 3.1 4.9 ... C.1, or all
    #[arg(value_name = "FIGURE", default_value = "all")]
    figures: Vec<String>,
    /// Folder for the results, which is created if it is missing
    #[arg(short, long, value_name = "FOLDER")]
    out: PathBuf,
    /// Use fewer points and realizations: all figures within ten minutes on two cores (the default)
    #[arg(long)]
    quick: bool,
    /// Use the numbers of points and realizations of the thesis
    #[arg(long, conflicts_with = "quick")]
    full: bool,
    #[command(flatten)]
    pub(crate) sharding: ShardArgs,
}

impl ReproduceArgs {
    /// Returns the figures, each once, in the order of the thesis.
    fn ids(&self) -> Result<Vec<FigureId>, CliError> {
        let mut ids = Vec::new();
        for name in &self.figures {
            if name == "all" {
                ids.extend(FigureId::all());
            } else {
                ids.push(name.parse().map_err(CliError::usage)?);
            }
        }
        ids.sort_unstable();
        ids.dedup();
        Ok(ids)
    }

    fn scale(&self) -> Scale {
        if self.full { Scale::Full } else { Scale::Quick }
    }

    /// Returns the command without folder, threads and `--quiet`, on which the files do not depend.
    fn canonical(&self, ids: &[FigureId], seed: u64) -> Provenance {
        let figures = if ids.len() == FigureId::all().count() {
            "all".to_owned()
        } else {
            ids.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
        };
        Provenance::of(format!("sphvar reproduce {figures} --{}", self.scale().name()), seed)
    }
}

/// The figures and claims of the thesis: `reproduce --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ReproductionBody {
    /// Every figure with its files.
    figures: Vec<FigureRecord>,
    /// Every claim with its verdict.
    claims: Vec<VerdictRecord>,
    /// The number of rows with each verdict.
    verdicts: BTreeMap<&'static str, usize>,
    /// The errata that wrong rows belong to, each once.
    wrong_errata: Vec<u8>,
    /// `quick` or `full`.
    scale: &'static str,
}

/// A figure and its files.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct FigureRecord {
    /// The number.
    id: &'static str,
    /// The title.
    title: &'static str,
    /// The titles of its panels.
    panels: Vec<String>,
    /// The files of its panels, relative to the folder.
    files: Vec<String>,
    /// Notes below the figure.
    notes: Vec<String>,
}

/// A figure with the files that show it.
struct Drawn {
    figure: Figure,
    /// The picture and the data of each panel, relative to the folder.
    files: Vec<[String; 2]>,
}

pub(crate) fn run(args: &ReproduceArgs, global: &Global) -> Result<(), CliError> {
    let ids = args.ids()?;
    let setting = Setting { scale: args.scale(), seed: global.seed };
    let provenance = args.canonical(&ids, global.seed);
    let jobs: Vec<Vec<Job>> = ids.iter().map(|id| id.jobs(setting)).collect();
    let tasks = global.session.tasks();
    if tasks.is_part() {
        return keep_pieces(&jobs.concat(), setting, global);
    }
    let mut results = Results::new(setting);
    let mut figures: Vec<(FigureId, Vec<Job>)> = ids.into_iter().zip(jobs).collect();
    if tasks.is_merge() {
        figures = merged_figures(figures, &mut results, global)?;
    }
    let folder = OutFolder::open(&args.out, &global.session)?;
    let store = folder.pieces()?;
    let mut pieces = if tasks.is_merge() {
        Pieces::Merged { tasks: tasks.clone(), store }
    } else if args.sharding.save.is_some() {
        Pieces::Kept { tasks: tasks.clone(), store: Some(store), known: HashSet::new() }
    } else {
        Pieces::Stored(store)
    };

    let all: Vec<Job> = figures.iter().flat_map(|(_, jobs)| jobs.clone()).collect();
    let progress = Progress::new(work(&all), &global.session);
    let mut drawn = Vec::new();
    for (id, jobs) in &figures {
        progress.stage(&format!("figure {id}"));
        pieces.run(jobs, &mut results, &progress)?;
        let figure = id.compose(&results)?;
        let files = folder.write_panels(&figure, &provenance)?;
        drawn.push(Drawn { figure, files });
    }
    drop(progress);

    let claims = records(&drawn);
    let [table, report, whole] = TABLES;
    folder.write(table, &csv(&provenance, CSV_HEADING, &csv_rows(&claims)))?;
    folder.write(report, &markdown(&claims, &drawn, setting.scale, &provenance))?;
    folder.write(whole, &page::page(&drawn, &claims, &folder, setting.scale, &provenance)?)?;
    global.session.say(&format!("wrote {}", args.out.join("index.html").display()));
    if global.json {
        let figures = drawn.iter().map(FigureRecord::new).collect();
        let summary = Summary::new(&claims);
        let wrong_errata = summary.errata().into_iter().filter(|e| e.is_wrong());
        let wrong_errata = wrong_errata.map(|erratum| erratum.number).collect();
        let verdicts = Verdict::ALL.map(|v| (v.name(), summary.count(v))).into();
        let scale = setting.scale.name();
        let body = ReproductionBody { figures, claims, verdicts, wrong_errata, scale };
        Document::new(&body, &provenance).print(&global.session)
    } else {
        global.session.print(&plain_table(&claims))
    }
}

/// Completes figures with the pieces of merged parts; those of which a partial merge lacks pieces are
/// left out.
fn merged_figures(
    figures: Vec<(FigureId, Vec<Job>)>,
    results: &mut Results,
    global: &Global,
) -> Result<Vec<(FigureId, Vec<Job>)>, CliError> {
    let mut complete = Vec::new();
    for (id, jobs) in figures {
        pieces::merge(&jobs, results, global.session.tasks())?;
        if jobs.iter().all(|job| results.contains(job)) {
            complete.push((id, jobs));
        } else {
            global.session.say(&format!("figure {id} is left out: parts of its work are missing"));
        }
    }
    if complete.is_empty() {
        return Err(CliError::File("the given parts have no figure completely".to_owned()));
    }
    Ok(complete)
}

/// Computes the pieces of one part of a run, which has no figures.
fn keep_pieces(jobs: &[Job], setting: Setting, global: &Global) -> Result<(), CliError> {
    let progress = Progress::new(work(jobs), &global.session);
    progress.stage("pieces of figures");
    let tasks = global.session.tasks().clone();
    let mut pieces = Pieces::Kept { tasks, store: None, known: HashSet::new() };
    pieces.run(jobs, &mut Results::new(setting), &progress)
}

impl FigureRecord {
    fn new(Drawn { figure, files }: &Drawn) -> Self {
        Self {
            id: figure.id.number(),
            title: figure.id.title(),
            panels: figure.panels.iter().map(|panel| panel.title.clone()).collect(),
            files: files.iter().flatten().cloned().collect(),
            notes: figure.notes.clone(),
        }
    }
}
