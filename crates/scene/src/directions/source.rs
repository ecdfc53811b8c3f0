use std::fmt::Debug;

use sphvar_samplers::PointSet;

use crate::{Error, ShadingPoint};

/// Directions for every hit point of a render: what [`render`](crate::render) samples an integral
/// by.
pub trait Directions: Debug + Sync {
    /// Returns the number of directions at a hit point, at least 1; for halves of sphere sets, the
    /// expected number.
    fn n_points(&self) -> usize;

    /// Replaces the content of `directions` by the directions of hit point `index` above its
    /// surface: unit vectors, with their weights if these differ. Returns the sums of weights that
    /// the estimators divide by.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Sampler`] if a set cannot be generated.
    fn directions_into(
        &self,
        at: &ShadingPoint<'_>,
        index: u64,
        directions: &mut PointSet,
    ) -> Result<SetWeight, Error>;

    /// Returns whether the directions are uniform on the hemisphere, for which estimates of the
    /// variance of independent directions are [`Image::spreads`](crate::Image::spreads).
    fn is_uniform(&self) -> bool;

    /// Returns the nominal work of a hit point beyond that of its rays. Default: 0.
    fn own_work(&self) -> f64 {
        0.0
    }
}

/// The sums of weights by which the two [`Estimator`](crate::Estimator)s divide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetWeight {
    /// The sum over the directions of this hit point.
    pub visible: f64,
    /// Its expected value.
    pub expected: f64,
}
