//! The lengths of vectors that should be unit vectors.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::ReadOptions;
use crate::files::file_error::{FileError, Place};

/// A length that differs from 1 by more than this causes a warning.
const TOLERANCE: f64 = 1e-6;
/// A length that differs from 1 by more than this is not a rounding effect.
const FAR: f64 = 1e-2;
/// Vectors this close to unit length are unchanged: normalization in `f64` leaves an error of at
/// most about three roundings, so vectors that this program wrote are read back bit-identically.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Statistics of the lengths of the vectors of a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Lengths {
    /// The number of lengths that differ from 1 by more than [`TOLERANCE`].
    rescaled: usize,
    /// The number of lengths that differ from 1 by more than [`FAR`].
    far: usize,
    worst: Option<(f64, Place)>,
    /// The largest magnitude of each coordinate.
    sizes: [f64; 3],
    /// The smallest first coordinate.
    min_x: f64,
}

impl Lengths {
    /// Returns a vector scaled to unit length, or `None` for the zero vector.
    pub(super) fn direction(&mut self, vector: DVec3, place: Place) -> Option<DVec3> {
        let size = vector.abs().max_element();
        if size == 0.0 {
            return None;
        }
        self.sizes = DVec3::from_array(self.sizes).max(vector.abs()).to_array();
        self.min_x = self.min_x.min(vector.x);
        // Scaled first, which keeps the squares of tiny and huge vectors in range.
        let scaled = vector / size;
        let length = size * scaled.length();
        let off = (length - 1.0).abs();
        if off <= ROUNDING {
            return Some(vector);
        }
        if off > TOLERANCE {
            self.rescaled += 1;
            self.far += usize::from(off > FAR);
            self.compare(length, place);
        }
        Some(scaled.normalize())
    }

    /// Takes a length as the worst if it is.
    fn compare(&mut self, length: f64, place: Place) {
        // Distances from 1 are ratios, so that 0.01 counts as worse than 2.
        let badness = length.ln().abs();
        if self.worst.is_none_or(|(other, _)| badness > other.ln().abs()) {
            self.worst = Some((length, place));
        }
    }

    /// Adds the statistics of later vectors.
    pub(super) fn append(&mut self, later: &Self) {
        self.rescaled = self.rescaled.saturating_add(later.rescaled);
        self.far = self.far.saturating_add(later.far);
        if let Some((length, place)) = later.worst {
            self.compare(length, place);
        }
        for (size, other) in self.sizes.iter_mut().zip(later.sizes) {
            *size = size.max(other);
        }
        self.min_x = self.min_x.min(later.min_x);
    }

    /// Returns a warning about lengths other than 1, if there are any and the user did not allow
    /// them.
    ///
    /// # Errors
    ///
    /// If most of `total` vectors are far from unit length, unless the user allowed it.
    pub(super) fn verdict(
        &self,
        path: &str,
        total: usize,
        options: &ReadOptions,
    ) -> Result<Option<String>, FileError> {
        let Some((length, place)) = self.worst.filter(|_| !options.normalize) else {
            return Ok(None);
        };
        // Seven digits, without an exponent where it is not needed.
        let length = format!("{length:.6e}").parse().unwrap_or(length);
        let furthest = format!("largest deviation: {path}{place}, length {length:?}");
        if self.far > total / 2 {
            return Err(FileError::Layout {
                path: path.to_owned(),
                place: Place::Whole,
                expected: format!("unit vectors x,y,z ({})", self.advice(options)),
                got: format!("{} of {total} with other lengths ({furthest})", self.far),
            });
        }
        Ok(Some(format!(
            "{path}: {} of {total} vectors did not have unit length and were normalized \
             ({furthest})",
            self.rescaled
        )))
    }

    /// Returns advice on the probable meaning of the columns.
    fn advice(&self, options: &ReadOptions) -> String {
        let spelling = options.spelling;
        let normalize = spelling.on("normalize");
        let [x, y, _] = self.sizes;
        let pi = std::f64::consts::PI;
        if x <= pi && self.min_x >= 0.0 && y <= 2.0 * pi && y > 1.1 {
            let columns =
                spelling.columns(if options.values { "theta,phi,_,value" } else { "theta,phi,_" });
            format!("these look like angles in radians: {columns}; {normalize} scales vectors")
        } else if x > 2.0 && x <= 360.0 && y <= 90.0 {
            let columns = match options.values {
                true => spelling.columns("ra,dec,_,value"),
                false => ["ra,dec,_", "ra,dec,w"].map(|value| spelling.columns(value)).join(" or "),
            };
            format!("these look like degrees: {columns}; {normalize} scales vectors")
        } else {
            format!("{normalize} scales vectors of any length")
        }
    }
}
