//! Sums of squares of the coefficients of prefixes.

use std::f64::consts::PI;

use glam::DVec3;
use sphvar_samplers::{PointSet, Progress, Stopped};
use sphvar_sh::{Colatitude, LegendrePlan};

use crate::Error;

/// The number of points after which interrupts are checked.
const CHECK: usize = 256;
/// The nominal work of a coefficient of a point.
const COEFFICIENT_WORK: f64 = 0.15;

/// The weights of the low degrees in a variance, `sum_l c_l 4 pi/(2l+1) sum_m |sum_k w_k Y_lm(x_k)|^2`.
///
/// Sums of squares do not cancel, however small the power of the points is.
#[derive(Debug)]
pub(super) struct LowDegrees {
    plan: LegendrePlan,
    /// The factors of the squares of coefficients with m >= 0, in the order of the plan.
    factors: Vec<f64>,
}

impl LowDegrees {
    /// Returns the sum over the degrees of `coefficients`, from 0.
    pub(super) fn new(coefficients: &[f64]) -> Result<Self, Error> {
        let lmax = coefficients.len().max(1) - 1;
        let plan = LegendrePlan::new(lmax).map_err(sphvar_spectrum::Error::from)?;
        let factor = |(l, m): (usize, usize)| {
            let c = coefficients.get(l).copied().unwrap_or(0.0);
            let pair = if m == 0 { 1.0 } else { 2.0 };
            pair * c * 4.0 * PI / (2 * l + 1) as f64
        };
        let factors = plan.index().iter().map(factor).collect();
        Ok(Self { plan, factors })
    }

    /// Returns the sums of the prefixes with `counts` points.
    pub(super) fn sums(
        &self,
        set: &PointSet,
        counts: &[usize],
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Stopped> {
        let len = self.factors.len();
        let (mut real, mut imaginary) = (vec![0.0; len], vec![0.0; len]);
        let mut lambda = vec![0.0; len];
        let mut sums = Vec::with_capacity(counts.len());
        let mut next = 0;
        for &count in counts {
            for k in next..count {
                let weight = set.weights.get(k).copied().unwrap_or(1.0);
                self.add(weight, set.points[k], &mut lambda, [&mut real, &mut imaginary]);
                if k % CHECK == 0 {
                    progress.tick(0.0)?;
                }
            }
            next = count;
            let squares = real.iter().zip(&imaginary).map(|(a, b)| a * a + b * b);
            sums.push(squares.zip(&self.factors).map(|(square, factor)| factor * square).sum());
        }
        Ok(sums)
    }

    /// Adds a point to the coefficients.
    fn add(
        &self,
        weight: f64,
        point: DVec3,
        lambda: &mut [f64],
        [real, imaginary]: [&mut [f64]; 2],
    ) {
        self.plan.eval_into(Colatitude::from_direction(point), lambda);
        let radius = point.x.hypot(point.y);
        let (cos, sin) =
            if radius > 0.0 { (point.x / radius, point.y / radius) } else { (1.0, 0.0) };
        let (mut re, mut im) = (weight, 0.0);
        for m in 0..=self.plan.lmax() {
            let column = self.plan.index().column(m);
            let lambda = &lambda[column.clone()];
            for (a, value) in real[column.clone()].iter_mut().zip(lambda) {
                *a += re * value;
            }
            for (b, value) in imaginary[column].iter_mut().zip(lambda) {
                *b += im * value;
            }
            (re, im) = (re * cos - im * sin, re * sin + im * cos);
        }
    }

    /// Returns the nominal work of a point.
    pub(super) fn work_of_point(&self) -> f64 {
        COEFFICIENT_WORK * self.factors.len() as f64
    }
}
