//! The user's own points, `file:PATH`, as a sampler of every subcommand.

use serde_json::Value;

use crate::outcome::numbers;
use crate::workplace::Workplace;

const CAP: &str = "--integrand cap:degrees=60";

/// Returns the row of a sampler.
fn row<'d>(document: &'d Value, sampler: &str) -> &'d Value {
    let rows = document["rows"].as_array().unwrap();
    let found = rows.iter().find(|row| row["sampler"] == sampler);
    found.unwrap_or_else(|| panic!("{sampler}: {document}"))
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key}: {value}"))
}

/// Points that are written and read back have the spectrum, the predicted variance and the rank of
/// their pattern.
#[test]
fn points_of_a_pattern_are_that_pattern() {
    let place = Workplace::new();
    for file in ["fib.csv", "fib.npz"] {
        place.run(&format!("sample fibonacci -n 291 -o {file}")).ok();
        let sampler = format!("file:{file}");
        let samplers = format!("fibonacci,{sampler}");
        // The number of points is that of the file.
        let document = place.run(&format!("variance {samplers} -n 291 {CAP} -m 4 --json")).json();
        let (own, built_in) = (row(&document, &sampler), row(&document, "fibonacci"));
        let [predicted, expected] = [own, built_in].map(|row| number(row, "predicted"));
        assert!((predicted / expected - 1.0).abs() < 1e-12, "{file}: {predicted}, {expected}");
        assert_eq!((&own["n"], &own["n_effective"]), (&291.into(), &Value::Null));
        if file != "fib.npz" {
            continue;
        }
        let document = place.run(&format!("choose {samplers},jittered -n 300 {CAP} --json")).json();
        let [own, built_in] = [&*sampler, "fibonacci"].map(|name| row(&document, name));
        assert_eq!(own["n"], 291);
        // The built-in pattern has 300 points.
        let ratio = number(own, "error") / number(built_in, "error");
        assert!((0.95..1.1).contains(&ratio), "{file}: {ratio}");
        assert!(number(row(&document, "jittered"), "rank") > 2.0, "{document}");
        assert_eq!(own["seconds_per_set"], Value::Null);
    }
    let spectrum = |source: &str| {
        let document = place.run(&format!("spectrum {source} --lmax 90 --json")).json();
        numbers(&document["power"])
    };
    assert_eq!(spectrum("file:fib.npz"), spectrum("--points fib.npz"));
}

/// A single file has one row at its own number, whatever the value of `-n`, and needs no `-n`.
#[test]
fn a_file_has_one_row_beside_lists_of_counts() {
    let place = Workplace::new();
    place.run("sample fibonacci -n 77 -o a.csv").ok();
    let rows = |arguments: &str| -> Vec<(String, u64)> {
        let document = place.run(&format!("{arguments} {CAP} -m 50 --json --quiet")).json();
        let row =
            |row: &Value| (row["sampler"].as_str().unwrap().into(), row["n"].as_u64().unwrap());
        document["rows"].as_array().unwrap().iter().map(row).collect()
    };
    let own = ("file:a.csv".to_owned(), 77);
    let jittered = |n| ("jittered".to_owned(), n);
    let expected = [jittered(48), jittered(108), own.clone()];
    assert_eq!(rows("variance jittered,file:a.csv -n 48,108"), expected);
    assert_eq!(
        rows("compare jittered,file:a.csv -n 77,100 -o out"),
        [jittered(48), jittered(108), own.clone()]
    );
    assert_eq!(rows("variance file:a.csv"), [own]);
    for command in ["spectrum", "sample", "bounds", "audit -m 30"] {
        place.run(&format!("{command} file:a.csv")).ok();
        let missing = ["missing required option -n/--count"];
        place.run(&format!("{command} jittered")).fails(2, &missing);
    }
    place.run(&format!("variance jittered,file:a.csv {CAP}")).fails(2, &["-n/--count"]);
    let left_out = place.run(&format!("choose jittered,file:a.csv -n 50 {CAP}")).ok();
    assert!(
        left_out.stdout.contains("Not considered: file:a.csv (its minimum number of points, 77")
    );
}

/// Files of one name are told apart by their paths, in tables as in plots.
#[test]
fn tables_and_plots_have_the_name_of_the_file() {
    let place = Workplace::new();
    for folder in ["one", "two"] {
        std::fs::create_dir(place.path(folder)).unwrap();
        place.run(&format!("sample fibonacci -n 50 -o {folder}/p.csv")).ok();
    }
    place.run("sample spiral -n 50 -o one/q.csv").ok();
    let run = |samplers: &str, rest: &str| {
        place.run(&format!("variance {samplers} {CAP} -m 20 {rest}")).ok().stdout
    };
    let first_words = |table: &str| -> Vec<String> {
        table
            .lines()
            .skip(1)
            .filter_map(|line| Some(line.split_whitespace().next()?.into()))
            .collect()
    };
    let words = first_words(&run("file:one/p.csv,file:two/p.csv,file:one/q.csv", ""));
    for label in ["file:one/p.csv", "file:two/p.csv", "file:q.csv"] {
        assert!(words.iter().any(|word| word == label), "{label}: {words:?}");
    }
    run("fibonacci,file:one/p.csv", "-n 50 -o v.svg");
    let plot = place.text("v.svg");
    assert!(plot.contains("file:p.csv") && !plot.contains("one/p.csv,"), "{plot}");
    assert!(plot.contains("Black: points from files."), "{plot}");
}

/// `file:sets-{n}.npy` is a file for every number of points, with rates and required points.
#[test]
fn a_template_names_a_file_for_every_count() {
    let place = Workplace::new();
    for n in [12, 48, 192] {
        place.run(&format!("sample jittered -n {n} -m 100 -o sets-{n}.npy")).ok();
    }
    let sampler = "file:sets-{n}.npy";
    let command = format!("compare {sampler},jittered -n 12,48,192 {CAP} -m 20 -o out --json");
    let document = place.run(&command).json();
    let samplers = document["samplers"].as_array().unwrap();
    let rates: Vec<f64> = samplers.iter().map(|s| number(s, "rate")).collect();
    // The error of a variance from 100 sets is about 2 %, that of a rate over a factor of 16 about
    // 0.01; one of 0.1 has a probability far below 1e-9.
    assert!((rates[0] - rates[1]).abs() < 0.1, "{rates:?}");
    assert_eq!(samplers[0]["sampler"], sampler);
    let document = place.run(&format!("choose {sampler},jittered --error 6% {CAP} --json")).json();
    let [own, built_in] = [sampler, "jittered"].map(|name| row(&document, name)["n"].clone());
    assert!([12, 48, 192].contains(&own.as_u64().unwrap()) && built_in.is_u64(), "{own}");
    let rejected = ["N must be 12, 48 or 192", "the nearest valid count is 192"];
    place.run(&format!("variance {sampler} -n 200 {CAP}")).fails(2, &rejected);
    place.run(&format!("variance {sampler} -n 200 --nearest {CAP} -m 20")).ok();
    place.run("sample fibonacci -n 10 -o wrong-12.csv").ok();
    let wrong = "variance file:wrong-{n}.csv -n 12 --integrand ylm:l=1";
    place.run(wrong).fails(1, &["wrong-12.csv", "states 12 points, but it has 10"]);
    // The other files of the template are used.
    place.run("sample fibonacci -n 20 -o wrong-20.csv").ok();
    place.write("wrong-30.csv", "no points");
    let run = place.run("variance file:wrong-{n}.csv -n 20 --integrand ylm:l=1").ok();
    for warning in ["states 12 points", "wrong-30.csv", "the file is not used"] {
        assert!(run.stderr.contains(warning), "{}", run.stderr);
    }
    place.run(wrong).fails(2, &["N must be 20"]);
    let none = "variance file:none-{n}.csv -n 12 --integrand ylm:l=1";
    place.run(none).fails(1, &["none-{n}.csv", "files such as none-256.csv"]);
}

/// Messages write the options of `file:` as its keys.
#[test]
fn messages_name_the_keys_of_the_text() {
    let place = Workplace::new();
    place.write("nan.csv", "x,y,z\n0,0,1\nnan,0,1\n");
    place.write("long.csv", "x,y,z\n0,0,2\n0,2,0\n");
    place.write("two.csv", "RA_1,DEC_1,RA_2,DEC_2\n1,2,3,4\n");
    place.write("four.csv", "1,2,3,4\n");
    for (file, keys, flags) in [
        ("nan.csv", "(skip-invalid=yes skips such rows)", "(--skip-invalid skips such rows)"),
        ("long.csv", "normalize=yes scales vectors", "--normalize scales vectors"),
        ("two.csv", "use columns=\"ra=RA_1,dec=DEC_1\"", "use --columns ra=RA_1,dec=DEC_1"),
        ("four.csv", "such as columns=\"x,y,z,w\"", "such as --columns x,y,z,w"),
    ] {
        place.run(&format!("spectrum file:{file}")).fails(1, &[keys]);
        place.run(&format!("spectrum --points {file}")).fails(1, &[flags]);
    }
    place.run("spectrum file:nan.csv,skip-invalid=yes --lmax 2").ok();
    place.run("spectrum file:long.csv,normalize=yes --lmax 2").ok();
    place.run("spectrum file:two.csv,columns=\"ra=RA_1,dec=DEC_1\" --lmax 2").ok();
}

/// Two hundred sets in a file have the bounds and the audits of the sampler that made them.
#[test]
fn bounds_and_audits_of_sets_are_those_of_their_sampler() {
    let place = Workplace::new();
    place.run("sample jittered -n 192 -m 200 -o raw.npy").ok();
    place.run("sample jittered -n 192 -m 200 --rotate -o rotated.npy").ok();
    let bounds = |sampler: &str| place.run(&format!("bounds {sampler} -n 192 --json")).json();
    let (own, exact) = (bounds("file:raw.npy"), bounds("jittered"));
    let find = |document: &Value, side: &str| {
        let bounds = document["bounds"].as_array().unwrap().clone();
        let is_wanted = |b: &&Value| b["family"] == "quadratic" && b["side"] == side;
        bounds.iter().find(is_wanted).cloned().unwrap()
    };
    for side in ["upper", "lower"] {
        // Profiles of estimates stay outside the confidence limits, so they are a little wider:
        // 200 sets know the power at l = 1 to 6 %, of which the limits of all degrees are 4.
        let ratio = number(&find(&own, side), "worst_variance")
            / number(&find(&exact, side), "worst_variance");
        assert!((0.6..1.6).contains(&ratio), "{side}: {ratio}");
    }
    let verdicts = |arguments: &str| -> Vec<(String, String)> {
        let document = place.run(&format!("audit {arguments} --lmax 6 --json")).json();
        let text = |value: &Value| value.as_str().unwrap().to_owned();
        let audits = document["audits"].as_array().unwrap().iter();
        audits.map(|a| (text(&a["ensemble"]), text(&a["verdict"]))).collect()
    };
    // With alpha = 1 % a homogeneous ensemble is rejected for 1 % of seeds.
    let own = verdicts("file:rotated.npy");
    assert_eq!(own.len(), 2, "{own:?}");
    assert!(own.iter().all(|(_, verdict)| verdict != "no"), "{own:?}");
    assert_eq!(own[0].1, verdicts("--points rotated.npy")[0].1);
    // One set is not homogeneous unless it is rotated.
    place.run("sample fibonacci -n 50 -o fib.csv").ok();
    let single = verdicts("file:fib.csv -m 100");
    assert_eq!(single, verdicts("fibonacci -n 50 -m 100"));
}

/// Weights count in every command, at any scale and with mixed signs.
#[test]
fn weights_are_used_everywhere() {
    let place = Workplace::new();
    let octahedron = "1,0,0\n-1,0,0\n0,1,0\n0,-1,0\n0,0,1\n0,0,-1\n";
    let with_weights = |weights: [&str; 6]| {
        let rows = octahedron.lines().zip(weights).map(|(row, w)| format!("{row},{w}\n"));
        format!("x,y,z,w\n{}", rows.collect::<String>())
    };
    place.write("equal.csv", format!("x,y,z\n{octahedron}"));
    place.write("constant.csv", with_weights(["7e200"; 6]));
    place.write("mixed.csv", with_weights(["1", "2", "-0.5", "1", "3", "1"]));
    place.write("huge.csv", with_weights(["1e300", "1", "1", "1", "1", "1"]));
    let variance = |file: &str, integrand: &str| {
        let command = format!("variance file:{file} --integrand {integrand} -m 200 --json");
        place.run(&command).json()["rows"][0].clone()
    };
    let [equal, constant] =
        ["equal.csv", "constant.csv"].map(|file| number(&variance(file, "ylm:l=4"), "predicted"));
    assert!((constant / equal - 1.0).abs() < 1e-12, "{constant}, {equal}");
    // (1 + 2 - 1/2 + 1 + 3 + 1)^2/(1 + 4 + 1/4 + 1 + 9 + 1), and a single point.
    for (file, n_effective) in [("mixed.csv", 7.5 * 7.5 / 16.25), ("huge.csv", 1.0)] {
        let row = variance(file, "ylm:l=1");
        assert!((number(&row, "n_effective") - n_effective).abs() < 1e-12, "{row}");
        // The variance of a mean of Y_1 over a random rotation: 4 pi sum w_j w_k P_1/(3 (sum w)^2)
        // times 3, with |sum w x|^2 = 1 + 2.25 + 4 or 1.
        let expected = 4.0
            * std::f64::consts::PI
            * if file == "mixed.csv" { (1.0 + 2.25 + 4.0) / (7.5 * 7.5) } else { 1.0 };
        let predicted = number(&row, "predicted");
        assert!((predicted / expected - 1.0).abs() < 1e-12, "{file}: {predicted}, {expected}");
        // One score beyond 4.5 has a probability of 7e-6.
        assert!(number(&row, "z").abs() < 4.5, "{row}");
        let bounds = place.run(&format!("bounds file:{file} --json")).json();
        assert!((number(&bounds, "n_effective") - n_effective).abs() < 1e-12, "{bounds}");
        for command in
            ["spectrum", "audit -m 30", "render cornell --mode rotated --size 16 --sampler"]
        {
            place.run(&format!("{command} file:{file}")).ok();
        }
        let spectrum = place.run(&format!("spectrum file:{file} --json")).json();
        assert!((number(&spectrum, "n_effective") - n_effective).abs() < 1e-12, "{spectrum}");
        // Conversions keep the weights.
        for copy in ["copy.npz", "copy.ply", "copy.csv"] {
            place.run(&format!("sample file:{file} -o {copy}")).ok();
            let [a, b] = [file, copy].map(|f| number(&variance(f, "cap:degrees=60"), "predicted"));
            assert!((a / b - 1.0).abs() < 1e-12, "{copy}: {a}, {b}");
            std::fs::remove_file(place.path(copy)).unwrap();
        }
        place.run(&format!("sample file:{file} -o p.npy")).fails(1, &["has no weights"]);
    }
    let table = place.run("variance file:mixed.csv,file:equal.csv --integrand ylm:l=2 -m 20").ok();
    assert!(table.stdout.lines().next().unwrap().contains("N_eff"), "{}", table.stdout);
    place.write("nothing.csv", with_weights(["1", "-1", "1", "-1", "0", "0"]));
    for command in ["spectrum", "audit -m 30", "bounds", "sample", "variance --integrand ylm:l=1"] {
        let run = place.run(&format!("{command} file:nothing.csv"));
        run.fails(1, &["nothing.csv:2", "the weights of set 0 (0-based) sum to 0"]);
    }
}

/// On the hemisphere, points below the plane are errors unless the text has `fold`.
#[test]
fn points_below_the_plane_are_errors() {
    let place = Workplace::new();
    place.write("p.csv", "x,y,z,set\n1,0,0,a\n0,0,1,a\n0,0.6,0.8,b\n0,0.6,-0.8,b\n");
    let command = |text: &str| format!("variance {text} --hemisphere --integrand cosine -m 20");
    place.run(&command("file:p.csv")).fails(1, &["p.csv:5", "z = -0.8", "set 1", "fold=yes"]);
    place.run(&command("file:p.csv,fold=yes")).ok();
    let rounding = "x,y,z\n1,0,-6e-8\n0,0,1\n";
    place.write("q.csv", rounding);
    place.run(&command("file:q.csv")).ok();
    let render = "render cornell --size 8 --sampler file:p.csv";
    place.run(render).fails(1, &["p.csv:5", "--mode rotated"]);
    let cut = "variance file:q.csv --hemisphere --visible-half --integrand cosine -m 20";
    place.run(cut).fails(2, &["--visible-half", "file:q.csv"]);
}

/// The options of `--points` are options of the text, with the same names.
#[test]
fn options_are_those_of_points() {
    let place = Workplace::new();
    place.write("a b,c.csv", "1,2,3\n3,1,0\n");
    place.write("long.csv", "x,y,z\n5,0,0\n0,3,0\n0,0,x\n");
    let power = |arguments: &[&str]| {
        let mut command = place.command("spectrum --lmax 4 --json --quiet");
        let output = command.args(arguments).output().unwrap();
        let outcome = crate::outcome::Outcome::new(&format!("{arguments:?}"), output);
        numbers(&outcome.json()["power"])
    };
    let text = power(&["file:\"a b,c.csv\",columns=\"phi,theta,_\""]);
    assert_eq!(text, power(&["--points", "a b,c.csv", "--columns", "phi,theta,_"]));
    let text = power(&["file:long.csv,normalize=yes,skip-invalid=yes"]);
    assert_eq!(text, power(&["--points", "long.csv", "--normalize", "--skip-invalid"]));
    place.run("spectrum file:long.csv,columns=q").fails(2, &["columns: unknown", "\"q\""]);
    place.run("spectrum file:none.csv").fails(1, &["cannot open none.csv"]);
    let list = place.run("list samplers file").ok().stdout;
    for part in ["your own point sets", "fold=no", "normalize=no", "drawn uniformly"] {
        assert!(list.contains(part), "{list}");
    }
    assert!(place.run("list").ok().stdout.contains("\n  file "));
}
