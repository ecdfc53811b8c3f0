//! Variances to a requested precision, rejected degrees, and upper halves of sphere sets.

use crate::outcome::assert_keys;
use crate::workplace::Workplace;

#[test]
fn trials_are_doubled_until_the_variance_is_precise() {
    let place = Workplace::new();
    let run = |flags: &str| {
        let command = format!("variance sobol -n 12 --integrand cosine -m 50 --json {flags}");
        place.run(&command).json()["rows"][0].clone()
    };
    let row = run("--until-rel 10%");
    let (measured, stderr) =
        (row["measured"].as_f64().unwrap(), row["measured_stderr"].as_f64().unwrap());
    assert!(stderr <= 0.1 * measured, "{row}");
    let trials = row["trials"].as_u64().unwrap();
    // 2/0.1^2 = 200 trials of near-normal estimates, by doubling 50.
    assert!([100, 200, 400].contains(&trials), "{row}");
    assert_eq!(run("--until-rel 0.1"), row);
    assert_eq!(run("--until-rel 0.1% --max-realizations 120")["trials"], 120);
    for (low, high, value) in [
        ("measured_low", "measured_high", "measured"),
        ("predicted_low", "predicted_high", "predicted"),
    ] {
        let [low, high, value] = [low, high, value].map(|key| row[key].as_f64().unwrap());
        assert!(low < value && value < high, "{row}");
    }
    assert_keys(&row, &["predicted_tail_error", "bias_z", "bias_p"]);
    for flags in ["--until-rel 0", "--until-rel=-2%", "--until-rel nan", "--until-rel x%"] {
        let command = format!("variance white-noise -n 12 --integrand cosine {flags}");
        place.run(&command).fails(2, &["a share above 0"]);
    }
    place
        .run("variance white-noise -n 12 --integrand cosine --until-rel 1% -m 10 --max-realizations 9")
        .fails(2, &["--max-realizations must be at least 10, the initial number of trials"]);
}

#[test]
fn a_degree_that_fakes_a_rate_is_rejected() {
    let place = Workplace::new();
    let with = |sampler: &str, lmax: usize, integrand: &str| {
        place.run(&format!(
            "variance {sampler} -n 768 -m 4 --lmax {lmax} --integrand {integrand} --json"
        ))
    };
    with("jittered", 30, "cap:degrees=60").fails(2, &["the minimum sufficient degree is 5"]);
    with("jittered", 3, "ylm:l=4").fails(2, &["the minimum sufficient degree is 4"]);
    with("jittered", 4, "ylm:l=4").ok();
    with("jittered", 56, "cap:degrees=60").ok();
    with("white-noise", 8, "cap:degrees=60").ok();
}

/// An integrand that vanishes at the equator has no additional variance on the half above it, and
/// the variance is predicted; that of the ratio estimate is larger.
#[test]
fn visible_halves_are_compared_with_hemisphere_patterns() {
    let place = Workplace::new();
    let command = "variance jittered -n 96 --integrand cosine -m 400 --hemisphere";
    let document = place.run(&format!("{command} --visible-half=equator --json")).json();
    let rows = document["visible_half"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    for row in rows {
        assert_keys(
            row,
            &["sampler", "m", "estimator", "measured_low", "over_hemisphere", "n_visible"],
        );
        assert_eq!(row["m"], 192, "{row}");
    }
    // Six standard errors of 7 % each.
    let ratio = |row: &serde_json::Value, over: &str| {
        row["measured"].as_f64().unwrap() / row[over].as_f64().unwrap()
    };
    assert!((ratio(&rows[0], "predicted") - 1.0).abs() < 0.45, "{rows:?}");
    assert!(rows[1]["over_hemisphere"].as_f64().unwrap() > 1.8, "{rows:?}");
    let text = place.run(&format!("{command} --visible-half")).ok().stdout;
    assert!(text.contains("half/hemisphere"), "{text}");
    assert!(place.run(&format!("{command} --json")).json().get("visible_half").is_none());
}

/// Predictions for the half above the equator state the error of their tail separately, and include
/// the errors of estimated energies.
#[test]
fn predictions_of_visible_halves_state_their_tail() {
    let place = Workplace::new();
    let command = "variance jittered -n 24 -m 20 --hemisphere --visible-half=equator --json";
    let rows = |integrand: &str| {
        let document = place.run(&format!("{command} --integrand {integrand}")).json();
        document["visible_half"].as_array().unwrap().clone()
    };
    for row in rows("cosine") {
        // The mean spectrum of jittered samples is exact, but not its tail.
        assert_eq!(row["predicted_stderr"], 0.0, "{row}");
        let number = |key: &str| row[key].as_f64().unwrap();
        assert!(number("predicted_tail_error") > 0.0, "{row}");
        assert!((0.0..number("predicted")).contains(&number("predicted_tail")), "{row}");
    }
    // The energies of a pixel map that the equator cuts are estimates.
    let map = format!("map:{}/tests/data/ring.fits", env!("CARGO_MANIFEST_DIR"));
    for row in rows(&map) {
        let number = |key: &str| row[key].as_f64().unwrap();
        assert!((0.0..0.01 * number("predicted")).contains(&number("predicted_stderr")), "{row}");
        assert!(number("predicted_stderr") > 0.0, "{row}");
    }
}
