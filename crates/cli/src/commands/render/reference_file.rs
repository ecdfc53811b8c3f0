//! Reference images on disk, each under the hash of its description.

use std::path::{Path, PathBuf};

use sphvar_scene::Image;

use crate::files::{FileError, read_regular, write_regular};

/// The first line of every file; the number changes with the computation or the format of
/// references.
const HEADER: &str = "sphvar reference image 2";

/// Returns a hash of bytes with their number, in hexadecimal digits (FNV-1a, 64 bits).
pub(super) fn fingerprint(bytes: &[u8]) -> String {
    format!("{:016x}-{}", hash(bytes), bytes.len())
}

fn hash(bytes: &[u8]) -> u64 {
    let step = |hash: u64, &byte: &u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, step)
}

/// The file of one reference image.
#[derive(Debug)]
pub(super) struct ReferenceFile {
    path: PathBuf,
    /// Header and description at the start of the file, which distinguish descriptions with equal
    /// hashes.
    head: String,
}

/// The content of a reference file.
#[derive(Debug, PartialEq)]
pub(super) enum Stored {
    /// The image.
    Image(Image),
    /// No file.
    Missing,
    /// A different or damaged file.
    Unusable,
}

impl ReferenceFile {
    /// Returns the file in `folder` for the image of `description`, which contains everything that
    /// the image depends on.
    pub(super) fn new(folder: &Path, description: &str) -> Self {
        let head = format!("{HEADER}\n{description}\n\n");
        let name = format!("reference-{:016x}.sphvar", hash(head.as_bytes()));
        Self { path: folder.join(name), head }
    }

    /// Returns the path.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Reads the image.
    pub(super) fn read(&self) -> Stored {
        match read_regular(&self.path) {
            Ok(bytes) => self.decode(&bytes).map_or(Stored::Unusable, Stored::Image),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Stored::Missing,
            Err(_) => Stored::Unusable,
        }
    }

    /// Writes the image, complete or not at all, and creates the folder.
    ///
    /// # Errors
    ///
    /// If the folder or the file cannot be written.
    pub(super) fn write(&self, image: &Image) -> Result<(), FileError> {
        if let Some(folder) = self.path.parent() {
            std::fs::create_dir_all(folder).map_err(|source| FileError::Write {
                path: folder.display().to_string(),
                source,
            })?;
        }
        write_regular(&self.path, &self.encode(image))
    }

    /// Returns the head, four integers, values, spreads, coverage, sampled spreads if there are any,
    /// and a hash of all these.
    fn encode(&self, image: &Image) -> Vec<u8> {
        let mut bytes = self.head.clone().into_bytes();
        let counts = [image.width, image.height, image.n_points].map(|n| n as u64);
        for count in counts.into_iter().chain([image.rays]) {
            bytes.extend(count.to_le_bytes());
        }
        let of_pixels = [&image.values, &image.spreads, &image.coverage, &image.sampled_spreads];
        for x in of_pixels.into_iter().flatten() {
            bytes.extend(x.to_le_bytes());
        }
        let sum = hash(&bytes);
        bytes.extend(sum.to_le_bytes());
        bytes
    }

    fn decode(&self, bytes: &[u8]) -> Option<Image> {
        let (content, sum) = bytes.split_last_chunk::<8>()?;
        if hash(content) != u64::from_le_bytes(*sum) {
            return None;
        }
        let rest = content.strip_prefix(self.head.as_bytes())?;
        let (counts, rest) = rest.split_first_chunk::<32>()?;
        let counts = counts.as_chunks::<8>().0;
        let count = |i: usize| usize::try_from(u64::from_le_bytes(counts[i])).ok();
        let (width, height, n_points) = (count(0)?, count(1)?, count(2)?);
        let n_pixels = width.checked_mul(height)?;
        let has_sampled_spreads = n_pixels.checked_mul(32)? == rest.len();
        if !has_sampled_spreads && n_pixels.checked_mul(24)? != rest.len() {
            return None;
        }
        let numbers = |bytes: &[u8]| -> Vec<f64> {
            bytes.as_chunks::<8>().0.iter().map(|&b| f64::from_le_bytes(b)).collect()
        };
        Some(Image {
            width,
            height,
            values: numbers(&rest[..8 * n_pixels]),
            spreads: numbers(&rest[8 * n_pixels..16 * n_pixels]),
            coverage: numbers(&rest[16 * n_pixels..24 * n_pixels]),
            n_points,
            rays: u64::from_le_bytes(counts[3]),
            sampled_spreads: numbers(&rest[24 * n_pixels..]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Image, ReferenceFile, Stored, fingerprint};

    fn image() -> Image {
        Image {
            width: 2,
            height: 1,
            values: vec![0.25, 0.0],
            spreads: vec![0.1875, 0.0],
            coverage: vec![1.0, 0.0],
            n_points: 6,
            rays: 6,
            sampled_spreads: Vec::new(),
        }
    }

    #[test]
    fn images_come_back_and_damage_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let file = ReferenceFile::new(&folder.path().join("new"), "a scene");
        assert_eq!(file.read(), Stored::Missing);
        file.write(&image()).unwrap();
        assert_eq!(file.read(), Stored::Image(image()));
        let warped = Image { sampled_spreads: vec![0.5, 0.0], ..image() };
        file.write(&warped).unwrap();
        assert_eq!(file.read(), Stored::Image(warped));
        let bytes = std::fs::read(file.path()).unwrap();
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 4;
            std::fs::write(file.path(), &damaged).unwrap();
            assert_eq!(file.read(), Stored::Unusable, "byte {at}");
            std::fs::write(file.path(), &bytes[..at]).unwrap();
            assert_eq!(file.read(), Stored::Unusable, "cut at {at}");
        }
    }

    #[test]
    fn another_description_is_another_image() {
        let folder = tempfile::tempdir().unwrap();
        let file = ReferenceFile::new(folder.path(), "a scene");
        file.write(&image()).unwrap();
        let other = ReferenceFile::new(folder.path(), "b scene");
        assert_ne!(file.path(), other.path());
        std::fs::copy(file.path(), other.path()).unwrap();
        assert_eq!(other.read(), Stored::Unusable);
    }

    /// Published values of FNV-1a.
    #[test]
    fn fingerprints() {
        assert_eq!(fingerprint(b""), "cbf29ce484222325-0");
        assert_eq!(fingerprint(b"a"), "af63dc4c8601ec8c-1");
    }
}
