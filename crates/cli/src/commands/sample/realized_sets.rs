//! The realized sets of a pattern of any space, and their output.

use std::path::Path;

use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sphvar_samplers::PointSet;

use super::SampleArgs;
use super::kept_set::{KeptSet, RestoredSets, restored};
use crate::draws::{Draws, GivenSets};
use crate::error::CliError;
use crate::files::{AtomicFile, FilePoint, NumberedPath, write_points};
use crate::global::Global;
use crate::memory::check_memory;
use crate::plots::{ImageFormat, PlotError};
use crate::progress::Progress;
use crate::report::{Document, Provenance, is_stdout};
use crate::shards::Divided;

/// Realizations of a pattern: `sample --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SampleBody<C> {
    /// The sampler with its parameters.
    sampler: String,
    /// The number of points; the mean where it is random.
    n: usize,
    /// The number of sets.
    realizations: usize,
    /// No set has power at any degree from 1 to this, for patterns that are made so.
    #[serde(skip_serializing_if = "Option::is_none")]
    last_empty_degree: Option<usize>,
    /// The number of points of each set, where the pattern does not fix it.
    #[serde(skip_serializing_if = "Option::is_none")]
    counts: Option<Vec<usize>>,
    /// The unit vectors x, y, z of each set, or the points u, v of the square, unless they are
    /// written to a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<Vec<Vec<f64>>>>")]
    points: Option<Vec<Vec<C>>>,
    /// The weights of the points of each set, if they have weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    weights: Option<Vec<Vec<f64>>>,
}

/// Draws points with a title and notes into a file.
type DrawPoints<P> = fn(String, Vec<String>, &[P], &Path) -> Result<(), PlotError>;

/// Sets that are generated and written.
pub(super) struct RealizedSets<'a, P> {
    pub(super) draws: &'a Draws<P>,
    /// Draws points with a title and notes.
    pub(super) picture: DrawPoints<P>,
}

impl<P> RealizedSets<'_, P>
where
    P: FilePoint<Numbers: Send + Serialize + DeserializeOwned + Into<P>>,
{
    /// Generates the sets, and writes them to the file of `args` or to standard output. Returns whether
    /// they are written, which a run that keeps only a part of them does not do.
    ///
    /// # Errors
    ///
    /// If a set cannot be generated, the sets exceed the memory or a file cannot be written.
    pub(super) fn write(self, args: &SampleArgs, global: &Global) -> Result<bool, CliError> {
        let draws = self.draws;
        let (realizations, given) = match (args.realizations, draws.n_given()) {
            (None, Some(n_given)) => (n_given, GivenSets::InOrder),
            (realizations, _) => (realizations.unwrap_or(1), GivenSets::Drawn),
        };
        let numbered = NumberedPath::of(&args.out);
        let first_and_last = numbered.map_or(vec![args.out.clone()], |numbered| {
            vec![numbered.path(0), numbered.path(realizations - 1)]
        });
        for path in first_and_last {
            AtomicFile::check(&path)?;
        }
        let n_points = draws.n_points();
        let of_run = (realizations as u64).div_ceil(global.session.tasks().part().parts);
        let total = (size_of::<P>() * n_points) as f64 * of_run as f64;
        check_memory(&format!("{of_run} sets of {n_points} points"), total)?;
        let Some((numbers, sets)) = self.realize(realizations as u64, given, global)? else {
            return Ok(false);
        };
        let realizations = sets.len();
        let provenance = Provenance::new(&global.session, global.seed);
        let line = provenance.line();
        let note = draws.remark.as_ref().map_or(line.clone(), |remark| format!("{line}; {remark}"));
        let to_stdout = is_stdout(&args.out);
        if let Some(numbered) = numbered {
            for (&number, set) in numbers.iter().zip(&sets) {
                self.write_sets(&numbered.path(number), std::slice::from_ref(set), &note)?;
            }
        } else if !(to_stdout && global.json) {
            if ImageFormat::of_path(&args.out).is_some() && realizations > 1 {
                global.session.say("the picture shows the first realization");
            }
            self.write_sets(&args.out, &sets, &note)?;
        }
        if global.json {
            let coordinates = |set: &PointSet<P>| set.points.iter().map(P::numbers).collect();
            let points = to_stdout.then(|| sets.iter().map(coordinates).collect());
            let is_weighted = sets.iter().any(|set| !set.weights.is_empty());
            let weights = (to_stdout && is_weighted)
                .then(|| sets.iter().map(|set| set.weights.clone()).collect());
            let counts: Vec<usize> = sets.iter().map(PointSet::len).collect();
            let counts =
                Some(counts).filter(|counts| counts.iter().any(|&count| count != n_points));
            let body = SampleBody {
                sampler: draws.sampler.clone(),
                n: n_points,
                realizations,
                last_empty_degree: draws.last_empty_degree,
                counts,
                points,
                weights,
            };
            Document::new(&body, &provenance).print(&global.session)?;
        }
        Ok(true)
    }

    /// Returns the sets and their numbers, from 0; `None` if this run keeps only a part of them.
    fn realize(
        &self,
        count: u64,
        given: GivenSets,
        global: &Global,
    ) -> Result<Option<RestoredSets<P>>, CliError> {
        let draws = self.draws;
        let work = if given == GivenSets::InOrder { 0.0 } else { draws.nominal_work() };
        let progress = Progress::with_expected_time(count as f64 * work, &global.session);
        progress.stage(&draws.label);
        let realize = |number| {
            let mut set = PointSet::default();
            draws.realize_into(number, given, &mut set, &progress).map_err(CliError::failed)?;
            Ok(KeptSet::new(number, set))
        };
        let append = |sets: &mut Vec<_>, others: Vec<_>| {
            sets.extend(others);
            Ok(())
        };
        let task = Divided { name: &draws.sampler, count, work };
        let sets = global.session.tasks().divided(task, &progress, append, |numbers| {
            numbers.into_par_iter().map(realize).collect::<Result<Vec<_>, CliError>>()
        })?;
        sets.map(|sets| restored(sets, count)).transpose()
    }

    /// Writes all sets, or a picture of the first one.
    fn write_sets(&self, path: &Path, sets: &[PointSet<P>], note: &str) -> Result<(), CliError> {
        if ImageFormat::of_path(path).is_none() {
            return Ok(write_points(path, None, sets, Some(note))?);
        }
        let title = format!("{}, N = {}", self.draws.label, sets[0].len());
        Ok((self.picture)(title, vec![note.to_owned()], &sets[0].points, path)?)
    }
}
