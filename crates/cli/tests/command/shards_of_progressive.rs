//! `progressive` in parts.

use crate::parts_of_runs::WholeRun;
use crate::workplace::Workplace;

const RUN: &str = "progressive halton,sobol,white-noise -n 9 --integrand cap:degrees=60 -m 21";

#[test]
fn parts_of_sequences_are_merged_to_one_run() {
    let place = Workplace::new();
    let whole = WholeRun::new(&place, RUN);
    for parts in [1, 3, 16] {
        whole.check(parts);
    }
    assert!(place.names().iter().all(|name| !name.contains("unfinished")), "{:?}", place.names());
}

/// The hemisphere, listed prefixes with a random reference, warped sequences, the square, and
/// sequences that are not rotated, of which a deterministic one has the same estimate in all trials.
#[test]
fn parts_of_other_spaces_are_merged_to_one_run() {
    let place = Workplace::new();
    for (command, parts) in [
        (
            "progressive halton -n 4,9 --hemisphere --integrand cosine -m 6 --reference jittered,fibonacci",
            7,
        ),
        (
            "progressive halton,sobol:warp=cosine,r2:warp=cosine -n 6 --hemisphere --integrand vmf:kappa=4 -m 5",
            3,
        ),
        ("progressive sobol,r2 --square -n 7 --integrand disk:radius=0.3 -m 5 -s 3", 3),
        ("progressive halton,white-noise -n 6 --integrand cosine -m 4 --no-rotate", 3),
    ] {
        WholeRun::new(&place, command).check(parts);
    }
}

#[test]
fn partial_merges_have_the_sequences_that_are_known() {
    let place = Workplace::new();
    let whole = WholeRun::new(&place, RUN);
    // The references are in part 1, the predictions of the sequences in parts 2, 3 and 4.
    let files: Vec<String> = [1, 2, 4].map(|part| whole.part(part, 5)).to_vec();
    let names = files.join(" ");
    place.run(&format!("merge {names}")).fails(1, &["missing: parts 3, 5 of 5", "--partial"]);
    let document = place.run(&format!("merge {names} --partial --json")).json();
    let sequences = document["sequences"].as_array().unwrap();
    let named: Vec<_> = sequences.iter().map(|s| s["sampler"].as_str().unwrap()).collect();
    assert_eq!(named, ["halton", "white-noise"]);
    assert_eq!(sequences[0]["trials"], 13);
    assert!(document["rows"][0]["factor"].is_number(), "{}", document["rows"][0]);
    // Without the references and what is known of the trials, there is nothing.
    place.run(&format!("merge {} --partial", files[1])).fails(1, &["the given parts have no"]);
}

/// Results for other numbers of points are an error, not a panic.
#[test]
fn damaged_results_of_sequences_are_errors() {
    let place = Workplace::new();
    let run = "progressive halton --integrand cosine -m 4 --reference none";
    for n in [3, 4] {
        place.run(&format!("{run} -n {n} --save {n}.shard --quiet")).ok();
    }
    let (from, to) = (place.bytes("3.shard"), place.bytes("4.shard"));
    // The question of one run with the results of the other: a line, and records of 8 bytes for
    // the length, 4 for the checksum, and the content.
    let end_of_first = |bytes: &[u8]| {
        let start = 1 + bytes.iter().position(|byte| *byte == b'\n').unwrap();
        let length = bytes[start..start + 8].try_into().unwrap();
        start + 12 + usize::try_from(u64::from_le_bytes(length)).unwrap()
    };
    let mixed = [&to[..end_of_first(&to)], &from[end_of_first(&from)..]].concat();
    place.write("mixed.shard", mixed);
    place.run("merge mixed.shard").fails(1, &["the saved result of", "has another form"]);
}
