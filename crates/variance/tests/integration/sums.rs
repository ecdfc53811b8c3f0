//! Sums of integrands: many terms, terms of very different size, and sums of any magnitude.

use glam::{DQuat, DVec3};
use sphvar_integrands::{
    Cap, ClampedCosine, Energy, Harmonic, Integrand, PhongLobe, Product, Rotated, Sum,
    VonMisesFisher,
};
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
use sphvar_sh::ByParity;
use sphvar_spectrum::{ExactSpectrum, Resolution, accumulate};
use sphvar_variance::{PredictionAccumulator, PredictionBudget, Predictor, Trials};

/// Returns a different rotation for every k.
fn rotation(k: usize) -> DQuat {
    DQuat::from_rotation_z(2.4 * k as f64) * DQuat::from_rotation_y(0.7 * (k % 5) as f64)
}

fn whole() -> Cap {
    Cap::from_degrees(180.0).unwrap()
}

fn tilted(k: usize, f: impl Integrand + 'static) -> Rotated<impl Integrand> {
    Rotated::new(f, rotation(k)).unwrap()
}

fn sum_of(terms: Vec<(f64, Box<dyn Integrand>)>) -> Sum {
    terms.into_iter().fold(Sum::default(), |sum, (w, f)| sum.plus(w, f).unwrap())
}

#[track_caller]
fn assert_close(what: &str, got: f64, expected: f64, size: f64) {
    assert!((got - expected).abs() <= 1e-12 * size, "{what}: {got:e}, not {expected:e}");
}

/// The square of a sum, computed by groups, against one quadrature of the product of the sum with
/// 1.
#[test]
fn squares_of_sums_are_those_of_one_quadrature() {
    let cap = |degrees: f64| Cap::from_degrees(degrees).unwrap();
    let sum = || {
        sum_of(vec![
            (1.0, Box::new(cap(50.0))),
            (-0.5, Box::new(tilted(1, cap(100.0)))),
            (2.0, Box::new(ClampedCosine)),
            (0.7, Box::new(tilted(2, PhongLobe::new(3.0).unwrap()))),
            (1.5, Box::new(tilted(3, Harmonic::new(4, 2).unwrap()))),
            (-2.0, Box::new(VonMisesFisher::new(5.0).unwrap())),
            (4.0, Box::new(whole())),
        ])
    };
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let got = sum().centred_square(domain).unwrap();
        let expected = Product::new(sum(), whole()).centred_square(domain).unwrap();
        assert_close("even", got.even, expected.even, expected.sum());
        assert_close("odd", got.odd, expected.odd, expected.sum());
    }
}

/// Of terms without edges all energies are known: they add up to the square, by parity.
#[test]
fn many_smooth_terms_have_the_sum_of_their_energies() {
    let mut sum = Sum::default();
    for k in 0..300 {
        let lobe = VonMisesFisher::new(1.0 + (k % 7) as f64).unwrap();
        sum = sum.plus(1.0 + (k % 3) as f64, tilted(k, lobe)).unwrap();
    }
    let energy = sum.energy(Domain::Sphere, 80).unwrap();
    let mut sums = ByParity::both(0.0);
    for (l, e) in energy.per_band().iter().enumerate().skip(1) {
        *sums.of_mut(l) += e;
    }
    let size = energy.centred().sum();
    assert_close("even", sums.even, energy.centred().even, size);
    assert_close("odd", sums.odd, energy.centred().odd, size);
    assert!(energy.beyond(80) == 0.0, "{energy:?}");
}

/// Constants of any size, and terms that cancel, do not contribute.
#[test]
fn constants_and_terms_that_cancel_leave_no_trace() {
    let half = Cap::half_space(0.0).unwrap();
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let harmonic = Harmonic::new(4, 0).unwrap();
        let sum = Sum::default().plus(1e15, whole()).unwrap().plus(1.0, harmonic).unwrap();
        let energy = sum.energy(domain, 8).unwrap();
        assert_close("Y_40", energy.beyond(0), 1.0, 1.0);
        assert!(energy.beyond(4) == 0.0, "{energy:?}");
        let nothing = Sum::default().plus(3.0, half).unwrap().plus(-3.0, half).unwrap();
        assert!(nothing.centred_square(domain).unwrap().sum() == 0.0);
    }
    // Two half spaces are odd except for their mean; an even part due to rounding counts as 0.
    let sum = Sum::default().plus(1.0, half).unwrap().plus(1.0, tilted(3, half)).unwrap();
    let energy = sum.energy(Domain::Sphere, 64).unwrap();
    assert!(energy.beyond_by_class(64).even == 0.0, "{:?}", energy.centred());
}

/// The variance of `Y_40` is `4 pi/N P(4)` whatever constant is added, even if the estimates of
/// trials are nothing but rounding; these do not contradict the prediction.
#[test]
fn constants_take_no_part_in_predictions() {
    let n = 12;
    for pattern in ["white-noise", "fibonacci"] {
        let pattern = pattern.parse::<Pattern>().unwrap();
        let sampler = pattern.build(n, Domain::Sphere).unwrap();
        let power = ExactSpectrum::of(&*sampler).unwrap().to(4, &()).unwrap().power()[4];
        let expected = 4.0 * std::f64::consts::PI / n as f64 * power;
        for constant in [0.0, 1.0, 1e8, 1e15, 1e16, 1e100] {
            let harmonic = Harmonic::new(4, 0).unwrap();
            let sum = Sum::default().plus(constant, whole()).unwrap().plus(1.0, harmonic).unwrap();
            let mut predictor =
                Predictor::new(&sum, Domain::Sphere, 0, PredictionBudget::DEFAULT).unwrap();
            let point = predictor.predict(&*sampler, &()).unwrap();
            let what = format!("{pattern} + {constant:e}");
            assert_close(&what, point.prediction.variance, expected, expected);
            let trials = Trials::new(100);
            let got = predictor.measure(point.prediction, &*sampler, trials, &()).unwrap();
            assert_close(&what, got.best_point().variance, expected, expected);
            assert!(got.z_score().abs() < 4.0, "{what}: {}", got.z_score());
            let (low, high) = got.measured_interval(0.9999).unwrap();
            assert!(low <= expected && expected <= high, "{what}: {low:e} to {high:e}");
        }
    }
}

/// Predictions scale with the square of the integrand, and so do their errors.
#[test]
fn predictions_scale_with_the_integrand() {
    let sampler = Pattern::Jittered.build(48, Domain::Sphere).unwrap();
    let sets = Realizations::rotated(&*sampler, Streams::new(5, Purpose::Pattern, 0));
    let predict = |weight: f64| {
        let sum = Sum::default().plus(weight, Cap::from_degrees(60.0).unwrap()).unwrap();
        let energy = sum.energy(Domain::Sphere, 28).unwrap();
        energy.check_magnitude().unwrap();
        let empty = PredictionAccumulator::new(&energy, 48, 28);
        accumulate(&sets, Resolution::new(28, 48), 0..10, &empty, &()).unwrap().finish()
    };
    let one = predict(1.0);
    for weight in [1e-150, 1e-80, 1e80, 1e150] {
        let got = predict(weight);
        for (what, got, one) in [
            ("variance", got.variance, one.variance),
            ("stderr", got.stderr, one.stderr),
            ("tail", got.tail, one.tail),
            ("tail error", got.tail_error, one.tail_error),
        ] {
            let ratio = got / weight / weight / one;
            assert!((ratio - 1.0).abs() < 1e-12, "{weight:e} {what}: {got:e}, {one:e}");
        }
    }
    for weight in [1e-200, 1e200, f64::NAN, f64::INFINITY] {
        let error = Sum::default().plus(weight, whole()).unwrap_err();
        assert!(
            matches!(error, sphvar_integrands::Error::Weight { .. })
                && error.to_string().contains("1e150")
        );
    }
    let tiny = Energy::new(Domain::Sphere, vec![1e-310], ByParity::both(0.0));
    assert!(tiny.check_magnitude().is_err());
}

#[test]
fn chained_rotations_equal_their_product() {
    let mut chained = Rotated::new(Harmonic::new(3, 2).unwrap(), rotation(0)).unwrap();
    let mut product = rotation(0);
    for k in 1..12_000 {
        chained = chained.then(rotation(k)).unwrap();
        product = rotation(k) * product;
    }
    let once = Rotated::new(Harmonic::new(3, 2).unwrap(), product).unwrap();
    let dir = DVec3::new(0.48, -0.6, 0.64);
    // 12000 roundings.
    assert!((chained.eval(dir) - once.eval(dir)).abs() < 1e-11);
}
