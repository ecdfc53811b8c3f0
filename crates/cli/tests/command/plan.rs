//! `plan`: a command in parts for engines, and what of it is done.
#![cfg(unix)]

use std::fs;
use std::process::{Command, Output};
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::outcome::Outcome;
use crate::schemas::{faults, faults_of};
use crate::workplace::Workplace;

/// A command of which 5 parts have 4 or 5 realizations each.
const COMMAND: &str = "spectrum jittered -n 12 -m 23 --lmax 4";

/// Runs a program in the folder of a workplace.
fn run(place: &Workplace, program: &str, words: &[&str]) -> Output {
    Command::new(program).args(words).current_dir(place.path("")).output().unwrap()
}

/// Runs a line of a shell and asserts success.
fn shell(place: &Workplace, line: &str) -> String {
    let output = run(place, "sh", &["-c", line]);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{line}\n{}{}", text(&output.stdout), text(&output.stderr));
    text(&output.stdout)
}

/// Returns the document of `plan status` and its exit status.
fn status(place: &Workplace, folder: &str) -> (Value, Option<i32>) {
    let outcome = place.run(&format!("plan status {folder} --json"));
    let document = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(faults("plan status", &document), Vec::<String>::new());
    (document, outcome.status)
}

fn counts(document: &Value) -> [u64; 4] {
    ["done", "running", "failed", "missing"].map(|key| document[key].as_u64().unwrap())
}

/// Returns the rows of a CSV file, without its head that states the command.
fn rows(place: &Workplace, name: &str) -> Vec<String> {
    place.text(name).lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect()
}

#[test]
fn a_plan_for_the_shell_is_run_to_the_bytes_of_one_run() {
    let place = Workplace::new();
    place.run(&format!("{COMMAND} -o one.csv")).ok();
    let said = place.run(&format!("plan --shards 5 --for shell -o job -- {COMMAND} -o s.csv")).ok();
    assert!(said.stdout.contains("sh job/submit"), "{}", said.stdout);
    assert!(said.stdout.contains("sphvar plan status job"), "{}", said.stdout);
    let (document, code) = status(&place, "job");
    assert_eq!((counts(&document), code), ([0, 0, 0, 5], Some(1)), "{document}");
    assert_eq!(document["resubmit"], "sh job/submit 1-5");
    place.run("merge job").fails(1, &["no part", "plan status job"]);
    // Some parts, then what is left of them.
    for part in [2, 4] {
        shell(&place, &format!("sh job/part {part}"));
    }
    let (document, code) = status(&place, "job");
    assert_eq!((counts(&document), code), ([2, 0, 0, 3], Some(1)), "{document}");
    assert_eq!(document["missing_parts"], serde_json::json!([1, 3, 5]));
    assert_eq!(document["progress"], 0.4);
    place.run("merge job").fails(1, &["missing: parts 1, 3, 5 of 5"]);
    let line = place.run("plan status job --resubmit");
    assert_eq!((&*line.stdout, line.status), ("sh job/submit 1,3,5\n", Some(1)));
    let before = fs::metadata(place.path("job/parts/0002.shard")).unwrap().modified().unwrap();
    shell(&place, line.stdout.trim());
    assert_eq!(rows(&place, "s.csv"), rows(&place, "one.csv"));
    let after = fs::metadata(place.path("job/parts/0002.shard")).unwrap().modified().unwrap();
    assert_eq!(before, after, "a part that is done is not computed again");
    let (document, code) = status(&place, "job");
    assert_eq!((counts(&document), code), ([5, 0, 0, 0], Some(0)), "{document}");
    assert_eq!((&document["merged"], &document["resubmit"]), (&Value::Bool(true), &Value::Null));
    let line = place.run("plan status job --resubmit").ok();
    assert_eq!(line.stdout, "");
    // All at once, in processes of this machine; the merge of a folder is that of its script.
    shell(&place, "rm job/parts/* s.csv && sh job/submit");
    assert_eq!(rows(&place, "s.csv"), rows(&place, "one.csv"));
    place.run("merge job -o merged.csv").ok();
    assert_eq!(rows(&place, "merged.csv"), rows(&place, "one.csv"));
    // Paths are relative to the folder of the plan.
    fs::create_dir(place.path("other")).unwrap();
    let mut elsewhere = place.command("merge ../job");
    let elsewhere = elsewhere.current_dir(place.path("other")).output().unwrap();
    Outcome::new("merge ../job", elsewhere).fails(1, &["relative to", "../job/parts/*.shard"]);
}

/// Words, folders and programs with everything that means something to a shell survive.
#[test]
fn hostile_words_survive() {
    let place = Workplace::new();
    let folder = "a 'b' \"c\" $HOME `id` \\ *\n; exit 3 %s # é";
    let inner = place.path(folder);
    fs::create_dir(&inner).unwrap();
    let points = "p $(touch x) '1' \"2\"\nq.csv";
    fs::write(inner.join(points), "x,y,z\n1,0,0\n0,1,0\n0,0,1\n").unwrap();
    let out = "s '$x' \n\"y\".csv";
    let sphvar = |words: &[&str]| {
        let output = place.command("").args(words).current_dir(&inner).output().unwrap();
        Outcome::new("", output)
    };
    let words = ["spectrum", "--points", points, "--lmax", "3", "-o", out];
    for engine in ["shell", "slurm", "hyperqueue", "dask"] {
        let job = format!("job {engine} $x 'y' %s");
        let plan = ["plan", "--shards", "2", "--for", engine, "-o", &job, "--"];
        sphvar(&[&plan[..], &words[..]].concat()).ok();
        let manifest: Value =
            serde_json::from_slice(&fs::read(inner.join(&job).join("manifest.json")).unwrap())
                .unwrap();
        assert_eq!(manifest["words"], serde_json::json!(words));
        assert_eq!(faults_of("files", "manifest.json of plan", &manifest), Vec::<String>::new());
        for file in manifest["files"].as_array().unwrap() {
            let path = inner.join(&job).join(file.as_str().unwrap());
            check_script(&path);
        }
        // Every engine runs the same script of a part.
        for part in ["1", "2"] {
            let script = inner.join(&job).join("part");
            let output = Command::new("sh").arg(script).arg(part).output().unwrap();
            let log = inner.join(&job).join(format!("logs/000{part}.out"));
            assert!(output.status.success(), "{}", fs::read_to_string(log).unwrap());
        }
        fs::remove_file(inner.join(out)).ok();
        let merge = Command::new("sh").arg(inner.join(&job).join("merge")).output().unwrap();
        assert!(merge.status.success(), "{}", String::from_utf8_lossy(&merge.stderr));
        assert!(inner.join(out).exists());
        assert!(!inner.join("x").exists(), "a word was run");
    }
    // The line that is printed is one of a shell.
    fs::remove_file(inner.join("job shell $x 'y' %s/parts/0001.shard")).unwrap();
    let line = sphvar(&["plan", "status", "job shell $x 'y' %s", "--resubmit"]).stdout;
    let output = Command::new("sh").args(["-c", &line]).current_dir(&inner).output().unwrap();
    assert!(output.status.success(), "{line}{}", String::from_utf8_lossy(&output.stderr));
    sphvar(&["plan", "status", "job shell $x 'y' %s"]).ok();
}

/// Asserts that a script is valid in its language.
fn check_script(path: &std::path::Path) {
    let is_python = path.extension().is_some_and(|extension| extension == "py");
    let mut command = if is_python {
        let mut python = Command::new("python3");
        python.args(["-c", "import ast, sys; ast.parse(open(sys.argv[1]).read())"]);
        python
    } else {
        let mut shell = Command::new("sh");
        shell.arg("-n");
        shell
    };
    match command.arg(path).output() {
        Ok(output) => {
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success(), "{}: {message}", path.display());
        }
        // Python need not be installed.
        Err(error) => assert!(is_python, "{error}"),
    }
}

/// With programs in place of those of Slurm and HyperQueue, which record what they are given.
#[test]
fn engines_get_the_parts_and_the_merge() {
    let place = Workplace::new();
    fs::create_dir(place.path("bin")).unwrap();
    for name in ["sbatch", "hq"] {
        place.write(
            &format!("bin/{name}"),
            format!("#!/bin/sh\necho {name} \"$@\" >>\"$CALLS\"\necho '7;cluster'\n"),
        );
        shell(&place, &format!("chmod +x bin/{name}"));
    }
    let submit = |job: &str, parts: &str| {
        let here = place.path("");
        let here = here.display();
        shell(
            &place,
            &format!(
                "CALLS={here}/calls PATH=\"{here}/bin:$PATH\" sh {job}/submit {parts} && cat calls && rm calls"
            ),
        )
    };
    place
        .run(&format!(
            "plan --shards 16 --for slurm --time 2:00:00 --mem 4G -j 2 -o slurm -- {COMMAND} -o s.csv"
        ))
        .ok();
    let calls = submit("slurm", "3,7-9");
    assert!(calls.contains("sbatch --parsable --array=3,7-9 array.sbatch"), "{calls}");
    assert!(calls.contains("--dependency=afterok:7 "), "{calls}");
    let job = place.text("slurm/array.sbatch");
    for option in ["--array=1-16", "--cpus-per-task=2", "--time=2:00:00", "--mem=4G"] {
        assert!(job.contains(&format!("#SBATCH {option}\n")), "{job}");
    }
    assert!(place.text("slurm/part").contains("--threads 2"));
    place.run(&format!("plan --shards 3 --for hyperqueue -o hq -- {COMMAND} -j 3 -o s.csv")).ok();
    let calls = submit("hq", "");
    assert!(calls.contains("hq job submit-file job.toml"), "{calls}");
    let job = place.text("hq/job.toml");
    assert!(job.contains("id = 3\ncommand = [\"sh\", \"part\", \"3\"]\n"), "{job}");
    assert!(job.contains("command = [\"sh\", \"merge\"]\ndeps = [1,2,3]\n"), "{job}");
    assert_eq!(job.matches("resources = { \"cpus\" = 3 }").count(), 3, "{job}");
    let part = place.text("hq/part");
    let command = part.lines().last().unwrap();
    assert!(command.contains(" --threads 3 ") && !command.contains(" -j"), "{command}");
    shell(&place, "sh hq/submit 'x;y' 2>&1 | grep usage");
    assert!(place.text("slurm/array.sbatch").contains("#SBATCH --output=logs/slurm-%a.out\n"));
    let large = |parts: u32| {
        let words = format!("plan --shards {parts} --for slurm -o s{parts} -- {COMMAND}");
        place.run(&words).ok().stderr.contains("MaxArraySize")
    };
    assert!(large(1001) && !large(1000));
}

/// The number of threads of the planned command, however it is written, is that of the parts.
#[test]
fn threads_of_the_command_replace_those_of_plan() {
    let place = Workplace::new();
    for (i, (words, threads)) in [
        (format!("{COMMAND} -j0"), 0),
        (format!("{COMMAND} -j 0"), 0),
        (format!("-j=2 {COMMAND}"), 2),
        (format!("{COMMAND} --threads=2"), 2),
        (format!("--threads 2 {COMMAND}"), 2),
        (COMMAND.to_owned(), 3),
    ]
    .into_iter()
    .enumerate()
    {
        place.run(&format!("plan -j 3 --shards 2 --for shell -o {i} -- {words}")).ok();
        let part = place.text(&format!("{i}/part"));
        let command = part.lines().last().unwrap();
        assert_eq!(command.matches("--threads").count(), 1, "{command}");
        assert!(command.contains(&format!(" --threads {threads} ")), "{command}");
        assert!(!command.contains(" -j"), "{command}");
        shell(&place, &format!("sh {i}/submit"));
        assert_eq!(status(&place, &i.to_string()).1, Some(0));
    }
}

/// Parts that a plan does not have are usage errors of its scripts.
#[test]
fn scripts_check_the_numbers_of_parts() {
    let place = Workplace::new();
    place.run(&format!("plan --shards 3 --for shell -o job -- {COMMAND}")).ok();
    for (line, message) in [
        ("part", "missing the number of the part"),
        ("part x", "expected the number of a part, got \"x\""),
        ("part 03", "expected the number of a part"),
        ("part 17", "there is no part 17; usage: sh job/part NUMBER, from 1 to 3"),
        ("part 99999999999999999999999", "there is no part 9"),
        ("submit 99", "expected parts from 1 to 3, got \"99\""),
        ("submit 1,2-4", "expected parts from 1 to 3"),
        ("submit 3-1", "expected parts from 1 to 3"),
        ("submit 0", "expected parts from 1 to 3"),
        ("submit 1-2-3", "expected parts from 1 to 3"),
        ("submit 1-99999999999999999999999", "expected parts from 1 to 3"),
        ("submit 2-", "expected a list of parts"),
        ("submit ,", "expected a list of parts"),
    ] {
        let output = run(&place, "sh", &["-c", &format!("sh job/{line}")]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{line}: {text}");
        assert!(text.contains(message) && text.contains("usage: sh "), "{line}: {text}");
    }
    assert_eq!(counts(&status(&place, "job").0), [0, 0, 0, 3], "nothing was run");
    shell(&place, "sh job/submit 2,1,3-3");
    assert_eq!(status(&place, "job").1, Some(0));
}

/// A part that ends before its log starts has failed, with what it printed.
#[test]
fn a_part_that_does_not_start_has_failed() {
    let place = Workplace::new();
    place.run(&format!("plan --shards 3 --for slurm -o job -- {COMMAND} -o s.csv")).ok();
    place.write("usage", "#!/bin/sh\nexec \"$TRUE_SPHVAR\" --no-such-flag\n");
    shell(&place, "chmod +x usage");
    for (program, part) in [("./nothing/sphvar", "1"), ("./usage", "2")] {
        let mut command = Command::new("sh");
        command.arg("job/part").arg(part).current_dir(place.path("")).env("SPHVAR", program);
        command.env("TRUE_SPHVAR", env!("CARGO_BIN_EXE_sphvar"));
        assert!(!command.output().unwrap().status.success());
    }
    let (document, code) = status(&place, "job");
    assert_eq!((counts(&document), code), ([0, 0, 2, 1], Some(2)), "{document}");
    for (i, words) in ["nothing/sphvar", "--no-such-flag"].iter().enumerate() {
        let message = document["failed_parts"][i]["message"].as_str().unwrap();
        assert!(message.contains(words), "{message}");
    }
    // What Slurm reports counts too.
    place.write("job/logs/slurm-3.out", "slurmstepd: error: *** DUE TO TIME LIMIT ***\n");
    let text = place.run("plan status job").stdout;
    assert!(text.contains("part 3: slurmstepd: error: *** DUE TO TIME LIMIT ***\n"), "{text}");
    assert!(text.contains("run failed and missing parts again: sh job/submit 1-3\n"), "{text}");
}

/// A plan is done when it is merged; a merge that failed states why and how it is run again.
#[test]
fn a_plan_is_done_when_it_is_merged() {
    let place = Workplace::new();
    fs::create_dir(place.path("results")).unwrap();
    place.run(&format!("plan --shards 2 --for shell -o job -- {COMMAND} -o results/s.csv")).ok();
    let text = place.run("plan status job").stdout;
    assert!(text.contains("nothing runs; unless the parts wait"), "{text}");
    assert!(text.contains(", run them: sh job/submit 1-2\n"), "{text}");
    shell(&place, "sh job/part 1; sh job/part 2");
    let (document, code) = status(&place, "job");
    assert_eq!((&document["merged"], code), (&Value::Null, Some(1)), "{document}");
    assert_eq!(document["resubmit"], "sh job/merge");
    let text = place.run("plan status job").stdout;
    assert!(text.contains("not merged; unless the merge waits"), "{text}");
    fs::remove_dir(place.path("results")).unwrap();
    assert!(!run(&place, "sh", &["job/merge"]).status.success());
    let (document, code) = status(&place, "job");
    assert_eq!((counts(&document), code), ([2, 0, 0, 0], Some(2)), "{document}");
    assert_eq!(document["merged"], false);
    assert!(document["merge_message"].as_str().unwrap().contains("results"), "{document}");
    assert_eq!(document["resubmit"], "sh job/merge");
    let text = place.run("plan status job").stdout;
    assert!(text.contains("the last merge failed: ") && text.contains("results"), "{text}");
    assert!(text.contains("run the merge again: sh job/merge\n"), "{text}");
    let line = place.run("plan status job --resubmit");
    assert_eq!((&*line.stdout, line.status), ("sh job/merge\n", Some(2)));
    fs::create_dir(place.path("results")).unwrap();
    shell(&place, line.stdout.trim());
    let (document, code) = status(&place, "job");
    assert_eq!((&document["merge_message"], code), (&Value::Null, Some(0)), "{document}");
}

#[test]
fn the_options_of_plan_stand_before_or_after_the_command() {
    let place = Workplace::new();
    for (job, words) in [
        ("a", format!("plan --shards 3 --for shell -o a -- {COMMAND} -o s.csv")),
        ("b", format!("plan --for=shell --shards=3 -o b {COMMAND} -o s.csv")),
        ("c", format!("plan {COMMAND} -o s.csv --shards 3 --for shell -o c")),
        ("d", format!("plan -- {COMMAND} -o s.csv --for=shell --out d --shards=3 --quiet")),
    ] {
        place.run(&words).ok();
        let manifest: Value =
            serde_json::from_str(&place.text(&format!("{job}/manifest.json"))).unwrap();
        let words: Vec<&str> = COMMAND.split(' ').chain(["-o", "s.csv"]).collect();
        assert_eq!(manifest["words"], serde_json::json!(words));
        assert_eq!(manifest["parts"], 3);
    }
    let names = place.names();
    assert_eq!(names, ["a", "b", "c", "d"], "nothing else");
    for (words, message) in [
        (format!("plan {COMMAND}"), "--shards"),
        (format!("plan --shards 2 -o x {COMMAND}"), "--for"),
        (format!("plan --shards 2 --for shell {COMMAND}"), "-o DIR"),
        ("plan --shards 2 --for shell -o x".to_owned(), "missing the command"),
        (format!("plan --shards 0 --for shell -o x {COMMAND}"), "0"),
        (format!("plan --shards 2 --for pbs -o x {COMMAND}"), "slurm, hyperqueue, dask, shell"),
        (format!("plan --shards 2 --for shell -o x {COMMAND} --shard 1/2 --save y"), "--shard"),
        (format!("plan --shards 2 --for shell -o x {COMMAND} --log y"), "--log"),
        (format!("plan --shards 2 --for shell -o x -s 3 {COMMAND}"), "--seed"),
        (
            format!("plan --shards 2 --for shell -o x --memory 100M {COMMAND}"),
            "--memory is an option",
        ),
        (
            format!("plan {COMMAND} --shards 2 --for shell -o x --memory 1G"),
            "--memory is an option",
        ),
        (format!("plan --shards 2 --for shell -o x --time 1 {COMMAND}"), "--for slurm"),
        (format!("plan --shards 2 --for slurm -o x --time 1;x {COMMAND}"), "expected minutes"),
        (format!("plan --shards 2 --for slurm -o x --mem 4GB {COMMAND}"), "4G"),
        ("plan --shards 2 --for shell -o x list samplers".to_owned(), "can: "),
        ("plan --shards 2 --for shell -o x spectrum jittered -n 12 --bad".to_owned(), "--bad"),
        ("plan --shards 2 --for shell -o x spectrum nothing -n 12".to_owned(), "nothing"),
        ("plan --shards 2 --for shell -o x --help-me".to_owned(), "--help-me"),
    ] {
        place.run(&words).fails(2, &[message]);
    }
    // What a part would find is found at once.
    place.run(&format!("plan --shards 2 --for shell -o x {COMMAND} -o no/s.csv")).fails(1, &["no"]);
    assert_eq!(place.names(), names);
    let said = place.run(&format!("plan --shards 30 --for shell -o x {COMMAND}")).ok();
    assert!(said.stderr.contains("23 indivisible pieces"), "{}", said.stderr);
}

#[test]
fn a_folder_has_one_plan() {
    let place = Workplace::new();
    let plan = |shards: u32| format!("plan --shards {shards} --for shell -o job -- {COMMAND}");
    place.run(&plan(3)).ok();
    shell(&place, "sh job/part 1");
    let part = place.bytes("job/parts/0001.shard");
    // The same plan is written again, and its parts stay.
    place.run(&plan(3)).ok();
    assert_eq!(place.bytes("job/parts/0001.shard"), part);
    place.run(&plan(4)).fails(1, &["job has another plan", "in 3 parts", "-o"]);
    let mut names = place.names_in("job");
    assert_eq!(names, ["logs", "manifest.json", "merge", "part", "parts", "submit"]);
    // Files that no plan describes are not replaced.
    fs::create_dir(place.path("mine")).unwrap();
    place.write("mine/merge", "mine");
    let plan = plan(3).replace("-o job", "-o mine");
    place.run(&plan).fails(1, &["mine has merge"]);
    names = place.names_in("mine");
    assert_eq!((names, place.text("mine/merge")), (vec!["merge".to_owned()], "mine".to_owned()));
    for (text, message) in [
        ("", "expected a file of sphvar plan"),
        ("{}", "missing field"),
        ("[1", "expected a file of sphvar plan"),
    ] {
        place.write("mine/manifest.json", text);
        place.run("plan status mine").fails(1, &["mine/manifest.json", message]);
        place.run("merge mine").fails(1, &["mine/manifest.json", message]);
    }
    let manifest = place.text("job/manifest.json");
    place.write("mine/manifest.json", manifest.replace("\"parts\": 3", "\"parts\": 99999999999"));
    place.run("plan status mine").fails(1, &["99999999999"]);
    place.write("mine/manifest.json", manifest.replace("\"form\": 1", "\"form\": 9"));
    place.run("plan status mine").fails(1, &["form 9"]);
    place.run("plan status logs").fails(1, &["logs"]);
    place.run("plan status job/logs").fails(1, &["no manifest.json"]);
}

#[test]
fn the_state_of_a_part_follows_from_its_files() {
    let place = Workplace::new();
    // A second of work for each of the parts, in pieces.
    let long = "spectrum poisson-disk -n 2000 -m 40000 --lmax 40 -o s.csv";
    place.run(&format!("plan --shards 4 --for shell -o long -- {long}")).ok();
    let mut child = Command::new("sh").arg(place.path("long/part")).arg("2").spawn().unwrap();
    let started = Instant::now();
    let running = loop {
        let (document, code) = status(&place, "long");
        assert_eq!(code, Some(1));
        if document["running_parts"][0]["done"].is_f64() {
            break document;
        }
        assert!(started.elapsed() < Duration::from_secs(60), "{document}");
        sleep(Duration::from_millis(50));
    };
    assert_eq!(counts(&running), [0, 1, 0, 3], "{running}");
    assert_eq!(running["running_parts"][0]["part"], 2);
    assert_eq!(running["resubmit"], "sh long/submit 1,3-4");
    let text = place.run("plan status long").stdout;
    assert!(text.contains("the missing parts wait for those that run"), "{text}");
    assert!(!text.contains("again"), "{text}");
    // The script is the process of the part, so this kills it.
    child.kill().unwrap();
    child.wait().unwrap();
    let (document, code) = status(&place, "long");
    assert_eq!((counts(&document), code), ([0, 0, 1, 3], Some(2)), "{document}");
    let message = document["failed_parts"][0]["message"].as_str().unwrap();
    assert!(message.contains("stopped without a message"), "{message}");
    assert_eq!(document["resubmit"], "sh long/submit 1-4");
    // A part that ends by a signal states it.
    let mut child = Command::new("sh").arg(place.path("long/part")).arg("3").spawn().unwrap();
    let log = place.path("long/logs/0003.jsonl");
    while !log.exists() {
        sleep(Duration::from_millis(20));
    }
    sleep(Duration::from_millis(300));
    shell(&place, &format!("kill -TERM {}", child.id()));
    child.wait().unwrap();
    let (document, _) = status(&place, "long");
    assert_eq!(counts(&document), [0, 0, 2, 2], "{document}");
    assert_eq!(document["failed_parts"][1]["message"], "ended by signal 15");

    // Files that are damaged, of another plan or of another part are not done.
    place.run(&format!("plan --shards 4 --for shell -o job -- {COMMAND}")).ok();
    place.run(&format!("plan --shards 4 --for shell -o other -- {COMMAND} -s 1")).ok();
    shell(&place, "for i in 1 2 3 4; do sh job/part $i; done; sh other/part 2");
    assert_eq!(counts(&status(&place, "job").0), [4, 0, 0, 0]);
    let mut damaged = place.bytes("job/parts/0001.shard");
    damaged[60] ^= 1;
    place.write("job/parts/0001.shard", damaged);
    shell(&place, "cp other/parts/0002.shard job/parts/0002.shard");
    shell(&place, "cp job/parts/0004.shard job/parts/0003.shard");
    let (document, code) = status(&place, "job");
    assert_eq!((counts(&document), code), ([1, 0, 3, 0], Some(2)), "{document}");
    let text = place.run("plan status job");
    for words in ["1 done, 0 running, 3 failed, 0 missing", "0001.shard", "damaged", "another plan"]
    {
        assert!(text.stdout.contains(words), "{words}: {}", text.stdout);
    }
    // Results of another run or part are not replaced.
    shell(&place, "rm job/parts/0002.shard job/parts/0003.shard; sh job/submit 1-3");
    assert_eq!(counts(&status(&place, "job").0), [4, 0, 0, 0]);

    // An error of a part is in its log.
    place.write("points.csv", "x,y,z\n1,0,0\n0,1,0\n");
    let files = "spectrum file:points.csv -m 9 --lmax 3 -o s.csv";
    place.run(&format!("plan --shards 2 --for shell -o files -- {files}")).ok();
    fs::remove_file(place.path("points.csv")).unwrap();
    let output = run(&place, "sh", &["files/submit"]);
    assert_eq!(output.status.code(), Some(1));
    let (document, _) = status(&place, "files");
    assert_eq!(counts(&document), [0, 0, 2, 0], "{document}");
    let message = document["failed_parts"][0]["message"].as_str().unwrap();
    assert!(message.contains("points.csv"), "{message}");
}

/// `--log` of any command: its lines, what it does not change, and what it does not replace.
#[test]
fn a_log_has_the_start_and_the_end_of_every_run() {
    let place = Workplace::new();
    let csv = format!("{COMMAND} -o s.csv");
    place.run(&csv).ok();
    let bytes = place.bytes("s.csv");
    place.run(&format!("{csv} --log run.jsonl")).ok();
    assert_eq!(place.bytes("s.csv"), bytes, "a log changes no result");
    place.run("--log=run.jsonl spectrum file:nothing.csv").fails(1, &["nothing.csv"]);
    let lines: Vec<Value> =
        place.text("run.jsonl").lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    for line in &lines {
        assert_eq!(faults_of("files", "lines of --log", line), Vec::<String>::new());
    }
    let events: Vec<&str> = lines.iter().map(|line| line["event"].as_str().unwrap()).collect();
    assert_eq!(events, ["start", "end", "start", "error"]);
    assert_eq!(lines[0]["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(lines[0]["words"][0], "spectrum");
    assert!(lines[1]["seconds"].as_f64().unwrap() >= 0.0);
    assert!(lines[3]["message"].as_str().unwrap().contains("nothing.csv"));
    assert_eq!(lines[3]["status"], 1);
    let log = place.bytes("run.jsonl");
    place.run("spectrum jittered -n 12 -m 2 --log s.csv").fails(1, &["s.csv", "not a log"]);
    place.run("spectrum jittered -n 12 -m 2 --log no/run.jsonl").fails(1, &["no/run.jsonl"]);
    place.run("spectrum jittered -n 12 -m 2 --log -").fails(2, &["--log"]);
    place.run("spectrum jittered -n 12 -m 2 --log x.csv -o x.csv").fails(1, &["x.csv"]);
    assert_eq!((place.bytes("s.csv"), place.bytes("run.jsonl")), (bytes, log));
}
