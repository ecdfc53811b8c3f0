//! Combinations of integrands against closed forms, for random parameters and at the extremes.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use sphvar_healpix::{Nested, Nside, PixelOrder, Ring};
use sphvar_integrands::{
    Cap, ClampedCosine, DoubleCap, Error, HealpixMap, Integrand, PhongLobe, Product, Rotated, Sum,
    VonMisesFisher,
};
use sphvar_samplers::Domain;
use sphvar_sh::{Alm, GaussLegendre, ylm_at};

/// Returns the area of the intersection of two caps with centres at the distance `d` (Tovchigrechko
/// and Vakser 2001).
fn lens(a: f64, b: f64, d: f64) -> f64 {
    if d >= a + b {
        return 0.0;
    }
    let cap = |a: f64| 2.0 * PI * (1.0 - a.cos());
    if d <= (a - b).abs() {
        return cap(a.min(b));
    }
    // The angle of a spherical triangle opposite to the side x, by half angles.
    let angle = |x: f64, y: f64, z: f64| {
        let half = 0.5 * (x + y + z);
        let (near, far) = ((half - y).sin() * (half - z).sin(), half.sin() * (half - x).sin());
        2.0 * near.max(0.0).sqrt().atan2(far.max(0.0).sqrt())
    };
    2.0 * (PI - angle(d, a, b) - angle(b, d, a) * a.cos() - angle(a, d, b) * b.cos())
}

fn tilted(degrees: f64, tilt: f64) -> Rotated<Cap> {
    Rotated::new(Cap::from_degrees(degrees).unwrap(), DQuat::from_rotation_x(tilt)).unwrap()
}

fn rotation() -> impl Strategy<Value = DQuat> {
    let part = || -1.0..1.0_f64;
    (part(), part(), part(), part())
        .prop_filter("no direction", |(x, y, z, w)| x * x + y * y + z * z + w * w > 0.01)
        .prop_map(|(x, y, z, w)| DQuat::from_xyzw(x, y, z, w).normalize())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn two_caps_share_a_lens(a in 1.0..89.0_f64, b in 1.0..89.0_f64, d in 0.01..3.0_f64) {
        let product = Product::new(Cap::from_degrees(a).unwrap(), tilted(b, d));
        let exact = lens(a.to_radians(), b.to_radians(), d);
        let got = product.exact(Domain::Sphere).unwrap();
        // Where the circles nearly touch, the root of the rounding of their distance, over the
        // length of the lens.
        prop_assert!((got - exact).abs() < 1e-11, "{a} {b} {d}: {got}, not {exact}");
    }

    #[test]
    fn a_cap_above_the_horizon_lights_by_its_height(a in 1.0..60.0_f64, share in 0.0..1.0_f64) {
        let tilt = share * (FRAC_PI_2 - a.to_radians());
        let product = Product::new(tilted(a, tilt), ClampedCosine);
        let exact = PI * a.to_radians().sin().powi(2) * tilt.cos();
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let got = product.exact(domain).unwrap();
            prop_assert!((got - exact).abs() < 1e-11, "{a} {tilt}: {got}, not {exact}");
        }
    }

    #[test]
    fn products_of_lobes_are_lobes(k in 0.1..300.0_f64, q in 0.1..300.0_f64, tilt in 0.0..3.1_f64) {
        let lobe = |kappa| VonMisesFisher::new(kappa).unwrap();
        let product = Product::new(
            lobe(k), Rotated::new(lobe(q), DQuat::from_rotation_y(tilt)).unwrap());
        let r = (k * k + q * q + 2.0 * k * q * tilt.cos()).sqrt();
        // C(k) C(q) 4 pi sinh(r)/r with C(k) = k/(4 pi sinh k), exponentials taken together.
        let half = |x: f64| -0.5 * (-2.0 * x).exp_m1();
        let exact = k * q / (4.0 * PI * r) * half(r) / (half(k) * half(q)) * (r - k - q).exp();
        let got = product.exact(Domain::Sphere).unwrap();
        // The series has terms of the size of the peaks' root.
        let size = (k * q).sqrt() + 1.0;
        prop_assert!((got - exact).abs() < 1e-12 * size, "{k} {q} {tilt}: {got}, not {exact}");
    }

    #[test]
    fn rotations_keep_the_energy_of_a_sum(
        a in 5.0..85.0_f64, kappa in 0.5..50.0_f64, n in 0_u32..6, tilt in 0.1..3.0_f64,
        q in rotation(),
    ) {
        let sum = |rotation: DQuat| -> Result<Sum, Error> {
            let tilt = DQuat::from_rotation_x(tilt);
            let lobe = VonMisesFisher::new(kappa)?;
            Sum::default()
                .plus(1.0, Rotated::new(Cap::from_degrees(a)?, rotation)?)?
                .plus(-0.3, Rotated::new(lobe, rotation * tilt)?)?
                .plus(0.7, Rotated::new(PhongLobe::new(f64::from(n))?, rotation * tilt.inverse())?)
        };
        let (before, after) = (sum(DQuat::IDENTITY).unwrap(), sum(q).unwrap());
        let (e, f) = (
            before.energy(Domain::Sphere, 30).unwrap(), after.energy(Domain::Sphere, 30).unwrap());
        // Rings about other axes: the rounding of the graded rules.
        prop_assert!((e.total() - f.total()).abs() < 1e-10 * e.total(), "{} {}", e.total(), f.total());
        for (l, (x, y)) in e.per_band().iter().zip(f.per_band()).enumerate() {
            prop_assert!((x - y).abs() < 1e-11 * e.total(), "l = {l}: {x} and {y}");
        }
    }

    /// Compares the energies on the hemisphere, by quadrature of rings that the equator cuts, with
    /// the closed form of the even function formed by the two caps.
    #[test]
    fn the_equator_may_cut_what_it_likes(degrees in 5.0..85.0_f64, tilt in 0.0..3.1_f64) {
        let both = Sum::default().plus(1.0, tilted(degrees, tilt)).unwrap()
            .plus(1.0, tilted(degrees, tilt + PI)).unwrap();
        let double = Rotated::new(
            DoubleCap::from_degrees(degrees).unwrap(), DQuat::from_rotation_x(tilt)).unwrap();
        let (e, f) = (
            both.energy(Domain::Hemisphere, 24).unwrap(),
            double.energy(Domain::Hemisphere, 24).unwrap(),
        );
        prop_assert!((e.total() - f.total()).abs() < 1e-10, "{} and {}", e.total(), f.total());
        for (l, (x, y)) in e.per_band().iter().zip(f.per_band()).enumerate() {
            prop_assert!((x - y).abs() < 1e-10, "l = {l}: {x} and {y}");
        }
    }
}

/// Phong's lobe of exponent 0 is the half space, which is the cap of 90 degrees.
#[test]
fn three_half_spaces_are_one() {
    let lmax = 100_000;
    let energies = |f: &dyn Integrand| f.energy(Domain::Sphere, lmax).unwrap();
    let phong = energies(&PhongLobe::new(0.0).unwrap());
    for cap in [Cap::from_degrees(90.0).unwrap(), Cap::half_space(0.0).unwrap()] {
        let cap = energies(&cap);
        for (l, (a, b)) in cap.per_band().iter().zip(phong.per_band()).enumerate() {
            // A product of l/2 factors against a recurrence of l steps, and the f64 nearest to
            // pi/2.
            let bound = 40.0 * f64::EPSILON * (l as f64 + 1.0) * b + 1e-30;
            assert!((a - b).abs() <= bound, "l = {l}: {a:e} and {b:e}");
        }
    }
}

/// Sums to degree 100000 and the mean tail `sum_{l > L} E(l) = 2 sin(t)/L`, from a cap that no
/// degree resolves to nearly the whole sphere.
#[test]
fn caps_of_any_size_sum_to_their_area() {
    let lmax = 100_000;
    for degrees in [1e-6, 1e-3, 1.0, 60.0, 90.0, 135.0, 179.0, 179.999999, 180.0] {
        let cap = Cap::from_degrees(degrees).unwrap();
        let energy = cap.energy(Domain::Sphere, lmax).unwrap();
        let area = cap.exact(Domain::Sphere).unwrap();
        let sum: f64 = energy.per_band().iter().sum();
        let sin = degrees.to_radians().sin();
        if degrees < 1.0 {
            // Below one wavelength across: the encircled energy of the Airy pattern.
            let expected = area * encircled((lmax as f64 + 1.0) * degrees.to_radians());
            assert!((sum / expected - 1.0).abs() < 1e-8, "{degrees}: {sum:e}, not {expected:e}");
        } else if degrees <= 179.0 {
            let tail = 2.0 * sin / lmax as f64;
            // The oscillation about the mean is 1/(2 L t) of it.
            let share = (area - sum) / tail;
            assert!((share - 1.0).abs() < 1e-3, "{degrees}: {share}");
        } else {
            // The rest of the sphere has an area of 1e-15.
            assert!((sum / area - 1.0).abs() < 1e-13, "{degrees}: {sum}");
        }
    }
}

/// `1 - J_0(x)^2 - J_1(x)^2` for x below 2, by the power series of the Bessel functions. The
/// relative error grows as x^-2.
fn encircled(x: f64) -> f64 {
    let bessel = |order: u32| {
        let mut term = (0.5 * x).powi(i32::try_from(order).unwrap());
        let mut sum = term;
        for k in 1..30 {
            term *= -0.25 * x * x / f64::from(k * (k + order));
            sum += term;
        }
        sum
    };
    (1.0 - bessel(0)) * (1.0 + bessel(0)) - bessel(1).powi(2)
}

#[test]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "thousands")]
fn narrow_phong_lobes_sum_to_their_total() {
    for n in [1e2, 12345.6, PhongLobe::MAX_EXPONENT] {
        let energy =
            PhongLobe::new(n).unwrap().energy(Domain::Sphere, (12.0 * n.sqrt()) as usize).unwrap();
        let sum: f64 = energy.per_band().iter().sum();
        assert!((sum / energy.total() - 1.0).abs() < 1e-11, "n = {n}: {sum} of {}", energy.total());
    }
}

/// The narrowest lobe, rotated, on both domains and multiplied by a narrow cap.
#[test]
fn the_narrowest_lobe_has_acceptable_cost() {
    let lobe = VonMisesFisher::new(VonMisesFisher::MAX_KAPPA).unwrap();
    let rotated = |degrees: f64| Rotated::to_angles(lobe, degrees.to_radians(), 0.2, 0.0).unwrap();
    for (degrees, share) in [(60.0, 1.0), (90.0, 0.5), (120.0, 0.0)] {
        let f = rotated(degrees);
        let exact = f.exact(Domain::Hemisphere).unwrap();
        // The equator is met with the rounding of cos(90 degrees) over the width 1e-3.
        assert!((exact - share).abs() < 1e-12, "{degrees}: {exact}");
        let energy = f.energy(Domain::Hemisphere, 8).unwrap();
        let expected = 4.0 / (4.0 * PI) * share * share;
        assert!((energy.per_band()[0] - expected).abs() < 1e-11, "{degrees}: {energy:?}");
    }
    let product = Product::new(rotated(60.0), tilted(0.05, 1.0));
    assert!(product.exact(Domain::Sphere).unwrap().abs() < 1e-12);
}

/// The coefficients of single pixels by Gauss-Legendre quadrature in their equal-area coordinates.
#[test]
fn pixels_have_the_coefficients_of_their_quadrature() {
    const LMAX: usize = 24;
    let nside = Nside::new(4).unwrap();
    let order = Ring::new(nside);
    let rule = GaussLegendre::new(24).unwrap();
    // Pixels in both caps and the belt: none is crossed by |z| = 2/3, where the coordinates have a
    // kink, or touches a pole, where they have no derivative.
    for pixel in [5, 60, 90, 101, 187] {
        let mut values = vec![0.0; 192];
        values[pixel] = 1.0;
        let map = HealpixMap::new(nside, values).unwrap();
        let got = map.alm(Domain::Sphere, LMAX).unwrap();
        let mut expected = Alm::zeros(LMAX).unwrap();
        for (x, v) in rule.nodes().iter().zip(rule.weights()) {
            for (y, w) in rule.nodes().iter().zip(rule.weights()) {
                let dir = order.uniform_point(pixel as u64, 0.5 * (1.0 + x), 0.5 * (1.0 + y));
                let weight = 0.25 * v * w * nside.pixel_area();
                for (l, m) in expected.index().iter() {
                    let order = i64::try_from(m).unwrap();
                    expected[(l, m)] += ylm_at(l, order, dir).unwrap().conj() * weight;
                }
            }
        }
        for (l, m) in expected.index().iter() {
            let error = (got[(l, m)] - expected[(l, m)]).norm();
            // Coefficients are at most 0.03; a few hundred roundings of that.
            assert!(error < 1e-14, "pixel {pixel}, l = {l}, m = {m}: {error:e}");
        }
    }
}

/// A map of a smooth function has its energies up to the pixel window, `1 - O(l(l+1) Omega)`, some
/// 0.13 for the coefficient here. (The estimate by points, `anafast` of healpy with iterations, has
/// the energies of the function to 1e-14 at the same centres, because it ignores the extent of
/// pixels.)
#[test]
fn a_smooth_map_has_the_energies_of_the_function() {
    let order = Nested::new(Nside::new(16).unwrap()).unwrap();
    let function = |d: DVec3| 1.0 + d.z + d.x * d.y;
    let values = (0..order.n_pixels()).map(|p| function(order.centre(p))).collect();
    let map = HealpixMap::from_nested(order, values).unwrap();
    assert!((map.eval(DVec3::Z) - function(DVec3::Z)).abs() < 0.1);
    let energy = map.energy(Domain::Sphere, 4).unwrap();
    let expected = [4.0 * PI, 4.0 * PI / 3.0, 4.0 * PI / 15.0];
    for (l, e) in expected.into_iter().enumerate() {
        let max_loss = 0.2 * (l * (l + 1)) as f64 * order.nside().pixel_area();
        let got = energy.per_band()[l] / e;
        assert!((1.0 - max_loss - 1e-12..=1.0 + 1e-12).contains(&got), "l = {l}: {got}");
    }
}

#[test]
fn maps_of_pixels_are_checked() {
    let nside = Nside::new(2).unwrap();
    assert!(matches!(
        HealpixMap::new(nside, vec![0.0; 47]),
        Err(Error::PixelCount { expected: 48, .. })
    ));
    let mut values = vec![0.0; 48];
    (values[7], values[9], values[11]) = (f64::NAN, f64::from(-1.6375e30_f32), -1.6375e30);
    let error = HealpixMap::from_nested(Nested::new(nside).unwrap(), values).unwrap_err();
    assert_eq!(error.to_string().find("3 pixels of the map"), Some(0), "{error}");
    assert!(error.to_string().contains("first is 7"), "{error}");
}
