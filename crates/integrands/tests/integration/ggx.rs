//! The GGX lobe against quadratures in other coordinates and the limit of smooth surfaces.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use sphvar_integrands::{Domain, Expression, GgxLobe, Integrand, NoFiles, SampledFunction};

fn lobe(roughness: f64, view: f64) -> GgxLobe {
    GgxLobe::new(roughness, view).unwrap()
}

/// Against quadratures of the values over rings about the normal, whose nodes do not know the lobe.
#[test]
fn results_are_those_of_rings_about_the_normal() {
    for (roughness, view) in
        [(1.0, 0.0), (1.0, 30.0), (1.0, 89.9), (0.7, 60.0), (0.7, 80.0), (0.5, 1e-3), (0.3, 45.0)]
    {
        let lobe = lobe(roughness, view);
        let slow = SampledFunction::with_shape(|d: DVec3| lobe.eval(d), lobe.shape().unwrap());
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let what = format!("roughness {roughness}, view {view}, {domain:?}");
            let ratio = lobe.exact(domain).unwrap() / slow.exact(domain).unwrap();
            assert!((ratio - 1.0).abs() < 1e-11, "{what}: {ratio}");
            let (fast, slow) = (lobe.energy(domain, 60).unwrap(), slow.energy(domain, 60).unwrap());
            let near = |a: f64, b: f64| (a - b).abs() < 1e-11 * slow.total();
            assert!(near(fast.centred().even, slow.centred().even), "{what}: {:?}", fast.centred());
            assert!(near(fast.centred().odd, slow.centred().odd), "{what}: {:?}", fast.centred());
            for (l, (a, b)) in fast.per_band().iter().zip(slow.per_band()).enumerate() {
                assert!(near(*a, *b), "{what}, l = {l}: {a}, {b}");
            }
        }
    }
}

/// Half vectors with the density D cos, on a midpoint grid of the square: the ratio of value and
/// density of the reflected direction has the integral as its mean, for any roughness and view.
///
/// The error of the rule of 600^2 points comes from the horizon, which cuts the grid.
#[test]
fn integrals_are_means_over_half_vectors() {
    const N: u32 = 600;
    for roughness in [1e-3, 0.02, 0.3, 1.0] {
        for view in [0.0, 45.0, 80.0f64] {
            let lobe = lobe(roughness, view);
            let alpha = roughness * roughness;
            let (sin, cos) = view.to_radians().sin_cos();
            let view_direction = DVec3::new(sin, 0.0, cos);
            let at = |k: u32| (f64::from(k) + 0.5) / f64::from(N);
            let mut sums = [0.0; 2];
            for (u, v) in (0..N).flat_map(|i| (0..N).map(move |j| (at(i), at(j)))) {
                let tangent = alpha * (u / (1.0 - u)).sqrt();
                let phi = TAU * v;
                let half = DVec3::new(tangent * phi.cos(), tangent * phi.sin(), 1.0).normalize();
                let toward = view_direction.dot(half);
                let dir = (2.0 * toward * half - view_direction).normalize();
                if toward <= 0.0 || dir.z <= 0.0 {
                    continue;
                }
                let slope = half.z * half.z * (1.0 + (tangent / alpha).powi(2));
                let density = half.z / (PI * (alpha * slope).powi(2)) / (4.0 * toward);
                let value = lobe.eval(dir);
                sums[0] += value / density;
                sums[1] += value * value / density;
            }
            let [albedo, square] = sums.map(|s| s / f64::from(N * N));
            let (exact, total) =
                (lobe.exact(Domain::Sphere).unwrap(), lobe.square(Domain::Sphere).unwrap());
            let what = format!("roughness {roughness}, view {view}");
            assert!((albedo / exact - 1.0).abs() < 2e-3, "{what}: {albedo}, {exact}");
            assert!((square / total - 1.0).abs() < 2e-3, "{what}: {square}, {total}");
            assert!(exact > 0.0 && exact < 1.0, "{what}: a surface reflects {exact} of the light");
        }
    }
}

/// The first modified Bessel function K of order 1, by the trapezoidal rule on its integral
/// `int_0^inf e^{-x cosh t} cosh t dt`.
fn bessel_k1(x: f64) -> f64 {
    let step = 1.0 / 64.0;
    (0..2000)
        .map(|k| f64::from(k) * step)
        .fold(-0.5 * (-x).exp(), |sum, t| sum + (-x * t.cosh()).exp() * t.cosh())
        * step
}

/// A narrow lobe seen along the normal is `a^2/(pi (a^2 + theta^2)^2)` with a = 2 alpha in the
/// tangent plane, whose Hankel transform is `a l K_1(a l)`.
#[test]
fn narrow_lobes_have_the_coefficients_of_the_plane() {
    let roughness = 0.03;
    let lmax = 6000;
    let coefficients = lobe(roughness, 0.0).coefficients(Domain::Sphere, lmax).unwrap();
    let (_, per_degree) = coefficients.as_zonal().unwrap();
    let a = 2.0 * roughness * roughness;
    for l in [1, 2, 10, 100, 700, 2000, 6000] {
        let degree = l as f64 + 0.5;
        let expected = (degree / TAU).sqrt() * a * degree * bessel_k1(a * degree);
        let ratio = per_degree[l] / expected;
        // Corrections of the order alpha^2 ln alpha, by curvature and by masking.
        assert!((ratio - 1.0).abs() < 1e-4, "{l}: {ratio}");
    }
    // Nearly all energy is below degree 6000.
    let energy = lobe(roughness, 0.0).energy(Domain::Sphere, lmax).unwrap();
    let sum: f64 = energy.per_band().iter().sum();
    assert!(sum <= energy.total() * (1.0 + 1e-12) && sum > 0.9999 * energy.total(), "{sum}");
}

/// A view next to the normal takes the general path, one along it the zonal path.
#[test]
fn views_near_the_normal_are_continuous() {
    for roughness in [0.05, 1.0] {
        let [zonal, general] = [0.0, 1e-7].map(|v| lobe(roughness, v));
        let (a, b) = (zonal.energy(Domain::Sphere, 200), general.energy(Domain::Sphere, 200));
        let (a, b) = (a.unwrap(), b.unwrap());
        for (l, (x, y)) in a.per_band().iter().zip(b.per_band()).enumerate() {
            assert!((x - y).abs() < 1e-11 * a.total(), "{roughness}, l = {l}: {x}, {y}");
        }
        let ratio =
            zonal.kurtosis(Domain::Sphere).unwrap() / general.kurtosis(Domain::Sphere).unwrap();
        assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
    }
}

#[test]
fn parameters_out_of_range_are_errors_with_a_reason() {
    let mirror = GgxLobe::new(0.0, 30.0).unwrap_err().to_string();
    assert!(mirror.contains("mirror"), "{mirror}");
    for (roughness, view) in
        [(9e-4, 0.0), (1.1, 0.0), (f64::NAN, 0.0), (0.5, 90.0), (0.5, -1.0), (0.5, f64::NAN)]
    {
        assert!(GgxLobe::new(roughness, view).is_err(), "{roughness}, {view}");
    }
    let parsed: Expression = "ggx:roughness=0.4,view=60 @ 40/10".parse().unwrap();
    let rotated = parsed.build(&NoFiles).unwrap();
    let ratio =
        rotated.exact(Domain::Sphere).unwrap() / lobe(0.4, 60.0).exact(Domain::Sphere).unwrap();
    assert!((ratio - 1.0).abs() < 1e-14);
    assert!("ggx:view=60".parse::<Expression>().is_err());
}
