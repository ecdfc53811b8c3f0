use std::array::from_fn;
use std::f64::consts::PI;
use std::num::NonZeroUsize;
use std::ops::Range;

use gauss_quad::GaussLegendre;

use crate::polynomial;
use crate::real::Real;

/// The maximum width of a window in grid cells, an even number.
pub(crate) const MAX_WIDTH: usize = 16;

/// Nodes of half of a window's transform, at most `MAX_WIDTH + 20`.
type Lanes = [[f64; 4]; (MAX_WIDTH + 20) / 4];

/// Orders of a window's transform from one accurate cosine to the next. Rotations between them lose a few
/// roundings.
const STRIDE: usize = 32;

/// The exponential-of-semicircle window that connects scattered points and a regular grid:
/// `psi(x) = exp(beta (sqrt(1 - (2x/w)^2) - 1))` for |x| <= w/2 grid cells.
///
/// # References
///
/// Barnett, Magland and af Klinteberg 2019, doi:10.1137/18M120885X.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    width: usize,
    beta: f64,
    /// The negligible error of its piecewise polynomials.
    tolerance: f64,
}

impl Window {
    /// Returns the narrowest window of an even width that achieves `epsilon` on a grid with this
    /// oversampling.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small positive number of cells"
    )]
    pub fn new(epsilon: f64, oversampling: f64) -> Self {
        // Aliasing decreases as exp(-pi w sqrt(1 - 1/sigma)) times a measured constant of 3.
        let decay = PI * (1.0 - 1.0 / oversampling).sqrt();
        let width = (((4.0 / epsilon).ln() / decay).ceil() as usize).clamp(4, MAX_WIDTH);
        let width = width.next_multiple_of(2);
        // The largest beta whose transform has decayed at the first alias, with a small margin.
        let beta = 0.98 * PI * width as f64 * (1.0 - 0.5 / oversampling);
        // Beyond rounding, higher degrees would only add noise, which derivatives amplify.
        Self { width, beta, tolerance: (0.01 * epsilon).max(4.0 * f64::EPSILON) }
    }

    /// Returns the window with another error of its piecewise polynomials.
    pub(crate) fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// Returns the width in grid cells.
    #[must_use]
    pub fn width(self) -> usize {
        self.width
    }

    /// Returns psi(x), for x in grid cells.
    #[must_use]
    pub fn value(self, x: f64) -> f64 {
        let s = 2.0 * x / self.width as f64;
        let root = 1.0 - s * s;
        if root < 0.0 { 0.0 } else { (self.beta * (root.sqrt() - 1.0)).exp() }
    }

    /// Returns `int psi(x) cos(2 pi m x / n) dx` for a grid of `n` cells and every m from 0 to
    /// `last`.
    #[must_use]
    pub fn transform(self, n: usize, last: usize) -> Vec<f64> {
        // The substitution x = w/2 sin(t) removes the square root; the rule then converges faster
        // than exponentially. The nodes are symmetric, and their number is even.
        let half = 0.5 * self.width as f64;
        let nodes = NonZeroUsize::MIN.saturating_add(2 * self.width + 39);
        let rule = GaussLegendre::new(nodes);
        let half_pi = 0.5 * PI;
        // Lanes without a node have the factor 0.
        let [mut factors, mut places] = [Lanes::default(); 2];
        for (i, (x, w)) in rule.iter().filter(|(x, _)| *x > 0.0).enumerate() {
            let (s, c) = (half_pi * x).sin_cos();
            factors[i / 4][i % 4] = 2.0 * half_pi * half * c * w * (self.beta * (c - 1.0)).exp();
            places[i / 4][i % 4] = half * s;
        }
        // Cosines and sines at every 32nd order, and rotations from order to order between these.
        let of_order = |m: usize| {
            let angle = |place: f64| 2.0 * PI * m as f64 / n as f64 * place;
            (places.map(|p| p.map(|p| angle(p).cos())), places.map(|p| p.map(|p| angle(p).sin())))
        };
        let (step_re, step_im) = of_order(1);
        let mut transform = vec![0.0; last + 1];
        for (block, values) in transform.chunks_mut(STRIDE).enumerate() {
            let (mut re, mut im) = of_order(block * STRIDE);
            for value in values {
                let mut sums = [0.0; 4];
                let nodes = factors.iter().zip(re.iter_mut().zip(&mut im));
                for ((factor, (re, im)), (c, s)) in nodes.zip(step_re.iter().zip(&step_im)) {
                    sums = from_fn(|i| sums[i] + factor[i] * re[i]);
                    let rotated = |i: usize| re[i] * c[i] - im[i] * s[i];
                    (*re, *im) = (from_fn(rotated), from_fn(|i| re[i] * s[i] + im[i] * c[i]));
                }
                *value = (sums[0] + sums[1]) + (sums[2] + sums[3]);
            }
        }
        transform
    }

    /// Returns the window as piecewise polynomials.
    pub fn table<T: Real>(self) -> WindowTable<T> {
        // Grid point i is at distance x - first - i, which covers cell i as t goes from -1 to 1.
        let piece =
            |cell: usize, t: f64| self.value(0.5 * (self.width as f64 - 1.0 + t) - cell as f64);
        let half = self.width / 2;
        let fit = |degree: usize| -> Vec<Vec<f64>> {
            (0..half).map(|cell| polynomial::interpolate(|t| piece(cell, t), degree)).collect()
        };
        let mut pieces = fit(3);
        let max_degree = self.width + 9;
        // Odd degrees have as many even as odd coefficients.
        for degree in (5..=max_degree).step_by(2) {
            let error = pieces.iter().enumerate().flat_map(|(cell, piece_fit)| {
                (0..=40).map(move |i| {
                    let t = f64::from(i) / 20.0 - 1.0;
                    let value = piece_fit.iter().fold(0.0, |sum, c| sum * t + c);
                    (value - piece(cell, t)).abs()
                })
            });
            if error.fold(0.0, f64::max) < self.tolerance {
                break;
            }
            pieces = fit(degree);
        }
        let padded = self.width.next_multiple_of(T::LANES).max(MIN_PADDED);
        let pad = (padded - self.width) / 2;
        let mut coefficients = Vec::new();
        // The odd one of each pair comes first in order of the degree.
        for d in (0..pieces[0].len()).step_by(2) {
            for d in [d + 1, d] {
                let lanes = (0..padded / 2).map(|lane| lane.checked_sub(pad));
                coefficients.extend(lanes.map(|cell| T::of(cell.map_or(0.0, |i| pieces[i][d]))));
            }
        }
        WindowTable { width: self.width, padded, coefficients: coefficients.into() }
    }
}

/// The minimum number of values of a table.
const MIN_PADDED: usize = 8;

/// The window as one polynomial for each of its w grid cells, evaluated together.
///
/// The window is even, and so is its width: cell w - 1 - i has the polynomial of cell i in -t. The
/// even and the odd part of half of the polynomials thus give the values of all cells.
#[derive(Clone, Debug)]
pub struct WindowTable<T> {
    width: usize,
    padded: usize,
    /// For cells of the first half, in padded order: the even coefficients of the highest degree,
    /// the odd ones of the highest degree, those of the next lower degrees, and so on.
    coefficients: Box<[T]>,
}

impl<T: Real> WindowTable<T> {
    /// Returns the number w of cells, an even number.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the number of values for whole vectors, at least w.
    #[must_use]
    pub fn padded(&self) -> usize {
        self.padded
    }

    /// Returns the number of zeros before and after the w values.
    #[must_use]
    pub fn pad(&self) -> usize {
        (self.padded - self.width) / 2
    }

    /// Returns the indices of the w values among the padded ones.
    pub(crate) fn rows(&self) -> Range<usize> {
        self.pad()..self.pad() + self.width
    }

    /// Returns the window at the w grid points nearest to two places, each given by `t` in [-1, 1],
    /// `t = 2 (x - first - w/2) + 1` for the first of the points, with [`Self::pad`] zeros on
    /// either side. `P` is [`Self::padded`] and `H` half of it.
    #[inline(always)]
    pub fn evaluate<const P: usize, const H: usize, const FUSED: bool>(
        &self,
        t: [T; 2],
    ) -> [[T; P]; 2] {
        let squares = t.map(|t| t * t);
        let (mut even, mut odd) = ([[T::default(); H]; 2], [[T::default(); H]; 2]);
        for [to_even, to_odd] in self.coefficients.as_chunks::<H>().0.as_chunks::<2>().0 {
            for k in 0..2 {
                for i in 0..H {
                    even[k][i] = even[k][i].times_plus::<FUSED>(squares[k], to_even[i]);
                    odd[k][i] = odd[k][i].times_plus::<FUSED>(squares[k], to_odd[i]);
                }
            }
        }
        let mut values = [[T::default(); P]; 2];
        for k in 0..2 {
            for i in 0..H {
                let odd = odd[k][i] * t[k];
                values[k][i] = even[k][i] + odd;
                values[k][P - 1 - i] = even[k][i] - odd;
            }
        }
        values
    }

    /// Returns the window and its derivative by t, `[value, slope]`, at the places of
    /// [`Self::evaluate`].
    #[inline(always)]
    pub(crate) fn evaluate_with_slope<const P: usize, const H: usize, const FUSED: bool>(
        &self,
        t: [T; 2],
    ) -> [[[T; P]; 2]; 2] {
        let squares = t.map(|t| t * t);
        // The even and the odd part over t, and their derivatives by the square of t.
        let mut parts = [[[T::default(); H]; 4]; 2];
        for coefficients in self.coefficients.as_chunks::<H>().0.as_chunks::<2>().0 {
            for ([even, odd, even_slope, odd_slope], square) in parts.iter_mut().zip(squares) {
                let [to_even, to_odd] = coefficients;
                for i in 0..H {
                    even_slope[i] = even_slope[i].times_plus::<FUSED>(square, even[i]);
                    odd_slope[i] = odd_slope[i].times_plus::<FUSED>(square, odd[i]);
                    even[i] = even[i].times_plus::<FUSED>(square, to_even[i]);
                    odd[i] = odd[i].times_plus::<FUSED>(square, to_odd[i]);
                }
            }
        }
        let mut pairs = [[[T::default(); P]; 2]; 2];
        for (([values, slopes], parts), t) in pairs.iter_mut().zip(&parts).zip(t) {
            let [even, odd, even_slope, odd_slope] = parts;
            for i in 0..H {
                let (odd_value, double) = (odd[i] * t, t + t);
                values[i] = even[i] + odd_value;
                values[P - 1 - i] = even[i] - odd_value;
                let slope_of_even = even_slope[i] * double;
                let slope_of_odd = odd_slope[i].times_plus::<FUSED>(t * double, odd[i]);
                slopes[i] = slope_of_even + slope_of_odd;
                slopes[P - 1 - i] = slope_of_even - slope_of_odd;
            }
        }
        pairs
    }
}
