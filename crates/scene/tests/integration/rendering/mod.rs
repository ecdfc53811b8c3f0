//! Pictures: integrals at points where they are known in closed form, the direction modes,
//! determinism and the errors of pictures.

mod determinism;
mod errors_of_pictures;
mod exact_values;
mod modes;
mod random_errors;
mod spot;
mod warped;
mod warped_lights;
mod weighted_sets;
