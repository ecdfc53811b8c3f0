use crate::Error;

/// Rejects sizes whose mass points cannot be counted in 32 bits.
pub(crate) fn check_sizes(n_points: usize, capacity: usize) -> Result<(), Error> {
    let rejected = |name, range, got: f64| Err(Error::Parameter { name, range, got });
    if n_points == 0 {
        return rejected("number of points of a CCVT", "at least 1", 0.0);
    }
    if capacity == 0 {
        return rejected("capacity of a CCVT", "at least 1", 0.0);
    }
    match n_points.checked_mul(capacity) {
        Some(count) if u32::try_from(count).is_ok() => Ok(()),
        _ => {
            let name = "number of mass points of a CCVT (capacity times points)";
            rejected(name, "at most 4294967295", n_points as f64 * capacity as f64)
        }
    }
}

/// Returns the nominal work of a relaxation.
pub(crate) fn nominal_work(n_points: usize, capacity: usize) -> f64 {
    let mass = capacity.max(2) as f64;
    1.2 * mass * mass.log2() * n_points as f64
}

/// Returns the nominal work of one pass.
pub(crate) fn work_per_pass(n_points: usize, capacity: usize) -> f64 {
    let expected = 6.0 * (n_points as f64).sqrt();
    nominal_work(n_points, capacity) / expected
}
