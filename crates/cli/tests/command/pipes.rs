//! Readers of standard output that close early, as `head -1` does: no message, exit status 0.

use std::io::{BufRead, BufReader, Read};

use crate::workplace::Workplace;

/// Each command writes far more than a pipe holds (64 KiB).
const LONG: [&str; 5] = [
    "sample white-noise -n 20000",
    "sample white-noise -n 20000 --json",
    "spectrum white-noise -n 2 -m 2 --lmax 3000 -o -",
    "eval cap-power --degrees 60 --lmax 20000",
    "healpix pix2ang --nside 128 pixels.csv",
];

#[test]
fn a_closed_pipe_is_not_a_failure() {
    let place = Workplace::new();
    place.write("pixels.csv", (0..20000).map(|i| format!("{i}\n")).collect::<String>());
    for arguments in LONG {
        let mut child = place.command(arguments).spawn().unwrap();
        let mut reader = BufReader::with_capacity(16, child.stdout.take().unwrap());
        let mut start = [0; 10];
        reader.read_exact(&mut start).unwrap();
        drop(reader);
        let mut stderr = String::new();
        child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        let status = child.wait().unwrap();
        assert_eq!(stderr, "", "sphvar {arguments}");
        assert_eq!(status.code(), Some(0), "sphvar {arguments}");
    }
}

#[test]
fn the_first_line_arrives() {
    let place = Workplace::new();
    let mut child = place.command("sample white-noise -n 20000").spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert!(line.trim_end() == "x,y,z", "{line}");
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
