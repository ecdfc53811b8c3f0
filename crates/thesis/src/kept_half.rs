use glam::DVec3;
use sphvar_samplers::Realizations;
use sphvar_spectrum::{Error, PointSets};

/// The points at z >= 0 of each set.
pub(crate) struct KeptHalf<'a>(pub(crate) Realizations<'a>);

impl PointSets for KeptHalf<'_> {
    fn realize_into(
        &self,
        index: u64,
        points: &mut Vec<DVec3>,
        weights: &mut Vec<f64>,
    ) -> Result<(), Error> {
        weights.clear();
        self.0.realize_into(index, points)?;
        points.retain(|p| p.z >= 0.0);
        Ok(())
    }
}
