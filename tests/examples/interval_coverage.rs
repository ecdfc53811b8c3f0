//! Measures how often the 95 % intervals of measured variances contain the true variance, and how
//! often there is no interval.
//!
//! `cargo run --release -p sphvar-tests --example interval_coverage -- SEEDS`: the first table
//! has integrands that few trials hit, the second has twenty ordinary ones. "seen" counts the seeds
//! for which 50 trials or more differ from the others by a tenth of the largest difference.

use std::error::Error;
use std::io::Write;

use sphvar_integrands::{
    AbsCosine, Cap, ClampedCosine, DoubleCap, Harmonic, Integrand, PhongLobe, VonMisesFisher,
};
use sphvar_samplers::{Domain, Pattern, Sampler};
use sphvar_spectrum::ExactSpectrum;
use sphvar_variance::{
    Comparison, PredictedPoint, PredictionBudget, Predictor, Trials, predict, prediction_degree,
};

struct Tally {
    present: u64,
    missed: u64,
    outside: u64,
    seen: u64,
    seen_present: u64,
}

/// Returns the number of trials that hit the integrand.
fn seeing(comparison: &Comparison) -> usize {
    let mean = comparison.measurement.mean();
    let off = |x: &f64| (x - mean).abs();
    let estimates = comparison.measurement.estimates();
    let largest = estimates.iter().map(off).fold(0.0, f64::max);
    estimates.iter().filter(|x| off(x) > 0.1 * largest).count()
}

/// Returns the true variance from a spectrum computed without sampling.
fn truth(
    sampler: &dyn Sampler,
    integrand: &dyn Integrand,
) -> Result<PredictedPoint, Box<dyn Error>> {
    let lmax = prediction_degree(sampler, integrand).min(20_000);
    let energy = integrand.energy(Domain::Sphere, lmax)?;
    let exact = ExactSpectrum::of(sampler).ok_or("no spectrum without trials")?;
    let spectrum = exact.to(lmax, &())?;
    let prediction = predict(&spectrum, &energy);
    // The spectrum itself is not printed.
    Ok(PredictedPoint { spectrum: exact.to(4, &())?, prediction })
}

fn tally(
    pattern: &Pattern,
    n: usize,
    integrand: &dyn Integrand,
    trials: u64,
    seeds: u64,
) -> Result<(Tally, f64), Box<dyn Error>> {
    let sampler = pattern.build(n, Domain::Sphere)?;
    let truth = truth(&*sampler, integrand)?.prediction;
    let mut tally = Tally { present: 0, missed: 0, outside: 0, seen: 0, seen_present: 0 };
    for seed in 0..seeds {
        let predictor = Predictor::new(integrand, Domain::Sphere, seed, PredictionBudget::DEFAULT)?;
        let got = predictor.measure(truth, &*sampler, Trials::new(trials), &())?;
        let interval = got.measured_interval(0.95);
        let seen = seeing(&got) >= 50;
        tally.seen += u64::from(seen);
        if let Some((low, high)) = interval {
            tally.present += 1;
            tally.seen_present += u64::from(seen);
            tally.missed += u64::from(!(low <= truth.variance && truth.variance <= high));
            let measured = got.measurement.variance();
            tally.outside += u64::from(!(low <= measured && measured <= high));
        }
    }
    Ok((tally, truth.variance))
}

fn main() -> Result<(), Box<dyn Error>> {
    let seeds: u64 = std::env::args().nth(1).map_or(Ok(200), |s| s.parse())?;
    let patterns = ["fibonacci", "white-noise", "jittered"];
    let patterns: Vec<Pattern> = patterns.iter().filter_map(|p| p.parse().ok()).collect();
    let mut out = std::io::stdout().lock();
    let row = |out: &mut dyn Write,
               pattern: &Pattern,
               n: usize,
               name: &str,
               f: &dyn Integrand,
               trials: u64| {
        let n = pattern.nearest_count(n, Domain::Sphere);
        let (t, truth) = tally(pattern, n, f, trials, seeds)?;
        writeln!(
            out,
            "{name:24} {pattern:12} N = {n:4} m = {trials:4} truth {truth:9.3e}: interval in {:3} of {seeds}, \
             misses {:3}, without its value {}; seen {} of which with interval {}",
            t.present, t.missed, t.outside, t.seen, t.seen_present
        )?;
        Ok::<u64, Box<dyn Error>>(t.missed)
    };
    let lobes: Vec<(&str, usize, u64, Box<dyn Integrand>)> = vec![
        ("vmf 1e6", 100, 1000, Box::new(VonMisesFisher::new(1e6)?)),
        ("vmf 1e5", 10, 1000, Box::new(VonMisesFisher::new(1e5)?)),
        ("vmf 1e4", 30, 1000, Box::new(VonMisesFisher::new(1e4)?)),
        ("phong 2000", 1, 200, Box::new(PhongLobe::new(2000.0)?)),
        ("phong 2000", 1, 1000, Box::new(PhongLobe::new(2000.0)?)),
        ("phong 2000", 12, 1000, Box::new(PhongLobe::new(2000.0)?)),
        ("cap 0.27", 100, 1000, Box::new(Cap::from_degrees(0.27)?)),
        ("cap 2", 48, 1000, Box::new(Cap::from_degrees(2.0)?)),
        ("cap 5", 48, 1000, Box::new(Cap::from_degrees(5.0)?)),
        ("cap 179", 2, 2000, Box::new(Cap::from_degrees(179.0)?)),
        ("cap 177", 12, 1000, Box::new(Cap::from_degrees(177.0)?)),
        ("double cap 1", 48, 1000, Box::new(DoubleCap::from_degrees(1.0)?)),
    ];
    for (name, n, trials, f) in &lobes {
        for pattern in &patterns {
            row(&mut out, pattern, *n, name, &**f, *trials)?;
        }
    }
    writeln!(out)?;
    let ordinary: Vec<(&str, Box<dyn Integrand>)> = vec![
        ("cosine", Box::new(ClampedCosine)),
        ("abs-cosine", Box::new(AbsCosine)),
        ("cap 60", Box::new(Cap::from_degrees(60.0)?)),
        ("cap 30", Box::new(Cap::from_degrees(30.0)?)),
        ("cap 90", Box::new(Cap::from_degrees(90.0)?)),
        ("cap 120", Box::new(Cap::from_degrees(120.0)?)),
        ("cap 150", Box::new(Cap::from_degrees(150.0)?)),
        ("half space 0.3", Box::new(Cap::new(0.3_f64.acos())?)),
        ("double cap 40", Box::new(DoubleCap::from_degrees(40.0)?)),
        ("double cap 70", Box::new(DoubleCap::from_degrees(70.0)?)),
        ("vmf 1", Box::new(VonMisesFisher::new(1.0)?)),
        ("vmf 10", Box::new(VonMisesFisher::new(10.0)?)),
        ("vmf 50", Box::new(VonMisesFisher::new(50.0)?)),
        ("phong 1.5", Box::new(PhongLobe::new(1.5)?)),
        ("phong 4", Box::new(PhongLobe::new(4.0)?)),
        ("phong 20", Box::new(PhongLobe::new(20.0)?)),
        ("Y_1,0", Box::new(Harmonic::new(1, 0)?)),
        ("Y_4,0", Box::new(Harmonic::new(4, 0)?)),
        ("Y_9,3", Box::new(Harmonic::new(9, 3)?)),
        ("Y_20,20", Box::new(Harmonic::new(20, 20)?)),
    ];
    let (mut missed, mut rows) = (0, 0);
    for (name, f) in &ordinary {
        for pattern in &patterns[1..] {
            missed += row(&mut out, pattern, 48, name, &**f, 1000)?;
            rows += seeds;
        }
    }
    writeln!(out, "ordinary: {:.2} % covered", 100.0 * (1.0 - missed as f64 / rows as f64))?;
    Ok(())
}
