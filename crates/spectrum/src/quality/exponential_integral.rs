use std::f64::consts::PI;

use libm::erfc;

/// Euler's constant.
pub(super) const EULER_GAMMA: f64 = 0.577_215_664_901_532_860_6;

/// Series are used below this number: beyond it they cancel, and the continued fraction converges.
const SMALL: f64 = 0.5;

/// The generalized exponential integrals `E_nu(x) = int_1^inf y^-nu exp(-x y) dy` of one x > 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExponentialIntegrals {
    /// nu = 0, 1, 2, ...
    whole: [f64; Self::ORDERS],
    /// nu = 1/2, 3/2, 5/2, ...
    half: [f64; Self::ORDERS],
}

impl ExponentialIntegrals {
    /// The number of orders of each kind.
    const ORDERS: usize = 13;

    /// Returns the integrals to a few units in the last place of the larger of value and `exp(-x)`.
    ///
    /// # References
    ///
    /// DLMF 8.19.12 (recurrence), 6.6.2 (series of `E_1`), 8.19.17 (continued fraction).
    pub(super) fn new(x: f64) -> Self {
        let decay = (-x).exp();
        if x >= SMALL {
            return Self {
                whole: std::array::from_fn(|n| decay * fraction(n as f64, x)),
                half: std::array::from_fn(|n| decay * fraction(n as f64 + 0.5, x)),
            };
        }
        let mut whole = [decay / x; Self::ORDERS];
        whole[1] = first(x);
        for n in 2..Self::ORDERS {
            whole[n] = (decay - x * whole[n - 1]) / (n as f64 - 1.0);
        }
        let mut half = [(PI / x).sqrt() * erfc(x.sqrt()); Self::ORDERS];
        for n in 1..Self::ORDERS {
            half[n] = (decay - x * half[n - 1]) / (n as f64 - 0.5);
        }
        Self { whole, half }
    }

    /// Returns `E_nu` for `twice_nu = 2 nu` below 26.
    pub(super) fn of(&self, twice_nu: usize) -> f64 {
        if twice_nu.is_multiple_of(2) { self.whole[twice_nu / 2] } else { self.half[twice_nu / 2] }
    }
}

/// Returns `E_1(x)` for any x > 0.
pub(super) fn first(x: f64) -> f64 {
    if x >= SMALL {
        return (-x).exp() * fraction(1.0, x);
    }
    let mut term = 1.0;
    let mut sum = 0.0;
    for k in 1..25 {
        let k = f64::from(k);
        term *= -x / k;
        sum -= term / k;
    }
    sum - EULER_GAMMA - x.ln()
}

/// Returns `exp(x) E_nu(x)` for x >= 1/2 by its continued fraction, from its end: unlike products
/// of convergents, this does not accumulate rounding errors.
fn fraction(nu: f64, x: f64) -> f64 {
    // The error of n terms is about exp(-4 sqrt(n x)).
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 10 to 250")]
    let n = (10.0 + 120.0 / x) as u32;
    let tail = (1..=n)
        .rev()
        .map(f64::from)
        .fold(0.0, |tail, i| -i * (nu - 1.0 + i) / (x + nu + 2.0 * i + tail));
    1.0 / (x + nu + tail)
}

#[cfg(test)]
mod tests {
    use sphvar_sh::GaussLegendre;

    use super::ExponentialIntegrals;

    /// The reference is quadrature in ln y, where the integrand is smooth.
    #[test]
    fn integrals_match_quadrature() {
        let rule = GaussLegendre::new(400).unwrap();
        for x in [1e-9, 1e-3, 0.3, 0.499, 0.5, 1.0, 1.7, 6.0, 40.0] {
            let integrals = ExponentialIntegrals::new(x);
            // Beyond it the integrand is below 1e-22 of its maximum.
            let end = f64::ln(1.0 + 50.0 / x);
            for twice_nu in 0..26 {
                let nu = 0.5 * twice_nu as f64;
                let expected = rule.integrate(0.0, end, |s| ((1.0 - nu) * s - x * s.exp()).exp());
                let got = integrals.of(twice_nu);
                let tolerance = 2e-15 * (expected.abs() + (-x).exp());
                assert!((got - expected).abs() < tolerance, "E_{nu}({x}): {got}, {expected}");
            }
        }
    }
}
