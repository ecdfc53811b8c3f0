//! Least-squares fits of values in files, and fits as integrands.

use serde_json::Value;

use crate::outcome::keys;
use crate::workplace::Workplace;

fn number(document: &Value, key: &str) -> f64 {
    document[key].as_f64().unwrap_or_else(|| panic!("{key}: {document}"))
}

/// A spiral of n directions with values of `1 + z + x y` and deterministic noise of amplitude
/// `noise`; the function has the energies 4 pi, 4 pi/3 and 4 pi/15.
fn rows(n: usize, noise: f64) -> Vec<[f64; 4]> {
    let row = |k: usize| {
        let z = 1.0 - (2 * k + 1) as f64 / n as f64;
        let (sin, cos) = (2.399_963_229_728_653 * k as f64).sin_cos();
        let s = (1.0 - z * z).sqrt();
        let (x, y) = (s * cos, s * sin);
        let phase = (k as f64 * 0.754_877_666).fract();
        [x, y, z, 1.0 + z + x * y + noise * (2.0 * phase - 1.0)]
    };
    (0..n).map(row).collect()
}

fn csv(header: &str, rows: &[[f64; 4]]) -> String {
    let line = |row: &[f64; 4]| row.map(|x| format!("{x:?}")).join(",") + "\n";
    format!("{header}\n{}", rows.iter().map(line).collect::<String>())
}

#[test]
fn fits_state_coefficients_noise_and_energies() {
    let place = Workplace::new();
    place.write("v.csv", csv("x,y,z,value", &rows(400, 0.0)));
    let document = place.run("fit v.csv --lmax 5 --json").json();
    let expected = [
        "points",
        "n",
        "n_distinct",
        "lmax",
        "ridge",
        "residual_rms",
        "noise_variance",
        "degrees_of_freedom",
        "condition",
        "iterations",
        "energies",
        "provenance",
    ];
    assert_eq!(keys(&document), expected);
    assert!(number(&document, "residual_rms") < 1e-11, "{document}");
    assert!((1.0..1.5).contains(&number(&document, "condition")), "{document}");
    assert_eq!(document["degrees_of_freedom"], 400.0 - 36.0);
    let pi = std::f64::consts::PI;
    for (l, exact) in [4.0 * pi, 4.0 * pi / 3.0, 4.0 * pi / 15.0, 0.0].into_iter().enumerate() {
        let energy = number(&document["energies"][l], "energy");
        assert!((energy - exact).abs() < 1e-10, "{l}: {energy}");
    }
    // Noise of variance 0.3^2/3; energies agree within 5 of their errors.
    place.write("noisy.csv", csv("x,y,z,value", &rows(400, 0.3)));
    let document = place.run("fit noisy.csv --lmax 5 --json").json();
    assert!((number(&document, "noise_variance") / 0.03 - 1.0).abs() < 0.2, "{document}");
    for (l, exact) in [4.0 * pi, 4.0 * pi / 3.0, 4.0 * pi / 15.0, 0.0].into_iter().enumerate() {
        let row = &document["energies"][l];
        let z = (number(row, "energy") - exact) / number(row, "stderr");
        assert!(z.abs() < 5.0, "{l}: {row}");
    }
    let text = place.run("fit noisy.csv --lmax 5").ok().stdout;
    assert!(text.starts_with("400 points, fit to degree 5\n"), "{text}");
    // On the hemisphere only even degrees count.
    let half = place.run("fit v.csv --lmax 4 --hemisphere --json").json();
    assert_eq!(half["energies"][1]["energy"], 0.0);
    assert_eq!(half["degrees_of_freedom"], 400.0 - 15.0);
    // As many harmonics as points leave the noise unknown.
    place.write("few.csv", csv("x,y,z,value", &rows(25, 0.1)));
    let square = place.run("fit few.csv --lmax 4 --json").json();
    assert!(square["noise_variance"].is_null() && square["energies"][0]["energy"].is_null());
}

#[test]
fn columns_weights_and_errors_of_values() {
    let place = Workplace::new();
    let rows = rows(100, 0.2);
    place.write("v.csv", csv("x,y,z,value", &rows));
    let plain = place.run("fit v.csv --lmax 3 --json").json();
    // The same without a header, by other names, and in angles.
    place.write("bare.txt", csv("", &rows));
    place.write("named.csv", csv("x,y,z,FLUX", &rows));
    for other in ["bare.txt", "named.csv --columns x=x,y=y,z=z,value=FLUX"] {
        let got = place.run(&format!("fit {other} --lmax 3 --json")).json();
        assert_eq!(got["energies"], plain["energies"], "{other}");
    }
    // Weights 4 and standard errors 1/2 are the same.
    let fourth = |last: f64| -> String {
        let line = |r: &[f64; 4]| format!("{:?},{:?},{:?},{:?},{last}\n", r[0], r[1], r[2], r[3]);
        rows.iter().map(line).collect()
    };
    place.write("w.csv", format!("x,y,z,value,w\n{}", fourth(4.0)));
    place.write("sigma.csv", format!("x,y,z,value,sigma\n{}", fourth(0.5)));
    let [w, sigma] =
        ["w", "sigma"].map(|name| place.run(&format!("fit {name}.csv --lmax 3 --json")).json());
    assert_eq!(w["energies"], sigma["energies"]);
    let ratio = number(&w, "noise_variance") / number(&plain, "noise_variance");
    assert!((ratio - 4.0).abs() < 1e-9, "{ratio}");
    // Two files joined are one set.
    place.write("a.csv", csv("x,y,z,value", &rows[..60]));
    place.write("b.csv", csv("x,y,z,value", &rows[60..]));
    place.run("fit a.csv b.csv --lmax 3").fails(2, &["--join"]);
    let joined = place.run("fit a.csv b.csv --join --lmax 3 --json").json();
    assert_eq!(joined["energies"], plain["energies"]);
}

#[test]
fn invalid_values_are_errors_that_name_the_place() {
    let place = Workplace::new();
    let rows = rows(60, 0.1);
    place.write("v.csv", csv("x,y,z,value", &rows));
    place
        .run("fit v.csv --lmax 8")
        .fails(2, &["81 distinct points", "largest possible degree is 6"]);
    place.run("fit v.csv --lmax 10 --hemisphere").fails(2, &["66 distinct", "degree is 8"]);
    place.run("fit v.csv --lmax 3 --ridge -1").fails(2, &["ridge", "at least 0"]);
    place.run("fit v.csv").fails(2, &["--lmax"]);
    place.run("fit none.csv --lmax 3").fails(1, &["none.csv"]);
    place.write("p.csv", "x,y,z,flux\n1,0,0,5\n");
    place.run("fit p.csv --lmax 0").fails(1, &["a column value", "flux"]);
    let nan = csv("x,y,z,value", &rows).replacen(",1.", ",NaN", 1);
    place.write("nan.csv", nan);
    place.run("fit nan.csv --lmax 3").fails(1, &["value", "finite number", "--skip-invalid"]);
    let skipped = place.run("fit nan.csv --lmax 3 --skip-invalid --json");
    assert!(skipped.stderr.contains("1 of 60 rows skipped"), "{}", skipped.stderr);
    assert_eq!(skipped.json()["n"], 59);
    place.write("both.csv", "x,y,z,value,w,sigma\n1,0,0,5,1,1\n");
    place.run("fit both.csv --lmax 0").fails(1, &["either weights w or standard errors sigma"]);
    place.write("zero.csv", "x,y,z,value,sigma\n1,0,0,5,0\n");
    place.run("fit zero.csv --lmax 0").fails(1, &["positive standard error"]);
    place.write("negative.csv", "x,y,z,value,w\n1,0,0,5,1\n0,1,0,5,-1\n");
    place.run("fit negative.csv --lmax 0").fails(1, &["negative.csv:3: w", "at least 0"]);
    // Values whose squares overflow or underflow.
    for size in ["e200", "e-200"] {
        let scaled = format!("x,y,z,value\n1,0,0,5{size}\n0,1,0,4{size}\n0,0,1,3{size}\n");
        place.write("scaled.csv", scaled);
        place.run("fit scaled.csv --lmax 0").fails(1, &["1e-150 to 1e150", "got 5e"]);
        let integrand = "variance fibonacci -n 48 --integrand values:scaled.csv,lmax=0";
        place.run(integrand).fails(1, &["1e-150 to 1e150"]);
    }
    // Standard errors and weights have different units.
    place.write("w.csv", "x,y,z,value,w\n1,0,0,5,1\n");
    place.write("sigma.csv", "x,y,z,value,sigma\n0,1,0,5,1\n");
    place.run("fit w.csv sigma.csv --join --lmax 0").fails(1, &["sigma.csv", "after w"]);
    // Points on a cap: a lower degree or a ridge.
    let lift = |r: &[f64; 4]| [0.1 * r[0], 0.1 * r[1], 1.0, r[3]];
    place.write("cap.csv", csv("x,y,z,value", &rows.iter().map(lift).collect::<Vec<_>>()));
    place
        .run("fit cap.csv --lmax 6 --normalize")
        .fails(1, &["do not determine", "condition number", "ridge of about"]);
    place.run("fit cap.csv --lmax 6 --normalize --ridge 0.1").ok();
}

#[test]
fn results_go_to_files() {
    let place = Workplace::new();
    place.write("v.csv", csv("x,y,z,value", &rows(100, 0.1)));
    place.run("fit v.csv --lmax 4 -o e.csv").ok();
    let text = place.text("e.csv");
    assert_eq!(text.lines().nth(1), Some("l,energy,stderr,fitted,noise"), "{text}");
    assert_eq!(text.lines().count(), 2 + 5);
    place.run("fit v.csv --lmax 4 -o alm.npy").ok();
    let npy = place.bytes("alm.npy");
    assert!(npy.starts_with(b"\x93NUMPY") && npy.len() % 64 == 15 * 16 % 64, "{}", npy.len());
    place.run("fit v.csv --lmax 4 -o alm.fits").ok();
    let fits = place.bytes("alm.fits");
    assert!(fits.starts_with(b"SIMPLE  =") && fits.len() == 3 * 2880, "{}", fits.len());
    let document = place.run("fit v.csv --lmax 4 --json -o e.json").json();
    assert_eq!(place.text("e.json").parse::<Value>().unwrap()["energies"], document["energies"]);
    place.run("fit v.csv --lmax 4 -o e.exe").fails(2, &[".npy or .fits", ".csv", ".json"]);
    // The same bytes for any number of threads.
    place.run("fit v.csv --lmax 4 -o again.npy --threads 3 --quiet").ok();
    assert_eq!(place.bytes("again.npy"), npy);
}

/// The fit as an integrand has its exact integral and the energies of the function behind the
/// values, so that the ranking of patterns is that of the function.
/// Noise alone, whose energies are negative in about half of all degrees.
#[test]
fn energies_of_fits_are_integrands_with_errors() {
    let place = Workplace::new();
    let noise: Vec<[f64; 4]> = rows(400, 0.3)
        .into_iter()
        .map(|[x, y, z, value]| [x, y, z, value - (1.0 + z + x * y)])
        .collect();
    place.write("v.csv", csv("x,y,z,value", &noise));
    place.run("fit v.csv --lmax 8 -o energies.csv").ok();
    let table = place.text("energies.csv");
    assert!(table.lines().any(|line| line.contains(",-")), "{table}");
    let outcome = place.run("variance jittered -n 48 -m 20 --json --integrand energy:energies.csv");
    let message = &outcome.stderr;
    assert!(message.contains("of 9 energies are negative"), "{message}");
    let row = outcome.json()["rows"][0].clone();
    let error = number(&row, "predicted_stderr");
    assert!(error > 1e-3 * number(&row, "predicted"), "{row}");
    // The same energies without errors: a negative one is wrong, the prediction exact.
    let energies = place.run("fit v.csv --lmax 8 --json").json();
    let rows = energies["energies"].as_array().unwrap().iter().enumerate();
    let exact: String =
        rows.map(|(l, row)| format!("{l},{:?}\n", number(row, "energy").max(0.0))).collect();
    place.write("exact.csv", exact);
    let exact = place.run("variance jittered -n 48 -m 20 --json --integrand energy:exact.csv");
    let exact = exact.json()["rows"][0].clone();
    let ratio = number(&exact, "predicted") / number(&row, "predicted");
    assert!((ratio - 1.0).abs() < 1e-6, "{row} {exact}");
    assert!(number(&exact, "predicted_stderr") < 0.1 * error, "{row} {exact}");
}

#[test]
fn fits_are_integrands() {
    let place = Workplace::new();
    place.write("v.csv", csv("x,y,z,value", &rows(400, 0.05)));
    let variance = |integrand: &str, flags: &str| {
        let command = format!("variance white-noise,fibonacci -n 40 -m 40 --integrand {integrand}");
        place.run(&format!("{command} --json {flags}")).json()["rows"].clone()
    };
    let rows = variance("values:v.csv,lmax=4", "");
    let pi = std::f64::consts::PI;
    // White noise: 4 pi/N times the energy from degree 1.
    let exact = 4.0 * pi / 40.0 * (4.0 * pi / 3.0 + 4.0 * pi / 15.0);
    let predicted = number(&rows[0], "predicted");
    assert!((predicted / exact - 1.0).abs() < 0.1, "{predicted}, not {exact}");
    assert!(number(&rows[0], "predicted_stderr") > 0.0, "{rows}");
    assert!((number(&rows[0], "exact") / (4.0 * pi) - 1.0).abs() < 0.01);
    let half = variance("values:v.csv,lmax=4,hemisphere=yes", "--hemisphere");
    assert!(number(&half[0], "predicted") > 0.0, "{half}");
    place
        .run("variance fibonacci -n 40 --integrand values:v.csv,lmax=4 --hemisphere")
        .fails(2, &["hemisphere=yes"]);
    place
        .run("variance fibonacci -n 40 --integrand values:v.csv,lmax=40")
        .fails(2, &["largest possible degree is 19"]);
    place.run("variance fibonacci -n 40 --integrand values:v.csv").fails(2, &["lmax"]);
    place.run("variance fibonacci -n 40 --integrand values:none,lmax=4").fails(1, &["none"]);
}
