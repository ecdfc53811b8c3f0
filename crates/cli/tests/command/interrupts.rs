//! Interrupts at random times: the exit status is that of the signal, and no unfinished or partial
//! files remain.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::thread::sleep;
use std::time::Instant;

use crate::workplace::Workplace;

/// The variable with the number of interrupts; `just interrupts` sends more.
const COUNT: &str = "SPHVAR_INTERRUPTS";
const DEFAULT_COUNT: usize = 4;

/// Commands that write files, most of them long enough to be interrupted.
const COMMANDS: [&str; 14] = [
    "sample white-noise -n 300000 -m 2 -o points.csv",
    "sample white-noise -n 300000 -m 3 -o points-{i}.ply",
    "sample white-noise -n 1000000 -m 2 -o points.npy",
    "sample white-noise -n 2000 -o picture.png",
    "spectrum jittered -n 972 -m 40 --lmax 90 -o s.csv --per-order orders.csv --coefficient 4 1 c.csv",
    "spectrum jittered -n 972 -m 200 --lmax 90 --save s.shard",
    "variance jittered,healpix -n 48,192 --integrand cap:degrees=60 -m 2000 -o v.csv",
    "compare jittered,healpix -n 48,192 --integrand cap:degrees=60 -m 2000 -o out",
    "render cornell --sampler jittered -n 12 --size 48 --cache cache -o picture.exr --error error.png",
    "lights data/city.exr -n 2000 -o lights.csv --picture lights.png",
    "healpix pix2vec --nside 256 pixels.npy -o vectors.csv",
    "bounds white-noise -n 192 -m 4000 -o bounds.csv",
    "reproduce C.1 --quick -o figures",
    "weights noise.csv --degree 60 -o weights.csv",
];

/// Random numbers that suffice for times and selections only.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    /// Returns a number below `end` (splitmix64).
    pub(crate) fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % end
    }
}

fn prepared() -> Workplace {
    let place = Workplace::new();
    let pixels: Vec<u8> = (0..786_432_i64).flat_map(i64::to_le_bytes).collect();
    let head = "{'descr': '<i8', 'fortran_order': False, 'shape': (786432,), }";
    let head = format!("{head:<117}\n");
    let start = [b"\x93NUMPY\x01\x00".as_slice(), &118_u16.to_le_bytes(), head.as_bytes()].concat();
    place.write("pixels.npy", [start, pixels].concat());
    place.run("sample white-noise -n 5000 -o noise.csv").ok();
    place
}

/// Returns all files below a folder with their content, and all folders.
pub(crate) fn tree(root: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(root).unwrap().to_path_buf();
            if path.is_dir() {
                found.insert(name, None);
                folders.push(path);
            } else {
                found.insert(name, Some(fs::read(path).unwrap()));
            }
        }
    }
    found
}

pub(crate) fn send(child: &Child, signal: &str) {
    let status = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(status.success());
}

/// Returns the status that a shell shows: 128 plus the signal, whether the command ends itself or
/// is ended earlier.
fn shown(status: ExitStatus) -> i32 {
    status.code().or_else(|| Some(128 + status.signal()?)).unwrap()
}

#[test]
fn nothing_unfinished_is_left() {
    let count = std::env::var(COUNT).map_or(DEFAULT_COUNT, |count| count.parse().unwrap());
    let mut numbers = Numbers(1);
    let mut whole = BTreeMap::new();
    let mut ended = 0;
    for i in 0..count {
        // 5 and 12 are coprime, so every command is selected.
        let command = COMMANDS[5 * i % COMMANDS.len()];
        let (files, time) = whole.entry(command).or_insert_with(|| {
            let place = prepared();
            let start = Instant::now();
            place.run(&format!("{command} --quiet")).ok();
            (tree(&place.path("")), start.elapsed())
        });
        let (signal, status) = [("-INT", 130), ("-TERM", 143), ("-HUP", 129)][i % 3];
        let place = prepared();
        let mut child = place.command(&format!("{command} --quiet")).spawn().unwrap();
        sleep(time.mul_f64(numbers.below(1000) as f64 / 1000.0));
        send(&child, signal);
        let got = shown(child.wait().unwrap());
        assert!(got == status || got == 0, "{signal} to {command}: {got}");
        ended += usize::from(got == status);
        for (name, content) in tree(&place.path("")) {
            let known = files.get(&name).unwrap_or_else(|| {
                panic!("{signal} to {command} left {}", name.display());
            });
            let is_record = name.extension().is_some_and(|x| x == "json");
            assert!(is_record || *known == content, "{signal} to {command}: {}", name.display());
            let is_folder = content.is_none();
            let is_empty = is_folder && fs::read_dir(place.path(&name)).unwrap().next().is_none();
            assert!(!is_empty, "{signal} to {command} left {} empty", name.display());
        }
    }
    assert!(4 * ended >= count, "{ended} of {count} runs were interrupted before their end");
}

/// Files of a run that could not clean up are removed by the next one; those of a live run and
/// other files are kept.
#[test]
fn files_of_a_killed_run_are_removed() {
    let place = Workplace::new();
    let left = place.path(".p.csv.sphvar-1-0.tmp");
    let others =
        [".p.csv.tmp", ".p.csv.sphvar-x-0.tmp", "p.csv.sphvar-1-0.tmp", ".p.csv.abcdef.tmp"];
    fs::write(&left, "half").unwrap();
    for name in others {
        place.write(name, "a user's");
    }
    let held = fs::File::create(place.path(".q.csv.sphvar-1-7.tmp")).unwrap();
    held.lock().unwrap();
    place.run("sample fibonacci -n 12 -o p.csv").ok();
    let mut wanted = vec![".q.csv.sphvar-1-7.tmp", "p.csv"];
    wanted.extend(others);
    wanted.sort_unstable();
    assert_eq!(place.names(), wanted);
    drop(held);
    place.run("sample fibonacci -n 12 -o p.csv").ok();
    assert!(!place.names().contains(&".q.csv.sphvar-1-7.tmp".to_owned()));
}

/// A signal that the caller has set to be ignored, as `nohup` does, stays ignored.
#[test]
fn ignored_signals_are_ignored() {
    let place = Workplace::new();
    let binary = env!("CARGO_BIN_EXE_sphvar");
    let script = format!(
        "trap '' HUP; {binary} sample white-noise -n 200000 -m 4 -o p.csv --quiet & child=$!; \
         sleep 0.1; kill -HUP $child; wait $child"
    );
    let status = Command::new("sh").args(["-c", &script]).current_dir(place.path("")).status();
    assert!(status.unwrap().success());
    assert_eq!(place.names(), ["p.csv"]);
}

/// A file that exceeds the size limit causes a write error and does not end the process.
#[test]
fn a_limit_on_the_size_of_files_is_an_error() {
    let place = Workplace::new();
    let binary = env!("CARGO_BIN_EXE_sphvar");
    let script = format!("ulimit -f 8; {binary} sample white-noise -n 20000 -o p.csv");
    let output = Command::new("sh").args(["-c", &script]).current_dir(place.path("")).output();
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("cannot write p.csv: File too large"), "{message}");
    assert!(place.names().is_empty(), "{:?}", place.names());
}
