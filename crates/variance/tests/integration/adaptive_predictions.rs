//! Predictions from energies that are estimated from values, against those from closed forms.

use glam::DVec3;
use sphvar_integrands::{
    AbsCosine, AdaptiveFunction, Cap, ClampedCosine, Energy, Integrand, PhongLobe, Tolerance,
    VonMisesFisher,
};
use sphvar_samplers::{Domain, Purpose, Streams, uniform_rotation};
use sphvar_spectrum::Spectrum;
use sphvar_variance::{Prediction, predict};

const SEED: u64 = 5;
/// The degree of the energies and spectra of the reference.
const WHOLE: usize = 4000;

/// Ten functions, two each of smooth ones, peaks, kinks, jumps and small supports.
fn functions() -> Vec<(&'static str, Box<dyn Integrand>)> {
    let cap = |degrees| Box::new(Cap::from_degrees(degrees).unwrap());
    let lobe = |kappa| Box::new(VonMisesFisher::new(kappa).unwrap());
    vec![
        ("lobe 5", lobe(5.0)),
        ("phong 40", Box::new(PhongLobe::new(40.0).unwrap())),
        ("lobe 1000", lobe(1e3)),
        ("lobe 10000", lobe(1e4)),
        ("cosine", Box::new(ClampedCosine)),
        ("abs cosine", Box::new(AbsCosine)),
        ("cap 60", cap(60.0)),
        ("cap 25", cap(25.0)),
        ("cap 5", cap(5.0)),
        ("cap 4", cap(4.0)),
    ]
}

/// Spectra of patterns of N points to degree `lmax`: stratified, without low degrees, and with a
/// floor.
fn spectra(n: usize, lmax: usize) -> [Spectrum; 3] {
    let powers: [fn(f64) -> f64; 3] = [
        |omega| 1.0 - (-1.1 * omega * omega).exp(),
        |omega| f64::from(u8::from(omega > 1.0)),
        |omega| (0.05 + omega.powi(4)).min(1.0),
    ];
    powers.map(|power| {
        let at = |l: usize| power(l as f64 / (n as f64).sqrt());
        Spectrum::exact(Domain::Sphere, n, (0..=lmax).map(at).collect())
    })
}

/// Returns the errors of predictions relative to the stated ones, by function, for random
/// orientations; those beyond 1 are outside the 95 % interval.
fn relative_errors(orientations: u64) -> Vec<(&'static str, Vec<f64>)> {
    let tolerance = Tolerance { max_evaluations: 130_000, ..Tolerance::default() };
    let errors = |(name, known): (&'static str, Box<dyn Integrand>)| {
        let exact = known.energy(Domain::Sphere, WHOLE).unwrap();
        let mut errors = vec![];
        for i in 0..orientations {
            let mut rng = Streams::new(SEED, Purpose::Trial, 0).realization(i);
            let rotation = uniform_rotation(&mut rng);
            let values = |dir: DVec3| known.eval((rotation * dir).normalize());
            let f = AdaptiveFunction::new(values, Domain::Sphere, tolerance).unwrap();
            for n in [100_usize, 1000, 10_000] {
                let lmax = 4 * n.isqrt();
                let energy: Energy = f.energy(Domain::Sphere, lmax).unwrap();
                // The rounding of closed forms and quadratures, relative to white noise.
                let rounding = 1e-11 * 4.0 * std::f64::consts::PI * exact.total() / n as f64;
                for (whole, cut) in spectra(n, WHOLE).iter().zip(&spectra(n, lmax)) {
                    let truth = predict(whole, &exact).variance;
                    let got: Prediction = predict(cut, &energy);
                    let half = got.interval(0.95).1 - got.variance;
                    let off = ((got.variance - truth).abs() - rounding).max(0.0);
                    errors.push(if off > 0.0 { off / half } else { 0.0 });
                }
            }
        }
        (name, errors)
    };
    functions().into_iter().map(errors).collect()
}

/// Checks that at least 95 % of the intervals of every function contain the variance, and that they
/// are not so wide that they contain anything.
fn check(errors: &[(&str, Vec<f64>)]) {
    let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
    for (name, errors) in errors {
        let outside = errors.iter().filter(|&&e| e > 1.0).count();
        assert!(20 * outside <= errors.len(), "{name}: {outside} of {}", errors.len());
    }
    let means: Vec<f64> = errors.iter().map(|(_, errors)| mean(errors)).collect();
    assert!(mean(&means) > 0.02, "{means:?}");
}

/// The errors of a rule depend on the orientation of the function. Independent ones that fall as
/// the power 1.5 of the degree are outside the interval in 2 % of cases; the errors of tails are
/// added. The seed is fixed.
#[test]
#[ignore = "statistics"]
fn predictions_from_values_have_the_stated_coverage() {
    check(&relative_errors(40));
}

#[test]
fn predictions_from_values_contain_the_variance() {
    check(&relative_errors(2));
}
