//! What is reported on the rows of a file, counted while they are read.

use serde::{Deserialize, Serialize};

use super::ReadOptions;
use super::lengths::Lengths;
use crate::files::file_error::{FileError, Place};

/// The maximum number of skipped rows that a warning names.
const NAMED: usize = 5;

/// The counts over rows of one file. Those of consecutive rows add to the counts of all.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct RowTally {
    pub(super) points: usize,
    pub(super) lengths: Lengths,
    skipped: usize,
    /// The places of the first skipped rows.
    skipped_places: Vec<Place>,
    /// The number of points of the square with coordinates by more than 1 outside.
    pub(super) n_far: usize,
    /// Warnings on the end of the file.
    pub(super) warnings: Vec<String>,
}

impl RowTally {
    /// Counts a row that is skipped.
    pub(super) fn skip(&mut self, place: Place) {
        self.skipped += 1;
        if self.skipped_places.len() < NAMED {
            self.skipped_places.push(place);
        }
    }

    /// Adds the counts over later rows.
    pub(crate) fn append(&mut self, later: Self) {
        self.points = self.points.saturating_add(later.points);
        self.lengths.append(&later.lengths);
        self.skipped = self.skipped.saturating_add(later.skipped);
        self.skipped_places.extend(later.skipped_places);
        self.skipped_places.truncate(NAMED);
        self.n_far = self.n_far.saturating_add(later.n_far);
        self.warnings.extend(later.warnings);
    }

    /// Returns the warnings on the file of this name.
    ///
    /// # Errors
    ///
    /// If there are no points, or most are not directions.
    pub(crate) fn conclude(
        self,
        path: &str,
        options: &ReadOptions,
    ) -> Result<Vec<String>, FileError> {
        let mut warnings = self.warnings;
        let mut warn = |message: String| warnings.push(format!("{path}: {message}"));
        if self.skipped > 0 {
            let places: Vec<String> =
                self.skipped_places.iter().map(|place| format!("{path}{place}")).collect();
            let more = if self.skipped > places.len() { ", ..." } else { "" };
            warn(format!(
                "{} of {} rows skipped as invalid: {}{more}",
                self.skipped,
                self.skipped + self.points,
                places.join(", ")
            ));
        }
        if self.points == 0 {
            return match self.skipped {
                0 => Err(FileError::Empty { path: path.to_owned() }),
                skipped => Err(FileError::Layout {
                    path: path.to_owned(),
                    place: Place::Whole,
                    expected: "at least one valid row".to_owned(),
                    got: format!("{skipped} invalid rows"),
                }),
            };
        }
        if self.n_far > 0 {
            warn(format!(
                "{} of {} points have coordinates beyond [-1, 2), which are taken modulo 1; coordinates in a \
                 periodic box must be divided by its period",
                self.n_far, self.points
            ));
        }
        let warning = self.lengths.verdict(path, self.points, options)?;
        warnings.extend(warning);
        Ok(warnings)
    }
}
