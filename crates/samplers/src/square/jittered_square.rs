use rand::{Rng, RngExt};

use crate::{Error, SquarePattern, count};

/// One uniform point in each rectangle of a grid on the square: stratified sampling with
/// N = rows x columns.
#[derive(Clone, Copy, Debug)]
pub struct JitteredSquare {
    rows: u32,
    columns: u32,
}

impl JitteredSquare {
    /// Returns the grid of `rows` strips in u, each divided into `columns` in v.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless the product is from 1 to `u32::MAX`.
    pub fn new(rows: usize, columns: usize) -> Result<Self, Error> {
        count::checked(rows.saturating_mul(columns))?;
        Ok(Self { rows: count::checked(rows)?, columns: count::checked(columns)? })
    }

    /// Returns the grid of `n_points` whose side counts are closest to each other, with at least as
    /// many columns as rows: a square grid for a square number, one row for a prime.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn nearest_to_square(n_points: usize) -> Result<Self, Error> {
        let n = count::checked(n_points)?;
        let rows = (1..=n.isqrt()).rev().find(|&rows| n.is_multiple_of(rows)).unwrap_or(1);
        Ok(Self { rows, columns: n / rows })
    }
}

impl SquarePattern for JitteredSquare {
    fn n_points(&self) -> usize {
        self.rows as usize * self.columns as usize
    }

    fn is_random(&self) -> bool {
        true
    }

    fn fill_into(&self, rng: &mut dyn Rng, points: &mut Vec<[f64; 2]>) -> Result<(), Error> {
        points.clear();
        for row in 0..self.rows {
            points.extend((0..self.columns).map(|column| {
                let [u, v]: [f64; 2] = rng.random();
                [within(row, self.rows, u), within(column, self.columns, v)]
            }));
        }
        Ok(())
    }
}

/// Returns `(index + x)/n`, which must not round to 1.
fn within(index: u32, n: u32, x: f64) -> f64 {
    ((f64::from(index) + x) / f64::from(n)).min(1.0 - f64::EPSILON / 2.0)
}
