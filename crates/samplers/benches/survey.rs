//! Points per second of the patterns of the survey, on one thread.
//!
//! Parameters are the number of points; patterns that relax are given their default effort.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sphvar_samplers::{
    BestCandidate, Domain, EqualArea, GeneralizedSpiral, Halton, Hammersley, JitteredSquare, Lloyd,
    OnSphere, Placement, Purpose, Riesz, Sampler, Sobol, Streams,
};

fn sets(n: usize) -> Vec<(&'static str, Box<dyn Sampler>)> {
    const LEGAL: &str = "a small number of points";
    let domain = Domain::Sphere;
    vec![
        ("equal-area", Box::new(EqualArea::new(n, domain, Placement::Jittered).expect(LEGAL))),
        ("spiral", Box::new(GeneralizedSpiral::new(n, domain).expect(LEGAL))),
        ("sobol", Box::new(OnSphere::new(Sobol::new(n).expect(LEGAL), domain))),
        ("halton", Box::new(OnSphere::new(Halton::new(n).expect(LEGAL), domain))),
        ("hammersley", Box::new(OnSphere::new(Hammersley::new(n).expect(LEGAL), domain))),
        (
            "jittered-square",
            Box::new(OnSphere::new(JitteredSquare::nearest_to_square(n).expect(LEGAL), domain)),
        ),
        ("lloyd", Box::new(Lloyd::new(n, domain, Lloyd::DEFAULT_ITERATIONS).expect(LEGAL))),
        (
            "riesz",
            Box::new(
                Riesz::new(n, domain, Riesz::DEFAULT_S, Riesz::DEFAULT_ITERATIONS).expect(LEGAL),
            ),
        ),
        ("best-candidate", Box::new(BestCandidate::new(n, domain, 1).expect(LEGAL))),
    ]
}

fn survey(c: &mut Criterion) {
    for n in [1024, 4096] {
        let mut group = c.benchmark_group("survey");
        group.sample_size(10).warm_up_time(Duration::from_millis(300));
        group.measurement_time(Duration::from_secs(1)).throughput(Throughput::Elements(n as u64));
        for (name, sampler) in sets(n) {
            // Their cost grows as N^2: seconds a set.
            if n > 1024 && ["riesz", "best-candidate"].contains(&name) {
                continue;
            }
            group.bench_function(BenchmarkId::new(name, n), |b| {
                let mut rng = Streams::new(0, Purpose::Pattern, n).realization(0);
                let mut points = Vec::new();
                b.iter(|| {
                    sampler.sample_into(&mut rng, &mut points).expect("a realization");
                    black_box(&mut points);
                });
            });
        }
    }
}

criterion_group!(benches, survey);
criterion_main!(benches);
