//! Parts and merges that are killed at random times: the same commands continue, the results are
//! bit-identical to those of one run, and no other file remains.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::interrupts::{Numbers, send, tree};
use crate::outcome::Outcome;
use crate::workplace::Workplace;

/// The variable with the number of kills; `just kills` sends more.
const COUNT: &str = "SPHVAR_KILLS";
const DEFAULT_COUNT: usize = 4;

/// The number of parts of each run.
const PARTS: usize = 3;

/// Commands whose work can be divided, with the files that they write.
const COMMANDS: [&str; 13] = [
    "variance jittered,fibonacci -n 48,192 --integrand cap:degrees=60 -m 20000 -o v.csv",
    "spectrum jittered -n 972 -m 600 --lmax 90 -o s.csv --per-order orders.csv",
    "compare white-noise,jittered,healpix -n 48,192 --integrand cap:degrees=60 -m 10000 -o out",
    "sample poisson-disk -n 2000 -m 30 -o points-{i}.csv",
    "render cornell --study --samplers jittered,fibonacci -n 6,24 -m 30 --size 40x37 --reference-count 256 --cache none \
     -o study.csv",
    "spectrum poisson-disk -n 400 -m 300 --lmax 40 -o s.png",
    "reproduce C.1 4.10 --quick -o figures",
    "variance sobol,r2 -n 64 --integrand cap:degrees=60 -m 40000 -o v.csv",
    "sample jittered -n 19200 -m 9 -o points.npy",
    "progressive sobol,halton -n 64 --integrand cap:degrees=60 -m 500 -o errors.csv",
    "audit jittered -n 192 -m 600 -o a.csv",
    "spectrum --points sets.npy --lmax 60 -o s.csv",
    "audit --points sets.npy --lmax 4 -o a.csv",
];

/// A run for the tests that do not need much of it.
const SHORT: &str =
    "variance jittered,fibonacci -n 48,192 --integrand cap:degrees=60 -m 4000 -o v.csv";

/// The files of a folder, by name, without the content of folders and of parts, which may have times.
type Files = BTreeMap<PathBuf, Option<Vec<u8>>>;

/// A command and what it does when nothing interrupts it.
struct Undisturbed {
    files: Files,
    part: Duration,
    merge: Duration,
}

fn part(command: &str, part: usize) -> String {
    format!("{command} --shard {part}/{PARTS} --save {part}.shard --quiet")
}

fn merge() -> String {
    let files: Vec<String> = (1..=PARTS).map(|part| format!("{part}.shard")).collect();
    format!("merge {} --quiet", files.join(" "))
}

impl Undisturbed {
    fn new(command: &str) -> Self {
        let place = prepared();
        place.run(&format!("{command} --quiet")).ok();
        let mut files = tree(&place.path(""));
        let place = prepared();
        let time = |arguments: &str| {
            let start = Instant::now();
            place.run(arguments).ok();
            start.elapsed()
        };
        let parts = (1..=PARTS).map(|i| time(&part(command, i))).sum::<Duration>();
        files.extend((1..=PARTS).map(|i| (PathBuf::from(format!("{i}.shard")), None)));
        let merge = time(&merge());
        assert_same(&tree(&place.path("")), &files, command);
        Self { files, part: parts.div_f64(PARTS as f64), merge }
    }
}

/// Returns a folder with the files that commands read.
fn prepared() -> Workplace {
    let place = Workplace::new();
    place.run("sample jittered -n 192 -m 300 -o sets.npy").ok();
    place
}

fn assert_same(got: &Files, wanted: &Files, command: &str) {
    let names = |files: &Files| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(got), names(wanted), "{command}");
    for (name, content) in wanted.iter().filter(|(_, content)| content.is_some()) {
        assert!(got[name] == *content, "{command}: other bytes in {}", name.display());
    }
}

/// Runs a command to its end after it was killed once or twice, at random times of its run.
/// Returns how many times a kill came before the end.
fn run_killed(place: &Workplace, arguments: &str, time: Duration, numbers: &mut Numbers) -> usize {
    let attempts = 1 + numbers.below(2);
    let mut killed = 0;
    for _ in 0..attempts {
        let mut child = place.command(arguments).stdout(Stdio::null()).spawn().unwrap();
        sleep(time.mul_f64(numbers.below(1000) as f64 / 1000.0));
        child.kill().unwrap();
        let status = child.wait().unwrap();
        assert!(status.signal() == Some(9) || status.success(), "{arguments}: {status}");
        killed += usize::from(status.signal() == Some(9));
    }
    place.run(arguments).ok();
    killed
}

#[test]
fn killed_work_is_continued_to_the_bytes_of_one_run() {
    let count = std::env::var(COUNT).map_or(DEFAULT_COUNT, |count| count.parse().unwrap());
    let mut numbers = Numbers(2);
    let mut undisturbed = BTreeMap::new();
    let mut killed = 0;
    for round in 0.. {
        if killed >= count {
            break;
        }
        assert!(round < 10 + count, "only {killed} processes were killed before their end");
        let command = COMMANDS[round % COMMANDS.len()];
        let expected = undisturbed.entry(command).or_insert_with(|| Undisturbed::new(command));
        let place = prepared();
        let first = usize::try_from(numbers.below(PARTS as u64)).unwrap();
        for i in 0..PARTS {
            let arguments = part(command, 1 + (first + i) % PARTS);
            killed += run_killed(&place, &arguments, expected.part, &mut numbers);
        }
        killed += run_killed(&place, &merge(), expected.merge, &mut numbers);
        assert_same(&tree(&place.path("")), &expected.files, command);
    }
}

/// A part that ends by a signal keeps its finished work, and the next run removes it.
#[test]
fn interrupted_parts_keep_their_work() {
    let command = SHORT;
    let expected = Undisturbed::new(command);
    let place = prepared();
    for (i, signal) in (1..=PARTS).zip(["-INT", "-TERM", "-HUP"]) {
        let mut child = place.command(&part(command, i)).stdout(Stdio::null()).spawn().unwrap();
        sleep(expected.part.mul_f64(0.6));
        send(&child, signal);
        child.wait().unwrap();
        // The signal may come after the end.
        let own = [format!("{i}.shard"), format!("{i}.shard.unfinished")];
        let names = place.names().into_iter().filter(|name| !own.contains(name));
        let done = (1..i).map(|done| format!("{done}.shard")).chain(["sets.npy".to_owned()]);
        assert_eq!(names.collect::<Vec<_>>(), done.collect::<Vec<_>>(), "{signal}");
        place.run(&part(command, i)).ok();
    }
    place.run(&merge()).ok();
    assert_same(&tree(&place.path("")), &expected.files, command);
}

/// Of several processes of the same part, one computes it; the others wait or end with an error.
#[test]
fn a_part_is_computed_by_one_process() {
    let command = SHORT;
    let expected = Undisturbed::new(command);
    let place = prepared();
    for i in 1..=PARTS {
        let start = |_| place.command(&part(command, i)).spawn().unwrap();
        let children: Vec<_> = (0..3).map(start).collect();
        let outcomes: Vec<Outcome> = children
            .into_iter()
            .map(|child| Outcome::new(command, child.wait_with_output().unwrap()))
            .collect();
        assert!(outcomes.iter().any(|outcome| outcome.status == Some(0)));
        for outcome in outcomes {
            let is_in_use = outcome.stderr.contains("another process computes the same part");
            assert!(outcome.status == Some(0) || is_in_use, "{}", outcome.stderr);
        }
    }
    place.run(&merge()).ok();
    assert_same(&tree(&place.path("")), &expected.files, command);
}

/// Where results cannot be written, the part is an error and leaves no file under its name; it
/// continues where they can.
#[test]
fn a_part_without_space_is_an_error() {
    let command = SHORT;
    let expected = Undisturbed::new(command);
    let place = prepared();
    let run = part(command, 1);
    let script = format!("ulimit -f 1; exec {} {run}", env!("CARGO_BIN_EXE_sphvar"));
    let output = Command::new("sh").args(["-c", &script]).current_dir(place.path("")).output();
    let outcome = Outcome::new(&run, output.unwrap());
    assert_eq!(outcome.status, Some(1), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("cannot write 1.shard"), "{}", outcome.stderr);
    assert!(!place.names().contains(&"1.shard".to_owned()), "{:?}", place.names());
    for i in 1..=PARTS {
        place.run(&part(command, i)).ok();
    }
    place.run(&merge()).ok();
    assert_same(&tree(&place.path("")), &expected.files, command);
}
