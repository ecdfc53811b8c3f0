//! Accuracy of the associated Legendre functions against values with more digits.

mod oracle;
mod reference;

use reference::{Region, compare_table};

#[test]
fn every_row_of_the_reference_table() {
    let rows = compare_table();
    assert_eq!(rows.len(), 263, "the table is complete");
    for region in Region::ALL {
        assert!(rows.iter().any(|row| row.region == region), "no row is {region:?}");
    }
    for row in rows {
        // Written so that NaN fails.
        assert!(row.of_bound <= 1.0, "{row}");
    }
}
