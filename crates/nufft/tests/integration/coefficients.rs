//! Coefficients by frequency.

use num_complex::Complex;
use sphvar_nufft::{ComplexTorusCoefficients, Error, MAX_KMAX, TorusCoefficients};

#[test]
fn negative_frequencies_are_conjugates() {
    let mut c = TorusCoefficients::zeros(2).unwrap();
    for (k, value) in c.values_mut().iter_mut().enumerate() {
        *value = Complex::new(k as f64, 1.0);
    }
    assert_eq!(c.get(-2, 0), Some(Complex::new(0.0, 1.0)));
    assert_eq!(c.get(1, 2), Some(Complex::new(11.0, 1.0)));
    assert_eq!(c.get(-1, -2), Some(Complex::new(11.0, -1.0)));
    for beyond in [3, -3, i32::MAX, i32::MIN] {
        assert_eq!((c.get(beyond, 0), c.get(0, beyond)), (None, None));
    }
    for kmax in [MAX_KMAX + 1, usize::MAX] {
        let expected = Error::FrequencyTooLarge { kmax, max: MAX_KMAX };
        assert_eq!(TorusCoefficients::<f64>::zeros(kmax), Err(expected));
        assert_eq!(ComplexTorusCoefficients::<f32>::zeros(kmax), Err(expected));
    }
}

#[test]
fn complex_coefficients_have_two_signs() {
    let mut c = ComplexTorusCoefficients::zeros(2).unwrap();
    for (k, value) in c.values_mut().iter_mut().enumerate() {
        *value = Complex::new(k as f64, 1.0);
    }
    assert_eq!(c.get(-2, -2), Some(Complex::new(0.0, 1.0)));
    assert_eq!(c.get(-1, 2), Some(Complex::new(9.0, 1.0)));
    assert_eq!(c.get(2, 2), Some(Complex::new(24.0, 1.0)));
    for beyond in [3, -3, i32::MAX, i32::MIN] {
        assert_eq!((c.get(beyond, 0), c.get(0, beyond)), (None, None));
    }
}
