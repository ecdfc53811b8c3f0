//! Grids that find points near a direction.

mod cube_grid;
mod grid;

pub(crate) use cube_grid::CubeGrid;
pub(crate) use grid::Grid;
