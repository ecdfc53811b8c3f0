use rand_chacha::ChaCha8Rng;

use super::sequential_addition::{End, SequentialAddition};
use super::subdivision::Subdivision;
use crate::Stopped;
use crate::ensemble::progress::Tick;

/// The factor by which the radius decreases once no disk fits.
pub(crate) const DECREASE: f64 = 0.99;

/// Replaces the content of `points` by disks of decreasing radius: random sequential addition with
/// the largest radius until nothing is free, then with the next radius, and so on to `radius`, the
/// smallest one. Ends when there are `limit` points, or when nothing is free for `radius`.
///
/// `largest` is the largest distance of two points of the domain; `space` returns the domain with
/// disks of a radius around given points. With random candidates instead of the free region this is
/// the method of McCool and Fiume 1992 (Proc. Graphics Interface, 94).
pub(crate) fn decreasing_into<S: Subdivision>(
    limit: usize,
    (largest, radius): (f64, f64),
    space: impl Fn(f64, &[S::Output]) -> S,
    rng: &mut ChaCha8Rng,
    points: &mut Vec<S::Output>,
    tick: Tick<'_>,
) -> Result<End, Stopped> {
    points.clear();
    let mut level = n_levels(largest, radius);
    loop {
        let current = radius * DECREASE.powf(-level);
        let end = SequentialAddition::new(space(current, points), rng).run(limit, points, tick)?;
        if end == End::Full || level <= 0.0 {
            return Ok(end);
        }
        level -= 1.0;
    }
}

/// Returns the number of steps from a radius of about `largest` to `radius`.
fn n_levels(largest: f64, radius: f64) -> f64 {
    ((radius / largest).ln() / DECREASE.ln()).max(0.0).floor()
}
