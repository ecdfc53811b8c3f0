use std::f64::consts::TAU;

use num_complex::Complex;

/// Returns `exp(2 pi i t)`, periodic in t to the last digit.
pub(super) fn cis_turns(t: f64) -> Complex<f64> {
    Complex::cis(TAU * (t - t.round()))
}

/// Returns `cos(2 pi t)`, periodic in t to the last digit.
pub(super) fn cos_turns(t: f64) -> f64 {
    (TAU * (t - t.round())).cos()
}

/// Returns `sin(pi x)/(pi x)`, which is 0 at every other integer.
pub(super) fn sinc(x: f64) -> f64 {
    let pi = std::f64::consts::PI;
    if x == 0.0 {
        return 1.0;
    }
    let nearest = x.round();
    let sin = (pi * (x - nearest)).sin();
    // sin(pi x) = cos(pi n) sin(pi (x - n)).
    let is_odd = nearest.rem_euclid(2.0) > 0.5;
    (if is_odd { -sin } else { sin }) / (pi * x)
}
