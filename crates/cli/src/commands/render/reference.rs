//! The reference image, from the cache or rendered.

use std::ops::Range;
use std::path::{Path, PathBuf};

use sphvar_integrands::Heuristic;
use sphvar_samplers::SquarePattern;
use sphvar_scene::{
    CropWindow, Density, DirectionPlan, Estimator, Image, View, WarpedPlan, render,
};

use super::RenderArgs;
use super::plan::Plan;
use super::reference_file::{ReferenceFile, Stored};
use super::rows::{append_below, is_complete, rows_of};
use super::stage::Stage;
use crate::error::CliError;
use crate::global::Global;
use crate::instruction_set::instruction_set;
use crate::memory::check_memory;
use crate::progress::Progress;
use crate::session::Session;
use crate::shards::Divided;

/// A reference image with this multiple of the number of directions is accurate enough: where
/// errors fall as N^-1.5, its error is 1 % of the picture's.
const SUFFICIENT_FACTOR: usize = 20;

/// The default minimum number of directions at each pixel, uniform ones and those of densities, which
/// take longer and have a smaller variance.
pub(super) const UNIFORM_DIRECTIONS: usize = 32768;
pub(super) const WARPED_DIRECTIONS: usize = 8192;

/// A requested reference image.
pub(super) struct Reference {
    plan: Plan,
    file: Option<ReferenceFile>,
    session: Session,
}

impl Reference {
    /// Checks the request. If the densities of the integral are known and `is_warped`, directions
    /// are drawn from them: uniform ones would have a larger error than the picture.
    pub(super) fn new(
        args: &RenderArgs,
        stage: &Stage,
        is_warped: bool,
        global: &Global,
    ) -> Result<Self, CliError> {
        let densities = if is_warped { stage.densities() } else { None };
        let (plan, kind) = match densities {
            None => {
                let n = args.reference_count.unwrap_or(UNIFORM_DIRECTIONS);
                (DirectionPlan::reference(n, global.seed).map(Plan::Uniform), "")
            }
            Some(densities) => {
                let n = args.reference_count.unwrap_or(WARPED_DIRECTIONS);
                (warped(densities, n, global.seed).map(Plan::Warped), " of densities")
            }
        };
        let plan = plan.map_err(|e| CliError::Usage(format!("--reference-count: {e}")))?;
        check_memory("--reference-count", plan.bytes())?;
        // Machines of another class may round differently.
        let description = format!(
            "program {} on {}\nseed {} directions {}{kind}\n{}",
            env!("CARGO_PKG_VERSION"),
            instruction_set(),
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
        Ok(Self { plan, file, session: global.session.clone() })
    }

    /// Returns the image, from the cache, rendered, or from merged parts.
    pub(super) fn image(&self, stage: &Stage) -> Result<Image, CliError> {
        self.image_of_run(stage)?.ok_or_else(Self::missing)
    }

    /// Returns the error of a merge whose files do not have the whole image.
    pub(super) fn missing() -> CliError {
        CliError::File("the files do not have all rows of the reference image".to_owned())
    }

    /// Returns the image; `None` if this run keeps only a part of its rows.
    pub(super) fn image_of_run(&self, stage: &Stage) -> Result<Option<Image>, CliError> {
        // Parts of a run are merged without the caches of machines.
        if self.session.tasks().is_merge() {
            return self.divided(stage, None);
        }
        let stored = self.file.as_ref().map_or(Stored::Missing, ReferenceFile::read);
        if let (Stored::Unusable, Some(file)) = (&stored, &self.file) {
            self.session.say(&format!(
                "{} is damaged; the reference image is rendered again",
                file.path().display()
            ));
        }
        let view = stage.view()?;
        let stored = match stored {
            Stored::Image(image) if is_complete(&image, view.region()) => Some(image),
            _ => None,
        };
        let is_stored = stored.is_some();
        let image = self.divided(stage, stored)?;
        if let (false, Some(file), Some(image)) = (is_stored, &self.file, &image) {
            // Without the cache the next run only takes longer.
            if let Err(error) = file.write(image) {
                self.session.say(&format!("the reference image cannot be stored: {error}"));
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
            self.session.say(&text);
        }
    }

    /// Returns the image, whose rows are divided among parts. They are those of `stored` if it is
    /// given.
    fn divided(&self, stage: &Stage, stored: Option<Image>) -> Result<Option<Image>, CliError> {
        let view = stage.view()?;
        let region = view.region();
        let work = region.width as f64 * self.plan.pixel_work();
        let count = region.height as u64;
        let rendered_work = if stored.is_some() { 0.0 } else { work * count as f64 };
        let progress = Progress::new(rendered_work, &self.session);
        progress.stage("reference image");
        let task = Divided { name: "reference image", count, work };
        let mut sets = None;
        let image = self.session.tasks().divided(task, &progress, append_below, |rows| {
            let rows = from_top(rows)?;
            if let Some(image) = &stored {
                return Ok(rows_of(image, rows));
            }
            let sets = match &mut sets {
                Some(sets) => sets,
                none => none.insert(self.plan.prepare(0).map_err(CliError::failed)?),
            };
            let view = view_of_rows(view, rows)?;
            let image = stage.with_integral(|integral| {
                render(&view, integral, Estimator::Ratio, &**sets, &progress)
            });
            image.map_err(CliError::failed)
        })?;
        match image {
            Some(image) if !is_complete(&image, region) => Err(Self::missing()),
            image => Ok(image),
        }
    }
}

/// Returns rows as indices.
fn from_top(rows: Range<u64>) -> Result<Range<usize>, CliError> {
    let index = |row| usize::try_from(row).map_err(CliError::failed);
    Ok(index(rows.start)?..index(rows.end)?)
}

/// Returns rows of a view, counted from the top of its region.
fn view_of_rows(view: View<'_>, rows: Range<usize>) -> Result<View<'_>, CliError> {
    let region = view.region();
    let (y, height) = (region.y + rows.start, rows.len());
    view.with_region(CropWindow { y, height, ..region }).map_err(CliError::failed)
}

/// Returns the plan of at least `n_points` jittered directions of densities.
fn warped(
    densities: Vec<(Density, f64)>,
    n_points: usize,
    seed: u64,
) -> Result<WarpedPlan, sphvar_scene::Error> {
    if n_points == 0 {
        let (name, range) = ("the number of directions", "at least 1");
        return Err(sphvar_scene::Error::Setting { name, range, got: 0.0 });
    }
    let pattern = SquarePattern::JitteredSquare;
    // Valid counts are squares; the next one for each density.
    let each = n_points.div_ceil(densities.len());
    let side = each.isqrt() + usize::from(each.isqrt().pow(2) < each);
    let n_points = side.saturating_mul(side).saturating_mul(densities.len());
    let plan = WarpedPlan::new(pattern, densities, n_points, Heuristic::Balance, seed)?;
    Ok(plan.into_reference())
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
