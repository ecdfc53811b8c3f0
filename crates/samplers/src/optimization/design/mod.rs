//! Spherical designs: sets of equal weights that integrate every polynomial up to a degree exactly
//! (Delsarte, Goethals and Seidel 1977).

mod counts;
mod dense;
mod equations;
mod jacobian;
mod matrix;
mod matrix_free;
mod products;
mod search;
mod start;
mod stored;

pub(crate) use counts::{default_count, equations_by_count, equations_of, valid_counts};
use dense::solve_dense;
pub(crate) use equations::{DesignEquations, Solved};
use matrix_free::solve_matrix_free;
pub(crate) use search::{design_points, expected_work};
