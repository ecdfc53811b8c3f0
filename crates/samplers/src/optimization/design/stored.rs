//! Designs of small degrees, which are stored because the search takes up to minutes.

use glam::DVec3;

use super::DesignEquations;
use super::counts::default_count;

/// The last degree of stored designs.
const MAX_DEGREE: usize = 32;

/// The last even degree of stored symmetric designs, which have no equations of odd degrees.
const MAX_SYMMETRIC_DEGREE: usize = 32;

/// The colatitude and longitude of every point, little-endian numbers of 8 bytes: the symmetric sets
/// of degrees 2, 4, ..., one point of each pair, then the others of degrees 1, 2, 3, ...; each has
/// its default number of points. The test `write_designs` completes a file that ends early.
const DATA: &[u8] = include_bytes!("../../../data/designs.bin");

/// The bytes of a point.
const POINT: usize = 16;

/// Returns the equations of the stored designs, in their order.
fn all() -> impl Iterator<Item = DesignEquations> {
    let even = (2..=MAX_SYMMETRIC_DEGREE).step_by(2);
    let symmetric = even.map(|degree| DesignEquations { degree, is_symmetric: true });
    let others = (1..=MAX_DEGREE).map(|degree| DesignEquations { degree, is_symmetric: false });
    symmetric.chain(others)
}

/// Returns whether a design is stored.
pub(super) fn has(equations: DesignEquations, n_points: usize) -> bool {
    let is_same = |stored: DesignEquations| {
        stored.is_symmetric == equations.is_symmetric
            && stored.degrees().last() == equations.degrees().last()
    };
    default_count(equations) == n_points && all().any(is_same)
}

/// Returns the points of a stored design.
pub(super) fn points(equations: DesignEquations, n_points: usize) -> Option<Vec<DVec3>> {
    if !has(equations, n_points) {
        return None;
    }
    let is_before = |stored: &DesignEquations| {
        stored.is_symmetric != equations.is_symmetric
            || stored.degrees().last() != equations.degrees().last()
    };
    let first: usize = all().take_while(is_before).map(default_count).sum();
    let bytes = DATA.get(first * POINT..(first + n_points) * POINT)?;
    let angle = |bytes: &[u8]| Some(f64::from_le_bytes(bytes.try_into().ok()?));
    let point = |bytes: &[u8]| {
        let (theta, phi) = bytes.split_at(POINT / 2);
        let ((sin_theta, cos_theta), (sin, cos)) = (angle(theta)?.sin_cos(), angle(phi)?.sin_cos());
        Some(DVec3::new(sin_theta * cos, sin_theta * sin, cos_theta))
    };
    bytes.chunks_exact(POINT).map(point).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::DVec3;

    use super::super::jacobian::Jacobian;
    use super::super::search::attempt_design;
    use super::{DATA, DesignEquations, POINT, all, default_count, points};
    use crate::separation;

    /// Returns the residual, the separation times `sqrt(N)` and the largest power of the next three
    /// degrees.
    fn quality(equations: DesignEquations, points: &[DVec3]) -> [f64; 3] {
        let n = points.len();
        let jacobian = Jacobian::new(equations, 3, 1.0).unwrap();
        let squares = jacobian.squares(&jacobian.values(points, &()).unwrap(), n);
        let domain = equations.domain();
        let distance = separation(points, domain, &()).unwrap().unwrap_or(2.0);
        let power =
            |l: usize| 4.0 * std::f64::consts::PI / n as f64 / (2 * l + 1) as f64 * squares[l];
        let beyond = (equations.degree + 1..squares.len()).map(power).fold(0.0, f64::max);
        let residual = equations.residual(&squares, n);
        [residual, distance * domain.count_on_sphere(n).sqrt(), beyond]
    }

    #[test]
    fn stored_designs_are_designs() {
        assert_eq!(DATA.len(), POINT * all().map(default_count).sum::<usize>());
        for equations in all() {
            let points = points(equations, default_count(equations)).unwrap();
            let [residual, separation, beyond] = quality(equations, &points);
            assert!(residual <= 1e-20, "{equations:?}: {residual}");
            assert!(separation > 2.5, "{equations:?}: {separation}");
            // Of pairs of antipodes, even degrees have twice the power of independent points.
            let limit = if equations.is_symmetric { 3.0 } else { 1.2 };
            assert!(equations.degree < 10 || beyond < limit, "{equations:?}: {beyond}");
        }
    }

    /// Writes `data/designs.bin`, from where an interrupted run left it: of several searches for each
    /// design the one with the least power beyond the degree among those with a separation of at
    /// least `3/sqrt(N)`, or else the one with the largest separation.
    #[test]
    #[ignore = "slow"]
    #[allow(clippy::print_stdout, reason = "progress of a run of minutes")]
    fn write_designs() {
        if std::env::var_os("SPHVAR_WRITE_DESIGNS").is_none() {
            return;
        }
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/designs.bin");
        let mut data = std::fs::read(&path).unwrap();
        let mut end = 0;
        for equations in all() {
            let n = default_count(equations);
            end += n * POINT;
            if end <= data.len() {
                continue;
            }
            let (wanted, attempts, sufficient) = match equations.count() {
                0..200 => (12, 60, 0.2),
                200..400 => (4, 12, 0.2),
                _ => (2, 8, 0.4),
            };
            let mut best: Option<([f64; 2], [f64; 3], Vec<DVec3>)> = None;
            let mut found = 0;
            for attempt in 0..attempts {
                let Ok(points) = attempt_design(equations, n, attempt, &()) else { continue };
                let [residual, separation, beyond] = quality(equations, &points);
                found += 1;
                let is_separated = separation >= 3.0;
                let rank = if is_separated { [1.0, -beyond] } else { [0.0, separation] };
                if best.as_ref().is_none_or(|best| rank > best.0) {
                    best = Some((rank, [residual, separation, beyond], points));
                }
                if found >= wanted || is_separated && beyond < sufficient {
                    break;
                }
            }
            let (_, quality, points) = best.expect("a design");
            println!("{equations:?} N = {n}, {found} found: {quality:?}");
            for p in points {
                let angles = [p.x.hypot(p.y).atan2(p.z), p.y.atan2(p.x)];
                data.extend(angles.iter().flat_map(|angle| angle.to_le_bytes()));
            }
            assert_eq!(data.len(), end);
            std::fs::write(&path, &data).unwrap();
        }
    }
}
