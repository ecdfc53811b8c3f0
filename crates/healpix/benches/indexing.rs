//! Index look-ups and the cell map, beside `cdshealpix` on the same places.

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use sphvar_healpix::{Cell, Nested, Nside, PixelOrder, Ring};

/// Enough places to defeat the branch predictor's memory, few enough for the level-2 cache.
const N_PLACES: u32 = 4096;

/// Low, usual and largest resolution; powers of two, which all contestants take.
const DEPTHS: [u8; 3] = [4, 10, 29];

struct Place {
    dir: DVec3,
    lon: f64,
    lat: f64,
    u: f64,
    v: f64,
}

/// Uniform places; a multiplicative generator (`SplitMix64`) saves a dependency.
fn places() -> Vec<Place> {
    let mut state = 1_u64;
    let mut uniform = move || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        let top = u32::try_from((bits ^ (bits >> 31)) >> 32).expect("32 bits");
        f64::from(top) / (f64::from(u32::MAX) + 1.0)
    };
    (0..N_PLACES)
        .map(|_| {
            let z = 2.0 * uniform() - 1.0;
            let lon = TAU * uniform();
            let radius = ((1.0 - z) * (1.0 + z)).sqrt();
            Place {
                dir: DVec3::new(radius * lon.cos(), radius * lon.sin(), z),
                lon,
                lat: z.asin(),
                u: uniform(),
                v: uniform(),
            }
        })
        .collect()
}

fn indexing(criterion: &mut Criterion) {
    let places = places();
    for depth in DEPTHS {
        let nside = Nside::new(1 << depth).expect("a legal nside");
        let ring = Ring::new(nside);
        let nested = Nested::new(nside).expect("a power of two");
        let ring_pixels: Vec<u64> = places.iter().map(|p| ring.pixel(p.dir)).collect();
        let nested_pixels: Vec<u64> = places.iter().map(|p| nested.pixel(p.dir)).collect();

        let mut group = criterion.benchmark_group("vec2pix");
        group.throughput(Throughput::Elements(u64::from(N_PLACES)));
        group.bench_function(BenchmarkId::new("ring", nside), |b| {
            b.iter(|| sum(&places, |p| ring.pixel(p.dir)));
        });
        group.bench_function(BenchmarkId::new("nested", nside), |b| {
            b.iter(|| sum(&places, |p| nested.pixel(p.dir)));
        });
        let dirs: Vec<DVec3> = places.iter().map(|place| place.dir).collect();
        let mut pixels = vec![0; dirs.len()];
        group.bench_function(BenchmarkId::new("ring-list", nside), |b| {
            b.iter(|| ring.pixels_into(black_box(&dirs), black_box(&mut pixels)));
        });
        group.bench_function(BenchmarkId::new("nested-list", nside), |b| {
            b.iter(|| nested.pixels_into(black_box(&dirs), black_box(&mut pixels)));
        });
        group.bench_function(BenchmarkId::new("cdshealpix-ring-lonlat", nside), |b| {
            b.iter(|| sum(&places, |p| cdshealpix::ring::hash(nside.value(), p.lon, p.lat)));
        });
        let layer = cdshealpix::nested::get(depth);
        group.bench_function(BenchmarkId::new("cdshealpix-nested-lonlat", nside), |b| {
            b.iter(|| sum(&places, |p| layer.hash(p.lon, p.lat)));
        });
        group.bench_function(BenchmarkId::new("cdshealpix-nested-vector", nside), |b| {
            b.iter(|| {
                sum(&places, |p| {
                    let lon = p.dir.y.atan2(p.dir.x);
                    let lat = p.dir.z.atan2(p.dir.x.hypot(p.dir.y));
                    layer.hash(lon, lat)
                })
            });
        });
        group.finish();

        let mut group = criterion.benchmark_group("pix2vec");
        group.throughput(Throughput::Elements(u64::from(N_PLACES)));
        group.bench_function(BenchmarkId::new("ring", nside), |b| {
            b.iter(|| sum_vectors(&ring_pixels, |&pixel| ring.centre(pixel)));
        });
        group.bench_function(BenchmarkId::new("nested", nside), |b| {
            b.iter(|| sum_vectors(&nested_pixels, |&pixel| nested.centre(pixel)));
        });
        group.bench_function(BenchmarkId::new("cdshealpix-nested-lonlat", nside), |b| {
            b.iter(|| {
                sum_vectors(&nested_pixels, |&pixel| {
                    let (lon, lat) = layer.center(pixel);
                    DVec3::new(lon, lat, 0.0)
                })
            });
        });
        group.finish();

        let cells: Vec<Cell> = nested_pixels.iter().map(|&p| nested.cell(p)).collect();
        let mut group = criterion.benchmark_group("cell-map");
        group.throughput(Throughput::Elements(u64::from(N_PLACES)));
        group.bench_function(BenchmarkId::new("random-cells", nside), |b| {
            b.iter(|| {
                cells
                    .iter()
                    .zip(&places)
                    .map(|(cell, p)| cell.uniform_point(black_box(p.u), p.v))
                    .sum::<DVec3>()
            });
        });
        // What a jittered sampler does: pixels in turn.
        let stride = (nside.n_pixels() / u64::from(N_PLACES)).max(1);
        let in_order: Vec<u64> =
            (0..u64::from(N_PLACES)).map(|k| (k * stride) % nside.n_pixels()).collect();
        group.bench_function(BenchmarkId::new("ring-in-order", nside), |b| {
            b.iter(|| {
                in_order
                    .iter()
                    .zip(&places)
                    .map(|(&pixel, p)| ring.uniform_point(pixel, black_box(p.u), p.v))
                    .sum::<DVec3>()
            });
        });
        group.bench_function(BenchmarkId::new("inverse", nside), |b| {
            b.iter(|| {
                places
                    .iter()
                    .map(|p| {
                        let (cell, u, v) = Cell::invert_uniform_point(nside, black_box(p.dir));
                        u + v + f64::from(cell.ix())
                    })
                    .sum::<f64>()
            });
        });
        group.finish();
    }
}

fn sum(places: &[Place], pixel: impl Fn(&Place) -> u64) -> u64 {
    places.iter().map(|place| pixel(black_box(place))).fold(0, u64::wrapping_add)
}

fn sum_vectors(pixels: &[u64], dir: impl Fn(&u64) -> DVec3) -> DVec3 {
    pixels.iter().map(|pixel| dir(black_box(pixel))).sum()
}

criterion_group!(benches, indexing);
criterion_main!(benches);
