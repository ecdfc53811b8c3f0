//! The documents of `--json` conform to docs/schema.json.

use serde_json::Value;

use crate::workplace::{Workplace, data};

/// Returns whether a value has one of the types that a schema names.
fn has_type(value: &Value, name: &str) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("an unknown type: {other}"),
    }
}

/// Collects the violations of a schema by a value, with their paths. Keys that the schema does not
/// describe are violations. Only the keywords of docs/schema.json are supported; another one causes
/// a panic.
fn check(root: &Value, schema: &Value, value: &Value, path: &str, faults: &mut Vec<String>) {
    let fault = |text: String| format!("{path}: {text}, got {value}");
    let Some(schema) = schema.as_object() else {
        assert_eq!(schema, &Value::Bool(true), "{path}");
        return;
    };
    for (keyword, expected) in schema {
        match keyword.as_str() {
            "description" | "format" | "$schema" | "title" => (),
            "type" => {
                let names = expected.as_array().map_or(vec![expected], |all| all.iter().collect());
                if !names.iter().any(|name| has_type(value, name.as_str().unwrap())) {
                    faults.push(fault(format!("expected {expected}")));
                }
            }
            "minimum" => {
                if value.as_f64().is_some_and(|x| x < expected.as_f64().unwrap()) {
                    faults.push(fault(format!("expected at least {expected}")));
                }
            }
            "maximum" => {
                if value.as_f64().is_some_and(|x| x > expected.as_f64().unwrap()) {
                    faults.push(fault(format!("expected at most {expected}")));
                }
            }
            "minItems" | "maxItems" => {
                let (got, limit) = (value.as_array().map(Vec::len), expected.as_u64().unwrap());
                let is_beyond = |n: usize| {
                    if keyword == "minItems" { (n as u64) < limit } else { n as u64 > limit }
                };
                if got.is_some_and(is_beyond) {
                    faults.push(fault(format!("{keyword} {expected}")));
                }
            }
            "required" => {
                let names = expected.as_array().unwrap().iter().map(|name| name.as_str().unwrap());
                for name in names.filter(|name| value.is_object() && value.get(name).is_none()) {
                    faults.push(fault(format!("{name} is missing")));
                }
            }
            "properties" => {
                for (key, value) in value.as_object().into_iter().flatten() {
                    let path = format!("{path}/{key}");
                    match expected.get(key) {
                        Some(schema) => check(root, schema, value, &path, faults),
                        None => faults.push(format!("{path}: not in the schema")),
                    }
                }
            }
            // The schema of keys without a fixed name, such as those of a map.
            "additionalProperties" => {
                for (key, value) in value.as_object().into_iter().flatten() {
                    check(root, expected, value, &format!("{path}/{key}"), faults);
                }
            }
            "items" => {
                for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                    check(root, expected, item, &format!("{path}/{i}"), faults);
                }
            }
            "prefixItems" => {
                let schemas = expected.as_array().unwrap();
                for (i, (item, schema)) in
                    value.as_array().into_iter().flatten().zip(schemas).enumerate()
                {
                    check(root, schema, item, &format!("{path}/{i}"), faults);
                }
            }
            "anyOf" => {
                let all = expected.as_array().unwrap().iter().map(|schema| {
                    let mut own = Vec::new();
                    check(root, schema, value, path, &mut own);
                    own
                });
                // The alternative with the fewest violations is the most informative.
                faults.extend(all.min_by_key(Vec::len).unwrap_or_default());
            }
            "$ref" => {
                let pointer = expected.as_str().unwrap().strip_prefix('#').unwrap();
                let schema =
                    root.pointer(pointer).unwrap_or_else(|| panic!("{pointer} is nowhere"));
                check(root, schema, value, path, faults);
            }
            other => panic!("{path}: an unknown keyword: {other}"),
        }
    }
}

fn root() -> Value {
    serde_json::from_str(include_str!("../../../../docs/schema.json")).unwrap()
}

/// Returns the violations of the schema of a command by a document.
pub(crate) fn faults(command: &str, document: &Value) -> Vec<String> {
    faults_of("documents", command, document)
}

/// Returns the violations of a schema of the section `documents` or `files`.
pub(crate) fn faults_of(section: &str, name: &str, document: &Value) -> Vec<String> {
    let (root, mut faults) = (root(), Vec::new());
    let schema = &root[section][name];
    assert!(schema.is_object(), "the schema has no {name}");
    check(&root, schema, document, name, &mut faults);
    faults
}

/// At least one document of every command in the schema is checked.
#[test]
fn documents_fit_their_schema() {
    let place = Workplace::new();
    place.run("sample jittered -n 12 -m 40 --rotate -o p.npy").ok();
    place.write("weighted.csv", "x,y,z,w\n1,0,0,1\n0,1,0,2\n0,0,1,3\n");
    place.write("pixels.csv", "0\n1\n");
    place.run("spectrum poisson-disk -n 24 -m 4 --lmax 4 --shard 1/2 --save a.shard").ok();
    place.run("spectrum poisson-disk -n 24 -m 4 --lmax 4 --shard 2/2 --save b.shard").ok();
    place.run("spectrum sobol --square -n 8 -m 4 --kmax 3 --shard 1/2 --save c.shard").ok();
    place.run("spectrum sobol --square -n 8 -m 4 --kmax 3 --shard 2/2 --save d.shard").ok();
    let spectrum = "spectrum jittered -n 12 -m 4";
    place.run(&format!("plan --shards 1 --for shell -o done -- {spectrum}")).ok();
    place.run(&format!("{spectrum} --shard 1/1 --save done/parts/0001.shard")).ok();
    place.run("merge done --log done/logs/merge.jsonl").ok();
    place.write("square.csv", "u,v,w\n0.5,0.25,1\n0,0.75,-3\n");
    let render = "render cornell --size 6 --reference-count 150 --cache none";
    let stars = data("stars.csv");
    let runs: Vec<(&str, String)> = [
        ("--shard", "spectrum jittered -n 12 -m 4 --shard 1/2 --save e.shard"),
        ("accuracy", "accuracy weights --quick"),
        ("audit", "audit jittered -n 12 -m 30 --lmax 3 --alpha 0.1"),
        ("audit", "audit --points p.npy --lmax 3 --alpha 0.1"),
        ("audit", "audit healpix -n 12 -m 30 --lmax 3 --alpha 0.2"),
        ("bounds", "bounds --profile step -n 5"),
        ("bounds", "bounds jittered -n 48 -m 30 --integrand ylm:l=2"),
        ("bounds", "bounds healpix -n 54 --hemisphere"),
        (
            "choose",
            "choose --integrand cap:degrees=60 --error 5% --samplers jittered,healpix,white-noise",
        ),
        ("choose", "choose --integrand cap:degrees=60 -n 100 --samplers jittered,fibonacci"),
        ("choose", "choose --integrand ylm:l=0 -n 12 --samplers jittered"),
        ("compare", "compare jittered,fibonacci -n 12,48 --integrand cap:degrees=60 -m 20 -o out"),
        ("eval cap-power", "eval cap-power --degrees 60 --lmax 4"),
        ("eval legendre", "eval legendre --l 4 --m 3 --theta 0"),
        ("eval profile", "eval profile --profile step -n 64 --lmax 9"),
        ("eval ylm", "eval ylm --l 4 --m -3 --theta 1.1 --phi 0.2"),
        ("healpix", "healpix pix2vec --nside 2 pixels.csv"),
        ("healpix", "healpix pix2ang --degrees --nside 2 pixels.csv"),
        ("healpix", "healpix ring2nest --nside 2 pixels.csv"),
        ("integrate", "integrate --integrand cosine --rtol 1%"),
        ("lights", "lights data/city.exr -n 8 -m 2"),
        ("lights", "lights data/city.exr -n 4,8 --samplers median-cut"),
        ("list", "list"),
        ("list", "list samplers step poisson-disk -n 100"),
        ("list", "list --square"),
        ("plan", "plan spectrum jittered -n 12 -m 4 --shards 2 --for shell -o job"),
        ("plan status", "plan status done"),
        ("progressive", "progressive sobol,white-noise -n 20 --integrand cap:degrees=60 -m 20"),
        ("progressive", "progressive halton -n 4,8 --integrand ylm:l=1 -m 20 --no-rotate"),
        ("progressive", "progressive r2 --square -n 6 --integrand disk:radius=0.3 -m 20"),
        ("quality", "quality fibonacci -n 60"),
        ("quality", "quality jittered -n 12 -m 2 --rank --hemisphere --nearest"),
        ("quality --square", "quality sobol,square.csv --square -n 8"),
        ("quality --square", "quality jittered-square --square -n 9 -m 3"),
        ("reproduce", "reproduce 3.1 C.1 --quick -o thesis"),
        ("sample", "sample white-noise -n 5 -m 2"),
        ("sample", "sample step -n 20 -o s.csv"),
        ("sample", "sample file:square.csv --square"),
        ("spectrum --square", "spectrum jittered-square --square -n 16 -m 3 --kmax 4"),
        ("spectrum --square", "spectrum --points square.csv --square --kmax 3"),
        ("spectrum --square", "spectrum jittered-square --square -n 16 --kmax 1 --exact"),
        ("spectrum --square", "merge d.shard c.shard"),
        ("spectrum", "spectrum jittered -n 12 -m 4"),
        ("spectrum", "merge a.shard b.shard"),
        ("spectrum", "spectrum jittered -n 6 -m 1 --hemisphere"),
        ("spectrum", "spectrum --points weighted.csv --lmax 4"),
        ("spectrum", "spectrum poisson-disk -n 12 -m 4 --pairs --density cap:degrees=180"),
        ("spectrum", "spectrum --points weighted.csv --lmax 4 --pairs --density weights --bins 5"),
        ("variance", "variance jittered -n 12 --integrand cap:degrees=60 -m 20"),
        (
            "variance --no-rotate",
            "variance jittered,fibonacci,white-noise -n 12 --integrand cosine -m 20 --no-rotate",
        ),
        ("variance", "variance white-noise -n 12 --integrand vmf:kappa=1e6 -m 10"),
        ("weights", "weights weighted.csv --degree 0"),
        ("weights", "weights weighted.csv --degree 0 --nonnegative -o w.csv"),
        (
            "variance",
            "variance jittered -n 24 --hemisphere --integrand cosine -m 20 --visible-half=equator",
        ),
        (
            "variance",
            "variance jittered -n 24 --hemisphere --integrand cosine -m 20 --visible-half",
        ),
    ]
    .into_iter()
    .map(|(command, arguments)| (command, arguments.to_owned()))
    .chain([
        ("rotations", "rotations uniform,sukharev:weights=cell -n 20 --kappa 2".to_owned()),
        ("rotations -o", "rotations healpix-hopf -n 72 -o rotations.csv".to_owned()),
        (
            "variance --rotations",
            "variance fibonacci -n 12 --integrand cap:degrees=60 --rotations uniform -m 64"
                .to_owned(),
        ),
        ("spectrum", format!("spectrum --points {stars} --lmax 4")),
        ("fit", format!("fit {stars} --columns ra,dec,value --lmax 2")),
        ("render", format!("{render} --sampler jittered -n 24 -m 2")),
        ("render", format!("{render} --sampler jittered -n 24 -m 1")),
        ("render --sheet", format!("{render} --sheet reference,healpix@shared -n 24 -o sheet.png")),
        ("render --study", format!("{render} --study --samplers jittered -n 6,24,54 -m 3")),
    ])
    .collect();
    for (command, arguments) in &runs {
        let document = place.run(&format!("{arguments} --json")).json();
        let faults = faults(command, &document);
        assert!(faults.is_empty(), "sphvar {arguments} --json\n{faults:#?}");
    }
    let root = root();
    let untried = root["documents"].as_object().unwrap().keys();
    let untried: Vec<_> = untried.filter(|name| runs.iter().all(|(c, _)| c != name)).collect();
    assert!(untried.is_empty(), "{untried:?}");
}

/// Violations are detected: a missing key, an additional key, and values of other types.
#[test]
fn other_documents_do_not_fit() {
    let place = Workplace::new();
    let document = place.run("variance jittered -n 12 --integrand ylm:l=2 -m 10 --json").json();
    assert_eq!(faults("variance", &document), Vec::<String>::new());
    let changed = |change: &dyn Fn(&mut Value)| {
        let mut document = document.clone();
        change(&mut document);
        faults("variance", &document)
    };
    let row = |document: &mut Value, key: &str, value: Value| document["rows"][0][key] = value;
    for (faults, place) in [
        (changed(&|d| row(d, "n", "12".into())), "variance/rows/0/n: expected"),
        (changed(&|d| row(d, "n", (-1).into())), "variance/rows/0/n: expected at least 0"),
        (changed(&|d| row(d, "new", 1.into())), "variance/rows/0/new: not in the schema"),
        (changed(&|d| row(d, "trials", Value::Null)), "variance/rows/0/trials: expected"),
        (changed(&|d| d["provenance"] = Value::Null), "variance/provenance: expected"),
        (changed(&|d| _ = d.as_object_mut().unwrap().remove("rows")), "variance: rows is missing"),
    ] {
        assert_eq!(faults.len(), 1, "{faults:?}");
        assert!(faults[0].starts_with(place), "{faults:?}");
    }
}
