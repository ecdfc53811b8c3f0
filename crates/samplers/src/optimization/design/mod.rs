//! Spherical designs: sets of equal weights that integrate every polynomial up to a degree exactly
//! (Delsarte, Goethals and Seidel 1977).

mod equations;
mod matrix_free;
mod start;

pub(crate) use equations::{DesignEquations, Solved};
