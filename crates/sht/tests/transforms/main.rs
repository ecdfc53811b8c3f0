//! The transforms against their definition, and the identities that tie them together.

mod accuracy;
mod adjointness;
mod batches;
mod coefficients;
mod crowds;
mod definition;
mod double;
mod gradients;
mod hostile;
mod legendre;
mod points;
mod rotations;
mod synthesis;
mod weights;
