//! `spectrum --pairs`: pair correlation, K and L of samplers and files.

use std::f64::consts::PI;

use crate::outcome::{assert_keys, numbers};
use crate::workplace::Workplace;

#[test]
fn disks_have_a_hard_core() {
    let place = Workplace::new();
    let run = "spectrum poisson-disk -n 100 -m 6 --pairs --max-angle 60 --bins 30";
    let document = place.run(&format!("{run} --json -o pairs.csv")).json();
    // The spectrum is still there.
    assert_eq!(numbers(&document["l"]).len(), numbers(&document["power"]).len());
    let pairs = &document["pairs"];
    let wanted = [
        "gamma",
        "g",
        "stderr",
        "g_uniform_stderr",
        "g_smooth",
        "g_smooth_stderr",
        "smoothing_width",
        "radius",
        "k",
        "k_stderr",
        "l",
        "l_stderr",
        "sum_rule",
    ];
    assert_keys(pairs, &wanted);
    let (gamma, g) = (numbers(&pairs["gamma"]), numbers(&pairs["g"]));
    assert!((gamma[0] - PI / 180.0).abs() < 1e-15 && gamma.len() == 30);
    // The default radius is about 2.9/sqrt(N) = 16.6 degrees.
    assert!(g[..7].iter().all(|g| *g == 0.0) && g[8] > 1.0, "{g:?}");
    let (radius, l) = (numbers(&pairs["radius"]), numbers(&pairs["l"]));
    assert!((l[29] - radius[29]).abs() < 0.05 && l[6] == 0.0, "{l:?}");
    let csv = place.text("pairs.csv");
    assert!(csv.lines().nth(1).unwrap().starts_with("gamma,g,stderr"), "{csv}");
    assert_eq!(csv.lines().count(), 32);
    let table = place.run(run).ok().stdout;
    assert!(table.contains("sum rule") && table.contains("g smooth"), "{table}");
    place.run(&format!("{run} -o pairs.svg")).ok();
    assert!(place.text("pairs.svg").contains("Pair correlation of poisson-disk"));
}

/// Two points at a right angle, with weights: one pair, and errors that do not exist.
#[test]
fn one_pair_is_one_pair() {
    let place = Workplace::new();
    place.write("two.csv", "x,y,z,w\n1,0,0,1\n0,1,0,3\n");
    let run = "spectrum --points two.csv --lmax 4 --pairs --max-angle 180 --bins 4 --json";
    let document = place.run(run).json();
    let pairs = &document["pairs"];
    // 2 w1 w2/(sum w)^2 over the share of the third bin, from 90 to 135 degrees.
    let expected = 2.0 * 3.0 / 16.0 / (0.5 * (PI / 4.0).sin());
    let g = numbers(&pairs["g"]);
    assert!((g[2] - expected).abs() < 1e-12 && g[0] + g[1] + g[3] == 0.0, "{g:?}");
    assert!((numbers(&pairs["k"])[3] - 4.0 * PI).abs() < 1e-12, "{pairs}");
    assert!(pairs["stderr"].as_array().unwrap().iter().all(serde_json::Value::is_null));
    // A single point has no pairs, and no K.
    place.write("one.csv", "x,y,z\n0,0,1\n");
    let run = "spectrum --points one.csv --lmax 4 --pairs --bins 3 --json";
    let document = place.run(run).json();
    for key in ["k", "k_stderr", "l", "stderr"] {
        let values = document["pairs"][key].as_array().unwrap().clone();
        assert!(values.iter().all(serde_json::Value::is_null), "{key}: {values:?}");
    }
    // Bins in which no realization has a pair have no error.
    let run = "spectrum white-noise -n 20 -m 10 --pairs --max-angle 1e-9 --bins 2 --json";
    let document = place.run(run).json();
    assert!(numbers(&document["pairs"]["g"]).iter().all(|g| *g == 0.0));
    assert!(document["pairs"]["stderr"].as_array().unwrap().iter().all(serde_json::Value::is_null));
}

#[test]
fn settings_of_pairs_out_of_range_are_rejected() {
    let place = Workplace::new();
    let run = "spectrum white-noise -n 24 --pairs";
    for (flags, parts) in [
        ("--max-angle 181", ["180", "got"]),
        ("--max-angle 0", ["above 0", "got 0"]),
        ("--max-angle 91 --hemisphere", ["90 degrees", "got"]),
        ("--bins 0", ["bins", "from 1"]),
        ("--bins 20000", ["bins", "10000"]),
        ("--density ylm:l=2", ["--density", "positive mean"]),
        ("--exact", ["--exact", "--pairs"]),
        ("--shard 1/2 --save a.shard", ["--shard", "--pairs"]),
    ] {
        place.run(&format!("{run} {flags}")).fails(2, &parts);
    }
    place.run("spectrum jittered -n 12 --bins 5").fails(2, &["--pairs"]);
    // A density that vanishes at a point is found with the points.
    let run = "spectrum white-noise -n 40 -m 2 --pairs --density cap:degrees=30";
    place.run(run).fails(1, &["local density", "positive"]);
}

#[test]
fn pairs_do_not_depend_on_threads() {
    let place = Workplace::new();
    let run = "spectrum jittered -n 96 -m 9 --hemisphere --pairs --density cosine --json";
    let pairs = |threads| place.run(&format!("{run} -j {threads}")).json()["pairs"].clone();
    assert_eq!(pairs(1), pairs(3));
}
