use std::path::PathBuf;

use sphvar_grammar::{Choice, Declaration, Parametric};
use sphvar_sh::{ByAxis, Frequencies};

use super::SquareDefinition;
use super::energy::{check_values, energy_of_coefficients};
use super::grid::Grid;
use super::turns::sinc;
use crate::{Energy, EnvironmentMap, Error, IntegrandResolver, SquareIntegrand, quadrature};

/// A picture on the square, of `width` columns along u and `height` rows along v.
///
/// Texel (row i, column j) covers `[j, j + 1]/width` in u and `[i, i + 1]/height` in v: row 0 is at v
/// = 0. Integral and energies are those of the function between the texels, not of the texels as
/// samples: with the discrete Fourier coefficients `D_k` of the texels, periodic in k,
///
/// ```text
/// |G_k| = |D_k| |sinc(k1/width) sinc(k2/height)|^p,   p = 1 constant, p = 2 bilinear
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SquareImage {
    width: usize,
    height: usize,
    texels: Vec<f64>,
    interpolation: Interpolation,
}

/// The function between the centres of texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Linear in u and in v between the centres of texels; beyond those at a side, towards the
    /// texels at the opposite one.
    #[default]
    Bilinear,
    /// Constant on every texel.
    Constant,
}

impl Choice for Interpolation {
    const CHOICES: &'static [(&'static str, Self)] =
        &[("bilinear", Self::Bilinear), ("constant", Self::Constant)];
}

impl SquareImage {
    /// Returns the picture of `height` rows of `width` texels, row by row from v = 0.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] without texels, [`Error::TexelCount`] and [`Error::Texel`] for texels
    /// that are missing or not finite, [`Error::Magnitude`] if their squares would overflow or
    /// underflow.
    pub fn new(
        width: usize,
        height: usize,
        texels: Vec<f64>,
        interpolation: Interpolation,
    ) -> Result<Self, Error> {
        for (name, size) in [("width", width), ("height", height)] {
            if size == 0 {
                return Err(Error::Parameter { name, range: "at least 1", got: 0.0 });
            }
        }
        EnvironmentMap::check_texels(width, height, &texels)?;
        check_values(&texels)?;
        Ok(Self { width, height, texels, interpolation })
    }

    fn row(&self, i: usize) -> &[f64] {
        let i = i % self.height;
        &self.texels[i * self.width..(i + 1) * self.width]
    }

    /// Returns the four texels between whose centres a cell lies, for every cell: this one, the next
    /// of the row, and both in the next row, beyond the last ones the first.
    fn cells(&self) -> impl Iterator<Item = [f64; 4]> {
        (0..self.height).flat_map(move |i| {
            let (row, next) = (self.row(i), self.row(i + 1));
            (0..self.width).map(move |j| {
                let k = (j + 1) % self.width;
                [row[j], row[k], next[j], next[k]]
            })
        })
    }

    /// Returns the variances of the three parts of the function.
    fn variances(&self, grid: &Grid) -> ByAxis {
        if self.interpolation == Interpolation::Constant {
            return grid.mean_squares();
        }
        // The parts of the interpolated function are the interpolated parts of the texels.
        let line = |values: &[f64]| inner_product(values, values);
        let rest: Vec<&[f64]> = grid.rest.chunks_exact(self.width).collect();
        let of_rows = rest.iter().zip(rest.iter().cycle().skip(1));
        let sum: f64 = of_rows
            .map(|(row, next)| (2.0 * inner_product(row, row) + inner_product(row, next)) / 3.0)
            .sum();
        let off = (sum / self.height as f64).max(0.0);
        ByAxis { off, u: line(&grid.columns), v: line(&grid.rows) }
    }
}

/// Returns the integral of the product of two periodic, piecewise linear functions on [0, 1] with
/// these values at equal distances.
fn inner_product(a: &[f64], b: &[f64]) -> f64 {
    let next = |x: &[f64], j: usize| x[(j + 1) % x.len()];
    let term = |j: usize| 2.0 / 3.0 * a[j] * b[j] + (a[j] * next(b, j) + next(a, j) * b[j]) / 6.0;
    (0..a.len()).map(term).sum::<f64>() / a.len() as f64
}

/// Returns the sum of the distances between neighbours, and for a period of the last and the first.
fn variation(values: impl Iterator<Item = f64> + Clone, is_periodic: bool) -> f64 {
    let pairs = values.clone().zip(values.cycle().skip(1));
    let distances: Vec<f64> = pairs.map(|(a, b)| (a - b).abs()).collect();
    let n = distances.len() - usize::from(!is_periodic);
    distances[..n].iter().sum()
}

impl SquareIntegrand for SquareImage {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the coordinates are in the square"
    )]
    fn eval(&self, [u, v]: [f64; 2]) -> f64 {
        let (x, y) = (u * self.width as f64, v * self.height as f64);
        if self.interpolation == Interpolation::Constant {
            return self.row((y as usize).min(self.height - 1))[(x as usize).min(self.width - 1)];
        }
        // The first centre is at 1/2; before it, the last texel is the left one.
        let place = |x: f64, n: usize| {
            let shifted = x + (n as f64 - 0.5);
            let floor = shifted.floor();
            (floor as usize % n, shifted - floor)
        };
        let ((j, s), (i, t)) = (place(x, self.width), place(y, self.height));
        let along = |row: &[f64]| row[j] + s * (row[(j + 1) % self.width] - row[j]);
        let (above, below) = (along(self.row(i)), along(self.row(i + 1)));
        above + t * (below - above)
    }

    fn exact(&self) -> Option<f64> {
        let n = self.texels.len() as f64;
        Some(self.texels.iter().sum::<f64>() / n)
    }

    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        let grid = Grid::new(self.width, self.texels.clone());
        let power = grid.power()?;
        let centred = self.variances(&grid);
        let exponent = if self.interpolation == Interpolation::Constant { 2 } else { 4 };
        energy_of_coefficients(frequencies, grid.mean, centred, |k| {
            let [s, t] = [(k[0], self.width), (k[1], self.height)]
                .map(|(k, n)| sinc(f64::from(k) / n as f64));
            power.at(k) * (s * t).powi(exponent)
        })
    }

    fn feature_size(&self) -> Option<f64> {
        Some(1.0 / self.width.max(self.height) as f64)
    }

    fn kurtosis(&self) -> Option<f64> {
        if self.interpolation == Interpolation::Constant {
            return quadrature::weighted_kurtosis(|| self.texels.iter().map(|x| (1.0, *x)));
        }
        // Gauss-Legendre nodes and weights on [0, 1], exact for the fourth powers.
        let offset = 0.15f64.sqrt();
        let nodes = [(0.5 - offset, 5.0), (0.5, 8.0), (0.5 + offset, 5.0)];
        quadrature::weighted_kurtosis(|| {
            self.cells().flat_map(move |[a, b, c, d]| {
                let at = move |(s, weight): (f64, f64), (t, other): (f64, f64)| {
                    let (above, below) = (a + s * (b - a), c + s * (d - c));
                    (weight * other, above + t * (below - above))
                };
                nodes.into_iter().flat_map(move |s| nodes.map(|t| at(s, t)))
            })
        })
    }

    /// Returns 0 if all texels are equal.
    fn band_limit(&self) -> Option<usize> {
        self.texels.windows(2).all(|pair| pair[0] - pair[1] == 0.0).then_some(0)
    }

    /// Returns the sum of the mixed differences of neighbours and of the differences along the sides
    /// u = 1 and v = 1, where a bilinear picture is the mean of its first and last texels.
    fn variation(&self) -> Option<f64> {
        let is_periodic = self.interpolation == Interpolation::Bilinear;
        let (w, h) = (self.width, self.height);
        let is_inside = |cell: usize| (cell % w + 1 < w && cell / w + 1 < h) || is_periodic;
        let cells = self.cells().enumerate().filter(|(cell, _)| is_inside(*cell));
        let mixed: f64 = cells.map(|(_, [a, b, c, d])| (a - b - c + d).abs()).sum();
        let side = |last: f64, first: f64| if is_periodic { 0.5 * (last + first) } else { last };
        let right = (0..h).map(|i| side(self.row(i)[w - 1], self.row(i)[0]));
        let bottom = (0..w).map(|j| side(self.row(h - 1)[j], self.row(0)[j]));
        Some(mixed + variation(right, is_periodic) + variation(bottom, is_periodic))
    }
}

/// Parameters of a picture in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageParameters {
    /// The file. Texels of `OpenEXR` and Radiance HDR are the values in the file; those of PNG the
    /// stored numbers over their maximum, 255 or 65535, without decoding sRGB.
    pub file: PathBuf,
    /// The channel; default: luminance.
    pub channel: Option<String>,
    /// The layer or part; default: channels without one.
    pub layer: Option<String>,
    /// The function between the centres of texels.
    pub interpolation: Interpolation,
}

/// An example.
impl Default for ImageParameters {
    fn default() -> Self {
        let interpolation = Interpolation::default();
        Self { file: "FILE".into(), channel: None, layer: None, interpolation }
    }
}

impl Parametric for ImageParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "picture: PNG, stored values over their maximum, without decoding sRGB; or \
                       OpenEXR or Radiance HDR, values as stored";
        d.required_file("file", summary, &mut self.file);
        let summary = "luminance, r, g, b or a channel's name in the file";
        d.word("channel", summary, "luminance", &mut self.channel);
        d.word("layer", "layer or part of the file", "none", &mut self.layer);
        let summary = "between texel centres, across the sides; or constant on each texel";
        d.choice("interpolation", summary, &mut self.interpolation);
    }
}

impl SquareDefinition for ImageParameters {
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn SquareIntegrand>, Error> {
        Ok(Box::new(files.square_image(self)?))
    }
}
