//! Catalogues of more points than a block, which are read and transformed in blocks.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::Value;

use crate::workplace::Workplace;

/// One block and a few points more.
const N: usize = (1 << 20) + 1000;

/// Returns vectors with weights: quasi-random directions, one of which is not of unit length.
fn rows(n: usize) -> Vec<[f64; 4]> {
    let row = |k: usize| {
        let z = 2.0 * ((k as f64 * 0.618_033_988_749_895).fract()) - 1.0;
        let phi = std::f64::consts::TAU * (k as f64 * 0.414_213_562_373_095).fract();
        let r = (1.0 - z * z).sqrt();
        let length = if k + 5 == N { 1.001 } else { 1.0 };
        let weight = 1.0 + (k % 7) as f64 * if k < n / 2 { 1.0 } else { 1e3 };
        [length * r * phi.cos(), length * r * phi.sin(), length * z, weight]
    };
    (0..n).map(row).collect()
}

/// Returns an NPY file of these rows.
fn npy(rows: &[[f64; 4]], is_fortran: bool) -> Vec<u8> {
    let order = if is_fortran { "True" } else { "False" };
    let shape = rows.len();
    let header = format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': ({shape}, 4), }}");
    let mut bytes = [&b"\x93NUMPY\x01\x00"[..], &118_u16.to_le_bytes()].concat();
    writeln!(bytes, "{header:<117}").unwrap();
    if is_fortran {
        (0..4).for_each(|c| rows.iter().for_each(|row| bytes.extend(row[c].to_le_bytes())));
    } else {
        rows.iter().flatten().for_each(|x| bytes.extend(x.to_le_bytes()));
    }
    bytes
}

/// Returns a spectrum without its time and command.
fn content(document: &Value) -> Value {
    let mut document = document.clone();
    let object = document.as_object_mut().unwrap();
    for key in ["provenance", "seconds", "sampler"] {
        object.remove(key);
    }
    document
}

const COLUMNS: &str = "--columns x,y,z,w --lmax 3";

#[test]
fn parts_formats_threads_and_memory_do_not_change_a_bit() {
    let place = Workplace::new();
    let rows = rows(N);
    place.write("a.npy", npy(&rows, false));
    let run = place.run(&format!("spectrum --points a.npy {COLUMNS} --json"));
    assert!(run.stderr.contains("1 of 1049576 vectors did not have unit length"), "{}", run.stderr);
    assert!(run.stderr.contains("a.npy[1049571], length 1.001"), "{}", run.stderr);
    let whole = content(&run.json());
    assert_eq!(whole["n"], N);
    assert_eq!((&whole["tail_even"], &whole["tail_odd"]), (&1.0.into(), &1.0.into()));
    let sum: f64 = rows.iter().map(|row| row[3]).sum();
    assert_eq!(whole["sum_w"], sum);
    // The same rows in two files, of which the first has some of the first block.
    place.write("b.npy", npy(&rows[..700_001], false));
    place.write("c.npy", npy(&rows[700_001..], true));
    let joined = format!("spectrum --points b.npy c.npy --join {COLUMNS}");
    let one = format!("{joined} -j 1 --memory 450M --quiet --json");
    assert_eq!(content(&place.run(&one).json()), whole);
    // More parts than blocks; the catalogue is not read again.
    for part in [3, 1, 2] {
        let save = format!("--shard {part}/3 --save {part}.shard --quiet");
        place.run(&format!("spectrum --points a.npy {COLUMNS} {save}")).ok();
    }
    std::fs::remove_file(place.path("a.npy")).unwrap();
    let merged = place.run("merge 2.shard 3.shard 1.shard --json");
    assert!(merged.stderr.contains("a.npy[1049571], length 1.001"), "{}", merged.stderr);
    assert_eq!(content(&merged.json()), whole);
}

#[test]
fn text_is_read_in_blocks_of_rows() {
    let place = Workplace::new();
    let mut text = "lon,lat\n".to_owned();
    for k in 0..N {
        use std::fmt::Write as _;
        // The first and the last block have an invalid row.
        match k {
            7 | 1_048_580 => text.push_str("1,\n"),
            _ => writeln!(text, "{},{}", k % 360, k * 7 % 90).unwrap(),
        }
    }
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(text.as_bytes()).unwrap();
    place.write("t.csv.gz", encoder.finish().unwrap());
    let arguments = "spectrum --points t.csv.gz --lmax 2";
    place.run(arguments).fails(1, &["t.csv.gz:9: lat", "--skip-invalid"]);
    let arguments = format!("{arguments} --skip-invalid");
    let run = place.run(&format!("{arguments} --json"));
    let words = "2 of 1049576 rows skipped as invalid: t.csv.gz:9, t.csv.gz:1048582";
    assert!(run.stderr.contains(words), "{}", run.stderr);
    let whole = content(&run.json());
    assert_eq!(whole["n"], N - 2);
    for part in [1, 2] {
        let save = format!("--shard {part}/2 --save {part}.shard --quiet");
        place.run(&format!("{arguments} {save}")).ok();
    }
    let merged = place.run("merge 1.shard 2.shard --json");
    assert!(merged.stderr.contains(words), "{}", merged.stderr);
    assert_eq!(content(&merged.json()), whole);
}

#[test]
fn sets_of_less_than_a_block_fall_into_parts_as_well() {
    let place = Workplace::new();
    place.write("s.csv", "x,y,z,set,u\n1,0,0,1,9\n0,1,0,1,9\n0,0,1,2,9\n0,0,-1,2,9\n0,1,0,3,9\n");
    for arguments in [
        "spectrum --points s.csv --lmax 3",
        "spectrum --points s.csv --lmax 3 --hemisphere",
        "spectrum --points s.csv --square --columns u=x,v=y --normalize --kmax 2",
    ] {
        let run = place.run(&format!("{arguments} --json"));
        let said = run.stderr.clone();
        let whole = content(&run.json());
        place.run(&format!("{arguments} --shard 2/2 --save b --quiet")).ok();
        place.run(&format!("{arguments} --shard 1/2 --save a --quiet")).ok();
        let text = place.text("s.csv");
        std::fs::remove_file(place.path("s.csv")).unwrap();
        let merged = place.run("merge a b --json");
        place.write("s.csv", text);
        for remark in said.lines() {
            assert!(merged.stderr.contains(remark), "{arguments}: {remark} in {}", merged.stderr);
        }
        assert_eq!(content(&merged.json()), whole, "{arguments}");
        // Results of another command are not replaced.
        for part in ["a", "b"] {
            std::fs::remove_file(place.path(part)).unwrap();
        }
    }
}

#[test]
fn what_cannot_be_divided_or_does_not_fit_is_an_error() {
    let place = Workplace::new();
    place.run("spectrum --points - --lmax 3 --shard 1/2 --save a").fails(
        2,
        &["--points -", "--shard", "standard input can be read only once", "name a file"],
    );
    place.write("a.npy", npy(&rows(N), false));
    let run = format!("spectrum --points a.npy {COLUMNS}");
    place
        .run(&format!("{run} --memory 20M"))
        .fails(1, &["--memory must be at least", "M for a spectrum", "got 20M"]);
    place.run(&format!("{run} --memory 8X")).fails(2, &["--memory", "500M or 8G"]);
    // A file that ends before its rows do is an error at once.
    let bytes = place.bytes("a.npy");
    place.write("a.npy", &bytes[..bytes.len() - 1]);
    place.run(&run).fails(1, &["a.npy: truncated"]);
}
