//! The output and the files of `sphvar compare`.

use crate::outcome::{assert_keys, same};
use crate::workplace::{Workplace, small_exr};

const FILES: [&str; 9] = [
    "comparison.csv",
    "comparison.json",
    "integrand.png",
    "integrand.svg",
    "spectra.csv",
    "spectra.png",
    "spectra.svg",
    "variance.png",
    "variance.svg",
];

/// Asserts that the bytes are a complete PNG or a well-formed SVG, according to the name.
pub(crate) fn assert_picture(name: &str, bytes: &[u8]) {
    if name.ends_with(".png") {
        assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"), "{name}");
        let picture =
            image::load_from_memory(bytes).unwrap_or_else(|e| panic!("{name}: {e}")).to_rgb8();
        let first = picture.get_pixel(0, 0);
        assert!(picture.pixels().any(|p| p != first), "{name} is empty");
        return;
    }
    let text = std::str::from_utf8(bytes).unwrap();
    assert!(
        text.trim_start().starts_with("<svg") || text.trim_start().starts_with("<?xml"),
        "{name}"
    );
    assert!(text.trim_end().ends_with("</svg>"), "{name}");
    assert!(text.contains("<text"), "{name} has no words");
    assert_balanced(name, text);
}

/// Asserts that elements are properly nested and every `&` starts an entity.
fn assert_balanced(name: &str, text: &str) {
    let mut open: Vec<&str> = Vec::new();
    for piece in text.split('<').skip(1) {
        let (tag, content) = piece.split_once('>').unwrap_or_else(|| panic!("{name}: <{piece}"));
        if let Some(closed) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(closed), "{name}: </{closed}>");
        } else if !tag.ends_with('/') && !tag.starts_with(['?', '!']) {
            open.push(tag.split_whitespace().next().unwrap());
        }
        for entity in content.split('&').skip(1) {
            let word = entity.split(';').next().unwrap();
            let known =
                ["amp", "lt", "gt", "quot", "apos"].contains(&word) || word.starts_with('#');
            assert!(known, "{name}: a bare & in {content}");
        }
    }
    assert!(open.is_empty(), "{name}: {open:?} stay open");
}

#[test]
fn every_file_is_whole() {
    let place = Workplace::new();
    // A name with characters that XML must escape.
    place.write("a&b<c.exr", small_exr(16, 8));
    let arguments =
        "compare white-noise,jittered,fibonacci -n 12,50 --integrand env:a&b<c.exr -m 20 -o out";
    let outcome = place.run(arguments).ok();
    assert_eq!(place.names_in("out"), FILES);
    for name in FILES {
        let bytes = place.bytes(&format!("out/{name}"));
        assert!(!bytes.is_empty(), "{name}");
        if name.ends_with(".svg") || name.ends_with(".png") {
            assert_picture(name, &bytes);
        }
    }
    // The requested and the actual N are shown side by side.
    for part in
        ["white-noise", "jittered", "fibonacci", "N requested", "predicted", "measured", "rate"]
    {
        assert!(outcome.stdout.contains(part), "{part}: {}", outcome.stdout);
    }
    let jittered: Vec<&str> =
        outcome.stdout.lines().filter(|l| l.starts_with("jittered")).collect();
    let words: Vec<&str> = jittered[1].split_whitespace().collect();
    assert_eq!(words[1..3], ["50", "48"], "{jittered:?}");
}

#[test]
fn json_and_files_agree() {
    let place = Workplace::new();
    let document =
        place.run("compare jittered,fibonacci -n 12,48,108 --integrand cap:degrees=60 -m 30 --json -o out").json();
    let file: serde_json::Value = serde_json::from_str(&place.text("out/comparison.json")).unwrap();
    assert_eq!(file, document);
    let rows = document["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 6);
    assert_keys(
        &rows[0],
        &[
            "sampler",
            "integrand",
            "n_requested",
            "n",
            "predicted",
            "predicted_stderr",
            "measured",
            "measured_stderr",
            "ratio",
            "ratio_stderr",
            "mean",
            "mean_stderr",
            "exact",
        ],
    );
    let samplers = document["samplers"].as_array().unwrap();
    assert_eq!(samplers.len(), 2);
    for summary in samplers {
        assert_keys(summary, &["sampler", "rate", "rate_interval", "predicted_rate"]);
        let (rate, low, high) = (
            summary["rate"].as_f64().unwrap(),
            summary["rate_interval"][0].as_f64().unwrap(),
            summary["rate_interval"][1].as_f64().unwrap(),
        );
        assert!(low < rate && rate < high, "{summary}");
        // Both patterns converge faster than white noise on a disk, even in 30 trials.
        assert!(rate < -1.0, "{summary}");
    }
    assert!(document["crossovers"].is_array());
    assert!(
        document["provenance"]["command"].as_str().unwrap().starts_with("sphvar compare jittered")
    );

    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(place.path("out/comparison.csv"))
        .unwrap();
    let heading = reader.headers().unwrap().clone();
    let column = |name| heading.iter().position(|h| h == name).unwrap();
    let records: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(records.len(), rows.len());
    for (record, row) in records.iter().zip(rows) {
        for key in ["predicted", "measured", "measured_stderr", "exact"] {
            let (cell, number) = (record[column(key)].parse().unwrap(), row[key].as_f64().unwrap());
            assert!(same(cell, number), "{key}: {cell}, {number}");
        }
    }
    let spectra = place.text("out/spectra.csv");
    assert!(spectra.lines().nth(1) == Some("sampler,n,l,omega,power,stderr"), "{spectra:.200}");
    let degrees = spectra.lines().filter(|l| l.starts_with("jittered,108,")).count();
    assert!(degrees > 40, "the spectrum goes to 4 sqrt(N): {degrees} degrees");
}

#[test]
fn a_pattern_named_twice_and_equal_numbers_are_one() {
    let place = Workplace::new();
    // Both 12 and 13 give 12 points of a jittered pattern.
    let document = place
        .run("compare jittered,jittered -n 12,13,12 --integrand ylm:l=1 -m 4 --json -o out")
        .json();
    assert_eq!(document["rows"].as_array().unwrap().len(), 1, "{document}");
    assert_eq!(document["samplers"].as_array().unwrap().len(), 1, "{document}");
}

#[test]
fn a_folder_is_made_and_used_again() {
    let place = Workplace::new();
    let arguments = "compare fibonacci -n 12 --integrand cosine --hemisphere -m 4 -o deep/er";
    let outcome = place.run(arguments).ok();
    assert!(outcome.stderr.contains("deep/er"), "{}", outcome.stderr);
    assert_eq!(place.names_in("deep/er"), FILES);
    let quiet = place.run(&format!("{arguments} --quiet")).ok();
    assert_eq!(quiet.stderr, "");
    assert_eq!(place.names_in("deep/er"), FILES);
}
