//! Energies of integrands and predicted variances.

mod energies;
mod hard;
mod lobe_pairs;
mod prefixes;
mod subjects;

use glam::DVec3;
use sphvar_integrands::{Cap, VonMisesFisher};
use sphvar_samplers::{Domain, Pattern, Purpose, Streams};
use sphvar_sht::{Method, Transform};
use sphvar_spectrum::Resolution;

pub(crate) use hard::hard_cases;

use crate::{Area, Effort, Subject, Trial};
use prefixes::OfPrefixes;
use subjects::{CapEnergies, LobeEnergies, OfHarmonic, OfLobe, White};

/// Returns the trials of this area.
///
/// - Energies are squares of coefficients. Those of a cap are accurate to `4 EPSILON (l + 1)` of
///   the local amplitude; those of a lobe are products of l ratios, each accurate to one or two
///   roundings.
/// - The variance of white noise is a sum of lmax terms, whose rounding errors partly cancel, and a
///   remainder; together they are the closed form.
/// - The variance of a harmonic or a lobe is a mean of squares of coefficients. If these have
///   errors relative to those of white noise, the error of the variance is twice that fraction of
///   the geometric mean of the variance and white noise's variance; see [`of_amplitudes`].
/// - The variances of all prefixes of a set are sums of squares of low coefficients, and sums over
///   pairs where an integrand has higher degrees; see [`OF_PREFIXES`].
pub(crate) fn trials(effort: Effort) -> Vec<Trial> {
    let (lmax, n) = match effort {
        Effort::Quick => (1000, 192),
        Effort::Full => (20_000, 432),
    };
    let cap = |degrees| Cap::from_degrees(degrees).expect("an angle in range");
    let lobe = |kappa| VonMisesFisher::new(kappa).expect("a concentration in range");
    let mut trials = Vec::new();
    for degrees in [1.0, 60.0, 179.0] {
        let case = format!("cap of {degrees} degrees, lmax = {lmax}");
        let subject = Box::new(CapEnergies::new(cap(degrees), degrees, lmax));
        trials.push(Trial {
            unit: "degrees",
            count: lmax as f64 + 1.0,
            relative_to: "(l + 1) times the larger energy of two degrees",
            ..trial("energies", case, 8.0 * f64::EPSILON, RECURRENCE, subject)
        });
    }
    // Up to the degree where energies are about 1e-16 of the largest.
    for (kappa, lmax) in [(1.0, 20_u32), (100.0, 80), (1e4, 500)] {
        let case = format!("von Mises-Fisher lobe, kappa = {kappa:e}, lmax = {lmax}");
        let subject = Box::new(LobeEnergies::new(lobe(kappa), kappa, lmax as usize));
        trials.push(Trial {
            unit: "degrees",
            count: f64::from(lmax) + 1.0,
            relative_to: "(l + 1) times the energy",
            ..trial("energies", case, 8.0 * f64::EPSILON, RECURRENCE, subject)
        });
    }
    for lmax in [4_u32, 64, 1000] {
        let case = format!("white noise, cap of 60 degrees, lmax = {lmax}");
        let subject = Box::new(White::new(cap(60.0), 1000, lmax as usize));
        let bound = f64::EPSILON * (2.0 + f64::from(lmax).sqrt());
        trials.push(trial("white noise", case, bound, "3 pi^2/N", subject));
    }
    for pattern in [Pattern::WhiteNoise, Pattern::FIBONACCI, Pattern::Healpix] {
        let method = if pattern == Pattern::WhiteNoise { "white noise" } else { "lattice" };
        let case = format!("{n} {}, Y_40", pattern.name());
        let subject = Box::new(OfHarmonic::new(pattern, n));
        trials.push(Trial {
            relative_to: OF_BOTH,
            ..trial(method, case, of_amplitudes(n, 4), "Legendre polynomials of all pairs", subject)
        });
    }
    for kappa in [1.0, 10.0, 100.0] {
        for (method, pattern) in [
            ("lattice", Pattern::FIBONACCI),
            ("lattice", Pattern::Healpix),
            ("realizations", Pattern::Jittered),
            ("realizations", Pattern::WhiteNoise),
        ] {
            let subject = Box::new(OfLobe::new(&pattern, n, kappa));
            let case = format!("{n} {}, lobe of kappa = {kappa}", pattern.name());
            let bound = of_amplitudes(n, subject.degree());
            trials.push(Trial {
                relative_to: OF_BOTH,
                ..trial(method, case, bound, "closed form for all pairs", subject)
            });
        }
    }
    for kappa in [1.0, 10.0, 100.0] {
        let subject = Box::new(OfPrefixes::new(lattice(n), kappa, vec![1, 2, 10, n / 2, n]));
        let case = format!("all prefixes of {n} fibonacci, lobe of kappa = {kappa}");
        trials.push(Trial {
            count: n as f64,
            relative_to: OF_BOTH,
            ..trial("prefixes", case, OF_PREFIXES, "closed form for all pairs", subject)
        });
    }
    trials
}

/// Returns points of a lattice.
fn lattice(n: usize) -> Vec<DVec3> {
    let sampler = Pattern::FIBONACCI.build(n, Domain::Sphere).expect("every count is valid");
    let mut rng = Streams::new(0, Purpose::Pattern, n).realization(0);
    sampler.sample(&mut rng).expect("a lattice is feasible").points
}

/// Returns twice the error of low coefficients: 24 EPSILON for the exact transform, where the
/// points of a parallel have common roundings, and 64 EPSILON for the fast one, from the roundings
/// of windows and grid.
fn of_amplitudes(n: usize, lmax: usize) -> f64 {
    let transform = Transform::new(Method::Auto, lmax, n, Resolution::EPSILON);
    let amplitude = if transform.is_ok_and(|t| t.is_fast()) { 64.0 } else { 24.0 };
    2.0 * amplitude * f64::EPSILON
}

/// Coefficients have a few roundings for each of up to 64 degrees of the recurrence, of which the
/// variance has twice the error.
const OF_PREFIXES: f64 = 512.0 * f64::EPSILON;

const OF_BOTH: &str = "the geometric mean of the variance and that of white noise";
const RECURRENCE: &str = "recurrences and series in twice the precision";

fn trial(
    method: &str,
    case: String,
    bound: f64,
    reference: &'static str,
    subject: Box<dyn Subject>,
) -> Trial {
    Trial {
        area: Area::Predictions,
        method: method.to_owned(),
        case,
        count: 1.0,
        unit: "predictions",
        relative_to: "the variance",
        bound,
        reference,
        subject,
    }
}
