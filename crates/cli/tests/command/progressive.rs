//! `progressive`: the errors of every prefix of sequences.

use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::outcome::{assert_keys, same};
use crate::workplace::Workplace;

fn rows(document: &Value) -> &Vec<Value> {
    document["rows"].as_array().unwrap()
}

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key}: {row}"))
}

/// The cap of 60 degrees covers a quarter of the sphere, so independent points have the variance
/// (4 pi)^2 (1/4) (3/4)/N.
#[test]
fn every_prefix_has_a_row() {
    let place = Workplace::new();
    let run = "progressive white-noise,halton -n 40 --integrand cap:degrees=60 -m 50";
    let document = place.run(&format!("{run} --json -o rows.csv")).json();
    assert_eq!(rows(&document).len(), 80);
    for (i, row) in rows(&document).iter().enumerate() {
        let names =
            ["sampler", "n", "predicted", "predicted_stderr", "measured", "measured_stderr"];
        assert_keys(row, &names);
        assert_eq!(row["n"], i % 40 + 1);
        assert_eq!(row["sampler"], if i < 40 { "white-noise" } else { "halton" });
        let white = 3.0 * std::f64::consts::PI.powi(2) / number(row, "n");
        let ratio = number(row, "predicted") / white;
        assert!(i >= 40 || (ratio - 1.0).abs() < 1e-12, "{row}");
        // A single rotated point of any sequence is uniform.
        assert!(i != 40 || (ratio - 1.0).abs() < 1e-3, "{row}");
    }
    let csv = place.text("rows.csv");
    let mut lines = csv.lines();
    assert!(lines.next().unwrap().starts_with("# sphvar progressive"), "{csv}");
    assert!(lines.next().unwrap().starts_with("sampler,integrand,n,predicted,"), "{csv}");
    assert_eq!(lines.count(), 80);
}

/// All prefixes of a trial are those of one realization, which does not depend on the longest.
#[test]
fn shorter_runs_are_heads_of_longer_ones() {
    let place = Workplace::new();
    for rotation in ["", "--no-rotate"] {
        let run = format!(
            "progressive sobol,halton,best-candidate --integrand cosine -m 20 --json {rotation} --reference none"
        );
        let [short, long] = ["4,7,12", "4..32"].map(|n| place.run(&format!("{run} -n {n}")).json());
        for row in rows(&short).iter().filter(|row| row["n"] == 4) {
            let is_same = |other: &&Value| other["sampler"] == row["sampler"] && other["n"] == 4;
            let other = rows(&long).iter().find(is_same).unwrap();
            assert!(same(number(row, "mean"), number(other, "mean")), "{row}\n{other}");
            assert!(same(number(row, "measured"), number(other, "measured")), "{row}\n{other}");
        }
    }
}

#[test]
fn the_reference_is_that_of_variance() {
    let place = Workplace::new();
    let run = "--integrand cap:degrees=60 -m 20 --json";
    let document = place.run(&format!("progressive sobol -n 32,64 {run}")).json();
    let variance = place.run(&format!("variance fibonacci -n 32,64 {run}")).json();
    let references = document["reference"].as_array().unwrap();
    for (i, (reference, row)) in references.iter().zip(rows(&variance)).enumerate() {
        assert_eq!((&reference["sampler"], &reference["n"]), (&row["sampler"], &row["n"]));
        assert!(same(number(reference, "predicted"), number(row, "predicted")), "{reference}");
        let of_sequence = &rows(&document)[i];
        let factor = (number(of_sequence, "predicted") / number(reference, "predicted")).sqrt();
        assert!(same(number(of_sequence, "factor"), factor), "{of_sequence}");
    }
    assert_eq!(references.len(), 2);
    // Patterns at their valid counts, the best of several, and none.
    let run = "progressive white-noise -n 64 --integrand cap:degrees=60 -m 20 --json";
    let document = place.run(&format!("{run} --reference healpix,white-noise")).json();
    let factor = |n: usize| &rows(&document)[n - 1]["factor"];
    assert!(same(factor(6).as_f64().unwrap(), 1.0), "white noise alone: {}", factor(6));
    assert!(factor(64).as_f64().unwrap() > 3.0, "HEALPix with 48 points: {}", factor(64));
    assert!(factor(7).is_null(), "nothing is interpolated: {}", factor(7));
    let sequence = &document["sequences"][0];
    assert!((number(sequence, "rate") + 1.0).abs() < 1e-9, "{sequence}");
    assert!(number(sequence, "worst_factor") >= number(sequence, "mean_factor"), "{sequence}");
    let document = place.run(&format!("{run} --reference none")).json();
    assert_eq!(document["reference"].as_array().map(Vec::len), Some(0));
    assert!(rows(&document).iter().all(|row| row["factor"].is_null()), "{document}");
}

/// The first point is uniform by rotation, the first two cancel odd degrees.
#[test]
fn files_are_sequences_in_their_order() {
    let place = Workplace::new();
    place.write("pair.csv", "x,y,z\n0,0,1\n0,0,-1\n1,0,0\n");
    let run = "progressive file:pair.csv --integrand ylm:l=1,m=0 -m 20 --json --reference none";
    for (n, count) in [("", 3), ("-n 2", 2), ("-n 64", 3), ("-n 3,1", 2)] {
        let document = place.run(&format!("{run} {n}")).json();
        assert_eq!(rows(&document).len(), count, "{n}: {document}");
        // 4 pi times the energy of a harmonic, 1.
        let first = number(&rows(&document)[0], "predicted");
        assert!((first / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12, "{document}");
        assert!(n == "-n 3,1" || number(&rows(&document)[1], "predicted") < 1e-25, "{document}");
    }
    place.run(&format!("{run} -n 4,5")).fails(2, &["pair.csv", "3 points"]);
}

/// Without rotation, a fixed sequence has one error: that of a point at the pole is
/// 4 pi `Y_10(0)` = 4 pi sqrt(3/(4 pi)).
#[test]
fn errors_without_rotation_are_measured() {
    let place = Workplace::new();
    place.write("pole.csv", "x,y,z\n0,0,1\n");
    let run = "--integrand ylm:l=1,m=0 -m 10 --no-rotate --reference none";
    let document = place.run(&format!("progressive file:pole.csv {run} --json")).json();
    let row = &rows(&document)[0];
    let square = 12.0 * std::f64::consts::PI;
    assert!((number(row, "measured") / square - 1.0).abs() < 1e-12, "{row}");
    assert!(row["predicted"].is_null() && row["z"].is_null(), "{row}");
    assert_eq!(document["sequences"][0]["basis"], "measured");
    let document = place.run(&format!("progressive white-noise -n 4 {run} --json")).json();
    assert!(number(&rows(&document)[3], "predicted") > 0.0, "independent points are predicted");
    let text = place.run(&format!("progressive file:pole.csv {run}")).ok().stdout;
    assert!(text.contains("not homogeneous"), "{text}");
}

#[test]
fn squares_and_densities_have_sequences() {
    let place = Workplace::new();
    let run = "progressive r2,sobol --square -n 9 --integrand wave:k1=1,k2=2 -m 20 --json";
    let document = place.run(run).json();
    // Shifted by a uniform vector, a single point is uniform.
    for row in rows(&document).iter().filter(|row| row["n"] == 1) {
        assert!((number(row, "predicted") - 0.5).abs() < 1e-12, "{row}");
    }
    assert_eq!(document["sequences"][0]["domain"], "square");
    assert_eq!(document["reference"][0]["sampler"], "fibonacci-lattice");
    // The cosine divided by its density is constant.
    let run = "progressive r2:warp=cosine,white-noise --hemisphere -n 6 --integrand cosine -m 20";
    let document = place.run(&format!("{run} --json")).json();
    assert_eq!(rows(&document)[0]["sampler"], "r2:warp=cosine");
    assert!(number(&rows(&document)[5], "measured") < 1e-20, "{document}");
    assert_eq!(document["sequences"][1]["domain"], "hemisphere");
}

#[test]
fn one_point_has_an_error() {
    let place = Workplace::new();
    for more in ["", "-o one.svg", "-o one.csv", "--json", "--no-rotate -o one.png"] {
        let run = "progressive sobol,white-noise -n 1 --integrand cap:degrees=60 -m 4";
        let text = place.run(&format!("{run} {more}")).ok().stdout;
        assert!(text.contains("white-noise"), "{text}");
    }
    let run = "progressive sobol -n 1 --integrand cap:degrees=60 -m 4 --reference white-noise";
    let text = place.run(run).ok().stdout;
    let line = text.lines().find(|line| line.starts_with("Least factor: sobol, ")).unwrap();
    assert!(line.ends_with(" times the standard error of white-noise at N = 1."), "{line}");
}

#[test]
fn channels_have_rows_of_their_own() {
    let place = Workplace::new();
    let run = "progressive halton -n 2 --integrand env:data/city.exr,channel=rgb -m 4";
    let document = place.run(&format!("{run} --json")).json();
    assert_eq!(rows(&document).len(), 8);
    assert_eq!(rows(&document)[2]["integrand"], "env:data/city.exr,channel=g");
    let text = place.run(run).ok().stdout;
    assert_eq!(text.matches("Standard errors of").count(), 4, "{text}");
}

/// With many sequences, a table shows some of the prefixes.
#[test]
fn tables_fit_a_terminal() {
    let place = Workplace::new();
    let run = "progressive all -n 60 --integrand cap:degrees=60 -m 4 --reference fibonacci,spiral";
    let text = place.run(run).ok().stdout;
    let longest = text.lines().max_by_key(|line| line.chars().count()).unwrap();
    assert!(longest.chars().count() <= 120, "{longest}");
    assert!(text.lines().count() < 100, "{text}");
    for part in
        ["halton", "white-noise", "worst factor", "Least mean factor: ", "best of fibonacci"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn errors_name_sequences() {
    let place = Workplace::new();
    let of = "--integrand cap:degrees=60";
    for (arguments, parts) in [
        (
            format!("jittered -n 48 {of}"),
            &["jittered is not a sequence", "on the sphere: ", "halton", "--reference jittered"][..],
        ),
        (format!("sobol,fibonacci -n 48 {of}"), &["fibonacci is not a sequence"]),
        (
            "hammersley --square -n 8 --integrand disk:radius=0.3".to_owned(),
            &["hammersley is not a sequence", "on the square: ", "pmj02"],
        ),
        (
            format!("jittered-square:warp=cosine -n 16 --hemisphere {of}"),
            &["jittered-square:warp=cosine is not a sequence", "on the square"],
        ),
        (format!("ccvt:density=cosine -n 16 {of}"), &["ccvt:density=cosine", "not a sequence"]),
        (format!("sobol {of}"), &["--count"]),
        ("sobol -n 8".to_owned(), &["--integrand"]),
        (format!("sobol -n 0 {of}"), &["at least 1", "got 0"]),
        (format!("sobol -n 8 -m 1 {of}"), &["-m must be at least"]),
        (format!("sobol -n 8 --reference fibonaci {of}"), &["fibonaci", "fibonacci"]),
        (format!("sobol -n 8 {of} -o errors.npy"), &["errors.npy", ".csv or .json"]),
        (
            "sobol --square --hemisphere -n 8 --integrand disk:radius=0.3".to_owned(),
            &["--hemisphere", "--square"],
        ),
    ] {
        place.run(&format!("progressive {arguments}")).fails(2, parts);
        assert!(place.names().is_empty(), "{arguments}");
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let place = Workplace::new();
    let run = "progressive sobol,halton -n 50 --integrand cap:degrees=60 -m 40 --json";
    let one = place.run(&format!("{run} -j 1")).ok().stdout;
    for threads in [2, 3] {
        assert_eq!(place.run(&format!("{run} -j {threads}")).ok().stdout, one);
    }
    assert_ne!(place.run(&format!("{run} --seed 1")).ok().stdout, one);
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_long_work() {
    let place = Workplace::new();
    let run = "progressive leja -n 100000 --integrand env:data/city.exr -o errors.csv";
    let mut child = place.command(run).spawn().unwrap();
    sleep(Duration::from_millis(300));
    let start = Instant::now();
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    // A loaded machine needs longer than the second that is promised.
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
    assert!(place.names().is_empty(), "{:?}", place.names());
}
