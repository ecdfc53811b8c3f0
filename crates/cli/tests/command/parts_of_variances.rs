//! `variance` with predictions only or measurements only.

use serde_json::Value;

use crate::outcome::keys;
use crate::workplace::Workplace;

const PREDICTED: [&str; 8] = [
    "lmax",
    "realizations",
    "predicted",
    "predicted_stderr",
    "predicted_tail",
    "predicted_low",
    "predicted_high",
    "relative_error",
];
const MEASURED: [&str; 9] = [
    "trials",
    "measured",
    "measured_stderr",
    "mean",
    "mean_stderr",
    "measured_low",
    "measured_high",
    "bias_z",
    "bias_p",
];

/// Runs with one part have the numbers of a run with both, and null or 0 for the others.
#[test]
fn parts_have_the_numbers_of_both() {
    let place = Workplace::new();
    let cases = [
        "jittered,fibonacci -n 48 --integrand cap:degrees=60 -m 60",
        "jittered -n 48 --integrand vmf:kappa=4 --project 1 -m 60",
        "jittered-square,sobol --square -n 16 --integrand disk:radius=0.3 -m 60",
        "white-noise,sobol:warp=cosine --hemisphere -n 16 --integrand phong:n=5 -m 60",
    ];
    for case in cases {
        let rows = |arguments: &str| {
            let document = place.run(&format!("variance {arguments} --json")).json();
            document["rows"].as_array().unwrap().clone()
        };
        let both = rows(case);
        let predicted = rows(&case.replace("-m 60", "--predict-only"));
        let measured = rows(&format!("{case} --measure-only"));
        assert_eq!((both.len(), both.len()), (predicted.len(), measured.len()), "{case}");
        for ((both, predicted), measured) in both.iter().zip(&predicted).zip(&measured) {
            // Warped patterns count the trials near their largest ratio.
            let of_trials = ["largest_ratio_trials", "largest_ratio_expected"];
            let mut expected = keys(both);
            expected.retain(|key| !of_trials.contains(key));
            assert_eq!(expected, keys(predicted), "{case}");
            assert_eq!(keys(both), keys(measured), "{case}");
            let is_none = |value: &Value| value.is_null() || *value == 0;
            for key in PREDICTED {
                assert_eq!(both[key], predicted[key], "{case}, {key}");
                assert!(is_none(&measured[key]), "{case}, {key}: {measured}");
            }
            for key in MEASURED {
                assert_eq!(both[key], measured[key], "{case}, {key}");
                assert!(is_none(&predicted[key]), "{case}, {key}: {predicted}");
            }
            for row in [predicted, measured] {
                assert_eq!(both["exact"], row["exact"], "{case}");
                for key in ["ratio", "ratio_stderr", "z", "remark"] {
                    assert!(row[key].is_null(), "{case}, {key}: {row}");
                }
            }
        }
    }
}

#[test]
fn tables_have_the_columns_of_their_part() {
    let place = Workplace::new();
    let run = "variance jittered -n 48 --integrand cap:degrees=60";
    let heading = |more: &str| {
        let outcome = place.run(&format!("{run} {more}")).ok();
        assert!(!outcome.stdout.contains("too few trials"), "{}", outcome.stdout);
        outcome.stdout.lines().next().unwrap().to_owned()
    };
    let (predicted, measured) = (heading("--predict-only"), heading("--measure-only -m 60"));
    for (heading, wanted, unwanted) in
        [(&predicted, "predicted", "measured"), (&measured, "measured", "predicted")]
    {
        assert!(heading.contains(wanted), "{heading}");
        for name in [unwanted, "ratio", " z "] {
            assert!(!heading.replace("bias z", "").contains(name), "{heading}: {name}");
        }
    }
    assert!(measured.contains("bias z") && !predicted.contains("bias z"), "{measured}");
}

#[test]
fn parts_exclude_the_options_of_the_other() {
    let place = Workplace::new();
    let run = "variance jittered -n 48 --integrand cap:degrees=60";
    for (part, options) in [
        ("--predict-only", ["--measure-only", "-m 60", "--until-rel 5%", "--no-rotate"]),
        (
            "--measure-only",
            ["--lmax 20", "--spectrum-realizations 9", "--method exact", "--no-rotate"],
        ),
    ] {
        for option in options {
            place.run(&format!("{run} {part} {option}")).fails(2, &[part, "cannot be used with"]);
        }
    }
    place
        .run("variance ccvt:density=cosine --hemisphere -n 8 --integrand cosine --predict-only")
        .fails(2, &["--predict-only", "ccvt:density=cosine"]);
}
