use crate::error::Error;
use crate::real::Real;

/// Checks that points and weights are valid and that the coefficients do not overflow.
pub(crate) fn check(points: &[[f64; 2]], weights: Option<&[f64]>) -> Result<(), Error> {
    check_count(points.len())?;
    if let Some(index) = points.iter().position(|&[u, v]| !(inside(u) && inside(v))) {
        let [u, v] = points[index];
        return Err(Error::Point { index, u, v });
    }
    weights.map_or(Ok(()), |weights| check_weights(weights, points.len()))
}

/// Checks coordinates on the circle and weights in the same way.
pub(crate) fn check_circle<R: Real>(points: &[R], weights: Option<&[R]>) -> Result<(), Error> {
    check_count(points.len())?;
    if let Some(index) = points.iter().position(|u| !inside(u.to_f64())) {
        return Err(Error::Coordinate { index, u: points[index].to_f64() });
    }
    weights.map_or(Ok(()), |weights| check_weights(weights, points.len()))
}

fn check_count(points: usize) -> Result<(), Error> {
    if u32::try_from(points).is_ok() {
        Ok(())
    } else {
        Err(Error::TooManyPoints { points, max: u32::MAX })
    }
}

fn inside(x: f64) -> bool {
    (0.0..1.0).contains(&x)
}

fn check_weights<R: Real>(weights: &[R], points: usize) -> Result<(), Error> {
    if weights.len() != points {
        return Err(Error::WeightCount { weights: weights.len(), points });
    }
    if let Some(index) = weights.iter().position(|w| !w.to_f64().is_finite()) {
        return Err(Error::Weight { index, weight: weights[index].to_f64() });
    }
    // No coefficient exceeds this sum.
    let sum: f64 = weights.iter().map(|w| w.to_f64().abs()).sum();
    if R::of(sum).to_f64().is_finite() { Ok(()) } else { Err(Error::Overflow) }
}
