use rand::{Rng, RngExt};

use crate::{Error, PointSet, Progress, SquareSampler};

/// Returns a shift drawn uniformly from the square.
pub fn uniform_shift(rng: &mut dyn Rng) -> [f64; 2] {
    rng.random()
}

/// Shifts every point of the square modulo 1 (Cranley and Patterson 1976); `by` is in `[0, 1)^2`.
///
/// ```
/// let mut points = [[0.25, 0.75]];
/// sphvar_samplers::shift([0.5, 0.5], &mut points);
/// assert_eq!(points, [[0.75, 0.25]]);
/// ```
pub fn shift(by: [f64; 2], points: &mut [[f64; 2]]) {
    for p in points {
        *p = [shifted(p[0], by[0]), shifted(p[1], by[1])];
    }
}

/// Returns `x + by` modulo 1, in [0, 1), for both in [0, 1).
fn shifted(x: f64, by: f64) -> f64 {
    let sum = x + by;
    if sum >= 1.0 { sum - 1.0 } else { sum }
}

/// A pattern of the square whose every realization is shifted by a uniform random vector, so that
/// every point is uniform in the square.
///
/// The shift comes from the same generator as the set, before it. The ensembles
/// [`SquareRealizations::shifted`](crate::SquareRealizations::shifted) shift any pattern; this is for
/// patterns that are mapped to directions.
#[derive(Clone, Copy, Debug)]
pub struct Shifted<P> {
    pattern: P,
}

impl<P: SquareSampler> Shifted<P> {
    /// Returns `pattern` with a random shift.
    #[must_use]
    pub fn new(pattern: P) -> Self {
        Self { pattern }
    }
}

impl<P: SquareSampler> SquareSampler for Shifted<P> {
    fn n_points(&self) -> usize {
        self.pattern.n_points()
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let by = uniform_shift(rng);
        self.pattern.sample_watched(rng, set, progress)?;
        shift(by, &mut set.points);
        Ok(())
    }

    fn nominal_work(&self) -> f64 {
        self.pattern.nominal_work()
    }

    fn is_independent(&self) -> bool {
        self.pattern.is_independent()
    }
}

#[cfg(test)]
mod tests {
    use super::shift;

    #[test]
    fn shifts_stay_in_the_unit_interval() {
        let below = 1.0 - f64::EPSILON / 2.0;
        for (x, by) in [(0.0, 0.0), (below, below), (0.5, 0.5), (1e-300, below), (0.25, 0.5)] {
            let mut points = [[x, by], [by, x]];
            shift([by, x], &mut points);
            assert!(points.as_flattened().iter().all(|s| (0.0..1.0).contains(s)), "{x} + {by}");
            assert!((points[0][0] - points[0][1]).abs() <= 0.0, "{x} + {by} is not symmetric");
        }
    }
}
