//! The sums of a part of an ensemble's spectrum.

use std::fs;
use std::ops::Range;
use std::path::Path;

use serde::{Deserialize, Serialize};
use sphvar_samplers::Domain;
use sphvar_spectrum::SpectrumAccumulator;

use super::{AtomicFile, FileError, Place};

/// Sums that are exact, so that parts can be put together in any order.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Shard {
    /// What the sums are of.
    pub(crate) ensemble: SavedEnsemble,
    /// Which realizations, in order and without overlap.
    pub(crate) parts: Vec<Range<u64>>,
    pub(crate) sums: SpectrumAccumulator,
}

/// Everything that sums depend on but the realizations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SavedEnsemble {
    pub(crate) sampler: String,
    /// Whether realizations differ: the one of a pattern that is not random has no error.
    pub(crate) is_random: bool,
    pub(crate) domain: Domain,
    pub(crate) lmax: usize,
    /// Method and accuracy of the transforms.
    pub(crate) transform: String,
    pub(crate) seed: u64,
    /// Of this program.
    pub(crate) version: String,
}

/// How the files begin; after it a CRC-32 of the rest, little-endian.
const HEAD: &[u8] = b"sphvar shard 1\n";

impl Shard {
    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(crate) fn write(&self, path: &Path) -> Result<(), FileError> {
        let body = postcard::to_stdvec(self).map_err(|error| FileError::Write {
            path: path.display().to_string(),
            source: std::io::Error::other(error),
        })?;
        let checksum = crc32fast::hash(&body).to_le_bytes();
        AtomicFile::write_whole(path, &[HEAD, &checksum, &body].concat())
    }

    /// Reads a file.
    ///
    /// # Errors
    /// When it cannot be read, is something else or is damaged.
    pub(crate) fn read(path: &Path) -> Result<Self, FileError> {
        let name = path.display().to_string();
        let bytes =
            fs::read(path).map_err(|source| FileError::Open { path: name.clone(), source })?;
        let wrong = |got: &str| FileError::Layout {
            path: name.clone(),
            place: Place::Whole,
            expected: "a file of `sphvar spectrum --save`".to_owned(),
            got: got.to_owned(),
        };
        let rest = bytes.strip_prefix(HEAD).ok_or_else(|| wrong("something else"))?;
        let (checksum, body) =
            rest.split_at_checked(4).ok_or_else(|| wrong("its beginning only"))?;
        if crc32fast::hash(body).to_le_bytes() != checksum {
            return Err(wrong("one that is damaged"));
        }
        postcard::from_bytes(body).map_err(|error| wrong(&error.to_string()))
    }
}
