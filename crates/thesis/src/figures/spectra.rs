use sphvar_samplers::{Domain, Pattern};
use sphvar_spectrum::{ExactSpectrum, Spectrum};

use super::patterns::ThesisPattern;
use crate::{Axis, Curve, Error, Job, Mark, Setting, ThesisEnsemble};

/// The number of points of the thesis's mean spectra.
pub(crate) const N_POINTS: usize = 4096;
/// Their last degree, omega = 4.
pub(crate) const LMAX: usize = 256;

/// Returns the job of the mean spectrum of rotated sphere sets of about [`N_POINTS`] points, shown
/// in several figures.
pub(crate) fn mean_spectrum(pattern: ThesisPattern, setting: Setting) -> Job {
    Job::Spectrum {
        ensemble: ThesisEnsemble::sphere(pattern.pattern(), N_POINTS),
        domain: Domain::Sphere,
        lmax: LMAX,
        sets: realizations(pattern, setting),
    }
}

/// Returns the number of realizations for spectra of about [`N_POINTS`] points: 1000 in the thesis.
pub(crate) fn realizations(pattern: ThesisPattern, setting: Setting) -> u64 {
    match pattern {
        // A deterministic pattern needs one set.
        ThesisPattern::Healpix | ThesisPattern::Fibonacci => 1,
        ThesisPattern::CcvtRandom | ThesisPattern::CcvtFibonacci => setting.scale.pick(100, 1000),
        _ => setting.scale.pick(300, 1000),
    }
}

/// Returns the axis of frequencies of spectra.
pub(crate) fn omega_axis() -> Axis {
    Axis::linear("omega = l/sqrt(N)")
}

/// Returns the power of every degree from 1 over omega, with standard errors.
pub(crate) fn spectrum_curve(
    label: impl Into<String>,
    colour: usize,
    spectrum: &Spectrum,
) -> Curve {
    let root = (spectrum.n_points() as f64).sqrt();
    let rows = spectrum.rows().filter(|row| row.0 > 0);
    Curve::new(label, colour, Mark::Line, rows.map(|(l, p, e)| [l as f64 / root, p, e]))
}

/// Returns the mean power of some degrees, weighted by their orders 2l+1, and its standard error
/// for independent degrees.
pub(crate) fn mean_power(spectrum: &Spectrum, degrees: impl Fn(usize) -> bool) -> (f64, f64) {
    let (mut sum, mut variance, mut count) = (0.0, 0.0, 0.0);
    for (l, power, stderr) in spectrum.rows().filter(|row| degrees(row.0)) {
        let orders = (2 * l + 1) as f64;
        sum += orders * power;
        variance += (orders * stderr).powi(2);
        count += orders;
    }
    (sum / count, variance.sqrt() / count)
}

/// Returns the exact spectrum of HEALPix jitter to degree `lmax`.
pub(super) fn exact_jitter(n_points: usize, lmax: usize) -> Result<Spectrum, Error> {
    let sampler = Pattern::Jittered.build(n_points, Domain::Sphere)?;
    let exact = ExactSpectrum::of(&*sampler)
        .ok_or_else(|| Error::Missing { key: "the exact spectrum of jitter".to_owned() })?;
    Ok(exact.to(lmax, &())?)
}
