//! A few values through the whole command, against independent references.

use std::f64::consts::PI;

use crate::outcome::numbers;
use crate::workplace::{Workplace, data};

/// Rows of the 25-digit table: an oscillating value, a tiny one near the pole, one below the range
/// of f64.
#[test]
fn legendre_functions() {
    let table = include_str!("../../../accuracy/data/associated_legendre.csv");
    let rows: Vec<Vec<&str>> = table
        .lines()
        .skip_while(|line| !line.starts_with("l,m"))
        .skip(1)
        .map(|line| line.split(',').collect())
        .collect();
    assert!(rows.len() > 100, "{}", rows.len());
    let place = Workplace::new();
    // Every fortieth, which includes low and high degrees from both ends of the colatitudes.
    for row in rows.iter().step_by(40) {
        let (l, reference) = (row[0].parse::<f64>().unwrap(), row[3].parse::<f64>().unwrap());
        let arguments = format!("eval legendre --l {l} --m {} --theta {} --json", row[1], row[2]);
        let got = place.run(&arguments).json()["value"].as_f64().unwrap();
        // 4 EPSILON (l + 1) of the local amplitude, which |lambda| <= sqrt((2l + 1)/(4 pi)) bounds.
        let bound = 4.0 * f64::EPSILON * (l + 1.0) * ((2.0 * l + 1.0) / (4.0 * PI)).sqrt();
        assert!((got - reference).abs() <= bound, "{row:?}: {got}");
    }
}

/// E(l) = pi (P_{l-1}(c) - P_{l+1}(c))^2 / (2l + 1), c = cos 60 degrees, by the plain recurrence.
#[test]
fn cap_energies() {
    let place = Workplace::new();
    let document = place.run("eval cap-power --degrees 60 --lmax 40 --json").json();
    let energy = numbers(&document["energy"]);
    let mut p = vec![1.0, 0.5];
    for l in 1..=40 {
        let k = l as f64;
        p.push(((2.0 * k + 1.0) * 0.5 * p[l] - k * p[l - 1]) / (k + 1.0));
    }
    // E(0) = area^2/(4 pi) with the area 2 pi (1 - c) = pi.
    assert!((energy[0] - PI / 4.0).abs() < 8.0 * f64::EPSILON, "{}", energy[0]);
    for l in 1..=40 {
        let expected = PI * (p[l - 1] - p[l + 1]).powi(2) / (2 * l + 1) as f64;
        // The recurrence loses a few ulp of P = O(1) in l steps; the square doubles that.
        let bound = 8.0 * f64::EPSILON * (l + 1) as f64 * expected.sqrt();
        assert!((energy[l] - expected).abs() < bound, "degree {l}: {}, not {expected}", energy[l]);
    }
    // Parseval: the square of the indicator integrates to the area.
    let total = document["total"].as_f64().unwrap();
    assert!((total - PI).abs() < 8.0 * PI * f64::EPSILON, "{total}");
}

#[test]
fn variance_of_white_noise() {
    let place = Workplace::new();
    let arguments = "variance white-noise -n 48 --integrand ylm:l=4 -m 1500 --json";
    let row = place.run(arguments).json()["rows"][0].clone();
    let number = |key: &str| row[key].as_f64().unwrap();
    // A harmonic has energy 1 in one degree: Var = 4 pi/N.
    let expected = 4.0 * PI / 48.0;
    let (value, error) = (number("measured"), number("measured_stderr"));
    assert!((value - expected).abs() < 4.0 * error, "measured {value} +- {error}, not {expected}");
    assert!(error < 0.06 * expected, "measured {value} +- {error}");
    // The spectrum is known in closed form, so the prediction is a product of a few numbers.
    let (value, error) = (number("predicted"), number("predicted_stderr"));
    assert!((value / expected - 1.0).abs() < 8.0 * f64::EPSILON && error == 0.0, "{value} {error}");
    // A sampled spectrum has an error.
    let row =
        place.run(&format!("{arguments} --spectrum-realizations 2000")).json()["rows"][0].clone();
    let number = |key: &str| row[key].as_f64().unwrap();
    let (value, error) = (number("predicted"), number("predicted_stderr"));
    assert!((value - expected).abs() < 4.0 * error, "predicted {value} +- {error}, not {expected}");
    assert!(error < 0.06 * expected, "predicted {value} +- {error}");
}

/// Stratification: at most 1/16 of white noise's variance at N = 192, the values of the issue.
#[test]
fn variance_of_jittered_strata() {
    let place = Workplace::new();
    let arguments = "variance jittered -n 192,768 --integrand ylm:l=4,m=0 -m 400 --json";
    let document = place.run(arguments).json();
    for (row, expected) in [(0, 7.183e-3), (1, 4.689e-4)] {
        let row = &document["rows"][row];
        let (predicted, error) =
            (row["predicted"].as_f64().unwrap(), row["predicted_stderr"].as_f64().unwrap());
        // The references have four digits.
        let bound = 4.0 * error + 1e-3 * expected;
        assert!((predicted - expected).abs() < bound, "{predicted} +- {error}, not {expected}");
        assert!(row["z"].as_f64().unwrap().abs() < 4.0, "{row}");
    }
}

#[test]
fn the_star_catalogue() {
    let place = Workplace::new();
    let document =
        place.run(&format!("spectrum --points {} --lmax 16 --json", data("stars.csv"))).json();
    assert_eq!((&document["n"], &document["realizations"]), (&5044.into(), &1.into()));
    let power = numbers(&document["power"]);
    assert_eq!(power.len(), 17);
    // P(0) = N; the sum of 5044 terms is rounded.
    assert!((power[0] - 5044.0).abs() < 5044.0 * 5044.0 * f64::EPSILON, "{}", power[0]);
    // Bright stars are concentrated along the Milky Way: their quadrupole is far above chance.
    assert!(power[2] > 20.0, "{power:?}");
}

/// The lattice of 972 points: odd degrees vanish by symmetry, the even ones are those of the
/// reference spectrum `healpix_972.csv`, near the limits N P -> 0.309, 0.906, 0.460, 0.208 of many
/// points.
#[test]
fn healpix_through_a_file() {
    const REFERENCE: [(usize, f64, f64); 4] = [
        (2, 3.191029e-4, 0.309),
        (4, 9.4847154e-4, 0.906),
        (6, 4.7912153e-4, 0.460),
        (8, 2.0933676e-4, 0.208),
    ];
    let place = Workplace::new();
    // The error of the fast transform is relative to P(0) = 972, not to the small power of the
    // lattice.
    let exact = "--lmax 9 --method exact --json";
    let direct = numbers(&place.run(&format!("spectrum healpix -n 972 {exact}")).json()["power"]);
    place.run("sample healpix -n 972 -o p.csv").ok();
    place.run("sample healpix -n 972 --rotate -o p.npy").ok();
    for (name, tolerance) in [("p.csv", 1e-11), ("p.npy", 1e-11)] {
        let power =
            numbers(&place.run(&format!("spectrum --points {name} {exact}")).json()["power"]);
        for l in (1..=9).step_by(2) {
            assert!(power[l] < 1e-20 && direct[l] < 1e-20, "{name}, degree {l}: {}", power[l]);
        }
        for (l, recorded, limit) in REFERENCE {
            // A rotated lattice has the same spectrum up to the rounding of 972 directions, whose
            // relative effect grows as the sum decreases.
            let apart = (power[l] - direct[l]).abs() / direct[l];
            assert!(apart < tolerance, "{name}, degree {l}: {}, {}", power[l], direct[l]);
            assert!((power[l] / recorded - 1.0).abs() < 1e-6, "degree {l}: {}", power[l]);
            assert!((972.0 * power[l] / limit - 1.0).abs() < 0.025, "degree {l}: {}", power[l]);
        }
    }
}
