//! Text files as lines of fields: numbers in columns, separated by commas, semicolons, tabs or
//! spaces.

use std::borrow::Cow;
use std::io::{BufRead, Read as _};
use std::iter;

use super::file_error::{FileError, Place};

/// The maximum number of characters of a wrong field or line that an error message quotes.
const SHOWN: usize = 40;
const BYTE_ORDER_MARK: char = '\u{feff}';
/// A longer line is not a row of numbers, and a compressed file may contain any number of bytes.
const MAX_LINE: u64 = 1 << 28;

/// The separator of the fields of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Separator {
    Comma,
    Semicolon,
    Tab,
    Blanks,
}

impl Separator {
    /// Returns the separator of a line such as `sep=;`.
    fn of_declaration(line: &str) -> Option<Self> {
        let (key, separator) = line.trim_end_matches(['\r', '\n']).split_at_checked(4)?;
        match separator {
            _ if !key.eq_ignore_ascii_case("sep=") => None,
            "," => Some(Self::Comma),
            ";" => Some(Self::Semicolon),
            "\t" => Some(Self::Tab),
            _ => None,
        }
    }

    /// Returns the separator of a file from its first line that is not a comment.
    ///
    /// It is the most frequent of commas, semicolons and tabs outside of quotes; in a tie it is the
    /// comma, and tabs count as spaces. Tabs separate single fields, which may be empty or contain
    /// spaces, if a header or an empty field shows it; otherwise any run of tabs and spaces
    /// separates.
    fn of_line(line: &str) -> Self {
        let count = |separator: char| {
            let mut quoted = false;
            let outside = line.chars().filter(|&c| {
                quoted ^= c == '"';
                c == separator && !quoted
            });
            outside.count()
        };
        let (commas, semicolons, tabs) = (count(','), count(';'), count('\t'));
        if commas.max(semicolons).max(tabs) == 0 {
            Self::Blanks
        } else if semicolons > 0 && semicolons >= tabs {
            // "1,5;2,5" has decimal commas, which are an error of the number and not of the fields.
            Self::Semicolon
        } else if commas >= tabs {
            Self::Comma
        } else {
            // Spaces that align columns, or tabs that do in rows of numbers, count as spaces.
            let is_aligned = ["\t ", " \t", "  "].iter().any(|blanks| line.contains(blanks));
            let is_header = line.split_whitespace().all(|word| word.parse::<f64>().is_err());
            if !is_aligned && (is_header || line.contains("\t\t")) {
                Self::Tab
            } else {
                Self::Blanks
            }
        }
    }
}

/// The lines of a text file.
pub(super) struct TextRows<'a, R> {
    input: R,
    path: &'a str,
    /// The expected content of a file that is not text, for the message.
    expected: &'static str,
    number: usize,
    line: String,
    separator: Option<Separator>,
}

impl<'a, R: BufRead> TextRows<'a, R> {
    /// Returns the lines of a file; `expected` is for the message if it is not text.
    pub(super) fn new(input: R, path: &'a str, expected: &'static str) -> Self {
        Self { input, path, expected, number: 0, line: String::new(), separator: None }
    }

    /// Returns the next line that is not empty, or `None` at the end.
    ///
    /// A byte order mark at the start of the file is skipped, and so is a first line `sep=;`, which
    /// tells Excel the separator.
    ///
    /// # Errors
    ///
    /// When reading fails or the line is not UTF-8.
    pub(super) fn next_line(&mut self) -> Result<Option<TextLine<'_>>, FileError> {
        self.line.clear();
        while self.line.trim().is_empty() {
            self.line.clear();
            self.number += 1;
            let mut bytes = std::mem::take(&mut self.line).into_bytes();
            let read = self.input.by_ref().take(MAX_LINE).read_until(b'\n', &mut bytes);
            let read =
                read.map_err(|source| FileError::Read { path: self.path.to_owned(), source })?;
            if read == 0 {
                return Ok(None);
            }
            if read as u64 == MAX_LINE && !bytes.ends_with(b"\n") {
                return Err(self.error(&format!("a line of more than {MAX_LINE} bytes")));
            }
            if self.number == 1
                && let Some(got) = not_lines(&bytes)
            {
                return Err(self.error(got));
            }
            self.line = match String::from_utf8(bytes) {
                Ok(line) => line,
                // The text of a comment is ignored, and many contain names in Latin-1.
                Err(error) if error.as_bytes().trim_ascii_start().starts_with(b"#") => {
                    String::from_utf8_lossy(error.as_bytes()).into_owned()
                }
                Err(_) => {
                    return Err(
                        self.error("other bytes; iconv -f LATIN1 -t UTF-8 converts Latin-1")
                    );
                }
            };
            if self.number == 1 && self.line.starts_with(BYTE_ORDER_MARK) {
                self.line.remove(0);
            }
            if self.number == 1
                && let Some(separator) = Separator::of_declaration(&self.line)
            {
                self.separator = Some(separator);
                self.line.clear();
            }
        }
        let text = self.line.trim();
        if text.starts_with('#') {
            return Ok(Some(TextLine { number: self.number, text, separator: Separator::Blanks }));
        }
        let separator = *self.separator.get_or_insert_with(|| Separator::of_line(text));
        let text = match separator {
            // The first or the last field may be empty.
            Separator::Tab => self.line.trim_matches([' ', '\r', '\n']),
            _ => text,
        };
        Ok(Some(TextLine { number: self.number, text, separator }))
    }

    fn error(&self, got: &str) -> FileError {
        FileError::Layout {
            path: self.path.to_owned(),
            place: Place::Line(self.number),
            expected: self.expected.to_owned(),
            got: got.to_owned(),
        }
    }
}

/// Returns a description of the bytes up to the first line feed if they are not a line of text.
fn not_lines(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        Some("UTF-16; save it as UTF-8")
    } else if bytes.contains(&0) {
        Some("zero bytes, as in UTF-16 or a binary file")
    } else if !bytes.ends_with(b"\n") && bytes.trim_ascii().contains(&b'\r') {
        Some("lines that end in a carriage return alone; end them with a line feed")
    } else {
        None
    }
}

/// A line that is stored while others are read.
#[derive(Debug)]
pub(super) struct HeldLine {
    text: String,
    number: usize,
    separator: Separator,
}

impl HeldLine {
    /// Returns the line.
    pub(super) fn line(&self) -> TextLine<'_> {
        TextLine { number: self.number, text: &self.text, separator: self.separator }
    }
}

/// A line that is not empty.
#[derive(Debug, Clone, Copy)]
pub(super) struct TextLine<'t> {
    /// The line number, counted from 1 as in editors.
    pub(super) number: usize,
    /// The line without leading and trailing spaces.
    pub(super) text: &'t str,
    /// The separator of the first line of the file that is not a comment.
    separator: Separator,
}

impl<'t> TextLine<'t> {
    /// Returns whether the line starts with `#`.
    pub(super) fn is_comment(&self) -> bool {
        self.text.starts_with('#')
    }

    /// Returns whether no field is a number.
    pub(super) fn is_header(&self) -> bool {
        self.fields().all(|field| field.parse::<f64>().is_err())
    }

    /// Returns whether the line is a rule below a header: every field consists of dashes, and at
    /// least one has three or more.
    pub(super) fn is_rule(&self) -> bool {
        let is_dashes = |field: Cow<'_, str>| !field.is_empty() && field.bytes().all(|b| b == b'-');
        self.text.contains("---") && self.fields().all(is_dashes)
    }

    /// Returns a copy that remains valid when the next line is read.
    pub(super) fn held(&self) -> HeldLine {
        HeldLine { text: self.text.to_owned(), number: self.number, separator: self.separator }
    }

    /// Returns the same line with another text.
    pub(super) fn with_text(self, text: &str) -> TextLine<'_> {
        TextLine { number: self.number, text: text.trim(), separator: self.separator }
    }

    /// Returns whether the line ends with a separator, which an empty field follows.
    pub(super) fn has_open_end(&self) -> bool {
        let separator = match self.separator {
            Separator::Comma => ',',
            Separator::Semicolon => ';',
            Separator::Tab => '\t',
            Separator::Blanks => return false,
        };
        self.text.ends_with(separator)
    }

    /// Returns the name of the separator, for messages.
    pub(super) fn separator(&self) -> &'static str {
        match self.separator {
            Separator::Comma => "commas",
            Separator::Semicolon => "semicolons",
            Separator::Tab => "tabs",
            Separator::Blanks => "blanks",
        }
    }

    /// Returns the fields without leading and trailing spaces.
    ///
    /// A field in `"` loses the quotes and may contain separators and, doubled, `"`, but no line
    /// break.
    pub(super) fn fields(&self) -> impl Iterator<Item = Cow<'t, str>> + use<'t> {
        let separator = self.separator;
        let mut rest = Some(self.text);
        iter::from_fn(move || {
            let text = match separator {
                Separator::Tab => rest?.trim_start_matches(' '),
                _ => rest?.trim_start(),
            };
            let quoted = quoted_bytes(text);
            let after = &text[quoted..];
            let divided = match separator {
                Separator::Comma => after.split_once(','),
                Separator::Semicolon => after.split_once(';'),
                Separator::Tab => after.split_once('\t'),
                Separator::Blanks => after.split_once(char::is_whitespace),
            };
            rest = divided.map(|(_, rest)| rest);
            let unquoted_bytes = divided.map_or(after.len(), |(end, _)| end.len());
            Some(unquoted(text[..quoted + unquoted_bytes].trim_end()))
        })
    }
}

/// Returns the length of the quoted field at the start of a text, including its quotes, or 0 if
/// there is none.
fn quoted_bytes(text: &str) -> usize {
    let Some(quoted) = text.strip_prefix('"') else {
        return 0;
    };
    // A quote ends the field unless a second one follows immediately.
    let mut ended = false;
    let end = quoted.char_indices().find(|&(i, c)| {
        ended ^= c == '"';
        ended && !quoted[i + 1..].starts_with('"')
    });
    end.map_or(text.len(), |(i, _)| i + 2)
}

fn unquoted(field: &str) -> Cow<'_, str> {
    match field.strip_prefix('"').and_then(|field| field.strip_suffix('"')) {
        Some(inner) if inner.contains('"') => inner.replace("\"\"", "\"").trim().to_owned().into(),
        Some(inner) => inner.trim().into(),
        None => field.into(),
    }
}

/// Returns the start of a text for a message, with an ellipsis if it is shortened.
pub(super) fn shortened(text: &str) -> String {
    let mut shown: String = text.chars().take(SHOWN).collect();
    if text.chars().nth(SHOWN).is_some() {
        shown.push_str("...");
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::{TextRows, shortened};

    /// Returns the number and the fields of every line that is not a comment.
    fn rows(text: &str) -> Vec<(usize, Vec<String>)> {
        let mut rows = TextRows::new(text.as_bytes(), "T", "text");
        let mut found = Vec::new();
        while let Some(line) = rows.next_line().unwrap() {
            if !line.is_comment() {
                found.push((line.number, line.fields().map(String::from).collect()));
            }
        }
        found
    }

    #[test]
    fn fields_are_divided_by_what_the_first_line_has() {
        let cases: [(&str, &[&str]); 18] = [
            ("a,b", &["a", "b"]),
            (" a , b,", &["a", "b", ""]),
            (",", &["", ""]),
            ("a\t b   c ", &["a", "b", "c"]),
            ("\"a, b\" , \"say \"\"c, d\"\"\",\"\"", &["a, b", "say \"c, d\"", ""]),
            ("\" a \",b", &["a", "b"]),
            ("5\" pipe,6\",7", &["5\" pipe", "6\"", "7"]),
            ("\"a b\" c", &["a b", "c"]),
            ("\"open, b", &["\"open, b"]),
            ("\"", &["\""]),
            ("a;b;;c", &["a", "b", "", "c"]),
            ("1,5;2,5", &["1,5", "2,5"]),
            ("a\tb c\t\td", &["a", "b c", "", "d"]),
            ("1.5\t\t2\t", &["1.5", "", "2", ""]),
            ("1,\t2,\t3", &["1", "2", "3"]),
            ("1\t 2 3", &["1", "2", "3"]),
            ("1 2\t3", &["1", "2", "3"]),
            ("\"a,b\" \"c;d\"", &["a,b", "c;d"]),
        ];
        for (line, fields) in cases {
            let [(1, found)] = &rows(line)[..] else { panic!("{line:?}: {:?}", rows(line)) };
            assert_eq!(found, fields, "{line:?}");
        }
        // A declaration for Excel is valid in the first line only.
        for (text, fields) in [
            ("sep=;\na,b;c\n", ["a,b", "c"]),
            ("\u{feff}SEP=,\r\na;b,c\r\n", ["a;b", "c"]),
            ("sep=\t\na b\tc d\n", ["a b", "c d"]),
        ] {
            assert_eq!(rows(text), [(2, fields.map(str::to_owned).to_vec())], "{text:?}");
        }
        assert_eq!(rows("sep=|\n").len() + rows("a;b\nsep=;\n").len(), 3);
        let found = rows("\u{feff}\r\n# no, comma\n 1 2 \r\n\n3,4 5\n");
        let expected = [(3, ["1", "2"]), (5, ["3,4", "5"])]
            .map(|(number, fields)| (number, fields.map(str::to_owned).to_vec()));
        assert_eq!(found, expected);
    }

    /// Where no quote is inside a field, the established library splits lines in the same way.
    #[test]
    fn quotes_mean_what_they_mean_to_another_library() {
        for line in ["a,b", "\"a, b\",\"c\"", "\"a\"\"b\",,\"\"", "1,\"2,\"\",\"\",3\",4", "\",\""]
        {
            let mut reader =
                csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_bytes());
            let record = reader.records().next().unwrap().unwrap();
            let expected: Vec<String> = record.iter().map(str::to_owned).collect();
            assert_eq!(rows(line), [(1, expected)], "{line:?}");
        }
    }

    #[test]
    fn messages_show_the_start() {
        let forty = "\u{e9}".repeat(40);
        assert_eq!(shortened(&forty), forty);
        assert_eq!(shortened(&format!("{forty}x")), format!("{forty}..."));
    }
}
