//! Grids that find points near a given one.

mod chains;
mod cube_grid;
mod grid;
mod separation;
mod square_grid;
mod toroidal_separation;

pub(crate) use cube_grid::CubeGrid;
pub(crate) use grid::Grid;
pub use separation::separation;
pub(crate) use square_grid::SquareGrid;
pub use toroidal_separation::toroidal_separation;
