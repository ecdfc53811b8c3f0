//! `integrate`: values with their errors, nodes, and tolerances that are not met.

use std::f64::consts::PI;

use crate::outcome::{assert_keys, numbers};
use crate::workplace::Workplace;

#[test]
fn an_integral_has_its_error_and_its_nodes() {
    let place = Workplace::new();
    let arguments = "integrate --integrand cosine --hemisphere --rtol 1e-3 --nodes nodes.csv";
    let document = place.run(&format!("{arguments} --json")).json();
    assert_keys(&document, &["integrand", "value", "error", "exact", "n", "copies", "evaluations"]);
    assert_keys(&document, &["sampler", "converged", "stop", "rtol", "atol", "seconds"]);
    let number = |key: &str| document[key].as_f64().unwrap();
    let (value, error) = (number("value"), number("error"));
    assert!((value - PI).abs() <= error && error <= 1e-3 * value, "{document}");
    assert!((number("exact") - PI).abs() < 1e-14, "{document}");
    assert_eq!(document["converged"], true);

    // The weighted sum of the values at the nodes is the value.
    let nodes = place.text("nodes.csv");
    let rows = nodes.lines().filter(|line| line.starts_with(|c: char| c == '-' || c.is_numeric()));
    let rows: Vec<Vec<f64>> =
        rows.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let count = |key: &str| document[key].as_u64().unwrap();
    assert_eq!(rows.len() as u64, count("copies") * count("n"));
    let sum: f64 = rows.iter().map(|row| row[2] * row[3]).sum();
    assert!((sum - value).abs() < 1e-13, "{sum}, {value}");

    let text = place.run("integrate --integrand vmf:kappa=20 --rtol 0.1%").ok().stdout;
    for part in ["integral", "+-", "exact", "16 copies of", "fibonacci", "evaluations"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// The result of a tolerance that is not met is printed, and the status is 1.
#[test]
fn a_tolerance_that_is_not_met_fails_with_a_result() {
    let place = Workplace::new();
    let limited = "integrate --integrand cap:degrees=60 --rtol 1e-6 --max-points 10k --json";
    for (arguments, stop, advice) in [
        (limited, "max-points", "--max-points 10000"),
        ("integrate --integrand ylm:l=3 --sampler lebedev --json", "rounding", "give --atol"),
        (
            "integrate --integrand cap:degrees=60 --rtol 1e-6 --sampler lebedev --json",
            "largest-set",
            "no set of more than 5810 points",
        ),
    ] {
        let output = place.command(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments}");
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(advice), "{message}");
        let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(
            (document["stop"].as_str(), &document["converged"]),
            (Some(stop), &false.into())
        );
        assert!(document["evaluations"].as_f64().unwrap() <= 1e7, "{document}");
    }
}

#[test]
fn seeds_and_samplers_are_options_and_results_do_not_depend_on_threads() {
    let place = Workplace::new();
    let value = |options: &str| {
        let arguments = "integrate --integrand cap:degrees=40 --rtol 1% --json";
        let document = place.run(&format!("{arguments} {options}")).json();
        numbers(&serde_json::json!([document["value"], document["error"], document["n"]]))
    };
    assert_eq!(value("-j 1"), value("-j 4"));
    assert_ne!(value(""), value("--seed 1"));
    assert_ne!(value(""), value("--sampler healpix"));
}

#[test]
fn options_out_of_range_are_usage_errors() {
    let place = Workplace::new();
    for (options, part) in [
        ("", "--integrand"),
        ("--integrand cosine --atol -1", "absolute tolerance"),
        ("--integrand cosine --atol 0", "must be positive"),
        ("--integrand cosine --max-points 15", "smallest set"),
        ("--integrand cosine --rtol 0", "must be positive"),
        ("--integrand cosine --rtol 0 --atol 0", "must be positive"),
        ("--integrand cosine --rtol=-1%", "share above 0"),
        ("--integrand cosine --max-points 1e18", "at most 2^53"),
        ("--integrand cosine --nodes - --json", "either --nodes - or --json"),
        ("--integrand cosine --nodes nodes.txt", "written as .csv, .npz or .ply"),
        ("--integrand cosine --sampler fibonacci,healpix", "expected one sampler"),
    ] {
        place.run(&format!("integrate {options}")).fails(2, &[part]);
    }
}

/// Equal values and features that few points hit have no error: the status is 0 only where a known
/// integral confirms the value.
#[test]
fn an_unknown_error_is_null_with_a_remark() {
    let place = Workplace::new();
    let with = |arguments: &str| {
        let arguments = format!("integrate --max-points 1M --json --integrand {arguments}");
        let output = place.command(&arguments).output().unwrap();
        let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(document["error"], serde_json::Value::Null, "{document}");
        let remarks = document["remarks"].to_string();
        assert!(remarks.contains("the error is unknown"), "{remarks}");
        assert!(message.contains("the error is unknown"), "{message}");
        assert!(!message.contains("if the integral may be 0"), "{message}");
        (output.status.code(), document, remarks)
    };
    let (status, document, remarks) = with("cap:degrees=180");
    assert_eq!((status, &document["converged"]), (Some(0), &true.into()), "{document}");
    assert_eq!(document["stop"], "equal-values");
    assert!(
        remarks.contains("features on less than 7.04e-6") && !remarks.contains("outside"),
        "{remarks}"
    );
    let (status, document, remarks) = with("cap:degrees=0.01");
    assert_eq!((status, &document["converged"]), (Some(1), &false.into()), "{document}");
    assert_eq!(document["stop"], "equal-values");
    assert!(remarks.contains("the exact integral is outside"), "{remarks}");
    for narrow in ["vmf:kappa=1e6", "ggx:roughness=0.02", "ggx:roughness=0.001"] {
        let (status, document, _) = with(narrow);
        assert_eq!((status, &document["stop"]), (Some(1), &"max-points".into()), "{document}");
    }
}

/// Rounding of large values is part of the error.
#[test]
fn errors_contain_the_rounding_of_large_values() {
    let place = Workplace::new();
    for mean in ["1e13", "1e14", "1e15", "1e17"] {
        let arguments =
            format!("integrate --integrand band:lmax=40,mean={mean} --max-points 100k --json");
        let document = place.run(&arguments).json();
        let number = |key: &str| document[key].as_f64();
        let difference = (number("value").unwrap() - number("exact").unwrap()).abs();
        assert!(number("error").is_none_or(|error| difference <= error), "{document}");
        assert!(difference <= 1e-13 * number("exact").unwrap(), "{document}");
    }
}

#[test]
fn one_of_the_tolerances_may_be_zero() {
    let place = Workplace::new();
    let document = place.run("integrate --integrand cosine --rtol 0 --atol 1e-3 --json").json();
    assert_eq!((&document["rtol"], &document["atol"]), (&0.0.into(), &0.001.into()));
}
