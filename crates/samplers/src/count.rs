//! The range of point counts that every pattern supports.

use crate::Error;

/// Returns `n_points` as the index type of the patterns; values outside 1 to `u32::MAX` are an
/// error. Beyond that range the product of an integer and a height is no longer exact in `f64`, and
/// the points alone take 96 GiB.
pub(crate) fn checked(n_points: usize) -> Result<u32, Error> {
    match u32::try_from(n_points) {
        Ok(n) if n > 0 => Ok(n),
        _ => Err(Error::Parameter {
            name: "the number of points",
            range: "from 1 to 4294967295",
            got: n_points as f64,
        }),
    }
}
