//! Throughput of the occlusion rays of hit points on one thread, in rays per second.
//!
//! An id is scene/kind/number of directions at a hit point. The directions are random over the
//! visible hemisphere, different at every point, and in random order. `endless` rays have no limit;
//! `near` rays have a reach of a tenth of the scene. Hit points are those seen through random
//! pixels, so that hardly any data of a point is in the cache from the previous one; in
//! `field-rows` they are those of neighbouring pixels, as in a picture. `hierarchy` is the result
//! of the crate that builds the hierarchy of the field for the same endless rays, each traced
//! separately.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::Ray;
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use sphvar_scene::{Camera, CornellBox, Hit, Mesh, Reach, Scene};

/// The numbers of directions at a hit point.
const N_DIRECTIONS: [usize; 3] = [16, 256, 4096];
/// The number of rays in one iteration.
const N_RAYS: usize = 1 << 16;

/// The height above surfaces at which the peer's rays start, in units of the size: vertices are
/// rounded to f32.
const CLEARANCE: f64 = 1.0 / (1u64 << 21) as f64;

/// The number of squares of the height field along each side: a million triangles.
const FIELD: u32 = 708;

/// A mixed Weyl sequence, sufficiently random for rays (Steele et al. 2014, `SplitMix64`).
struct Numbers(u64);

impl Numbers {
    /// Returns the next number in [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Returns a direction uniform over the hemisphere around `normal`.
    fn above(&mut self, normal: DVec3) -> DVec3 {
        let (z, phi) = (2.0 * self.unit() - 1.0, std::f64::consts::TAU * self.unit());
        let dir = ((1.0 - z * z).sqrt() * DVec3::new(phi.cos(), phi.sin(), 0.0)).with_z(z);
        if dir.dot(normal) < 0.0 { -dir } else { dir }
    }
}

/// Heights with hills of several sizes, so that a third of the rays from the surface meet it again.
fn height(x: f64, y: f64) -> f64 {
    (0..6).fold(0.0, |sum, octave| {
        let frequency = 7.0 * f64::from(1u32 << octave);
        sum + 0.6 / frequency * (frequency * x + y).sin() * (frequency * y - 2.0 * x).cos()
    })
}

fn field() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let place = |i: u32| f64::from(i) / f64::from(FIELD);
    let rows = (0..=FIELD).flat_map(|j| (0..=FIELD).map(move |i| (place(i), place(j))));
    let vertices = rows.map(|(x, y)| DVec3::new(x, y, height(x, y))).collect();
    let squares = (0..FIELD).flat_map(|j| (0..FIELD).map(move |i| j * (FIELD + 1) + i));
    let faces = squares.flat_map(|k| {
        let above = k + FIELD + 1;
        [[k, k + 1, above], [k + 1, above + 1, above]]
    });
    (vertices, faces.collect())
}

/// Hit points seen through pixels, each with directions.
type Work = Vec<(Hit, Vec<DVec3>)>;

/// The choice of pixels.
#[derive(Clone, Copy)]
enum Pixels {
    Random,
    Rows,
}

/// The size of the picture from which neighbouring pixels are taken, and of the part that they
/// fill, from its centre downwards.
const SIZE: [usize; 2] = [512, 512];
const ROW: usize = 64;

fn work(scene: &Scene, camera: &Camera, pixels: Pixels, n: usize) -> Work {
    let mut numbers = Numbers(1);
    let mut work = Vec::new();
    for pixel in 0.. {
        let (x, y) = match pixels {
            Pixels::Random => (512.0 * numbers.unit(), 512.0 * numbers.unit()),
            Pixels::Rows => ((224 + pixel % ROW) as f64, (256 + pixel / ROW % 256) as f64),
        };
        if let Some(hit) = scene.closest_hit(camera.position(), camera.direction(x, y, SIZE)) {
            work.push((hit, (0..n).map(|_| numbers.above(hit.normal)).collect()));
        }
        if work.len() * n >= N_RAYS {
            break;
        }
    }
    work
}

fn trace(scene: &Scene, work: &[(Hit, Vec<DVec3>)], reach: f64, occluded: &mut [bool]) {
    for (hit, dirs) in work {
        let occluded = &mut occluded[..dirs.len()];
        scene.occlusion_into(hit, dirs, Reach::Within(reach), occluded);
        black_box(occluded);
    }
}

fn bench_scene(
    c: &mut Criterion,
    name: &str,
    scene: &Scene,
    work: impl Fn(usize) -> Work,
    peer: Option<&Hierarchy>,
) {
    let mut group = c.benchmark_group(name);
    group.sample_size(10).warm_up_time(Duration::from_millis(300));
    group.measurement_time(Duration::from_secs(2)).throughput(Throughput::Elements(N_RAYS as u64));
    let near = 0.1 * scene.bounds().size();
    for n in N_DIRECTIONS {
        let work = work(n);
        let mut occluded = vec![false; n];
        for (name, reach) in [("endless", f64::INFINITY), ("near", near)] {
            group.bench_function(BenchmarkId::new(name, n), |b| {
                b.iter(|| trace(scene, black_box(&work), reach, &mut occluded));
            });
        }
        if let Some(peer) = peer {
            group.bench_function(BenchmarkId::new("hierarchy", n), |b| {
                b.iter(|| peer.trace(black_box(&work), CLEARANCE * scene.bounds().size()));
            });
        }
    }
    group.finish();
}

/// Rays traced one by one through the hierarchy, as its crate recommends.
struct Hierarchy {
    hierarchy: CwBvh,
    triangles: Vec<RtTriangle>,
}

impl Hierarchy {
    fn new(vertices: &[DVec3], faces: &[[u32; 3]]) -> Self {
        let triangles = faces.iter().map(|face| {
            let [v0, v1, v2] = face.map(|v| vertices[v as usize].as_vec3a());
            Triangle { v0, v1, v2 }
        });
        let triangles = triangles.collect::<Vec<_>>();
        let parameters = BvhBuildParams::medium_build();
        let hierarchy = build_cwbvh_from_tris(&triangles, parameters, &mut Duration::default());
        let order = hierarchy.primitive_indices.iter();
        let triangles = order.map(|&i| RtTriangle::from(&triangles[i as usize])).collect();
        Self { hierarchy, triangles }
    }

    fn trace(&self, work: &[(Hit, Vec<DVec3>)], clearance: f64) -> usize {
        let mut n_occluded = 0;
        for (hit, dirs) in work {
            let origin: Vec3A = (hit.position + clearance * hit.normal).as_vec3a();
            for dir in dirs {
                let ray = Ray::new_inf(origin, dir.as_vec3a());
                let missed = self
                    .hierarchy
                    .ray_traverse_miss(ray, |ray, i| self.triangles[i].intersect(ray));
                n_occluded += usize::from(!missed);
            }
        }
        n_occluded
    }
}

fn occlusion(c: &mut Criterion) {
    let CornellBox { scene, camera, .. } = CornellBox::new();
    bench_scene(c, "box", &scene, |n| work(&scene, &camera, Pixels::Random, n), None);

    let (vertices, faces) = field();
    let position = DVec3::new(0.5, -0.7, 1.0);
    let camera = Camera::look_at(position, DVec3::new(0.5, 0.45, 0.0), DVec3::Z, 0.8);
    let camera = camera.expect("a camera");
    let peer = Hierarchy::new(&vertices, &faces);
    let scene = Scene::from_mesh(Mesh::new(vertices, faces).expect("a mesh"));
    for (name, pixels) in [("field", Pixels::Random), ("field-rows", Pixels::Rows)] {
        bench_scene(c, name, &scene, |n| work(&scene, &camera, pixels, n), Some(&peer));
    }
}

criterion_group!(benches, occlusion);
criterion_main!(benches);
