//! Spectrum shards: `spectrum --shard --save` and `merge`.

use crate::workplace::Workplace;

const RUN: &str = "spectrum jittered -n 48 -m 23 --lmax 9";

/// Returns the contents of a spectrum, without its time and command.
fn numbers(place: &Workplace, arguments: &str) -> Vec<serde_json::Value> {
    let document = place.run(arguments).json();
    let keys = ["sampler", "domain", "n", "lmax", "realizations", "l", "power", "stderr"];
    keys.map(|key| document[key].clone()).to_vec()
}

#[test]
fn parts_in_any_order_are_bit_identical_to_one_run() {
    let place = Workplace::new();
    let whole = numbers(&place, &format!("{RUN} --json"));
    for (i, threads) in [(1, 1), (2, 2), (3, 1)] {
        place.run(&format!("{RUN} --shard {i}/3 --save {i}.shard -j {threads} --quiet")).ok();
    }
    assert_eq!(numbers(&place, "merge 3.shard 1.shard 2.shard --json"), whole);
    // Merged shards can be merged again.
    place.run("merge 2.shard 1.shard --save 12.shard --partial --quiet").ok();
    assert_eq!(numbers(&place, "merge 3.shard 12.shard --json"), whole);
    let said = place.run("merge 3.shard 1.shard --partial").ok();
    let words = "15 of 23 realizations: 0 to 6, 15 to 22";
    assert!(said.stderr.contains(words), "{}", said.stderr);
    assert!(said.stdout.contains("power"), "{}", said.stdout);
    // A file has the same digits.
    place.run(&format!("{RUN} -o whole.csv")).ok();
    place.run("merge 1.shard 2.shard 3.shard -o merged.csv").ok();
    let rows = |name: &str| place.text(name).lines().skip(1).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(rows("whole.csv"), rows("merged.csv"));
}

#[test]
fn missing_parts_are_listed() {
    let place = Workplace::new();
    for i in [2, 4] {
        place.run(&format!("{RUN} --shard {i}/4 --save {i}.shard --quiet")).ok();
    }
    // 23 in 4: 0 to 4, 5 to 10, 11 to 16, 17 to 22.
    let words = [
        "missing: parts 1/4, 3/4 (realizations 0 to 4, 11 to 16)",
        "--partial",
        "12 available of 23",
    ];
    place.run("merge 4.shard 2.shard -o m.csv").fails(1, &words);
    assert!(!place.names().contains(&"m.csv".to_owned()));
    place.run("merge 2.shard 4.shard -o m.csv --partial").ok();
    assert!(
        place.text("m.csv").lines().nth(3).unwrap().ends_with(",12"),
        "{}",
        place.text("m.csv")
    );
    // Many gaps are counted, whatever the number of parts.
    let run = "spectrum white-noise -n 5 -m 90 --lmax 2";
    place.run(&format!("{run} --shard 7/90 --save 7.shard --quiet")).ok();
    place.run("merge 7.shard").fails(1, &["1/90, 2/90", "12/90", "...", "0 to 5, 7 to 89"]);
    place
        .run(&format!("{run} --shard 18446744073709551615/18446744073709551615 --save b.shard"))
        .ok();
    place.run("merge b.shard").fails(1, &["missing", "realizations 0 to 88"]);
    place.run("merge 7.shard b.shard").fails(1, &["missing: realizations 0 to 5, 7 to 88"]);
}

/// A shard states the instruction set of its machine and the version of its format; both are
/// checked.
#[test]
fn shards_of_other_machines_and_versions_are_errors() {
    let place = Workplace::new();
    for i in [1, 2] {
        place.run(&format!("{RUN} --shard {i}/2 --save {i}.shard --quiet")).ok();
    }
    let bytes = place.bytes("2.shard");
    let changed = |from: &[u8], to: &[u8]| {
        let mut bytes = bytes.clone();
        let at = bytes.windows(from.len()).position(|window| window == from).unwrap();
        bytes[at..at + from.len()].copy_from_slice(to);
        let sum = crc32fast::hash(&bytes[19..]).to_le_bytes();
        bytes[15..19].copy_from_slice(&sum);
        bytes
    };
    let arch = std::env::consts::ARCH.replace('_', "-");
    let other = "z".repeat(arch.len());
    place.write("2.shard", changed(arch.as_bytes(), other.as_bytes()));
    place.run("merge 1.shard 2.shard").fails(1, &["1.shard", "2.shard", "instruction sets", &arch]);
    let version = env!("CARGO_PKG_VERSION");
    let other = "9".repeat(version.len());
    place.write("2.shard", changed(version.as_bytes(), other.as_bytes()));
    place.run("merge 1.shard 2.shard").fails(1, &["versions of sphvar", version, &other]);
    place.write("2.shard", changed(b"sphvar shard 4", b"sphvar shard 1"));
    place.run("merge 1.shard 2.shard").fails(1, &["2.shard", "another version", "create it again"]);
    place.run("merge 1.shard 1.shard").fails(1, &["realization 0 is in 1.shard and in 1.shard"]);
}

#[test]
fn a_pattern_that_is_not_random_keeps_its_exact_spectrum() {
    let place = Workplace::new();
    let arguments = "spectrum fibonacci -n 30 --lmax 6 --hemisphere";
    let whole = numbers(&place, &format!("{arguments} --json"));
    place.run(&format!("{arguments} --save one.shard --quiet")).ok();
    assert_eq!(numbers(&place, "merge one.shard --json"), whole);
}

#[test]
fn incompatible_parts_are_rejected() {
    let place = Workplace::new();
    place.run(&format!("{RUN} --shard 1/2 --save a --quiet")).ok();
    for (other, what) in [
        ("spectrum jittered -n 48 -m 23 --lmax 9 --shard 1/3", "realization 0 is in a and in b"),
        ("spectrum jittered -n 48 -m 23 --lmax 9 --shard 2/2 -s 1", "different seeds: 0 and 1"),
        (
            "spectrum jittered -n 48 -m 24 --lmax 9 --shard 2/2",
            "numbers of realizations: 23 and 24",
        ),
        ("spectrum jittered -n 48 -m 23 --lmax 8 --shard 2/2", "degrees: 10 and 9"),
        ("spectrum jittered -n 108 -m 23 --lmax 9 --shard 2/2", "points: 48 and 108"),
        ("spectrum white-noise -n 48 -m 23 --lmax 9 --shard 2/2", "jittered and white-noise"),
        ("spectrum jittered -n 48 -m 23 --lmax 9 --shard 2/2 --epsilon 1e-6", "transforms"),
    ] {
        place.run(&format!("{other} --save b --quiet")).ok();
        place.run("merge a b -o c.csv").fails(1, &["a", "b", what]);
    }
    assert!(!place.names().contains(&"c.csv".to_owned()));
    let whole = place.bytes("a");
    place.write("text", "l,power\n1,1\n");
    place.write("cut", &whole[..whole.len() - 1]);
    place.write("head", &whole[..17]);
    let mut flipped = whole.clone();
    flipped[40] ^= 1;
    place.write("flipped", flipped);
    for (file, got) in [
        ("text", "something else"),
        ("cut", "damaged"),
        ("head", "beginning"),
        ("flipped", "damaged"),
    ] {
        place.run(&format!("merge {file}")).fails(1, &[file, "spectrum --save", got]);
    }
    place.run("merge missing").fails(1, &["missing"]);
    for (flags, message) in [
        ("--shard 0/2 --save x", "1 <= I <= K"),
        ("--shard 3/2 --save x", "1 <= I <= K"),
        ("--shard 1/2", "--save"),
        ("--exact --save x", "--save"),
        ("--save -", "name a file"),
    ] {
        place
            .run(&format!("{RUN} {flags}").replace("-m 23 --lmax 9 --exact", "--exact"))
            .fails(2, &[message]);
    }
    place
        .run("spectrum jittered -n 48 -m 2 --shard 1/5 --save x")
        .fails(2, &["none of the 2 realizations"]);
}
