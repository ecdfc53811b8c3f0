//! Repeated renders of one pattern with their errors.

use std::time::Instant;

use sphvar_scene::{
    DirectionPlan, Error, ErrorReport, Estimator, Image, RenderErrors, View, WarpedPlan, render,
};

use super::RenderArgs;
use super::kept_renders::KeptRenders;
use super::plan::Plan;
use super::sampler::RenderSampler;
use super::stage::Stage;
use crate::error::CliError;
use crate::global::Global;
use crate::memory::check_memory;
use crate::patterns::SamplerName;
use crate::progress::Progress;
use crate::shards::{Divided, Tasks};

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
        // Value, two spreads and coverage of the render and the reference, and of all renders the
        // errors, or the values and spreads.
        let of_render = if matches!(self.plan, Plan::Warped(_)) { 16.0 } else { 8.0 };
        let pixel = (2 * 32 + 8) as f64 + of_render * self.renders as f64;
        let region = stage.view()?.region();
        check_memory("the picture", pixel * (region.width * region.height) as f64)
    }

    /// Returns the work for the progress bar.
    pub(super) fn work(&self, stage: &Stage) -> Result<f64, CliError> {
        Ok(self.render_work(&stage.view()?) * self.renders as f64)
    }

    /// Returns the nominal work of one render.
    fn render_work(&self, view: &View<'_>) -> f64 {
        let region = view.region();
        let pixels = (region.width * region.height) as f64 * self.plan.pixel_work();
        self.plan.table_work() + pixels
    }

    /// Renders and compares.
    pub(super) fn run(
        &self,
        stage: &Stage,
        reference: Option<&Image>,
        progress: &Progress,
    ) -> Result<Outcome, CliError> {
        self.set_stage(progress);
        let view = stage.view()?;
        let mut errors = reference.map(RenderErrors::new);
        let (mut picture, mut rays, mut seconds) = (None, 0, 0.0);
        for number in 0..self.renders {
            let (image, time) = self.render(stage, &view, number, progress)?;
            seconds += time;
            rays += image.rays;
            if let Some(errors) = &mut errors {
                errors.push(&image).map_err(CliError::failed)?;
            }
            picture.get_or_insert(image);
        }
        let picture =
            picture.ok_or_else(|| CliError::Usage("-m must be at least 1, got 0".to_owned()))?;
        let errors =
            errors.zip(reference).map(|(errors, reference)| self.errors(&errors, reference));
        Ok(Outcome { picture, errors, rays, seconds })
    }

    /// Returns the renders that a run of these tasks has; `None` if it keeps only a part of them.
    pub(super) fn kept(
        &self,
        stage: &Stage,
        tasks: &Tasks,
        progress: &Progress,
    ) -> Result<Option<KeptRenders>, CliError> {
        self.set_stage(progress);
        let view = stage.view()?;
        let name = format!("{} {} N = {}", self.name.text, self.mode, self.plan.n_points());
        let task = Divided { name: &name, count: self.renders, work: self.render_work(&view) };
        tasks.divided(task, progress, KeptRenders::append, |numbers| {
            let mut kept = KeptRenders::new(self.plan.n_points());
            for number in numbers {
                let (image, seconds) = self.render(stage, &view, number, progress)?;
                kept.push(image, seconds);
            }
            Ok(kept)
        })
    }

    fn set_stage(&self, progress: &Progress) {
        progress.stage(&format!("{} N = {}", self.name.label, self.plan.n_points()));
    }

    /// Returns one render and the time of its rays.
    fn render(
        &self,
        stage: &Stage,
        view: &View<'_>,
        number: u64,
        progress: &Progress,
    ) -> Result<(Image, f64), CliError> {
        let sets = self.plan.prepare(number).map_err(CliError::failed)?;
        progress.advance(self.plan.table_work())?;
        let start = Instant::now();
        let image = stage
            .with_integral(|integral| render(view, integral, self.estimator, &*sets, progress))
            .map_err(CliError::failed)?;
        let seconds = start.elapsed().as_secs_f64();
        if image.n_hits() == 0 {
            return Err(CliError::Failed(
                "the picture shows no surface: --eye, --look-at, --fov or --crop miss the scene"
                    .to_owned(),
            ));
        }
        Ok((image, seconds))
    }

    /// Returns the statistics of errors.
    pub(super) fn errors(&self, errors: &RenderErrors<'_>, reference: &Image) -> Errors {
        Errors {
            report: errors.report(),
            squared: errors.squared_errors(),
            white_noise: reference.white_noise_variance(self.plan.n_points()),
        }
    }
}
