//! Speed of columns and whole plans: `cargo bench -p sphvar-sh`.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sphvar_sh::{Colatitude, LegendrePlan, Recurrence};

fn columns(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("column");
    for lmax in [64, 1024, 20000] {
        let plan = LegendrePlan::new(lmax).expect("a supported degree");
        let colatitude = Colatitude::from_theta(1.1).expect("a colatitude");
        let m = lmax / 4;
        let mut out = vec![0.0; lmax + 1 - m];
        group.throughput(Throughput::Elements(out.len() as u64));
        group.bench_function(BenchmarkId::new("on_the_fly", lmax), |b| {
            b.iter(|| plan.column_into(m, black_box(colatitude), black_box(&mut out)));
        });
        let recurrence = Recurrence::new(m, lmax);
        group.bench_function(BenchmarkId::new("kept_coefficients", lmax), |b| {
            b.iter(|| recurrence.column_into(black_box(colatitude), black_box(&mut out)));
        });
    }
    group.finish();
}

fn plans(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("plan");
    for lmax in [16, 128, 1024] {
        let plan = LegendrePlan::new(lmax).expect("a supported degree");
        let mut out = vec![0.0; plan.index().len()];
        group.throughput(Throughput::Elements(out.len() as u64));
        for (name, theta) in [("middle", 1.1), ("near_pole", 0.01)] {
            let colatitude = Colatitude::from_theta(theta).expect("a colatitude");
            group.bench_function(BenchmarkId::new(name, lmax), |b| {
                b.iter(|| plan.eval_into(black_box(colatitude), black_box(&mut out)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, columns, plans);
criterion_main!(benches);
