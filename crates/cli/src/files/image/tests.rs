use std::path::Path;

use image::ImageFormat;

use super::{ChannelChoice, ChannelImage, decode_picture, png_file, read_image};

fn choice(channel: &str, layer: &str) -> ChannelChoice {
    let given = |text: &str| Some(text.to_owned()).filter(|text| !text.is_empty());
    ChannelChoice { channel: given(channel), layer: given(layer) }
}

/// Reads a file with this content.
fn read(content: &[u8], choice: &ChannelChoice) -> Result<ChannelImage, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map");
    std::fs::write(&path, content).unwrap();
    read_image(&path, choice).map_err(|error| error.to_string())
}

/// Written by OpenEXR 3.5: ramps 0, 1, 2, ... of 8 x 4.
const GREY: &[u8] = include_bytes!("../../../tests/data/grey_half.exr");
const DEPTH: &[u8] = include_bytes!("../../../tests/data/depth_uint.exr");
const LAYERS: &[u8] = include_bytes!("../../../tests/data/layers.exr");
const PARTS: &[u8] = include_bytes!("../../../tests/data/parts.exr");
/// A file of 442 bytes with PXR24 whose data window goes from x = 536870912 to 7.
const INVERTED: &[u8] = include_bytes!("../../../tests/data/inverted_window.exr");

#[test]
fn pictures_that_are_not_linear_are_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let picture = image::RgbImage::from_pixel(8, 4, image::Rgb([188; 3]));
    // The format is determined by the content of a file, not its name.
    for (name, format) in [("map.png", ImageFormat::Png), ("map.exr", ImageFormat::Png)] {
        let path = folder.path().join(name);
        picture.save_with_format(&path, format).unwrap();
        let message = read_image(&path, &choice("r", "")).unwrap_err().to_string();
        assert!(
            message.contains(name)
                && message.contains("expected OpenEXR (.exr) or Radiance HDR (.hdr)")
                && message.contains(".png"),
            "{message}"
        );
    }
    let path = folder.path().join("map.hdr");
    let map = image::Rgb32FImage::from_pixel(8, 4, image::Rgb([0.5; 3]));
    map.save_with_format(&path, ImageFormat::Hdr).unwrap();
    let got = read_image(&path, &choice("r", "")).unwrap();
    assert_eq!((got.width, got.height, got.values), (8, 4, vec![0.5; 32]));
    assert!(read_image(Path::new("no such file"), &choice("", "")).is_err());
}

/// Messages for pictures on the square say that they can be PNG, and the size of too large ones.
#[test]
fn errors_of_pictures_name_every_format_and_the_size() {
    let mut png = Vec::new();
    let picture = image::RgbImage::from_pixel(8, 4, image::Rgb([51, 0, 255]));
    picture.write_to(&mut std::io::Cursor::new(&mut png), ImageFormat::Png).unwrap();
    let decode = |bytes: &[u8]| {
        decode_picture("p".to_owned(), bytes, &choice("r", "")).map_err(|e| e.to_string())
    };
    let got = decode(&png).unwrap();
    assert_eq!((got.width, got.height), (8, 4));
    assert!(got.values.iter().all(|r| (r - 0.2).abs() < 1e-7), "{:?}", got.values);
    let mut huge = png.clone();
    huge[16..20].copy_from_slice(&0x7fff_ffff_u32.to_be_bytes());
    huge[20..24].copy_from_slice(&0x7fff_fffe_u32.to_be_bytes());
    let cases: [(&[u8], &[&str]); 6] = [
        (&huge, &["2147483647 x 2147483646 texels", "GiB"]),
        (&png[..png.len() - 20], &["cannot read p as a PNG image"]),
        (&png[..20], &["cannot read p as a PNG image", "header"]),
        (&png_file::MAGIC, &["cannot read p as a PNG image", "header"]),
        (&[], &["expected PNG (.png), OpenEXR (.exr) or Radiance HDR (.hdr)"]),
        (b"\xff\xd8\xff\xe0", &["expected PNG (.png), OpenEXR", ".jpg"]),
    ];
    for (bytes, parts) in cases {
        let message = decode(bytes).unwrap_err();
        assert!(parts.iter().all(|part| message.contains(part)), "{parts:?}: {message}");
    }
}

#[test]
fn channels_and_layers_are_found_by_name() {
    // (file, channel, layer, the first value, the step)
    for (file, channel, layer, first, step) in [
        (GREY, "", "", 0.0, 1.0),
        (GREY, "y", "", 0.0, 1.0),
        (DEPTH, "Z", "", 0.0, 1000.0),
        (LAYERS, "g", "diffuse", 0.0, 2.0),
        (LAYERS, "", "diffuse", 0.0, 0.2126 + 2.0 * 0.7152 + 3.0 * 0.0722),
        (LAYERS, "", "specular", 100.0, 1.0),
        (LAYERS, "diffuse.B", "", 0.0, 3.0),
        (LAYERS, "mask", "", 1.0, 0.0),
        // Without a name, the first part with these channels.
        (PARTS, "r", "", 0.0, 1.0),
        (PARTS, "r", "sun", 50.0, 1.0),
        (PARTS, "sun.R", "", 50.0, 1.0),
    ] {
        let got = read(file, &choice(channel, layer)).unwrap();
        assert_eq!((got.width, got.height), (8, 4));
        for (k, value) in got.values.iter().enumerate() {
            let expected = first + step * k as f64;
            assert!((value - expected).abs() < 1e-12 * (1.0 + expected), "{channel} {layer} {k}");
        }
    }
    for (file, channel, layer, parts) in [
        (
            LAYERS,
            "",
            "",
            &["the channels R, G and B, or Y", "diffuse.B", "specular.Y", "layer="][..],
        ),
        (LAYERS, "", "ambient", &["a layer \"ambient\"", "diffuse.B"]),
        (LAYERS, "alpha", "diffuse", &["unknown channel \"alpha\"", "luminance, r, g, b", "mask"]),
        (DEPTH, "", "", &["R, G and B, or Y", "got Z"]),
        (PARTS, "", "moon", &["a layer \"moon\"", "sky.B", "sun.B"]),
        (GREY, "r", "", &["unknown channel \"r\"", "the file has Y"]),
    ] {
        let message = read(file, &choice(channel, layer)).unwrap_err();
        for part in parts {
            assert!(message.contains(part), "{channel} {layer}: {message}");
        }
    }
}

/// The decoder does not support subsampled channels; the error names them for any channel of that
/// layer.
#[test]
fn luminance_and_chroma_are_named() {
    // In the list of channels a name is followed by its type, four bytes of flags, and the two
    // sampling steps.
    let mut file = LAYERS.to_vec();
    for name in [b"diffuse.B\0".as_slice(), b"diffuse.G\0"] {
        let at = file.windows(name.len()).position(|bytes| bytes == name).unwrap() + name.len();
        file[at + 8] = 2;
        file[at + 12] = 2;
    }
    for channel in ["", "r", "diffuse.R"] {
        let message = read(&file, &choice(channel, "diffuse")).unwrap_err();
        for part in ["diffuse.B, diffuse.G have fewer samples", "luminance-chroma", "R, G and B"] {
            assert!(message.contains(part), "{channel}: {message}");
        }
    }
}

/// Returns the bytes of a window in the file: four numbers of four bytes.
fn with_window(file: &[u8], name: &str, window: [i32; 4]) -> Vec<u8> {
    let mut copy = file.to_vec();
    let key = [name.as_bytes(), b"\0box2i\0\x10\0\0\0"].concat();
    let at = copy.windows(key.len()).position(|bytes| bytes == key).unwrap() + key.len();
    let numbers: Vec<u8> = window.iter().flat_map(|n| n.to_le_bytes()).collect();
    copy[at..at + 16].copy_from_slice(&numbers);
    copy
}

#[test]
fn windows_are_checked_before_anything_is_decoded() {
    let message = read(INVERTED, &choice("", "")).unwrap_err();
    assert!(message.contains("dataWindow goes from (536870912, 0) to (7, 3)"), "{message}");
    let huge = 1 << 29;
    for file in [INVERTED, GREY, DEPTH, LAYERS, PARTS] {
        for (name, window, part) in [
            ("dataWindow", [0, 0, huge, 3], "cannot hold"),
            ("dataWindow", [0, 0, 7, huge], "cannot"),
            ("dataWindow", [-huge, -huge, huge, huge], "cannot"),
            ("displayWindow", [0, 0, huge, huge], "cannot hold"),
            ("displayWindow", [0, 5, 7, 3], "displayWindow goes from (0, 5) to (7, 3)"),
        ] {
            if file == PARTS && name == "displayWindow" && window[1] == 0 {
                // All parts must have the same window; the library reports a violation.
                continue;
            }
            let mut damaged = with_window(file, name, window);
            if name == "displayWindow" {
                damaged = with_window(&damaged, "dataWindow", [0, 0, 7, 3]);
            }
            let channel = if file == DEPTH { "Z" } else { "" };
            let layer = if file == LAYERS { "diffuse" } else { "" };
            let message = read(&damaged, &choice(channel, layer)).unwrap_err();
            assert!(message.contains(part), "{name} {window:?}: {message}");
        }
    }
    // A shifted data window is visible where it overlaps the display window.
    let moved = with_window(GREY, "displayWindow", [2, -1, 9, 2]);
    let got = read(&moved, &choice("", "")).unwrap();
    let expected: Vec<f64> = (-1..3)
        .flat_map(|y| (2..10).map(move |x| (x, y)))
        .map(|(x, y)| if x < 8 && y >= 0 { f64::from(8 * y + x) } else { 0.0 })
        .collect();
    assert_eq!(got.values, expected);
    // 6 of 8 columns and 3 of 4 rows are covered.
    let remark = "14 of 32 texels of the display window are outside of the data window";
    assert!(got.remarks.len() == 1 && got.remarks[0].contains(remark), "{:?}", got.remarks);
}

#[test]
fn damaged_pictures_do_not_panic() {
    let radiance = radiance(b"#?RADIANCE", "EXPOSURE=2\n", "-Y 4 +X 8", &ramp());
    for file in [GREY, DEPTH, LAYERS, PARTS, &radiance] {
        for end in (0..file.len()).step_by(5) {
            let channel = if file == DEPTH { "Z" } else { "" };
            // The last part, so that every truncation affects the data that are read.
            let layer = match file {
                _ if file == LAYERS => "diffuse",
                _ if file == PARTS => "sun",
                _ => "",
            };
            assert!(read(&file[..end], &choice(channel, layer)).is_err(), "{end}");
        }
        for at in 0..file.len() {
            let mut damaged = file.to_vec();
            damaged[at] ^= 0x91;
            if let Ok(image) = read(&damaged, &choice("", "")) {
                assert_eq!(image.values.len(), image.width * image.height);
            }
        }
    }
}

/// A picture with uncompressed scanlines, of texels with red = green = blue = 2^0 times a byte.
fn radiance(magic: &[u8], header: &str, resolution: &str, texels: &[u8]) -> Vec<u8> {
    let mut file = [magic, b"\n", header.as_bytes(), b"\n", resolution.as_bytes(), b"\n"].concat();
    // A byte is multiplied by 2^(e - 136).
    file.extend(texels.iter().flat_map(|&c| [c, c, c, 136]));
    file
}

/// Texels 10, 11, ..., none of which is a mark.
fn ramp() -> Vec<u8> {
    (10..42).collect()
}

#[test]
#[expect(clippy::float_cmp, reason = "small integers and quotients of powers of two")]
fn radiance_values_are_divided_by_their_exposure() {
    let red = choice("r", "");
    for (header, divisor) in [
        ("", 1.0),
        ("EXPOSURE=2\n", 2.0),
        (
            "# a comment, EXPOSURE=9\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=  2.0 \nVIEW= -vtv\nEXPOSURE=4\n",
            8.0,
        ),
        ("COLORCORR= 0.5 3 7\n", 0.5),
        ("COLORCORR=4 1 1\nEXPOSURE=0.5\n", 2.0),
    ] {
        for magic in [&b"#?RADIANCE"[..], b"#?RGBE"] {
            let file = radiance(magic, header, "-Y 4 +X 8", &ramp());
            let got = read(&file, &red).unwrap();
            assert!(got.remarks.is_empty());
            for (value, texel) in got.values.iter().zip(ramp()) {
                assert_eq!(*value, f64::from(texel) / divisor, "{header}");
            }
        }
    }
    // Files in use contain 0.
    for line in ["EXPOSURE=0", "EXPOSURE=-1", "COLORCORR=1 0 1", "EXPOSURE=inf"] {
        let got = read(&radiance(b"#?RGBE", &format!("{line}\n"), "-Y 4 +X 8", &ramp()), &red);
        let got = got.unwrap();
        assert_eq!(got.values[0], 10.0);
        assert!(got.remarks[0].contains(&format!("{line} is ignored")), "{:?}", got.remarks);
    }
    for (header, resolution, parts) in [
        ("EXPOSURE=two\n", "-Y 4 +X 8", &[":2:", "EXPOSURE=NUMBER", "EXPOSURE=two"][..]),
        ("COLORCORR=1 2\n", "-Y 4 +X 8", &["COLORCORR=RED GREEN BLUE"]),
        (
            "FORMAT=16-bit_rle_xyze\n",
            "-Y 4 +X 8",
            &["32-bit_rle_rgbe or 32-bit_rle_xyze", "16-bit"],
        ),
        ("", "-Y 4 -Y 8", &["-Y 512 +X 1024", "-Y 4 -Y 8"]),
        ("", "-Y 4", &["a resolution"]),
        ("", "-Y 9 +X 8", &["scanline 4 of 9", "the file ends"]),
        ("", "-Y 4000000 +X 8000000", &["cannot hold"]),
    ] {
        let message = read(&radiance(b"#?RGBE", header, resolution, &ramp()), &red).unwrap_err();
        for part in parts {
            assert!(message.contains(part), "{header} {resolution}: {message}");
        }
    }
    let message = read(&radiance(b"#?RGBE", "", "-Y 4 +X 8", &ramp()), &choice("", "sky"));
    assert!(message.unwrap_err().contains("no layers"));
    let message = read(&radiance(b"#?RGBE", "", "-Y 4 +X 8", &ramp()), &choice("y", ""));
    assert!(message.unwrap_err().contains("unknown channel \"y\"; valid: luminance, r, g, b"));
}

/// Luminance is Y; white is red = green = blue; the primaries have the chromaticities of Radiance's
/// `color.h`.
#[test]
fn tristimulus_values_become_colours() {
    let texel = |xyz: [u8; 3], header: &str, channel: &str| {
        let head =
            format!("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n{header}\n-Y 1 +X 1\n").into_bytes();
        let file = [head, xyz.to_vec(), vec![136]].concat();
        read(&file, &choice(channel, "")).map(|image| image.values[0])
    };
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12 * (1.0 + b.abs());
    for channel in ["", "r", "g", "b"] {
        assert!(near(texel([90; 3], "", channel).unwrap(), 90.0), "{channel}");
        assert!(near(texel([90; 3], "EXPOSURE=3\n", channel).unwrap(), 30.0), "{channel}");
    }
    assert_eq!(texel([13, 77, 200], "", "luminance"), Ok(77.0));
    assert_eq!(texel([13, 77, 200], "COLORCORR=2 0.5 4\n", "luminance"), Ok(154.0));
    // Light of a primary's chromaticity (x, y, 1 - x - y) times 100 has no component of the other
    // two.
    for (primary, xyz) in [("r", [64, 33, 3]), ("g", [29, 60, 11]), ("b", [15, 6, 79])] {
        for channel in ["r", "g", "b"] {
            let value = texel(xyz, "", channel).unwrap();
            assert!(
                if channel == primary { value > 50.0 } else { near(value, 0.0) },
                "{channel} {value}"
            );
        }
    }
    // Colours outside of the triangle of the primaries are negative, which causes a remark.
    assert!(texel([0, 100, 0], "", "r").unwrap() < -100.0);
    assert!(texel([1, 1, 1], "", "x").unwrap_err().contains("unknown channel \"x\""));
}

#[test]
fn radiance_pictures_are_oriented_as_they_say() {
    // The index of texel (x, y) of the picture in the file, 8 wide and 4 high.
    type Place = fn(usize, usize) -> usize;
    let orders: [(&str, Place); 8] = [
        ("-Y 4 +X 8", |x, y| 8 * y + x),
        ("-Y 4 -X 8", |x, y| 8 * y + 7 - x),
        ("+Y 4 +X 8", |x, y| 8 * (3 - y) + x),
        ("+Y 4 -X 8", |x, y| 8 * (3 - y) + 7 - x),
        ("+X 8 -Y 4", |x, y| 4 * x + y),
        ("+X 8 +Y 4", |x, y| 4 * x + 3 - y),
        ("-X 8 -Y 4", |x, y| 4 * (7 - x) + y),
        ("-X 8 +Y 4", |x, y| 4 * (7 - x) + 3 - y),
    ];
    for (resolution, place) in orders {
        let got = read(&radiance(b"#?RADIANCE", "", resolution, &ramp()), &choice("r", ""));
        let got = got.unwrap();
        assert_eq!((got.width, got.height), (8, 4), "{resolution}");
        let places = (0..4).flat_map(|y| (0..8).map(move |x| (x, y)));
        let expected: Vec<f64> = places.map(|(x, y)| f64::from(ramp()[place(x, y)])).collect();
        assert_eq!(got.values, expected, "{resolution}");
    }
}

#[test]
fn radiance_scanlines_of_both_compressions_are_read() {
    let mut file = b"#?RGBE\n\n-Y 2 +X 8\n".to_vec();
    // New: the width, then runs and lists for each of red, green, blue and exponent.
    file.extend([2, 2, 0, 8, 128 + 8, 20, 128 + 8, 30, 4, 1, 2, 3, 4, 128 + 4, 5, 128 + 8, 136]);
    // Old: a texel, repeated six times, and another.
    file.extend([50, 51, 52, 136, 1, 1, 1, 6, 60, 61, 62, 137]);
    let read = |channel| read(&file, &choice(channel, "")).unwrap().values;
    let old = |value: f64, last: f64| [vec![value; 7], vec![last]].concat();
    assert_eq!(read("r"), [vec![20.0; 8], old(50.0, 120.0)].concat());
    assert_eq!(
        read("b"),
        [vec![1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0, 5.0], old(52.0, 124.0)].concat()
    );
    let mut wrong = file.clone();
    wrong[21] = 9;
    let message = super::tests::read(&wrong, &choice("", "")).unwrap_err();
    assert!(message.contains("it has 9 texels, but its header states 8"), "{message}");
}

#[test]
fn negative_texels_are_counted() {
    let mut texels = [1.0_f32; 32];
    texels[13] = -0.5;
    texels[30] = -0.25;
    let texel = |x, y| image::Rgb([texels[(8 * y + x) as usize]; 3]);
    let map = image::Rgb32FImage::from_fn(8, 4, texel);
    let mut bytes = std::io::Cursor::new(Vec::new());
    map.write_to(&mut bytes, ImageFormat::OpenExr).unwrap();
    let got = read(bytes.get_ref(), &choice("r", "")).unwrap();
    let remark = &got.remarks[0];
    assert!(
        remark.contains("2 of 32 texels are negative, the smallest is -0.5 (row 1, column 5)"),
        "{remark}"
    );
}
