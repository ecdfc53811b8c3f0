//! One picture, and if it is wished its errors.

use std::path::{Path, PathBuf};

use serde::Serialize;
use sphvar_scene::Image;

use super::RenderArgs;
use super::colours::{grey, quantile, signed};
use super::reference::Reference;
use super::stage::Stage;
use super::trials::{Errors, Outcome, Trials, USUAL_RENDERS};
use crate::error::CliError;
use crate::files::{AtomicFile, Picture, PictureFormat};
use crate::global::Global;
use crate::patterns::parse_pattern;
use crate::progress::Progress;
use crate::report::{Provenance, is_stdout, print, print_json, say, short};

/// Pixels on a side, unless others are wished.
const USUAL_SIZE: usize = 512;
/// Directions, unless others are wished.
const USUAL_COUNT: usize = 256;

/// The document of `--json`.
#[derive(Debug, Serialize)]
struct Document<'a> {
    sampler: String,
    mode: &'static str,
    estimator: &'static str,
    asked: usize,
    n: usize,
    sets: usize,
    width: usize,
    height: usize,
    /// Pixels in which a surface is seen, the share of the picture that surfaces cover, and the mean value over that.
    pixels: usize,
    coverage: f64,
    mean: f64,
    renders: u64,
    #[serde(flatten)]
    errors: ErrorRecord,
    reference_n: usize,
    rays: u64,
    seconds: f64,
    provenance: &'a Provenance,
}

/// Errors as scripts see them.
#[derive(Debug, Serialize)]
pub(super) struct ErrorRecord {
    pub(super) mse: f64,
    pub(super) mse_stderr: f64,
    pub(super) variance: f64,
    pub(super) variance_stderr: f64,
    pub(super) bias_squared: f64,
    pub(super) bias_squared_stderr: f64,
    pub(super) white_noise: f64,
    /// White noise's exact mean squared error over this one.
    pub(super) gain: f64,
    pub(super) structured_error: f64,
    pub(super) structured_error_stderr: f64,
    pub(super) autocorrelation: f64,
    pub(super) bias_t: Option<f64>,
    pub(super) bias_limit: Option<f64>,
    pub(super) biased_pixels: Option<usize>,
}

impl ErrorRecord {
    pub(super) fn new(errors: &Errors) -> Self {
        let Errors { report, white_noise, .. } = errors;
        Self {
            mse: report.mse.value,
            mse_stderr: report.mse.stderr,
            variance: report.variance.value,
            variance_stderr: report.variance.stderr,
            bias_squared: report.bias_squared.value,
            bias_squared_stderr: report.bias_squared.stderr,
            white_noise: *white_noise,
            gain: white_noise / report.mse.value,
            structured_error: report.structure.value,
            structured_error_stderr: report.structure.stderr,
            autocorrelation: report.autocorrelation.value,
            bias_t: report.bias.map(|b| b.largest),
            bias_limit: report.bias.map(|b| b.limit),
            biased_pixels: report.bias.map(|b| b.beyond),
        }
    }
}

pub(super) fn run(args: &RenderArgs, global: &Global) -> Result<(), CliError> {
    let Some(sampler) = &args.sampler else {
        return Err(CliError::Usage("--sampler is missing: which directions?".to_owned()));
    };
    check_outputs(args, global)?;
    let count = match args.points.as_ref().map(|counts| counts.all()) {
        None => USUAL_COUNT,
        Some(&[n]) => n,
        Some(several) => {
            return Err(CliError::Usage(format!(
                "one picture has one number of directions, got {}; several are for --study and --sheet",
                several.len()
            )));
        }
    };
    let compare = args.mse || global.json || args.difference.is_some() || args.error.is_some();
    let renders = args.realizations.unwrap_or(if compare { USUAL_RENDERS } else { 1 });
    if renders > 1 && !compare {
        return Err(CliError::Usage(format!(
            "-m {renders} is for errors: ask for them with --mse, --json, --difference or --error"
        )));
    }
    let pattern = parse_pattern(sampler)?;
    let trials = Trials::new(args, pattern, args.mode()?, count, renders, global.seed)?;
    Trials::check_sets(args, [&trials])?;
    let stage = args.stage.stage(USUAL_SIZE, global.quiet)?;
    trials.check(&stage)?;
    let reference = Reference::new(args, &stage, global)?;
    let reference = if compare {
        reference.remark(trials.plan.n_points());
        Some(reference.image(&stage)?)
    } else {
        None
    };
    let progress = Progress::new(trials.work(&stage)?, global.quiet);
    let outcome = trials.run(&stage, reference.as_ref(), &progress)?;
    drop(progress);
    let provenance = Provenance::new(global.seed);
    write_pictures(args, &stage, &outcome, reference.as_ref(), &provenance, global)?;
    if let (true, Some(reference), Some(errors)) = (global.json, &reference, &outcome.errors) {
        return print_json(&document(&trials, &outcome, errors, reference, &provenance));
    }
    if args.out.as_deref().is_some_and(is_stdout) {
        return Ok(());
    }
    print(&text(&trials, &outcome))
}

/// Refuses names that could not be written, before the work.
fn check_outputs(args: &RenderArgs, global: &Global) -> Result<(), CliError> {
    let paths: Vec<&PathBuf> =
        [&args.out, &args.difference, &args.error].into_iter().flatten().collect();
    for (i, path) in paths.iter().enumerate() {
        PictureFormat::of_path(path)?;
        AtomicFile::check(path)?;
        if !is_stdout(path) && paths[..i].contains(path) {
            return Err(CliError::Usage(format!(
                "-o, --difference and --error need files of their own, got {} twice",
                path.display()
            )));
        }
    }
    let on_stdout = |path: &Option<PathBuf>| path.as_deref().is_some_and(is_stdout);
    let others = [&args.difference, &args.error].into_iter().any(on_stdout);
    if others || (on_stdout(&args.out) && global.json) {
        return Err(CliError::Usage(
            "standard output takes one document: the picture of -o - or that of --json".to_owned(),
        ));
    }
    if args.white.is_some_and(|white| !(white > 0.0 && white.is_finite())) {
        return Err(CliError::Usage("--white must be a number above 0".to_owned()));
    }
    Ok(())
}

fn document<'a>(
    trials: &Trials,
    outcome: &Outcome,
    errors: &Errors,
    reference: &Image,
    provenance: &'a Provenance,
) -> Document<'a> {
    let Outcome { picture, rays, seconds, .. } = outcome;
    Document {
        sampler: trials.plan.pattern().to_string(),
        mode: trials.plan.mode().name(),
        estimator: trials.estimator.name(),
        asked: trials.asked,
        n: trials.plan.n_points(),
        sets: trials.plan.n_sets(),
        width: picture.width,
        height: picture.height,
        pixels: picture.n_hits(),
        coverage: picture.covered_area() / (picture.width * picture.height) as f64,
        mean: picture.mean(),
        renders: trials.renders,
        errors: ErrorRecord::new(errors),
        reference_n: reference.n_points,
        rays: *rays,
        seconds: *seconds,
        provenance,
    }
}

fn text(trials: &Trials, outcome: &Outcome) -> String {
    let Outcome { picture, errors, rays, seconds } = outcome;
    let plan = &trials.plan;
    let mut text = format!(
        "{}, {}, N = {}: mean value {:.4} over {} pixels\n{:.3e} rays in {:.1} s, {:.2e} a second\n",
        plan.pattern(),
        plan.mode(),
        plan.n_points(),
        picture.mean(),
        picture.n_hits(),
        *rays as f64,
        seconds,
        *rays as f64 / seconds,
    );
    if let Some(errors) = errors {
        let record = ErrorRecord::new(errors);
        text += &format!(
            "mean squared error {} +- {} (renders: {}), {} times less than white noise's {}\n\
             variance {} +- {}, squared bias {} +- {}\n\
             structured error {} +- {} (1: independent pixels), neighbours' correlation {}\n",
            short(record.mse),
            short(record.mse_stderr),
            trials.renders,
            plain(record.gain, 2),
            short(record.white_noise),
            short(record.variance),
            short(record.variance_stderr),
            short(record.bias_squared),
            short(record.bias_squared_stderr),
            plain(record.structured_error, 2),
            plain(record.structured_error_stderr, 2),
            plain(record.autocorrelation, 3),
        );
        if let Some(bias) = errors.report.bias {
            text += &format!(
                "bias: {} of {} pixels beyond |t| = {:.1}, which chance passes in 1 % of pictures\n",
                bias.beyond, errors.report.pixels, bias.limit
            );
        }
    }
    text
}

/// A number for people with so many digits after the point, or a dash if there is none.
pub(super) fn plain(x: f64, digits: usize) -> String {
    if x.is_finite() { format!("{x:.digits$}") } else { "-".to_owned() }
}

fn write_pictures(
    args: &RenderArgs,
    stage: &Stage,
    outcome: &Outcome,
    reference: Option<&Image>,
    provenance: &Provenance,
    global: &Global,
) -> Result<(), CliError> {
    let Outcome { picture, errors, .. } = outcome;
    let remark = provenance.line();
    let (width, height) = (picture.width, picture.height);
    let write = |path: &Path, values: &[f64], colour: &dyn Fn(f64) -> [u8; 3]| {
        Picture { width, height, values, coverage: None }.write(path, colour, &remark)
    };
    if let Some(path) = &args.out {
        let white = white(args, stage, picture, global.quiet);
        let is_whole = picture.coverage.iter().all(|&c| c >= 1.0);
        // Where surfaces are seen all over there is no need of alpha.
        let coverage = (!is_whole).then_some(&*picture.coverage);
        let picture = Picture { width, height, values: &picture.values, coverage };
        picture.write(path, &grey(white), &remark)?;
    }
    if let (Some(path), Some(reference)) = (&args.difference, reference) {
        let pairs = picture.values.iter().zip(&reference.values);
        let difference: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
        let full = quantile(difference.iter().map(|x| x.abs()), 0.99);
        write(path, &difference, &signed(full))?;
    }
    if let (Some(path), Some(errors)) = (&args.error, errors) {
        let full = quantile(errors.squared.iter().copied(), 0.99);
        write(path, &errors.squared, &grey(full))?;
    }
    Ok(())
}

/// What is white in a picture of these values: what is asked for, or 1 for shares, else the brightest pixel; but where
/// few pixels are far brighter than the others, as under a sun, what 99 % of the pixels stay below. Says so where
/// most of the picture would be black.
pub(super) fn white(args: &RenderArgs, stage: &Stage, picture: &Image, quiet: bool) -> f64 {
    let seen = || {
        let pixels = picture.values.iter().zip(&picture.coverage);
        pixels.filter(|(_, coverage)| **coverage > 0.0).map(|(&value, _)| value)
    };
    let brightest = seen().fold(0.0, f64::max);
    let nearly_all = quantile(seen(), 0.99);
    let is_spiky = nearly_all > 0.0 && nearly_all < SPIKE * brightest;
    let white = match args.white {
        Some(white) => white,
        None if stage.is_share() || brightest == 0.0 => 1.0,
        None if is_spiky => nearly_all,
        None => brightest,
    };
    let median = quantile(seen(), 0.5);
    if brightest > 0.0 && (median < BLACK * white || (args.white.is_none() && is_spiky)) {
        let least = seen().fold(f64::INFINITY, f64::min);
        let text = format!(
            "values are from {} to {}, half of them below {}; {} is white (--white sets it)",
            short(least),
            short(brightest),
            short(median),
            short(white),
        );
        say(quiet, &text);
    }
    white
}

/// Pixels are spikes if 99 % of a picture stay below this share of them.
const SPIKE: f64 = 0.1;
/// The linear share of white below which a pixel of 8 bits looks black.
const BLACK: f64 = 1.0 / 256.0;
