//! Spectra in parts: `spectrum --shard --save` and `merge`.

use crate::workplace::Workplace;

const RUN: &str = "spectrum jittered -n 48 -m 23 --lmax 9";

/// What a spectrum consists of, without the time and the command that it took.
fn numbers(place: &Workplace, arguments: &str) -> Vec<serde_json::Value> {
    let document = place.run(arguments).json();
    let keys = ["sampler", "domain", "n", "lmax", "realizations", "l", "power", "stderr"];
    keys.map(|key| document[key].clone()).to_vec()
}

#[test]
fn parts_in_any_order_give_the_bits_of_one_run() {
    let place = Workplace::new();
    let whole = numbers(&place, &format!("{RUN} --json"));
    for (i, threads) in [(1, 1), (2, 2), (3, 1)] {
        place.run(&format!("{RUN} --shard {i}/3 --save {i}.shard -j {threads} --quiet")).ok();
    }
    assert_eq!(numbers(&place, "merge 3.shard 1.shard 2.shard --json"), whole);
    // Parts of parts, too.
    place.run("merge 2.shard 1.shard --save 12.shard --quiet").ok();
    assert_eq!(numbers(&place, "merge 3.shard 12.shard --json"), whole);
    let said = place.run("merge 3.shard 1.shard").ok();
    assert!(said.stderr.contains("realizations 0 to 6, 15 to 22"), "{}", said.stderr);
    assert!(said.stdout.contains("power"), "{}", said.stdout);
    // A file has the same digits.
    place.run(&format!("{RUN} -o whole.csv")).ok();
    place.run("merge 1.shard 2.shard 3.shard -o merged.csv").ok();
    let rows = |name: &str| place.text(name).lines().skip(1).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(rows("whole.csv"), rows("merged.csv"));
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
fn parts_that_do_not_belong_together_are_refused() {
    let place = Workplace::new();
    place.run(&format!("{RUN} --shard 1/2 --save a --quiet")).ok();
    for (other, what) in [
        ("spectrum jittered -n 48 -m 23 --lmax 9 --shard 1/3", "realization 0 is in a and in b"),
        ("spectrum jittered -n 48 -m 23 --lmax 9 --shard 2/2 -s 1", "different seeds: 0 and 1"),
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
    place.run("spectrum jittered -n 48 -m 2 --shard 1/5 --save x").fails(2, &["none of 2"]);
}
