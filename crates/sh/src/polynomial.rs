use crate::Error;

/// Returns the Legendre polynomial `P_l(x)`, `P_l(1) = 1`.
///
/// It is evaluated at `|x|` by the recurrence in difference form,
///
/// ```text
/// D_{l+1} = r D_l - (1 + r) (1 - |x|) P_l,   P_{l+1} = P_l + D_{l+1},   r = l/(l + 1)
/// ```
///
/// with `P_l(-x) = (-1)^l P_l(x)`. Domain: the closed interval `[-1, 1]`. The error is at most
/// `4 EPSILON (l + 1)` times the larger of `|P_l|` and `|P_{l-1}|`. The cost is `O(l)`.
///
/// Near `x = 1` the rounding of the argument limits the accuracy. For directions at a small angle
/// use `sqrt(4 pi / (2l + 1))` [`lambda`](crate::lambda())`(l, 0, ..)`, which takes the angle.
///
/// # Errors
///
/// [`Error::Argument`] if `x` is NaN or outside `[-1, 1]`; clamp dot products of unit vectors.
///
/// # Examples
///
/// ```
/// use sphvar_sh::legendre_p;
///
/// assert!((legendre_p(2, 0.3)? - (3.0 * 0.09 - 1.0) / 2.0).abs() < 1e-15);
/// assert_eq!(legendre_p(1001, -1.0)?, -1.0);
/// assert!(legendre_p(2, 1.1).is_err());
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
///
/// # References
///
/// DLMF 18.9.1, table 18.9.1; see [`Recurrence`](crate::Recurrence) for the difference form.
pub fn legendre_p(l: usize, x: f64) -> Result<f64, Error> {
    let mut state = State::new(x)?;
    for degree in 0..l {
        state.advance(degree);
    }
    Ok(if x < 0.0 && l % 2 == 1 { -state.value } else { state.value })
}

/// Writes `P_0(x), P_1(x), ..` to `out`, for all degrees below its length.
///
/// The values are bit-identical to those of [`legendre_p`]; the cost is `O(out.len())`.
///
/// # Errors
///
/// Those of [`legendre_p`]; `out` is then unchanged.
///
/// # Examples
///
/// ```
/// let mut p = [0.0; 4];
/// sphvar_sh::legendre_p_into(0.5, &mut p)?;
/// assert_eq!(p, [1.0, 0.5, -0.125, -0.4375]);
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
pub fn legendre_p_into(x: f64, out: &mut [f64]) -> Result<(), Error> {
    let mut state = State::new(x)?;
    for (degree, slot) in out.iter_mut().enumerate() {
        *slot = if x < 0.0 && degree % 2 == 1 { -state.value } else { state.value };
        state.advance(degree);
    }
    Ok(())
}

/// The state of the recurrence at `|x|`.
struct State {
    versine: f64,
    value: f64,
    difference: f64,
}

impl State {
    fn new(x: f64) -> Result<Self, Error> {
        if (-1.0..=1.0).contains(&x) {
            Ok(Self { versine: 1.0 - x.abs(), value: 1.0, difference: 0.0 })
        } else {
            Err(Error::Argument { x })
        }
    }

    #[inline]
    fn advance(&mut self, l: usize) {
        let r = l as f64 / (l as f64 + 1.0);
        self.difference = r * self.difference - (1.0 + r) * (self.versine * self.value);
        self.value += self.difference;
    }
}
