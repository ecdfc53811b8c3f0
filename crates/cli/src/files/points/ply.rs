//! Reads point sets from PLY files.
//!
//! The grammar (three encodings, lists, any mix of types) is parsed by `ply-rs-bw`, the maintained
//! successor of `ply-rs` 0.1, which has had no release for years. Only the writer is part of this
//! crate: it writes one fixed header and doubles.

use std::io::{self, BufRead, Cursor, Read};

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::collector::{Cell, PointCollector};
use super::column::Column;
use super::columns::{Layout, Table};
use super::{FilePoint, PointFile, Purpose, ReadOptions};
use crate::files::file_error::{FileError, Place};
use crate::files::input::{Input, SkipBytes};
use crate::files::text_rows::shortened;

/// The maximum number of bytes of a header.
const MAX_HEADER: u64 = 1 << 20;
/// The number of rows that are read at a time.
const CHUNK: usize = 1 << 12;

/// Returns the sets of a PLY file: the element vertex, whose properties are columns. Other elements
/// are skipped.
pub(super) fn read_ply<P: FilePoint>(
    mut input: Input,
    path: &str,
    options: &ReadOptions,
    file_bytes: Option<u64>,
    purpose: Purpose<'_, P>,
) -> Result<PointFile<P>, FileError> {
    let start =
        input.fill_buf().map_err(|source| FileError::Read { path: path.to_owned(), source })?;
    if start.is_empty() {
        return Err(FileError::Empty { path: path.to_owned() });
    }
    let is_regular = input.is_regular();
    let head = header_bytes(&mut input)
        .map_err(|source| FileError::Read { path: path.to_owned(), source })?;
    check_names(&head, path)?;
    let mut reader = Reader::new(Counted { input: Cursor::new(head).chain(input), bytes: 0 });
    let header = Parser::<Skipped>::new()
        .read_header(&mut reader)
        .map_err(|error| malformed(path, "a PLY header", &error))?;
    let header_bytes = reader.get_ref().bytes;
    let layout = layout(&header, path, options)?;

    let slots: Vec<usize> = layout.slots.iter().map(|slot| slot.column).collect();
    let announced = bytes_through_vertices(&header).map(|bytes| header_bytes.saturating_add(bytes));
    // Whether the file has all the vertices that its header announces.
    let is_whole =
        announced.zip(file_bytes.filter(|_| is_regular)).map(|(expected, got)| expected <= got);
    let is_count = matches!(purpose, Purpose::Count(_));
    if is_count && is_whole == Some(false) {
        // The error is that of reading the whole file.
        return Ok(PointFile::default());
    }
    let mut points = PointCollector::new(path, layout, options, purpose)?;
    for (name, element) in &header.elements {
        let is_vertex = name == "vertex";
        if is_count && !is_vertex {
            continue;
        }
        let mut part = if is_vertex { with_slots(element, &slots) } else { element.clone() };
        let (mut done, mut end) = (0, element.count);
        let mut wanted = 0..0;
        if is_vertex {
            if is_whole == Some(true) {
                points.reserve(element.count as u64);
            }
            let rows = points.rows(element.count as u64);
            let row = |row: u64| usize::try_from(row).unwrap_or(element.count);
            wanted = row(rows.start)..row(rows.end);
            end = wanted.end;
            // Rows of a known length need not be parsed.
            if header.encoding != Encoding::Ascii
                && let Some(bytes) = bytes_of(element, wanted.start)
            {
                let input = reader.get_mut();
                let skipped = input.input.get_mut().1.skip_bytes(bytes);
                skipped.map_err(|source| FileError::Read { path: path.to_owned(), source })?;
                input.bytes = input.bytes.saturating_add(bytes);
                done = wanted.start;
            }
        }
        while done < end {
            let is_read = is_vertex && done >= wanted.start;
            let until = if is_read || !is_vertex { end } else { wanted.start };
            part.count = CHUNK.min(until - done);
            let rows = if is_read {
                Parser::<Vertex>::new().read_payload_for_element(&mut reader, &part, &header)
            } else {
                let skipped = Parser::<Skipped>::new();
                skipped.read_payload_for_element(&mut reader, &part, &header).map(|_| Vec::new())
            };
            let rows = rows.map_err(|error| {
                if error.kind() == io::ErrorKind::UnexpectedEof
                    && let Some(expected) = announced
                {
                    return FileError::Truncated {
                        path: path.to_owned(),
                        what: format!("{} vertices", header.elements["vertex"].count),
                        expected,
                        got: reader.get_ref().bytes,
                    };
                }
                let expected = format!("{} rows of {}", element.count, shortened(name));
                malformed(path, &expected, &error)
            })?;
            for (index, row) in rows.iter().enumerate() {
                points.row(Place::Vertex(done + index), |slot| Cell::Number(row.slots[slot]))?;
            }
            done += part.count;
        }
        if is_vertex {
            break;
        }
    }
    points.finish()
}

/// Returns the bytes up to the line `end_header`, or up to the maximum length of a header.
fn header_bytes(input: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut input = input.take(MAX_HEADER);
    let mut head = Vec::new();
    loop {
        let start = head.len();
        if input.read_until(b'\n', &mut head)? == 0 || head[start..].trim_ascii() == b"end_header" {
            return Ok(head);
        }
    }
}

/// Rejects two elements of one name, or two properties of one element: the parser would silently
/// keep only one of them.
fn check_names(head: &[u8], path: &str) -> Result<(), FileError> {
    let text = String::from_utf8_lossy(head);
    let mut elements: Vec<&str> = Vec::new();
    let mut properties: Vec<&str> = Vec::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let (what, names, name) = match words[..] {
            ["element", name, ..] => {
                properties.clear();
                ("element", &mut elements, name)
            }
            ["property", .., name] => ("property", &mut properties, name),
            _ => continue,
        };
        if names.contains(&name) {
            return Err(FileError::Layout {
                path: path.to_owned(),
                place: Place::Whole,
                expected: format!("each {what} once"),
                got: format!("{what} {} twice", shortened(name)),
            });
        }
        names.push(name);
    }
    Ok(())
}

/// Returns the meaning of the properties of the vertices, and checks that every element occupies
/// space: a count without properties would take time in proportion to an arbitrary number.
fn layout(header: &Header, path: &str, options: &ReadOptions) -> Result<Layout, FileError> {
    let error = |expected: &str, got: String| FileError::Layout {
        path: path.to_owned(),
        place: Place::Whole,
        expected: expected.to_owned(),
        got,
    };
    let Some(vertex) = header.elements.get("vertex") else {
        let names: Vec<String> = header.elements.keys().take(8).map(|n| shortened(n)).collect();
        return Err(error("the element vertex", format!("the elements [{}]", names.join(", "))));
    };
    for (name, element) in &header.elements {
        if element.properties.is_empty() && element.count > 0 {
            let got = format!("{} without any", shortened(name));
            return Err(error("elements with properties", got));
        }
    }
    let columns: Vec<Column> = vertex
        .properties
        .iter()
        .map(|(name, property)| {
            let is_number = matches!(property.data_type, PropertyType::Scalar(_));
            Column { name: name.clone(), items: is_number.into(), unit: String::new() }
        })
        .collect();
    Table { path, place: Place::Whole, columns: &columns, has_names: true, options }.layout()
}

/// Returns the vertices with the used properties renamed to the numbers of their slots.
fn with_slots(vertex: &ElementDef, slots: &[usize]) -> ElementDef {
    let mut renamed = vertex.clone();
    renamed.properties.clear();
    for (index, property) in vertex.properties.values().enumerate() {
        let name = match slots.iter().position(|&column| column == index) {
            Some(slot) => slot.to_string(),
            None => format!("unused {index}"),
        };
        let mut property = property.clone();
        property.name.clone_from(&name);
        renamed.properties.insert(name, property);
    }
    renamed
}

/// Returns the number of bytes from the end of the header to the end of the vertices, if the header
/// determines it: not for text, and not with a list before the end.
fn bytes_through_vertices(header: &Header) -> Option<u64> {
    if header.encoding == Encoding::Ascii {
        return None;
    }
    let mut total = 0_u64;
    for (name, element) in &header.elements {
        total = total.saturating_add(bytes_of(element, element.count)?);
        if name == "vertex" {
            break;
        }
    }
    Some(total)
}

/// Returns the number of bytes of rows of an element without lists in a binary file.
fn bytes_of(element: &ElementDef, rows: usize) -> Option<u64> {
    let mut row = 0_u64;
    for property in element.properties.values() {
        row += match property.data_type {
            PropertyType::List(..) => return None,
            PropertyType::Scalar(ScalarType::Char | ScalarType::UChar) => 1,
            PropertyType::Scalar(ScalarType::Short | ScalarType::UShort) => 2,
            PropertyType::Scalar(ScalarType::Int | ScalarType::UInt | ScalarType::Float) => 4,
            PropertyType::Scalar(ScalarType::Double) => 8,
        };
    }
    Some(row.saturating_mul(rows as u64))
}

/// Returns a concise form of the parser's error, whose text has a line for the defect, lines for
/// the value or row, and debug text.
fn malformed(path: &str, expected: &str, error: &ParseError) -> FileError {
    let text = error.to_string();
    let text = match error.line() {
        Some(line) => text.strip_prefix(&format!("Line {line}: ")).unwrap_or(&text),
        None => &text,
    };
    let (what, details) = text.split_once("\n\t").unwrap_or((text, ""));
    let quoted = |label: &str| {
        let (_, rest) = details.split_once(label)?;
        let value = rest.split("\n\t").next()?.trim_matches(['\'', '\n', '\r', ' ']);
        Some(format!("{:?}: ", shortened(value)))
    };
    let shown = quoted("Value: ").or_else(|| quoted("String: ")).unwrap_or_default();
    FileError::Layout {
        path: path.to_owned(),
        place: error.line().map_or(Place::Whole, Place::Line),
        expected: expected.to_owned(),
        got: format!("{shown}{}", what.trim().trim_end_matches('.')),
    }
}

/// The numbers of a vertex in the slots of the layout.
#[derive(Debug)]
struct Vertex {
    slots: [f64; 5],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { slots: [0.0; 5] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(slot) = name.parse().ok().and_then(|slot: usize| self.slots.get_mut(slot)) else {
            return PropertyAccessResult::Ignored;
        };
        *slot = match property {
            Property::Char(value) => f64::from(value),
            Property::UChar(value) => f64::from(value),
            Property::Short(value) => f64::from(value),
            Property::UShort(value) => f64::from(value),
            Property::Int(value) => f64::from(value),
            Property::UInt(value) => f64::from(value),
            Property::Float(value) => f64::from(value),
            Property::Double(value) => value,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element that is skipped.
#[derive(Debug)]
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }

    fn set_property(&mut self, _name: &str, _property: Property) -> PropertyAccessResult {
        PropertyAccessResult::Ignored
    }
}

/// A reader that counts its bytes.
struct Counted<R> {
    input: R,
    bytes: u64,
}

impl<R: BufRead> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(buffer)?;
        self.bytes += read as u64;
        Ok(read)
    }
}

impl<R: BufRead> BufRead for Counted<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.input.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        self.bytes += amount as u64;
        self.input.consume(amount);
    }
}
