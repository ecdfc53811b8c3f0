//! Channels of a picture and coefficients of projections, estimated from the same directions.

use std::f64::consts::PI;
use std::io::Cursor;

use serde_json::Value;

use crate::outcome::{Outcome, same};
use crate::workplace::{Workplace, data};

/// Returns a picture of 8 x 4 texels with different channels.
fn colours() -> Vec<u8> {
    let texel = |x, y| image::Rgb([(1 + x * y) as f32, (9 - x) as f32, ((3 * x + y) % 5) as f32]);
    let map = image::Rgb32FImage::from_fn(8, 4, texel);
    let mut bytes = Cursor::new(Vec::new());
    map.write_to(&mut bytes, image::ImageFormat::OpenExr).unwrap();
    bytes.into_inner()
}

fn place() -> Workplace {
    let place = Workplace::new();
    place.write("map.exr", colours());
    place
}

fn rows(document: &Value) -> &[Value] {
    document["rows"].as_array().unwrap()
}

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} of {row}"))
}

fn with_integrand(row: &Value) -> String {
    row["integrand"].as_str().unwrap().to_owned()
}

/// Every row of `channel=rgb` is that of the channel alone, also where each has trials of its own.
#[test]
fn channels_have_the_rows_of_single_runs() {
    let place = place();
    let run = |integrand: &str, effort: &str| {
        let samplers = "white-noise,jittered,poisson-disk -n 27 --nearest";
        let arguments =
            format!("variance {samplers} --integrand {integrand} {effort} --seed 3 --json");
        place.run(&arguments).json()
    };
    for effort in ["-m 20", "-m 10 --until-rel 15%"] {
        let all = run("env:map.exr,channel=rgb,up=y", effort);
        let names: Vec<String> = rows(&all).iter().take(4).map(with_integrand).collect();
        let channels = ["r", "g", "b", "luminance"];
        assert_eq!(names, channels.map(|channel| format!("env:map.exr,channel={channel},up=y")));
        for (i, name) in names.iter().enumerate() {
            let single = run(name, effort);
            let own: Vec<&Value> = rows(&all).iter().skip(i).step_by(4).collect();
            assert_eq!(own, rows(&single).iter().collect::<Vec<_>>(), "{name}");
        }
    }
}

/// The coefficients are the products with harmonics, as any command takes them, and the irradiance
/// is their weighted sum.
#[test]
fn projections_have_the_errors_of_products_with_harmonics() {
    let place = place();
    let samplers = "jittered,fibonacci -n 48 --seed 5 -m 20 --json";
    let run = |integrand: &str| {
        let mut command = place.command(&format!("variance {samplers}"));
        Outcome::new(integrand, command.args(["--integrand", integrand]).output().unwrap()).json()
    };
    let arguments = format!("variance {samplers} --integrand env:map.exr --project 2");
    let all = place.run(&arguments).json();
    assert_eq!(rows(&all).len(), 2 * 10);
    let factors = [PI, 2.0 * PI / 3.0, PI / 4.0];
    let degree = usize::isqrt;
    for (case, of_case) in rows(&all).chunks(10).enumerate() {
        let (irradiance, coefficients) = of_case.split_last().unwrap();
        assert_eq!(with_integrand(irradiance), "irradiance of env:map.exr");
        // Spectra of lattices end where the integrand's energy does, which differs.
        for (key, tolerance) in [("predicted", 1e-4), ("measured", 1e-10)] {
            let terms = coefficients.iter().enumerate();
            let sum: f64 =
                terms.map(|(i, row)| factors[degree(i)].powi(2) * number(row, key)).sum();
            let ratio = sum / number(irradiance, key);
            assert!((ratio - 1.0).abs() < tolerance, "{key}: {ratio}");
        }
        let norm: f64 = coefficients
            .iter()
            .enumerate()
            .map(|(i, row)| (factors[degree(i)] * number(row, "exact")).powi(2))
            .sum();
        assert!((number(irradiance, "exact") - norm.sqrt()).abs() < 1e-12 * norm.sqrt());
        assert!(irradiance["bias_z"].is_null());
        // Slow products: two of the nine.
        for i in [0, 5] {
            let name = with_integrand(&coefficients[i]);
            let single = run(&name);
            let single = &rows(&single)[case];
            for key in ["predicted", "measured", "mean"] {
                let (got, expected) = (number(&coefficients[i], key), number(single, key));
                assert!((got / expected - 1.0).abs() < 1e-9, "{name}, {key}: {got} {expected}");
            }
        }
    }
    assert_eq!(with_integrand(&rows(&all)[5]), "env:map.exr * ylm:l=2,m=-1");
}

#[test]
fn variance_compare_and_choose_agree_on_projections() {
    let place = place();
    let common = "jittered,fibonacci --integrand env:map.exr --project 1 -n 48 --seed 2 --json";
    let variance = place.run(&format!("variance {common} -m 10")).json();
    let compare = place.run(&format!("compare {common} -m 10 -o out")).json();
    let choose = place.run(&format!("choose {common}")).json();
    assert_eq!(rows(&variance), rows(&compare));
    assert_eq!(compare["samplers"].as_array().unwrap().len(), 2);
    let spectra = place.text("out/spectra.csv");
    // 33 degrees of the two samplers, the provenance and the heading.
    assert!(spectra.lines().count() >= 2 + 2 * 33, "{spectra}");
    for chosen in rows(&choose) {
        assert_eq!(with_integrand(chosen), "irradiance of env:map.exr");
        let own: Vec<&Value> =
            rows(&variance).iter().filter(|row| row["sampler"] == chosen["sampler"]).collect();
        let (irradiance, coefficients) = own.split_last().unwrap();
        assert!(same(number(chosen, "variance"), number(irradiance, "predicted")));
        let relative = number(irradiance, "relative_error");
        assert!(same(number(chosen, "relative_error"), relative));
        let errors = chosen["coefficients"].as_array().unwrap();
        assert_eq!(errors.len(), 4);
        for (error, row) in errors.iter().zip(coefficients) {
            let (got, expected) = (number(error, "variance"), number(row, "predicted"));
            // The spectrum is that of the irradiance, perhaps to another degree.
            assert!((got / expected - 1.0).abs() < 0.02, "{got} {expected}");
        }
    }
    let errors: Vec<f64> = rows(&choose).iter().map(|row| number(row, "error")).collect();
    assert!(errors.is_sorted(), "{errors:?}");
}

#[test]
fn choose_ranks_every_channel() {
    let place = place();
    let run = |integrand: &str| {
        let arguments = format!("choose jittered,fibonacci --error 5% --integrand {integrand}");
        place.run(&format!("{arguments} --json")).json()
    };
    let all = run("env:map.exr,channel=rgb");
    assert_eq!(rows(&all).len(), 8);
    for (i, name) in
        ["luminance", "b", "g", "r"].map(|c| format!("env:map.exr,channel={c}")).iter().enumerate()
    {
        let single = run(name);
        for (got, expected) in rows(&all)[2 * i..].iter().zip(rows(&single)) {
            for key in ["integrand", "rank", "sampler", "n", "variance", "relative_error", "rate"] {
                assert_eq!(got[key], expected[key], "{name}, {key}");
            }
        }
        if i == 0 {
            assert_eq!(all["recommendation"], single["recommendation"]);
        }
    }
    let text = place.run("choose jittered --integrand env:map.exr,channel=rgb -n 24").ok().stdout;
    assert_eq!(text.matches("Standard errors with about 24 points").count(), 4, "{text}");
}

#[test]
fn wrong_uses_are_errors() {
    let place = place();
    for (arguments, parts) in [
        (
            "bounds jittered -n 48 --integrand env:map.exr,channel=rgb",
            &["channel=rgb", "variance, compare and choose"][..],
        ),
        (
            "variance jittered -n 48 --integrand env:map.exr,channel=rgb --no-rotate",
            &["--no-rotate", "one integral"],
        ),
        (
            "variance jittered -n 48 --integrand env:map.exr --project 2 --no-rotate",
            &["--no-rotate", "ylm"],
        ),
        ("variance jittered -n 48 --integrand env:map.exr --project 11", &["0 to 10", "11"]),
        (
            "variance jittered -n 48 --hemisphere --integrand env:map.exr --project 2",
            &["--project", "--hemisphere"],
        ),
        ("choose jittered -n 48 --integrand env:map.exr --project -1", &["-1"]),
    ] {
        place.run(arguments).fails(2, parts);
    }
}

/// Compares predicted with measured errors of the 9 coefficients and the irradiance of the light
/// probe `city.exr`, for six patterns.
///
/// For standard normal scores, one beyond 5 of 300 has a probability of 2e-4. Those of one pattern
/// depend on each other, as its coefficients have the same sets: a mean square beyond 1.6 has a
/// probability below 1 % with 40 effectively independent scores.
fn assert_errors_of_city(counts: &str, trials: u32) {
    let samplers = "white-noise,jittered,poisson-disk,fibonacci,healpix,sobol";
    let city = data("city.exr");
    let arguments = format!(
        "variance {samplers} -n {counts} --nearest --integrand env:{city} --project 2 -m {trials} \
         --json"
    );
    let document = Workplace::new().run(&arguments).json();
    let scores: Vec<f64> = rows(&document).iter().map(|row| number(row, "z")).collect();
    let mean_square = scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64;
    let largest = scores.iter().fold(0.0, |max: f64, z| max.max(z.abs()));
    assert!(largest < 5.0 && mean_square < 1.6, "{largest}, {mean_square}: {scores:?}");
}

#[test]
fn errors_of_a_light_probe_are_those_predicted() {
    assert_errors_of_city("16,64", 100);
}

#[test]
#[ignore = "statistics"]
fn errors_of_a_light_probe_are_those_predicted_for_many_rays() {
    assert_errors_of_city("16,64,256,1024,4096", 500);
}
