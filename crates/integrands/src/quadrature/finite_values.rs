use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::DVec3;

use crate::{Error, Integrand};

/// Writes the values of a function at many points; `place` describes a point.
///
/// # Errors
///
/// Those of `eval_into`, and [`Error::Evaluation`] with the point for a value that is NaN or infinite
/// or whose evaluation panics.
pub(crate) fn finite_values<P: Copy>(
    points: &[P],
    values: &mut [f64],
    eval_into: impl Fn(&[P], &mut [f64]) -> Result<(), Error>,
    place: impl Fn(P) -> String,
) -> Result<(), Error> {
    let evaluate = |points: &[P], values: &mut [f64]| {
        catch_unwind(AssertUnwindSafe(|| eval_into(points, values)))
    };
    let invalid = |point: Option<&P>, what: &str| {
        let place = point.map_or_else(String::new, |point| place(*point));
        let reason = format!("its value at {place} {what}; every value must be finite");
        Error::Evaluation { reason }
    };
    let Ok(result) = evaluate(points, values) else {
        // One at a time, to find the point.
        let at = points.iter().find(|point| evaluate(&[**point], &mut [0.0]).is_err());
        let at = at.or(points.first());
        return Err(invalid(at, "cannot be computed: the function panicked"));
    };
    result?;
    match points.iter().zip(&*values).find(|(_, value)| !value.is_finite()) {
        Some((point, value)) => Err(invalid(Some(point), &format!("is {value}"))),
        None => Ok(()),
    }
}

/// [`finite_values`] of an integrand.
pub(crate) fn finite_values_at(
    function: &dyn Integrand,
    dirs: &[DVec3],
    values: &mut [f64],
) -> Result<(), Error> {
    let eval_into = |dirs: &[DVec3], values: &mut [f64]| function.eval_into(dirs, values);
    finite_values(dirs, values, eval_into, |dir| {
        format!("x = {}, y = {}, z = {}", dir.x, dir.y, dir.z)
    })
}
