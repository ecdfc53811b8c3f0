use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The purpose of a family of random streams; two purposes never share random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Purpose {
    /// The realizations of a pattern: sampling it and estimating its spectrum.
    Pattern,
    /// The trials of a measured variance, which must be independent of the spectrum that
    /// predicts it.
    Trial,
    /// Resampling of results, for intervals.
    Resample,
}

/// A family of independent random streams, one per realization.
///
/// The generator is `ChaCha8` (Bernstein 2008, 8 rounds), a counter-based generator whose
/// output is fully specified. Its 256-bit key consists of (seed, purpose, group); its 64-bit stream
/// number is the realization. Results therefore depend on these numbers alone, never on threads,
/// order or shards.
///
/// ```
/// use rand::Rng;
/// use sphvar_samplers::{Purpose, Streams};
/// let streams = Streams::new(7, Purpose::Pattern, 1024);
/// assert_eq!(streams.realization(3).next_u64(), streams.realization(3).next_u64());
/// assert_ne!(streams.realization(3).next_u64(), streams.realization(4).next_u64());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Streams {
    key: [u8; 32],
}

impl Streams {
    /// Returns the family of streams of `seed` for one purpose. `group` distinguishes ensembles of
    /// one run that must not share numbers; see
    /// [`Pattern::stream_group`](crate::Pattern::stream_group).
    #[must_use]
    pub fn new(seed: u64, purpose: Purpose, group: usize) -> Self {
        let purpose: u64 = match purpose {
            Purpose::Pattern => 0,
            Purpose::Trial => 1,
            Purpose::Resample => 2,
        };
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&purpose.to_le_bytes());
        key[16..24].copy_from_slice(&(group as u64).to_le_bytes());
        // "sphvar 1": any change to the use of streams requires a new version here and an entry
        // under Value-breaking in the change log.
        key[24..].copy_from_slice(b"sphvar 1");
        Self { key }
    }

    /// Returns the generator of one realization, at its start.
    #[must_use]
    pub fn realization(&self, index: u64) -> ChaCha8Rng {
        generator(self.key, index)
    }

    /// Returns the generator of the rotation or shift of one realization, independent of
    /// [`Self::realization`].
    #[must_use]
    pub fn randomization(&self, index: u64) -> ChaCha8Rng {
        let mut key = self.key;
        key[24..].copy_from_slice(b"rotate 1");
        generator(key, index)
    }
}

fn generator(key: [u8; 32], index: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::from_seed(key);
    rng.set_stream(index);
    rng
}

#[cfg(test)]
mod tests {
    use rand::Rng;

    use super::{Purpose, Streams};

    #[test]
    fn every_part_of_the_key_changes_the_numbers() {
        let first = |seed, purpose, group, realization| {
            Streams::new(seed, purpose, group).realization(realization).next_u64()
        };
        let all = [
            first(0, Purpose::Pattern, 12, 0),
            first(1, Purpose::Pattern, 12, 0),
            first(0, Purpose::Trial, 12, 0),
            first(0, Purpose::Resample, 12, 0),
            first(0, Purpose::Pattern, 48, 0),
            first(0, Purpose::Pattern, 12, 1),
        ];
        let other = Streams::new(0, Purpose::Pattern, 12).randomization(0).next_u64();
        assert!(!all.contains(&other), "{other:x} is among {all:x?}");
        for (i, a) in all.iter().enumerate() {
            for b in &all[i + 1..] {
                assert_ne!(a, b, "two streams start alike: {all:x?}");
            }
        }
    }
}
