//! The sums of a part of an ensemble's spectrum, which a program keeps in memory.

use std::fmt;
use std::ops::Range;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sphvar_samplers::Domain;
use sphvar_sh::Frequencies;
use sphvar_spectrum::{Error, RadialAccumulator, SpectrumAccumulator};

use crate::shards::Part;

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
    /// The domain, as far as the sums do not determine it.
    type Domain: Clone + fmt::Debug + Serialize + DeserializeOwned;

    /// Returns whether the sums are of this number of realizations, and of this ensemble.
    fn are_of(&self, realizations: u64, ensemble: &SavedEnsemble<Self::Domain>) -> bool;

    /// Adds the realizations of other sums exactly.
    fn try_merge(&mut self, other: &Self) -> Result<(), Error>;
}

impl ShardSums for SpectrumAccumulator {
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

impl<S: ShardSums> Shard<S> {
    /// Returns the realizations in it, part by part.
    pub(crate) fn ranges(&self) -> Vec<Range<u64>> {
        self.parts.iter().map(|part| part.range(self.ensemble.realizations)).collect()
    }

    /// Returns whether the sums are consistent with the number of realizations; those of this
    /// program always are.
    pub(crate) fn is_whole(&self) -> bool {
        let Self { ensemble, parts, sums } = self;
        let is_valid = |part: &Part| 1 <= part.part && part.part <= part.parts;
        if parts.is_empty() || !parts.iter().all(is_valid) {
            return false;
        }
        let ranges = self.ranges();
        let apart = ranges.windows(2).all(|pair| pair[0].end <= pair[1].start);
        let filled = ranges.iter().all(|range| range.start < range.end);
        filled
            && apart
            && sums.are_of(ranges.iter().map(|range| range.end - range.start).sum(), ensemble)
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

    /// Sums from outside with inconsistent content.
    #[test]
    fn sums_of_other_realizations_are_rejected() {
        for (what, wrong) in [
            ("nothing was accumulated", shard(&[(1, 5)], 3, 5)),
            ("no parts", shard(&[], 3, 5)),
            ("a part of none", shard(&[(0, 0)], 3, 5)),
            ("part 0", shard(&[(0, 2)], 3, 5)),
            ("a part beyond the last", shard(&[(5, 1)], 3, 5)),
            ("an empty part", shard(&[(11, 11)], 3, 5)),
            ("parts that overlap", shard(&[(1, 2), (1, 3)], 3, 5)),
            ("other degrees", shard(&[(1, 10)], 2, 5)),
            ("no points", shard(&[(1, 10)], 3, 0)),
        ] {
            assert!(!wrong.is_whole(), "{what}");
        }
    }
}
