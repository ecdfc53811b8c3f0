use super::distance_penalty::PenaltySpace;
use super::energy::{BandTransform, SpectralEnergy};
use super::freedom;
use super::staged::StagedEnergy;
use crate::Error;
use crate::ensemble::progress::Tick;
use crate::optimization::descent::Descent;

/// Below this number of points, or below this ratio of the last degree to the last vanishing one,
/// all degrees are treated together: their transforms take little more time than the vanishing
/// ones.
pub(crate) const MIN_STAGED: (usize, f64) = (1024, 1.25);

/// Maximum number of steps of one descent: some 5000, in few cases 8000, are needed where the number
/// of vanishing coefficients is the largest feasible.
const MAX_STEPS: u32 = 20_000;

/// Descents from random sets of points until one meets a target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search {
    /// Maximum number of descents.
    pub(crate) starts: u32,
    /// The root of the area per point.
    pub(crate) spacing: f64,
}

impl Search {
    /// Replaces the content of `points` by a set that meets the target of `energy`; `start` appends
    /// a random set to the empty vector. If `staged` has an energy, it is minimized first, which
    /// is enough in most cases. Returns the residuals of the last descent if all stall.
    pub(crate) fn run<T: BandTransform, S: PenaltySpace<Point = T::Point>>(
        self,
        points: &mut Vec<T::Point>,
        mut start: impl FnMut(&mut Vec<T::Point>),
        staged: impl Fn() -> Result<Option<StagedEnergy<T, S>>, Error>,
        energy: impl Fn() -> Result<SpectralEnergy<T, S>, Error>,
        tick: Tick<'_>,
    ) -> Result<Option<[f64; 2]>, Error> {
        let mut reached = [0.0; 2];
        for _ in 0..self.starts {
            points.clear();
            start(points);
            let descent = Descent {
                iterations: MAX_STEPS,
                scale: 1.0,
                is_adaptive: false,
                reach: 8.0 * self.spacing,
            };
            if let Some(mut staged) = staged()? {
                descent.run(points, &mut staged, tick)?;
                if staged.has_arrived(points) {
                    return Ok(None);
                }
            }
            let mut energy = energy()?;
            descent.run(points, &mut energy, tick)?;
            if energy.has_arrived() {
                return Ok(None);
            }
            reached = energy.residuals();
        }
        Ok(Some(reached))
    }

    /// Returns the reason why no descent met the target: the residuals of the last, and the pair
    /// correlation at distance 0 with white noise beyond the target if no pattern has it.
    pub(crate) fn failure(self, reached: [f64; 2], g2: f64) -> String {
        let Self { starts, .. } = self;
        let impossible = if g2 < 0.0 {
            format!(
                "With white noise beyond the target the pair correlation at distance 0 would be {g2:.3}; no \
                 pattern has one below 0. "
            )
        } else {
            String::new()
        };
        format!(
            "{starts} descents stalled before reaching the target, the last with power {:.1e} where there \
             should be none and {:.1e} off elsewhere. {impossible}Use more points, or a smaller alpha, core or \
             range",
            reached[0], reached[1]
        )
    }
}

/// Returns the reason why a target with more zeros than degrees of freedom is infeasible.
pub(crate) fn infeasible_power(constraints: f64, freedom: f64) -> String {
    let max_zeros = freedom::MAX_SHARE * freedom;
    format!(
        "{constraints} coefficients cannot vanish with {freedom} degrees of freedom: at most {} can. Use more \
         points, or a smaller range without power",
        max_zeros.floor()
    )
}

/// Returns the maximum number of descents per set: for some small numbers of points up to two
/// in five stall; with more than 100 points none was observed to stall.
pub(crate) fn starts(n: u32) -> u32 {
    (2048 / n).clamp(4, 16)
}

/// Returns the approximate number of steps of a descent that constrains a fraction f of the degrees
/// of freedom: `8 r (1 + r/25)` with `r = (1 + sqrt f)/(1 - sqrt f)`.
///
/// The gradients of the constraints are like random vectors, whose matrix has the condition number
/// `r^2` (Marchenko and Pastur 1967, doi:10.1070/SM1967v001n04ABEH001994). Conjugate gradients take a
/// number of steps proportional to r; a descent that stores few steps does so up to about 100 steps,
/// and then takes a number proportional to the condition number.
pub(crate) fn descent_steps(share: f64) -> f64 {
    let root = share.min(freedom::MAX_SHARE).sqrt();
    let ratio = (1.0 + root) / (1.0 - root);
    8.0 * ratio * (1.0 + ratio / 25.0)
}

/// Returns the number of steps of a descent that constrains a fraction of the degrees of freedom over
/// that for half of them, and at least 1.
pub(crate) fn relative_steps(share: f64) -> f64 {
    (descent_steps(share) / descent_steps(0.5)).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::descent_steps;

    /// Steps of sets of 200 to 4096 points with zero power up to alpha sqrt(N), alpha from 1 to 1.36, on both
    /// domains: means of two sets or single ones, which vary by a factor of 2 near the limit.
    #[test]
    fn numbers_of_steps_are_those_measured() {
        for (share, measured) in [
            (0.516, 52.0),
            (0.530, 61.0),
            (0.626, 64.0),
            (0.730, 116.0),
            (0.816, 294.0),
            (0.883, 756.0),
            (0.902, 1145.0),
            (0.907, 854.0),
            (0.950, 2478.0),
            (0.963, 4367.0),
        ] {
            let ratio = descent_steps(share) / measured;
            assert!((0.6..1.6).contains(&ratio), "share {share}: {ratio}");
        }
    }
}
