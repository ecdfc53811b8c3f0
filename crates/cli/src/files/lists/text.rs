//! Reads lists from text.

use std::io::BufRead;

use super::{Columns, Fault, Number, fault_error};
use crate::files::file_error::{FileError, Place};

/// How much of a wrong field an error message repeats.
const SHOWN: usize = 40;

/// Returns `accept` of every row of a text file.
pub(super) fn read_text<T: Number, R, const N: usize>(
    mut input: impl BufRead,
    path: &str,
    columns: &Columns<N>,
    mut accept: impl FnMut([T; N]) -> Result<R, Fault>,
) -> Result<Vec<R>, FileError> {
    let mut reader = TextReader { path, columns, layout: None, line: 0 };
    let mut rows = Vec::new();
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        let read = input
            .read_until(b'\n', &mut bytes)
            .map_err(|source| FileError::Read { path: path.to_owned(), source })?;
        if read == 0 {
            break;
        }
        reader.line += 1;
        let text = std::str::from_utf8(&bytes).map_err(|_| {
            reader.layout_error("text in UTF-8, or an NPY array", "other bytes".to_owned())
        })?;
        let text = if reader.line == 1 { text.trim_start_matches('\u{feff}') } else { text };
        let text = text.trim();
        if text.is_empty() || text.starts_with('#') {
            continue;
        }
        if let Some(fields) = reader.fields(text)? {
            rows.push(reader.row(fields, &mut accept)?);
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
    /// The current line, counted from 1.
    line: usize,
}

/// How lines are divided and where the columns stand.
#[derive(Clone, Copy)]
struct Layout<const N: usize> {
    commas: bool,
    fields: usize,
    at: [usize; N],
}

impl<const N: usize> TextReader<'_, N> {
    /// Returns the columns' fields of a line; `None` for a header.
    fn fields<'t>(&mut self, text: &'t str) -> Result<Option<[&'t str; N]>, FileError> {
        let layout = match self.layout {
            Some(layout) => layout,
            None => {
                let (layout, is_header) = self.first_line(text)?;
                self.layout = Some(layout);
                if is_header {
                    return Ok(None);
                }
                layout
            }
        };
        let mut picked = [""; N];
        let count = if layout.commas {
            pick(text.split(',').map(str::trim), &layout.at, &mut picked)
        } else {
            pick(text.split_whitespace(), &layout.at, &mut picked)
        };
        if count == layout.fields {
            return Ok(Some(picked));
        }
        Err(self.layout_error(
            &format!("{} {}", layout.fields, if layout.fields == 1 { "field" } else { "fields" }),
            count.to_string(),
        ))
    }

    /// Returns the layout that the first line gives, and whether that line is a header.
    fn first_line(&self, text: &str) -> Result<(Layout<N>, bool), FileError> {
        let commas = text.contains(',');
        let fields: Vec<&str> = if commas {
            text.split(',').map(str::trim).collect()
        } else {
            text.split_whitespace().collect()
        };
        if fields.iter().any(|field| field.parse::<f64>().is_ok()) {
            if fields.len() != N {
                let (one, many) = ("field without a header", "fields without a header");
                return Err(self.layout_error(
                    &format!("{}, or a header that names them", shown_columns(self.columns)),
                    format!("{} {}", fields.len(), if fields.len() == 1 { one } else { many }),
                ));
            }
            return Ok((Layout { commas, fields: N, at: std::array::from_fn(|i| i) }, false));
        }
        let mut at = [0; N];
        for (place, wanted) in at.iter_mut().zip(self.columns.names) {
            let mut found = fields.iter().enumerate().filter(|(_, name)| is_named(name, wanted));
            match (found.next(), found.next()) {
                (Some((column, _)), None) => *place = column,
                (None, _) => {
                    return Err(self.layout_error(
                        &shown_columns(self.columns),
                        format!("the header {}", shortened(text)),
                    ));
                }
                (Some(_), Some(_)) => {
                    return Err(self.layout_error(
                        &format!("the column {wanted} once"),
                        format!("the header {}", shortened(text)),
                    ));
                }
            }
        }
        Ok((Layout { commas, fields: fields.len(), at }, true))
    }

    fn row<T: Number, R>(
        &self,
        fields: [&str; N],
        accept: &mut impl FnMut([T; N]) -> Result<R, Fault>,
    ) -> Result<R, FileError> {
        let mut numbers = [T::default(); N];
        let mut result = Ok(());
        for (column, (number, field)) in numbers.iter_mut().zip(fields).enumerate() {
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
                Fault::Column(..) => fields.map(|field| format!("{:?}", shortened(field))),
                Fault::Row(_) => fields.map(shortened),
            };
            fault_error(fault, self.path, Place::Line(self.line), self.columns, &got)
        })
    }

    fn layout_error(&self, expected: &str, got: String) -> FileError {
        FileError::Layout {
            path: self.path.to_owned(),
            place: Place::Line(self.line),
            expected: expected.to_owned(),
            got,
        }
    }
}

/// Sets `picked` to the fields that stand `at` the wanted places, and returns the number of all.
fn pick<'t, const N: usize>(
    fields: impl Iterator<Item = &'t str>,
    at: &[usize; N],
    picked: &mut [&'t str; N],
) -> usize {
    let mut count = 0;
    for field in fields {
        for (slot, &column) in picked.iter_mut().zip(at) {
            if column == count {
                *slot = field;
            }
        }
        count += 1;
    }
    count
}

/// Returns whether a header's field, quoted or not, is this name in any case.
fn is_named(field: &str, name: &str) -> bool {
    let bare = field.strip_prefix('"').and_then(|f| f.strip_suffix('"')).unwrap_or(field);
    bare.trim().eq_ignore_ascii_case(name)
}

fn shown_columns<const N: usize>(columns: &Columns<N>) -> String {
    let noun = if N == 1 { "the column" } else { "the columns" };
    format!("{noun} {} ({})", columns.names.join(","), columns.remark)
}

fn shortened(text: &str) -> String {
    let mut shown: String = text.chars().take(SHOWN).collect();
    if text.chars().nth(SHOWN).is_some() {
        shown.push_str("...");
    }
    shown
}
