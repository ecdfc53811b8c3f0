//! The subcommand `accuracy`.

use crate::outcome::assert_keys;
use crate::workplace::Workplace;

const DOCUMENT: [&str; 8] =
    ["held", "quick", "date", "version", "machine", "trials", "hard_cases", "provenance"];
const TRIAL: [&str; 13] = [
    "area",
    "method",
    "case",
    "unit",
    "count",
    "seconds_per_unit",
    "error",
    "rms",
    "worst",
    "compared",
    "bound",
    "held",
    "relative_to",
];
const HARD_CASES: [&str; 5] = [
    "directions_at_the_poles_at_the_largest_nside",
    "directions_at_the_seams_at_the_largest_nside",
    "directions_at_the_borders_of_the_caps_at_the_largest_nside",
    "centres_at_the_largest_nside",
    "numbers_of_both_orders_at_the_largest_nside",
];

#[test]
fn indexing_holds_its_bounds_and_writes_every_form() {
    let place = Workplace::new();
    std::fs::create_dir_all(place.path("docs/images")).unwrap();
    let arguments = "accuracy indexing --quick --json -o docs/accuracy.md --plot docs/images";
    let document = place.run(arguments).json();
    assert_keys(&document, &DOCUMENT);
    assert_eq!(document["held"], true);
    assert_eq!(document["version"], env!("CARGO_PKG_VERSION"));
    let date = document["date"].as_str().unwrap();
    assert!(date.len() == 10 && date > "2024-01-01", "{date}");
    assert_keys(&document["machine"], &["cpu", "cores", "threads"]);

    let trials = document["trials"].as_array().unwrap();
    assert!(trials.len() > 10, "{}", trials.len());
    for trial in trials {
        assert_keys(trial, &TRIAL);
        assert_eq!((&trial["area"], &trial["held"]), (&"indexing".into(), &true.into()));
        let number = |key: &str| trial[key].as_f64().unwrap();
        assert!(number("error") <= number("bound"), "{trial}");
        assert!(number("rms") <= number("error"), "{trial}");
        assert!(number("seconds_per_unit") > 0.0 && number("compared") > 0.0, "{trial}");
    }
    let cases = document["hard_cases"].as_array().unwrap();
    let names: Vec<&str> = cases.iter().map(|case| case["name"].as_str().unwrap()).collect();
    assert_eq!(names, HARD_CASES);
    assert!(cases.iter().all(|case| case["held"] == true), "{cases:?}");

    let markdown = place.text("docs/accuracy.md");
    for part in [
        "# Accuracy\n",
        "sphvar accuracy indexing --quick",
        date,
        "## Indexing\n",
        "](images/accuracy-indexing.svg)",
        "## Hard cases\n",
        "`numbers_of_both_orders_at_the_largest_nside`",
        "bounds hold.\n",
    ] {
        assert!(markdown.contains(part), "{part:?} is missing:\n{markdown}");
    }
    // Every row of a table has the same number of cells as its heading.
    for table in markdown.split("\n\n").filter(|block| block.starts_with('|')) {
        let cells: Vec<usize> = table.lines().map(|line| line.matches('|').count()).collect();
        assert!(cells.iter().all(|&count| count == cells[0]), "{table}");
    }
    assert_eq!(place.names_in("docs/images"), ["accuracy-indexing.svg"]);
    let chart = place.text("docs/images/accuracy-indexing.svg");
    for part in ["<svg", "ring, pixel", "nested, centre", "Not shown, because the error is 0"] {
        assert!(chart.contains(part), "{part:?} is missing in the chart");
    }
}

#[test]
#[ignore = "slow"]
fn tables_and_files() {
    let place = Workplace::new();
    let text = place.run("accuracy indexing --quick -o a.csv --plot a.svg").ok().stdout;
    for part in [
        "indexing: errors relative to",
        "largest error",
        "nside = 536870912",
        "centres at the largest nside",
    ] {
        assert!(text.contains(part), "{part:?} is missing:\n{text}");
    }
    let csv = place.text("a.csv");
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(csv.as_bytes());
    assert_eq!(reader.headers().unwrap().get(0), Some("kind"));
    let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.iter().filter(|row| &row[0] == "hard case").count(), HARD_CASES.len());
    assert!(rows.iter().any(|row| &row[0] == "trial" && &row[2] == "ring, pixel"), "{csv}");
    assert_eq!(place.names(), ["a.csv", "a.svg"]);
    place.run("accuracy indexing --quick -o b.png").ok();
    assert!(place.names().contains(&"b.png".to_owned()));
}

#[test]
fn invalid_command_lines() {
    let place = Workplace::new();
    let cases: [(&str, i32, &[&str]); 6] = [
        (
            "accuracy poles",
            2,
            &["poles", "harmonics, indexing, transforms, spectra, predictions, quality, weights"],
        ),
        ("accuracy --quick --plot a.svg", 2, &["a.svg", "one area", "folder"]),
        ("accuracy --quick -o a.svg", 2, &["a.svg", "one area", "--plot"]),
        ("accuracy --quick -o a.txt", 2, &["a.txt", ".md, .json or .csv"]),
        ("accuracy indexing --plot none", 1, &["none"]),
        ("accuracy indexing -o none/a.md", 1, &["none"]),
    ];
    for (arguments, status, parts) in cases {
        place.run(arguments).fails(status, parts);
    }
    assert!(place.names().is_empty());
}
