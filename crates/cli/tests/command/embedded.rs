//! The command inside another program answers as the process does.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::Value;
use sphvar_cli::embedding::{FailureKind, PointTable, Session};
use sphvar_samplers::{ProfileTable, Progress, Stopped};

use crate::workplace::{Workplace, small_exr};

/// Stops work at a tick, and counts the ticks.
struct StopsAt {
    tick: usize,
    ticks: AtomicUsize,
}

impl Progress for StopsAt {
    fn tick(&self, _work: f64) -> Result<(), Stopped> {
        let before = self.ticks.fetch_add(1, Ordering::Relaxed);
        if before >= self.tick { Err(Stopped) } else { Ok(()) }
    }
}

fn session() -> Session {
    Session::new(Arc::new(()))
}

fn words(text: &str) -> Vec<String> {
    text.split_whitespace().map(str::to_owned).collect()
}

#[track_caller]
fn answer(session: &Session, text: &str) -> Value {
    let document = session.answer(&words(text)).unwrap_or_else(|e| panic!("{text}: {e}"));
    assert!(document.ends_with("}\n"), "{text}: {document}");
    serde_json::from_str(&document).unwrap_or_else(|e| panic!("{text}: {e}"))
}

/// Sets what differs between runs to null: times and the command.
fn without_times(mut value: Value) -> Value {
    match &mut value {
        Value::Object(fields) => {
            for (key, field) in fields {
                let is_time = key.contains("seconds") || key == "command";
                *field = if is_time { Value::Null } else { without_times(field.take()) };
            }
        }
        Value::Array(items) => {
            items.iter_mut().for_each(|item| *item = without_times(item.take()));
        }
        _ => {}
    }
    value
}

/// A directions file with weights and values, and the same as an array.
fn points(place: &Workplace) -> PointTable {
    let direction = |i: usize| {
        let z = -0.95 + 0.1 * i as f64;
        let (sin, cos) = (2.4 * i as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * cos, r * sin, z]
    };
    let rows: Vec<[f64; 3]> = (0..20).map(direction).collect();
    let weights: Vec<f64> = (0..20).map(|i| 1.0 + 0.05 * i as f64).collect();
    let values: Vec<f64> = rows.iter().map(|[x, _, z]| 1.0 + x - 0.5 * z).collect();
    let text = |header: &str, last: &[f64]| {
        let line = |([x, y, z], last): (&[f64; 3], &f64)| format!("{x},{y},{z},{last}\n");
        header.to_owned() + &rows.iter().zip(last).map(line).collect::<String>()
    };
    place.write("weighted.csv", text("x,y,z,w\n", &weights));
    place.write("values.csv", text("x,y,z,value\n", &values));
    PointTable {
        coordinates: rows.concat(),
        dimension: 3,
        weights: Some(weights),
        values: Some(values),
        ..PointTable::default()
    }
}

/// Returns a question of every command with a document, with little work and all kinds of output.
fn questions() -> Vec<&'static str> {
    vec![
        "choose jittered,healpix,sobol:warp=vmf:kappa=5 --integrand vmf:kappa=5 --error 5%",
        "choose jittered-square --square --integrand disk:radius=0.3 -n 64",
        "spectrum jittered -n 12 -m 20 --lmax 8",
        "spectrum jittered-square --square -n 16 -m 4",
        "variance jittered,sobol:warp=cosine --hemisphere --integrand cosine -n 24 -m 30 --nearest",
        "variance jittered-square --square -n 16 -m 30 --integrand disk:radius=0.3",
        "progressive halton --integrand cap:degrees=60 -n 1..8 -m 20",
        "integrate --integrand vmf:kappa=5",
        "bounds jittered -n 12 --integrand cap:degrees=60",
        "audit jittered -n 12 -m 60",
        "quality healpix,white-noise -n 12 -m 4",
        "quality jittered-square --square -n 16 -m 4",
        "rotations uniform -n 3 -m 2",
        "rotations uniform,super-fibonacci -n 8 -m 2 --kappa 2",
        "lights env:data/city.exr -n 4 --samplers jittered -m 2 --nearest",
        "list samplers",
        "list integrands",
        "eval legendre --l 3 --m 1 --theta 0.5",
    ]
}

#[test]
fn answers_are_those_of_the_process() {
    let place = Workplace::new();
    for question in questions() {
        let process = place.run(&format!("{question} --json")).json();
        let session = session();
        let embedded = answer(&session, question);
        assert_eq!(embedded["provenance"]["command"], process["provenance"]["command"]);
        assert_eq!(without_times(embedded), without_times(process), "{question}");
    }
    assert_eq!(place.names(), [""; 0], "no files");
    let compare = "compare jittered,halton -n 12,48 --integrand cosine -m 30";
    let process = place.run(&format!("{compare} -o out --json")).json();
    assert_eq!(without_times(answer(&session(), compare)), without_times(process));
}

#[test]
fn errors_have_the_words_of_the_process() {
    let place = Workplace::new();
    let missing = place.path("missing.csv");
    let missing = missing.display();
    place.write("bad.csv", "x,y,z\n1,0,0\n0,x,1\n");
    let bad = place.path("bad.csv");
    let bad = bad.display();
    for (text, kind) in [
        ("choose nosuch --integrand cosine -n 8".to_owned(), FailureKind::Usage),
        ("choose --integrand cosine --error 150".to_owned(), FailureKind::Usage),
        ("bounds white-noise -n 1T".to_owned(), FailureKind::Usage),
        ("variance jittered -n 12".to_owned(), FailureKind::Usage),
        ("spectrum jittered -n 13".to_owned(), FailureKind::Usage),
        ("spectrum jittered --nosuch 3".to_owned(), FailureKind::Usage),
        ("nosuch".to_owned(), FailureKind::Usage),
        (format!("spectrum --points {missing}"), FailureKind::File),
        (format!("quality file:{bad}"), FailureKind::File),
        (format!("integrate --integrand map:{missing}"), FailureKind::File),
        ("spectrum white-noise -n 1e15 -m 1".to_owned(), FailureKind::Memory),
    ] {
        let failure = session().answer(&words(&text)).unwrap_err();
        assert_eq!(failure.kind, kind, "{text}: {failure}");
        // Messages of the parser have several lines, and the usage after them.
        let stderr = place.run(&text).stderr;
        let stderr = stderr.split_whitespace().collect::<Vec<_>>().join(" ");
        let message = &failure.message;
        assert!(stderr.starts_with(&format!("error: {message}")), "{text}: {failure}\n{stderr}");
        assert!(!failure.message.contains("Usage"), "{failure}");
    }
}

#[test]
fn options_that_write_files_are_rejected() {
    for text in [
        "spectrum jittered -n 12 -o s.csv",
        "spectrum jittered -n 12 --save s.bin",
        "compare jittered -n 12 -o out",
        "integrate --integrand cosine --nodes n.csv",
        "choose --integrand cosine -n 12 -j 2",
        "sample jittered -n 12",
        "render jittered -n 12",
        "completions bash",
    ] {
        let failure = session().answer(&words(text)).unwrap_err();
        assert_eq!(failure.kind, FailureKind::Usage, "{text}: {failure}");
    }
}

#[test]
fn arrays_are_read_as_files() {
    let place = Workplace::new();
    let table = points(&place);
    let session = session();
    let unvalued = PointTable { values: None, ..table.clone() };
    let unweighted = PointTable { weights: None, ..table };
    session.add_points("weighted", unvalued).unwrap();
    session.add_points("values", unweighted).unwrap();
    place.write("map.exr", small_exr(8, 4));
    // The file has equal red, green and blue.
    let texels = (0..32).flat_map(|i| [f64::from(1 + i); 3]).collect();
    session.add_picture("map", 8, 4, texels).unwrap();
    place.write("energies.csv", "l,energy\n0,1\n1,0.5\n2,0.25\n");
    session.add_energies("energies", vec![1.0, 0.5, 0.25], None).unwrap();
    // The random streams of a profile depend on its name, so the file has that of the array.
    place.write("profile", "l,power\n0,0\n1,0.5\n2,1\n");
    session.add_profile("profile", ProfileTable::Powers(vec![0.0, 0.5, 1.0]));
    for (question, files) in [
        ("spectrum --points weighted", &["weighted"][..]),
        ("quality file:weighted", &["weighted"]),
        ("variance file:weighted -n 20 --integrand cosine -m 20", &["weighted"]),
        ("bounds file:weighted", &["weighted"]),
        ("weights weighted --degree 2", &["weighted"]),
        ("fit values --lmax 2", &["values"]),
        ("integrate --integrand values:values,lmax=2", &["values"]),
        ("integrate --integrand env:map", &["map"]),
        ("variance jittered -n 12 -m 20 --integrand env:map,channel=rgb", &["map"]),
        ("variance jittered-square --square -n 16 -m 20 --integrand image:map", &["map"]),
        ("variance jittered -n 12 -m 20 --integrand energy:energies", &["energies"]),
        ("spectrum profile:profile -n 12 -m 2 --lmax 4", &[]),
    ] {
        let mut with_files = question.to_owned();
        for file in files {
            let extension = if *file == "map" { "exr" } else { "csv" };
            for before in [":", " "] {
                let name = format!("{before}{file}.{extension}");
                for after in [" ", ",", ""] {
                    let (from, to) = (format!("{before}{file}{after}"), format!("{name}{after}"));
                    if !with_files.contains(&name)
                        && (!after.is_empty() || with_files.ends_with(&from))
                    {
                        with_files = with_files.replace(&from, &to);
                    }
                }
            }
        }
        let process = place.run(&format!("{with_files} --json"));
        assert_eq!(process.status, Some(0), "{with_files}: {}", process.stderr);
        // Results name their inputs, and are otherwise the same.
        let text = process.stdout.replace(".csv", "").replace(".exr", "");
        let process: Value = serde_json::from_str(&text).unwrap();
        let embedded = answer(&session, question);
        assert_eq!(without_times(embedded), without_times(process), "{question}");
    }
}

#[test]
fn maps_and_coefficients_are_read() {
    let session = session();
    session.add_map("map", vec![2.0; 48], true).unwrap();
    session.add_coefficients("alm", &[[1.0, 0.0], [0.5, 0.0], [0.25, -0.125]]).unwrap();
    let area = 4.0 * std::f64::consts::PI;
    let map = answer(&session, "integrate --integrand map:map");
    assert!((map["value"].as_f64().unwrap() / (2.0 * area) - 1.0).abs() < 1e-3, "{map}");
    let alm = answer(&session, "integrate --integrand alm:alm");
    assert!((alm["value"].as_f64().unwrap() / area.sqrt() - 1.0).abs() < 1e-3, "{alm}");
    assert!(session.add_map("bad", vec![0.0; 47], false).is_err());
    assert!(session.add_coefficients("bad", &[[0.0; 2]; 4]).is_err());
    assert!(session.add_picture("bad", 3, 3, vec![0.0; 10]).is_err());
}

#[test]
fn invalid_content_of_arrays_is_a_usage_error() {
    let table = |coordinates: &[f64], dimension, sets| PointTable {
        coordinates: coordinates.to_vec(),
        dimension,
        sets,
        ..PointTable::default()
    };
    let nan = f64::NAN;
    let several = [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, nan, 1.0, 0.0, 1.0, 0.0];
    let session = session();
    session.add_points("nan", table(&several, 3, None)).unwrap();
    session.add_points("sets", table(&several, 3, Some(2))).unwrap();
    session.add_points("none", table(&[], 3, None)).unwrap();
    session.add_points("below", table(&[0.0, 0.0, -1.0], 3, None)).unwrap();
    session.add_points("square", table(&[0.5, 1.5], 2, None)).unwrap();
    session.add_points("good", table(&several[..6], 3, None)).unwrap();
    session.add_map("map", vec![nan; 12], false).unwrap();
    session.add_energies("energies", vec![1.0, -1.0], None).unwrap();
    for (text, message) in [
        ("spectrum --points nan", "nan[2]: y: expected a finite number, got NaN"),
        ("spectrum --points sets", "sets[1, 0]: y: expected a finite number, got NaN"),
        ("quality file:nan", "nan[2]: y: expected a finite number, got NaN"),
        ("spectrum --points none", "none: no points"),
        ("quality file:below --hemisphere", "below"),
        ("spectrum --square --points square", "square[0]: v: expected"),
        ("spectrum --points good --columns x,y,z", "good: --columns is for files"),
        ("spectrum file:good,columns=\"x,y,z\" -m 1", "good: columns is for files"),
        ("spectrum --points square", "square"),
        ("integrate --integrand map:map", "map: 12 pixels of the map have no value"),
        ("integrate --integrand map:map,field=1", "map: field is for files"),
        ("variance jittered -n 12 --integrand energy:energies", "energies[1]: energy: expected"),
    ] {
        let failure = session.answer(&words(text)).unwrap_err();
        assert!(failure.message.contains(message), "{text}: {failure}");
        assert_eq!(failure.kind, FailureKind::Usage, "{text}: {failure}");
    }
    for wrong in [
        table(&several[..5], 3, None),
        table(&several, 4, None),
        table(&several, 3, Some(3)),
        table(&several, 3, Some(0)),
        PointTable { weights: Some(vec![1.0]), ..table(&several, 3, None) },
        PointTable { values: Some(vec![]), ..table(&several, 3, None) },
    ] {
        let failure = session.add_points("wrong", wrong.clone()).unwrap_err();
        assert_eq!(failure.kind, FailureKind::Usage, "{wrong:?}: {failure}");
    }
}

#[test]
fn remarks_are_collected() {
    let session = session();
    let table = PointTable {
        coordinates: [0.0, 0.0, 1.1].repeat(4),
        dimension: 3,
        ..PointTable::default()
    };
    session.add_points("longer", table).unwrap();
    let failure = session.answer(&words("spectrum --points longer")).unwrap_err();
    assert_eq!(failure.kind, FailureKind::Usage);
    answer(&session, "quality jittered -n 13 --nearest -m 2");
    let remark = "jittered: 12 points, the valid count nearest to the requested 13";
    assert_eq!(session.remarks(), [remark]);
}

#[test]
fn progress_stops_every_command() {
    let place = Workplace::new();
    let table = points(&place);
    let more = [
        "compare jittered,halton -n 12,48 --integrand cosine -m 30",
        "weights points --degree 2",
        "fit points --lmax 2",
    ];
    let without_work = ["list", "eval", "rotations uniform -n 3 -m 2", "integrate"];
    for question in questions().into_iter().chain(more) {
        let run = |tick| {
            let progress = Arc::new(StopsAt { tick, ticks: AtomicUsize::new(0) });
            let session = Session::new(Arc::clone(&progress) as _);
            session.add_points("points", PointTable { weights: None, ..table.clone() }).unwrap();
            let result = session.answer(&words(question));
            (result, progress.ticks.load(Ordering::Relaxed))
        };
        let (result, all) = run(usize::MAX);
        result.unwrap_or_else(|e| panic!("{question}: {e}"));
        if without_work.iter().any(|start| question.starts_with(start)) && all == 0 {
            continue;
        }
        assert!(all > 0, "{question} reports no work");
        for tick in [0, all / 2] {
            let (result, ticks) = run(tick);
            let failure = result.expect_err(question);
            assert_eq!(failure.kind, FailureKind::Stopped, "{question}: {failure}");
            // Other threads end at their own next ticks.
            assert!(
                ticks <= tick + 64,
                "{question}: {ticks} ticks after a stop at {tick} of {all}"
            );
        }
    }
}
