//! Compares the fast transforms with their definitions on difficult inputs, and both with closed
//! forms.

mod adjointness;
mod circle;
mod complex;
mod definition;
mod errors;
mod evaluation;
mod hostile;
mod input;
mod single;
