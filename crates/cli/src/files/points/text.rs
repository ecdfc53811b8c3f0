//! Reads point sets from text: CSV with a header, or bare columns of numbers.

use std::io::BufRead;

use super::PointFile;
use super::angles::{direction_of_degrees, direction_of_radians};
use super::collector::PointCollector;
use super::columns::{Coordinates, Layout};
use crate::files::file_error::{FileError, Place};

/// A colatitude printed with seven digits may exceed pi by this much; it is then taken as pi.
const THETA_SLACK: f64 = 1e-6;
/// How much of a wrong field an error message repeats.
const SHOWN: usize = 40;

/// Returns the sets of a text file.
pub(super) fn read_text(
    mut input: impl BufRead,
    path: &str,
    columns: Option<&[String]>,
) -> Result<PointFile, FileError> {
    let mut reader = TextReader {
        path,
        points: PointCollector::new(path),
        layout: None,
        has_header: false,
        commas: false,
        comment_inside: None,
        pending_comment: None,
    };
    let mut bytes = Vec::new();
    let mut line = 0;
    loop {
        bytes.clear();
        let read = input
            .read_until(b'\n', &mut bytes)
            .map_err(|source| FileError::Read { path: path.to_owned(), source })?;
        if read == 0 {
            break;
        }
        line += 1;
        let text = std::str::from_utf8(&bytes).map_err(|_| FileError::Layout {
            path: path.to_owned(),
            place: Place::Line(line),
            expected: "UTF-8 text".to_owned(),
            got: "other bytes (a binary file? .npy and .ply are known by their extension)"
                .to_owned(),
        })?;
        let text = if line == 1 { text.trim_start_matches('\u{feff}') } else { text };
        reader.line(text.trim(), line, columns)?;
    }
    reader.finish()
}

struct TextReader<'a> {
    path: &'a str,
    points: PointCollector<'a>,
    layout: Option<Layout>,
    has_header: bool,
    commas: bool,
    /// The first comment with words between the rows of a file without a header.
    comment_inside: Option<usize>,
    /// The same, before it is known whether more rows follow.
    pending_comment: Option<usize>,
}

impl TextReader<'_> {
    fn line(
        &mut self,
        text: &str,
        line: usize,
        columns: Option<&[String]>,
    ) -> Result<(), FileError> {
        if text.is_empty() {
            return Ok(());
        }
        if text.starts_with('#') {
            self.comment(text, line);
            return Ok(());
        }
        if self.layout.is_none() {
            self.commas = text.contains(',');
        }
        let quoted;
        let fields: Vec<&str> = if !self.commas {
            text.split_whitespace().collect()
        } else if text.contains('"') {
            quoted = self.unquote(text, line)?;
            quoted.iter().map(str::trim).collect()
        } else {
            text.split(',').map(str::trim).collect()
        };
        let Some(layout) = self.layout.take() else {
            self.has_header = fields.iter().all(|field| field.parse::<f64>().is_err());
            if self.has_header {
                self.layout = Some(Layout::of_header(&fields, columns, self.path, line)?);
                return Ok(());
            }
            let layout = Layout::without_header(fields.len(), columns, self.path, line)?;
            let row = self.row(&layout, &fields, line);
            self.layout = Some(layout);
            return row;
        };
        let row = self.row(&layout, &fields, line);
        self.layout = Some(layout);
        row
    }

    /// A bare `#` between the rows of a file without a header starts the next set: so do the
    /// programs UTK and pbrt's pspec. A comment with words does not; whoever meant it so is warned.
    fn comment(&mut self, text: &str, line: usize) {
        let sets_by_line = match &self.layout {
            Some(layout) => !self.has_header && layout.set.is_none(),
            None => false,
        };
        if !sets_by_line {
            return;
        }
        if text == "#" {
            self.points.next_set();
        } else if self.points.len() > 0 {
            self.pending_comment.get_or_insert(line);
        }
    }

    fn row(&mut self, layout: &Layout, fields: &[&str], line: usize) -> Result<(), FileError> {
        if fields.len() != layout.names.len() {
            let mut expected = format!("{} fields", layout.names.len());
            if layout.names.len() <= 8 && layout.names.iter().all(|name| !name.is_empty()) {
                expected = format!("{expected} ({})", layout.names.join(", "));
            }
            return Err(FileError::Layout {
                path: self.path.to_owned(),
                place: Place::Line(line),
                expected,
                got: fields.len().to_string(),
            });
        }
        if self.comment_inside.is_none() {
            self.comment_inside = self.pending_comment;
        }
        if let Some(column) = layout.set {
            self.points.select(fields[column]);
        }
        let number = |column: usize| self.number(&layout.names[column], fields[column], line);
        match layout.coordinates {
            Coordinates::Vector { x, y, z } => {
                let vector = [number(x)?, number(y)?, number(z)?];
                self.points.push_vector(vector, Place::Line(line))?;
            }
            Coordinates::Radians { theta, phi } => {
                let (colatitude, longitude) = (number(theta)?, number(phi)?);
                let pi = std::f64::consts::PI;
                if !(0.0..=pi + THETA_SLACK).contains(&colatitude) {
                    let expected = "a colatitude in [0, pi] radians (degrees are called lon, lat)";
                    return Err(self.value_error("theta", expected, fields[theta], line));
                }
                self.points.push_direction(direction_of_radians(colatitude.min(pi), longitude));
            }
            Coordinates::Degrees { lon, lat } => {
                let (longitude, latitude) = (number(lon)?, number(lat)?);
                if !(-90.0..=90.0).contains(&latitude) {
                    let name = &layout.names[lat];
                    let expected = "an angle in [-90, 90] degrees";
                    return Err(self.value_error(name, expected, fields[lat], line));
                }
                self.points.push_direction(direction_of_degrees(longitude, latitude));
            }
        }
        if let Some(column) = layout.weight {
            let weight = self.number("w", fields[column], line)?;
            self.points.push_weight(weight);
        }
        if let Some(column) = layout.value {
            let value = self.number("value", fields[column], line)?;
            self.points.push_value(value);
        }
        Ok(())
    }

    fn number(&self, name: &str, field: &str, line: usize) -> Result<f64, FileError> {
        match field.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self.value_error(name, "a finite number", field, line)),
        }
    }

    fn value_error(&self, name: &str, expected: &str, field: &str, line: usize) -> FileError {
        let mut got: String = field.chars().take(SHOWN).collect();
        if field.chars().count() > SHOWN {
            got.push_str("...");
        }
        FileError::Value {
            path: self.path.to_owned(),
            place: Place::Line(line),
            field: name.to_owned(),
            expected: expected.to_owned(),
            got: format!("{got:?}"),
        }
    }

    /// Splits a line with quoted fields; a quoted field may hold commas but no line break.
    fn unquote(&self, text: &str, line: usize) -> Result<csv::StringRecord, FileError> {
        let mut record = csv::StringRecord::new();
        csv::ReaderBuilder::new()
            .has_headers(false)
            .from_reader(text.as_bytes())
            .read_record(&mut record)
            .map_err(|error| FileError::Layout {
                path: self.path.to_owned(),
                place: Place::Line(line),
                expected: "fields divided by commas, quoted by \"".to_owned(),
                got: error.to_string(),
            })?;
        Ok(record)
    }

    fn finish(mut self) -> Result<PointFile, FileError> {
        if let Some(line) = self.comment_inside {
            self.points.warn(&format!(
                "line {line} is a comment between points and was skipped; \
                 only a line that is a bare # starts the next set"
            ));
        }
        self.points.finish()
    }
}
