use std::f64::consts::PI;

use crate::reference::DoubleDouble;
use glam::DVec3;
use sphvar_integrands::{Cap, Energy, Integrand, VonMisesFisher};
use sphvar_samplers::Domain;
use sphvar_sh::ByParity;
use sphvar_spectrum::Spectrum;
use sphvar_variance::predict;

use super::energies;
use super::prefixes::OfPrefixes;
use super::subjects::errors_of;
use crate::{Errors, HardCase, Subject};

/// Returns the hard cases of this area.
pub(crate) fn hard_cases() -> Vec<HardCase> {
    vec![
        HardCase {
            name: "a_cap_of_a_millionth_of_a_degree",
            what: "energies to degree 100000, with errors relative to (l + 1) times the energy; its area, its variance",
            bound: 4.0 * f64::EPSILON,
            reason: "the coefficient of degree l has a few roundings and those of l steps of a recurrence \
                     without cancellation",
            measure: tiny_cap,
        },
        HardCase {
            name: "a_cap_of_180_degrees",
            what: "relative errors of the area, the square and the energy of degree 0 of the whole sphere; infinite if the energy \
                   of another degree to 1000, or the variance, is not 0",
            bound: 2.0 * f64::EPSILON,
            reason: "products of pi and of roots of it, with a few roundings; a constant has no other energy and no variance",
            measure: whole_sphere,
        },
        HardCase {
            name: "von_mises_fisher_of_kappa_1e6",
            what: "energies to degree 6000, where they are 3e-15 of the largest, with errors relative to (l + 1) times the energy; \
                   their sum, relative to the total",
            bound: 4.0 * f64::EPSILON,
            reason: "the square of a product of l ratios, each accurate to one or two roundings",
            measure: narrow_lobe,
        },
        HardCase {
            name: "prefixes_with_repeated_points",
            what: "variances of all prefixes of poles, repeated points and antipodes with lobes of kappa = 0.01 to 1000, relative to \
                   the geometric mean of the variance and that of white noise",
            bound: 50.0 * 1e-12,
            reason: "the kernel of pairs has an error of at most 1e-12 of its largest value, which is the variance of white noise times the \
                     number of points, and repeated points have at least that variance",
            measure: repeated_points,
        },
    ]
}

fn relative(got: f64, exact: DoubleDouble) -> f64 {
    ((DoubleDouble::from(got) - exact) / exact).value()
}

/// Adds the largest error of `more` under its name.
fn push_worst(errors: &mut Errors, more: &Errors) {
    errors.push(more.max(), || more.worst().to_owned());
}

fn tiny_cap() -> Errors {
    const LMAX: usize = 100_000;
    const N: usize = 1000;
    let cap = Cap::from_degrees(1e-6).expect("an angle in range");
    let exact = energies::of_small_cap(cap.angle(), LMAX);
    let energy = cap.energy(Domain::Sphere, LMAX).unwrap_or_else(|_| unavailable());
    let mut errors = Errors::default();
    push_worst(&mut errors, &errors_of(&energy, &exact, |l| exact[l].value()));
    // 4 pi E(0) = A^2, and the variance of white noise is (4 pi A - A^2)/N.
    let four_pi = DoubleDouble::from(4.0) * DoubleDouble::pi();
    let area = (four_pi * exact[0]).sqrt();
    let got = cap.exact(Domain::Sphere).unwrap_or(f64::NAN);
    errors.push(relative(got, area), || "the area".to_owned());
    let white = Spectrum::exact(Domain::Sphere, N, vec![1.0; 200]);
    let variance = (four_pi - area) * area / DoubleDouble::from(N as f64);
    let got = predict(&white, &energy).variance;
    errors.push(relative(got, variance), || "the variance with white noise".to_owned());
    errors
}

/// Returns a replacement for energies that are unavailable, which violates every bound.
fn unavailable() -> Energy {
    Energy::new(Domain::Sphere, vec![f64::NAN], ByParity::both(f64::NAN))
}

fn whole_sphere() -> Errors {
    let cap = Cap::from_degrees(180.0).expect("an angle in range");
    let energy = cap.energy(Domain::Sphere, 1000).unwrap_or_else(|_| unavailable());
    let mut errors = Errors::default();
    let four_pi = 4.0 * PI;
    for (name, got) in [
        ("the integral", cap.exact(Domain::Sphere).unwrap_or(f64::NAN)),
        ("the square", energy.total()),
        ("the energy of degree 0", energy.per_band()[0]),
    ] {
        errors.push(got / four_pi - 1.0, || name.to_owned());
    }
    // Only exactly 0 is accepted, not a small number.
    let zero = |x: f64| if x == 0.0 { 0.0 } else { f64::INFINITY };
    for (l, &e) in energy.per_band().iter().enumerate().skip(1) {
        errors.push(zero(e), || format!("the energy of l = {l}"));
    }
    let white = Spectrum::exact(Domain::Sphere, 1, vec![1.0; 1001]);
    let variance = predict(&white, &energy).variance;
    errors.push(zero(variance), || format!("a variance of {variance:e}"));
    errors
}

fn narrow_lobe() -> Errors {
    const LMAX: usize = 6000;
    let kappa = VonMisesFisher::MAX_KAPPA;
    let lobe = VonMisesFisher::new(kappa).expect("the largest concentration");
    let exact = energies::of_lobe(kappa, LMAX);
    let energy = lobe.energy(Domain::Sphere, LMAX).unwrap_or_else(|_| unavailable());
    let mut errors = Errors::default();
    push_worst(&mut errors, &errors_of(&energy, &exact, |l| exact[l].value()));
    // int f^2 = kappa/(4 pi) coth(kappa), and e^{-2 kappa} is negligible.
    let four_pi = DoubleDouble::from(4.0) * DoubleDouble::pi();
    let total = DoubleDouble::from(kappa) / four_pi;
    errors.push(relative(energy.total(), total), || "the total".to_owned());
    errors
}

fn repeated_points() -> Errors {
    let near = DVec3::new(1e-7, 0.0, 1.0).normalize();
    let few = [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::Z, near, -near, DVec3::Y, DVec3::NEG_X];
    let points: Vec<DVec3> = few.iter().cycle().take(50).copied().collect();
    let mut errors = Errors::default();
    for kappa in [0.01, 1.0, 100.0, 1000.0] {
        let mut subject = OfPrefixes::new(points.clone(), kappa, (1..=points.len()).collect());
        subject.run();
        push_worst(&mut errors, &subject.errors());
    }
    errors
}
