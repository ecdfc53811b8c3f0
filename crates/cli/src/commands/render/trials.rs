//! Repeated renders of one pattern with their errors.

use std::time::Instant;

use sphvar_scene::{
    DirectionPlan, Error, ErrorReport, Estimator, Image, RenderErrors, WarpedPlan, render,
};

use super::RenderArgs;
use super::plan::Plan;
use super::sampler::RenderSampler;
use super::stage::Stage;
use crate::error::CliError;
use crate::global::Global;
use crate::memory::check_memory;
use crate::patterns::SamplerName;
use crate::progress::Progress;

/// The default number of renders from which errors are estimated.
pub(super) const DEFAULT_RENDERS: u64 = 8;

/// One sampler at one number of directions.
pub(super) struct Trials {
    pub(super) name: SamplerName,
    /// The mapping of sets to directions.
    pub(super) mode: &'static str,
    pub(super) requested: usize,
    pub(super) plan: Plan,
    /// The value of `--sets`.
    sets: Option<usize>,
    pub(super) estimator: Estimator,
    pub(super) renders: u64,
}

/// The result of the renders.
pub(super) struct Outcome {
    /// The first render.
    pub(super) picture: Image,
    /// The errors, if there was a reference image.
    pub(super) errors: Option<Errors>,
    /// Occlusion rays of all renders and their time, without the time to generate the sets.
    pub(super) rays: u64,
    pub(super) seconds: f64,
}

/// Errors against the reference image.
pub(super) struct Errors {
    pub(super) report: ErrorReport,
    /// The squared error of each pixel, averaged over the renders.
    pub(super) squared: Vec<f64>,
    /// The exact mean squared error of the same number of independent directions.
    pub(super) white_noise: f64,
}

impl Trials {
    /// Uses the nearest valid number of directions.
    pub(super) fn new(
        args: &RenderArgs,
        sampler: &RenderSampler,
        stage: &Stage,
        requested: usize,
        renders: u64,
        global: &Global,
    ) -> Result<Self, CliError> {
        let mut plan = match sampler {
            RenderSampler::Uniform(pattern, mode) => {
                let n = DirectionPlan::nearest_count(pattern, requested, *mode);
                let plan = DirectionPlan::new(pattern.clone(), n, *mode, global.seed);
                Plan::Uniform(plan.map_err(|error| match error {
                    Error::Sampler(sphvar_samplers::Error::Given { .. }) => CliError::Failed(format!(
                        "{error}; --mode rotated and --mode shared take sets of the whole sphere"
                    )),
                    _ => CliError::usage(error),
                })?)
            }
            RenderSampler::Warped(sampler) => {
                let densities = sampler.densities(stage, &global.session)?;
                let (pattern, heuristic) = (sampler.pattern.clone(), sampler.heuristic);
                let plan = WarpedPlan::new(pattern, densities, requested, heuristic, global.seed);
                let plan = plan.map_err(CliError::usage)?;
                stage
                    .with_integral(|integral| plan.check(integral))
                    .map_err(|error| CliError::Usage(format!("{}: {error}", sampler.text())))?;
                Plan::Warped(plan)
            }
        };
        if let Some(sets) = args.sets {
            plan = plan.with_sets(sets).map_err(CliError::usage)?;
        }
        Ok(Self {
            name: sampler.name(),
            mode: sampler.mode(),
            requested,
            plan,
            sets: args.sets,
            estimator: args.estimator(sampler)?,
            renders,
        })
    }

    /// Rejects `--sets` if no case uses a table.
    pub(super) fn check_sets<'a>(
        args: &RenderArgs,
        cases: impl IntoIterator<Item = &'a Self>,
    ) -> Result<(), CliError> {
        if args.sets.is_some() && !cases.into_iter().any(|case| case.plan.has_table()) {
            return Err(CliError::Usage(
                "--sets requires a random sampler, and without warp= the mode rotated or antipodal"
                    .to_owned(),
            ));
        }
        Ok(())
    }

    /// Rejects work that does not fit in memory.
    pub(super) fn check(&self, stage: &Stage) -> Result<(), CliError> {
        let what = match self.sets {
            Some(sets) if self.plan.has_table() => format!("-n {} --sets {sets}", self.requested),
            _ => format!("-n {}", self.requested),
        };
        check_memory(&what, self.plan.bytes())?;
        // Value, two spreads and coverage of the render and the reference, and the errors of all
        // renders.
        let pixel = (2 * 32 + 8) as f64 + 8.0 * self.renders as f64;
        let region = stage.view()?.region();
        check_memory("the picture", pixel * (region.width * region.height) as f64)
    }

    /// Returns the work for the progress bar.
    pub(super) fn work(&self, stage: &Stage) -> Result<f64, CliError> {
        let region = stage.view()?.region();
        let pixels = (region.width * region.height) as f64 * self.plan.pixel_work();
        Ok((self.plan.table_work() + pixels) * self.renders as f64)
    }

    /// Renders and compares.
    pub(super) fn run(
        &self,
        stage: &Stage,
        reference: Option<&Image>,
        progress: &Progress,
    ) -> Result<Outcome, CliError> {
        progress.stage(&format!("{} N = {}", self.name.label, self.plan.n_points()));
        let view = stage.view()?;
        let mut errors = reference.map(RenderErrors::new);
        let (mut picture, mut rays, mut seconds) = (None, 0, 0.0);
        for number in 0..self.renders {
            let sets = self.plan.prepare(number).map_err(CliError::failed)?;
            progress.advance(self.plan.table_work())?;
            let start = Instant::now();
            let image = stage
                .with_integral(|integral| render(&view, integral, self.estimator, &*sets, progress))
                .map_err(CliError::failed)?;
            seconds += start.elapsed().as_secs_f64();
            rays += image.rays;
            if let Some(errors) = &mut errors {
                errors.push(&image).map_err(CliError::failed)?;
            }
            if image.n_hits() == 0 {
                return Err(CliError::Failed(
                    "the picture shows no surface: --eye, --look-at, --fov or --crop miss the scene"
                        .to_owned(),
                ));
            }
            picture.get_or_insert(image);
        }
        let picture =
            picture.ok_or_else(|| CliError::Usage("-m must be at least 1, got 0".to_owned()))?;
        let errors = errors.zip(reference).map(|(errors, reference)| Errors {
            report: errors.report(),
            squared: errors.squared_errors(),
            white_noise: reference.white_noise_variance(self.plan.n_points()),
        });
        Ok(Outcome { picture, errors, rays, seconds })
    }
}
