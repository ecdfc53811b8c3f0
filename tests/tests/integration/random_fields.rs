//! Measured against predicted variances of random functions of a given bandwidth.

use sphvar_integrands::{BandParameters, Integrand, NoFiles, Term};
use sphvar_samplers::{Domain, Pattern};
use sphvar_tests::Family;
use sphvar_variance::{PredictionBudget, Predictor, Trials};

const SEED: u64 = 19;
/// The probability that a family of comparisons fails by chance (nominal).
const ALPHA: f64 = 1e-4;

fn band(lmax: usize, field: u64) -> Box<dyn Integrand> {
    let parameters = BandParameters { lmax, field, ..BandParameters::default() };
    Term::Band(parameters).build(&NoFiles).unwrap()
}

/// Compares fields 1 to `fields`, each with its own realizations, at one number of points.
fn check_fields(patterns: &[(&str, usize)], lmax: usize, fields: u64, trials: u64) {
    let mut family = Family::new("random fields");
    for &(name, n) in patterns {
        let pattern: Pattern = name.parse().unwrap();
        let sampler = pattern.build(n, Domain::Sphere).unwrap();
        for field in 1..=fields {
            let f = band(lmax, field);
            let budget = PredictionBudget::DEFAULT;
            let mut predictor = Predictor::new(&*f, Domain::Sphere, SEED + field, budget).unwrap();
            let got = predictor.compare(&*sampler, Trials::new(trials), &()).unwrap();
            let prediction = got.prediction;
            let measured = got.measurement.variance();
            let stderr = got.measurement.variance_stderr().hypot(prediction.stderr);
            let what = || format!("{name} {n}, field {field}");
            family.compare(measured, prediction.variance, stderr, what);
        }
    }
    family.assert_null(ALPHA);
}

/// All fields of a bandwidth have the same energies, so the prediction is the same for each. False
/// alarm 1e-4 by the Sidak bound over all comparisons.
#[test]
fn fields_have_the_variance_of_their_energies() {
    check_fields(&[("fibonacci", 100), ("jittered", 48), ("white-noise", 10)], 8, 4, 300);
}

#[test]
#[ignore = "statistics"]
fn fields_of_bandwidth_40_have_the_variance_of_their_energies() {
    let patterns = [
        ("fibonacci", 600),
        ("spiral", 600),
        ("jittered", 768),
        ("poisson-disk", 500),
        ("white-noise", 100),
        ("healpix", 588),
    ];
    check_fields(&patterns, 40, 20, 1000);
}
