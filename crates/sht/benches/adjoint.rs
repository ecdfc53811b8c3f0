//! The adjoint transform of random points, exact and fast.

use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace};

/// Directions without order: successive additive recurrences of two irrational steps.
fn points(n: usize) -> Vec<DVec3> {
    let fraction = |k: usize, step: f64| (k as f64 * step).fract();
    (0..n)
        .map(|k| {
            let z = 1.0 - 2.0 * fraction(k, 0.754_877_666_246_693);
            let phi = TAU * fraction(k, 0.569_840_290_998_053);
            let s = (1.0 - z * z).sqrt();
            DVec3::new(s * phi.cos(), s * phi.sin(), z)
        })
        .collect()
}

fn exact(c: &mut Criterion) {
    let mut group = c.benchmark_group("exact");
    for (n, lmax) in [(1024, 128), (4096, 256)] {
        let points = points(n);
        let transform = ExactTransform::new(lmax).expect("a small degree");
        let (mut workspace, mut alm) =
            (ExactWorkspace::default(), Alm::zeros(lmax).expect("small"));
        group.throughput(Throughput::Elements(n as u64));
        group.bench_function(BenchmarkId::from_parameter(format!("{n}/{lmax}")), |b| {
            b.iter(|| transform.adjoint_into(black_box(&points), None, &mut workspace, &mut alm));
        });
    }
    group.finish();
}

fn fast(c: &mut Criterion) {
    let mut group = c.benchmark_group("fast");
    group.measurement_time(Duration::from_secs(3)).sample_size(20);
    for (n, lmax) in [(1024, 128), (4096, 256), (4096, 512), (100_000, 1024)] {
        let points = points(n);
        for epsilon in [1e-5, 1e-12] {
            let plan = FastTransform::new(lmax, epsilon).expect("a small degree");
            let (mut workspace, mut alm) =
                (FastWorkspace::default(), Alm::zeros(lmax).expect("small"));
            group.throughput(Throughput::Elements(n as u64));
            let id = BenchmarkId::new(format!("{n}/{lmax}"), epsilon);
            group.bench_function(id, |b| {
                b.iter(|| plan.adjoint_into(black_box(&points), None, &mut workspace, &mut alm));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, exact, fast);
criterion_main!(benches);
