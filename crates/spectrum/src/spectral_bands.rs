use std::f64::consts::PI;
use std::fmt::Debug;

use glam::DVec3;
use sphvar_samplers::{Point, PointSet};
use sphvar_sh::{Alm, Bands, Domain};

use crate::tail_power;

/// Bands whose powers are computed from coefficients of point sets: degrees from those of spherical
/// harmonics, frequencies of the square from those of Fourier series.
pub trait SpectralBands: Bands {
    /// A point of the space.
    type Point: Point;

    /// The coefficients of a point set.
    type Coefficients: Debug + Send + Sync;

    /// The power of a unit mass in units of its mean square coefficient: 4 pi on the sphere, 1 on
    /// the square.
    const UNIT_POWER: f64;

    /// Returns the power of every band from 0, `normalization` times the mean square of its
    /// coefficients.
    fn powers(coefficients: &Self::Coefficients, normalization: f64) -> Vec<f64>;

    /// Returns the mean power of a set beyond any band, by class.
    fn tail_power(set: &PointSet<Self::Point>) -> Self::Tail;
}

impl SpectralBands for Domain {
    type Point = DVec3;
    type Coefficients = Alm;

    const UNIT_POWER: f64 = 4.0 * PI;

    fn powers(alm: &Alm, normalization: f64) -> Vec<f64> {
        let mut powers = alm.power_per_degree();
        powers.iter_mut().for_each(|p| *p *= normalization);
        powers
    }

    fn tail_power(set: &PointSet) -> Self::Tail {
        tail_power(&set.points, &set.weights)
    }
}
