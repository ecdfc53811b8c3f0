//! Functions given by coefficients against sums of single harmonics and quadrature.

use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::Complex;
use sphvar_integrands::{Domain, Error, Expansion, Harmonic, Integrand, SampledFunction};
use sphvar_sh::{Alm, ylm_at};

/// Returns coefficients of comparable size and irregular phase.
fn coefficients(lmax: usize) -> Alm {
    let mut alm = Alm::zeros(lmax).unwrap();
    for (i, (l, m)) in alm.index().iter().enumerate() {
        let x = (i as f64 * 0.618_034).fract() - 0.4;
        let y = (i as f64 * 0.414_214).fract() - 0.5;
        let scale = 1.0 / (l + 1) as f64;
        alm[(l, m)] = Complex::new(x * scale, if m == 0 { 0.0 } else { y * scale });
    }
    alm
}

/// The definition.
fn value(alm: &Alm, dir: DVec3) -> f64 {
    let term = |(l, m): (usize, usize)| {
        let both_signs = if m == 0 { 1.0 } else { 2.0 };
        both_signs * (alm[(l, m)] * ylm_at(l, i64::try_from(m).unwrap(), dir).unwrap()).re
    };
    alm.index().iter().map(term).sum()
}

fn norm(alm: &Alm) -> f64 {
    alm.energy_per_degree().iter().sum::<f64>().sqrt()
}

/// Poles, the equator, antipodes, repeated points and a spiral.
fn directions(n: usize) -> Vec<DVec3> {
    let special = [DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::X, DVec3::Y, DVec3::Z];
    let near = [1e-12, 1e-5].map(|t: f64| DVec3::new(t.sin(), 0.0, t.cos()));
    let spiral = (0..n).map(|k| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / n as f64;
        let (s, c) = (TAU * (k as f64 * 0.618_034).fract()).sin_cos();
        let r = ((1.0 - z) * (1.0 + z)).sqrt();
        DVec3::new(r * c, r * s, z).normalize()
    });
    special.into_iter().chain(near).chain(spiral).take(n).collect()
}

#[test]
fn values_are_sums_of_harmonics() {
    for lmax in [0, 1, 2, 13, 40] {
        let alm = coefficients(lmax);
        let f = Expansion::new(alm.clone()).unwrap();
        assert_eq!(f.alm(), &alm);
        let tolerance = 4e-13 * norm(&alm) * (lmax + 1) as f64;
        for n in [0, 1, 2, 100] {
            let dirs = directions(n);
            let mut values = vec![f64::NAN; n];
            f.eval_into(&dirs, &mut values).unwrap();
            for (&dir, value_of_many) in dirs.iter().zip(values) {
                let defined = value(&alm, dir);
                let single = f.eval(dir);
                for got in [single, value_of_many] {
                    assert!((got - defined).abs() < tolerance, "{lmax} {dir}: {got}, {defined}");
                }
            }
        }
    }
}

/// Ten thousand points take the fast transform.
#[test]
fn many_values_equal_single_ones() {
    for lmax in [7, 40, 150] {
        let alm = coefficients(lmax);
        let f = Expansion::new(alm.clone()).unwrap();
        let dirs = directions(10_000);
        let mut values = vec![0.0; dirs.len()];
        f.eval_into(&dirs, &mut values).unwrap();
        let tolerance = 1e-13 * norm(&alm) * (lmax + 1) as f64;
        for (&dir, many) in dirs.iter().zip(values).step_by(17) {
            let single = f.eval(dir);
            assert!((single - many).abs() < tolerance, "{lmax} {dir}: {single}, {many}");
        }
    }
}

/// Everything that the expansion computes from coefficients, by quadrature of values.
#[test]
fn integrals_and_energies_are_those_of_the_values() {
    for (lmax, keep) in [(0, 1), (1, 1), (6, 1), (6, 2), (11, 1)] {
        let mut alm = coefficients(lmax);
        for (l, m) in alm.index().iter() {
            if l % keep != 0 {
                alm[(l, m)] = Complex::ZERO;
            }
        }
        let f = Expansion::new(alm.clone()).unwrap();
        let slow = SampledFunction::new(|dir: DVec3| value(&alm, dir), lmax);
        let size = norm(&alm);
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let what = format!("{lmax} {keep} {domain:?}");
            let [a, b] = [f.exact(domain), slow.exact(domain)].map(Option::unwrap);
            assert!((a - b).abs() < 1e-12 * size, "{what}: integral {a}, {b}");
            let [a, b] =
                [f.centred_square(domain), slow.centred_square(domain)].map(Result::unwrap);
            assert!((a.even - b.even).abs() < 1e-12 * size * size, "{what}: {a:?}, {b:?}");
            assert!((a.odd - b.odd).abs() < 1e-12 * size * size, "{what}: {a:?}, {b:?}");
            let [a, b] = [f.square(domain), slow.square(domain)].map(Result::unwrap);
            assert!((a - b).abs() < 1e-12 * size * size, "{what}: square {a}, {b}");
            for degree in [0, 3, 20] {
                let of = |f: &dyn Integrand| f.coefficients(domain, degree).unwrap().to_alm();
                let [a, b] = [of(&f), of(&slow)].map(Result::unwrap);
                for (l, m) in a.index().iter() {
                    let error = (a[(l, m)] - b[(l, m)]).norm();
                    assert!(error < 1e-12 * size, "{what}: a_{l},{m} is off by {error}");
                }
                let [a, b] =
                    [f.energy(domain, degree), slow.energy(domain, degree)].map(Result::unwrap);
                for (a, b) in a.per_band().iter().zip(b.per_band()) {
                    assert!((a - b).abs() < 1e-12 * size * size, "{what}: energies {a}, {b}");
                }
            }
            match [f.kurtosis(domain), slow.kurtosis(domain)] {
                [None, None] => assert_eq!(lmax, 0, "{what}"),
                [Some(a), Some(b)] => assert!((a / b - 1.0).abs() < 1e-11, "{what}: {a}, {b}"),
                other => panic!("{what}: kurtosis {other:?}"),
            }
        }
    }
}

#[test]
fn a_single_coefficient_is_the_harmonic() {
    let mut alm = Alm::zeros(40).unwrap();
    alm[(40, 17)] = Complex::new(0.5f64.sqrt(), 0.0);
    let f = Expansion::new(alm).unwrap();
    let harmonic = Harmonic::new(40, 17).unwrap();
    for dir in directions(200) {
        let [a, b] = [f.eval(dir), harmonic.eval(dir)];
        assert!((a - b).abs() < 1e-13, "{dir}: {a}, {b}");
    }
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let energy = f.energy(domain, 50).unwrap();
        for (l, e) in energy.per_band().iter().enumerate() {
            let expected = if l == 40 { 1.0 } else { 0.0 };
            assert!((e - expected).abs() < 1e-14, "{domain:?} l = {l}: {e}");
        }
        assert!((energy.centred().even - 1.0).abs() < 1e-14 && energy.centred().odd == 0.0);
        assert_eq!(f.exact(domain), Some(0.0));
    }
    let [a, b] =
        [f.kurtosis(Domain::Sphere), harmonic.kurtosis(Domain::Sphere)].map(Option::unwrap);
    assert!((a / b - 1.0).abs() < 1e-11, "{a}, {b}");
}

#[test]
fn impossible_coefficients_are_errors() {
    for (place, bad) in [
        ((2, 1), Complex::new(f64::NAN, 0.0)),
        ((2, 2), Complex::new(0.0, f64::INFINITY)),
        ((3, 0), Complex::new(1.0, 1e-3)),
    ] {
        let mut alm = coefficients(3);
        alm[place] = bad;
        let error = Expansion::new(alm).unwrap_err();
        assert!(
            matches!(error, Error::Coefficient { l, m, .. } if (l, m) == place),
            "{error} for {place:?}"
        );
    }
    // A rounding of single precision.
    let mut alm = coefficients(3);
    alm[(3, 0)].im = 1e-8;
    let f = Expansion::new(alm).unwrap();
    assert_eq!(f.alm()[(3, 0)].im.to_bits(), 0);
    assert!((f.square(Domain::Sphere).unwrap() / norm(f.alm()).powi(2) - 1.0).abs() < 1e-14);
}
