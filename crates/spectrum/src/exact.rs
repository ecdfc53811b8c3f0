//! Spectra that are known without sampling.

mod cell_means;
mod chord_moments;
mod partition;
mod quadrature;
mod strata;
#[cfg(test)]
mod tests;

use sphvar_samplers::{Law, PointSet, Progress, Purpose, Realizations, Sampler, Streams};
use sphvar_sh::{ByParity, LmIndex};
use sphvar_sht::Method;

use crate::{Error, Resolution, Spectrum, SpectrumAccumulator, accumulate};
use partition::Partition;

/// The accuracy of coefficients by the fast transform, its best.
const EPSILON: f64 = 1e-13;

/// The mean power per degree of a sampler, from what is known of its law, without sampling: no realizations, standard
/// errors of 0.
///
/// - Independent uniform points have 1 for every `l >= 1`.
/// - A pattern that is not random has the power of its one set, transformed to `1e-13 N`; one of several given sets the
///   mean of theirs.
/// - One uniform point in each of N strata `W_k` of equal area, independent of the others, has
///
/// ```text
/// P(l) = 1 - (1/N) sum_k E P_l(x.y),   x and y independent and uniform in W_k,   l >= 1
/// ```
///
/// on the hemisphere, for even l, with the N strata of the hemisphere. The mean is taken by
/// Gauss-Legendre quadrature in equal-area coordinates, over one of all congruent strata. While strata are
/// small against `1/l` it goes by the distances of pairs of nodes, otherwise by the transforms of the
/// nodes, whichever is of less nominal work; degrees to sqrt(N), where the power is small, always go
/// by distances, which keep relative accuracy: about 1e-12, as far as tested (1e-12 absolute
/// beyond sqrt(N)).
///
/// # Examples
///
/// ```
/// use sphvar_samplers::{Domain, Pattern};
/// use sphvar_spectrum::ExactSpectrum;
///
/// let jittered = Pattern::Jittered.build(3072, Domain::Sphere)?;
/// let spectrum = ExactSpectrum::of(&*jittered).expect("of strata").to(8, &())?;
/// assert!(spectrum.is_exact() && spectrum.realizations() == 0);
/// // c_N l(l+1)/N with c_N = 1.1168.
/// assert!((spectrum.power()[1] * 3072.0 / 2.0 - 1.1168).abs() < 1e-4);
/// # Ok::<(), sphvar_spectrum::Error>(())
/// ```
#[derive(Debug)]
pub struct ExactSpectrum<'a> {
    sampler: &'a dyn Sampler,
    kind: Kind<'a>,
}

/// Why there is a spectrum without sampling.
#[derive(Debug)]
enum Kind<'a> {
    White,
    Fixed,
    Sets(&'a [PointSet]),
    Stratified(Partition),
}

impl<'a> ExactSpectrum<'a> {
    /// Returns the spectrum of a sampler; `None` if its law does not tell.
    #[must_use]
    pub fn of(sampler: &'a dyn Sampler) -> Option<Self> {
        let kind = match sampler.law() {
            Law::Independent => Kind::White,
            Law::Fixed => Kind::Fixed,
            Law::OneOf(sets) => Kind::Sets(sets),
            Law::Stratified(strata) => Kind::Stratified(Partition::of(strata, sampler.n_points())?),
            _ => return None,
        };
        Some(Self { sampler, kind })
    }

    /// Returns the power to degree `lmax`; [`Self::work`] is ticked in pieces. The bits do not depend on the number of
    /// threads.
    ///
    /// # Errors
    ///
    /// [`Error::Transform`] if `lmax` is out of range, [`Error::Sampler`] if the one set cannot be made or `progress` ends
    /// the work.
    pub fn to(&self, lmax: usize, progress: &dyn Progress) -> Result<Spectrum, Error> {
        // The one check of the degree for all ways.
        LmIndex::new(lmax)?;
        let (domain, n_points) = (self.sampler.domain(), self.sampler.n_points());
        let power = match &self.kind {
            Kind::White => vec![1.0; lmax + 1],
            Kind::Stratified(partition) => strata::power(partition, lmax, progress)?,
            Kind::Fixed => {
                let one =
                    Realizations::unrotated(self.sampler, Streams::new(0, Purpose::Pattern, 0));
                let mut set = PointSet::default();
                one.realize_into(0, &mut set, progress)?;
                return self.of_sets(&[set], lmax, progress);
            }
            Kind::Sets(sets) => return self.of_sets(sets, lmax, progress),
        };
        // Random points coincide with probability 0.
        Ok(Spectrum::exact(domain, n_points, power).with_tail(ByParity::both(1.0)))
    }

    /// Returns the nominal work of [`Self::to`].
    #[must_use]
    pub fn work(&self, lmax: usize) -> f64 {
        let transform = |n_points| Method::Auto.nominal_work(n_points, lmax);
        match &self.kind {
            Kind::White => 0.0,
            Kind::Fixed => self.sampler.nominal_work() + transform(self.sampler.n_points()),
            Kind::Sets(sets) => sets.len() as f64 * transform(self.sampler.n_points()),
            Kind::Stratified(partition) => strata::work(partition, lmax),
        }
    }

    /// Returns the bytes that [`Self::to`] takes on `threads` threads: an estimate from below that misses no
    /// large part.
    #[must_use]
    pub fn bytes(&self, lmax: usize, threads: usize) -> f64 {
        let spectrum = 16.0 * (lmax as f64 + 1.0);
        let transform = Method::Auto.bytes(self.sampler.n_points(), lmax, 1);
        spectrum
            + match &self.kind {
                Kind::White => 0.0,
                Kind::Fixed => transform,
                Kind::Sets(sets) => transform * threads.clamp(1, sets.len().max(1)) as f64,
                Kind::Stratified(partition) => strata::bytes(partition, lmax, threads),
            }
    }

    /// The mean power of sets, each normalised by its own number of points. Rotations would not change it.
    fn of_sets(
        &self,
        sets: &[PointSet],
        lmax: usize,
        progress: &dyn Progress,
    ) -> Result<Spectrum, Error> {
        let n_points = self.sampler.n_points();
        let resolution = Resolution { epsilon: EPSILON, ..Resolution::new(lmax, n_points) };
        let empty = SpectrumAccumulator::new(self.sampler.domain(), n_points, lmax);
        let all = 0..sets.len() as u64;
        let mean = accumulate(&sets, resolution, all, &empty, progress)?.finish()?;
        let n_effective = mean.n_effective();
        let spectrum = Spectrum::exact(self.sampler.domain(), n_points, mean.power().to_vec());
        Ok(spectrum.with_tail(mean.tail()).with_n_effective(n_effective))
    }
}
