//! One picture and, on request, its errors.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_scene::Image;

use super::RenderArgs;
use super::colours::{grey, quantile, signed};
use super::exposure::white;
use super::plan::Plan;
use super::reference::Reference;
use super::sampler::RenderSampler;
use super::stage::{PICTURE_SIZE, Stage};
use super::trials::{DEFAULT_RENDERS, Errors, Outcome, Trials};
use crate::error::CliError;
use crate::files::{AtomicFile, Picture, PictureFormat};
use crate::global::Global;
use crate::point_sets::WeightSums;
use crate::progress::Progress;
use crate::report::{Document, Provenance, is_stdout, number};

/// The default number of directions.
pub(super) const DEFAULT_COUNT: usize = 256;

/// One picture with its errors: `render --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct RenderBody {
    /// The sampler with its parameters.
    sampler: String,
    /// The mapping of point sets to directions at each shading point; shifted for densities.
    mode: &'static str,
    /// The estimator for the visible half of a sphere set.
    estimator: &'static str,
    /// The number of directions requested.
    n_requested: usize,
    /// The number of directions on the visible hemisphere of each point.
    n: usize,
    /// The effective number of the weighted points of a set, `(sum w)^2 / sum w^2`.
    #[serde(skip_serializing_if = "Option::is_none")]
    n_effective: Option<f64>,
    /// The number of sets in the table of a render.
    sets: usize,
    /// The width of the picture in pixels.
    width: usize,
    /// The height of the picture in pixels.
    height: usize,
    /// The number of pixels in which a surface is visible.
    pixels: usize,
    /// The share of the picture that surfaces cover, from 0 to 1.
    coverage: f64,
    /// The mean value over the covered part.
    #[schemars(with = "Option<f64>")]
    mean: f64,
    /// The number of renders from which errors are estimated.
    renders: u64,
    #[serde(flatten)]
    errors: ErrorRecord,
    /// Directions of each pixel of the reference image.
    reference_n: usize,
    /// Occlusion rays of all renders.
    rays: u64,
    /// The time of the rays, in seconds.
    seconds: f64,
}

/// Errors of renders against the reference image, in squared units of the values. A number that
/// cannot be given is null.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ErrorRecord {
    /// The mean squared error over the pixels.
    #[schemars(with = "Option<f64>")]
    pub(super) mse: f64,
    /// The standard error of `mse`.
    #[schemars(with = "Option<f64>")]
    pub(super) mse_stderr: f64,
    /// The variance of a pixel over the renders, averaged over the pixels.
    #[schemars(with = "Option<f64>")]
    pub(super) variance: f64,
    /// The standard error of `variance`.
    #[schemars(with = "Option<f64>")]
    pub(super) variance_stderr: f64,
    /// The squared bias of a pixel, averaged over the pixels.
    #[schemars(with = "Option<f64>")]
    pub(super) bias_squared: f64,
    /// The standard error of `bias_squared`.
    #[schemars(with = "Option<f64>")]
    pub(super) bias_squared_stderr: f64,
    /// The exact mean squared error of the same number of independent uniform directions.
    #[schemars(with = "Option<f64>")]
    pub(super) white_noise: f64,
    /// `white_noise` divided by `mse`.
    #[schemars(with = "Option<f64>")]
    pub(super) variance_reduction: f64,
    /// The largest error of a pixel, averaged over renders, in units of the root mean squared error:
    /// 4 to 5 for normal errors of equal size, more with fireflies.
    #[schemars(with = "Option<f64>")]
    pub(super) firefly: f64,
    /// The standard error of `firefly`.
    #[schemars(with = "Option<f64>")]
    pub(super) firefly_stderr: f64,
    /// 64 times the error of means over 8 by 8 pixels over that of pixels: 1 for independent
    /// pixels.
    #[schemars(with = "Option<f64>")]
    pub(super) structured_error: f64,
    /// The standard error of `structured_error`.
    #[schemars(with = "Option<f64>")]
    pub(super) structured_error_stderr: f64,
    /// The correlation of the errors of neighbouring pixels.
    #[schemars(with = "Option<f64>")]
    pub(super) autocorrelation: f64,
    /// The largest |t| of a pixel: its bias over its standard error.
    pub(super) bias_t: Option<f64>,
    /// The limit that `bias_t` exceeds by chance in 1 % of pictures.
    pub(super) bias_limit: Option<f64>,
    /// The number of pixels beyond the limit.
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
            variance_reduction: white_noise / report.mse.value,
            firefly: report.firefly.value,
            firefly_stderr: report.firefly.stderr,
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
        return Err(CliError::Usage("missing required option --sampler".to_owned()));
    };
    check_outputs(args, global)?;
    let count = match args.counts.counts.as_ref().map(|counts| counts.all()) {
        None => DEFAULT_COUNT,
        Some(&[n]) => n,
        Some(several) => {
            return Err(CliError::Usage(format!(
                "-n must be one number for a single picture, got {}; --study and --sheet take several",
                several.len()
            )));
        }
    };
    let compare = args.mse || global.json || args.difference.is_some() || args.error.is_some();
    let renders = args.realizations.unwrap_or(if compare { DEFAULT_RENDERS } else { 1 });
    if renders > 1 && !compare {
        return Err(CliError::Usage(format!(
            "-m {renders} needs errors: request them with --mse, --json, --difference or --error"
        )));
    }
    let sampler = RenderSampler::parse(sampler, args.mode()?, &global.session)?;
    args.check_mode([&sampler])?;
    let stage = args.stage.stage(PICTURE_SIZE, &global.session)?;
    let trials = Trials::new(args, &sampler, &stage, count, renders, global)?;
    Trials::check_sets(args, [&trials])?;
    trials.check(&stage)?;
    let n = trials.plan.n_points();
    if n != count {
        let why = format!("{n} directions, the valid number nearest to the requested {count}");
        global.session.say(&format!("{}: {why}", sampler.name().label));
    }
    let reference = Reference::new(args, &stage, sampler.is_warped(), global)?;
    let reference = if compare {
        reference.remark(trials.plan.n_points());
        Some(reference.image(&stage)?)
    } else {
        None
    };
    let progress = Progress::new(trials.work(&stage)?, &global.session);
    let outcome = trials.run(&stage, reference.as_ref(), &progress)?;
    drop(progress);
    let provenance = Provenance::new(&global.session, global.seed);
    write_pictures(args, &stage, &outcome, reference.as_ref(), &provenance, global)?;
    if let (true, Some(reference), Some(errors)) = (global.json, &reference, &outcome.errors) {
        let body = body(&trials, &outcome, errors, reference)?;
        return Document::new(&body, &provenance).print(&global.session);
    }
    if args.out.as_deref().is_some_and(is_stdout) {
        return Ok(());
    }
    global.session.print(&text(&trials, &outcome))
}

/// Rejects output names that cannot be written, before the work starts.
fn check_outputs(args: &RenderArgs, global: &Global) -> Result<(), CliError> {
    let paths: Vec<&PathBuf> =
        [&args.out, &args.difference, &args.error].into_iter().flatten().collect();
    for (i, path) in paths.iter().enumerate() {
        PictureFormat::of_path(path)?;
        AtomicFile::check(path)?;
        if !is_stdout(path) && paths[..i].contains(path) {
            return Err(CliError::Usage(format!(
                "-o, --difference and --error must name different files, got {} twice",
                path.display()
            )));
        }
    }
    let on_stdout = |path: &Option<PathBuf>| path.as_deref().is_some_and(is_stdout);
    let others = [&args.difference, &args.error].into_iter().any(on_stdout);
    if others || (on_stdout(&args.out) && global.json) {
        return Err(CliError::Usage(
            "standard output holds one document: use either -o - or --json".to_owned(),
        ));
    }
    Ok(())
}

fn body(
    trials: &Trials,
    outcome: &Outcome,
    errors: &Errors,
    reference: &Image,
) -> Result<RenderBody, CliError> {
    let Outcome { picture, rays, seconds, .. } = outcome;
    let weights = match &trials.plan {
        Plan::Uniform(plan) => {
            let sampler = plan.pattern().build(plan.set_points(), plan.mode().domain());
            WeightSums::of_sampler(&*sampler.map_err(CliError::failed)?)?
        }
        // The weights of densities estimate solid angles.
        Plan::Warped(_) => None,
    };
    Ok(RenderBody {
        sampler: trials.name.text.clone(),
        mode: trials.mode,
        estimator: trials.estimator.name(),
        n_requested: trials.requested,
        n: trials.plan.n_points(),
        n_effective: weights.map(|weights| weights.n_effective),
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
    })
}

fn text(trials: &Trials, outcome: &Outcome) -> String {
    let Outcome { picture, errors, rays, seconds } = outcome;
    let rays = *rays as f64;
    let mut text = format!(
        "{}, {}, N = {}: mean value {} over {} pixels\n{} rays in {}, {} per second\n",
        trials.name.label,
        trials.mode,
        trials.plan.n_points(),
        number::value(picture.mean()),
        picture.n_hits(),
        number::count(rays),
        number::seconds(*seconds),
        number::count(rays / seconds),
    );
    if let Some(errors) = errors {
        let record = ErrorRecord::new(errors);
        text += &format!(
            "mean squared error {} (renders: {}), {} times smaller than the {} of white noise\n\
             variance {}, squared bias {}\n\
             largest error of a pixel {} times the root mean square (4 to 5 for normal errors of equal size)\n\
             structured error {} (1: independent pixels), correlation of neighbours {}\n",
            number::with_uncertainty(record.mse, record.mse_stderr),
            trials.renders,
            number::ratio(record.variance_reduction),
            number::value(record.white_noise),
            number::with_uncertainty(record.variance, record.variance_stderr),
            number::with_uncertainty(record.bias_squared, record.bias_squared_stderr),
            number::with_uncertainty(record.firefly, record.firefly_stderr),
            number::with_uncertainty(record.structured_error, record.structured_error_stderr),
            number::ratio(record.autocorrelation),
        );
        if let Some(bias) = errors.report.bias {
            text += &format!(
                "bias: {} of {} pixels beyond |t| = {}, a limit that is exceeded by chance in 1 % of pictures\n",
                bias.beyond,
                errors.report.pixels,
                number::ratio(bias.limit)
            );
        }
    }
    text
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
        let white = white(args.white, stage, picture, &global.session);
        let is_whole = picture.coverage.iter().all(|&c| c >= 1.0);
        // A picture that is covered completely needs no alpha channel.
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
