//! Prints how far the associated Legendre functions are from the 25-digit reference table.
//!
//! `cargo run -p sphvar-sh --example accuracy`. Errors are in units of what the crate promises, `4 EPSILON (l + 1)`
//! times the local amplitude (relative to the value itself in the evanescent region); at most 1 is right.

#[path = "../tests/legendre/double_double.rs"]
#[expect(dead_code, reason = "the oracle of the tests uses the rest")]
mod double_double;
#[path = "../tests/legendre/reference.rs"]
mod reference;

use std::io::Write;

use reference::{Region, compare_table};

fn main() -> std::io::Result<()> {
    let rows = compare_table();
    let mut out = std::io::stdout().lock();
    writeln!(out, "{:<12} {:>5} {:>14}   worst row", "region", "rows", "worst / bound")?;
    for region in Region::ALL {
        let here: Vec<_> = rows.iter().filter(|row| row.region == region).collect();
        if let Some(worst) = here.iter().max_by(|a, b| a.of_promise.total_cmp(&b.of_promise)) {
            let (name, count) = (format!("{region:?}").to_lowercase(), here.len());
            writeln!(out, "{name:<12} {count:>5} {:>14.4}   {worst}", worst.of_promise)?;
        }
    }
    Ok(())
}
