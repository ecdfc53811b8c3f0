//! Targets that are not regular files, and names of extreme length.
#![cfg(unix)]

use std::fs::{self, File};
use std::io::Read;
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};

use crate::workplace::Workplace;

/// A command with a known output.
const POINTS: &str = "sample fibonacci -n 12 -o";

fn points() -> String {
    let place = Workplace::new();
    place.run(&format!("{POINTS} -")).ok().stdout
}

#[test]
fn links_are_followed_to_files_that_do_not_exist_yet() {
    let place = Workplace::new();
    fs::create_dir(place.path("deep")).unwrap();
    // Relative to the folder of the link, through a chain, and absolute.
    symlink("deep/near.csv", place.path("near.csv")).unwrap();
    symlink("deep/link.csv", place.path("far.csv")).unwrap();
    symlink("../real.csv", place.path("deep/link.csv")).unwrap();
    symlink(place.path("absolute-target.csv"), place.path("absolute.csv")).unwrap();
    for (link, target) in [
        ("near.csv", "deep/near.csv"),
        ("far.csv", "real.csv"),
        ("absolute.csv", "absolute-target.csv"),
    ] {
        for _ in 0..2 {
            place.run(&format!("{POINTS} {link}")).ok();
            assert!(fs::symlink_metadata(place.path(link)).unwrap().is_symlink(), "{link}");
            assert!(fs::symlink_metadata(place.path(target)).unwrap().is_file(), "{target}");
            assert_eq!(place.text(target), points());
        }
    }
    assert!(place.path("deep/link.csv").is_symlink());
}

#[test]
fn links_that_lead_nowhere_are_errors() {
    let place = Workplace::new();
    symlink("b.csv", place.path("a.csv")).unwrap();
    symlink("a.csv", place.path("b.csv")).unwrap();
    symlink("self.csv", place.path("self.csv")).unwrap();
    symlink("no/such/file.csv", place.path("lost.csv")).unwrap();
    fs::create_dir(place.path("folder")).unwrap();
    symlink("folder", place.path("to-folder.csv")).unwrap();
    let names = place.names();
    for (name, words) in [
        ("a.csv", "symbolic links form a loop"),
        ("self.csv", "symbolic links form a loop"),
        ("lost.csv", "no/such does not exist"),
        ("to-folder.csv", "it is a folder"),
        ("new.csv/", "it names no file"),
    ] {
        place.run(&format!("{POINTS} {name}")).fails(1, &[name, words]);
    }
    assert_eq!(place.names(), names);
}

#[test]
fn standard_output_by_its_other_names() {
    let place = Workplace::new();
    for name in ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"] {
        if !std::path::Path::new(name).exists() {
            continue;
        }
        assert_eq!(place.run(&format!("{POINTS} {name}")).ok().stdout, points(), "{name}");
        // A file that already has content keeps it.
        let script =
            format!("(echo head; {} {POINTS} {name}) > file", env!("CARGO_BIN_EXE_sphvar"));
        let run = Command::new("sh").args(["-c", &script]).current_dir(place.path("")).status();
        assert!(run.unwrap().success());
        assert_eq!(place.text("file"), format!("head\n{}", points()), "{name}");
        let script =
            format!("(echo head >&3; {} {POINTS} /dev/fd/3) 3> file", env!("CARGO_BIN_EXE_sphvar"));
        let run = Command::new("sh").args(["-c", &script]).current_dir(place.path("")).status();
        assert!(run.unwrap().success());
        assert_eq!(place.text("file"), format!("head\n{}", points()), "{name}");
        assert_eq!(place.names(), ["file"]);
    }
    place.run(&format!("{POINTS} /dev/null")).ok();
    for command in [
        "spectrum fibonacci -n 12 --lmax 4 -o /dev/stdout",
        "variance fibonacci -n 12 --integrand ylm:l=2 -m 4 -o /dev/stdout",
        "eval cap-power --degrees 60 --lmax 4 -o /dev/stdout",
    ] {
        let dash = place.run(&command.replace("/dev/stdout", "-"));
        let named = place.run(command);
        let numbers = |text: &str| text.lines().skip(1).map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(dash.status, named.status, "{command}");
        assert_eq!(numbers(&dash.stdout), numbers(&named.stdout), "{command}");
    }
    place
        .run("sample fibonacci -n 12 -o /dev/full")
        .fails(1, &["cannot write /dev/full", "No space left on device"]);
}

#[test]
fn pipes_are_written_to() {
    let place = Workplace::new();
    for name in ["pipe", "pipe.csv"] {
        assert!(Command::new("mkfifo").arg(place.path(name)).status().unwrap().success());
        let child = place.command(&format!("{POINTS} {name}")).stderr(Stdio::null()).spawn();
        let mut text = String::new();
        File::open(place.path(name)).unwrap().read_to_string(&mut text).unwrap();
        assert!(child.unwrap().wait().unwrap().success());
        assert_eq!(text, points(), "{name}");
        assert!(!fs::symlink_metadata(place.path(name)).unwrap().is_file(), "{name}");
    }
    // A pipe in a cache is not an image, and the command does not wait for it.
    place.run("render cornell --sampler jittered -n 12 --size 8 --cache cache --mse").ok();
    let reference = place.names_in("cache").remove(0);
    fs::remove_file(place.path("cache").join(&reference)).unwrap();
    let made = Command::new("mkfifo").arg(place.path("cache").join(&reference)).status();
    assert!(made.unwrap().success());
    place.run("render cornell --sampler jittered -n 12 --size 8 --cache cache --mse").ok();
}

#[test]
fn names_of_every_length() {
    let place = Workplace::new();
    for length in [200, 243, 244, 250, 255] {
        let name = format!("{}.csv", "n".repeat(length - 4));
        place.run(&format!("{POINTS} {name}")).ok();
        assert_eq!(place.text(&name), points(), "{length}");
        let wide = format!("{}.csv", "\u{e4}".repeat((length - 4) / 2));
        place.run(&format!("{POINTS} {wide}")).ok();
        assert_eq!(place.text(&wide), points(), "{length}");
    }
    let name = format!("{}.csv", "n".repeat(252));
    place.run(&format!("{POINTS} {name}")).fails(1, &["File name too long"]);
    assert_eq!(place.names().len(), 10);
}

#[test]
fn one_file_a_set() {
    let place = Workplace::new();
    let disks = "sample poisson-disk:mode=saturated -n 60 -m 5";
    place.run(&format!("{disks} -o all.csv")).ok();
    let all = place.text("all.csv");
    let rows = |set: usize| -> Vec<&str> {
        all.lines().skip(1).filter_map(|row| row.strip_suffix(&format!(",{set}"))).collect()
    };
    let counts: Vec<usize> = (0..5).map(|set| rows(set).len()).collect();
    assert!(counts.iter().any(|count| *count != counts[0]), "the sets differ in size: {counts:?}");
    place.run(&format!("{disks} -o all.npy")).fails(1, &["differ in size", "sets-{i}.npy"]);
    for extension in ["csv", "npy", "ply", "svg"] {
        place.run(&format!("{disks} -o set-{{i}}.{extension}")).ok();
    }
    for (set, count) in counts.iter().enumerate() {
        let text = place.text(&format!("set-{set:06}.csv"));
        assert_eq!(text.lines().skip(1).collect::<Vec<_>>(), rows(set));
        let head =
            String::from_utf8_lossy(&place.bytes(&format!("set-{set:06}.npy"))[..128]).into_owned();
        assert!(head.contains(&format!("({count}, 3")), "{head}");
        let ply = place.bytes(&format!("set-{set:06}.ply"));
        let line = format!("element vertex {count}\n");
        assert!(ply.windows(line.len()).any(|window| window == line.as_bytes()), "{line}");
        assert!(place.text(&format!("set-{set:06}.svg")).contains("<svg"));
    }
    assert_eq!(place.names().len(), 1 + 4 * 5);
    place.run(&format!("{disks} -o no/{{i}}.csv")).fails(1, &["no does not exist"]);
}

#[test]
fn a_comparison_is_overwritten_only_with_force() {
    let place = Workplace::new();
    let one = "compare fibonacci -n 12 --integrand cosine --hemisphere -m 4 -o out";
    let other = "compare fibonacci -n 24 --integrand cosine --hemisphere -m 4 -o out";
    place.run(one).ok();
    let before = place.bytes("out/comparison.json");
    place.run(&format!("{one} --quiet -j 1")).ok();
    place
        .run(other)
        .fails(1, &["out has the results of another run", "fibonacci -n 12", "--force"]);
    place.run(&format!("{one} -s 3")).fails(1, &["another run", "--force"]);
    assert_ne!(before, b"");
    place.run(&format!("{other} --force")).ok();
    assert!(place.text("out/comparison.csv").contains("-n 24"));
    place.run(one).fails(1, &["-n 24"]);
    fs::remove_file(place.path("out/comparison.json")).unwrap();
    place.run(other).fails(1, &["comparison.csv, spectra.csv", "not known", "--force"]);
    // Other files do not count as results.
    fs::create_dir(place.path("mine")).unwrap();
    place.write("mine/notes.txt", "kept");
    place.run(&one.replace("out", "mine")).ok();
    assert_eq!(place.text("mine/notes.txt"), "kept");
}

#[test]
fn two_runs_do_not_share_a_folder() {
    let place = Workplace::new();
    let long = "compare jittered -n 192 --integrand cap:degrees=60 -m 400000 -o out";
    let mut child = place.command(long).spawn().unwrap();
    while !place.path("out/.sphvar.lock").exists() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    std::thread::sleep(std::time::Duration::from_millis(100));
    let words = ["out", "another run", &format!("process {}", child.id()), "-m 400000"];
    place.run("compare fibonacci -n 12 --integrand cosine -o out --force").fails(1, &words);
    place.run("reproduce C.1 --quick -o out").fails(1, &words);
    // A killed run leaves its lock file, which no process holds.
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(place.names_in("out"), [".sphvar.lock"]);
    place.run("compare fibonacci -n 12 --integrand cosine -m 4 -o out").ok();
    assert!(!place.names_in("out").contains(&".sphvar.lock".to_owned()));
}

/// Files of a run that was killed while it wrote them do not count as results; other files and
/// complete results are kept.
#[test]
fn results_of_a_killed_comparison_are_replaced() {
    let place = Workplace::new();
    let one = "compare spiral -n 30 --integrand ylm:l=2 -m 4 -o out";
    let other = "compare white-noise -n 12 --integrand cosine -m 4 -o out";
    let lock = "writing, process 1: sphvar compare spiral -n 30\n";
    let half = ["comparison.csv", "spectra.csv", ".spectra.svg.sphvar-1-3.tmp"];
    let prepare = |lock: Option<&str>| {
        let _ = fs::remove_dir_all(place.path("out"));
        fs::create_dir(place.path("out")).unwrap();
        place.write("out/notes.txt", "kept");
        for name in half {
            place.write(&format!("out/{name}"), "half");
        }
        if let Some(lock) = lock {
            place.write("out/.sphvar.lock", lock);
        }
    };
    prepare(Some(lock));
    place.run(other).ok();
    assert_eq!(place.names_in("out").len(), 10, "{:?}", place.names_in("out"));
    assert_eq!(place.text("out/notes.txt"), "kept");
    // Without the mark they may belong to the user, even if a run was killed during its work.
    for lock in [None, Some(""), Some("process 1: sphvar compare spiral -n 30\n")] {
        prepare(lock);
        place.run(other).fails(1, &["comparison.csv, spectra.csv", "not known", "--force"]);
        assert_eq!(place.text("out/comparison.csv"), "half");
        assert!(!place.names_in("out").contains(&".sphvar.lock".to_owned()));
    }
    // Complete results, if the run was killed before it removed its lock.
    place.run(&format!("{one} --force")).ok();
    place.write("out/.sphvar.lock", lock);
    place.run(other).fails(1, &["the results of another run", "spiral -n 30", "--force"]);
    // Whenever a run is killed, another comparison is possible unless the results are complete.
    for delay in [0, 16, 40] {
        fs::remove_dir_all(place.path("out")).unwrap();
        let mut child = place.command(one).spawn().unwrap();
        while !place.path("out/comparison.csv").exists() && child.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        std::thread::sleep(std::time::Duration::from_millis(delay));
        child.kill().unwrap();
        child.wait().unwrap();
        if place.path("out/comparison.json").exists() {
            place.run(other).fails(1, &["spiral -n 30", "--force"]);
        } else {
            place.run(other).ok();
            assert_eq!(place.names_in("out").len(), 9, "{:?}", place.names_in("out"));
        }
    }
}

/// An error while results are written leaves no partial results, and earlier files are kept.
#[test]
fn results_that_cannot_be_written_are_removed() {
    let place = Workplace::new();
    fs::create_dir_all(place.path("out/variance.svg")).unwrap();
    place.write("out/spectra.csv", "mine");
    let compare = "compare fibonacci -n 12 --integrand cosine -m 4 -o out --force";
    place.run(compare).fails(1, &["variance.svg", "folder"]);
    assert_eq!(place.names_in("out"), ["spectra.csv", "variance.svg"]);
}
