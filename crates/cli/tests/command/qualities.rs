//! The subcommand `quality`.

use serde_json::Value;

use crate::outcome::assert_keys;
use crate::workplace::Workplace;

const RECORD: [&str; 19] = [
    "sampler",
    "domain",
    "n",
    "n_effective",
    "realizations",
    "separation",
    "covering_radius",
    "mesh_ratio",
    "cap_discrepancy_l2",
    "generalized_discrepancy",
    "worst_case_error",
    "riesz_energy",
    "stderr",
    "scaled",
    "exact_degree",
    "condition",
    "hyperuniformity",
    "p_value",
    "rank",
];

fn number(document: &Value, path: &str) -> f64 {
    document.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {document}"))
}

/// The vertices of the icosahedron, the best packing of 12 points, as a file.
#[test]
fn a_file_is_measured_as_it_is() {
    let place = Workplace::new();
    let golden = 0.5 + 1.25f64.sqrt();
    let mut text = "x,y,z\n".to_owned();
    let norm = (1.0 + golden * golden).sqrt();
    for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        let (a, b) = (a / norm, b / norm);
        text += &format!("0,{a:?},{b:?}\n{a:?},{b:?},0\n{b:?},0,{a:?}\n");
    }
    place.write("icosahedron.csv", text);
    let document = place.run("quality icosahedron.csv --lmax 1,2,3 --json").json();
    let mut keys = RECORD.to_vec();
    keys.extend(["remarks", "provenance"]);
    assert_keys(&document, &keys);
    assert_eq!(
        (&document["sampler"], &document["n"]),
        (&"file:icosahedron.csv".into(), &12.into())
    );
    for (path, expected, error) in [
        ("/n_effective", 12.0, 1e-12),
        ("/separation", 1.051_462_224_238, 1e-11),
        ("/covering_radius", 0.640_851_820_171, 1e-11),
        ("/mesh_ratio", 1.218_972_599_107, 1e-11),
        ("/riesz_energy/1", 49.165_253_058, 1e-8),
        ("/exact_degree", 5.0, 0.0),
        ("/condition/1", 1.0, 1e-6),
        ("/condition/2", 1.0, 1e-6),
    ] {
        let got = number(&document, path);
        assert!((got - expected).abs() <= error, "{path}: {got}, {expected}");
    }
    // 16 harmonics to degree 3 are more than 12 points; 12 points have no range of low degrees.
    for path in ["/condition/3", "/hyperuniformity/class", "/stderr", "/rank"] {
        assert!(document.pointer(path).is_some_and(Value::is_null), "{path}: {document}");
    }
    let remarks = document["remarks"].to_string();
    assert!(remarks.contains("16 harmonics to degree 3 exceed 12 points"), "{remarks}");
    let text = place.run("quality icosahedron.csv").ok().stdout;
    for part in ["mesh ratio", "1.219", "worst-case error, s = 1.5", "exact degree"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn several_sets_are_side_by_side() {
    let place = Workplace::new();
    let arguments = "quality jittered,fibonacci -n 48 -m 3";
    let document = place.run(&format!("{arguments} --json -o a.csv")).json();
    assert_keys(&document, &["rows", "provenance"]);
    let rows = document["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    // A lattice has one realization.
    assert_eq!((&rows[0]["realizations"], &rows[1]["realizations"]), (&3.into(), &1.into()));
    assert!(number(&rows[0], "/stderr/separation") > 0.0 && rows[1]["stderr"].is_null());
    let csv = place.text("a.csv");
    let lines: Vec<&str> = csv.lines().skip(1).collect();
    assert!(lines[0].starts_with("sampler,n,measure,value,stderr,scaled,power"), "{csv}");
    assert_eq!(lines.len(), 1 + 2 * 12);
    let text = place.run(&format!("{arguments} -j 1 -o q.svg")).ok().stdout;
    assert_eq!(text, place.run(&format!("{arguments} -j 2")).ok().stdout);
    let picture = place.text("q.svg");
    for part in ["white noise", "mesh", "s = 4", "healpix", "jittered"] {
        assert!(picture.contains(part), "{part}");
    }
}

#[test]
fn ranks_are_among_all_patterns() {
    let place = Workplace::new();
    let rank = |text: &str| {
        let document = place.run(&format!("quality {text} -n 24 --rank --json --quiet")).json();
        document["rank"].clone()
    };
    let (lattice, white) = (rank("fibonacci"), rank("white-noise"));
    let of = lattice["of"].as_u64().unwrap();
    assert!(lattice["cap_discrepancy_l2"].as_u64().unwrap() <= of / 3, "{lattice}");
    assert_eq!(white["cap_discrepancy_l2"].as_u64(), Some(of), "{white}");
    assert_eq!(lattice["patterns"].as_array().unwrap().len() as u64, of - 1);
}

/// Repeated points, a single point, weights of both signs.
#[test]
fn what_cannot_be_given_is_null() {
    let place = Workplace::new();
    place.write("one.csv", "x,y,z\n0,0,1\n");
    place.write("odd.csv", "x,y,z,w\n0,0,1,1\n0,0,1,2e300\n1,0,0,-0.5\n0,0,-1,1e3\n0,1,0,3\n");
    for domain in ["", " --hemisphere"] {
        let one = place.run(&format!("quality one.csv --json{domain}")).json();
        assert!(one["separation"].is_null() && one["mesh_ratio"].is_null());
        assert!(one["p_value"]["cap_discrepancy_l2"].is_null());
        let odd = place.run(&format!("quality file:odd.csv,fold=yes --json{domain}")).json();
        assert!(number(&odd, "/separation").abs() <= 0.0 && odd["mesh_ratio"].is_null());
        assert!(odd["riesz_energy"].as_object().unwrap().values().all(Value::is_null));
        assert!((number(&odd, "/n_effective") - 1.0).abs() < 1e-9);
    }
    for (arguments, part) in [
        ("quality fibonacci", "-n/--count"),
        ("quality fibonacci -n 20 -m 0", "-m must be at least 1"),
        ("quality fibonacci -n 20 --lmax 1e9", "largest degree"),
        ("quality healpix -n 20", "--nearest"),
        ("quality no-such.csv -n 20", "no-such.csv"),
    ] {
        place.run(arguments).fails(2, &[part]);
    }
}
