//! `sphvar render`.

use serde_json::Value;

use crate::outcome::{assert_keys, numbers, same};
use crate::workplace::{Workplace, data, small_exr};

/// Small pictures with a small reference image in a folder of their own.
const SMALL: &str = "--size 24 --reference-count 600 --cache cache";

const PYRAMID: &str = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1.5 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf -2 -5 -1\nf 1 2 3 4\n";

fn number(document: &Value, key: &str) -> f64 {
    document[key].as_f64().unwrap_or_else(|| panic!("{key}: {document}"))
}

/// Returns the grey values of a portable float map, from the top.
fn pfm(bytes: &[u8], width: usize, height: usize) -> Vec<f32> {
    let head = format!("Pf\n{width} {height}\n-1.0\n");
    let body = bytes.strip_prefix(head.as_bytes()).unwrap_or_else(|| panic!("no {head:?}"));
    assert_eq!(body.len(), 4 * width * height);
    let rows = body.chunks(4 * width).rev();
    rows.flat_map(|row| row.chunks(4).map(|c| f32::from_le_bytes(c.try_into().unwrap()))).collect()
}

#[test]
fn a_picture_needs_no_reference_image() {
    let place = Workplace::new();
    let arguments = "render cornell --sampler jittered -n 24 --size 48x32 -o ao.png --cache cache";
    let text = place.run(arguments).ok().stdout;
    assert!(text.contains("jittered, antipodal, N = 24") && text.contains("rays"), "{text}");
    assert_eq!(place.names(), ["ao.png"]);
    let picture = image::open(place.path("ao.png")).unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (48, 32));
    // The surroundings of the box are dark, the middle of the back wall is not.
    assert_eq!(picture.get_pixel(0, 16).0, [0; 3]);
    assert!(picture.get_pixel(24, 6).0[0] > 60, "{:?}", picture.get_pixel(24, 6));
    assert!(place.bytes("ao.png").windows(6).any(|w| w == b"render"), "the command is in the file");
}

#[test]
fn the_document_has_its_keys_and_agrees_with_itself() {
    let place = Workplace::new();
    let run = |mode: &str, more: &str| {
        let arguments =
            format!("render cornell --sampler jittered -n 100 --mode {mode} --json {SMALL} {more}");
        place.run(&arguments).json()
    };
    let document = run("antipodal", "-o p.exr --difference d.pfm --error e.pfm");
    assert_keys(
        &document,
        &[
            "mse",
            "mse_stderr",
            "rays",
            "seconds",
            "variance",
            "bias_squared",
            "bias_squared_stderr",
            "white_noise",
            "variance_reduction",
            "structured_error",
            "autocorrelation",
            "bias_t",
            "bias_limit",
            "n",
            "n_requested",
            "mode",
            "renders",
            "reference_n",
            "provenance",
        ],
    );
    assert_eq!((document["n"].as_u64(), document["n_requested"].as_u64()), (Some(96), Some(100)));
    assert_eq!(document["reference_n"].as_u64(), Some(600));
    let mse = number(&document, "mse");
    assert!(mse > 0.0 && number(&document, "mse_stderr") < 0.3 * mse, "{document}");
    let sum = number(&document, "variance") + number(&document, "bias_squared");
    assert!((sum / mse - 1.0).abs() < 1e-12, "{document}");
    assert!(
        (number(&document, "variance_reduction") * mse / number(&document, "white_noise") - 1.0)
            .abs()
            < 1e-12
    );
    assert!(number(&document, "variance_reduction") > 1.5, "{document}");
    let rays = document["rays"].as_u64().unwrap();
    assert_eq!(rays, 8 * 96 * document["pixels"].as_u64().unwrap());
    // The error image has the same mean.
    let errors = pfm(&place.bytes("e.pfm"), 24, 24);
    let mean = errors.iter().map(|&e| f64::from(e)).sum::<f64>() / number(&document, "pixels");
    assert!((mean / mse - 1.0).abs() < 1e-5, "{mean:e} {mse:e}");
    let differences = pfm(&place.bytes("d.pfm"), 24, 24);
    assert!(differences.iter().any(|&d| d > 0.0) && differences.iter().any(|&d| d < 0.0));
    for mode in ["shared", "spun", "rotated", "fresh"] {
        assert!(number(&run(mode, ""), "mse") > 0.0, "{mode}");
    }
    let shared = run("shared --estimator unbiased", "");
    assert!(number(&shared, "mse") > 0.0);
}

#[test]
fn parts_of_a_picture_are_those_of_the_whole() {
    let place = Workplace::new();
    let run = |more: &str| {
        place.run(&format!("render cornell --sampler healpix -n 24 --size 40 --seed 5 {more}")).ok()
    };
    run("-o whole.pfm");
    run("-o part.pfm --crop 7,11,20,9");
    let (whole, part) =
        (pfm(&place.bytes("whole.pfm"), 40, 40), pfm(&place.bytes("part.pfm"), 20, 9));
    for y in 0..9 {
        assert_eq!(part[20 * y..20 * (y + 1)], whole[40 * (y + 11) + 7..][..20], "row {y}");
    }
}

#[test]
fn threads_do_not_show() {
    let run = |threads: u32| {
        let place = Workplace::new();
        let arguments = "render cornell --sampler poisson-disk -n 30 --mode rotated -o p.png --error e.exr \
             --difference d.png --json -m 3";
        let mut document = place.run(&format!("{arguments} {SMALL} -j {threads}")).json();
        document["seconds"] = Value::Null;
        let files = ["p.png", "e.exr", "d.png"].map(|name| place.bytes(name));
        let cached = place.names_in("cache");
        (document, files, place.bytes(&format!("cache/{}", cached[0])))
    };
    assert!(run(1) == run(2), "one thread and two give different bytes");
}

#[test]
fn reference_images_are_kept_and_damage_is_noticed() {
    let place = Workplace::new();
    let arguments = format!("render cornell --sampler fibonacci -n 20 -m 2 --json {SMALL}");
    let mse = |place: &Workplace| number(&place.run(&arguments).json(), "mse");
    let first = mse(&place);
    let [name] = &*place.names_in("cache") else { panic!("{:?}", place.names_in("cache")) };
    let name = format!("cache/{name}");
    let kept = place.bytes(&name);
    assert!(same(mse(&place), first));
    let mut damaged = kept.clone();
    damaged[kept.len() / 2] ^= 1;
    place.write(&name, &damaged);
    let outcome = place.run(&arguments).ok();
    assert!(
        outcome.stderr.contains("is damaged; the reference image is rendered again"),
        "{}",
        outcome.stderr
    );
    assert_eq!(place.bytes(&name), kept, "it is rendered again and stored");
    place.write(&name, &kept[..kept.len() / 3]);
    assert!(same(mse(&place), first));
    // A change of any quantity that the reference depends on gives another image.
    for other in
        ["--seed 1", "--max-distance 50", "--crop 2,2,20,20", "--integral light", "--fov 30"]
    {
        let before = place.names_in("cache").len();
        place.run(&format!("{arguments} {other}")).ok();
        assert_eq!(place.names_in("cache").len(), before + 1, "{other}");
    }
    // A cache that cannot be written does not stop the run.
    let outcome = place.run(&arguments.replace("--cache cache", "--cache /dev/null/x")).ok();
    assert!(outcome.stderr.contains("cannot be stored"), "{}", outcome.stderr);
    place.run(&arguments.replace("--cache cache", "--cache none")).ok();
}

#[test]
fn light_and_skies() {
    let place = Workplace::new();
    place.write("sky.exr", small_exr(8, 4));
    place.write("pyramid.obj", PYRAMID);
    let mean = |arguments: &str| {
        number(&place.run(&format!("render {arguments} -m 2 --json {SMALL}")).json(), "mean")
    };
    let box_light = mean("cornell --sampler jittered -n 96 --integral light:albedo=0.5");
    let twice = mean("cornell --sampler jittered -n 96 --integral light");
    assert!((twice / box_light - 2.0).abs() < 1e-9, "{box_light} {twice}");
    let sky = "--sampler jittered -n 96 --integral irradiance:env=sky.exr";
    // The map's rows are 1 to 8, 9 to 16, ...: the sky is darker than 17, a mean over it above 4.
    let under_sky = mean(&format!("pyramid.obj {sky}"));
    assert!(under_sky > 4.0 && under_sky < 17.0, "{under_sky}");
    let upside_down = mean(&format!("pyramid.obj {sky} --up 0,-1,0 --eye 3,3,3"));
    assert!(
        upside_down > under_sky,
        "the ground of the map is brighter: {upside_down} {under_sky}"
    );
    let lamp = "--integral light --lamp 1,3,-1,1,3,1,-1,3,1,-1,3,-1";
    assert!(mean(&format!("pyramid.obj --sampler healpix -n 96 {lamp}")) > 0.01);
    let wide = mean("pyramid.obj --sampler healpix -n 96 --eye 0,5,0.1 --look-at 0,0,0 --fov 60");
    let cosine = mean("pyramid.obj --sampler healpix -n 96 --integral ao:weight=cosine");
    assert!(wide > 0.99 && cosine > 0.99, "nothing is above it: {wide} {cosine}");
}

/// A quarter of the sky is bright: the quarter in which the emitter `envmap` of Mitsuba 3 shows the
/// columns from 1/4 to 1/2, between +x and +z with y up, as in pictures that it rendered. A wall
/// receives pi/2 (sin b - sin a) from longitudes a to b off its normal, and reflects that divided
/// by pi.
#[test]
fn the_sky_is_oriented_as_in_other_renderers() {
    let place = Workplace::new();
    let sky = image::Rgb32FImage::from_fn(64, 32, |x, _| {
        image::Rgb([if (16..32).contains(&x) { 1.0 } else { 0.0 }; 3])
    });
    sky.save_with_format(place.path("sky.exr"), image::ImageFormat::OpenExr).unwrap();
    let mut cube = String::new();
    for k in 0..8 {
        let side = |bit: i32| if k & bit == 0 { -1 } else { 1 };
        cube.push_str(&format!("v {} {} {}\n", side(1), side(2), side(4)));
    }
    cube.push_str("f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n");
    place.write("cube.obj", cube);
    let wall = |eye: &str, options: &str| {
        let integral = format!("--integral irradiance:env=sky.exr{options} --fov 30");
        let arguments = format!(
            "render cube.obj --eye={eye} --look-at 0,0,0 --sampler fibonacci -n 4096 {integral}"
        );
        let more = "-m 2 --json --size 4 --reference-count 600 --cache none";
        number(&place.run(&format!("{arguments} {more}")).json(), "mean")
    };
    for (options, bright, dark) in [
        ("", ["4,0,0", "0,0,4"], ["-4,0,0", "0,0,-4"]),
        // With the opposite orientation, -z replaces z.
        (",mirror=yes", ["4,0,0", "0,0,-4"], ["-4,0,0", "0,0,4"]),
        // Counterclockwise as seen from above: from +x to -z.
        (",rotate=90", ["0,0,-4", "4,0,0"], ["0,0,4", "-4,0,0"]),
        (",rotate=180", ["-4,0,0", "0,0,-4"], ["4,0,0", "0,0,4"]),
        // With z up, the quarter is between +x and -y, where the floor receives light too.
        (",up=z", ["4,0,0", "4,0,0"], ["-4,0,0", "-4,0,0"]),
    ] {
        for eye in bright {
            let got = wall(eye, options);
            assert!((got - 0.5).abs() < 0.01, "{options} {eye}: {got}");
        }
        for eye in dark {
            let got = wall(eye, options);
            assert!(got < 0.01, "{options} {eye}: {got}");
        }
    }
}

#[test]
fn a_study_has_rows_rates_and_crossovers() {
    let place = Workplace::new();
    let arguments = format!(
        "render cornell --study -n 6..48 --samplers white-noise,jittered,white-noise -m 4 {SMALL}"
    );
    let document = place.run(&format!("{arguments} --json -o s.csv")).json();
    let rows = document["rows"].as_array().unwrap();
    // 6, 12, 24, 48 and of jitter 6, 24, 54.
    assert_eq!(rows.len(), 7, "{document}");
    for row in rows {
        assert_keys(
            row,
            &["sampler", "mode", "n", "mse", "mse_stderr", "white_noise", "variance_reduction"],
        );
        if row["sampler"] == "white-noise" {
            let reduction = number(row, "variance_reduction");
            // Four renders of about 400 pixels: 4 %.
            assert!((reduction - 1.0).abs() < 0.2, "{row}");
        }
    }
    let samplers = document["samplers"].as_array().unwrap();
    let rate = number(&samplers[0]["all"], "rate");
    assert!((rate + 1.0).abs() < 0.15, "{samplers:?}");
    assert!(number(&samplers[1]["all"], "rate") < rate, "{samplers:?}");
    assert_eq!(numbers(&samplers[0]["all"]["interval"]).len(), 2);
    assert!(rows.iter().all(|row| number(row, "bias_squared_stderr") > 0.0), "{document}");
    let table = place.text("s.csv");
    assert!(table.starts_with("# sphvar render cornell --study"), "{table}");
    assert_eq!(table.lines().count(), 2 + 7);
    assert!(table.lines().nth(1).unwrap().ends_with(",bias_limit,biased_pixels"), "{table}");
    let text = place.run(&format!("{arguments} -o s.png --quiet")).ok().stdout;
    assert!(text.contains("structured error") && text.contains("rate"), "{text}");
    assert_eq!(image::open(place.path("s.png")).unwrap().width(), 1920);
}

#[test]
fn a_sheet_shows_panels() {
    let place = Workplace::new();
    let panels = "reference,fibonacci@shared,fibonacci@rotated";
    let arguments = format!("render cornell --sheet {panels} -n 24,54 -o sheet.png --json {SMALL}");
    let document = place.run(&arguments).json();
    let rows = document["panels"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    assert_eq!(
        (rows[0]["mode"].as_str(), rows[1]["mode"].as_str()),
        (Some("shared"), Some("rotated"))
    );
    let sheet = image::open(place.path("sheet.png")).unwrap();
    assert!(sheet.width() > 3 * 24 && sheet.height() > 2 * 24, "{sheet:?}");
}

/// A square of 2 by 2 under an open sky covers parts of pixels: its value is 1, and alpha is the
/// covered fraction.
#[test]
fn partly_covered_pixels_count_as_such() {
    let place = Workplace::new();
    let square =
        "\u{feff}v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0 0 1\nfo 1//1 2//1 3//1 4//1\n";
    place.write("square.obj", square);
    let view = "render square.obj --sampler jittered -n 96 --size 4 --pixel-rays 16 --eye 0,0,5 \
                --look-at 0,0,0 --fov 30 --reference-count 96 --cache none -m 2";
    let document = place.run(&format!("{view} --json -o s.exr")).json();
    assert_eq!((number(&document, "mean"), number(&document, "mse")), (1.0, 0.0));
    // The picture's height is 10 tan(15 degrees); primary rays are off by at most 1/32 of a pixel.
    let share = (2.0 / (10.0 * 15f64.to_radians().tan())).powi(2);
    assert!((number(&document, "coverage") - share).abs() < 0.05, "{document}");
    let picture = image::open(place.path("s.exr")).unwrap().into_rgba32f();
    let same = |p: &image::Rgba<f32>| p.0[0].to_bits() == p.0[3].to_bits();
    assert!(picture.pixels().all(same), "grey times alpha, and the grey is 1");
    let output = place.run(&format!("{view} --mse -o s.png")).ok();
    assert!(output.stderr.contains("square.obj: ignored: vertex normals (1)"), "{}", output.stderr);
    let picture = image::open(place.path("s.png")).unwrap().into_rgba8();
    assert!(picture.pixels().all(|p| p.0[0] == 255 && p.0[3] > 0));
}

#[test]
fn usage_errors_are_reported() {
    let place = Workplace::new();
    place.write("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1 nan\nf 1 2 3\n");
    place.write("empty.obj", "");
    let run = |arguments: &str| place.run(&format!("render {arguments}"));
    run("cornell -n 24").fails(2, &["missing", "--sampler"]);
    run("teapot --sampler jittered").fails(2, &["unknown scene \"teapot\"", "cornell", ".obj"]);
    run("no.obj --sampler jittered").fails(1, &["cannot open no.obj"]);
    run("broken.obj --sampler jittered").fails(1, &["broken.obj", "line 3"]);
    run("empty.obj --sampler jittered").fails(1, &["empty.obj"]);
    for (arguments, parts) in [
        ("-n 0", &["numbers of points must be at least 1"][..]),
        ("-n 24,48", &["-n must be one number"]),
        ("--mode spin", &["unknown mode", "did you mean \"spun\""]),
        ("--mode projective", &["is now named \"antipodal\""]),
        ("--estimator best", &["unknown estimator", "ratio, unbiased"]),
        ("--integral gi", &["unknown integral", "ao, irradiance, light"]),
        ("--integral ao:weight=x", &["unknown weight of ao"]),
        ("--integral irradiance", &["irradiance:env=FILE"]),
        ("--integral light:albedo=2", &["albedo must be in [0, 1]"]),
        ("--integral light --max-distance 3", &["--max-distance requires --integral ao"]),
        ("--max-distance -3", &["--max-distance must be above 0"]),
        ("--max-distance nan", &["--max-distance must be above 0"]),
        ("--size 0", &["sides must be from 1"]),
        ("--size 10x", &["expected W or WxH"]),
        ("--size 20 --crop 15,0,10,10", &["is not within an image of 20 by 20"]),
        ("--size 20 --crop 1,2,3", &["expected 4 numbers"]),
        ("--pixel-rays 0", &["0 by 0 primary rays"]),
        ("--fov 180", &["field of view above 0 and below 180"]),
        ("--fov nan", &["field of view"]),
        ("--eye 1,2", &["expected 3 numbers"]),
        ("--eye 0,0,0 --look-at 0,0,0", &["a target that differs from its position"]),
        ("--up 0,0,0", &["an upward direction"]),
        ("--white 0 -o p.png", &["--white must be a number above 0"]),
        ("-o p.gif", &[".png, .exr or .pfm"]),
        ("--json -o -", &["standard output holds one document"]),
        ("--difference -", &["standard output holds one document"]),
        ("-m 0", &["-m must be at least 1"]),
        ("--reference-count 0 --json", &["--reference-count"]),
        ("--sets 0", &["--sets must be at least 1"]),
        ("--sets 9 --mode shared", &["--sets requires a random sampler"]),
        ("--sets 9 --mode fresh", &["--sets requires a random sampler"]),
        ("-m 8 -o p.png", &["-m 8 needs errors", "--mse"]),
        ("--lamp 0,0,0,1,0,0,1,1,0,0,1,0", &["--lamp requires --integral light, got ao"]),
        ("-o p.png --difference p.png", &["must name different files", "p.png twice"]),
        ("--difference p.exr --error p.exr", &["must name different files", "p.exr twice"]),
        ("-m 99999999", &["-m must be at most"]),
        ("--samplers jittered", &["cannot be used with"]),
    ] {
        run(&format!("cornell --sampler jittered --cache none {arguments}")).fails(2, parts);
    }
    let away = "--eye 0,0,-800 --look-at 0,0,-900 --size 8";
    run(&format!("cornell --sampler jittered {away}")).fails(1, &["shows no surface", "--eye"]);
    let many = "-n 1000000000000 --size 8";
    run(&format!("cornell --sampler jittered {many}"))
        .fails(1, &["-n 1000000000000 requires", "memory"]);
    let sets = format!("--sets {} -n 24 --size 8", u64::MAX);
    run(&format!("cornell --sampler jittered {sets}"))
        .fails(1, &["--sets 18446744073709551615 requires", "memory"]);
    run("cornell --sampler healpix -n 24 --sets 9").fails(2, &["--sets requires a random sampler"]);
    place.write("pyramid.obj", PYRAMID);
    for fov in ["0", "nan", "180", "-3"] {
        run(&format!("pyramid.obj --sampler jittered --fov {fov}"))
            .fails(2, &["--fov must be", "above 0 and below 180 degrees"]);
    }
    image::RgbImage::new(8, 4).save(place.path("sky.png")).unwrap();
    run("cornell --sampler jittered --integral irradiance:env=sky.png")
        .fails(1, &["sky.png", "expected OpenEXR (.exr) or Radiance HDR (.hdr)"]);
    let panels = vec!["reference"; 4000].join(",");
    run(&format!("cornell --sheet {panels} -o s.png --size 32768"))
        .fails(1, &["the sheet requires", "memory"]);
    run("cornell --study -n 6").fails(2, &["missing", "--samplers"]);
    run("cornell --study --samplers jittered -m 1").fails(2, &["-m must be at least 2"]);
    run("cornell --sheet jittered@upside").fails(2, &["missing", "-o"]);
    run("cornell --sheet jittered@upside -o s.png").fails(2, &["unknown mode \"upside\""]);
    run("cornell --sheet jittered -o s.exr").fails(2, &["sheets are written as .png"]);
    assert_eq!(place.names(), ["broken.obj", "empty.obj", "pyramid.obj", "sky.png"]);
}

/// The environment map of the repository lights a mesh.
#[test]
fn a_real_map_lights_a_mesh() {
    let place = Workplace::new();
    place.write("pyramid.obj", PYRAMID);
    let map = data("city.exr");
    let arguments = "render pyramid.obj --sampler step -n 32 --size 32 -o m.png";
    let text = place.run(&format!("{arguments} --integral irradiance:env={map}")).ok().stdout;
    assert!(text.contains("mean value"), "{text}");
    // The brightest pixel is white.
    let picture = image::open(place.path("m.png")).unwrap().into_rgb8();
    assert_eq!(picture.pixels().map(|p| p.0[0]).max(), Some(255));
}
