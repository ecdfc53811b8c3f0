//! Gathers points from a reader into sets, whatever the format.

use std::collections::HashMap;

use glam::DVec3;

use super::{PointFile, PointSet};
use crate::files::file_error::{FileError, Place};

/// A length that differs from 1 by more than this is worth a warning (`formats.md`, "Points").
const LENGTH_TOLERANCE: f64 = 1e-6;
/// Vectors this close to unit length keep their bits: normalising one in `f64` leaves an error of
/// at most some three roundings, so that what this program wrote is read back unchanged.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The point sets of one file as they come in.
pub(super) struct PointCollector<'a> {
    path: &'a str,
    sets: Vec<PointSet>,
    by_label: HashMap<String, usize>,
    current: usize,
    rescaled: usize,
    worst: Option<(f64, Place)>,
    warnings: Vec<String>,
}

impl<'a> PointCollector<'a> {
    /// Returns an empty collector for the file of this name.
    pub(super) fn new(path: &'a str) -> Self {
        Self {
            path,
            sets: vec![PointSet::default()],
            by_label: HashMap::new(),
            current: 0,
            rescaled: 0,
            worst: None,
            warnings: Vec::new(),
        }
    }

    /// Sends the points that follow to the set of this label, which is new at its first use.
    pub(super) fn select(&mut self, label: &str) {
        if let Some(&index) = self.by_label.get(label) {
            self.current = index;
            return;
        }
        if !self.by_label.is_empty() {
            self.sets.push(PointSet::default());
        }
        self.current = self.sets.len() - 1;
        self.by_label.insert(label.to_owned(), self.current);
    }

    /// Starts the next set, unless the present one is still empty.
    pub(super) fn next_set(&mut self) {
        if !self.sets[self.current].directions.is_empty() {
            self.sets.push(PointSet::default());
            self.current = self.sets.len() - 1;
        }
    }

    /// Returns the number of points of the present set.
    pub(super) fn len(&self) -> usize {
        self.sets[self.current].directions.len()
    }

    /// Adds the vector of a direction, scaled to unit length.
    pub(super) fn push_vector(&mut self, vector: [f64; 3], place: Place) -> Result<(), FileError> {
        for (field, value) in ["x", "y", "z"].into_iter().zip(vector) {
            self.finite(value, field, place)?;
        }
        let vector = DVec3::from_array(vector);
        let size = vector.abs().max_element();
        if size == 0.0 {
            return Err(FileError::Value {
                path: self.path.to_owned(),
                place,
                field: "x, y, z".to_owned(),
                expected: "a vector that has a direction".to_owned(),
                got: "the zero vector".to_owned(),
            });
        }
        // Scaled first, which keeps the squares of tiny and huge vectors in range.
        let scaled = vector / size;
        let length = size * scaled.length();
        if (length - 1.0).abs() <= ROUNDING {
            self.push_direction(vector);
            return Ok(());
        }
        if (length - 1.0).abs() > LENGTH_TOLERANCE {
            self.rescaled += 1;
            // Far from 1 in ratio, so that 0.01 counts as worse than 2.
            let badness = length.ln().abs();
            if self.worst.is_none_or(|(other, _)| badness > other.ln().abs()) {
                self.worst = Some((length, place));
            }
        }
        self.push_direction(scaled.normalize());
        Ok(())
    }

    /// Adds a direction that is unit already.
    pub(super) fn push_direction(&mut self, direction: DVec3) {
        self.sets[self.current].directions.push(direction);
    }

    /// Adds the weight of the point added last.
    pub(super) fn push_weight(&mut self, weight: f64) {
        self.sets[self.current].weights.get_or_insert_default().push(weight);
    }

    /// Adds the value at the point added last.
    pub(super) fn push_value(&mut self, value: f64) {
        self.sets[self.current].values.get_or_insert_default().push(value);
    }

    /// Adds a line for the user; the path is put before it.
    pub(super) fn warn(&mut self, message: &str) {
        self.warnings.push(format!("{}: {message}", self.path));
    }

    /// Returns an error unless the value is finite.
    pub(super) fn finite(&self, value: f64, field: &str, place: Place) -> Result<(), FileError> {
        if value.is_finite() {
            return Ok(());
        }
        Err(FileError::Value {
            path: self.path.to_owned(),
            place,
            field: field.to_owned(),
            expected: "a finite number".to_owned(),
            got: value.to_string(),
        })
    }

    /// Returns the sets, or an error when there is not a single point.
    pub(super) fn finish(mut self) -> Result<PointFile, FileError> {
        self.sets.retain(|set| !set.directions.is_empty());
        if self.sets.is_empty() {
            return Err(FileError::Empty { path: self.path.to_owned() });
        }
        if let Some((length, place)) = self.worst {
            let total: usize = self.sets.iter().map(|set| set.directions.len()).sum();
            self.warnings.push(format!(
                "{}: {} of {total} vectors were not of unit length and were scaled to it \
                 (the furthest off: {}{place}, length {length})",
                self.path, self.rescaled, self.path,
            ));
        }
        Ok(PointFile { sets: self.sets, warnings: self.warnings })
    }
}
