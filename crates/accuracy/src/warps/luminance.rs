use std::f64::consts::{PI, TAU};

use glam::DVec3;
use sphvar_warps::Interpolation;

use crate::reference::DoubleDouble;

/// A luminance map of H rows of 2H texels, by its definition.
#[derive(Debug)]
pub(super) struct Luminance {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) texels: Vec<f64>,
    interpolation: Interpolation,
    has_cosine: bool,
    /// The integral over the domain.
    integral: f64,
}

impl Luminance {
    /// Returns a map with values from 1 to 4, zeros in a corner, and a texel of 100.
    pub(super) fn with_sun(height: usize, interpolation: Interpolation, has_cosine: bool) -> Self {
        let width = 2 * height;
        let value = |k: usize| 1.0 + 3.0 * (k as f64 * 0.754_877_666_246_692_7).fract();
        let mut texels: Vec<f64> = (0..width * height).map(value).collect();
        texels[width * (height / 4) + 3 * width / 4] = 100.0;
        Self::new(width, height, texels, interpolation, has_cosine)
    }

    pub(super) fn new(
        width: usize,
        height: usize,
        texels: Vec<f64>,
        interpolation: Interpolation,
        has_cosine: bool,
    ) -> Self {
        let mut map = Self { width, height, texels, interpolation, has_cosine, integral: 0.0 };
        map.integral = map.integrate().value();
        map
    }

    /// Returns the integral as a sum of bands that are linear in theta, in twice the precision.
    fn integrate(&self) -> DoubleDouble {
        let row = |i: usize| {
            let texels = &self.texels[i * self.width..(i + 1) * self.width];
            texels.iter().fold(DoubleDouble::ZERO, |sum, x| sum + DoubleDouble::from(*x))
        };
        let mut sum = DoubleDouble::ZERO;
        // Edges in halves of a row, to those of the domain.
        let end = if self.has_cosine { self.height } else { 2 * self.height };
        let mut push = |from: usize, to: usize, rows: [usize; 2]| {
            if from < end {
                let [first, last] = rows.map(row);
                sum += self.band(from, to, to.min(end), [first, last]);
            }
        };
        match self.interpolation {
            Interpolation::Constant => {
                (0..self.height).for_each(|i| push(2 * i, 2 * i + 2, [i, i]));
            }
            Interpolation::Bilinear => {
                let last = self.height - 1;
                push(0, 1, [0, 0]);
                (0..last).for_each(|i| push(2 * i + 1, 2 * i + 3, [i, i + 1]));
                push(2 * last + 1, 2 * last + 2, [last, last]);
            }
        }
        let column =
            DoubleDouble::from(2.0) * DoubleDouble::pi() / DoubleDouble::from(self.width as f64);
        sum * column
    }

    /// Returns the integral over theta of a band that is linear from `from` to `to`, to `end`.
    fn band(&self, from: usize, to: usize, end: usize, rows: [DoubleDouble; 2]) -> DoubleDouble {
        let half = DoubleDouble::pi() / DoubleDouble::from(2.0 * self.height as f64);
        let angle = |halves: usize| half * DoubleDouble::from(halves as f64);
        let slope = (rows[1] - rows[0]) / (angle(to) - angle(from));
        let start = rows[0] - slope * angle(from);
        // The antiderivative of (start + slope theta) sin(theta) w.
        let antiderivative = |halves: usize| {
            let theta = angle(halves);
            let value = start + slope * theta;
            if self.has_cosine {
                let (sin, cos) = (theta + theta).sin_cos();
                slope * sin / DoubleDouble::from(8.0) - value * cos / DoubleDouble::from(4.0)
            } else {
                let (sin, cos) = theta.sin_cos();
                slope * sin - value * cos
            }
        };
        antiderivative(end) - antiderivative(from)
    }

    /// Returns the density at a direction.
    pub(super) fn density(&self, dir: DVec3) -> f64 {
        let theta = dir.x.hypot(dir.y).atan2(dir.z);
        let phi = dir.y.atan2(dir.x).rem_euclid(TAU);
        let (row, column) = (theta / PI * self.height as f64, phi / TAU * self.width as f64);
        let value = match self.interpolation {
            Interpolation::Constant => self.texel(row.floor(), column.floor()),
            Interpolation::Bilinear => {
                let (row, column) = (row - 0.5, column - 0.5);
                let (i, j) = (row.floor(), column.floor());
                let (s, t) = (row - i, column - j);
                let of_row = |i: f64| (1.0 - t) * self.texel(i, j) + t * self.texel(i, j + 1.0);
                (1.0 - s) * of_row(i) + s * of_row(i + 1.0)
            }
        };
        let weight = if self.has_cosine { dir.z.max(0.0) } else { 1.0 };
        value * weight / self.integral
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in the map")]
    fn texel(&self, row: f64, column: f64) -> f64 {
        let row = row.clamp(0.0, self.height as f64 - 1.0) as usize;
        let column = column.rem_euclid(self.width as f64) as usize;
        self.texels[row * self.width + column]
    }
}
