use crate::reference::DoubleDouble;
use glam::DVec3;

use super::energies::exp;
use crate::spectra::{dot, unit};

/// Returns the variance of integrating a von Mises-Fisher lobe with one set of points under all
/// rotations, by a closed form for pairs of points, without spectra.
///
/// ```text
/// Var = ((4 pi/N)^2 sum_{k,j} G(s_k, s_j)) - 1,   G(x, y) = mean over rotations R of f(R x) f(R y)
///     = C^2 sinh(r)/r,   C = kappa/(4 pi sinh kappa),   r = kappa |x + y|
/// ```
///
/// (The product of two lobes is a lobe about the sum of their axes.) It is computed in twice the
/// working precision, since the subtraction of 1 loses up to ten digits.
pub(super) fn variance(points: &[DVec3], kappa: f64) -> DoubleDouble {
    let units: Vec<_> = points.iter().map(|p| unit(*p)).collect();
    let two = DoubleDouble::from(2.0);
    let kappa = DoubleDouble::from(kappa);
    let mut sum = DoubleDouble::ZERO;
    for (k, a) in units.iter().enumerate() {
        for b in &units[..k] {
            let together = [0, 1, 2].map(|i: usize| a[i] + b[i]);
            sum += two * scaled_mean(kappa * dot(together, together).sqrt(), kappa);
        }
        sum += scaled_mean(two * kappa, kappa);
    }
    // kappa^2/sinh^2 kappa, without the factor e^{-2 kappa}, which is included in the means.
    let shrunk = exp(-(two * kappa));
    let factor = two * kappa / (DoubleDouble::ONE - shrunk);
    let n = DoubleDouble::from(points.len() as f64);
    factor * factor * sum / (n * n) - DoubleDouble::ONE
}

/// Returns `e^{-2 kappa} sinh(r)/r`.
fn scaled_mean(r: DoubleDouble, kappa: DoubleDouble) -> DoubleDouble {
    let two = DoubleDouble::from(2.0);
    if r.value() < 1.0 {
        let mut term = exp(-(two * kappa));
        let mut sum = term;
        for k in 1_u64..15 {
            term = term * r * r / DoubleDouble::from(2 * k * (2 * k + 1));
            sum += term;
        }
        return sum;
    }
    exp(r - two * kappa) * (DoubleDouble::ONE - exp(-(two * r))) / (two * r)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::DVec3;

    use super::super::energies::of_lobe;
    use super::variance;

    /// One point: `4 pi int f^2 - 1` equals `4 pi sum_{l >= 1} E(l)`, by the addition theorem.
    #[test]
    fn one_point_and_antipodes() {
        let kappa = 1.5;
        let energies: Vec<f64> = of_lobe(kappa, 20).iter().map(|e| e.value()).collect();
        let one = variance(&[DVec3::Y], kappa).value();
        let expected = 4.0 * PI * energies[1..].iter().sum::<f64>();
        assert!((one / expected - 1.0).abs() < 1e-13, "{one}, not {expected}");
        let both = variance(&[DVec3::Y, DVec3::NEG_Y], kappa).value();
        let even = 4.0 * PI * energies.iter().skip(2).step_by(2).sum::<f64>();
        assert!((both / even - 1.0).abs() < 1e-13, "{both}, not {even}");
    }
}
