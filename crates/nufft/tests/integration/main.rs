//! Compares the fast transforms with their definitions on difficult inputs, and both with closed
//! forms.

mod circle;
mod definition;
mod input;
