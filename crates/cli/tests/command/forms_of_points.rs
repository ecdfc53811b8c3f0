//! The files of `sphvar sample`, read here byte by byte and by the command itself.

use crate::outcome::{numbers, same};
use crate::workplace::Workplace;

/// Returns the lines that are not comments.
fn lines(text: &str) -> Vec<&str> {
    text.lines().filter(|line| !line.starts_with('#')).collect()
}

/// Returns the coordinates of a CSV file, without a fourth column.
fn coordinates(text: &str) -> Vec<f64> {
    let rows = lines(text).into_iter().skip(1);
    rows.flat_map(|row| row.split(',').take(3).map(|x| x.parse().unwrap())).collect()
}

/// Returns the header of an NPY file and its numbers.
fn npy(bytes: &[u8]) -> (String, Vec<f64>) {
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00", "magic and version");
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!((10 + length) % 16, 0, "the data are aligned");
    let (header, data) = bytes[10..].split_at(length);
    let header = String::from_utf8(header.to_vec()).unwrap().replace(' ', "");
    (header, doubles(data))
}

fn doubles(data: &[u8]) -> Vec<f64> {
    let (chunks, rest) = data.as_chunks::<8>();
    assert!(rest.is_empty(), "{} bytes too many", rest.len());
    chunks.iter().map(|c| f64::from_le_bytes(*c)).collect()
}

#[test]
fn csv_of_one_set() {
    let place = Workplace::new();
    let outcome = place.run("sample jittered -n 48 -o p.csv").ok();
    assert_eq!(outcome.stdout, "");
    assert_eq!(place.names(), ["p.csv"]);
    let text = place.text("p.csv");
    let rows = lines(&text);
    assert_eq!(rows[0], "x,y,z");
    assert_eq!(rows.len(), 49);
    for row in &rows[1..] {
        let fields: Vec<&str> = row.split(',').collect();
        let p: Vec<f64> = fields.iter().map(|x| x.parse().unwrap()).collect();
        // Three squares and two additions, each rounded once, on top of a rounded direction.
        let length = p.iter().map(|x| x * x).sum::<f64>();
        assert!((length - 1.0).abs() < 8.0 * f64::EPSILON, "{row}: {length}");
        // The shortest digits that are read back as the same number, at most 17.
        for (field, x) in fields.iter().zip(&p) {
            assert_eq!(*field, format!("{x:?}"), "{row}");
        }
    }
    // The header is the first line, because many readers do not support comments.
    assert!(text.starts_with("x,y,z\n"), "{text}");
}

#[test]
fn csv_of_several_sets() {
    let place = Workplace::new();
    place.run("sample white-noise -n 5 -m 3 -o p.csv").ok();
    let text = place.text("p.csv");
    let rows = lines(&text);
    assert_eq!(rows[0], "x,y,z,set");
    let sets: Vec<&str> = rows[1..].iter().map(|row| row.split(',').nth(3).unwrap()).collect();
    assert_eq!(sets.join(""), "000001111122222");
}

#[test]
fn standard_output_is_the_csv_file() {
    let place = Workplace::new();
    place.run("sample white-noise -n 7 -m 2 -s 5 -o p.csv").ok();
    let file = place.text("p.csv");
    for arguments in ["sample white-noise -n 7 -m 2 -s 5 -o -", "sample white-noise -n 7 -m 2 -s 5"]
    {
        let outcome = place.run(arguments).ok();
        assert_eq!(lines(&outcome.stdout), lines(&file), "{arguments}");
        assert_eq!(outcome.stderr, "", "{arguments}");
    }
    assert_eq!(place.names(), ["p.csv"]);
}

#[test]
fn npy_has_the_shape_and_the_values_of_the_csv() {
    let place = Workplace::new();
    for (options, shape) in [("-n 12", "(12,3"), ("-n 12 -m 1", "(12,3"), ("-n 12 -m 4", "(4,12,3")]
    {
        place.run(&format!("sample jittered {options} -o p.npy")).ok();
        place.run(&format!("sample jittered {options} -o p.csv")).ok();
        let (header, data) = npy(&place.bytes("p.npy"));
        // Python allows a comma after the last item.
        let header = header.replace(",)", ")");
        let shape = format!("{shape})");
        for part in ["'descr':'<f8'", "'fortran_order':False", &format!("'shape':{shape}")] {
            assert!(header.contains(part), "{header} lacks {part}");
        }
        assert_eq!(data, coordinates(&place.text("p.csv")), "{options}");
    }
}

#[test]
fn ply_has_doubles_and_sets() {
    let place = Workplace::new();
    for (sets, stride) in [(1, 24), (2, 28)] {
        place.run(&format!("sample fibonacci -n 6 -m {sets} --rotate -o p.ply")).ok();
        place.run(&format!("sample fibonacci -n 6 -m {sets} --rotate -o p.csv")).ok();
        let bytes = place.bytes("p.ply");
        let end = b"end_header\n";
        let at = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        let header = std::str::from_utf8(&bytes[..at]).unwrap();
        assert!(
            header.starts_with("ply\nformat binary_little_endian 1.0\ncomment sphvar "),
            "{header}"
        );
        let vertices =
            format!("element vertex {}\nproperty double x\nproperty double y\n", 6 * sets);
        assert!(header.contains(&vertices), "{header}");
        assert_eq!(header.contains("property int set\n"), sets > 1, "{header}");
        let rows: Vec<&[u8]> = bytes[at..].chunks(stride).collect();
        let points: Vec<f64> = rows.iter().flat_map(|row| doubles(&row[..24])).collect();
        assert_eq!(points, coordinates(&place.text("p.csv")), "{sets} sets");
        if sets > 1 {
            let labels: Vec<u8> = rows.iter().map(|row| row[24]).collect();
            assert_eq!(labels, [0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1]);
        }
    }
}

#[test]
fn the_command_reads_what_it_writes() {
    let place = Workplace::new();
    let mut spectra = Vec::new();
    for name in ["p.csv", "p.npy", "p.ply"] {
        place.run(&format!("sample white-noise -n 40 -m 3 -o {name}")).ok();
        let document = place.run(&format!("spectrum --points {name} --lmax 8 --json")).json();
        assert_eq!(document["n"], 40, "{name}");
        assert_eq!(document["realizations"], 3, "{name}");
        spectra.push(numbers(&document["power"]));
    }
    assert_eq!(spectra[0], spectra[1]);
    assert_eq!(spectra[0], spectra[2]);
    // The document, and one file for each set.
    let document = place.run("sample white-noise -n 40 -m 3 --json").ok().stdout;
    place.write("p.json", &document);
    let read = place.run("spectrum --points p.json --lmax 8 --json").json();
    for (got, expected) in numbers(&read["power"]).into_iter().zip(&spectra[0]) {
        // `serde_json` may change the last bit of a number.
        assert!((got - expected).abs() < 1e-13 * expected.max(1.0), "{got}, {expected}");
    }
    for extension in ["csv", "npy", "ply"] {
        place.run(&format!("sample white-noise -n 40 -m 3 -o q{{i}}.{extension}")).ok();
        let files =
            ["q000000", "q000001", "q000002"].map(|name| format!("{name}.{extension}")).join(" ");
        let read = place.run(&format!("spectrum --points {files} --lmax 8 --json")).json();
        assert_eq!(numbers(&read["power"]), spectra[0], "{files}");
    }
    // Sets of different sizes cannot be one array, but can be written to files of their own.
    let disks = "sample poisson-disk:mode=saturated -n 100 -m 3 -o";
    place.run(&format!("{disks} d.npy")).fails(1, &["differ in size", "{i}"]);
    place.run(&format!("{disks} d{{i}}.npy")).ok();
    assert!(place.names().iter().any(|name| name == "d000002.npy"), "{:?}", place.names());
    let csv = place.text("p.csv");
    let piped = place.run_on("spectrum --points - --lmax 8 --json", &csv).json();
    assert_eq!(numbers(&piped["power"]), spectra[0]);
    // Three files of one set each are three realizations.
    let bare = lines(&csv);
    for set in ["0", "1", "2"] {
        let rows = bare[1..].iter().filter(|row| row.ends_with(&format!(",{set}")));
        let rows: Vec<&str> = rows.map(|row| &row[..row.len() - 2]).collect();
        place.write(&format!("{set}.txt"), rows.join("\n"));
    }
    let several = place.run("spectrum --points 0.txt 1.txt 2.txt --lmax 8 --json").json();
    assert_eq!(numbers(&several["power"]), spectra[0]);
}

#[test]
fn hemisphere_and_rotation() {
    let place = Workplace::new();
    let half = coordinates(&place.run("sample jittered -n 24 --hemisphere").ok().stdout);
    assert_eq!(half.len(), 72);
    assert!(half.chunks(3).all(|p| p[2] >= 0.0), "{half:?}");
    let plain = coordinates(&place.run("sample healpix -n 12 -m 2").ok().stdout);
    assert_eq!(plain[..36], plain[36..], "a lattice is the same each time");
    let rotated = coordinates(&place.run("sample healpix -n 12 -m 2 --rotate").ok().stdout);
    assert_ne!(rotated[..36], rotated[36..], "and --rotate rotates each realization independently");
    assert_ne!(rotated[..36], plain[..36]);
}

#[test]
fn pictures_are_svg_and_png() {
    let place = Workplace::new();
    for name in ["p.svg", "p.png"] {
        place.run(&format!("sample fibonacci -n 100 -o {name}")).ok();
        place.run(&format!("spectrum healpix -n 48 -o spectrum-{name}")).ok();
    }
    assert_eq!(place.names(), ["p.png", "p.svg", "spectrum-p.png", "spectrum-p.svg"]);
    for name in place.names() {
        crate::comparison_files::assert_picture(&name, &place.bytes(&name));
    }
}

#[test]
fn json_of_points() {
    let place = Workplace::new();
    let shown = place.run("sample jittered -n 12 -m 2 --json").json();
    assert_eq!(
        (&shown["sampler"], &shown["n"], &shown["realizations"]),
        (&"jittered".into(), &12.into(), &2.into())
    );
    let sets = shown["points"].as_array().unwrap();
    assert_eq!(sets.len(), 2);
    assert_eq!(sets[0].as_array().unwrap().len(), 12);
    let csv = coordinates(&place.run("sample jittered -n 12 -m 2").ok().stdout);
    for (shown, written) in numbers(&sets[0][0]).into_iter().zip(&csv) {
        assert!(same(shown, *written), "{shown}, {written}");
    }
    // If the points are written to a file, the document describes it.
    let written = place.run("sample jittered -n 12 -m 2 --json -o p.npy").json();
    assert_eq!(written["n"], 12);
    assert!(written.get("points").is_none(), "{written}");
    assert_eq!(npy(&place.bytes("p.npy")).1, csv);
}
