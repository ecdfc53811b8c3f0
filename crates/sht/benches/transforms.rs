//! Times transforms between random points and coefficients, on one thread with warm workspaces.
//!
//! The benchmark parameters are points / degree, and the requested accuracy of the fast transform.

use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main,
};
use glam::DVec3;
use num_complex::Complex;
use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace};

/// Accuracies, one for a grid in f32 and one for f64.
const EPSILONS: [f64; 2] = [1e-5, 1e-12];

/// Returns unordered directions: an additive recurrence with two irrational steps.
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

fn zeros(lmax: usize) -> Alm {
    Alm::zeros(lmax).expect("a small degree")
}

/// Returns equal coefficients, real for m = 0.
fn flat(lmax: usize) -> Alm {
    let mut alm = zeros(lmax);
    alm.values_mut().fill(Complex::new(0.6, 0.8));
    alm.column_mut(0).fill(Complex::ONE);
    alm
}

fn plan(lmax: usize, epsilon: f64) -> FastTransform {
    FastTransform::new(lmax, epsilon).expect("a small degree")
}

fn id(n: usize, lmax: usize, epsilon: f64) -> BenchmarkId {
    BenchmarkId::new(format!("{n}/{lmax}"), format!("{epsilon:e}"))
}

fn group<'c>(c: &'c mut Criterion, name: &str) -> BenchmarkGroup<'c, WallTime> {
    let mut group = c.benchmark_group(name);
    group.sample_size(20).warm_up_time(Duration::from_secs(1));
    group.measurement_time(Duration::from_secs(2));
    group
}

fn exact_adjoint(c: &mut Criterion) {
    let mut group = group(c, "exact adjoint");
    for (n, lmax) in [(1024, 128), (4096, 256)] {
        let points = points(n);
        let transform = ExactTransform::new(lmax).expect("a small degree");
        let (mut workspace, mut alm) = (ExactWorkspace::default(), zeros(lmax));
        group.throughput(Throughput::Elements(n as u64));
        group.bench_function(BenchmarkId::from_parameter(format!("{n}/{lmax}")), |b| {
            b.iter(|| transform.adjoint_into(black_box(&points), None, &mut workspace, &mut alm));
        });
    }
    group.finish();
}

fn fast_adjoint(c: &mut Criterion) {
    let mut group = group(c, "fast adjoint");
    for (n, lmax) in [(1024, 128), (4096, 256), (4096, 512), (100_000, 1024)] {
        let points = points(n);
        for epsilon in EPSILONS {
            let plan = plan(lmax, epsilon);
            let (mut workspace, mut alm) = (FastWorkspace::default(), zeros(lmax));
            group.throughput(Throughput::Elements(n as u64));
            group.bench_function(id(n, lmax, epsilon), |b| {
                b.iter(|| plan.adjoint_into(black_box(&points), None, &mut workspace, &mut alm));
            });
        }
    }
    group.finish();
}

/// Measures sets per second in a batch of four that share the recurrence.
fn batch(c: &mut Criterion) {
    const SETS: usize = 4;
    let mut group = group(c, "fast adjoint, batch of 4");
    let (n, lmax) = (4096, 256);
    let points = points(SETS * n);
    let sets: Vec<_> = points.chunks(n).map(|set| (set, None)).collect();
    for epsilon in EPSILONS {
        let plan = plan(lmax, epsilon);
        let (mut workspace, mut alms) = (FastWorkspace::default(), vec![zeros(lmax); SETS]);
        group.throughput(Throughput::Elements(SETS as u64));
        group.bench_function(id(n, lmax, epsilon), |b| {
            b.iter(|| plan.adjoint_batch_into(black_box(&sets), &mut workspace, &mut alms));
        });
    }
    group.finish();
}

fn synthesis(c: &mut Criterion) {
    let mut group = group(c, "fast synthesis");
    for (n, lmax) in [(4096, 256), (100_000, 1024)] {
        let (points, alm, mut values) = (points(n), flat(lmax), vec![0.0; n]);
        for epsilon in EPSILONS {
            let (plan, mut workspace) = (plan(lmax, epsilon), FastWorkspace::default());
            group.throughput(Throughput::Elements(n as u64));
            group.bench_function(id(n, lmax, epsilon), |b| {
                b.iter(|| {
                    plan.synthesis_into(black_box(&alm), &points, &mut workspace, &mut values);
                });
            });
        }
    }
    group.finish();
}

fn gradient(c: &mut Criterion) {
    let mut group = group(c, "fast gradient");
    for (n, lmax) in [(4096, 256), (100_000, 1024)] {
        let (points, alm) = (points(n), flat(lmax));
        let (mut values, mut gradients) = (vec![0.0; n], vec![DVec3::ZERO; n]);
        for epsilon in EPSILONS {
            let (plan, mut workspace) = (plan(lmax, epsilon), FastWorkspace::default());
            group.throughput(Throughput::Elements(n as u64));
            group.bench_function(id(n, lmax, epsilon), |b| {
                b.iter(|| {
                    let alm = black_box(&alm);
                    plan.gradient_into(alm, &points, &mut workspace, &mut values, &mut gradients);
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, exact_adjoint, fast_adjoint, batch, synthesis, gradient);
criterion_main!(benches);
