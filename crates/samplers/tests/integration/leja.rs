//! The Leja sequence: its first points, prefixes, maxima and discrepancies.

use glam::DVec3;
use sphvar_samplers::{Domain, Fibonacci, Leja, Purpose, Sampler, Streams};

fn points(sampler: &dyn Sampler) -> Vec<DVec3> {
    sampler.sample(&mut Streams::new(0, Purpose::Pattern, 0).realization(0)).unwrap().points
}

fn leja(n: usize, domain: Domain, is_symmetric: bool) -> Vec<DVec3> {
    points(&Leja::new(n, domain, is_symmetric).unwrap())
}

#[test]
fn the_first_six_points_are_the_octahedron() {
    for is_symmetric in [false, true] {
        let six = leja(6, Domain::Sphere, is_symmetric);
        assert_eq!(six[0], DVec3::Z);
        for (i, p) in six.iter().enumerate() {
            for q in &six[..i] {
                let cosine = p.dot(*q);
                let is_vertex = cosine.abs() < 1e-9 || (cosine + 1.0).abs() < 1e-15;
                assert!(is_vertex, "{i} {is_symmetric}: {cosine}");
            }
        }
        for pair in six.chunks(2) {
            assert!((pair[0] + pair[1]).length() < 1e-9, "{is_symmetric}: {pair:?}");
        }
    }
}

/// Also across the numbers of points where the lattice of candidates is replaced.
#[test]
fn sets_begin_with_smaller_sets() {
    for (domain, is_symmetric) in
        [(Domain::Sphere, false), (Domain::Sphere, true), (Domain::Hemisphere, false)]
    {
        let all = leja(300, domain, is_symmetric);
        for n in [1, 2, 3, 63, 64, 65, 127, 128, 129, 130, 255, 256, 257, 258] {
            assert_eq!(leja(n, domain, is_symmetric), all[..n], "{domain} {is_symmetric} {n}");
        }
    }
}

#[test]
fn symmetric_sets_consist_of_pairs() {
    let pairs = leja(301, Domain::Sphere, true);
    let half = leja(151, Domain::Hemisphere, false);
    for (i, pair) in pairs.chunks(2).enumerate() {
        assert!(pair.len() == 1 || pair[1] == -pair[0], "{i}");
        assert_eq!(Domain::Hemisphere.representative(pair[0]), half[i], "{i}");
    }
    assert_eq!(leja(151, Domain::Hemisphere, true), half);
}

/// Returns the logarithm of the product of the distances of `x` from `points`.
fn log_product(points: &[DVec3], x: DVec3) -> f64 {
    points.iter().map(|p| p.distance(x).ln()).sum()
}

/// No point of a fine lattice has a much larger product than the next point of the sequence, and
/// the gradient vanishes there.
#[test]
fn points_maximize_the_product_of_distances() {
    let lattice = points(&Fibonacci::new(20_000, Domain::Sphere).unwrap());
    for is_symmetric in [false, true] {
        let all = leja(300, Domain::Sphere, is_symmetric);
        for (n, tolerance) in [
            (2, 1e-9),
            (4, 1e-9),
            (6, 1e-9),
            (10, 1e-9),
            (62, 0.02),
            (126, 0.02),
            (200, 0.02),
            (254, 0.1),
        ] {
            let (previous, next) = (&all[..n], all[n]);
            let here = log_product(previous, next);
            let best = lattice.iter().map(|&x| log_product(previous, x)).fold(f64::MIN, f64::max);
            assert!(best - here <= tolerance, "{is_symmetric} {n}: {best} above {here}");
            let gradient: DVec3 =
                previous.iter().map(|p| (next - *p) / next.distance_squared(*p)).sum();
            let slope = (gradient - gradient.dot(next) * next).length();
            assert!(slope < 1e-11 * n as f64, "{is_symmetric} {n}: {slope}");
        }
    }
}

/// The L2 cap discrepancy, the mean squared error of caps of all sizes, follows from the sum of
/// distances (Stolarsky 1973): `4 D^2 = 4/3 - mean |x_j - x_k|`.
#[test]
fn all_prefixes_have_nearly_the_discrepancy_of_the_fibonacci_lattice() {
    const N: usize = 400;
    let distances = |points: &[DVec3], x: DVec3| points.iter().map(|p| p.distance(x)).sum::<f64>();
    let squared = |sum: f64, n: usize| 4.0 / 3.0 - 2.0 * sum / (n * n) as f64;
    for is_symmetric in [false, true] {
        let all = leja(N, Domain::Sphere, is_symmetric);
        let (mut sum, mut worst) = (0.0, 0.0_f64);
        for n in 1..=N {
            sum += distances(&all[..n - 1], all[n - 1]);
            if n < 8 {
                continue;
            }
            let lattice = points(&Fibonacci::new(n, Domain::Sphere).unwrap());
            let of_lattice = (0..n).map(|i| distances(&lattice[..i], lattice[i])).sum();
            worst = worst.max((squared(sum, n) / squared(of_lattice, n)).sqrt());
        }
        assert!(worst < 1.25, "{is_symmetric}: {worst}");
    }
}

#[test]
fn invalid_numbers_are_rejected() {
    for n in [0, 1 << 32, usize::MAX] {
        assert!(Leja::new(n, Domain::Sphere, false).is_err());
    }
}
