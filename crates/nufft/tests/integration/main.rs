//! Compares the fast transforms with their definitions on difficult inputs, and both with closed
//! forms.

mod adjointness;
mod circle;
mod coefficients;
mod complex;
mod definition;
mod errors;
mod evaluation;
mod hostile;
mod input;
mod parts;
mod portable;
mod single;
