//! The figures of chapters 3 and 4 and of the point sets: their content can be drawn, and claims
//! with known closed-form answers have the correct verdicts.

use std::collections::HashSet;
use std::sync::LazyLock;

use sphvar_samplers::SECONDS_PER_WORK;

use super::tests::{check_claim, check_curves, check_picture};
use crate::{
    Content, Directions, Field, Figure, FigureId, NoStore, Results, Scale, Setting, Verdict, run,
    work,
};

const QUICK: Setting = Setting { scale: Scale::Quick, seed: 0 };
const FULL: Setting = Setting { scale: Scale::Full, seed: 0 };
/// The figures composed here: all that take less than about a second of one core.
const FAST: [&str; 13] = [
    "3.1", "4.1", "4.2", "4.7", "4.9", "4.10", "4.11", "4.12", "4.15", "4.16", "7.1", "7.2", "7.3",
];
/// The figures composed from fewer sets in the tests next to their code.
const EXPENSIVE: [&str; 7] = ["2.2", "4.3", "4.4", "4.5", "4.6", "4.14", "4.17"];

/// The inexpensive figures, each composed once.
static FIGURES: LazyLock<Vec<Figure>> = LazyLock::new(|| {
    let ids: Vec<FigureId> = FAST.iter().map(|number| number.parse().unwrap()).collect();
    let jobs: Vec<_> = ids.iter().flat_map(|id| id.jobs(QUICK)).collect();
    let mut results = Results::new(QUICK);
    run(&jobs, &NoStore, &mut results, &()).unwrap();
    ids.iter().map(|id| id.compose(&results).unwrap()).collect()
});

fn figure(number: &str) -> &'static Figure {
    FIGURES.iter().find(|figure| figure.id.number() == number).unwrap()
}

fn check_directions(directions: &Directions, place: &str) {
    assert!(!directions.points.is_empty(), "{place}: no points");
    assert!(directions.viewpoint.length() > 0.5, "{place}: {}", directions.viewpoint);
    for p in directions.points.iter().chain(directions.lines.iter().flatten()) {
        // Unit vectors of any sampler, rotated once: some roundings.
        assert!((p.length() - 1.0).abs() < 16.0 * f64::EPSILON, "{place}: {p}");
    }
}

pub(super) fn check_square_points(points: &[[f64; 2]], place: &str) {
    assert!(!points.is_empty(), "{place}: no points");
    assert!(points.iter().flatten().all(|x| (0.0..1.0).contains(x)), "{place}: outside");
}

pub(super) fn check_field(field: &Field, place: &str) {
    assert_eq!(field.values.len(), field.size[0] * field.size[1], "{place}: size");
    assert!(field.values.iter().all(|v| !v.is_infinite()), "{place}: infinite");
    let shown = field.values.iter().filter(|v| v.is_finite()).count();
    assert!(3 * shown > field.values.len(), "{place}: {shown} values");
    let min = field.values.iter().copied().fold(f64::INFINITY, f64::min);
    let max = field.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert!(min < max, "{place}: all values are {min}");
    for axis in [&field.x, &field.y] {
        let (first, last) = axis.range.unwrap();
        assert!(first.is_finite() && (last - first).abs() > 0.0, "{place}: {axis:?}");
    }
}

#[test]
fn panels_can_be_drawn() {
    for number in FAST {
        let figure = figure(number);
        let mut names = HashSet::new();
        assert!(!figure.panels.is_empty(), "{number}");
        for panel in &figure.panels {
            let place = format!("{number} {}", panel.name);
            let safe = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
            assert!(!panel.name.is_empty() && panel.name.chars().all(safe), "{place}");
            assert!(names.insert(&panel.name), "{place}: twice");
            match &panel.content {
                Content::Curves(curves) => check_curves(curves, &place),
                Content::Directions(directions) => check_directions(directions, &place),
                Content::SquarePoints(set) => check_square_points(&set.points, &place),
                Content::Field(field) => check_field(field, &place),
                Content::Picture(picture) => check_picture(picture, &place),
            }
        }
        for claim in &figure.claims {
            check_claim(claim, number);
        }
    }
}

/// Verdicts that depend on no sampling, or so little that any seed gives the same.
#[test]
fn known_claims_have_their_verdicts() {
    use Verdict::{ByConstruction, Holds, Wrong};
    type Known = (&'static str, &'static [(Verdict, Option<u8>)]);
    const KNOWN: [Known; 10] = [
        (
            "3.1",
            &[(ByConstruction, None), (Wrong, Some(1)), (Wrong, Some(33)), (ByConstruction, None)],
        ),
        ("4.1", &[(Holds, None), (Holds, None)]),
        ("4.2", &[(Holds, None), (ByConstruction, None)]),
        ("4.7", &[(Holds, None), (Holds, None), (Holds, None), (ByConstruction, None)]),
        ("4.9", &[(ByConstruction, None), (Holds, None)]),
        (
            "4.10",
            &[
                (Holds, None),
                (Holds, None),
                (Wrong, Some(12)),
                (Holds, None),
                (Wrong, Some(9)),
                (Holds, None),
                (Holds, None),
                (Wrong, Some(9)),
            ],
        ),
        ("4.15", &[(Holds, None), (Holds, None), (Holds, None)]),
        ("7.1", &[(ByConstruction, None), (ByConstruction, None)]),
        ("7.2", &[(ByConstruction, None)]),
        ("7.3", &[(Holds, None), (ByConstruction, None)]),
    ];
    for (number, expected) in KNOWN {
        let figure = figure(number);
        let got: Vec<_> = figure.claims.iter().map(|c| (c.verdict, c.erratum)).collect();
        assert_eq!(got, expected, "{number}: {:#?}", figure.claims);
    }
}

/// Compares numbers of the claims of 4.10 with values of independent programs.
#[test]
fn lattices_have_their_recorded_peaks() {
    let figure = figure("4.10");
    let measured = |what: &str| {
        let claim = figure.claims.iter().find(|c| c.what.contains(what));
        claim.and_then(|c| c.measured).unwrap().value
    };
    for (what, recorded, unit) in [
        ("N P(2)", 0.309, 1e-3),
        ("HEALPix regular: the region", 30.2, 0.1),
        ("Fibonacci: the region", 7.96, 0.01),
        ("HEALPix regular: largest power for omega < 1", 9e-4, 1e-4),
        ("Fibonacci: largest power for omega < 1", 2.3e-4, 1e-5),
    ] {
        // Half a unit of the last recorded digit.
        let got = measured(what);
        assert!((got - recorded).abs() <= 0.5 * unit, "{what}: {got}");
    }
}

/// Compares with an independent program: direct sums over the points for every frequency.
#[test]
fn low_discrepancy_points_have_their_recorded_peaks() {
    let claims = &figure("4.7").claims;
    for (claim, recorded) in claims.iter().zip([0.322_351, 0.932_8, 0.022_1, 1.0]) {
        let got = claim.measured.unwrap().value;
        // Half a unit of the last recorded digit; Hammersley points are centred here.
        assert!((got - recorded).abs() < 1e-4, "{}: {got}", claim.what);
    }
}

/// Without a rotation the orders of a lattice would be unchanged.
#[test]
fn rotations_level_the_orders() {
    for number in ["4.11", "4.12", "4.16"] {
        let figure = figure(number);
        let unchanged = &figure.claims[0];
        assert_eq!(unchanged.verdict, Verdict::ByConstruction, "{number}: {unchanged:?}");
        // Differences are judged wrong with a probability of 1e-4; the seed is fixed.
        assert_ne!(figure.claims[1].verdict, Verdict::Wrong, "{number}: {:?}", figure.claims[1]);
        let brightest = |name: &str| {
            let panel = figure.panels.iter().find(|p| p.name == name).unwrap();
            let Content::Field(field) = &panel.content else { panic!("{name} is not a field") };
            field.values.iter().copied().fold(0.0, f64::max)
        };
        let (before, after) = (brightest("power-0"), brightest("power-1000"));
        assert!(after < before / 10.0, "{number}: {before} becomes {after}");
    }
}

/// The modelled cost of these figures: the budgets of a quick and of a full run.
#[test]
fn jobs_stay_within_the_budget() {
    let all = |setting| -> Vec<_> {
        let ids = FAST.iter().chain(&EXPENSIVE).map(|number| number.parse::<FigureId>().unwrap());
        ids.flat_map(|id| id.jobs(setting)).collect()
    };
    let [quick, full] = [QUICK, FULL].map(|setting| SECONDS_PER_WORK * work(&all(setting)));
    assert!(quick < 150.0, "{quick} s");
    assert!(full < 1500.0, "{full} s");
}
