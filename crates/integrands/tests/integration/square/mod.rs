//! Integrands on the square against quadrature, closed forms and each other.

mod adaptive;
mod cases;
mod energies;
mod extremes;
mod grammar;
mod pulled_back;
mod pulled_back_statistics;
mod sums;
mod variation;
