//! The subcommand `audit`.

use crate::outcome::assert_keys;
use crate::workplace::Workplace;

const DOCUMENT: [&str; 10] = [
    "sampler",
    "domain",
    "n",
    "realizations",
    "lmax",
    "alpha",
    "tolerance",
    "copies",
    "audits",
    "provenance",
];
const AUDIT: [&str; 8] =
    ["ensemble", "verdict", "conclusion", "detectable", "vanishing", "tests", "ratios", "bias"];

/// An unrotated lattice is a single set, to which no formula of variances applies. For the rotated
/// lattice, no test rejects the formula, but 60 realizations are few. Both are answers, with exit
/// status 0.
#[test]
fn a_lattice_must_be_rotated() {
    let place = Workplace::new();
    let arguments = "audit fibonacci -n 40 -m 60 --lmax 4 --alpha 0.05";
    let text = place.run(arguments).ok().stdout;
    for part in [
        "as drawn",
        "a single fixed set",
        "apply a uniform random rotation",
        "rotated",
        "Undecided: only",
        "E R_",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let document = place.run(&format!("{arguments} --json -o a.csv")).json();
    assert_keys(&document, &DOCUMENT);
    assert_eq!(document["copies"], 199);
    let audits = document["audits"].as_array().unwrap();
    assert_eq!(audits.len(), 2);
    for (audit, verdict, tests) in [(&audits[0], "no", 4), (&audits[1], "undecided", 5)] {
        assert_keys(audit, &AUDIT);
        assert_eq!(audit["verdict"], verdict);
        assert_eq!(audit["tests"].as_array().unwrap().len(), tests);
        // (l, m) with 1 <= l <= 4.
        assert_eq!(audit["ratios"].as_array().unwrap().len(), 14);
    }
    let csv = place.text("a.csv");
    let mut lines = csv.lines().skip(1);
    assert!(lines.next().unwrap().starts_with("ensemble,test,compared,statistic,p_value"));
    assert_eq!(lines.count(), 4 + 5);
    let only = place.run(&format!("{arguments} --unrotated --json")).json();
    assert_eq!(only["audits"].as_array().unwrap().len(), 1);
    assert_eq!(only["audits"][0], audits[0]);
}

/// Sets of a file are realizations; their rotations are unknown.
#[test]
fn sets_of_a_file() {
    let place = Workplace::new();
    place.run("sample jittered -n 12 -m 40 --rotate -o p.npy").ok();
    let text = place.run("audit --points p.npy --lmax 3 --alpha 0.1").ok().stdout;
    assert!(text.contains("from files: 40 realizations"), "{text}");
    assert!(text.contains("rotations: unknown"), "{text}");
    // The file contains the sets of the rotated sampler, so the results are the same.
    let p_value = |document: &serde_json::Value, audit: usize, test: usize| {
        document["audits"][audit]["tests"][test]["p_value"].clone()
    };
    let sets = place.run("audit --points p.npy --lmax 3 --alpha 0.1 --json").json();
    let made = place.run("audit jittered -n 12 -m 40 --lmax 3 --alpha 0.1 --json").json();
    assert!(p_value(&sets, 0, 0).is_f64(), "{sets}");
    assert_eq!(p_value(&sets, 0, 0), p_value(&made, 1, 0));
    assert_eq!(p_value(&sets, 0, 2), p_value(&made, 1, 2));
    place.run("sample jittered -n 12 -m 29 -o few.npy").ok();
    place.run("audit --points few.npy").fails(1, &["at least 30 sets", "few.npy has 29"]);
    place.run("audit --points none.npy").fails(1, &["none.npy"]);
}

#[test]
fn the_hemisphere_has_even_degrees() {
    let place = Workplace::new();
    let document =
        place.run("audit white-noise -n 5 -m 30 --lmax 4 --alpha 0.2 --hemisphere --json").json();
    let ratios = document["audits"][0]["ratios"].as_array().unwrap();
    assert_eq!(ratios.len(), 3 + 5);
    assert!(ratios.iter().all(|r| r["l"] == 2 || r["l"] == 4), "{ratios:?}");
    // Antipodal sets on the sphere.
    let text = place.run("audit healpix -n 12 -m 30 --lmax 3 --alpha 0.2").ok().stdout;
    assert!(text.contains("not tested, without power: l = 1, 3"), "{text}");
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let place = Workplace::new();
    let arguments = "audit white-noise -n 7 -m 31 --lmax 3 --alpha 0.2 --json";
    let one = place.run(&format!("{arguments} -j 1")).ok().stdout;
    assert_eq!(place.run(&format!("{arguments} -j 3")).ok().stdout, one);
    assert_ne!(place.run(&format!("{arguments} -s 5")).ok().stdout, one);
}

#[test]
fn invalid_command_lines() {
    let place = Workplace::new();
    let cases: [(&str, &[&str]); 9] = [
        ("audit", &["SAMPLER"]),
        ("audit jittered -n 12 -m 29", &["-m", "at least 30", "got 29"]),
        ("audit jittered -n 12 --lmax 0", &["--lmax", "at least 1", "got 0"]),
        ("audit jittered -n 12 --hemisphere --lmax 1", &["--lmax", "at least 2", "hemisphere"]),
        ("audit jittered -n 12 --alpha 0", &["--alpha", "[1e-4, 0.5]", "got 0"]),
        ("audit jittered -n 12 --alpha nan", &["--alpha", "NaN"]),
        ("audit jittered -n 12 --tolerance=-1", &["--tolerance", "got -1"]),
        ("audit jittered -n 13", &["nearest valid count is 12", "--nearest"]),
        ("audit --points p.csv --unrotated", &["--unrotated"]),
    ];
    for (arguments, parts) in cases {
        place.run(arguments).fails(2, parts);
    }
    assert!(place.names().is_empty());
}

/// The ratios of every ensemble, with their reference values.
#[test]
fn a_chart_of_ratios() {
    let place = Workplace::new();
    let text = place.run("audit fibonacci -n 40 -m 60 --lmax 4 -o a.svg").ok().stdout;
    assert!(text.contains("as drawn"), "{text}");
    let chart = place.text("a.svg");
    for part in ["as drawn", "rotated", "variance formula", "degree l", "fibonacci, N = 40"] {
        assert!(chart.contains(part), "{part} is missing");
    }
    assert_eq!(place.names(), ["a.svg"]);
}
