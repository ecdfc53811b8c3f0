//! Expensive figures composed from a few sets: the results are not tested, but the content must be
//! complete and drawable.

use std::collections::HashSet;

use sphvar_samplers::SECONDS_PER_WORK;

use crate::{
    Claim, Content, Curves, Error, Figure, FigureId, Job, NoStore, Picture, Pictures, Results,
    Scale, Setting, Stated, Verdict, run, work,
};

const QUICK: Setting = Setting { scale: Scale::Quick, seed: 0 };
const FULL: Setting = Setting { scale: Scale::Full, seed: 0 };
/// Figures of chapters 5 and 6, of variances and scenes, and of the appendix.
const FIGURES: [&str; 13] =
    ["4.13", "5.1", "6.1", "6.2", "6.3", "7.4", "7.5", "7.6", "7.7", "7.8", "7.9", "7.10", "C.1"];

/// Returns the job with few sets, which is fast but still gives all standard errors: bounds of a
/// spectrum need more sets than variances.
fn cut(job: &Job) -> Job {
    match job.clone() {
        Job::Spectrum { ensemble, domain, lmax, sets } => {
            let sets = sets.min(if lmax == super::spectra::LMAX { 14 } else { 3 });
            Job::Spectrum { ensemble, domain, lmax, sets }
        }
        Job::Trials { ensemble, sets } => {
            // A single point misses the cap in three trials of four: all of 60 miss with
            // probability 1/3e7.
            let sets = sets.min(if ensemble.n_points < 100 { 60 } else { 6 });
            Job::Trials { ensemble, sets }
        }
        Job::Pictures(pictures) => Job::Pictures(Pictures {
            n_points: 24,
            side: 24,
            renders: pictures.renders.min(2),
            ..pictures
        }),
        job => job,
    }
}

/// Results of reduced jobs in place of those of complete ones.
pub(super) fn results_of(jobs: &[Job], cut: fn(&Job) -> Job) -> Result<Results, Error> {
    let cut: Vec<Job> = jobs.iter().map(cut).collect();
    let mut few = Results::new(QUICK);
    run(&cut, &NoStore, &mut few, &())?;
    let mut results = Results::new(QUICK);
    for (job, cut) in jobs.iter().zip(&cut) {
        results.take_over(job, &few, cut);
    }
    Ok(results)
}

pub(super) fn check_curves(curves: &Curves, place: &str) {
    assert!(!curves.curves.is_empty(), "{place}: no curves");
    for curve in &curves.curves {
        let place = format!("{place}, {}", curve.label);
        assert!(curve.points.len() > 1, "{place}: {} points", curve.points.len());
        assert!(curve.points.is_sorted_by(|a, b| a[0] < b[0]), "{place}: x must grow");
        for &[x, y, error] in &curve.points {
            assert!(x.is_finite() && y.is_finite() && error >= 0.0, "{place}: {x}, {y}, {error}");
            assert!(!curves.x.logarithmic || x > 0.0, "{place}: log of x = {x}");
            assert!(!curves.y.logarithmic || y > 0.0, "{place}: log of y = {y}");
        }
    }
}

pub(super) fn check_picture(picture: &Picture, place: &str) {
    assert_eq!(picture.values.len(), picture.size[0] * picture.size[1], "{place}: size");
    assert!(picture.values.iter().all(|v| (0.0..=1.0).contains(v)), "{place}: not a share");
    assert!(picture.values.iter().any(|v| *v > 0.1), "{place}: black");
    assert!(picture.caption.contains("N = "), "{place}: {}", picture.caption);
}

/// Every outcome has the value that determines it, with its interval.
pub(super) fn check_claim(claim: &Claim, id: &str) {
    let outcomes = match &claim.choice {
        Some(choice) => choice.options.iter().map(|o| (o.measured, o.verdict)).collect(),
        None => vec![(claim.measured, claim.verdict)],
    };
    for (measured, verdict) in outcomes {
        let Some(measured) = measured else {
            assert_ne!(verdict, Verdict::Holds, "{id}: {claim:?}");
            continue;
        };
        let (low, high) = measured.interval;
        let within = low <= measured.value && measured.value <= high;
        // A single random number in words.
        let single = low.is_nan() && matches!(claim.stated, Stated::Words(_));
        assert!(within || single || verdict == Verdict::Undecided, "{id}: {claim:?}");
    }
}

fn check(figure: &Figure) {
    let id = figure.id;
    assert!(!figure.panels.is_empty(), "{id}");
    let mut names = HashSet::new();
    for panel in &figure.panels {
        let place = format!("{id}, {}", panel.name);
        let safe = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        assert!(!panel.name.is_empty() && panel.name.chars().all(safe), "{place}");
        assert!(names.insert(panel.name.clone()), "{place} is there twice");
        match &panel.content {
            Content::Curves(curves) => check_curves(curves, &place),
            Content::Picture(picture) => check_picture(picture, &place),
            other => panic!("{place}: {other:?}"),
        }
    }
    let mut claims = HashSet::new();
    for claim in &figure.claims {
        assert!(claims.insert(claim.what.clone()), "{id}: \"{}\" is there twice", claim.what);
        assert_ne!(claim.stated, Stated::Words(""), "{id}: {claim:?}");
        check_claim(claim, id.number());
    }
}

#[test]
#[ignore = "slow"]
fn every_figure_can_be_composed() -> Result<(), Error> {
    let ids: Result<Vec<FigureId>, Error> = FIGURES.iter().map(|name| name.parse()).collect();
    let ids = ids?;
    let jobs: Vec<Job> = ids.iter().flat_map(|id| id.jobs(QUICK)).collect();
    let results = results_of(&jobs, cut)?;
    for id in ids {
        let figure = id.compose(&results)?;
        check(&figure);
        // 4096 strata do not exist, whatever the sets.
        let count = figure.claims.iter().find(|claim| claim.erratum == Some(38));
        let expected = (id.number() == "7.4").then_some(Verdict::Wrong);
        assert_eq!(count.map(|claim| claim.verdict), expected, "{id}: {count:?}");
        let missing = id.compose(&Results::new(QUICK));
        assert_eq!(missing.is_ok(), id.jobs(QUICK).is_empty(), "{id}");
    }
    Ok(())
}

/// Verdicts that follow from closed forms and exact spectra alone.
#[test]
fn claims_about_closed_forms_have_their_verdicts() -> Result<(), Error> {
    for (number, wrong) in [
        ("5.1", vec![]),
        ("6.1", vec![]),
        (
            "C.1",
            vec![
                "constant of C.20 in the norm of the variance formula 5.18",
                "power of degree 0, bound C.26",
            ],
        ),
    ] {
        let id: FigureId = number.parse()?;
        for claim in id.compose(&Results::new(QUICK))?.claims {
            let expected = wrong.contains(&claim.what.as_str());
            let verdict = if expected { Verdict::Wrong } else { Verdict::Holds };
            assert_eq!(claim.verdict, verdict, "{number}: {claim:?}");
        }
    }
    Ok(())
}

/// Seven minutes of one core for these figures in a quick run, and forty at the thesis's numbers.
#[test]
fn the_work_is_affordable() -> Result<(), Error> {
    for (setting, max_seconds) in [(QUICK, 420.0), (FULL, 2400.0)] {
        let ids: Result<Vec<FigureId>, Error> = FIGURES.iter().map(|name| name.parse()).collect();
        let jobs: Vec<Job> = ids?.iter().flat_map(|id| id.jobs(setting)).collect();
        let took = SECONDS_PER_WORK * work(&jobs);
        assert!(
            took > 0.3 * max_seconds && took < max_seconds,
            "{:?}: {took} seconds",
            setting.scale
        );
    }
    Ok(())
}
