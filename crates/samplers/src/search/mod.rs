//! Grids that find points near a direction.

mod cube_grid;
mod grid;
mod separation;
mod toroidal_separation;

pub(crate) use cube_grid::CubeGrid;
pub(crate) use grid::Grid;
pub use separation::separation;
pub use toroidal_separation::toroidal_separation;
