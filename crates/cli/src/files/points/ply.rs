//! Reads point sets from PLY files.
//!
//! The grammar (three encodings, lists, any mix of types) is left to `ply-rs-bw`, the kept
//! successor of `ply-rs` 0.1, which has seen no release for years. Only the writing is our own:
//! it is one fixed header and a run of doubles.

use std::io::{self, BufRead, Read};

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::PointFile;
use super::collector::PointCollector;
use crate::files::file_error::{FileError, Place};

/// Returns the sets of a PLY file: the vertices' `x`, `y`, `z`, and `w` (or `weight`), `value` and
/// `set` where they are there. Other properties and elements are skipped.
pub(super) fn read_ply(mut input: impl BufRead, path: &str) -> Result<PointFile, FileError> {
    let start =
        input.fill_buf().map_err(|source| FileError::Read { path: path.to_owned(), source })?;
    if start.is_empty() {
        return Err(FileError::Empty { path: path.to_owned() });
    }
    let mut reader = Reader::new(Counted { input, bytes: 0 });
    let vertices = Parser::<Vertex>::new();
    let header = vertices
        .read_header(&mut reader)
        .map_err(|error| malformed(path, "a PLY header", error))?;
    let header_bytes = reader.get_ref().bytes;
    check_vertices(&header, path)?;

    let mut rows = Vec::new();
    for (name, element) in &header.elements {
        let outcome = if name == "vertex" {
            vertices.read_payload_for_element(&mut reader, element, &header).map(|read| rows = read)
        } else {
            Parser::<Skipped>::new()
                .read_payload_for_element(&mut reader, element, &header)
                .map(|_| ())
        };
        if let Err(error) = outcome {
            if error.kind() == io::ErrorKind::UnexpectedEof
                && let Some(expected) = bytes_through_vertices(&header)
            {
                return Err(FileError::Truncated {
                    path: path.to_owned(),
                    what: format!("{} vertices", header.elements["vertex"].count),
                    expected: header_bytes.saturating_add(expected),
                    got: reader.get_ref().bytes,
                });
            }
            return Err(malformed(path, &format!("{} rows of {name}", element.count), error));
        }
        if name == "vertex" {
            break;
        }
    }

    let has = |name: &str| header.elements["vertex"].properties.contains_key(name);
    let (has_weight, has_value, has_set) = (has("w") || has("weight"), has("value"), has("set"));
    let mut points = PointCollector::new(path);
    for (index, row) in rows.iter().enumerate() {
        let place = Place::Vertex(index);
        if has_set {
            points.select(&row.set.to_string());
        }
        points.push_vector([row.x, row.y, row.z], place)?;
        if has_weight {
            points.finite(row.weight, "w", place)?;
            points.push_weight(row.weight);
        }
        if has_value {
            points.finite(row.value, "value", place)?;
            points.push_value(row.value);
        }
    }
    points.finish()
}

/// Checks that there are vertices with scalar x, y, z, and that every element takes up room: a
/// count without properties would cost time in proportion to a number that the file makes up.
fn check_vertices(header: &Header, path: &str) -> Result<(), FileError> {
    let error = |expected: &str, got: String| FileError::Layout {
        path: path.to_owned(),
        place: Place::Whole,
        expected: expected.to_owned(),
        got,
    };
    let Some(vertex) = header.elements.get("vertex") else {
        let names: Vec<&str> = header.elements.keys().map(String::as_str).collect();
        return Err(error("the element vertex", format!("the elements [{}]", names.join(", "))));
    };
    for name in ["x", "y", "z", "w", "weight", "value", "set"] {
        match vertex.properties.get(name).map(|property| &property.data_type) {
            Some(PropertyType::Scalar(_)) => {}
            Some(PropertyType::List(..)) => {
                return Err(error(
                    &format!("a number as vertex property {name}"),
                    "a list".to_owned(),
                ));
            }
            None if matches!(name, "x" | "y" | "z") => {
                let names: Vec<&str> = vertex.properties.keys().map(String::as_str).collect();
                return Err(error(
                    &format!("the vertex property {name}"),
                    format!("the properties [{}]", names.join(", ")),
                ));
            }
            None => {}
        }
    }
    for (name, element) in &header.elements {
        if element.properties.is_empty() && element.count > 0 {
            return Err(error("elements with properties", format!("{name} without any")));
        }
    }
    Ok(())
}

/// Returns the number of bytes from the end of the header to the end of the vertices, where the
/// header tells it: not for text, and not with a list on the way.
fn bytes_through_vertices(header: &Header) -> Option<u64> {
    if header.encoding == Encoding::Ascii {
        return None;
    }
    let mut total = 0_u64;
    for (name, element) in &header.elements {
        total = total.saturating_add(bytes_of(element)?);
        if name == "vertex" {
            break;
        }
    }
    Some(total)
}

fn bytes_of(element: &ElementDef) -> Option<u64> {
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
    Some(row.saturating_mul(element.count as u64))
}

fn malformed(path: &str, expected: &str, error: ParseError) -> FileError {
    FileError::Layout {
        path: path.to_owned(),
        place: Place::Whole,
        expected: expected.to_owned(),
        got: format!(
            "an error ({})",
            io::Error::from(error).to_string().replace("\n\t", "; ").trim()
        ),
    }
}

/// The properties of a vertex that matter here.
#[derive(Debug)]
struct Vertex {
    x: f64,
    y: f64,
    z: f64,
    weight: f64,
    value: f64,
    set: f64,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, weight: 0.0, value: 0.0, set: 0.0 }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let slot = match name {
            "x" => &mut self.x,
            "y" => &mut self.y,
            "z" => &mut self.z,
            "w" | "weight" => &mut self.weight,
            "value" => &mut self.value,
            "set" => &mut self.set,
            _ => return PropertyAccessResult::Ignored,
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

/// An element that is read past.
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

/// Counts the bytes that pass.
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
