use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use sphvar_healpix::{Cell, Nside};
use sphvar_samplers::{Domain, Pattern};
use sphvar_sh::{Alm, GaussLegendre};
use sphvar_sht::ExactTransform;
use sphvar_spectrum::ExactSpectrum;

/// A HEALPix cell as nodes and weights of a quadrature for the uniform distribution on it.
#[derive(Clone, Debug)]
pub struct Stratum {
    /// The number of cells of the sphere that this one represents, including itself: its images
    /// under quarter turns about z and the antipodal map.
    pub multiplicity: f64,
    /// The nodes.
    pub points: Vec<DVec3>,
    /// The weights, of sum 1.
    pub weights: Vec<f64>,
}

/// Returns the strata of HEALPix jitter, faces 0 and 4 only: multiplicities 8 and 4.
///
/// A cell is divided along u + v = 1, where the map changes its form in the cells that touch |z| =
/// 2/3, and each triangle is collapsed to its far corner, which may be a pole. The integrands are
/// therefore smooth, and the tensor rule with `nodes` points per edge converges like Gauss-Legendre
/// rules.
///
/// # Panics
///
/// If `nside` or `nodes` is 0.
#[must_use]
pub fn strata(nside: u32, nodes: usize) -> Vec<Stratum> {
    let nside = Nside::new(nside).expect("a valid nside");
    let rule = GaussLegendre::new(nodes).expect("at least one node");
    // Nodes of the unit interval, and of the triangle u + v <= 1 collapsed to the origin.
    let unit: Vec<(f64, f64)> =
        rule.nodes().iter().zip(rule.weights()).map(|(x, w)| (0.5 + 0.5 * x, 0.5 * w)).collect();
    let triangle: Vec<(f64, f64, f64)> = unit
        .iter()
        .flat_map(|&(s, ws)| unit.iter().map(move |&(t, wt)| (s * t, s * (1.0 - t), ws * wt * s)))
        .collect();
    let side = nside.value();
    let cells = [(0, 8.0), (4, 4.0)].into_iter().flat_map(|(face, multiplicity)| {
        (0..side * side).map(move |i| (face, i % side, i / side, multiplicity))
    });
    cells
        .map(|(face, ix, iy, multiplicity)| {
            let cell = Cell::new(nside, face, ix, iy).expect("within the face");
            let mut stratum = Stratum { multiplicity, points: Vec::new(), weights: Vec::new() };
            for &(u, v, w) in &triangle {
                for (u, v) in [(u, v), (1.0 - u, 1.0 - v)] {
                    stratum.points.push(cell.uniform_point(u, v));
                    stratum.weights.push(w);
                }
            }
            stratum
        })
        .collect()
}

/// Returns `P(l, m) = (4 pi/N) E |S_lm|^2` of HEALPix jitter that is not rotated, `m >= 0`.
///
/// ```text
/// P(l, m) = 1 - (4 pi/N) sum_k |E_k Y_lm|^2,   l >= 1
/// ```
///
/// with `E_k` the mean over cell k: one point in each cell, independent of the others, and
/// `E S_lm = 0`. The value is the real part; degree 0 is 0. It is computed by quadrature, without
/// sampling.
///
/// # Panics
///
/// If `nside` is 0.
#[must_use]
pub fn exact_jitter_orders(nside: u32, lmax: usize) -> Alm {
    // The phase across a cell is about l/nside, and n nodes follow a phase of 2n; 8 more leave
    // 1e-12.
    jitter_orders(nside, lmax, lmax / (2 * nside as usize) + 8)
}

fn jitter_orders(nside: u32, lmax: usize, nodes: usize) -> Alm {
    let transform = ExactTransform::new(lmax).expect("a small lmax");
    let n_points = 12.0 * f64::from(nside * nside);
    let cells = strata(nside, nodes);
    let means: Vec<Alm> = cells
        .par_iter()
        .map(|c| transform.adjoint(&c.points, Some(&c.weights)).expect("little memory"))
        .collect();
    let mut orders = Alm::zeros(lmax).expect("little memory");
    for (cell, mean) in cells.iter().zip(&means) {
        let factor = 4.0 * PI / n_points * cell.multiplicity;
        for (power, a) in orders.values_mut().iter_mut().zip(mean.values()) {
            power.re -= factor * a.norm_sqr();
        }
    }
    for power in orders.values_mut() {
        power.re += 1.0;
    }
    orders[(0, 0)].re = 0.0;
    orders
}

/// Returns the mean power per degree of HEALPix jitter, which is invariant under rotations.
///
/// # Panics
///
/// If `nside` is 0.
#[must_use]
pub fn exact_jitter_spectrum(nside: u32, lmax: usize) -> Vec<f64> {
    let n_points = 12 * (nside * nside) as usize;
    let sampler =
        Pattern::Jittered.build(n_points, Domain::Sphere).expect("a valid number of points");
    let exact = ExactSpectrum::of(&*sampler).expect("strata have one");
    exact.to(lmax, &()).expect("a degree in range").power().to_vec()
}

#[cfg(test)]
mod tests {
    use super::{Alm, exact_jitter_spectrum, jitter_orders, strata};
    use crate::ReferenceSpectrum;

    fn mean_over_orders(orders: &Alm, l: usize) -> f64 {
        let both_signs = (1..=l).map(|m| 2.0 * orders[(l, m)].re).sum::<f64>();
        (orders[(l, 0)].re + both_signs) / (2 * l + 1) as f64
    }

    #[test]
    fn the_weights_are_those_of_a_distribution() {
        let cells = strata(3, 7);
        let total: f64 = cells.iter().map(|c| c.multiplicity).sum();
        assert!((total - 108.0).abs() < 1e-12, "{total}");
        for cell in &cells {
            let sum: f64 = cell.weights.iter().sum();
            assert!((sum - 1.0).abs() < 1e-14, "{sum}");
        }
    }

    /// Fewer symmetries, another rule and the exact transform give a reference for the spectrum.
    #[test]
    fn the_mean_over_orders_is_the_spectrum() {
        for (nside, lmax) in [(1, 40), (2, 60), (5, 80)] {
            let got = exact_jitter_spectrum(nside, lmax);
            let orders = jitter_orders(nside, lmax, lmax / nside as usize + 24);
            for (l, p) in got.iter().enumerate().skip(1) {
                let expected = mean_over_orders(&orders, l);
                assert!((p - expected).abs() < 1e-12, "nside {nside}, l = {l}: {p}, {expected}");
            }
        }
    }

    /// The recorded spectra come from a coarser quadrature, whose error of 1.1e-5 relative in the
    /// lowest degrees and less above shows in their digits.
    #[test]
    fn the_spectrum_is_the_recorded_one() {
        for (nside, lmax, reference) in [
            (9, 126, ReferenceSpectrum::load("jitter_exact_972")),
            (18, 100, ReferenceSpectrum::load("jitter_exact_3888")),
        ] {
            let got = exact_jitter_spectrum(nside, lmax);
            for (l, (p, expected)) in got.iter().zip(reference.power()).enumerate().skip(1) {
                let relative = (p / expected - 1.0).abs();
                assert!(relative < 2e-5, "nside {nside}, l = {l}: {p}, recorded {expected}");
            }
        }
    }

    /// The midpoint rule in (u, v), extrapolated, with the map of Gorski et al. (2005) written out.
    #[test]
    fn degree_1_is_that_of_the_mean_vectors() {
        for nside in [1_u32, 2, 3, 9] {
            let n_points = 12.0 * f64::from(nside * nside);
            let sum = |per_cell: u32| -> f64 {
                let step = 1.0 / f64::from(nside * per_cell);
                let middle = |i: u32| step * (f64::from(i) + 0.5);
                let cell = |polar: bool, ix: u32, iy: u32| -> f64 {
                    let mut mean = glam::DVec3::ZERO;
                    for (i, j) in (0..per_cell).flat_map(|i| (0..per_cell).map(move |j| (i, j))) {
                        let (x, y) = (middle(ix * per_cell + i), middle(iy * per_cell + j));
                        let (z, eighths) = match 2.0 - x - y {
                            d if polar && d < 1.0 => (1.0 - d * d / 3.0, (x - y) / d),
                            d if polar => ((2.0 - d) * 2.0 / 3.0, x - y),
                            d => ((1.0 - d) * 2.0 / 3.0, x - y),
                        };
                        let (sin, cos) = (std::f64::consts::FRAC_PI_4 * eighths).sin_cos();
                        mean += glam::DVec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt();
                        mean.z += z;
                    }
                    mean.length_squared() / f64::from(per_cell).powi(4)
                };
                (0..nside * nside)
                    .map(|k| {
                        let (ix, iy) = (k % nside, k / nside);
                        8.0 * cell(true, ix, iy) + 4.0 * cell(false, ix, iy)
                    })
                    .sum()
            };
            // The error is of second order in the step.
            let (coarse, fine) = (sum(40), sum(80));
            let expected = 1.0 - (fine + (fine - coarse) / 3.0) / n_points;
            let got = exact_jitter_spectrum(nside, 1)[1];
            assert!(
                (got / expected - 1.0).abs() < 1e-6,
                "nside {nside}: {got}, extrapolated {expected}"
            );
        }
    }
}
