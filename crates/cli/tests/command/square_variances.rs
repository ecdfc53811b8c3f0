//! `variance`, `compare` and `choose` with `--square`.

use serde_json::Value;

use crate::workplace::Workplace;

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or(f64::NAN)
}

/// The variance of a wave is half of the power at its frequency over N: in closed form for jitter
/// and grids, which no frequency but the multiples of their sides reaches.
#[test]
fn predictions_of_a_wave_are_the_power_at_its_frequency() {
    let place = Workplace::new();
    let run = "variance white-square,jittered-square,regular-square --square -n 64 -m 40 --json";
    let sinc = (0.375 * std::f64::consts::PI).sin() / (0.375 * std::f64::consts::PI);
    for (wave, powers) in
        [("wave:k1=3,k2=0", [1.0, 1.0 - sinc * sinc, 0.0]), ("wave:k1=8,k2=0", [1.0, 1.0, 64.0])]
    {
        let document = place.run(&format!("{run} --integrand {wave}")).json();
        let rows = document["rows"].as_array().unwrap();
        assert_eq!(rows.len(), 3);
        for (row, power) in rows.iter().zip(powers) {
            let expected = power / 128.0;
            let got = number(row, "predicted");
            assert!((got - expected).abs() <= 1e-12 * expected, "{wave}: {row}");
            assert_eq!((&row["domain"], &row["n"]), (&"square".into(), &64.into()));
            assert_eq!(row["integrand"], *wave);
            assert!(expected == 0.0 || number(row, "z").abs() < 5.0, "{row}");
        }
    }
}

/// The points of a file are an ensemble under shifts, whatever their weights: a single point is
/// white noise, two points half a period apart cancel odd frequencies.
#[test]
fn files_are_patterns() {
    let place = Workplace::new();
    place.write("one.csv", "u,v\n0.3,0.9\n");
    place.write("two.csv", "u,v,w\n0.3,0.9,2\n0.8,0.9,2\n");
    let run = "variance file:one.csv,file:two.csv --square -m 40 --json --integrand wave:k1=1,k2=0";
    let document = place.run(run).json();
    let rows = document["rows"].as_array().unwrap();
    assert!((number(&rows[0], "predicted") - 0.5).abs() < 1e-12, "{document}");
    assert!(number(&rows[1], "predicted") <= 0.0, "{document}");
    assert!((number(&rows[1], "n_effective") - 2.0).abs() < 1e-12, "{document}");
}

#[test]
fn a_comparison_has_all_files() {
    let place = Workplace::new();
    let run = "compare white-square,jittered-square --square -n 16,64,256 \
               --integrand disk:radius=0.3 -m 60";
    let output = place.run(&format!("{run} -o out")).ok();
    assert!(output.stdout.contains("Largest variance reduction: jittered-square"), "{output:?}");
    for name in ["comparison.csv", "spectra.csv", "comparison.json", "spectra.svg", "variance.svg"]
    {
        assert!(place.text(&format!("out/{name}")).len() > 100, "{name}");
    }
    // Radial means of jitter are small at low and 1 at high frequencies.
    let text = place.text("out/spectra.csv");
    let of = |l: usize| {
        let line = text.lines().find(|x| x.starts_with(&format!("jittered-square,256,{l},")));
        line.unwrap().split(',').nth(4).unwrap().parse::<f64>().unwrap()
    };
    assert!(of(1) < 0.02 && (of(60) - 1.0).abs() < 0.05, "{text}");
    let document: Value = serde_json::from_str(&place.text("out/comparison.json")).unwrap();
    let rate = number(&document["samplers"][1], "predicted_rate");
    assert!((rate + 1.5).abs() < 0.1, "{rate}");
}

/// White noise needs Var(f)/e^2 points, here r^2 pi (1 - r^2 pi)/(0.02 r^2 pi)^2 for a disk.
#[test]
fn patterns_are_ranked() {
    let place = Workplace::new();
    let run = "choose white-square,jittered-square --square --integrand disk:radius=0.25 --json";
    let document = place.run(&format!("{run} --error 2%")).json();
    let area = std::f64::consts::PI / 16.0;
    let white = ((1.0 - area) / (4e-4 * area)).ceil();
    assert!((number(&document, "white_noise_points") - white).abs() < 0.5, "{document}");
    let rows = document["rows"].as_array().unwrap();
    assert_eq!(rows[0]["sampler"], "jittered-square");
    assert!(number(&rows[0], "n") < 0.2 * white && number(&rows[1], "n") >= white);
    assert_eq!(document["domain"], "square");
    assert!(document["reason"]["half_degree"].is_number(), "{document}");
    let document = place.run(&format!("{run} -n 64")).json();
    assert_eq!(document["rows"][0]["n"], 64);
}

#[test]
fn options_of_the_sphere_are_errors() {
    let place = Workplace::new();
    let square = "jittered-square --square -n 16 --integrand disk:radius=0.3";
    for (arguments, parts) in [
        (format!("variance {square} --hemisphere"), &["--hemisphere", "--square"][..]),
        (format!("variance {square} --lmax 8"), &["--lmax", "--kmax"]),
        (format!("variance {square} --no-rotate"), &["--no-rotate", "shifted"]),
        (format!("variance {square} --project 2"), &["--project", "--square"]),
        (format!("variance {square} --method exact"), &["--method", "--epsilon"]),
        (format!("compare {square} --lmax 8"), &["--lmax", "--kmax"]),
        (format!("choose {square} --hemisphere"), &["--hemisphere", "--square"]),
        ("variance jittered -n 12 --integrand cosine --kmax 8".to_owned(), &["--square"]),
        ("variance jittered-square -n 16 --integrand cosine".to_owned(), &["--square"]),
        ("variance jittered -n 12 --integrand disk:radius=0.3".to_owned(), &["--square"]),
        (
            "variance jittered-square --square -n 16 --integrand cosine".to_owned(),
            &["cosine", "sphere", "disk"],
        ),
        (
            "variance jittered --square -n 12 --integrand disk:radius=0.3".to_owned(),
            &["jittered", "sphere"],
        ),
        (format!("variance {square} --kmax 100000"), &["100000", "10000"]),
    ] {
        place.run(&arguments).fails(2, parts);
    }
}
