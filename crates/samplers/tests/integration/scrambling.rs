//! Scrambled digits: strata, the distribution of the permutations, and slow definitions.

use std::collections::HashMap;

use rand::{Rng, RngExt};
use sphvar_samplers::checks::{is_stratified, net_parameter};
use sphvar_samplers::{
    Halton, Hammersley, Purpose, ScrambledPattern, Scrambling, SobolSequence, SquarePattern,
    SquareSampler, Streams,
};

const RANDOM: [Scrambling; 2] = [Scrambling::Digital, Scrambling::Owen];

fn rng(index: u64) -> impl Rng {
    Streams::new(23, Purpose::Pattern, 4).realization(index)
}

fn sample<P: ScrambledPattern>(n: usize, scrambling: Scrambling, index: u64) -> Vec<[f64; 2]> {
    P::scrambled(n, scrambling).unwrap().sample(&mut rng(index)).unwrap().points
}

#[test]
fn scrambled_nets_are_nets() {
    for scrambling in RANDOM {
        for index in 0..4 {
            let sobol = sample::<SobolSequence>(1 << 11, scrambling, index);
            for m in 0..=11 {
                assert!(sobol.chunks(1 << m).all(|block| net_parameter(block) == Some(0)), "{m}");
                let hammersley = sample::<Hammersley>(1 << m, scrambling, index);
                assert_eq!(net_parameter(&hammersley), Some(0), "{m}");
            }
        }
    }
}

#[test]
fn scrambled_halton_points_have_their_strata() {
    for scrambling in RANDOM {
        for index in 0..4 {
            let points = sample::<Halton>(1 << 11, scrambling, index);
            for (a, b) in (0..12).flat_map(|a| (0..7).map(move |b| (1 << a, 3_usize.pow(b)))) {
                for block in points.chunks_exact(a * b) {
                    assert!(is_stratified(block, a, b), "{scrambling:?}, {a} x {b}");
                }
            }
        }
    }
}

/// Returns the first `count` digits of a coordinate, which is known to about half of the last bit.
fn digits(x: f64, base: u32, count: usize) -> Vec<u32> {
    let mut rest = x;
    let mut digit = || {
        rest *= f64::from(base);
        let digit = (1..base).filter(|&d| rest >= f64::from(d)).count();
        rest -= digit as f64;
        u32::try_from(digit).unwrap()
    };
    (0..count).map(|_| digit()).collect()
}

/// Nested uniform scrambling by its definition: a tree of permutations by the digits that precede.
#[derive(Default)]
struct Tree(HashMap<Vec<u32>, Vec<u32>>);

impl Tree {
    fn scramble(&mut self, digits: &[u32], base: u32, rng: &mut dyn Rng) -> Vec<u32> {
        let place = |k: usize| {
            let permutation = self.0.entry(digits[..k].to_vec()).or_insert_with(|| {
                let mut left: Vec<u32> = (0..base).collect();
                (0..base).map(|_| left.swap_remove(rng.random_range(0..left.len()))).collect()
            });
            permutation[digits[k] as usize]
        };
        (0..digits.len()).map(place).collect()
    }
}

type Boxed = Box<dyn SquareSampler>;

/// The patterns without and with nested scrambling, with the bases of their coordinates.
fn owen(n: usize) -> [(Boxed, Boxed, [u32; 2]); 3] {
    fn pair<P: ScrambledPattern>(n: usize) -> [Boxed; 2] {
        [Scrambling::None, Scrambling::Owen]
            .map(|scrambling| Box::new(P::scrambled(n, scrambling).unwrap()) as Boxed)
    }
    [
        (pair::<SobolSequence>(n), [2, 2]),
        (pair::<Halton>(n), [2, 3]),
        (pair::<Hammersley>(n), [2, 2]),
    ]
    .map(|([plain, scrambled], bases)| (plain, scrambled, bases))
}

/// A scrambling is nested if two points have as many first digits in common after it as before.
#[test]
fn scrambled_points_share_their_first_digits() {
    for n in [1, 2, 3, 64, 81, 100, 243] {
        for (plain, scrambled, bases) in owen(n) {
            let before = plain.sample(&mut rng(0)).unwrap().points;
            for index in 0..3 {
                let after = scrambled.sample(&mut rng(index)).unwrap().points;
                for d in 0..2 {
                    // The first coordinate of Hammersley points in base 2 needs not end.
                    let of = |points: &[[f64; 2]]| -> Vec<Vec<u32>> {
                        let count = if bases[d] == 2 { 12 } else { 8 };
                        points.iter().map(|p| digits(p[d] + 1e-14, bases[d], count)).collect()
                    };
                    let [before, after] = [of(&before), of(&after)];
                    let common = |all: &[Vec<u32>], i: usize, j: usize| {
                        all[i].iter().zip(&all[j]).take_while(|(a, b)| a == b).count()
                    };
                    for (i, j) in (0..n).flat_map(|i| (0..i).map(move |j| (i, j))) {
                        let [a, b] = [common(&before, i, j), common(&after, i, j)];
                        assert_eq!(a, b, "{scrambled:?}, {i}, {j}");
                    }
                }
            }
        }
    }
}

/// The joint distributions of pairs of scrambled coordinates are those of the tree of permutations.
#[test]
fn scrambled_points_have_the_distribution_of_the_definition() {
    const M: u64 = 4000;
    // Points that share no digit, some digits and all that the bins resolve.
    const PAIRS: [(usize, usize); 6] = [(0, 1), (0, 2), (1, 3), (3, 12), (2, 17), (5, 23)];
    for (plain, scrambled, bases) in owen(27) {
        let unscrambled = plain.sample(&mut rng(0)).unwrap().points;
        for d in 0..2 {
            let (base, places) = (bases[d], if bases[d] == 2 { 3 } else { 2 });
            let side = base.pow(places) as usize;
            let mut counts = vec![[vec![0.0; side * side], vec![0.0; side * side]]; PAIRS.len()];
            let bin = |digits: &[u32]| {
                digits.iter().take(places as usize).fold(0, |sum, digit| sum * base + digit)
                    as usize
            };
            for index in 0..M {
                let fast = scrambled.sample(&mut rng(index)).unwrap().points;
                let (mut tree, mut stream) = (Tree::default(), rng(M + index));
                let slow: Vec<usize> = unscrambled
                    .iter()
                    .map(|p| bin(&tree.scramble(&digits(p[d] + 1e-14, base, 3), base, &mut stream)))
                    .collect();
                for (counts, (i, j)) in counts.iter_mut().zip(PAIRS) {
                    let of = |i: usize| bin(&digits(fast[i][d], base, 3));
                    counts[0][side * of(i) + of(j)] += 1.0;
                    counts[1][side * slow[i] + slow[j]] += 1.0;
                }
            }
            for ([fast, slow], pair) in counts.iter().zip(PAIRS) {
                let seen = fast.iter().zip(slow).filter(|(a, b)| **a + **b > 0.0);
                let (bins, chi2) = seen.fold((0.0, 0.0), |(bins, chi2), (a, b): (&f64, &f64)| {
                    (bins + 1.0, chi2 + (a - b).powi(2) / (a + b))
                });
                // Wilson and Hilferty 1931: normal beyond 5 in 3e-7 of seeds each, 1e-5 of all 36.
                let dof: f64 = bins - 1.0;
                let variance = 2.0 / (9.0 * dof);
                let z = ((chi2 / dof).cbrt() - (1.0 - variance)) / variance.sqrt();
                assert!(z < 5.0, "{scrambled:?}, coordinate {d}, {pair:?}: {chi2} of {dof}");
            }
        }
    }
}

/// Flips of binary digits are the bits of the first point with the same preceding digits, by a search
/// through all points before: the numbers of the square's `sobol`.
#[test]
fn binary_flips_come_from_the_first_point_with_the_same_digits() {
    const N: usize = 300;
    for (plain, scrambled) in
        [owen(N).map(|(plain, scrambled, _)| (plain, scrambled)).into_iter().next().unwrap(), {
            let hammersley = |scrambling| Hammersley::scrambled(N, scrambling).unwrap();
            let [plain, scrambled] = [Scrambling::None, Scrambling::Owen].map(hammersley);
            (Box::new(plain) as Boxed, Box::new(scrambled) as Boxed)
        }]
    {
        let before = plain.sample(&mut rng(7)).unwrap().points;
        let after = scrambled.sample(&mut rng(7)).unwrap().points;
        let mut stream = rng(7);
        let words: Vec<[u64; 2]> = (0..N).map(|_| [stream.next_u64(), stream.next_u64()]).collect();
        for (i, d) in (0..N).flat_map(|i| [(i, 0), (i, 1)]) {
            let all: Vec<Vec<u32>> = before.iter().map(|p| digits(p[d], 2, 40)).collect();
            let mut expected = 0.0;
            for level in 0..40 {
                let first = (0..=i).find(|&j| all[j][..level] == all[i][..level]).unwrap();
                // The first point itself has the bit of its word; others flip as it does.
                let flip = u64::from(all[first][level]) ^ words[first][d] >> (63 - level) & 1;
                let digit = u64::from(all[i][level]) ^ flip;
                expected += digit as f64 * 0.5_f64.powi(i32::try_from(level).unwrap() + 1);
            }
            let off = after[i][d] - expected;
            assert!((0.0..0.5_f64.powi(39)).contains(&off), "{scrambled:?}, {i}, {d}: {off}");
        }
    }
}

/// A digital shift adds the same number without carry.
#[test]
fn digital_shifts_add_the_same_digits_to_all_points() {
    fn check<P: ScrambledPattern>(bases: [u32; 2]) {
        const N: usize = 243;
        let before = sample::<P>(N, Scrambling::None, 0);
        for index in 0..3 {
            let after = sample::<P>(N, Scrambling::Digital, index);
            for (d, base) in bases.into_iter().enumerate() {
                let difference = |i: usize| -> Vec<u32> {
                    // Fifth digits are exact, although thirds are rounded.
                    let [p, q] = [before[i][d] + 1e-14, after[i][d]].map(|x| digits(x, base, 5));
                    q.iter().zip(p).map(|(q, p)| (q + base - p) % base).collect()
                };
                for i in 1..N {
                    assert_eq!(difference(i), difference(0), "{index}, {i}, coordinate {d}");
                }
            }
        }
    }
    check::<SobolSequence>([2, 2]);
    check::<Halton>([2, 3]);
    check::<Hammersley>([2, 2]);
}

/// Every single point is uniform in the square.
#[test]
fn scrambled_points_are_uniform() {
    const M: u64 = 3600;
    const SIDE: usize = 6;
    const POINTS: [usize; 7] = [0, 1, 2, 5, 26, 27, 80];
    let texts = ["sobol", "halton", "hammersley"]
        .into_iter()
        .flat_map(|name| ["digital", "owen"].map(|kind| format!("{name}:randomization={kind}")));
    for text in texts.chain(["pmj02".to_owned()]) {
        let sampler = text.parse::<SquarePattern>().unwrap().build(81).unwrap();
        let mut counts = [[0.0; SIDE * SIDE]; POINTS.len()];
        for index in 0..M {
            let points = sampler.sample(&mut rng(index)).unwrap().points;
            for (counts, i) in counts.iter_mut().zip(POINTS) {
                let part = |x: f64| (1..SIDE).filter(|k| SIDE as f64 * x >= *k as f64).count();
                counts[SIDE * part(points[i][0]) + part(points[i][1])] += 1.0;
            }
        }
        let expected = M as f64 / (SIDE * SIDE) as f64;
        for (counts, i) in counts.iter().zip(POINTS) {
            let chi2: f64 = counts.iter().map(|c| (c - expected).powi(2) / expected).sum();
            // 35 degrees of freedom: beyond 95 in 2.6e-7 of seeds, 1.3e-5 of all 49.
            assert!(chi2 < 95.0, "{text}: point {i}, {chi2}");
        }
    }
}
