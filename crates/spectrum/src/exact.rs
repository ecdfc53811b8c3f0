//! Spectra that are known without sampling.

mod cell_means;
mod chord_moments;
mod partition;
mod quadrature;
mod strata;
#[cfg(test)]
mod tests;

use std::f64::consts::PI;

use glam::DVec3;
use sphvar_samplers::{Domain, Pattern, Purpose, Sampler, Streams};
use sphvar_sh::{Alm, ByParity, LmIndex};
use sphvar_sht::{Method, Transform, TransformWorkspace};

use crate::{Error, Spectrum, tail_power};
use partition::Partition;

/// The accuracy of coefficients by the fast transform, its best.
const EPSILON: f64 = 1e-13;

/// Whether [`exact_spectrum`] has an answer for the pattern: white noise, strata of equal area, and
/// whatever is not random.
#[must_use]
pub fn has_exact_spectrum(pattern: &Pattern) -> bool {
    matches!(
        pattern,
        Pattern::WhiteNoise
            | Pattern::Jittered
            | Pattern::EqualArea { .. }
            | Pattern::Healpix
            | Pattern::Fibonacci
            | Pattern::Spiral
    )
}

/// The names of the patterns with an exact spectrum.
pub(crate) fn patterns_in_words() -> String {
    let names: Vec<_> =
        Pattern::ALL.iter().filter(|p| has_exact_spectrum(p)).map(Pattern::name).collect();
    names.join(", ")
}

/// The mean power per degree of a pattern, to `lmax`, without sampling: no realizations, standard
/// errors of 0.
///
/// - White noise has 1 for every `l >= 1`.
/// - A pattern that is not random has the power of its one set, transformed to `1e-13 N`.
/// - One uniform point in each of N strata `W_k` of equal area, independent of the others, has
///
/// ```text
/// P(l) = 1 - (1/N) sum_k E P_l(x.y),   x and y independent and uniform in W_k,   l >= 1
/// ```
///
/// on the hemisphere, for even l, with the N strata of the hemisphere. The mean is taken by
/// Gauss-Legendre quadrature in equal-area coordinates, over one of all congruent strata. While strata are
/// small against `1/l` it goes by the distances of pairs of nodes, otherwise by the transforms of the
/// nodes, whichever is expected to take less time; degrees to sqrt(N), where the power is small, always go
/// by distances, which keep relative accuracy: about 1e-12, as far as tested (1e-12 absolute
/// beyond sqrt(N)).
///
/// `done` is called with a number of seconds, roughly, after each piece of work;
/// [`exact_spectrum_cost`] is their sum. The bits do not depend on the number of threads.
///
/// ```
/// use sphvar_samplers::{Domain, Pattern};
/// use sphvar_spectrum::exact_spectrum;
///
/// let spectrum = exact_spectrum(&Pattern::Jittered, 3072, Domain::Sphere, 8, &|_| ())?;
/// assert!(spectrum.is_exact() && spectrum.realizations() == 0);
/// // c_N l(l+1)/N with c_N = 1.1168.
/// assert!((spectrum.power()[1] * 3072.0 / 2.0 - 1.1168).abs() < 1e-4);
/// # Ok::<(), sphvar_spectrum::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::NoExactSpectrum`] unless [`has_exact_spectrum`], [`Error::Sampler`] if the pattern does not
/// exist with `n_points`, [`Error::Transform`] if `lmax` is out of range.
pub fn exact_spectrum(
    pattern: &Pattern,
    n_points: usize,
    domain: Domain,
    lmax: usize,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Spectrum, Error> {
    // The one check of the degree for all ways.
    LmIndex::new(lmax)?;
    // Random points coincide with probability 0.
    let mut tail = ByParity::both(1.0);
    let power = match Kind::of(pattern, n_points, domain)? {
        Kind::White => vec![1.0; lmax + 1],
        Kind::Fixed(sampler) => {
            let points =
                sampler.sample(&mut Streams::new(0, Purpose::Pattern, 0).realization(0))?;
            tail = tail_power(&points, &[]);
            let power = power_of_one_set(&points, lmax)?;
            done(fixed_cost(n_points, lmax));
            power
        }
        Kind::Stratified(partition) => strata::power(&partition, lmax, done)?,
    };
    Ok(Spectrum::exact(domain, n_points, power).with_tail(tail))
}

/// The seconds that [`exact_spectrum`] reports in all: what it is expected to take on one core of a
/// 2.6 GHz machine. 0 where it ends with an error.
#[must_use]
pub fn exact_spectrum_cost(pattern: &Pattern, n_points: usize, domain: Domain, lmax: usize) -> f64 {
    match Kind::of(pattern, n_points, domain) {
        Err(_) | Ok(Kind::White) => 0.0,
        Ok(Kind::Fixed(_)) => fixed_cost(n_points, lmax),
        Ok(Kind::Stratified(partition)) => strata::cost(&partition, lmax),
    }
}

/// The bytes that [`exact_spectrum`] takes on `threads` threads: an estimate from below that misses no
/// large part. 0 where it ends with an error.
#[must_use]
pub fn exact_spectrum_bytes(
    pattern: &Pattern,
    n_points: usize,
    domain: Domain,
    lmax: usize,
    threads: usize,
) -> f64 {
    let spectrum = 16.0 * (lmax as f64 + 1.0);
    match Kind::of(pattern, n_points, domain) {
        Err(_) => 0.0,
        Ok(Kind::White) => spectrum,
        Ok(Kind::Fixed(_)) => spectrum + Method::Auto.bytes(n_points, lmax, 1),
        Ok(Kind::Stratified(partition)) => spectrum + strata::bytes(&partition, lmax, threads),
    }
}

/// Why a pattern has an exact spectrum.
enum Kind {
    White,
    Fixed(Box<dyn Sampler>),
    Stratified(Partition),
}

impl Kind {
    fn of(pattern: &Pattern, n_points: usize, domain: Domain) -> Result<Self, Error> {
        if !has_exact_spectrum(pattern) {
            return Err(Error::NoExactSpectrum { pattern: pattern.clone() });
        }
        // Building is cheap for these, and checks the number of points.
        let sampler = pattern.build(n_points, domain)?;
        if !sampler.is_random() {
            return Ok(Self::Fixed(sampler));
        }
        if *pattern == Pattern::WhiteNoise {
            return Ok(Self::White);
        }
        let unknown = || Error::NoExactSpectrum { pattern: pattern.clone() };
        Partition::of(pattern, n_points, domain)?.map(Self::Stratified).ok_or_else(unknown)
    }
}

/// The power of a pattern that is not random. Rotations would not change it.
fn power_of_one_set(points: &[DVec3], lmax: usize) -> Result<Vec<f64>, Error> {
    let transform = Transform::new(Method::Auto, lmax, points.len(), EPSILON)?;
    let mut alm = [Alm::zeros(lmax)?];
    transform.adjoint_batch_into(&[(points, None)], &mut TransformWorkspace::default(), &mut alm);
    let factor = 4.0 * PI / points.len() as f64;
    Ok(alm[0].power_per_degree().into_iter().map(|p| factor * p).collect())
}

fn fixed_cost(n_points: usize, lmax: usize) -> f64 {
    Method::Auto.seconds(n_points, lmax)
}
