//! Properties of every integrand, in one check.
//!
//! Integral, coefficients, energies and square are compared with each other and with a lattice of
//! many points, which is independent of them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use num_complex::Complex;
use sphvar_healpix::Nside;
use sphvar_integrands::{
    AbsCosine, Cap, Circle, ClampedCosine, DoubleCap, EnvironmentMap, GaussianFilter, GgxLobe,
    Harmonic, HealpixMap, Integrand, PhongLobe, Product, Rotated, SampledFunction, Sum,
    VonMisesFisher,
};
use sphvar_samplers::Domain;
use sphvar_sh::ylm_at;

/// The decay of the energy beyond a degree.
#[derive(Clone, Copy, Debug)]
enum Tail {
    /// No energy beyond the largest degree of the checks.
    None,
    /// As a power of the degree.
    Power(f64),
}

struct Case {
    name: &'static str,
    function: Box<dyn Integrand>,
    /// On the sphere and on the hemisphere.
    tails: [Tail; 2],
}

fn case(name: &'static str, tails: [Tail; 2], function: impl Integrand + 'static) -> Case {
    Case { name, function: Box::new(function), tails }
}

fn rotated(function: impl Integrand + 'static, theta: f64) -> Rotated<Box<dyn Integrand>> {
    let function: Box<dyn Integrand> = Box::new(function);
    Rotated::to_angles(function, theta.to_radians(), 0.3, 0.4).unwrap()
}

fn filtered(fwhm: f64, function: &dyn Integrand) -> Box<dyn Integrand> {
    GaussianFilter::new(fwhm).unwrap().apply(function).unwrap().function
}

/// A jump falls as 1/l, a kink as 1/l^3 (squares of coefficients as l^-2 and l^-4).
const JUMP: Tail = Tail::Power(1.0);
const KINK: Tail = Tail::Power(3.0);

fn cases() -> Vec<Case> {
    let cap = |degrees| Cap::from_degrees(degrees).unwrap();
    let vmf = |kappa| VonMisesFisher::new(kappa).unwrap();
    let phong = |n| PhongLobe::new(n).unwrap();
    let texels: Vec<f64> = (0..72).map(|k: u32| f64::from(k * 7919 % 31) / 31.0 + 0.1).collect();
    let environment = EnvironmentMap::new(12, 6, texels).unwrap();
    let map = |nside: u32| {
        let values = (0..12 * nside * nside).map(|k| f64::from(k * 7919 % 31) / 31.0).collect();
        HealpixMap::new(Nside::new(nside).unwrap(), values).unwrap()
    };
    let smooth = |d: DVec3| (d.x + 0.5 * d.z).exp() * (1.0 + d.y * d.z);
    let edged = |d: DVec3| if d.x >= 0.6 { 1.0 + d.y } else { d.z };
    vec![
        case("cap 10", [JUMP, JUMP], cap(10.0)),
        case("cap 135", [JUMP, Tail::None], cap(135.0)),
        case("cap 180", [Tail::None, Tail::None], cap(180.0)),
        case("half space", [JUMP, Tail::None], Cap::half_space(0.0).unwrap()),
        case("half space above", [JUMP, JUMP], Cap::half_space(0.3).unwrap()),
        case("cap rotated", [JUMP, JUMP], rotated(cap(40.0), 20.0)),
        case("cap on the equator", [JUMP, JUMP], rotated(cap(40.0), 75.0)),
        case("cap below", [JUMP, Tail::None], rotated(cap(20.0), 170.0)),
        case("double cap", [JUMP, JUMP], DoubleCap::from_degrees(60.0).unwrap()),
        case(
            "double cap rotated",
            [JUMP, JUMP],
            rotated(DoubleCap::from_degrees(60.0).unwrap(), 50.0),
        ),
        case("vmf 0", [Tail::None, Tail::None], vmf(0.0)),
        case("vmf 3", [Tail::None, KINK], vmf(3.0)),
        case("vmf 100", [Tail::None, Tail::None], vmf(100.0)),
        case("vmf 30 rotated", [Tail::None, JUMP], rotated(vmf(30.0), 80.0)),
        case("cosine", [KINK, KINK], ClampedCosine),
        case("cosine rotated", [KINK, JUMP], rotated(ClampedCosine, 60.0)),
        case("abs cosine rotated", [KINK, KINK], rotated(AbsCosine, 60.0)),
        case("phong 0", [JUMP, Tail::None], phong(0.0)),
        case("phong 0.5", [Tail::Power(2.0), Tail::Power(2.0)], phong(0.5)),
        case("phong 0.5 rotated", [Tail::Power(2.0), JUMP], rotated(phong(0.5), 60.0)),
        case("phong 12", [Tail::None, Tail::None], phong(12.0)),
        case("ggx", [KINK, KINK], GgxLobe::new(0.9, 0.0).unwrap()),
        case("ggx 40", [KINK, KINK], GgxLobe::new(0.9, 40.0).unwrap()),
        case("ggx rotated", [KINK, JUMP], rotated(GgxLobe::new(0.9, 40.0).unwrap(), 50.0)),
        case("filtered", [Tail::None, KINK], filtered(30.0, &cap(60.0))),
        case("filtered rotated", [Tail::None, JUMP], rotated(filtered(30.0, &cap(60.0)), 50.0)),
        case(
            "filtered caps",
            [Tail::None, JUMP],
            filtered(30.0, &Product::new(rotated(cap(50.0), 40.0), rotated(cap(45.0), 75.0))),
        ),
        case("ylm 4 0", [Tail::None, Tail::None], Harmonic::new(4, 0).unwrap()),
        case("ylm 4 -3", [Tail::None, Tail::None], Harmonic::new(4, -3).unwrap()),
        case(
            "ylm 4 3 rotated",
            [Tail::None, Tail::None],
            rotated(Harmonic::new(4, 3).unwrap(), 30.0),
        ),
        case("ylm 3 1 rotated", [Tail::None, JUMP], rotated(Harmonic::new(3, 1).unwrap(), 30.0)),
        // At the poles a value for every longitude: coefficients as l^-2, energies as l^-3. On the
        // hemisphere a jump across the equator, which does not dominate yet at these degrees.
        case("environment", [Tail::Power(2.0), Tail::Power(1.4)], environment.clone()),
        case("map 1", [JUMP, JUMP], map(1)),
        case("map 3", [JUMP, JUMP], map(3)),
        case("constant", [Tail::None, Tail::None], SampledFunction::new(|_: DVec3| 2.0, 0)),
        case("smooth", [Tail::None, JUMP], SampledFunction::new(smooth, 24)),
        case(
            "edged",
            [JUMP, JUMP],
            SampledFunction::new(edged, 1)
                .with_edge(Circle { axis: DVec3::X, angle: f64::acos(0.6) }),
        ),
        case(
            "cap and lobe",
            [JUMP, JUMP],
            Sum::default()
                .plus(1.0, rotated(cap(30.0), 40.0))
                .unwrap()
                .plus(-0.5, vmf(10.0))
                .unwrap()
                .plus(0.25, rotated(cap(50.0), 80.0))
                .unwrap(),
        ),
        case("lit cosine", [JUMP, JUMP], Product::new(rotated(cap(40.0), 60.0), ClampedCosine)),
        case(
            "two caps",
            [JUMP, JUMP],
            Product::new(rotated(cap(50.0), 40.0), rotated(cap(35.0), 75.0)),
        ),
        case("two lobes", [Tail::None, JUMP], Product::new(rotated(vmf(8.0), 70.0), vmf(5.0))),
        case("lit environment", [JUMP, JUMP], Product::new(environment, rotated(cap(70.0), 50.0))),
    ]
}

/// The largest degree of the checks; tails are compared between it and its half.
const LMAX: usize = 96;
/// Points of the lattice.
const POINTS: u32 = 60_000;
/// The degree to which coefficients are compared with the lattice.
const LATTICE_DEGREE: usize = 4;

/// A spherical Fibonacci lattice with the conjugate harmonics at its points.
struct Lattice {
    points: Vec<DVec3>,
    /// By degree, order and point, for the orders from 0.
    harmonics: Vec<Vec<Vec<Complex<f64>>>>,
}

impl Lattice {
    fn new() -> Self {
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let point = |j: u32| {
            let z = 1.0 - (2.0 * f64::from(j) + 1.0) / f64::from(POINTS);
            let (sin, cos) = (TAU * (f64::from(j) * golden).fract()).sin_cos();
            let radius = ((1.0 - z) * (1.0 + z)).sqrt();
            DVec3::new(radius * cos, radius * sin, z)
        };
        let points: Vec<DVec3> = (0..POINTS).map(point).collect();
        let of_order = |l: usize, m: usize| {
            let m = i64::try_from(m).unwrap();
            points.iter().map(|d| ylm_at(l, m, *d).unwrap().conj()).collect()
        };
        let harmonics =
            (0..=LATTICE_DEGREE).map(|l| (0..=l).map(|m| of_order(l, m)).collect()).collect();
        Self { points, harmonics }
    }

    /// Returns the points on the domain: the upper half comes first.
    fn on(&self, domain: Domain) -> &[DVec3] {
        let n = self.points.partition_point(|d| domain == Domain::Sphere || d.z >= 0.0);
        &self.points[..n]
    }
}

fn check(case: &Case, domain: Domain, tail: Tail, lattice: &Lattice) {
    let (name, f) = (case.name, &case.function);
    let what = format!("{name} {domain:?}");
    let copies = if domain == Domain::Sphere { 1.0 } else { 2.0 };
    let exact = f.exact(domain).unwrap();
    let coefficients = f.coefficients(domain, LMAX).unwrap();
    let energy = f.energy(domain, LMAX).unwrap();
    // Sums of a few thousand terms of the size of the largest value, or a transform good to 1e-13.
    let size = energy.total().sqrt().max(1e-3);
    let mean = coefficients.mean() * (4.0 * PI).sqrt() / copies;
    assert!((exact - mean).abs() < 1e-11 * size, "{what}: {exact} and {mean} by F_00");

    let per_degree = coefficients.energy_per_degree().unwrap();
    for (l, (a, b)) in per_degree.iter().zip(energy.per_band()).enumerate() {
        assert!((a - b).abs() < 1e-11 * size * size, "{what} l = {l}: {a} and {b}");
        assert!(domain.has_degree(l) || *a == 0.0, "{what}: odd degree {l}");
    }

    // The total is the sum over all degrees.
    let sum: f64 = energy.per_band().iter().sum();
    assert!(sum <= energy.total() * (1.0 + 1e-11), "{what}: {sum} of {}", energy.total());
    match tail {
        Tail::None => {
            assert!(
                (sum / energy.total().max(1e-30) - 1.0).abs() < 1e-11 || energy.total() < 1e-20,
                "{what}: {sum} of {}",
                energy.total()
            );
        }
        Tail::Power(power) => {
            // Smooth on average, with oscillations of a few 10 % from edges that intersect or are
            // small.
            let ratio = energy.beyond(LMAX / 2) / energy.beyond(LMAX);
            let exponent = ratio.log2();
            assert!((exponent - power).abs() < 0.35, "{what}: the rest falls as l^-{exponent}");
        }
    }

    // The error of the lattice comes from points misclassified at edges: some N^-3/4 for a jump of
    // 1.
    let weight = 4.0 * PI / f64::from(POINTS);
    let dirs = lattice.on(domain);
    let mut values = vec![0.0; dirs.len()];
    f.eval_into(dirs, &mut values).unwrap();
    values.iter_mut().for_each(|v| *v *= weight);
    let integral: f64 = values.iter().sum();
    assert!((integral - exact).abs() < 3e-3 * size, "{what}: {exact}, lattice {integral}");
    let square: f64 = values.iter().map(|v| copies * v * v / weight).sum();
    assert!((square - energy.total()).abs() < 5e-3 * size * size, "{what}: {square}");
    let alm = coefficients.to_alm().unwrap();
    for l in (0..=LATTICE_DEGREE).step_by(domain.degree_step()) {
        for m in 0..=l {
            let terms = lattice.harmonics[l][m].iter().zip(&values);
            let sum: Complex<f64> = terms.map(|(y, v)| y * v * copies).sum();
            assert!((sum - alm[(l, m)]).norm() < 5e-3 * size, "{what} l = {l}, m = {m}: {sum}");
        }
    }
}

#[test]
fn integral_coefficients_square_and_values_agree() {
    let lattice = Lattice::new();
    for case in cases() {
        for (domain, tail) in [Domain::Sphere, Domain::Hemisphere].into_iter().zip(case.tails) {
            check(&case, domain, tail, &lattice);
        }
    }
}

/// Additional edges do not change the results.
#[test]
fn edges_that_are_none_change_nothing() {
    let axis = DVec3::new(0.6, 0.0, 0.8);
    let cap = Cap::from_degrees(50.0).unwrap();
    let exact = cap.energy(Domain::Sphere, 40).unwrap();
    let function = move |d: DVec3| f64::from(d.dot(axis) >= 50f64.to_radians().cos());
    let mut shaped =
        SampledFunction::new(function, 0).with_edge(Circle { axis, angle: 50f64.to_radians() });
    for (tilt, angle) in [(1.0, 0.7), (2.0, FRAC_PI_2), (0.3, 1.4), (1.0, 0.70001)] {
        let (sin, cos) = f64::sin_cos(tilt);
        let axis = DVec3::new(0.0, sin, cos);
        shaped = shaped.with_edge(Circle { axis, angle });
        let energy = shaped.energy(Domain::Sphere, 40).unwrap();
        // Coefficients are accurate to 1e-13 of the transform and to the graded rules.
        assert!((energy.total() / exact.total() - 1.0).abs() < 1e-11, "{tilt}: {energy:?}");
        for (l, (a, b)) in energy.per_band().iter().zip(exact.per_band()).enumerate() {
            assert!((a - b).abs() < 1e-11, "{tilt} {angle} l = {l}: {a} and {b}");
        }
    }
}

#[test]
fn unavailable_quantities_are_errors_with_a_reason() {
    let map = HealpixMap::new(Nside::new(1).unwrap(), vec![1.0; 12]).unwrap();
    let product = Product::new(map, Cap::from_degrees(30.0).unwrap());
    let message = product.coefficients(Domain::Sphere, 3).unwrap_err().to_string();
    assert!(message.contains("edges of HEALPix pixels are not circles"), "{message}");
    let closure = Product::new(|d: DVec3| d.z, ClampedCosine);
    let message = closure.energy(Domain::Sphere, 3).unwrap_err().to_string();
    assert!(message.contains("only its values"), "{message}");
    assert!(Sum::default().plus(f64::NAN, ClampedCosine).is_err());
    assert!(Rotated::to_angles(ClampedCosine, f64::NAN, 0.0, 0.0).is_err());
    for bad in [-1e-300, f64::NAN, 1.1e6] {
        assert!(PhongLobe::new(bad).is_err(), "{bad}");
    }
    for bad in [-1.1, 1.0, f64::NAN] {
        assert!(Cap::half_space(bad).is_err(), "{bad}");
    }
    assert!(DoubleCap::from_degrees(90.1).is_err());
}
