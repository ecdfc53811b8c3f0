//! The plan of the directions of a sampler.

use sphvar_scene::{DirectionMode, DirectionPlan, Directions, Error, WarpedPlan, pixel_work};

/// The assignment of directions to hit points.
#[derive(Debug)]
pub(super) enum Plan {
    Uniform(DirectionPlan),
    Warped(WarpedPlan),
}

impl Plan {
    /// Returns the number of directions at each point.
    pub(super) fn n_points(&self) -> usize {
        match self {
            Self::Uniform(plan) => plan.n_points(),
            Self::Warped(plan) => plan.n_points(),
        }
    }

    /// Returns the number of sets that one render uses, 0 if every pixel has its own.
    pub(super) fn n_sets(&self) -> usize {
        match self {
            Self::Uniform(plan) => plan.n_sets(),
            Self::Warped(plan) => plan.n_sets(),
        }
    }

    /// Returns whether a render uses a table of several sets.
    pub(super) fn has_table(&self) -> bool {
        match self {
            Self::Uniform(plan) => plan.has_table(),
            Self::Warped(plan) => plan.has_table(),
        }
    }

    /// Returns the plan with tables of `n_sets` sets.
    pub(super) fn with_sets(self, n_sets: usize) -> Result<Self, Error> {
        Ok(match self {
            Self::Uniform(plan) => Self::Uniform(plan.with_sets(n_sets)?),
            Self::Warped(plan) => Self::Warped(plan.with_sets(n_sets)?),
        })
    }

    /// Returns the number of different sets in `renders` renders.
    pub(super) fn distinct_sets(&self, renders: u64) -> u64 {
        match self {
            Self::Uniform(plan) => plan.distinct_sets(renders),
            Self::Warped(plan) if plan.has_table() => renders.saturating_mul(plan.n_sets() as u64),
            Self::Warped(_) => 1,
        }
    }

    /// Returns the bytes of the sets of a render and of the threads.
    pub(super) fn bytes(&self) -> f64 {
        let direction = size_of::<glam::DVec3>() as f64;
        let threads = rayon::current_num_threads() as f64;
        match self {
            Self::Uniform(plan) => {
                direction * plan.set_points() as f64 * (plan.n_sets() as f64 + threads)
            }
            Self::Warped(plan) => {
                // Points of the square in the table, and directions with their weights.
                let of_table = size_of::<[f64; 2]>() as f64 * plan.n_sets() as f64;
                let of_threads = (direction + size_of::<f64>() as f64) * threads;
                plan.n_points() as f64 * (of_table + of_threads)
            }
        }
    }

    /// Returns the nominal work of the sets of a render.
    pub(super) fn table_work(&self) -> f64 {
        match self {
            Self::Uniform(plan) => {
                plan.n_sets() as f64 * plan.pattern().nominal_work(plan.set_points())
            }
            Self::Warped(plan) => plan.table_work(),
        }
    }

    /// Returns the nominal work of a pixel.
    pub(super) fn pixel_work(&self) -> f64 {
        let own = match self {
            Self::Uniform(plan) if plan.mode() == DirectionMode::Fresh => {
                plan.pattern().nominal_work(plan.n_points())
            }
            Self::Uniform(_) => 0.0,
            Self::Warped(plan) => plan.map_work(),
        };
        pixel_work(self.n_points()) + own
    }

    /// Returns the directions of one render.
    pub(super) fn prepare(&self, render: u64) -> Result<Box<dyn Directions>, Error> {
        Ok(match self {
            Self::Uniform(plan) => Box::new(plan.prepare(render)?),
            Self::Warped(plan) => Box::new(plan.prepare(render)?),
        })
    }
}
