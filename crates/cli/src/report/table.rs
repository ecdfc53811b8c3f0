//! Tables for a terminal, built from columns with a heading, an alignment and cells.

use comfy_table::{CellAlignment, Table, presets};

/// A column of a table of records.
pub(crate) struct Column<'a, R: ?Sized> {
    heading: &'a str,
    alignment: CellAlignment,
    cell: Box<dyn Fn(&R) -> String + 'a>,
}

impl<'a, R: ?Sized> Column<'a, R> {
    /// A column of words, aligned left.
    pub(crate) fn text(heading: &'a str, cell: impl Fn(&R) -> String + 'a) -> Self {
        Self { heading, alignment: CellAlignment::Left, cell: Box::new(cell) }
    }

    /// A column of numbers, aligned at the decimal point.
    pub(crate) fn number(heading: &'a str, cell: impl Fn(&R) -> String + 'a) -> Self {
        Self { heading, alignment: CellAlignment::Right, cell: Box::new(cell) }
    }

    /// The heading.
    pub(crate) fn heading(&self) -> &'a str {
        self.heading
    }

    /// Returns whether the column contains numbers.
    pub(crate) fn is_number(&self) -> bool {
        self.alignment == CellAlignment::Right
    }

    /// Returns the cell of a record.
    pub(crate) fn cell(&self, record: &R) -> String {
        (self.cell)(record)
    }
}

/// Returns a table with a row for each record.
pub(crate) fn table_of<'r, R: ?Sized + 'r>(
    columns: &[Column<'_, R>],
    records: impl IntoIterator<Item = &'r R>,
) -> String {
    let heading: Vec<&str> = columns.iter().map(|column| column.heading).collect();
    let alignments: Vec<CellAlignment> = columns.iter().map(|column| column.alignment).collect();
    let cells = |record: &R| columns.iter().map(|column| column.cell(record)).collect();
    text_table(&heading, records.into_iter().map(cells).collect(), &alignments)
}

/// Returns a table of text cells under a heading; all columns except the first `left` are
/// right-aligned.
pub(crate) fn table(heading: &[&str], rows: Vec<Vec<String>>, left: usize) -> String {
    let alignment = |i| if i < left { CellAlignment::Left } else { CellAlignment::Right };
    let alignments: Vec<CellAlignment> = (0..heading.len()).map(alignment).collect();
    text_table(heading, rows, &alignments)
}

fn text_table(
    heading: &[&str],
    mut rows: Vec<Vec<String>>,
    alignments: &[CellAlignment],
) -> String {
    for (column, alignment) in alignments.iter().enumerate() {
        if *alignment == CellAlignment::Right {
            align_points(&mut rows, column);
        }
    }
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(heading.iter().copied());
    for row in rows {
        table.add_row(row);
    }
    for (column, &alignment) in table.column_iter_mut().zip(alignments) {
        column.set_padding((0, 2));
        column.set_cell_alignment(alignment);
    }
    let text = table.to_string();
    // Trailing spaces would show up in files and diffs.
    text.lines().map(str::trim_end).fold(String::new(), |all, line| all + line + "\n")
}

/// Appends spaces to the numbers of a column so that their decimal points align.
fn align_points(rows: &mut [Vec<String>], column: usize) {
    let longest = rows.iter().filter_map(|row| after_units(row.get(column)?)).max().unwrap_or(0);
    for cell in rows.iter_mut().filter_map(|row| row.get_mut(column)) {
        if let Some(after) = after_units(cell) {
            cell.push_str(&" ".repeat(longest - after));
        }
    }
}

/// Returns the number of characters after the units digit of a number, or `None` for other text.
fn after_units(cell: &str) -> Option<usize> {
    let digits = cell.trim_start_matches(['(', '~', '+', '-']);
    let whole = digits.bytes().take_while(u8::is_ascii_digit).count();
    (whole > 0).then(|| digits[whole..].chars().count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_align_at_the_point() {
        let columns = [
            Column::text("name", |row: &(&str, &str)| row.0.to_owned()),
            Column::number("value", |row: &(&str, &str)| row.1.to_owned()),
            Column::text("note", |_: &(&str, &str)| "x".to_owned()),
        ];
        let rows = [("a", "1234"), ("bc", "-1.234e-5"), ("d", "-"), ("e", "0.98 +- 0.01")];
        let expected = "\
name            value  note
a     1234             x
bc      -1.234e-5      x
d                   -  x
e        0.98 +- 0.01  x
";
        assert_eq!(table_of(&columns, &rows), expected);
    }
}
