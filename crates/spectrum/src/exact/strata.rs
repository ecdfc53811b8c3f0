//! The spectrum of one uniform point per stratum, by the method with less nominal work.

use sphvar_samplers::Progress;

use super::cell_means;
use super::chord_moments::{self, ChordMoments};
use super::partition::Partition;
use crate::Error;

/// Returns the power of degrees 0 to `lmax`; the entry of degree 0 is 0 instead of N.
pub(super) fn power(
    partition: &Partition,
    lmax: usize,
    progress: &dyn Progress,
) -> Result<Vec<f64>, Error> {
    let by_chords = degrees_by_chords(partition, lmax);
    let count = chord_moments::n_moments(by_chords, partition.longest_chord_squared());
    let low = ChordMoments::new(partition, by_chords, count, progress)?.power(by_chords);
    if by_chords == lmax {
        return Ok(low);
    }
    let mut power = cell_means::power(partition, lmax, lmax, progress)?;
    power[..=by_chords].copy_from_slice(&low);
    Ok(power)
}

/// Returns the nominal work that [`power`] ticks.
pub(super) fn work(partition: &Partition, lmax: usize) -> f64 {
    let by_chords = degrees_by_chords(partition, lmax);
    let rest = if by_chords == lmax { 0.0 } else { cell_means::work(partition, lmax) };
    chord_moments::work(partition, by_chords) + rest
}

/// Returns the memory in bytes that [`power`] needs on `threads` threads.
pub(super) fn bytes(partition: &Partition, lmax: usize, threads: usize) -> f64 {
    let by_chords = degrees_by_chords(partition, lmax);
    let each = if by_chords == lmax {
        chord_moments::bytes(partition, lmax)
    } else {
        cell_means::bytes(partition, lmax)
    };
    partition.n_rows().min(threads.max(1)) as f64 * each
}

/// Returns the maximum degree computed by chords: `lmax`, or about sqrt(N) where cell means are
/// less expensive. Beyond sqrt(N) the power is not small, so a difference from 1 is accurate
/// enough.
fn degrees_by_chords(partition: &Partition, lmax: usize) -> usize {
    if chord_moments::work(partition, lmax) <= cell_means::work(partition, lmax) {
        return lmax;
    }
    // The chord of a stratum is about 2 spacings long.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the bound is positive; a cast saturates"
    )]
    let low = (8.0 / partition.longest_chord_squared().sqrt()) as usize;
    low.min(lmax)
}
