//! The reference image, from the cache or rendered.

use std::path::{Path, PathBuf};

use sphvar_scene::{DirectionPlan, Estimator, Image, pixel_work, render};

use super::RenderArgs;
use super::reference_file::{ReferenceFile, Stored};
use super::stage::Stage;
use crate::error::CliError;
use crate::global::Global;
use crate::memory::check_memory;
use crate::progress::Progress;
use crate::report::say;

/// A reference image with this multiple of the number of directions is accurate enough: where
/// errors fall as N^-1.5, its error is 1 % of the picture's.
const SUFFICIENT_FACTOR: usize = 20;

/// A requested reference image.
pub(super) struct Reference {
    plan: DirectionPlan,
    file: Option<ReferenceFile>,
    quiet: bool,
}

impl Reference {
    /// Checks the request.
    pub(super) fn new(args: &RenderArgs, stage: &Stage, global: &Global) -> Result<Self, CliError> {
        let plan = DirectionPlan::reference(args.reference_count, global.seed)
            .map_err(|e| CliError::Usage(format!("--reference-count: {e}")))?;
        let directions = size_of::<glam::DVec3>() as f64 * plan.n_points() as f64;
        let at_once = plan.n_sets() as f64 + rayon::current_num_threads() as f64;
        check_memory("--reference-count", directions * at_once)?;
        let description = format!(
            "program {}\nseed {} directions {}\n{}",
            env!("CARGO_PKG_VERSION"),
            global.seed,
            plan.n_points(),
            stage.description
        );
        let folder = match &args.cache {
            Some(folder) if folder.as_os_str() == "none" => None,
            Some(folder) => Some(folder.clone()),
            None => user_cache(),
        };
        let file = folder.map(|folder| ReferenceFile::new(&folder, &description));
        Ok(Self { plan, file, quiet: global.quiet })
    }

    /// Returns the image, from the cache or rendered.
    pub(super) fn image(&self, stage: &Stage) -> Result<Image, CliError> {
        if let Some(file) = &self.file {
            match file.read() {
                Stored::Image(image) => return Ok(image),
                Stored::Missing => (),
                Stored::Unusable => say(
                    self.quiet,
                    &format!(
                        "{} is damaged; the reference image is rendered again",
                        file.path().display()
                    ),
                ),
            }
        }
        let image = self.make(stage)?;
        if let Some(file) = &self.file {
            // Without the cache the next run only takes longer.
            if let Err(error) = file.write(&image) {
                say(self.quiet, &format!("the reference image cannot be stored: {error}"));
            }
        }
        Ok(image)
    }

    /// Prints a remark if the reference image is not much more accurate than one of `n_points`
    /// directions.
    pub(super) fn remark(&self, n_points: usize) {
        if n_points.saturating_mul(SUFFICIENT_FACTOR) > self.plan.n_points() {
            let text = format!(
                "the error of the reference image ({} directions) is not negligible beside that of {n_points} \
                 directions; increase --reference-count",
                self.plan.n_points()
            );
            say(self.quiet, &text);
        }
    }

    fn make(&self, stage: &Stage) -> Result<Image, CliError> {
        let view = stage.view()?;
        let n_pixels = view.region().width * view.region().height;
        let work = n_pixels as f64 * pixel_work(self.plan.n_points());
        let progress = Progress::new(work, self.quiet);
        progress.stage("reference image");
        let sets = self.plan.prepare(0).map_err(CliError::failed)?;
        stage
            .with_integral(|integral| render(&view, integral, Estimator::Ratio, &sets, &progress))
            .map_err(CliError::failed)
    }
}

/// Returns the folder `sphvar` in the user's cache, if the system names one.
fn user_cache() -> Option<PathBuf> {
    let folder = |name: &str| {
        let value = std::env::var_os(name)?;
        Path::new(&value).is_absolute().then(|| PathBuf::from(value))
    };
    let caches = folder("XDG_CACHE_HOME").or_else(|| Some(folder("HOME")?.join(".cache")))?;
    Some(caches.join("sphvar"))
}
