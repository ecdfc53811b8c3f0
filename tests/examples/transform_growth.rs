//! Prints the time of the fast adjoint as a function of the number of points and the degree, and
//! the fractions spent in spreading, Fourier transforms and the Legendre stage.
//!
//! `cargo run --release -p sphvar-tests --example transform_growth [EPSILON]`; uses one thread,
//! prints medians, and takes about a minute.
//!
//! The fractions are differences: an empty set has the cost of the grid, and the Legendre stage is
//! timed separately on the same number of rings. There it is that of the exact transform for any
//! epsilon, in f64 with values down to 1e-20. In a fast transform it is shorter, by up to 40 % at
//! 1e-5, and the fraction of the Fourier transforms larger by as much.

#![allow(clippy::print_stdout, reason = "the example prints a table")]

use std::f64::consts::{PI, TAU};
use std::time::Instant;

use glam::DVec3;
use num_complex::Complex;
use sphvar_sh::{Alm, Colatitude, Error};
use sphvar_sht::{FastTransform, FastWorkspace, RingTransform, RingWorkspace};

fn main() -> Result<(), Error> {
    let epsilon = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(1e-5);
    println!("epsilon {epsilon:e}, one thread; milliseconds\n");
    println!(
        "      N    L     total    ns/point  spreading  Fourier  Legendre  Gflop/s of Legendre"
    );
    for n in [1_000, 10_000, 100_000, 1_000_000, 10_000_000] {
        row(n, 1024, epsilon)?;
    }
    println!();
    for lmax in [128, 256, 512, 1024, 2048, 4096] {
        row(100_000, lmax, epsilon)?;
    }
    Ok(())
}

fn row(n_points: usize, lmax: usize, epsilon: f64) -> Result<(), Error> {
    let plan = FastTransform::new(lmax, epsilon)?;
    let points = spiral(n_points);
    let mut workspace = FastWorkspace::default();
    let mut alm = Alm::zeros(lmax)?;
    let total = median(|| plan.adjoint_into(&points, None, &mut workspace, &mut alm));
    let empty = median(|| plan.adjoint_into(&[], None, &mut workspace, &mut alm));
    let legendre = legendre(lmax, &mut alm)?;
    // Two degrees on one ring take three multiply-adds for the recurrence and four for the sums; a
    // ring and its reflection share the recurrence.
    let rings = (lmax + 2) as f64 / 2.0;
    let flops = 2.0 * 7.0 * rings * ((lmax + 1) as f64).powi(2) / 4.0;
    println!(
        "{n_points:8} {lmax:4} {:9.3} {:11.1} {:9.0}% {:7.0}% {:8.0}% {:10.1}",
        1e3 * total,
        1e9 * total / n_points as f64,
        100.0 * (total - empty) / total,
        100.0 * (empty - legendre).max(0.0) / total,
        100.0 * legendre / total,
        1e-9 * flops / legendre,
    );
    Ok(())
}

/// Returns the seconds of the Legendre stage on the rings of the grid for this degree.
fn legendre(lmax: usize, alm: &mut Alm) -> Result<f64, Error> {
    let transform = RingTransform::new(lmax)?;
    let last = lmax + 1;
    let colatitudes: Vec<Colatitude> = (0..=last)
        .map(|r| {
            // Bit-identical reflections, as in the grid, so that they share the recurrence.
            let (sin, cos) = (PI * r.min(last - r) as f64 / last as f64).sin_cos();
            let z = if 2 * r > last { -cos } else { cos };
            Colatitude::from_direction(DVec3::new(sin, 0.0, z))
        })
        .collect();
    let mut workspace = RingWorkspace::default();
    Ok(median(|| {
        let fourier = |_: usize, values: &mut [Complex<f64>]| values.fill(Complex::ONE);
        transform.adjoint_into(colatitudes.iter().copied(), fourier, &mut workspace, alm);
    }))
}

/// Returns the median time of several calls after a warm-up call.
fn median(mut call: impl FnMut()) -> f64 {
    call();
    let start = Instant::now();
    let mut times = Vec::new();
    while times.len() < 3 || (start.elapsed().as_secs_f64() < 0.7 && times.len() < 200) {
        let begun = Instant::now();
        call();
        times.push(begun.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Returns points over the whole sphere, in an order without spatial locality.
fn spiral(n_points: usize) -> Vec<DVec3> {
    (0..n_points)
        .map(|k| {
            let along = |step: f64| (k as f64 * step).fract();
            let (z, phi) =
                (1.0 - 2.0 * along(0.754_877_666_246_693), TAU * along(0.569_840_290_998_053));
            let rho = (1.0 - z * z).sqrt();
            DVec3::new(rho * phi.cos(), rho * phi.sin(), z)
        })
        .collect()
}
