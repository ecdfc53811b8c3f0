//! Energies of products that no affordable quadrature integrates exactly: estimates with errors.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use num_complex::Complex;
use sphvar_healpix::Nside;
use sphvar_integrands::{
    AbsCosine, AdaptiveFunction, Cap, ClampedCosine, Energy, EnvironmentMap, Error, GgxLobe,
    HealpixMap, Integrand, PhongLobe, Product, Rotated, Shape, Sum, Tolerance,
    VisibleHalfEstimator, VisibleHalfIntegrand,
};
use sphvar_samplers::Domain;
use sphvar_sh::ylm_at;

const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

fn environment(height: usize) -> EnvironmentMap {
    let texels = (0..2 * height * height).map(|k| (k * 7919 % 31) as f64 / 31.0 + 0.1).collect();
    EnvironmentMap::new(2 * height, height, texels).unwrap()
}

fn map(nside: u32, value: impl Fn(u32) -> f64) -> HealpixMap {
    let values = (0..12 * nside * nside).map(value).collect();
    HealpixMap::new(Nside::new(nside).unwrap(), values).unwrap()
}

fn tilted<I: Integrand>(function: I) -> Rotated<I> {
    Rotated::new(function, DQuat::from_rotation_x(0.7)).unwrap()
}

/// Asserts that estimates are within their errors of exact energies. Errors of kinks and jumps are
/// independent from rule to rule, so a single one may exceed the larger of two differences: three
/// times that, and a rounding, is never reached.
fn assert_within_errors(what: &str, got: &Energy, exact: &Energy) {
    let rounding = 1e-13 * exact.total();
    let errors = got.per_band_stderr().expect("the product is estimated");
    for (l, ((a, b), e)) in got.per_band().iter().zip(exact.per_band()).zip(errors).enumerate() {
        assert!((a - b).abs() <= 3.0 * e + rounding, "{what} l = {l}: {a} +- {e} and {b}");
    }
    let error = got.centred_stderr();
    let (a, b) = (got.centred(), exact.centred());
    for (a, b, e) in [(a.even, b.even, error.even), (a.odd, b.odd, error.odd)] {
        assert!((a - b).abs() <= 3.0 * e + rounding, "{what}: {a} +- {e} and {b}");
    }
    assert!(error.sum() < 2e-3 * exact.centred().sum(), "{what}: {error:?}");
}

/// A constant map has no shape, so its products are estimated; they are multiples of the factor.
#[test]
fn products_with_a_constant_map_are_the_other_factor() {
    let cap = || tilted(Cap::from_degrees(40.0).unwrap());
    let cases: [(&str, Domain, Box<dyn Integrand>); 5] = [
        ("cosine", Domain::Hemisphere, Box::new(tilted(ClampedCosine))),
        ("cap", Domain::Sphere, Box::new(cap())),
        ("cap", Domain::Hemisphere, Box::new(cap())),
        ("lobe", Domain::Sphere, Box::new(tilted(PhongLobe::new(20.0).unwrap()))),
        // A lobe of half a degree, which the first rules may miss.
        ("narrow lobe", Domain::Sphere, Box::new(tilted(PhongLobe::new(12_000.0).unwrap()))),
    ];
    for (name, domain, factor) in cases {
        let integral = factor.exact(domain).unwrap();
        let exact = factor.energy(domain, 60).unwrap();
        let product = Product::new(map(1, |_| 1.0), factor);
        let (got, error) = product.integral_estimate(domain).unwrap();
        let bound = 3.0 * error + 1e-11 * integral;
        assert!((got - integral).abs() <= bound, "{name}: {got} +- {error} and {integral}");
        assert!(error <= 1e-3 * integral, "{name}: {got} +- {error}");
        let got = product.energy(domain, 60).unwrap();
        assert_within_errors(&format!("{name} {domain:?}"), &got, &exact);
    }
}

/// Returns a spherical Fibonacci lattice.
fn lattice() -> impl Iterator<Item = DVec3> {
    const POINTS: u32 = 200_000;
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    (0..POINTS).map(move |j| {
        let z = 1.0 - (2.0 * f64::from(j) + 1.0) / f64::from(POINTS);
        let (sin, cos) = (TAU * (f64::from(j) * golden).fract()).sin_cos();
        let radius = ((1.0 - z) * (1.0 + z)).sqrt();
        DVec3::new(radius * cos, radius * sin, z)
    })
}

fn two_maps() -> impl Integrand {
    Product::new(environment(48), tilted(environment(32)))
}

fn map_and_lobe() -> impl Integrand {
    Product::new(environment(256), tilted(GgxLobe::new(0.4, 30.0).unwrap()))
}

/// The edges of all texels cross in too many places: products, sums and visible halves agree with
/// sums over a lattice, whose error for a jump at the equator or between pixels is some N^-3/4.
#[test]
fn estimates_agree_with_sums_over_many_points() {
    let pixels = Product::new(map(4, |k| f64::from(k * 7919 % 31)), ClampedCosine);
    let half = two_maps();
    let half = VisibleHalfIntegrand::new(&half, VisibleHalfEstimator::Unbiased).unwrap();
    assert_agree_with_sums("pixels", &pixels, &[Domain::Hemisphere]);
    assert_agree_with_sums("visible half", &half, &[Domain::Sphere]);
}

/// The same for more products.
#[test]
#[ignore = "slow"]
fn estimates_of_more_products_agree_with_sums_over_many_points() {
    let pixels = Product::new(map(4, |k| f64::from(k * 7919 % 31)), ClampedCosine);
    let sum = Sum::default().plus(0.5, two_maps()).unwrap().plus(2.0, map_and_lobe()).unwrap();
    assert_agree_with_sums("two maps", &two_maps(), &DOMAINS);
    assert_agree_with_sums("map and lobe", &map_and_lobe(), &[Domain::Sphere]);
    assert_agree_with_sums("pixels", &pixels, &[Domain::Sphere]);
    assert_agree_with_sums("sum", &sum, &[Domain::Sphere]);
}

/// Compares energies with sums over the lattice.
#[track_caller]
fn assert_agree_with_sums(name: &str, function: &dyn Integrand, domains: &[Domain]) {
    for &domain in domains {
        let what = format!("{name} {domain:?}");
        let energy = function.energy(domain, 300).unwrap();
        assert!(energy.errors().is_some() && energy.lmax() == 300, "{what}");
        assert!(energy.centred_stderr().sum() < 2e-3 * energy.total(), "{what}: {energy:?}");
        let copies = if domain == Domain::Sphere { 1.0 } else { 2.0 };
        let dirs: Vec<DVec3> =
            lattice().filter(|d| domain == Domain::Sphere || d.z >= 0.0).collect();
        let mut values = vec![0.0; dirs.len()];
        function.eval_into(&dirs, &mut values).unwrap();
        let weight = domain.area() / dirs.len() as f64;
        let square: f64 = values.iter().map(|v| copies * weight * v * v).sum();
        assert!((square / energy.total() - 1.0).abs() < 3e-3, "{what}: {square}");
        for l in (0..=2).step_by(domain.degree_step()) {
            let of_order = |m: i64| -> Complex<f64> {
                let terms = dirs.iter().zip(&values);
                terms.map(|(d, v)| copies * weight * v * ylm_at(l, m, *d).unwrap()).sum()
            };
            let degree = i64::try_from(l).unwrap();
            let sum: f64 = (-degree..=degree).map(|m| of_order(m).norm_sqr()).sum();
            let got = energy.per_band()[l];
            assert!((sum - got).abs() < 2e-3 * energy.total(), "{what} {l}: {sum}, {got}");
        }
    }
}

/// A single term keeps the estimate, a factor without known features has none.
#[test]
fn multiples_keep_estimates_and_unknown_features_are_errors() {
    let product = || Product::new(map(1, f64::from), ClampedCosine);
    let bare = product().energy(Domain::Sphere, 20).unwrap();
    let multiple = Sum::default().plus(-3.0, product()).unwrap();
    assert_eq!(multiple.energy(Domain::Sphere, 20).unwrap(), bare.of_multiple(-3.0));
    let of_closure = Product::new(map(1, |_| 1.0), |d: DVec3| d.z);
    assert!(of_closure.energy(Domain::Sphere, 3).is_err());
    let narrow = Product::new(map(1, |_| 1.0), PhongLobe::new(1e6).unwrap());
    let message = narrow.energy(Domain::Sphere, 3).unwrap_err().to_string();
    assert!(message.contains("narrower than 0.1 degrees"), "{message}");
}

/// Where a quadrature is affordable it is exact, and estimates are within their errors of it.
#[test]
fn affordable_products_stay_exact() {
    let product = || Product::new(environment(6), tilted(PhongLobe::new(20.0).unwrap()));
    for domain in DOMAINS {
        let exact = product().energy(domain, 30).unwrap();
        assert!(exact.errors().is_none());
        let tolerance = Tolerance { max_evaluations: 400_000, ..Tolerance::default() };
        let estimated = AdaptiveFunction::new(product(), domain, tolerance).unwrap();
        assert_within_errors("lobe", &estimated.energy(domain, 30).unwrap(), &exact);
    }
}

/// A map of which only values and edges are known, for quadrature between all of them.
struct Values(EnvironmentMap);

impl Integrand for Values {
    fn eval(&self, dir: DVec3) -> f64 {
        self.0.eval(dir)
    }

    fn shape(&self) -> Result<Shape, Error> {
        self.0.shape()
    }
}

/// Products of a map and a function of z follow from the rows of the map; quadrature between all
/// edges gives the same.
#[test]
fn products_with_functions_of_z_agree_with_quadrature() {
    let below = DQuat::from_rotation_x(std::f64::consts::PI);
    let factors: [&dyn Fn() -> Box<dyn Integrand>; 6] = [
        &|| Box::new(ClampedCosine),
        &|| Box::new(AbsCosine),
        &|| Box::new(PhongLobe::new(20.0).unwrap()),
        &|| Box::new(Cap::from_degrees(50.0).unwrap()),
        &|| Box::new(Cap::from_degrees(117.0).unwrap()),
        &|| Box::new(Rotated::new(Cap::from_degrees(70.0).unwrap(), below).unwrap()),
    ];
    let map = || environment(6).with_first_longitude(0.3);
    for (i, factor) in factors.iter().enumerate() {
        for domain in DOMAINS {
            if domain == Domain::Hemisphere && i == 5 {
                continue;
            }
            let rows = Product::new(factor(), map());
            let values = Product::new(Values(map()), factor());
            let [a, b] = [rows.exact(domain), values.exact(domain)].map(Option::unwrap);
            assert!((a / b - 1.0).abs() < 1e-12, "{i} {domain}: {a}, {b}");
            let [a, b] = [rows.energy(domain, 24), values.energy(domain, 24)].map(Result::unwrap);
            assert!(a.errors().is_none() && b.errors().is_none());
            let rounding = 1e-12 * b.total();
            for (l, (a, b)) in a.per_band().iter().zip(b.per_band()).enumerate() {
                assert!((a - b).abs() <= rounding, "{i} {domain} l = {l}: {a}, {b}");
            }
            let (a, b) = (a.centred(), b.centred());
            let difference = (a.even - b.even).abs().max((a.odd - b.odd).abs());
            assert!(difference <= rounding, "{i} {domain}: {a:?}, {b:?}");
        }
    }
}

/// The part above the horizon of a constant map of 1 times the indicator of z >= 0 is constant, so
/// nothing is left of its centred square but rounding.
#[test]
fn a_constant_product_has_no_variation() {
    let constant = EnvironmentMap::new(8, 4, vec![1e3; 32]).unwrap();
    let product = Product::new(constant, Cap::from_degrees(90.0).unwrap());
    let square = product.centred_square(Domain::Hemisphere).unwrap().sum();
    assert!(square < 1e-24 * 1e6, "{square}");
}
