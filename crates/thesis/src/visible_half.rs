use sphvar_samplers::{Ensemble, Error, PointSet, Progress, Realizations};

/// An ensemble of the visible halves of sets: the points with z >= 0.
pub(crate) struct VisibleHalf<'a>(pub(crate) Realizations<'a>);

impl Ensemble for VisibleHalf<'_> {
    fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        self.0.realize_into(index, set, progress)?;
        set.points.retain(|p| p.z >= 0.0);
        Ok(())
    }
}
