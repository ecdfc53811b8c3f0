//! Measures the time to generate one set of every pattern on one thread with warm buffers, in
//! points per second.
//!
//! An id is group/pattern/number of points, so that
//! `cargo bench -p sphvar-samplers -- 'ccvt/.*capacity=256.*/1024'` runs a selection. Jittered sets
//! and HEALPix use the nearest valid count.
//! `cargo run --release -p sphvar-tests --example pattern_growth` shows how times grow with the
//! number of points.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sphvar_samplers::{
    CcvtParameters, DiskMode, Domain, JitteredSquare, MassPoints, OnSphere, Pattern, PointSet,
    PoissonDiskParameters, Purpose, Sampler, SpectralControl, StepParameters, Streams,
};

const VALID: &str = "a valid number of points and valid parameters";

/// A sampler to time, and its name with parameters.
type Named = (String, Box<dyn Sampler>);

fn named(pattern: &Pattern, n_points: usize) -> Named {
    let n_points = pattern.nearest_count(n_points, Domain::Sphere);
    (pattern.to_string(), pattern.build(n_points, Domain::Sphere).expect(VALID))
}

/// Realizations differ from one iteration to the next, as those of an ensemble do.
fn bench(c: &mut Criterion, group: &str, samplers: Vec<Named>) {
    let mut group = c.benchmark_group(group);
    group.sample_size(10).warm_up_time(Duration::from_millis(300));
    group.measurement_time(Duration::from_secs(1));
    for (name, sampler) in samplers {
        let n_points = sampler.n_points();
        group.throughput(Throughput::Elements(n_points as u64));
        group.bench_function(BenchmarkId::new(name, n_points), |b| {
            let streams = Streams::new(0, Purpose::Pattern, n_points);
            let mut set = PointSet::new(Vec::with_capacity(n_points));
            let mut realization = 0;
            b.iter(|| {
                let mut rng = streams.realization(black_box(realization));
                realization += 1;
                black_box(&sampler).sample_into(&mut rng, &mut set).expect("a realization");
                black_box(&mut set);
            });
        });
    }
    group.finish();
}

fn elementary(c: &mut Criterion) {
    let samplers = Pattern::ELEMENTARY
        .iter()
        .flat_map(|pattern| [10_000, 1_000_000].map(|n| named(pattern, n)))
        .collect();
    bench(c, "elementary", samplers);
}

fn poisson_disk(c: &mut Criterion) {
    let samplers = [DiskMode::Exact, DiskMode::Saturated]
        .into_iter()
        .flat_map(|mode| {
            let pattern = Pattern::PoissonDisk(PoissonDiskParameters {
                mode,
                ..PoissonDiskParameters::DEFAULT
            });
            [1024, 4096, 32_768, 262_144, 1_000_000].map(|n| named(&pattern, n))
        })
        .collect();
    bench(c, "poisson-disk", samplers);
}

/// Whole tessellations, from the mass points to the last exchange.
fn ccvt(c: &mut Criterion) {
    let samplers = [(1024, 64), (4096, 64), (16_384, 64), (1024, 256)]
        .into_iter()
        .flat_map(|(n, capacity)| {
            [MassPoints::White, MassPoints::Fibonacci]
                .map(|mass| named(&Pattern::Ccvt(CcvtParameters { capacity, mass }), n))
        })
        .collect();
    bench(c, "ccvt", samplers);
}

/// From white noise to a spectrum without power at low degrees, with and without further
/// requirements.
fn spectral_control(c: &mut Criterion) {
    let bare = Pattern::Step(StepParameters { alpha: None, flat: Some(0.0), core: 0.0 });
    let full =
        Pattern::Step(StepParameters { alpha: None, flat: None, core: SpectralControl::STEP_CORE });
    let samplers = [bare, full]
        .iter()
        .flat_map(|pattern| [256, 1024, 4096].map(|n| named(pattern, n)))
        .collect();
    bench(c, "spectral-control", samplers);
}

fn survey(c: &mut Criterion) {
    const LINEAR: [&str; 7] =
        ["equal-area", "spiral", "sobol", "halton", "hammersley", "lloyd", "best-candidate"];
    // Large fractions of a second for a set of 4096.
    const EXPENSIVE: [&str; 2] = ["riesz", "leja"];
    let parsed = |name: &str| name.parse::<Pattern>().expect("the name of a pattern");
    let mut samplers = Vec::new();
    for name in LINEAR {
        samplers.extend([1024, 4096].map(|n| named(&parsed(name), n)));
    }
    samplers.extend(EXPENSIVE.map(|name| named(&parsed(name), 1024)));
    for n in [1024, 4096] {
        let square = JitteredSquare::nearest_to_square(n).expect(VALID);
        let square = Box::new(OnSphere::new(square, Domain::Sphere));
        samplers.push(("jittered-square".to_owned(), square));
    }
    bench(c, "survey", samplers);
}

criterion_group!(benches, elementary, poisson_disk, ccvt, spectral_control, survey);
criterion_main!(benches);
