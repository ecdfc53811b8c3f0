//! Predictions and measurements against closed forms, pair sums and each other.

mod adaptive_predictions;
mod extreme_parameters;
mod fixed_orientation;
mod given_sets;
mod hostile_samplers;
mod integral_errors;
mod integrals;
mod joint_trials;
mod measured_intervals;
mod other_bands;
mod over_rotations;
mod predictions;
mod progressive;
mod rough_answers;
mod square;
mod sums;
mod tails;
mod warped;
