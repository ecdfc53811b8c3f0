//! Occlusion rays, many at a time in single precision, compared with the slow definition in double
//! precision.

use crate::reference::{Numbers, Reference};
use glam::DVec3;
use sphvar_scene::{CornellBox, Hit, Mesh, Reach, Scene};

/// Returns whether a ray from above the surface is blocked within its reach, by the surface itself
/// or by another one.
fn is_occluded(reference: &Reference, at: &Hit, origin: DVec3, dir: DVec3, reach: f64) -> bool {
    dir.dot(at.normal) < 0.0 || reference.closest(origin, dir).is_some_and(|(t, _)| t <= reach)
}

/// The number of rays with a result other than the definition's, and the maximum angle by which
/// such a ray would have to be rotated for the same result.
#[derive(Debug)]
struct Differences {
    n_rays: usize,
    n_differ: usize,
    worst: f64,
}

/// Compares sets of directions at points all over a scene; half of the directions pass within 1e-5
/// to 1e-9 radians of an edge.
fn differences(scene: &Scene, reference: &Reference, n_points: usize, reach: f64) -> Differences {
    let mut numbers = Numbers(7);
    let bounds = scene.bounds();
    let (mut n_rays, mut n_differ, mut worst) = (0, 0, 0.0);
    for point in 0..n_points {
        let origin = numbers.inside(bounds.min, bounds.max);
        let Some(hit) = scene.closest_hit(origin, numbers.direction()) else { continue };
        let start = scene.ray_origin(&hit);
        // Sets of every length, including those that do not fill a SIMD vector.
        let dirs = (0..40 + point % 300).map(|i| match i % 2 {
            0 => numbers.direction(),
            _ => {
                let aside = 10f64.powf(-5.0 - 4.0 * numbers.unit()) * numbers.direction();
                ((reference.near_edges(&mut numbers) - start).normalize() + aside).normalize()
            }
        });
        let dirs = dirs.collect::<Vec<_>>();
        let mut occluded = vec![point % 2 == 0; dirs.len()];
        scene.occlusion_into(&hit, &dirs, Reach::Within(reach), &mut occluded);
        for (&dir, &got) in dirs.iter().zip(&occluded) {
            n_rays += 1;
            if got != is_occluded(reference, &hit, start, dir, reach) {
                n_differ += 1;
                worst = f64::max(worst, reference.margin(&hit, start, dir, reach));
            }
        }
    }
    Differences { n_rays, n_differ, worst }
}

/// The bound stated in the documentation.
const MARGIN: f64 = 9.0 * f32::EPSILON as f64;

fn reference_of(mesh: &Mesh) -> Reference {
    Reference::of_triangles((0..mesh.n_triangles()).map(|i| mesh.triangle(i)))
}

#[test]
fn box_differs_only_at_edges() {
    let cornell = CornellBox::new();
    let reference = Reference::of_quads(cornell.scene.quads());
    for reach in [f64::INFINITY, 300.0, 40.0] {
        let found = differences(&cornell.scene, &reference, 400, reach);
        assert!(found.n_rays > 40_000 && found.worst < MARGIN, "{reach}: {found:?}");
        // About one in ten of the rays close to an edge is within MARGIN of it.
        assert!(found.n_differ * 20 < found.n_rays, "{reach}: {found:?}");
    }
}

/// Returns a wavy height field of `2 n^2` triangles over the unit square.
fn field(n: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let place = |i: u32| f64::from(i) / f64::from(n);
    let height = |x: f64, y: f64| 0.1 * (17.0 * x).sin() * (11.0 * y + x).cos();
    let rows = (0..=n).flat_map(|j| (0..=n).map(move |i| (place(i), place(j))));
    let vertices = rows.map(|(x, y)| DVec3::new(x, y, height(x, y))).collect();
    let squares = (0..n).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
    let faces = squares.flat_map(|k| [[k, k + 1, k + n + 1], [k + 1, k + n + 2, k + n + 1]]);
    (vertices, faces.collect())
}

/// Vertices are rounded to 2^-25 of the size; as seen from most points that is less than the bound.
#[test]
fn meshes_of_any_scale_and_place_differ_only_at_edges() {
    let places = [
        (1.0, DVec3::ZERO),
        (1e-90, DVec3::ZERO),
        (3e-7, DVec3::new(1.0, -2.0, 0.5) * 1e-3),
        (1e90, DVec3::new(1e90, 0.0, -3e90)),
        (1.0, DVec3::new(1e5, -3e5, 2e5)),
    ];
    for (scale, offset) in places {
        let (vertices, faces) = field(12);
        let vertices = vertices.into_iter().map(|v| scale * v + offset).collect();
        let mesh = Mesh::new(vertices, faces).expect("a mesh");
        let reference = reference_of(&mesh);
        let scene = Scene::from_mesh(mesh);
        for reach in [f64::INFINITY, 0.2 * scale] {
            let found = differences(&scene, &reference, 300, reach);
            let case = format!("{scale:e}, {offset:?}, {reach:e}: {found:?}");
            assert!(found.n_rays > 20_000 && found.worst < MARGIN, "{case}");
            assert!(found.n_differ * 20 < found.n_rays, "{case}");
        }
    }
}

/// Returns a sphere of rings of triangles around the z axis, closed.
fn sphere(n_rings: u32, n_around: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut vertices = vec![DVec3::Z];
    for ring in 1..n_rings {
        let theta = std::f64::consts::PI * f64::from(ring) / f64::from(n_rings);
        vertices.extend((0..n_around).map(|i| {
            let phi = std::f64::consts::TAU * f64::from(i) / f64::from(n_around);
            DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        }));
    }
    vertices.push(DVec3::NEG_Z);
    let place = |ring: u32, i: u32| match ring {
        0 => 0,
        _ if ring == n_rings => 1 + (n_rings - 1) * n_around,
        _ => 1 + (ring - 1) * n_around + i % n_around,
    };
    let faces = (0..n_rings).flat_map(|ring| {
        (0..n_around).flat_map(move |i| {
            let [a, b] = [place(ring, i), place(ring, i + 1)];
            let [c, d] = [place(ring + 1, i), place(ring + 1, i + 1)];
            // At the poles one of the two has no area.
            [[a, c, b], [b, c, d]]
        })
    });
    (vertices, faces.collect())
}

#[test]
fn no_ray_leaves_a_closed_mesh() {
    let (vertices, faces) = sphere(24, 40);
    let mesh = Mesh::new(vertices.clone(), faces).expect("a mesh");
    assert_eq!(mesh.n_triangles(), 2 * 40 * 23, "those without area are left out");
    let corners = (0..mesh.n_triangles()).map(|i| mesh.triangle(i)).collect::<Vec<_>>();
    let scene = Scene::from_mesh(mesh);
    let mut numbers = Numbers(3);
    for _ in 0..40 {
        let inside = 0.9 * numbers.unit() * numbers.direction();
        let hit = scene.closest_hit(inside, numbers.direction()).expect("the sphere");
        let start = scene.ray_origin(&hit);
        // Through vertices, and along and across edges.
        let mut dirs = vertices.iter().map(|v| (v - start).normalize()).collect::<Vec<_>>();
        for [a, b, _] in &corners {
            dirs.extend([0.5, numbers.unit()].map(|t| (a.lerp(*b, t) - start).normalize()));
        }
        let mut occluded = vec![false; dirs.len()];
        scene.occlusion_into(&hit, &dirs, Reach::Within(f64::INFINITY), &mut occluded);
        let escaped = occluded.iter().position(|o| !o).map(|i| dirs[i]);
        assert_eq!(escaped, None, "from {start}");
    }
}

/// Rays share nodes and triangles, but no result depends on the others: those that reach a node
/// together test its children one after the other, few of them all children at once.
#[test]
fn rays_have_the_same_result_alone_and_together() {
    let (vertices, faces) = field(40);
    let mesh = Mesh::new(vertices, faces).expect("a mesh");
    let reference = reference_of(&mesh);
    let scene = Scene::from_mesh(mesh);
    let mut numbers = Numbers(11);
    let mut n_occluded = 0;
    for point in 0..40 {
        let above = numbers.inside(scene.bounds().min, scene.bounds().max).with_z(10.0);
        let Some(hit) = scene.closest_hit(above, DVec3::NEG_Z) else { continue };
        let start = scene.ray_origin(&hit);
        let axis = numbers.direction();
        // All around, close together, and through edges and corners.
        let dirs = (0..300 + point).map(|i| match i % 4 {
            0 => numbers.direction(),
            1 => (reference.near_edges(&mut numbers) - start).normalize(),
            _ => (axis + 0.01 * numbers.direction()).normalize(),
        });
        let dirs = dirs.collect::<Vec<_>>();
        let reaches = dirs.iter().map(|_| 4.0 * numbers.unit() - 0.5).collect::<Vec<_>>();
        let mut together = vec![false; dirs.len()];
        scene.occlusion_into(&hit, &dirs, Reach::Each(&reaches), &mut together);
        for ((dir, reach), together) in dirs.iter().zip(&reaches).zip(together) {
            let mut alone = [false];
            scene.occlusion_into(&hit, &[*dir], Reach::Each(&[*reach]), &mut alone);
            assert_eq!(alone, [together], "from {start} along {dir}, reach {reach}");
            n_occluded += usize::from(together);
        }
    }
    assert!((1000..10000).contains(&n_occluded), "{n_occluded}");
}

#[test]
fn degenerate_rays_have_a_result() {
    let hit = |scene: &Scene| {
        let center = scene.bounds().center();
        scene.closest_hit(center - 2.0 * scene.bounds().size() * DVec3::Z, DVec3::Z)
    };
    let (vertices, faces) = field(4);
    for scene in
        [CornellBox::new().scene, Scene::from_mesh(Mesh::new(vertices, faces).expect("a mesh"))]
    {
        let hit = hit(&scene).expect("the scene");
        let dirs = [DVec3::NAN, DVec3::ZERO, DVec3::INFINITY, DVec3::X * 1e300, DVec3::Y * 1e-300];
        let reaches = [1.0, f64::NAN, -1.0, f64::INFINITY, 0.0];
        let mut occluded = [false; 5];
        scene.occlusion_into(&hit, &dirs, Reach::Each(&reaches), &mut occluded);
        // A reach that is 0, negative or NaN includes nothing.
        let dirs = [hit.normal; 3];
        let mut occluded = [true; 3];
        scene.occlusion_into(&hit, &dirs, Reach::Each(&[0.0, -1.0, f64::NAN]), &mut occluded);
        assert_eq!(occluded, [false; 3]);
        scene.occlusion_into(&hit, &[], Reach::Each(&[]), &mut []);
        let wrong = Hit { position: DVec3::NAN, ..hit };
        scene.occlusion_into(&wrong, &dirs, Reach::Within(1.0), &mut occluded);
        for (origin, dir) in [
            (DVec3::NAN, DVec3::X),
            (DVec3::ZERO, DVec3::ZERO),
            (DVec3::ZERO, DVec3::INFINITY),
            (DVec3::splat(1e300), -DVec3::ONE),
            (DVec3::ZERO, DVec3::X * 1e300),
            (DVec3::ZERO, DVec3::X * 1e-300),
        ] {
            let met = scene.closest_hit(origin, dir);
            assert!(met.is_none_or(|hit| hit.position.is_finite()), "{origin} {dir}: {met:?}");
        }
    }
}
