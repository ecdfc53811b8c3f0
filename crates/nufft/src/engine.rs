use num_complex::Complex;
use pulp::Arch;

use crate::cells::{Cells, LANES, Places, Turns};
use crate::design::Design;
use crate::error::Error;
use crate::fourier::{Fourier, FourierScratch};
use crate::magnitude::{magnitude, magnitude_of, magnitude_of_complex};
use crate::memory::resize;
use crate::real::Real;
use crate::spreading::Spreading;
use crate::threads::Threads;

/// The transforms of both types with grids of type `T`.
#[derive(Clone)]
pub(crate) struct Engine<T> {
    arch: Arch,
    spreading: Spreading<T>,
    fourier: Fourier<T>,
}

/// Workspace of [`Engine`].
#[derive(Debug, Default)]
pub(crate) struct Scratch<T> {
    cells: Cells<T>,
    /// One grid after the other.
    grids: Vec<T>,
    fourier: FourierScratch<T>,
    /// The weights of two functions at each point.
    weights: Vec<[T; 2]>,
}

impl<T: Real> Engine<T> {
    pub(crate) fn new(kmax: usize, design: Design, arch: Arch) -> Self {
        let cells = design.cells(kmax);
        let spreading = Spreading::new([cells; 2], cells, design.window, design.epsilon);
        Self { arch, spreading, fourier: Fourier::new(kmax, cells, design.window) }
    }

    fn reserve(&self, points: usize, grids: usize, scratch: &mut Scratch<T>) -> Result<(), Error> {
        scratch.cells.reserve(points, Threads::Caller)?;
        resize(scratch.fourier.spectra(), self.fourier.spectra_len())?;
        resize(&mut scratch.grids, grids * self.spreading.grid_len())
    }

    /// Replaces `out` by the coefficients of points.
    pub(crate) fn adjoint<R: Real>(
        &self,
        points: &[[R; 2]],
        weights: Option<&[R]>,
        scratch: &mut Scratch<T>,
        out: &mut [Complex<R>],
    ) -> Result<(), Error> {
        self.reserve(points.len(), 1, scratch)?;
        let Scratch { cells, grids, fourier, .. } = scratch;
        let size = weights.map_or(1.0, magnitude_of);
        self.spreading.locate(
            self.arch,
            &Points(points),
            weights,
            1.0 / size,
            Threads::Caller,
            cells,
        );
        self.spreading.spread(self.arch, cells, Threads::Caller, grids);
        self.fourier.run(self.arch, grids, &self.spreading, size, fourier, out);
        Ok(())
    }

    /// Replaces `outs` by the coefficients of points with pairs of weights; `weight(j, b)` is that
    /// of point j for output b.
    pub(crate) fn adjoint_pair<R: Real, C: Real>(
        &self,
        points: &[[R; 2]],
        weight: impl Fn(usize, usize) -> f64,
        scratch: &mut Scratch<T>,
        outs: [&mut [Complex<C>]; 2],
    ) -> Result<(), Error> {
        self.reserve(points.len(), 2, scratch)?;
        resize(&mut scratch.weights, points.len())?;
        let Scratch { cells, grids, fourier, weights } = scratch;
        let sizes = [0, 1].map(|b| magnitude((0..points.len()).map(|j| weight(j, b))));
        for (j, scaled) in weights.iter_mut().enumerate().take(points.len()) {
            *scaled = [0, 1].map(|b| T::of(weight(j, b) * (1.0 / sizes[b])));
        }
        self.spreading.locate::<R>(self.arch, &Points(points), None, 1.0, Threads::Caller, cells);
        let (first, second) = grids.split_at_mut(self.spreading.grid_len());
        let mut grids = [first, second];
        self.spreading.spread_together(
            self.arch,
            cells,
            Some(weights),
            Threads::Caller,
            grids.each_mut().map(|g| &mut **g),
        );
        for ((grid, size), out) in grids.into_iter().zip(sizes).zip(outs) {
            self.fourier.run(self.arch, grid, &self.spreading, size, fourier, out);
        }
        Ok(())
    }

    /// Replaces `out` by the values of series at points: that of series b at point j at
    /// `j n_series + b`.
    pub(crate) fn evaluate<R: Real, C: Real>(
        &self,
        series: &[&[Complex<C>]],
        points: &[[R; 2]],
        scratch: &mut Scratch<T>,
        out: &mut [R],
    ) -> Result<(), Error> {
        let sizes = self.synthesise(series, points, scratch)?;
        let Scratch { cells, grids, .. } = scratch;
        self.spreading.interpolate_body(self.arch, cells, grids, &sizes, Threads::Caller, out);
        Ok(())
    }

    /// Replaces `out` by the value of a series and its derivatives by both coordinates at points.
    pub(crate) fn gradient<R: Real>(
        &self,
        series: &[Complex<R>],
        points: &[[R; 2]],
        scratch: &mut Scratch<T>,
        out: &mut [[R; 3]],
    ) -> Result<(), Error> {
        let sizes = self.synthesise(&[series], points, scratch)?;
        let Scratch { cells, grids, .. } = scratch;
        self.spreading.interpolate_gradient(
            self.arch,
            cells,
            grids,
            sizes[0],
            Threads::Caller,
            out,
        );
        Ok(())
    }

    /// Computes the grids of series and locates the points; returns the factors of the grids.
    fn synthesise<R: Real, C: Real>(
        &self,
        series: &[&[Complex<C>]],
        points: &[[R; 2]],
        scratch: &mut Scratch<T>,
    ) -> Result<Vec<f64>, Error> {
        self.reserve(points.len(), series.len(), scratch)?;
        let Scratch { cells, grids, fourier, .. } = scratch;
        self.spreading.locate::<R>(self.arch, &Points(points), None, 1.0, Threads::Caller, cells);
        let grids = grids.chunks_exact_mut(self.spreading.grid_len());
        let grid_of = |(coefficients, grid): (&&[Complex<C>], &mut [T])| {
            let size = magnitude_of_complex(coefficients);
            let spreading = &self.spreading;
            self.fourier.run_inverse(self.arch, coefficients, 1.0 / size, spreading, fourier, grid);
            size
        };
        Ok(series.iter().zip(grids).map(grid_of).collect())
    }
}

/// Points given in turns.
struct Points<'a, R>(&'a [[R; 2]]);

impl<R: Real> Places for Points<'_, R> {
    fn count(&self) -> usize {
        self.0.len()
    }

    #[inline(always)]
    fn turns<const FUSED: bool>(&self, first: usize) -> [Turns; 2] {
        let mut turns = [Turns::default(); 2];
        for (i, point) in self.0[first..].iter().take(LANES).enumerate() {
            for (turns, x) in turns.iter_mut().zip(point) {
                turns.set(i, x.to_f64());
            }
        }
        turns
    }
}
