//! Filters against the convolution by its definition.

use std::f64::consts::{LN_2, PI, TAU};

use glam::DVec3;
use sphvar_integrands::{Domain, Expression, GaussianFilter, Integrand, NoFiles};
use sphvar_sh::legendre_p_into;

fn built(text: &str) -> Box<dyn Integrand> {
    text.parse::<Expression>().unwrap().build(&NoFiles).unwrap()
}

fn error(text: &str) -> String {
    let parsed = text.parse::<Expression>();
    match parsed.and_then(|expression| expression.build(&NoFiles)) {
        Ok(_) => panic!("{text} is accepted"),
        Err(error) => error.to_string(),
    }
}

/// Returns a spherical Fibonacci lattice.
fn lattice(n: u32) -> impl Iterator<Item = DVec3> {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    (0..n).map(move |j| {
        let z = 1.0 - (2.0 * f64::from(j) + 1.0) / f64::from(n);
        let (sin, cos) = (TAU * (f64::from(j) * golden).fract()).sin_cos();
        let radius = ((1.0 - z) * (1.0 + z)).sqrt();
        DVec3::new(radius * cos, radius * sin, z)
    })
}

const PLACES: [DVec3; 4] =
    [DVec3::Z, DVec3::new(0.0, 0.6, 0.8), DVec3::new(-0.48, 0.64, -0.6), DVec3::NEG_Z];

/// The convolution `int K(x . y) f(y) dy` as a sum over a lattice, K being the sum of Legendre
/// polynomials; the error is that of the lattice, for functions with jumps some N^-3/4 of the peak of K, at most 7.
#[test]
fn values_are_convolutions() {
    const POINTS: u32 = 40_000;
    for (fwhm, of, tolerance) in [
        (20.0, "cap:degrees=50", 3e-3),
        (20.0, "cap:degrees=50 @ 70/20 + 0.5 * cap:degrees=20", 3e-3),
        (40.0, "vmf:kappa=20 @ 30/40 * ylm:l=3,m=2", 1e-6),
        (180.0, "phong:n=3 @ 60/0", 1e-6),
        (30.0, "cosine * cap:degrees=60 @ 50/10", 3e-3),
    ] {
        let sigma = f64::to_radians(fwhm) / (8.0 * LN_2).sqrt();
        // The width is at least 20 degrees: factors fall below 1e-38 at degree 90.
        let mut polynomials = vec![0.0; 90];
        let factor = |l: usize| {
            let l = l as f64;
            (2.0 * l + 1.0) / (4.0 * PI) * (-0.5 * l * (l + 1.0) * sigma * sigma).exp()
        };
        let factors: Vec<f64> = (0..polynomials.len()).map(factor).collect();
        let mut kernel = |x: f64| -> f64 {
            legendre_p_into(x.clamp(-1.0, 1.0), &mut polynomials).unwrap();
            factors.iter().zip(&polynomials).map(|(factor, p)| factor * p).sum()
        };
        let f = built(of);
        let filtered = built(&format!("filtered:fwhm={fwhm},of=\"{of}\""));
        let mut batch = [0.0; PLACES.len()];
        filtered.eval_into(&PLACES, &mut batch).unwrap();
        for (place, value) in PLACES.into_iter().zip(batch) {
            let weight = 4.0 * PI / f64::from(POINTS);
            let expected: f64 =
                lattice(POINTS).map(|y| weight * kernel(place.dot(y)) * f.eval(y)).sum();
            assert!((value - expected).abs() < tolerance, "{of}, {fwhm}: {value}, {expected}");
            assert!((value - filtered.eval(place)).abs() < 1e-12, "{of}, {fwhm}: {value}");
        }
        let ratio = filtered.exact(Domain::Sphere).unwrap() / f.exact(Domain::Sphere).unwrap();
        assert!((ratio - 1.0).abs() < 1e-10 || of.contains("ylm"), "{of}: {ratio}");
    }
}

/// The full width at half maximum of the image of a narrow peak is that of the filter.
#[test]
fn a_peak_becomes_as_wide_as_the_filter() {
    let image = built("filtered:fwhm=2,of=vmf:kappa=1000000");
    let (sin, cos) = 1f64.to_radians().sin_cos();
    let half = image.eval(DVec3::new(sin, 0.0, cos)) / image.eval(DVec3::Z);
    // The variances add up: (2 degrees)^2/(8 ln 2) and 1e-6.
    let variance = (2f64.to_radians()).powi(2) / (8.0 * LN_2) + 1e-6;
    let expected = (-0.5 * 1f64.to_radians().powi(2) / variance).exp();
    assert!((half / expected - 1.0).abs() < 1e-4, "{half}, {expected}");
}

/// Energies are those of the function times the squares of the multipliers, the difference has the
/// stated root mean square, and two filters are one of the sum of the variances.
#[test]
fn energies_are_multiplied() {
    for of in ["cap:degrees=50", "cap:degrees=50 @ 70/20 + 0.5 * cap:degrees=20"] {
        let f = built(of);
        let filter = GaussianFilter::new(5.0).unwrap();
        let filtered = filter.apply(&f).unwrap();
        let g = &filtered.function;
        let before = f.energy(Domain::Sphere, 400).unwrap();
        let after = g.energy(Domain::Sphere, 400).unwrap();
        let pairs = before.per_band().iter().zip(after.per_band());
        for (l, (e, got)) in pairs.enumerate() {
            let expected = filter.multiplier(l).powi(2) * e;
            assert!((got - expected).abs() < 1e-12 * before.total(), "{of}, l = {l}: {got}");
        }
        let sum: f64 = after.per_band().iter().sum();
        assert!((sum / after.total() - 1.0).abs() < 1e-12, "{of}: {sum} of {}", after.total());
        // The mean over a lattice; the difference has jumps.
        let points: Vec<DVec3> = lattice(20_000).collect();
        let mut values = vec![0.0; points.len()];
        g.eval_into(&points, &mut values).unwrap();
        let squares = values.iter().zip(&points).map(|(v, &p)| (v - f.eval(p)).powi(2));
        let rms = (squares.sum::<f64>() / points.len() as f64).sqrt();
        assert!((rms / filtered.rms_change - 1.0).abs() < 0.02, "{of}: {rms}, {filtered:?}");
        assert!(filtered.rms_change < filtered.rms, "{of}: {filtered:?}");

        let twice = built(&format!("filtered:fwhm=4,of=\"filtered:fwhm=3,of=\\\"{of}\\\"\""));
        let twice = twice.energy(Domain::Sphere, 400).unwrap();
        for (l, (a, b)) in after.per_band().iter().zip(twice.per_band()).enumerate() {
            assert!((a - b).abs() < 1e-12 * before.total(), "{of}, l = {l}: {a}, {b}");
        }
    }
}

#[test]
fn filters_of_any_width_have_results_or_errors() {
    // Band-limited functions take any filter; narrow ones leave them unchanged.
    let narrow = built("filtered:fwhm=1e-6,of=\"ylm:l=5,m=3\"");
    let harmonic = built("ylm:l=5,m=3");
    let place = PLACES[2];
    assert!((narrow.eval(place) - harmonic.eval(place)).abs() < 1e-12);
    assert_eq!(narrow.band_limit(), Some(5));
    let square = narrow.centred_square(Domain::Sphere).unwrap();
    assert!((square.odd - 1.0).abs() < 1e-12 && square.even == 0.0, "{square:?}");
    // The widest: only the lowest degrees remain, each as e^{-l(l+1) sigma^2}.
    let wide = built("filtered:fwhm=180,of=\"ylm:l=1\"").square(Domain::Sphere).unwrap();
    let sigma = PI / (8.0 * LN_2).sqrt();
    assert!((wide / (-2.0 * sigma * sigma).exp() - 1.0).abs() < 1e-12, "{wide}");
    // A filtered constant is itself, without a change.
    let constant = GaussianFilter::new(1.0).unwrap().apply(&built("cap:degrees=180")).unwrap();
    assert!(constant.rms_change < 1e-12, "{constant:?}");

    for text in [
        "filtered:fwhm=1e-6,of=cap:degrees=60",
        "filtered:fwhm=1e-300,of=cosine",
        "filtered:fwhm=0.1,of=\"cosine @ 3/4 + cosine\"",
    ] {
        let message = error(text);
        assert!(message.contains("at least 0.29 degrees"), "{message}");
    }
    assert!(error("filtered:fwhm=0,of=cosine").contains("in (0, 180]"));
    assert!(error("filtered:fwhm=181,of=cosine").contains("in (0, 180]"));
    assert!(error("filtered:fwhm=5").contains("of is missing"));
    assert!(error("filtered:fwhm=5,of=cosin").contains("of: unknown integrand \"cosin\""));
    let unknown = GaussianFilter::new(5.0).unwrap().apply(&|d: DVec3| d.x).unwrap_err();
    assert!(unknown.to_string().contains("only its values"), "{unknown}");
}

/// The filtered factors of an expression are replaced, at any depth and with their rotations.
#[test]
fn expressions_without_filters_are_their_functions() {
    let text =
        "2 * filtered:fwhm=5,of=\"cosine + filtered:fwhm=9,of=vmf:kappa=3\" @ 30/40 * cosine";
    let expression: Expression = text.parse().unwrap();
    assert_eq!(expression.terms().count(), 5);
    let unfiltered = expression.build_unfiltered(&NoFiles).unwrap().unwrap();
    let expected =
        [built("2 * cosine @ 30/40 * cosine"), built("2 * vmf:kappa=3 @ 30/40 * cosine")];
    for place in PLACES {
        let sum: f64 = expected.iter().map(|f| f.eval(place)).sum();
        assert!((unfiltered.eval(place) - sum).abs() < 1e-14);
    }
    let plain: Expression = "cosine".parse().unwrap();
    assert!(plain.build_unfiltered(&NoFiles).unwrap().is_none());
}
