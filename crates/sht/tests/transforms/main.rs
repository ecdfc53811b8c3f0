//! Comparison of the transforms with their definition, and identities between them.

mod accuracy;
mod adjointness;
mod batches;
mod coefficients;
mod crowds;
mod definition;
mod double;
mod fit;
mod fit_errors;
mod gradients;
mod hostile;
mod legendre;
mod points;
mod quadrature;
mod rotations;
mod synthesis;
mod threads;
mod weights;
