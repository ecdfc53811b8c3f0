//! Errors of figures.

use crate::files::FileError;

/// Errors of drawing and writing a figure.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum PlotError {
    /// The extension of the output is not that of a supported image format.
    #[error("cannot write {path}: expected a name that ends in .svg or .png")]
    UnknownExtension {
        /// The output path as the user wrote it.
        path: String,
    },
    /// The drawing library failed.
    #[error("cannot draw the figure: {reason}")]
    Drawing {
        /// The reason that it reported.
        reason: String,
    },
    /// The image could not be encoded as PNG.
    #[error("cannot encode the figure as PNG: {source}")]
    Encoding {
        /// The reason that the encoder reported.
        source: image::ImageError,
    },
    /// The file could not be written.
    #[error(transparent)]
    File(#[from] FileError),
}
