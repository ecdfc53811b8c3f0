//! Predicted and measured variances on the unit square.

use sphvar_integrands::{IntegrandResolver, SquareIntegrand, SquareTerm};
use sphvar_samplers::SquarePattern;
use sphvar_tests::{ks_distance, ks_p_value, sidak_z};
use sphvar_variance::{PredictionBudget, SquarePredictor, Trials};
use statrs::distribution::{ContinuousCDF, Normal};

/// The probability that a family of comparisons fails by chance (nominal).
const ALPHA: f64 = 1e-4;
const PATTERNS: [&str; 8] = [
    "white-square",
    "jittered-square",
    "regular-square",
    "latin-hypercube",
    "fibonacci-lattice",
    "pmj02",
    "sobol",
    "halton",
];
/// A smooth function that is not periodic, and functions with edges.
const INTEGRANDS: [&str; 5] = [
    "exponential:a=1.5,b=-0.7",
    "gaussian:width=0.15",
    "zone-plate",
    "disk:radius=0.3",
    "half-plane:angle=30",
];
const COUNTS: [usize; 5] = [16, 64, 256, 1024, 4096];

struct NoFiles;

impl IntegrandResolver for NoFiles {}

fn integrand(text: &str) -> Box<dyn SquareIntegrand> {
    text.parse::<SquareTerm>().unwrap().build(&NoFiles).unwrap()
}

/// A comparison of a measured with a predicted variance.
struct Cell {
    name: String,
    predicted: f64,
    ratio: f64,
    z: f64,
}

/// Returns the comparisons of patterns and integrands at some numbers of points. Each has a seed of
/// its own, and therefore sets of its own.
fn cells(patterns: &[&str], integrands: &[&str], counts: &[usize], trials: u64) -> Vec<Cell> {
    let mut cells = Vec::new();
    for pattern in patterns.iter().map(|name| name.parse::<SquarePattern>().unwrap()) {
        for text in integrands {
            let function = integrand(text);
            for &n in counts {
                let seed = cells.len() as u64;
                let sampler = pattern.build(pattern.nearest_count(n)).unwrap();
                let budget = PredictionBudget::DEFAULT;
                let mut predictor = SquarePredictor::new(&*function, seed, budget).unwrap();
                let compared = predictor.compare(&*sampler, Trials::new(trials), &()).unwrap();
                cells.push(Cell {
                    name: format!("{pattern}, N = {}, {text}", sampler.n_points()),
                    predicted: compared.prediction.variance,
                    ratio: compared.ratio().0,
                    z: compared.z_score(),
                });
            }
        }
    }
    cells
}

/// Scores of 200 comparisons: a normal distribution by the test of Kolmogorov and Smirnov at 1e-3,
/// and the largest one with a family false-alarm rate of 1e-4.
#[test]
#[ignore = "statistics"]
#[expect(clippy::print_stdout, reason = "the figures of all comparisons")]
fn scores_are_standard_normal() {
    let cells = cells(&PATTERNS, &INTEGRANDS, &COUNTS, 1000);
    let normal = Normal::standard();
    for Cell { name, predicted, ratio, z } in &cells {
        println!("{name}: predicted {predicted:.4e}, measured/predicted {ratio:.4}, z {z:.2}");
    }
    let scores: Vec<f64> = cells.iter().map(|cell| cell.z).collect();
    assert_eq!(scores.len(), 200);
    let distance = ks_distance(&scores, |z| normal.cdf(z));
    let p = ks_p_value(scores.len(), distance);
    let square = scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64;
    println!("distance {distance:.4}, p {p:.3}, mean square {square:.3}");
    let limit = sidak_z(ALPHA, scores.len());
    for Cell { name, z, .. } in &cells {
        assert!(z.abs() < limit, "{name}: z {z}, limit {limit}");
    }
    assert!(p > 1e-3, "distance {distance}, p {p}");
}

/// The same comparisons with few points and trials, whose scores have longer tails than the normal
/// distribution: at 5.5 standard errors about 1 in 1000 sets of seeds fails.
#[test]
fn few_comparisons_agree() {
    let cells = cells(&PATTERNS[1..4], &INTEGRANDS[..2], &[16], 100);
    for Cell { name, z, .. } in cells {
        assert!(z.abs() < 5.5, "{name}: z {z}");
    }
}
