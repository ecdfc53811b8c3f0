//! Composite integrands: sums, products, rotations, maps.

use std::f64::consts::PI;

use crate::workplace::{Workplace, small_exr};

/// Returns the row of an integrand, including its exact value, by `variance`.
fn row(place: &Workplace, integrand: &str, more: &str) -> serde_json::Value {
    let command = format!("variance white-noise -n 12 -m 4 --json {more}");
    // One argument, because an expression may start with a minus.
    let output = place.command(&command).arg(format!("--integrand={integrand}")).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{integrand}: {message}");
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["rows"][0]["integrand"], integrand);
    document["rows"][0].clone()
}

/// Returns the message and the exit status for an invalid integrand.
fn rejection(place: &Workplace, integrand: &str, more: &str) -> (String, Option<i32>) {
    let command = format!("variance healpix -n 24 --nearest -m 4 {more} --integrand");
    let output = place.command(&command).arg(integrand).output().unwrap();
    (String::from_utf8_lossy(&output.stderr).into_owned(), output.status.code())
}

#[test]
fn expressions_have_the_integrals_of_their_parts() {
    let place = Workplace::new();
    let cap = |degrees: f64| 2.0 * PI * (1.0 - degrees.to_radians().cos());
    for (integrand, exact) in [
        ("cap:degrees=30 @ 40/10 + 0.5 * vmf:kappa=10", cap(30.0) + 0.5),
        ("cap:degrees=30 - cosine", cap(30.0) - PI),
        ("2 * cosine * 0.25", 0.5 * PI),
        ("-1e-3 * cosine", -1e-3 * PI),
        ("cosine * half-space", PI),
        ("cosine * cap:degrees=30 @ 40/10", 0.25 * PI * 40f64.to_radians().cos()),
        (
            "cosine * cap:degrees=20 @ 50/10/70",
            cap(20.0) * 0.5 * (1.0 + 20f64.to_radians().cos()) * 50f64.to_radians().cos(),
        ),
        ("1 + ylm:l=3,m=2 @ 10/20/30", 4.0 * PI),
        ("half-space:height=0.5", PI),
        ("phong:n=20 @ 90/0", 2.0 * PI / 21.0),
        ("abs-cosine @ 12/34", 2.0 * PI),
        ("double-cap:degrees=60 @ 12/34", 2.0 * PI),
        ("cap:degrees=60 @ 30/0 @ 0/90", PI),
    ] {
        let got = row(&place, integrand, "")["exact"].as_f64().unwrap();
        assert!((got - exact).abs() < 1e-12, "{integrand}: {got}, not {exact}");
    }
    let got = row(&place, "cosine @ 90/0 + cosine", "--hemisphere")["exact"].as_f64().unwrap();
    assert!((got - 1.5 * PI).abs() < 1e-11, "{got}");
}

#[test]
fn mistakes_name_the_piece() {
    let place = Workplace::new();
    for (integrand, parts) in [
        ("cap:degrees=30 @ 40", &["@ requires THETA/PHI", "\"40\""][..]),
        ("cap:degrees=30 @ 40/x", &["\"40/x\""]),
        ("cap:degrees=30 @ 181/0", &["[0, 180]", "\"181/0\""]),
        ("cap:degrees=30 @ 1/2/3/4", &["\"1/2/3/4\""]),
        ("cosine + cap:degrees=300", &["cap:degrees=300", "got 300"]),
        ("cosine +  + cosine", &["an operator has no operand on one side"]),
        ("cosine * cosin", &["\"cosin\"", "did you mean \"cosine\""]),
        ("cosine * nan", &["a weight must be 0 or between 1e-150 and 1e150"]),
        ("phong:n=-1", &["n must be in [0, 1e6]", "-1"]),
        ("half-space:height=1", &["height", "[-1, 1)"]),
        ("double-cap:degrees=91", &["(0, 90]"]),
    ] {
        let (message, status) = rejection(&place, integrand, "");
        assert_eq!(status, Some(2), "{integrand}: {message}");
        for part in parts {
            assert!(message.contains(part), "{integrand}: {message}");
        }
    }
}

#[test]
fn maps_are_functions() {
    let place = Workplace::new();
    let data = |name: &str| format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    // The mean of 0 .. 191 in either order.
    for name in ["ring.fits", "nested.fits"] {
        let got = row(&place, &format!("map:{}", data(name)), "")["exact"].as_f64().unwrap();
        assert!((got - 4.0 * PI * 95.5).abs() < 1e-9, "{name}: {got}");
    }
    let half = |name: &str| {
        row(&place, &format!("map:{}", data(name)), "--hemisphere")["exact"].as_f64().unwrap()
    };
    // The upper half in ring order is 0 .. 87 and half of 88 .. 103; it differs in the other order.
    let exact = 4.0 * PI / 192.0 * (87.0 * 44.0 + 0.5 * 16.0 * 95.5);
    for name in ["ring.fits", "nested.fits"] {
        assert!((half(name) - exact).abs() < 1e-9, "{name}: {}, not {exact}", half(name));
    }
    let got = row(&place, &format!("map:{},field=1", data("two_fields.fits")), "");
    assert!((got["exact"].as_f64().unwrap() + 4.0 * PI * 95.5).abs() < 1e-4);
    row(&place, &format!("map:{} @ 30/40 + vmf:kappa=3", data("ring.fits")), "");
    let (message, status) = rejection(&place, &format!("map:{}", data("unseen.fits")), "");
    assert!(
        message.contains("2 pixels of the map have no value") && message.contains("first is 3"),
        "{message}"
    );
    assert_eq!(status, Some(1));
    // The edges of pixels are not circles, so that energies of products are estimates.
    let got = row(&place, &format!("map:{} * cap:degrees=30", data("ring.fits")), "-s 3");
    assert!(got["predicted"].as_f64().unwrap() > 0.0, "{got}");
    assert!(got["predicted_stderr"].as_f64().unwrap() > 0.0 && got["exact"].is_null(), "{got}");
}

#[test]
fn maps_may_be_partial_compressed_and_chosen() {
    let place = Workplace::new();
    let data = |name: &str| format!("map:{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    let exact = |integrand: &str, more: &str| {
        row(&place, integrand, more)["exact"].as_f64().unwrap() / (4.0 * PI)
    };
    // Means and the ring order of `benches/peers/map_variants.py`.
    for (integrand, more, mean) in [
        (data("odd.fits.gz"), "", 53.5),
        (format!("{},missing=0", data("explicit.fits")), "", 26.700520833333332),
        (format!("{},missing=mean", data("explicit.fits")), "", 51.265),
        // 1227 in the rings above the equator and 424.5 on it.
        (
            format!("{},missing=0", data("explicit.fits")),
            "--hemisphere",
            (1227.0 + 0.5 * 424.5) / 192.0,
        ),
        (format!("{},field=MASK", data("mixed.fits[2]")), "", 1.0 / 3.0),
        (format!("{},field=counts,hdu=MAP,missing=0", data("mixed.fits")), "", 1963.5 / 192.0),
        (format!("{},missing=mean", data("implicit_part.fits")), "", 59.5),
    ] {
        let got = exact(&integrand, more);
        assert!((got - mean).abs() < 1e-12 * mean, "{integrand}: {got}, not {mean}");
    }
    let command =
        format!("variance white-noise -n 12 -m 4 --integrand {},missing=0", data("explicit.fits"));
    let remark = "92 of 192 pixels have no value and are replaced by 0";
    assert!(place.run(&command).ok().stderr.contains(remark));
    assert!(!place.run(&format!("{command} --quiet")).ok().stderr.contains(remark));
    for (options, parts) in [
        ("", &["92 pixels of the map", "missing=0 or missing=mean"][..]),
        (",missing=1", &["missing of map", "0, mean"]),
        (",field=3", &["a field below 2", "SIGNAL, N_OBS"]),
        (",hdu=7", &["HDU 7", "[1] table"]),
    ] {
        let (message, _) = rejection(&place, &format!("{}{options}", data("explicit.fits")), "");
        for part in parts {
            assert!(message.contains(part), "{options}: {message}");
        }
    }
}

/// The orientation changes the function but not its integral; it affects `render` and directions.
#[test]
fn environment_maps_have_options() {
    let place = Workplace::new();
    place.write("sky.exr", small_exr(16, 8));
    let value = |integrand: &str, more: &str| row(&place, integrand, more);
    let plain = value("env:sky.exr", "");
    for options in
        ["mirror=yes", "rotate=33", "up=y", "up=-x,rotate=-5,mirror=yes", "up=z,channel=r"]
    {
        let other = value(&format!("env:sky.exr,{options}"), "");
        let (a, b) = (plain["exact"].as_f64().unwrap(), other["exact"].as_f64().unwrap());
        assert!((a - b).abs() < 1e-6 * a, "{options}: {a} {b}");
    }
    let upper = |integrand: &str| value(integrand, "--hemisphere")["exact"].as_f64().unwrap();
    let bright_below = upper("env:sky.exr,up=-z");
    let sum = plain["exact"].as_f64().unwrap();
    assert!((bright_below + upper("env:sky.exr") - sum).abs() < 1e-6 * sum);
    assert!(bright_below > upper("env:sky.exr"));
    for (options, parts) in [
        ("up=w", &["unknown up of env \"w\"", "z, y, x, -z, -y, -x"][..]),
        ("mirror=maybe", &["mirror of env", "no, yes"]),
        ("rotate=inf", &["rotate must be a finite number"]),
        ("projection=cube", &["projection of env", "latlong, octahedral"]),
        ("projection=octahedral", &["must be square", "16 x 8"]),
        ("tilt=3", &["unknown parameter \"tilt\"", "mirror (no, yes), rotate"]),
    ] {
        let (message, _) = rejection(&place, &format!("env:sky.exr,{options}"), "");
        for part in parts {
            assert!(message.contains(part), "{options}: {message}");
        }
    }
}

#[test]
fn quoted_names_hold_anything() {
    let place = Workplace::new();
    place.write("a,b=c + d * e @ f.exr", small_exr(8, 4));
    let quoted = "\"a,b=c + d * e @ f.exr\"";
    let one = row(&place, &format!("env:{quoted}"), "")["exact"].as_f64().unwrap();
    let many = format!("2 * env:file={quoted},channel=r @ 40/10 - env:{quoted} + cap:degrees=60");
    let got = row(&place, &many, "")["exact"].as_f64().unwrap();
    assert!((got - one - PI).abs() < 1e-5 * one, "{got} {one}");
    place.write(
        "x=1.fits",
        std::fs::read(format!("{}/tests/data/two_fields.fits", env!("CARGO_MANIFEST_DIR")))
            .unwrap(),
    );
    let got = row(&place, "map:file=\"x=1.fits\",field=1", "")["exact"].as_f64().unwrap();
    assert!((got + 4.0 * PI * 95.5).abs() < 1e-4);
    let (message, status) = rejection(&place, "cosine + env:\"a,b", "");
    assert!(message.contains("the quote is not closed"), "{message}");
    assert_eq!(status, Some(2));
}

/// Names of files need not be UTF-8.
#[cfg(target_os = "linux")]
#[test]
fn names_of_any_bytes_are_read() {
    use std::os::unix::ffi::OsStrExt;

    let place = Workplace::new();
    let name = std::ffi::OsStr::from_bytes(b"sky\xff,1.exr");
    std::fs::write(place.path(name), small_exr(8, 4)).unwrap();
    std::fs::write(place.path(std::ffi::OsStr::from_bytes(b"sky\xff.exr")), small_exr(8, 4))
        .unwrap();
    for (argument, shown) in [
        (&b"--integrand=env:\"sky\xff,1.exr\""[..], "env:\"sky\\xff,1.exr\""),
        (b"--integrand=env:sky\xff.exr,channel=r", "env:\"sky\\xff.exr\",channel=r"),
        // The name is accepted in the form in which it is shown.
        (b"--integrand=env:\"sky\\xff.exr\"", "env:\"sky\\xff.exr\""),
    ] {
        let mut command = place.command("variance white-noise -n 12 -m 4 --json");
        let output = command.arg(std::ffi::OsStr::from_bytes(argument)).output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{shown}: {message}");
        let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(document["rows"][0]["integrand"], shown);
    }
    let mut command = place.command("render cornell --sampler jittered -n 24 --size 4 -o p.exr");
    let integral =
        std::ffi::OsStr::from_bytes(b"--integral=irradiance:env=sky\xff.exr,rotate=90,mirror=yes");
    let output = command.arg(integral).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// A term with a file and parameters is accepted on either side of an operator.
#[test]
fn parameters_of_maps_end_at_operators() {
    let place = Workplace::new();
    place.write("sky.exr", small_exr(16, 8));
    let data = format!("{}/tests/data/two_fields.fits", env!("CARGO_MANIFEST_DIR"));
    place.write("two.fits", std::fs::read(data).unwrap());
    let exact = |integrand: &str| row(&place, integrand, "")["exact"].as_f64().unwrap();
    let env = exact("env:sky.exr,channel=r,up=y");
    let map = exact("map:two.fits,field=1");
    let close = |got: f64, wanted: f64| (got - wanted).abs() < 1e-9 * wanted.abs();
    for (integrand, wanted) in [
        ("env:sky.exr,channel=r,up=y * 0.5", 0.5 * env),
        ("env:sky.exr,channel=r,up=y @ 40/10", env),
        ("env:sky.exr,up=y,channel=r + cap:degrees=60", env + PI),
        ("env:sky.exr,channel=r,up=y - env:sky.exr,channel=r,mirror=yes", 0.0),
        ("map:two.fits,field=1 * 2", 2.0 * map),
        ("map:two.fits,field=1 + ylm:l=2,m=0", map),
    ] {
        let got = exact(integrand);
        assert!(close(got, wanted) || (got - wanted).abs() < 1e-6 * env, "{integrand}: {got}");
    }
    let product = "env:sky.exr,up=y * cap:degrees=60 @ 40/10";
    let reversed = "cap:degrees=60 @ 40/10 * env:sky.exr,up=y";
    assert!((exact(product) / exact(reversed) - 1.0).abs() < 1e-6);
}

/// Every text that was a valid file name before expressions existed still is.
#[test]
fn names_of_files_may_look_like_expressions() {
    let place = Workplace::new();
    place.write("a + b @ c.exr", small_exr(8, 4));
    row(&place, "env:a + b @ c.exr", "");
    row(&place, "env:a + b @ c.exr,channel=r,up=y", "");
    let (message, _) = rejection(&place, "env:a + b.exr", "");
    assert!(message.contains('a') && !message.contains("panic"), "{message}");
}
