//! The bands and rows of a density map, and their integrals.

use std::f64::consts::PI;

use super::guide::write_guide;
use super::latitude::{Angle, Band, EQUATOR, Profile};
use super::longitude::{BLOCK, Columns, Row};
use super::{DensityMap, Interpolation};
use crate::Error;

impl DensityMap {
    /// Replaces the minima of the map by those above the equator.
    pub(super) fn restrict_minima(&mut self) {
        self.floor = 0.0;
        let (mut min, mut min_positive) = (f64::INFINITY, f64::INFINITY);
        for band in (0..self.n_bands()).map(|band| self.band(band)) {
            // A bilinear cell has its minimum at a corner, of which the lower may be on the equator.
            for t in [0.0, band.extent()] {
                let columns = self.columns(&band, t);
                for value in (0..self.width).map(|cell| columns.value(cell, 0.0)) {
                    min = min.min(value);
                    if value > 0.0 {
                        min_positive = min_positive.min(value);
                    }
                }
            }
        }
        (self.min_texel, self.min_positive) = (min, min_positive);
    }

    /// Computes the integrals over bands.
    pub(super) fn integrate_bands(&mut self) -> Result<(), Error> {
        let sum_bands = |map: &Self| {
            let mut sum = 0.0;
            let mut bands = vec![sum];
            for band in 0..map.n_bands() {
                sum += map.profile(&map.band(band)).total();
                bands.push(sum);
            }
            (bands, sum)
        };
        self.floor = 0.0;
        let (bands, total) = sum_bands(self);
        if total <= 0.0 {
            let domain = if self.is_hemisphere { "the hemisphere z >= 0" } else { "the sphere" };
            return Err(Error::NoDensity { domain });
        }
        self.bands = bands;
        if self.floor_share > 0.0 {
            let height = if self.is_hemisphere { 1.0 } else { 2.0 };
            self.floor = self.floor_share / (1.0 - self.floor_share) * total / height;
            self.bands = sum_bands(self).0;
        }
        self.band_guide = vec![0; self.n_bands()];
        write_guide(&self.bands, &mut self.band_guide);
        Ok(())
    }

    /// Returns the number of bands of the domain.
    pub(super) fn n_bands(&self) -> usize {
        match (self.interpolation, self.is_hemisphere) {
            (Interpolation::Constant, false) => self.height,
            (Interpolation::Constant, true) => self.height.div_ceil(2),
            (Interpolation::Bilinear, false) => self.height + 1,
            // Those that begin above the equator.
            (Interpolation::Bilinear, true) => self.height / 2 + 1,
        }
    }

    /// Returns the extent of a row in theta.
    pub(super) fn step(&self) -> f64 {
        PI / self.height as f64
    }

    /// Returns the parallels between bands, from theta = 0 to the end of the domain.
    pub(super) fn parallels(&self) -> Vec<Angle> {
        let end = if self.is_hemisphere { EQUATOR } else { PI };
        // The first bilinear band is half a row.
        let halves = |edge: usize| match self.interpolation {
            Interpolation::Constant => 2 * edge,
            Interpolation::Bilinear => (2 * edge).saturating_sub(1),
        };
        let theta = |edge| 0.5 * self.step() * halves(edge) as f64;
        (0..=self.n_bands()).map(|edge| Angle::new(theta(edge).min(end))).collect()
    }

    pub(super) fn band(&self, band: usize) -> Band {
        let last = self.height - 1;
        let (rows, slope) = match self.interpolation {
            Interpolation::Constant => ([band, band], 0.0),
            Interpolation::Bilinear if band == 0 => ([0, 0], 0.0),
            Interpolation::Bilinear if band > last => ([last, last], 0.0),
            Interpolation::Bilinear => ([band - 1, band], self.step().recip()),
        };
        Band { top: self.edges[band], bottom: self.edges[band + 1], rows, slope }
    }

    pub(super) fn row(&self, row: usize) -> Row<'_> {
        let stride = self.width.div_ceil(BLOCK) + 1;
        Row {
            texels: &self.texels[row * self.width..(row + 1) * self.width],
            sums: &self.sums[row * stride..(row + 1) * stride],
            guide: &self.guides[row * (stride - 1)..(row + 1) * (stride - 1)],
            is_bilinear: self.interpolation == Interpolation::Bilinear,
        }
    }

    pub(super) fn is_zero_somewhere(&self, band: usize) -> bool {
        let rows = self.band(band).rows.map(|row| self.row(row));
        (0..self.width).any(|cell| rows.iter().all(|row| row.cell(cell) == 0.0))
    }

    pub(super) fn profile(&self, band: &Band) -> Profile {
        let means = band.rows.map(|row| self.row(row).mean());
        Profile::new(band, means, self.floor, self.has_cosine)
    }

    /// Returns the conditional density at t below the top of a band.
    pub(super) fn columns(&self, band: &Band, t: f64) -> Columns<'_> {
        let weight = if self.has_cosine { (band.top.radians + t).cos().max(0.0) } else { 1.0 };
        let share = t * band.slope;
        Columns {
            rows: band.rows.map(|row| self.row(row)),
            factors: [weight * (1.0 - share).max(0.0), weight * share],
            floor: self.floor,
        }
    }
}
