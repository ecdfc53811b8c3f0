//! Patterns of the square: ensembles, given sets and the list of names.

use std::path::Path;

use proptest::prelude::*;
use rand::Rng;
use sphvar_samplers::grammar::ResolveError;
use sphvar_samplers::{
    Ensemble, Error, FileResolver, PointFile, PointFileParameters, PointSet, PointSets,
    ProfileTable, Purpose, SamplerFamily, Square, SquareDistribution, SquarePattern,
    SquarePointFileParameters, SquareRealizations, SquareSampler, Streams, uniform_shift,
};

fn streams(group: usize) -> Streams {
    Streams::new(11, Purpose::Pattern, group)
}

fn build(pattern: &SquarePattern, requested: usize) -> Box<dyn SquareSampler> {
    pattern.build(pattern.nearest_count(requested)).unwrap()
}

/// The points of a realization, always the same.
#[derive(Debug)]
struct Given(PointSet<[f64; 2]>);

impl SquareSampler for Given {
    fn n_points(&self) -> usize {
        self.0.len()
    }

    fn sample_into(&self, _: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        set.clone_from(&self.0);
        Ok(())
    }
}

#[test]
fn every_pattern_meets_the_contract() {
    for pattern in SquarePattern::ALL {
        for requested in [1, 2, 3, 4, 7, 16, 31, 64, 100] {
            let sampler = build(&pattern, requested);
            let n = pattern.nearest_count(requested);
            assert_eq!(sampler.n_points(), n, "{pattern}");
            assert_eq!(sampler.stream_group(), pattern.stream_group(n), "{pattern}");
            let mut set = PointSet { points: vec![[f64::NAN; 2]; 7], weights: vec![2.0; 7] };
            let rng = |index| streams(1).realization(index);
            sampler.sample_into(&mut rng(1), &mut set).unwrap();
            assert_eq!((set.points.len(), set.weights.len()), (n, 0), "{pattern}");
            let coordinates = set.points.as_flattened();
            assert!(coordinates.iter().all(|x| (0.0..1.0).contains(x)), "{pattern} N = {n}");
            assert_eq!(set, sampler.sample(&mut rng(1)).unwrap(), "{pattern} N = {n}");
            let other = sampler.sample(&mut rng(2)).unwrap();
            assert_eq!(set != other, sampler.is_random(), "{pattern} N = {n}");
        }
    }
}

/// The shift comes from a stream of its own, so that the unshifted ensemble has the same sets.
#[test]
fn shifted_realizations_are_the_unshifted_ones_after_the_shift() {
    for pattern in SquarePattern::ALL {
        let sampler = build(&pattern, 64);
        let shifted = SquareRealizations::shifted(&*sampler, streams(2));
        let unshifted = SquareRealizations::unshifted(&*sampler, streams(2));
        for index in [0, 1, 9] {
            let by = shifted.shift(index);
            let drawn = uniform_shift(&mut streams(2).randomization(index));
            let shifts = [drawn, [0.0; 2]];
            assert_eq!(shifts.as_slice(), [by, unshifted.shift(index)]);
            let expected = unshifted.realize(index).unwrap().points;
            let got = shifted.realize(index).unwrap().points;
            for (p, q) in expected.iter().zip(&got) {
                for d in 0..2 {
                    let off = (q[d] - p[d] - by[d]).rem_euclid(1.0);
                    assert!(off.min(1.0 - off) < 4.0 * f64::EPSILON, "{pattern}: {p:?}, {q:?}");
                    assert!((0.0..1.0).contains(&q[d]), "{pattern}: {q:?}");
                }
            }
            assert_ne!([by].as_slice(), [shifted.shift(index + 1)]);
        }
    }
}

/// A faulty user-defined sampler causes an error, never a result.
#[test]
fn an_invalid_realization_is_an_error() {
    let set = |points: &[[f64; 2]], weights: &[f64]| PointSet {
        points: points.to_vec(),
        weights: weights.to_vec(),
    };
    let p = [0.5; 2];
    for (given, expected) in [
        (set(&[], &[]), "no points"),
        (set(&[p, [0.0, 1.0]], &[]), "coordinates outside [0, 1) at point 1"),
        (set(&[[-1e-300, 0.0], p], &[]), "outside [0, 1) at point 0"),
        (set(&[p, [f64::NAN, 0.0]], &[]), "outside [0, 1) at point 1"),
        (set(&[p, p], &[1.0]), "2 points and 1 weights"),
        (set(&[p, p], &[1.0, f64::INFINITY]), "not finite at point 1"),
        (set(&[p, p], &[1e200, -1e200]), "sum is 0"),
    ] {
        let sampler = Given(given);
        for sets in [
            SquareRealizations::shifted(&sampler, streams(0)),
            SquareRealizations::unshifted(&sampler, streams(0)),
        ] {
            let error = sets.realize(0).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}

#[test]
fn given_sets_are_a_sampler_an_ensemble_and_a_family() {
    let set = |x: f64, weights: &[f64]| PointSet {
        points: vec![[x, 0.0], [0.25, 1.0 - f64::EPSILON / 2.0]],
        weights: weights.to_vec(),
    };
    let given = vec![set(0.0, &[]), set(0.5, &[1.0, -0.25])];
    let sets = PointSets::new(given.clone(), Square).unwrap().with_name("mine");
    assert_eq!((sets.to_string(), sets.sets()), ("mine".to_owned(), &given[..]));
    assert!(matches!(sets.distribution(), SquareDistribution::OneOf(all) if all.len() == 2));
    let mut buffer = PointSet::default();
    for (i, expected) in (0..).zip(&given) {
        sets.realize_into(i, &mut buffer, &()).unwrap();
        assert_eq!(buffer, *expected);
    }
    assert!(sets.realize_into(2, &mut buffer, &()).is_err());
    let family: &dyn SamplerFamily<Square> = &sets;
    assert_eq!((family.nearest_count(99, Square), family.nearest_count(1, Square)), (2, 2));
    let error = family.build(3, Square).unwrap_err().to_string();
    assert!(error.contains("on the square") && error.contains("count is 2"), "{error}");
    let sampler = family.build(2, Square).unwrap();
    let drawn = SquareRealizations::unshifted(&*sampler, streams(4));
    // Each of 2 sets is missing from 64 draws with probability 2^-64.
    for expected in &given {
        assert!((0..64).any(|i| drawn.realize(i).unwrap() == *expected));
    }
    for (points, expected) in [
        (vec![[0.0, 1.0]], "coordinates outside [0, 1) at point 0"),
        (vec![[0.0, 0.0], [f64::NAN, 0.0]], "outside [0, 1) at point 1"),
        (vec![], "no points"),
    ] {
        let error = PointSets::new(vec![PointSet::new(points)], Square).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn names_are_read_and_counts_are_checked() {
    for pattern in SquarePattern::ALL {
        assert_eq!(pattern.to_string().parse::<SquarePattern>(), Ok(pattern.clone()));
        assert_eq!(pattern.name(), pattern.to_string());
        let rejected = pattern.build(0).unwrap_err();
        assert_eq!(rejected, Error::NoPoints { pattern: pattern.to_string() });
        for n in [usize::MAX, usize::MAX / 12, 1 << 62] {
            let _ = pattern.build(n);
        }
        let family: &dyn SamplerFamily<Square> = &pattern;
        assert_eq!(family.nearest_count(1000, Square), pattern.nearest_count(1000));
        let facts = pattern.facts();
        assert!(!facts.source.is_empty() && !pattern.summary().is_empty(), "{pattern}");
    }
    let error = "jitered-square".parse::<SquarePattern>().unwrap_err().to_string();
    assert!(error.contains("did you mean \"jittered-square\""), "{error}");
    let error = SquarePattern::JitteredSquare.build(70).unwrap_err().to_string();
    assert!(error.contains("on the square: N must be") && error.contains("is 64"), "{error}");
}

/// One file, or two for a template; their points are invalid if the name contains `outside`.
struct Files;

impl FileResolver for Files {
    fn profile(&self, _: &Path) -> Result<ProfileTable, ResolveError> {
        Err(ResolveError::new("no profile"))
    }

    fn points(&self, _: &PointFileParameters) -> Result<Vec<PointFile>, ResolveError> {
        Err(ResolveError::new("no directions"))
    }

    fn square_points(
        &self,
        source: &SquarePointFileParameters,
    ) -> Result<Vec<PointFile<[f64; 2]>>, ResolveError> {
        let name = source.file().display().to_string();
        let x = if name.contains("outside") { 1.0 } else { 0.5 };
        let file = |n: usize| PointFile {
            name: name.clone(),
            stated_count: name.contains("{n}").then_some(n),
            sets: vec![PointSet::new(vec![[x, 0.25]; n])],
            starts: vec![name.clone()],
            first_below: None,
        };
        Ok(if name.contains("{n}") { vec![file(3), file(2)] } else { vec![file(5)] })
    }
}

#[test]
fn files_are_patterns_with_the_numbers_of_points_of_their_sets() {
    let parse = |text: &str| SquarePattern::parse(text, &Files);
    let one = parse("file:a/b.csv,columns=\"u,v\"").unwrap();
    assert_eq!((one.own_count(), one.nearest_count(1)), (Some(5), 5));
    assert_eq!(one.label(), "file:b.csv,columns=\"u,v\"");
    let set = one.build(5).unwrap().sample(&mut streams(0).realization(0)).unwrap();
    assert_eq!(set.points, [[0.5, 0.25]; 5]);
    let error = one.build(4).unwrap_err().to_string();
    assert!(error.contains("N must be 5"), "{error}");
    let template = parse("file:set-{n}.csv").unwrap();
    assert_eq!((template.own_count(), template.nearest_count(9)), (None, 3));
    assert_ne!(template.stream_group(2), template.stream_group(3));
    let error = parse("file:outside.csv").unwrap_err().to_string();
    assert!(error.contains("outside.csv: set 0 has coordinates outside [0, 1)"), "{error}");
    let error = parse("file:a.csv,fold=yes").unwrap_err().to_string();
    assert!(error.contains("unknown parameter \"fold\""), "{error}");
    let error = "file:a.csv".parse::<SquarePattern>().unwrap_err().to_string();
    assert!(error.contains("needs a resolver"), "{error}");
}

proptest! {
    #[test]
    fn jittered_points_lie_in_their_cells(side in 1_usize..20, seed: u64) {
        let sampler = SquarePattern::JitteredSquare.build(side * side).unwrap();
        let mut rng = Streams::new(seed, Purpose::Pattern, 0).realization(0);
        let set = sampler.sample(&mut rng).unwrap();
        for (i, p) in set.points.iter().enumerate() {
            let corner = [i / side, i % side].map(|c| c as f64 / side as f64);
            for d in 0..2 {
                let off = p[d] - corner[d];
                prop_assert!(off >= -1e-15 && off <= 1.0 / side as f64 + 1e-15, "{i}: {p:?}");
            }
        }
    }
}
