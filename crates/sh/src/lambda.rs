use crate::{
    Colatitude, Scaled,
    recurrence::{State, Step},
    sectoral::sectoral_function,
};

/// Returns the orthonormal associated Legendre function `lambda_lm(theta)`, Condon-Shortley phase
/// included.
///
/// ```text
/// Y_lm(theta, phi) = lambda_lm(theta) e^(i m phi),   integral |Y_lm|^2 = 1
/// lambda_lm = (-1)^m sqrt((2l + 1)/(4 pi) (l - m)!/(l + m)!) sin^m(theta) d^m P_l(x)/dx^m,
/// x = cos theta
/// ```
///
/// Domain: `0 <= m`, `l <=` [`MAX_DEGREE`](crate::MAX_DEGREE), any colatitude; 0 for `m > l`.
/// Values below the range of `f64` are 0; [`lambda_scaled`] preserves them.
///
/// # Accuracy
///
/// The error is at most `4 EPSILON (l + 1)` times the local amplitude, the largest of
/// `|lambda_lm|`, `|lambda_{l-1,m}|` and `|d lambda_lm/d theta|/(l + 1/2)`, verified for
/// `l <= 20000`. In the evanescent region, `sin theta < m / (l + 1/2)`, the error is relative to
/// the value.
///
/// # Performance
///
/// `O(l - m + log m)`, no allocation. All degrees of an order together have the same cost:
/// [`LegendrePlan::column_into`](crate::LegendrePlan::column_into).
///
/// # Examples
///
/// ```
/// use sphvar_sh::{Colatitude, lambda};
///
/// let theta: f64 = 0.4;
/// let exact = -(15.0 / (8.0 * std::f64::consts::PI)).sqrt() * theta.sin() * theta.cos();
/// let value = lambda(2, 1, Colatitude::from_theta(theta)?);
/// assert!((value - exact).abs() < 4.0 * f64::EPSILON);
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
///
/// # References
///
/// See [`Recurrence`](crate::Recurrence) for the recurrence and [`sectoral`](crate::sectoral) for
/// its initial value.
#[must_use]
pub fn lambda(l: usize, m: usize, colatitude: Colatitude) -> f64 {
    lambda_scaled(l, m, colatitude).value()
}

/// Returns [`lambda`] with an extended exponent, for values below the range of `f64`.
///
/// Domain, accuracy and cost are those of [`lambda`].
///
/// # Examples
///
/// ```
/// use sphvar_sh::{Colatitude, lambda, lambda_scaled};
///
/// let c = Colatitude::from_theta(1e-100)?;
/// assert_eq!(lambda(4, 4, c), 0.0);
/// let magnitude = lambda_scaled(4, 4, c).log10_abs();
/// let constant = (315.0 / (512.0 * std::f64::consts::PI)).sqrt().log10();
/// assert!((magnitude - (constant - 400.0)).abs() < 1e-12);
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
#[must_use]
pub fn lambda_scaled(l: usize, m: usize, colatitude: Colatitude) -> Scaled {
    if m > l {
        return Scaled::ZERO;
    }
    let mut state = State::start(sectoral_function(m, colatitude));
    for k in m..l {
        state.advance(Step::new(k, m), colatitude.versine());
    }
    let acute = state.scaled();
    if colatitude.is_south() && !(l - m).is_multiple_of(2) { -acute } else { acute }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_above_the_degree_vanish() {
        let c = Colatitude::from_theta(1.0).unwrap();
        assert_eq!(lambda_scaled(3, 4, c), Scaled::ZERO);
    }
}
