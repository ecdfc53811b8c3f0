use crate::reference::DoubleDouble;
use glam::DVec3;

/// Normalizes a direction in twice the working precision.
pub(crate) fn unit(p: DVec3) -> [DoubleDouble; 3] {
    let p = p.to_array().map(DoubleDouble::from);
    let length = dot(p, p).sqrt();
    p.map(|x| x / length)
}

pub(crate) fn dot(a: [DoubleDouble; 3], b: [DoubleDouble; 3]) -> DoubleDouble {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns an infinite iterator over the Legendre polynomials `P_0(x), P_1(x), ...`.
///
/// It uses `(l + 1) P_{l+1} = (2l + 1) x P_l - l P_{l-1}`; near x = 1 and -1 this loses a factor of
/// about l^2, which leaves 25 digits at degrees of some hundreds.
pub(crate) fn legendre(x: DoubleDouble) -> impl Iterator<Item = DoubleDouble> {
    let (mut below, mut value) = (DoubleDouble::ZERO, DoubleDouble::ONE);
    (0_u64..).map(move |l| {
        let number = |n: u64| DoubleDouble::from(n);
        let current = value;
        let next = (number(2 * l + 1) * x * value - number(l) * below) / number(l + 1);
        (below, value) = (value, next);
        current
    })
}

/// Returns `(1/N) sum_{k,j} P_l(s_k.s_j)` for l = 0 ..= lmax: the power per degree of one set, by
/// the addition theorem.
///
/// The norms of the points have no effect. Cost `O(N^2 lmax)`.
pub(crate) fn legendre_sums(points: &[DVec3], lmax: usize) -> Vec<DoubleDouble> {
    let units: Vec<_> = points.iter().map(|p| unit(*p)).collect();
    let mut sums = vec![DoubleDouble::ZERO; lmax + 1];
    for (k, a) in units.iter().enumerate() {
        for b in &units[..k] {
            for (sum, value) in sums.iter_mut().zip(legendre(dot(*a, *b))) {
                *sum += value;
            }
        }
    }
    let n = DoubleDouble::from(points.len() as f64);
    // Each pair counts twice, and each point once with itself.
    sums.into_iter().map(|sum| DoubleDouble::ONE + DoubleDouble::from(2.0) * sum / n).collect()
}

#[cfg(test)]
mod tests {
    use crate::reference::DoubleDouble;
    use glam::DVec3;
    use sphvar_sh::legendre_p;

    use super::{legendre, legendre_sums};

    #[test]
    fn polynomials_are_those_of_the_harmonics() {
        for x in [-1.0, -0.3, 0.0, 0.75, 1.0] {
            for (l, value) in legendre(DoubleDouble::from(x)).take(60).enumerate() {
                let expected = legendre_p(l, x).unwrap();
                assert!((value.value() - expected).abs() < 1e-13, "l = {l}, x = {x}: {expected}");
            }
        }
    }

    #[test]
    fn power_of_antipodes_and_of_one_point() {
        let both = legendre_sums(&[DVec3::Z, DVec3::NEG_Z], 5);
        let one = legendre_sums(&[DVec3::new(0.6, 0.0, -0.8)], 5);
        for l in 0..=5 {
            let expected = if l % 2 == 0 { 2.0 } else { 0.0 };
            assert!((both[l].value() - expected).abs() < 1e-30, "l = {l}: {:?}", both[l]);
            assert!(one[l] == DoubleDouble::ONE, "l = {l}: {:?}", one[l]);
        }
    }
}
