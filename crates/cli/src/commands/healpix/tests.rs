use std::f64::consts::PI;
use std::fs;
use std::path::PathBuf;

use clap::Parser;
use sphvar_healpix::{Cell, Nested, Nside, PixelOrder, Ring};
use tempfile::TempDir;

use super::{Column, HealpixBody, PIXEL, RADIANS, VECTOR, run};
use crate::args::{Cli, Command};
use crate::error::CliError;
use crate::files::{Columns, Number, read_list};
use crate::report::{Document, Provenance};
use crate::session::Session;

/// Runs `sphvar healpix` with these arguments.
fn healpix(words: &str) -> Result<(), CliError> {
    let cli = Cli::try_parse_from(["sphvar", "healpix"].into_iter().chain(words.split(' ')))
        .map_err(CliError::usage)?;
    match cli.command {
        Command::Healpix(args) => run(&args, &cli.global),
        _ => panic!("{words}: another command"),
    }
}

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs `sphvar healpix CONVERSION IN -o OUT` on files of this folder.
    fn convert(&self, conversion: &str, from: &str, to: &str) {
        let words =
            format!("{conversion} {} -o {}", self.path(from).display(), self.path(to).display());
        healpix(&words).unwrap_or_else(|error| panic!("{words}: {error}"));
    }

    /// Returns the output of a conversion of `text`.
    fn text(&self, conversion: &str, text: &str) -> String {
        fs::write(self.path("in.csv"), text).unwrap();
        self.convert(conversion, "in.csv", "out.csv");
        fs::read_to_string(self.path("out.csv")).unwrap()
    }

    /// Returns the error of a conversion of `text`.
    fn error(&self, conversion: &str, text: &str) -> CliError {
        fs::write(self.path("in.csv"), text).unwrap();
        let (from, to) = (self.path("in.csv"), self.path("out.csv"));
        let words = format!("{conversion} {} -o {}", from.display(), to.display());
        let error = healpix(&words).expect_err(&words);
        assert!(!to.exists(), "{words}: a file in spite of {error}");
        error
    }

    fn list<T: Number, const N: usize>(&self, name: &str, columns: &Columns<N>) -> Vec<[T; N]> {
        read_list(&self.path(name), columns, Ok).unwrap()
    }
}

fn pixel_text(pixels: impl IntoIterator<Item = u64>) -> String {
    pixels.into_iter().fold("pixel\n".to_owned(), |text, pixel| text + &format!("{pixel}\n"))
}

/// The values are published in the documentation of healpy; no direction is near the edge of a
/// pixel.
#[test]
fn published_values() {
    let folder = Folder::new();
    assert_eq!(folder.text("ring2nest --nside 16", "1504\n"), "pixel\n1130\n");
    assert_eq!(folder.text("nest2ring --nside 16", "1130\n"), "pixel\n1504\n");
    for (order, pixel) in [("", "1504"), (" --nested", "1130")] {
        folder.text(&format!("pix2vec --nside 16{order}"), pixel);
        let [found] = folder.list::<f64, 3>("out.csv", &VECTOR)[..] else {
            panic!("one row is due");
        };
        let published = [0.998_795_456_205_172_4, 0.049_067_674_327_418_015, 0.0];
        for (a, b) in found.iter().zip(published) {
            // Both libraries round little more than a sine or a cosine.
            assert!((a - b).abs() <= 2.0 * f64::EPSILON, "{order}: {found:?}");
        }
        let text = folder.text(&format!("vec2pix --nside 16{order}"), "0.9987 0.049 1e-9\n");
        assert_eq!(text, format!("pixel\n{pixel}\n"));
    }
    folder.text("pix2ang --nside 16", "1440\n");
    let [[theta, phi]] = folder.list::<f64, 2>("out.csv", &RADIANS)[..] else {
        panic!("one row is due");
    };
    assert!((theta - 1.529_117_594_372_318_8).abs() <= 4.0 * f64::EPSILON, "{theta}");
    assert!(phi.abs() <= 0.0, "{phi}");
    assert_eq!(folder.text("ang2pix --nside 16", "1.5291 0.001\n"), "pixel\n1440\n");
    assert_eq!(folder.text("ang2pix --nside 16", "1.5291 -628.3175\n"), "pixel\n1440\n");
}

#[test]
fn files_hold_the_bits_of_the_library() {
    let folder = Folder::new();
    let nside = Nside::new(8).unwrap();
    let (ring, nested) = (Ring::new(nside), Nested::new(nside).unwrap());
    fs::write(folder.path("p.csv"), pixel_text(0..nside.n_pixels())).unwrap();
    let orders: [(&str, &dyn PixelOrder); 2] = [("", &ring), (" --nested", &nested)];
    for (flag, order) in orders {
        for extension in ["csv", "npy"] {
            let (vec, ang) = (format!("v.{extension}"), format!("a.{extension}"));
            folder.convert(&format!("pix2vec --nside 8{flag}"), "p.csv", &vec);
            folder.convert(&format!("pix2ang --nside 8{flag}"), "p.csv", &ang);
            let vectors: Vec<[f64; 3]> = folder.list(&vec, &VECTOR);
            let angles: Vec<[f64; 2]> = folder.list(&ang, &RADIANS);
            assert_eq!((vectors.len(), angles.len()), (768, 768), "{extension}{flag}");
            for ((pixel, vector), angles) in (0..).zip(vectors).zip(angles) {
                let (centre, (theta, phi)) = (order.centre(pixel), order.centre_angles(pixel));
                let expected = centre.to_array().map(f64::to_bits);
                assert_eq!(vector.map(f64::to_bits), expected, "{pixel} {extension}{flag}");
                let expected = [theta, phi].map(f64::to_bits);
                assert_eq!(angles.map(f64::to_bits), expected, "{pixel} {extension}{flag}");
            }
        }
    }
}

/// Pixels of the finest grid: the first and last, borders of the caps, numbers that `f64` cannot
/// represent, and many between.
fn fine_pixels() -> Vec<u64> {
    let nside = Nside::new(Nside::MAX).unwrap();
    let (n, total) = (u64::from(Nside::MAX), nside.n_pixels());
    let cap = 2 * n * (n - 1);
    let mut pixels = vec![0, 1, 2, 3, 4, 11, 12, cap - 1, cap, cap + 1, total / 2, (1 << 53) + 1];
    pixels.extend([total - cap - 1, total - cap, total - 12, total - 4, total - 2, total - 1]);
    // Golden-section steps are evenly spread and have odd low digits.
    let step = 2_137_634_030_281_913_621;
    pixels.extend((1..2000).map(|i: u64| i.wrapping_mul(step) % total));
    pixels
}

#[test]
fn round_trips_at_the_finest_grid() {
    let folder = Folder::new();
    let pixels = fine_pixels();
    fs::write(folder.path("p.csv"), pixel_text(pixels.iter().copied())).unwrap();
    let nside = format!("--nside {}", Nside::MAX);
    // The NPY input comes from a round-trip conversion that is checked below.
    folder.convert(&format!("ring2nest {nside}"), "p.csv", "n.csv");
    folder.convert(&format!("nest2ring {nside}"), "n.csv", "p.npy");
    let nested = Nested::new(Nside::new(Nside::MAX).unwrap()).unwrap();
    let expected: Vec<[i128; 1]> = pixels.iter().map(|&p| [p.into()]).collect();
    let expected_nested: Vec<[i128; 1]> =
        pixels.iter().map(|&p| [nested.from_ring(p).into()]).collect();
    assert_eq!(folder.list::<i128, 1>("n.csv", &PIXEL), expected_nested);

    for extension in ["csv", "npy"] {
        let name = |stem: &str| format!("{stem}.{extension}");
        assert_eq!(folder.list::<i128, 1>(&name("p"), &PIXEL), expected, "{extension}");
        folder.convert(&format!("ring2nest {nside}"), &name("p"), &name("q"));
        folder.convert(&format!("nest2ring {nside}"), &name("q"), &name("r"));
        assert_eq!(folder.list::<i128, 1>(&name("q"), &PIXEL), expected_nested, "{extension}");
        assert_eq!(folder.list::<i128, 1>(&name("r"), &PIXEL), expected, "{extension}");
        for flag in ["", " --nested"] {
            for (there, back, degrees) in [
                ("pix2vec", "vec2pix", ""),
                ("pix2ang", "ang2pix", ""),
                ("pix2ang", "ang2pix", " --degrees"),
            ] {
                folder.convert(&format!("{there} {nside}{flag}{degrees}"), &name("p"), &name("d"));
                folder.convert(&format!("{back} {nside}{flag}{degrees}"), &name("d"), &name("e"));
                let back: Vec<[i128; 1]> = folder.list(&name("e"), &PIXEL);
                for (found, wanted) in back.iter().zip(&expected) {
                    assert_eq!(found, wanted, "{there} {extension}{flag}{degrees}");
                }
                assert_eq!(back.len(), expected.len(), "{there} {extension}{flag}{degrees}");
            }
        }
    }
}

#[test]
fn vectors_have_any_length() {
    let folder = Folder::new();
    let text = "x,y,z\n1,2,3\n1e-300,2e-300,3e-300\n1e300,2e300,3e300\n5e-324,0,0\n";
    let found = folder.text("vec2pix --nside 64", text);
    let lines: Vec<&str> = found.lines().collect();
    assert_eq!(lines.len(), 5, "{found}");
    assert!(lines[1] == lines[2] && lines[2] == lines[3] && lines[3] != lines[4], "{found}");
}

#[test]
fn degrees_are_longitude_and_latitude() {
    let folder = Folder::new();
    // Centres of the faces: longitudes 45, 0 and 45 degrees, and the latitude whose sine is 2/3.
    let latitude = (2.0_f64 / 3.0).asin().to_degrees();
    let text = folder.text("pix2ang --nside 1 --degrees", "0\n4\n8\n");
    assert!(text.starts_with("lon,lat\n"), "{text}");
    let columns = Columns { names: ["lon", "lat"], remark: "" };
    let found: Vec<[f64; 2]> = folder.list("out.csv", &columns);
    for (found, expected) in found.iter().zip([[45.0, latitude], [0.0, 0.0], [45.0, -latitude]]) {
        for (a, b) in found.iter().zip(expected) {
            // The latitude is a difference from 90, whose last bit is 64 EPSILON.
            assert!((a - b).abs() <= 128.0 * f64::EPSILON, "{found:?} against {expected:?}");
        }
    }
    // The header determines the order; longitudes differ by full periods.
    let text =
        folder.text("ang2pix --nside 1 --degrees", "lat,lon\n41,45\n41,3.6e9\n90,0\n-90,7\n");
    let pixels: Vec<&str> = text.lines().skip(1).collect();
    let pole = |lon: f64, theta: f64| {
        let cell = Cell::containing_angles(Nside::new(1).unwrap(), theta, lon.to_radians());
        Ring::new(Nside::new(1).unwrap()).pixel_of_cell(cell.unwrap()).to_string()
    };
    assert_eq!(pixels, ["0", &pole(0.0, 49_f64.to_radians()), &pole(0.0, 0.0), &pole(7.0, PI)]);
}

#[test]
fn pi_in_single_precision_is_the_south_pole() {
    let folder = Folder::new();
    let pole = folder.text("ang2pix --nside 4", &format!("{PI:?} 1\n"));
    assert_eq!(folder.text("ang2pix --nside 4", &format!("{:?} 1\n", std::f32::consts::PI)), pole);
}

#[test]
fn empty_lists_stay_empty() {
    let folder = Folder::new();
    assert_eq!(folder.text("pix2vec --nside 4", "pixel\n"), "x,y,z\n");
    folder.convert("pix2vec --nside 4", "in.csv", "out.npy");
    folder.convert("vec2pix --nside 4", "out.npy", "back.csv");
    assert_eq!(fs::read_to_string(folder.path("back.csv")).unwrap(), "pixel\n");
}

#[test]
fn wrong_rows_are_named() {
    let folder = Folder::new();
    let pixel_3 = "expected a pixel from 0 to 107 (nside 3)";
    let theta = "theta: expected a colatitude from 0 to pi radians";
    for (conversion, text, parts) in [
        ("pix2vec --nside 3", "pixel\n0\n108\n", [":3: pixel: ", pixel_3, "got \"108\""]),
        ("pix2ang --nside 3", "-1\n", [":1: pixel: ", pixel_3, "got \"-1\""]),
        (
            "pix2vec --nside 3",
            "# \n\n99999999999999999999999999999999999999999\n",
            [":3: pixel: ", pixel_3, "got \"9999"],
        ),
        ("ring2nest --nside 4", "192\n", [":1: pixel: ", "from 0 to 191 (nside 4)", "\"192\""]),
        ("nest2ring --nside 4", "192\n", [":1: pixel: ", "from 0 to 191 (nside 4)", "\"192\""]),
        ("pix2vec --nside 3", "1\n1.5\n", [":2: pixel: ", "expected an integer", "got \"1.5\""]),
        ("pix2vec --nside 3", "pixel\n3.0\n", [":2: pixel: ", "expected an integer", "\"3.0\""]),
        ("pix2vec --nside 3", "pixel\nnan\n", [":2: pixel: ", "expected an integer", "\"nan\""]),
        (
            "vec2pix --nside 3",
            "1,2,3\n1,NaN,3\n",
            [":2: y: ", "expected a finite number", "got \"NaN\""],
        ),
        ("vec2pix --nside 3", "1,2,inf\n", [":1: z: ", "expected a finite number", "got \"inf\""]),
        (
            "vec2pix --nside 3",
            "1 2 3\n0 -0 0\n",
            [":2: x,y,z: ", "expected a vector other than zero", "got (0, -0, 0)"],
        ),
        ("ang2pix --nside 3", "3.2,0\n", [":1: ", theta, "got \"3.2\""]),
        ("ang2pix --nside 3", "phi,theta\n1,-1e-9\n", [":2: ", theta, "got \"-1e-9\""]),
        ("ang2pix --nside 3", "1,inf\n", [":1: phi: ", "expected a finite number", "got \"inf\""]),
        (
            "ang2pix --nside 3 --degrees",
            "10,90.5\n",
            [":1: lat: ", "expected a latitude from -90 to 90 degrees", "got \"90.5\""],
        ),
        (
            "ang2pix --nside 3",
            "lon,lat\n1,1\n",
            [":1: ", "expected the columns theta,phi", "--degrees takes lon,lat"],
        ),
        ("vec2pix --nside 3", "1,2\n", [":1: ", "the columns x,y,z", "2 fields without a header"]),
    ] {
        let error = folder.error(conversion, text);
        let message = error.to_string();
        assert_eq!(error.status(), 1, "{conversion} {text:?}: {message}");
        for part in ["in.csv"].into_iter().chain(parts) {
            assert!(message.contains(part), "{conversion} {text:?}: no {part:?} in {message}");
        }
    }
}

#[test]
fn wrong_usage_is_named() {
    let folder = Folder::new();
    let range = "expected an integer from 1 to 536870912";
    for (conversion, part) in [
        ("pix2vec --nside 0", range),
        ("pix2vec --nside 536870913", range),
        ("pix2vec --nside 99999999999999999999", range),
        ("pix2vec --nside -4", range),
        ("pix2vec --nside 2.5", range),
        ("pix2vec", "--nside"),
        ("pix2vec --nside 3 --nested", "nested order requires nside to be a power of two, got 3"),
        ("ring2nest --nside 12", "nested order requires nside to be a power of two, got 12"),
        ("nest2ring --nside 12", "the nearest are 8 and 16"),
        ("vec2pix --nside 4 --degrees", "--degrees requires ang2pix or pix2ang"),
        ("vec2pixel --nside 4", "vec2pix, pix2vec, ang2pix, pix2ang, ring2nest, nest2ring"),
    ] {
        let error = folder.error(conversion, "pixel\n0\n");
        assert_eq!(error.status(), 2, "{conversion}: {error}");
        assert!(error.to_string().contains(part), "{conversion}: no {part:?} in {error}");
    }
}

#[test]
fn wrong_files_are_named() {
    let folder = Folder::new();
    let (missing, present) = (folder.path("missing.csv"), folder.path("in.csv"));
    fs::write(&present, "0\n").unwrap();
    let (missing, present) = (missing.display(), present.display());
    for (words, status, part) in [
        (format!("pix2vec --nside 4 {missing} -o -"), 1, format!("cannot open {missing}")),
        (format!("pix2vec --nside 4 {present} -o {present}.ply"), 2, ".csv, .npy".to_owned()),
        (format!("pix2vec --nside 4 {present} -o {missing}/a.csv"), 1, "does not exist".to_owned()),
    ] {
        let error = healpix(&words).expect_err(&words);
        assert_eq!(error.status(), status, "{words}: {error}");
        assert!(error.to_string().contains(&part), "{words}: no {part:?} in {error}");
    }
}

#[test]
fn document_has_a_key_for_each_column() {
    let words = ["sphvar", "healpix", "pix2ang", "--nside", "536870912", "--nested", "-"];
    let Command::Healpix(args) = Cli::try_parse_from(words).unwrap().command else {
        panic!("another command");
    };
    let provenance = Provenance::new(&Session::default(), 0);
    let rows = [[1.5, 0.25], [2.5, 3e-300]];
    let order = "nested";
    let body = HealpixBody::new(&args, order, &RADIANS.names, &rows);
    let text = serde_json::to_string(&Document::new(&body, &provenance)).unwrap();
    let start = "{\"conversion\":\"pix2ang\",\"nside\":536870912,\"order\":\"nested\",\
                 \"theta\":[1.5,2.5],\"phi\":[0.25,3e-300],\"provenance\":{";
    assert!(text.starts_with(start), "{text}");
    // Integers keep all their digits.
    let column = Column { rows: &[[9_007_199_254_740_993_i64]], column: 0 };
    assert_eq!(serde_json::to_string(&column).unwrap(), "[9007199254740993]");
}
