//! `sphvar render`: the effect of a pattern on a rendered image.

mod colours;
mod exposure;
mod kept_renders;
mod numbers;
mod plan;
mod reference;
mod reference_file;
mod rows;
mod sampler;
pub(crate) mod sheet;
pub(crate) mod single;
mod stage;
pub(crate) mod study;
mod trials;

use std::path::PathBuf;

use clap::Args;
use sphvar_scene::{DirectionMode, DirectionSets, Estimator};

use self::exposure::White;
use self::sampler::{LIGHT_DENSITIES, RenderSampler};
use self::stage::StageArgs;
use crate::counts::{parse_count, parse_one_count, parse_realizations};
use crate::error::CliError;
use crate::flags::retired::unknown_value;
use crate::flags::{CountsArgs, one_sampler};
use crate::global::Global;
use crate::shards::ShardArgs;
use crate::spec::{argument, unknown_name};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar render cornell --sampler jittered -n 24 --size 64 -o ao.png
  sphvar render cornell --sampler fibonacci -n 256 --mode shared --mse -o bands.png
  sphvar render cornell --study --samplers white-noise,jittered -o study.png
  sphvar render cornell --study --samplers white-noise,jittered -m 64 --shard 3/16 --save 3.shard
  sphvar render mesh.obj --sampler healpix --integral irradiance:env=sky.exr -o m.exr
  sphvar render cornell --integral light --sampler sobol:warp=light -n 16 --size 64 -o light.png
  sphvar render cornell --sheet reference,healpix@shared,healpix@rotated -o sheet.png

Modes: shared, one unrotated sphere set for all pixels; spun, one hemisphere set rotated about each \
normal; rotated, sphere sets rotated uniformly at each point; antipodal, hemisphere sets rotated as \
antipodal pairs; fresh, the same with a new realization for each pixel. Sphere sets have 2N points, of which the \
visible half is used.

Importance sampling: sobol:warp=cosine maps each set, shifted at each point, to a density, with weights 1/(N p). \
Densities are about the normal (cosine, cylinder, octahedral, cap, phong, vmf) or in the world (env:FILE); light is \
uniform on the solid angle of the light, by the map of a spherical rectangle or, where it is no rectangle, of two spherical \
triangles, and triangles always by these. A sum such as warp=\"0.5 * cosine + 0.5 * env:FILE\" divides N and takes \
weights by heuristic=balance or power.

Exposure: a .png of light shows the 99th percentile of the lit pixels as white, so a sun or fireflies do not darken it; \
.exr and .pfm hold the values. Every sampler takes its valid number of points nearest to N.

Errors are relative to a reference image (--reference-count). It is rendered when \
--mse, --json, --difference, --error, --study or --sheet need it, which takes minutes for large \
pictures, and kept in --cache for the next run. Files of --save have 8 bytes for each pixel of each render of a study, \
16 with warp=, and 24 to 32 for each of the reference image; a merge needs the memory for all of them.";

#[derive(Debug, Args)]
#[command(mut_arg("counts", |counts| counts.help(counts_help())))]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(super) stage: StageArgs,
    #[arg(long, value_parser = one_sampler(), conflicts_with_all = ["samplers", "sheet"], help = format!(
        "Sampler of the directions at each shading point: name or name:key=value,key=value; with warp=, a pattern of the \
         unit square that is mapped to a density: {LIGHT_DENSITIES}, or those of sphvar list warps"
    ))]
    pub(super) sampler: Option<String>,
    #[command(flatten)]
    pub(super) counts: CountsArgs,
    #[arg(long, help = format!(
        "How point sets are mapped to uniform directions at each shading point: {} [default: {DEFAULT_MODE}]",
        in_words(&DirectionMode::ALL.map(DirectionMode::name))
    ))]
    pub(super) mode: Option<String>,
    /// Estimator for the visible half of a sphere set: ratio (mean of visible samples) or unbiased (sum divided by N) [default: ratio; always unbiased with warp=]
    #[arg(long)]
    pub(super) estimator: Option<String>,
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
    #[arg(long, value_name = "N", value_parser = parse_one_count, help = format!(
        "Minimum number of directions at each pixel of the reference image; they are jittered, so 6 nside^2. If a sampler \
         has warp=, they have the densities of the light, or of the cosine and the map [default: {}; of densities {}]",
        reference::UNIFORM_DIRECTIONS, reference::WARPED_DIRECTIONS
    ))]
    pub(super) reference_count: Option<usize>,
    /// Folder for reference images; none disables the cache [default: the cache folder of the user]
    #[arg(long, value_name = "FOLDER")]
    pub(super) cache: Option<PathBuf>,
    /// Write the picture to a file: .png, .exr or .pfm, with the coverage of pixels as alpha where surfaces do not fill it; of a study the results, .csv or .json, or a plot, .svg or .png
    #[arg(short, long, value_name = "FILE")]
    pub(super) out: Option<PathBuf>,
    /// Value shown as white in a .png; a percentage P% is the value that P percent of the lit pixels, those above 0, do not exceed [default: 1; for irradiance and light 99%]
    #[arg(long, value_name = "VALUE|P%", allow_negative_numbers = true)]
    pub(super) white: Option<White>,
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
    #[command(flatten)]
    pub(crate) sharding: ShardArgs,
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

/// The default mode.
const DEFAULT_MODE: DirectionMode = DirectionMode::Antipodal;

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
    if args.sharding.save.is_some() && !args.study {
        return Err(CliError::Usage(
            "--save and --shard require --study: the renders of a study are independent, whereas one picture is \
             divided by --crop"
                .to_owned(),
        ));
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
        self.mode.as_deref().map_or(Ok(DEFAULT_MODE), parse_mode)
    }

    /// Rejects flags about uniform directions if there are none.
    fn check_mode<'a>(
        &self,
        samplers: impl IntoIterator<Item = &'a RenderSampler>,
    ) -> Result<(), CliError> {
        let mut samplers = samplers.into_iter().peekable();
        let is_without_effect = samplers.peek().is_some() && samplers.all(RenderSampler::is_warped);
        let flags = [("--mode", self.mode.is_some()), ("--estimator", self.estimator.is_some())];
        match flags.into_iter().find(|(_, is_given)| *is_given && is_without_effect) {
            Some((flag, _)) => Err(CliError::Usage(format!(
                "{flag} requires a sampler of uniform directions, without warp="
            ))),
            None => Ok(()),
        }
    }

    fn estimator(&self, sampler: &RenderSampler) -> Result<Estimator, CliError> {
        let Some(name) = &self.estimator else {
            return Ok(if sampler.is_warped() { Estimator::Unbiased } else { Estimator::Ratio });
        };
        let found = Estimator::ALL.into_iter().find(|e| e.name() == name);
        let found = if sampler.is_warped() { found.and(Some(Estimator::Unbiased)) } else { found };
        let names = Estimator::ALL.map(Estimator::name);
        found.ok_or_else(|| unknown_name("estimator", name, &names))
    }
}

fn parse_mode(text: &str) -> Result<DirectionMode, CliError> {
    let found = DirectionMode::ALL.into_iter().find(|m| m.name() == text);
    found.ok_or_else(|| unknown_value("mode", text, &DirectionMode::ALL.map(DirectionMode::name)))
}
