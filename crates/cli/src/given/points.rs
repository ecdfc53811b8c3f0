//! Points that are given as arrays.

/// Points as rows of numbers, in one set or in sets of equal size.
///
/// They are read as the file with these columns is: not normalized, not checked.
#[derive(Clone, Debug, Default)]
pub struct PointTable {
    /// The coordinates, row by row: x, y, z of a direction, or u, v on the unit square.
    pub coordinates: Vec<f64>,
    /// The number of coordinates of a point: 3, or 2 on the unit square.
    pub dimension: usize,
    /// The number of sets, if the array has a dimension for them.
    pub sets: Option<usize>,
    /// The weight of each point, if they have weights.
    pub weights: Option<Vec<f64>>,
    /// The value at each point, for fits.
    pub values: Option<Vec<f64>>,
    /// The standard error of each value, for fits; excludes weights.
    pub errors: Option<Vec<f64>>,
}

impl PointTable {
    /// Returns the number of points of all sets.
    #[must_use]
    pub fn len(&self) -> usize {
        self.coordinates.len() / self.dimension.max(1)
    }

    /// Returns whether there are no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.coordinates.is_empty()
    }

    /// Returns an error if the numbers are not those of whole points in sets of equal size.
    pub(crate) fn check(&self, name: &str) -> Result<(), String> {
        let (n, count) = (self.len(), self.coordinates.len());
        if !matches!(self.dimension, 2 | 3) || !count.is_multiple_of(self.dimension) {
            return Err(format!("{name}: expected points of 3 coordinates, or of 2 on the square"));
        }
        if let Some(sets) = self.sets
            && (sets == 0 || !n.is_multiple_of(sets))
        {
            return Err(format!(
                "{name}: expected sets of equal size, got {n} points in {sets} sets"
            ));
        }
        let columns =
            [("weights", &self.weights), ("values", &self.values), ("errors", &self.errors)];
        for (column, numbers) in columns {
            if let Some(numbers) = numbers
                && numbers.len() != n
            {
                let got = numbers.len();
                return Err(format!(
                    "{name}: expected one of the {column} for each of {n} points, got {got}"
                ));
            }
        }
        Ok(())
    }
}
