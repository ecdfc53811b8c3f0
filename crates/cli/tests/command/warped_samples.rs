//! `sphvar sample` with patterns of the square that are mapped to a density.

use std::f64::consts::{PI, TAU};

use crate::outcome::{Outcome, numbers};
use crate::workplace::{Workplace, small_exr};

/// Returns the rows x, y, z, w of a CSV file.
fn rows(text: &str) -> Vec<[f64; 4]> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    assert_eq!(lines.next(), Some("x,y,z,w"), "{text}");
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        <[f64; 4]>::try_from(numbers).unwrap()
    };
    lines.map(row).collect()
}

/// Runs `sphvar sample` with a sampler whose text has spaces.
fn sample(place: &Workplace, sampler: &str, arguments: &str) -> Outcome {
    let output = place.command(&format!("sample {arguments}")).arg(sampler).output().unwrap();
    Outcome::new(sampler, output)
}

fn sum_of_weights(rows: &[[f64; 4]]) -> f64 {
    rows.iter().map(|[.., w]| w).sum()
}

#[test]
fn points_have_the_weights_of_their_density() {
    let place = Workplace::new();
    place.run("sample sobol:warp=cosine -n 64 -m 3 --hemisphere -o s-{i}.csv").ok();
    assert_eq!(place.names(), ["s-000000.csv", "s-000001.csv", "s-000002.csv"]);
    let texts: Vec<String> = place.names().iter().map(|name| place.text(name)).collect();
    assert_ne!(rows(&texts[0]), rows(&texts[1]));
    for text in &texts {
        let rows = rows(text);
        assert_eq!(rows.len(), 64);
        for [_, _, z, w] in &rows {
            // 1/(N p) with the density cos(theta)/pi.
            assert!((w * z * 64.0 / PI - 1.0).abs() < 1e-14, "{z}, {w}");
        }
    }
}

#[test]
fn sums_of_weights_estimate_the_solid_angle() {
    let place = Workplace::new();
    place.write("sky.exr", small_exr(16, 8));
    for (sampler, domain, solid_angle) in [
        ("r2:warp=\"env:sky.exr,floor=0.2\"", "", 2.0 * TAU),
        ("sobol:warp=\"1 * cylinder + 3 * vmf:kappa=4\"", "", 2.0 * TAU),
        ("jittered-square:warp=\"env:sky.exr,floor=0.2 * cosine\"", "--hemisphere", TAU),
    ] {
        let outcome = sample(&place, sampler, &format!("-n 1024 {domain}")).ok();
        let rows = rows(&outcome.stdout);
        assert_eq!(rows.len(), 1024, "{sampler}");
        let sum = sum_of_weights(&rows);
        // Ten times the standard deviation of white noise with these densities, at most.
        assert!((sum / solid_angle - 1.0).abs() < 0.3, "{sampler}: {sum}");
    }
}

#[test]
fn json_and_npz_have_the_points_of_csv() {
    let place = Workplace::new();
    let run = "sample r2:warp=cosine -n 16 -m 2 --hemisphere";
    let document = place.run(&format!("{run} -o - --json")).ok().json();
    let weights = numbers(&document["weights"][1]);
    place.run(&format!("{run} -o s.npz")).ok();
    place.run("sample file:s.npz -o again-{i}.csv").ok();
    let again = rows(&place.text("again-000001.csv"));
    assert_eq!(again.len(), 16);
    for (k, [x, y, z, w]) in again.into_iter().enumerate() {
        // Directions are normalized when they are read.
        for (got, expected) in [x, y, z].iter().zip(numbers(&document["points"][1][k])) {
            assert!((got - expected).abs() < 1e-15, "{k}: {got}, {expected}");
        }
        assert!((w / weights[k] - 1.0).abs() < 1e-15, "{k}");
    }
}

#[test]
fn usage_errors_state_what_is_right() {
    let place = Workplace::new();
    let mixture = "jittered-square:warp=\"cosine + cylinder\"";
    for (status, sampler, arguments, messages) in [
        (2, "sobol:warp=cosine", "-n 16 --hemisphere --rotate", &["--rotate", "shifted"][..]),
        (2, "jittered-square:warp=cosine", "-n 12 --hemisphere", &["--nearest"]),
        (2, mixture, "-n 100 --hemisphere", &["--nearest"]),
        (2, "sobol:warp=cosine", "--hemisphere", &["-n"]),
        (1, "sobol:warp=env:none.exr", "-n 16", &["none.exr"]),
        (2, "sobol:warp=cosine", "--square -n 16", &["warp"]),
    ] {
        sample(&place, sampler, arguments).fails(status, messages);
    }
    let outcome = sample(&place, mixture, "-n 100 --nearest --hemisphere").ok();
    assert_eq!(rows(&outcome.stdout).len(), 98);
    assert!(outcome.stderr.contains("98 points"), "{}", outcome.stderr);
}
