use crate::{Error, Estimate, Image, PictureBias};

/// The side of the squares whose mean errors measure structure.
const BLOCK: usize = 8;

/// Errors of repeated renders of one view relative to a reference image.
///
/// The unit of replication is the render, whose pixels may share directions. Renders must be
/// independent, as those of one [`DirectionPlan`](crate::DirectionPlan) are. Means over pixels are
/// weighted by coverage; pixels without a surface do not count.
///
/// Memory: 8 bytes for each pixel of each render.
#[derive(Clone, Debug)]
pub struct RenderErrors<'a> {
    reference: &'a Image,
    /// The pixels that count.
    pixels: Vec<usize>,
    /// The upper left pixels of the squares in which all pixels count.
    blocks: Vec<usize>,
    n_points: usize,
    /// The errors of the pixels that count, one slice per render.
    errors: Vec<Box<[f64]>>,
    /// The sums over renders of the sampled spreads; empty for uniform directions.
    sampled_spreads: Vec<f64>,
    sums: Vec<Sums>,
}

/// Sums over the errors of one render.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// The mean square over all pixels that count.
    mean_square: f64,
    /// The largest magnitude.
    largest: f64,
    /// The squares of the means over blocks, and the mean squares in the same blocks.
    of_blocks: f64,
    in_blocks: f64,
    /// The products of the errors of neighbours, and the means of their squares.
    products: f64,
    squares: f64,
}

/// Error statistics of repeated renders of a view.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorReport {
    /// The number of renders.
    pub renders: usize,
    /// The number of pixels that count.
    pub pixels: usize,
    /// The mean squared error relative to the reference image; it includes the error of that image.
    pub mse: Estimate,
    /// The mean variance of a pixel between renders; NaN for a single render.
    pub variance: Estimate,
    /// The mean squared bias of a pixel, `mse - variance`, which may be negative by chance. It
    /// includes the squared error of the reference image. It has no standard error for two renders
    /// and is NaN for one.
    pub bias_squared: Estimate,
    /// The largest error of a pixel in magnitude, averaged over renders, in units of the root mean
    /// squared error: a measure of fireflies. It is 4.0 for 10^4 pixels with normal errors of equal
    /// variance, and 5.0 for 10^6; it is larger where single directions carry much of a pixel, or
    /// where errors differ between parts of the picture. NaN without errors.
    pub firefly: Estimate,
    /// The variance of mean errors over 8 by 8 pixels, relative to its value for independent
    /// pixels: 1 for independent pixels, 64 if all errors in a square are equal. NaN if no square
    /// is completely visible or there are no errors.
    pub structure: Estimate,
    /// The correlation of the errors of horizontally or vertically adjacent pixels: 0 for
    /// independent pixels. NaN without such pixels or without errors.
    pub autocorrelation: Estimate,
    /// The test for a bias of any pixel; `None` for a single render.
    pub bias: Option<PictureBias>,
}

impl<'a> RenderErrors<'a> {
    /// Returns the errors without any render.
    #[must_use]
    pub fn new(reference: &'a Image) -> Self {
        let is_seen = |i: usize| reference.coverage[i] > 0.0;
        let pixels = (0..reference.coverage.len()).filter(|&i| is_seen(i)).collect();
        let corners = |length: usize| (0..length / BLOCK).map(|i| i * BLOCK);
        let blocks = corners(reference.height)
            .flat_map(|y| corners(reference.width).map(move |x| y * reference.width + x))
            .filter(|&corner| square(corner, reference.width).all(is_seen))
            .collect();
        Self {
            reference,
            pixels,
            blocks,
            n_points: 0,
            errors: Vec::new(),
            sampled_spreads: Vec::new(),
            sums: Vec::new(),
        }
    }

    /// Adds a render.
    ///
    /// # Errors
    ///
    /// Returns [`Error::OtherView`] if it does not show the same surfaces in the same pixels as the
    /// reference image.
    pub fn push(&mut self, image: &Image) -> Result<(), Error> {
        let reference = self.reference;
        if image.width != reference.width || image.coverage != reference.coverage {
            return Err(Error::OtherView);
        }
        let pairs = image.values.iter().zip(&reference.values);
        let errors: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
        self.sums.push(self.sums_of(&errors));
        self.errors.push(self.pixels.iter().map(|&i| errors[i]).collect());
        self.n_points = image.n_points;
        if !image.sampled_spreads.is_empty() {
            self.sampled_spreads.resize(image.values.len(), 0.0);
            let pairs = self.sampled_spreads.iter_mut().zip(&image.sampled_spreads);
            pairs.for_each(|(sum, spread)| *sum += spread);
        }
        Ok(())
    }

    /// Returns the sums for one render; `errors` are those of all pixels, 0 for pixels without a
    /// surface.
    fn sums_of(&self, errors: &[f64]) -> Sums {
        let width = self.reference.width;
        let squared = |i: usize| errors[i] * errors[i];
        let mean_square = self.mean(self.pixels.iter().map(|&i| squared(i)));
        let largest = self.pixels.iter().fold(0.0, |max: f64, &i| max.max(errors[i].abs()));
        let mut sums = Sums { mean_square, largest, ..Sums::default() };
        let area = (BLOCK * BLOCK) as f64;
        for &corner in &self.blocks {
            let mean = square(corner, width).map(|i| errors[i]).sum::<f64>() / area;
            sums.of_blocks += mean * mean;
            sums.in_blocks += square(corner, width).map(squared).sum::<f64>() / area;
        }
        for &i in &self.pixels {
            let right = ((i + 1) % width != 0).then_some(i + 1);
            for j in right.into_iter().chain([i + width]) {
                if self.reference.coverage.get(j).is_some_and(|&c| c > 0.0) {
                    sums.products += errors[i] * errors[j];
                    sums.squares += 0.5 * (squared(i) + squared(j));
                }
            }
        }
        sums
    }

    /// Returns the mean over the pixels that count, weighted by coverage.
    fn mean(&self, of_pixels: impl Iterator<Item = f64>) -> f64 {
        let weights = self.pixels.iter().map(|&i| self.reference.coverage[i]);
        let products = of_pixels.zip(weights.clone()).map(|(x, weight)| weight * x);
        products.sum::<f64>() / weights.sum::<f64>()
    }

    /// Returns the squared error of each pixel of the image, averaged over the renders; 0 for
    /// pixels without a surface.
    #[must_use]
    pub fn squared_errors(&self) -> Vec<f64> {
        let mut result = vec![0.0; self.reference.values.len()];
        let share = 1.0 / self.errors.len() as f64;
        for errors in &self.errors {
            for (&i, e) in self.pixels.iter().zip(errors) {
                result[i] += share * e * e;
            }
        }
        result
    }

    /// Returns the statistics of the renders.
    #[must_use]
    pub fn report(&self) -> ErrorReport {
        let count = self.errors.len();
        let mse = self.jackknife(|sums| [sums.mean_square, 1.0]);
        let moments: Vec<(f64, f64)> =
            (0..self.pixels.len()).map(|k| moments(self.errors.iter().map(|e| e[k]))).collect();
        let variance = self.variance(&moments);
        let area = (BLOCK * BLOCK) as f64;
        ErrorReport {
            renders: count,
            pixels: self.pixels.len(),
            mse,
            variance,
            bias_squared: self.bias_squared(mse.value, variance.value, &moments),
            firefly: self.firefly(),
            structure: self.jackknife(|sums| [area * sums.of_blocks, sums.in_blocks]),
            autocorrelation: self.jackknife(|sums| [sums.products, sums.squares]),
            bias: PictureBias::new(
                self.reference,
                &self.pixels,
                count,
                self.n_points,
                |k| moments[k],
                self.contribution(&moments),
            ),
        }
    }

    /// Returns the size of those directions that contribute to the k-th pixel, `<g^2>/<g>` for
    /// estimates `(1/N) sum g`: from the reference for uniform directions; otherwise from the
    /// renders of this pixel, which may have missed rare directions, or of the whole picture,
    /// whichever is larger.
    fn contribution(&self, moments: &[(f64, f64)]) -> impl Fn(usize) -> f64 {
        let of_renders = |k: usize| {
            let pixel = self.pixels[k];
            let mean = self.reference.values[pixel] + moments[k].0;
            let spread = self.sampled_spreads[pixel] / self.errors.len() as f64;
            [mean * mean + spread, mean]
        };
        let is_uniform = self.sampled_spreads.is_empty();
        let pixels = if is_uniform { 0..0 } else { 0..self.pixels.len() };
        let sums = pixels.map(of_renders).fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
        let of_picture = sums[0] / sums[1];
        move |k| {
            if is_uniform {
                let pixel = self.pixels[k];
                let value = self.reference.values[pixel];
                return value + self.reference.spreads[pixel] / value;
            }
            let [square, mean] = of_renders(k);
            if mean > 0.0 { of_picture.max(square / mean) } else { of_picture }
        }
    }

    /// Returns the mean of the largest errors over the root of the mean square.
    fn firefly(&self) -> Estimate {
        let count = self.sums.len();
        let ratio = |left_out: Option<usize>| {
            let used = self.sums.iter().enumerate().filter(|(i, _)| Some(*i) != left_out);
            let [n, largest, square] = used.fold([0.0; 3], |[n, largest, square], (_, sums)| {
                [n + 1.0, largest + sums.largest, square + sums.mean_square]
            });
            largest / n / (square / n).sqrt()
        };
        Estimate::jackknife(ratio(None), count, |i| ratio(Some(i)))
    }

    /// Returns the mean of the pixels' variances.
    fn variance(&self, moments: &[(f64, f64)]) -> Estimate {
        let value = self.mean(moments.iter().map(|m| m.1));
        Estimate::jackknife(value, self.errors.len(), |r| self.variance_without(r, value, moments))
    }

    /// Returns the mean of the pixels' variances over all renders except one; `variance` is that
    /// over all.
    fn variance_without(&self, render: usize, variance: f64, moments: &[(f64, f64)]) -> f64 {
        let count = self.errors.len() as f64;
        let deviations = self.errors[render].iter().zip(moments).map(|(e, m)| (e - m.0).powi(2));
        let squares = self.mean(deviations);
        // The change of the sum of squared deviations when one number is left out.
        ((count - 1.0) * variance - squares * count / (count - 1.0)) / (count - 2.0)
    }

    /// Returns the difference of mean squared error and variance.
    fn bias_squared(&self, mse: f64, variance: f64, moments: &[(f64, f64)]) -> Estimate {
        let count = self.errors.len() as f64;
        Estimate::jackknife(mse - variance, self.errors.len(), |r| {
            let mse = (count * mse - self.sums[r].mean_square) / (count - 1.0);
            mse - self.variance_without(r, variance, moments)
        })
    }

    /// Returns the ratio of the sums over renders of two numbers per render.
    fn jackknife(&self, pair: impl Fn(&Sums) -> [f64; 2]) -> Estimate {
        let pairs: Vec<[f64; 2]> = self.sums.iter().map(pair).collect();
        let total = |left_out: Option<usize>| {
            let used = pairs.iter().enumerate().filter(|(i, _)| Some(*i) != left_out);
            let [a, b] = used.fold([0.0; 2], |[a, b], (_, p)| [a + p[0], b + p[1]]);
            a / b
        };
        Estimate::jackknife(total(None), pairs.len(), |i| total(Some(i)))
    }
}

/// Returns the pixels of the square with this upper left pixel.
fn square(corner: usize, width: usize) -> impl Iterator<Item = usize> {
    (0..BLOCK * BLOCK).map(move |k| corner + k / BLOCK * width + k % BLOCK)
}

/// Returns mean and unbiased variance; exact if all values are equal.
fn moments(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let first = values.clone().next().unwrap_or(0.0);
    let (sum, count) = values.clone().fold((0.0, 0.0), |(sum, n), x| (sum + (x - first), n + 1.0));
    let mean = first + sum / count;
    (mean, values.map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0))
}

#[cfg(test)]
mod tests {
    use super::{Image, RenderErrors};

    fn image(width: usize, height: usize, value: impl Fn(usize, usize) -> f64) -> Image {
        let values = (0..width * height).map(|i| value(i % width, i / width)).collect();
        Image {
            width,
            height,
            values,
            spreads: vec![0.25; width * height],
            coverage: vec![1.0; width * height],
            n_points: 16,
            rays: 0,
            sampled_spreads: Vec::new(),
        }
    }

    #[test]
    fn constant_errors_have_maximal_structure() {
        let reference = image(16, 9, |_, _| 0.5);
        let mut errors = RenderErrors::new(&reference);
        for sign in [1.0, -1.0] {
            errors.push(&image(16, 9, |_, _| 0.5 + 0.25 * sign)).unwrap();
        }
        let report = errors.report();
        // Quarters are exact in binary.
        assert_eq!((report.mse.value, report.mse.stderr), (0.0625, 0.0));
        assert_eq!((report.structure.value, report.autocorrelation.value), (64.0, 1.0));
        assert_eq!((report.firefly.value, report.firefly.stderr), (1.0, 0.0));
        assert_eq!((report.variance.value, report.bias_squared.value), (0.125, -0.0625));
        assert_eq!(errors.squared_errors(), [0.0625; 16 * 9]);
    }

    #[test]
    fn a_chequerboard_has_no_mean_in_a_square() {
        let reference = image(8, 8, |_, _| 0.5);
        let mut errors = RenderErrors::new(&reference);
        let board = |x: usize, y: usize| if (x + y).is_multiple_of(2) { 0.75 } else { 0.25 };
        errors.push(&image(8, 8, board)).unwrap();
        let report = errors.report();
        assert_eq!((report.structure.value, report.autocorrelation.value), (0.0, -1.0));
        assert!(report.bias.is_none() && report.variance.value.is_nan(), "{report:?}");
    }

    #[test]
    fn pixels_without_a_surface_do_not_count() {
        let mut reference = image(8, 8, |_, _| 0.5);
        reference.coverage[0] = 0.0;
        let mut errors = RenderErrors::new(&reference);
        let mut other = image(8, 8, |_, _| 0.75);
        errors.push(&other).unwrap_err();
        other.coverage[0] = 0.0;
        errors.push(&other).unwrap();
        let report = errors.report();
        assert_eq!((report.pixels, report.mse.value), (63, 0.0625));
        assert!(report.structure.value.is_nan(), "no square is whole: {report:?}");
    }

    /// One error in 64 pixels, in one of two renders: 1/2 of it over its root mean square.
    #[test]
    fn a_firefly_stands_out() {
        let reference = image(8, 8, |_, _| 0.5);
        let mut errors = RenderErrors::new(&reference);
        errors.push(&image(8, 8, |x, y| if x + y == 0 { 8.5 } else { 0.5 })).unwrap();
        errors.push(&reference).unwrap();
        let expected = 4.0 / (64.0f64 / 128.0).sqrt();
        assert!((errors.report().firefly.value - expected).abs() < 1e-12, "{:?}", errors.report());
        let none = RenderErrors::new(&reference).report();
        assert!(none.firefly.value.is_nan());
    }

    #[test]
    fn pixels_count_as_they_are_covered() {
        let mut reference = image(2, 1, |_, _| 0.5);
        reference.coverage[1] = 0.25;
        let mut errors = RenderErrors::new(&reference);
        let mut other = image(2, 1, |x, _| if x == 0 { 0.5 } else { 1.0 });
        other.coverage[1] = 0.25;
        errors.push(&other).unwrap();
        // A quarter of an error of 1/2, over an area of 5/4.
        assert_eq!((errors.report().mse.value, other.mean()), (0.05, 0.6));
    }
}
