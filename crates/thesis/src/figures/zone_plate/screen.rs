use std::f64::consts::PI;

use num_complex::Complex;
use sphvar_integrands::{SquareIntegrand, ZonePlate};
use sphvar_sh::GaussLegendre;

use crate::Error;

/// A picture of the zone plate `sin(x^2 + y^2)`, x and y from 0 to `extent`, in square pixels.
#[derive(Clone, Debug)]
pub(super) struct Screen {
    /// Pixels per side.
    pub(super) side: usize,
    /// The largest x and y.
    pub(super) extent: f64,
    pub(super) zone_plate: ZonePlate,
}

/// The number of nodes for the mean of a function over a pixel, whose phase varies by less than
/// three turns: the relative error is below 1e-16.
const NODES: usize = 16;

impl Screen {
    /// Returns the picture in which the frequency of the rings, x/pi in each direction, equals that
    /// of the pixels, side/extent, at three quarters of the side: aliases of the centre appear
    /// there.
    ///
    /// # Errors
    ///
    /// [`Error::Integrand`] for more than 2000 pixels, where the extent exceeds that of
    /// [`ZonePlate`].
    pub(super) fn new(side: usize) -> Result<Self, Error> {
        let extent = (side as f64 * PI / 0.75).sqrt();
        Ok(Self { side, extent, zone_plate: ZonePlate::new(extent)? })
    }

    /// Returns the exact means over the pixels, row by row from the smallest y.
    pub(super) fn pixel_means(&self) -> Result<Vec<f64>, Error> {
        self.filtered(&[(0.0, 1.0)], |_| 1.0)
    }

    /// Returns the exact picture with the reconstruction filter of Mitchell and Netravali (1988,
    /// B = C = 1/3), the limit of infinitely many samples per pixel.
    pub(super) fn mitchell(&self) -> Result<Vec<f64>, Error> {
        let pieces = [(-1.5, -0.5), (-0.5, 0.5), (0.5, 1.5), (1.5, 2.5)];
        self.filtered(&pieces, |t| mitchell((t - 0.5).abs()))
    }

    /// Returns the integral of the zone plate times `filter(s) filter(t)` for each pixel, where s
    /// and t are coordinates in pixels from its edge and `pieces` are intervals of each on which
    /// the filter is smooth.
    ///
    /// `sin(x^2 + y^2)` is the imaginary part of `exp(i x^2) exp(i y^2)`, so the integrals of one
    /// coordinate suffice.
    fn filtered(
        &self,
        pieces: &[(f64, f64)],
        filter: impl Fn(f64) -> f64,
    ) -> Result<Vec<f64>, Error> {
        let rule = GaussLegendre::new(NODES)?;
        let unit = self.extent / self.side as f64;
        let column = |i: usize| {
            let part = |of: fn(f64) -> f64| -> f64 {
                let at = |t: f64| filter(t) * of(((i as f64 + t) * unit).powi(2));
                pieces.iter().map(|&(low, high)| rule.integrate(low, high, at)).sum()
            };
            Complex::new(part(f64::cos), part(f64::sin))
        };
        let columns: Vec<Complex<f64>> = (0..self.side).map(column).collect();
        let row = |y: &Complex<f64>| -> Vec<f64> { columns.iter().map(|x| (x * y).im).collect() };
        Ok(columns.iter().flat_map(row).collect())
    }

    /// Returns the picture from samples at points of the unit square: each pixel shows the mean of
    /// its samples, and one without samples that nearest to its centre.
    pub(super) fn render(&self, points: &[[f64; 2]]) -> Vec<f64> {
        let pixels = PixelIndex::new(self.side, points);
        let value = |&index: &usize| self.zone_plate.eval(points[index]);
        (0..self.side * self.side)
            .map(|pixel| match pixels.samples(pixel) {
                [] => pixels.nearest(pixel, points).as_ref().map_or(0.0, value),
                samples => samples.iter().map(value).sum::<f64>() / samples.len() as f64,
            })
            .collect()
    }
}

/// The reconstruction filter at a distance in pixels.
fn mitchell(t: f64) -> f64 {
    let polynomial = if t < 1.0 {
        (7.0 * t - 12.0) * t * t + 16.0 / 3.0
    } else {
        ((-7.0 / 3.0 * t + 12.0) * t - 20.0) * t + 32.0 / 3.0
    };
    polynomial / 6.0
}

/// The samples of each pixel.
struct PixelIndex {
    side: usize,
    /// The samples, ordered by pixel.
    order: Vec<usize>,
    /// The first position in `order` of each pixel, and the end.
    starts: Vec<usize>,
}

impl PixelIndex {
    fn new(side: usize, points: &[[f64; 2]]) -> Self {
        let pixels: Vec<usize> = points.iter().map(|&point| pixel_of(point, side)).collect();
        let mut starts = vec![0; side * side + 1];
        for pixel in &pixels {
            starts[pixel + 1] += 1;
        }
        for pixel in 0..side * side {
            starts[pixel + 1] += starts[pixel];
        }
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by_key(|&index| pixels[index]);
        Self { side, order, starts }
    }

    fn samples(&self, pixel: usize) -> &[usize] {
        &self.order[self.starts[pixel]..self.starts[pixel + 1]]
    }

    /// Returns the sample nearest to the centre of a pixel, by search in squares of pixels around
    /// it; `None` if there are no samples.
    fn nearest(&self, pixel: usize, points: &[[f64; 2]]) -> Option<usize> {
        let (column, row) = (pixel % self.side, pixel / self.side);
        let centre = [column, row].map(|i| (i as f64 + 0.5) / self.side as f64);
        let mut best: Option<(f64, usize)> = None;
        for reach in 0..self.side {
            // Samples of farther pixels are at least this far away.
            let safe = (reach as f64 - 0.5) / self.side as f64;
            if best.is_some_and(|(distance, _)| distance <= safe) {
                break;
            }
            let span = |i: usize| i.saturating_sub(reach)..=(i + reach).min(self.side - 1);
            for (x, y) in span(row).flat_map(|y| span(column).map(move |x| (x, y))) {
                if x.abs_diff(column).max(y.abs_diff(row)) < reach {
                    continue;
                }
                for &index in self.samples(y * self.side + x) {
                    let [u, v] = points[index];
                    let distance = (u - centre[0]).hypot(v - centre[1]);
                    if best.is_none_or(|(least, _)| distance < least) {
                        best = Some((distance, index));
                    }
                }
            }
        }
        best.map(|(_, index)| index)
    }
}

fn pixel_of([u, v]: [f64; 2], side: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a coordinate in [0, 1), cut to the last pixel where rounding reaches its end"
    )]
    let [column, row] = [u, v].map(|x| ((x * side as f64) as usize).min(side - 1));
    row * side + column
}
