//! Products with harmonics and their squares against quadrature.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use sphvar_healpix::Nside;
use sphvar_integrands::{
    Cap, Domain, EnvironmentMap, Error, Harmonic, HarmonicProjection, HealpixMap, Integrand,
    Product, Rotated, SampledFunction, Shape, VectorIntegrand, VonMisesFisher,
};

const LMAX: usize = 12;

/// A map of texels with large differences.
fn map(height: usize) -> EnvironmentMap {
    let texels = (0..2 * height * height).map(|k| ((37 * k + 11) % 23) as f64 - 4.0).collect();
    EnvironmentMap::new(2 * height, height, texels).unwrap().with_first_longitude(0.3)
}

/// A name and the function that makes an integrand.
type Named = (&'static str, fn() -> Box<dyn Integrand>);

fn functions() -> Vec<Named> {
    vec![
        ("cap", || {
            let cap = Cap::from_degrees(50.0).unwrap();
            Box::new(Rotated::new(cap, DQuat::from_rotation_x(0.7)).unwrap())
        }),
        ("lobe", || {
            let lobe = VonMisesFisher::new(6.0).unwrap();
            Box::new(Rotated::new(lobe, DQuat::from_rotation_y(2.1)).unwrap())
        }),
        ("band-limited", || Box::new(Harmonic::new(5, -3).unwrap())),
        ("odd", || Box::new(SampledFunction::new(|d: DVec3| d.z + d.x * d.y * d.z, 3))),
        ("map", || Box::new(map(3))),
        ("map of two texels", || Box::new(map(1))),
    ]
}

/// Every energy and both totals of every product equal those of a quadrature of the product.
#[test]
fn products_have_the_energies_of_a_quadrature() {
    for (name, build) in functions() {
        let f = build();
        let projection = HarmonicProjection::new(&*f, 3).unwrap();
        for (l, m) in projection.orders() {
            let product = projection.coefficient(l, m).unwrap();
            let slow = Product::new(build(), Harmonic::new(l, m).unwrap());
            let (got, expected) = (
                product.energy(Domain::Sphere, LMAX).unwrap(),
                slow.energy(Domain::Sphere, LMAX).unwrap(),
            );
            let tolerance = 1e-12 * expected.total();
            for (degree, (a, b)) in got.per_band().iter().zip(expected.per_band()).enumerate() {
                assert!((a - b).abs() < tolerance, "{name} {l} {m}, degree {degree}: {a} {b}");
            }
            let (a, b) = (got.centred(), expected.centred());
            let deviation = (a.even - b.even).abs().max((a.odd - b.odd).abs());
            assert!(deviation < tolerance, "{name} {l} {m}: {a:?} {b:?}");
            let (a, b) =
                (product.exact(Domain::Sphere).unwrap(), slow.exact(Domain::Sphere).unwrap());
            assert!((a - b).abs() < 1e-12 * expected.total().sqrt(), "{name} {l} {m}: {a} {b}");
        }
    }
}

/// Only the values and the shape of a map, so that its squares come from quadrature.
struct Values(EnvironmentMap);

impl Integrand for Values {
    fn eval(&self, dir: DVec3) -> f64 {
        self.0.eval(dir)
    }

    fn shape(&self) -> Result<Shape, Error> {
        self.0.shape()
    }
}

#[test]
fn squares_of_maps_are_those_of_a_quadrature() {
    for height in [1, 2, 5] {
        let (fast, slow) = (map(height), Values(map(height)));
        let (fast, slow) = (fast.squared_parts(8).unwrap(), slow.squared_parts(8).unwrap());
        for (a, b) in fast.iter().zip(&slow) {
            let (a, b) = (a.to_alm().unwrap(), b.to_alm().unwrap());
            let size = b[(0, 0)].norm();
            for ((l, m), (a, b)) in a.index().iter().zip(a.values().iter().zip(b.values())) {
                assert!((a - b).norm() < 1e-12 * size, "{height}, {l} {m}: {a} {b}");
            }
        }
    }
}

/// The energies of a HEALPix map's products approach the totals from its squares; those of either
/// parity would not with the other's square.
#[test]
fn products_of_healpix_maps_have_the_totals_of_their_squares() {
    let nside = Nside::new(2).unwrap();
    let values = (0..48).map(|k| f64::from((7 * k + 3) % 13)).collect();
    let map = HealpixMap::new(nside, values).unwrap();
    let projection = HarmonicProjection::new(&map, 2).unwrap();
    for (l, m) in projection.orders() {
        let product = projection.coefficient(l, m).unwrap();
        let energy = product.energy(Domain::Sphere, 400).unwrap();
        let rest = |lmax: usize| energy.beyond_by_class(lmax);
        for (near, far, total) in [
            (rest(100).even, rest(400).even, energy.centred().even),
            (rest(100).odd, rest(400).odd, energy.centred().odd),
        ] {
            // Jumps leave an energy of about 1/lmax.
            assert!(far > 0.0 && far < 0.02 * total, "{l} {m}: {far} of {total}");
            assert!((near / far / 4.0 - 1.0).abs() < 0.2, "{l} {m}: {near} {far}");
        }
    }
}

#[test]
fn values_of_components_are_those_of_their_integrands() {
    let f = map(2);
    let projection = HarmonicProjection::new(&f, 4).unwrap();
    let dirs = [DVec3::Z, DVec3::NEG_Z, DVec3::new(0.6, -0.48, 0.64)];
    let mut values = vec![0.0; 25 * dirs.len()];
    projection.eval_into(&dirs, &mut values).unwrap();
    for ((l, m), c) in projection.orders().zip(0..) {
        let one = projection.coefficient(l, m).unwrap();
        for (i, &dir) in dirs.iter().enumerate() {
            let (got, expected) = (values[25 * i + c], one.eval(dir));
            assert!((got - expected).abs() < 1e-12, "{l} {m} {dir}: {got} {expected}");
        }
    }
}

/// A nearly constant function keeps the digits of its variation in degree 0.
#[test]
fn the_variation_of_a_nearly_constant_function_is_known() {
    let texels = (0..8).map(|k| 1.0 + 1e-9 * f64::from(k % 3)).collect();
    let f = EnvironmentMap::new(4, 2, texels).unwrap();
    let projection = HarmonicProjection::new(&f, 1).unwrap();
    let product = projection.coefficient(0, 0).unwrap();
    let own = f.centred_square(Domain::Sphere).unwrap().sum() / (4.0 * PI);
    let got = product.centred_square(Domain::Sphere).unwrap().sum();
    assert!(own > 0.0 && (got / own - 1.0).abs() < 1e-12, "{got} {own}");
}

/// Radiance 1 has the irradiance pi for every normal; Ramamoorthi and Hanrahan (2001) state the
/// factors.
#[test]
fn irradiance_follows_from_coefficients() {
    let f = Cap::from_degrees(180.0).unwrap();
    let projection = HarmonicProjection::new(&f, 4).unwrap();
    let irradiance = projection.irradiance();
    let factors = [PI, 2.0 * PI / 3.0, PI / 4.0, 0.0, -PI / 24.0];
    for ((l, _), weight) in projection.orders().zip(irradiance.weights()) {
        assert!((weight - factors[l]).abs() < 1e-14, "{l}: {weight}");
    }
    let norm = irradiance.exact(Domain::Sphere).unwrap();
    assert!((norm / (PI * (4.0 * PI).sqrt()) - 1.0).abs() < 1e-14, "{norm}");
    let energy = irradiance.energy(Domain::Sphere, 6).unwrap();
    // F_lm has the energy 1 in degree l.
    for (l, e) in energy.per_band().iter().enumerate() {
        let factor = factors.get(l).copied().unwrap_or(0.0);
        assert!((e - (2 * l + 1) as f64 * factor * factor).abs() < 1e-12, "{l}: {e}");
    }
    assert!(irradiance.eval_into(&[DVec3::Z], &mut [0.0]).is_err());
}

#[test]
fn domains_degrees_and_orders_out_of_range_are_errors() {
    let f = map(1);
    let degree = HarmonicProjection::new(&f, 11).unwrap_err().to_string();
    assert!(degree.contains("at most 10") && degree.contains("11"), "{degree}");
    let projection = HarmonicProjection::new(&f, 2).unwrap();
    assert!(matches!(projection.coefficient(2, -3), Err(Error::Order { l: 2, m: -3 })));
    assert!(matches!(projection.coefficient(3, 0), Err(Error::Parameter { .. })));
    let hemisphere = projection.coefficient(1, 0).unwrap().energy(Domain::Hemisphere, 4);
    assert!(hemisphere.is_err_and(|e| e.to_string().contains("whole sphere")));
    // A closure has no energies, but it can be measured.
    let closure = |d: DVec3| d.x;
    let projection = HarmonicProjection::new(&closure, 1).unwrap();
    assert!(projection.exact().is_none());
    assert!(projection.irradiance().energy(Domain::Sphere, 2).is_err());
}
