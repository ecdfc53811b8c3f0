use num_complex::Complex;
use sphvar_nufft::parts::{FftDirection, Real};
use sphvar_sh::ByAxis;

use super::energy::{centre, zeros};
use crate::{Error, quadrature};

/// Values on a grid of the square, row by row, as the mean, a part of each coordinate, and the rest.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) mean: f64,
    /// The mean of every column without that of all values, a function of u.
    pub(super) columns: Vec<f64>,
    /// The mean of every row without that of all values, a function of v.
    pub(super) rows: Vec<f64>,
    /// The values without the means of their row and column.
    pub(super) rest: Vec<f64>,
}

/// The squared moduli of the discrete Fourier coefficients of the three parts, divided by the
/// number of values.
#[derive(Clone, Debug)]
pub(super) struct GridPower {
    columns: Vec<f64>,
    rows: Vec<f64>,
    rest: Vec<f64>,
}

impl Grid {
    /// Returns the parts of the values of a grid of `width` columns, whose number is a multiple of
    /// `width` above 0.
    pub(super) fn new(width: usize, mut values: Vec<f64>) -> Self {
        let height = values.len() / width;
        let average = |sum: f64, n: usize| sum / n as f64;
        let mean = centre(&mut values, |x| average(x.iter().sum(), x.len()));
        let mut columns = vec![0.0; width];
        let mut rows = Vec::with_capacity(height);
        for row in values.chunks_exact(width) {
            rows.push(average(row.iter().sum(), width));
            columns.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
        }
        columns.iter_mut().for_each(|sum| *sum = average(*sum, height));
        for (row, of_row) in values.chunks_exact_mut(width).zip(&rows) {
            row.iter_mut().zip(&columns).for_each(|(x, of_column)| *x -= of_row + of_column);
        }
        Self { mean, columns, rows, rest: values }
    }

    /// Returns the mean squares of the three parts.
    pub(super) fn mean_squares(&self) -> ByAxis {
        let mean_square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64;
        ByAxis {
            off: mean_square(&self.rest),
            u: mean_square(&self.columns),
            v: mean_square(&self.rows),
        }
    }

    /// Returns the kurtosis of the values.
    pub(super) fn kurtosis(&self) -> Option<f64> {
        quadrature::weighted_kurtosis(|| {
            let rows = self.rest.chunks_exact(self.columns.len()).zip(&self.rows);
            rows.flat_map(|(rest, of_row)| {
                let of_columns = rest.iter().zip(&self.columns);
                of_columns.map(move |(x, of_column)| (1.0, x + (of_row + of_column)))
            })
        })
    }

    /// Returns the squared moduli of the Fourier coefficients.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if memory is exhausted.
    pub(super) fn power(&self) -> Result<GridPower, Error> {
        let Self { columns, rows, rest, .. } = self;
        let (width, height) = (columns.len(), rows.len());
        let complex = |x: &f64| Complex::new(*x, 0.0);
        let transform = |values: &mut [Complex<f64>], len: usize| {
            f64::fourier_plan(len, FftDirection::Forward).process(values);
        };
        let line = |values: &[f64]| {
            let mut spectrum: Vec<_> = values.iter().map(complex).collect();
            transform(&mut spectrum, values.len());
            spectrum.iter().map(|c| (c / values.len() as f64).norm_sqr()).collect()
        };
        let mut plane = zeros::<Complex<f64>>(rest.len())?;
        plane.iter_mut().zip(rest).for_each(|(c, x)| *c = complex(x));
        transform(&mut plane, width);
        let mut power = zeros(rest.len())?;
        let mut column = vec![Complex::ZERO; height];
        for j in 0..width {
            for (i, c) in column.iter_mut().enumerate() {
                *c = plane[i * width + j];
            }
            transform(&mut column, height);
            for (i, c) in column.iter().enumerate() {
                power[i * width + j] = (c / rest.len() as f64).norm_sqr();
            }
        }
        Ok(GridPower { columns: line(columns), rows: line(rows), rest: power })
    }
}

impl GridPower {
    /// Returns the squared modulus of the coefficient at a frequency, periodic in both numbers; 0
    /// where it is that of the mean.
    pub(super) fn at(&self, k: [i32; 2]) -> f64 {
        let index = |k: i32, len: usize| {
            let len = i64::try_from(len).unwrap_or(i64::MAX);
            usize::try_from(i64::from(k).rem_euclid(len)).unwrap_or_default()
        };
        let (j, i) = (index(k[0], self.columns.len()), index(k[1], self.rows.len()));
        match (j, i) {
            (0, 0) => 0.0,
            (j, 0) => self.columns[j],
            (0, i) => self.rows[i],
            (j, i) => self.rest[i * self.columns.len() + j],
        }
    }
}
