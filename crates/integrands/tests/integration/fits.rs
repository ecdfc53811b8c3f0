//! Integrands that are known by values.

use std::ops::ControlFlow;

use glam::DVec3;
use sphvar_integrands::{Domain, Error, FittedFunction, Integrand};
use sphvar_sht::LeastSquares;

/// Values of `1 + z + x y` at 300 spiral points with deterministic noise.
fn fitted(noise: f64, domain: Domain, lmax: usize) -> sphvar_sht::Fit {
    let n = 300;
    let point = |k: usize| {
        let z = 1.0 - (2 * k + 1) as f64 / n as f64;
        let (sin, cos) = (2.399_963_229_728_653 * k as f64).sin_cos();
        let s = (1.0 - z * z).sqrt();
        DVec3::new(s * cos, s * sin, z)
    };
    let points: Vec<DVec3> = (0..n).map(point).collect();
    let values: Vec<f64> = points
        .iter()
        .enumerate()
        .map(|(k, p)| 1.0 + p.z + p.x * p.y + noise * ((k as f64 * 0.754_877_666).fract() - 0.5))
        .collect();
    let problem = LeastSquares::new(&points, &values, domain).unwrap();
    problem.solve(lmax, &mut || ControlFlow::Continue(())).unwrap()
}

#[test]
fn energies_are_those_without_noise_and_carry_their_errors() {
    let fit = fitted(0.4, Domain::Sphere, 8);
    let f = FittedFunction::new(&fit).unwrap();
    let energy = f.energy(Domain::Sphere, 12).unwrap();
    let stderr = energy.per_band_stderr().unwrap();
    assert_eq!((energy.per_band().len(), stderr.len()), (13, 13));
    let mut n_negative = 0;
    for (l, fitted) in fit.energies.iter().enumerate().skip(1) {
        let corrected = fitted.corrected.unwrap();
        n_negative += usize::from(corrected < 0.0);
        let expected = corrected.max(0.0);
        let error = (energy.per_band()[l] - expected).abs();
        assert!(error <= 1e-13 * fitted.fitted, "{l}: {} {expected}", energy.per_band()[l]);
        assert_eq!(stderr[l].to_bits(), fitted.stderr.unwrap().to_bits());
    }
    assert!(n_negative > 0, "no degree tests negative estimates");
    // The integral is that of the fit.
    let exact = (4.0 * std::f64::consts::PI).sqrt() * fit.alm[(0, 0)].re;
    assert!((f.exact(Domain::Sphere).unwrap() / exact - 1.0).abs() < 1e-14);
    // Values in batches are single values.
    let dirs = [DVec3::Z, DVec3::X, DVec3::new(0.48, 0.6, 0.64)];
    let mut values = [0.0; 3];
    f.eval_into(&dirs, &mut values).unwrap();
    for (value, dir) in values.into_iter().zip(dirs) {
        assert!((value - f.eval(dir)).abs() < 1e-12);
    }
}

#[test]
fn unknown_energies_are_errors() {
    // On the hemisphere, the even extension has other energies.
    let sphere = FittedFunction::new(&fitted(0.1, Domain::Sphere, 4)).unwrap();
    let error = sphere.energy(Domain::Hemisphere, 4).unwrap_err();
    assert!(matches!(error, Error::NoEnergy { .. }), "{error}");
    let half = FittedFunction::new(&fitted(0.1, Domain::Hemisphere, 4)).unwrap();
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let energy = half.energy(domain, 4).unwrap();
        assert_eq!((energy.per_band()[1], energy.per_band()[3]), (0.0, 0.0));
    }
    let points = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z];
    let problem = LeastSquares::new(&points, &[1.0, 2.0, 3.0, 4.0], Domain::Sphere).unwrap();
    let fit = problem.solve(1, &mut || ControlFlow::Continue(())).unwrap();
    let error = FittedFunction::new(&fit).unwrap_err();
    assert!(error.to_string().contains("use a lower degree"), "{error}");
}
