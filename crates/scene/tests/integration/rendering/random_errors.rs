//! Error reports for images of normal random numbers, whose error distribution is known.

use std::f64::consts::TAU;

use rand::RngExt;
use sphvar_samplers::{Purpose, Streams};
use sphvar_scene::{ErrorReport, Image, RenderErrors};

const SEED: u64 = 11;
const SIDE: usize = 8;
/// The standard deviation of a pixel.
const SIGMA: f64 = 1e-3;

fn image(values: Vec<f64>) -> Image {
    Image {
        width: SIDE,
        height: SIDE,
        values,
        // The reference image is exact, and the large number of directions resolves any share.
        spreads: vec![0.0; SIDE * SIDE],
        coverage: vec![1.0; SIDE * SIDE],
        n_points: 1 << 40,
        rays: 0,
        sampled_spreads: Vec::new(),
    }
}

/// Returns the report of `renders` images with errors of mean `bias(pixel)`; different numbers are
/// independent.
fn report(number: u64, renders: usize, bias: impl Fn(usize) -> f64) -> ErrorReport {
    let reference = image(vec![0.5; SIDE * SIDE]);
    let mut rng = Streams::new(SEED, Purpose::Trial, 0).realization(number);
    let mut errors = RenderErrors::new(&reference);
    for _ in 0..renders {
        let normal = |i: usize| {
            // Box and Muller (1958).
            let radius = (-2.0 * (-rng.random::<f64>()).ln_1p()).sqrt();
            0.5 + bias(i) + SIGMA * radius * (TAU * rng.random::<f64>()).cos()
        };
        errors.push(&image((0..SIDE * SIDE).map(normal).collect())).unwrap();
    }
    errors.report()
}

/// Three renders have 2 degrees of freedom: limits from a normal distribution would report a bias
/// in every picture.
#[test]
fn the_bias_test_has_the_stated_false_alarm_rate() {
    let alarms = (0..2000).filter(|&k| report(k, 3, |_| 0.0).bias.unwrap().is_biased()).count();
    // 1 % of 2000 is 20; a Poisson variable of that mean is outside for 3e-5 of seeds.
    assert!((5..=41).contains(&alarms), "{alarms}");
}

/// The limit is 80 standard errors for 2 degrees of freedom; the bias has 1700.
#[test]
fn one_biased_pixel_is_detected() {
    for k in 0..20 {
        let test = report(k, 3, |i| if i == 13 { -1000.0 * SIGMA } else { 0.0 }).bias.unwrap();
        assert!(test.beyond >= 1 && test.largest > test.limit, "{k}: {test:?}");
    }
}

/// For a bias of one standard deviation, the estimate has the correct mean and scatters as its
/// standard error states.
#[test]
fn the_squared_bias_has_its_standard_error() {
    let n = 400.0;
    let estimates: Vec<_> = (0..400).map(|k| report(k, 8, |_| SIGMA).bias_squared).collect();
    let mean = estimates.iter().map(|e| e.value).sum::<f64>() / n;
    let scatter = estimates.iter().map(|e| (e.value - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let exact = SIGMA * SIGMA;
    assert!((mean - exact).abs() < 4.5 * (scatter / n).sqrt(), "{mean:e} {exact:e}");
    let ratio = estimates.iter().map(|e| e.stderr * e.stderr).sum::<f64>() / n / scatter;
    // sqrt(2/399) = 7 % of the scatter, 3 % of the mean; the jackknife is too large by 7 % for
    // eight renders.
    assert!((ratio - 1.07).abs() < 4.5 * 0.08, "{ratio}");
    assert!(
        report(0, 2, |_| 0.0).bias_squared.stderr.is_nan(),
        "two renders have no standard error"
    );
}
