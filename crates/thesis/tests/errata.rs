//! The errata cited by claims match `docs/theory.md` word for word.

use std::fs;
use std::path::Path;

use sphvar_thesis::Erratum;

#[test]
fn errata_are_those_of_the_list() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/theory.md");
    let theory = fs::read_to_string(path).unwrap();
    let numbers: Vec<u8> = Erratum::cited().map(|erratum| erratum.number).collect();
    assert!(numbers.is_sorted_by(|a, b| a < b), "{numbers:?}");
    for erratum in Erratum::cited() {
        let row = format!("\n| {} | {} | {} | ", erratum.number, erratum.place, erratum.problem);
        assert!(theory.contains(&row), "not in docs/theory.md: {row}");
        assert_eq!(Erratum::numbered(erratum.number), Some(erratum));
    }
    assert_eq!(Erratum::numbered(0), None);
}
