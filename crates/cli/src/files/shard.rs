//! The sums of a part of an ensemble's spectrum.

use std::fmt;
use std::fs;
use std::io::Read;
use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sphvar_samplers::Domain;
use sphvar_sh::Frequencies;
use sphvar_spectrum::{Error, RadialAccumulator, SpectrumAccumulator};

use super::used_files::record_input;
use super::{AtomicFile, FileError, Place};

/// Exact sums, which can be merged in any order.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound = "S: ShardSums")]
pub(crate) struct Shard<S: ShardSums = SpectrumAccumulator> {
    /// The ensemble of the sums.
    pub(crate) ensemble: SavedEnsemble<S::Domain>,
    /// The parts of its realizations, in order and without overlap.
    pub(crate) parts: Vec<Part>,
    pub(crate) sums: S,
}

/// The sums of a spectrum, on the sphere or on the square.
pub(crate) trait ShardSums: Clone + fmt::Debug + Serialize + DeserializeOwned {
    /// The rest of the first line of the files in this version of their format; a CRC-32 of the rest
    /// of the file follows, little-endian.
    const FORM: &'static [u8];

    /// The domain, as far as the sums do not determine it.
    type Domain: Clone + fmt::Debug + Serialize + DeserializeOwned;

    /// Returns whether the sums are of this number of realizations, and of this ensemble.
    fn are_of(&self, realizations: u64, ensemble: &SavedEnsemble<Self::Domain>) -> bool;

    /// Adds the realizations of other sums exactly.
    fn try_merge(&mut self, other: &Self) -> Result<(), Error>;
}

impl ShardSums for SpectrumAccumulator {
    const FORM: &'static [u8] = b"4\n";

    type Domain = Domain;

    fn are_of(&self, realizations: u64, ensemble: &SavedEnsemble) -> bool {
        self.realizations() == Some(realizations)
            && self.lmax() == Some(ensemble.lmax)
            && self.domain() == ensemble.domain
            && self.n_points() > 0
    }

    fn try_merge(&mut self, other: &Self) -> Result<(), Error> {
        self.try_merge(other)
    }
}

/// The sums of a spectrum on the square and of its radial mean.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct SquareSums {
    pub(crate) spectrum: SpectrumAccumulator<Frequencies>,
    pub(crate) radial: RadialAccumulator,
}

impl ShardSums for SquareSums {
    const FORM: &'static [u8] = b"square 1\n";

    type Domain = ();

    fn are_of(&self, realizations: u64, ensemble: &SavedEnsemble<()>) -> bool {
        let Self { spectrum, radial } = self;
        let bands = spectrum.bands();
        // Without complete rings there is no radial mean.
        let has_rings = bands.kmax() > 1;
        spectrum.realizations() == Some(realizations)
            && spectrum.lmax() == Some(bands.len() - 1)
            && bands.kmax() == ensemble.lmax
            && radial.frequencies() == bands
            && radial.realizations() == has_rings.then_some(realizations)
            && spectrum.n_points() > 0
    }

    fn try_merge(&mut self, other: &Self) -> Result<(), Error> {
        // The radial means name the frequencies that differ.
        self.radial.try_merge(&other.radial)?;
        self.spectrum.try_merge(&other.spectrum)
    }
}

/// One of several equal parts of an ensemble, `I/K`, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Part {
    pub(crate) part: u64,
    pub(crate) parts: u64,
}

/// All quantities that the sums depend on except the realizations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SavedEnsemble<D = Domain> {
    pub(crate) sampler: String,
    /// Whether realizations differ; the single realization of a deterministic pattern has no error.
    pub(crate) is_random: bool,
    pub(crate) domain: D,
    /// The largest degree or, on the square, the largest frequency.
    pub(crate) lmax: usize,
    /// The number of realizations of the whole ensemble.
    pub(crate) realizations: u64,
    /// Method and accuracy of the transforms.
    pub(crate) transform: String,
    pub(crate) seed: u64,
    /// The version of this program.
    pub(crate) version: String,
    /// The instruction set of the machine, because others round differently.
    pub(crate) instruction_set: String,
}

/// The first bytes of the files, in every version of the format.
const NAME: &[u8] = b"sphvar shard ";

impl Part {
    /// The whole ensemble.
    pub(crate) const WHOLE: Self = Self { part: 1, parts: 1 };

    /// Returns the realizations of this part of `count`; the sizes of parts differ by at most one.
    pub(crate) fn range(self, count: u64) -> Range<u64> {
        let end = |part: u64| {
            let wide = u128::from(count) * u128::from(part) / u128::from(self.parts);
            u64::try_from(wide).unwrap_or(count)
        };
        end(self.part - 1)..end(self.part)
    }

    /// Returns the one of `parts` parts of `count` realizations that contains realization
    /// `realization`, which is below `count`.
    pub(crate) fn of_realization(realization: u64, count: u64, parts: u64) -> Self {
        let wide = (u128::from(realization) + 1) * u128::from(parts);
        let part = u64::try_from(wide.div_ceil(u128::from(count))).unwrap_or(parts);
        Self { part, parts }
    }

    fn is_valid(self) -> bool {
        1 <= self.part && self.part <= self.parts
    }
}

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers =
            text.split_once('/').and_then(|(i, k)| Some((i.parse().ok()?, k.parse().ok()?)));
        numbers
            .map(|(part, parts)| Self { part, parts })
            .filter(|part| part.is_valid())
            .ok_or_else(|| format!("expected I/K with 1 <= I <= K as in 2/4, got \"{text}\""))
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.part, self.parts)
    }
}

impl<S: ShardSums> Shard<S> {
    /// Writes the file, complete or not at all.
    ///
    /// # Errors
    ///
    /// If it cannot be written.
    pub(crate) fn write(&self, path: &Path) -> Result<(), FileError> {
        let body = postcard::to_stdvec(self).map_err(|error| FileError::Write {
            path: path.display().to_string(),
            source: std::io::Error::other(error),
        })?;
        let checksum = crc32fast::hash(&body).to_le_bytes();
        AtomicFile::write_whole(path, &[NAME, S::FORM, &checksum, &body].concat())
    }

    /// Reads a file.
    ///
    /// # Errors
    ///
    /// If it cannot be read, has another format or is damaged.
    pub(crate) fn read(path: &Path) -> Result<Self, FileError> {
        let name = path.display().to_string();
        let bytes =
            fs::read(path).map_err(|source| FileError::Open { path: name.clone(), source })?;
        record_input(path);
        let wrong = |got: &str| FileError::Layout {
            path: name.clone(),
            place: Place::Whole,
            expected: "a file of `sphvar spectrum --save`".to_owned(),
            got: got.to_owned(),
        };
        let rest = bytes.strip_prefix(NAME).ok_or_else(|| wrong("something else"))?;
        let rest = rest.strip_prefix(S::FORM).ok_or_else(|| {
            let is_of_square = |form: &[u8]| form.starts_with(b"square");
            if is_of_square(rest) != is_of_square(S::FORM) {
                return wrong("one of another domain: the unit square and the sphere do not mix");
            }
            wrong("one of another version of sphvar, whose sums cannot be added to those of this one; create it again")
        })?;
        let (checksum, body) =
            rest.split_at_checked(4).ok_or_else(|| wrong("its beginning only"))?;
        if crc32fast::hash(body).to_le_bytes() != checksum {
            return Err(wrong("a damaged one"));
        }
        let shard: Self = postcard::from_bytes(body).map_err(|_| wrong("other content"))?;
        if shard.is_whole() {
            Ok(shard)
        } else {
            Err(wrong("sums that do not fit its realizations"))
        }
    }

    /// Returns the realizations in it, part by part.
    pub(crate) fn ranges(&self) -> Vec<Range<u64>> {
        self.parts.iter().map(|part| part.range(self.ensemble.realizations)).collect()
    }

    /// Returns the missing realizations.
    pub(crate) fn missing(&self) -> Vec<Range<u64>> {
        let mut missing = Vec::new();
        let mut next = 0;
        let end = self.ensemble.realizations;
        for range in self.ranges().into_iter().chain(std::iter::once(end..end)) {
            if next < range.start {
                missing.push(next..range.start);
            }
            next = range.end;
        }
        missing
    }

    /// Returns whether the sums are consistent with the number of realizations; those of this
    /// program always are.
    pub(crate) fn is_whole(&self) -> bool {
        let Self { ensemble, parts, sums } = self;
        if parts.is_empty() || !parts.iter().all(|part| part.is_valid()) {
            return false;
        }
        let ranges = self.ranges();
        let apart = ranges.windows(2).all(|pair| pair[0].end <= pair[1].start);
        let filled = ranges.iter().all(|range| range.start < range.end);
        filled
            && apart
            && sums.are_of(ranges.iter().map(|range| range.end - range.start).sum(), ensemble)
    }

    /// Returns whether a file begins as one of these shards.
    pub(crate) fn begins(path: &Path) -> bool {
        let mut start = vec![0; NAME.len() + S::FORM.len()];
        let read = fs::File::open(path).and_then(|mut file| file.read_exact(&mut start));
        read.is_ok() && start == [NAME, S::FORM].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::{Domain, Part, SavedEnsemble, Shard, SpectrumAccumulator};

    fn shard(parts: &[(u64, u64)], lmax: usize, n_points: usize) -> Shard {
        let ensemble = SavedEnsemble {
            sampler: "white-noise".to_owned(),
            is_random: true,
            domain: Domain::Sphere,
            lmax: 3,
            transform: String::new(),
            seed: 0,
            version: String::new(),
            realizations: 10,
            instruction_set: String::new(),
        };
        let parts = parts.iter().map(|&(part, parts)| Part { part, parts }).collect();
        Shard { ensemble, parts, sums: SpectrumAccumulator::new(Domain::Sphere, n_points, lmax) }
    }

    #[test]
    fn digits_that_exceed_the_memory_are_rejected() {
        use sphvar_spectrum::ExactSum;
        let mut sum = ExactSum::default();
        sum.add(0.1);
        let whole = postcard::to_stdvec(&sum).unwrap();
        let back: ExactSum = postcard::from_bytes(&whole).unwrap();
        assert_eq!(back.value().to_bits(), 0.1_f64.to_bits());
        // No digits, the first at 2^35 or at 100, none pending, and 0.0.
        for first in [&[0x80, 0x80, 0x80, 0x80, 0x80, 0x01][..], &[100]] {
            let crafted = [&[0], first, &[0], &[0; 8]].concat();
            assert!(postcard::from_bytes::<ExactSum>(&crafted).is_err(), "{first:?}");
        }
    }

    #[test]
    fn parts_are_equal_and_missing_ones_are_known() {
        for (count, parts) in [(10_u64, 3_u64), (7, 7), (u64::MAX, 5), (3, 8)] {
            let ranges: Vec<_> =
                (1..=parts).map(|part| Part { part, parts }.range(count)).collect();
            assert_eq!((ranges[0].start, ranges[ranges.len() - 1].end), (0, count));
            assert!(ranges.windows(2).all(|pair| pair[0].end == pair[1].start), "{ranges:?}");
            for range in ranges.iter().filter(|range| !range.is_empty()) {
                for realization in [range.start, range.end - 1] {
                    let part = Part::of_realization(realization, count, parts);
                    assert_eq!(part.range(count), *range, "{realization} of {count}");
                }
            }
            let sizes = || ranges.iter().map(|range| range.end - range.start);
            assert!(sizes().max().unwrap() - sizes().min().unwrap() <= 1, "{ranges:?}");
        }
        // Of ten: 0..3, 3..6, 6..10 and 9..10.
        assert_eq!(shard(&[(1, 3), (2, 3), (3, 3)], 3, 5).missing(), []);
        assert_eq!(shard(&[(2, 3), (10, 10)], 3, 5).missing(), [0..3, 6..9]);
        assert_eq!(shard(&[(2, 3)], 3, 5).missing(), [0..3, 6..10]);
        for text in ["", "1", "0/2", "3/2", "1/0", "-1/2", "1/2/3", "a/b"] {
            assert!(text.parse::<Part>().is_err(), "{text}");
        }
        assert_eq!("2/3".parse::<Part>().unwrap().to_string(), "2/3");
    }

    /// Files with a correct checksum and inconsistent content.
    #[test]
    fn sums_of_other_realizations_are_rejected() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.shard");
        for (what, wrong) in [
            ("nothing was accumulated", shard(&[(1, 5)], 3, 5)),
            ("no parts", shard(&[], 3, 5)),
            ("a part of none", shard(&[(0, 0)], 3, 5)),
            ("part 0", shard(&[(0, 2)], 3, 5)),
            ("a part beyond the last", shard(&[(5, 1)], 3, 5)),
            ("an empty part", shard(&[(1, 11)], 3, 5)),
            ("parts that overlap", shard(&[(1, 2), (1, 3)], 3, 5)),
            ("other degrees", shard(&[(1, 10)], 2, 5)),
            ("no points", shard(&[(1, 10)], 3, 0)),
        ] {
            wrong.write(&path).unwrap();
            let message = Shard::<SpectrumAccumulator>::read(&path).unwrap_err().to_string();
            assert!(message.contains("do not fit"), "{what}: {message}");
        }
    }
}
