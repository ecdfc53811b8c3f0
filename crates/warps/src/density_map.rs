mod bands;
mod guide;
mod latitude;
mod longitude;
mod sampling;

use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

use crate::Error;
use latitude::Angle;
use longitude::{BLOCK, Row};

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
/// Accuracy: the density of a constant map has a relative error of 2e-16. A bilinear density changes
/// between the centres of texels, so it magnifies the rounding of a direction, 1e-16 radians, by W/(2
/// pi) and by the ratio of neighbouring texels: 4e-14 for 128 x 64 texels with a ratio of 100. Round
/// trips are accurate to 1e-14 in u and v where a texel has at least 1e-12 of the largest one,
/// because coordinates have only 53 bits. A texel with less than 1e-16 of the integral is not
/// sampled.
///
/// Performance: 8.75 bytes per texel, which include the texels and which clones share. Construction
/// reads the texels twice. A sample takes two searches from tables and Newton's iteration in theta.
/// A map of 16384 x 8192 texels takes 1.2 GB and about a second.
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
    texels: Arc<Vec<f64>>,
    /// For each row, the sums of [`Row`].
    sums: Arc<Vec<f64>>,
    /// For each row, the guide of [`Row`].
    guides: Arc<Vec<u32>>,
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
    /// The parallels between bands.
    edges: Vec<Angle>,
    /// The integrals over the bands above each band, divided by 2 pi, and the total.
    bands: Vec<f64>,
    /// The bands at equidistant fractions of the integral.
    band_guide: Vec<u32>,
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
        let (mut sums, mut guides) = (zeros(len)?, zeros(len - height)?);
        let is_bilinear = interpolation == Interpolation::Bilinear;
        let tables = sums.chunks_exact_mut(stride).zip(guides.chunks_exact_mut(stride - 1));
        for (row, (sums, guide)) in texels.chunks_exact_mut(width).zip(tables) {
            row.iter_mut().for_each(|texel| *texel *= scale);
            Row::write_sums(row, is_bilinear, sums, guide);
        }
        let mut map = Self {
            width,
            height,
            texels: Arc::new(texels),
            sums: Arc::new(sums),
            guides: Arc::new(guides),
            has_zero_cell: Vec::new(),
            min_texel: min * scale,
            min_positive: min_positive * scale,
            interpolation,
            first_longitude: 0.0,
            is_hemisphere: false,
            has_cosine: false,
            floor_share: 0.0,
            floor: 0.0,
            edges: Vec::new(),
            bands: Vec::new(),
            band_guide: Vec::new(),
        };
        map.edges = map.parallels();
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
            self.edges = self.parallels();
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
        self.edges = self.parallels();
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

    /// Returns the integral over the domain, divided by 2 pi.
    fn total(&self) -> f64 {
        self.bands[self.bands.len() - 1]
    }

    /// Returns the density per steradian of a value in units of texels.
    fn density_of(&self, value: f64) -> f64 {
        value / (TAU * self.total())
    }
}

/// Returns a table of zeros.
fn zeros<T: Clone + Default>(len: usize) -> Result<Vec<T>, Error> {
    let mut table = Vec::new();
    table.try_reserve_exact(len).map_err(|_| Error::OutOfMemory { len })?;
    table.resize(len, T::default());
    Ok(table)
}

/// Returns the power of two that scales a positive number to [1, 2).
fn inverse_power_of_two(x: f64) -> f64 {
    /// Bits of the mantissa, and twice the bias of the exponent.
    const MANTISSA: u32 = 52;
    const TWICE_BIAS: u64 = 2 * 1023;
    let exponent = x.to_bits() >> MANTISSA;
    f64::from_bits(TWICE_BIAS.saturating_sub(exponent).clamp(1, TWICE_BIAS) << MANTISSA)
}
