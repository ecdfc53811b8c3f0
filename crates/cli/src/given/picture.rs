//! Pictures that are given as arrays.

/// The texels of a picture, row by row from the top: one number each, or red, green and blue.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GivenPicture {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) channels: usize,
    pub(crate) texels: Vec<f64>,
}
