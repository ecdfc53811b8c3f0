//! Integrands on the square against quadrature, closed forms and each other.

mod adaptive;
mod cases;
mod energies;
mod extremes;
mod grammar;
mod sums;
mod variation;
