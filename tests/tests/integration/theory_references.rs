//! `docs/theory.md` names the test of each formula: every name that it gives exists.

use std::fs;
use std::path::Path;

const ROWS: usize = 44;

#[test]
fn every_test_named_in_the_theory_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let theory = fs::read_to_string(root.join("docs/theory.md")).unwrap();
    let mut count = 0;
    for reference in theory.split('`').filter(|part| part.contains(".rs::")) {
        let (file, name) = reference.split_once("::").unwrap();
        let source = fs::read_to_string(root.join(file))
            .unwrap_or_else(|e| panic!("docs/theory.md names {reference}: {e}"));
        let function = format!("fn {name}(");
        let at = source.find(&function);
        let at = at.unwrap_or_else(|| panic!("docs/theory.md names {reference}: no {function}"));
        // An attribute of a test, or a function within proptest's macro, precedes it.
        let before = source[..at].rsplit("\n\n").next().unwrap_or_default();
        assert!(
            before.contains("#[test]"),
            "docs/theory.md names {reference}, which is not a test"
        );
        count += 1;
    }
    assert!(count > ROWS, "only {count} tests are named");
}

/// The table of errata is complete: rows 1 to 44 in order.
#[test]
fn every_erratum_has_its_row() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/theory.md");
    let theory = fs::read_to_string(path).unwrap();
    let errata = theory.split("## Errata").nth(1).unwrap();
    let rows: Vec<usize> = errata
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.split(' ').next()?.parse().ok())
        .collect();
    assert_eq!(rows, (1..=ROWS).collect::<Vec<_>>());
}
