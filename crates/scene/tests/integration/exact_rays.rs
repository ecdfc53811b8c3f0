//! Primary rays compared with exact integer arithmetic: through corners, along sides, in planes of
//! faces, from far away.
//!
//! Corners and origins are small integers. Directions are used exactly as stored in f64, as integer
//! multiples of a power of two. The signs that determine which triangles a ray meets then fit into
//! 128 bits.

use crate::reference::Numbers;
use glam::DVec3;
use sphvar_scene::{Mesh, Scene};

type Whole = [i64; 3];

fn vector(p: Whole) -> DVec3 {
    DVec3::from_array(p.map(|x| x as f64))
}

/// Returns a component of a unit vector in units of 2^-70, if it is an integer multiple of them.
fn units(x: f64) -> Option<i128> {
    let scaled = x * 70f64.exp2();
    #[expect(clippy::cast_possible_truncation, reason = "at most 2^70")]
    (scaled.fract() == 0.0).then_some(scaled as i128)
}

fn difference(a: Whole, b: Whole) -> [i128; 3] {
    std::array::from_fn(|i| i128::from(a[i] - b[i]))
}

fn cross(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

fn dot(a: [i128; 3], b: [i128; 3]) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The exact result for a ray and a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Exact {
    /// Hit at this distance, clear of the sides.
    Met(f64),
    Missed,
    /// Within a few roundings of a side or of the plane: both results are acceptable.
    Doubtful,
}

/// The rounding of a ray's direction as seen from its origin.
const DOUBT: f64 = 1e-14;

fn exact(origin: Whole, dir: [i128; 3], corners: [Whole; 3]) -> Exact {
    let [a, b, c] = corners.map(|p| difference(p, origin));
    let length = |v: [i128; 3]| v.iter().map(|&x| (x as f64).powi(2)).sum::<f64>().sqrt();
    let sides = [[a, b], [b, c], [c, a]].map(|[p, q]| {
        let plane = cross(p, q);
        // The sine of the angle to the plane of the side.
        let scale = length(dir) * length(p) * length(q);
        (dot(dir, plane), dot(dir, plane) as f64 / scale.max(1.0))
    });
    let normal = cross(difference(corners[1], corners[0]), difference(corners[2], corners[0]));
    let (height, approach) = (dot(a, normal), dot(dir, normal));
    if height == 0 {
        // Surfaces that contain the origin are not intersected.
        return Exact::Missed;
    }
    let distance = height as f64 / approach as f64 * 70f64.exp2();
    let clear = |sign: f64| sides.iter().all(|&(_, sine)| sign * sine > DOUBT);
    if (clear(1.0) || clear(-1.0)) && approach != 0 {
        return if distance > 0.0 { Exact::Met(distance) } else { Exact::Missed };
    }
    let beyond = |sign: f64| sides.iter().any(|&(_, sine)| sign * sine > DOUBT);
    if beyond(1.0) && beyond(-1.0) { Exact::Missed } else { Exact::Doubtful }
}

/// Returns a direction that normalization leaves unchanged.
fn exact_direction(dir: DVec3) -> Option<DVec3> {
    let mut dir = dir.normalize();
    for _ in 0..10 {
        let again = dir.normalize();
        if again == dir {
            return Some(dir);
        }
        dir = again;
    }
    None
}

/// Returns closed surfaces with integer coordinates as lists of triangles.
fn shapes() -> Vec<(&'static str, bool, Vec<[Whole; 3]>)> {
    let octahedron = |r: i64| {
        let at = |i: usize, s: i64| std::array::from_fn(|k| if k == i { s * r } else { 0 });
        let sign = |octant: i32, axis: i32| if octant >> axis & 1 == 0 { 1 } else { -1 };
        let face =
            |octant| [at(0, sign(octant, 0)), at(1, sign(octant, 1)), at(2, sign(octant, 2))];
        (0..8).map(face).collect::<Vec<[Whole; 3]>>()
    };
    // A grid of squares on each side of a box.
    let boxed = |n: i64, step: i64| {
        let half = n * step / 2;
        let mut triangles = Vec::new();
        for (axis, side) in [0, 1, 2].into_iter().flat_map(|axis| [(axis, -half), (axis, half)]) {
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let at = |i: i64, j: i64| -> Whole {
                    let mut p = [0; 3];
                    p[axis] = side;
                    p[(axis + 1) % 3] = i * step - half;
                    p[(axis + 2) % 3] = j * step - half;
                    p
                };
                triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        triangles
    };
    let mut nested = boxed(2, 200);
    nested.extend(octahedron(100));
    nested.extend(boxed(4, 10));
    // A needle-shaped tetrahedron.
    let [a, b, c, d] = [[-500, 0, 0], [500, 1, 0], [500, 0, 1], [500, -1, -1]];
    let needle = vec![[a, b, c], [a, c, d], [a, d, b], [b, d, c]];
    // Two octahedra that touch in a corner.
    let mut touching = octahedron(100);
    touching.extend(octahedron(100).into_iter().map(|t| t.map(|[x, y, z]| [x + 200, y, z])));
    vec![
        ("octahedron", true, octahedron(64)),
        ("box", true, boxed(1, 128)),
        ("squares of a box", true, boxed(8, 16)),
        ("nested shells", true, nested),
        ("needle", false, needle),
        ("touching octahedra", true, touching),
    ]
}

#[test]
fn rays_agree_with_integer_arithmetic() {
    let mut numbers = Numbers(5);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let (mut n_rays, mut n_certain) = (0, 0);
    for (name, around_0, triangles) in shapes() {
        // No two triangles share a vertex index.
        let vertices = triangles.as_flattened().iter().map(|&p| vector(p)).collect();
        let faces = (0..).take(triangles.len()).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let scene = Scene::from_mesh(Mesh::new(vertices, faces).expect("a mesh"));
        for ray in 0..4000 {
            let spread = [2.0, 40.0, 600.0, 1e6][ray % 4];
            let place =
                spread * (2.0 * DVec3::new(numbers.unit(), numbers.unit(), numbers.unit()) - 1.0);
            #[expect(clippy::cast_possible_truncation, reason = "at most 1e6")]
            let mut origin = place.to_array().map(|x| x.round() as i64);
            // In planes of faces, and in line with corners.
            if ray % 3 == 0 {
                let corner = triangles[numbers.below(triangles.len())][0];
                let axis = numbers.below(3);
                origin[axis] = corner[axis];
            }
            let [a, b, c] = triangles[numbers.below(triangles.len())].map(vector);
            let from = vector(origin);
            let towards = match ray / 4 % 6 {
                0 => a - from,
                1 => (a + b) / 2.0 - from,
                2 => b - a,
                3 => axes[numbers.below(3)] * [1.0, -1.0][numbers.below(2)],
                4 => (a + b + c) / 3.0 - from,
                _ => a.lerp(b, numbers.unit()).lerp(c, 1e-9 * numbers.unit()) - from,
            };
            let Some(dir) = exact_direction(towards).filter(|dir| dir.is_finite()) else {
                continue;
            };
            let Some(wide) = dir.to_array().into_iter().map(units).collect::<Option<Vec<_>>>()
            else {
                continue;
            };
            let wide = [wide[0], wide[1], wide[2]];
            let answers = triangles.iter().map(|&t| exact(origin, wide, t)).collect::<Vec<_>>();
            let nearest = answers.iter().filter_map(|a| match a {
                Exact::Met(distance) => Some(*distance),
                _ => None,
            });
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            let doubtful = answers.contains(&Exact::Doubtful);
            let hit = scene.closest_hit(from, dir);
            let case = format!("{name}: from {origin:?} to {dir}: {hit:?}, {nearest}");
            let tolerance = 1e-12 * (nearest.min(2e6) + from.length() + 1e3);
            match hit {
                None => assert!(nearest.is_infinite(), "{case}"),
                Some(hit) => {
                    assert!(hit.distance <= nearest + tolerance, "{case}");
                    let answer = answers[hit.primitive];
                    assert!(answer != Exact::Missed, "{case}");
                    assert!(doubtful || (hit.distance - nearest).abs() <= tolerance, "{case}");
                }
            }
            // Strictly inside the outermost surface every ray meets something, whether or not it is
            // doubtful.
            let inside = around_0 && from.abs().element_sum() < 60.0;
            assert!(!inside || hit.is_some(), "{case}");
            n_rays += 1;
            n_certain += u32::from(!doubtful);
        }
    }
    assert!(n_rays > 15_000 && n_certain * 4 > n_rays, "{n_rays}, {n_certain} certain");
}
