//! Missing, damaged or invalid inputs: exit status 1 and a message with the file and the place.

use crate::workplace::{Workplace, small_exr};

/// Returns a table whose line 17 is `bad`, below a header and fifteen valid rows.
fn table_with(bad: &str) -> String {
    format!("x,y,z\n{}{bad}\n0,0,1\n", "0,0.6,0.8\n".repeat(15))
}

/// Asserts that the folder contains only the input.
fn assert_untouched(place: &Workplace, input: &str) {
    assert_eq!(place.names(), [input], "something was left beside the input");
}

#[test]
fn line_17_of_a_table() {
    for (bad, part) in [
        ("NaN,0,1", "x: expected a finite number, got \"NaN\""),
        ("0,0,-inf", "z: expected a finite number"),
        ("0,0,0", "a vector that has a direction, got the zero vector"),
        ("0,0", "expected 3 fields (x, y, z), got 2"),
        ("0,zero,1", "y: expected a finite number, got \"zero\""),
    ] {
        let place = Workplace::new();
        place.write("p.csv", table_with(bad));
        for output in ["", " -o s.csv", " --json", " -o s.svg"] {
            place
                .run(&format!("spectrum --points p.csv --lmax 8{output}"))
                .fails(1, &["p.csv:17", part]);
            assert_untouched(&place, "p.csv");
        }
    }
}

#[test]
fn other_point_files() {
    let cases: [(&str, &str, &[&str]); 5] = [
        ("p.csv", "", &["p.csv", "no points", "at least one"]),
        ("p.csv", "theta,phi\n4,0\n", &["p.csv:2", "theta", "[0, pi]"]),
        ("p.csv", "ra,dec\n4,95\n", &["p.csv:2", "dec", "[-90, 90]"]),
        ("p.npy", "x,y,z\n", &["p.npy", "magic"]),
        ("p.ply", "x,y,z\n", &["p.ply", "expected a PLY header"]),
    ];
    for (name, content, parts) in cases {
        let place = Workplace::new();
        place.write(name, content);
        place.run(&format!("spectrum --points {name} -o s.json")).fails(1, parts);
        assert_untouched(&place, name);
    }
    let place = Workplace::new();
    place.run_on("spectrum --points -", "x,y,z\n0,0,nan\n").fails(1, &["standard input:2", "nan"]);
    place.run("spectrum --points none.csv -o s.csv").fails(1, &["none.csv", "No such file"]);
    place.run("spectrum --points .").fails(1, &["cannot open .", "directory"]);
    assert!(place.names().is_empty(), "{:?}", place.names());
}

#[test]
fn truncated_arrays() {
    for extension in ["npy", "ply"] {
        let place = Workplace::new();
        let name = format!("p.{extension}");
        place.run(&format!("sample fibonacci -n 20 -o {name}")).ok();
        let whole = place.bytes(&name);
        for length in [whole.len() - 1, whole.len() - 200, 60, 9, 1] {
            place.write(&name, &whole[..length]);
            place.run(&format!("spectrum --points {name} -o s.csv")).fails(1, &[&name, "expected"]);
            assert_untouched(&place, &name);
        }
        place.write(&name, &whole[..whole.len() - 1]);
        let counts =
            [format!("expected {} bytes", whole.len()), format!("got {}", whole.len() - 1)];
        place.run(&format!("spectrum --points {name}")).fails(1, &[&counts[0], &counts[1]]);
    }
}

#[test]
fn environment_maps() {
    let place = Workplace::new();
    place.write("square.exr", small_exr(8, 8));
    for command in [
        "variance fibonacci -n 12 -o v.csv",
        "compare fibonacci -n 12",
        "bounds --profile step -n 12",
    ] {
        let arguments = format!("{command} --integrand env:square.exr");
        place.run(&arguments).fails(1, &["square.exr", "2:1", "width = 2 height", "8 x 8"]);
        place
            .run(&format!("{command} --integrand env:none.exr"))
            .fails(1, &["none.exr", "No such file"]);
        assert_untouched(&place, "square.exr");
    }
    let arguments = "variance fibonacci -n 12 --integrand env:square.exr,channel=alpha";
    place.run(arguments).fails(2, &["channel \"alpha\"", "luminance, r, g, b"]);
}

#[test]
fn damaged_environment_maps() {
    let place = Workplace::new();
    let whole = small_exr(16, 8);
    let mut flipped = whole.clone();
    // In the middle of the header's list of channels.
    flipped[40] ^= 0xff;
    let mut infinite = image::Rgb32FImage::new(16, 8);
    infinite.get_pixel_mut(3, 2).0[1] = f32::NAN;
    let mut with_nan = std::io::Cursor::new(Vec::new());
    infinite.write_to(&mut with_nan, image::ImageFormat::OpenExr).unwrap();
    let cases: [(&[u8], &str); 7] = [
        (&whole[..whole.len() - 1], "EXR or HDR"),
        (&whole[..100], "EXR or HDR"),
        (&whole[..4], "EXR or HDR"),
        (&[], "OpenEXR (.exr) or Radiance HDR (.hdr)"),
        (b"no picture at all", "OpenEXR (.exr) or Radiance HDR (.hdr)"),
        (&flipped, "EXR or HDR"),
        (with_nan.get_ref(), "texel (row 2, column 3)"),
    ];
    for (content, part) in cases {
        place.write("map.exr", content);
        for command in
            ["variance fibonacci -n 12 -m 4 -o v.csv", "compare fibonacci -n 12 -m 4 -o out"]
        {
            place.run(&format!("{command} --integrand env:map.exr")).fails(1, &["map.exr", part]);
            assert_untouched(&place, "map.exr");
        }
    }
}

#[test]
fn spectrum_files() {
    let place = Workplace::new();
    let cases: [(&str, &[&str]); 6] = [
        ("l,power\n1,0.5\n2,nan\n", &["s.csv:3", "power", "finite"]),
        ("l,power\n1,0.5\n2,-1\n", &["s.csv:3", "power"]),
        ("l,power\n1,0.5\n1,0.5\n", &["s.csv:3", "once"]),
        ("l,power\n1,0.5\n3,0.5\n", &["s.csv", "degree 2"]),
        ("l,strength\n1,0.5\n", &["s.csv:1", "columns l and power"]),
        ("", &["s.csv", "rows of l and power"]),
    ];
    for (content, parts) in cases {
        place.write("s.csv", content);
        place.run("bounds --spectrum s.csv -n 10 --profile step").fails(1, parts);
    }
    place.run("bounds --spectrum t.csv -n 10 --profile step").fails(1, &["t.csv", "No such file"]);
}

/// A transform to degree 900000 needs terabytes; so do too many points.
#[test]
fn work_beyond_the_memory() {
    let place = Workplace::new();
    let parts: &[&str] = &["GiB of memory", "are available", "use a smaller value"];
    for (arguments, name) in [
        ("spectrum white-noise -n 100 --lmax 900000 -o s.csv", "degree 900000 (--lmax)"),
        (
            "variance white-noise -n 100 --integrand cosine --lmax 900000 -o v.csv",
            "degree 900000 (--lmax)",
        ),
        (
            "compare white-noise -n 100 --integrand cosine --lmax 900000 -o out",
            "degree 900000 (--lmax)",
        ),
        ("bounds white-noise -n 100 -m 300 --profile step --lmax 900000", "degree 900000 (--lmax)"),
        ("spectrum white-noise -n 20000 --lmax 30000 -m 50", "degree 30000 (--lmax)"),
        (
            "bounds white-noise -n 1000000000000 -m 300 --lmax 4 --profile constant",
            "1000000000000 points",
        ),
        ("sample white-noise -n 999999999999999 -o p.npy", "999999999999999 points"),
        ("sample white-noise -n 1000 -m 999999999999 -o p.npy", "999999999999 sets"),
        ("spectrum white-noise -n 999999999999999 --lmax 9", "999999999999999 points"),
        (
            "variance white-noise -n 9 --integrand cosine -m 18446744073709551615",
            "-m 18446744073709551615",
        ),
    ] {
        place.run(arguments).fails(1, &[&[name], parts].concat());
        assert!(place.names().is_empty(), "sphvar {arguments} left {:?}", place.names());
    }
    // The energies of an integrand may be known to any degree; then the limit on degrees applies
    // before that on memory.
    place.run("bounds --profile step -n 18446744073709551615 --integrand cap:degrees=60").ok();
}
