//! Spectra, sums and predictions over bands that are not the degrees of the sphere: the frequencies
//! of the circle and of the square.

use std::f64::consts::TAU;

use rand::RngExt;
use serde::{Deserialize, Serialize};
use sphvar_integrands::Energy;
use sphvar_samplers::{Purpose, Streams};
use sphvar_sh::{Bands, ByAxis, ByParity, Frequencies};
use sphvar_spectrum::{Spectrum, SpectrumAccumulator};
use sphvar_variance::{Measurement, PredictionAccumulator, predict};

/// The frequencies k = 0, 1, ... of the circle of length 1, each with a cosine and a sine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Circle;

impl Bands for Circle {
    type Tail = ByParity;

    fn label(&self) -> &'static str {
        "k"
    }

    fn has_band(&self, _: usize) -> bool {
        true
    }

    fn multiplicity(&self, band: usize) -> f64 {
        if band == 0 { 1.0 } else { 2.0 }
    }

    fn radius(&self, band: usize) -> f64 {
        band as f64
    }

    /// Even or odd under a shift by half a turn.
    fn tail_class(&self, band: usize) -> usize {
        band % 2
    }

    fn area(&self) -> f64 {
        TAU
    }

    fn factor(&self, n_points: usize) -> f64 {
        1.0 / n_points as f64
    }

    fn spacing_radius(&self, _class: usize, n_points: usize) -> f64 {
        n_points as f64
    }
}

const N: usize = 8;
const LAST: usize = 24;
const SETS: u64 = 4000;
/// The length of the arc whose indicator is integrated.
const ARC: f64 = 0.3;

/// Jittered points: one in each of N equal arcs, with a uniform random rotation.
fn jittered(index: u64) -> Vec<f64> {
    let streams = Streams::new(2, Purpose::Pattern, N);
    let rng = &mut streams.realization(index);
    let shift: f64 = streams.randomization(index).random();
    let x = |k: usize, u: f64| ((k as f64 + u) / N as f64 + shift).fract();
    (0..N).map(|k| x(k, rng.random())).collect()
}

/// `P(k) = |sum_j e^(2 pi i k x_j)|^2/N`, 1 for white noise.
fn powers(points: &[f64]) -> Vec<f64> {
    let power = |k: usize| {
        let waves = points.iter().map(|x| (TAU * k as f64 * x).sin_cos());
        let (s, c) = waves.fold((0.0, 0.0), |sum, wave| (sum.0 + wave.0, sum.1 + wave.1));
        (s * s + c * c) / points.len() as f64
    };
    (0..=LAST).map(power).collect()
}

/// `1 - sinc^2(k/N)` for jittered points and k >= 1.
fn exact() -> Spectrum<Circle> {
    let power = (0..=LAST).map(|k| {
        let x = std::f64::consts::PI * k as f64 / N as f64;
        if k == 0 { N as f64 } else { 1.0 - (x.sin() / x).powi(2) }
    });
    Spectrum::exact(Circle, N, power.collect())
}

/// Returns an arc of length a has `|f_k|^2 = (sin(pi k a)/(pi k))^2`, twice for the wave and its
/// conjugate, and the variance `a - a^2` in all; that of even frequencies is that of the mean over
/// opposite points.
fn arc() -> Energy<Circle> {
    let energy = |k: usize| {
        let x = std::f64::consts::PI * k as f64;
        if k == 0 { ARC * ARC } else { 2.0 * ((ARC * x).sin() / x).powi(2) }
    };
    // The arc and its opposite do not meet: the even part is 1/2 on a set of measure 2 a.
    let even = 0.5 * ARC - ARC * ARC;
    let centred = ByParity { even, odd: ARC - ARC * ARC - even };
    Energy::new(Circle, (0..=LAST).map(energy).collect(), centred)
}

#[test]
fn prediction_and_measurement_agree_on_the_circle() {
    let energy = arc();
    let mut spectrum = SpectrumAccumulator::new(Circle, N, LAST);
    let mut other = SpectrumAccumulator::new(Circle, N, LAST);
    let mut prediction = PredictionAccumulator::new(&energy, N, LAST);
    let mut estimates = Vec::new();
    for index in 0..SETS {
        let points = jittered(index);
        let powers = powers(&points);
        let half = if index % 2 == 0 { &mut spectrum } else { &mut other };
        half.push_powers(N as f64, powers.iter().copied(), ByParity::both(1.0));
        prediction.push_powers(N as f64, &powers, || ByParity::both(1.0));
        let inside = jittered(SETS + index).iter().filter(|x| **x < ARC).count();
        estimates.push(inside as f64 / N as f64);
    }
    // Merged through a file, as shards are.
    let saved = serde_json::to_string(&other).unwrap();
    spectrum.try_merge(&serde_json::from_str(&saved).unwrap()).unwrap();
    let sampled = spectrum.finish().unwrap();
    let exact = exact();
    // 24 means, each beyond 5 standard errors by chance for 1.4e-5 of seeds in total.
    for ((k, p, e), (_, expected, _)) in sampled.rows().zip(exact.rows()).skip(1) {
        assert!((p - expected).abs() <= 5.0 * e, "P({k}) = {p} +- {e}, expected {expected}");
    }
    let [by_realizations, by_mean, truth] =
        [prediction.finish(), predict(&sampled, &energy), predict(&exact, &energy)];
    assert!((by_realizations.variance / by_mean.variance - 1.0).abs() < 1e-12);
    // One error includes the covariance of frequencies, the other does not.
    assert!(by_realizations.stderr > 0.5 * by_mean.stderr, "{by_realizations:?}, {by_mean:?}");
    let sigma = by_realizations.stderr;
    assert!((by_realizations.variance - truth.variance).abs() < 5.0 * sigma, "{truth:?}");
    // Either end of the arc lies in one stratum, uniformly: the share u of it that is inside gives
    // the count the variance u (1 - u), 1/6 on average.
    let of_ends = 2.0 / 6.0 / (N * N) as f64;
    assert!((truth.variance - of_ends).abs() <= truth.tail_error, "{truth:?}, {of_ends}");
    assert!(truth.tail_error < 0.05 * of_ends, "{truth:?}");
    let measured = Measurement::new(estimates);
    let z = (measured.variance() - of_ends) / measured.variance_stderr();
    assert!(z.abs() < 4.5, "{z}");
}

/// Half the effective number of points has twice the variance.
#[test]
fn weights_change_the_effective_number() {
    let energy = arc();
    let exact = exact();
    let half = exact.clone().with_n_effective(0.5 * N as f64);
    let [whole, half] = [predict(&exact, &energy), predict(&half, &energy)];
    assert!((half.variance / whole.variance - 2.0).abs() < 1e-14);
}

/// `|g_k|^2` for g(u) = u.
fn ramp(k: i32) -> f64 {
    if k == 0 { 0.25 } else { (TAU * f64::from(k)).powi(-2) }
}

/// Returns the energy of u v, of which 6/7 is on the axes.
fn product(bands: &Frequencies) -> Energy<Frequencies> {
    let energy = |band: usize| {
        let [k1, k2] = bands.frequency(band);
        bands.multiplicity(band) * ramp(k1) * ramp(k2)
    };
    let centred = ByAxis { off: 1.0 / 144.0, u: 1.0 / 48.0, v: 1.0 / 48.0 };
    Energy::new(bands.clone(), (0..bands.len()).map(energy).collect(), centred)
}

/// A regular grid with a random shift integrates u v with the product of two independent means, of
/// mean 1/2 and variance 1/(12 side^2). Its power is N at the multiples of the sides, so the mean
/// power at high frequencies differs between the axes.
#[test]
fn tails_apart_by_axis_are_those_of_the_square() {
    let bands = Frequencies::new(60).unwrap().with_axes(480).unwrap();
    let energy = product(&bands);
    let (rows, columns) = (16, 12);
    let power = (0..bands.len()).map(|band| {
        let [k1, k2] = bands.frequency(band);
        if k1 % rows == 0 && k2 % columns == 0 { f64::from(rows * columns) } else { 0.0 }
    });
    let power: Vec<f64> = power.collect();
    let n_points = 192;
    let tail = ByAxis { off: 1.0, u: f64::from(columns), v: f64::from(rows) };
    let spectrum = Spectrum::exact(bands.clone(), n_points, power.clone()).with_tail(tail);
    let predicted = predict(&spectrum, &energy);
    let of_mean = |side: i32| 0.25 + 1.0 / (12.0 * f64::from(side).powi(2));
    let exact = of_mean(rows) * of_mean(columns) - 0.0625;
    let error = (predicted.variance - exact).abs();
    assert!(error <= predicted.tail_error, "{predicted:?}, {exact}");
    assert!(predicted.tail_error < 0.02 * exact && predicted.tail > 0.01 * exact, "{predicted:?}");
    // With one mean power for all classes the error is several times larger.
    let other = predict(&spectrum.with_tail(ByAxis { off: 1.0, u: 1.0, v: 1.0 }), &energy);
    assert!((other.variance - exact).abs() > 2.5 * error, "{other:?}, {exact}");

    let mut sums = PredictionAccumulator::new(&energy, n_points, bands.len() - 1);
    sums.push_powers(n_points as f64, &power, || tail);
    let by_realizations = sums.finish();
    assert!((by_realizations.variance / predicted.variance - 1.0).abs() < 1e-14);
    assert!((by_realizations.tail_error / predicted.tail_error - 1.0).abs() < 1e-12);
}

/// Accumulated powers survive serialization and merge exactly; errors of energies are those of
/// their bands and classes.
#[test]
fn sums_over_the_square_merge_and_errors_propagate() {
    let bands = Frequencies::new(3).unwrap().with_axes(6).unwrap();
    let last = bands.len() - 1;
    let powers = |scale: f64| (0..bands.len()).map(move |band| scale * (band + 1) as f64);
    let tail = ByAxis { off: 1.0, u: 2.0, v: 3.0 };
    let mut sums = SpectrumAccumulator::new(bands.clone(), 4, last);
    let mut part = sums.clone();
    sums.push_powers(4.0, powers(1.0), tail);
    part.push_powers(4.0, powers(3.0), tail);
    let saved = serde_json::to_string(&part).unwrap();
    sums.try_merge(&serde_json::from_str(&saved).unwrap()).unwrap();
    let spectrum = sums.finish().unwrap();
    assert_eq!((spectrum.power()[5], spectrum.tail(), sums.realizations()), (12.0, tail, Some(2)));
    let wider = Frequencies::new(3).unwrap().with_axes(7).unwrap();
    assert!(sums.try_merge(&SpectrumAccumulator::new(wider, 4, last)).is_err());

    let mut per_band = vec![0.0; bands.len()];
    let on_axis = bands.band_of([0, 5]).unwrap();
    per_band[on_axis] = 0.3;
    let centred = ByAxis { off: 0.0, u: 0.1, v: 0.5 };
    let energy = product(&bands).with_stderr(per_band, centred);
    // The rest of the error on the second axis, 0.4, is beyond the last band.
    let power = 2.0 * (on_axis + 1) as f64;
    let expected = (0.3 * power).hypot(0.1 * tail.u).hypot(0.4 * tail.v) / 4.0;
    let got = predict(&spectrum, &energy).energy_stderr;
    assert!((got / expected - 1.0).abs() < 1e-12, "{got} and {expected}");
}
