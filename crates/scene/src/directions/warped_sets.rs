use std::f64::consts::TAU;

use rand::{Rng, RngExt};
use sphvar_integrands::Heuristic;
use sphvar_samplers::{PointSet, Streams, shift, uniform_shift};
use sphvar_warps::WarpSample;

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

    /// Returns the weight of the heuristic for a sample of density `own`.
    fn weight(&self, own: usize, sample: WarpSample, local: &[LocalDensity<'_>]) -> f64 {
        if local.len() == 1 {
            return 1.0;
        }
        let pairs = self.densities.iter().zip(local).enumerate();
        let scaled = pairs.map(|(k, (sampled, density))| {
            let density = if k == own { sample.density } else { density.density(sample.point) };
            sampled.share * density
        });
        self.heuristic.weight(own, &scaled.collect::<Vec<f64>>())
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
                let share = set.weights.get(k).copied().unwrap_or(1.0 / set.len() as f64);
                directions.points.push(dir);
                let weight = self.weight(strategy, sample, &local);
                directions.weights.push(share * weight / sample.density);
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
