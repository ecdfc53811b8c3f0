use crate::error::Error;

/// Checks that points and weights are valid and that the coefficients do not overflow.
pub(crate) fn check(points: &[[f64; 2]], weights: Option<&[f64]>) -> Result<(), Error> {
    if u32::try_from(points.len()).is_err() {
        return Err(Error::TooManyPoints { points: points.len(), max: u32::MAX });
    }
    let inside = |x: f64| (0.0..1.0).contains(&x);
    if let Some(index) = points.iter().position(|&[u, v]| !(inside(u) && inside(v))) {
        let [u, v] = points[index];
        return Err(Error::Point { index, u, v });
    }
    let Some(weights) = weights else { return Ok(()) };
    if weights.len() != points.len() {
        return Err(Error::WeightCount { weights: weights.len(), points: points.len() });
    }
    if let Some(index) = weights.iter().position(|w| !w.is_finite()) {
        return Err(Error::Weight { index, weight: weights[index] });
    }
    // No coefficient exceeds this sum.
    let sum: f64 = weights.iter().map(|w| w.abs()).sum();
    if sum.is_finite() { Ok(()) } else { Err(Error::Overflow) }
}
