//! Identities that hold for every point set and every function, against the transforms.

use std::f64::consts::PI;

use glam::DVec3;
use num_complex::Complex;
use rand::RngExt;
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams, rotate, uniform_rotation};
use sphvar_sh::{Alm, GaussLegendre, legendre_p_into, ylm_at};
use sphvar_sht::ExactTransform;
use sphvar_tests::{exact_jitter_spectrum, strata};

const SEED: u64 = 1;

/// Returns one realization of every pattern near `requested` points, and a set with the poles and
/// repetitions.
fn point_sets(requested: usize) -> Vec<(String, Vec<DVec3>)> {
    let mut sets: Vec<_> = Pattern::ELEMENTARY
        .into_iter()
        .map(|pattern| {
            let n = pattern.nearest_count(requested, Domain::Sphere);
            let sampler = pattern.build(n, Domain::Sphere).unwrap();
            let streams = Streams::new(SEED, Purpose::Pattern, n);
            (
                format!("{pattern}, N = {n}"),
                Realizations::rotated(&*sampler, streams).realize(0).unwrap().points,
            )
        })
        .collect();
    let hostile = vec![DVec3::Z, DVec3::Z, -DVec3::Z, DVec3::X, DVec3::NEG_Y, DVec3::Y];
    sets.push(("poles and equator".into(), hostile));
    sets
}

fn power(points: &[DVec3], lmax: usize) -> Vec<f64> {
    let alm = ExactTransform::new(lmax).unwrap().adjoint(points, None).unwrap();
    let factor = 4.0 * PI / points.len() as f64;
    alm.power_per_degree().into_iter().map(|p| factor * p).collect()
}

fn some_coefficients(lmax: usize) -> Alm {
    let mut rng = Streams::new(SEED, Purpose::Pattern, 0).realization(7);
    let mut alm = Alm::zeros(lmax).unwrap();
    for (l, m) in alm.index().iter() {
        let im = if m == 0 { 0.0 } else { rng.random_range(-1.0..1.0) };
        alm[(l, m)] = Complex::new(rng.random_range(-1.0..1.0), im);
    }
    alm
}

/// Evaluates the function of these coefficients by its definition, one harmonic at a time.
fn value(alm: &Alm, dir: DVec3) -> f64 {
    let term = |(l, m): (usize, usize)| {
        let real = (alm[(l, m)] * ylm_at(l, i64::try_from(m).unwrap(), dir).unwrap()).re;
        if m == 0 { real } else { 2.0 * real }
    };
    alm.index().iter().map(term).sum()
}

/// `P_S(l) = 1 + (1/N) sum_{k != j} P_l(s_k . s_j)`: pairs on one side, the transform on the other.
#[test]
fn the_power_is_the_sum_over_pairs() {
    const LMAX: usize = 24;
    for (name, points) in point_sets(50) {
        let n = points.len() as f64;
        let mut pairs = [0.0; LMAX + 1];
        let mut legendre = [0.0; LMAX + 1];
        for (k, a) in points.iter().enumerate() {
            for b in points.iter().skip(k + 1) {
                legendre_p_into(a.dot(*b).clamp(-1.0, 1.0), &mut legendre).unwrap();
                for (sum, p) in pairs.iter_mut().zip(legendre) {
                    *sum += 2.0 * p;
                }
            }
        }
        for (l, (p, sum)) in power(&points, LMAX).iter().zip(pairs).enumerate() {
            let expected = 1.0 + sum / n;
            // The slope of P_l amplifies the rounding of N^2/2 dot products: l^2/2 * EPSILON * N.
            assert!((p - expected).abs() < 1e-12, "{name}, l = {l}: {p}, pairs {expected}");
        }
    }
}

/// `P(0) = N` for every set: the coefficient of degree 0 is not random.
#[test]
fn degree_0_is_the_number_of_points() {
    for (name, points) in point_sets(300) {
        let n = points.len() as f64;
        let got = power(&points, 3)[0];
        // N equal terms, squared: 2 EPSILON for each doubling of the partial sums.
        assert!((got / n - 1.0).abs() < 1e-13, "{name}: P(0) = {got}, N = {n}");
    }
}

/// A single point has the flat spectrum 1/(4 pi) before normalization and 1 after.
#[test]
fn a_single_point_has_a_flat_spectrum() {
    const LMAX: usize = 60;
    for (_, points) in point_sets(12) {
        let alm = ExactTransform::new(LMAX).unwrap().adjoint(&points[..1], None).unwrap();
        for (l, p) in alm.power_per_degree().into_iter().enumerate() {
            // Each value is good to 4 EPSILON (l+1), its square to twice that.
            let tolerance = 8.0 * f64::EPSILON * (l + 1) as f64;
            assert!((4.0 * PI * p - 1.0).abs() < tolerance, "{}, l = {l}: {p}", points[0]);
        }
    }
}

#[test]
fn rotations_keep_the_power_of_every_degree() {
    const LMAX: usize = 40;
    const ROTATIONS: u64 = 5;
    let streams = Streams::new(SEED, Purpose::Trial, 0);
    for (name, points) in point_sets(100) {
        let before = power(&points, LMAX);
        for i in 0..ROTATIONS {
            let mut rotated_points = points.clone();
            rotate(
                uniform_rotation(&mut streams.realization(i)),
                Domain::Sphere,
                &mut rotated_points,
            );
            for (l, (a, b)) in before.iter().zip(power(&rotated_points, LMAX)).enumerate() {
                // Points move by some EPSILON, S_lm by l times that for each of N points, and
                // |S_lm|^2 = P N/(4 pi): 2 sqrt(P N) l EPSILON, with a margin for the transform.
                let tolerance = 1e-13 * (1.0 + l as f64) * (1.0 + (a * points.len() as f64).sqrt());
                assert!((a - b).abs() < tolerance, "{name}, rotation {i}, l = {l}: {a} and {b}");
            }
        }
    }
}

/// Parseval: the coefficients of a band-limited function are recovered from its values by an exact
/// quadrature, and their energies sum to the integral of its square.
#[test]
fn a_band_limited_function_comes_back_with_its_energy() {
    const LMAX: usize = 12;
    const LONGITUDES: u32 = 25; // 2 LMAX + 1: exact in phi
    let alm = some_coefficients(LMAX);
    let rule = GaussLegendre::new(LMAX + 1).unwrap();
    let (mut points, mut weights, mut square) = (Vec::new(), Vec::new(), 0.0);
    for (z, w) in rule.nodes().iter().zip(rule.weights()) {
        let sin = ((1.0 - z) * (1.0 + z)).sqrt();
        for j in 0..LONGITUDES {
            let step = 2.0 * PI / f64::from(LONGITUDES);
            let (s, c) = (step * f64::from(j)).sin_cos();
            let dir = DVec3::new(sin * c, sin * s, *z).normalize();
            let f = value(&alm, dir);
            points.push(dir);
            weights.push(w * step * f);
            square += w * step * f * f;
        }
    }
    let back = ExactTransform::new(LMAX).unwrap().adjoint(&points, Some(&weights)).unwrap();
    for (l, m) in alm.index().iter() {
        let (got, expected) = (back[(l, m)], alm[(l, m)]);
        // 325 terms of order one, each good to 4 EPSILON (l+1).
        assert!((got - expected).norm() < 1e-12, "l = {l}, m = {m}: {got}, expected {expected}");
    }
    let energy: f64 = alm.energy_per_degree().iter().sum();
    assert!((square / energy - 1.0).abs() < 1e-12, "int F^2 = {square}, energy {energy}");
}

/// `sum_k w_k F(s_k) = sum_lm conj(S_lm) F_lm`: the adjoint against direct evaluation.
#[test]
fn the_transform_is_the_adjoint_of_evaluation() {
    const LMAX: usize = 20;
    let coefficients = some_coefficients(LMAX);
    let mut rng = Streams::new(SEED, Purpose::Resample, 0).realization(0);
    for (name, points) in point_sets(60) {
        let weights: Vec<f64> = points.iter().map(|_| rng.random_range(-1.0..1.0)).collect();
        let direct: f64 =
            points.iter().zip(&weights).map(|(&p, w)| w * value(&coefficients, p)).sum();
        let alm = ExactTransform::new(LMAX).unwrap().adjoint(&points, Some(&weights)).unwrap();
        let product = |(l, m): (usize, usize)| {
            let real = (alm[(l, m)].conj() * coefficients[(l, m)]).re;
            if m == 0 { real } else { 2.0 * real }
        };
        let spectral: f64 = alm.index().iter().map(product).sum();
        // 60 points times 441 harmonics of order one.
        assert!((direct - spectral).abs() < 1e-11, "{name}: {direct} and {spectral}");
    }
}

/// The heat kernel's sum rule: `sum_{l >= 1} (2l+1) (1 - P(l)) e^{-l(l+1) t} -> N - 1` for t well
/// below the squared distance of neighbours; with white noise it would be 0.
#[test]
fn separated_points_obey_the_sum_rule() {
    const LMAX: usize = 320;
    for pattern in [Pattern::FIBONACCI, Pattern::Healpix] {
        let n = pattern.nearest_count(192, Domain::Sphere);
        let sampler = pattern.build(n, Domain::Sphere).unwrap();
        let rng = &mut Streams::new(SEED, Purpose::Pattern, n).realization(0);
        let points = sampler.sample(rng).unwrap().points;
        let nearest = points
            .iter()
            .enumerate()
            .flat_map(|(k, a)| points[..k].iter().map(move |b| a.distance(*b)))
            .fold(f64::INFINITY, f64::min);
        let t = nearest * nearest / 120.0;
        let sum: f64 = power(&points, LMAX)
            .iter()
            .enumerate()
            .skip(1)
            .map(|(l, p)| {
                let l = l as f64;
                (2.0 * l + 1.0) * (1.0 - p) * (-l * (l + 1.0) * t).exp()
            })
            .sum();
        // A neighbour weighs 4 pi e^{-d^2/(4 t)}/(4 pi t) = e^-30/t, six of them N-fold; degrees
        // beyond 320 weigh e^{-320^2 t}, t about 2.5e-4.
        let expected = n as f64 - 1.0;
        assert!((sum / expected - 1.0).abs() < 1e-8, "{pattern}: {sum}, expected {expected}");
    }
}

/// One point in each equal-area stratum: `0 <= <P> <= 1`, and `<P> <= l(l+1)/4` times the mean
/// squared chord of two points of a stratum.
#[test]
fn stratified_power_stays_within_its_bounds() {
    const LMAX: usize = 80;
    for nside in [1_u32, 2, 5] {
        // E |x - y|^2 = 2 - 2 |E x|^2 for unit vectors.
        let n_points = 12.0 * f64::from(nside * nside);
        let chord: f64 = strata(nside, 16)
            .iter()
            .map(|cell| {
                let mean: DVec3 = cell.points.iter().zip(&cell.weights).map(|(p, w)| *p * *w).sum();
                cell.multiplicity * (2.0 - 2.0 * mean.length_squared()) / n_points
            })
            .sum();
        let spectrum = exact_jitter_spectrum(nside, LMAX);
        // Degree 1 is the bound itself: P_1(x.y) = 1 - |x - y|^2/2.
        assert!((spectrum[1] / (0.5 * chord) - 1.0).abs() < 1e-10, "nside {nside}: {chord}");
        for (l, p) in spectrum.into_iter().enumerate().skip(1) {
            let bound = 0.25 * (l * (l + 1)) as f64 * chord;
            assert!((0.0..=1.0).contains(&p), "nside {nside}, l = {l}: {p}");
            assert!(p <= bound * (1.0 + 1e-12), "nside {nside}, l = {l}: {p} above {bound}");
        }
    }
}
