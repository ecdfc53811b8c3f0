//! The documents of `--json` and the result files of the other subcommands.

use crate::outcome::{assert_keys, numbers, same};
use crate::workplace::Workplace;

/// Returns the CSV rows below the comment, the heading first.
fn rows(text: &str) -> Vec<csv::StringRecord> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .has_headers(false)
        .from_reader(text.as_bytes());
    reader.records().map(Result::unwrap).collect()
}

#[test]
fn spectrum() {
    let place = Workplace::new();
    let document = place.run("spectrum jittered -n 48 -m 6 --lmax 9 --json").json();
    assert_keys(&document, &["n", "lmax", "realizations", "l", "power", "stderr", "seconds"]);
    assert_eq!(
        (&document["n"], &document["lmax"], &document["realizations"]),
        (&48.into(), &9.into(), &6.into())
    );
    let l: Vec<f64> = (0..10).map(f64::from).collect();
    assert_eq!(numbers(&document["l"]), l);
    let (power, stderr) = (numbers(&document["power"]), numbers(&document["stderr"]));
    assert_eq!((power.len(), stderr.len()), (10, 10));
    // P(0) = N, here to the rounding of 48 terms.
    assert!((power[0] - 48.0).abs() < 48.0 * 48.0 * f64::EPSILON, "{}", power[0]);
    assert!(power[1..].iter().zip(&stderr[1..]).all(|(p, e)| *p > 0.0 && *e > 0.0), "{document}");
    assert!(document["seconds"].as_f64().unwrap() >= 0.0);

    place.run("spectrum jittered -n 48 -m 6 --lmax 9 -o s.csv").ok();
    let table = rows(&place.text("s.csv"));
    assert_eq!(table[0], ["l", "omega", "power", "stderr", "realizations"][..]);
    for (l, row) in table[1..].iter().enumerate() {
        assert_eq!(row[0].parse(), Ok(l));
        assert!(same(row[2].parse().unwrap(), power[l]), "degree {l}: {row:?}");
        assert!(same(row[3].parse().unwrap(), stderr[l]), "degree {l}: {row:?}");
    }
    place.run("spectrum jittered -n 48 -m 6 --lmax 9 -o s.json").ok();
    let file: serde_json::Value = serde_json::from_str(&place.text("s.json")).unwrap();
    assert_eq!(file["power"], document["power"]);
}

/// Closed-form spectra are written in the same formats.
#[test]
fn exact_spectrum() {
    let place = Workplace::new();
    let document = place.run("spectrum jittered -n 48 --exact --lmax 9 --json").json();
    assert_eq!((&document["n"], &document["realizations"]), (&48.into(), &0.into()));
    let (power, stderr) = (numbers(&document["power"]), numbers(&document["stderr"]));
    assert!(same(power[0], 48.0), "{document}");
    // c_N l(l+1)/N with c = 1.0771.
    assert!((power[1] * 24.0 - 1.0771).abs() < 1e-4, "{document}");
    assert!(stderr.iter().all(|e| same(*e, 0.0)) && stderr.len() == 10, "{document}");

    place.run("spectrum jittered -n 48 --exact --lmax 9 -o s.csv").ok();
    for (l, row) in rows(&place.text("s.csv"))[1..].iter().enumerate() {
        assert!(same(row[2].parse().unwrap(), power[l]), "degree {l}: {row:?}");
        assert_eq!((&row[3], &row[4]), ("0e0", "0"), "degree {l}: {row:?}");
    }
    place.run("spectrum jittered -n 48 --exact --lmax 9 -o s.svg").ok();
    assert!(place.text("s.svg").contains("jittered"));

    // The lines of the hemisphere have the spectrum of the sphere with the same cells, at even
    // degrees.
    let half = place.run("spectrum jittered -n 24 --exact --hemisphere --lmax 9 --json").json();
    assert_eq!(numbers(&half["l"]), [0.0, 2.0, 4.0, 6.0, 8.0]);
    for (l, p) in [2, 4, 6, 8].into_iter().zip(&numbers(&half["power"])[1..]) {
        assert!(same(*p, power[l]), "degree {l}: {p}, {}", power[l]);
    }
    // The default degree of other spectra.
    let white = place.run("spectrum white-noise -n 100 --exact --json").json();
    assert_eq!(white["lmax"], 40);
    for thread in [1, 2] {
        let again =
            place.run(&format!("spectrum jittered -n 48 --exact --lmax 9 -j {thread} --json"));
        assert_eq!(numbers(&again.json()["power"]), power, "{thread} threads");
    }
}

#[test]
fn spectrum_by_order_and_single_coefficients() {
    let place = Workplace::new();
    let document =
        place.run("spectrum jittered -n 48 -m 6 --lmax 4 --per-order lm.csv --coefficient 3 2 a.csv --json").json();
    let power = numbers(&document["power"]);
    let orders = rows(&place.text("lm.csv"));
    assert_eq!(orders[0], ["l", "m", "power", "stderr"][..]);
    // (2l + 1) P(l) = P(l, 0) + 2 sum over m >= 1 of P(l, m).
    for (l, power) in power.iter().enumerate() {
        let of_degree = orders[1..].iter().filter(|r| r[0].parse() == Ok(l));
        let sum: f64 = of_degree
            .map(|r| r[2].parse::<f64>().unwrap() * if &r[1] == "0" { 1.0 } else { 2.0 })
            .sum();
        let expected = (2 * l + 1) as f64 * power;
        assert!((sum - expected).abs() < 1e-12 * expected, "degree {l}: {sum}, not {expected}");
    }
    let samples = rows(&place.text("a.csv"));
    assert_eq!(samples[0], ["re", "im"][..]);
    assert_eq!(samples.len(), 1 + 6, "one for each realization");
    let mean = samples[1..]
        .iter()
        .map(|r| r[0].parse::<f64>().unwrap().powi(2) + r[1].parse::<f64>().unwrap().powi(2));
    let mean = mean.sum::<f64>() / 6.0 * 4.0 * std::f64::consts::PI / 48.0;
    let order = orders.iter().find(|r| &r[0] == "3" && &r[1] == "2").unwrap();
    let listed: f64 = order[2].parse().unwrap();
    assert!((mean - listed).abs() < 1e-12 * listed, "{mean}, {listed}");
}

#[test]
fn variance() {
    let place = Workplace::new();
    let arguments = "variance jittered,healpix -n 12,48 --integrand ylm:l=4,m=1 -m 20";
    let document = place.run(&format!("{arguments} --json")).json();
    let list = document["rows"].as_array().unwrap();
    let names: Vec<_> =
        list.iter().map(|r| (r["sampler"].as_str().unwrap(), r["n"].as_u64().unwrap())).collect();
    assert_eq!(names, [("jittered", 12), ("jittered", 48), ("healpix", 12), ("healpix", 48)]);
    for row in list {
        assert_keys(
            row,
            &[
                "sampler",
                "integrand",
                "n",
                "predicted",
                "predicted_stderr",
                "measured",
                "measured_stderr",
                "mean",
                "mean_stderr",
                "exact",
            ],
        );
        assert_eq!(row["integrand"], "ylm:l=4,m=1");
        assert_eq!(row["exact"], 0.0);
        for key in ["predicted", "measured", "measured_stderr", "mean_stderr"] {
            assert!(row[key].as_f64().unwrap() > 0.0, "{key}: {row}");
        }
        // 20 trials: a mean that differs by six standard errors is not due to chance.
        let (mean, error) = (row["mean"].as_f64().unwrap(), row["mean_stderr"].as_f64().unwrap());
        assert!(mean.abs() < 6.0 * error, "{row}");
    }
    place.run(&format!("{arguments} -o v.csv")).ok();
    let table = rows(&place.text("v.csv"));
    assert_eq!(table.len(), 5);
    let column = table[0].iter().position(|name| name == "measured").unwrap();
    for (row, json) in table[1..].iter().zip(list) {
        let measured = json["measured"].as_f64().unwrap();
        assert!(same(row[column].parse().unwrap(), measured), "{row:?}, {json}");
        assert_eq!(&row[1], "ylm:l=4,m=1", "a comma within a cell is quoted");
    }
}

#[test]
fn eval() {
    let place = Workplace::new();
    let value = place.run("eval legendre --l 3 --m 2 --theta 1 --json").json();
    assert_keys(&value, &["value"]);
    // sqrt(105/(32 pi)) sin^2 cos of 1 rad.
    let (sin, cos) = 1.0_f64.sin_cos();
    let expected = (105.0 / (32.0 * std::f64::consts::PI)).sqrt() * sin * sin * cos;
    let got = value["value"].as_f64().unwrap();
    assert!((got - expected).abs() < 8.0 * f64::EPSILON, "{got}, {expected}");

    let y = place.run("eval ylm --l 3 --m 2 --theta 1 --phi 0.5 --json").json();
    assert_keys(&y, &["re", "im"]);
    let (re, im) = (y["re"].as_f64().unwrap(), y["im"].as_f64().unwrap());
    assert!((re - expected * 1.0_f64.cos()).abs() < 8.0 * f64::EPSILON, "{y}");
    assert!((im - expected * 1.0_f64.sin()).abs() < 8.0 * f64::EPSILON, "{y}");

    let cap = place.run("eval cap-power --degrees 60 --lmax 5 --json").json();
    assert_eq!(numbers(&cap["l"]), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(numbers(&cap["energy"]).len(), 6);

    // min(gamma (omega/alpha)^2, gamma), omega = l/10.
    let profile = place
        .run("eval profile --profile poly:b=2,alpha=0.5,gamma=2 -n 100 --lmax 7 --json")
        .json();
    let power = numbers(&profile["power"]);
    for (l, got) in power.iter().enumerate() {
        let expected = 2.0 * (l as f64 / 10.0 / 0.5).powi(2).min(1.0);
        assert!((got - expected).abs() < 8.0 * f64::EPSILON, "degree {l}: {got}, {expected}");
    }
    assert_eq!(numbers(&profile["l"]).len(), power.len());
}

#[test]
fn bounds() {
    let place = Workplace::new();
    let alone = place.run("bounds --profile poly:b=2 -n 1024 --json").json();
    let record = &alone["bounds"][0];
    assert_keys(
        record,
        &["best_rate", "worst_rate", "best_variance", "worst_variance", "alpha", "gamma"],
    );
    assert_eq!((&record["best_rate"], &record["worst_rate"]), (&"N^-2".into(), &"N^-1.5".into()));

    let fitted = place
        .run("bounds jittered -n 48 -m 30 --profile poly:b=2 --integrand ylm:l=2 --json")
        .json();
    let sides: Vec<_> = fitted["bounds"].as_array().unwrap().iter().collect();
    assert_eq!((&sides[0]["side"], &sides[1]["side"]), (&"upper".into(), &"lower".into()));
    assert!(sides.iter().all(|s| s["holds"] == true), "a fitted bound holds: {fitted}");
    assert!(sides[0]["gamma"].as_f64() > sides[1]["gamma"].as_f64(), "{fitted}");

    // The same from a spectrum file, also from standard input.
    place.run("spectrum jittered -n 48 -m 30 -o s.csv").ok();
    let file = place.run("bounds --spectrum s.csv -n 48 --profile poly:b=2 --json").json();
    let piped = place
        .run_on("bounds --spectrum - -n 48 --profile poly:b=2 --json", &place.text("s.csv"))
        .json();
    for side in [0, 1] {
        assert_eq!(file["bounds"][side]["gamma"], fitted["bounds"][side]["gamma"]);
        assert_eq!(piped["bounds"][side]["gamma"], fitted["bounds"][side]["gamma"]);
    }
}

/// Without a profile, every family is fitted; the statements of the thesis on the sampler are
/// checked.
#[test]
fn bounds_without_a_profile() {
    let place = Workplace::new();
    let document = place.run("bounds jittered -n 192 -m 40 --integrand ylm:l=2 --json").json();
    assert_keys(&document, &["n", "lmax", "confidence", "bounds", "none", "thesis"]);
    let list = document["bounds"].as_array().unwrap();
    let names: Vec<_> =
        list.iter().map(|r| (r["side"].as_str().unwrap(), r["family"].as_str().unwrap())).collect();
    let upper = ["constant", "linear", "quadratic", "poly"].map(|f| ("upper", f));
    let lower = ["constant", "step", "linear", "quadratic", "poly"].map(|f| ("lower", f));
    assert_eq!(names, [&upper[..], &lower[..]].concat());
    // Jitter has power at l = 1.
    assert_eq!(document["none"][0]["family"], "step");
    assert!(document["none"][0]["reason"].as_str().unwrap().contains("degree 1"), "{document}");
    for record in list {
        assert_keys(
            record,
            &["exponent", "alpha", "gamma", "offset", "touching", "gap", "best_rate"],
        );
        assert_eq!((&record["holds"], &record["origin"]), (&true.into(), &"fitted".into()));
        assert!(!numbers(&record["touching"]).is_empty(), "{record}");
        assert!(record["gap"].as_f64().unwrap() <= 1e-4, "{record}");
    }
    let variance = |i: usize| list[i]["worst_variance"].as_f64().unwrap();
    assert!((0..3).all(|i| variance(3) <= variance(i)), "poly is the least upper: {document}");
    assert!((0..4).all(|i| variance(i) > variance(8)), "upper above lower: {document}");
    let verdicts: Vec<_> = document["thesis"].as_array().unwrap().iter().collect();
    assert_eq!((&verdicts[0]["side"], &verdicts[1]["side"]), (&"upper".into(), &"lower".into()));
    for verdict in verdicts {
        assert_keys(
            verdict,
            &["verdict", "worst_degree", "worst_omega", "worst_ratio", "z", "critical_z"],
        );
        assert_ne!(verdict["verdict"], "broken", "{verdict}");
    }
    // A file with degree 0 determines the number of points.
    place.run("spectrum jittered -n 192 -m 40 -o s.csv").ok();
    let file = place.run("bounds --spectrum s.csv --json").json();
    assert_eq!(file["n"], 192);
    assert_eq!(file["bounds"][3]["alpha"], list[3]["alpha"]);
    place.write("bare.csv", "l,power\n1,0.5\n2,0.6\n");
    place.run("bounds --spectrum bare.csv").fails(2, &["bare.csv", "-n N", "degree 0"]);
    // Tables, plots, and an offset.
    let table = place.run("bounds --spectrum s.csv --offset fit").ok().stdout;
    assert!(table.contains("quadratic") && table.contains("Confidence 0.99"), "{table}");
    place.run("bounds --spectrum s.csv --offset 0.001 -o b.csv").ok();
    let cells = rows(&place.text("b.csv"));
    assert!(cells.len() > 5 && cells.iter().all(|r| r.len() == cells[0].len()), "{cells:?}");
    place.run("bounds --spectrum s.csv -o b.svg").ok();
    let plot = place.text("b.svg");
    assert!(plot.contains("upper quadratic") && plot.contains("lower step"), "the legend");
    place.run("bounds --profile step -n 100 -o p.png").ok();
    place.run("bounds --spectrum s.csv --offset -1").fails(2, &["--offset"]);
    place.run("bounds --spectrum s.csv --offset x").fails(2, &["--offset", "fit", "\"x\""]);
    place.run("bounds -n 12").fails(2, &["--profile"]);
    place.run("bounds jittered").fails(2, &["--count"]);
}

#[test]
fn healpix_round_trip() {
    let place = Workplace::new();
    let pixels: Vec<String> = (0..48).map(|i| i.to_string()).collect();
    place.write("pixels.csv", format!("pixel\n{}\n", pixels.join("\n")));
    for (there, back) in
        [("pix2vec", "vec2pix"), ("pix2ang", "ang2pix"), ("ring2nest", "nest2ring")]
    {
        place.run(&format!("healpix {there} --nside 2 pixels.csv -o there.csv")).ok();
        place.run(&format!("healpix {back} --nside 2 there.csv -o back.csv")).ok();
        assert_ne!(place.text("there.csv"), place.text("pixels.csv"), "{there}");
        let returned: Vec<String> =
            rows(&place.text("back.csv"))[1..].iter().map(|r| r[0].to_owned()).collect();
        assert_eq!(returned, pixels, "{there} and {back}");
    }
}

/// The document replaces a result for standard output: `--json` prints exactly one document.
#[test]
fn json_is_alone_on_standard_output() {
    let place = Workplace::new();
    for arguments in [
        "sample fibonacci -n 5 -o -",
        "spectrum fibonacci -n 5 --lmax 3 -o -",
        "variance fibonacci -n 5 --integrand ylm:l=2 -m 4 -o -",
        "bounds --profile step -n 5 -o -",
        "compare fibonacci -n 5 --integrand ylm:l=2 -m 4 -o out",
        "list samplers",
    ] {
        let document = place.run(&format!("{arguments} --json")).json();
        assert!(document.is_object() || document.is_array(), "{arguments}: {document}");
    }
    place.write("pixels.csv", "0\n1\n");
    place.run("healpix pix2ang --nside 1 pixels.csv --json").json();
}

/// The same output without `--json` and with `-` is a table on standard output and nothing else.
#[test]
fn dash_is_csv_on_standard_output() {
    let place = Workplace::new();
    for (arguments, heading) in [
        ("spectrum fibonacci -n 5 --lmax 3 -o -", "l,omega,power,stderr,realizations"),
        ("variance fibonacci -n 5 --integrand ylm:l=2 -m 4 -o -", "sampler,integrand,"),
        ("bounds --profile step -n 5 -o -", "side,origin,"),
    ] {
        let outcome = place.run(arguments).ok();
        let mut lines = outcome.stdout.lines();
        assert!(lines.next().unwrap().starts_with("# sphvar "), "{}", outcome.stdout);
        assert!(lines.next().unwrap().starts_with(heading), "{}", outcome.stdout);
        let width = rows(&outcome.stdout)[0].len();
        assert!(rows(&outcome.stdout).iter().all(|r| r.len() == width), "{}", outcome.stdout);
    }
    assert!(place.names().is_empty(), "{:?}", place.names());
}

/// A flat spectrum touches its bound at every degree: the table shows a few, the file all.
#[test]
fn long_lists_of_degrees_stay_out_of_tables() {
    let place = Workplace::new();
    let rows: String = (1..=64).map(|l| format!("{l},1\n")).collect();
    place.write("flat.csv", format!("l,power\n{rows}"));
    let table = place.run("bounds --spectrum flat.csv -n 256").ok().stdout;
    assert!(table.contains("1 2 3 4 ... (64 in all)"), "{table}");
    assert!(table.lines().all(|line| line.len() < 160), "{table}");
    place.run("bounds --spectrum flat.csv -n 256 -o bounds.csv").ok();
    assert!(place.text("bounds.csv").contains("61 62 63 64"));
}
