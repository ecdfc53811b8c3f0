use num_complex::Complex;

use super::Recipe;
use super::patterns::ThesisPattern;
use super::significance::{Kuiper, equal_to, kuiper, mean_is_zero, verdict};
use crate::{
    Axis, Claim, Error, Field, Figure, Job, Palette, Quantity, Results, Setting, ThesisEnsemble,
    Verdict,
};

/// Figure 4.17: the distribution of one coefficient over rotated sets.
pub(crate) struct CoefficientClouds;

const PATTERNS: [ThesisPattern; 4] = [
    ThesisPattern::WhiteNoise,
    ThesisPattern::Jittered,
    ThesisPattern::Healpix,
    ThesisPattern::Fibonacci,
];
const DEGREE: usize = 4;
const ORDER: usize = 3;
const N_POINTS: usize = 1024;
const SETS: u64 = 8192;
/// Bins per side of the plane; odd, so that 0 is inside a bin.
const BINS: usize = 41;
/// The plane reaches to this multiple of the root mean square of a coefficient.
const REACH: f64 = 3.0;
/// Claims that are judged together: two for each pattern, and one of order 0.
const COMPARISONS: f64 = 9.0;

fn job(pattern: ThesisPattern, m: usize) -> Job {
    let ensemble = ThesisEnsemble::sphere(pattern.pattern(), N_POINTS);
    Job::Coefficient { ensemble, l: DEGREE, m, sets: SETS }
}

impl Recipe for CoefficientClouds {
    fn title(&self) -> &'static str {
        "Distribution of the coefficient l = 4, m = 3 over 8192 rotated sets"
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        let zonal = job(ThesisPattern::Jittered, 0);
        PATTERNS.iter().map(|&pattern| job(pattern, ORDER)).chain([zonal]).collect()
    }

    fn compose(&self, _: Setting, results: &Results, figure: &mut Figure) -> Result<(), Error> {
        for pattern in PATTERNS {
            let samples = normalized(pattern, results.coefficients(&job(pattern, ORDER))?);
            let n = pattern.pattern().nearest_count(N_POINTS, sphvar_samplers::Domain::Sphere);
            figure.panel(
                pattern.name(),
                format!("{}, N = {n}", pattern.label()),
                density(&samples, "sqrt(4 pi/N) S(4,3)"),
            );
            let pairs: Vec<[f64; 2]> = samples.iter().map(|s| [s.re, s.im]).collect();
            let mean = samples.iter().sum::<Complex<f64>>() / samples.len() as f64;
            figure.claims.push(
                judged(
                    format!("{}: mean of S(4,3)", pattern.label()),
                    "zero",
                    mean_is_zero(&pairs),
                )
                .measured(Quantity::single(mean.norm() / root_mean_square(&samples)))
                .because(format!(
                    "its size in units of the root mean square, {:.3e}; {:.4} on average by chance, {}",
                    root_mean_square(&samples),
                    // A sum of R unit vectors of random phase has the mean length sqrt(pi R)/2.
                    (0.25 * std::f64::consts::PI / SETS as f64).sqrt(),
                    equal_to(mean_is_zero(&pairs))
                )),
            );
            figure.claims.push(phases(pattern, ORDER, &samples));
        }
        let pattern = ThesisPattern::Jittered;
        let zonal = normalized(pattern, results.coefficients(&job(pattern, 0))?);
        figure.panel(
            "jittered-order-0",
            "jittered, order 0: the coefficient is real",
            density(&zonal, "sqrt(4 pi/N) S(4,0)"),
        );
        figure.claims.push(phases(pattern, 0, &zonal).erratum_if(Verdict::Wrong, 10));
        figure.note(format!(
            "The {COMPARISONS} claims are judged together by their p-values times {COMPARISONS}: wrong below 1e-4, undecided below 1e-2."
        ));
        Ok(())
    }
}

/// Returns coefficients in units in which white noise has mean square 1.
fn normalized(pattern: ThesisPattern, samples: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let domain = sphvar_samplers::Domain::Sphere;
    let n = pattern.pattern().nearest_count(N_POINTS, domain) as f64;
    let unit = (domain.area() / n).sqrt();
    samples.iter().map(|s| s * unit).collect()
}

fn root_mean_square(samples: &[Complex<f64>]) -> f64 {
    (samples.iter().map(Complex::norm_sqr).sum::<f64>() / samples.len() as f64).sqrt()
}

fn judged(what: String, stated: &'static str, p_value: f64) -> Claim {
    let verdict: Verdict = verdict(COMPARISONS * p_value);
    Claim::words(what, stated, verdict)
}

/// "The phase of coefficients is uniformly distributed over [0, 2 pi]."
fn phases(pattern: ThesisPattern, m: usize, samples: &[Complex<f64>]) -> Claim {
    let phases: Vec<f64> = samples.iter().map(|s| s.arg()).collect();
    let Kuiper { statistic, p_value } = kuiper(&phases);
    let why = if m == 0 { "S_l0 is real, its phase 0 or pi; " } else { "" };
    let what = format!("{}: phase of S({DEGREE},{m})", pattern.label());
    judged(what, "uniform on [0, 2 pi]", p_value).measured(Quantity::single(statistic)).because(
        format!("{why}Kuiper's statistic, whose 5 % point is 1.747; {}", equal_to(p_value)),
    )
}

/// Returns the number of samples in each bin of the complex plane.
fn density(samples: &[Complex<f64>], what: &str) -> Field {
    let reach = REACH * root_mean_square(samples);
    let bin = |x: f64| {
        let place = (x / reach + 1.0) * 0.5 * BINS as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the number of bins"
        )]
        (0.0..BINS as f64).contains(&place).then_some(place as usize)
    };
    let mut values = vec![0.0; BINS * BINS];
    for sample in samples {
        // The imaginary axis points up.
        if let (Some(column), Some(row)) = (bin(sample.re), bin(-sample.im)) {
            values[row * BINS + column] += 1.0;
        }
    }
    Field {
        size: [BINS; 2],
        values,
        label: "sets in a bin".to_owned(),
        palette: Palette::Heat,
        x: Axis::linear(&format!("Re {what}")).over(-reach, reach),
        y: Axis::linear(&format!("Im {what}")).over(reach, -reach),
        rings: Vec::new(),
    }
}
