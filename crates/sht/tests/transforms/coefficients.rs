//! Norms, products and random samples of coefficients.

use num_complex::Complex;
use sphvar_sh::Alm;

use crate::points::Lcg;

/// Returns the relative accuracy of the exact transforms.
///
/// `e^{-i phi}`, computed by a square root and a quotient, has an error of 2/3 EPSILON (measured
/// for random directions). Its power m has m times that error and the rounding errors of the
/// products, which mostly cancel. The Legendre function of degree l has an error of a fraction of l
/// EPSILON. Sums and constants contribute the rest.
pub(crate) fn rounding(lmax: usize) -> f64 {
    f64::EPSILON * (lmax as f64 + 32.0)
}

/// Returns coefficients of a real function, independent and with mean square 1/3 in each part.
pub(crate) fn random(lmax: usize, rng: &mut Lcg) -> Alm {
    let mut alm = Alm::zeros(lmax).unwrap();
    for m in 0..=lmax {
        for a in alm.column_mut(m) {
            *a = Complex::new(rng.signed(), if m == 0 { 0.0 } else { rng.signed() });
        }
    }
    alm
}

/// Returns the coefficients multiplied by a number.
pub(crate) fn scaled(alm: &Alm, factor: f64) -> Alm {
    let values = alm.values().iter().map(|a| a * factor).collect();
    Alm::from_values(alm.lmax(), values).unwrap()
}

/// Returns the norm over orders of both signs.
pub(crate) fn norm(alm: &Alm) -> f64 {
    alm.energy_per_degree().iter().sum::<f64>().sqrt()
}

/// Returns `||a - b||`.
pub(crate) fn distance(a: &Alm, b: &Alm) -> f64 {
    assert_eq!(a.lmax(), b.lmax(), "coefficients with the same lmax");
    let differences = a.values().iter().zip(b.values()).map(|(a, b)| a - b).collect();
    norm(&Alm::from_values(a.lmax(), differences).unwrap())
}

/// Returns `integral f g` of real functions: `sum conj(a_lm) b_lm` over orders of both signs.
pub(crate) fn product(a: &Alm, b: &Alm) -> f64 {
    let orders = (0..=a.lmax()).map(|m| {
        let copies = if m == 0 { 1.0 } else { 2.0 };
        let terms = a.column(m).iter().zip(b.column(m)).map(|(a, b)| a.re * b.re + a.im * b.im);
        copies * terms.sum::<f64>()
    });
    orders.sum()
}

/// Returns whether all values are finite.
pub(crate) fn is_finite(alm: &Alm) -> bool {
    alm.values().iter().all(|a| a.is_finite())
}
