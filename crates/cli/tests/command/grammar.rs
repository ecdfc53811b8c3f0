//! The common grammar of samplers, integrands and profiles.

use crate::workplace::{Workplace, small_exr};

#[test]
fn every_sampler_of_the_list_works() {
    let place = Workplace::new();
    let list = place.run("list samplers --json").json();
    let names: Vec<&str> = list["samplers"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|entry| !needs_file(entry))
        .map(|entry| entry["name"].as_str().unwrap())
        .collect();
    for name in ["white-noise", "jittered", "healpix", "fibonacci"] {
        assert!(names.contains(&name), "{names:?}");
    }
    let table = place.run("list").ok().stdout;
    for name in &names {
        assert!(table.contains(name), "{table}");
        place.run(&format!("sample {name} -n 12 --nearest")).ok();
        place.run(&format!("sample {name}: -n 6 --nearest --hemisphere")).ok();
    }
    let all = names.join(",");
    let few = "-m 4 --spectrum-realizations 4";
    let document = place
        .run(&format!("variance {all} -n 12 --nearest --integrand ylm:l=2 {few} --json"))
        .json();
    assert_eq!(document["rows"].as_array().unwrap().len(), names.len());
}

/// Returns whether a listed sampler has a parameter without a default.
pub(crate) fn needs_file(entry: &serde_json::Value) -> bool {
    entry["parameters"].as_array().unwrap().iter().any(|parameter| parameter["required"] == true)
}

#[test]
fn every_integrand_works_and_keeps_its_name() {
    let place = Workplace::new();
    place.write("map.exr", small_exr(16, 8));
    for (integrand, exact) in [
        ("ylm:l=4", Some(0.0)),
        ("ylm:m=-3,l=4", Some(0.0)),
        ("cap:degrees=60", Some(std::f64::consts::PI)),
        ("cap:degrees=180", Some(4.0 * std::f64::consts::PI)),
        ("vmf:kappa=10", None),
        ("vmf:kappa=0.5", None),
        ("cosine", Some(std::f64::consts::PI)),
        ("env:map.exr", None),
        ("env:file=map.exr", None),
        ("env:map.exr,channel=g", None),
        ("env:map.exr,channel=luminance", None),
    ] {
        let document = place
            .run(&format!("variance fibonacci -n 20 --integrand {integrand} -m 4 --json"))
            .json();
        let row = &document["rows"][0];
        assert_eq!(row["integrand"], integrand);
        if let Some(exact) = exact {
            let got = row["exact"].as_f64().unwrap();
            assert!((got - exact).abs() < 1e-14, "{integrand}: {got}, not {exact}");
        }
    }
}

#[test]
fn every_profile_works() {
    let place = Workplace::new();
    for profile in [
        "constant",
        "step",
        "linear:alpha=0.5",
        "quadratic:gamma=2,alpha=1",
        "poly:b=3.5",
        "poly:b=2,alpha=0.5,gamma=1,offset=0.1",
    ] {
        place.run(&format!("bounds --profile {profile} -n 100 --json")).json();
        place.run(&format!("eval profile --profile {profile} -n 100 --lmax 5 --json")).json();
    }
}

#[test]
fn flags_may_precede_or_follow_the_subcommand() {
    let place = Workplace::new();
    let first = place.run("--seed 9 --json sample white-noise --count 3").ok().stdout;
    let last = place.run("sample white-noise -n 3 -s 9 --json").ok().stdout;
    let points =
        |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap()["points"].clone();
    assert_eq!(points(&first), points(&last));
}
