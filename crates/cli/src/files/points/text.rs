//! Reads point sets from text: CSV with a header, or bare columns of numbers.

use std::borrow::Cow;
use std::io::BufRead;

use super::collector::{Cell, PointCollector};
use super::column::Column;
use super::columns::Table;
use super::{FilePoint, PointFile, Purpose, ReadOptions};
use crate::files::file_error::{FileError, Place};
use crate::files::text_rows::{HeldLine, TextLine, TextRows};

/// A layout has at most three coordinates, a weight, a value with its error and a set.
const MAX_SLOTS: usize = 7;

/// Returns the sets of a text file.
pub(super) fn read_text<'a, P: FilePoint>(
    input: impl BufRead,
    path: &'a str,
    options: &'a ReadOptions,
    purpose: Purpose<'a, P>,
) -> Result<PointFile<P>, FileError> {
    let mut reader = TextReader {
        path,
        options,
        purpose: Some(purpose),
        table: None,
        header: None,
        units: None,
        header_comment: None,
        comment_inside: None,
        pending_comment: None,
    };
    let expected = "UTF-8 text (is it binary? .npy and .ply are known by their extension)";
    let mut lines = TextRows::new(input, path, expected);
    while let Some(line) = lines.next_line()? {
        if line.is_comment() {
            reader.comment(line);
        } else {
            reader.line(line)?;
        }
        if reader.table.as_ref().is_some_and(|table| table.points.is_done()) {
            break;
        }
    }
    reader.finish()
}

struct TextReader<'a, P> {
    path: &'a str,
    options: &'a ReadOptions,
    /// What is done with the rows, before there is a table.
    purpose: Option<Purpose<'a, P>>,
    table: Option<TextTable<'a, P>>,
    /// The header, before the line below it is known.
    header: Option<HeldLine>,
    /// The line below the header if it has no numbers; it contains units if a rule follows.
    units: Option<HeldLine>,
    /// The last comment before the rows, which may be a header.
    header_comment: Option<String>,
    /// The first comment with words between the rows of a file without a header.
    comment_inside: Option<usize>,
    /// The same, before it is known whether more rows follow.
    pending_comment: Option<usize>,
}

/// The structure of the table, determined by its first line.
struct TextTable<'a, P> {
    points: PointCollector<'a, P>,
    names: Vec<String>,
    has_header: bool,
    /// Whether the first line ends with a separator, so that others may have one more field.
    open_end: bool,
}

impl<'a, P: FilePoint> TextReader<'a, P> {
    fn line(&mut self, line: TextLine<'_>) -> Result<(), FileError> {
        if let Some(table) = &mut self.table {
            if self.comment_inside.is_none() {
                self.comment_inside = self.pending_comment;
            }
            return table.row(line, self.path);
        }
        let Some(header) = &self.header else {
            if line.is_header() {
                self.header = Some(line.held());
            } else {
                let path = self.path;
                self.start(line, None)?.row(line, path)?;
            }
            return Ok(());
        };
        // VizieR and others write names, units and dashes above the rows.
        if line.is_rule() && line.fields().count() == header.line().fields().count() {
            let (header, units) = (self.header.take(), self.units.take());
            let units = units.as_ref().map(HeldLine::line);
            header.map_or(Ok(()), |header| self.start(header.line(), units).map(drop))
        } else if self.units.is_none() && line.is_header() {
            self.units = Some(line.held());
            Ok(())
        } else {
            self.start_without_rule()?;
            self.line(line)
        }
    }

    /// Starts the table of the pending header; the line below it is a row.
    fn start_without_rule(&mut self) -> Result<(), FileError> {
        let Some(header) = self.header.take() else { return Ok(()) };
        let (path, row) = (self.path, self.units.take());
        let table = self.start(header.line(), None)?;
        row.map_or(Ok(()), |row| table.row(row.line(), path))
    }

    /// Starts the table whose first line, a header or a row, is this one, with the units below a
    /// header.
    fn start(
        &mut self,
        first: TextLine<'_>,
        units: Option<TextLine<'_>>,
    ) -> Result<&mut TextTable<'a, P>, FileError> {
        let purpose = self.purpose.take().unwrap_or(Purpose::Keep);
        let table = table_of(first, units, self, purpose)?;
        Ok(self.table.insert(table))
    }

    /// Handles a comment. A bare `#` between the rows of a file without a header starts the next
    /// set, as in the programs UTK and pbrt's pspec. A comment with words does not, and causes a
    /// warning.
    fn comment(&mut self, line: TextLine<'_>) {
        let Some(table) = &mut self.table else {
            self.header_comment = Some(line.text.trim_start_matches('#').to_owned());
            return;
        };
        if table.has_header || table.points.layout().set.is_some() {
            return;
        }
        if line.text == "#" {
            table.points.next_set();
        } else if table.points.has_rows() {
            self.pending_comment.get_or_insert(line.number);
        }
    }

    fn finish(mut self) -> Result<PointFile<P>, FileError> {
        if self.table.is_none() {
            self.start_without_rule()?;
        }
        let Some(mut table) = self.table else {
            return Err(FileError::Empty { path: self.path.to_owned() });
        };
        // What follows the rows that are read is warned of where these are.
        if let Some(line) = self.comment_inside.filter(|_| !table.points.is_done()) {
            table.points.warn(&format!(
                "line {line} is a comment between points and was skipped; \
                 only a line that is a bare # starts the next set"
            ));
        }
        table.points.finish()
    }
}

/// Returns the columns that the first line, a header or a row, determines, with the units below it.
fn table_of<'a, P: FilePoint>(
    line: TextLine<'_>,
    units: Option<TextLine<'_>>,
    reader: &TextReader<'a, P>,
    purpose: Purpose<'a, P>,
) -> Result<TextTable<'a, P>, FileError> {
    let (path, options) = (reader.path, reader.options);
    let has_header = line.is_header();
    let mut fields: Vec<Cow<'_, str>> = line.fields().collect();
    let open_end = line.has_open_end();
    if open_end {
        fields.pop();
    }
    let columns = |names: &[Cow<'_, str>]| -> Vec<Column> {
        names.iter().map(|name| Column::single(&**name)).collect()
    };
    let table =
        Table { path, place: Place::Line(line.number), columns: &[], has_names: true, options };
    let (columns, layout) = if has_header {
        let mut columns = columns(&fields);
        for (column, unit) in columns.iter_mut().zip(units.iter().flat_map(TextLine::fields)) {
            column.unit = unit.into_owned();
        }
        let layout = Table { columns: &columns, ..table }.layout()?;
        (columns, layout)
    } else {
        // Some programs write the names in a comment above the rows.
        let comment = reader.header_comment.as_deref().map(|text| line.with_text(text));
        let from_comment = comment.filter(TextLine::is_header).and_then(|comment| {
            let names: Vec<Cow<'_, str>> = comment.fields().collect();
            let columns = columns(&names);
            let layout = Table { columns: &columns, ..table }.layout().ok()?;
            (names.len() == fields.len()).then_some((columns, layout))
        });
        match from_comment {
            Some(found) => found,
            None => {
                let columns = vec![Column::single(""); fields.len()];
                let layout = Table { columns: &columns, has_names: false, ..table }.layout()?;
                (columns, layout)
            }
        }
    };
    let names = columns.into_iter().map(|column| column.name).collect();
    Ok(TextTable {
        points: PointCollector::new(path, layout, options, purpose)?,
        names,
        has_header,
        open_end,
    })
}

impl<P: FilePoint> TextTable<'_, P> {
    fn row(&mut self, line: TextLine<'_>, path: &str) -> Result<(), FileError> {
        if !self.points.begin_row()? {
            return Ok(());
        }
        let slots = &self.points.layout().slots;
        let mut picked = [const { Cow::Borrowed("") }; MAX_SLOTS];
        let mut count = 0;
        for field in line.fields() {
            if let Some(slot) = slots.iter().position(|slot| slot.column == count) {
                picked[slot] = field;
            }
            count += 1;
        }
        let place = Place::Line(line.number);
        // A separator at the end of a line begins one more field, which is empty.
        let one_more = count == self.names.len() + 1 && (line.has_open_end() || self.open_end);
        if count != self.names.len() && !one_more {
            let error = self.count_error(place, count, line.separator(), path);
            return self.points.skip(place, error);
        }
        self.points.begun_row(place, |slot| Cell::Text(Cow::Borrowed(&picked[slot])))
    }

    fn count_error(&self, place: Place, count: usize, separator: &str, path: &str) -> FileError {
        let names = &self.names;
        let mut expected = format!("{} fields", names.len());
        if names.len() <= 8 && names.iter().all(|name| !name.is_empty()) {
            expected = format!("{expected} ({})", names.join(", "));
        }
        let got = format!("{count}, separated by {separator}");
        FileError::Layout { path: path.to_owned(), place, expected, got }
    }
}
