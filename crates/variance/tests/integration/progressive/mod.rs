//! Variances of all prefixes of sequences.

mod measurements;
mod predictions;
mod square;
mod warped;
mod work;

use glam::DVec3;
use rand::Rng;
use sphvar_samplers::{
    Domain, Error, PointSet, PointSets, Purpose, Realizations, Sampler, SetDistribution, Streams,
};

/// A sampler with the number of random streams of a sequence.
#[derive(Debug)]
struct Sequence {
    sampler: Box<dyn Sampler>,
    group: usize,
    /// Whether independent points are declared as such.
    is_declared: bool,
}

impl Sampler for Sequence {
    fn n_points(&self) -> usize {
        self.sampler.n_points()
    }

    fn domain(&self) -> Domain {
        self.sampler.domain()
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        self.sampler.sample_into(rng, set)
    }

    fn distribution(&self) -> SetDistribution<'_> {
        if self.is_declared { self.sampler.distribution() } else { SetDistribution::Random }
    }

    fn stream_group(&self) -> usize {
        self.group
    }
}

fn sequence(name: &str, n: usize, domain: Domain) -> Sequence {
    let sampler = name.parse::<sphvar_samplers::Pattern>().unwrap().build(n, domain).unwrap();
    Sequence { sampler, group: 9, is_declared: false }
}

/// Returns independent points.
fn white(n: usize, domain: Domain) -> PointSet {
    let sampler = sequence("white-noise", n, domain);
    Realizations::unrotated(&sampler, Streams::new(3, Purpose::Pattern, 0)).realize(0).unwrap()
}

/// Returns points with repetitions, antipodes, poles and weights of different signs and scales.
fn hostile(n: usize, domain: Domain) -> PointSet {
    let mut points = vec![DVec3::Z, DVec3::X, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Z];
    points.extend(white(n - points.len(), domain).points);
    for k in (11..n).step_by(7) {
        points[k] = if k % 2 == 0 { points[k - 5] } else { -points[k - 6] };
    }
    points.iter_mut().for_each(|p| *p = domain.representative(*p));
    let weight = |k: usize| [1.0, 3.0, -0.5, 1e-9, 40.0][k * k % 5];
    PointSet { points, weights: (0..n).map(|k| 1e-200 * weight(k)).collect() }
}

fn given(set: &PointSet, n: usize, domain: Domain) -> PointSets {
    let mut set = set.clone();
    set.points.truncate(n);
    set.weights.truncate(n);
    PointSets::new(vec![set], domain).unwrap()
}
