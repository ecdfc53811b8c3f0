use std::f64::consts::TAU;

use rand::{Rng, RngExt};
use sphvar_integrands::Heuristic;
use sphvar_samplers::{PointSet, Streams, shift, uniform_shift};

use super::density::LocalDensity;
use crate::{Density, DirectionSets, Directions, Error, SetWeight, ShadingPoint};

/// The sets of one render for importance sampling.
///
/// Created by [`WarpedPlan::prepare`](crate::WarpedPlan::prepare).
#[derive(Debug)]
pub struct WarpedSets {
    densities: Vec<SampledDensity>,
    heuristic: Heuristic,
    n_points: usize,
    own_work: f64,
    streams: Streams,
    first_stream: u64,
}

/// A density with the sets that sample it.
#[derive(Debug)]
pub(crate) struct SampledDensity {
    density: Density,
    share: f64,
    /// Sets with weights that sum to 1, or without weights.
    sets: Vec<PointSet<[f64; 2]>>,
}

impl SampledDensity {
    pub(crate) fn new(density: Density, share: f64, mut sets: Vec<PointSet<[f64; 2]>>) -> Self {
        for set in &mut sets {
            set.normalize_weights();
            let sum = set.weight_sums().0;
            set.weights.iter_mut().for_each(|weight| *weight /= sum);
        }
        Self { density, share, sets }
    }

    /// Returns a random set.
    fn choose(&self, rng: &mut dyn Rng) -> &PointSet<[f64; 2]> {
        // A single set needs no random number.
        let chosen = if self.sets.len() == 1 { 0 } else { rng.random_range(0..self.sets.len()) };
        &self.sets[chosen]
    }
}

impl WarpedSets {
    pub(crate) fn new(
        densities: Vec<SampledDensity>,
        heuristic: Heuristic,
        n_points: usize,
        own_work: f64,
        streams: Streams,
        render: u64,
    ) -> Self {
        let first_stream = render * (DirectionSets::MAX_HITS + 1);
        Self { densities, heuristic, n_points, own_work, streams, first_stream }
    }

    /// Returns w/p for a direction that density `strategy` drew with density `drawn`, where w is its
    /// weight in the heuristic.
    fn weight_over_density(
        &self,
        strategy: usize,
        drawn: f64,
        others: impl Fn(usize) -> f64,
    ) -> f64 {
        let share = |i: usize| self.densities[i].share;
        let own = share(strategy) * drawn;
        // Relative to this density, so that squares neither overflow nor underflow.
        let ratio = |i: usize| if i == strategy { 1.0 } else { share(i) * others(i) / own };
        let ratios = (0..self.densities.len()).map(ratio);
        let sum: f64 = match self.heuristic {
            Heuristic::Balance => ratios.sum(),
            Heuristic::Power => ratios.map(|ratio| ratio * ratio).sum(),
        };
        1.0 / (drawn * sum)
    }
}

impl Directions for WarpedSets {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn directions_into(
        &self,
        at: &ShadingPoint<'_>,
        index: u64,
        directions: &mut PointSet,
    ) -> Result<SetWeight, Error> {
        let mut rng = self.streams.realization(self.first_stream + index);
        let local: Vec<LocalDensity<'_>> =
            self.densities.iter().map(|sampled| sampled.density.at(at)).collect();
        directions.start();
        for (strategy, sampled) in self.densities.iter().enumerate() {
            let set = sampled.choose(&mut rng);
            let by = uniform_shift(&mut rng);
            for (k, point) in set.points.iter().enumerate() {
                let mut shifted = [*point];
                shift(by, &mut shifted);
                let Some(sample) = local[strategy].sample(shifted[0]) else { break };
                let dir = sample.point;
                // Elsewhere the integrand is 0, or the direction is in a set of measure 0.
                if !(at.normal().dot(dir) > 0.0 && sample.density > 0.0) {
                    continue;
                }
                let inverse_density =
                    self.weight_over_density(strategy, sample.density, |i| local[i].density(dir));
                let share = set.weights.get(k).copied().unwrap_or(1.0 / set.len() as f64);
                directions.points.push(dir);
                directions.weights.push(share * inverse_density);
            }
        }
        // The weights estimate steradians, and the integrals are means over the hemisphere.
        Ok(SetWeight { visible: TAU, expected: TAU })
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn own_work(&self) -> f64 {
        self.own_work
    }
}
