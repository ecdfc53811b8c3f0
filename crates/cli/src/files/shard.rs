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
const HEAD: &[u8] = b"sphvar shard 2\n";

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
        let shard: Self = postcard::from_bytes(body).map_err(|error| wrong(&error.to_string()))?;
        if shard.is_whole() {
            Ok(shard)
        } else {
            Err(wrong("sums that do not fit its realizations"))
        }
    }

    /// Whether the sums can be those of the realizations: nothing that this program writes fails here.
    fn is_whole(&self) -> bool {
        let Self { ensemble, parts, sums } = self;
        let apart = parts.windows(2).all(|pair| pair[0].end < pair[1].start);
        let filled = !parts.is_empty() && parts.iter().all(|part| part.start < part.end);
        let count: u64 = parts
            .iter()
            .fold(0_u64, |sum, part| sum.saturating_add(part.end.saturating_sub(part.start)));
        filled
            && apart
            && sums.realizations() == Some(count)
            && sums.lmax() == Some(ensemble.lmax)
            && sums.domain() == ensemble.domain
            && sums.n_points() > 0
    }
}

#[cfg(test)]
mod tests {
    use super::{Domain, SavedEnsemble, Shard, SpectrumAccumulator};

    fn shard(parts: &[(u64, u64)], lmax: usize, n_points: usize) -> Shard {
        let ensemble = SavedEnsemble {
            sampler: "white-noise".to_owned(),
            is_random: true,
            domain: Domain::Sphere,
            lmax: 3,
            transform: String::new(),
            seed: 0,
            version: String::new(),
        };
        let parts = parts.iter().map(|part| part.0..part.1).collect();
        Shard { ensemble, parts, sums: SpectrumAccumulator::new(Domain::Sphere, n_points, lmax) }
    }

    #[test]
    fn digits_that_would_fill_the_memory_are_refused() {
        use sphvar_spectrum::ExactSum;
        let mut sum = ExactSum::default();
        sum.add(0.1);
        let whole = postcard::to_stdvec(&sum).unwrap();
        let back: ExactSum = postcard::from_bytes(&whole).unwrap();
        assert_eq!(back.value().to_bits(), 0.1_f64.to_bits());
        // No digits, the first of them at 2^35 or at 100, nothing pending, and 0.0.
        for first in [&[0x80, 0x80, 0x80, 0x80, 0x80, 0x01][..], &[100]] {
            let crafted = [&[0], first, &[0], &[0; 8]].concat();
            assert!(postcard::from_bytes::<ExactSum>(&crafted).is_err(), "{first:?}");
        }
    }

    /// Files whose checksum is right and whose content is not.
    #[test]
    fn sums_of_other_realizations_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.shard");
        for (what, wrong) in [
            ("nothing was accumulated", shard(&[(0, 2)], 3, 5)),
            ("no parts", shard(&[], 3, 5)),
            ("an empty part", shard(&[(0, 0)], 3, 5)),
            ("a reversed part", shard(&[(5, 1)], 3, 5)),
            ("parts that overlap", shard(&[(0, 4), (2, 6)], 3, 5)),
            ("other degrees", shard(&[(0, 1)], 2, 5)),
            ("no points", shard(&[(0, 1)], 3, 0)),
        ] {
            wrong.write(&path).unwrap();
            let message = Shard::read(&path).unwrap_err().to_string();
            assert!(message.contains("do not fit"), "{what}: {message}");
        }
    }
}
