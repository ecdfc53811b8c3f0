use crate::reference::DoubleDouble;

use crate::spectra::legendre;

fn number(n: usize) -> DoubleDouble {
    DoubleDouble::from(n as f64)
}

/// Returns the energies `E(l) = pi (P_{l-1}(c) - P_{l+1}(c))^2/(2l+1)`, l = 0 ..= lmax, of the cap
/// of `degrees`; `P_{-1}` is 1. The f64 of the angle in radians from the nearer pole is taken as an
/// exact number, since an angle near pi would lose the digits of its difference from pi.
///
/// Valid for angles of 1 to 179 degrees; beyond, the difference cancels.
pub(super) fn of_cap(degrees: f64, lmax: usize) -> Vec<DoubleDouble> {
    let (_, cos) = DoubleDouble::from(degrees.min(180.0 - degrees).to_radians()).sin_cos();
    let cos = if degrees > 90.0 { -cos } else { cos };
    let values: Vec<_> =
        std::iter::once(DoubleDouble::ONE).chain(legendre(cos).take(lmax + 2)).collect();
    let energy = |l: usize| {
        let step = values[l] - values[l + 2];
        DoubleDouble::pi() * step * step / number(2 * l + 1)
    };
    (0..=lmax).map(energy).collect()
}

/// Returns the energies of a cap for small `lmax * angle`, by the series of `int_c^1 P_l` about the
/// pole:
///
/// ```text
/// E(l) = pi (2l+1) (2 s sum_k t_k/(k+1))^2,   s = sin^2(angle/2)
/// t_0 = 1,   t_{k+1} = -t_k (l-k)(l+k+1) s/(k+1)^2
/// ```
pub(super) fn of_small_cap(angle: f64, lmax: usize) -> Vec<DoubleDouble> {
    // Halving an f64 is exact.
    let (half_sin, _) = DoubleDouble::from(0.5 * angle).sin_cos();
    let s = half_sin * half_sin;
    let energy = |l: usize| {
        let (mut term, mut sum) = (DoubleDouble::ONE, DoubleDouble::ZERO);
        for k in 0..=l.min(40) {
            sum += term / number(k + 1);
            let ratio = number(l - k) * number(l + k + 1) * s / number((k + 1) * (k + 1));
            term = -(term * ratio);
        }
        let mean = number(2) * s * sum;
        DoubleDouble::pi() * number(2 * l + 1) * mean * mean
    };
    (0..=lmax).map(energy).collect()
}

/// Returns the energies `(2l+1)/(4 pi) A_l^2` of the von Mises-Fisher lobe, l = 0 ..= lmax.
///
/// ```text
/// A_l = i_l/i_0,   i_l = kappa^l/(2l+1)!! (1 + sum_{k >= 1} (kappa^2/2)^k/(k! (2l+3) (2l+5) ... (2l+2k+1)))
/// A_0 = 1,   A_1 = coth(kappa) - 1/kappa,   A_{l+1} = A_{l-1} - (2l+1)/kappa A_l
/// ```
///
/// For kappa up to 200 the series is used, all of whose terms are positive. For larger kappa the
/// upward recurrence is used: it magnifies errors by about `e^{l^2/kappa}`, so of 31 digits 15
/// remain at l^2 = 36 kappa.
pub(super) fn of_lobe(kappa: f64, lmax: usize) -> Vec<DoubleDouble> {
    let ratios = if kappa <= 200.0 { by_series(kappa, lmax) } else { upwards(kappa, lmax) };
    let four_pi = DoubleDouble::from(4.0) * DoubleDouble::pi();
    let energy = |(l, a): (usize, DoubleDouble)| number(2 * l + 1) * a * a / four_pi;
    ratios.into_iter().enumerate().map(energy).collect()
}

fn by_series(kappa: f64, lmax: usize) -> Vec<DoubleDouble> {
    const TERMS: usize = 500;
    let k = DoubleDouble::from(kappa);
    let half_square = k * k / number(2);
    let sum = |l: usize| {
        let (mut term, mut sum) = (DoubleDouble::ONE, DoubleDouble::ONE);
        for j in 1..=TERMS {
            term = term * half_square / number(j * (2 * l + 2 * j + 1));
            sum += term;
        }
        sum
    };
    let (mut front, first) = (DoubleDouble::ONE, sum(0));
    let ratio = |l: usize| {
        let ratio = front * sum(l) / first;
        front = front * k / number(2 * l + 3);
        ratio
    };
    (0..=lmax).map(ratio).collect()
}

fn upwards(kappa: f64, lmax: usize) -> Vec<DoubleDouble> {
    let k = DoubleDouble::from(kappa);
    // coth(200) is 1 to 170 digits.
    let mut pair = (DoubleDouble::ONE, DoubleDouble::ONE - DoubleDouble::ONE / k);
    let ratio = |l: usize| {
        let (value, next) = pair;
        pair = (next, value - number(2 * l + 3) / k * next);
        value
    };
    (0..=lmax).map(ratio).collect()
}

/// Returns `e^x` by the Taylor series at a 1024th of `|x|` and ten squarings of `e^x - 1`; about 28
/// digits to |x| = 1000.
pub(super) fn exp(x: DoubleDouble) -> DoubleDouble {
    const SQUARINGS: u64 = 10;
    if x < DoubleDouble::ZERO {
        return DoubleDouble::ONE / exp(-x);
    }
    let t = x / DoubleDouble::from(2.0).power(SQUARINGS);
    let (mut term, mut less_one) = (DoubleDouble::ONE, DoubleDouble::ZERO);
    for k in 1..=60 {
        term = term * t / number(k);
        less_one += term;
    }
    for _ in 0..SQUARINGS {
        less_one = less_one * (less_one + DoubleDouble::from(2.0));
    }
    less_one + DoubleDouble::ONE
}

#[cfg(test)]
mod tests {
    use crate::reference::DoubleDouble;

    use super::{by_series, exp, of_cap, of_lobe, of_small_cap, upwards};

    #[test]
    fn exponentials_have_twice_the_digits() {
        for x in [-500.0, -50.0, -1.0, 1e-20, 0.7, 30.0] {
            let half = exp(DoubleDouble::from(0.5 * x));
            let one = half * half * exp(DoubleDouble::from(-x));
            assert!((one - DoubleDouble::ONE).value().abs() < 1e-26, "{x}");
            let got = exp(DoubleDouble::from(x)).value();
            assert!((got - x.exp()).abs() <= 2.0 * f64::EPSILON * x.exp(), "{x}: {got}");
        }
    }

    /// Two independent formulas where both are valid, and the hemisphere by hand.
    #[test]
    fn caps_by_both_formulas() {
        let (a, b) = (of_cap(30.0, 20), of_small_cap(30f64.to_radians(), 20));
        for (l, (a, b)) in a.into_iter().zip(b).enumerate() {
            assert!(((a - b) / b).value().abs() < 1e-23, "l = {l}");
        }
        let half = of_cap(90.0, 3);
        for (energy, expected) in half.into_iter().zip([1.0, 0.75, 0.0, 7.0 / 64.0]) {
            let got = (energy / DoubleDouble::pi()).value();
            assert!((got - expected).abs() < 1e-15, "{got}, not {expected}");
        }
    }

    #[test]
    fn lobes_by_both_formulas() {
        // The upward recurrence loses a factor of e^(900/200) of its 31 digits.
        for (l, (a, b)) in by_series(200.0, 30).into_iter().zip(upwards(200.0, 30)).enumerate() {
            assert!(((a - b) / a).value().abs() < 1e-24, "l = {l}");
        }
    }

    /// `A_2 = 1 - 3 A_1/kappa`, and a very narrow lobe has `A_l = e^{-l(l+1)/(2 kappa)}`.
    #[test]
    fn lobes_at_both_ends() {
        let one = of_lobe(1.0, 2);
        let a1 = 1.0 / 1f64.tanh() - 1.0;
        let expected = 5.0 * (1.0 - 3.0 * a1).powi(2) / (4.0 * std::f64::consts::PI);
        assert!((one[2].value() / expected - 1.0).abs() < 1e-13);
        let narrow = of_lobe(1e6, 10)[10].value() * 4.0 * std::f64::consts::PI / 21.0;
        assert!((narrow.ln() + 110.0 / 1e6).abs() < 1e-9, "{narrow}");
    }
}
