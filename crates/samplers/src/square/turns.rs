use glam::DVec2;

/// Returns the representative modulo 1 of a point of the plane: coordinates in [0, 1).
pub(crate) fn wrapped(point: DVec2) -> DVec2 {
    let wrap = |x: f64| {
        let part = x - x.floor();
        // A value slightly below an integer rounds to 1.
        if part < 1.0 { part } else { 0.0 }
    };
    DVec2::new(wrap(point.x), wrap(point.y))
}

#[cfg(test)]
mod tests {
    use super::{DVec2, wrapped};

    #[test]
    fn coordinates_are_below_1() {
        for x in [-7.5, -0.5, -f64::MIN_POSITIVE, -1e-17, -0.0, 0.0, 0.3, 1.0, 1.0 + 1e-15, 1e9] {
            let p = wrapped(DVec2::new(x, 0.25));
            let turns = x - p.x;
            assert!((0.0..1.0).contains(&p.x), "{x}: {p}");
            assert!((turns - turns.round()).abs() < 1e-15, "{x}: {p}");
        }
    }
}
