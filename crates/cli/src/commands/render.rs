//! `sphvar render`: the effect of a pattern on a rendered image.

mod colours;
mod reference;
mod reference_file;
pub(crate) mod sheet;
pub(crate) mod single;
mod stage;
pub(crate) mod study;
mod trials;

use std::path::PathBuf;

use clap::Args;
use sphvar_scene::{DirectionMode, DirectionSets, Estimator};

use self::stage::StageArgs;
use crate::counts::{parse_count, parse_number, parse_one_count, parse_realizations};
use crate::error::CliError;
use crate::flags::retired::unknown_value;
use crate::flags::{CountsArgs, one_sampler};
use crate::global::Global;
use crate::spec::{argument, unknown_name};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar render cornell --sampler jittered -n 24 --size 64 -o ao.png
  sphvar render cornell --sampler fibonacci -n 256 --mode shared --mse -o bands.png
  sphvar render cornell --study --samplers white-noise,jittered -o study.png
  sphvar render mesh.obj --sampler healpix --integral irradiance:env=sky.exr -o m.exr
  sphvar render cornell --sheet reference,healpix@shared,healpix@rotated -o sheet.png

Modes: shared, one unrotated sphere set for all pixels; spun, one hemisphere set rotated about each \
normal; rotated, sphere sets rotated uniformly at each point; antipodal, hemisphere sets rotated as \
antipodal pairs; fresh, the same with a new realization for each pixel. Sphere sets have 2N points, of which the \
visible half is used. Every sampler takes its valid number of points nearest to N.

Errors are relative to a reference image (--reference-count). It is rendered when \
--mse, --json, --difference, --error, --study or --sheet need it, which takes minutes for large \
pictures, and kept in --cache for the next run.";

#[derive(Debug, Args)]
#[command(mut_arg("counts", |counts| counts.help(counts_help())))]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(super) stage: StageArgs,
    /// Sampler of the directions at each shading point: name or name:key=value,key=value
    #[arg(long, value_parser = one_sampler(), conflicts_with_all = ["samplers", "sheet"])]
    pub(super) sampler: Option<String>,
    #[command(flatten)]
    pub(super) counts: CountsArgs,
    #[arg(long, default_value = DirectionMode::Antipodal.name(), help = format!(
        "How point sets are mapped to directions at each shading point: {}", in_words(&DirectionMode::ALL.map(DirectionMode::name))
    ))]
    pub(super) mode: String,
    /// Estimator for the visible half of a sphere set: ratio (mean of visible samples) or unbiased (sum divided by N)
    #[arg(long, default_value = Estimator::Ratio.name())]
    pub(super) estimator: String,
    /// Sets in the table from which each pixel takes one [default: 262144/N, from 4 to 1024; fewer where they are expensive]
    #[arg(long, value_name = "K", value_parser = parse_count)]
    pub(super) sets: Option<usize>,
    #[arg(short = 'm', long, value_name = "M", value_parser = parse_realizations, help = format!(
        "Renders from which errors are estimated; the first one is the picture [default: {}; of a sheet {}; 1 without errors]",
        trials::DEFAULT_RENDERS, sheet::DEFAULT_RENDERS
    ))]
    pub(super) realizations: Option<u64>,
    /// Compare with the reference image: mean squared error, bias, structure
    #[arg(long)]
    pub(super) mse: bool,
    /// Minimum number of directions at each pixel of the reference image; they are jittered, so 6 nside^2
    #[arg(long, default_value = "32768", value_name = "N", value_parser = parse_one_count)]
    pub(super) reference_count: usize,
    /// Folder for reference images; none disables the cache [default: the cache folder of the user]
    #[arg(long, value_name = "FOLDER")]
    pub(super) cache: Option<PathBuf>,
    /// Write the picture to a file: .png, .exr or .pfm, with the coverage of pixels as alpha where surfaces do not fill it; of a study the results, .csv or .json, or a plot, .svg or .png
    #[arg(short, long, value_name = "FILE")]
    pub(super) out: Option<PathBuf>,
    /// Value shown as white in a .png [default: 1; for irradiance and light the brightest pixel, or the 99th percentile of the pixels if that is less than a tenth of it]
    #[arg(long, value_name = "VALUE", value_parser = parse_number)]
    pub(super) white: Option<f64>,
    /// Write picture minus reference image; in a .png red is too bright and blue too dark
    #[arg(long, value_name = "FILE")]
    pub(super) difference: Option<PathBuf>,
    /// Write the squared error of each pixel, averaged over the renders
    #[arg(long, value_name = "FILE")]
    pub(super) error: Option<PathBuf>,
    /// Mean squared errors against N of --samplers, with rates and crossovers
    #[arg(long, conflicts_with_all = ["difference", "error", "sheet", "white"])]
    pub(super) study: bool,
    /// Samplers of a study, separated by commas; all is every sampler
    #[arg(long, requires = "study", value_parser = argument())]
    pub(super) samplers: Option<String>,
    /// Pictures side by side with their errors: SAMPLER@MODE or reference, separated by commas; one row for each N
    #[arg(long, value_name = "PANELS", conflicts_with_all = ["difference", "error"], value_parser = argument())]
    pub(super) sheet: Option<String>,
}

fn counts_help() -> String {
    let (first, last) = study::DEFAULT_RANGE;
    format!(
        "Numbers of points N on the visible hemisphere of each shading point: one, or for --study and --sheet a list such \
         as 16,64,256 or a range such as 16..1024, which doubles [default: {}; of a study {first}..{last}]",
        single::DEFAULT_COUNT
    )
}

/// Returns names for help texts: `a, b or c`.
fn in_words(names: &[&str]) -> String {
    let (last, others) = names.split_last().unwrap_or((&"", &[]));
    format!("{} or {last}", others.join(", "))
}

pub(crate) fn run(args: &RenderArgs, global: &Global) -> Result<(), CliError> {
    if args.realizations == Some(0) {
        return Err(CliError::Usage("-m must be at least 1, got 0".to_owned()));
    }
    if args.realizations.is_some_and(|m| m > DirectionSets::MAX_RENDERS) {
        let max = DirectionSets::MAX_RENDERS;
        return Err(CliError::Usage(format!("-m must be at most {max}")));
    }
    if args.sets == Some(0) {
        return Err(CliError::Usage("--sets must be at least 1, got 0".to_owned()));
    }
    if args.study {
        study::run(args, global)
    } else if let Some(panels) = &args.sheet {
        sheet::run(args, panels, global)
    } else {
        single::run(args, global)
    }
}

impl RenderArgs {
    fn mode(&self) -> Result<DirectionMode, CliError> {
        parse_mode(&self.mode)
    }

    fn estimator(&self) -> Result<Estimator, CliError> {
        let found = Estimator::ALL.into_iter().find(|e| e.name() == self.estimator);
        let names = Estimator::ALL.map(Estimator::name);
        found.ok_or_else(|| unknown_name("estimator", &self.estimator, &names))
    }
}

fn parse_mode(text: &str) -> Result<DirectionMode, CliError> {
    let found = DirectionMode::ALL.into_iter().find(|m| m.name() == text);
    found.ok_or_else(|| unknown_value("mode", text, &DirectionMode::ALL.map(DirectionMode::name)))
}
