//! Results are bit-identical for any number of threads and any split of a run.

use rayon::ThreadPoolBuilder;
use sphvar_integrands::{Cap, Integrand};
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
use sphvar_spectrum::{Resolution, SpectrumAccumulator, accumulate, estimate};
use sphvar_variance::{PredictionAccumulator, VariancePoint, crossover, measure, predict};

const SEED: u64 = 5;
const N: usize = 108;
const LMAX: usize = 30;
const REALIZATIONS: u64 = 60;

fn streams() -> Streams {
    Streams::new(SEED, Purpose::Pattern, N)
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|x| x.to_bits()).collect()
}

/// Returns all results of an experiment, as bits.
fn experiment() -> Vec<u64> {
    let mut out = Vec::new();
    let cap = Cap::from_degrees(60.0).unwrap();
    let energy = cap.energy(Domain::Sphere, LMAX).unwrap();
    let mut points = Vec::new();
    for pattern in Pattern::ELEMENTARY {
        let n = pattern.nearest_count(N, Domain::Sphere);
        let sampler = pattern.build(n, Domain::Sphere).unwrap();
        let ensemble = Realizations::rotated(&*sampler, streams());
        let spectrum = estimate(&ensemble, LMAX, REALIZATIONS, &()).unwrap();
        out.extend(bits(spectrum.power()));
        out.extend(bits(spectrum.stderr()));
        let predicted = predict(&spectrum, &energy);
        out.extend(bits(&[predicted.variance, predicted.stderr, predicted.tail]));
        let empty = PredictionAccumulator::new(&energy, n, LMAX);
        let own = accumulate(&ensemble, Resolution::new(LMAX, n), 0..REALIZATIONS, &empty, &())
            .unwrap()
            .finish();
        out.extend(bits(&[own.variance, own.stderr, own.tail]));
        let measured = measure(&ensemble, &cap, REALIZATIONS, &()).unwrap();
        out.extend(bits(measured.estimates()));
        out.extend(bits(&[measured.mean(), measured.variance(), measured.variance_stderr()]));
        points.push(VariancePoint {
            n_points: n as f64,
            variance: measured.variance(),
            stderr: measured.variance_stderr(),
        });
    }
    let steep = |p: &VariancePoint, k: f64| VariancePoint {
        n_points: k * p.n_points,
        variance: p.variance / (k * k),
        ..*p
    };
    let a = [points[1], steep(&points[1], 16.0)];
    let b = [points[3], VariancePoint { n_points: 16.0 * points[3].n_points, ..points[3] }];
    // Falling as N^-2 from above against a level: they cross.
    let at = crossover(&a, &b, streams()).expect("the curves cross");
    out.extend(bits(&[at.n_points, at.interval.0, at.interval.1]));
    out
}

#[test]
fn threads_change_nothing() {
    let one = ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(experiment);
    assert!(one.len() > 4 * 2 * LMAX, "nothing was computed");
    for threads in [2, 3, 7] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for attempt in 0..3 {
            let got = pool.install(experiment);
            let differs = one.iter().zip(&got).position(|(a, b)| a != b);
            assert_eq!(differs, None, "{threads} threads, attempt {attempt}");
            assert_eq!(one.len(), got.len(), "{threads} threads");
        }
    }
}

/// Shards of any size, merged in any order, are bit-identical to the unsplit run.
#[test]
fn shards_merge_to_the_unsplit_run() {
    let sampler = Pattern::Jittered.build(N, Domain::Sphere).unwrap();
    let ensemble = Realizations::rotated(&*sampler, streams());
    let empty = SpectrumAccumulator::new(Domain::Sphere, N, LMAX);
    let run = |range| accumulate(&ensemble, Resolution::new(LMAX, N), range, &empty, &()).unwrap();
    let whole = run(0..REALIZATIONS).finish().unwrap();
    for cuts in [vec![30], vec![1, 2, 3], vec![7, 20, 21, 59], vec![10, 20, 30, 40, 50]] {
        let mut limits = vec![0];
        limits.extend(&cuts);
        limits.push(REALIZATIONS);
        let shards: Vec<_> = limits.windows(2).map(|w| run(w[0]..w[1])).collect();
        let count = shards.len();
        // Forwards, backwards, and from the middle outwards.
        let forwards: Vec<usize> = (0..count).collect();
        let backwards: Vec<usize> = (0..count).rev().collect();
        let mut middle = forwards.clone();
        middle.rotate_left(count / 2);
        for order in [forwards, backwards, middle] {
            let mut merged = empty.clone();
            for &i in &order {
                merged.try_merge(&shards[i]).unwrap();
            }
            let got = merged.finish().unwrap();
            assert_eq!(got.realizations(), REALIZATIONS, "cuts {cuts:?}, order {order:?}");
            assert_eq!(bits(got.power()), bits(whole.power()), "cuts {cuts:?}, order {order:?}");
            assert_eq!(bits(got.stderr()), bits(whole.stderr()), "cuts {cuts:?}, order {order:?}");
        }
    }
}

/// Merging shards of different ensembles is an error.
#[test]
fn shards_of_other_ensembles_are_rejected() {
    let empty = |domain, n, lmax| SpectrumAccumulator::new(domain, n, lmax);
    let mut mine = empty(Domain::Sphere, N, LMAX);
    for other in [
        empty(Domain::Hemisphere, N, LMAX),
        empty(Domain::Sphere, N + 1, LMAX),
        empty(Domain::Sphere, N, LMAX + 1),
    ] {
        assert!(mine.try_merge(&other).is_err(), "merged {other:?}");
    }
}
