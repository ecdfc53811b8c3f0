//! The unit square: `--square` of `sample`, `spectrum`, `quality` and `list`, and its files.

use serde_json::Value;

use crate::outcome::{assert_keys, numbers, same};
use crate::workplace::Workplace;

/// Returns the frequencies of a spectrum with their powers.
fn powers(document: &Value) -> Vec<([f64; 2], f64)> {
    let [k1, k2, power] = ["k1", "k2", "power"].map(|key| numbers(&document[key]));
    k1.into_iter().zip(k2).map(|(k1, k2)| [k1, k2]).zip(power).collect()
}

/// Returns the rows of a CSV file below its header.
fn rows(text: &str) -> Vec<Vec<f64>> {
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines.map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect()
}

#[test]
fn sets_are_the_same_in_every_form() {
    let place = Workplace::new();
    let run = "sample jittered-square --square -n 16 -m 3 -s 7";
    place.run(&format!("{run} -o p.csv")).ok();
    let text = place.text("p.csv");
    assert!(text.starts_with("u,v,set\n"), "{text}");
    let points: Vec<[f64; 2]> = rows(&text).iter().map(|row| [row[0], row[1]]).collect();
    assert_eq!(points.len(), 48);
    // One point in each cell of the 4 x 4 grid.
    for set in points.chunks(16) {
        let mut cells: Vec<[usize; 2]> = set
            .iter()
            .map(|p| p.map(|x| (1..4).filter(|&i| 4.0 * x >= f64::from(i)).count()))
            .collect();
        cells.sort_unstable();
        cells.dedup();
        assert_eq!(cells.len(), 16);
    }
    for name in ["p.npy", "p.npz", "p.ply"] {
        place.run(&format!("{run} -o {name}")).ok();
        place.run(&format!("sample file:{name} --square -o back.csv")).ok();
        assert_eq!(place.text("back.csv"), text, "{name}");
    }
    let document = place.run(&format!("{run} --json")).json();
    let set = document["points"][2].as_array().unwrap();
    let last: Vec<f64> = set[15].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert!(last.iter().zip(points[47]).all(|(&a, b)| same(a, b)), "{last:?}");
    assert_eq!(place.run(run).ok().stdout, text);
    place.run(&format!("{run} -o set-{{i}}.csv")).ok();
    assert!(place.text("set-000002.csv").starts_with("u,v\n"));
    for name in ["p.svg", "p.png"] {
        place.run(&format!("{run} -o {name}")).ok();
    }
}

/// A shift moves all points of a set by one vector modulo 1.
#[test]
fn shifts_are_of_whole_sets() {
    let place = Workplace::new();
    place.write("p.csv", "u,v,w\n0,0.5,1\n0.25,0.75,-2\n");
    place.run("sample file:p.csv --square --shift -o s.csv").ok();
    let text = place.text("s.csv");
    assert!(text.starts_with("u,v,w\n"), "{text}");
    let moved = rows(&text);
    for (first, second) in moved[0].iter().zip(&moved[1]).take(2) {
        let step = (second - first).rem_euclid(1.0);
        assert!((step - 0.25).abs() < 1e-15, "{text}");
        assert!((0.0..1.0).contains(first));
    }
    assert!(moved[0][0] > 0.0 && (moved[1][2] + 2.0).abs() < 1e-300);
}

#[test]
fn errors_name_the_other_space() {
    let place = Workplace::new();
    place.write("sphere.csv", "x,y,z\n1,0,0\n");
    place.write("edge.csv", "u,v\n0.5,1.0\n");
    let square = "--square -n 16";
    for (arguments, parts) in [
        ("sample jittered-square -n 16", &["jittered-square", "--square"][..]),
        ("bounds white-square -n 16", &["white-square", "--square"]),
        ("audit white-square -n 16 -m 40", &["white-square", "--square"]),
        (
            &format!("sample jittered {square}"),
            &["jittered", "pattern of the sphere", "white-square"],
        ),
        (&format!("sample sobl {square}"), &["sobl", "sobol"]),
        (&format!("sample sobol {square} --hemisphere"), &["--hemisphere", "--square"]),
        (&format!("sample sobol {square} --rotate"), &["--rotate", "shifted"]),
        ("sample sobol -n 16 --shift", &["--square"]),
        (&format!("sample jittered-square {square}5"), &["169", "--nearest"]),
    ] {
        place.run(arguments).fails(2, parts);
    }
    place.run("sample file:sphere.csv --square").fails(1, &["sphere.csv:1", "without --square"]);
    place
        .run("sample file:edge.csv --square")
        .fails(1, &["edge.csv:2", "excludes 1", "normalize=yes"]);
    place.run("sample file:edge.csv,normalize=yes --square").ok();
}

/// The closed form of jittered sampling, with the radial mean and the anisotropy by their
/// definitions.
#[test]
fn spectra_have_frequencies_and_rings() {
    let place = Workplace::new();
    let run = "spectrum jittered-square --square -n 16 --kmax 9";
    let document = place.run(&format!("{run} --exact --json")).json();
    let keys = ["k1", "k2", "power", "stderr", "radius", "radial_power", "radial_stderr"];
    assert_keys(&document, &keys);
    assert_keys(&document, &["anisotropy", "kmax", "n", "realizations", "seconds", "tail"]);
    let sinc = |x: f64| {
        if x == 0.0 { 1.0 } else { (std::f64::consts::PI * x).sin() / (std::f64::consts::PI * x) }
    };
    let powers = powers(&document);
    // Half of the frequencies with |k| <= 9, and 0.
    assert_eq!(powers.len(), (253 - 1) / 2 + 1);
    for (k, power) in &powers[1..] {
        let expected = 1.0 - k.map(|k| sinc(k / 4.0).powi(2)).iter().product::<f64>();
        assert!((power - expected).abs() < 1e-14, "{k:?}: {power}, {expected}");
    }
    assert!((powers[0].1 - 16.0).abs() < 1e-12 && powers[0].0.iter().all(|k| k.abs() <= 0.0));
    let radius = numbers(&document["radius"]);
    assert_eq!(radius, (1..9).map(f64::from).collect::<Vec<_>>());
    let (means, anisotropy) =
        (numbers(&document["radial_power"]), numbers(&document["anisotropy"]));
    for (i, r) in radius.iter().enumerate() {
        let ring: Vec<f64> = powers
            .iter()
            .filter(|(k, _)| (-0.5..0.5).contains(&(k[0].hypot(k[1]) - r)))
            .map(|(_, power)| *power)
            .collect();
        let n = ring.len() as f64;
        let mean = ring.iter().sum::<f64>() / n;
        let variance = ring.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / (n - 1.0);
        assert!((means[i] - mean).abs() < 1e-13, "{r}");
        assert!((anisotropy[i] - variance / (mean * mean)).abs() < 1e-12, "{r}");
    }
    assert!(numbers(&document["stderr"]).iter().all(|&e| e == 0.0));
    // Sampled: 126 frequencies within 5.5 standard errors of 200 realizations, whose powers have
    // nearly exponential distributions; the means of such exceed that for about 1e-4 of seeds.
    let sampled = place.run(&format!("{run} -m 200 --json")).json();
    let errors = numbers(&sampled["stderr"]);
    for (((k, power), e), (_, expected)) in
        self::powers(&sampled).iter().zip(errors).zip(&powers).skip(1)
    {
        assert!((power - expected).abs() < 5.5 * e, "{k:?}: {power} +- {e}, {expected}");
    }
    let text = place.run(run).ok().stdout;
    assert!(text.contains("|k|") && text.contains("anisotropy"), "{text}");
    place.run(&format!("{run} -m 3 -o s.csv")).ok();
    let text = place.text("s.csv");
    assert!(text.contains("k1,k2,power,stderr,realizations\n"), "{text}");
    place.run(&format!("{run} -m 3 -o s.svg")).ok();
    assert_eq!(place.text("s.svg").matches("<image ").count(), 2);
    place.run(&format!("{run} --exact -o s.png")).ok();
}

#[test]
fn a_lattice_has_the_power_of_its_peaks_without_error() {
    let place = Workplace::new();
    let document = place.run("spectrum regular-square --square -n 16 --kmax 8 --json").json();
    assert_eq!(document["realizations"], 1);
    for (k, power) in powers(&document) {
        let expected = if k.iter().all(|k| k % 4.0 == 0.0) { 16.0 } else { 0.0 };
        assert!((power - expected).abs() < 1e-10, "{k:?}: {power}");
    }
    assert_eq!(document["stderr"][5], 0.0);
    assert!((document["tail_u"].as_f64().unwrap() - 4.0).abs() < 1e-12);
    assert_eq!(document["anisotropy"].as_array().unwrap().len(), 7);
}

/// Rings without power have no anisotropy, with and without --exact, from samplers, from their saved
/// sums, and from files.
#[test]
fn rings_of_lattices_without_power_are_empty() {
    let place = Workplace::new();
    place.run("sample fibonacci-lattice --square -n 34 -o lattice.npy").ok();
    place.run("sample regular-square --square -n 36 -s 3 --shift -o grid.csv").ok();
    place.run("spectrum regular-square --square -n 25 --kmax 12 --save s.shard --quiet").ok();
    for run in [
        "spectrum fibonacci-lattice --square -n 34 --kmax 9 --json",
        "spectrum regular-square --square -n 25 --kmax 12 --exact --json",
        "spectrum file:lattice.npy --square --exact --kmax 11 --json",
        "spectrum --points grid.csv --square --kmax 13 --json",
        "merge s.shard --json",
    ] {
        let document = place.run(run).json();
        let n = document["n"].as_f64().unwrap();
        let of_peak = |p: f64| (p - n).abs() < 1e-9 * n;
        assert!(powers(&document).iter().all(|(_, p)| of_peak(*p) || same(*p, 0.0)), "{run}");
        let powers = document["radial_power"].as_array().unwrap();
        let empty: Vec<bool> = powers.iter().map(|p| p.as_f64() == Some(0.0)).collect();
        assert!(empty[0] && empty.contains(&false), "{run}: {empty:?}");
        let anisotropy = document["anisotropy"].as_array().unwrap();
        assert!(anisotropy.iter().zip(empty).all(|(a, empty)| a.is_null() == empty), "{run}");
    }
}

#[test]
fn sums_of_weights_that_leave_the_range_are_null() {
    let place = Workplace::new();
    for (weight, squares) in [("1e-190", false), ("-1e170", false), ("1e-20", true)] {
        place.write("w.csv", format!("u,v,w\n0,0,{weight}\n0.5,0.25,{weight}\n"));
        let run = "spectrum --points w.csv --square --kmax 2 --json --quiet";
        let document = place.run(run).json();
        assert!(document["sum_w"].is_f64() && document["n_effective"] == 2.0, "{document}");
        assert_eq!(document["sum_w2"].is_f64(), squares, "{weight}: {document}");
    }
    place.write("z.csv", "u,v,w,set\n0,0,0,a\n0.5,0.25,0,a\n0.5,0.25,1,b\n");
    place.write("d.csv", "x,y,z,w\n0,0,1,0\n");
    place.run("spectrum --points w.csv z.csv --square").fails(1, &["z.csv", "set 0", "weights"]);
    place.run("spectrum --points d.csv").fails(1, &["d.csv", "set 0", "weights"]);
    place.run("spectrum --points d.csv --join").fails(1, &["d.csv", "weight"]);
}

#[test]
fn spectra_of_files_have_no_error_unless_they_are_ensembles() {
    let place = Workplace::new();
    place.write("one.csv", "u,v\n0.3,0.4\n");
    place.write("equal.txt", "0.3 0.4\n0.3 0.4\n0.3 0.4\n");
    place.write("mixed.csv", "u,v,w\n0.5,0,1\n0,0.25,-2\n0.1,0.9,4e0\n");
    place.write("two.txt", "0.1 0.2\n#\n0.1 0.2\n0.6 0.2\n");
    let spectrum = |arguments: &str| {
        place.run(&format!("spectrum {arguments} --square --kmax 4 --json --quiet")).json()
    };
    for (file, power) in [("one.csv", 1.0), ("equal.txt", 3.0)] {
        let document = spectrum(&format!("--points {file}"));
        assert!(powers(&document).iter().all(|(_, p)| (p - power).abs() < 1e-11), "{document}");
        assert_eq!(
            (&document["stderr"][3], &document["radial_stderr"][0]),
            (&Value::Null, &Value::Null)
        );
    }
    let mixed = spectrum("--points mixed.csv");
    assert!((mixed["n_effective"].as_f64().unwrap() - 9.0 / 21.0).abs() < 1e-14);
    let (k, power) = powers(&mixed)[1];
    let terms = [(0.5, 0.0, 1.0), (0.0, 0.25, -2.0), (0.1, 0.9, 4.0)];
    let (re, im) = terms.iter().fold((0.0, 0.0), |sum, (u, v, w)| {
        let (sin, cos) = (std::f64::consts::TAU * (k[0] * u + k[1] * v)).sin_cos();
        (sum.0 + w * cos, sum.1 + w * sin)
    });
    assert!((power - (re * re + im * im) / 21.0).abs() < 1e-12, "{k:?}: {power}");
    let two = spectrum("file:two.txt");
    assert_eq!(two["realizations"], 2);
    assert!(two["stderr"][1].as_f64().is_some_and(|e| e > 0.0), "{two}");
    assert_eq!(powers(&two), powers(&spectrum("--points two.txt")));
}

/// Any split and any number of threads gives the same digits.
#[test]
fn shards_of_the_square_merge_to_one_run() {
    let place = Workplace::new();
    let run = "spectrum sobol --square -n 30 -m 11 --kmax 7 -s 3";
    let content = |document: Value| {
        let mut document = document;
        let map = document.as_object_mut().unwrap();
        map.remove("seconds");
        map.remove("provenance");
        document
    };
    let whole = content(place.run(&format!("{run} --json -j 2")).json());
    for i in 1..=3 {
        place.run(&format!("{run} --shard {i}/3 --save {i}.shard -j {i} --quiet")).ok();
    }
    assert_eq!(content(place.run("merge 2.shard 3.shard 1.shard --json").json()), whole);
    place.run("merge 1.shard 3.shard --partial --save 13.shard --quiet").ok();
    assert_eq!(content(place.run("merge 2.shard 13.shard --json").json()), whole);
    place.run("merge 1.shard 3.shard").fails(1, &["missing: part 2 of 3", "--partial"]);
    place.run("merge 1.shard 1.shard 2.shard 3.shard").fails(1, &["part 1 is in"]);
    let other = run.replace("--kmax 7", "--kmax 8");
    place.run(&format!("{other} --shard 2/3 --save other.shard --quiet")).ok();
    place
        .run("merge 1.shard other.shard --partial")
        .fails(1, &["commands", "--kmax 7", "--kmax 8"]);
}

#[test]
fn options_of_the_sphere_are_rejected_on_the_square() {
    let place = Workplace::new();
    let run = "spectrum sobol --square -n 16";
    for (arguments, parts) in [
        ("--lmax 8", &["--lmax", "--kmax"][..]),
        ("--hemisphere", &["--hemisphere"]),
        ("--pairs", &["--pairs"]),
        ("--per-order o.csv", &["--per-order"]),
        ("--kmax 513", &["--kmax", "512"]),
        ("--exact", &["no closed form", "jittered-square"]),
        ("-m 0", &["-m must be at least 1"]),
    ] {
        place.run(&format!("{run} {arguments}")).fails(2, parts);
    }
    place.run("spectrum jittered -n 12 --kmax 4").fails(2, &["--square"]);
    place.run("quality sobol --square -n 16 --rank").fails(2, &["--rank"]);
    place.run("quality sobol --square -n 16 -o q.svg").fails(2, &["q.svg", ".csv or .json"]);
}

#[test]
fn quality_measures_sets_of_the_square() {
    let place = Workplace::new();
    place.write("middle.csv", "u,v\n0.5,0.5\n");
    let document = place.run("quality middle.csv --square --json").json();
    assert_keys(&document, &["sampler", "n", "separation", "star_discrepancy", "net_t", "remarks"]);
    assert_eq!((&document["n"], &document["separation"]), (&1.into(), &Value::Null));
    let number = |document: &Value, key: &str| document[key].as_f64().unwrap();
    assert!((number(&document, "star_discrepancy") - 0.75).abs() < 1e-15);
    // Warnock: 1/9 - 2 (3/8)^2 + 1/4.
    let l2 = (1.0 / 9.0 - 2.0 * 0.140_625 + 0.25f64).sqrt();
    assert!((number(&document, "l2_star_discrepancy") - l2).abs() < 1e-14, "{document}");
    let document = place.run("quality sobol,white-square --square -n 64 -m 4 --json").json();
    let [sobol, white] = [0, 1].map(|i| &document["rows"][i]);
    assert_eq!((&sobol["net_t"], &sobol["realizations"]), (&0.into(), &4.into()));
    assert!(number(sobol, "star_discrepancy") < number(white, "star_discrepancy"));
    assert!(number(&white["stderr"], "star_discrepancy") > 0.0);
    let relative = number(sobol, "relative_separation") / number(sobol, "separation");
    assert!((relative - (3f64.sqrt() * 32.0).sqrt()).abs() < 1e-9, "{relative}");
    let text = place.run("quality sobol --square -n 64").ok().stdout;
    assert!(text.contains("star discrepancy") && text.contains("(t,m,2)-net"), "{text}");
    place.run("quality sobol --square -n 64 -o q.csv").ok();
    assert!(place.text("q.csv").contains("relative separation"), "{}", place.text("q.csv"));
}

#[test]
fn lists_show_the_square() {
    let place = Workplace::new();
    let text = place.run("list").ok().stdout;
    for part in ["Samplers of the unit square", "jittered-square", "zone-plate"] {
        assert!(text.contains(part), "{text}");
    }
    let document = place.run("list --square --json").json();
    let names = |key: &str| -> Vec<&str> {
        document[key].as_array().unwrap().iter().map(|e| e["name"].as_str().unwrap()).collect()
    };
    assert!(
        names("square_samplers").contains(&"sobol") && names("square_integrands").contains(&"wave")
    );
    assert_eq!(document.get("samplers"), None);
    let text = place.run("list samplers regular-square --square").ok().stdout;
    assert!(text.contains("P(k) as k -> 0") && text.contains("up to a shift"), "{text}");
    place.run("list samplers regular-square").fails(2, &["regular-square", "--square"]);
    place.run("list integrands cap disk").fails(2, &["disk", "--square"]);
    place.run("list samplers sobol jittered --square").fails(2, &["jittered", "omit --square"]);
    place.run("list samplers nothing --square").fails(2, &["nothing", "pmj02"]);
    let text = place.run("list samplers sobol latin-hypercube --square").ok().stdout;
    for part in ["for smooth periodic integrands", "N^-1 for integrands in general"] {
        assert!(text.contains(part), "{text}");
    }
}
