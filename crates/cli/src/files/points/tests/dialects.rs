//! Text as other programs write it, and rows that cannot be used.

use glam::DVec3;

use super::super::ReadOptions;
use super::{doubles, npy, read, read_as, read_with};

/// Returns the message of the error with default options.
fn error(content: &str) -> String {
    read_with("p.csv", content, &ReadOptions::default()).unwrap_err()
}

#[test]
fn headers_of_catalogues() {
    let expected = [DVec3::X, DVec3::NEG_Y];
    let cases = [
        "RAJ2000,DEJ2000\n0,0\n270,0\n",
        "id;_RAJ2000;_DEJ2000;mag\n1;0;0;\n2;-90;0;5\n",
        "ALPHA_J2000\tDELTA_J2000\tname with blanks\n0\t0\ta b\n270\t0\t\n",
        "GLON GLAT\n360 0\n-450 0\n",
        "l,b\n0,0\n270,0\n",
        "# a title\n# ra dec\n0 0\n270 0\n",
        "#ra,dec,z\n0,0,0.5\n270,0,0.1\n",
        "\u{feff}Longitude,Latitude\r\n0,0\r\n630,0",
        "\u{3b1},ra,dec,\u{3b4}\n1,0,0,2\n1,270,0,2\n",
        "ra,dec,\n0,0,\n270,0,\n",
        "ra,dec\n0,0,\n270,0,\n",
        "ra,dec,\n0,0\n270,0\n",
        ",ra,dec\n0,0,0\n1,270,0\n",
        "# ra dec n\n0 0 \"\"\n270 0 5\n",
        "\"ra\",\"dec\",\"a \"\"note\"\"\"\n0,0,\"x,y\"\n\"270\",\"0\",\n",
    ];
    for content in cases {
        let back = read("p.csv", content);
        assert_eq!(back.sets[0].points, expected, "{content}");
        assert!(back.warnings.is_empty(), "{content}: {:?}", back.warnings);
    }
    // Comments in Latin-1 are skipped.
    let latin = b"# \xb0 and \xe9\nra,dec\n90,0\n#\xff\n";
    let back = read_with("p.csv", latin, &ReadOptions::default()).unwrap();
    assert_eq!(back.sets[0].points, [DVec3::Y]);
    // Three fields below a comment that names other quantities are still x y z.
    assert_eq!(read("p.txt", "# made by a program\n0 0 1\n").sets[0].points, [DVec3::Z]);
}

/// The tables of `VizieR` have names, units and dashes.
#[test]
fn units_and_dashes_below_a_header() {
    let top = "#RESOURCE=yCat_1239\n#Column\t_RAJ2000\t(F11.7)\n";
    let cases = [
        "_RAJ2000\t_DEJ2000\tVT\ndeg\tdeg\tmag\n---------\t--------\t---\n0\t0\t9\n270\t0\t\n",
        "recno;RAJ2000;DEJ2000;n\n;deg;deg;\n--------;---;---;-\n1;0;0;a\n2;270;0;\n\n#END#\n",
        "_RAJ2000\t_DEJ2000\n---\t---\n000.0\t+00.0\n270.0\t-00.0\n",
        "ra  dec\n--- ---\n0 0\n270 0\n",
        "ra,dec\r\ndeg,-\r\n---,----\r\n0,0\r\n270,0\r\n",
    ];
    for content in cases {
        let back = read("p.tsv", format!("{top}{content}"));
        assert_eq!(back.sets[0].points, [DVec3::X, DVec3::NEG_Y], "{content}");
        assert!(back.warnings.is_empty(), "{content}: {:?}", back.warnings);
    }
    // A line that is not followed by dashes is a row, and dashes elsewhere are a row too.
    for (content, part) in [
        ("ra,dec\ndeg,deg\n0,0\n", "p.csv:2: ra: expected a finite number, got \"deg\""),
        ("ra,dec\ndeg,deg\n", "p.csv:2: ra: expected a finite number, got \"deg\""),
        ("ra,dec\na,b\nc,d\n---,---\n", "p.csv:2: ra"),
        ("ra,dec\n0,0\n---,---\n", "p.csv:3: ra: expected a finite number, got \"---\""),
        ("ra,dec\n-,-\n0,0\n", "p.csv:2: ra: expected a finite number, got \"-\""),
        ("ra,dec\n---\n0,0\n", "p.csv:2: expected 2 fields"),
        ("ra,dec\nrad,rad\n---,---\n0,0\n", "ra in degrees, got ra in the unit rad"),
        ("ra,dec\n\"h:m:s\",\"d:m:s\"\n---,---\n0,0\n", "got ra in the unit h:m:s"),
        ("theta,phi\narcmin,rad\n---,---\n0,0\n", "theta in radians, got theta in the unit arcmin"),
        ("ra,dec\ndeg,deg\n---,---\n", "no points"),
    ] {
        let message = error(content);
        assert!(message.contains(part), "{message}\n{part}");
    }
    let options = ReadOptions { skip_invalid: true, ..ReadOptions::default() };
    let back = read_with("p.csv", "ra,dec\n,\n0,0\n", &options).unwrap();
    assert_eq!(back.warnings, ["p.csv: 1 of 2 rows skipped as invalid: p.csv:2"]);
}

#[test]
fn files_without_lines_of_utf_8_are_named() {
    let utf_16 = |text: &str, bytes: fn(u16) -> [u8; 2]| {
        text.encode_utf16().flat_map(bytes).collect::<Vec<u8>>()
    };
    for (content, part) in [
        (utf_16("\u{feff}x,y,z\n0,0,1\n", u16::to_le_bytes), "got UTF-16; save it as UTF-8"),
        (utf_16("\u{feff}x,y,z\n0,0,1\n", u16::to_be_bytes), "got UTF-16; save it as UTF-8"),
        (utf_16("x,y,z\n0,0,1\n", u16::to_le_bytes), "got zero bytes, as in UTF-16"),
        (b"x,y,z\r0,0,1\r".to_vec(), "lines that end in a carriage return alone"),
    ] {
        let message = read_with("p.csv", content, &ReadOptions::default()).unwrap_err();
        assert!(message.starts_with("p.csv:1: expected UTF-8 text"), "{message}");
        assert!(message.contains(part), "{message}\n{part}");
    }
}

#[test]
fn headers_with_several_directions_or_none() {
    let cases = [
        ("ra,dec,RAJ2000,DEJ2000\n0,0,0,0\n", "the column ra once, got ra and RAJ2000"),
        ("ra,dec,lon,lat\n0,0,0,0\n", "one way to name the point, chosen by"),
        ("ra,decl\n0,0\n", "the column dec beside the others of ra,dec, got the columns ra,decl"),
        ("ra,dec,ra\n0,0,0\n", "the column ra once"),
        ("ra,dec,w,weight\n0,0,1,1\n", "the column w once, got w and weight"),
        ("ra;dec\n0,0\n", "expected 2 fields (ra, dec), got 1, separated by semicolons"),
        ("ra;dec\n1,5;2,5\n", "ra: expected a finite number, got \"1,5\""),
        ("ra,dec\n", "no points"),
        ("\u{feff}", "no points"),
        ("\n\n# nothing\n\r\n", "no points"),
    ];
    for (content, part) in cases {
        let message = error(content);
        assert!(message.contains(part), "{message}\n{part}");
    }
    // The selection by name accepts either.
    let both = "ra,dec,RAJ2000,DEJ2000\n0,0,90,0\n";
    let back = read_as("p.csv", both, "ra=RAJ2000,dec=DEJ2000").unwrap();
    assert_eq!(back.sets[0].points, [DVec3::Y]);
    // A redshift is not a coordinate, and positions may skip it.
    let catalogue = "RA,DEC,Z,WT\n90,0,0.5,2\n";
    let back = read_as("p.csv", catalogue, "ra,dec,_,w").unwrap();
    assert_eq!(back.sets[0].weights, [2.0]);
    assert_eq!(back.remarks, ["p.csv: column not used: Z"]);
    let message = read_as("p.csv", "0 0\n", "ra=RA,dec=DEC").unwrap_err();
    assert!(message.contains("expected a header"), "{message}");
    let message = read_as("p.csv", "ra,dec\n0,0\n", "ra,dec,w").unwrap_err();
    assert!(message.contains("3 fields for --columns ra,dec,w, got 2"), "{message}");
}

#[test]
fn wide_headers_are_listed_in_part() {
    let names: Vec<String> = (0..100_000).map(|i| format!("c{i}")).collect();
    let zeros = vec!["0"; 100_000].join(",");
    let content = format!("{},ra,dec\n{zeros},90,0\n", names.join(","));
    let back = read("p.csv", &content);
    assert_eq!(back.sets[0].points, [DVec3::Y]);
    assert!(back.remarks[0].len() < 300, "{:?}", back.remarks);
    assert!(back.remarks[0].ends_with("c11,... (99988 more)"), "{:?}", back.remarks);
    let message = read_as("p.csv", &content, "ra=RA2000,dec=dec").unwrap_err();
    assert!(message.len() < 300 && message.contains("(99990 more)"), "{message}");
}

#[test]
fn invalid_rows_are_skipped_and_counted() {
    let content = "ra,dec,w\n0,0,1\n,,\n10,NaN,1\n1,91,1\n0,0\n90,0,inf\n90,0,2\nx,0,1\n-1,0,0,9\n";
    let options = ReadOptions { skip_invalid: true, ..ReadOptions::default() };
    let back = read_with("p.csv", content, &options).unwrap();
    assert_eq!(back.sets[0].points, [DVec3::X, DVec3::Y]);
    assert_eq!(back.sets[0].weights, [1.0, 2.0]);
    assert_eq!(
        back.warnings,
        ["p.csv: 7 of 9 rows skipped as invalid: p.csv:3, p.csv:4, p.csv:5, p.csv:6, p.csv:7, ..."]
    );
    let message = error(content);
    assert!(message.starts_with("p.csv:3: ra: expected a finite number, got \"\""), "{message}");
    assert!(message.contains("--skip-invalid"), "{message}");
    let message = read_with("p.csv", "x,y,z\n0,0,0\n", &options).unwrap_err();
    assert!(message.contains("got 1 invalid rows"), "{message}");

    let dictionary = "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 3), }";
    let rows = [0.0, 0.0, 1.0, f64::NAN, 0.0, 1.0, 0.0, 0.0, 0.0];
    let back = read_with("p.npy", npy(dictionary, &doubles(&rows)), &options).unwrap();
    assert_eq!(back.sets[0].points, [DVec3::Z]);
    assert_eq!(back.warnings, ["p.npy: 2 of 3 rows skipped as invalid: p.npy[1], p.npy[2]"]);
}

#[test]
fn vectors_far_from_unit_length_in_bulk() {
    let cases = [
        ("10 20 1\n200 -45 2\n359 80 1\n", "these look like degrees: --columns ra,dec,_"),
        ("1 2 0\n3 6 0.5\n0.1 4 1\n", "these look like angles in radians: --columns theta,phi,_"),
        ("100 200 300\n-500 600 1\n", "--normalize scales vectors"),
        ("2 0 0\n0 2 0\n0 0 1\n", "got 2 of 3 with other lengths"),
    ];
    for (content, part) in cases {
        let message = read_with("p.txt", content, &ReadOptions::default()).unwrap_err();
        assert!(message.contains("expected unit vectors x,y,z"), "{message}");
        assert!(message.contains(part), "{message}\n{part}");
        let options = ReadOptions { normalize: true, ..ReadOptions::default() };
        let back = read_with("p.txt", content, &options).unwrap();
        let lengths = back.sets[0].points.iter().map(|p| (p.length() - 1.0).abs());
        assert!(lengths.fold(0.0, f64::max) < 1e-15 && back.warnings.is_empty(), "{content}");
    }
    // Three digits are not another length, and a single stray vector is not most of them.
    for content in ["0.577 0.577 0.578\n0 0 1\n", "0 0 1\n0 1 0\n0 0 7\n"] {
        let back = read("p.txt", content);
        assert!(back.warnings[0].contains("vectors did not have unit length"), "{content}");
    }
}

#[test]
fn one_row_and_no_final_newline() {
    for content in ["0 0 1", "x,y,z\n0,0,1", "x,y,z\r\n0,0,1\r\n\r\n", "0,0,1,"] {
        assert_eq!(read("p.csv", content).sets[0].points, [DVec3::Z], "{content:?}");
    }
}
