use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sphvar_warps::{Measure, Oriented, Support, UniformCap, Warp, WarpSample};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::subjects::{Subject, all, enclosing_cap, points};

/// Samples of each map.
const SAMPLES: usize = 20_000;

/// Cells in z and in longitude, of equal solid angle.
const ROWS: usize = 24;
const COLUMNS: usize = 12;

/// Points of low discrepancy for the expected counts.
const POINTS: usize = 200_000;

/// Cells with a smaller expected count are joined.
const MIN_COUNT: f64 = 10.0;

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most n")]
fn cell_of([u, v]: [f64; 2]) -> usize {
    (u * ROWS as f64) as usize * COLUMNS + (v * COLUMNS as f64) as usize
}

/// Returns the probability of each cell by quadrature of the density.
fn probabilities(warp: &dyn Warp, cap: &Oriented<UniformCap>) -> Vec<f64> {
    let mut masses = vec![0.0; ROWS * COLUMNS];
    for point in points(POINTS) {
        masses[cell_of(point)] += warp.density(cap.map(point));
    }
    let total: f64 = masses.iter().sum();
    masses.iter_mut().for_each(|mass| *mass /= total);
    masses
}

/// Returns chi-square and degrees of freedom of samples in cells.
fn chi_square(warp: &dyn Warp) -> (f64, f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let samples: Vec<_> = (0..SAMPLES).map(|_| warp.map([rng.random(), rng.random()])).collect();
    let cap = enclosing_cap(&samples);
    let mut counts = vec![0.0; ROWS * COLUMNS];
    for dir in samples {
        counts[cell_of(cap.inverse(dir).expect("in the cap"))] += 1.0;
    }
    let (mut chi, mut cells) = (0.0, 0.0);
    let (mut expected, mut got) = (0.0, 0.0);
    for (probability, count) in probabilities(warp, &cap).iter().zip(counts) {
        expected += probability * SAMPLES as f64;
        got += count;
        if expected >= MIN_COUNT {
            chi += (got - expected) * (got - expected) / expected;
            cells += 1.0;
            (expected, got) = (0.0, 0.0);
        }
    }
    chi += (got - expected) * (got - expected) / expected.max(1.0);
    (chi, (cells - 1.0f64).max(1.0))
}

/// A correct program fails with probability 1e-6 in total (Bonferroni), up to the error of the
/// expected counts.
#[test]
fn samples_have_the_density() {
    let subjects: Vec<Subject> =
        all().into_iter().filter(|(_, warp)| warp.measure() == Measure::SolidAngle).collect();
    let level = 1e-6 / subjects.len() as f64;
    for (name, warp) in subjects {
        let (chi, degrees) = chi_square(warp.as_ref());
        let limit = ChiSquared::new(degrees).unwrap().inverse_cdf(1.0 - level);
        assert!(
            chi < limit,
            "{name}: chi-square {chi} with {degrees} degrees of freedom, not {limit}"
        );
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
    let (chi, degrees) = chi_square(&Tilted);
    let limit = ChiSquared::new(degrees).unwrap().inverse_cdf(1.0 - 1e-8);
    assert!(chi > limit, "chi-square {chi} with {degrees} degrees of freedom, limit {limit}");
}
