use num_complex::Complex;
use sphvar_nufft::{
    CircleTransform, CircleWorkspace, TorusCoefficients, TorusTransform, TorusWorkspace,
};
use sphvar_samplers::PointSet;
use sphvar_sh::{ByAxis, Frequencies};

use crate::accumulate::{SetTransform, given_weights};
use crate::{Error, Resolution, SpectralBands, square_tail_power};

/// The coefficients of a set of points [u, v] of the square are
/// `S_k = sum_j w_j exp(-2 pi i (k1 u_j + k2 v_j))` for every band.
impl SpectralBands for Frequencies {
    type Point = [f64; 2];
    type Coefficients = Vec<Complex<f64>>;

    const UNIT_POWER: f64 = 1.0;

    fn powers(coefficients: &Vec<Complex<f64>>, normalization: f64) -> Vec<f64> {
        coefficients.iter().map(|s| normalization * s.norm_sqr()).collect()
    }

    fn tail_power(set: &PointSet<[f64; 2]>) -> ByAxis {
        square_tail_power(set)
    }
}

/// Frequencies and accuracy of a spectrum on the square.
#[derive(Clone, Debug, PartialEq)]
pub struct SquareResolution {
    /// The frequencies.
    pub frequencies: Frequencies,
    /// The accuracy of coefficients relative to the sum of the absolute weights, in [1e-13, 1e-1].
    pub epsilon: f64,
}

impl SquareResolution {
    /// The maximum kmax of spectra with an error for every band; the accumulator of a band takes
    /// about 400 bytes on every thread.
    pub const MAX_KMAX_WITH_ERRORS: usize = 512;

    /// Returns the resolution with the default accuracy, [`Resolution::EPSILON`].
    #[must_use]
    pub fn new(frequencies: Frequencies) -> Self {
        Self { frequencies, epsilon: Resolution::EPSILON }
    }

    /// Returns the frequency at which the spectrum of a random pattern has converged to its limit:
    /// 4 sqrt(N), at least 32, as [`Resolution::natural_degree`].
    #[must_use]
    pub fn natural_frequency(n_points: usize) -> usize {
        Resolution::natural_degree(n_points)
    }

    /// Returns the nominal work of transforming one set of `n_points`, in the units of
    /// [`Method::nominal_work`](crate::Method::nominal_work), about 60 ns on one core.
    ///
    /// ```text
    /// 3 N + 5 (kmax + 1)^2 + 100,   with axes beyond kmax: + N + axis_max + 100
    /// ```
    #[must_use]
    pub fn nominal_work(&self, n_points: usize) -> f64 {
        let (n, kmax) = (n_points as f64, self.frequencies.kmax() as f64);
        let axes =
            if self.has_axes() { n + self.frequencies.axis_max() as f64 + 100.0 } else { 0.0 };
        3.0 * n + 5.0 * (kmax + 1.0).powi(2) + 100.0 + axes
    }

    /// Returns the memory in bytes that [`accumulate_square`](crate::accumulate_square) needs for
    /// `sets` sets of `n_points` on `threads` threads, excluding the accumulators: a lower bound
    /// that includes all large allocations.
    #[must_use]
    pub fn bytes(&self, n_points: usize, sets: u64, threads: usize) -> f64 {
        let busy = sets.clamp(1, threads.max(1) as u64) as f64;
        // Grid and spectra of the transform, coefficients and gathered bands of four sets.
        let side = 2.0 * self.frequencies.kmax() as f64 + 1.0;
        let plane = 48.0 * side * side;
        let axes = if self.has_axes() { 150.0 * self.frequencies.axis_max() as f64 } else { 0.0 };
        busy * (plane + axes + 64.0 * self.frequencies.len() as f64 + 150.0 * n_points as f64)
    }

    /// Returns whether there are frequencies on the axes beyond kmax.
    fn has_axes(&self) -> bool {
        self.frequencies.axis_max() > self.frequencies.kmax()
    }
}

/// The transform of points of the square: all frequencies to kmax from a grid in two dimensions,
/// those on the axes beyond it from the coordinates alone.
pub(super) struct SquareTransform {
    resolution: SquareResolution,
    plane: TorusTransform,
    axes: Option<CircleTransform>,
}

#[derive(Debug, Default)]
pub(crate) struct SquareWorkspace {
    plane: TorusWorkspace,
    /// Of the largest frequency of the current transform.
    coefficients: Option<TorusCoefficients>,
    axes: CircleWorkspace,
    coordinates: Vec<f64>,
    of_axis: Vec<Complex<f64>>,
}

impl SquareTransform {
    /// Returns the transform.
    ///
    /// # Errors
    ///
    /// [`Error::SquareTransform`] if the accuracy is out of range.
    pub(super) fn new(resolution: &SquareResolution) -> Result<Self, Error> {
        let SquareResolution { frequencies, epsilon } = resolution;
        let axes = resolution.has_axes();
        Ok(Self {
            plane: TorusTransform::new(frequencies.kmax(), *epsilon)?,
            axes: axes
                .then(|| CircleTransform::new(frequencies.axis_max(), *epsilon))
                .transpose()?,
            resolution: resolution.clone(),
        })
    }

    fn transform(
        &self,
        set: &PointSet<[f64; 2]>,
        workspace: &mut SquareWorkspace,
        out: &mut [Complex<f64>],
    ) -> Result<(), Error> {
        let frequencies = &self.resolution.frequencies;
        let (kmax, axis_max) = (frequencies.kmax(), frequencies.axis_max());
        let weights = given_weights(set);
        let coefficients = match &mut workspace.coefficients {
            Some(coefficients) => coefficients,
            none => none.insert(TorusCoefficients::zeros(kmax)?),
        };
        self.plane.adjoint_into(&set.points, weights, &mut workspace.plane, coefficients)?;
        let (within, beyond) = out.split_at_mut(frequencies.len() - 2 * (axis_max - kmax));
        for (band, s) in within.iter_mut().enumerate() {
            let [k1, k2] = frequencies.frequency(band);
            *s = coefficients.get(k1, k2).unwrap_or_default();
        }
        let Some(transform) = &self.axes else {
            return Ok(());
        };
        // Beyond kmax, (k, 0) and (0, k) alternate.
        for axis in 0..2 {
            workspace.coordinates.clear();
            workspace.coordinates.extend(set.points.iter().map(|p| p[axis]));
            workspace.of_axis.resize(axis_max + 1, Complex::default());
            let of_axis = &mut workspace.of_axis;
            transform.adjoint_into(
                &workspace.coordinates,
                weights,
                &mut workspace.axes,
                of_axis,
            )?;
            let places = beyond.iter_mut().skip(axis).step_by(2);
            for (s, value) in places.zip(&of_axis[kmax + 1..]) {
                *s = *value;
            }
        }
        Ok(())
    }
}

impl SetTransform for SquareTransform {
    type Bands = Frequencies;
    type Workspace = SquareWorkspace;

    fn zeros(&self) -> Result<Vec<Complex<f64>>, Error> {
        Ok(vec![Complex::default(); self.resolution.frequencies.len()])
    }

    fn prepare(&self, workspace: &mut SquareWorkspace, _is_lone: bool) {
        let kmax = self.resolution.frequencies.kmax();
        workspace.coefficients.take_if(|coefficients| coefficients.kmax() != kmax);
    }

    fn run(
        &self,
        sets: &[PointSet<[f64; 2]>],
        workspace: &mut SquareWorkspace,
        out: &mut [Vec<Complex<f64>>],
    ) -> Result<(), Error> {
        sets.iter().zip(out).try_for_each(|(set, out)| self.transform(set, workspace, out))
    }

    fn work(&self, n_points: usize) -> f64 {
        self.resolution.nominal_work(n_points)
    }
}
