//! Integrands that are given by energies, a bandwidth or coefficients.

use std::f64::consts::PI;

use crate::workplace::Workplace;

/// Returns the first row of `variance` for an integrand.
fn row(place: &Workplace, command: &str, integrand: &str) -> serde_json::Value {
    let output = place.command(command).arg(format!("--integrand={integrand}")).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{integrand}: {message}");
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    document["rows"][0].clone()
}

fn number(row: &serde_json::Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} in {row}"))
}

fn data(name: &str) -> String {
    format!("alm:{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The files are those of healpy, with four harmonics; see `benches/peers/map_variants.py`.
#[test]
fn coefficients_of_healpy_are_sums_of_harmonics() {
    let place = Workplace::new();
    let command = "variance white-noise -n 12 -m 4 --json";
    for file in [data("alm.npy"), data("alm.fits[2]"), data("alm.fits,hdu=2")] {
        let alone = row(&place, command, &file);
        let exact = 3.0 * (4.0 * PI).sqrt();
        assert!((number(&alone, "exact") / exact - 1.0).abs() < 1e-14, "{alone}");
        let predicted = 4.0 * PI / 12.0 * (0.25 + 4.0 + 1.0);
        assert!((number(&alone, "predicted") / predicted - 1.0).abs() < 1e-13, "{alone}");
        let rest = format!("{file} - 3 * ylm:l=0 - 0.5 * ylm:l=2,m=1 - 2 * ylm:l=3,m=-2 + ylm:l=4");
        let rest = row(&place, command, &rest);
        // Energies of the parts cancel to rounding, values to the square of it.
        assert!(number(&rest, "predicted") < 1e-14, "{rest}");
        assert!(number(&rest, "measured") < 1e-27, "{rest}");
        assert!(number(&rest, "exact").abs() < 1e-14, "{rest}");
    }
    // The first table has coefficients of 0.
    let zero = row(&place, command, &data("alm.fits"));
    assert_eq!((zero["predicted"].as_f64(), zero["exact"].as_f64()), (Some(0.0), Some(0.0)));
}

#[test]
fn the_first_of_several_tables_is_named() {
    let place = Workplace::new();
    let remark = |hdu: &str| {
        let arguments = "variance white-noise -n 12 -m 4";
        let integrand = format!("--integrand={}", data(&format!("alm.fits{hdu}")));
        let output = place.command(arguments).arg(integrand).output().unwrap();
        String::from_utf8_lossy(&output.stderr).contains("hdu=2 selects the next")
    };
    assert!(remark(""));
    assert!(!remark("[1]") && !remark(",hdu=2"));
}

/// The prediction of a cap, cut off at the degree of the file.
#[test]
fn energies_of_a_cap_give_its_prediction() {
    let place = Workplace::new();
    let table = place.run("eval cap-power --degrees 30 --lmax 80").stdout;
    place.write("cap.csv", table);
    let command = "variance jittered -n 192 -m 20 --lmax 80 --json";
    let [file, cap] =
        ["energy:cap.csv", "cap:degrees=30"].map(|integrand| row(&place, command, integrand));
    let of_band = number(&cap, "predicted") - number(&cap, "predicted_tail");
    assert!((number(&file, "predicted") / of_band - 1.0).abs() < 1e-12, "{file} {cap}");
    assert_eq!(number(&file, "predicted_tail").to_bits(), 0);
    assert!(number(&cap, "predicted_tail") > 0.0);
    assert!((number(&file, "exact") / number(&cap, "exact") - 1.0).abs() < 1e-14);
}

#[test]
fn a_bandwidth_has_counts_and_a_relative_error() {
    let place = Workplace::new();
    let rows = |arguments: &str| -> serde_json::Value {
        let document = place.run(&format!("choose fibonacci,lebedev --json {arguments}")).stdout;
        let document: serde_json::Value = serde_json::from_str(&document).unwrap();
        document["rows"].clone()
    };
    let counts = rows("--integrand band:lmax=12 --error 0.1%");
    // The smallest rule of Lebedev that is exact to degree 12.
    assert_eq!((&counts[0]["sampler"], &counts[0]["n"]), (&"lebedev".into(), &74.into()));
    let error = number(&counts[1], "relative_error");
    assert!((5e-4..=1e-3).contains(&error), "{counts}");
    // Standard deviation 1 and mean 2.
    let halved = rows("--integrand band:lmax=12,mean=2 --error 0.1%");
    assert!(number(&halved[1], "n") < number(&counts[1], "n"), "{halved}");
    for integrand in ["band:lmax=12,mean=0", "energy:from_1.csv"] {
        place.write("from_1.csv", "1,1\n2,0.5\n");
        let without = rows(&format!("--integrand {integrand} -n 50"));
        assert!(without[0]["relative_error"].is_null(), "{without}");
        let rejected = place.run(&format!("choose fibonacci --integrand {integrand} --error 1%"));
        assert_eq!(rejected.status, Some(2));
        assert!(rejected.stderr.contains("use --absolute"), "{}", rejected.stderr);
    }
}

#[test]
fn wrong_files_and_parameters_are_named() {
    let place = Workplace::new();
    // An array of 19 complex numbers, and one of 3 with a NaN.
    let array = |values: &[[f64; 2]]| {
        let header =
            format!("{{'descr': '<c16', 'fortran_order': False, 'shape': ({},), }}", values.len());
        let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
        bytes.extend(format!("{header:<117}\n").bytes());
        bytes.extend(values.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes
    };
    place.write("short.npy", array(&[[1.0, 0.0]; 19]));
    place.write("nan.npy", array(&[[1.0, 0.0], [2.0, 0.0], [f64::NAN, 0.0]]));
    place.write("complex.npy", array(&[[1.0, 0.0], [2.0, 1.0], [0.0, 0.0]]));
    for (name, text) in [
        ("negative.csv", "1,1\n2,-1\n"),
        ("nan.csv", "1,1\n2,nan\n"),
        ("gap.csv", "1,1\n3,1\n"),
        ("again.csv", "1,1\n2,1\n2,1\n"),
        ("header.csv", "l,power\n1,1\n"),
        ("empty.csv", ""),
    ] {
        place.write(name, text);
    }
    for (integrand, parts, status) in [
        ("energy:negative.csv", &["negative.csv:2", "from 0", "-1"][..], 1),
        ("energy:nan.csv", &["nan.csv:2", "nan"], 1),
        ("energy:gap.csv", &["gap.csv", "every degree from 1 to 3", "degree 2"], 1),
        ("energy:again.csv", &["again.csv:3", "each degree once"], 1),
        ("energy:header.csv", &["header.csv:1", "energy", "cl", "l,power"], 1),
        ("energy:empty.csv", &["rows of l and energy"], 1),
        ("energy:none.csv", &["none.csv"], 1),
        ("energy:gap.csv,quantity=power", &["quantity", "energy", "cl"], 2),
        (
            "alm:short.npy",
            &["short.npy", "21 for lmax = 5, the nearest", "healpy.resize_alm", "19"],
            1,
        ),
        ("alm:nan.npy", &["nan.npy[2]", "finite"], 1),
        ("alm:complex.npy", &["complex.npy", "l = 1, m = 0", "real for m = 0"], 1),
        ("alm:gap.csv", &["an NPY array or a FITS table of coefficients"], 1),
        ("band", &["lmax is missing"], 2),
        ("band:lmax=0", &["from 1", "got 0"], 2),
        ("band:lmax=10000000", &["from 1 to 1000000"], 2),
        ("band:lmax=4,decay=21", &["decay", "[-20, 20]"], 2),
        ("band:lmax=4,field=-1", &["field", "-1"], 2),
        ("band:lmax=4,field=18446744073709551615", &["integer, 9223372036854775807"], 2),
    ] {
        let outcome =
            place.run(&format!("variance white-noise -n 12 -m 4 --integrand {integrand}"));
        assert_eq!(outcome.status, Some(status), "{integrand}: {}", outcome.stderr);
        for part in parts {
            assert!(outcome.stderr.contains(part), "{integrand}: {}", outcome.stderr);
        }
    }
}

#[test]
fn expansions_take_part_in_every_command() {
    let place = Workplace::new();
    for arguments in [
        "compare fibonacci,jittered -n 12,48 -m 20 -o out --integrand",
        "bounds fibonacci -n 48 --integrand",
        "variance fibonacci -n 24 -m 20 --hemisphere --integrand",
        "variance jittered -n 24 --nearest -m 20 --no-rotate --integrand",
    ] {
        let integrand = "band:lmax=4 * cosine + 0.5 * band:lmax=3,field=1 @ 30/40";
        let output = place.command(arguments).arg(integrand).output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments}: {message}");
    }
}

/// Values of about 1e16 are even numbers, so that all estimates are equal.
#[test]
fn a_variance_hidden_by_rounding_is_not_measured() {
    let place = Workplace::new();
    let row = row(&place, "variance fibonacci -n 48 -m 20 --json", "band:lmax=40,mean=1e16");
    assert!(number(&row, "predicted") > 1.0, "{row}");
    for key in ["measured", "measured_stderr", "measured_high", "z", "bias_p"] {
        assert!(row[key].is_null(), "{key}: {row}");
    }
    assert!(row["remark"].as_str().unwrap().contains("rounding"), "{row}");
}
