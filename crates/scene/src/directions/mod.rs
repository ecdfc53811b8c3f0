//! Direction sets for each shading point.

pub(crate) mod frame;
pub(crate) mod mode;
pub(crate) mod plan;
pub(crate) mod sets;
