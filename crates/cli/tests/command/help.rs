//! The texts of `--help` and `--version`.

use std::path::Path;

use crate::workplace::{Workplace, data, small_exr};

const SUBCOMMANDS: [&str; 23] = [
    "compare",
    "choose",
    "rotations",
    "sample",
    "spectrum",
    "merge",
    "plan",
    "variance",
    "progressive",
    "integrate",
    "weights",
    "fit",
    "bounds",
    "audit",
    "quality",
    "render",
    "lights",
    "reproduce",
    "healpix",
    "eval",
    "accuracy",
    "list",
    "completions",
];

#[test]
fn every_subcommand_shows_an_example() {
    let place = Workplace::new();
    let overview = place.run("--help").ok().stdout;
    for name in SUBCOMMANDS {
        assert!(overview.contains(&format!("\n  {name} ")), "{name}: {overview}");
        let help = place.run(&format!("{name} --help")).ok().stdout;
        assert!(help.contains("Example"), "{help}");
        assert!(help.contains(&format!("sphvar {name}")), "{help}");
        assert!(help.contains("--seed") && help.contains("--json"), "{help}");
    }
    // The command without arguments and its help begin with its purpose.
    let alone = place.command("").output().unwrap();
    let alone = String::from_utf8(alone.stderr).unwrap();
    assert!(alone.contains("Three questions"), "{alone}");
    for question in alone.lines().filter_map(|l| l.trim().strip_prefix("sphvar ")) {
        assert!(SUBCOMMANDS.iter().any(|name| question.starts_with(name)), "{question}");
    }
    for name in ["legendre", "ylm", "cap-power", "profile"] {
        let help = place.run(&format!("eval {name} --help")).ok().stdout;
        assert!(help.contains("Usage: sphvar eval"), "{help}");
    }
}

/// Only the terminal wraps paragraphs: text that is also wrapped in the source has ragged lines.
#[test]
fn paragraphs_are_wrapped_once() {
    let place = Workplace::new();
    for name in SUBCOMMANDS {
        let help = place.run(&format!("{name} --help")).ok().stdout;
        let lines: Vec<&str> = help.lines().collect();
        for pair in lines.windows(2) {
            let starts = |line: &str| line.starts_with(|c: char| c.is_alphabetic());
            let [line, next] = [pair[0], pair[1]];
            if !starts(line) || !starts(next) {
                continue;
            }
            let word = next.split(' ').next().unwrap();
            let ends = line.ends_with(['.', ':']);
            assert!(ends || line.len() + 1 + word.len() > 100, "{name}: {line}\n{next}");
        }
    }
}

#[test]
fn examples_work() {
    assert_examples_work(|example| example != ACCURACY);
}

#[test]
#[ignore = "slow"]
fn the_example_of_accuracy_works() {
    assert_examples_work(|example| example == ACCURACY);
}

/// The example that measures accuracy, for which there are no smaller numbers.
const ACCURACY: &str = "accuracy harmonics indexing --quick";

/// Runs the selected examples, with smaller numbers if they would take long.
fn assert_examples_work(selected: impl Fn(&str) -> bool) {
    let place = Workplace::new();
    place.write("sky.exr", small_exr(16, 8));
    place.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    place.write("pixels.csv", "pixel\n0\n17\n");
    let catalogue = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/catalogue.fits.gz");
    std::fs::copy(catalogue, place.path("cat.fits.gz")).unwrap();
    std::fs::create_dir_all(place.path("docs/images")).unwrap();
    std::fs::create_dir(place.path("data")).unwrap();
    for name in ["stars.csv", "city.exr"] {
        std::fs::copy(data(name), place.path(format!("data/{name}"))).unwrap();
    }
    for files in [
        "sample white-noise -n 12 -m 30 --rotate -o sets.npy",
        "sample fibonacci -n 12 -o points.npy",
        "spectrum jittered -n 12 --exact --lmax 32 -o s.csv",
    ] {
        place.run(files).ok();
    }
    let mut skipped = Vec::new();
    let mut count = 0;
    for name in SUBCOMMANDS {
        let help = place.run(&format!("{name} --help")).ok().stdout;
        let mut found = 0;
        let examples = help.split_once("\nExamples:\n").map(|(_, examples)| examples);
        for line in examples.unwrap().lines().take_while(|line| line.starts_with("  ")) {
            let Some((before, example)) = line.split_once("sphvar ") else { continue };
            // A remark follows several spaces; output that the shell would redirect goes to
            // standard output here.
            let example = example.split("   ").next().unwrap().split(" > ").next().unwrap();
            let example = smaller(example);
            found += 1;
            // The last areas of accuracy and the figures of the thesis have no smaller version.
            let is_large = (name == "accuracy" && !example.contains("--quick"))
                || (name == "reproduce" && example.contains("--full"));
            if is_large {
                skipped.push(example);
                continue;
            }
            if !selected(&example) {
                continue;
            }
            count += 1;
            // The parts of other examples have the same names, and are not replaced.
            if let Some((_, kept)) = example.split_once("--save ") {
                let _ = std::fs::remove_file(place.path(kept.split(' ').next().unwrap()));
            }
            match before.trim().strip_suffix(" |") {
                Some("echo 13.4 52.5") => place.run_on(&example, "13.4 52.5\n").ok(),
                Some("seq 0 47") => place.run_on(&example, "0\n47\n").ok(),
                Some(other) => panic!("{other}"),
                // Nothing has run the parts.
                None if example.starts_with("plan status") => {
                    let outcome = place.run(&example);
                    assert_eq!(outcome.status, Some(1), "{example}: {}", outcome.stderr);
                    outcome
                }
                None => place.run(&example).ok(),
            };
        }
        assert!(found > 0, "{name}: no example was found\n{help}");
    }
    assert!(count > 0, "no example was run");
    assert_eq!(skipped.len(), 3, "{skipped:?}");
}

/// Returns an example with smaller numbers that takes at most a second.
fn smaller(example: &str) -> String {
    let mut example = example.to_owned();
    for (large, small) in [
        ("-m 20000", "-m 40"),
        ("-m 2000", "-m 40"),
        ("-m 300", "-m 9"),
        ("-m 200", "-m 4"),
        ("-n 3888", "-n 108"),
        ("-n 4096", "-n 100"),
        ("-n 1024", "-n 48"),
        ("-n 100,1000", "-n 12,48"),
        ("-n 1k", "-n 12"),
        ("-n 1000", "-n 48"),
        ("-n 768", "-n 48"),
        ("-n 972", "-n 48"),
        ("--lmax 190", "--lmax 40"),
        ("--error 1%", "--error 20% white-noise,jittered"),
        ("--size 64", "--size 16"),
        ("reproduce all", "reproduce 5.1"),
    ] {
        example = example.replace(large, small);
    }
    let more = match example.split(' ').next().unwrap() {
        "compare" if example == "compare" => " white-noise,jittered -n 12 -m 4 -o default",
        "compare" if !example.contains(" -n ") => " white-noise,jittered -n 12,48 -m 4 --force",
        "compare" if example.contains(" -m ") => "",
        "compare" => " -m 4 --force",
        "choose" if example.contains("-n 48") => " white-noise,jittered",
        "render" if example.contains("--size") => "",
        "render" => " --size 8 --reference-count 600 --cache none",
        _ => "",
    };
    example + more
}

#[test]
fn version() {
    let place = Workplace::new();
    let expected = format!("sphvar {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(place.run("--version").ok().stdout, expected);
}

/// A manual page for the command and for each subcommand, with every flag of its help.
#[test]
fn manual_pages_describe_every_subcommand() {
    let place = Workplace::new();
    place.run("completions --man share/man1").ok();
    let names = place.names_in("share/man1");
    let evals = ["cap-power", "legendre", "profile", "ylm"].map(|name| format!("eval {name}"));
    let nested = evals.into_iter().chain(["plan status".to_owned()]);
    let commands = SUBCOMMANDS.iter().map(|&name| name.to_owned()).chain(nested);
    let mut count = 1;
    assert!(names.contains(&"sphvar.1".to_owned()), "{names:?}");
    for command in commands {
        let name = format!("sphvar-{}.1", command.replace(' ', "-"));
        assert!(names.contains(&name), "{name}: {names:?}");
        // Dashes are escaped, so that lines are not broken at them.
        let page = place.text(&format!("share/man1/{name}")).replace("\\-", "-");
        assert!(page.contains("SYNOPSIS"), "{page}");
        let help = place.run(&format!("{command} --help")).ok().stdout;
        let words = help.split(|c: char| !c.is_alphanumeric() && c != '-');
        for flag in words.filter(|word| word.starts_with("--") && word.len() > 2) {
            assert!(page.contains(flag), "{name} lacks {flag}\n{page}");
        }
        count += 1;
    }
    assert_eq!(names.len(), count, "{names:?}");
    // No other files remain, and a second run replaces the pages.
    place.run("completions --man share/man1 --quiet").ok();
    assert_eq!(place.names_in("share/man1"), names);
    place.run("completions").fails(2, &["SHELL", "--man"]);
    place.run("completions bash --man man").fails(2, &["cannot be used with"]);
    place.write("file", "");
    place.run("completions --man file").fails(1, &["file", "folder"]);
}
