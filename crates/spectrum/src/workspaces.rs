use std::sync::{Mutex, PoisonError};

use sphvar_sht::TransformWorkspace;

use crate::square::SquareWorkspace;

/// Buffers of transforms, for callers that compute many spectra one after the other.
///
/// A transform to degree 1500 fills about 120 MB. Without this, every spectrum allocates its buffers and
/// returns them to the operating system, which takes up to half of the time of a single transform. The
/// buffers grow to the largest transform so far and are kept, for each thread that was busy at the same
/// time, until this is dropped. Results do not depend on it.
///
/// # Examples
///
/// ```
/// use sphvar_samplers::{Domain, Pattern};
/// use sphvar_spectrum::{ExactSpectrum, Workspaces};
///
/// let workspaces = Workspaces::default();
/// for n in [100, 200] {
///     let fibonacci = Pattern::Fibonacci.build(n, Domain::Sphere)?;
///     let spectrum = ExactSpectrum::of(&*fibonacci).expect("is always the same set");
///     assert_eq!(spectrum.to_with(&workspaces, 40, &())?, spectrum.to(40, &())?);
/// }
/// # Ok::<(), sphvar_spectrum::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct Workspaces {
    pub(crate) sphere: Stock<TransformWorkspace>,
    pub(crate) square: Stock<SquareWorkspace>,
}

/// Workspaces that are not in use.
#[derive(Debug, Default)]
pub(crate) struct Stock<W>(Mutex<Vec<W>>);

impl<W: Default> Stock<W> {
    /// Returns the workspace that was returned last, or a new one.
    pub(crate) fn take(&self) -> W {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default()
    }

    /// Returns a workspace to the stock.
    pub(crate) fn put(&self, workspace: W) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(workspace);
    }
}
