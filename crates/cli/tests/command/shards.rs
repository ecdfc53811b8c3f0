//! `sphvar spectrum --shard --save` and `merge`, and what holds for the parts of every command.

use crate::workplace::Workplace;

const RUN: &str = "spectrum jittered -n 48 -m 23 --lmax 9";

/// Returns the contents of a spectrum, without its time and command.
fn numbers(place: &Workplace, arguments: &str) -> Vec<serde_json::Value> {
    let document = place.run(arguments).json();
    let keys = ["sampler", "domain", "n", "lmax", "realizations", "l", "power", "stderr"];
    keys.map(|key| document[key].clone()).to_vec()
}

/// Returns the rows of a file, without its provenance.
fn rows(place: &Workplace, name: &str) -> Vec<String> {
    place.text(name).lines().skip(1).map(str::to_owned).collect()
}

#[test]
fn parts_in_any_order_are_bit_identical_to_one_run() {
    let place = Workplace::new();
    let whole = numbers(&place, &format!("{RUN} --json"));
    for (i, threads) in [(1, 1), (2, 2), (3, 1)] {
        let part = place.run(&format!("{RUN} --shard {i}/3 --save {i}.shard -j {threads}")).ok();
        assert!(part.stdout.is_empty(), "{}", part.stdout);
        assert!(part.stderr.contains(&format!("part {i}/3 is complete: {i}.shard")));
    }
    assert_eq!(numbers(&place, "merge 3.shard 1.shard 2.shard --json"), whole);
    // Merged parts can be merged again.
    place.run("merge 2.shard 1.shard --save 12.shard --partial --quiet").ok();
    assert_eq!(numbers(&place, "merge 3.shard 12.shard --json"), whole);
    let said = place.run("merge 3.shard 1.shard --partial").ok();
    assert!(said.stderr.contains("2 of 3 parts"), "{}", said.stderr);
    assert!(said.stdout.contains("power"), "{}", said.stdout);
    assert_eq!(place.run("merge 3.shard 1.shard --partial --json").json()["realizations"], 15);
    // Files have the same digits, in every form.
    place.run(&format!("{RUN} -o whole.csv")).ok();
    place.run("merge 1.shard 2.shard 3.shard -o merged.csv").ok();
    assert_eq!(rows(&place, "whole.csv"), rows(&place, "merged.csv"));
    place.run(&format!("{RUN} -o plot.svg")).ok();
    let plot = place.bytes("plot.svg");
    place.run("merge 1.shard 2.shard 3.shard -o plot.svg").ok();
    assert!(place.bytes("plot.svg") == plot, "the plots differ");
}

/// A part has the outputs of its command, which the merge writes unless it names others.
#[test]
fn outputs_of_parts_are_those_of_the_merge() {
    let place = Workplace::new();
    let run = format!("{RUN} -o a.csv --per-order orders.csv --coefficient 2 1 c.csv");
    place.run(&run).ok();
    let names = ["a.csv", "orders.csv", "c.csv"];
    let whole = names.map(|name| rows(&place, name));
    for name in names {
        std::fs::remove_file(place.path(name)).unwrap();
    }
    for i in [2, 1] {
        place.run(&format!("{run} --shard {i}/2 --save {i}.shard --quiet")).ok();
        assert!(!place.names().iter().any(|name| names.contains(&name.as_str())));
    }
    place.run("merge 1.shard 2.shard").ok();
    assert_eq!(names.map(|name| rows(&place, name)), whole);
    let others = "merge 1.shard 2.shard -o b.csv -- --per-order others.csv --coefficient 2 1 d.csv";
    place.run(others).ok();
    assert_eq!(["b.csv", "others.csv", "d.csv"].map(|name| rows(&place, name)), whole);
    // What was not computed is missing, also from a partial merge.
    place.run(&format!("{RUN} --save s.shard --quiet")).ok();
    place
        .run("merge s.shard -- --per-order o.csv")
        .fails(1, &["do not have the result of jittered, every order"]);
    place.run(&format!("{RUN} --shard 1/2 --save p.shard --quiet")).ok();
    let run = "merge p.shard --partial --json -- --per-order o.csv";
    place.run(run).fails(1, &["do not have all that a result needs"]);
    place.run("merge s.shard -- --nonsense").fails(2, &["--nonsense"]);
    for words in ["-n 300", "--lmax=4", "--exact", "--pairs", "--hemisphere"] {
        place.run(&format!("merge s.shard -- {words}")).fails(2, &["is no option of output"]);
    }
    for words in ["-s 4", "--seed=4", "-s4"] {
        place.run(&format!("merge s.shard {words}")).fails(2, &["--seed", "of their command"]);
    }
}

#[test]
fn missing_parts_are_listed() {
    let place = Workplace::new();
    for i in [2, 4] {
        place.run(&format!("{RUN} --shard {i}/4 --save {i}.shard --quiet")).ok();
    }
    let words = ["missing: parts 1, 3 of 4", "--partial", "the 2 given"];
    place.run("merge 4.shard 2.shard -o m.csv").fails(1, &words);
    assert!(!place.names().contains(&"m.csv".to_owned()));
    // 23 in 4: 0 to 5, 6 to 11, 12 to 17, 18 to 22.
    place.run("merge 2.shard 4.shard -o m.csv --partial").ok();
    let row = place.text("m.csv").lines().nth(3).unwrap().to_owned();
    assert!(row.ends_with(",11"), "{row}");
    // A result of some parts is not one of the command.
    let first = place.text("m.csv").lines().next().unwrap().to_owned();
    assert!(first.contains("merge 2.shard 4.shard -o m.csv --partial"), "{first}");
    // Many gaps are counted, whatever the number of parts.
    let run = "spectrum white-noise -n 5 -m 90 --lmax 2";
    place.run(&format!("{run} --shard 7/90 --save 7.shard --quiet")).ok();
    place.run("merge 7.shard").fails(1, &["parts 1, 2, 3", "13, ... of 90"]);
    let last = u64::MAX;
    place.run(&format!("{run} --shard {last}/{last} --save b.shard")).ok();
    place.run("merge b.shard").fails(1, &["missing", "1, 2, 3"]);
    place.run("merge b.shard --partial").fails(1, &["no results"]);
    place.run("merge 7.shard b.shard").fails(1, &["different numbers of parts"]);
}

/// Parts state the version, the instruction set and the form of the file.
#[test]
fn parts_of_other_machines_and_versions_are_errors() {
    let place = Workplace::new();
    for i in [1, 2] {
        place.run(&format!("{RUN} --shard {i}/2 --save {i}.shard --quiet")).ok();
    }
    let bytes = place.bytes("2.shard");
    // The first record follows the first line: length, checksum, content.
    let changed = |from: &[u8], to: &[u8]| {
        let mut bytes = bytes.clone();
        let at = bytes.windows(from.len()).position(|window| window == from).unwrap();
        bytes[at..at + from.len()].copy_from_slice(to);
        let length = u64::from_le_bytes(bytes[15..23].try_into().unwrap());
        let end = 27 + usize::try_from(length).unwrap();
        let sum = crc32fast::hash(&bytes[27..end]).to_le_bytes();
        bytes[23..27].copy_from_slice(&sum);
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
    place.write("2.shard", changed(b"sphvar shard 5", b"sphvar shard 1"));
    place.run("merge 1.shard 2.shard").fails(1, &["2.shard", "another version", "create it again"]);
    place.run("merge 1.shard 1.shard").fails(1, &["part 1 is in 1.shard and in 1.shard"]);
}

/// The first part has the whole answer, and the others are valid and empty.
#[test]
fn a_pattern_that_is_not_random_is_in_the_first_part() {
    let place = Workplace::new();
    let arguments = "spectrum fibonacci -n 30 --lmax 6 --hemisphere";
    let whole = numbers(&place, &format!("{arguments} --json"));
    place.run(&format!("{arguments} --save one.shard --quiet")).ok();
    assert_eq!(numbers(&place, "merge one.shard --json"), whole);
    for i in 1..=3 {
        place.run(&format!("{arguments} --shard {i}/3 --save {i}.shard --quiet")).ok();
    }
    assert_eq!(numbers(&place, "merge 3.shard 1.shard 2.shard --json"), whole);
    assert_eq!(numbers(&place, "merge 1.shard --partial --json"), whole);
}

#[test]
fn files_that_are_no_parts_of_one_run_are_rejected() {
    let place = Workplace::new();
    place.run(&format!("{RUN} --shard 1/2 --save a --quiet")).ok();
    for (other, what) in [
        (
            "spectrum jittered -n 48 -m 23 --lmax 9 --shard 1/3",
            "different numbers of parts: 2 and 3",
        ),
        ("spectrum jittered -n 48 -m 23 --lmax 9 --shard 2/2 -s 1", "different commands"),
        ("spectrum jittered -n 48 -m 24 --lmax 9 --shard 2/2", "-m 23 --lmax 9 and sphvar"),
        ("spectrum --square sobol -n 48 -m 23 --kmax 9 --shard 2/2", "different commands"),
        ("spectrum jittered -n 48 -m 23 --lmax 9 --shard 2/2 --epsilon 1e-6", "commands"),
    ] {
        place.run(&format!("{other} --save b --quiet")).ok();
        place.run("merge a b -o c.csv").fails(1, &["a", "b", what]);
        // Results are replaced by those of the same part only.
        let again = format!("{RUN} --shard 2/2 --save b");
        place.run(&again).fails(1, &["b has part", "remove it"]);
        std::fs::remove_file(place.path("b")).unwrap();
    }
    assert!(!place.names().contains(&"c.csv".to_owned()));
    let whole = place.bytes("a");
    place.write("text", "l,power\n1,1\n");
    place.run(&format!("{RUN} --save text")).fails(1, &["text exists", "not a file of --save"]);
    place.run(&format!("{RUN} --shard 2/2 --save a")).fails(1, &["a has part 1 of 2", "remove it"]);
    place.write("cut", &whole[..whole.len() - 1]);
    place.write("head", &whole[..17]);
    place.write("line", &whole[..15]);
    place.write("long", [&whole[..], b"x"].concat());
    let mut flipped = whole.clone();
    flipped[40] ^= 1;
    place.write("flipped", flipped);
    let mut later = whole.clone();
    let middle = whole.len() / 2;
    later[middle] ^= 1;
    place.write("later", later);
    for (file, got) in [
        ("text", "something else"),
        ("cut", "damaged"),
        ("head", "damaged"),
        ("line", "damaged"),
        ("flipped", "damaged"),
        ("later", "damaged"),
        ("long", "damaged"),
    ] {
        place.run(&format!("merge {file}")).fails(1, &[file, "a file of --save", got]);
    }
    place.run("merge missing").fails(1, &["missing"]);
    for (flags, message) in [
        ("--shard 0/2 --save x", "1 <= I <= K"),
        ("--shard 3/2 --save x", "1 <= I <= K"),
        ("--shard 1/2", "--save"),
        ("--save -", "name a file"),
    ] {
        place.run(&format!("{RUN} {flags}")).fails(2, &[message]);
    }
}

/// A finished part is not computed again, and unfinished work is continued.
#[test]
fn work_that_is_known_is_not_done_again() {
    let place = Workplace::new();
    let run = format!("{RUN} --shard 1/2 --save a.shard");
    place.run(&run).ok();
    let bytes = place.bytes("a.shard");
    place.run(&run).ok();
    assert!(place.bytes("a.shard") == bytes);
    // All records but the last one are those of unfinished work.
    let end = bytes.len() - 12 - 2;
    place.write("a.shard.unfinished", &bytes[..end]);
    std::fs::remove_file(place.path("a.shard")).unwrap();
    place.run(&run).ok();
    assert!(place.bytes("a.shard") == bytes);
    // A record that was cut, or damaged, is computed again.
    let mut damaged = bytes[..end].to_vec();
    *damaged.last_mut().unwrap() ^= 1;
    for left in [&bytes[..end - 5], &bytes[..20], &damaged, b""] {
        place.write("a.shard.unfinished", left);
        std::fs::remove_file(place.path("a.shard")).unwrap();
        place.run(&run).ok();
        assert!(place.bytes("a.shard") == bytes, "{}", left.len());
        assert_eq!(place.names(), ["a.shard"]);
    }
    // A file of another program, or what is not a file, is kept.
    for (left, what) in [("anything", "not unfinished work"), ("sphvar shard 4\n", "this version")]
    {
        place.write("c.shard.unfinished", left);
        place.run(&run.replace("a.shard", "c.shard")).fails(1, &["c.shard.unfinished", what]);
        assert_eq!(place.text("c.shard.unfinished"), left);
    }
    std::fs::remove_file(place.path("c.shard.unfinished")).unwrap();
    std::fs::create_dir(place.path("c.shard.unfinished")).unwrap();
    place.run(&run.replace("a.shard", "c.shard")).fails(1, &["not a regular file"]);
    std::fs::remove_dir(place.path("c.shard.unfinished")).unwrap();
    // The work for another question is not discarded.
    place.write("a.shard.unfinished", &bytes[..end]);
    let other = run.replace("-m 23", "-m 24");
    place.run(&other).fails(1, &["a.shard.unfinished", "-m 23", "remove it"]);
    // A run that fails before its first result leaves nothing.
    std::fs::remove_file(place.path("a.shard.unfinished")).unwrap();
    place.run("spectrum jittered -n 47 --shard 1/2 --save b.shard").fails(2, &["47"]);
    assert_eq!(place.names(), ["a.shard"]);
}

/// Parts that read other contents are not of one run.
#[test]
fn inputs_must_be_the_same_for_all_parts() {
    let place = Workplace::new();
    let points = |first: &str| format!("{first}\n1 0 0\n#\n0 1 0\n0 0 1\n#\n0 1 0\n1 0 0\n");
    place.write("p.txt", points("0 0 1"));
    let run = "spectrum file:p.txt --lmax 3";
    let whole = numbers(&place, &format!("{run} --json"));
    for i in [1, 2] {
        place.run(&format!("{run} --shard {i}/2 --save {i}.shard --quiet")).ok();
    }
    assert_eq!(numbers(&place, "merge 1.shard 2.shard --json"), whole);
    place.write("p.txt", points("0.6 0 0.8"));
    place.run("merge 1.shard 2.shard").fails(1, &["p.txt has changed"]);
    place.run(&format!("{run} --shard 2/2 --save 2.shard --quiet")).ok();
    place.run("merge 1.shard 2.shard").fails(1, &["1.shard and 2.shard", "contents of p.txt"]);
    place.run(&format!("{run} --shard 1/2 --save 1.shard --quiet")).ok();
    let now = numbers(&place, "merge 1.shard 2.shard --json");
    assert_eq!(now, numbers(&place, &format!("{run} --json")));
    assert_ne!(now, whole);
}

/// Returns the records of a file of parts, after its first line.
fn records(bytes: &[u8]) -> Vec<&[u8]> {
    let mut rest = &bytes[15..];
    let mut records = Vec::new();
    while !rest.is_empty() {
        let length = u64::from_le_bytes(rest[..8].try_into().unwrap());
        let (record, others) = rest.split_at(12 + usize::try_from(length).unwrap());
        records.push(record);
        rest = others;
    }
    records
}

/// Results of earlier contents of a file are not used, however often the work was interrupted since.
#[test]
fn unfinished_work_of_changed_inputs_is_done_again() {
    let place = Workplace::new();
    let run = "spectrum file:p.txt -m 6 --lmax 3 --shard 1/2 --save a.shard";
    let of = |points: &str| {
        place.write("p.txt", points);
        place.run(run).ok();
        let bytes = place.bytes("a.shard");
        std::fs::remove_file(place.path("a.shard")).unwrap();
        bytes
    };
    let (old, new) = (of("0 0 1\n1 0 0\n"), of("0 0 1\n0.6 0 0.8\n"));
    assert_ne!(old, new);
    let (old_records, new_records) = (records(&old), records(&new));
    let [request, input, piece, _] = old_records[..] else {
        panic!("{} records", old_records.len())
    };
    // Killed with the old content, and again with the new one before and after its first result.
    let head = [&old[..15], request, input, piece].concat();
    let again = [&head[..], new_records[1]].concat();
    let later = [&again[..], new_records[2]].concat();
    for left in [head, again, later] {
        place.write("a.shard.unfinished", left);
        place.run(run).ok();
        assert!(place.bytes("a.shard") == new, "results of another content were used");
        assert_eq!(place.names(), ["a.shard", "p.txt"]);
        std::fs::remove_file(place.path("a.shard")).unwrap();
    }
    // The file has the results of the old content, the unfinished work those of the new one.
    place.write("a.shard", &old);
    place.write(
        "a.shard.unfinished",
        [&new[..15], request, new_records[1], new_records[2]].concat(),
    );
    place.run(run).ok();
    assert!(place.bytes("a.shard") == new);
}
