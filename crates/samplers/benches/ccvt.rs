//! Whole tessellations, from the mass points to the last exchange.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sphvar_samplers::{Ccvt, Domain, MassPoints, Purpose, Sampler, Streams};

fn tessellations(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("ccvt");
    group.sample_size(10);
    for (n_points, capacity) in [(1024, 64), (4096, 64), (16384, 64), (1024, 256)] {
        group.throughput(Throughput::Elements(n_points as u64));
        for (name, mass_points) in
            [("white", MassPoints::White), ("fibonacci", MassPoints::Fibonacci)]
        {
            let ccvt = Ccvt::new(n_points, Domain::Sphere, capacity, mass_points)
                .expect("legal parameters");
            let id = BenchmarkId::new(format!("{name} capacity {capacity}"), n_points);
            group.bench_function(id, |bencher| {
                let streams = Streams::new(0, Purpose::Pattern, n_points);
                let mut points = Vec::new();
                let mut realization = 0;
                bencher.iter(|| {
                    let mut rng = streams.realization(black_box(realization));
                    realization += 1;
                    ccvt.sample_into(&mut rng, &mut points).expect("a realization");
                    points[0]
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, tessellations);
criterion_main!(benches);
