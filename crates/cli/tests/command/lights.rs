//! Environment maps as directional lights.

use serde_json::Value;

use crate::outcome::{Outcome, keys};
use crate::workplace::{Workplace, small_exr};

/// Returns an uncompressed Radiance picture of 16 x 8 texels in these colours: a mantissa of each
/// channel and an exponent.
fn radiance(texel: impl Fn(usize, usize) -> [u8; 4]) -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n".to_vec();
    bytes.extend(
        (0..8).flat_map(|i| (0..16).flat_map(move |j| [(i, j)])).flat_map(|(i, j)| texel(i, j)),
    );
    bytes
}

fn error(document: &Value, row: usize) -> f64 {
    document["irradiance_errors"][row]["error"].as_f64().unwrap_or_else(|| panic!("{document}"))
}

#[test]
fn lights_are_written_in_every_form() {
    let place = Workplace::new();
    place.write("sky.exr", small_exr(16, 8));
    let document = place.run("lights sky.exr -n 12 --json").json();
    let expected = [
        "environment",
        "axes",
        "colours",
        "rows",
        "irradiance_error",
        "irradiance_errors",
        "provenance",
    ];
    assert_eq!(keys(&document), expected);
    assert_eq!(document["environment"], "env:sky.exr");
    let rows = document["rows"].as_array().unwrap();
    assert_eq!((rows.len(), keys(&rows[0])), (12, ["x", "y", "z", "r", "g", "b"].to_vec()));
    assert!(document["irradiance_error"].as_f64().unwrap() < 0.2, "{document}");
    place.run("lights sky.exr -n 12 -o lights.csv").ok();
    let csv = place.text("lights.csv");
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines[0].starts_with("# sphvar lights sky.exr"), "{csv}");
    assert_eq!(lines[1], "# environment: env:sky.exr");
    let conventions = ["axes", "colours"].map(|key| document[key].as_str().unwrap());
    assert_eq!([lines[2], lines[3]], conventions.map(|text| format!("# {text}")));
    assert_eq!((lines[4], lines.len()), ("x,y,z,r,g,b", 17));
    let first: Vec<f64> = lines[5].split(',').map(|cell| cell.parse().unwrap()).collect();
    for (key, x) in ["x", "y", "z", "r", "g", "b"].iter().zip(&first) {
        // The reader of JSON in tests rounds the last digit.
        assert!((rows[0][key].as_f64().unwrap() - x).abs() <= 1e-15 * x.abs(), "{key}: {x}");
    }
    place.run("lights sky.exr -n 12 -o lights.glsl --threads 3 --quiet").ok();
    let glsl = place.text("lights.glsl");
    assert!(glsl.contains("const vec3 LIGHT_DIRECTIONS[12] = vec3[12](\n"), "{glsl}");
    assert!(
        glsl.contains(&format!(
            "{}, {}, {}",
            lines[5].split(',').next().unwrap(),
            lines[5].split(',').nth(1).unwrap(),
            lines[5].split(',').nth(2).unwrap()
        )),
        "{glsl}"
    );
    let all = "lights sky.exr -n 4,8 --samplers white-noise,median-cut,ccvt:density=luminance,capacity=16 \
               -m 3 --json --picture all.png -o all.json";
    let document = place.run(all).json();
    assert!(document["rows"].is_null() && document["irradiance_error"].is_null(), "{document}");
    assert_eq!(document["irradiance_errors"].as_array().unwrap().len(), 6);
    assert!(document["irradiance_errors"][2]["error_stderr"].is_null(), "{document}");
    let picture = image::open(place.path("all.png")).unwrap();
    assert!(picture.width() > 1000 && picture.height() > 800);
    place
        .run("lights sky.exr -n 4,8 -o lights.csv")
        .fails(2, &["one sampler and one number of points"]);
}

#[test]
fn importance_reduces_errors() {
    let place = Workplace::new();
    let samplers = "white-noise,sobol:warp=cylinder,sobol:warp=luminance,ccvt:density=luminance";
    let document =
        place.run(&format!("lights data/city.exr -n 64 -m 4 --samplers {samplers} --json")).json();
    // Measured: 19 %, 11 %, 2.6 % and 0.45 %.
    let errors = [0, 1, 2, 3].map(|row| error(&document, row));
    assert!(errors[3] < 0.006 && errors[2] < 0.05 && errors[0] > 0.05, "{errors:?}");
    assert!(errors[3] < errors[2] && errors[2] < errors[1], "{errors:?}");
    // The density of a map by its name as a warp.
    place.write("sky.exr", small_exr(16, 8));
    let samplers = r#"sobol:warp=luminance,sobol:warp="env:sky.exr""#;
    let document = place.run(&format!("lights sky.exr -n 64 --samplers {samplers} --json")).json();
    let [own, named] = [0, 1].map(|row| error(&document, row));
    assert!((named / own - 1.0).abs() < 1e-9, "{document}");
}

#[test]
fn axes_of_maps_rotate_lights() {
    let place = Workplace::new();
    let light =
        |i: usize, j: usize| if (i, j) == (0, 0) { [255, 200, 100, 140] } else { [2, 1, 1, 120] };
    place.write("sun.hdr", radiance(light));
    for (axes, key) in [("", "z"), (",up=y", "y"), (",up=-x", "x")] {
        let document = place.run(&format!("lights env:sun.hdr{axes} -n 1 --json")).json();
        let along = document["rows"][0][key].as_f64().unwrap();
        assert!(if key == "x" { along < -0.9 } else { along > 0.9 }, "{document}");
    }
}

#[test]
fn axes_are_those_that_files_state() {
    let place = Workplace::new();
    for (i, j) in [(2, 3), (5, 11)] {
        let light = |row, column| if (row, column) == (i, j) { [255, 9, 1, 200] } else { [0; 4] };
        place.write("texel.hdr", radiance(light));
        let document = place.run("lights texel.hdr -n 1 --samplers median-cut --json").json();
        let light = &document["rows"][0];
        let theta = std::f64::consts::PI * (i as f64 + 0.5) / 8.0;
        let phi = std::f64::consts::PI * (0.5 - 2.0 * (j as f64 + 0.5) / 16.0);
        let stated = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
        let cosine: f64 = ["x", "y", "z"]
            .iter()
            .zip(stated)
            .map(|(key, x)| light[key].as_f64().unwrap() * x)
            .sum();
        // Within half of the texel.
        assert!(cosine > (std::f64::consts::PI / 16.0).cos(), "{document}");
    }
}

#[test]
fn extreme_maps() {
    let place = Workplace::new();
    place.write("black.hdr", radiance(|_, _| [0; 4]));
    place.run("lights black.hdr").fails(1, &["black.hdr: the density is 0"]);
    place.write(
        "texel.hdr",
        radiance(|i, j| if (i, j) == (2, 3) { [255, 0, 0, 194] } else { [0; 4] }),
    );
    let document = place.run("lights texel.hdr -n 200 -m 2 --json").json();
    assert_eq!(document["rows"].as_array().unwrap().len(), 200);
    assert!(error(&document, 0) < 0.001, "{document}");
    assert!(document["irradiance_errors"][0]["blue"].is_null(), "{document}");
}

#[test]
fn mistakes_are_named() {
    let place = Workplace::new();
    place.write("sky.exr", small_exr(16, 8));
    for (arguments, message) in [
        ("lights", "ENVIRONMENT"),
        ("lights sky.exr -m 0", "-m must be at least 1"),
        (
            "lights sky.exr --samplers ccvt:density=nope",
            "unknown density \"nope\"; valid: luminance",
        ),
        ("lights sky.exr --samplers median", "median-cut"),
        ("lights sky.exr --samplers latin-hypercube", "latin-hypercube:warp=luminance"),
        ("lights sky.exr --samplers median-cut:capacity=3", "capacity"),
        ("lights sky.exr --samplers healpix -n 13", "use --nearest"),
        ("lights sky.exr -o lights.npy", "written as .csv, .json or .glsl"),
        ("lights sky.exr --picture lights.exr", "written as .png"),
        ("lights env:sky.exr,channel=r", "omit channel="),
    ] {
        place.run(arguments).fails(2, &[message]);
    }
    place.run("lights nothing.exr").fails(1, &["nothing.exr"]);
    // Densities that are 0 where the map is not lose light.
    let message = ["sobol:warp=cosine", "theta = ", "of |f| is lost", "0.1 * cylinder"];
    place.run("lights sky.exr --samplers sobol:warp=cosine -n 8").fails(1, &message);
    let luminance = ["--samplers", "sobol:warp=\"luminance + cylinder\""];
    let mut command = place.command("lights sky.exr -n 8");
    Outcome::new("a sum with luminance", command.args(luminance).output().unwrap())
        .fails(2, &["a density by itself", "env:FILE"]);
    let both = ["--samplers", "sobol:warp=\"0.9 * cosine + 0.1 * cylinder\""];
    let mut command = place.command("lights sky.exr -n 8 -m 2");
    Outcome::new("a mixture", command.args(both).output().unwrap()).ok();
}
