use std::borrow::Cow;

use thiserror::Error as ThisError;

use crate::CropWindow;

/// An error in the input of this crate.
#[derive(Debug, Clone, PartialEq, ThisError)]
#[non_exhaustive]
pub enum Error {
    /// A text could not be read to its end.
    #[error("the text cannot be read: {reason}")]
    Unreadable {
        /// The reader's error message.
        reason: String,
    },
    /// An OBJ text is encoded in characters of two or four bytes.
    #[error(
        "the text is in {encoding}: expected ASCII, UTF-8 or Latin-1; `iconv -f {encoding} -t UTF-8` converts it"
    )]
    ObjEncoding {
        /// UTF-16 or UTF-32.
        encoding: &'static str,
    },
    /// A line of an OBJ text is invalid.
    #[error("line {line}: `{text}`: expected {expected}")]
    ObjLine {
        /// The 1-based line number.
        line: usize,
        /// The beginning of the line.
        text: String,
        /// A description of valid input.
        expected: Cow<'static, str>,
    },
    /// The mesh has no surface.
    #[error(
        "no triangle with positive area among {n_faces} faces: at least one face with three vertices that \
         are not collinear is required"
    )]
    NoTriangles {
        /// Number of faces given.
        n_faces: usize,
    },
    /// The number of triangles exceeds the range of their indices.
    #[error("{n_triangles} triangles given: the largest supported number is {max}")]
    TooManyTriangles {
        /// Number of triangles given.
        n_triangles: usize,
        /// The largest number supported.
        max: usize,
    },
    /// A vertex of a triangle is invalid.
    #[error("vertex {vertex} is at ({x}, {y}, {z}): expected finite coordinates within 1e100")]
    Vertex {
        /// The 0-based vertex number.
        vertex: u32,
        /// Its first coordinate.
        x: f64,
        /// Its second coordinate.
        y: f64,
        /// Its third coordinate.
        z: f64,
    },
    /// A mesh is so far from the origin that rounding of its coordinates destroys its shape.
    #[error(
        "the mesh is of size {size:e} at coordinates up to {magnitude:e}, so its size is fewer than 4096 \
         steps of double precision: move it closer to the origin"
    )]
    TooFar {
        /// The longest side of the bounds.
        size: f64,
        /// The largest absolute coordinate.
        magnitude: f64,
    },
    /// A triangle references a vertex that does not exist.
    #[error(
        "triangle {face} references vertex {vertex}, but the mesh has {n_vertices} vertices (0-based)"
    )]
    FaceIndex {
        /// The 0-based triangle number.
        face: usize,
        /// The vertex number.
        vertex: u32,
        /// Number of vertices given.
        n_vertices: usize,
    },
    /// Four corners do not form a plane convex quadrilateral.
    #[error("a quadrilateral must have {expected}")]
    Quad {
        /// The violated requirement.
        expected: &'static str,
    },
    /// A scene of quadrilaterals is empty.
    #[error("a scene needs at least one quadrilateral")]
    NoQuads,
    /// The parameters of a camera do not define a view.
    #[error("a camera must have {expected}")]
    Camera {
        /// The violated requirement.
        expected: &'static str,
    },
    /// A setting outside its range.
    #[error("{name} must be {range}, got {got}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// The valid range in words.
        range: &'static str,
        /// The value given.
        got: f64,
    },
    /// A set of directions cannot be generated.
    #[error(transparent)]
    Sampler(#[from] sphvar_samplers::Error),
    /// The render number exceeds the number of random streams of one seed.
    #[error("the renders of one seed are numbered from 0 to {}", max - 1)]
    TooManyRenders {
        /// The number of renders.
        max: u64,
    },
    /// An image is empty or too large.
    #[error("an image of {width} by {height} pixels: sides must be from 1 to {max}")]
    ImageSize {
        /// The requested number of columns.
        width: usize,
        /// The requested number of rows.
        height: usize,
        /// The maximum length of a side.
        max: usize,
    },
    /// A crop window is empty or not within the image.
    #[error(
        "the part of {} by {} pixels at ({}, {}) is not within an image of {width} by {height}",
        region.width, region.height, region.x, region.y
    )]
    CropWindow {
        /// The crop window.
        region: CropWindow,
        /// Columns of the image.
        width: usize,
        /// Rows of the image.
        height: usize,
    },
    /// The number of primary rays is out of range.
    #[error("a pixel has {got} by {got} primary rays: the number must be from 1 to {max}")]
    RaysPerSide {
        /// The requested number per side.
        got: usize,
        /// The maximum number per side.
        max: usize,
    },
    /// A map of the square leads to points of a disk instead of directions.
    #[error("a density of directions is required, got one of points of a disk")]
    NoDirections,
    /// Densities are 0 where the integrand is not, so that estimates would be biased.
    #[error(
        "the density is 0 where the integrand is not: at theta = {theta:.1}, phi = {phi:.1} degrees {frame}; \
         {percent:.2} % of the integral is lost; add a density that is positive there, such as the uniform \
         one, or a floor to that of a map"
    )]
    NoDensity {
        /// Colatitude in degrees.
        theta: f64,
        /// Longitude in degrees.
        phi: f64,
        /// The frame of both, in words.
        frame: &'static str,
        /// The lost share of the integral in percent.
        percent: f64,
    },
    /// Directions of a light are to sample another integral.
    #[error("the density of a light samples only the integral over the same light")]
    OtherLight,
    /// Two images to be compared show different surfaces.
    #[error("the image shows different surfaces from the reference image")]
    OtherView,
    /// The maps of red, green and blue differ in size or orientation.
    #[error("the maps of red, green and blue must have the same size and first longitude")]
    Channels,
    /// An environment has no density.
    #[error(transparent)]
    Density(#[from] sphvar_warps::Error),
    /// Coefficients of a map are unavailable.
    #[error(transparent)]
    Integrand(#[from] sphvar_integrands::Error),
    /// A transform is unavailable.
    #[error(transparent)]
    Harmonics(#[from] sphvar_sh::Error),
}
