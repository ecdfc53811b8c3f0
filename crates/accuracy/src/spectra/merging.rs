use crate::reference::DoubleDouble;
use rand::Rng;
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
use sphvar_spectrum::{Moments, Resolution, SpectrumAccumulator, accumulate};

use crate::Errors;

const SEED: u64 = 7;
/// The total number of realizations.
const COUNT: u64 = 100_000;
/// The number of realizations accumulated together.
const SHARD: u64 = 100;

/// Returns a number below `n`; the bias of the remainder does not matter for a random order.
fn below(n: usize, rng: &mut impl Rng) -> usize {
    let n = n as u64;
    usize::try_from(rng.next_u64() % n).unwrap_or(0)
}

/// Merges accumulators in random pairs: a random tree in a random order.
fn merged<A>(mut parts: Vec<A>, rng: &mut impl Rng, merge: impl Fn(&mut A, &A)) -> Option<A> {
    while parts.len() > 1 {
        let other = parts.swap_remove(below(parts.len(), rng));
        let into = below(parts.len(), rng);
        merge(&mut parts[into], &other);
    }
    parts.pop()
}

/// Compares the bits of two results; the error is infinite if any differ.
fn push_bits(errors: &mut Errors, name: &str, got: &[f64], expected: &[f64]) {
    let same = got.len() == expected.len()
        && got.iter().zip(expected).all(|(a, b)| a.to_bits() == b.to_bits());
    errors.push(if same { 0.0 } else { f64::INFINITY }, || format!("the bits of {name}"));
}

/// Compares the mean and the variance of numbers, accumulated in order and merged one by one in a
/// random tree, with twice the working precision; and the spectrum of the same number of
/// realizations, in shards merged in a random tree, with that of all of them at once.
pub(super) fn errors() -> Errors {
    let mut errors = Errors::default();
    let mut rng = Streams::new(SEED, Purpose::Resample, 0).realization(0);
    let numbers: Vec<f64> = (0..COUNT).map(|_| power_of_one(&mut rng)).collect();
    let mut in_order = Moments::default();
    let singles = numbers.iter().map(|&x| {
        in_order.push(x);
        let mut single = Moments::default();
        single.push(x);
        single
    });
    let singles: Vec<Moments> = singles.collect();
    let of = |m: &Moments| [m.mean(), m.variance()];
    for _ in 0..2 {
        let tree = merged(singles.clone(), &mut rng, Moments::merge);
        let tree = tree.unwrap_or_default();
        push_bits(&mut errors, "mean and variance", &of(&tree), &of(&in_order));
    }
    let n = DoubleDouble::from(COUNT);
    let sum = |f: &dyn Fn(DoubleDouble) -> DoubleDouble| {
        numbers.iter().fold(DoubleDouble::ZERO, |sum, &x| sum + f(DoubleDouble::from(x)))
    };
    let mean = sum(&|x| x) / n;
    let variance = sum(&|x| (x - mean) * (x - mean)) / (n - DoubleDouble::ONE);
    for (name, got, exact) in
        [("mean", in_order.mean(), mean), ("variance", in_order.variance(), variance)]
    {
        let error = (DoubleDouble::from(got) - exact) / exact;
        errors.push(error.value(), || format!("the {name} of {COUNT} numbers"));
    }
    push_spectra(&mut errors, &mut rng);
    errors
}

/// Returns a number like the power of one realization: positive, of any size between 2^-20 and
/// 2^20, with all digits.
fn power_of_one(rng: &mut impl Rng) -> f64 {
    let (digits, size) = (rng.next_u64() >> 11, below(41, rng));
    let mantissa = 1.0 + digits as f64 * f64::EPSILON * 0.5;
    mantissa * 2f64.powi(i32::try_from(size).unwrap_or(0) - 20)
}

fn push_spectra(errors: &mut Errors, rng: &mut impl Rng) {
    const N: usize = 3;
    const LMAX: usize = 3;
    let sampler = Pattern::WhiteNoise.build(N, Domain::Sphere).expect("three points exist");
    let sets = Realizations::rotated(&*sampler, Streams::new(SEED, Purpose::Pattern, N));
    let empty = SpectrumAccumulator::new(Domain::Sphere, N, LMAX);
    let resolution = Resolution::new(LMAX, N);
    let range = |range| accumulate(&sets, resolution, range, &empty, &());
    let shards: Result<Vec<_>, _> =
        (0..COUNT / SHARD).map(|i| range(i * SHARD..(i + 1) * SHARD)).collect();
    let tree = shards.ok().and_then(|shards| {
        // A failed merge would leave realizations out, which changes the bits.
        merged(shards, rng, |into, other| _ = into.try_merge(other))
    });
    let spectra = [tree, range(0..COUNT).ok()].map(|sum| sum.and_then(|sum| sum.finish().ok()));
    let [tree, whole] = spectra.map(|s| s.map_or(vec![], |s| [s.power(), s.stderr()].concat()));
    errors.push(if whole.is_empty() { f64::INFINITY } else { 0.0 }, || "no spectrum".to_owned());
    push_bits(errors, "power and standard errors", &tree, &whole);
}
