//! Pictures as environment maps: projections and orientation.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use super::EnvironmentMap;
use crate::Error;

/// The layout of a picture on the sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Projection {
    /// Equirectangular: rows are circles of latitude and columns meridians, width = 2 height.
    #[default]
    LatLong,
    /// The square equal-area octahedral map of pbrt-v4 (Clarberg 2008): +z in the middle, -z at the
    /// corners.
    Octahedral,
}

/// The mapping of a picture to the sphere, with the convention of renderers: unmirrored as seen
/// from inside.
///
/// In the equirectangular projection texel (row i, column j) has its centre at
/// `theta = pi (i + 1/2)/H`, `phi = pi/2 - 2 pi (j + 1/2)/W + rotation`: columns run clockwise as seen
/// from +z, from +y over +x. With the pole rotated to +y about the x axis this is the emitter
/// `envmap` of Mitsuba 3. In the octahedral projection columns run towards +x and rows towards +y,
/// as in pbrt.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_integrands::{EnvironmentMap, Integrand, PictureLayout};
///
/// let columns = vec![1.0, 2.0, 3.0, 4.0, 1.0, 2.0, 3.0, 4.0];
/// let map = EnvironmentMap::from_picture(4, 2, columns.clone(), PictureLayout::default())?;
/// // From the inside, facing +x with +z up, +y is on the left.
/// assert!((map.eval(DVec3::new(1.0, 1.0, 0.0).normalize()) - 1.0).abs() < 1e-12);
/// assert!((map.eval(DVec3::new(1.0, -1.0, 0.0).normalize()) - 2.0).abs() < 1e-12);
/// let rotated = PictureLayout { rotation: std::f64::consts::PI, ..PictureLayout::default() };
/// let map = EnvironmentMap::from_picture(4, 2, columns, rotated)?;
/// assert!((map.eval(DVec3::new(-1.0, -1.0, 0.0).normalize()) - 1.0).abs() < 1e-12);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PictureLayout {
    /// The projection of the picture.
    pub projection: Projection,
    /// Whether y becomes -y, before the rotation.
    pub mirror: bool,
    /// Added to all longitudes, in radians.
    pub rotation: f64,
}

/// Samples per side of a texel when an octahedral map is resampled to rows and columns.
const SAMPLES: usize = 4;

impl EnvironmentMap {
    /// Returns the map of a picture of `height` rows of `width` texels, row by row from the top.
    ///
    /// An octahedral picture of n x n texels is resampled to n rows of 2n texels, each the mean of
    /// 16 bilinear look-ups; the other projection keeps its texels.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] or [`Error::Square`] if width and height do not fit the projection,
    /// [`Error::TexelCount`] and [`Error::Texel`] for texels that are missing or not finite, by
    /// their position in the picture.
    pub fn from_picture(
        width: usize,
        height: usize,
        mut texels: Vec<f64>,
        layout: PictureLayout,
    ) -> Result<Self, Error> {
        if layout.projection == Projection::Octahedral && (height == 0 || width != height) {
            return Err(Error::Square { width, height });
        }
        if layout.projection == Projection::LatLong && (height == 0 || width != 2 * height) {
            return Err(Error::Shape { width, height });
        }
        Self::check_texels(width, height, &texels)?;
        if layout.projection == Projection::Octahedral {
            texels = OctahedralPicture { side: width, texels: &texels }.equirectangular();
        }
        let width = 2 * height;
        // Both projections now have columns that run westwards from +y; those of the map run
        // eastwards.
        let first_longitude = if layout.mirror {
            -FRAC_PI_2
        } else {
            texels.chunks_exact_mut(width).for_each(<[f64]>::reverse);
            FRAC_PI_2
        };
        let map = Self::new(width, height, texels)?;
        Ok(map.with_first_longitude((first_longitude + layout.rotation).rem_euclid(TAU)))
    }
}

/// A square map, row by row from the top.
struct OctahedralPicture<'a> {
    side: usize,
    texels: &'a [f64],
}

impl OctahedralPicture<'_> {
    /// Returns the same as n rows of 2n texels in the equirectangular layout.
    fn equirectangular(&self) -> Vec<f64> {
        let (width, height) = (2 * self.side, self.side);
        let fraction = |k: usize| (k as f64 + 0.5) / SAMPLES as f64;
        let mut texels = Vec::with_capacity(width * height);
        for i in 0..height {
            for j in 0..width {
                let (mut sum, mut weights) = (0.0, 0.0);
                for row in 0..SAMPLES {
                    let theta = PI * (i as f64 + fraction(row)) / height as f64;
                    let weight = theta.sin();
                    for column in 0..SAMPLES {
                        let phi = FRAC_PI_2 - TAU * (j as f64 + fraction(column)) / width as f64;
                        sum += weight * self.at(equal_area_square(theta, phi));
                        weights += weight;
                    }
                }
                texels.push(sum / weights);
            }
        }
        texels
    }

    /// Returns the bilinear value at a point of the unit square.
    fn at(&self, [u, v]: [f64; 2]) -> f64 {
        let side = self.side as f64;
        let (x, y) = (u * side - 0.5, v * side - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        #[expect(clippy::cast_possible_truncation, reason = "from -1 to the side")]
        let (x, y) = (x.floor() as i64, y.floor() as i64);
        let above = (1.0 - fx) * self.texel(x, y) + fx * self.texel(x + 1, y);
        let below = (1.0 - fx) * self.texel(x, y + 1) + fx * self.texel(x + 1, y + 1);
        (1.0 - fy) * above + fy * below
    }

    /// Returns the texel in a column and row, one of which may be one step outside: each edge of
    /// the square is joined to its own other half.
    fn texel(&self, column: i64, row: i64) -> f64 {
        let side = i64::try_from(self.side).unwrap_or(i64::MAX);
        let wrap = |along: i64, across: i64| {
            if (0..side).contains(&across) {
                (along, across)
            } else {
                (side - 1 - along, if across < 0 { -1 - across } else { 2 * side - 1 - across })
            }
        };
        let (row, column) = wrap(row, column);
        let (column, row) = wrap(column, row);
        let index = usize::try_from(row * side + column).unwrap_or(usize::MAX);
        self.texels.get(index).copied().unwrap_or(f64::NAN)
    }
}

/// Returns the point of a direction in the equal-area octahedral square (Clarberg 2008).
fn equal_area_square(theta: f64, phi: f64) -> [f64; 2] {
    let (sin, cos) = phi.sin_cos();
    // In the upper half r = sqrt(1 - |z|), without cancellation.
    let from_pole = theta.min(PI - theta);
    let r = std::f64::consts::SQRT_2 * (0.5 * from_pole).sin();
    let octant = sin.abs().atan2(cos.abs()) / FRAC_PI_4 * 0.5;
    let (mut a, mut b) = (r * (1.0 - octant), r * octant);
    if theta > FRAC_PI_2 {
        (a, b) = (1.0 - b, 1.0 - a);
    }
    [0.5 * (1.0 + a.copysign(cos)), 0.5 * (1.0 + b.copysign(sin))]
}
