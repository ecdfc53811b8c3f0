use std::f64::consts::TAU;

use num_complex::Complex;

use crate::coefficients::{ComplexTorusCoefficients, TorusCoefficients};
use crate::error::Error;
use crate::input;
use crate::limits::MAX_CIRCLE_KMAX;
use crate::long_sum::add_with_rests;
use crate::magnitude::magnitude;

/// Returns the coefficients of [`TorusTransform::adjoint`](crate::TorusTransform::adjoint) by the
/// definition, to rounding.
///
/// Use it for few points, and to verify the fast transform.
///
/// # Errors
///
/// [`Error::FrequencyTooLarge`] and [`Error::OutOfMemory`] as for [`TorusCoefficients::zeros`]; for
/// points and weights as for [`TorusTransform::adjoint`](crate::TorusTransform::adjoint).
///
/// # Performance
///
/// The cost is O(N kmax^2).
///
/// # Examples
///
/// ```
/// let points = [[0.0, 0.0], [0.5, 0.0]];
/// let c = sphvar_nufft::direct_adjoint(3, &points, None)?;
/// assert_eq!(c.get(0, 2).map(|c| c.re), Some(2.0));
/// assert!(c.get(1, 0).is_some_and(|c| c.norm() < 1e-15));
/// # Ok::<(), sphvar_nufft::Error>(())
/// ```
pub fn direct_adjoint(
    kmax: usize,
    points: &[[f64; 2]],
    weights: Option<&[f64]>,
) -> Result<TorusCoefficients, Error> {
    let mut out = TorusCoefficients::<f64>::zeros(kmax)?;
    input::check(points, weights)?;
    let size = weights.map_or(1.0, |w| magnitude(w.iter().copied()));
    let weight = |j: usize| Complex::new(weights.map_or(1.0, |w| w[j]) / size, 0.0);
    add_waves(kmax, 0.0, points, weight, size, out.values_mut());
    Ok(out)
}

/// Returns the coefficients of
/// [`TorusTransform::adjoint_complex`](crate::TorusTransform::adjoint_complex) by the definition, to
/// rounding.
///
/// # Errors
///
/// As for [`direct_adjoint`].
///
/// # Performance
///
/// The cost is O(N kmax^2).
pub fn direct_adjoint_complex(
    kmax: usize,
    points: &[[f64; 2]],
    weights: &[Complex<f64>],
) -> Result<ComplexTorusCoefficients, Error> {
    let mut out = ComplexTorusCoefficients::zeros(kmax)?;
    input::check_complex(points, weights)?;
    let size = magnitude(weights.iter().flat_map(|w| [w.re, w.im]));
    let first = -(kmax as f64);
    add_waves(kmax, first, points, |j| weights[j] / size, size, out.values_mut());
    Ok(out)
}

/// Replaces `out` by `size` times the coefficients for k2 from `first` to kmax, in compensated sums.
fn add_waves(
    kmax: usize,
    first: f64,
    points: &[[f64; 2]],
    weight: impl Fn(usize) -> Complex<f64>,
    size: f64,
    out: &mut [Complex<f64>],
) {
    let columns = out.len() / (2 * kmax + 1);
    // Real and imaginary parts alternate.
    let mut sums = vec![0.0; out.len() * 2];
    let mut rests = vec![0.0; sums.len()];
    let mut terms = vec![0.0; 2 * columns];
    for (index, &[u, v]) in points.iter().enumerate() {
        let by_v: Vec<Complex<f64>> = (0..columns).map(|k| wave(first + k as f64, v)).collect();
        let rows = sums.chunks_exact_mut(2 * columns).zip(rests.chunks_exact_mut(2 * columns));
        for (line, (sums, rests)) in rows.enumerate() {
            let by_u = wave(line as f64 - kmax as f64, u) * weight(index);
            for (term, by_v) in terms.as_chunks_mut::<2>().0.iter_mut().zip(&by_v) {
                let product = by_u * by_v;
                *term = [product.re, product.im];
            }
            add_with_rests(sums, rests, &terms);
        }
    }
    let parts = sums.as_chunks::<2>().0.iter().zip(rests.as_chunks::<2>().0);
    for (value, (sum, rest)) in out.iter_mut().zip(parts) {
        *value = Complex::new(sum[0] + rest[0], sum[1] + rest[1]) * size;
    }
}

/// Returns `e^{-2 pi i k x}`; the angle is rounded once, after reduction by whole turns.
pub(crate) fn wave(k: f64, x: f64) -> Complex<f64> {
    let turns = k * x;
    let rest = k.mul_add(x, -turns);
    let (sin, cos) = (TAU * (turns - turns.round() + rest)).sin_cos();
    Complex::new(cos, -sin)
}

/// Returns the coefficients of [`CircleTransform::adjoint`](crate::CircleTransform::adjoint) by the
/// definition, to rounding.
///
/// # Errors
///
/// [`Error::FrequencyTooLarge`] if `kmax` exceeds [`MAX_CIRCLE_KMAX`]; for points and weights as for
/// [`CircleTransform::adjoint`](crate::CircleTransform::adjoint).
///
/// # Performance
///
/// The cost is O(N kmax).
///
/// # Examples
///
/// ```
/// let c = sphvar_nufft::direct_circle(3, &[0.0, 0.5], None)?;
/// assert!((c[2] - 2.0).norm() < 1e-15 && c[3].norm() < 1e-15);
/// # Ok::<(), sphvar_nufft::Error>(())
/// ```
pub fn direct_circle(
    kmax: usize,
    points: &[f64],
    weights: Option<&[f64]>,
) -> Result<Vec<Complex<f64>>, Error> {
    if kmax > MAX_CIRCLE_KMAX {
        return Err(Error::FrequencyTooLarge { kmax, max: MAX_CIRCLE_KMAX });
    }
    input::check_circle(points, weights)?;
    let size = weights.map_or(1.0, |w| magnitude(w.iter().copied()));
    let scale = 1.0 / size;
    let coefficient = |k: usize| {
        let (mut sums, mut rests) = ([0.0; 2], [0.0; 2]);
        for (index, &u) in points.iter().enumerate() {
            let term = wave(k as f64, u) * weights.map_or(scale, |w| w[index] * scale);
            add_with_rests(&mut sums, &mut rests, &[term.re, term.im]);
        }
        Complex::new(sums[0] + rests[0], sums[1] + rests[1]) * size
    };
    Ok((0..=kmax).map(coefficient).collect())
}
