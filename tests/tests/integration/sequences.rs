//! Prefixes of nested sequences of the sphere against the best sets of each number of points.

use std::f64::consts::{PI, TAU};
use std::iter::successors;

use glam::DVec3;
use sphvar_integrands::{Cap, Integrand, VonMisesFisher};
use sphvar_samplers::{Domain, Pattern, Purpose, Streams};
use sphvar_variance::{PredictionBudget, Predictor};

/// Returns the predicted standard deviations of `pattern` at each number of points.
fn errors(integrand: &dyn Integrand, pattern: &str, counts: &[usize]) -> Vec<f64> {
    let pattern: Pattern = pattern.parse().unwrap();
    let budget = PredictionBudget::DEFAULT;
    let mut predictor = Predictor::new(integrand, Domain::Sphere, 3, budget).unwrap();
    let error = |&n: &usize| {
        let sampler = pattern.build(n, Domain::Sphere).unwrap();
        predictor.predict(&*sampler, &()).unwrap().prediction.variance.sqrt()
    };
    counts.iter().map(error).collect()
}

#[test]
fn prefixes_of_leja_sequences_have_nearly_the_error_of_fibonacci_for_caps() {
    // The worst prefixes to 4096 are at 31 and 260.
    let counts = [8, 15, 31, 32, 64, 129, 260, 400];
    for (degrees, largest) in [(20.0, 1.30), (60.0, 1.30), (90.0, 1.20)] {
        let cap = Cap::from_degrees(degrees).unwrap();
        let lattices = errors(&cap, "fibonacci", &counts);
        for pattern in ["leja", "leja:symmetric=yes"] {
            let prefixes = errors(&cap, pattern, &counts);
            for ((n, prefix), lattice) in counts.iter().zip(prefixes).zip(&lattices) {
                let factor = prefix / lattice;
                assert!(factor < largest, "{pattern} {n}, {degrees} degrees: {factor}");
            }
        }
    }
}

/// `N sqrt(V_N) + (N+1) sqrt(V_(N+1)) >= sqrt(V_1)` for every sequence and integrand: no sequence
/// is as good as lattices for smooth integrands.
#[test]
fn successive_prefixes_cannot_both_be_accurate() {
    let counts: Vec<usize> = (1..=60).collect();
    let lobe = VonMisesFisher::new(10.0).unwrap();
    let mut smallest = f64::INFINITY;
    for pattern in ["leja", "leja:symmetric=yes"] {
        let errors = errors(&lobe, pattern, &counts);
        let sums: Vec<f64> = errors.iter().zip(&counts).map(|(e, &n)| e * n as f64).collect();
        for pair in sums.windows(2) {
            smallest = smallest.min((pair[0] + pair[1]) / sums[0]);
        }
    }
    // Here 2.26; the bound itself is attained by odd functions and pairs of antipodes.
    assert!((1.0..2.5).contains(&smallest), "{smallest}");
    // Lattices break it, so they are no sequences.
    let lattices = errors(&lobe, "fibonacci", &[1, 255, 256]);
    assert!(255.0 * lattices[1] + 256.0 * lattices[2] < 0.5 * lattices[0]);
}

/// Returns the area that two caps of `radius <= pi/2` at an angle with this cosine share, minus the
/// mean over all angles.
fn excess_overlap(radius: f64, cosine: f64) -> f64 {
    let (sin, cos) = radius.sin_cos();
    let area = TAU * (1.0 - cos);
    let half_tangent = ((1.0 - cosine) / (1.0 + cosine).max(f64::MIN_POSITIVE)).sqrt();
    let overlap = if half_tangent >= radius.tan() {
        0.0
    } else {
        let corner = ((cosine - cos * cos) / (sin * sin)).clamp(-1.0, 1.0).acos();
        2.0 * (PI - corner) - 4.0 * cos * (cos / sin * half_tangent).min(1.0).acos()
    };
    overlap - area * area / (2.0 * TAU)
}

/// Returns `N^2 V_N` of every prefix for caps, up to a factor, from all pairs of points.
fn cap_sums(points: &[DVec3], radius: f64) -> Vec<f64> {
    let mut sum = 0.0;
    let prefix = |n: usize| {
        let pairs = points[..n].iter().map(|p| excess_overlap(radius, p.dot(points[n])));
        sum += 2.0 * pairs.sum::<f64>() + excess_overlap(radius, 1.0);
        sum
    };
    (0..points.len()).map(prefix).collect()
}

#[test]
#[ignore = "slow"]
fn all_prefixes_of_leja_sequences_to_4096_have_nearly_the_error_of_fibonacci() {
    let set = |pattern: &str, n: usize| {
        let sampler = pattern.parse::<Pattern>().unwrap().build(n, Domain::Sphere).unwrap();
        sampler.sample(&mut Streams::new(0, Purpose::Pattern, 0).realization(0)).unwrap().points
    };
    let sequences = ["leja", "leja:symmetric=yes"].map(|pattern| (pattern, set(pattern, 4096)));
    let counts = successors(Some(8), |n| Some(n + 1 + n / 25)).take_while(|n| *n <= 4096);
    for degrees in [20.0_f64, 60.0, 90.0] {
        let radius = degrees.to_radians();
        let sums = sequences.each_ref().map(|(_, points)| cap_sums(points, radius));
        for n in counts.clone() {
            let lattice = cap_sums(&set("fibonacci", n), radius)[n - 1];
            for ((pattern, _), sums) in sequences.iter().zip(&sums) {
                let factor = (sums[n - 1] / lattice).max(0.0).sqrt();
                assert!(factor < 1.35, "{pattern} {n}, {degrees} degrees: {factor}");
            }
        }
    }
}
