use std::f64::consts::{PI, TAU};
use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};
use sphvar_sh::{Alm, Colatitude, Error};

use crate::window::{MAX_WIDTH, Window};
use crate::{RingTransform, RingWorkspace};

/// The fast transform of scattered weighted points to a requested accuracy,
/// `a_lm = sum_k w_k conj Y_lm(x_k)`.
///
/// The sphere is laid twice on the torus, theta in [0, 2 pi), where a function of degree L is a
/// trigonometric polynomial. Points are spread onto a regular grid by a window; Fourier transforms,
/// divided by that of the window, take the grid to L + 2 rings of constant theta; from there a
/// Legendre transform that is exact for degree L leads to the coefficients.
///
/// Cost O(N log^2(1/epsilon) + L^3) against O(N L^2) of [`ExactTransform`](crate::ExactTransform).
#[derive(Clone)]
pub struct FastTransform {
    rings: RingTransform,
    window: Window,
    n_phi: usize,
    n_theta: usize,
    /// Rings on the whole torus, an even number 2R > 2 lmax: ring r is at `theta = pi r/R`.
    n_rings: usize,
    /// One over the window's transform at each m, and at each k from 0 (it is even in k).
    phi_correction: Box<[f64]>,
    theta_correction: Box<[f64]>,
    row_fft: Arc<dyn RealToComplex<f64>>,
    grid_fft: Arc<dyn Fft<f64>>,
    ring_fft: Arc<dyn Fft<f64>>,
}

impl fmt::Debug for FastTransform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FastTransform")
            .field("lmax", &self.lmax())
            .field("window_width", &self.window.width())
            .field("grid", &(self.n_theta, self.n_phi))
            .finish_non_exhaustive()
    }
}

/// Scratch memory of [`FastTransform`]; grows to the largest set it has seen.
#[derive(Debug, Default)]
pub struct FastWorkspace {
    rings: RingWorkspace,
    /// The points as (row, column) coordinates and weight, by row.
    points: Vec<GridPoint>,
    unsorted: Vec<GridPoint>,
    row_starts: Vec<usize>,
    /// Rows of the grid, each followed by `MAX_WIDTH` more entries that wrap to its start.
    grid: Vec<f64>,
    row: Vec<f64>,
    row_spectrum: Vec<Complex<f64>>,
    /// By set: `columns[m * rows + i]` is the Fourier coefficient m of row i.
    columns: Vec<Vec<Complex<f64>>>,
    torus: Vec<Complex<f64>>,
    ring_values: Vec<Complex<f64>>,
    odd: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

/// A point in units of the grid.
#[derive(Clone, Copy, Debug, Default)]
struct GridPoint {
    row: f64,
    column: f64,
    weight: f64,
}

impl FastTransform {
    /// The plan for degree `lmax`, inclusive, and relative accuracy `epsilon`, which is brought into
    /// [1e-14, 1e-1] (down to 1e-13 it is met): for weights of one sign the error
    /// `||a - a_exact||` is at most `epsilon ||a_exact||`. With weights that cancel, the norm is that
    /// of their absolute values.
    ///
    /// # Errors
    ///
    /// [`Error::DegreeTooLarge`] if `lmax` is beyond what coefficients can be indexed for.
    pub fn new(lmax: usize, epsilon: f64) -> Result<Self, Error> {
        let epsilon = epsilon.clamp(1e-14, 1e-1);
        // A coarser grid needs a wider window, and rounding is amplified at its high frequencies: it
        // pays for low accuracies only.
        let oversampling = if epsilon >= 1e-8 { 1.5 } else { 2.0 };
        let window = Window::new(epsilon, oversampling)?;
        let fine = |least: usize| good_size((oversampling * least as f64).ceil().max(24.0));
        let n_phi = fine(2 * lmax + 2);
        let n_theta = fine(2 * lmax + 2);
        let n_rings = good_size((2 * lmax + 2).max(4) as f64);
        let correction = |n: usize| -> Result<Box<[f64]>, Error> {
            (0..=lmax).map(|m| Ok(1.0 / window.transform(m, n)?)).collect()
        };
        let mut planner = FftPlanner::new();
        Ok(Self {
            rings: RingTransform::new(lmax)?,
            phi_correction: correction(n_phi)?,
            theta_correction: correction(n_theta)?,
            row_fft: RealFftPlanner::new().plan_fft_forward(n_phi),
            grid_fft: planner.plan_fft_forward(n_theta),
            ring_fft: planner.plan_fft_inverse(n_rings),
            window,
            n_phi,
            n_theta,
            n_rings,
        })
    }

    /// The largest degree, inclusive.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.rings.lmax()
    }

    /// Rows of the grid beyond either pole.
    fn margin(&self) -> usize {
        self.window.width() / 2 + 1
    }

    /// Rows of the grid: theta from 0 to pi, and the margins.
    fn n_rows(&self) -> usize {
        self.n_theta / 2 + 1 + 2 * self.margin()
    }

    fn stride(&self) -> usize {
        self.n_phi + MAX_WIDTH
    }

    /// Replaces `out` by the coefficients of the points, with unit weights if `weights` is `None`.
    ///
    /// # Panics
    ///
    /// If `weights` and `points` differ in length, or `out` is not of this plan's lmax.
    pub fn adjoint_into(
        &self,
        points: &[DVec3],
        weights: Option<&[f64]>,
        workspace: &mut FastWorkspace,
        out: &mut Alm,
    ) {
        self.adjoint_batch_into(&[(points, weights)], workspace, std::slice::from_mut(out));
    }

    /// Replaces each of `outs` by the coefficients of one weighted set of points.
    ///
    /// The result for a set does not depend on its company, to the last bit, but the Legendre
    /// recurrence is shared: sets cost least in multiples of four.
    ///
    /// # Panics
    ///
    /// If there are not as many `outs` as `sets`, or as [`Self::adjoint_into`].
    pub fn adjoint_batch_into(
        &self,
        sets: &[(&[DVec3], Option<&[f64]>)],
        workspace: &mut FastWorkspace,
        outs: &mut [Alm],
    ) {
        assert_eq!(sets.len(), outs.len(), "one place for coefficients per set");
        workspace.columns.resize_with(sets.len().max(workspace.columns.len()), Vec::new);
        for (i, (points, weights)) in sets.iter().enumerate() {
            if let Some(weights) = weights {
                assert_eq!(weights.len(), points.len(), "one weight per point");
            }
            self.load(points, *weights, workspace);
            self.spread(workspace);
            self.transform_rows(i, workspace);
        }
        let FastWorkspace { rings, columns, torus, ring_values, odd, scratch, .. } = workspace;
        let half = self.n_rings / 2;
        let colatitudes = (0..=half).map(|r| ring_colatitude(r, half));
        odd.clear();
        odd.resize(sets.len() * (half + 1), Complex::ZERO);
        let columns = &columns[..sets.len()];
        self.rings.adjoint_batch_into(
            colatitudes,
            |m, terms| {
                if m % 2 == 1 {
                    terms.copy_from_slice(odd);
                    return;
                }
                let terms = terms.chunks_exact_mut(half + 1);
                for ((even, odd), columns) in terms.zip(odd.chunks_exact_mut(half + 1)).zip(columns)
                {
                    self.ring_pair(m, columns, torus, ring_values, scratch, even, odd);
                }
            },
            rings,
            outs,
        );
    }

    /// Brings the points into grid units, by row.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "rows are between 0 and their number"
    )]
    fn load(&self, points: &[DVec3], weights: Option<&[f64]>, workspace: &mut FastWorkspace) {
        let FastWorkspace { points: sorted, unsorted, row_starts, .. } = workspace;
        let (per_theta, per_phi) = (self.n_theta as f64 / TAU, self.n_phi as f64 / TAU);
        unsorted.clear();
        unsorted.extend(points.iter().enumerate().map(|(k, p)| {
            let theta = p.x.hypot(p.y).atan2(p.z);
            let phi = p.y.atan2(p.x);
            let column = phi * per_phi;
            GridPoint {
                row: theta * per_theta,
                column: if column < 0.0 { column + self.n_phi as f64 } else { column },
                weight: weights.map_or(1.0, |w| w[k]),
            }
        }));
        // Counting sort: points of a row share its stretch of memory.
        row_starts.clear();
        row_starts.resize(self.n_rows() + 1, 0);
        let row = |p: &GridPoint| (p.row as usize).min(self.n_rows() - 1);
        for p in &*unsorted {
            row_starts[row(p) + 1] += 1;
        }
        for i in 0..self.n_rows() {
            row_starts[i + 1] += row_starts[i];
        }
        sorted.clear();
        sorted.resize(unsorted.len(), GridPoint::default());
        for p in &*unsorted {
            let place = &mut row_starts[row(p)];
            sorted[*place] = *p;
            *place += 1;
        }
    }

    #[expect(
        clippy::cast_possible_wrap,
        clippy::cast_sign_loss,
        reason = "the margins keep rows and columns at or above 0"
    )]
    fn spread(&self, workspace: &mut FastWorkspace) {
        let FastWorkspace { points, grid, .. } = workspace;
        let (width, stride) = (self.window.width(), self.stride());
        grid.clear();
        grid.resize(self.n_rows() * stride, 0.0);
        let (mut by_row, mut by_column) = ([0.0; MAX_WIDTH], [0.0; MAX_WIDTH]);
        for p in &*points {
            let row = self.window.evaluate(p.row, &mut by_row) + self.margin() as isize;
            // Half a window to the right, so that no column is negative; `transform_rows` turns back.
            let shifted = p.column + 0.5 * width as f64;
            let column = self.window.evaluate(shifted, &mut by_column) as usize;
            for (i, &value) in by_row.iter().enumerate().take(width) {
                let start = (row as usize + i) * stride + column;
                let value = value * p.weight;
                for (g, w) in grid[start..start + MAX_WIDTH].iter_mut().zip(&by_column) {
                    *g += value * w;
                }
            }
        }
    }

    /// Fourier transforms of the rows, corrected for the window, into the columns of set `set`.
    fn transform_rows(&self, set: usize, workspace: &mut FastWorkspace) {
        let FastWorkspace { grid, row, row_spectrum, columns, scratch, .. } = workspace;
        let n_rows = self.n_rows();
        let columns = &mut columns[set];
        row.resize(self.n_phi, 0.0);
        row_spectrum.resize(self.n_phi / 2 + 1, Complex::ZERO);
        scratch.resize(self.row_fft.get_scratch_len().max(scratch.len()), Complex::ZERO);
        columns.clear();
        columns.resize(n_rows * (self.lmax() + 1), Complex::ZERO);
        let turn: Vec<Complex<f64>> = (0..=self.lmax())
            .map(|m| {
                let shift = 0.5 * self.window.width() as f64 * TAU / self.n_phi as f64;
                Complex::cis(m as f64 * shift) * self.phi_correction[m]
            })
            .collect();
        for (i, line) in grid.chunks_exact_mut(self.stride()).enumerate() {
            let (body, wrapped) = line.split_at_mut(self.n_phi);
            for (b, w) in body.iter_mut().zip(wrapped) {
                *b += *w;
            }
            row.copy_from_slice(body);
            // The lengths are those of the plan, so the transform cannot refuse them.
            let done = self.row_fft.process_with_scratch(row, row_spectrum, scratch);
            debug_assert!(done.is_ok());
            for (m, (value, turn)) in row_spectrum.iter().zip(&turn).enumerate() {
                columns[m * n_rows + i] = value * turn;
            }
        }
    }

    /// The terms of all rings for the even order `m` and the odd order m + 1.
    ///
    /// A column of even order is even about the poles, one of odd order odd: their sum is
    /// transformed once and taken apart by its symmetry.
    #[expect(clippy::too_many_arguments, reason = "the parts of a borrowed workspace")]
    fn ring_pair(
        &self,
        m: usize,
        columns: &[Complex<f64>],
        torus: &mut Vec<Complex<f64>>,
        ring_values: &mut Vec<Complex<f64>>,
        scratch: &mut Vec<Complex<f64>>,
        even: &mut [Complex<f64>],
        odd: &mut [Complex<f64>],
    ) {
        let (n, n_rows, margin) = (self.n_theta, self.n_rows(), self.margin());
        torus.clear();
        torus.resize(n, Complex::ZERO);
        for (order, sign) in [(m, 1.0), (m + 1, -1.0)] {
            let Some(column) = columns.get(order * n_rows..(order + 1) * n_rows) else {
                continue;
            };
            for (i, &value) in column.iter().enumerate() {
                let at = (i + n - margin) % n;
                torus[at] += value;
                torus[(n - at) % n] += value * sign;
            }
        }
        let needed =
            self.grid_fft.get_inplace_scratch_len().max(self.ring_fft.get_inplace_scratch_len());
        scratch.resize(needed.max(scratch.len()), Complex::ZERO);
        self.grid_fft.process_with_scratch(torus, scratch);
        ring_values.clear();
        ring_values.resize(self.n_rings, Complex::ZERO);
        // One 1/2 because the symmetrised column counts everything twice, one over the rings.
        let scale = 0.5 / self.n_rings as f64;
        ring_values[0] = torus[0] * (self.theta_correction[0] * scale);
        for (k, correction) in self.theta_correction.iter().enumerate().skip(1) {
            ring_values[k] = torus[k] * (correction * scale);
            ring_values[self.n_rings - k] = torus[n - k] * (correction * scale);
        }
        self.ring_fft.process_with_scratch(ring_values, scratch);
        let half = self.n_rings / 2;
        for r in 0..=half {
            let (here, mirrored) = (ring_values[r], ring_values[(self.n_rings - r) % self.n_rings]);
            // Rings between the poles stand for their mirror image on the torus too.
            let copies = if r == 0 || r == half { 0.5 } else { 1.0 };
            even[r] = (here + mirrored) * copies;
            odd[r] = (here - mirrored) * copies;
        }
    }
}

/// `theta = pi r/R`, exact at the poles and on the equator's two sides alike.
fn ring_colatitude(r: usize, half: usize) -> Colatitude {
    let acute = PI * r.min(half - r) as f64 / half as f64;
    let (sin, cos) = acute.sin_cos();
    let z = if 2 * r > half { -cos } else { cos };
    Colatitude::from_direction(DVec3::new(sin, 0.0, z))
}

/// The least even number from `least` on that has no prime factor above 5.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a grid size")]
fn good_size(least: f64) -> usize {
    let mut n = (least as usize).next_multiple_of(2);
    loop {
        let mut rest = n;
        for p in [2, 3, 5] {
            while rest.is_multiple_of(p) {
                rest /= p;
            }
        }
        if rest == 1 {
            return n;
        }
        n += 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ExactTransform;

    fn sets() -> Vec<(&'static str, Vec<DVec3>)> {
        let mut state = 1u64;
        let mut uniform = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 * 2f64.powi(-53)
        };
        let mut direction = move || {
            let (z, phi) = (1.0 - 2.0 * uniform(), TAU * uniform());
            let s = (1.0 - z * z).sqrt();
            DVec3::new(s * phi.cos(), s * phi.sin(), z)
        };
        let random: Vec<DVec3> = (0..300).map(|_| direction()).collect();
        let clustered = random.iter().map(|p| (*p * 1e-3 + DVec3::Y).normalize()).collect();
        let polar =
            random.iter().map(|p| DVec3::new(p.x * 1e-9, p.y * 1e-9, p.z.signum())).collect();
        vec![
            ("random", random),
            ("clustered", clustered),
            ("polar", polar),
            ("axes", vec![DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y]),
            ("one", vec![DVec3::new(0.48, 0.6, 0.64)]),
            ("none", vec![]),
        ]
    }

    #[test]
    fn a_set_does_not_feel_its_company() {
        let plan = FastTransform::new(40, 1e-9).unwrap();
        let sets = sets();
        let weights: Vec<f64> = (0..300).map(|k| 1.0 + 0.1 * f64::from(k % 7)).collect();
        // Six sets: a full pass of the shared recurrence and two single ones.
        let batch: Vec<(&[DVec3], Option<&[f64]>)> = sets
            .iter()
            .map(|(_, p)| (p.as_slice(), (p.len() == 300).then_some(weights.as_slice())))
            .collect();
        let mut workspace = FastWorkspace::default();
        let mut together = vec![Alm::zeros(40).unwrap(); batch.len()];
        plan.adjoint_batch_into(&batch, &mut workspace, &mut together);
        for ((points, weights), together) in batch.iter().zip(&together) {
            let mut alone = Alm::zeros(40).unwrap();
            plan.adjoint_into(points, *weights, &mut workspace, &mut alone);
            assert_eq!(&alone, together);
            let exact = ExactTransform::new(40).unwrap().adjoint(points, *weights).unwrap();
            let size: f64 = exact.values().iter().map(|a| a.norm_sqr()).sum::<f64>().sqrt();
            for (a, b) in exact.values().iter().zip(alone.values()) {
                assert!((a - b).norm() <= 1e-9 * size, "{a} and {b}");
            }
        }
    }

    #[test]
    fn the_accuracy_asked_for_is_met() {
        let mut workspace = FastWorkspace::default();
        for (name, points) in sets() {
            for lmax in [0, 1, 2, 15, 200] {
                let exact = ExactTransform::new(lmax).unwrap().adjoint(&points, None).unwrap();
                let norm = exact.values().iter().map(|a| a.norm_sqr()).sum::<f64>().sqrt();
                for epsilon in [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-12, 1e-13] {
                    let mut fast = Alm::zeros(lmax).unwrap();
                    let plan = FastTransform::new(lmax, epsilon).unwrap();
                    plan.adjoint_into(&points, None, &mut workspace, &mut fast);
                    let error = exact
                        .values()
                        .iter()
                        .zip(fast.values())
                        .map(|(a, b)| (a - b).norm_sqr())
                        .sum::<f64>()
                        .sqrt();
                    assert!(
                        error <= epsilon * norm,
                        "{name}, lmax {lmax}, {epsilon:e}: {:e}",
                        error / norm
                    );
                }
            }
        }
    }
}
