//! Variances of fixed point sets under random rotations, from sums over pairs, which have no tail.

use std::f64::consts::PI;

use glam::DVec3;
use sphvar_integrands::{Cap, Integrand};
use sphvar_samplers::{Domain, Ensemble, Error, Pattern, PointSet, Progress, Purpose, Streams};
use sphvar_sh::ByParity;
use sphvar_spectrum::{ExactSpectrum, Resolution, Spectrum, SpectrumAccumulator, accumulate};
use sphvar_variance::{Prediction, PredictionAccumulator, predict};

/// Returns the area of the intersection of two caps of angle `theta`, at most 90 degrees, whose
/// axes are `gamma` apart.
fn lens(theta: f64, gamma: f64) -> f64 {
    if gamma >= 2.0 * theta {
        return 0.0;
    }
    let (s, c) = theta.sin_cos();
    // The isosceles triangle formed by the two axes and a corner of the lens; its angles at the
    // corner and at an axis.
    let corner = 2.0 * ((0.5 * gamma).sin() / s).min(1.0).asin();
    let half = (c * (0.5 * gamma).tan() / s).clamp(-1.0, 1.0).acos();
    2.0 * PI - 2.0 * corner - 4.0 * c * half
}

/// `Var(Q) = 4 pi sum w_j w_k lens(angle)/(sum w)^2 - A^2`: a random cap contains two points if and
/// only if its axis lies in the caps about both. A cap beyond 90 degrees has the variance of its
/// complement.
fn variance_by_pairs(points: &[DVec3], weights: &[f64], degrees: f64) -> f64 {
    let theta = degrees.min(180.0 - degrees).to_radians();
    let weight = |k: usize| weights.get(k).copied().unwrap_or(1.0);
    let (mut sum, mut total) = (0.0, 0.0);
    for (j, a) in points.iter().enumerate() {
        total += weight(j);
        for (k, b) in points.iter().enumerate() {
            let gamma = if j == k { 0.0 } else { a.cross(*b).length().atan2(a.dot(*b)) };
            sum += weight(j) * weight(k) * lens(theta, gamma);
        }
    }
    let area = 2.0 * PI * (1.0 - theta.cos());
    4.0 * PI * sum / (total * total) - area * area
}

struct One<'a>(&'a [DVec3], &'a [f64]);

impl Ensemble for One<'_> {
    fn realize_into(&self, _: u64, set: &mut PointSet, _: &dyn Progress) -> Result<(), Error> {
        *set = PointSet { points: self.0.to_vec(), weights: self.1.to_vec() };
        Ok(())
    }
}

fn pattern(pattern: &Pattern, n: usize) -> Vec<DVec3> {
    let sampler = pattern.build(n, Domain::Sphere).unwrap();
    sampler.sample(&mut Streams::new(0, Purpose::Pattern, 0).realization(0)).unwrap().points
}

fn icosahedron() -> Vec<DVec3> {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let corners = [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)];
    let cyclic =
        |(a, b): (f64, f64)| [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)];
    corners.into_iter().flat_map(cyclic).map(DVec3::normalize).collect()
}

fn sets() -> Vec<(&'static str, Vec<DVec3>, Vec<f64>)> {
    let spiral = pattern(&Pattern::Spiral, 60);
    // Every third point twice, every fourth with its antipode, of two weights.
    let mut repeated = spiral.clone();
    repeated.extend(spiral.iter().step_by(3));
    repeated.extend(spiral.iter().step_by(4).map(|p| -*p));
    let weights = (0..repeated.len()).map(|k| if k % 2 == 0 { 1.0 } else { 2.5 }).collect();
    vec![
        ("poles", vec![DVec3::Z, DVec3::NEG_Z], vec![]),
        ("icosahedron", icosahedron(), vec![]),
        ("healpix 12", pattern(&Pattern::Healpix, 12), vec![]),
        ("healpix 108", pattern(&Pattern::Healpix, 108), vec![]),
        ("fibonacci", pattern(&Pattern::FIBONACCI, 101), vec![]),
        ("spiral", spiral, vec![]),
        ("repeated", repeated.clone(), vec![]),
        ("weighted", repeated, weights),
    ]
}

/// Returns the spectrum and the predictions from it: realization by realization and from the mean
/// spectrum.
fn predictions(
    points: &[DVec3],
    weights: &[f64],
    degrees: f64,
    lmax: usize,
) -> (Spectrum, [Prediction; 2]) {
    let n = points.len();
    let energy = Cap::from_degrees(degrees).unwrap().energy(Domain::Sphere, lmax).unwrap();
    let empty = (
        SpectrumAccumulator::new(Domain::Sphere, n, lmax),
        PredictionAccumulator::new(&energy, n, lmax),
    );
    let resolution = Resolution::new(lmax, n);
    let sums = accumulate(&One(points, weights), resolution, 0..1, &empty, &()).unwrap();
    let spectrum = sums.0.finish().unwrap().into_exact();
    let direct = predict(&spectrum, &energy);
    (spectrum, [sums.1.finish(), direct])
}

/// Half spaces intersect in lunes, a cap intersects itself in itself, and caps that touch have an
/// empty intersection.
#[test]
fn lenses_have_the_known_areas() {
    for gamma in [1e-9, 0.3, 1.0, 3.0] {
        assert!((lens(0.5 * PI, gamma) - 2.0 * (PI - gamma)).abs() < 1e-14, "{gamma}");
    }
    for theta in [0.1, 1.0, 1.5] {
        let area = 2.0 * PI * (1.0 - f64::cos(theta));
        assert!((lens(theta, 1e-9) - area).abs() < 1e-8, "{theta}");
        assert!(lens(theta, 2.0 * theta - 1e-9) < 1e-7, "{theta}");
    }
}

/// For caps of any angle the stated tail error holds, and with the tail by parity the remaining
/// error is small. `T = 1` for all degrees would be wrong by the whole tail for half spaces.
#[test]
fn predictions_with_tails_by_parity_are_the_sums_over_pairs() {
    const LMAX: usize = 1200;
    for (name, points, weights) in sets() {
        for degrees in [15.0, 60.0, 85.0, 90.0, 120.0, 175.0] {
            let truth = variance_by_pairs(&points, &weights, degrees);
            for got in predictions(&points, &weights, degrees, LMAX).1 {
                let variance = got.variance;
                let off = (variance - truth).abs();
                // The sum over pairs has roundings of the size of A^2.
                let allowed = got.tail_error + 1e-12;
                assert!(
                    off <= allowed,
                    "{name}, {degrees}: {variance:e}, by pairs {truth:e}, {got:?}"
                );
                assert!(off <= 2e-3 * truth + 1e-12, "{name}, {degrees}: {variance:e}, {truth:e}");
            }
        }
    }
}

/// A half space minus its mean is odd, so antipodal sets of any size integrate it exactly.
#[test]
fn antipodal_sets_integrate_half_spaces_exactly() {
    for (name, points, weights) in sets().into_iter().take(4) {
        assert!(variance_by_pairs(&points, &weights, 90.0).abs() < 1e-13, "{name}");
        for lmax in [8, 1200] {
            for got in predictions(&points, &weights, 90.0, lmax).1 {
                assert!(got.variance < 1e-20 && got.tail_error < 1e-20, "{name}: {got:?}");
            }
        }
    }
    for n in [12, 48, 192, 3072] {
        let sampler = Pattern::Healpix.build(n, Domain::Sphere).unwrap();
        let spectrum = ExactSpectrum::of(&*sampler).unwrap().to(64, &()).unwrap();
        assert_eq!(spectrum.tail(), ByParity { even: 2.0, odd: 0.0 });
        let energy = Cap::half_space(0.0).unwrap().energy(Domain::Sphere, 64).unwrap();
        let got = predict(&spectrum, &energy);
        assert!(got.variance < 1e-20 && got.tail_error < 1e-20, "{n}: {got:?}");
    }
}

/// P does not depend on the magnitude of the weights over the range of f64: two points at right
/// angles with weights 1 and 2 have `P(l) = 1 + 2 (1 x 2) P_l(0)/5`, so 1.8, 1, 0.6.
#[test]
fn power_does_not_depend_on_the_magnitude_of_weights() {
    let points = [DVec3::X, DVec3::Y];
    for scale in [1.0, 1e200, 1e-200, 1e154, 1e-160, 8e307, 5e-324, 1e-310] {
        let weights = [scale, 2.0 * scale];
        let empty = SpectrumAccumulator::new(Domain::Sphere, 2, 2);
        let sets = One(&points, &weights);
        let spectrum = accumulate(&sets, Resolution::new(2, 2), 0..1, &empty, &()).unwrap();
        let spectrum = spectrum.finish().unwrap();
        for (got, expected) in spectrum.power().iter().zip([1.8, 1.0, 0.6]) {
            // 1e-310 itself has 14 digits.
            assert!((got - expected).abs() < 1e-13, "{scale:e}: {got}, not {expected}");
        }
        assert_eq!(spectrum.tail(), ByParity::both(1.0), "{scale:e}");
    }
}
