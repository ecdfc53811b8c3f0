//! `variance` and `compare` in parts: `--shard --save` and `merge`.

use crate::workplace::{Workplace, small_exr};

/// Command lines of all modes, without the name of a command.
const MODES: [&str; 12] = [
    "variance jittered,fibonacci,white-noise -n 48,12 --integrand cap:degrees=60 -m 23",
    "variance jittered,healpix -n 48 --hemisphere --nearest --integrand vmf:kappa=9 -m 23 --spectrum-realizations 9",
    "variance jittered,spiral -n 48 --integrand env:map.exr,channel=rgb -m 23 --lmax 40",
    "variance poisson-disk -n 12 --integrand env:map.exr --project 1 -m 23",
    "variance jittered-square,sobol,white-square --square -n 16 --integrand disk:radius=0.3 -m 23",
    "variance fibonacci,sobol:warp=cylinder -n 16 --hemisphere --integrand vmf:kappa=3 -m 23",
    "variance ccvt:density=vmf:kappa=5,capacity=4 jittered -n 12 --integrand vmf:kappa=4 -m 23",
    "variance jittered,fibonacci -n 12 --integrand ylm:l=2,m=0 -m 23 --no-rotate --lmax 8",
    "variance jittered,fibonacci -n 30 --nearest --integrand vmf:kappa=4 -m 40 --rotations super-fibonacci",
    "variance jittered,fibonacci -n 12 --hemisphere --nearest --integrand cosine -m 23 --visible-half=equator",
    "variance jittered,fibonacci -n 48 --integrand env:map.exr --predict-only",
    "variance jittered,fibonacci -n 48 --integrand env:map.exr --measure-only -m 23",
];

fn place() -> Workplace {
    let place = Workplace::new();
    place.write("map.exr", small_exr(16, 8));
    place
}

/// Computes all parts of a command in a mixed order, with one and two threads, and returns the names
/// of their files, in another order.
fn parts(place: &Workplace, command: &str, parts: u64) -> String {
    let mixed = (0..parts).map(|i| (7 * i + 2) % parts + 1);
    for part in mixed {
        let threads = 1 + part % 2;
        // Results of another command are not replaced.
        let _ = std::fs::remove_file(place.path(format!("{part}-of-{parts}")));
        let shard = format!("--shard {part}/{parts} --save {part}-of-{parts} -j {threads} --quiet");
        let outcome = place.run(&format!("{command} {shard}")).ok();
        // A single part reports what it has computed.
        assert_eq!(outcome.stdout.is_empty(), parts > 1, "{command} {shard}");
    }
    let names: Vec<String> = (1..=parts).rev().map(|part| format!("{part}-of-{parts}")).collect();
    names.join(" ")
}

#[test]
fn merged_variances_are_bit_identical_to_one_run() {
    for (i, mode) in MODES.iter().enumerate() {
        let place = place();
        let whole = place.run(&format!("{mode} --json")).ok().stdout;
        // One part, and more parts than trials, for some of the modes.
        let counts: &[u64] = if i % 6 == 0 { &[1, 3, 25] } else { &[3] };
        for &count in counts {
            let files = parts(&place, mode, count);
            let merged = place.run(&format!("merge {files} --json")).ok().stdout;
            assert_eq!(merged, whole, "{mode}, {count} parts");
        }
        assert!(!place.names().iter().any(|name| name.contains("unfinished")), "{mode}");
    }
}

/// Tables and charts in files, and the remarks on the terminal.
#[test]
fn merged_files_are_bit_identical_to_those_of_one_run() {
    let place = place();
    let run = "variance jittered,spiral -n 12,27 --nearest --integrand cap:degrees=60 -m 10";
    for name in ["v.csv", "v.svg"] {
        let said = place.run(&format!("{run} -o {name}")).ok().stdout;
        let whole = place.bytes(name);
        let files = parts(&place, &format!("{run} -o {name}"), 3);
        assert_eq!(place.bytes(name), whole, "a part has written {name}");
        std::fs::remove_file(place.path(name)).unwrap();
        assert_eq!(place.run(&format!("merge {files}")).ok().stdout, said);
        assert!(place.bytes(name) == whole, "{name} differs");
    }
    let files = parts(&place, run, 3);
    let table = place.run(run).ok().stdout;
    assert_eq!(place.run(&format!("merge {files}")).ok().stdout, table);
}

/// The folder of `compare` is written by the merge alone.
#[test]
fn merged_comparisons_have_the_files_of_one_run() {
    for mode in [
        "jittered,fibonacci,sobol:warp=cylinder -n 12 --integrand ylm:l=2,m=0 -m 11 --spectrum-realizations 8",
        "jittered-square,sobol --square -n 16 --integrand exponential:a=1,b=2 -m 11 --kmax 8",
    ] {
        let place = place();
        let run = format!("compare {mode} -o results");
        let said = place.run(&run).ok().stdout;
        std::fs::rename(place.path("results"), place.path("whole")).unwrap();
        let files = parts(&place, &run, 3);
        assert!(!place.names().contains(&"results".to_owned()), "{mode}");
        assert_eq!(place.run(&format!("merge {files}")).ok().stdout, said, "{mode}");
        let names = place.names_in("whole");
        assert_eq!(place.names_in("results"), names, "{mode}");
        assert!(names.len() >= 9, "{names:?}");
        for name in names {
            let [whole, merged] =
                ["whole", "results"].map(|folder| place.bytes(&format!("{folder}/{name}")));
            assert!(whole == merged, "{mode}: {name} differs");
        }
    }
}

#[test]
fn a_partial_merge_has_the_trials_of_its_parts() {
    let place = place();
    let run = "variance fibonacci -n 48 --integrand cap:degrees=60 -m 30";
    parts(&place, run, 3);
    // The first part has the energies, the second one the prediction.
    place.run("merge 1-of-3 3-of-3").fails(1, &["missing: part 2 of 3"]);
    let row = |files: &str| {
        let document = place.run(&format!("merge {files} --partial --json")).json();
        document["rows"][0].clone()
    };
    let (all, some) = (row("1-of-3 2-of-3 3-of-3"), row("2-of-3 3-of-3"));
    assert_eq!((&all["trials"], &some["trials"]), (&30.into(), &20.into()));
    assert_eq!(all["predicted"], some["predicted"]);
    place.run("merge 1-of-3 --partial").fails(1, &["no row", "add other parts"]);
}

#[test]
fn what_cannot_be_divided_is_a_usage_error_with_the_reason() {
    let place = Workplace::new();
    let run = "variance jittered -n 48 --integrand cap:degrees=60 -m 10";
    for shard in ["--save a --shard 1/2", "--save a"] {
        let wrong = format!("{run} --until-rel 10% {shard}");
        place.run(&wrong).fails(2, &["--until-rel", "stops by itself", "-m"]);
    }
    place
        .run("choose --integrand cosine -n 48 --shard 1/2")
        .fails(2, &["choose stops by itself", "compare", "variance"]);
    place.run(&format!("{run} --shard 1/2")).fails(2, &["--save"]);
    assert!(place.names().is_empty(), "{:?}", place.names());
}

/// A spectrum in closed form is a task of one part.
#[test]
fn exact_spectra_are_computed_by_one_part() {
    for (mode, columns) in [
        ("spectrum jittered -n 48 --exact --lmax 12", &["power", "stderr", "l"][..]),
        ("spectrum jittered-square --square -n 16 --exact --kmax 6", &["power", "k1"][..]),
    ] {
        let place = Workplace::new();
        let whole = place.run(&format!("{mode} --json")).json();
        let files = parts(&place, mode, 3);
        let merged = place.run(&format!("merge {files} --json")).json();
        for column in columns {
            assert!(!whole[column].is_null(), "{mode}: {column}");
            assert_eq!(merged[column], whole[column], "{mode}: {column}");
        }
    }
}
