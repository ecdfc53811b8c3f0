//! The spherical ensemble against its closed forms.

use glam::DVec3;
use sphvar_samplers::{Domain, Pattern, PointSet, Purpose, Sampler, Streams};

fn ensemble(n: usize, domain: Domain) -> Box<dyn Sampler> {
    Pattern::Dpp.build(n, domain).expect("every number of points is valid")
}

fn sets(n: usize, domain: Domain, count: u64) -> Vec<Vec<DVec3>> {
    let (sampler, streams) = (ensemble(n, domain), Streams::new(8, Purpose::Pattern, n));
    let set = |i| sampler.sample(&mut streams.realization(i)).expect("a set").points;
    (0..count).map(set).collect()
}

/// Returns the largest difference of the empirical distribution of numbers from `cdf`, times the
/// root of their number (Kolmogorov). It exceeds 2.23 with probability `2 exp(-2 2.23^2)`, 1e-4.
fn kolmogorov(mut numbers: Vec<f64>, cdf: impl Fn(f64) -> f64) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let n = numbers.len() as f64;
    let off = |(k, &x): (usize, &f64)| {
        let (below, p) = (k as f64 / n, cdf(x));
        (p - below).abs().max((p - below - 1.0 / n).abs())
    };
    numbers.iter().enumerate().map(off).fold(0.0, f64::max) * n.sqrt()
}

const LIMIT: f64 = 2.23;

/// A single point is uniform, and so is one point of a larger set, without rotation: coordinates
/// along any axis are uniform. 12 comparisons, a false alarm in 1e-3.
#[test]
fn points_are_uniform_without_rotation() {
    let axes = [DVec3::X, DVec3::Z, DVec3::new(0.6, -0.64, 0.48)];
    for n in [1, 2, 3, 6] {
        let sets = sets(n, Domain::Sphere, 3000);
        for axis in axes {
            // One point of a set, since the points of a set depend on each other. The order in
            // which they are found is not random.
            let picked = sets.iter().enumerate().map(|(k, set)| set[k % n].dot(axis)).collect();
            let off = kolmogorov(picked, |t| 0.5 * (1.0 + t));
            assert!(off < LIMIT, "{n} {axis}: {off}");
        }
    }
}

/// The cosine of the angle of two points has the density `(1 - t)/2` for N = 2, and
/// `(N/(N - 1)) (1 - ((1 + t)/2)^{N-1})/2` in general. 4 comparisons, a false alarm in 4e-4.
#[test]
fn pairs_have_the_density_of_the_closed_form() {
    for n in [2, 3, 5, 8] {
        // One pair of each set.
        let pairs = sets(n, Domain::Sphere, 4000);
        let pick = |(k, set): (usize, &Vec<DVec3>)| {
            let first = k % n;
            let second = (first + 1 + k / n % (n - 1)) % n;
            set[first].dot(set[second])
        };
        let cosines = pairs.iter().enumerate().map(pick).collect();
        let m = n as f64;
        let cdf = |t: f64| {
            let u = 0.5 * (1.0 + t);
            (m * u - u.powf(m)) / (m - 1.0)
        };
        let off = kolmogorov(cosines, cdf);
        assert!(off < LIMIT, "{n}: {off}");
    }
}

/// The second moments of the points of sets are isotropic without rotation: `sum_k x_k x_k^T` has the
/// mean N/3 times the identity. The scores of 6 entries are below 4.2 with probability 1 - 2e-4.
#[test]
fn second_moments_are_isotropic_without_rotation() {
    const N: usize = 30;
    let sets = sets(N, Domain::Sphere, 400);
    let entries: [fn(DVec3) -> f64; 6] = [
        |p| p.x * p.x - 1.0 / 3.0,
        |p| p.y * p.y - 1.0 / 3.0,
        |p| p.z * p.z - 1.0 / 3.0,
        |p| p.x * p.y,
        |p| p.y * p.z,
        |p| p.z * p.x,
    ];
    for (k, entry) in entries.iter().enumerate() {
        let sums: Vec<f64> = sets.iter().map(|set| set.iter().map(|&p| entry(p)).sum()).collect();
        let mean = sums.iter().sum::<f64>() / sums.len() as f64;
        let squares: f64 = sums.iter().map(|s| (s - mean).powi(2)).sum();
        let score = mean / (squares.sqrt() / sums.len() as f64);
        assert!(score.abs() < 4.2, "entry {k}: {score}");
    }
}

#[test]
fn results_depend_on_the_generator_and_not_on_the_buffer() {
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        for n in [1, 2, 50] {
            let clean = sets(n, domain, 2);
            assert_ne!(clean[0], clean[1]);
            let mut dirty = PointSet { points: vec![DVec3::NAN; 99], weights: vec![2.0; 99] };
            let mut rng = Streams::new(8, Purpose::Pattern, n).realization(0);
            ensemble(n, domain).sample_into(&mut rng, &mut dirty).unwrap();
            assert_eq!(dirty, PointSet::new(clean[0].clone()));
            for p in &dirty.points {
                assert!((p.length() - 1.0).abs() <= 1e-15, "{domain} {n}: {p}");
                assert!(domain == Domain::Sphere || p.z >= 0.0, "{domain} {n}: {p}");
            }
        }
    }
}

/// On the hemisphere points are those of the sphere, or their antipodes.
#[test]
fn hemisphere_sets_are_folded() {
    let (sphere, hemisphere) = (sets(40, Domain::Sphere, 1), sets(40, Domain::Hemisphere, 1));
    let folded: Vec<DVec3> =
        sphere[0].iter().map(|&p| Domain::Hemisphere.representative(p)).collect();
    assert_eq!(folded, hemisphere[0]);
}
