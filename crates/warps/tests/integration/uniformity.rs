use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sphvar_warps::{Measure, Oriented, Support, UniformCap, Warp, WarpSample};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::subjects::{Subject, all, enclosing_cap, points};

/// Samples of each map.
const SAMPLES: usize = 20_000;

/// Cells in z and in longitude, of equal solid angle.
const ROWS: usize = 16;
const COLUMNS: usize = 10;

/// Points of low discrepancy for the expected counts.
const POINTS: usize = 100_000;

/// Cells with a smaller expected count are joined.
const MIN_COUNT: f64 = 10.0;

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most n")]
fn cell_of([u, v]: [f64; 2]) -> usize {
    (u * ROWS as f64) as usize * COLUMNS + (v * COLUMNS as f64) as usize
}

/// Returns the integral of the density over each cell by quadrature.
fn integrals(warp: &dyn Warp, cap: &Oriented<UniformCap>) -> Vec<f64> {
    let mut masses = vec![0.0; ROWS * COLUMNS];
    for point in points(POINTS) {
        let sample = cap.sample(point);
        masses[cell_of(point)] += warp.density(sample.point) / (sample.density * POINTS as f64);
    }
    masses
}

/// Samples of a map, compared with its density.
#[derive(Debug)]
struct Comparison {
    chi_square: f64,
    degrees_of_freedom: f64,
    /// The integral of the density over the samples' cap.
    integral: f64,
}

impl Comparison {
    /// Returns whether chi-square exceeds a limit that it exceeds with this probability by chance.
    fn is_rejected(&self, level: f64) -> bool {
        let distribution = ChiSquared::new(self.degrees_of_freedom).unwrap();
        self.chi_square > distribution.inverse_cdf(1.0 - level)
    }
}

/// Compares the counts of samples in cells with their expected values, in proportion to the density.
fn compare(warp: &dyn Warp) -> Comparison {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let samples: Vec<_> = (0..SAMPLES).map(|_| warp.map([rng.random(), rng.random()])).collect();
    let cap = enclosing_cap(&samples);
    let mut counts = vec![0.0; ROWS * COLUMNS];
    for dir in samples {
        counts[cell_of(cap.inverse(dir).expect("in the cap"))] += 1.0;
    }
    let (mut chi, mut cells) = (0.0, 0.0);
    let (mut expected, mut got) = (0.0, 0.0);
    let integrals = integrals(warp, &cap);
    let integral: f64 = integrals.iter().sum();
    for (part, count) in integrals.iter().zip(counts) {
        expected += part / integral * SAMPLES as f64;
        got += count;
        if expected >= MIN_COUNT {
            chi += (got - expected) * (got - expected) / expected;
            cells += 1.0;
            (expected, got) = (0.0, 0.0);
        }
    }
    chi += (got - expected) * (got - expected) / expected.max(1.0);
    let degrees_of_freedom = (cells - 1.0f64).max(1.0);
    Comparison { chi_square: chi, degrees_of_freedom, integral }
}

/// A correct program fails with probability 1e-6 in total (Bonferroni), up to the error of the
/// expected counts. The error of the integral is that of the quadrature.
#[test]
fn samples_have_the_density_and_its_integral_is_1() {
    let subjects: Vec<Subject> =
        all().into_iter().filter(|(_, warp)| warp.measure() == Measure::SolidAngle).collect();
    let level = 1e-6 / subjects.len() as f64;
    for (name, warp) in subjects {
        let comparison = compare(warp.as_ref());
        assert!(!comparison.is_rejected(level), "{name}: {comparison:?}");
        assert!((comparison.integral - 1.0).abs() < 5e-3, "{name}: {comparison:?}");
    }
}

/// The test finds a density that is 20 % too large on a hemisphere.
#[test]
fn a_wrong_density_is_found() {
    #[derive(Debug)]
    struct Tilted;
    impl Warp for Tilted {
        fn sample(&self, point: [f64; 2]) -> WarpSample {
            UniformCap::SPHERE.sample(point)
        }
        fn density(&self, dir: DVec3) -> f64 {
            if dir.z > 0.0 { 1.4 } else { 1.0 }
        }
        fn inverse(&self, dir: DVec3) -> Option<[f64; 2]> {
            UniformCap::SPHERE.inverse(dir)
        }
        fn support(&self) -> Support {
            Support::Sphere
        }
        fn min_density(&self) -> f64 {
            1.0
        }
    }
    let comparison = compare(&Tilted);
    assert!(comparison.is_rejected(1e-8), "{comparison:?}");
}
