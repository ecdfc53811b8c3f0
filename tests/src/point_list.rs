use glam::DVec3;
use sphvar_samplers::{Ensemble, Error, PointSet, Progress};

/// Point sets from a function, for ensembles without a sampler.
#[derive(Clone, Copy, Debug)]
pub struct PointList<F>(pub F);

impl<F: Fn(u64) -> Vec<DVec3> + Sync> Ensemble for PointList<F> {
    fn realize_into(&self, index: u64, set: &mut PointSet, _: &dyn Progress) -> Result<(), Error> {
        *set = PointSet::new((self.0)(index));
        Ok(())
    }
}
