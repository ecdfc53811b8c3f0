use rand::{Rng, RngExt};
use sphvar_grammar::Parametric;

use crate::definition::Definition;
use crate::{
    CostOrder, Error, PatternFacts, PointSet, Rate, Square, SquareDistribution, SquareSampler,
    ValidCounts, count,
};

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

impl SquareSampler for JitteredSquare {
    fn n_points(&self) -> usize {
        self.rows as usize * self.columns as usize
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        SquareDistribution::Jittered { rows: self.rows as usize, columns: self.columns as usize }
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        let points = set.start();
        for row in 0..self.rows {
            points.extend((0..self.columns).map(|column| {
                let [u, v]: [f64; 2] = rng.random();
                [within(row, self.rows, u), within(column, self.columns, v)]
            }));
        }
        Ok(())
    }
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition<Square> for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "pi^2 |k|^2/(3 N)",
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Singh 2015",
        }
    }

    fn valid_counts(&self, _: Square) -> ValidCounts {
        ValidCounts::Squares { unit: 1, root: "k" }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(JitteredSquare::nearest_to_square(n_points)?))
    }
}

/// Returns `(index + x)/n`, which must not round to 1.
pub(super) fn within(index: u32, n: u32, x: f64) -> f64 {
    ((f64::from(index) + x) / f64::from(n)).min(1.0 - f64::EPSILON / 2.0)
}
