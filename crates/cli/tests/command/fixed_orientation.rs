//! `variance --no-rotate`: errors of patterns in their own orientation.

use std::f64::consts::PI;

use crate::outcome::{assert_keys, same};
use crate::workplace::Workplace;

#[test]
fn a_harmonic_about_the_axis_of_the_cells() {
    let place = Workplace::new();
    let run = "variance jittered,healpix -n 768 --integrand ylm:l=4,m=0 -m 100 --no-rotate --json";
    let document = place.run(run).json();
    let rows = document["rows"].as_array().unwrap();
    let wanted = [
        "sampler",
        "integrand",
        "n",
        "varied",
        "trials",
        "signed_error",
        "mean_error",
        "mean_error_stderr",
        "predicted",
        "predicted_stderr",
        "predicted_method",
        "predicted_diagonal",
        "predicted_rotated",
        "measured",
        "measured_stderr",
        "z",
        "standard_deviation",
        "predicted_standard_deviation",
        "error_q05",
        "error_q50",
        "error_q95",
        "worst_error",
        "exact",
    ];
    rows.iter().for_each(|row| assert_keys(row, &wanted));
    let number = |row: usize, key: &str| rows[row][key].as_f64();
    // Theory, erratum 11.
    let ratio = number(0, "predicted").unwrap() / number(0, "predicted_rotated").unwrap();
    assert!((ratio - 1.1156).abs() < 1e-4, "{ratio}");
    assert!(number(0, "signed_error").is_none() && number(0, "mean_error").is_some());
    assert_eq!(
        (&rows[0]["varied"], &rows[1]["varied"]),
        (&"realization".into(), &"orientation".into())
    );
    // One set: its predicted variance is that of its orientations.
    assert!(same(number(1, "predicted").unwrap(), number(1, "predicted_rotated").unwrap()));
    assert!(number(1, "signed_error").is_some() && number(1, "mean_error").is_none());
    assert!(number(1, "error_q05").unwrap() < number(1, "error_q95").unwrap());
}

/// The signed error of a set is that of its points, and the forms of the result agree.
#[test]
fn the_signed_error_is_that_of_the_points() {
    let place = Workplace::new();
    place.run("sample fibonacci -n 50 -o p.csv").ok();
    let heights = place.text("p.csv");
    let heights = heights.lines().filter(|line| !line.starts_with(['#', 'x']));
    let cosines = heights.map(|line| line.rsplit(',').next().unwrap().parse::<f64>().unwrap());
    let sum: f64 = cosines.map(|z| z.max(0.0)).sum();
    let run = "variance fibonacci -n 50 --integrand cosine -m 40 --no-rotate";
    let document = place.run(&format!("{run} --json -o rows.csv")).json();
    let got = document["rows"][0]["signed_error"].as_f64().unwrap();
    let expected = 4.0 * PI / 50.0 * sum - PI;
    assert!((got - expected).abs() < 1e-13, "{got}, {expected}");
    let csv = place.text("rows.csv");
    assert!(csv.lines().nth(1).unwrap().contains("signed_error"), "{csv}");
    let table = place.run(run).ok().stdout;
    assert!(table.contains("worst") && table.contains("orientations"), "{table}");
    place.run(&format!("{run} -o errors.svg")).ok();
    assert!(place.text("errors.svg").contains("Errors without rotation"));
}

#[test]
fn settings_that_need_rotation_are_rejected() {
    let place = Workplace::new();
    let run = "variance jittered -n 24 --hemisphere --integrand cosine --no-rotate";
    place.run(&format!("{run} --until-rel 5%")).fails(2, &["--until-rel"]);
    place.run(&format!("{run} --visible-half")).fails(2, &["--visible-half"]);
}

#[test]
fn results_do_not_depend_on_threads() {
    let place = Workplace::new();
    let run = "variance jittered,poisson-disk,spiral -n 48 --integrand cap:degrees=50 --no-rotate";
    let few = "-m 30 --spectrum-realizations 100 --json";
    let rows = |threads| place.run(&format!("{run} {few} -j {threads}")).json()["rows"].clone();
    assert_eq!(rows(1), rows(3));
}
