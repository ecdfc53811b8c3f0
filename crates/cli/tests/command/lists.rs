//! `sphvar list`: the contents of the registries, as text and as JSON.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::grammar::needs_file;
use crate::workplace::Workplace;

fn entries<'d>(document: &'d Value, kind: &str) -> &'d Vec<Value> {
    document[kind].as_array().unwrap()
}

fn named<'d>(document: &'d Value, kind: &str, name: &str) -> &'d Value {
    entries(document, kind).iter().find(|entry| entry["name"] == name).unwrap()
}

#[test]
fn samplers_show_rates_and_every_parameter() {
    let place = Workplace::new();
    let text = place.run("list samplers").ok().stdout;
    let words: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "variance exact for smooth integrands, N^-1.5 for those with jumps",
        "radius minimum chord times sqrt(N), on the hemisphere times sqrt(2N): finite and above 0; default by N",
        "mode=exact exactly N points, or the number at which the set is saturated: exact, saturated",
        "mass=fibonacci what the mass points are: white, fibonacci, healpix",
        "core=0.3 minimum distance in units of a hexagonal lattice's: in [0, 0.95]",
        "last empty degree 10 for N = 100, 31 for N = 1000, 100 for N = 10000",
        "N 12 nside^2 (12, 48, 108, ...); on the hemisphere 6 nside^2 (6, 24, 54, ...)",
        "cost N log N per step",
        "sets always the same, up to rotation",
        "sets independent uniform points; a sequence, the first points of a set are a set",
    ] {
        assert!(words.contains(part), "no {part:?} in:\n{text}");
    }
    assert!(!text.contains("N^exact") && !text.contains("N^as"), "{text}");
    let text = place.run("list samplers step -n 9").ok().stdout;
    assert!(text.contains("2 for N = 9") && !text.contains("spiral"), "{text}");
}

#[test]
fn every_list_fits_a_terminal() {
    let place = Workplace::new();
    for arguments in ["list", "list samplers", "list integrands", "list warps", "list formats"] {
        let text = place.run(arguments).ok().stdout;
        let longest = text.lines().max_by_key(|line| line.chars().count()).unwrap();
        assert!(longest.chars().count() <= 80, "{arguments}: {longest}");
        assert!(text.lines().count() > 10, "{arguments}: {text}");
    }
}

/// Listed parameters are accepted, with their defaults, and missing required ones are reported.
#[test]
fn listed_parameters_are_taken() {
    let place = Workplace::new();
    let document = place.run("list --json").json();
    for entry in entries(&document, "samplers") {
        let name = entry["name"].as_str().unwrap();
        if needs_file(entry) {
            place.run(&format!("sample {name} -n 12")).fails(2, &["the file is missing"]);
            continue;
        }
        for parameter in entries(entry, "parameters") {
            let key = parameter["name"].as_str().unwrap();
            for value in entries_or_default(parameter) {
                // A number of points for which every value is feasible.
                place.run(&format!("sample {name}:{key}={value} -n 48 --nearest")).ok();
            }
        }
    }
    for entry in entries(&document, "integrands") {
        let name = entry["name"].as_str().unwrap();
        let example = entry["example"].as_str().unwrap();
        if example.contains("FILE") {
            continue;
        }
        let run = |integrand: &str| {
            place.run(&format!("variance fibonacci -n 4 -m 4 --integrand {integrand}"))
        };
        run(example).ok();
        for parameter in entries(entry, "parameters") {
            if parameter["required"] == true {
                let key = parameter["name"].as_str().unwrap();
                let (_, given) = example.split_once(':').unwrap();
                let is_other = |item: &&str| !item.starts_with(&format!("{key}="));
                let others: Vec<&str> = given.split(',').filter(is_other).collect();
                let text = [name, &others.join(",")].join(":");
                run(&text).fails(2, &[&format!("the parameter {key} is missing")]);
            }
        }
    }
}

/// Returns the named values of a parameter, or its default if it has one.
fn entries_or_default(parameter: &Value) -> Vec<String> {
    match (&parameter["values"], &parameter["default"]) {
        // The masses of HEALPix need a matching number of points.
        (Value::Array(values), _) => values
            .iter()
            .map(|value| value.as_str().unwrap().to_owned())
            .filter(|value| value != "healpix")
            .collect(),
        (_, Value::Number(number)) => vec![number.to_string()],
        _ => Vec::new(),
    }
}

#[test]
fn warps_show_their_parameters() {
    let place = Workplace::new();
    let overview = place.run("list").ok().stdout;
    assert!(overview.contains("Warps") && overview.contains("\n  octahedral"), "{overview}");
    let text = place.run("list warps env").ok().stdout;
    let words: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "interpolation=bilinear between texel centres, as the integrand, or constant",
        "floor=0 share of the uniform density mixed in",
        "in [0, 1)",
        "channel luminance, r, g, b or a channel's name in the file; default luminance",
    ] {
        assert!(words.contains(part), "no {part:?} in:\n{text}");
    }
    assert!(!text.contains("cylinder"), "{text}");
    let document = place.run("list warps --json").json();
    assert_eq!(named(&document, "warps", "vmf")["example"], "vmf:kappa=10");
    assert!(document.get("formats").is_none());
    place.run("list warps cosin").fails(2, &["unknown warp \"cosin\"", "\"cosine\""]);
}

#[test]
fn documents_have_facts_as_numbers() {
    let place = Workplace::new();
    let document = place.run("list --json").json();
    let riesz = named(&document, "samplers", "riesz");
    assert_eq!(riesz["cost"]["exponent"], 1.0);
    assert_eq!(riesz["cost"]["text"], "N log N per step");
    assert_eq!(riesz["smooth_rate"]["exponent"], -2.0);
    assert_eq!(riesz["parameters"][0]["default"], 1.0);
    assert_eq!(riesz["counts"]["sphere"], "any number from 1");
    assert_eq!(named(&document, "samplers", "step")["smooth_rate"]["exponent"], Value::Null);
    assert_eq!(named(&document, "samplers", "fibonacci")["deterministic"], true);
    assert_eq!(named(&document, "samplers", "halton")["extensible"], true);
    let extensions: BTreeSet<&str> = entries(&document, "formats")
        .iter()
        .flat_map(|format| entries(format, "extensions"))
        .map(|extension| extension.as_str().unwrap())
        .collect();
    for extension in ["csv", "npy", "npz", "ply", "fits", "json", "exr", "hdr", "svg", "png"] {
        assert!(extensions.contains(extension), "no {extension} in {extensions:?}");
    }
    let one = place.run("list integrands cap --json").json();
    assert_eq!(entries(&one, "integrands").len(), 1);
    assert!(one.get("samplers").is_none());
}

#[test]
fn mistakes_name_what_there_is() {
    let place = Workplace::new();
    place.run("list samplers sobel").fails(2, &["unknown sampler \"sobel\"", "\"sobol\""]);
    place.run("list sampler").fails(2, &["samplers"]);
    place.run("sample --list").fails(2, &["sphvar list samplers"]);
}
