//! Kurtosis of integrands' values against moments in closed form.

use glam::{DQuat, DVec3};
use sphvar_integrands::{
    Cap, ClampedCosine, Domain, DoubleCap, Harmonic, Integrand, PhongLobe, Product, Rotated, Sum,
    VonMisesFisher,
};

/// Computes the kurtosis from the raw moments `E f^k`, k = 1 to 4, of a uniform direction.
fn central(m: [f64; 4]) -> f64 {
    let [a, b, c, d] = m;
    let variance = b - a * a;
    (d - 4.0 * a * c + 6.0 * a * a * b - 3.0 * a.powi(4)) / (variance * variance)
}

fn assert_near(name: &str, got: Option<f64>, expected: f64, relative: f64) {
    let got = got.unwrap_or(f64::NAN);
    assert!((got / expected - 1.0).abs() < relative, "{name}: {got}, expected {expected}");
}

#[test]
fn kurtoses_match_the_moments() {
    let sphere = Domain::Sphere;
    // z is uniform on (-1, 1): kurtosis 9/5.
    assert_near("Y_10", Harmonic::new(1, 0).unwrap().kurtosis(sphere), 1.8, 1e-9);
    // E max(z, 0)^k = 1/(2 (k+1)), of a lobe of exponent n with k n.
    let lobe = |n: f64| central([1.0, 2.0, 3.0, 4.0].map(|k| 0.5 / (k * n + 1.0)));
    assert_near("cosine", ClampedCosine.kurtosis(sphere), lobe(1.0), 1e-9);
    let phong = PhongLobe::new(2000.0).unwrap();
    assert_near("phong", phong.kurtosis(sphere), lobe(2000.0), 1e-6);
    // E e^{-k kappa (1 - z)} = (1 - e^{-2 k kappa})/(2 k kappa).
    for kappa in [1.0, 1e4, 1e6] {
        let moment = |k: f64| -(-2.0 * k * kappa).exp_m1() / (2.0 * k * kappa);
        let vmf = VonMisesFisher::new(kappa).unwrap();
        let expected = central([1.0, 2.0, 3.0, 4.0].map(moment));
        assert_near("vmf", vmf.kurtosis(sphere), expected, 1e-6);
        let rotated = Rotated::new(vmf, DQuat::from_rotation_x(1.0)).unwrap();
        assert_near("rotated vmf", rotated.kurtosis(sphere), expected, 1e-6);
        let scaled = Sum::default().plus(1e-140, rotated).unwrap();
        assert_near("scaled vmf", scaled.kurtosis(sphere), expected, 1e-6);
    }
}

/// A cap that covers a fraction p has `(1 - 3 p q)/(p q)`, its complement the same: no cancellation
/// at either end.
#[test]
fn caps_have_the_kurtosis_of_their_complements() {
    let of = |degrees: f64| Cap::from_degrees(degrees).unwrap().kurtosis(Domain::Sphere);
    assert_near("60", of(60.0), 7.0 / 3.0, 1e-12);
    for angle in [1e-6, 1e-3, 0.27, 5.0, 80.0] {
        let complement = of(180.0 - angle).unwrap();
        // The angle itself rounds by 3e-14 degrees.
        assert_near("complement", of(angle), complement, 1e-7);
        let half = 0.5 * angle.to_radians();
        let p = half.sin().powi(2);
        assert_near("cap", of(angle), 1.0 / (p * half.cos().powi(2)) - 3.0, 1e-9);
    }
    assert_eq!(of(180.0), None);
    let double = DoubleCap::from_degrees(60.0).unwrap();
    assert_near("double", double.kurtosis(Domain::Sphere), 1.0, 1e-12);
    let cut = Cap::from_degrees(60.0).unwrap();
    assert_near("hemisphere", cut.kurtosis(Domain::Hemisphere), 1.0, 1e-12);
    assert_eq!(Cap::from_degrees(120.0).unwrap().kurtosis(Domain::Hemisphere), None);
}

/// A product of caps about axes at right angles, a quarter of a sphere: p = 1/4. Closures have no
/// known kurtosis.
#[test]
fn products_and_closures() {
    let half = || Cap::half_space(0.0).unwrap();
    let rotated = Rotated::new(half(), DQuat::from_rotation_x(90f64.to_radians())).unwrap();
    let quarter = Product::new(half(), rotated);
    assert_near("quarter", quarter.kurtosis(Domain::Sphere), 7.0 / 3.0, 1e-3);
    assert_eq!((|d: DVec3| d.z).kurtosis(Domain::Sphere), None);
}
