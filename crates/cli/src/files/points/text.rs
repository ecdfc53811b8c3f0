//! Reads point sets from text: CSV with a header, or bare columns of numbers.

use std::borrow::Cow;
use std::io::BufRead;

use super::PointFile;
use super::angles::{direction_of_degrees, direction_of_radians};
use super::collector::PointCollector;
use super::columns::{Coordinates, Layout};
use crate::files::file_error::{FileError, Place};
use crate::files::text_rows::{TextLine, TextRows, shortened};

/// A colatitude printed with seven digits may exceed pi by this much; it is then taken as pi.
const THETA_SLACK: f64 = 1e-6;
/// Returns the sets of a text file.
pub(super) fn read_text(
    input: impl BufRead,
    path: &str,
    columns: Option<&[String]>,
) -> Result<PointFile, FileError> {
    let mut reader = TextReader {
        path,
        points: PointCollector::new(path),
        layout: None,
        has_header: false,
        comment_inside: None,
        pending_comment: None,
    };
    let expected = "UTF-8 text (is it binary? .npy and .ply are known by their extension)";
    let mut lines = TextRows::new(input, path, expected);
    while let Some(line) = lines.next_line()? {
        if line.is_comment() {
            reader.comment(line);
        } else {
            reader.line(line, columns)?;
        }
    }
    reader.finish()
}

struct TextReader<'a> {
    path: &'a str,
    points: PointCollector<'a>,
    layout: Option<Layout>,
    has_header: bool,
    /// The first comment with words between the rows of a file without a header.
    comment_inside: Option<usize>,
    /// The same, before it is known whether more rows follow.
    pending_comment: Option<usize>,
}

impl TextReader<'_> {
    fn line(&mut self, line: TextLine<'_>, columns: Option<&[String]>) -> Result<(), FileError> {
        let fields: Vec<Cow<'_, str>> = line.fields().collect();
        let layout = match self.layout.take() {
            Some(layout) => layout,
            None => {
                self.has_header = line.is_header();
                if self.has_header {
                    let layout = Layout::of_header(&fields, columns, self.path, line.number)?;
                    self.layout = Some(layout);
                    return Ok(());
                }
                Layout::without_header(fields.len(), columns, self.path, line.number)?
            }
        };
        let row = self.row(&layout, &fields, line.number);
        self.layout = Some(layout);
        row
    }

    /// A bare `#` between the rows of a file without a header starts the next set: so do the
    /// programs UTK and pbrt's pspec. A comment with words does not; whoever meant it so is warned.
    fn comment(&mut self, line: TextLine<'_>) {
        let sets_by_line = match &self.layout {
            Some(layout) => !self.has_header && layout.set.is_none(),
            None => false,
        };
        if !sets_by_line {
            return;
        }
        if line.text == "#" {
            self.points.next_set();
        } else if self.points.len() > 0 {
            self.pending_comment.get_or_insert(line.number);
        }
    }

    fn row(
        &mut self,
        layout: &Layout,
        fields: &[Cow<'_, str>],
        line: usize,
    ) -> Result<(), FileError> {
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
            self.points.select(&fields[column]);
        }
        let number = |column: usize| self.number(&layout.names[column], &fields[column], line);
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
                    return Err(self.value_error("theta", expected, &fields[theta], line));
                }
                self.points.push_direction(direction_of_radians(colatitude.min(pi), longitude));
            }
            Coordinates::Degrees { lon, lat } => {
                let (longitude, latitude) = (number(lon)?, number(lat)?);
                if !(-90.0..=90.0).contains(&latitude) {
                    let name = &layout.names[lat];
                    let expected = "an angle in [-90, 90] degrees";
                    return Err(self.value_error(name, expected, &fields[lat], line));
                }
                self.points.push_direction(direction_of_degrees(longitude, latitude));
            }
        }
        if let Some(column) = layout.weight {
            let weight = self.number("w", &fields[column], line)?;
            self.points.push_weight(weight);
        }
        if let Some(column) = layout.value {
            let value = self.number("value", &fields[column], line)?;
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
        FileError::Value {
            path: self.path.to_owned(),
            place: Place::Line(line),
            field: name.to_owned(),
            expected: expected.to_owned(),
            got: format!("{:?}", shortened(field)),
        }
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
