use std::io::Read;

use glam::DVec3;
use tobj::{LoadError, LoadOptions};

use crate::{Error, MAX_COORDINATE, Mesh};

impl Mesh {
    /// The mesh of a text in Wavefront's OBJ format.
    ///
    /// Faces of more than three corners become fans around their first, so they should be convex; negative indices count
    /// from the last vertex so far. Objects and groups are put together. Points, lines, normals, texture coordinates
    /// and materials are not used.
    ///
    /// # Errors
    /// [`Error::Unreadable`] if the reader fails; [`Error::ObjLine`] with the number of the line for a vertex that is not
    /// three finite numbers (or four, or six with a colour), a face with an index that is no number or has no vertex,
    /// and bytes that are not UTF-8; else as [`Mesh::new`].
    ///
    /// # Examples
    /// ```
    /// use sphvar_scene::{Error, Mesh};
    ///
    /// let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    /// assert_eq!(Mesh::from_obj(format!("{text}f -4 -3 -2 -1\n").as_bytes())?.n_triangles(), 2);
    /// let error = Mesh::from_obj(format!("{text}f 1 2 5\n").as_bytes()).unwrap_err();
    /// assert!(matches!(error, Error::ObjLine { line: 5, .. }));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn from_obj(mut reader: impl Read) -> Result<Self, Error> {
        let mut bytes = Vec::new();
        if let Err(error) = reader.read_to_end(&mut bytes) {
            return Err(Error::Unreadable { reason: error.to_string() });
        }
        let text = String::from_utf8(bytes).map_err(|error| not_text(&error))?;
        let options = LoadOptions {
            single_index: true,
            triangulate: true,
            ignore_points: true,
            ignore_lines: true,
        };
        // Vertices of no face count, too, of which neither loader nor mesh says anything.
        if text.lines().any(is_wrong_vertex) {
            return Err(wrong_line(&text, "a vertex is not finite"));
        }
        let geometry = geometry_of(&text);
        let loaded = tobj::load_obj_buf(&mut geometry.as_bytes(), &options, |_| {
            Err(LoadError::OpenFileFailed)
        });
        let models = match loaded {
            Ok((models, _)) => models,
            Err(error) => return Err(wrong_line(&text, &error.to_string())),
        };
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        for model in models {
            vertices
                .extend(model.mesh.positions.as_chunks().0.iter().map(|&p| DVec3::from_array(p)));
            faces.extend_from_slice(model.mesh.indices.as_chunks().0);
        }
        Self::new(vertices, faces).map_err(|error| match error {
            Error::NoTriangles { n_faces: 0 } => wrong_line(&text, &error.to_string()),
            error => error,
        })
    }
}

/// Numbers of a vertex that has a colour.
const N_WITH_COLOR: usize = 6;

/// The lines for vertices and faces, the latter without texture coordinates and normals.
fn geometry_of(text: &str) -> String {
    let mut geometry = String::with_capacity(text.len());
    for line in text.lines().map(without_comment) {
        let mut words = line.split_whitespace();
        match words.next() {
            // The loader wants a colour for all vertices or none.
            Some("v") if words.clone().count() == N_WITH_COLOR => {
                let coordinates = words.take(3).collect::<Vec<_>>();
                geometry.extend(["v ", &coordinates.join(" ")]);
            }
            Some("v") => geometry.push_str(line),
            Some("f") => {
                geometry.push('f');
                for word in words {
                    geometry.push(' ');
                    geometry.push_str(vertex_index(word));
                }
            }
            _ => continue,
        }
        geometry.push('\n');
    }
    geometry
}

fn without_comment(line: &str) -> &str {
    line.split('#').next().unwrap_or_default()
}

fn vertex_index(corner: &str) -> &str {
    corner.split('/').next().unwrap_or_default()
}

/// The first line that keeps a text from being a mesh; the loader does not tell.
fn wrong_line(text: &str, reason: &str) -> Error {
    let words_of = |line| without_comment(line).split_whitespace();
    let n_vertices = text.lines().filter(|line| words_of(line).next() == Some("v")).count();
    let (mut so_far, mut n_faces) = (0, 0);
    for (i, line) in text.lines().enumerate() {
        let mut words = words_of(line);
        let expected = match words.next() {
            Some("v") => {
                so_far += 1;
                (!is_vertex(words)).then_some("`v` and three finite numbers within 1e100")
            }
            Some("f") => {
                n_faces += usize::from(words.clone().count() > 2);
                wrong_face(words, so_far, n_vertices)
            }
            _ => None,
        };
        if let Some(expected) = expected {
            return Error::ObjLine {
                line: i + 1,
                text: line.chars().take(QUOTED).collect(),
                expected,
            };
        }
    }
    if n_faces == 0 {
        let line = text.lines().count().max(1);
        let expected = "a face (`f` and three vertices or more) before the end";
        return Error::ObjLine { line, text: "end of the text".into(), expected };
    }
    Error::Unreadable { reason: reason.into() }
}

/// How much of a wrong line a message has.
const QUOTED: usize = 60;

fn is_wrong_vertex(line: &str) -> bool {
    let mut words = without_comment(line).split_whitespace();
    words.next() == Some("v") && !is_vertex(words)
}

fn is_vertex<'a>(words: impl Iterator<Item = &'a str>) -> bool {
    let numbers = words.map(|word| word.parse().unwrap_or(f64::NAN)).collect::<Vec<_>>();
    let w = match numbers.len() {
        3 | N_WITH_COLOR => 1.0,
        4 => numbers[3],
        _ => f64::NAN,
    };
    numbers.iter().take(3).all(|x| (x / w).abs() <= MAX_COORDINATE)
}

fn wrong_face<'a>(
    words: impl Iterator<Item = &'a str>,
    so_far: usize,
    n_vertices: usize,
) -> Option<&'static str> {
    let mut n_corners = 0;
    for word in words {
        n_corners += 1;
        match vertex_index(word).parse::<i64>() {
            Err(_) => {
                return Some(
                    "the number of a vertex, with or without `/` and more, for each corner",
                );
            }
            Ok(0) => return Some("vertices counted from 1, or backwards from -1"),
            Ok(index) if index < 0 && index.unsigned_abs() > so_far as u64 => {
                return Some("indices that go back no further than the first vertex");
            }
            Ok(index) if index > 0 && index.unsigned_abs() > n_vertices as u64 => {
                return Some("indices up to the number of vertices");
            }
            Ok(_) => {}
        }
    }
    (n_corners == 0).then_some("three vertices or more")
}

fn not_text(error: &std::string::FromUtf8Error) -> Error {
    let (valid, _) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
    let line = 1 + valid.iter().filter(|&&b| b == b'\n').count();
    Error::ObjLine { line, text: "bytes that are no text".into(), expected: "text in UTF-8" }
}
