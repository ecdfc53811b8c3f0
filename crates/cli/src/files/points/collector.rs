//! Collects points from a reader into sets, for all formats.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;

use glam::DVec3;
use sphvar_samplers::PointSet;

use super::angles::{direction_of_degrees, direction_of_radians};
use super::columns::{Layout, listed};
use super::space::FilePoint;
use super::tally::RowTally;
use super::{PointFile, Purpose, ReadOptions};
use crate::files::file_error::{FileError, Place};
use crate::files::memory_guard::MemoryGuard;
use crate::files::text_rows::shortened;

/// The tolerance within which a colatitude above pi is taken as pi: one printed with seven digits
/// may exceed pi by this much.
const THETA_SLACK: f64 = 1e-6;
/// The number of points between two checks of the memory.
const STEP: usize = 1 << 12;
/// The number of bytes of a set without its points.
const SET_BYTES: usize = 128;
/// The content of a column of a row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Cell<'a> {
    Number(f64),
    Text(Cow<'a, str>),
    /// An empty cell, or a mark for an unknown value.
    Missing,
}

/// The numbers of a point.
pub(crate) struct Row<P> {
    pub(super) point: P,
    pub(super) weight: Option<f64>,
    pub(super) value: Option<f64>,
}

/// The point sets of one file while it is read.
pub(crate) struct PointCollector<'a, P> {
    path: &'a str,
    options: &'a ReadOptions,
    purpose: Purpose<'a, P>,
    layout: Layout,
    sets: Vec<PointSet<P>>,
    values: Vec<f64>,
    /// The place of the first point of each set.
    starts: Vec<Place>,
    /// The first point below the plane: its place, the index of its set, and z.
    below: Option<(Place, usize, f64)>,
    by_label: HashMap<String, usize>,
    /// The label of the previous row.
    label: Option<String>,
    current: usize,
    pub(super) tally: RowTally,
    guard: MemoryGuard,
}

impl<'a, P: FilePoint> PointCollector<'a, P> {
    /// Returns an empty collector for the file of this name.
    ///
    /// # Errors
    ///
    /// If values are requested and the layout has none, or both a weight and a standard error.
    pub(super) fn new(
        path: &'a str,
        layout: Layout,
        options: &'a ReadOptions,
        purpose: Purpose<'a, P>,
    ) -> Result<Self, FileError> {
        let layout_error = |expected: &str, got: String| FileError::Layout {
            path: path.to_owned(),
            place: Place::Whole,
            expected: expected.to_owned(),
            got,
        };
        if options.values && layout.value.is_none() {
            let got = match &layout.unused[..] {
                [] => "none".to_owned(),
                others => format!("the other columns {}", listed(others, others.len())),
            };
            // Names choose columns of a table with names, and others are chosen by position.
            let example = options.spelling.columns(match &layout.unused[..] {
                [] => "x,y,z,value",
                _ => "...,value=NAME",
            });
            let expected = format!("a column value (as named in {example})");
            return Err(layout_error(&expected, got));
        }
        if layout.weight.is_some() && layout.sigma.is_some() {
            let expected = "either weights w or standard errors sigma, whose weights are 1/sigma^2";
            return Err(layout_error(expected, "both".to_owned()));
        }
        Ok(Self {
            path,
            options,
            purpose,
            layout,
            sets: vec![PointSet::default()],
            values: Vec::new(),
            starts: vec![Place::Whole],
            below: None,
            by_label: HashMap::new(),
            label: None,
            current: 0,
            tally: RowTally::default(),
            guard: MemoryGuard::default(),
        })
    }

    /// Returns the options for reading the file.
    pub(super) fn options(&self) -> &ReadOptions {
        self.options
    }

    /// Returns the meaning of the columns.
    pub(super) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Returns which of the rows of a file of this number of rows are read.
    pub(super) fn rows(&mut self, total: u64) -> Range<u64> {
        match &mut self.purpose {
            Purpose::Keep => 0..total,
            Purpose::Count(survey) => {
                survey.rows = total;
                survey.is_streamed = true;
                0..0
            }
            Purpose::Blocks(writer) => writer.jump(),
        }
    }

    /// Returns whether no more rows of the file are read, although others follow.
    pub(super) fn is_done(&self) -> bool {
        match &self.purpose {
            Purpose::Keep | Purpose::Count(_) => false,
            Purpose::Blocks(writer) => writer.is_done(),
        }
    }

    /// Reserves memory for this number of points.
    pub(super) fn reserve(&mut self, points: u64) {
        if matches!(self.purpose, Purpose::Keep) {
            let points = usize::try_from(points).unwrap_or(usize::MAX);
            let set = &mut self.sets[self.current];
            // Without this memory, an error follows where it is needed.
            let _ = set.points.try_reserve_exact(points);
            if self.layout.weight.or(self.layout.sigma).is_some() {
                let _ = set.weights.try_reserve_exact(points);
            }
        }
    }

    /// Starts the next set, unless the current one is still empty.
    pub(super) fn next_set(&mut self) {
        if let Purpose::Count(survey) = &mut self.purpose {
            survey.has_sets |= survey.rows > 0;
        }
        if !self.sets[self.current].points.is_empty() {
            self.add_set();
        }
    }

    fn add_set(&mut self) {
        self.sets.push(PointSet::default());
        self.starts.push(Place::Whole);
        self.current = self.sets.len() - 1;
    }

    /// Returns whether the current set has rows before the next one.
    pub(super) fn has_rows(&self) -> bool {
        match &self.purpose {
            Purpose::Keep => !self.sets[self.current].points.is_empty(),
            Purpose::Count(survey) => survey.rows > 0,
            Purpose::Blocks(writer) => writer.has_rows(),
        }
    }

    /// Counts a row, and returns whether it is read.
    ///
    /// # Errors
    ///
    /// If nothing more is to be read.
    pub(super) fn begin_row(&mut self) -> Result<bool, FileError> {
        match &mut self.purpose {
            Purpose::Keep => Ok(true),
            Purpose::Count(survey) => {
                survey.rows += 1;
                survey.is_streamed = true;
                Ok(false)
            }
            Purpose::Blocks(writer) => writer.begin_row(self.path, &mut self.tally),
        }
    }

    /// Adds the point of a row; `cell` returns the content of each of the layout's slots.
    ///
    /// # Errors
    ///
    /// When the row has no direction or weight, unless such rows are skipped.
    pub(super) fn row<'c>(
        &mut self,
        place: Place,
        cell: impl Fn(usize) -> Cell<'c>,
    ) -> Result<(), FileError> {
        if self.begin_row()? { self.begun_row(place, cell) } else { Ok(()) }
    }

    /// Adds the point of a row as [`row`](Self::row) does, after [`begin_row`](Self::begin_row).
    ///
    /// # Errors
    ///
    /// As [`row`](Self::row).
    pub(super) fn begun_row<'c>(
        &mut self,
        place: Place,
        cell: impl Fn(usize) -> Cell<'c>,
    ) -> Result<(), FileError> {
        match P::of_row(self, place, &cell) {
            Ok(row) => {
                if let Some(set) = self.layout.set {
                    self.select(cell(set));
                }
                self.push(place, row)
            }
            Err(error) => self.skip(place, error),
        }
    }

    /// Adds the point with these coordinates and this weight, and returns whether it could be added
    /// as it is: others are left to [`begun_row`](Self::begun_row), with its messages. The layout has the
    /// coordinates in their order, and neither a column of sets nor one of values. The row has begun.
    ///
    /// # Errors
    ///
    /// If the memory does not suffice.
    pub(super) fn plain_row(
        &mut self,
        place: Place,
        coordinates: &[f64],
        weight: Option<f64>,
    ) -> Result<bool, FileError> {
        if !weight.is_none_or(f64::is_finite) {
            return Ok(false);
        }
        match P::of_coordinates(coordinates, place, &mut self.tally.lengths) {
            Some(point) => self.push(place, Row { point, weight, value: None }).map(|()| true),
            None => Ok(false),
        }
    }

    /// Adds a point to the current set.
    fn push(&mut self, place: Place, row: Row<P>) -> Result<(), FileError> {
        let Row { point, weight, value } = row;
        self.tally.points += 1;
        if let Purpose::Blocks(writer) = &mut self.purpose {
            writer.push(point, weight);
            return Ok(());
        }
        let set = &mut self.sets[self.current];
        if set.is_empty() {
            self.starts[self.current] = place;
        }
        if let Some(z) = point.below() {
            self.below.get_or_insert((place, self.current, z));
        }
        set.points.push(point);
        if let Some(weight) = weight {
            set.weights.push(weight);
        }
        self.values.extend(value);
        if self.tally.points.is_multiple_of(STEP) {
            self.check_memory()?;
        }
        Ok(())
    }

    /// Skips a row that cannot be used, or returns its error if skipping is not requested.
    ///
    /// # Errors
    ///
    /// `error`, unless invalid rows are skipped.
    pub(super) fn skip(&mut self, place: Place, error: FileError) -> Result<(), FileError> {
        if !self.options.skip_invalid {
            let option = self.options.spelling.on("skip-invalid");
            return Err(error.with_hint(&format!("{option} skips such rows")));
        }
        self.tally.skip(place);
        Ok(())
    }

    /// Adds a warning for the user, prefixed by the path.
    pub(super) fn warn(&mut self, message: &str) {
        self.tally.warnings.push(format!("{}: {message}", self.path));
    }

    /// Returns the sets, or an error if there are no points or most are not directions. For another
    /// purpose than to keep them, there are none, and the counts are where it needs them.
    pub(super) fn finish(mut self) -> Result<PointFile<P>, FileError> {
        let remarks = self.remarks();
        let weight_role = match (self.layout.weight, self.layout.sigma) {
            (Some(_), _) => Some("w"),
            (None, Some(_)) => Some("sigma"),
            (None, None) => None,
        };
        match &mut self.purpose {
            Purpose::Keep => {}
            Purpose::Count(survey) => {
                self.path.clone_into(&mut survey.name);
                survey.has_sets |= self.layout.set.is_some();
                survey.has_weights = weight_role.is_some();
                survey.remarks = remarks;
                return Ok(PointFile::default());
            }
            Purpose::Blocks(writer) => {
                writer.end_file(self.tally);
                return Ok(PointFile::default());
            }
        }
        let first_below = self.below.map(|(place, set, z)| {
            let set = self.sets[..set].iter().filter(|set| !set.is_empty()).count();
            let path = self.path;
            format!("{path}{place}: the point has z = {z} (set {set}, 0-based)")
        });
        let places = self.sets.iter().zip(&self.starts).filter(|(set, _)| !set.is_empty());
        let starts = places.map(|(_, place)| *place).collect();
        self.sets.retain(|set| !set.points.is_empty());
        let warnings = self.tally.conclude(self.path, self.options)?;
        let (sets, values) = (self.sets, self.values);
        Ok(PointFile { sets, values, weight_role, starts, first_below, warnings, remarks })
    }

    /// Returns remarks on columns that are not used.
    fn remarks(&self) -> Vec<String> {
        let unused = &self.layout.unused;
        let mut remarks = if unused.is_empty() {
            Vec::new()
        } else {
            let noun = if unused.len() == 1 { "column" } else { "columns" };
            vec![format!("{}: {noun} not used: {}", self.path, listed(unused, unused.len()))]
        };
        if let Some(others) = &self.layout.others {
            let used: Vec<&str> = self.layout.slots.iter().take(2).map(|slot| slot.role).collect();
            let used = used.join(",");
            remarks.push(format!(
                "{}: {} are {used}; use {} for others",
                self.path,
                P::SPACE.points_in_words(),
                self.options.spelling.columns(others)
            ));
        }
        remarks
    }

    /// Returns the weight of a row, stated or from a standard error, and its value.
    pub(super) fn weight_and_value<'c>(
        &self,
        place: Place,
        cell: &impl Fn(usize) -> Cell<'c>,
    ) -> Result<(Option<f64>, Option<f64>), FileError> {
        let number = |slot: usize| self.number(place, slot, cell(slot));
        let value = self.layout.value.map(number).transpose()?;
        let weight = match (self.layout.weight, self.layout.sigma) {
            // Inverse variances, unlike the weights of estimates, have one sign.
            (Some(slot), _) if self.options.values && number(slot)? < 0.0 => {
                return Err(self.slot_error(place, slot, "a weight of at least 0", &cell(slot)));
            }
            (Some(slot), _) => Some(number(slot)?),
            (None, Some(slot)) => {
                let weight = number(slot)?.powi(-2);
                let is_valid = weight.is_finite() && weight > 0.0 && number(slot)? > 0.0;
                if !is_valid {
                    let expected = "a positive standard error, 1e-150 to 1e150";
                    return Err(self.slot_error(place, slot, expected, &cell(slot)));
                }
                Some(weight)
            }
            (None, None) => None,
        };
        Ok((weight, value))
    }

    pub(super) fn number(
        &self,
        place: Place,
        slot: usize,
        cell: Cell<'_>,
    ) -> Result<f64, FileError> {
        let value = match &cell {
            Cell::Number(value) => Some(*value),
            Cell::Text(text) => text.parse().ok(),
            Cell::Missing => None,
        };
        value
            .filter(|value| value.is_finite())
            .ok_or_else(|| self.slot_error(place, slot, "a finite number", &cell))
    }

    pub(super) fn slot_error(
        &self,
        place: Place,
        slot: usize,
        expected: &str,
        cell: &Cell<'_>,
    ) -> FileError {
        let got = match cell {
            Cell::Number(value) => value.to_string(),
            Cell::Text(text) => format!("{:?}{}", shortened(text), advice(text)),
            Cell::Missing => "nothing".to_owned(),
        };
        self.error(place, &self.layout.slots[slot].label, expected, got)
    }

    fn error(&self, place: Place, field: &str, expected: &str, got: String) -> FileError {
        FileError::Value {
            path: self.path.to_owned(),
            place,
            field: field.to_owned(),
            expected: expected.to_owned(),
            got,
        }
    }

    /// Selects the set of this label for the points that follow, and creates it at its first use.
    fn select(&mut self, label: Cell<'_>) {
        let label = match label {
            Cell::Number(value) => Cow::Owned(value.to_string()),
            Cell::Text(text) => text,
            Cell::Missing => Cow::Borrowed(""),
        };
        if self.label.as_deref() == Some(&*label) {
            return;
        }
        self.label = Some(label.clone().into_owned());
        if let Some(&index) = self.by_label.get(&*label) {
            self.current = index;
            return;
        }
        if self.by_label.is_empty() {
            self.current = self.sets.len() - 1;
        } else {
            self.add_set();
        }
        self.by_label.insert(label.into_owned(), self.current);
    }

    fn check_memory(&mut self) -> Result<(), FileError> {
        let numbers = [self.layout.weight.or(self.layout.sigma), self.layout.value];
        let of_point = size_of::<P>() + numbers.iter().flatten().count() * size_of::<f64>();
        let points = self.tally.points;
        let held = points * of_point + self.sets.len() * SET_BYTES;
        let what = format!("a set of more than {points} points");
        self.guard.check(self.path, &what, held as u64)
    }
}

impl PointCollector<'_, DVec3> {
    /// Returns the direction of a row with its weight and value.
    ///
    /// # Errors
    ///
    /// If the row has no direction, or an invalid weight or value.
    pub(super) fn direction<'c>(
        &mut self,
        place: Place,
        cell: &impl Fn(usize) -> Cell<'c>,
    ) -> Result<Row<DVec3>, FileError> {
        let number = |slot: usize| self.number(place, slot, cell(slot));
        let point = match self.layout.slots[0].role {
            "x" => {
                let vector = DVec3::new(number(0)?, number(1)?, number(2)?);
                let (weight, value) = self.weight_and_value(place, cell)?;
                let point = self.tally.lengths.direction(vector, place).ok_or_else(|| {
                    let expected = "a vector that has a direction";
                    self.error(place, "x, y, z", expected, "the zero vector".to_owned())
                })?;
                return Ok(Row { point, weight, value });
            }
            "theta" => {
                let (colatitude, longitude) = (number(0)?, number(1)?);
                let pi = std::f64::consts::PI;
                if !(0.0..=pi + THETA_SLACK).contains(&colatitude) {
                    let expected = "a colatitude in [0, pi] radians (degrees are called lon, lat)";
                    return Err(self.slot_error(place, 0, expected, &cell(0)));
                }
                direction_of_radians(colatitude.min(pi), longitude)
            }
            // Longitude and latitude, under any name.
            _ => {
                let (longitude, latitude) = (number(0)?, number(1)?);
                if !(-90.0..=90.0).contains(&latitude) {
                    let expected = "an angle in [-90, 90] degrees";
                    return Err(self.slot_error(place, 1, expected, &cell(1)));
                }
                direction_of_degrees(longitude, latitude)
            }
        };
        let (weight, value) = self.weight_and_value(place, cell)?;
        Ok(Row { point, weight, value })
    }
}

/// Returns advice on a number in an unsupported notation.
fn advice(text: &str) -> &'static str {
    let is_made_of = |others: &str| {
        let is_part = |c: char| c.is_ascii_digit() || others.contains(c);
        text.starts_with(is_part) && text.chars().all(is_part)
    };
    let is_sexagesimal = text.contains([':', 'h']) || (text.contains('d') && text.contains('m'));
    if is_sexagesimal && is_made_of("+-.: hmsd'\"") {
        "; convert hours, minutes and seconds to decimal degrees"
    } else if text.matches(',').count() == 1 && is_made_of("+-,") {
        "; replace decimal commas by points"
    } else {
        ""
    }
}
