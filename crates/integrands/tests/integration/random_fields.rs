//! Random fields with given energies, and the integrands that are made of them.

use std::f64::consts::PI;

use glam::DVec3;
use num_complex::Complex;
use sphvar_integrands::grammar::ResolveError;
use sphvar_integrands::{
    AlmParameters, Cap, Domain, EnergiesParameters, EnergyEstimates, Error, Expansion, Expression,
    Integrand, IntegrandResolver, NoFiles, RandomField,
};
use sphvar_sh::Alm;

fn built(text: &str, files: &dyn IntegrandResolver) -> Box<dyn Integrand> {
    text.parse::<Expression>().unwrap().build(files).unwrap()
}

#[test]
fn energies_are_exact_for_every_field() {
    let energies: Vec<f64> =
        (0..60).map(|l| if l == 7 { 0.0 } else { f64::from(l % 5) + 1e-9 }).collect();
    for field in [0, 1, u64::MAX] {
        let f = Expansion::random_field(-0.5, &energies, field).unwrap();
        let got = f.energy(Domain::Sphere, energies.len()).unwrap();
        for (l, (e, got)) in energies.iter().zip(&got.per_band()[1..]).enumerate() {
            assert!((e - got).abs() <= 1e-14 * e, "{field}, l = {}: {got}, not {e}", l + 1);
        }
        assert!((f.exact(Domain::Sphere).unwrap() / (-2.0 * PI) - 1.0).abs() < 1e-15);
        assert_eq!(got.beyond(energies.len()).to_bits(), 0);
    }
}

#[test]
fn coefficients_depend_on_field_degree_and_order_only() {
    let short = Expansion::random_field(1.0, &[1.0; 5], 3).unwrap();
    let long = Expansion::random_field(0.0, &[1.0; 50], 3).unwrap();
    let other = Expansion::random_field(0.0, &[1.0; 5], 4).unwrap();
    for (l, m) in short.alm().index().iter().skip(1) {
        if l > 0 {
            assert_eq!(short.alm()[(l, m)], long.alm()[(l, m)], "l = {l}, m = {m}");
            let differs = short.alm()[(l, m)] != other.alm()[(l, m)];
            // The only component of degree 0 aside, equal numbers have probability 0.
            assert!(differs, "l = {l}, m = {m}");
        }
    }
}

/// The 2l+1 real components of a degree are exchangeable: each has the mean square E(l)/(2l+1), and
/// components are uncorrelated, also between degrees.
#[test]
fn fields_are_isotropic() {
    const FIELDS: u64 = 600;
    // Components of degrees 1 and 2, each with energy 1, in units of their root mean square.
    let components = |field| -> Vec<f64> {
        let f = Expansion::random_field(0.0, &[3.0, 5.0], field).unwrap();
        let orders = f.alm().index().iter().filter(|(l, _)| *l > 0);
        let parts = |(l, m): (usize, usize)| {
            let a = f.alm()[(l, m)];
            if m == 0 { vec![a.re] } else { vec![a.re * 2f64.sqrt(), a.im * 2f64.sqrt()] }
        };
        orders.flat_map(parts).collect()
    };
    let fields: Vec<Vec<f64>> = (0..FIELDS).map(components).collect();
    let mean = |f: &dyn Fn(&[f64]) -> f64| fields.iter().map(|x| f(x)).sum::<f64>() / FIELDS as f64;
    // The variances of x_i, x_i^2 and x_i x_j are at most 1, 1.15 and 1 (Beta distributions):
    // 5.5 standard errors, 44 comparisons, false alarm 2e-6.
    let tolerance = 5.5 * (1.2 / FIELDS as f64).sqrt();
    for i in 0..8 {
        let first = mean(&|x| x[i]);
        assert!(first.abs() < tolerance, "mean of {i}: {first}");
        for j in 0..=i {
            let second = mean(&|x| x[i] * x[j]);
            let expected = if i == j { 1.0 } else { 0.0 };
            assert!((second - expected).abs() < tolerance, "{i}, {j}: {second}");
        }
    }
}

#[test]
fn bands_have_variance_1_and_the_requested_power() {
    for (text, mean, decay) in [
        ("band:lmax=40", 1.0, 0),
        ("band:lmax=12,decay=2,mean=-3", -3.0, 2),
        ("band:lmax=1,mean=0", 0.0, 0),
    ] {
        let f = built(text, &NoFiles);
        let limit = f.band_limit().unwrap();
        let energy = f.energy(Domain::Sphere, limit + 9).unwrap();
        assert!((energy.centred().sum() / (4.0 * PI) - 1.0).abs() < 1e-14, "{text}");
        assert!((f.exact(Domain::Sphere).unwrap() - 4.0 * PI * mean).abs() < 1e-13, "{text}");
        let power = |l: usize| energy.per_band()[l] / (2 * l + 1) as f64;
        for l in 1..=limit {
            let expected = power(1) * (l as f64).powi(-decay);
            assert!((power(l) / expected - 1.0).abs() < 1e-13, "{text}, l = {l}");
        }
        assert!(energy.per_band()[limit + 1..].iter().all(|e| *e == 0.0), "{text}");
    }
    // The same text is the same function, another field another one with the same energies.
    let values = |text| built(text, &NoFiles).eval(DVec3::new(0.6, 0.0, 0.8));
    assert_eq!(values("band:lmax=9").to_bits(), values("band:lmax=9,field=0").to_bits());
    assert!((values("band:lmax=9") - values("band:lmax=9,field=1")).abs() > 1e-3);
}

/// Files of known content.
struct Files;

const CAP_DEGREE: usize = 64;

fn cap() -> Cap {
    Cap::from_degrees(30.0).unwrap()
}

impl IntegrandResolver for Files {
    fn energies(&self, _: &EnergiesParameters) -> Result<EnergyEstimates, ResolveError> {
        let per_degree = cap().energy(Domain::Sphere, CAP_DEGREE).unwrap().per_band().to_vec();
        Ok(EnergyEstimates { per_degree, stderr: vec![] })
    }

    fn expansion(&self, _: &AlmParameters) -> Result<Expansion, ResolveError> {
        let mut alm = Alm::zeros(4).map_err(ResolveError::new)?;
        alm[(3, 2)].re = 0.5f64.sqrt();
        Expansion::new(alm).map_err(ResolveError::new)
    }
}

/// To the degree of the file: beyond it the function has no energy.
#[test]
fn energies_of_a_cap_are_those_of_the_cap() {
    let (f, cap) = (built("energy:cap.csv", &Files), cap());
    assert_eq!(f.band_limit(), Some(CAP_DEGREE));
    let [a, b] = [f.exact(Domain::Sphere), cap.exact(Domain::Sphere)].map(Option::unwrap);
    assert!((a / b - 1.0).abs() < 1e-14, "{a}, {b}");
    let [a, b]: [_; 2] = [&*f, &cap].map(|f| f.energy(Domain::Sphere, 100).unwrap());
    for l in 0..=CAP_DEGREE {
        let (a, b) = (a.per_band()[l], b.per_band()[l]);
        assert!((a - b).abs() <= 1e-14 * b, "l = {l}: {a}, {b}");
    }
    let band: f64 = b.per_band()[1..=CAP_DEGREE].iter().sum();
    assert!((a.centred().sum() / band - 1.0).abs() < 1e-14);
    assert_eq!(a.beyond(CAP_DEGREE).to_bits(), 0);
    assert!(b.beyond(CAP_DEGREE) > 0.01 * b.centred().sum());
}

#[test]
fn coefficients_of_files_take_part_in_expressions() {
    let rest = built("alm:a.npy @ 30/40 - ylm:l=3,m=2 @ 30/40", &Files);
    assert!(rest.centred_square(Domain::Sphere).unwrap().sum() < 1e-28);
    let product = built("alm:a.npy * ylm:l=3,m=2", &Files);
    assert!((product.exact(Domain::Sphere).unwrap() - 1.0).abs() < 1e-14);
    assert_eq!(product.band_limit(), Some(7));
}

#[test]
fn errors_of_energies_are_stated_with_them() {
    struct Estimates([f64; 3]);
    impl IntegrandResolver for Estimates {
        fn energies(&self, _: &EnergiesParameters) -> Result<EnergyEstimates, ResolveError> {
            let per_degree = vec![1.0, self.0[1] * 2.0, 5.0, 0.0];
            Ok(EnergyEstimates { per_degree, stderr: self.0.to_vec() })
        }
    }
    let f = built("energy:a.csv", &Estimates([9.0, 0.5, 0.25]));
    let energy = f.energy(Domain::Sphere, 5).unwrap();
    assert_eq!(energy.per_band_stderr(), Some(&[9.0, 0.5, 0.25, 0.0, 0.0, 0.0][..]));
    let centred = energy.centred_stderr();
    assert_eq!([centred.even, centred.odd].map(f64::to_bits), [0.25, 0.5].map(f64::to_bits));
    assert!((energy.centred().sum() - 6.0).abs() < 1e-14);
    // The even extension of a field with odd degrees has other energies, of unknown errors.
    assert!(f.energy(Domain::Hemisphere, 5).is_err());
    let even = built("energy:a.csv", &Estimates([9.0, 0.0, 0.25]));
    let energy = even.energy(Domain::Hemisphere, 5).unwrap();
    assert_eq!(energy.centred_stderr().even.to_bits(), 0.25f64.to_bits());
}

/// Values of `alm2map` of healpy 1.18 at the centres of pixels 0, 5 and 10 of nside 1.
#[test]
fn values_are_those_of_healpy() {
    let values = [(0.5, 0.0), (-1.25, 0.0), (2.0, 0.0), (0.75, 0.5), (-0.3, 1.1), (0.2, -0.9)];
    let alm = Alm::from_values(2, values.map(|(re, im)| Complex::new(re, im)).to_vec()).unwrap();
    let f = Expansion::new(alm).unwrap();
    let x = (5.0f64 / 18.0).sqrt();
    for (dir, value) in [
        (DVec3::new(x, x, 2.0 / 3.0), 0.999_416_530_792_354_9),
        (DVec3::Y, -0.298_751_265_956_041_07),
        (DVec3::new(-x, -x, -2.0 / 3.0), 1.995_845_455_729_234_7),
    ] {
        assert!((f.eval(dir) - value).abs() < 1e-14, "{dir}: {}", f.eval(dir));
    }
}

#[test]
fn impossible_energies_are_errors() {
    for bad in [-1e-300, f64::NAN, f64::INFINITY] {
        let error = Expansion::random_field(0.0, &[1.0, bad], 0).unwrap_err();
        assert!(matches!(error, Error::Energy { l: 2, .. }), "{error}");
    }
    assert!(matches!(
        Expansion::random_field(f64::NAN, &[1.0], 0),
        Err(Error::Coefficient { l: 0, m: 0, .. })
    ));
    struct Negative;
    impl IntegrandResolver for Negative {
        fn energies(&self, _: &EnergiesParameters) -> Result<EnergyEstimates, ResolveError> {
            Ok(EnergyEstimates { per_degree: vec![-1.0, 1.0], stderr: vec![] })
        }
    }
    let expression: Expression = "energy:a.csv".parse().unwrap();
    let error = expression.build(&Negative).map(drop).unwrap_err().to_string();
    assert!(error.contains("degree 0") && error.contains("-1"), "{error}");
}

#[test]
fn fields_drawn_on_first_use_are_the_same() {
    let (energies, dir) = ([3.0, 0.0, 0.5, 1e-9], DVec3::new(0.6, 0.0, 0.8));
    let later = RandomField::new(-0.5, &energies, 7).unwrap();
    let drawn = Expansion::random_field(-0.5, &energies, 7).unwrap();
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let [a, b]: [_; 2] =
            [&later as &dyn Integrand, &drawn].map(|f| f.energy(domain, 6).unwrap());
        for (a, b) in a.per_band().iter().zip(b.per_band()) {
            assert!((a - b).abs() <= 1e-14 * b, "{a}, {b}");
        }
        assert!((a.total() / b.total() - 1.0).abs() < 1e-14);
        assert_eq!(later.exact(domain), drawn.exact(domain));
    }
    assert_eq!(later.eval(dir).to_bits(), drawn.eval(dir).to_bits());
}

/// Energies are known without memory, values are not.
#[test]
fn values_wait_for_the_check_of_memory() {
    let none = |lmax| Err(format!("degree {lmax} does not fit"));
    let f = RandomField::new(0.0, &[1.0; 5], 0).unwrap().with_memory_check(none);
    assert!((f.energy(Domain::Sphere, 2).unwrap().total() - 5.0).abs() < 1e-14);
    let error = f.eval_into(&[DVec3::X], &mut [0.0]).unwrap_err().to_string();
    assert!(error.contains("degree 5 does not fit"), "{error}");
    assert!(f.eval(DVec3::X).is_nan());
}

#[test]
fn coefficients_whose_squares_vanish_are_errors() {
    for size in [1e-200, 1e200] {
        let mut alm = Alm::zeros(3).unwrap();
        alm[(2, 1)].re = size;
        let error = Expansion::new(alm).unwrap_err();
        assert!(matches!(error, Error::Magnitude { .. }), "{error}");
    }
}
