//! Predicted and measured variances of patterns of the square that are mapped to directions.

use std::sync::LazyLock;

use sphvar_integrands::grammar::ResolveError;
use sphvar_integrands::{
    Domain, EnvironmentMap, EnvironmentParameters, Expression, Integrand, IntegrandResolver,
    PulledBack,
};
use sphvar_tests::{ks_distance, ks_p_value, sidak_z};
use sphvar_variance::{PredictionBudget, Trials, WarpedPattern, WarpedPredictor};
use statrs::distribution::{ContinuousCDF, Normal};

/// The probability that a family of comparisons fails by chance (nominal).
const ALPHA: f64 = 1e-4;
const WARPS: [&str; 5] = [
    "cosine",
    "cylinder",
    "vmf:kappa=2 @ 30/0",
    "env:city.exr,interpolation=constant,floor=0.2",
    "2 * cosine + 3 * env:city.exr",
];
const PATTERNS: [&str; 4] = ["white-square", "jittered-square", "fibonacci-lattice", "sobol"];
/// A light probe, a function with an edge, and a smooth one; 0 at the horizon, where the density of
/// the cosine is, so that no variance is infinite.
const INTEGRANDS: [&str; 3] =
    ["env:city.exr * cosine", "cap:degrees=40 @ 30/20", "vmf:kappa=5 @ 50/0 * cosine"];
const COUNTS: [usize; 2] = [64, 250];

/// The light probe of the repository, whatever the name of the file.
struct City;

impl IntegrandResolver for City {
    fn environment(&self, _: &EnvironmentParameters) -> Result<EnvironmentMap, ResolveError> {
        static MAP: LazyLock<EnvironmentMap> = LazyLock::new(|| {
            let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/city.exr");
            let picture = image::open(file).unwrap().into_rgb32f();
            let (width, height) = picture.dimensions();
            // Some dark texels have tiny negative values, which a density cannot have.
            let luminance = |[r, g, b]: [f32; 3]| {
                (0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)).abs()
            };
            let texels = picture.pixels().map(|pixel| luminance(pixel.0)).collect();
            EnvironmentMap::new(width as usize, height as usize, texels).unwrap()
        });
        Ok(MAP.clone())
    }
}

fn integrand(text: &str) -> Box<dyn Integrand> {
    text.parse::<Expression>().unwrap().build(&City).unwrap()
}

/// The prediction of one number of points and, after trials, their comparison with it.
struct Cell {
    name: String,
    predicted: f64,
    stderr: f64,
    ratio: f64,
    z: f64,
}

/// Returns the comparisons of the patterns of some names, each with a seed of its own.
fn cells(
    function: &dyn Integrand,
    domain: Domain,
    warp: &str,
    rows: &[(&str, usize)],
    (first_seed, trials): (u64, u64),
) -> Vec<Cell> {
    let pattern =
        |name: &str| -> WarpedPattern { format!("{name}:warp=\"{warp}\"").parse().unwrap() };
    let any = pattern("white-square");
    let strategies = any.warp.strategies(domain, &City).unwrap();
    let tolerance = PulledBack::TOLERANCE;
    let functions =
        PulledBack::of_strategies(function, domain, &strategies, any.heuristic, tolerance).unwrap();
    let integral = function.exact(domain);
    let cell = |(seed, &(name, n)): (u64, &(&str, usize))| {
        let pattern = pattern(name);
        let n = pattern.nearest_count(n);
        let predictor = WarpedPredictor::new(&functions, seed, PredictionBudget::DEFAULT).unwrap();
        let mut predictor = predictor.with_integral(integral);
        let compared = predictor.compare(&pattern, n, Trials::new(trials), &()).unwrap().comparison;
        assert!(compared.bias().is_none_or(|bias| bias.p_value > 1e-6), "{pattern}, {n}");
        Cell {
            name: format!("{pattern}, N = {n}"),
            predicted: compared.prediction.variance,
            stderr: compared.prediction.total_stderr(),
            ratio: compared.ratio().0,
            z: compared.z_score(),
        }
    };
    (first_seed..).zip(rows).map(cell).collect()
}

/// Scores of 120 comparisons: a normal distribution by the test of Kolmogorov and Smirnov at 1e-3,
/// and the largest one with a family false-alarm rate of 1e-4.
#[test]
#[ignore = "statistics"]
#[expect(clippy::print_stdout, reason = "the figures of all comparisons")]
fn scores_are_standard_normal() {
    let rows: Vec<(&str, usize)> =
        PATTERNS.iter().flat_map(|pattern| COUNTS.map(|n| (*pattern, n))).collect();
    let mut scores = Vec::new();
    for text in INTEGRANDS {
        let function = integrand(text);
        for warp in WARPS {
            let seed = 1000 + scores.len() as u64;
            for cell in cells(&*function, Domain::Hemisphere, warp, &rows, (seed, 500)) {
                let Cell { name, predicted, stderr, ratio, z } = cell;
                println!(
                    "{text}: {name}: predicted {predicted:.4e} +- {stderr:.1e}, \
                     measured/predicted {ratio:.4}, z {z:.2}"
                );
                scores.push((format!("{text}: {name}"), z));
            }
        }
    }
    assert_eq!(scores.len(), 120);
    let limit = sidak_z(ALPHA, scores.len());
    for (name, z) in &scores {
        assert!(z.abs() < limit, "{name}: z {z}, limit {limit}");
    }
    let scores: Vec<f64> = scores.into_iter().map(|score| score.1).collect();
    let distance = ks_distance(&scores, |z| Normal::standard().cdf(z));
    let p = ks_p_value(scores.len(), distance);
    let square = scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64;
    println!("distance {distance:.4}, p {p:.3}, mean square {square:.3}");
    assert!(p > 1e-3, "distance {distance}, p {p}");
}

/// Variances that another program measured: numpy, 3000 to 4000 shifts. Predictions agree with
/// them within 1 % and three standard errors, which is exceeded by one of seven rows for 1 in 50
/// sets of shifts if the 1 % are not counted. The errors of the last four were not recorded and are
/// taken as 3 %, and as 5 % where few values of f/p are large.
#[test]
#[ignore = "statistics"]
#[expect(clippy::print_stdout, reason = "the figures of all comparisons")]
fn variances_of_a_light_probe_are_those_of_another_program() {
    let (env, product) = ("env:city.exr", "env:city.exr * cosine");
    let constant = "env:city.exr,interpolation=constant";
    let (sphere, hemisphere) = (Domain::Sphere, Domain::Hemisphere);
    let rows: [(&str, Domain, &str, &str, usize, f64, f64); 7] = [
        (product, hemisphere, "cosine", "white-square", 256, 2.262e-2, 5e-4),
        (product, hemisphere, "cosine", "jittered-square", 256, 3.520e-3, 8e-5),
        (product, hemisphere, "cosine", "fibonacci-lattice", 233, 7.045e-4, 2e-5),
        (env, sphere, "cylinder", "white-square", 256, 3.418e-1, 1.0e-2),
        (env, sphere, "cylinder", "jittered-square", 256, 5.91e-2, 1.8e-3),
        (product, sphere, constant, "white-square", 256, 1.61e-2, 8e-4),
        (product, sphere, constant, "jittered-square", 256, 2.18e-3, 1.1e-4),
    ];
    for (text, domain, warp, pattern, n, measured, stderr) in rows {
        let function = integrand(text);
        let [cell] = &*cells(&*function, domain, warp, &[(pattern, n)], (0, 1000)) else {
            unreachable!("one row")
        };
        let Cell { name, predicted, stderr: own, ratio, z } = cell;
        println!(
            "{text}: {name}: predicted {predicted:.4e} +- {own:.1e}, other {measured:.4e}, \
             measured/predicted {ratio:.4}, z {z:.2}"
        );
        let error = 0.01 * measured + 3.0 * stderr.hypot(*own);
        assert!((predicted - measured).abs() < error, "{name}: {predicted}, {measured}");
        assert!(z.abs() < sidak_z(ALPHA, rows.len()), "{name}: z {z}");
    }
}
