//! Patterns of which every prefix is a set of the pattern: heads of realizations.

use sphvar_samplers::grammar::{Parameter, ParameterKind};
use sphvar_samplers::{
    Domain, Pattern, Purpose, Realizations, SquarePattern, SquareRealizations, Streams,
};

pub(crate) const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

/// Numbers of points around those at which strata are complete: powers of 2 and 3, and multiples of
/// the twelve faces of HEALPix.
const COUNTS: [usize; 17] = [1, 2, 3, 4, 5, 7, 11, 12, 13, 26, 27, 31, 49, 81, 128, 191, 243];
const MAX: usize = 250;

/// Returns the texts of a pattern with every combination of its choices of names.
pub(crate) fn combinations(name: &str, parameters: &[Parameter]) -> Vec<String> {
    let mut all = vec![Vec::new()];
    for parameter in parameters {
        let ParameterKind::Choice(values) = &parameter.kind else { continue };
        // A colour excludes other parameters.
        if parameter.name == "colour" {
            continue;
        }
        let with = |items: &Vec<String>| -> Vec<Vec<String>> {
            let of = |value: &&str| {
                let mut items = items.clone();
                items.push(format!("{}={value}", parameter.name));
                items
            };
            values.iter().map(of).collect()
        };
        all = all.iter().flat_map(with).collect();
    }
    let text = |items: Vec<String>| {
        if items.is_empty() { name.to_owned() } else { format!("{name}:{}", items.join(",")) }
    };
    all.into_iter().map(text).collect()
}

/// Returns the built-in patterns of the sphere with all combinations of their choices.
pub(crate) fn patterns() -> Vec<Pattern> {
    let of = |pattern: Pattern| combinations(pattern.name(), &pattern.parameters());
    let others = ["best-candidate:factor=3"].map(str::to_owned);
    let texts = Pattern::ALL.into_iter().flat_map(of).chain(others);
    texts.map(|text| text.parse().unwrap()).collect()
}

/// Returns the built-in patterns of the square with all combinations of their choices.
pub(crate) fn square_patterns() -> Vec<SquarePattern> {
    let of = |pattern: SquarePattern| combinations(pattern.name(), &pattern.parameters());
    SquarePattern::ALL.into_iter().flat_map(of).map(|text| text.parse().unwrap()).collect()
}

#[test]
fn heads_of_sequences_are_equal_on_the_sphere() {
    let mut sequences = 0;
    for pattern in patterns() {
        let group = pattern.sequence_group();
        assert_eq!(group.is_some(), pattern.facts().is_extensible, "{pattern}");
        let Some(group) = group else { continue };
        sequences += 1;
        for domain in DOMAINS {
            let longest = pattern.build(MAX, domain).unwrap();
            assert_eq!(longest.sequence_group(), Some(group), "{pattern}");
            for seed in [0, 1, 977] {
                let streams = Streams::new(seed, Purpose::Pattern, group);
                let draw = |n: usize, is_rotated: bool| {
                    let sampler = pattern.build(n, domain).unwrap();
                    let sets = if is_rotated {
                        Realizations::rotated(&*sampler, streams)
                    } else {
                        Realizations::unrotated(&*sampler, streams)
                    };
                    sets.realize(seed).unwrap().points
                };
                for is_rotated in [true, false] {
                    let all = draw(MAX, is_rotated);
                    for n in COUNTS {
                        assert_eq!(draw(n, is_rotated), all[..n], "{pattern} on the {domain}");
                    }
                }
            }
        }
    }
    // White noise, two kinds of best candidates, sobol and halton (12 each), r2 (6), pmj02 (3).
    assert!(sequences >= 36, "{sequences}");
}

#[test]
fn heads_of_sequences_are_equal_on_the_square() {
    let mut sequences = Vec::new();
    for pattern in square_patterns() {
        let group = pattern.sequence_group();
        assert_eq!(group.is_some(), pattern.facts().is_extensible, "{pattern}");
        let Some(group) = group else { continue };
        sequences.push(pattern.to_string());
        assert_eq!(pattern.build(MAX).unwrap().sequence_group(), Some(group), "{pattern}");
        for seed in [0, 1, 977] {
            let streams = Streams::new(seed, Purpose::Pattern, group);
            let draw = |n: usize, is_shifted: bool| {
                let sampler = pattern.build(n).unwrap();
                let sets = if is_shifted {
                    SquareRealizations::shifted(&*sampler, streams)
                } else {
                    SquareRealizations::unshifted(&*sampler, streams)
                };
                sets.realize(seed).unwrap().points
            };
            for is_shifted in [true, false] {
                let all = draw(MAX, is_shifted);
                for n in COUNTS {
                    assert_eq!(draw(n, is_shifted), all[..n], "{pattern}");
                }
            }
        }
    }
    for text in ["white-square", "r2", "pmj02", "sobol:randomization=digital", "halton"] {
        assert!(sequences.iter().any(|sequence| sequence == text), "{text}");
    }
}

/// Realizations of a sequence at different numbers of points share no numbers in other commands.
#[test]
fn sets_of_different_numbers_of_points_are_independent() {
    for pattern in patterns().iter().filter(|pattern| pattern.facts().is_extensible) {
        let groups = [1, 2, 3, 64].map(|n| pattern.stream_group(n));
        let sequence = pattern.sequence_group().unwrap();
        for (i, group) in groups.iter().enumerate() {
            assert!(*group != sequence && !groups[..i].contains(group), "{pattern}");
        }
    }
}
