mod latitude;
mod longitude;
mod sampling;

use std::f64::consts::{PI, TAU};
use std::fmt;

use crate::Error;
use latitude::{Band, EQUATOR, Profile};
use longitude::{BLOCK, Columns, Row};

/// The density between the centres of texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The density is constant in each texel, and jumps at the edges between texels.
    Constant,
    /// The density is bilinear in (theta, phi) between the centres of texels, wrapped in phi and
    /// constant in theta beyond the first and last row. It is continuous.
    Bilinear,
}

/// Directions with the density of an equirectangular map, such as the luminance of the incident
/// light:
///
/// ```text
/// p(theta, phi) = ((1 - floor) m(theta, phi) w(theta)/M + floor/Omega),   M = int m w d omega
/// ```
///
/// Row 0 is at theta = 0; texel (row i, column j) of H x W has its centre at theta = pi (i +
/// 1/2)/H, phi = first longitude + 2 pi (j + 1/2)/W, and any H and W of at least 1 are valid. The
/// [`Interpolation`] states m between the centres; w is 1, or [`cos(theta)`](Self::times_cosine).
/// The domain is the sphere, or the hemisphere z >= 0 [on request](Self::on_hemisphere) and with
/// the cosine. A [`floor`](Self::with_floor) mixes in the uniform density of the domain, of solid
/// angle Omega.
///
/// u selects theta by the marginal distribution, and v the longitude given theta. Both
/// distributions are integrated and inverted in closed form or to rounding, with the exact solid
/// angles of rows and the cosine inside texels, so the density of samples is exactly p, and an
/// integrand proportional to p is pulled back to a constant. theta increases with u and the
/// longitude with v. A bilinear map without zeros is continuous; a constant one jumps at the edges
/// of rows.
///
/// Accuracy: the density has relative errors of about 1e-15. Round trips are accurate to 1e-14 in u
/// and v where a texel has at least 1e-12 of the largest one, because coordinates have only 53
/// bits. A texel with less than 1e-16 of the integral is not sampled.
///
/// Performance: 8.5 bytes per texel, which include the texels. Construction reads the texels twice.
/// A sample takes two bisections and Newton's iteration in theta. A map of 16384 x 8192 texels takes
/// 1.1 GB and about a second.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_warps::{DensityMap, Interpolation, Warp};
///
/// // Dark but for a sun in row 1, column 2.
/// let mut texels = vec![1.0; 8 * 4];
/// texels[8 + 2] = 1e4;
/// let map = DensityMap::new(8, 4, texels, Interpolation::Constant)?;
/// let sun = map.map([0.5, 0.5]);
/// assert!((map.density(sun) / map.density(-sun) - 1e4).abs() < 1e-8);
/// let lit = map.times_cosine()?.with_floor(0.1)?;
/// assert!(lit.density(DVec3::X) >= 0.1 / std::f64::consts::TAU);
/// # Ok::<(), sphvar_warps::Error>(())
/// ```
///
/// # References
///
/// Pharr, Jakob and Humphreys 2023, appendix A, for rows weighted at their centres.
#[derive(Clone)]
pub struct DensityMap {
    width: usize,
    height: usize,
    /// Texels times a power of two, at most 2.
    texels: Vec<f64>,
    /// For each row, the sums of [`Row`].
    sums: Vec<f64>,
    /// For each band of the sphere, whether a cell is 0 at all its corners.
    has_zero_cell: Vec<bool>,
    min_texel: f64,
    min_positive: f64,
    interpolation: Interpolation,
    first_longitude: f64,
    /// Whether the domain is the hemisphere; the cosine requires it.
    is_hemisphere: bool,
    has_cosine: bool,
    floor_share: f64,
    /// The uniform density, in units of texels.
    floor: f64,
    /// The integrals over the bands above each band, divided by 2 pi, and the total.
    bands: Vec<f64>,
}

/// Without the texels, of which there may be millions.
impl fmt::Debug for DensityMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DensityMap")
            .field("width", &self.width)
            .field("height", &self.height)
            .field("interpolation", &self.interpolation)
            .field("is_hemisphere", &self.is_hemisphere)
            .field("has_cosine", &self.has_cosine)
            .field("floor_share", &self.floor_share)
            .finish_non_exhaustive()
    }
}

impl DensityMap {
    /// Returns the density of `height` rows of `width` texels, row by row from theta = 0.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] without texels, [`Error::TexelCount`], [`Error::Texel`] for a texel that is
    /// negative, infinite or NaN, [`Error::NoDensity`] if all are 0, [`Error::OutOfMemory`].
    pub fn new(
        width: usize,
        height: usize,
        mut texels: Vec<f64>,
        interpolation: Interpolation,
    ) -> Result<Self, Error> {
        if width == 0 || height == 0 {
            return Err(Error::Shape { width, height });
        }
        if width.checked_mul(height) != Some(texels.len()) {
            return Err(Error::TexelCount { width, height, got: texels.len() });
        }
        let (mut max, mut min, mut min_positive) = (0.0f64, f64::INFINITY, f64::INFINITY);
        for (i, &value) in texels.iter().enumerate() {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::Texel { row: i / width, column: i % width, value });
            }
            max = max.max(value);
            min = min.min(value);
            if value > 0.0 {
                min_positive = min_positive.min(value);
            }
        }
        let scale = inverse_power_of_two(max);
        let stride = width.div_ceil(BLOCK) + 1;
        let len = stride.saturating_mul(height);
        let mut sums = Vec::new();
        sums.try_reserve_exact(len).map_err(|_| Error::OutOfMemory { len })?;
        sums.resize(len, 0.0);
        let is_bilinear = interpolation == Interpolation::Bilinear;
        for (row, sums) in texels.chunks_exact_mut(width).zip(sums.chunks_exact_mut(stride)) {
            row.iter_mut().for_each(|texel| *texel *= scale);
            Row::write_sums(row, is_bilinear, sums);
        }
        let mut map = Self {
            width,
            height,
            texels,
            sums,
            has_zero_cell: Vec::new(),
            min_texel: min * scale,
            min_positive: min_positive * scale,
            interpolation,
            first_longitude: 0.0,
            is_hemisphere: false,
            has_cosine: false,
            floor_share: 0.0,
            floor: 0.0,
            bands: Vec::new(),
        };
        if min == 0.0 {
            map.has_zero_cell =
                (0..map.n_bands()).map(|band| map.is_zero_somewhere(band)).collect();
        } else {
            map.has_zero_cell = vec![false; map.n_bands()];
        }
        map.integrate_bands()?;
        Ok(map)
    }

    /// Returns the map with the left edge of its first column at another longitude, in radians.
    #[must_use]
    pub fn with_first_longitude(self, first_longitude: f64) -> Self {
        Self { first_longitude, ..self }
    }

    /// Returns the map rotated about +z by an angle in radians.
    #[must_use]
    pub fn rotated_about_pole(self, angle: f64) -> Self {
        let first_longitude = self.first_longitude + angle;
        Self { first_longitude, ..self }
    }

    /// Returns the map restricted to the hemisphere z >= 0, where its density integrates to 1.
    ///
    /// # Errors
    ///
    /// [`Error::NoDensity`] if the map is 0 on the hemisphere.
    pub fn on_hemisphere(mut self) -> Result<Self, Error> {
        if !self.is_hemisphere {
            self.is_hemisphere = true;
            self.restrict_minima();
            self.integrate_bands()?;
        }
        Ok(self)
    }

    /// Returns the product with cos(theta), on the hemisphere z >= 0.
    ///
    /// # Errors
    ///
    /// [`Error::NoDensity`] if the map is 0 on the hemisphere.
    pub fn times_cosine(mut self) -> Result<Self, Error> {
        (self.is_hemisphere, self.has_cosine) = (true, true);
        self.integrate_bands()?;
        Ok(self)
    }

    /// Returns the mixture with the uniform density on the domain, which has the share `floor` in
    /// [0, 1): the density is at least `floor`/(4 pi), or `floor`/(2 pi) on the hemisphere.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn with_floor(mut self, floor: f64) -> Result<Self, Error> {
        if !(0.0..1.0).contains(&floor) {
            return Err(Error::Parameter { name: "floor", range: "in [0, 1)", got: floor });
        }
        self.floor_share = floor;
        self.integrate_bands()?;
        Ok(self)
    }

    /// Replaces the minima of the map by those above the equator.
    fn restrict_minima(&mut self) {
        self.floor = 0.0;
        let (mut min, mut min_positive) = (f64::INFINITY, f64::INFINITY);
        for band in (0..self.n_bands()).map(|band| self.band(band)) {
            // A bilinear cell has its minimum at a corner, of which the lower may be on the equator.
            for t in [0.0, band.extent] {
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
    fn integrate_bands(&mut self) -> Result<(), Error> {
        let sum_bands = |map: &Self| {
            let mut sum = 0.0;
            let mut bands = vec![sum];
            for band in 0..map.n_bands() {
                let profile = map.profile(&map.band(band));
                sum += profile.mass(profile.extent);
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
        Ok(())
    }

    /// Returns the number of bands of the domain.
    fn n_bands(&self) -> usize {
        match (self.interpolation, self.is_hemisphere) {
            (Interpolation::Constant, false) => self.height,
            (Interpolation::Constant, true) => self.height.div_ceil(2),
            (Interpolation::Bilinear, false) => self.height + 1,
            // Those that begin above the equator.
            (Interpolation::Bilinear, true) => self.height / 2 + 1,
        }
    }

    /// Returns the extent of a row in theta.
    fn step(&self) -> f64 {
        PI / self.height as f64
    }

    fn band(&self, band: usize) -> Band {
        let step = self.step();
        let edge = |halves: usize| 0.5 * step * halves as f64;
        let last = self.height - 1;
        let (top, bottom, rows, slope) = match self.interpolation {
            Interpolation::Constant => (edge(2 * band), edge(2 * band + 2), [band, band], 0.0),
            Interpolation::Bilinear if band == 0 => (0.0, edge(1), [0, 0], 0.0),
            Interpolation::Bilinear if band > last => (edge(2 * band - 1), PI, [last, last], 0.0),
            Interpolation::Bilinear => {
                (edge(2 * band - 1), edge(2 * band + 1), [band - 1, band], step.recip())
            }
        };
        let bottom = if self.is_hemisphere { bottom.min(EQUATOR) } else { bottom };
        Band { top, extent: bottom - top, rows, slope }
    }

    fn row(&self, row: usize) -> Row<'_> {
        let stride = self.sums.len() / self.height;
        Row {
            texels: &self.texels[row * self.width..(row + 1) * self.width],
            sums: &self.sums[row * stride..(row + 1) * stride],
            is_bilinear: self.interpolation == Interpolation::Bilinear,
        }
    }

    fn is_zero_somewhere(&self, band: usize) -> bool {
        let rows = self.band(band).rows.map(|row| self.row(row));
        (0..self.width).any(|cell| rows.iter().all(|row| row.cell(cell) == 0.0))
    }

    fn profile(&self, band: &Band) -> Profile {
        let [first, last] = band.rows.map(|row| self.row(row).mean());
        Profile {
            top: band.top,
            extent: band.extent,
            a: first,
            b: (last - first) * band.slope,
            c: self.floor,
            has_cosine: self.has_cosine,
        }
    }

    /// Returns the conditional density at t below the top of a band.
    fn columns(&self, band: &Band, t: f64) -> Columns<'_> {
        let weight = if self.has_cosine { (band.top + t).cos().max(0.0) } else { 1.0 };
        let share = t * band.slope;
        Columns {
            rows: band.rows.map(|row| self.row(row)),
            factors: [weight * (1.0 - share).max(0.0), weight * share],
            floor: self.floor,
        }
    }

    /// Returns the integral over the domain, divided by 2 pi.
    fn total(&self) -> f64 {
        self.bands[self.bands.len() - 1]
    }

    /// Returns the density per steradian of a value in units of texels.
    fn density_of(&self, value: f64) -> f64 {
        value / (TAU * self.total())
    }
}

/// Returns the power of two that scales a positive number to [1, 2).
fn inverse_power_of_two(x: f64) -> f64 {
    /// Bits of the mantissa, and twice the bias of the exponent.
    const MANTISSA: u32 = 52;
    const TWICE_BIAS: u64 = 2 * 1023;
    let exponent = x.to_bits() >> MANTISSA;
    f64::from_bits(TWICE_BIAS.saturating_sub(exponent).clamp(1, TWICE_BIAS) << MANTISSA)
}
