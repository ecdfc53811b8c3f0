//! Samples, densities and inverses of a density map.

use std::f64::consts::TAU;

use glam::DVec3;

use super::guide::{bracket, last_interval};
use super::latitude::Band;
use super::longitude::Columns;
use super::{DensityMap, Interpolation};
use crate::polar::half_open;
use crate::{Support, Warp, WarpSample};

impl DensityMap {
    /// Returns the band, and t below its top, of a fraction u of the integral.
    fn find_band(&self, u: f64) -> (Band, f64) {
        let target = (u * self.total()).min(self.total().next_down());
        // The last band that begins at or before the target has a positive integral.
        let bracket = bracket(&self.band_guide, u);
        let index = last_interval(self.n_bands(), bracket, target, |band| self.bands[band]);
        let band = self.band(index);
        let t = self.profile(&band).inverse(target - self.bands[index]);
        (band, t)
    }

    /// Returns the directions of a fraction u.
    fn parallel(&self, u: f64) -> Parallel<'_> {
        let (band, t) = self.find_band(u);
        let (sin, z) = (band.top.radians + t).sin_cos();
        // The cosine of pi/2, rounded, may be negative.
        let z = if self.is_hemisphere { z.max(0.0) } else { z };
        Parallel { map: self, columns: self.columns(&band, t), sin, z }
    }

    /// The shift of cells by half a column if they lie between centres.
    fn offset(&self) -> f64 {
        if self.interpolation == Interpolation::Bilinear { 0.5 } else { 0.0 }
    }

    /// Returns band, t, cell and place in the cell of a direction of the domain.
    fn locate(&self, dir: DVec3) -> Option<(usize, f64, usize, f64)> {
        if self.is_hemisphere && dir.z < 0.0 {
            return None;
        }
        let theta = dir.x.hypot(dir.y).atan2(dir.z);
        let index = index_of(theta / self.step() + self.offset(), self.n_bands());
        let band = self.band(index);
        let t = (theta - band.top.radians).clamp(0.0, band.extent());
        let turns = (dir.y.atan2(dir.x) - self.first_longitude) / TAU;
        let place = (turns - self.offset() / self.width as f64).rem_euclid(1.0) * self.width as f64;
        let cell = index_of(place, self.width);
        Some((index, t, cell, (place - cell as f64).clamp(0.0, 1.0)))
    }
}

/// The directions of one latitude.
#[derive(Clone, Copy)]
struct Parallel<'a> {
    map: &'a DensityMap,
    columns: Columns<'a>,
    sin: f64,
    z: f64,
}

impl Parallel<'_> {
    fn sample(&self, v: f64) -> WarpSample {
        let Self { map, columns, sin: sin_theta, z } = *self;
        let (cell, x, value) = columns.find(v);
        let turns = (cell as f64 + x + map.offset()) / map.width as f64;
        let (sin, cos) = (map.first_longitude + TAU * turns).sin_cos();
        let point = DVec3::new(sin_theta * cos, sin_theta * sin, z);
        WarpSample { point, density: map.density_of(value) }
    }
}

/// Returns the whole part of a number that is not negative, at most `len - 1`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the cast saturates, and the result is limited"
)]
pub(super) fn index_of(x: f64, len: usize) -> usize {
    (x as usize).min(len - 1)
}

impl Warp for DensityMap {
    fn sample(&self, [u, v]: [f64; 2]) -> WarpSample {
        self.parallel(u).sample(v)
    }

    /// Consecutive points of equal u share their latitude, about half of the work.
    fn sample_into(&self, points: &[[f64; 2]], samples: &mut Vec<WarpSample>) {
        samples.clear();
        let mut last: Option<(f64, Parallel<'_>)> = None;
        samples.extend(points.iter().map(|&[u, v]| {
            let known = last.filter(|(of, _)| of.to_bits() == u.to_bits());
            let (_, parallel) = *last.insert(known.unwrap_or_else(|| (u, self.parallel(u))));
            parallel.sample(v)
        }));
    }

    fn density(&self, dir: DVec3) -> f64 {
        self.locate(dir).map_or(0.0, |(index, t, cell, x)| {
            self.density_of(self.columns(&self.band(index), t).value(cell, x))
        })
    }

    fn inverse(&self, dir: DVec3) -> Option<[f64; 2]> {
        let (index, t, cell, x) = self.locate(dir)?;
        let band = self.band(index);
        let columns = self.columns(&band, t);
        if columns.value(cell, x) <= 0.0 {
            return None;
        }
        let u = (self.bands[index] + self.profile(&band).mass(t)) / self.total();
        Some([half_open(u), half_open(columns.fraction(cell, x))])
    }

    fn support(&self) -> Support {
        let has_zeros = self.floor == 0.0 && self.has_zero_cell[..self.n_bands()].contains(&true);
        match (has_zeros, self.is_hemisphere) {
            (true, _) => Support::Directions,
            (false, true) => Support::UpperHemisphere,
            (false, false) => Support::Sphere,
        }
    }

    fn min_density(&self) -> f64 {
        let texel = if self.has_cosine {
            0.0
        } else if self.floor == 0.0 && self.interpolation == Interpolation::Constant {
            self.min_positive
        } else {
            self.min_texel
        };
        self.density_of(texel + self.floor)
    }

    fn breaks_in_u(&self) -> Vec<f64> {
        let mut breaks: Vec<f64> = self.bands.iter().map(|before| before / self.total()).collect();
        breaks.retain(|u| *u > 0.0 && *u < 1.0);
        breaks.dedup();
        breaks
    }

    fn breaks_in_v(&self, u: f64) -> Vec<f64> {
        let (band, t) = self.find_band(u);
        let mut breaks = self.columns(&band, t).edges();
        breaks.retain(|v| *v > 0.0 && *v < 1.0);
        breaks.dedup();
        breaks
    }
}
