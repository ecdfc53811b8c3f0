//! Pictures of a scene and their errors.

pub(crate) mod camera;
pub(crate) mod cornell;
pub(crate) mod crop_window;
pub(crate) mod estimate;
pub(crate) mod estimator;
pub(crate) mod image;
pub(crate) mod integral;
pub(crate) mod picture_bias;
pub(crate) mod render;
pub(crate) mod render_errors;
pub(crate) mod view;
