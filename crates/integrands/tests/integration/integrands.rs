//! Every integrand's exact integral, energies and total agree with its values.
//!
//! The reference is quadrature of the values: a Gauss-Legendre rule over panels in theta, the
//! trapezoidal rule over phi. It is independent of the closed forms.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use num_complex::Complex;
use sphvar_integrands::{Cap, ClampedCosine, EnvironmentMap, Harmonic, Integrand, VonMisesFisher};
use sphvar_samplers::Domain;
use sphvar_sh::{GaussLegendre, ylm};

/// Returns nodes and weights of the reference quadrature over a domain, with panel limits at
/// `breaks`.
fn quadrature(
    domain: Domain,
    breaks: &[f64],
    per_panel: usize,
    n_phi: usize,
) -> Vec<(f64, f64, f64)> {
    let end = if domain == Domain::Sphere { PI } else { FRAC_PI_2 };
    let mut limits: Vec<f64> = breaks.iter().copied().filter(|&b| b > 0.0 && b < end).collect();
    limits.extend([0.0, end]);
    limits.sort_by(f64::total_cmp);
    let rule = GaussLegendre::new(per_panel).unwrap();
    let mut nodes = Vec::new();
    for panel in limits.windows(2) {
        let half = 0.5 * (panel[1] - panel[0]);
        for (x, w) in rule.nodes().iter().zip(rule.weights()) {
            let theta = panel[0] + half * (1.0 + x);
            for j in 0..n_phi {
                let phi = TAU * (j as f64 + 0.5) / n_phi as f64;
                nodes.push((theta, phi, half * w * theta.sin() * TAU / n_phi as f64));
            }
        }
    }
    nodes
}

fn direction(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

/// Compares integral, E(l) for l up to `lmax`, and total with the reference.
#[expect(clippy::cast_possible_wrap, reason = "orders of a few")]
fn check(
    name: &str,
    integrand: &dyn Integrand,
    domain: Domain,
    lmax: usize,
    nodes: &[(f64, f64, f64)],
    tolerance: f64,
) {
    let values: Vec<f64> =
        nodes.iter().map(|&(t, p, w)| w * integrand.eval(direction(t, p))).collect();
    let integral: f64 = values.iter().sum();
    let exact = integrand.exact(domain).unwrap();
    assert!(
        (integral - exact).abs() <= tolerance,
        "{name} {domain:?}: exact {exact}, quadrature {integral}"
    );
    // The even extension has twice the square of the hemisphere, and doubled coefficients.
    let copies = if domain == Domain::Sphere { 1.0 } else { 2.0 };
    let energy = integrand.energy(domain, lmax).unwrap();
    let square: f64 =
        nodes.iter().map(|&(t, p, w)| copies * w * integrand.eval(direction(t, p)).powi(2)).sum();
    assert!(
        (square - energy.total()).abs() <= tolerance * energy.total().max(1.0),
        "{name} {domain:?}: total {}, quadrature {square}",
        energy.total()
    );
    for l in 0..=lmax {
        let expected: f64 = if domain.has_degree(l) {
            (0..=l)
                .map(|m| {
                    let c: Complex<f64> = nodes
                        .iter()
                        .zip(&values)
                        .map(|(&(t, p, _), v)| ylm(l, m as i64, t, p).unwrap().conj() * v * copies)
                        .sum();
                    if m == 0 { c.norm_sqr() } else { 2.0 * c.norm_sqr() }
                })
                .sum()
        } else {
            0.0
        };
        let got = energy.per_band()[l];
        assert!(
            (got - expected).abs() <= tolerance * energy.total().max(1.0),
            "{name} {domain:?} l = {l}: {got:e}, quadrature {expected:e}"
        );
    }
    // Energies never exceed the total, and the rest is the energy beyond.
    let sum: f64 = energy.per_band().iter().sum();
    assert!(sum <= energy.total() * (1.0 + 1e-12), "{name}: {sum} of {}", energy.total());
}

/// The function is smooth on panels, so 40 nodes leave only the rounding of some thousand terms.
const TOLERANCE: f64 = 1e-12;

#[test]
fn zonal_integrands_agree_with_quadrature() {
    // One more than the largest order, which leaves the other orders of a zonal function 0.
    const LONGITUDES: usize = 16;
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        for degrees in [1e-3, 10.0, 60.0, 90.0, 135.0, 180.0] {
            let cap = Cap::from_degrees(degrees).unwrap();
            let nodes = quadrature(domain, &[f64::to_radians(degrees)], 40, LONGITUDES);
            check(&format!("cap {degrees}"), &cap, domain, 12, &nodes, TOLERANCE);
        }
        let nodes = quadrature(domain, &[FRAC_PI_2], 40, LONGITUDES);
        check("cosine", &ClampedCosine, domain, 15, &nodes, TOLERANCE);
        for kappa in [0.0, 1e-9, 0.5, 3.0, 40.0, 1000.0] {
            let lobe = VonMisesFisher::new(kappa).unwrap();
            let breaks: Vec<f64> = (0..15).map(|k| 0.1 * f64::from(k)).collect();
            let nodes = quadrature(domain, &breaks, 24, LONGITUDES);
            check(&format!("vmf {kappa}"), &lobe, domain, 12, &nodes, TOLERANCE * kappa.max(1.0));
        }
    }
}

#[test]
fn harmonics_agree_with_quadrature() {
    for (l, m) in [(0, 0), (1, 0), (2, -1), (4, 0), (4, 4), (5, 3)] {
        let harmonic = Harmonic::new(l, m).unwrap();
        check(
            "ylm",
            &harmonic,
            Domain::Sphere,
            7,
            &quadrature(Domain::Sphere, &[], 40, 24),
            TOLERANCE,
        );
        if l % 2 == 0 {
            check(
                "ylm",
                &harmonic,
                Domain::Hemisphere,
                7,
                &quadrature(Domain::Hemisphere, &[], 40, 24),
                TOLERANCE,
            );
        } else {
            assert!(harmonic.energy(Domain::Hemisphere, 7).is_err());
        }
    }
    assert!(Harmonic::new(2, 3).is_err() && Harmonic::new(2, -3).is_err());
}

/// A small map whose kinks the reference can resolve: panels between its rows, and enough
/// longitudes that the trapezoidal rule has its nodes symmetric about the kinks.
#[test]
fn an_environment_map_agrees_with_quadrature() {
    let height = 5;
    let texels: Vec<f64> = (0..50).map(|k: u32| f64::from(k * 7919 % 31) / 31.0 + 0.1).collect();
    let map = EnvironmentMap::new(10, height, texels).unwrap();
    let breaks: Vec<f64> = (0..height).map(|i| PI * (i as f64 + 0.5) / height as f64).collect();
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        // Piecewise smooth in phi: the midpoint rule errs by (2 pi/n)^2.
        let nodes = quadrature(domain, &breaks, 16, 4000);
        check("map", &map, domain, 4, &nodes, 2e-6);
    }
}

/// Doubling the nodes changes nothing: the panel rule of the map is converged at any degree.
#[test]
fn the_energy_of_a_map_does_not_depend_on_the_largest_degree() {
    let texels: Vec<f64> = (0..2 * 16 * 16).map(|k: u32| f64::from(k * 7919 % 997)).collect();
    let map = EnvironmentMap::new(32, 16, texels).unwrap();
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let coarse = map.energy(domain, 60).unwrap();
        let fine = map.energy(domain, 700).unwrap();
        for (l, (a, b)) in coarse.per_band().iter().zip(fine.per_band()).enumerate() {
            assert!((a - b).abs() <= 1e-12 * coarse.total(), "{domain:?} l = {l}: {a:e} and {b:e}");
        }
        // Kinks along lines: the energy beyond L falls as L^-3.
        let tail = fine.beyond(700) / fine.total();
        assert!(tail > 0.0 && tail < 1e-4, "{domain:?}: {tail:e}");
    }
}

#[test]
fn small_caps_and_high_degrees_are_accurate() {
    // E(l) -> A^2 (2l+1)/4pi for l theta << 1; the first correction is l^2 theta^2/4.
    let cap = Cap::from_degrees(1e-6).unwrap();
    let area = cap.exact(Domain::Sphere).unwrap();
    let energy = cap.energy(Domain::Sphere, 1000).unwrap();
    for l in [0usize, 1, 10, 1000] {
        let expected = area * area * (2 * l + 1) as f64 / (4.0 * PI);
        let relative = energy.per_band()[l] / expected - 1.0;
        assert!(relative.abs() < 1e-9, "l = {l}: {relative:e}");
    }
    // The mean of l^2 E(l) is 2 sin(theta) (theory.md, erratum 35).
    let energy = Cap::from_degrees(60.0).unwrap().energy(Domain::Sphere, 100_000).unwrap();
    let mean = (90_000..=100_000usize).map(|l| (l * l) as f64 * energy.per_band()[l]).sum::<f64>()
        / 10_001.0;
    assert!((mean / (2.0 * (PI / 3.0).sin()) - 1.0).abs() < 1e-3, "{mean}");
}

#[test]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a degree of some thousands"
)]
fn an_extreme_lobe_sums_to_its_total() {
    for kappa in [1e4, VonMisesFisher::MAX_KAPPA] {
        let lmax = (12.0 * f64::sqrt(kappa)) as usize;
        let energy = VonMisesFisher::new(kappa).unwrap().energy(Domain::Sphere, lmax).unwrap();
        let sum: f64 = energy.per_band().iter().sum();
        assert!(
            (sum / energy.total() - 1.0).abs() < 1e-10,
            "kappa = {kappa}: {sum} of {}",
            energy.total()
        );
    }
    for kappa in [-1.0, f64::NAN, f64::INFINITY, 1.1e6] {
        assert!(VonMisesFisher::new(kappa).is_err(), "{kappa}");
    }
}

#[test]
fn maps_are_checked() {
    assert!(EnvironmentMap::new(0, 0, vec![]).is_err());
    assert!(EnvironmentMap::new(3, 2, vec![0.0; 6]).is_err());
    assert!(EnvironmentMap::new(4, 2, vec![0.0; 7]).is_err());
    let mut texels = vec![0.0; 8];
    texels[5] = f64::NAN;
    let message = EnvironmentMap::new(4, 2, texels).unwrap_err().to_string();
    assert!(message.contains("row 1, column 1"), "{message}");
}
