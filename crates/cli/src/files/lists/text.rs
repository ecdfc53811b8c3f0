//! Reads lists from text.

use std::borrow::Cow;
use std::io::BufRead;

use super::{Columns, Fault, Number, fault_error};
use crate::files::file_error::{FileError, Place};
use crate::files::text_rows::{TextLine, TextRows, shortened};

/// Returns the result of `accept` for every row of a text file.
pub(super) fn read_text<T: Number, R, const N: usize>(
    input: impl BufRead,
    path: &str,
    columns: &Columns<N>,
    mut accept: impl FnMut([T; N]) -> Result<R, Fault>,
) -> Result<Vec<R>, FileError> {
    let mut lines = TextRows::new(input, path, "text in UTF-8, or an NPY array");
    let mut reader = TextReader { path, columns, layout: None };
    let mut rows = Vec::new();
    while let Some(line) = lines.next_line()? {
        if line.is_comment() {
            continue;
        }
        if let Some(fields) = reader.fields(line)? {
            rows.push(reader.row(line.number, fields, &mut accept)?);
        }
    }
    if reader.layout.is_none() {
        return Err(FileError::Layout {
            path: path.to_owned(),
            place: Place::Whole,
            expected: format!("rows of {}, or at least a header", shown_columns(columns)),
            got: "neither".to_owned(),
        });
    }
    Ok(rows)
}

struct TextReader<'a, const N: usize> {
    path: &'a str,
    columns: &'a Columns<N>,
    layout: Option<Layout<N>>,
}

/// The number of fields of a line, and the positions of the columns among them.
#[derive(Clone, Copy)]
struct Layout<const N: usize> {
    fields: usize,
    at: [usize; N],
}

impl<const N: usize> TextReader<'_, N> {
    /// Returns the columns' fields of a line, or `None` for a header.
    fn fields<'t>(&mut self, line: TextLine<'t>) -> Result<Option<[Cow<'t, str>; N]>, FileError> {
        let layout = match self.layout {
            Some(layout) => layout,
            None if line.is_header() => {
                self.layout = Some(self.header(line)?);
                return Ok(None);
            }
            None => *self.layout.insert(self.without_header(line)?),
        };
        let mut picked = [const { Cow::Borrowed("") }; N];
        let mut count = 0;
        for field in line.fields() {
            if let Some(column) = layout.at.iter().position(|&at| at == count) {
                picked[column] = field;
            }
            count += 1;
        }
        if count == layout.fields {
            return Ok(Some(picked));
        }
        let noun = if layout.fields == 1 { "field" } else { "fields" };
        Err(self.layout_error(line, format!("{} {noun}", layout.fields), count.to_string()))
    }

    fn without_header(&self, line: TextLine<'_>) -> Result<Layout<N>, FileError> {
        let count = line.fields().count();
        if count == N {
            return Ok(Layout { fields: N, at: std::array::from_fn(|i| i) });
        }
        let noun = if count == 1 { "field" } else { "fields" };
        Err(self.layout_error(
            line,
            format!("{}, or a header that names them", shown_columns(self.columns)),
            format!("{count} {noun} without a header"),
        ))
    }

    fn header(&self, line: TextLine<'_>) -> Result<Layout<N>, FileError> {
        let mut at = [0; N];
        for (place, wanted) in at.iter_mut().zip(self.columns.names) {
            let mut found =
                (0..).zip(line.fields()).filter(|(_, n)| n.eq_ignore_ascii_case(wanted));
            let expected = match (found.next(), found.next()) {
                (Some((column, _)), None) => {
                    *place = column;
                    continue;
                }
                (None, _) => shown_columns(self.columns),
                (Some(_), Some(_)) => format!("the column {wanted} once"),
            };
            let got = format!("the header {}", shortened(line.text));
            return Err(self.layout_error(line, expected, got));
        }
        Ok(Layout { fields: line.fields().count(), at })
    }

    fn row<T: Number, R>(
        &self,
        line: usize,
        fields: [Cow<'_, str>; N],
        accept: &mut impl FnMut([T; N]) -> Result<R, Fault>,
    ) -> Result<R, FileError> {
        let mut numbers = [T::default(); N];
        let mut result = Ok(());
        for (column, (number, field)) in numbers.iter_mut().zip(&fields).enumerate() {
            match T::of_text(field) {
                Some(parsed) => *number = parsed,
                None => {
                    result = Err(Fault::Column(column, T::EXPECTED.to_owned()));
                    break;
                }
            }
        }
        result.and_then(|()| accept(numbers)).map_err(|fault| {
            let got = match fault {
                Fault::Column(..) => fields.map(|field| format!("{:?}", shortened(&field))),
                Fault::Row(_) => fields.map(|field| shortened(&field)),
            };
            fault_error(fault, self.path, Place::Line(line), self.columns, &got)
        })
    }

    fn layout_error(&self, line: TextLine<'_>, expected: String, got: String) -> FileError {
        let (path, place) = (self.path.to_owned(), Place::Line(line.number));
        FileError::Layout { path, place, expected, got }
    }
}

fn shown_columns<const N: usize>(columns: &Columns<N>) -> String {
    let noun = if N == 1 { "the column" } else { "the columns" };
    format!("{noun} {} ({})", columns.names.join(","), columns.remark)
}
