//! Primary rays compared with the slow definition.

use crate::reference::{Numbers, Reference};
use glam::DVec3;
use sphvar_scene::{CornellBox, Hit, Mesh, Quad, Reach, Scene};

/// Hits agree to `tolerance`, except where a ray passes so close to an edge that both results are
/// acceptable.
fn agree(scene: &Scene, reference: &Reference, origin: DVec3, dir: DVec3, tolerance: f64) -> bool {
    let got = scene.closest_hit(origin, dir);
    let case = || {
        format!("from {origin} towards {dir}: {got:?}, not {:?}", reference.closest(origin, dir))
    };
    if let Some(Hit { position, normal, distance, primitive }) = got {
        assert!(primitive < scene.n_primitives(), "{}", case());
        assert!((normal.length() - 1.0).abs() < 8.0 * f64::EPSILON, "{}", case());
        assert!(normal.dot(dir) <= 0.0, "{}", case());
        assert!(position.is_finite() && distance > 0.0, "{}", case());
    }
    match (got, reference.closest(origin, dir)) {
        (None, None) => true,
        (Some(hit), Some((distance, _))) if (hit.distance - distance).abs() <= tolerance => {
            let on_ray = origin + distance * dir;
            assert!(hit.position.distance(on_ray) <= tolerance, "{}", case());
            true
        }
        _ => {
            // An edge within a few roundings of the coordinates, as seen from the origin.
            let at = Hit { position: origin, normal: dir, distance: 0.0, primitive: 0 };
            let margin = reference.margin(&at, origin, dir, f64::INFINITY);
            assert!(margin <= 64.0 * f64::EPSILON, "{}, {margin:e} from an edge", case());
            false
        }
    }
}

/// Rays from many origins: random ones, along the axes, and through points on edges and corners.
fn survey(scene: &Scene, reference: &Reference) {
    let mut numbers = Numbers(11);
    let bounds = scene.bounds();
    let (size, center) = (bounds.size(), bounds.center());
    let mut n_doubtful = 0;
    let n_rays = 6000;
    for i in 0..n_rays {
        let away = [0.3, 1.0, 30.0][i % 3];
        let origin = center + away * size * numbers.unit() * numbers.direction();
        let dir = match i / 3 % 4 {
            0 => numbers.direction(),
            1 => (numbers.inside(bounds.min, bounds.max) - origin).normalize(),
            2 => (reference.near_edges(&mut numbers) - origin).normalize(),
            _ => [DVec3::X, DVec3::NEG_Y, DVec3::Z][numbers.below(3)],
        };
        // Distances are sums and quotients of coordinates; for oblique rays their roundings are
        // magnified.
        let tolerance = 1e-9 * size;
        n_doubtful += usize::from(!agree(scene, reference, origin, dir, tolerance));
    }
    assert!(n_doubtful * 4 < n_rays, "{n_doubtful} of {n_rays} at edges");
}

#[test]
fn box_agrees() {
    let scene = CornellBox::new().scene;
    survey(&scene, &Reference::of_quads(scene.quads()));
}

/// Many overlapping triangles, some of them without area, some very thin.
#[test]
fn heap_of_triangles_agrees() {
    let mut numbers = Numbers(5);
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for i in 0..500 {
        let first = 3 * i;
        let a = numbers.inside(-DVec3::ONE, DVec3::ONE);
        let (u, v) = (0.3 * numbers.direction(), 0.3 * numbers.direction());
        vertices.extend(match i % 5 {
            0 => [a, a + u, a + 0.25 * u],
            1 => [a, a, a],
            2 => [a, a + u, a + 0.5 * u + 1e-7 * v],
            _ => [a, a + u, a + v],
        });
        faces.push([first, first + 1, first + 2]);
    }
    let mesh = Mesh::new(vertices, faces).expect("a mesh");
    assert!((300..=400).contains(&mesh.n_triangles()), "{} have an area", mesh.n_triangles());
    let reference = Reference::of_triangles((0..mesh.n_triangles()).map(|i| mesh.triangle(i)));
    survey(&Scene::from_mesh(mesh), &reference);
}

#[test]
fn one_triangle_at_any_scale() {
    for scale in [1e-95, 1e-3, 1.0, 1e95] {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|c| c * scale);
        let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).expect("a triangle");
        let scene = Scene::from_mesh(mesh);
        let origin = DVec3::new(0.25, 0.25, 2.0) * scale;
        let hit = scene.closest_hit(origin, DVec3::NEG_Z).expect("the triangle");
        assert!((hit.distance / scale - 2.0).abs() < 8.0 * f64::EPSILON, "{scale:e}: {hit:?}");
        assert_eq!((hit.normal, hit.primitive), (DVec3::Z, 0));
        assert_eq!(scene.closest_hit(origin, DVec3::Z), None);
        assert_eq!(scene.closest_hit(origin, DVec3::X), None);
    }
}

/// Sizes from 1 to 1e-60: nested boxes, as deep as a hierarchy can be.
#[test]
fn triangles_of_all_sizes_are_all_met() {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for i in 0..200 {
        let size = 0.5f64.powi(i);
        let first = 3 * u32::try_from(i).expect("small");
        let corners =
            [DVec3::new(1.0, 0.0, 0.0), DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 0.0, 1.0)];
        vertices.extend(corners.map(|c| c * size));
        faces.push([first, first + 1, first + 2]);
    }
    let scene = Scene::from_mesh(Mesh::new(vertices, faces).expect("a mesh"));
    let dir = DVec3::new(1.0, 0.25, 0.25).normalize();
    // From the origin all of them are in line; the small ones are below the accuracy of the large
    // ones.
    for i in 0..20 {
        let from = 0.75 * 0.5f64.powi(i);
        let hit = scene.closest_hit(dir * from, dir).expect("a triangle");
        let next = 0.5f64.powi(i) * dir.x.recip();
        let next = if from * dir.x < 0.5f64.powi(i) { next } else { 2.0 * next };
        assert!((hit.distance + from - next).abs() < 1e-12, "{i}: {hit:?}");
    }
}

#[test]
fn many_triangles_at_one_place() {
    let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let scene = Scene::from_mesh(Mesh::new(vertices, vec![[0, 1, 2]; 5000]).expect("a mesh"));
    let origin = DVec3::new(0.25, 0.25, 1.0);
    let hit = scene.closest_hit(origin, DVec3::NEG_Z).expect("one of them");
    assert!((hit.distance - 1.0).abs() < 4.0 * f64::EPSILON, "{hit:?}");
    let above = Hit { position: origin, normal: DVec3::NEG_Z, ..hit };
    let mut occluded = [false; 2];
    let dirs = [DVec3::NEG_Z, DVec3::new(0.9, 0.9, -1.0).normalize()];
    scene.occlusion_into(&above, &dirs, Reach::Within(2.0), &mut occluded);
    assert_eq!(occluded, [true, false]);
}

#[test]
fn walls_far_from_the_origin_of_coordinates() {
    let corner = DVec3::new(1e8, -2e8, 3e8);
    let quad =
        Quad::new([corner, corner + DVec3::X, corner + DVec3::X + DVec3::Y, corner + DVec3::Y])
            .expect("a square");
    let scene = Scene::from_quads(vec![quad]).expect("a wall");
    let hit =
        scene.closest_hit(corner + DVec3::new(0.5, 0.5, 1.0), DVec3::NEG_Z).expect("the wall");
    assert!((hit.distance - 1.0).abs() < 3e8 * 4.0 * f64::EPSILON, "{hit:?}");
}
