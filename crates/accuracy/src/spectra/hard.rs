use std::f64::consts::PI;

use crate::reference::DoubleDouble;
use glam::DVec3;
use sphvar_samplers::{Domain, Pattern, Purpose, SpectralControl, Streams};
use sphvar_sh::Alm;
use sphvar_sht::{Method, Transform, TransformWorkspace};
use sphvar_spectrum::Resolution;

use super::{blocks, legendre_sums, merging};
use crate::{Errors, HardCase};

/// Returns the hard cases of this area.
pub(crate) fn hard_cases() -> Vec<HardCase> {
    let power = |name, amplitude: f64, reason, measure| HardCase {
        name,
        what: "the power of degrees 1 to 8 of 100 points, about 1e-20, from a transform to degree 40; \
               absolute",
        bound: amplitude * (2.0 * POWER.sqrt() + amplitude),
        reason,
        measure,
    };
    vec![
        power(
            "power_of_1e_minus_20_at_epsilon_1e_minus_6",
            4.0 * f64::from(f32::EPSILON),
            "2 a sqrt(P) + a^2 for an error a of amplitudes, here 2 EPSILON of the f32 grid and as much of sums of \
             Legendre functions in f32: power below a^2 = 2.3e-13 is not resolved",
            || errors_of_power(Some(1e-6)),
        ),
        power(
            "power_of_1e_minus_20_at_epsilon_1e_minus_9",
            3e-13,
            "2 a sqrt(P) + a^2 for an error a of amplitudes, here 3e-4 of epsilon: the error of windows is largest at the highest \
             degrees and small at the lowest",
            || errors_of_power(Some(1e-9)),
        ),
        power(
            "power_of_1e_minus_20_at_epsilon_1e_minus_12",
            128.0 * f64::EPSILON,
            "2 a sqrt(P) + a^2 for an error a of amplitudes, here 128 EPSILON, the roundings of windows and grid",
            || errors_of_power(Some(1e-12)),
        ),
        power(
            "power_of_1e_minus_20_by_the_exact_transform",
            4.0 * f64::EPSILON,
            "2 a sqrt(P) + a^2 for an error a of amplitudes, here 4 EPSILON: the roundings of single points, which \
             partly cancel",
            || errors_of_power(None),
        ),
        HardCase {
            name: "realizations_merged_in_any_order",
            what: "mean and variance of 10^5 numbers merged in random trees, and the spectrum of 10^5 realizations; \
                   relative, and infinite if a bit depends on the order",
            bound: 1.5 * f64::EPSILON,
            reason: "the sums are exact: they are returned to one unit in the last place, and a quotient is rounded",
            measure: merging::errors,
        },
        HardCase {
            name: "catalogues_in_blocks",
            what: "coefficients to degree 24 of sets that are divided into blocks of 64 points: coincident points, one block \
                   and one point, weights of 1e-30 to 1e30; relative to the norm, and infinite if a bit depends on the \
                   order of the blocks",
            bound: Resolution::EPSILON,
            reason: "epsilon times the norm: blocks are transformed to this accuracy, and their sum has a rounding at each \
                     level of a binary tree",
            measure: blocks::errors,
        },
    ]
}

const N: usize = 100;
/// The degree at which the spectrum of this number of points has settled.
const LMAX: usize = 40;
/// The largest degree that is compared.
const LAST: usize = 8;
/// The approximate power of the set.
const POWER: f64 = 1e-20;

/// Returns a set without power up to degree 10 whose points are displaced by about 1e-11.
fn nearly_a_design() -> Vec<DVec3> {
    let design =
        SpectralControl::step(N, Domain::Sphere, None, None).expect("a step of 100 points");
    let mut rng = Streams::new(0, Purpose::Pattern, N).realization(0);
    let points =
        sphvar_samplers::Sampler::sample(&design, &mut rng).expect("the descent converges").points;
    let mut rng = Streams::new(0, Purpose::Trial, N).realization(0);
    let noise = Pattern::WhiteNoise.build(N, Domain::Sphere).expect("any number of points");
    let moves = noise.sample(&mut rng).expect("white noise is feasible").points;
    points.iter().zip(moves).map(|(p, v)| (p + MOVE * v).normalize()).collect()
}

/// The displacement of the points: the power of degree l is about `l(l+1)/3` times its square.
const MOVE: f64 = 3e-11;

fn errors_of_power(epsilon: Option<f64>) -> Errors {
    let points = nearly_a_design();
    let method = if epsilon.is_some() { Method::Fast } else { Method::Exact };
    let mut errors = Errors::default();
    let mut alm = [Alm::zeros(LMAX).expect("a low degree")];
    let transform = Transform::new(method, LMAX, N, epsilon.unwrap_or(Resolution::EPSILON))
        .expect("a low degree");
    transform.adjoint_batch_into(&[(&points, None)], &mut TransformWorkspace::default(), &mut alm);
    let got = alm[0].power_per_degree();
    let exact = legendre_sums(&points, LAST);
    // The case requires a set with this power; otherwise it would not be a hard case.
    let mean = exact[1..].iter().map(|power| power.value()).sum::<f64>() / LAST as f64;
    if !(POWER / 10.0..=POWER * 10.0).contains(&mean) {
        errors.push(f64::INFINITY, || format!("a set with a mean power of {mean:.1e}"));
    }
    for (l, (got, exact)) in got.into_iter().zip(exact).enumerate().skip(1) {
        let got = 4.0 * PI / N as f64 * got;
        let error = DoubleDouble::from(got) - exact;
        errors.push(error.value(), || {
            format!("l = {l}: measured {got:.3e}, true {:.3e}", exact.value())
        });
    }
    errors
}
