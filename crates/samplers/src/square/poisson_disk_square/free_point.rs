use glam::DVec2;

use super::square_cells::SquareCells;
use crate::Error;
use crate::disks::{FreeRegion, Subdivision};

/// Returns a point of the unit square at least `radius` away from all `points`, or `None` if there
/// is none: a set of Poisson disks is maximal if no further disk fits. With `is_wrapped` opposite
/// sides of the square are joined, and distances are toroidal.
///
/// The square is divided recursively, and the parts that one disk covers are dropped. `None` is
/// therefore a proof, apart from squares with sides of 1e-9 that no single disk covers, which count
/// as covered. Cost: O(N) for a maximal set.
///
/// ```
/// use sphvar_samplers::free_point;
/// let points = [[0.25, 0.25], [0.75, 0.75]];
/// // The points farthest from both are 1/2 away.
/// assert_eq!(free_point(&points, 0.501, true)?, None);
/// let [u, v] = free_point(&points, 0.499, true)?.unwrap();
/// assert!((u - 0.25).hypot(v - 0.75) < 0.01 || (u - 0.75).hypot(v - 0.25) < 0.01);
/// // Without periodic images the corners are farther from them.
/// assert!(free_point(&points, 0.501, false)?.is_some());
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Parameter`] unless `radius` is positive, [`Error::Given`] if a coordinate is not in
/// [0, 1).
pub fn free_point(
    points: &[[f64; 2]],
    radius: f64,
    is_wrapped: bool,
) -> Result<Option<[f64; 2]>, Error> {
    if radius.is_nan() || radius <= 0.0 {
        let (name, range) = ("the radius of disks", "positive");
        return Err(Error::Parameter { name, range, got: radius });
    }
    let is_inside = |p: &[f64; 2]| p.iter().all(|c| (0.0..1.0).contains(c));
    if let Some(k) = points.iter().position(|p| !is_inside(p)) {
        let reason = format!("point {k} (0-based) is {:?}, not in [0, 1)^2", points[k]);
        return Err(Error::Given { reason });
    }
    let mut cells = SquareCells::new(is_wrapped, radius, points.len() as f64);
    for &point in points {
        cells.insert_at(DVec2::from(point));
    }
    let mut region = FreeRegion::whole(cells);
    let mut found = None;
    while found.is_none() && !region.is_empty() && !region.is_finest() {
        region.refine(|cells, live| {
            for &child in live.children {
                let middle = cells.point_in(child, live.resolution, 0.5, 0.5);
                let free = middle.filter(|&p| live.near.iter().all(|&q| !cells.overlap(q, p)));
                found = found.or(free.map(<[f64; 2]>::from));
            }
        });
    }
    Ok(found)
}
