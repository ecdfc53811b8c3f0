//! `variance` and `compare` with patterns of the square that are mapped to a density.

use serde_json::Value;

use crate::outcome::{Outcome, keys, same};
use crate::workplace::{Workplace, small_exr};

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} of {row}"))
}

fn rows(document: &Value) -> &[Value] {
    document["rows"].as_array().unwrap()
}

/// Runs a command whose last arguments contain blanks.
fn run(place: &Workplace, arguments: &str, last: &[&str]) -> Outcome {
    let mut command = place.command(arguments);
    command.args(last);
    Outcome::new(&format!("{arguments} {last:?}"), command.output().unwrap())
}

/// Points of density cos(theta)/pi integrate the cosine without an error, and with the uniform
/// density of `cylinder`, independent points have the variance of white noise.
#[test]
fn densities_decide_the_variance() {
    let place = Workplace::new();
    let samplers = "white-noise,white-square:warp=cylinder,sobol:warp=cosine,r2:warp=cylinder";
    let run = format!("variance {samplers} --hemisphere -n 64 --integrand cosine -m 300 --json");
    let document = place.run(&run).json();
    let rows = rows(&document);
    let names: Vec<&str> = rows.iter().map(|row| row["sampler"].as_str().unwrap()).collect();
    assert_eq!(names, samplers.split(',').collect::<Vec<_>>());
    let [white, uniform, cosine, r2] = [0, 1, 2, 3].map(|i| &rows[i]);
    let pi = std::f64::consts::PI;
    for row in rows {
        assert_eq!((&row["domain"], &row["n"]), (&"hemisphere".into(), &64.into()));
        assert!(same(number(row, "exact"), pi), "{row}");
    }
    // Var(2 pi u) = pi^2/3 for a height u, uniform in [0, 1).
    let expected = pi * pi / 3.0 / 64.0;
    for row in [white, uniform] {
        let got = number(row, "predicted");
        assert!((got / expected - 1.0).abs() < 1e-6, "{row}");
        // Exceeded by chance for 6e-7 of seeds.
        assert!(number(row, "z").abs() < 5.0, "{row}");
    }
    for key in ["predicted", "measured"] {
        assert!(number(cosine, key) < 1e-25 * pi * pi, "{cosine}");
    }
    // Shifts wrap around, so the jump from the pole to the horizon remains.
    assert!(number(r2, "predicted") < 0.2 * expected, "{r2}");
    assert!(number(r2, "z").abs() < 5.0, "{r2}");
    // cos(theta)/p is 2 pi cos(theta), largest at the pole.
    assert!(number(uniform, "largest_ratio") <= 2.0 * pi * (1.0 + 1e-12), "{uniform}");
    assert!(number(uniform, "largest_ratio") > 1.9 * pi, "{uniform}");
    assert!(number(uniform, "largest_ratio_theta") < 20.0, "{uniform}");
    // Half of the points exceed half of it, so every trial sees them.
    assert_eq!(uniform["largest_ratio_trials"], 300);
    assert!(!keys(white).contains(&"largest_ratio"), "{white}");
}

/// Rows depend neither on the other samplers nor on the number of threads, and files have the
/// columns of densities only where a row has them.
#[test]
fn rows_are_those_of_single_runs() {
    let place = Workplace::new();
    place.write("map.exr", small_exr(8, 4));
    let integrand = "env:map.exr * cosine";
    let samplers =
        ["fibonacci", "jittered-square:warp=\"env:map.exr,floor=0.1\"", "sobol:warp=cosine"];
    let with = |samplers: &str, threads: &str| {
        let arguments = format!("variance --hemisphere -n 16 -m 50 --json {threads} --integrand");
        run(&place, &arguments, &[integrand, samplers]).json()
    };
    let all = with(&samplers.join(","), "-j 1");
    assert_eq!(rows(&all).len(), 3);
    assert_eq!(rows(&all), rows(&with(&samplers.join(","), "-j 3")));
    for (sampler, row) in samplers.iter().zip(rows(&all)) {
        let alone = with(sampler, "");
        assert_eq!(rows(&alone), std::slice::from_ref(row), "{sampler}");
        assert!(number(row, "z").abs() < 5.0, "{row}");
    }
    for (samplers, has_density) in [(samplers[0], false), (samplers[1], true)] {
        let arguments = "variance --hemisphere -n 16 -m 50 -o v.csv --integrand";
        run(&place, arguments, &[integrand, samplers]).ok();
        assert_eq!(place.text("v.csv").contains("largest_ratio"), has_density, "{samplers}");
    }
}

/// All channels are estimated from the same directions, each with the row that it has alone.
#[test]
fn channels_have_the_rows_of_single_runs() {
    let place = Workplace::new();
    place.write("map.exr", small_exr(8, 4));
    let with = |channel: &str| {
        let integrand = format!("env:map.exr,channel={channel}");
        let sampler = "sobol:warp=\"1 * cylinder + 3 * env:map.exr,interpolation=constant\"";
        let arguments = "variance -n 16 -m 40 --json --until-rel 20% --integrand";
        run(&place, arguments, &[&integrand, sampler]).json()
    };
    let all = with("rgb");
    let channels = ["r", "g", "b", "luminance"].into_iter().zip(rows(&all));
    assert_eq!(rows(&all).len(), 4);
    for (channel, row) in channels.skip(1).step_by(2) {
        assert_eq!(rows(&with(channel)), std::slice::from_ref(row));
        assert_eq!(row["largest_ratio_strategy"].as_u64().map(|s| s == 1 || s == 2), Some(true));
    }
}

#[test]
fn a_comparison_has_uniform_and_warped_patterns() {
    let place = Workplace::new();
    let arguments = "--integrand vmf:kappa=20 -n 16,64 -m 60 -o out";
    let mixed = "compare white-noise,sobol:warp=vmf:kappa=10,r2:warp=octahedral";
    let output = place.run(&format!("{mixed} {arguments}")).ok();
    for part in ["max f/p", "Best density: sobol", "white noise of uniform density"] {
        assert!(output.stdout.contains(part), "{part}: {}", output.stdout);
    }
    assert!(place.text("out/spectra.svg").contains("warped patterns, which have no angular"));
    let spectra = place.text("out/spectra.csv");
    assert!(spectra.contains("white-noise,16") && !spectra.contains("\nsobol"), "{spectra}");
    assert!(place.text("out/comparison.csv").contains("largest_ratio"));
    // White noise of the warped pattern is that of the sphere.
    let document: Value = serde_json::from_str(&place.text("out/comparison.json")).unwrap();
    let samplers = document["samplers"].as_array().unwrap();
    let power = |i: usize| number(&samplers[i], "effective_power");
    let of_rows = |i: usize| number(&rows(&document)[i], "predicted");
    assert!((power(1) * of_rows(1) / of_rows(3) - 1.0).abs() < 1e-9, "{document}");
    // Without a uniform pattern there are no spectra, and those of the other run are removed.
    place.run(&format!("compare r2:warp=octahedral {arguments} --force")).ok();
    let names = place.names_in("out");
    assert!(!names.iter().any(|name| name == "spectra.svg" || name == "spectra.png"), "{names:?}");
    assert!(names.iter().any(|name| name == "variance.svg"), "{names:?}");
}

#[test]
fn errors_of_warps_state_what_is_right() {
    let place = Workplace::new();
    let cosine = "--hemisphere --integrand cosine -n 16";
    for (arguments, parts) in [
        ("variance healpix:warp=cosine", ["pattern of the sphere", "jittered-square"]),
        ("variance sobl:warp=cosine", ["\"sobl\"", "sobol"]),
        ("variance sobol:warp=cosin", ["cosin", "cosine"]),
        ("variance sobol:warp=cosine,size=3", ["size", "sobol"]),
        ("variance jittered-square:warp=cosine -n 18", ["16", "--nearest"]),
        ("variance sobol:warp=cosine --lmax 8", ["--lmax", "sobol:warp=cosine"]),
        ("variance sobol:warp=cosine --no-rotate", ["--no-rotate", "shifted"]),
        ("variance fibonacci,sobol:warp=cosine --visible-half", ["--visible-half", "sobol"]),
        ("variance sobol:warp=cosine -n 0", ["0", "points"]),
    ] {
        let arguments = match arguments.contains(" -n ") {
            true => format!("{arguments} --hemisphere --integrand cosine"),
            false => format!("{arguments} {cosine}"),
        };
        place.run(&arguments).fails(2, &parts);
    }
    let project = "variance r2:warp=cylinder --project 1 --integrand cosine -n 16";
    place.run(project).fails(2, &["--project", "r2:warp=cylinder", "ylm"]);
    let missing = "variance sobol:warp=env:missing.exr --integrand cosine -n 16";
    place.run(missing).fails(1, &["missing.exr"]);
    // The cosine warp has no points below the horizon.
    let lost = "variance sobol:warp=cosine --integrand vmf:kappa=1 -n 16";
    place.run(lost).fails(1, &["density is 0", "%"]);
}

/// Commands for homogeneous patterns, or for the square itself, reject warps.
#[test]
fn other_commands_name_the_option_for_the_square() {
    let place = Workplace::new();
    for command in [
        "spectrum sobol:warp=cosine -n 16",
        "audit sobol:warp=cosine -n 16",
        "bounds sobol:warp=cosine -n 16",
        "quality sobol:warp=cosine -n 16",
        "integrate --sampler sobol:warp=cosine --integrand cosine",
        "spectrum sobol:warp=cosine -n 16 --square",
        "variance sobol:warp=cosine -n 16 --square --integrand disk:radius=0.3",
    ] {
        place.run(command).fails(2, &["sobol:warp=cosine", "--square", "warp="]);
    }
}

/// A remark on a file is one line of the command, however often the map is read and for whatever.
#[test]
fn remarks_on_maps_are_printed_once() {
    let place = Workplace::new();
    let texel = |x, y| if (x, y) == (3, 2) { -3.0 } else { 1.0 };
    place.write("sky.exr", crate::workplace::grey_exr(8, 4, texel));
    let warps = "sobol:warp=env:sky.exr,r2:warp=\"env:sky.exr,interpolation=constant\"";
    let map = "--integrand env:sky.exr";
    for arguments in [
        format!("variance fibonacci,{warps} -n 4 -m 4 {map}"),
        format!("variance {warps} -n 4 -m 4 {map},channel=rgb"),
        format!("compare {warps} -n 4 -m 4 {map}"),
        format!("choose -n 4 --samplers white-noise,{warps} {map}"),
        "sample sobol:warp=env:sky.exr -n 4".to_owned(),
        format!("lights sky.exr -n 4 -m 2 --samplers {warps},median-cut"),
        "render cornell -n 4 --size 8 --integral irradiance:env=sky.exr --sampler sobol:warp=env:sky.exr -o a.exr".to_owned(),
    ] {
        let message = place.run(&arguments).ok().stderr;
        assert_eq!(message.matches("texels are negative").count(), 1, "{arguments}: {message}");
        assert!(message.contains("densities their magnitudes"), "{arguments}: {message}");
    }
}

/// Parameters of a warp belong to its text, which commas end.
#[test]
fn parameters_of_warps_without_quotes_are_explained() {
    let place = Workplace::new();
    place.write("sky.exr", small_exr(8, 4));
    for command in [
        "variance {} -n 4 --integrand env:sky.exr",
        "sample {} -n 4",
        "render cornell -n 4 --sampler {} --integral irradiance:env=sky.exr",
        "choose --samplers {} -n 4 --integrand env:sky.exr",
        "lights sky.exr --samplers {}",
    ] {
        let arguments = command.replace("{}", "sobol:warp=env:sky.exr,floor=0.1");
        place.run(&arguments).fails(2, &[r#"sobol:warp="env:sky.exr,floor=0.1""#]);
    }
    place
        .run("variance sobol:warp=cosine,exponent=2 -n 4 --integrand cosine")
        .fails(2, &["exponent", "unknown parameter"]);
}

/// What a sampler cannot do is said once, with the reason.
#[test]
fn mistakes_in_densities_are_explained() {
    let place = Workplace::new();
    for (sampler, message) in [
        ("ccvt:density=nothing", "unknown warp"),
        ("ccvt:density=cosine,capacity=0", "capacity must be at least 1"),
        ("sobol:warp=cosine,heuristic=power", "is for a sum of warps"),
        ("sobol:warp=", "the parameter warp is missing"),
        ("sobol:warp=cosine --method exact", "--method does not apply to sobol:warp=cosine"),
    ] {
        for command in ["variance", "compare"] {
            let arguments = format!("{command} {sampler} -n 4 --integrand cosine");
            let outcome = place.run(&arguments);
            let name = sampler.split(' ').next().unwrap();
            assert!(outcome.stderr.matches(name).count() <= 1, "{}", outcome.stderr);
            outcome.fails(2, &[message]);
        }
    }
    place.run("choose ccvt:density=cosine -n 4 --integrand cosine").fails(2, &["no spectrum"]);
    place.run("sample ccvt:density=cosine -n 4").fails(2, &["lights writes"]);
    place.run("spectrum sobol:warp=cosine -n 4").fails(2, &["render and lights"]);
}

/// Tessellations for a density have a measured variance, a mean and the reason why there is no
/// prediction.
#[test]
fn tessellations_for_a_density_are_measured() {
    let place = Workplace::new();
    let density = "ccvt:density=cosine,capacity=16";
    let arguments = format!(
        "variance {density},white-square:warp=cosine --hemisphere -n 16 --integrand phong:n=2 -m 200 --json"
    );
    let document = place.run(&arguments).json();
    let [adapted, white] = rows(&document) else { panic!("{document}") };
    assert_eq!(adapted["sampler"], density);
    for key in ["predicted", "predicted_stderr", "predicted_low", "ratio", "z"] {
        assert!(adapted[key].is_null(), "{key}: {adapted}");
    }
    assert!(adapted["remark"].as_str().unwrap().contains("no spectrum predicts"), "{adapted}");
    // Well separated points of the same density and weights.
    let measured = number(adapted, "measured");
    assert!(measured < 0.5 * number(white, "predicted") && measured > 0.0, "{adapted}");
    assert!(
        number(adapted, "measured_low") < measured && number(adapted, "measured_high") > measured
    );
    assert!((number(adapted, "mean") / number(adapted, "exact") - 1.0).abs() < 0.2, "{adapted}");
    assert!(!adapted["bias_z"].is_null(), "{adapted}");
    let one_thread = place.run(&format!("{arguments} -j 1")).json();
    assert_eq!(rows(&one_thread), rows(&document));
    let table = place.run(&arguments.replace(" --json", "")).ok().stdout;
    assert!(table.contains("no spectrum predicts"), "{table}");
    let compared =
        format!("compare {density},jittered --hemisphere -n 8,16 -m 30 --integrand phong:n=2");
    let table = place.run(&compared).ok().stdout;
    assert!(table.contains("no spectrum predicts"), "{table}");
    // The density is 0 below the horizon.
    place.run(&format!("variance {density} -n 16 --integrand vmf:kappa=1")).fails(1, &["is lost"]);
}
