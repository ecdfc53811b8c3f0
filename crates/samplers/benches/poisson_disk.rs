//! Speed of Poisson disk sets: `cargo bench -p sphvar-samplers`.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sphvar_samplers::{DiskMode, Domain, PoissonDisk, Purpose, Sampler, Streams};

fn sets(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("poisson_disk");
    group.sample_size(10);
    for mode in [DiskMode::Exact, DiskMode::Saturated] {
        for n in [1024, 4096, 32_768, 262_144, 1_000_000] {
            let disks = PoissonDisk::new(n, Domain::Sphere, mode, None).expect("a legal pattern");
            let streams = Streams::new(0, Purpose::Pattern, n);
            let mut realization = 0;
            let mut points = Vec::new();
            group.throughput(Throughput::Elements(n as u64));
            group.bench_function(BenchmarkId::new(mode.name(), n), |b| {
                b.iter(|| {
                    realization += 1;
                    let mut rng = streams.realization(realization);
                    disks.sample_into(&mut rng, black_box(&mut points)).expect("a full set");
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, sets);
criterion_main!(benches);
