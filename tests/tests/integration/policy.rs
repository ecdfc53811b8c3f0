//! Frozen values of everything that determines results: degrees, methods, numbers of realizations
//! and stopping points.
//!
//! A change of any line changes results and requires an entry in the change log under
//! Value-breaking. Nothing here depends on time.

use std::fmt::Write;

use sphvar_integrands::{Cap, EnvironmentMap, Integrand, VonMisesFisher};
use sphvar_samplers::{Domain, Pattern};
use sphvar_sht::{Method, Transform};
use sphvar_variance::{PredictionBudget, Predictor, prediction_degree};

/// For every pattern at three sizes: the nominal work of a set, the degree of the spectrum for a
/// cap, the maximum and the actual number of realizations, and the transform.
#[test]
fn counts_and_methods_are_frozen() {
    let cap = Cap::from_degrees(60.0).unwrap();
    let mut table = String::new();
    for pattern in Pattern::ALL {
        for requested in [12, 192, 3072] {
            let n = pattern.nearest_count(requested, Domain::Sphere);
            let sampler = pattern.build(n, Domain::Sphere).unwrap();
            let lmax = prediction_degree(&*sampler, &cap);
            let max_realizations = PredictionBudget::DEFAULT.realizations(&*sampler, lmax);
            let is_fast = Transform::new(Method::Auto, lmax, n, 1e-12).unwrap().is_fast();
            let transform = if is_fast { "fast" } else { "exact" };
            let mut predictor =
                Predictor::new(&cap, Domain::Sphere, 0, PredictionBudget::DEFAULT).unwrap();
            let affordable = predictor.is_affordable(&*sampler).unwrap();
            // Large optimizations take seconds.
            let taken = if n < 1000 && sampler.nominal_work() < 2e5 {
                let point = predictor.predict(&*sampler, &()).unwrap();
                point.spectrum.realizations().to_string()
            } else {
                "-".to_owned()
            };
            let work = sampler.nominal_work();
            let beyond = if affordable { "" } else { " beyond the budget" };
            writeln!(
                table,
                "{pattern} {n}: {work:.0} {lmax} {max_realizations} {taken} {transform}{beyond}"
            )
            .unwrap();
        }
    }
    assert_eq!(table.trim(), COUNTS.trim(), "\n{table}");
}

/// The degrees to which lattices' spectra reach, which follow from the integrand's energies.
#[test]
fn degrees_are_frozen() {
    let texels = (0..128).map(|k| f64::from(k % 7)).collect();
    let map = EnvironmentMap::new(16, 8, texels).unwrap();
    let lobe = VonMisesFisher::new(50.0).unwrap();
    let cap = Cap::from_degrees(60.0).unwrap();
    let integrands: [(&str, &dyn Integrand); 3] = [("cap", &cap), ("lobe", &lobe), ("map", &map)];
    let mut table = String::new();
    for (name, integrand) in integrands {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            for n in [1, 100, 1000] {
                let sampler = Pattern::FIBONACCI.build(n, domain).unwrap();
                let mut predictor =
                    Predictor::new(integrand, domain, 0, PredictionBudget::DEFAULT).unwrap();
                let lmax = predictor.predict(&*sampler, &()).unwrap().spectrum.lmax();
                writeln!(table, "{name} {domain} {n}: {lmax}").unwrap();
            }
        }
    }
    assert_eq!(table.trim(), DEGREES.trim(), "\n{table}");
}

const COUNTS: &str = "\
white-noise 12: 12 32 9211 0 exact
white-noise 192: 192 52 3830 0 exact
white-noise 3072: 3072 220 259 - fast
jittered 12: 12 32 9211 0 exact
jittered 192: 192 52 3830 0 exact
jittered 3072: 3072 220 259 - fast
healpix 12: 12 320 154 0 exact
healpix 192: 192 520 58 0 exact
healpix 3072: 3072 2200 4 - fast
fibonacci 12: 12 320 154 0 exact
fibonacci 192: 192 520 58 0 exact
fibonacci 3072: 3072 2200 4 - fast
poisson-disk 12: 480 32 5985 64 exact
poisson-disk 192: 7680 52 835 256 exact
poisson-disk 3072: 122880 220 53 - fast
ccvt 12: 5530 32 1252 64 exact
ccvt 192: 88474 52 88 8 exact
ccvt 3072: 1415578 220 5 - fast
step 12: 9600 32 765 32 exact
step 192: 153600 52 51 8 exact
step 3072: 2457600 220 4 - fast beyond the budget
blue 12: 5400 32 1278 64 exact
blue 192: 86400 52 90 8 exact
blue 3072: 1382400 220 5 - fast
profile 12: 1560 32 3310 8 exact
profile 192: 24960 52 297 8 exact
profile 3072: 399360 220 18 - fast
equal-area 12: 12 32 9211 0 exact
equal-area 192: 192 52 3830 0 exact
equal-area 3072: 3072 220 259 - fast
spiral 12: 12 320 154 0 exact
spiral 192: 192 520 58 0 exact
spiral 3072: 3072 2200 4 - fast
best-candidate 12: 1282 32 3740 256 exact
best-candidate 192: 35717 52 212 212 exact
best-candidate 3072: 994990 220 7 - fast
leja 12: 36 320 154 0 exact
leja 192: 9216 520 55 0 exact
leja 3072: 2359296 2200 4 - fast
lloyd 12: 1920 32 2881 512 exact
lloyd 192: 30720 52 245 8 exact
lloyd 3072: 491520 220 15 - fast
dpp 12: 109 32 8287 0 exact
dpp 192: 445907 52 17 - exact
dpp 3072: 1826434843 220 4 - fast
riesz 12: 936 32 4463 8 exact
riesz 192: 239616 52 33 - exact
riesz 3072: 39936000 220 4 - fast beyond the budget
sobol 12: 12 32 9211 128 exact
sobol 192: 192 52 3830 16 exact
sobol 3072: 3072 220 259 - fast
halton 12: 12 32 9211 64 exact
halton 192: 192 52 3830 16 exact
halton 3072: 3072 220 259 - fast
hammersley 12: 12 32 9211 16 exact
hammersley 192: 192 52 3830 8 exact
hammersley 3072: 3072 220 259 - fast
r2 12: 12 32 9211 256 exact
r2 192: 192 52 3830 64 exact
r2 3072: 3072 220 259 - fast
pmj02 12: 16 32 9165 256 exact
pmj02 192: 338 52 3580 32 exact
pmj02 3072: 6631 220 232 - fast
gauss-legendre 8: 8 320 154 0 exact
gauss-legendre 200: 200 560 50 0 exact
gauss-legendre 3042: 3042 2200 4 - fast
driscoll-healy 13: 13 320 154 0 exact
driscoll-healy 183: 183 520 58 0 exact
driscoll-healy 3081: 3081 2200 4 - fast
mcewen-wiaux 11: 11 320 154 0 exact
mcewen-wiaux 211: 211 560 50 0 exact
mcewen-wiaux 3082: 3082 2200 4 - fast
lebedev 14: 14 320 154 0 exact
lebedev 194: 194 520 58 0 exact
lebedev 3074: 3074 2200 4 - fast
icosahedral 12: 12 320 154 0 exact
icosahedral 162: 162 480 68 0 exact
icosahedral 3242: 3242 2240 4 - fast
cube-sphere 6: 6 320 154 0 exact
cube-sphere 216: 216 560 50 0 exact
cube-sphere 3174: 3174 2240 4 - fast
sukharev 12: 12 320 154 0 exact
sukharev 192: 192 520 58 0 exact
sukharev 3072: 3072 2200 4 - fast
design 12: 12 320 154 0 exact
design 192: 1345750 520 5 - exact
design 3072: 105983693 2200 4 - fast beyond the budget
";
const DEGREES: &str = "\
cap sphere 1: 320
cap sphere 100: 400
cap sphere 1000: 1240
cap hemisphere 1: 320
cap hemisphere 100: 400
cap hemisphere 1000: 1240
lobe sphere 1: 32
lobe sphere 100: 40
lobe sphere 1000: 124
lobe hemisphere 1: 32
lobe hemisphere 100: 40
lobe hemisphere 1000: 124
map sphere 1: 167
map sphere 100: 206
map sphere 1000: 628
map hemisphere 1: 320
map hemisphere 100: 400
map hemisphere 1000: 1024
";
