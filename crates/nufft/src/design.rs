use crate::error::Error;
use crate::limits::{MAX_EPSILON, MIN_EPSILON};
use crate::sizes::good_size;
use crate::window::Window;

/// What reaches an accuracy at least cost: the numbers of the grid, how fine it is, and the window.
///
/// A coarser grid is less expensive to transform but needs a wider window, and amplifies rounding
/// at its high frequencies: it pays for low accuracies only. Numbers of f32 round at 6e-8 before
/// that.
#[derive(Clone, Copy, Debug)]
pub struct Design {
    /// Whether the numbers of the grid are f32.
    pub single: bool,
    /// The window between points and grid.
    pub window: Window,
    /// The accuracy.
    pub epsilon: f64,
    oversampling: f64,
}

impl Design {
    /// Returns the design for accuracy `epsilon` in the Euclidean norm, where frequencies that are
    /// high in both directions count little, as they do on the sphere.
    ///
    /// # Errors
    ///
    /// [`Error::Accuracy`] if it is NaN or outside \[[`MIN_EPSILON`], [`MAX_EPSILON`]\].
    pub fn in_norm(epsilon: f64) -> Result<Self, Error> {
        // The first ones lie a little below 5/4, 3/2 and 7/4, which keeps grids for degrees 2^k at
        // sizes 5 2^k, 3 2^k and 7 2^k.
        let (single, oversampling) = match epsilon {
            e if e >= 2e-6 => (true, 1.245),
            e if e >= 5e-7 => (true, 1.49),
            e if e >= 1e-9 => (false, 1.245),
            e if e >= 1e-11 => (false, 1.49),
            e if e >= 5e-13 => (false, 1.745),
            _ => (false, 2.0),
        };
        Self::new(epsilon, Window::new(epsilon, oversampling), single, oversampling)
    }

    /// Returns the design for accuracy `epsilon` at every frequency, the highest in both directions
    /// included.
    ///
    /// There, the window must be better by a factor that was measured as 13 at most, and rounding
    /// is amplified twice. With these limits the largest error measured was 0.6 epsilon, for kmax
    /// up to 1500.
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
            e if e >= 1e-7 => (false, 1.245),
            e if e >= 1e-10 => (false, 1.49),
            e if e >= 1e-11 => (false, 1.745),
            e if e >= 5e-13 => (false, 2.0),
            _ => (false, 2.5),
        };
        Self::new(epsilon, Window::new(epsilon / 16.0, oversampling), single, oversampling)
    }

    fn new(epsilon: f64, window: Window, single: bool, oversampling: f64) -> Result<Self, Error> {
        if (MIN_EPSILON..=MAX_EPSILON).contains(&epsilon) {
            Ok(Self { single, window, epsilon, oversampling })
        } else {
            Err(Error::Accuracy { epsilon })
        }
    }

    /// Returns the grid cells to a turn for frequencies up to `kmax`, a multiple of 4.
    #[must_use]
    pub fn cells(&self, kmax: usize) -> usize {
        // Not so small that the window would meet its own other end.
        good_size((self.oversampling * (2 * kmax + 2) as f64).max(48.0), 1.12)
    }
}
