use glam::DVec3;
use spade::Triangulation;

use super::voronoi::{MAX_SITES, for_each_side, triangulate};
use crate::search::CubeGrid;
use crate::{Domain, Progress, Stopped};

/// Nominal work per point: sorting and inserting it into the triangulation.
const WORK_PER_POINT: f64 = 30.0;

/// Rounding errors of the end of a side, generously; a candidate too many is harmless.
const SIDE_TOLERANCE: f64 = 1e-9;

/// Returns the covering radius of unit vectors: the largest chord from a direction of the domain to
/// its nearest point. Weights have no part in it.
///
/// On the hemisphere, whose directions are lines through the origin, a point covers its antipode
/// too, as in `P_2`: the result is that of the points and their antipodes on the sphere. It is 2 if
/// all points coincide, or if there are none.
///
/// The largest empty cap is centred at the circumcentre of a Delaunay triangle (Brown 1979) or, for
/// points that are all in one hemisphere, opposite to the middle of two of them. The distance from
/// each candidate to its nearest point is verified, largest candidate first, so that rounding in
/// the triangulation never enlarges the result. `None` if there are more points than the
/// triangulation can index, 2^29.
///
/// # Errors
///
/// [`Stopped`] if `progress` stops the work before or after the triangulation.
///
/// # Performance
///
/// O(N log N): 0.5 s for 100,000 points.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_samplers::{Domain, covering_radius};
///
/// let axes = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
/// // The diagonals of the octants are farthest: |(1, 1, 1)/sqrt(3) - x|^2 = 2 - 2/sqrt(3).
/// let chord = covering_radius(&axes, Domain::Sphere, &())?.unwrap();
/// assert!((chord - (2.0 - 2.0 / 3f64.sqrt()).sqrt()).abs() < 1e-15);
/// # Ok::<(), sphvar_samplers::Stopped>(())
/// ```
///
/// # References
///
/// K. Q. Brown, "Voronoi diagrams from convex hulls", Information Processing Letters 9(5), 1979.
pub fn covering_radius(
    points: &[DVec3],
    domain: Domain,
    progress: &dyn Progress,
) -> Result<Option<f64>, Stopped> {
    let antipodes = (domain == Domain::Hemisphere).then(|| points.iter().map(|p| -*p));
    let sites: Vec<DVec3> = points.iter().copied().chain(antipodes.into_iter().flatten()).collect();
    if sites.len() > MAX_SITES {
        return Ok(None);
    }
    progress.tick(0.0)?;
    let mut candidates = candidates(&sites);
    progress.tick(WORK_PER_POINT * sites.len() as f64)?;
    candidates.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    let mut grid = CubeGrid::for_points(sites.len());
    sites.iter().for_each(|&x| grid.insert(x));
    let mut largest = 0.0_f64;
    for (estimate, centre) in candidates {
        if estimate <= largest {
            break;
        }
        progress.tick(0.0)?;
        largest = largest.max(grid.clearance(&sites, centre, -1.0).unwrap_or(0.0));
    }
    Ok(Some(if sites.is_empty() { 2.0 } else { largest.sqrt() }))
}

/// Returns the possible centres of the largest empty cap, each with the squared chord to the points
/// that determine it.
fn candidates(sites: &[DVec3]) -> Vec<(f64, DVec3)> {
    let Some((&pole, others)) = sites.split_first() else { return Vec::new() };
    let planar = triangulate(pole, others);
    let mut found = Vec::with_capacity(6 * sites.len());
    let mut add = |direction: DVec3, corner: DVec3| {
        if let Some(centre) = direction.try_normalize() {
            found.push((centre.distance_squared(corner), centre));
        }
    };
    // With one or two distinct points there is no side.
    let partner = planar.vertices().next().map_or(pole, |v| sites[v.data().number]);
    add(-(pole + partner), pole);
    if pole.dot(partner) < 0.0 {
        add((pole - partner).any_orthogonal_vector(), pole);
    }
    for_each_side(sites, &planar, |[a, b], left, right| {
        let (a, b) = (sites[a], sites[b]);
        add(left, a);
        add(right, a);
        // Along a side that passes opposite to the middle of its two points, as where all points
        // are in a half circle, the distance is largest there.
        let opposite = -(a + b);
        let [left, right] = [left, right].map(DVec3::normalize_or_zero);
        let is_inside = |from: DVec3, to: DVec3| (a - b).dot(from.cross(to)) >= -SIDE_TOLERANCE;
        let is_far = left.dot(opposite).max(right.dot(opposite)) >= -SIDE_TOLERANCE;
        if is_far && is_inside(right, opposite) && is_inside(opposite, left) {
            add(opposite, a);
        }
    });
    found
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::covering_radius;
    use crate::{Domain, Pattern, Purpose, Streams};

    fn radius(points: &[DVec3], domain: Domain) -> f64 {
        covering_radius(points, domain, &()).unwrap().unwrap()
    }

    /// Returns the covering radius by the definition: the centre of the largest empty cap is
    /// equidistant from three points, or opposite to the mean of two, or to all.
    fn definition(points: &[DVec3]) -> f64 {
        let mut centres: Vec<DVec3> = points.iter().map(|p| -*p).collect();
        for (i, a) in points.iter().enumerate() {
            for (j, b) in points.iter().enumerate().skip(i + 1) {
                centres.extend([-(a + b), (a - b).any_orthogonal_vector()]);
                for c in &points[j + 1..] {
                    let normal = (b - a).cross(c - a);
                    centres.extend([normal, -normal]);
                }
            }
        }
        let clearance =
            |centre: DVec3| points.iter().map(|p| p.distance(centre)).fold(f64::INFINITY, f64::min);
        centres.iter().filter_map(|c| c.try_normalize()).map(clearance).fold(0.0, f64::max)
    }

    fn pattern(pattern: Pattern, n: usize) -> Vec<DVec3> {
        let mut rng = Streams::new(1, Purpose::Pattern, n).realization(0);
        pattern.build(n, Domain::Sphere).unwrap().sample(&mut rng).unwrap().points
    }

    #[test]
    fn it_matches_the_definition_on_hostile_sets() {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        let ring = |n: u32, height: f64| -> Vec<DVec3> {
            let at = |k| f64::from(k) * std::f64::consts::TAU / f64::from(n);
            (0..n).map(|k| DVec3::new(at(k).cos(), at(k).sin(), height).normalize()).collect()
        };
        let near = |p: DVec3, by: f64| (p + by * DVec3::new(0.3, -0.7, 0.2)).normalize();
        let corner = |k: u32| {
            let sign = |bit: u32| if k >> bit & 1 == 0 { 1.0 } else { -1.0 };
            DVec3::new(sign(0), sign(1), sign(2)).normalize()
        };
        let mut sets: Vec<(String, Vec<DVec3>)> = vec![
            ("one".into(), vec![z]),
            ("two".into(), vec![z, x]),
            ("poles".into(), vec![z, -z]),
            ("repeated".into(), vec![y; 7]),
            ("repeated pairs".into(), vec![x, x, near(x, 0.4), x, near(x, 0.4)]),
            ("three".into(), vec![x, y, near(z, 0.3)]),
            ("great circle".into(), ring(9, 0.0)),
            ("small circle".into(), ring(8, 3.0)),
            ("two circles".into(), [ring(7, 0.5), ring(7, -0.5)].concat()),
            ("octahedron".into(), vec![x, y, z, -x, -y, -z]),
            ("cube".into(), (0..8).map(corner).collect()),
            ("axes, repeated".into(), vec![x, x, y, near(y, 1e-16), z, near(x, 1e-9), -x, -y]),
            ("cluster".into(), (0..20).map(|k| near(z, 1e-7 * f64::from(k * k))).collect()),
            ("clustered line".into(), (0..20).map(|k| near(z, f64::from(k))).collect()),
        ];
        for n in [3, 4, 5, 13, 30] {
            sets.push((format!("white noise {n}"), pattern(Pattern::WhiteNoise, n)));
        }
        sets.push(("healpix".into(), pattern(Pattern::Healpix, 12)));
        let turn = DQuat::from_xyzw(0.3, -0.5, 0.2, 0.7).normalize();
        for (name, set) in &sets {
            for rotated in [false, true] {
                let set: Vec<DVec3> =
                    set.iter().map(|&p| if rotated { turn * p } else { p }).collect();
                let (got, expected) = (radius(&set, Domain::Sphere), definition(&set));
                // A chord near 0 or 2 has the rounding error of its square.
                assert!((got - expected).abs() < 1e-8, "{name}, {rotated}: {got}, {expected}");
                let both: Vec<DVec3> = set.iter().flat_map(|&p| [p, -p]).collect();
                let (got, expected) = (radius(&set, Domain::Hemisphere), definition(&both));
                assert!((got - expected).abs() < 1e-8, "lines, {name}: {got}, {expected}");
            }
        }
        assert!((radius(&[], Domain::Sphere) - 2.0).abs() <= 0.0);
    }

    /// 37.377368 degrees, the circumradius of the faces.
    #[test]
    fn icosahedron() {
        let golden = 0.5 + 1.25f64.sqrt();
        let points: Vec<DVec3> = [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)]
            .iter()
            .flat_map(|&(a, b)| {
                [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]
            })
            .map(DVec3::normalize)
            .collect();
        let expected = 2.0 * (37.377_368_140_649_7f64.to_radians() / 2.0).sin();
        assert!((radius(&points, Domain::Sphere) - expected).abs() < 1e-14);
    }

    /// The best covering has a radius of about 2.2/sqrt(N) (Toth), Fibonacci points are near.
    #[test]
    fn large_sets() {
        let cover = |n| radius(&pattern(Pattern::FIBONACCI, n), Domain::Sphere) * (n as f64).sqrt();
        let healpix = radius(&pattern(Pattern::Healpix, 49_152), Domain::Sphere);
        assert!((2.2..2.8).contains(&cover(50_000)), "{}", cover(50_000));
        assert!((2.2..3.2).contains(&(healpix * 49_152f64.sqrt())), "{healpix}");
    }
}
