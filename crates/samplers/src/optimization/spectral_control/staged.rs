use super::distance_penalty::PenaltySpace;
use super::energy::{BandTransform, NEAR, SpectralEnergy};
use crate::optimization::descent::Objective;

/// The powers of vanishing bands, and the deviation of other powers from their targets, below which
/// the vanishing bands are treated alone. The rest of the descent changes the other powers by less
/// than the difference to [`NEAR`].
const SETTLED: [f64; 2] = [1e-13, 0.25 * NEAR];

/// The energy of a target that vanishes up to some band: of all bands until those beyond have their
/// powers, then of the vanishing ones alone.
///
/// Powers are sums of many squares with a tolerance of 1e-6, and zeros must be exact to 1e-10 of
/// the amplitude. The last quarter of a descent therefore only changes the vanishing bands, whose
/// transforms are several times smaller.
pub(crate) struct StagedEnergy<T: BandTransform, S: PenaltySpace> {
    all: SpectralEnergy<T, S>,
    vanishing: SpectralEnergy<T, S>,
    is_last_stage: bool,
}

impl<T: BandTransform, S: PenaltySpace<Point = T::Point>> StagedEnergy<T, S> {
    /// Returns the energy of all bands followed by that of the vanishing ones.
    pub(crate) fn new(all: SpectralEnergy<T, S>, vanishing: SpectralEnergy<T, S>) -> Self {
        Self { all, vanishing: vanishing.into_fine(), is_last_stage: false }
    }

    /// Returns whether the points of the last call have the target spectrum and the minimum
    /// distance.
    pub(crate) fn has_arrived(&mut self, points: &[T::Point]) -> bool {
        if !self.is_last_stage {
            return self.all.has_arrived();
        }
        // The zeros are at the limit of the accuracy, so each transform judges its own.
        self.all.energy(points);
        let [_, others] = self.all.residuals();
        self.vanishing.has_arrived() && others <= NEAR
    }
}

impl<T, S> Objective<T::Point> for StagedEnergy<T, S>
where
    T: BandTransform,
    S: PenaltySpace<Point = T::Point>,
{
    fn energy(&mut self, points: &[T::Point]) -> f64 {
        if self.is_last_stage { self.vanishing.energy(points) } else { self.all.energy(points) }
    }

    fn gradient(&mut self, points: &[T::Point], gradient: &mut Vec<T::Point>) {
        if self.is_last_stage {
            self.vanishing.gradient(points, gradient);
        } else {
            self.all.gradient(points, gradient);
        }
    }

    fn is_final(&mut self, energy: f64, squared_slope: f64) -> bool {
        if self.is_last_stage {
            return self.vanishing.is_final(energy, squared_slope);
        }
        let is_final = self.all.is_final(energy, squared_slope);
        let [vanishing, others] = self.all.residuals();
        self.is_last_stage =
            !is_final && self.all.is_fine() && vanishing <= SETTLED[0] && others <= SETTLED[1];
        is_final
    }
}
