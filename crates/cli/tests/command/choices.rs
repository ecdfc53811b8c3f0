//! `choose`: its two questions, its output formats and its errors.

use serde_json::Value;

use crate::outcome::{assert_keys, same};
use crate::workplace::{Workplace, small_exr};

const ROW: [&str; 18] = [
    "rank",
    "sampler",
    "n",
    "basis",
    "too_few",
    "variance",
    "variance_stderr",
    "error",
    "relative_error",
    "variance_reduction",
    "rate",
    "rate_interval",
    "seconds_per_set",
    "seconds_are_scaled",
    "seconds_in_all",
    "lmax",
    "realizations",
    "curve",
];

fn rows(document: &Value) -> &Vec<Value> {
    document["rows"].as_array().unwrap()
}

#[test]
fn an_error_is_answered_with_points() {
    let place = Workplace::new();
    place.write("map.exr", small_exr(8, 4));
    let arguments = "choose --integrand env:map.exr --error 1% --samplers \
                     white-noise,jittered,fibonacci --json";
    let document = place.run(arguments).json();
    assert_keys(
        &document,
        &[
            "integrand",
            "domain",
            "integral",
            "error_requested",
            "points_requested",
            "max_points",
            "cost_per_sample",
            "rows",
            "left_out",
            "crossovers",
            "reason",
            "recommendation",
            "provenance",
        ],
    );
    let integral = document["integral"].as_f64().unwrap();
    let requested = document["error_requested"].as_f64().unwrap();
    assert!(same(requested, 0.01 * integral), "{requested} of {integral}");
    let mut last = 0;
    for row in rows(&document) {
        assert_keys(row, &ROW);
        assert_eq!(row["basis"], "predicted", "{row}");
        let n = row["n"].as_u64().unwrap();
        assert!(n >= last, "the fewest points come first: {document}");
        last = n;
        let error = row["error"].as_f64().unwrap();
        assert!(error <= requested && error > 0.5 * requested, "{row}");
        assert!(same(row["relative_error"].as_f64().unwrap(), error / integral), "{row}");
        assert!(row["too_few"].as_u64().unwrap() < n, "{row}");
    }
    assert_eq!(rows(&document)[2]["sampler"], "white-noise");
    let sentence = document["recommendation"].as_str().unwrap();
    assert!(sentence.contains("half of the integrand's variance"), "{sentence}");
    assert_eq!(document["reason"]["half_degree"], 1, "{document}");
}

/// White noise has the variance (4 pi int f^2 - I^2)/N: of the cap 3 pi^2/N.
#[test]
fn white_noise_is_exact_in_every_unit() {
    let place = Workplace::new();
    let n = |flags: &str| {
        let cap = "choose --integrand cap:degrees=60 --samplers white-noise --json";
        rows(&place.run(&format!("{cap} {flags}")).json())[0]["n"].as_u64()
    };
    assert_eq!(n("--error 3%"), Some(3334));
    assert_eq!(n("--error 0.03"), Some(3334));
    assert_eq!(n("--error 0.3 --absolute"), Some(329));
    assert_eq!(n("--error 3% --max-count 3000"), None);
    assert_eq!(n("--error 1000%"), Some(1));
    assert_eq!(n("-n 77"), Some(77));
    // The double cap of the hemisphere: pi^2/N.
    assert_eq!(n("--error 3% --hemisphere"), Some(1112));
    // The same by the number of values: the total time of white noise is N times the cost, plus the
    // set.
    let arguments = "choose --integrand cap:degrees=60 --samplers white-noise --error 3% \
                     --cost-per-sample 2 --json";
    let row = &rows(&place.run(arguments).json())[0].clone();
    let (all, set) = (&row["seconds_in_all"], &row["seconds_per_set"]);
    assert!(same(all.as_f64().unwrap(), 6668.0 + set.as_f64().unwrap()), "{row}");
}

#[test]
fn points_are_answered_with_errors() {
    let place = Workplace::new();
    let arguments =
        "choose --integrand cap:degrees=60 -n 200 --samplers white-noise,jittered,healpix";
    let document = place.run(&format!("{arguments} --json")).json();
    let names: Vec<&str> = rows(&document).iter().map(|r| r["sampler"].as_str().unwrap()).collect();
    assert_eq!(names, ["healpix", "jittered", "white-noise"]);
    let n: Vec<u64> = rows(&document).iter().map(|r| r["n"].as_u64().unwrap()).collect();
    assert_eq!(n, [192, 192, 200]);
    // Recorded variance of HEALPix at 192 points, and the rate of white noise.
    let variance = rows(&document)[0]["variance"].as_f64().unwrap();
    assert!((variance / 5.64e-3 - 1.0).abs() < 0.02, "{variance}");
    let rate = rows(&document)[2]["rate"].as_f64().unwrap();
    assert!((rate + 1.0).abs() < 1e-12, "{rate}");
    // Predictions, unlike times, are the same with any number of threads.
    let one = place.run(&format!("{arguments} --json -j 1")).json();
    for (a, b) in rows(&document).iter().zip(rows(&one)) {
        assert_eq!((&a["variance"], &a["curve"]), (&b["variance"], &b["curve"]));
    }
    let text = place.run(arguments).ok().stdout;
    for part in ["about 200 points", "healpix", "rate", "Recommended: healpix with N = 192"] {
        assert!(text.contains(part), "{text}\nlacks {part}");
    }
}

#[test]
fn files_have_the_answer() {
    let place = Workplace::new();
    let arguments = "choose --integrand cosine --error 5% --samplers white-noise,healpix -o";
    for name in ["a.csv", "a.json", "a.svg", "a.png"] {
        place.run(&format!("{arguments} {name}")).ok();
    }
    assert_eq!(place.names(), ["a.csv", "a.json", "a.png", "a.svg"]);
    let text = place.text("a.csv");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 4, "{text}");
    assert!(lines[1].starts_with("rank,sampler,n,basis"), "{text}");
    let columns = lines[1].split(',').count();
    assert!(lines[2..].iter().all(|l| l.split(',').count() == columns), "{text}");
    let document: Value = serde_json::from_str(&place.text("a.json")).unwrap();
    assert_eq!(rows(&document).len(), 2);
    let svg = place.text("a.svg");
    for part in ["healpix", "white-noise", "requested: 5%", "number of points N"] {
        assert!(svg.contains(part), "{part} is missing");
    }
    let piped = place.run(&format!("{arguments} -")).ok().stdout;
    assert!(piped.starts_with("# choose") || piped.starts_with("# sphvar choose"), "{piped}");
}

#[test]
fn unsupported_samplers_are_named() {
    let place = Workplace::new();
    let arguments = "choose --integrand cap:degrees=60 -n 2 --samplers white-noise,profile";
    let text = place.run(arguments).ok().stdout;
    assert!(text.contains("Not considered: profile (") && text.contains("infeasible"), "{text}");
    place
        .run("choose --integrand cap:degrees=60 -n 2 --samplers profile")
        .fails(1, &["profile", "infeasible"]);
    let text = place
        .run("choose --integrand cap:degrees=60 --error 1% --max-count 50 --samplers jittered")
        .ok()
        .stdout;
    assert!(text.contains("Out of reach") && text.contains("--max-count"), "{text}");
}

#[test]
fn invalid_requests_are_rejected() {
    let place = Workplace::new();
    let cases: [(&str, &[&str]); 14] = [
        ("--integrand cap:degrees=60", &["--error"]),
        ("--error 1%", &["--integrand"]),
        ("--integrand cap:degrees=60 --error 1% -n 12", &["cannot be used with"]),
        ("--integrand cap:degrees=60 -n 0", &["-n", "at least 1", "got 0"]),
        ("--integrand cap:degrees=60 --error 0", &["positive number", "\"0\""]),
        ("--integrand cap:degrees=60 --error -1%", &["-1"]),
        ("--integrand cap:degrees=60 --error nan", &["positive number", "nan"]),
        ("--integrand cap:degrees=60 --error 1e400", &["positive number"]),
        ("--integrand cap:degrees=60 --error 1% --absolute", &["--absolute", "relative"]),
        ("--integrand ylm:l=4 --error 1%", &["zero integral", "--absolute"]),
        ("--integrand cap:degrees=60 --error 1% --max-count 0", &["--max-count", "got 0"]),
        (
            "--integrand cap:degrees=60 --error 1% --cost-per-sample nan",
            &["--cost-per-sample", "NaN"],
        ),
        ("--integrand ylm:l=3 --hemisphere -n 12", &["ylm:l=3"]),
        ("--integrand cap:degrees=60 -n 12 -o a.txt", &["a.txt", ".csv or .json", ".svg"]),
    ];
    for (arguments, parts) in cases {
        place.run(&format!("choose {arguments}")).fails(2, parts);
    }
    assert!(place.names().is_empty());
}

/// Every command makes the same prediction, to the last digit, for any number of trials.
#[test]
fn every_command_predicts_the_same() {
    let place = Workplace::new();
    for (integrand, samplers) in [
        ("cap:degrees=60", "white-noise,jittered,fibonacci,poisson-disk,sobol"),
        ("ylm:l=4,m=0", "white-noise,jittered,fibonacci"),
    ] {
        let question = format!("{samplers} -n 48 --integrand {integrand} --json");
        let few = place.run(&format!("variance {question} -m 10")).json();
        let many = place.run(&format!("variance {question} -m 300")).json();
        let compared = place.run(&format!("compare {question} -m 20 --force")).json();
        let chosen = place.run(&format!("choose --samplers {question}")).json();
        assert_eq!(rows(&few).len(), samplers.split(',').count());
        for row in rows(&few) {
            let sampler = row["sampler"].as_str().unwrap();
            let bounds = format!("bounds {sampler} -n 48 --integrand {integrand} --json");
            let bounds = place.run(&bounds).json();
            for key in ["predicted", "predicted_stderr", "predicted_tail_error"] {
                assert_eq!(bounds[key], row[key], "{integrand}: {row}, {bounds}");
            }
            let same_sampler = |r: &&Value| r["sampler"] == row["sampler"];
            for (other, variance, stderr) in [
                (&many, "predicted", "predicted_stderr"),
                (&compared, "predicted", "predicted_stderr"),
                (&chosen, "variance", ""),
            ] {
                let other = rows(other).iter().find(same_sampler).unwrap();
                assert_eq!(other["n"], 48, "{other}");
                assert_eq!(other[variance], row["predicted"], "{integrand}: {row}, {other}");
                assert_eq!(other["realizations"], row["realizations"], "{row}, {other}");
                assert!(stderr.is_empty() || other[stderr] == row[stderr], "{row}, {other}");
            }
        }
    }
}

/// HEALPix has no power in odd degrees: its variance is 0 with 12 points, and 0 has no rate.
#[test]
fn an_exact_pattern_needs_its_smallest_set() {
    let place = Workplace::new();
    let arguments = "choose --integrand ylm:l=3 --absolute --error 0.001 --samplers \
                     white-noise,healpix";
    let document = place.run(&format!("{arguments} --json")).json();
    let best = &rows(&document)[0];
    assert_eq!((&best["sampler"], &best["n"]), (&"healpix".into(), &12.into()), "{document}");
    assert!(best["rate"].is_null() && best["variance_reduction"].is_null(), "{best}");
    assert_eq!(best["variance"], 0.0, "{best}");
    let text = place.run(arguments).ok().stdout;
    assert!(text.contains("exact") && text.contains("Recommended: healpix with N = 12"), "{text}");
}

/// A half-space has odd degrees only, in which HEALPix has no power; all other patterns need many
/// more points.
#[test]
fn half_a_sphere_takes_twelve_points() {
    let place = Workplace::new();
    let arguments = "choose --integrand half-space --error 0.1% --json";
    let named = format!("{arguments} --samplers white-noise,fibonacci,healpix --max-count 1000");
    let document = place.run(&named).json();
    let best = &rows(&document)[0];
    assert_eq!((&best["sampler"], &best["n"]), (&"healpix".into(), &12.into()), "{document}");
    assert_eq!(best["variance"], 0.0, "{best}");
    assert!(best["rate"].is_null() && best["rate_interval"].is_null(), "{best}");
    assert_eq!(document["crossovers"].as_array().map(Vec::len), Some(0), "{document}");
}

/// The relative variance of a cap of area A is (4 pi/A - 1)/N with white noise: 13131.6/N for one
/// of a degree, A = 2 pi (1 - cos 1 deg).
#[test]
fn unreachable_errors_are_compared_with_white_noise() {
    let place = Workplace::new();
    let arguments = "choose --integrand cap:degrees=1 --error 0.01%";
    let document = place.run(&format!("{arguments} --json")).json();
    let needed = document["white_noise_points"].as_f64().unwrap();
    let area = 2.0 * std::f64::consts::PI * (1.0 - 1_f64.to_radians().cos());
    let exact = (4.0 * std::f64::consts::PI / area - 1.0) / 1e-8;
    assert!((needed / exact - 1.0).abs() < 1e-9, "{needed}, exactly {exact}");
    let text = place.run(arguments).ok().stdout;
    for part in ["No other sampler achieves this error", "white noise needs 1.31e12 points"] {
        assert!(text.contains(part), "{text}\nlacks {part}");
    }
    // With the density of the cap itself in the table.
    assert!(text.contains("known integral") && text.lines().count() < 16, "{text}");
}

/// The integrand is concentrated on a cap of half a degree, which 48 points cannot resolve.
#[test]
fn no_pattern_is_recommended_for_a_sun() {
    let place = Workplace::new();
    let arguments = "choose --integrand cap:degrees=0.5 -n 48 --samplers \
                     white-noise,jittered,fibonacci,healpix";
    let text = place.run(arguments).ok().stdout;
    for part in ["No recommendation", "No pattern can", "of the variance lies beyond degree 14"] {
        assert!(text.contains(part), "{text}\nlacks {part}");
    }
    assert!(!text.contains("Recommended"), "{text}");
}

/// The alpha of a design is chosen for the integrand, and the printed name is accepted.
#[test]
#[ignore = "slow"]
fn designs_are_fitted_to_the_integrand() {
    let place = Workplace::new();
    let question = "choose --integrand vmf:kappa=20 -n 80 --json";
    let document = place.run(question).json();
    let fitted = |row: &&Value| row["sampler"].as_str().unwrap().contains(":alpha=1.");
    let best = rows(&document).iter().find(fitted).unwrap();
    let name = best["sampler"].as_str().unwrap();
    // E(l) is about (2l+1) exp(-l(l+1)/20): the energy beyond degree 11 is a fifth of that beyond
    // 8.
    let plain = place.run(&format!("{question} --samplers step,blue")).json();
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
    let (better, default) = (best, &rows(&plain)[0]);
    assert!(number(better, "error") < 0.5 * number(default, "error"), "{better}, {default}");
    let [tuned, untuned] = [better, default].map(|row| number(row, "last_empty_degree"));
    assert!(tuned > untuned, "{better}, {default}");
    let again = place.run(&format!("{question} --samplers {name}")).json();
    assert_eq!(rows(&again)[0]["variance"], best["variance"], "{again}");
    place.run(&format!("sample {name} -n 80 -o a.npy")).ok();
}
