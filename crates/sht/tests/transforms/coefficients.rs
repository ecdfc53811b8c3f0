//! Norms, products and samples of coefficients.

use num_complex::Complex;
use sphvar_sh::Alm;

use crate::points::Lcg;

/// The relative accuracy of the exact transforms.
///
/// `e^{-i phi}` from a root and a quotient is right to 2/3 EPSILON (as random directions show), its power m to
/// m times that and the roundings of the products, which mostly cancel; so is the Legendre function of degree
/// l to a part of l EPSILON. Sums and constants add the rest.
pub(crate) fn rounding(lmax: usize) -> f64 {
    f64::EPSILON * (lmax as f64 + 32.0)
}

/// Coefficients of a real function, independent and of mean square 1/3 in either part.
pub(crate) fn random(lmax: usize, rng: &mut Lcg) -> Alm {
    let mut alm = Alm::zeros(lmax).unwrap();
    for m in 0..=lmax {
        for a in alm.column_mut(m) {
            *a = Complex::new(rng.signed(), if m == 0 { 0.0 } else { rng.signed() });
        }
    }
    alm
}

/// The coefficients times a number.
pub(crate) fn scaled(alm: &Alm, factor: f64) -> Alm {
    let values = alm.values().iter().map(|a| a * factor).collect();
    Alm::from_values(alm.lmax(), values).unwrap()
}

/// The norm over orders of both signs.
pub(crate) fn norm(alm: &Alm) -> f64 {
    alm.energy_per_degree().iter().sum::<f64>().sqrt()
}

/// `||a - b||`.
pub(crate) fn distance(a: &Alm, b: &Alm) -> f64 {
    assert_eq!(a.lmax(), b.lmax(), "coefficients of one lmax");
    let differences = a.values().iter().zip(b.values()).map(|(a, b)| a - b).collect();
    norm(&Alm::from_values(a.lmax(), differences).unwrap())
}

/// `integral f g` of the real functions: `sum conj(a_lm) b_lm` over orders of both signs.
pub(crate) fn product(a: &Alm, b: &Alm) -> f64 {
    let orders = (0..=a.lmax()).map(|m| {
        let copies = if m == 0 { 1.0 } else { 2.0 };
        let terms = a.column(m).iter().zip(b.column(m)).map(|(a, b)| a.re * b.re + a.im * b.im);
        copies * terms.sum::<f64>()
    });
    orders.sum()
}

/// Whether none of the values is NaN or infinite.
pub(crate) fn is_finite(alm: &Alm) -> bool {
    alm.values().iter().all(|a| a.is_finite())
}
