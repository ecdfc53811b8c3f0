//! The numbers of points that every pattern of the survey can have.

use crate::Error;

/// `n_points` as the index type of the patterns, rejected outside 1 to `u32::MAX`: beyond, an
/// integer times a height would no longer be exact in `f64`, and the points alone fill 96 GiB.
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
