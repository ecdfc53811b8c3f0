//! What can go wrong with a figure.

use crate::files::FileError;

/// Errors of drawing and writing a figure.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum PlotError {
    /// The extension of the output names no image format known here.
    #[error("cannot write {path}: expected a name that ends in .svg or .png")]
    UnknownExtension {
        /// The output path as the user wrote it.
        path: String,
    },
    /// The drawing library refused.
    #[error("cannot draw the figure: {reason}")]
    Drawing {
        /// The reason that it gave.
        reason: String,
    },
    /// The image could not be encoded as PNG.
    #[error("cannot encode the figure as PNG: {source}")]
    Encoding {
        /// The reason that the encoder gave.
        source: image::ImageError,
    },
    /// The file could not be written.
    #[error(transparent)]
    File(#[from] FileError),
}
