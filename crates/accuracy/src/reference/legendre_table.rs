use super::DoubleDouble;

const TABLE: &str = include_str!("../../data/associated_legendre.csv");

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct LegendreRow {
    /// The degree.
    pub l: usize,
    /// The order.
    pub m: usize,
    /// The colatitude, radians.
    pub theta: f64,
    /// The orthonormal associated Legendre function with the Condon-Shortley phase.
    pub value: DoubleDouble,
}

/// A table of 263 values of associated Legendre functions with 25 digits, computed with many more.
///
/// Degrees up to 20000, colatitudes from 1e-300 to 5.4e-8 from the south pole, values down to about
/// `1e-306477`.
#[derive(Clone, Copy, Debug)]
pub struct LegendreTable;

impl LegendreTable {
    /// Returns the rows in the order of the file.
    pub fn rows() -> impl Iterator<Item = LegendreRow> {
        TABLE.lines().filter_map(|line| {
            let mut fields = line.split(',');
            let mut field = || fields.next();
            Some(LegendreRow {
                l: field()?.parse().ok()?,
                m: field()?.parse().ok()?,
                theta: field()?.parse().ok()?,
                value: DoubleDouble::parse(field()?)?,
            })
        })
    }
}
