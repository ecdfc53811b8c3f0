//! Meshes from texts in the Wavefront OBJ format.

mod lines;
pub(crate) mod remarks;
mod triangulation;

use std::borrow::Cow;
use std::io::Read;

use glam::DVec3;

use crate::obj::lines::lines;
use crate::obj::triangulation::triangulate;
use crate::{Error, MAX_COORDINATE, Mesh, ObjRemarks};

impl Mesh {
    /// Returns the mesh of a text in the Wavefront OBJ format, see [`Self::from_obj_with_remarks`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::from_obj_with_remarks`].
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_scene::{Error, Mesh};
    ///
    /// let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    /// assert_eq!(Mesh::from_obj(format!("{text}f -4 -3 -2 -1\n").as_bytes())?.n_triangles(), 2);
    /// let error = Mesh::from_obj(format!("{text}f 1 2 5\n").as_bytes()).unwrap_err();
    /// assert!(matches!(error, Error::ObjLine { line: 5, .. }));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn from_obj(reader: impl Read) -> Result<Self, Error> {
        Ok(Self::from_obj_with_remarks(reader)?.0)
    }

    /// Returns the mesh of a text in the Wavefront OBJ format, with remarks on the other contents
    /// of the text.
    ///
    /// Faces (`f`, and the old spelling `fo`) with more than three corners are triangulated. Convex
    /// faces become fans around their first corner. Others are triangulated in the projection along
    /// the largest component of their area vector; if the sides of a face cross there, the part
    /// from which no more ears can be cut becomes a fan, and the face is counted in the remarks.
    /// Negative indices count back from the last vertex so far; positive ones may refer to later
    /// vertices. Objects and groups are merged.
    ///
    /// A vertex has three numbers; or four, the last of which divides the others; or three and a
    /// colour of three or four numbers, which is ignored. Lines end in LF, CR LF or CR, and are
    /// continued after `\` at their end unless they have a comment. A UTF-8 byte order mark is
    /// skipped; names and comments may contain any bytes.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Unreadable`] if the reader fails, and [`Error::ObjEncoding`] for a text in
    /// UTF-16 or UTF-32. Returns [`Error::ObjLine`] with the line number for a vertex that is not
    /// as above or not finite, a face with an index that is not a number or has no vertex, a
    /// keyword that is not printable ASCII, and a text without faces. Also returns the errors of
    /// [`Mesh::new`].
    pub fn from_obj_with_remarks(mut reader: impl Read) -> Result<(Self, ObjRemarks), Error> {
        let mut bytes = Vec::new();
        if let Err(error) = reader.read_to_end(&mut bytes) {
            return Err(Error::Unreadable { reason: error.to_string() });
        }
        if let Some(encoding) = wide_encoding(&bytes) {
            return Err(Error::ObjEncoding { encoding });
        }
        let mut content = Content::default();
        let mut n_lines = 0;
        for (line, text) in lines(&bytes) {
            n_lines = line;
            let read = content.read(line, &text);
            read.map_err(|expected| Error::ObjLine { line, text: quoted(&text), expected })?;
        }
        if content.faces.is_empty() {
            let expected = "a face (`f` and three vertices or more) before the end".into();
            let line = n_lines.max(1);
            return Err(Error::ObjLine { line, text: "end of the text".into(), expected });
        }
        content.mesh(&bytes)
    }
}

/// Returns the encoding of a text whose characters have two or four bytes, detected by its byte
/// order mark or by the zero byte beside its first character.
fn wide_encoding(text: &[u8]) -> Option<&'static str> {
    match *text {
        [0xff, 0xfe, 0, 0, ..]
        | [0, 0, 0xfe, 0xff, ..]
        | [1..=255, 0, 0, 0, ..]
        | [0, 0, 0, 1..=255, ..] => Some("UTF-32"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [1..=255, 0, ..] | [0, 1..=255, ..] => Some("UTF-16"),
        _ => None,
    }
}

/// The maximum number of bytes of an invalid line in a message.
const QUOTED: usize = 60;

/// Returns the beginning of a line, with nonprintable characters escaped.
fn quoted(text: &[u8]) -> String {
    let end = text.len().min(QUOTED);
    let shown = String::from_utf8_lossy(&text[..end]);
    shown.trim().chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

/// The parsed content.
#[derive(Debug, Default)]
struct Content {
    vertices: Vec<DVec3>,
    faces: Vec<Face>,
    /// The 0-based indices of the corners of all faces.
    corners: Vec<u64>,
    remarks: ObjRemarks,
}

/// A polygon.
#[derive(Clone, Copy, Debug)]
struct Face {
    line: usize,
    first_corner: usize,
}

impl Content {
    /// Parses a line; the error describes valid input.
    fn read(&mut self, line: usize, text: &[u8]) -> Result<(), Cow<'static, str>> {
        let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            None => Ok(()),
            Some(b"v") => {
                self.vertices.push(vertex(words)?);
                Ok(())
            }
            Some(b"f" | b"fo") => self.face(line, words),
            Some(keyword) => {
                if !keyword.iter().all(u8::is_ascii_graphic) {
                    return Err("a keyword of the OBJ format, as `v` or `f`, in ASCII".into());
                }
                self.remarks.count(&String::from_utf8_lossy(keyword));
                Ok(())
            }
        }
    }

    fn face<'a>(
        &mut self,
        line: usize,
        words: impl Iterator<Item = &'a [u8]>,
    ) -> Result<(), Cow<'static, str>> {
        let first_corner = self.corners.len();
        for word in words {
            self.corners.push(corner(word, self.vertices.len() as u64)?);
        }
        match self.corners.len() - first_corner {
            0 => return Err("three vertices or more".into()),
            1 | 2 => {
                self.corners.truncate(first_corner);
                self.remarks.small_faces += 1;
            }
            _ => self.faces.push(Face { line, first_corner }),
        }
        Ok(())
    }

    /// Returns the mesh of the content of `text`.
    fn mesh(self, text: &[u8]) -> Result<(Mesh, ObjRemarks), Error> {
        let Self { vertices, faces, corners, mut remarks } = self;
        let ends = faces.iter().skip(1).map(|f| f.first_corner).chain([corners.len()]);
        let mut triangles = Vec::with_capacity(corners.len() - 2 * faces.len());
        let (mut polygon, mut places) = (Vec::new(), Vec::new());
        for (face, end) in faces.iter().zip(ends) {
            polygon.clear();
            places.clear();
            for &corner in &corners[face.first_corner..end] {
                let place = usize::try_from(corner).ok().and_then(|i| vertices.get(i));
                let (Some(&place), Ok(index)) = (place, u32::try_from(corner)) else {
                    let statement = lines(text).find(|&(line, _)| line == face.line);
                    return Err(Error::ObjLine {
                        line: face.line,
                        text: statement.map_or_else(String::new, |(_, text)| quoted(&text)),
                        expected: format!(
                            "indices up to {}, the number of vertices",
                            vertices.len()
                        )
                        .into(),
                    });
                };
                polygon.push(index);
                places.push(place);
            }
            let (parts, is_simple) = triangulate(&places);
            remarks.crossed_faces += usize::from(!is_simple);
            triangles.extend(parts.iter().map(|part| part.map(|i| polygon[i])));
        }
        let n_triangles = triangles.len();
        let mesh = Mesh::new(vertices, triangles)?;
        remarks.left_out_triangles = n_triangles - mesh.n_triangles();
        Ok((mesh, remarks))
    }
}

/// Returns the position of a vertex from the numbers after `v`.
fn vertex<'a>(words: impl Iterator<Item = &'a [u8]>) -> Result<DVec3, &'static str> {
    let mut numbers = [f64::NAN; 7];
    let mut n = 0;
    for word in words {
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        match (numbers.get_mut(n), number) {
            (Some(slot), Some(number)) => *slot = number,
            _ => return Err(VERTEX),
        }
        n += 1;
    }
    let w = match n {
        3 | 6 | 7 => 1.0,
        4 => numbers[3],
        _ => return Err(VERTEX),
    };
    let place = DVec3::from_slice(&numbers) / w;
    // This rejects NaN too.
    let is_usable = place.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE);
    is_usable.then_some(place).ok_or(VERTEX)
}

const VERTEX: &str = "`v` and three finite numbers within 1e100 (or four, the last a divisor that is not 0; or a \
     colour of three or four numbers more)";

/// Returns the 0-based index of a vertex in a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`; `so_far`
/// vertices have been read.
fn corner(word: &[u8], so_far: u64) -> Result<u64, Cow<'static, str>> {
    let index = word.split(|&b| b == b'/').next().unwrap_or_default();
    let index = std::str::from_utf8(index).ok().and_then(|text| text.parse::<i64>().ok());
    match index {
        None => Err("the number of a vertex, with or without `/` and more, for each corner".into()),
        Some(0) => Err("vertices counted from 1, or backwards from -1".into()),
        Some(index) if index > 0 => Ok(index.unsigned_abs() - 1),
        Some(index) => so_far.checked_sub(index.unsigned_abs()).ok_or_else(|| {
            format!(
                "indices that go back no further than the first of the {so_far} vertices so far"
            )
            .into()
        }),
    }
}
