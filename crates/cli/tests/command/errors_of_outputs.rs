//! Outputs that cannot be written: a message, and no file under the final name or beside it.

use crate::workplace::Workplace;

/// One command of each kind that writes to a file, without the file's name.
const WRITERS: [(&str, &str); 8] = [
    ("sample fibonacci -n 12 -o", "csv"),
    ("sample fibonacci -n 12 -o", "npy"),
    ("sample fibonacci -n 12 -o", "png"),
    ("spectrum fibonacci -n 12 --lmax 4 -o", "csv"),
    ("spectrum fibonacci -n 12 --lmax 4 -o", "svg"),
    ("spectrum fibonacci -n 12 --lmax 4 --per-order", "csv"),
    ("variance fibonacci -n 12 --integrand ylm:l=2 -m 4 -o", "json"),
    ("bounds --profile step -n 12 -o", "csv"),
];

#[test]
fn a_folder_that_is_not_there() {
    let place = Workplace::new();
    for (command, extension) in WRITERS {
        let path = format!("no/such/f.{extension}");
        place
            .run(&format!("{command} {path}"))
            .fails(1, &[&path, "no/such does not exist", "create it"]);
        assert!(place.names().is_empty(), "{command}: {:?}", place.names());
    }
}

/// A parent that is a file is an error for all users, including the superuser.
#[test]
fn a_parent_that_is_a_file() {
    let place = Workplace::new();
    place.write("file", "kept");
    for (command, extension) in WRITERS {
        let path = format!("file/f.{extension}");
        place.run(&format!("{command} {path}")).fails(1, &[&path, "is a file and not a folder"]);
    }
    let compare = "compare fibonacci -n 12 --integrand ylm:l=2 -m 4 -o";
    place.run(&format!("{compare} file")).fails(1, &["file is a file", "folder"]);
    place.run(&format!("{compare} file/out")).fails(1, &["cannot write into file/out"]);
    assert_eq!(place.names(), ["file"]);
    assert_eq!(place.text("file"), "kept");
}

#[test]
fn a_target_that_is_a_folder_or_standard_output() {
    let place = Workplace::new();
    std::fs::create_dir(place.path("taken.csv")).unwrap();
    place.run("sample fibonacci -n 12 -o taken.csv").fails(1, &["taken.csv", "it is a folder"]);
    place.run("spectrum fibonacci -n 12 -o taken.csv").fails(1, &["taken.csv", "it is a folder"]);
    place
        .run("compare fibonacci -n 12 --integrand cosine -o -")
        .fails(2, &["-o must name a folder"]);
    assert_eq!(place.names(), ["taken.csv"]);
}

#[test]
fn unknown_extensions() {
    let place = Workplace::new();
    for (command, known) in [
        ("sample fibonacci -n 12 -o", ".csv, .npy, .npz, .ply (points), .svg, .png (a picture)"),
        ("spectrum fibonacci -n 12 -o", ".csv or .json, plots as .svg or .png"),
        ("variance fibonacci -n 12 --integrand cosine -m 4 -o", ".csv or .json"),
        ("bounds --profile step -n 12 -o", ".csv or .json"),
    ] {
        for name in ["p.xls", "p", "p.csv.gz"] {
            place.run(&format!("{command} {name}")).fails(2, &[name, known]);
        }
    }
    assert!(place.names().is_empty(), "{:?}", place.names());
}

/// An existing file is unchanged after a failed run.
#[test]
fn an_old_file_survives_a_failure() {
    let place = Workplace::new();
    for name in ["s.csv", "p.npy", "v.json"] {
        place.write(name, "old");
    }
    place.run("spectrum jittered -n 13 -o s.csv").fails(2, &["13"]);
    place.run("sample white-noise -n 99999999999999 -o p.npy").fails(1, &["memory"]);
    place.run("variance healpix -n 12 --integrand env:none.exr -o v.json").fails(1, &["none.exr"]);
    for name in place.names() {
        assert_eq!(place.text(&name), "old", "{name}");
    }
    assert_eq!(place.names(), ["p.npy", "s.csv", "v.json"]);
    place.run("sample fibonacci -n 12 -o p.npy").ok();
    assert!(place.bytes("p.npy").starts_with(b"\x93NUMPY"), "and a run that works replaces it");
}

/// Reports a check that a test had to skip.
#[cfg(unix)]
fn skipped(what: &str) {
    // Written through the handle because of the lint; the harness shows it with --nocapture.
    let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("skipped: {what}\n"));
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_or_file() {
    use std::fs::{Permissions, set_permissions};
    use std::os::unix::fs::PermissionsExt;

    let place = Workplace::new();
    // Read-only files are rejected even if permissions are not enforced.
    place.write("kept.csv", "kept");
    set_permissions(place.path("kept.csv"), Permissions::from_mode(0o444)).unwrap();
    place.run("sample fibonacci -n 12 -o kept.csv").fails(1, &["kept.csv", "read-only"]);
    assert_eq!(place.text("kept.csv"), "kept");

    std::fs::create_dir(place.path("closed")).unwrap();
    set_permissions(place.path("closed"), Permissions::from_mode(0o555)).unwrap();
    let probe = place.path("closed/probe");
    if std::fs::write(&probe, "").is_ok() {
        std::fs::remove_file(probe).unwrap();
        skipped("permissions do not bind here: a read-only folder");
    } else {
        for (command, extension) in WRITERS {
            let path = format!("closed/f.{extension}");
            place.run(&format!("{command} {path}")).fails(1, &[&path, "ermission denied"]);
        }
        let compare = "compare fibonacci -n 12 --integrand ylm:l=2 -m 4 -o closed";
        place.run(compare).fails(1, &["cannot write into closed", "ermission denied"]);
        assert!(place.names_in("closed").is_empty(), "{:?}", place.names_in("closed"));
    }
    set_permissions(place.path("closed"), Permissions::from_mode(0o755)).unwrap();
}

/// File names need not be UTF-8.
#[cfg(target_os = "linux")]
#[test]
fn names_that_are_not_text() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    let place = Workplace::new();
    let name = OsStr::from_bytes(b"\xff.csv");
    let mut command = place.command("sample fibonacci -n 12 -o");
    let outcome = command.arg(name).output().unwrap();
    assert!(outcome.status.success(), "{}", String::from_utf8_lossy(&outcome.stderr));
    assert!(place.path(name).is_file());
}
