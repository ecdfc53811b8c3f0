//! Patterns of the unit square, and the maps from the square to directions.

mod cosine_hemisphere;
mod jittered_square;
mod on_sphere;
pub(crate) mod radical_inverse;
mod square_pattern;
mod white_square;

pub use cosine_hemisphere::CosineHemisphere;
pub use jittered_square::JitteredSquare;
pub use on_sphere::OnSphere;
pub use square_pattern::SquarePattern;
pub use white_square::WhiteSquare;
