//! The notation of samplers, numbers of points and errors in arguments, and the remarks on
//! samplers.

use serde_json::Value;

use crate::grammar::needs_file;
use crate::workplace::Workplace;

fn numbers(document: &Value, key: &str) -> Vec<u64> {
    let rows = document["rows"].as_array().unwrap();
    rows.iter().map(|row| row[key].as_u64().unwrap()).collect()
}

#[test]
fn numbers_of_points_are_lists_ranges_and_powers() {
    let place = Workplace::new();
    let rows = "--integrand ylm:l=1 -m 4 --json";
    let variance = place.run(&format!("variance fibonacci -n 4..20,1e2,1k {rows}")).json();
    assert_eq!(numbers(&variance, "n"), [4, 8, 16, 100, 1000]);
    let compare = place.run(&format!("compare fibonacci -n 6..24 {rows} -o out")).json();
    assert_eq!(numbers(&compare, "n"), [6, 12, 24]);
    for arguments in [
        "sample fibonacci -n 0.1k --json",
        "spectrum fibonacci -n 1e2 --lmax 3 --json",
        "bounds --profile step -n 1e2 --json",
        "eval profile --profile step -n 1e2 --lmax 3 --json",
    ] {
        place.run(arguments).json();
    }
    for (arguments, parts) in [
        ("sample fibonacci -n 1.5", ["whole number", "\"1.5\""]),
        ("variance fibonacci -n 8..4 --integrand cosine", ["8..4", "smaller number first"]),
        ("compare -n 1e400", ["expected numbers", "1e400"]),
    ] {
        place.run(arguments).fails(2, &parts);
    }
}

#[test]
#[ignore = "slow"]
fn all_selects_every_sampler() {
    let place = Workplace::new();
    let list = place.run("list samplers --json").json();
    // A sampler that needs a file is not among all.
    let all = list["samplers"].as_array().unwrap().iter().filter(|s| !needs_file(s)).count();
    let variance = place.run("variance all -n 12 --nearest --integrand ylm:l=2 -m 4 --json").json();
    assert_eq!(variance["rows"].as_array().unwrap().len(), all);
    let compare = place.run("compare all -n 12 --integrand ylm:l=2 -m 4 --json -o out").json();
    assert_eq!(compare["rows"].as_array().unwrap().len(), all);
    place.run("sample all -n 12").fails(2, &["expected one sampler, got all"]);
}

/// The folder of a test is not a clone of the repository.
#[test]
fn the_default_comparison_needs_no_file() {
    let place = Workplace::new();
    let document = place.run("compare fibonacci -n 12 -m 4 --lmax 32 --json -o out").json();
    assert_eq!(document["rows"][0]["integrand"], "env:data/city.exr");
    // The integral of `theory.md` over the sphere.
    let exact = document["rows"][0]["exact"].as_f64().unwrap();
    assert!((exact - 7.0165).abs() < 1e-3, "{exact}");
    place.run("variance fibonacci -n 12 --integrand env:city.exr").fails(1, &["city.exr"]);
}

#[test]
#[ignore = "slow"]
fn help_states_the_default_samplers_of_a_comparison() {
    let place = Workplace::new();
    let help = place.run("compare --help").ok().stdout;
    let words: Vec<&str> = help.split_whitespace().collect();
    let stated = "[default: white-noise,jittered,poisson-disk,ccvt,healpix,fibonacci,step]";
    assert!(words.join(" ").contains(stated), "{help}");
    let rows = place.run("compare -n 12 --integrand ylm:l=1 -m 4 --json -o out").json();
    let names: Vec<&str> = rows["samplers"]
        .as_array()
        .unwrap()
        .iter()
        .map(|s| s["sampler"].as_str().unwrap())
        .collect();
    assert_eq!(format!("[default: {}]", names.join(",")), stated);
    // The output is read in a terminal.
    let text =
        place.run("compare -n 12,48 --integrand cap:degrees=60 -m 50 -o out --force").ok().stdout;
    let longest = text.lines().max_by_key(|line| line.chars().count()).unwrap();
    assert!(longest.chars().count() <= 100, "{longest}");
}

/// Samplers are arguments or the value of a flag, separated by commas or spaces; all notations have
/// the same result.
#[test]
#[ignore = "slow"]
fn samplers_are_arguments_or_a_flag() {
    let place = Workplace::new();
    for (command, more) in [
        ("variance", "-n 12 --integrand ylm:l=1 -m 4 --json"),
        ("compare", "-n 12 --integrand ylm:l=1 -m 4 --json --force"),
        ("choose", "-n 12 --integrand ylm:l=1 --json"),
    ] {
        let rows = |samplers: &str| {
            let document = place.run(&format!("{command} {samplers} {more}")).json();
            let rows = document["rows"].as_array().unwrap().clone();
            let number = if command == "choose" { "variance" } else { "predicted" };
            rows.iter().map(|r| (r["sampler"].clone(), r[number].clone())).collect::<Vec<_>>()
        };
        let first = rows("jittered,fibonacci");
        assert_eq!(first.len(), 2);
        for other in
            ["jittered fibonacci", "--samplers jittered,fibonacci", "--samplers=jittered,fibonacci"]
        {
            assert_eq!(rows(other), first, "{command} {other}");
        }
        let quoted = |list: &str| {
            let mut command = place.command(&format!("{command} {more}"));
            let output = command.args(["--samplers", list]).output().unwrap();
            let document: Value = serde_json::from_slice(&output.stdout).unwrap();
            document["rows"].as_array().unwrap().len()
        };
        for list in ["jittered fibonacci", "jittered, fibonacci", "jittered,fibonacci"] {
            assert_eq!(quoted(list), 2, "{command} --samplers {list:?}");
        }
        place
            .run(&format!("{command} jittered --samplers fibonacci {more}"))
            .fails(2, &["--samplers", "cannot be used with"]);
    }
    let named = "variance poisson-disk:radius=0.2,mode=exact jittered -n 12 --integrand ylm:l=1 -m 4 --json";
    assert_eq!(place.run(named).json()["rows"].as_array().unwrap().len(), 2);
}

/// Without -m, expensive samplers have fewer trials than inexpensive ones; predictions do not
/// depend on that number.
#[test]
#[ignore = "slow"]
fn default_trials_follow_from_the_cost_of_a_set() {
    let place = Workplace::new();
    let arguments = "variance white-noise,step -n 300 --integrand ylm:l=1 --json";
    let document = place.run(arguments).json();
    let trials = numbers(&document, "trials");
    assert_eq!(trials[0], 1000);
    assert!((50..1000).contains(&trials[1]), "{trials:?}");
    let explicit = place.run(&format!("{arguments} -m {}", trials[1])).json();
    let row = |document: &Value| document["rows"][1].clone();
    assert_eq!(row(&explicit)["measured"], row(&document)["measured"]);
    assert_eq!(row(&explicit)["predicted"], row(&document)["predicted"]);
    let until = place.run(&format!("{arguments} --until-rel 50% --max-realizations 8")).json();
    assert!(numbers(&until, "trials").iter().all(|&trials| trials <= 8), "{until}");
}

/// An error of 1 is 100 %, which is hardly ever meant.
#[test]
fn shares_above_a_half_need_a_percent_sign() {
    let place = Workplace::new();
    for arguments in [
        "choose --integrand cap:degrees=60 --error 1",
        "variance fibonacci -n 12 --integrand cap:degrees=60 --until-rel 1",
        "compare fibonacci -n 12 --integrand cap:degrees=60 --until-rel 1",
    ] {
        place.run(arguments).fails(2, &["did you mean 1%?", "100%"]);
    }
    let choose = "choose --integrand cap:degrees=60 --samplers white-noise --json";
    place.run(&format!("{choose} --error 100%")).json();
    place.run(&format!("{choose} --error 2 --absolute")).json();
}

#[test]
fn variances_are_drawn() {
    let place = Workplace::new();
    let arguments = "variance jittered,fibonacci -n 12,48 --integrand cap:degrees=60 -m 20";
    place.run(&format!("{arguments} -o v.svg")).ok();
    let picture = place.text("v.svg");
    for part in ["<svg", "jittered", "fibonacci"] {
        assert!(picture.contains(part), "no {part} in the picture");
    }
    place.run(&format!("{arguments} -o v.png")).ok();
    assert_eq!(place.bytes("v.png")[1..4], *b"PNG");
}

/// The last empty degree is stated whenever a step sampler is generated or recommended; if no set
/// exists for an alpha, the error names the largest valid one.
#[test]
fn steps_state_their_last_empty_degree() {
    let place = Workplace::new();
    for (arguments, last) in [
        ("step -n 150", 12),
        ("step:alpha=1 -n 100", 10),
        ("blue -n 25", 5),
        ("step:alpha=1.2 -n 100", 12),
        ("step -n 50 --hemisphere", 10),
        ("step -n 9", 2),
        ("step -n 1", 0),
    ] {
        let document = place.run(&format!("sample {arguments} --json -o p.csv")).json();
        assert_eq!(document["last_empty_degree"], last, "{arguments}");
    }
    let sample = place.run("sample step -n 150 -o p.svg").ok();
    assert!(sample.stderr.contains("no power at degrees 1 to 12"), "{}", sample.stderr);
    assert!(place.text("p.svg").contains("no power at degrees 1 to 12"));
    place.run("sample step:alpha=1 -n 9").fails(2, &["largest alpha of 9 points", "0.999999"]);
    let others = place.run("sample fibonacci -n 12 --json -o p.csv").json();
    assert!(others.get("last_empty_degree").is_none(), "{others}");

    let choose = "choose --samplers step,fibonacci -n 100 --integrand vmf:kappa=5";
    let document = place.run(&format!("{choose} --json")).json();
    let rows = document["rows"].as_array().unwrap();
    let of = |name: &str| &rows.iter().find(|r| r["sampler"] == name).unwrap()["last_empty_degree"];
    assert_eq!((of("step"), of("fibonacci")), (&Value::from(10), &Value::Null));
    let text = place.run(choose).ok().stdout;
    assert!(text.contains("Largest degree without power: step 10"), "{text}");
}

/// Long work states its expected time first; that the points have no power follows them.
#[test]
fn long_work_states_its_expected_time_before_results() {
    use std::io::{BufRead, BufReader};
    let place = Workplace::new();
    for sampler in ["design:t=64", "dpp -n 6000"] {
        let mut command = place.command(&format!("sample {sampler} -o long.npy"));
        let mut child = command.stderr(std::process::Stdio::piped()).spawn().unwrap();
        let mut first = String::new();
        BufReader::new(child.stderr.take().unwrap()).read_line(&mut first).unwrap();
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(first.contains("expected time on one core: about"), "{sampler}: {first}");
    }
    let brief = place.run("sample design -n 12 -o short.npy").ok();
    assert_eq!(brief.stderr, "design, N = 12: no power at degrees 1 to 5\n");
}
