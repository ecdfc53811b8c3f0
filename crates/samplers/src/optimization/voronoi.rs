//! Spherical Voronoi cells from a planar Delaunay triangulation.
//!
//! Stereographic projection from one of the sites preserves circles. The Delaunay triangulation of
//! the images of the other sites is therefore that of the sphere without the triangles at the pole
//! of projection, of which there is one per edge of the planar hull (Brown 1979).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use spade::handles::DirectedEdgeHandle;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

/// Maximum number of sites: the triangulation indexes its 6 half-edges per site with 32 bits.
pub(crate) const MAX_SITES: usize = 1 << 29;

/// Replaces the content of `moments` by the integral of x over each site's cell on the unit sphere.
///
/// For a cell whose sides are arcs of length t with inward unit normals n, the integral is exactly
/// half the sum of t n. The side between the cells of a and b has the normal (a - b)/|a - b| and
/// its opposite, so one pass over the Delaunay edges suffices. A site that coincides with another
/// to rounding, or that is zero or not finite, may have no cell; its moment is then zero.
pub(crate) fn cell_moments(sites: &[DVec3], moments: &mut Vec<DVec3>) {
    moments.clear();
    moments.resize(sites.len(), DVec3::ZERO);
    if let &[a, b] = sites {
        let moment = PI * (a - b).normalize_or_zero();
        moments.copy_from_slice(&[moment, -moment]);
    } else if let [pole, others @ ..] = sites {
        let planar = triangulate(*pole, others);
        for_each_side(sites, &planar, |ab, left, right| add_side(sites, moments, ab, left, right));
    }
}

/// Calls `side` for every pair of sites whose cells share a side, with vectors along its ends: it
/// runs counter-clockwise about the first site from `right` to `left`.
pub(super) fn for_each_side(
    sites: &[DVec3],
    planar: &DelaunayTriangulation<Image>,
    mut side: impl FnMut([usize; 2], DVec3, DVec3),
) {
    for edge in planar.undirected_edges() {
        let [from, to] = edge.as_directed().vertices().map(|v| v.data().number);
        let edge = edge.as_directed();
        side([from, to], circumcentre(sites, edge), circumcentre(sites, edge.rev()));
    }
    for edge in planar.directed_edges().filter(|e| e.face().is_outer()) {
        let (left, right) = (circumcentre(sites, edge), circumcentre(sites, edge.next()));
        side([edge.to().data().number, 0], left, right);
    }
}

/// A site's image in the plane.
pub(super) struct Image {
    position: Point2<f64>,
    /// Its index among the sites.
    pub(super) number: usize,
}

impl HasPosition for Image {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

type Edge<'a> = DirectedEdgeHandle<'a, Image, (), (), ()>;

/// Returns the triangulation of `others` projected from `pole`, counter-clockwise as seen from
/// outside the sphere.
pub(super) fn triangulate(pole: DVec3, others: &[DVec3]) -> DelaunayTriangulation<Image> {
    // Seen from outside, the sphere beyond the pole has its normal along -pole.
    let (e1, e2) = (-pole).any_orthonormal_pair();
    let images = others.iter().zip(1..).filter_map(|(&x, number)| {
        // 1 - x.pole without cancellation. The pole, points that coincide with it to rounding, and
        // vectors that are zero or not finite have no image.
        let below = (x - pole).length_squared() / 2.0;
        let position = Point2::new(x.dot(e1) / below, x.dot(e2) / below);
        let image = Image { position: spade::mitigate_underflow(position), number };
        (1e-40..=4.0).contains(&below).then_some(image)
    });
    // This fails only if a site is zero or not finite; then there are no cells.
    DelaunayTriangulation::bulk_load(images.collect()).unwrap_or_default()
}

/// Returns a vector along the circumcentre of the triangle left of `edge`. Where the plane has no
/// face, the third vertex is the pole of projection, site 0.
fn circumcentre(sites: &[DVec3], edge: Edge<'_>) -> DVec3 {
    let [a, b] = edge.vertices().map(|v| sites[v.data().number]);
    let c = sites[edge.opposite_vertex().map_or(0, |v| v.data().number)];
    (b - a).cross(c - a)
}

/// Adds the side between the cells of two sites, from `right` to `left` about the first one.
fn add_side(sites: &[DVec3], moments: &mut [DVec3], ab: [usize; 2], left: DVec3, right: DVec3) {
    let [a, b] = ab.map(|number| sites[number]);
    let normal = (a - b).normalize_or_zero();
    let angle = normal.dot(right.cross(left)).atan2(right.dot(left));
    // A value slightly below 0 means that rounding chose the wrong diagonal of cocircular sites,
    // which the sign corrects. A value far below 0 is a half circle that rounding has taken past
    // pi.
    let length = if angle < -FRAC_PI_2 { angle + TAU } else { angle };
    let half = 0.5 * length * normal;
    moments[ab[0]] += half;
    moments[ab[1]] -= half;
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::DVec3;

    use super::cell_moments;
    use crate::{Domain, Pattern, Purpose, Streams};

    fn moments(sites: &[DVec3]) -> Vec<DVec3> {
        let mut moments = vec![DVec3::NAN];
        cell_moments(sites, &mut moments);
        moments
    }

    fn pattern(pattern: Pattern, n: usize) -> Vec<DVec3> {
        let mut rng = Streams::new(4, Purpose::Pattern, n).realization(0);
        pattern.build(n, Domain::Sphere).unwrap().sample(&mut rng).unwrap().points
    }

    #[test]
    fn few_cells() {
        assert_eq!(moments(&[]), []);
        assert_eq!(moments(&[DVec3::X]), [DVec3::ZERO]);
        // Hemispheres: pi times the pole.
        assert_eq!(moments(&[DVec3::X, -DVec3::X]), [PI * DVec3::X, -PI * DVec3::X]);
        // Three lunes of 120 degrees: two half circles with normals 60 degrees apart.
        let (c, s) = (-0.5, 0.75f64.sqrt());
        let three = [DVec3::X, DVec3::new(c, s, 0.0), DVec3::new(c, -s, 0.0)];
        for (m, p) in moments(&three).iter().zip(three) {
            let expected = PI * s * p;
            assert!((m - expected).length() < 16.0 * f64::EPSILON, "{m}, {expected}");
        }
        // Coincident sites share one cell.
        assert_eq!(moments(&[DVec3::X; 5]), [DVec3::ZERO; 5]);
    }

    #[test]
    fn zero_and_non_finite_sites_are_tolerated() {
        let near = DVec3::new(1e-18, 0.0, 1.0);
        for odd in [DVec3::NAN, DVec3::INFINITY, DVec3::ZERO, 1e200 * DVec3::X, near, 1e9 * near] {
            for place in 0..6 {
                let mut sites = vec![DVec3::Z, DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Z, DVec3::X];
                sites[place] = odd;
                assert_eq!(moments(&sites).len(), 6);
            }
        }
    }

    /// Each cell of the octahedron has four sides acos(1/3) long; each of a square on a great
    /// circle, where all four sites are on one circle, two half circles.
    #[test]
    fn cells_of_cocircular_sites() {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        for (sites, length) in [
            (vec![x, y, z, -x, -y, -z], 2f64.sqrt() * (1f64 / 3.0).acos()),
            (vec![x, y, -x, -y], PI * 0.5f64.sqrt()),
        ] {
            for (m, p) in moments(&sites).iter().zip(&sites) {
                assert!((m - length * p).length() < 16.0 * f64::EPSILON, "{p}: {m}, {length}");
            }
        }
    }

    #[test]
    fn moments_match_those_of_dense_mass_points() {
        const MASS: usize = 200_000;
        let mass = pattern(Pattern::FIBONACCI, MASS);
        for n in [3, 4, 5, 8, 50] {
            let sites = pattern(Pattern::WhiteNoise, n);
            let mut expected = vec![DVec3::ZERO; n];
            for &x in &mass {
                let nearest = (0..n).max_by(|&a, &b| sites[a].dot(x).total_cmp(&sites[b].dot(x)));
                expected[nearest.unwrap()] += x * (4.0 * PI / MASS as f64);
            }
            for (k, (m, e)) in moments(&sites).iter().zip(&expected).enumerate() {
                // About perimeter times sqrt(MASS) points along the rim are counted wrongly at
                // random: an error of about MASS^(-3/4); measured at most 2e-4.
                assert!((m - e).length() < 1e-3, "N = {n}, site {k}: {m} and {e}");
            }
        }
    }

    #[test]
    fn moments_of_large_sets_sum_to_zero() {
        for kind in [Pattern::WhiteNoise, Pattern::FIBONACCI, Pattern::Healpix] {
            let sites = pattern(kind.clone(), 12 * 40 * 40);
            let moments = moments(&sites);
            let area = 4.0 * PI / sites.len() as f64;
            let sum: DVec3 = moments.iter().sum();
            assert!(sum.length() < 1e-12, "{kind}: {sum}");
            // Lengths are areas up to a small relative error for cells of that size: 4 pi in total.
            let total: f64 = moments.iter().map(|m| m.length()).sum();
            assert!((total / (4.0 * PI) - 1.0).abs() < area, "{kind}: {total}");
        }
    }
}
