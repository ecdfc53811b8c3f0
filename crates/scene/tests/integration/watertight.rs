//! Closed surfaces have no holes: neither at sides nor at corners, at any size and position, for
//! rays along axes and in planes of faces.

use crate::reference::Numbers;
use glam::{DMat3, DVec3};
use sphvar_scene::{Camera, Hit, Mesh, Reach, Scene};

type Shape = (Vec<DVec3>, Vec<[u32; 3]>);

/// Returns closed surfaces that are star-shaped about 0.
fn shapes() -> Vec<(&'static str, Shape)> {
    vec![
        ("octahedron", octahedron()),
        ("box", cube()),
        ("globe", globe(9, 12)),
        ("icosphere", icosphere(2)),
        ("noisy icosphere", noisy(icosphere(2))),
    ]
}

fn octahedron() -> Shape {
    let vertices = vec![DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let faces =
        [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]];
    (vertices, faces.to_vec())
}

fn cube() -> Shape {
    let corner = |i: u32| {
        DVec3::from_array([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }))
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    ((0..8).map(corner).collect(), faces.collect())
}

/// Rings of triangles about the z axis; many corners have equal or nearly equal coordinates.
fn globe(n_rings: u32, n_around: u32) -> Shape {
    let mut vertices = vec![DVec3::Z];
    for ring in 1..n_rings {
        let theta = std::f64::consts::PI * f64::from(ring) / f64::from(n_rings);
        vertices.extend((0..n_around).map(|i| {
            let phi = std::f64::consts::TAU * f64::from(i) / f64::from(n_around);
            DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        }));
    }
    vertices.push(DVec3::NEG_Z);
    let at = |ring: u32, i: u32| 1 + (ring - 1) * n_around + i % n_around;
    let last = 1 + (n_rings - 1) * n_around;
    let mut faces = Vec::new();
    for i in 0..n_around {
        faces.push([0, at(1, i), at(1, i + 1)]);
        faces.push([last, at(n_rings - 1, i + 1), at(n_rings - 1, i)]);
        for ring in 1..n_rings - 1 {
            let [a, b, c, d] = [at(ring, i), at(ring, i + 1), at(ring + 1, i), at(ring + 1, i + 1)];
            faces.extend([[a, c, b], [b, c, d]]);
        }
    }
    (vertices, faces)
}

/// Returns the octahedron on the sphere, with each face repeatedly split into four.
fn icosphere(levels: u32) -> Shape {
    let (mut vertices, mut faces) = octahedron();
    for _ in 0..levels + 1 {
        let mut middles = std::collections::HashMap::new();
        let mut next = Vec::new();
        for [a, b, c] in faces {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    vertices.push((vertices[i as usize] + vertices[j as usize]).normalize());
                    u32::try_from(vertices.len() - 1).expect("small")
                })
            };
            let [x, y, z] = [middle(a, b), middle(b, c), middle(c, a)];
            next.extend([[a, x, z], [x, b, y], [z, y, c], [x, y, z]]);
        }
        faces = next;
    }
    (vertices, faces)
}

fn noisy((vertices, faces): Shape) -> Shape {
    let mut numbers = Numbers(9);
    (vertices.into_iter().map(|v| v * (0.8 + 0.4 * numbers.unit())).collect(), faces)
}

fn scene_of((vertices, faces): &Shape, place: impl Fn(DVec3) -> DVec3) -> (Scene, Vec<[DVec3; 3]>) {
    let vertices = vertices.iter().map(|&v| place(v)).collect();
    let mesh = Mesh::new(vertices, faces.clone()).expect("a mesh");
    let triangles = (0..mesh.n_triangles()).map(|i| mesh.triangle(i)).collect();
    (Scene::from_mesh(mesh), triangles)
}

/// Returns sizes, positions and rotations, with a bound on the distance of ray origins from the
/// centre of the shape.
fn places() -> Vec<(f64, DVec3, DMat3)> {
    let rotation = DMat3::from_rotation_x(0.3) * DMat3::from_rotation_z(0.7);
    vec![
        (1.0, DVec3::ZERO, DMat3::IDENTITY),
        (1e-6, DVec3::ZERO, DMat3::IDENTITY),
        (1e6, DVec3::ZERO, rotation),
        (1.0, DVec3::new(1e3, -2e4, 5e5), rotation),
        (1e-3, DVec3::new(1.0, 2.0, -3.0), DMat3::IDENTITY),
    ]
}

/// Returns points at corners, on sides and inside triangles.
fn targets(triangles: &[[DVec3; 3]], numbers: &mut Numbers) -> Vec<DVec3> {
    triangles
        .iter()
        .flat_map(|&[a, b, c]| [a, a.lerp(b, 0.5), b.lerp(c, numbers.unit()), (a + b + c) / 3.0])
        .collect()
}

#[test]
fn from_inside_every_ray_meets_the_surface() {
    let mut numbers = Numbers(1);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for (name, shape) in shapes() {
        for (size, offset, rotation) in places() {
            let (scene, triangles) = scene_of(&shape, |v| offset + size * (rotation * v));
            for start in 0..6 {
                // The centre, points on axes, and others.
                let away = match start {
                    0 => DVec3::ZERO,
                    1..=3 => 0.25 * axes[start - 1],
                    4 => numbers.inside(DVec3::splat(-0.3), DVec3::splat(0.3)),
                    _ => 0.4 * numbers.direction(),
                };
                let origin = offset + size * (rotation * away);
                let targets = targets(&triangles, &mut numbers);
                let dirs = targets.iter().map(|&target| target - origin);
                for dir in dirs.chain(axes).chain(axes.map(|axis| -axis)) {
                    let hit = scene.closest_hit(origin, dir);
                    assert!(hit.is_some(), "{name} {size:e} {offset}: from {origin} to {dir}");
                }
            }
        }
    }
}

#[test]
fn from_outside_rays_at_sides_and_corners_meet_the_surface() {
    let mut numbers = Numbers(2);
    for (name, shape) in shapes() {
        for (size, offset, rotation) in places() {
            let (scene, triangles) = scene_of(&shape, |v| offset + size * (rotation * v));
            for start in 0..20 {
                let away = match start {
                    0 => 4.0 * [DVec3::X, DVec3::Y, DVec3::Z][numbers.below(3)],
                    1 => DVec3::new(3.0, 1.0, 0.0),
                    _ => 5.0 * numbers.direction(),
                };
                let origin = offset + size * (rotation * away);
                // Rounding of directions must not move them across the outline.
                let faces_it = |t: &[DVec3; 3]| {
                    let [a, b, c] = *t;
                    let normal = (b - a).cross(c - a).normalize();
                    normal.dot((origin - a).normalize()) > 1e-3
                };
                let mut facing = std::collections::HashMap::<[u64; 3], (bool, DVec3)>::new();
                let key = |p: DVec3| p.to_array().map(f64::to_bits);
                for t in &triangles {
                    for corner in *t {
                        let all = facing.entry(key(corner)).or_insert((true, corner));
                        all.0 &= faces_it(t);
                    }
                }
                let corners = facing.values().filter(|(all, _)| *all).map(|&(_, corner)| corner);
                let sides = triangles
                    .iter()
                    .filter(|t| faces_it(t))
                    .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(|[p, q]| p.lerp(q, 0.5)));
                // Only sides of a single front-facing triangle can belong to the outline.
                let seen_twice = |p: &DVec3| {
                    let with = triangles.iter().filter(|t| {
                        let [a, b, c] = **t;
                        [[a, b], [b, c], [c, a]]
                            .iter()
                            .any(|[x, y]| x.lerp(*y, 0.5) == *p || y.lerp(*x, 0.5) == *p)
                    });
                    with.filter(|t| faces_it(t)).count() == 2
                };
                let sides = sides.filter(seen_twice).take(60);
                for target in corners.chain(sides) {
                    let hit = scene.closest_hit(origin, target - origin);
                    assert!(hit.is_some(), "{name} {size:e} {offset}: from {origin} at {target}");
                }
            }
        }
    }
}

/// An octahedron whose corners are out of the plane of its square by zero or very little, as
/// cos(pi/2) is, is visible in the pixels whose centres are within its square outline.
#[test]
fn an_octahedron_is_completely_visible() {
    for off in [0.0, 1e-12, -1e-12, 6.123233995736766e-17] {
        let (mut vertices, faces) = octahedron();
        for vertex in &mut vertices[..4] {
            vertex.z = off;
        }
        let scene = Scene::from_mesh(Mesh::new(vertices, faces).expect("a mesh"));
        let camera = Camera::look_at(4.0 * DVec3::X, DVec3::ZERO, DVec3::Z, 40f64.to_radians());
        let camera = camera.expect("a camera");
        let size = [65, 65];
        let pixels = (0..65 * 65).map(|i| (f64::from(i % 65) + 0.5, f64::from(i / 65) + 0.5));
        let seen = pixels.filter(|&(x, y)| {
            scene.closest_hit(camera.position(), camera.direction(x, y, size)).is_some()
        });
        // |y| + |z| <= 1 at distance 4, counted independently.
        assert_eq!(seen.count(), 1013, "{off:e}");
    }
}

fn open_share(scene: &Scene, hit: &Hit, numbers: &mut Numbers) -> f64 {
    let dirs = (0..2000).map(|_| {
        let dir = numbers.direction();
        if dir.dot(hit.normal) < 0.0 { -dir } else { dir }
    });
    let dirs = dirs.collect::<Vec<_>>();
    let mut occluded = vec![false; dirs.len()];
    scene.occlusion_into(hit, &dirs, Reach::Within(f64::INFINITY), &mut occluded);
    occluded.iter().filter(|o| !**o).count() as f64 / dirs.len() as f64
}

/// From inside nothing is open and from outside everything is, on faces, sides and corners alike.
#[test]
fn edges_and_corners_of_a_closed_box_are_dark_inside() {
    let mut numbers = Numbers(3);
    for (size, offset, rotation) in places() {
        let (scene, triangles) = scene_of(&cube(), |v| offset + size * (rotation * v));
        for (i, &[a, b, c]) in triangles.iter().enumerate() {
            let outwards = (b - a).cross(c - a).normalize();
            let points = [
                (a + b + c) / 3.0,
                a,
                b,
                c,
                a.lerp(b, 0.5),
                b.lerp(c, 0.3),
                c.lerp(a, 0.7),
                a.lerp(b, 1e-9),
            ];
            for position in points {
                let mut hit = Hit { position, normal: -outwards, distance: 1.0, primitive: i };
                let open = open_share(&scene, &hit, &mut numbers);
                assert!(open <= 0.0, "{size:e} {offset} {position}: {open}");
                hit.normal = outwards;
                let open = open_share(&scene, &hit, &mut numbers);
                // At sides and corners rays within about 1e-3 of the planes of other faces may be
                // lost.
                assert!(open >= 0.997, "outside: {size:e} {offset} {position}: {open}");
            }
        }
    }
}

fn tetrahedron() -> Shape {
    let vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
    let vertices = vertices.map(|v| DVec3::from_array(v.map(f64::from)));
    (vertices.to_vec(), vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
}

/// Returns a tube about the z axis whose centre line is the unit circle.
fn torus(n_along: u32, n_around: u32) -> Shape {
    let angle = |i: u32, n: u32| std::f64::consts::TAU * f64::from(i % n) / f64::from(n);
    let place = |i: u32, j: u32| {
        let (u, v) = (angle(i, n_along), angle(j, n_around));
        let r = 1.0 + 0.3 * v.cos();
        DVec3::new(r * u.cos(), r * u.sin(), 0.3 * v.sin())
    };
    let vertices = (0..n_along).flat_map(|i| (0..n_around).map(move |j| place(i, j))).collect();
    let at = |i: u32, j: u32| i % n_along * n_around + j % n_around;
    let squares = (0..n_along).flat_map(|i| (0..n_around).map(move |j| (i, j)));
    let faces = squares.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    (vertices, faces.collect())
}

/// Returns a roof with three sides that meet in a sharp ridge, closed at both ends: angles of 3
/// degrees and up.
fn wedge() -> Shape {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let w = 0.05;
    let vertices = vec![
        at(-1.0, -w, -1.0),
        at(1.0, -w, -1.0),
        at(1.0, w, -1.0),
        at(-1.0, w, -1.0),
        at(-1.0, 0.0, 1.0),
        at(1.0, 0.0, 1.0),
    ];
    let faces = vec![
        [0, 2, 1],
        [0, 3, 2],
        [0, 1, 5],
        [0, 5, 4],
        [2, 3, 4],
        [2, 4, 5],
        [3, 0, 4],
        [1, 2, 5],
    ];
    (vertices, faces)
}

/// For interior angles below 90 degrees, a point raised along the normal of one face would lie
/// behind the other face.
#[test]
fn sharp_edges_and_corners_are_dark_inside_and_open_outside() {
    let mut numbers = Numbers(21);
    let more_places = [
        (1.0, DVec3::new(1e9, -3e8, 2e8), DMat3::from_rotation_y(1.1)),
        (1e6, DVec3::new(0.0, 1e9, 1e9), DMat3::from_rotation_x(0.4)),
    ];
    let sharp = [("tetrahedron", tetrahedron()), ("wedge", wedge()), ("torus", torus(12, 8))];
    for (name, shape) in sharp.into_iter().chain(shapes()) {
        let convex = !["torus", "noisy icosphere"].contains(&name);
        let step = shape.1.len().div_ceil(6);
        for (size, offset, rotation) in places().into_iter().chain(more_places) {
            let (scene, triangles) = scene_of(&shape, |v| offset + size * (rotation * v));
            for (i, &[a, b, c]) in triangles.iter().enumerate().step_by(step) {
                let normal = (b - a).cross(c - a).normalize();
                let center = rotation.transpose() * ((a + b + c) / 3.0 - offset);
                let inside = if name == "torus" {
                    size * center.with_z(0.0).normalize()
                } else {
                    DVec3::ZERO
                };
                let outwards = normal.dot(a - offset - rotation * inside).signum() * normal;
                let at = |v: f64, w: f64| a + v * (b - a) + w * (c - a);
                let mut points =
                    vec![a, b, c, at(0.5, 0.0), at(0.3, 0.7), at(0.0, 0.9), at(1e-9, 1e-9)];
                for _ in 0..2 {
                    let near = 0.4 * 10f64.powf(-16.0 * numbers.unit());
                    points.push(at(near, numbers.unit() * (1.0 - near)));
                    points.push(at(numbers.unit() * (1.0 - near), near));
                    points.push(at(1.0 - 2.0 * near, near));
                }
                for position in points {
                    let mut hit = Hit { position, normal: -outwards, distance: 1.0, primitive: i };
                    let open = open_share(&scene, &hit, &mut numbers);
                    assert!(open <= 0.0, "{name}: {size:e} {offset} {position}: {open}");
                    hit.normal = outwards;
                    let open = open_share(&scene, &hit, &mut numbers);
                    // Close to a side, rays within about 1e-3 of the horizon may be lost.
                    assert!(
                        !convex || open >= 0.997,
                        "{name} outside: {size:e} {offset} {position}: {open}"
                    );
                }
            }
        }
    }
}

/// A block on a square of ground: a larger ground only increases the occlusion, wherever the block
/// is.
#[test]
fn more_ground_only_darkens() {
    for place in [DVec3::ZERO, DVec3::new(0.31, -0.27, 0.0)] {
        let mut before = 1.0;
        let mut first = None;
        for half_side in [1e2, 1e3, 1e4, 1e5, 1e6] {
            let center = half_side * place;
            let (mut vertices, mut faces) = noisy(icosphere(2));
            for v in &mut vertices {
                *v = 0.5 * *v + 0.6 * DVec3::Z + center;
            }
            let n = u32::try_from(vertices.len()).expect("small");
            let corner = |x: f64, y: f64| half_side * DVec3::new(x, y, 0.0);
            vertices.extend([corner(-1., -1.), corner(1., -1.), corner(1., 1.), corner(-1., 1.)]);
            faces.extend([[n, n + 1, n + 2], [n, n + 2, n + 3]]);
            let scene = Scene::from_mesh(Mesh::new(vertices, faces).expect("a mesh"));
            // The same rays relative to the block.
            let mut numbers = Numbers(4);
            let (mut sum, mut count) = (0.0, 0.0);
            for _ in 0..400 {
                let dir = numbers.direction();
                let from = center + 0.6 * DVec3::Z + 0.4 * numbers.direction() - 2.0 * dir;
                let Some(hit) = scene.closest_hit(from.with_z(from.z.abs()), dir) else { continue };
                if hit.position.distance(center) < 2.0 {
                    sum += open_share(&scene, &hit, &mut numbers);
                    count += 1.0;
                }
            }
            let mean = sum / count;
            // Coordinates of the block are rounded to those of its position, which changes a few
            // rays.
            assert!(mean <= before + 3e-4, "{place} {half_side:e}: {mean}, before {before}");
            let first = *first.get_or_insert(mean);
            assert!((first - mean).abs() < 0.01, "{place} {half_side:e}: {mean}, first {first}");
            before = mean;
        }
    }
}

/// Repeated triangles, triangles about a common centre, and triangles with a common corner, 30,000
/// of each.
#[test]
fn coinciding_triangles_are_fast() {
    let n = 30_000;
    let shape = |size: &dyn Fn(u32) -> f64, shift: &dyn Fn(u32) -> DVec3| {
        let corners = [DVec3::X, DVec3::new(-0.5, 0.75, 0.0), DVec3::new(-0.5, -0.75, 0.25)];
        let vertices = (0..n).flat_map(|i| corners.map(|c| size(i) * (c + shift(i)))).collect();
        let faces = (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh::new(vertices, faces).expect("a mesh")
    };
    let start = std::time::Instant::now();
    assert_eq!(shape(&|_| 1.0, &|_| DVec3::ZERO).n_triangles(), 1);
    let growing = |i: u32| 1.0 + f64::from(i);
    let halving = |i: u32| 0.999f64.powi(i32::try_from(i).expect("small") + 1);
    for size in [&growing as &dyn Fn(u32) -> f64, &halving] {
        for shift in [DVec3::ZERO, DVec3::NEG_X, DVec3::new(3.0, 2.0, 1.0)] {
            let mesh = shape(size, &|_| shift);
            assert_eq!(mesh.n_triangles(), n as usize);
            let scene = Scene::from_mesh(mesh);
            let origin = scene.bounds().max + DVec3::ONE;
            scene.closest_hit(origin, scene.bounds().center() - origin);
        }
    }
    // 180,000 triangles take about a second; an algorithm of order n^2 would take minutes.
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}

#[test]
fn a_mesh_too_far_from_the_origin_is_an_error() {
    let moved = |by: f64| {
        let (vertices, faces) = cube();
        Mesh::new(vertices.into_iter().map(|v| v + by).collect(), faces)
    };
    assert!(moved(1e12).is_ok());
    assert!(moved(1e14).is_err());
}

/// A million rays at corners and sides of surfaces with 8 to 131,072 triangles, from inside, and
/// from outside at front-facing triangles.
#[test]
#[ignore = "slow"]
fn a_million_rays_all_meet_the_surface() {
    let mut numbers = Numbers(8);
    let shapes = [
        octahedron(),
        cube(),
        globe(9, 12),
        globe(120, 200),
        icosphere(1),
        noisy(icosphere(3)),
        icosphere(6),
        noisy(icosphere(6)),
    ];
    let (mut n_rays, mut n_missed) = (0, 0);
    for shape in &shapes {
        let (scene, triangles) = scene_of(shape, |v| v);
        for _ in 0..125 {
            let inside = 0.4 * numbers.unit() * numbers.direction();
            let outside = 5.0 * numbers.direction();
            for _ in 0..1000 {
                let [a, b, _] = triangles[numbers.below(triangles.len())];
                let target = if numbers.unit() < 0.5 { a } else { a.lerp(b, numbers.unit()) };
                n_missed += u32::from(scene.closest_hit(inside, target - inside).is_none());
                n_rays += 1;
                // A ball of half the size is inside all of them: points in front of it cannot be on
                // the outline.
                let across = (target - outside).reject_from(outside).length();
                if across < 0.5 {
                    n_missed += u32::from(scene.closest_hit(outside, target - outside).is_none());
                    n_rays += 1;
                }
            }
        }
    }
    assert!(n_rays > 1_000_000 && n_missed == 0, "{n_missed} of {n_rays}");
}
