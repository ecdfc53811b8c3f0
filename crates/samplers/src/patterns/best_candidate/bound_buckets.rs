use rand::{Rng, RngExt};

use super::cell_place::{LAST_LEVEL, area};

/// The number of binary digits of a bound after the first that tell buckets apart: the bounds of a
/// bucket differ by at most 0.4 %.
pub(super) const BUCKET_BITS: u32 = 8;

/// More than every bound.
const TOP: f64 = 4.0;

/// The number of digits of a bound that buckets do not distinguish.
const SHIFT: u32 = f64::MANTISSA_DIGITS - 1 - BUCKET_BITS;

const N_LEVELS: usize = LAST_LEVEL as usize + 1;

/// Leaves by their bounds, the largest bounds first: a bucket has those whose bounds have the same
/// leading digits, by level.
#[derive(Debug, Default)]
pub(super) struct BoundBuckets {
    /// The areas of the buckets in units of the smallest cells.
    areas: Vec<u64>,
    /// The leaves of each bucket and level.
    leaves: Vec<Vec<u32>>,
    /// Where each leaf is in its list.
    places: Vec<u32>,
    /// No bucket before this one has leaves.
    first: usize,
}

impl BoundBuckets {
    /// Returns the first bucket that has leaves, of which there is one.
    pub(super) fn first(&mut self) -> usize {
        while self.areas[self.first] == 0 {
            self.first += 1;
        }
        self.first
    }

    /// Returns the area of a bucket in units of the smallest cells.
    pub(super) fn area(&self, bucket: usize) -> u64 {
        self.areas[bucket]
    }

    /// Returns the leaf of a level that has entered a bucket last.
    pub(super) fn last_of_level(&self, bucket: usize, level: u8) -> Option<u32> {
        self.leaves[bucket * N_LEVELS + usize::from(level)].last().copied()
    }

    /// Adds a leaf.
    pub(super) fn enter(&mut self, leaf: u32, level: u8, bound: f64) {
        let bucket = bucket_of(bound);
        if bucket >= self.areas.len() {
            self.areas.resize(bucket + 1, 0);
            self.leaves.resize_with((bucket + 1) * N_LEVELS, Vec::new);
        }
        if leaf as usize >= self.places.len() {
            self.places.resize(leaf as usize + 1, 0);
        }
        self.first = self.first.min(bucket);
        self.areas[bucket] += area(level);
        let leaves = &mut self.leaves[bucket * N_LEVELS + usize::from(level)];
        // Cells have 32-bit numbers.
        self.places[leaf as usize] = u32::try_from(leaves.len()).unwrap_or(u32::MAX);
        leaves.push(leaf);
    }

    /// Removes a leaf.
    pub(super) fn leave(&mut self, leaf: u32, level: u8, bound: f64) {
        let bucket = bucket_of(bound);
        self.areas[bucket] -= area(level);
        let leaves = &mut self.leaves[bucket * N_LEVELS + usize::from(level)];
        let place = self.places[leaf as usize];
        leaves.swap_remove(place as usize);
        if let Some(&moved) = leaves.get(place as usize) {
            self.places[moved as usize] = place;
        }
    }

    /// Returns a random leaf of a bucket, with probability proportional to its area, or `None` if
    /// it has none.
    pub(super) fn random_leaf(&self, bucket: usize, rng: &mut dyn Rng) -> Option<u32> {
        if self.areas[bucket] == 0 {
            return None;
        }
        let mut at = rng.random_range(0..self.areas[bucket]);
        for level in 0..=LAST_LEVEL {
            let leaves = &self.leaves[bucket * N_LEVELS + usize::from(level)];
            let index = at / area(level);
            match usize::try_from(index).ok().and_then(|index| leaves.get(index)) {
                Some(&leaf) => return Some(leaf),
                None => at -= leaves.len() as u64 * area(level),
            }
        }
        None
    }

    #[cfg(test)]
    pub(super) fn n_buckets(&self) -> usize {
        self.areas.len()
    }

    /// Returns the leaves of a bucket and level, after a check that each knows its place.
    #[cfg(test)]
    pub(super) fn leaves(&self, bucket: usize, level: u8) -> &[u32] {
        let leaves = &self.leaves[bucket * N_LEVELS + usize::from(level)];
        for (place, &leaf) in leaves.iter().enumerate() {
            assert_eq!(self.places[leaf as usize] as usize, place);
        }
        leaves
    }
}

/// Returns the bucket of a bound.
pub(super) fn bucket_of(bound: f64) -> usize {
    // Fewer than 2^(BUCKET_BITS + 6), since bounds are not below the radius of the smallest cells.
    usize::try_from((TOP.to_bits() - bound.to_bits()) >> SHIFT).unwrap_or(usize::MAX)
}

/// Returns the largest bound of a bucket.
pub(super) fn largest_bound(bucket: usize) -> f64 {
    f64::from_bits(TOP.to_bits() - ((bucket as u64) << SHIFT))
}
