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
///     let fibonacci = Pattern::FIBONACCI.build(n, Domain::Sphere)?;
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

#[cfg(test)]
mod tests {
    use sphvar_samplers::{
        Domain, Pattern, Purpose, Realizations, SquarePattern, SquareRealizations, Streams,
    };
    use sphvar_sh::Frequencies;

    use super::Workspaces;
    use crate::{
        ExactSpectrum, ExactSquareSpectrum, Method, Resolution, SpectrumAccumulator,
        SquareResolution, accumulate, accumulate_square, accumulate_square_with, accumulate_with,
    };

    /// Buffers of larger and smaller sets, other degrees, accuracies in f32 and f64, and both methods.
    #[test]
    fn used_buffers_do_not_change_spectra() {
        let workspaces = Workspaces::default();
        let streams = Streams::new(3, Purpose::Pattern, 0);
        for (n, lmax, epsilon, count) in [
            (300, 90, 1e-12, 9),
            (20, 7, 1e-3, 2),
            (700, 130, 1e-5, 3),
            (1, 0, 1e-9, 6),
            (300, 90, 1e-12, 4),
        ] {
            for method in [Method::Fast, Method::Exact] {
                let sampler = Pattern::WhiteNoise.build(n, Domain::Sphere).unwrap();
                let sets = Realizations::rotated(&*sampler, streams);
                let resolution = Resolution { lmax, n_points: n, method, epsilon };
                let empty = SpectrumAccumulator::new(Domain::Sphere, n, lmax);
                let used = accumulate_with(&workspaces, &sets, resolution, 0..count, &empty, &());
                let fresh = accumulate(&sets, resolution, 0..count, &empty, &()).unwrap();
                assert_eq!(used.unwrap().finish().unwrap(), fresh.finish().unwrap(), "{n} {lmax}");
            }
            let sampler = Pattern::FIBONACCI.build(n, Domain::Sphere).unwrap();
            let exact = ExactSpectrum::of(&*sampler).unwrap();
            let used = exact.to_with(&workspaces, lmax, &()).unwrap();
            assert_eq!(used, exact.to(lmax, &()).unwrap(), "{n} {lmax}");
        }
    }

    #[test]
    fn used_buffers_do_not_change_spectra_on_the_square() {
        let workspaces = Workspaces::default();
        let streams = Streams::new(3, Purpose::Pattern, 0);
        for (n, kmax, axis, epsilon, count) in [
            (200, 40, 900, 1e-12, 9),
            (3, 0, 0, 1e-3, 2),
            (500, 60, 60, 1e-5, 3),
            (200, 40, 41, 1e-12, 5),
        ] {
            let frequencies = Frequencies::new(kmax).unwrap().with_axes(axis).unwrap();
            let resolution = SquareResolution { frequencies: frequencies.clone(), epsilon };
            let empty = SpectrumAccumulator::of_square(frequencies.clone(), n).unwrap();
            let sampler = SquarePattern::WhiteSquare.build(n).unwrap();
            let sets = SquareRealizations::shifted(&*sampler, streams);
            let used =
                accumulate_square_with(&workspaces, &sets, &resolution, 0..count, &empty, &());
            let fresh = accumulate_square(&sets, &resolution, 0..count, &empty, &()).unwrap();
            assert_eq!(used.unwrap().finish().unwrap(), fresh.finish().unwrap(), "{n} {kmax}");
            let sampler = SquarePattern::HAMMERSLEY.build(n).unwrap();
            let exact = ExactSquareSpectrum::of(&*sampler).unwrap();
            let used = exact.to_with(&workspaces, &frequencies, &()).unwrap();
            assert_eq!(used, exact.to(&frequencies, &()).unwrap(), "{n} {kmax}");
        }
    }
}
