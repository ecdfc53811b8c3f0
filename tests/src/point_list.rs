use glam::DVec3;
use sphvar_spectrum::{Error, PointSets};

/// Point sets that a function makes, for ensembles that are no sampler's.
#[derive(Clone, Copy, Debug)]
pub struct PointList<F>(pub F);

impl<F: Fn(u64) -> Vec<DVec3> + Sync> PointSets for PointList<F> {
    fn realize_into(
        &self,
        index: u64,
        points: &mut Vec<DVec3>,
        weights: &mut Vec<f64>,
    ) -> Result<(), Error> {
        weights.clear();
        *points = (self.0)(index);
        Ok(())
    }
}
