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

/// The bytes that a tessellation takes for each of its mass points.
const BYTES_PER_MASS_POINT: usize = 56;

/// Rejects tessellations whose mass points exceed the memory, before it is allocated.
pub(crate) fn check_memory(n_points: usize, capacity: usize) -> Result<(), Error> {
    let len = n_points * capacity;
    let error = Error::OutOfMemory {
        pattern: "a CCVT",
        items: "mass points",
        len,
        bytes_each: BYTES_PER_MASS_POINT,
        remedy: "a smaller capacity or fewer points",
    };
    // Memory that is reserved only, and never written to, costs no time.
    Vec::<[u8; BYTES_PER_MASS_POINT]>::new().try_reserve_exact(len).map_err(|_| error)
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

#[cfg(test)]
mod tests {
    use super::check_memory;
    use crate::Error;

    /// 2^60 mass points exceed the addresses of every machine.
    #[test]
    fn too_many_mass_points_are_rejected_before_they_take_memory() {
        check_memory(1, 64).unwrap();
        check_memory(1 << 10, 1 << 10).unwrap();
        let error = check_memory(1 << 30, 1 << 30).unwrap_err();
        assert!(matches!(error, Error::OutOfMemory { len, .. } if len == 1 << 60), "{error}");
        assert!(error.to_string().contains("a smaller capacity"), "{error}");
    }
}
