//! The texts of `--help` and `--version`.

use crate::workplace::Workplace;

const SUBCOMMANDS: [&str; 14] = [
    "compare",
    "choose",
    "sample",
    "spectrum",
    "merge",
    "variance",
    "bounds",
    "audit",
    "render",
    "reproduce",
    "healpix",
    "eval",
    "accuracy",
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
    // The command alone and its help begin with what it is for.
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

/// Paragraphs are wrapped by the terminal alone: text that is wrapped in the source too shows as ragged lines.
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

/// Examples are promises: those that need no more than this repository are run, small.
#[test]
fn examples_work() {
    let place = Workplace::new();
    for name in SUBCOMMANDS {
        let help = place.run(&format!("{name} --help")).ok().stdout;
        let examples = help.lines().filter_map(|l| l.trim().strip_prefix("sphvar "));
        // A remark behind an example stands in brackets.
        // What the shell would redirect goes to standard output here.
        let examples = examples.map(|l| l.split("   ").next().unwrap());
        let examples = examples.map(|l| l.split(" > ").next().unwrap());
        let mut run = 0;
        for example in examples.filter(|e| {
            // `compare` and `reproduce` are large, and so are `choose` of all samplers, `accuracy` of large inputs and
            // reference images; some need files that a reader has.
            let large = e.starts_with("compare")
                || e.starts_with("reproduce")
                || (e.starts_with("accuracy") && !e.contains("--quick"))
                || (e.starts_with("choose") && !e.contains("--samplers"))
                || ["--mse", "--study", "--sheet"].iter().any(|flag| e.contains(flag))
                || e.contains("-m ")
                || e.starts_with("merge")
                || e.contains("jittered -n 972 --profile");
            let files = ["--points ", "--spectrum ", ".obj"].iter().any(|file| e.contains(file))
                || e.starts_with("healpix");
            !large && !files
        }) {
            place.run(example).ok();
            run += 1;
        }
        let expected = !["compare", "merge", "audit", "reproduce", "healpix"].contains(&name);
        assert_eq!(run > 0, expected, "{name}: {run} examples were run\n{help}");
    }
}

#[test]
fn version() {
    let place = Workplace::new();
    let expected = format!("sphvar {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(place.run("--version").ok().stdout, expected);
}
