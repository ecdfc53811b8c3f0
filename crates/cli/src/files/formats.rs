//! The file formats, for `sphvar list formats`.

use schemars::JsonSchema;
use serde::Serialize;

use super::picture::PictureFormat;
use super::points::PointFormat;

/// A format of files that the command reads or writes.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub(crate) struct FileFormat {
    /// The name.
    pub(crate) name: &'static str,
    /// The content of its files.
    pub(crate) content: &'static str,
    /// Extensions without the dot.
    pub(crate) extensions: &'static [&'static str],
    /// Whether commands read it.
    pub(crate) is_read: bool,
    /// Whether commands write it.
    pub(crate) is_written: bool,
    /// One phrase.
    pub(crate) summary: &'static str,
}

/// Returns every format, those of points first.
pub(crate) fn formats() -> Vec<FileFormat> {
    let points = PointFormat::ALL.map(|format| {
        let (name, summary) = match format {
            PointFormat::Csv => ("csv", "text with commas, semicolons, tabs or blanks; gzip too"),
            PointFormat::Npy => {
                ("npy", "array of NumPy, (N, 3) or (M, N, 3), on the square (N, 2) or (M, N, 2)")
            }
            PointFormat::Npz => ("npz", "archive of arrays of NumPy, with weights"),
            PointFormat::Ply => ("ply", "vertices of a polygon file, ASCII or binary"),
            PointFormat::Fits => ("fits", "table of a FITS file; gzip too"),
            PointFormat::Json => ("json", "the document of sphvar sample --json"),
        };
        let extensions = format.extensions();
        let is_written = format.is_writable();
        FileFormat { name, content: "points", extensions, is_read: true, is_written, summary }
    });
    let input = |name, content, extensions, summary| FileFormat {
        name,
        content,
        extensions,
        is_read: true,
        is_written: false,
        summary,
    };
    let maps = [
        input("environment-exr", "environment map", &["exr"], "linear picture, OpenEXR"),
        input("environment-hdr", "environment map", &["hdr", "pic"], "linear picture, Radiance"),
        input("healpix-fits", "HEALPix map", &["fits"], "FITS table or image; gzip too"),
        input("energies", "energy per degree", &["csv", "txt"], "text with l and energy or cl"),
        input("alm-npy", "coefficients", &["npy"], "complex array of NumPy in the order of healpy"),
        input("alm-fits", "coefficients", &["fits"], "FITS table of healpy: index, real, imag"),
    ];
    let renderings = PictureFormat::ALL.map(|format| {
        let (name, summary) = match format {
            PictureFormat::Png => ("picture-png", "8 bits per channel, sRGB"),
            PictureFormat::Exr => ("picture-exr", "linear, 32 bits"),
            PictureFormat::Pfm => ("picture-pfm", "linear, 32 bits, grey"),
        };
        output(name, "rendered picture", format.extensions(), summary)
    });
    let figures = [
        output("figure-svg", "figure", &["svg"], "vector graphics"),
        output("figure-png", "figure", &["png"], "8 bits per channel"),
    ];
    points.into_iter().chain(maps).chain(renderings).chain(figures).collect()
}

const fn output(
    name: &'static str,
    content: &'static str,
    extensions: &'static [&'static str],
    summary: &'static str,
) -> FileFormat {
    FileFormat { name, content, extensions, is_read: false, is_written: true, summary }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{PictureFormat, PointFormat, formats};
    use crate::plots::ImageFormat;

    /// The listed extensions of outputs are those of the writers.
    #[test]
    fn writers_know_the_listed_extensions() {
        for format in formats() {
            for extension in format.extensions {
                let name = format!("a.{}", extension.to_uppercase());
                let path = Path::new(&name);
                let is_known = match format.content {
                    "points" => PointFormat::of_path(path).is_some(),
                    "rendered picture" => PictureFormat::of_path(path).is_ok(),
                    "figure" => ImageFormat::of_path(path).is_some(),
                    _ => format.is_read,
                };
                assert!(is_known, "{} {extension}", format.name);
            }
        }
        let mut names: Vec<_> = formats().iter().map(|format| format.name).collect();
        names.dedup();
        assert_eq!(names.len(), formats().len());
    }
}
