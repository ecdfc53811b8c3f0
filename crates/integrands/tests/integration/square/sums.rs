//! Constants, repeated terms and large means.

use sphvar_integrands::{
    AdaptiveSquareFunction, Disk, Error, NoFiles, SquareExpression, SquareIntegrand, SquareSum,
    Tolerance, Wave,
};
use sphvar_sh::{Frequencies, TailClasses};

use super::cases::energies;

fn of(text: &str) -> Box<dyn SquareIntegrand> {
    text.parse::<SquareExpression>().unwrap().build(&NoFiles).unwrap()
}

/// A constant changes the integral and the energy of band 0, and nothing else at all.
#[test]
fn constants_change_the_mean_alone() {
    let functions = [
        "disk:radius=0.25",
        "half-plane:angle=30",
        "exponential:a=3,b=-1",
        "2 * wave:k1=3,k2=-1",
        "disk:radius=0.3 * gaussian:width=0.2",
        "half-plane:angle=10 + disk:radius=0.1",
    ];
    let constants = [
        ("1e12 +", 1e12),
        ("-1 * exponential:a=0,b=0 +", -1.0),
        ("1e100 * wave:k1=0,k2=0 +", 1e100),
        ("half-plane:angle=5,offset=-1 - 3 * half-plane:angle=7,offset=1 +", 1.0),
        ("1e16 - 1e16 +", 0.0),
    ];
    for text in functions {
        let plain = of(text);
        let expected = energies(&plain, 6, 40);
        let (without, stated) = plain.integral_estimate().unwrap();
        let (kurtosis, variation) = (plain.kurtosis(), plain.variation());
        for (constant, value) in constants {
            let sum = of(&format!("{constant} {text}"));
            let energy = energies(&sum, 6, 40);
            assert_eq!(energy.per_band()[1..], expected.per_band()[1..], "{constant} {text}");
            assert_eq!(energy.centred(), expected.centred(), "{constant} {text}");
            assert_eq!(energy.centred_stderr(), expected.centred_stderr(), "{constant} {text}");
            assert_eq!(energy.errors().is_none(), expected.errors().is_none());
            let (integral, error) = sum.integral_estimate().unwrap();
            assert_eq!((integral, error), (value + without, stated), "{constant} {text}");
            assert_eq!(sum.exact(), plain.exact().map(|exact| value + exact));
            let of_mean = energy.per_band()[0] - integral * integral;
            assert!(of_mean.abs() <= 1e-15 * integral * integral, "{constant} {text}");
            if let Some(errors) = energy.per_band_stderr() {
                let of_mean = (integral.abs() + stated).powi(2) - integral * integral;
                assert!((errors[0] - of_mean).abs() <= 1e-9 * of_mean + 1e-15 * integral.powi(2));
            }
            assert_eq!(sum.kurtosis(), kurtosis);
            assert_eq!(sum.variation(), variation);
            assert_eq!(sum.band_limit(), plain.band_limit());
            assert_eq!(sum.feature_size(), plain.feature_size());
        }
    }
}

/// Terms with the same factors, in any order, are one.
#[test]
fn repeated_terms_are_merged() {
    for (text, single) in [
        ("disk:radius=0.2 + disk:radius=0.2", "2 * disk:radius=0.2"),
        ("2 * half-plane:angle=3 - 1 + 0.5 * half-plane:angle=3", "2.5 * half-plane:angle=3"),
        ("1 * wave:k1=0,k2=0 + disk:radius=0.1", "disk:radius=0.1"),
        (
            "zone-plate:scale=2 * disk:radius=0.4 - 3 * disk:radius=0.4 * zone-plate:scale=2",
            "-2 * disk:radius=0.4 * zone-plate:scale=2",
        ),
        ("disk:radius=0.1 + gaussian:width=0.1 - disk:radius=0.1", "gaussian:width=0.1"),
    ] {
        let (sum, expected) = (energies(&of(text), 5, 5), energies(&of(single), 5, 5));
        assert_eq!(sum.per_band()[1..], expected.per_band()[1..], "{text}");
        assert_eq!(
            (sum.centred(), sum.centred_stderr()),
            (expected.centred(), expected.centred_stderr())
        );
    }
    // Terms that cancel, factors of 0 and numbers leave a constant.
    for (text, value) in [
        ("disk:radius=0.3 - disk:radius=0.3 + 4", 4.0),
        ("0 * disk:radius=0.3", 0.0),
        ("7 * half-plane:angle=0,offset=1 * disk:radius=0.3 - 2", -2.0),
        ("-1e6", -1e6),
    ] {
        let constant = of(text);
        let energy = energies(&constant, 4, 4);
        assert_eq!((energy.total(), energy.centred().sum()), (value * value, 0.0), "{text}");
        assert_eq!((constant.exact(), constant.band_limit()), (Some(value), Some(0)), "{text}");
        assert_eq!((constant.kurtosis(), constant.variation()), (None, Some(0.0)), "{text}");
    }
    let limits = of("wave:k1=3,k2=4 * wave:k1=0,k2=1 - wave:k1=2,k2=0 + 5").band_limit();
    assert_eq!(limits, Some(6));
    let large = |weight| {
        let constant =
            AdaptiveSquareFunction::new(Wave::new([1, 0]).unwrap(), Tolerance::default());
        SquareSum::default().plus(weight, vec![Box::new(constant.unwrap())]).map(|_| ())
    };
    assert!(matches!(large(1e151), Err(Error::Weight { .. })) && large(1e149).is_ok());
}

/// Values far from 0 are rounded; energies of their deviations, of which no digit is lost otherwise,
/// have errors that contain that.
#[test]
fn large_means_have_honest_errors() {
    let disk = Disk::new(0.23, [0.4, 0.5]).unwrap();
    let wave = Wave::new([3, -2]).unwrap();
    let frequencies = Frequencies::new(10).unwrap();
    for (name, function, known) in
        [("disk", &disk as &dyn SquareIntegrand, 1e-2), ("wave", &wave, 0.0)]
    {
        let exact = function.energy(&frequencies).unwrap();
        for offset in [0.0, 1e3, 1e6, -1e9, 1e12, -1e14, 1e15, 4e15] {
            let shifted = |point: [f64; 2]| offset + function.eval(point);
            let tolerance = Tolerance { max_evaluations: 150_000, ..Tolerance::default() };
            let found = AdaptiveSquareFunction::new(shifted, tolerance).unwrap();
            let energy = found.energy(&frequencies).unwrap();
            let total = exact.centred().sum();
            // Errors of quadrature, and 16 units of rounding.
            let rounding = 16.0 * f64::EPSILON * offset.abs();
            let expected = known * total + 4.0 * rounding * (total.sqrt() + rounding);
            let (of_total, error) = (energy.centred().sum(), energy.centred_stderr().sum());
            let deviation = (of_total - total).abs();
            let message = format!("{name} + {offset:e}: {deviation:e} of {error:e}");
            assert!(error <= expected, "{message}, {expected:e}");
            assert!(deviation <= 2.0 * error + 1e-13 * total, "{message}");
            let stated = energy.per_band_stderr();
            for (band, (a, b)) in energy.per_band().iter().zip(exact.per_band()).enumerate().skip(1)
            {
                let stated = stated.map_or(0.0, |errors| errors[band]);
                assert!((a - b).abs() <= 4.0 * stated + 1e-12 * total, "{message}, band {band}");
            }
            let (integral, error) = found.integral_estimate().unwrap();
            let deviation = (integral - offset - function.exact().unwrap()).abs();
            assert!(deviation <= 4.0 * error + 1e-13, "{message}: {deviation:e}, {error:e}");
        }
    }
    // A constant has no deviations, however large it is.
    for constant in [1.0 / 3.0, -1e9 / 7.0, 1e100] {
        let flat = AdaptiveSquareFunction::new(|_: [f64; 2]| constant, Tolerance::default());
        let flat = flat.unwrap();
        let energy = flat.energy(&frequencies).unwrap();
        assert_eq!((energy.centred().sum(), energy.errors()), (0.0, None));
        assert_eq!((flat.exact(), flat.kurtosis()), (Some(constant), None));
    }
}
