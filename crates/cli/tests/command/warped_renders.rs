//! `sphvar render` by importance sampling.

use serde_json::Value;

use crate::outcome::{Outcome, assert_keys};
use crate::workplace::{Workplace, small_exr};

/// Small pictures with a small reference image in a folder of their own.
const SMALL: &str = "--size 24 --reference-count 600 --cache cache";

const PYRAMID: &str =
    "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1.5 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";

/// Runs the command with further arguments, which may contain blanks.
fn run_with(place: &Workplace, arguments: &str, more: &[&str]) -> Outcome {
    Outcome::new(arguments, place.command(arguments).args(more).output().unwrap())
}

fn number(document: &Value, key: &str) -> f64 {
    document[key].as_f64().unwrap_or_else(|| panic!("{key}: {document}"))
}

#[test]
fn the_directions_of_a_light() {
    let place = Workplace::new();
    let run = |sampler: &str| {
        let arguments = format!("render cornell --integral light --sampler {sampler} -n 64 --json");
        place.run(&format!("{arguments} {SMALL}")).json()
    };
    let light = run("sobol:warp=light");
    assert_keys(&light, &["mse", "mse_stderr", "firefly", "firefly_stderr", "variance_reduction"]);
    assert_eq!(light["sampler"], "sobol:warp=light");
    assert_eq!((&light["mode"], &light["estimator"]), (&"shifted".into(), &"unbiased".into()));
    assert_eq!((light["n"].as_u64(), light["reference_n"].as_u64()), (Some(64), Some(625)));
    let triangles = run("sobol:warp=triangles");
    let uniform = run("jittered");
    for document in [&light, &triangles] {
        // The light covers a few per cent of the hemisphere.
        let (mse, of_uniform) = (number(document, "mse"), number(&uniform, "mse"));
        assert!(50.0 * mse < of_uniform, "{mse:e} {of_uniform:e}");
        // 1 % of correct programs have a biased pixel; the seed is fixed.
        assert_eq!(document["biased_pixels"], 0, "{document}");
        let (mean, expected) = (number(document, "mean"), number(&uniform, "mean"));
        assert!((mean / expected - 1.0).abs() < 0.05, "{mean} {expected}");
        assert!(number(document, "firefly") > 1.0, "{document}");
    }
    assert_eq!(place.names_in("cache").len(), 2, "one reference for densities");
}

/// The map of the density has the orientation of the sky, with its own parameters and with `--up`.
#[test]
fn the_density_of_a_sky_has_its_orientation() {
    let place = Workplace::new();
    place.write("sky.exr", small_exr(8, 4));
    place.write("pyramid.obj", PYRAMID);
    for (options, up) in [
        ("", ""),
        (",mirror=yes", ""),
        (",rotate=70", "--up 0,-1,0 --eye 3,3,3"),
        (",up=z", "--up 1,1,0 --eye 3,3,3"),
    ] {
        let sky = format!("env:sky.exr{options}");
        let sampler = format!("jittered-square:warp=\"{sky}\"");
        let integral = format!("--integral irradiance:env=sky.exr{options}");
        let arguments = format!("render pyramid.obj {integral} {up} {SMALL} -n 144 --json");
        let document = run_with(&place, &arguments, &["--sampler", &sampler]).json();
        // A wrong orientation gives the same mean, because weights are 1/p, but a larger error: the
        // texels are 1 to 32.
        assert_eq!(document["biased_pixels"], 0, "{options} {document}");
        let both = format!("jittered-square:warp=\"0.5 * cosine + 0.5 * {sky}\",heuristic=power");
        let several = run_with(&place, &arguments, &["--sampler", &both]).json();
        assert_eq!((several["n"].as_u64(), &several["biased_pixels"]), (Some(128), &0.into()));
        assert!(number(&several, "variance_reduction") > 1.5, "{options} {several}");
    }
}

#[test]
fn studies_and_sheets_take_densities() {
    let place = Workplace::new();
    let samplers = "sobol:warp=light,white-noise,jittered-square:warp=\"cosine + light\"";
    let arguments = format!("render cornell --integral light -m 4 {SMALL} --quiet");
    let words = |more: &str, last: &[&str]| run_with(&place, &format!("{arguments} {more}"), last);
    let study = words("--study -n 16,64 --json", &["--samplers", samplers]).json();
    let rows = study["rows"].as_array().unwrap();
    let names: Vec<&str> = rows.iter().map(|row| row["sampler"].as_str().unwrap()).collect();
    // Uniform directions come first.
    assert_eq!(names[..4], ["white-noise", "white-noise", "sobol:warp=light", "sobol:warp=light"]);
    assert!(number(&rows[2], "mse") < 0.1 * number(&rows[0], "mse"), "{study}");
    assert_eq!(rows[4]["n"], 18, "9 points for each of two densities");
    let table = words("--study -n 16", &["--samplers", samplers]).ok().stdout;
    assert!(table.contains("firefly") && table.contains("sobol:warp=light"), "{table}");
    let panels = "reference,jittered@rotated,sobol:warp=light";
    let sheet = words("-n 16 --json -o s.png", &["--sheet", panels]).json();
    let panels = sheet["panels"].as_array().unwrap();
    assert_eq!((&panels[0]["mode"], &panels[1]["mode"]), (&"rotated".into(), &"shifted".into()));
    assert!(image::open(place.path("s.png")).unwrap().width() > 72);
}

/// The built-in probe, whose file need not exist.
#[test]
fn the_probe_of_the_examples_lights_a_mesh() {
    let place = Workplace::new();
    place.write("pyramid.obj", PYRAMID);
    let integral = "--integral irradiance:env=data/city.exr";
    let run = |sampler: &str| {
        place
            .run(&format!("render pyramid.obj {integral} {SMALL} -n 96 --json --sampler {sampler}"))
    };
    let (cosine, uniform) = (run("sobol:warp=cosine").json(), run("jittered").json());
    assert_eq!(cosine["biased_pixels"], 0, "{cosine}");
    assert!(1.5 * number(&cosine, "mse") < number(&uniform, "mse"), "{cosine} {uniform}");
}

#[test]
fn threads_do_not_show() {
    let run = |threads: u32| {
        let place = Workplace::new();
        let arguments = "render cornell --integral light --sampler r2:warp=light -n 20 -o p.pfm";
        place.run(&format!("{arguments} --size 20 --threads {threads}")).ok();
        place.bytes("p.pfm")
    };
    assert!(run(1) == run(2), "one thread and two give different bytes");
}

/// One per cent of the lit pixels are white by default, or another share.
#[test]
fn exposure_is_a_percentile_of_the_lit_pixels() {
    let place = Workplace::new();
    let bright = |white: &str| {
        let arguments = "render cornell --integral light --sampler sobol:warp=light -n 4 -o p.png";
        place.run(&format!("{arguments} --size 40 {white}")).ok();
        let picture = image::open(place.path("p.png")).unwrap().into_luma8();
        let lit = picture.pixels().filter(|p| p.0[0] > 0).count();
        picture.pixels().filter(|p| p.0[0] == 255).count() as f64 / lit as f64
    };
    let automatic = bright("");
    assert!((0.008..0.02).contains(&automatic), "{automatic}");
    assert!((bright("--white 99%") - automatic).abs() < 1e-12);
    let upper = bright("--white 60%");
    assert!((0.39..0.43).contains(&upper), "{upper}");
    assert!(bright("--white 100%") < 0.005 && bright("--white 9") < 1e-12);
}

#[test]
fn usage_errors_are_reported() {
    let place = Workplace::new();
    place.write("sky.exr", small_exr(8, 4));
    let run = |sampler: &str, more: &str| {
        let arguments = format!("render cornell --size 8 --cache none {more}");
        run_with(&place, &arguments, &["--sampler", sampler])
    };
    let sky = "--integral irradiance:env=sky.exr";
    run("sobol:warp=light", sky).fails(2, &["requires --integral light"]);
    run("sobol:warp=light", "").fails(2, &["requires --integral light"]);
    run("sobol:warp=lamp", "--integral light").fails(2, &["lamp"]);
    run("sobol:warp=\"2 * light\"", "--integral light").fails(2, &["remove the number"]);
    run("sobol:warp=\"2 * light + cosine\"", "--integral light").fails(2, &["or none"]);
    run("sobol:warp=\"-1 * light + 1 * cosine\"", "--integral light")
        .fails(2, &["positive number"]);
    run("sobol:warp=light,heuristic=power", "--integral light").fails(2, &["has one"]);
    run("sobol:warp=\"light + cosine\",heuristic=best", "--integral light")
        .fails(2, &["unknown heuristic"]);
    run("sobol:warp=\"env:sky.exr * cosine\"", sky)
        .fails(2, &["its own normal", "\"env:sky.exr + cosine\""]);
    run("sobol:warp=cap:degrees=60", "").fails(2, &["25.00 % of the integral is lost"]);
    run("jittered:warp=cosine", "").fails(2, &["jittered"]);
    run("sobol:warp=\"env:no.exr\"", sky).fails(1, &["no.exr"]);
    run("sobol:warp=cosine", "--mode shared").fails(2, &["--mode requires a sampler of uniform"]);
    run("sobol:warp=cosine", "--estimator ratio").fails(2, &["--estimator requires"]);
    run("r2:warp=cosine", "--sets 4").fails(2, &["--sets requires"]);
    run("sobol:warp=cosine", "--reference-count 0 --mse").fails(2, &["at least 1 point"]);
    for white in ["0", "-3", "0%", "101%", "nan", "bright"] {
        run("sobol:warp=cosine", &format!("-o p.png --white {white}"))
            .fails(2, &["--white must be a number above 0"]);
    }
    let panel = "render cornell --sheet sobol:warp=cosine@shared -o s.png";
    place.run(panel).fails(2, &["have no mode"]);
    assert_eq!(place.names(), ["sky.exr"]);
}
