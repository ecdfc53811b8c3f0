//! Spectra of the square against the definition and against closed forms.

use std::f64::consts::TAU;

use rayon::ThreadPoolBuilder;
use sphvar_samplers::{
    Ensemble, JitteredSquare, LatinHypercube, Lattice, PointSet, PointSets, Progress, Purpose,
    Square, SquareDistribution, SquarePattern, SquareRealizations, SquareSampler, Stopped, Streams,
    WhiteSquare,
};
use sphvar_sh::{ByAxis, Frequencies, TailClasses};

use crate::{
    Error, ExactSquareSpectrum, Spectrum, SpectrumAccumulator, SquareResolution, accumulate_square,
    estimate_square, square_tail_power,
};

type Set = PointSet<[f64; 2]>;

fn bands(kmax: usize, axis_max: usize) -> Frequencies {
    Frequencies::new(kmax).unwrap().with_axes(axis_max).unwrap()
}

/// Returns `|sum w_j exp(-2 pi i k.p_j)|^2/sum w^2` by the definition.
fn power(set: &Set, [k1, k2]: [i32; 2]) -> f64 {
    let weight = |j: usize| set.weights.get(j).copied().unwrap_or(1.0);
    let (mut re, mut im, mut squares) = (0.0, 0.0, 0.0);
    for (j, [u, v]) in set.points.iter().enumerate() {
        let turns = (f64::from(k1) * u).fract() + (f64::from(k2) * v).fract();
        let (sin, cos) = (TAU * turns).sin_cos();
        re += weight(j) * cos;
        im += weight(j) * sin;
        squares += weight(j) * weight(j);
    }
    (re * re + im * im) / squares
}

fn mean(sets: &dyn Ensemble<[f64; 2]>, n_sets: u64, bands: &Frequencies) -> Spectrum<Frequencies> {
    let empty = SpectrumAccumulator::of_square(bands.clone(), 1).unwrap();
    let resolution = SquareResolution::new(bands.clone());
    accumulate_square(sets, &resolution, 0..n_sets, &empty, &()).unwrap().finish().unwrap()
}

fn scattered(n: usize) -> Vec<[f64; 2]> {
    (0..n).map(|j| [0.754_877_666, 0.569_840_291].map(|a: f64| (a * j as f64).fract())).collect()
}

#[test]
fn powers_of_hostile_sets_are_those_of_the_definition() {
    let below = 1.0 - f64::EPSILON / 2.0;
    let signs: Vec<f64> =
        (0..50).map(|j| if j % 3 == 0 { -1.0 } else { 1.0 } * 1.7f64.powi(j % 20)).collect();
    let scaled = |scale: f64| signs.iter().map(|w| w * scale).collect::<Vec<f64>>();
    let sets = [
        Set::new(vec![[0.3, 0.9]]),
        Set::new(vec![[0.0, below], [below, 0.0], [0.0, 0.0], [below, below]]),
        Set::new(vec![[0.25, 0.125]; 300]),
        Set::new(scattered(50)),
        PointSet { points: scattered(50), weights: scaled(1.0) },
        PointSet { points: scattered(50), weights: scaled(1e-200) },
        PointSet { points: scattered(50), weights: scaled(1e200) },
    ];
    for (kmax, axis_max) in [(0, 0), (0, 7), (1, 1), (9, 9), (6, 40)] {
        let bands = bands(kmax, axis_max);
        for set in &sets {
            // The definition overflows for weights of extreme scale.
            let mut unit = set.clone();
            unit.normalize_weights();
            let n_effective = set.n_effective();
            let got = mean(&[set.clone()].as_slice(), 1, &bands);
            let total: f64 = unit.weights.iter().map(|w| w.abs()).sum();
            let squares: f64 = unit.weights.iter().map(|w| w * w).sum();
            let scale =
                if unit.weights.is_empty() { set.len() as f64 } else { total * total / squares };
            for (band, p, _) in got.rows() {
                let k = bands.frequency(band);
                let expected = power(&unit, k);
                let error = (p - expected).abs();
                assert!(error <= 4e-12 * scale, "{k:?} of {}: {p}, {expected}", set.len());
            }
            assert!((got.n_effective() - n_effective).abs() <= 1e-12 * n_effective);
            assert_eq!(got.tail(), square_tail_power(&unit));
        }
    }
    // A point outside the square.
    let outside: [Set; 1] = [Set::new(vec![[0.5, 1.0]])];
    let resolution = SquareResolution::new(bands(3, 3));
    let empty = SpectrumAccumulator::of_square(bands(3, 3), 1).unwrap();
    let error = accumulate_square(&outside.as_slice(), &resolution, 0..1, &empty, &()).unwrap_err();
    assert!(matches!(error, Error::Sampler(_)), "{error}");
}

#[test]
fn lattices_have_their_power_at_the_dual_frequencies() {
    let bands = bands(24, 60);
    for lattice in [
        Lattice::grid(4, 6).unwrap(),
        Lattice::grid(1, 1).unwrap(),
        Lattice::rank_1(21, 13).unwrap(),
        Lattice::rank_1(12, 4).unwrap(),
    ] {
        let n = lattice.n_points();
        let points: Vec<[f64; 2]> = (0..n).map(|j| lattice.point(j)).collect();
        #[derive(Debug)]
        struct Fixed(Lattice, bool, Vec<[f64; 2]>);
        impl SquareSampler for Fixed {
            fn n_points(&self) -> usize {
                self.2.len()
            }
            fn sample_into(
                &self,
                _: &mut dyn rand::Rng,
                set: &mut Set,
            ) -> Result<(), sphvar_samplers::Error> {
                set.start().extend(&self.2);
                Ok(())
            }
            fn distribution(&self) -> SquareDistribution<'_> {
                if self.1 { SquareDistribution::Lattice(self.0) } else { SquareDistribution::Fixed }
            }
        }
        let [closed, transformed] = [true, false].map(|is_lattice| {
            let sampler = Fixed(lattice, is_lattice, points.clone());
            ExactSquareSpectrum::of(&sampler).unwrap().to(&bands, &()).unwrap()
        });
        let sampler = Fixed(lattice, false, points.clone());
        let streams = Streams::new(3, Purpose::Pattern, 0);
        let shifted =
            estimate_square(&SquareRealizations::shifted(&sampler, streams), &bands, 5, &())
                .unwrap();
        assert!(closed.is_exact() && shifted.is_exact() && shifted.realizations() == 1);
        for spectrum in [&transformed, &shifted] {
            assert_eq!(spectrum.tail(), closed.tail(), "{lattice:?}");
            for ((band, p, _), exact) in spectrum.rows().zip(closed.power()) {
                let k = bands.frequency(band);
                assert!((p - exact).abs() <= 1e-10 * n as f64, "{lattice:?} {k:?}: {p}, {exact}");
            }
            let rounded = (*spectrum).clone().without_rounding();
            for (p, exact) in rounded.power().iter().zip(closed.power()) {
                assert_eq!(*p == 0.0, *exact == 0.0, "{lattice:?}: {p:e}, {exact}");
            }
        }
    }
}

/// Compares the mean over `n_sets` sets with the closed form. Every band must be within 5.5
/// standard errors, which 950 bands exceed by chance for 4e-5 of seeds. The sum of the squared
/// deviations over their number has the standard deviation 0.046 for independent bands; the limits
/// are more than 3 of them away, a false alarm in 1 of 500 seeds for each pattern.
fn check_closed_form(sampler: &dyn SquareSampler, seed: u64, n_sets: u64) {
    let bands = bands(24, 48);
    let exact = ExactSquareSpectrum::of(sampler).unwrap().to(&bands, &()).unwrap();
    assert!(exact.is_exact() && exact.tail() == ByAxis::all(1.0));
    let streams = Streams::new(seed, Purpose::Pattern, sampler.n_points());
    let ensemble = SquareRealizations::shifted(sampler, streams);
    let got = estimate_square(&ensemble, &bands, n_sets, &()).unwrap();
    let mut sum = 0.0;
    for ((band, p, e), (_, expected, _)) in got.rows().zip(exact.rows()).skip(1) {
        let z = (p - expected) / e;
        assert!(z.abs() < 5.5, "{sampler:?} {:?}: {p} +- {e}, {expected}", bands.frequency(band));
        sum += z * z;
    }
    let chi2 = sum / (bands.len() - 1) as f64;
    assert!((0.85..=1.15).contains(&chi2), "{sampler:?}: chi2/dof {chi2}");
    assert!((got.power()[0] - sampler.n_points() as f64).abs() < 1e-9);
}

#[test]
fn sampled_spectra_are_those_in_closed_form() {
    check_closed_form(&WhiteSquare::new(10).unwrap(), 1, 1500);
    check_closed_form(&JitteredSquare::new(3, 7).unwrap(), 2, 1500);
    check_closed_form(&LatinHypercube::new(5).unwrap(), 3, 1500);
}

#[test]
#[ignore = "statistics"]
fn more_sampled_spectra_are_those_in_closed_form() {
    for (seed, (rows, columns)) in
        [(2, 2), (1, 12), (9, 2), (8, 8), (16, 16)].into_iter().enumerate()
    {
        let seed = seed as u64 + 10;
        check_closed_form(&JitteredSquare::new(rows, columns).unwrap(), seed, 10_000);
    }
    check_closed_form(&LatinHypercube::new(2).unwrap(), 20, 10_000);
    check_closed_form(&LatinHypercube::new(16).unwrap(), 21, 10_000);
}

#[test]
fn one_of_several_sets_has_their_mean_power() {
    let weighted = PointSet { points: scattered(5), weights: vec![1.0, 2.0, -0.5, 3.0, 1.0] };
    let column = (0..6).map(|j| [0.5, f64::from(j) / 7.0]).collect();
    let sets = [Set::new(scattered(9)), weighted, Set::new(column)];
    let sampler = PointSets::new(sets.to_vec(), Square).unwrap();
    let bands = bands(5, 11);
    let got = ExactSquareSpectrum::of(&sampler).unwrap().to(&bands, &()).unwrap();
    for (band, p, e) in got.rows() {
        let k = bands.frequency(band);
        let expected = sets.iter().map(|set| power(set, k)).sum::<f64>() / 3.0;
        assert!((p - expected).abs() < 1e-11 && e == 0.0, "{k:?}: {p}, {expected}");
    }
    let n_effective = sets.iter().map(PointSet::n_effective).sum::<f64>() / 3.0;
    assert!((got.n_effective() - n_effective).abs() < 1e-12);
    assert!((got.tail().u - (1.0 + 1.0 + 6.0) / 3.0).abs() < 1e-14);
    assert!((got.tail().v - 1.0).abs() < 1e-14);
}

/// One run equals any parts of it, on any number of threads.
#[test]
fn parts_merge_to_a_bit_identical_spectrum() {
    let sampler = JitteredSquare::new(4, 4).unwrap();
    let sets = SquareRealizations::shifted(&sampler, Streams::new(5, Purpose::Pattern, 16));
    let bands = bands(8, 20);
    let resolution = SquareResolution::new(bands.clone());
    let empty = SpectrumAccumulator::of_square(bands, 16).unwrap();
    let part = |indices| accumulate_square(&sets, &resolution, indices, &empty, &()).unwrap();
    let pool = ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let whole = pool.install(|| part(0..13)).finish().unwrap();
    let mut merged = part(6..13);
    merged.try_merge(&part(0..6)).unwrap();
    assert_eq!(whole, merged.finish().unwrap());
}

#[test]
fn invalid_requests_and_stops_are_errors() {
    let white = SquarePattern::WhiteSquare.build(4).unwrap();
    let sets = SquareRealizations::shifted(&*white, Streams::new(0, Purpose::Pattern, 4));
    let large = Frequencies::new(SquareResolution::MAX_KMAX_WITH_ERRORS + 1).unwrap();
    let error = estimate_square(&sets, &large, 1, &()).unwrap_err();
    assert_eq!(error, Error::Frequencies { kmax: 513, max: 512 });
    let none = estimate_square(&sets, &bands(4, 4), 0, &()).unwrap_err();
    assert_eq!(none, Error::NoRealizations);
    let single = estimate_square(&sets, &bands(4, 4), 1, &()).unwrap();
    assert!(single.stderr()[1].is_nan() && !single.power()[1].is_nan());
    let resolution = SquareResolution { epsilon: 1e-20, ..SquareResolution::new(bands(4, 4)) };
    let empty = SpectrumAccumulator::of_square(bands(4, 4), 4).unwrap();
    let error = accumulate_square(&sets, &resolution, 0..1, &empty, &()).unwrap_err();
    assert!(matches!(error, Error::SquareTransform(_)), "{error}");

    #[derive(Debug)]
    struct Interrupted;
    impl Progress for Interrupted {
        fn tick(&self, _work: f64) -> Result<(), Stopped> {
            Err(Stopped)
        }
    }
    let error = estimate_square(&sets, &bands(4, 4), 100, &Interrupted).unwrap_err();
    assert_eq!(error, Error::from(Stopped));
}
