use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The part of a circle that disks leave free: disjoint arcs of angles in [0, 2 pi).
#[derive(Debug, Default)]
pub(crate) struct FreeArcs {
    arcs: Vec<(f64, f64)>,
    /// The arcs before the last subtraction.
    previous: Vec<(f64, f64)>,
}

impl FreeArcs {
    /// Arcs shorter than this, in radians, count as covered: more than the rounding of the angles
    /// at which two circles meet.
    const MIN_LENGTH: f64 = 1e-12;

    /// Makes the whole circle free.
    pub(crate) fn reset(&mut self) {
        self.arcs.clear();
        self.arcs.push((0.0, TAU));
    }

    /// Removes the angles nearer to `middle` than `half_width`, which is at least 0.
    pub(crate) fn subtract(&mut self, middle: f64, half_width: f64) {
        if half_width >= 0.5 * TAU {
            self.arcs.clear();
            return;
        }
        let start = (middle - half_width).rem_euclid(TAU);
        let end = start + 2.0 * half_width;
        self.cut(start, end);
        if end > TAU {
            self.cut(0.0, end - TAU);
        }
    }

    fn cut(&mut self, start: f64, end: f64) {
        std::mem::swap(&mut self.arcs, &mut self.previous);
        self.arcs.clear();
        for &(from, to) in &self.previous {
            let rest = [(from, to.min(start)), (from.max(end), to)];
            self.arcs.extend(rest.iter().filter(|(from, to)| to - from > Self::MIN_LENGTH));
        }
    }

    /// Returns an angle that is uniform on the arcs; `None` if nothing is free.
    pub(crate) fn uniform_angle(&self, rng: &mut ChaCha8Rng) -> Option<f64> {
        let &(_, last) = self.arcs.last()?;
        let total: f64 = self.arcs.iter().map(|(from, to)| to - from).sum();
        let mut rest = total * rng.random::<f64>();
        for &(from, to) in &self.arcs {
            if rest < to - from {
                return Some(from + rest);
            }
            rest -= to - from;
        }
        // Only by rounding.
        Some(last)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::{FreeArcs, TAU};

    /// The reference counts points of a fine grid of angles outside all intervals.
    #[test]
    fn free_arcs_are_those_outside_all_intervals() {
        const STEPS: usize = 20_000;
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..200 {
            let intervals: Vec<(f64, f64)> = (0..rng.random_range(0..6))
                .map(|_| (20.0 * rng.random::<f64>() - 10.0, 1.2 * rng.random::<f64>()))
                .collect();
            let mut arcs = FreeArcs::default();
            arcs.reset();
            intervals.iter().for_each(|&(middle, half)| arcs.subtract(middle, half));
            let is_free = |angle: f64| {
                let off = |middle: f64| (angle - middle + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU;
                intervals.iter().all(|&(middle, half)| off(middle).abs() > half)
            };
            let free = (0..STEPS).filter(|&k| is_free(TAU * k as f64 / STEPS as f64)).count();
            let length: f64 = arcs.arcs.iter().map(|(from, to)| to - from).sum();
            // Each end of an arc may be off by a step.
            let off = length - TAU * free as f64 / STEPS as f64;
            assert!(off.abs() < 14.0 * TAU / STEPS as f64, "{intervals:?}: {off}");
            match arcs.uniform_angle(&mut rng) {
                Some(angle) => assert!(is_free(angle) && (0.0..=TAU).contains(&angle)),
                None => assert_eq!(free, 0, "{intervals:?}"),
            }
        }
    }
}
