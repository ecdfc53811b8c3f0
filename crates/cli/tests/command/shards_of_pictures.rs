//! Parts of `sample`, `render --study` and `reproduce`, which are merged to the bytes of one run.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::workplace::Workplace;

/// Computes all parts of a run in another order than theirs, with one or two threads, and returns
/// the names of their files.
fn parts(place: &Workplace, run: &str, count: usize) -> String {
    let mut names = Vec::new();
    for k in 0..count {
        // 7 and 5 have no divisor in common with 1, 3 and 16.
        let part = (7 * k + 5) % count + 1;
        let name = format!("{part}of{count}.shard");
        let threads = 1 + k % 2;
        place.run(&format!("{run} --shard {part}/{count} --save {name} -j {threads} --quiet")).ok();
        names.push(name);
    }
    names.join(" ")
}

/// Returns the files of a folder and its folders, except those of `--save`.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            all.extend(files(&path).into_iter().map(|(below, b)| (format!("{name}/{below}"), b)));
        } else if !name.ends_with(".shard") {
            all.insert(name, fs::read(path).unwrap());
        }
    }
    all
}

/// Asserts that two folders have the same files with the same bytes.
#[track_caller]
fn assert_same(merged: &Workplace, whole: &Workplace, what: &str) {
    let [merged, whole] = [merged, whole].map(|place| files(&place.path("")));
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&merged), names(&whole), "{what}");
    for (name, bytes) in &whole {
        assert!(merged[name] == *bytes, "{what}: {name} differs");
    }
}

#[test]
fn sets_in_parts_have_the_bytes_of_one_run_in_every_form() {
    // Weights, numbers of points that vary, fewer sets than parts, and points of the square.
    for (run, forms) in [
        ("sample r2:warp=cosine --hemisphere -n 9 -m 5", &["s.npz", "s-{i}.npz", "s.svg"][..]),
        ("sample jittered -n 12 -m 7 --rotate", &["s.npy", "s.csv", "s.ply", "s-{i}.csv", "-"]),
        ("sample sobol --square -n 8 -m 3 --shift", &["s.csv", "s.png"]),
    ] {
        for count in [1, 3, 16] {
            for form in forms {
                let [whole, merged] = [Workplace::new(), Workplace::new()];
                let run = format!("{run} -o {form}");
                if count == 16 && *form != forms[0] {
                    continue;
                }
                let out = whole.run(&run).ok().stdout;
                let names = parts(&merged, &run, count);
                if count > 1 {
                    let written = files(&merged.path(""));
                    assert!(written.is_empty(), "{run}: {:?}", written.keys());
                }
                assert_eq!(merged.run(&format!("merge {names}")).ok().stdout, out, "{run}");
                assert_same(&merged, &whole, &run);
            }
        }
    }
}

#[test]
fn documents_and_messages_of_sets_are_those_of_one_run() {
    let place = Workplace::new();
    let run = "sample step:alpha=1 -n 20 -m 3";
    let whole = place.run(&format!("{run} --json")).ok();
    let names = parts(&place, run, 3);
    let merged = place.run(&format!("merge {names} --json")).ok();
    assert_eq!(merged.stdout, whole.stdout);
    let last = whole.stderr.lines().last().unwrap();
    assert!(last.contains("no power at degrees") && merged.stderr.contains(last), "{last}");
    let part = place.run(&format!("{run} --shard 2/3 --save part.shard")).ok();
    assert!(!part.stderr.contains("no power"), "{}", part.stderr);
    assert!(part.stdout.is_empty(), "{}", part.stdout);
    // Numbers of sets are those of the whole run where some are missing.
    place.run("merge 3of3.shard 1of3.shard --partial -o s-{i}.csv").ok();
    assert!(place.names().contains(&"s-000002.csv".to_owned()), "{:?}", place.names());
    assert!(!place.names().contains(&"s-000001.csv".to_owned()), "{:?}", place.names());
}

#[test]
fn sets_of_a_file_are_divided_too() {
    let [whole, merged] = [Workplace::new(), Workplace::new()];
    for place in [&whole, &merged] {
        place.write("sets.csv", "x,y,z,set\n1,0,0,0\n0,1,0,1\n0,0,1,1\n-1,0,0,2\n");
    }
    let run = "sample file:sets.csv -o copy.ply";
    whole.run(run).ok();
    let names = parts(&merged, run, 3);
    merged.run(&format!("merge {names}")).ok();
    assert_same(&merged, &whole, run);
}

/// A study of a deterministic pattern, a random one, and one of densities.
const STUDY: &str = "render cornell --integral light --study --samplers fibonacci,jittered,sobol:warp=light \
     -n 6,24 -m 4 --size 20x17 --crop 2,1,16,15 --reference-count 64";

/// Returns a document without the time of rays and the command.
fn without_times(mut document: Value) -> Value {
    let map = document.as_object_mut().unwrap();
    map.remove("seconds").unwrap();
    map.remove("provenance").unwrap();
    document
}

#[test]
fn a_study_in_parts_has_the_bytes_of_one_run_in_every_form() {
    let [whole, merged] = [Workplace::new(), Workplace::new()];
    let document = without_times(whole.run(&format!("{STUDY} --cache none --json")).json());
    for form in ["s.csv", "s.svg"] {
        whole.run(&format!("{STUDY} --cache none -o {form}")).ok();
    }
    for count in [1, 3, 16] {
        let run = format!("{STUDY} --cache none");
        let names = parts(&merged, &run, count);
        let found = without_times(merged.run(&format!("merge {names} --json")).json());
        assert_eq!(found, document, "{count} parts");
        for form in ["s.csv", "s.svg"] {
            merged.run(&format!("merge {names} -o {form}")).ok();
        }
        assert_same(&merged, &whole, &format!("{count} parts"));
    }
    merged
        .run("merge 1of3.shard 3of3.shard --partial")
        .fails(1, &["do not have all rows of the reference image"]);
}

/// The reference image of a cache is the same as a rendered one.
#[test]
fn a_study_takes_rows_of_a_stored_reference_image() {
    let place = Workplace::new();
    let run = format!("{STUDY} --cache cache");
    let document = without_times(place.run(&format!("{run} --json")).json());
    let stored = files(&place.path("cache"));
    assert_eq!(stored.len(), 1);
    let names = parts(&place, &run, 3);
    // The merge needs no cache.
    fs::remove_dir_all(place.path("cache")).unwrap();
    let merged = place.run(&format!("merge {names} --json")).json();
    assert_eq!(without_times(merged), document);
}

#[test]
fn one_picture_has_no_parts() {
    let place = Workplace::new();
    let shard = "--shard 1/2 --save x";
    for run in [
        "render cornell --sampler jittered --size 16",
        "render cornell --sheet reference,jittered --size 16 -o sheet.png",
    ] {
        place.run(&format!("{run} {shard}")).fails(2, &["--study", "--crop"]);
    }
    assert_eq!(place.names(), Vec::<String>::new());
}

/// A figure of closed forms, and one of two ensembles.
const FIGURES: &str = "reproduce C.1 4.10 --quick -o out";

#[test]
fn figures_in_parts_have_the_bytes_of_one_run() {
    let whole = Workplace::new();
    let text = whole.run(FIGURES).ok().stdout;
    let document = whole.run(&format!("{FIGURES} --json")).ok().stdout;
    for count in [1, 3, 16] {
        let merged = Workplace::new();
        let names = parts(&merged, FIGURES, count);
        assert_eq!(merged.path("out").exists(), count == 1);
        assert_eq!(merged.run(&format!("merge {names}")).ok().stdout, text);
        assert_same(&merged, &whole, &format!("{count} parts"));
        assert_eq!(merged.run(&format!("merge {names} --json")).ok().stdout, document);
    }
}

/// Figures of closed forms have no pieces, so that no part has results.
#[test]
fn figures_without_pieces_are_made_by_the_merge() {
    let place = Workplace::new();
    let names = parts(&place, "reproduce C.1 -o out", 3);
    place.run(&format!("merge {names}")).ok();
    assert!(place.path("out/index.html").exists());
    place.run("merge 1of3.shard --partial -o none").fails(1, &["have no results"]);
}

#[test]
fn figures_of_missing_parts_are_left_out() {
    let place = Workplace::new();
    place.run(&format!("{FIGURES} --shard 2/16 --save part.shard")).ok();
    let merged = place.run("merge part.shard --partial").ok();
    assert!(merged.stderr.contains("figure 4.10 is left out"), "{}", merged.stderr);
    let page = place.text("out/index.html");
    assert!(page.contains("figure-C.1") && !page.contains("figure-4.10"));
    let run = FIGURES.replace("C.1 ", "");
    place.run(&format!("{run} --shard 2/16 --save other.shard")).ok();
    place.run("merge other.shard --partial -o none").fails(1, &["no figure completely"]);
    assert!(!place.names().contains(&"none".to_owned()), "{:?}", place.names());
}
