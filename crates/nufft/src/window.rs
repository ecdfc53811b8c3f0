use std::f64::consts::PI;

use std::num::NonZeroUsize;

use gauss_quad::GaussLegendre;

use crate::polynomial;
use crate::real::Real;

/// The maximum width of a window in grid cells.
pub(crate) const MAX_WIDTH: usize = 20;

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
    /// Returns the narrowest window that achieves `epsilon` on a grid with this oversampling.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small positive number of cells"
    )]
    pub fn new(epsilon: f64, oversampling: f64) -> Self {
        // Aliasing decreases as exp(-pi w sqrt(1 - 1/sigma)) times a measured constant of 3.
        let decay = PI * (1.0 - 1.0 / oversampling).sqrt();
        let width = ((4.0 / epsilon).ln() / decay).ceil() as usize;
        let width = width.clamp(4, MAX_WIDTH);
        // The largest beta whose transform has decayed at the first alias, with a small margin.
        let beta = 0.98 * PI * width as f64 * (1.0 - 0.5 / oversampling);
        Self { width, beta, tolerance: 0.01 * epsilon }
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
        // than exponentially.
        let half = 0.5 * self.width as f64;
        let nodes = NonZeroUsize::MIN.saturating_add(2 * self.width + 23);
        let rule = GaussLegendre::new(nodes);
        let half_pi = 0.5 * PI;
        let nodes: Vec<[f64; 4]> = rule
            .iter()
            .map(|(x, w)| {
                let (s, c) = (half_pi * x).sin_cos();
                [*w, (self.beta * (c - 1.0)).exp(), s, c]
            })
            .collect();
        let of_order = |m: usize| {
            let frequency = 2.0 * PI * m as f64 / n as f64 * half;
            let terms =
                nodes.iter().map(|[w, psi, s, c]| w * (psi * (frequency * s).cos() * half * c));
            half_pi * terms.sum::<f64>()
        };
        (0..=last).map(of_order).collect()
    }

    /// Returns the window as piecewise polynomials.
    pub fn table<T: Real>(self) -> WindowTable<T> {
        // Grid point i is at distance x - first - i, which covers cell i as t goes from -1 to 1.
        let piece =
            |cell: usize, t: f64| self.value(0.5 * (self.width as f64 - 1.0 + t) - cell as f64);
        let fit = |degree: usize| -> Vec<Vec<f64>> {
            (0..self.width)
                .map(|cell| polynomial::interpolate(|t| piece(cell, t), degree))
                .collect()
        };
        let mut pieces = fit(2);
        let max_degree = self.width + 8;
        for degree in 3..=max_degree {
            pieces = fit(degree);
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
        }
        let padded = self.width.next_multiple_of(4);
        let mut coefficients = Vec::new();
        for d in 0..pieces[0].len() {
            coefficients.extend((0..padded).map(|i| T::of(pieces.get(i).map_or(0.0, |p| p[d]))));
        }
        WindowTable { width: self.width, padded, coefficients: coefficients.into() }
    }
}

/// The window as one polynomial for each of its w grid cells, evaluated together.
#[derive(Clone, Debug)]
pub struct WindowTable<T> {
    width: usize,
    /// The width padded to a multiple of 4, for whole vectors.
    padded: usize,
    /// Coefficient of degree d for cell i at `d * padded + i`, highest degree first.
    coefficients: Box<[T]>,
}

impl<T: Real> WindowTable<T> {
    /// Returns the number w of cells.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the number of values, w padded to a multiple of 4.
    #[must_use]
    pub fn padded(&self) -> usize {
        self.padded
    }

    /// Returns the window at the w grid points nearest to two places, each given by `t` in [-1, 1],
    /// `t = 2 (x - first - w/2) + 1` for the first of the points. `P` is [`Self::padded`].
    #[inline(always)]
    pub fn evaluate<const P: usize, const FUSED: bool>(&self, t: [T; 2]) -> [[T; P]; 2] {
        let mut values = [[T::default(); P]; 2];
        for row in self.coefficients.as_chunks::<P>().0 {
            for (values, t) in values.iter_mut().zip(t) {
                for i in 0..P {
                    values[i] = values[i].times_plus::<FUSED>(t, row[i]);
                }
            }
        }
        values
    }

    /// Returns the window and its derivative by t, `[value, slope]`, at the places of
    /// [`Self::evaluate`].
    #[inline(always)]
    pub(crate) fn evaluate_with_slope<const P: usize, const FUSED: bool>(
        &self,
        t: [T; 2],
    ) -> [[[T; P]; 2]; 2] {
        let mut pairs = [[[T::default(); P]; 2]; 2];
        for row in self.coefficients.as_chunks::<P>().0 {
            for ([values, slopes], t) in pairs.iter_mut().zip(t) {
                for i in 0..P {
                    slopes[i] = slopes[i].times_plus::<FUSED>(t, values[i]);
                    values[i] = values[i].times_plus::<FUSED>(t, row[i]);
                }
            }
        }
        pairs
    }
}
