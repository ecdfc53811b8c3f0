//! Integrands against closed forms, quadrature and each other.

mod adaptive;
mod closed_forms;
mod every_integrand;
mod expansions;
mod expressions;
mod filtered;
mod fits;
mod ggx;
mod integrands;
mod kurtosis;
mod pictures;
mod products;
mod projections;
mod random_fields;
mod square;
mod supplied_functions;
mod warps;
