//! Invalid input.

use num_complex::Complex;
use sphvar_nufft::{
    ComplexTorusCoefficients, Error, MAX_KMAX, TorusCoefficients, TorusTransform, TorusWorkspace,
    direct_adjoint, direct_adjoint_complex, direct_evaluate, direct_evaluate_complex,
    direct_gradient,
};

#[test]
fn invalid_input_is_an_error() {
    for epsilon in [0.0, -1e-3, 0.99e-13, 0.1001, 1.0, f64::INFINITY, f64::NAN] {
        let error = TorusTransform::new(4, epsilon).unwrap_err();
        assert!(matches!(error, Error::Accuracy { .. }), "{epsilon}: {error}");
    }
    for kmax in [MAX_KMAX + 1, usize::MAX] {
        let expected = Error::FrequencyTooLarge { kmax, max: MAX_KMAX };
        assert_eq!(TorusTransform::new(kmax, 1e-3).unwrap_err(), expected);
        assert_eq!(direct_adjoint(kmax, &[], None).unwrap_err(), expected);
    }
    let plan = TorusTransform::new(4, 1e-3).unwrap();
    let both = |points: &[[f64; 2]], weights: Option<&[f64]>| {
        let errors = [plan.adjoint(points, weights), direct_adjoint(4, points, weights)]
            .map(Result::unwrap_err);
        assert_eq!(errors[0].to_string(), errors[1].to_string());
        errors[0]
    };
    for bad in [1.0, -1e-300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for point in [[bad, 0.0], [0.0, bad]] {
            let error = both(&[[0.0, 0.0], point], None);
            assert!(matches!(error, Error::Point { index: 1, .. }), "{bad}: {error}");
        }
    }
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = both(&[[0.0, 0.0]; 3], Some(&[1.0, 2.0, bad]));
        assert!(matches!(error, Error::Weight { index: 2, .. }), "{bad}: {error}");
    }
    let two = [[0.0, 0.0]; 2];
    assert_eq!(both(&two, Some(&[1.0])), Error::WeightCount { weights: 1, points: 2 });
    assert_eq!(both(&[], Some(&[1.0])), Error::WeightCount { weights: 1, points: 0 });
    assert_eq!(both(&two, Some(&[f64::MAX, -1e300])), Error::Overflow);

    let mut out = direct_adjoint(5, &two, None).unwrap();
    let before = out.clone();
    let error = plan.adjoint_into(&two, None, &mut TorusWorkspace::default(), &mut out);
    assert_eq!(error, Err(Error::KmaxMismatch { expected: 4, got: 5 }));
    assert_eq!(out, before);
}

#[test]
fn invalid_complex_input_is_an_error() {
    let plan = TorusTransform::new(4, 1e-3).unwrap();
    let both = |points: &[[f64; 2]], weights: &[Complex<f64>]| {
        let fast = plan.adjoint_complex(points, weights).unwrap_err();
        let slow = direct_adjoint_complex(4, points, weights).unwrap_err();
        assert_eq!(fast.to_string(), slow.to_string());
        fast
    };
    let one = Complex::new(1.0, 0.0);
    assert!(matches!(both(&[[1.0, 0.0]], &[one]), Error::Point { index: 0, .. }));
    assert_eq!(both(&[[0.0; 2]], &[]), Error::WeightCount { weights: 0, points: 1 });
    for bad in [f64::NAN, f64::INFINITY] {
        for weight in [Complex::new(bad, 0.0), Complex::new(0.0, bad)] {
            let error = both(&[[0.0; 2]; 2], &[one, weight]);
            assert!(matches!(error, Error::Weight { index: 1, .. }), "{error}");
        }
    }
    assert_eq!(both(&[[0.0; 2]], &[Complex::new(f64::MAX, 1e300)]), Error::Overflow);

    let mut workspace = TorusWorkspace::default();
    let mut out = ComplexTorusCoefficients::zeros(5).unwrap();
    let error = plan.adjoint_complex_into(&[[0.0; 2]], &[one], &mut workspace, &mut out);
    assert_eq!(error, Err(Error::KmaxMismatch { expected: 4, got: 5 }));
    let mut outs = [TorusCoefficients::zeros(4).unwrap()];
    let error = plan.adjoint_batch_into(&[[0.0; 2]], &[], &mut workspace, &mut outs);
    assert_eq!(error, Err(Error::BatchSize { inputs: 0, outputs: 1 }));
}

#[test]
fn invalid_coefficients_are_an_error() {
    let plan = TorusTransform::new(2, 1e-3).unwrap();
    let points = [[0.0; 2], [0.5, 0.1]];
    let mut c = TorusCoefficients::zeros(2).unwrap();
    c.values_mut()[7] = Complex::new(0.0, f64::NAN);
    for error in [
        plan.evaluate(&c, &points).unwrap_err(),
        plan.gradient(&c, &points).unwrap_err(),
        direct_evaluate(&c, &points).unwrap_err(),
        direct_gradient(&c, &points).unwrap_err(),
    ] {
        assert!(matches!(error, Error::Coefficient { index: 7, .. }), "{error}");
    }
    // c and its conjugate overflow together, and a derivative sooner.
    c.values_mut()[7] = Complex::new(1e308, 0.0);
    assert_eq!(plan.evaluate(&c, &points), Err(Error::Overflow));
    assert_eq!(direct_evaluate(&c, &points), Err(Error::Overflow));
    c.values_mut()[7] = Complex::new(1e307, 0.0);
    assert!(plan.evaluate(&c, &points).is_ok() && direct_evaluate(&c, &points).is_ok());
    assert_eq!(plan.gradient(&c, &points), Err(Error::Overflow));
    assert_eq!(direct_gradient(&c, &points), Err(Error::Overflow));

    let mut workspace = TorusWorkspace::default();
    let c = TorusCoefficients::zeros(2).unwrap();
    let mut values = [7.0; 3];
    let error = plan.evaluate_into(&c, &points, &mut workspace, &mut values);
    assert_eq!(error, Err(Error::ValueCount { expected: 2, got: 3 }));
    assert_eq!(values.map(f64::to_bits), [7.0; 3].map(f64::to_bits));
    let error = plan.gradient_into(&c, &points, &mut workspace, &mut []);
    assert_eq!(error, Err(Error::ValueCount { expected: 2, got: 0 }));
    for bad in [1.0, -1e-9, f64::NAN] {
        let error = plan.evaluate(&c, &[[0.0, bad]]).unwrap_err();
        assert!(matches!(error, Error::Point { index: 0, .. }), "{error}");
    }
    let other = TorusCoefficients::zeros(3).unwrap();
    let expected = Error::KmaxMismatch { expected: 2, got: 3 };
    assert_eq!(plan.evaluate(&other, &points), Err(expected));
    let other = ComplexTorusCoefficients::zeros(3).unwrap();
    assert_eq!(plan.evaluate_complex(&other, &points), Err(expected));
    let mut other = ComplexTorusCoefficients::zeros(2).unwrap();
    other.values_mut()[24] = Complex::new(f64::INFINITY, 0.0);
    let expected = Error::Coefficient { index: 24, value: f64::INFINITY };
    assert_eq!(plan.evaluate_complex(&other, &points), Err(expected));
    assert_eq!(direct_evaluate_complex(&other, &points), Err(expected));
}
