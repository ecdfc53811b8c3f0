use std::borrow::Cow;

use thiserror::Error as ThisError;

use crate::CropWindow;

/// What can be wrong with the input of this crate.
#[derive(Debug, Clone, PartialEq, ThisError)]
#[non_exhaustive]
pub enum Error {
    /// A text could not be read to its end.
    #[error("the text cannot be read: {reason}")]
    Unreadable {
        /// What the reader said.
        reason: String,
    },
    /// An OBJ text has characters of two or four bytes.
    #[error(
        "the text is in {encoding}: expected ASCII, UTF-8 or Latin-1; `iconv -f {encoding} -t UTF-8` converts it"
    )]
    ObjEncoding {
        /// UTF-16 or UTF-32.
        encoding: &'static str,
    },
    /// A line of an OBJ text is not what it should be.
    #[error("line {line}: `{text}`: expected {expected}")]
    ObjLine {
        /// Its number, counted from 1.
        line: usize,
        /// Its beginning.
        text: String,
        /// What would be right.
        expected: Cow<'static, str>,
    },
    /// There is nothing that a ray could meet.
    #[error(
        "no triangle with an area among {n_faces} faces: at least one face of three vertices that are \
         not on a line is needed"
    )]
    NoTriangles {
        /// Number of faces given.
        n_faces: usize,
    },
    /// There are more triangles than indices for them.
    #[error("{n_triangles} triangles given: the largest supported number is {max}")]
    TooManyTriangles {
        /// Number of triangles given.
        n_triangles: usize,
        /// The largest number supported.
        max: usize,
    },
    /// A vertex of a triangle is not usable.
    #[error("vertex {vertex} is at ({x}, {y}, {z}): expected finite coordinates within 1e100")]
    Vertex {
        /// Its number, counted from 0.
        vertex: u32,
        /// Its first coordinate.
        x: f64,
        /// Its second coordinate.
        y: f64,
        /// Its third coordinate.
        z: f64,
    },
    /// A mesh is so far from 0 that rounding of its coordinates leaves little of its shape.
    #[error(
        "the mesh is of size {size:e} at coordinates up to {magnitude:e}, which leaves it fewer than \
         4096 steps of double precision: move it nearer to 0"
    )]
    TooFar {
        /// The longest side of its bounds.
        size: f64,
        /// Its largest coordinate.
        magnitude: f64,
    },
    /// A triangle has a vertex that there is not.
    #[error(
        "triangle {face} references vertex {vertex}, but the mesh has {n_vertices} vertices (0-based)"
    )]
    FaceIndex {
        /// The triangle's number, counted from 0.
        face: usize,
        /// The vertex's number.
        vertex: u32,
        /// Number of vertices given.
        n_vertices: usize,
    },
    /// Four corners are not those of a plane convex quadrilateral.
    #[error("a quadrilateral is needed that is {expected}")]
    Quad {
        /// What is missing.
        expected: &'static str,
    },
    /// A scene of quadrilaterals has none.
    #[error("a scene needs at least one quadrilateral")]
    NoQuads,
    /// A camera's parameters do not make a view.
    #[error("a camera needs {expected}")]
    Camera {
        /// What is missing.
        expected: &'static str,
    },
    /// A setting outside its range.
    #[error("{name} must be {range}, got {got}")]
    Setting {
        /// What is set.
        name: &'static str,
        /// The values that there are, in words.
        range: &'static str,
        /// The value given.
        got: f64,
    },
    /// A set of directions cannot be made.
    #[error(transparent)]
    Sampler(#[from] sphvar_samplers::Error),
    /// More renders of one seed than there are random streams for.
    #[error("renders of one seed are counted from 0 and below {max}")]
    TooManyRenders {
        /// One more than the last render.
        max: u64,
    },
    /// An image without pixels or too large.
    #[error("an image of {width} by {height} pixels: sides must be from 1 to {max}")]
    ImageSize {
        /// Columns asked for.
        width: usize,
        /// Rows asked for.
        height: usize,
        /// The longest side.
        max: usize,
    },
    /// A part of an image that is empty or sticks out.
    #[error(
        "the part of {} by {} pixels at ({}, {}) is not within an image of {width} by {height}",
        region.width, region.height, region.x, region.y
    )]
    CropWindow {
        /// The part.
        region: CropWindow,
        /// Columns of the image.
        width: usize,
        /// Rows of the image.
        height: usize,
    },
    /// Too many or too few primary rays.
    #[error("a pixel has {got} by {got} primary rays: the number must be from 1 to {max}")]
    RaysPerSide {
        /// The number per side asked for.
        got: usize,
        /// The largest.
        max: usize,
    },
    /// Images that are to be compared show different things.
    #[error("the image shows other surfaces than the reference image")]
    OtherView,
}
