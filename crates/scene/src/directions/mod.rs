//! Direction sets for each shading point.

pub(crate) mod coverage;
pub(crate) mod density;
pub(crate) mod frame;
pub(crate) mod light_warp;
pub(crate) mod mode;
pub(crate) mod plan;
pub(crate) mod sets;
pub(crate) mod shading_point;
pub(crate) mod source;
pub(crate) mod warped_plan;
pub(crate) mod warped_sets;
