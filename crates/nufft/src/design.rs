use crate::error::Error;
use crate::limits::{MAX_EPSILON, MIN_EPSILON};
use crate::sizes::good_size;
use crate::window::Window;

/// The least expensive parameters for an accuracy: number type, oversampling, and window.
///
/// A coarser grid has a less expensive Fourier transform, but it needs a wider window and amplifies
/// rounding errors at high frequencies: it is efficient only for low accuracies. The rounding error
/// of f32, 6e-8, is a further limit.
#[derive(Clone, Copy, Debug)]
pub struct Design {
    /// Whether the grid is stored in f32.
    pub single: bool,
    /// The window between points and grid.
    pub window: Window,
    /// The accuracy.
    pub epsilon: f64,
    oversampling: f64,
}

impl Design {
    /// Returns the design for accuracy `epsilon` in the Euclidean norm, where frequencies that are
    /// high in both directions have little weight, as on the sphere.
    ///
    /// # Errors
    ///
    /// [`Error::Accuracy`] if it is NaN or outside \[[`MIN_EPSILON`], [`MAX_EPSILON`]\].
    pub fn in_norm(epsilon: f64) -> Result<Self, Error> {
        // Rounding of f32 is amplified more by wider windows, and least by the finer grid. The
        // first factors are slightly below 5/4 and 3/2, so that the grids for degrees 2^k have
        // sizes 5 2^k and 3 2^k. From 1e-9 down to 5e-13 the grid is the smallest for which the
        // widest window, of 16 cells, has the accuracy; below, rounding needs a finer one.
        let (single, oversampling) = match epsilon {
            e if e >= 4e-6 => (true, 1.245),
            e if e >= 5e-7 => (true, 1.49),
            e if e >= 1e-9 => (false, 1.245),
            e if e >= 1e-11 => (false, 1.395),
            e if e >= 5e-13 => (false, 1.545),
            _ => (false, 2.0),
        };
        Self::new(epsilon, Window::new(epsilon, oversampling), single, oversampling)
    }

    /// Returns the design with the smallest errors that windows in f64 permit, about 1e-14: a window
    /// of 16 cells on grids that are twice as fine as necessary.
    #[must_use]
    pub fn finest() -> Self {
        // Aliasing is below this; the window itself has rounding errors of a few 1e-15.
        let (epsilon, oversampling) = (1.6e-15, 2.0);
        let window = Window::new(epsilon, oversampling).with_tolerance(5e-15);
        Self { single: false, window, epsilon, oversampling }
    }

    /// Returns the design for accuracy `epsilon` at every frequency, including the highest in both
    /// directions.
    ///
    /// Compared with [`Self::in_norm`], the window must be more accurate by a measured factor of at
    /// most 13, and rounding is amplified in both directions. With these limits the maximum
    /// measured error was 0.6 epsilon, for kmax up to 1500.
    ///
    /// # Errors
    ///
    /// [`Error::Accuracy`] if it is NaN or outside \[[`MIN_EPSILON`], [`MAX_EPSILON`]\].
    pub fn at_every_frequency(epsilon: f64) -> Result<Self, Error> {
        let (single, oversampling) = match epsilon {
            e if e >= 1e-3 => (true, 1.245),
            e if e >= 3e-5 => (true, 1.49),
            e if e >= 1e-5 => (true, 1.745),
            e if e >= 5e-6 => (true, 2.0),
            e => return Self::double_at_every_frequency(e),
        };
        Self::new(epsilon, Window::new(epsilon / 16.0, oversampling), single, oversampling)
    }

    /// Returns the design for accuracy `epsilon` at every frequency on a grid in f64.
    pub(crate) fn double_at_every_frequency(epsilon: f64) -> Result<Self, Error> {
        let oversampling = match epsilon {
            e if e >= 1e-7 => 1.245,
            e if e >= 1e-10 => 1.49,
            e if e >= 1e-11 => 1.745,
            // Wide windows on coarser grids amplify rounding in derivatives beyond these accuracies.
            e if e >= 5e-13 => 2.25,
            _ => 2.75,
        };
        Self::new(epsilon, Window::new(epsilon / 16.0, oversampling), false, oversampling)
    }

    fn new(epsilon: f64, window: Window, single: bool, oversampling: f64) -> Result<Self, Error> {
        if (MIN_EPSILON..=MAX_EPSILON).contains(&epsilon) {
            Ok(Self { single, window, epsilon, oversampling })
        } else {
            Err(Error::Accuracy { epsilon })
        }
    }

    /// Returns the number of grid cells per turn for frequencies up to `kmax`, a multiple of 4.
    #[must_use]
    pub fn cells(&self, kmax: usize) -> usize {
        // The minimum keeps the window from overlapping itself around the torus.
        good_size((self.oversampling * (2 * kmax + 2) as f64).max(48.0), 1.12)
    }
}
