use sphvar_integrands::{
    AdaptiveSquareFunction, Disk, Energy, Error, Exponential, Gaussian, HalfPlane, Interpolation,
    SquareImage, SquareIntegrand, Tolerance, Wave, ZonePlate,
};
use sphvar_sh::{Bands, ByAxis, Frequencies, TailClasses};

use super::cases::energies;

fn adaptive<'a>(
    f: &'a dyn SquareIntegrand,
    max_evaluations: usize,
) -> AdaptiveSquareFunction<impl SquareIntegrand + 'a> {
    let values = |point: [f64; 2]| f.eval(point);
    let tolerance = Tolerance { max_evaluations, relative: 1e-8, ..Tolerance::default() };
    AdaptiveSquareFunction::new(values, tolerance).unwrap()
}

/// Smooth functions are resolved by their values, to the last frequency and where they are not
/// periodic.
#[test]
fn smooth_functions_have_exact_energies() {
    let functions: Vec<Box<dyn SquareIntegrand>> = vec![
        Box::new(Gaussian::new(0.07, [0.3, 0.6]).unwrap()),
        Box::new(Gaussian::new(2.0, [0.3, 1.0]).unwrap()),
        Box::new(Exponential::new([1.0, -3.0]).unwrap()),
        Box::new(Exponential::new([0.0, 2.0]).unwrap()),
        Box::new(ZonePlate::new(6.0).unwrap()),
        Box::new(Wave::new([5, -3]).unwrap()),
        Box::new(Wave::new([0, 0]).unwrap()),
    ];
    for (i, f) in functions.iter().enumerate() {
        let found = adaptive(f, 1 << 22);
        assert!(found.relative_error() < 1e-10 && found.n_evaluations() < 100_000, "{i} {found:?}");
        let exact = f.exact().unwrap();
        assert!((found.exact().unwrap() - exact).abs() < 1e-14, "{i}");
        let (known, got) = (energies(f, 40, 1 << 16), energies(&found, 40, 1 << 16));
        assert!(got.errors().is_none());
        let total = known.total();
        for class in 0..3 {
            let error = (known.centred().get(class) - got.centred().get(class)).abs();
            assert!(error < 1e-13 * total, "{i}, class {class}: {error:e}");
        }
        for (band, (a, b)) in known.per_band().iter().zip(got.per_band()).enumerate() {
            let tolerance = 1e-13 * (a * total).sqrt() + 1e-27 * total;
            assert!((a - b).abs() <= tolerance, "{i}, band {band}: {a:e} and {b:e}");
        }
        let kurtosis = [found.kurtosis(), f.kurtosis()].map(|k| k.unwrap_or(1.0));
        assert!((kurtosis[0] / kurtosis[1] - 1.0).abs() < 0.03, "{i}: {kurtosis:?}");
    }
}

/// Returns the variance and its error for the power of jitter on a number of strata along a side, to
/// frequency `kmax`, and 1 beyond.
fn variance(energy: &Energy<Frequencies>, strata: f64, kmax: f64) -> (f64, f64) {
    let is_known = |band: &usize| energy.bands().radius(*band) <= kmax;
    let power: Vec<f64> = (0..energy.per_band().len())
        .take_while(is_known)
        .map(|band| {
            let of_axis = |k: i32| {
                let x = std::f64::consts::PI * f64::from(k) / strata;
                if k == 0 { 1.0 } else { (x.sin() / x).powi(2) }
            };
            let [k1, k2] = energy.bands().frequency(band);
            1.0 - of_axis(k1) * of_axis(k2)
        })
        .collect();
    let known: f64 = energy.per_band().iter().zip(&power).skip(1).map(|(e, p)| e * p).sum();
    let last = power.len() - 1;
    let sum = known + energy.beyond_by_class(last).sum();
    let error = energy.errors().map_or(0.0, |errors| errors.of_sum(&power, ByAxis::all(1.0)));
    (sum, error)
}

/// Functions with jumps and kinks have errors that contain the variances of white and jittered
/// patterns: the larger of two differences is no confidence interval, so that a tenth may be outside,
/// none by more than a factor 4.
#[test]
fn functions_with_jumps_have_errors() {
    let mut functions: Vec<Box<dyn SquareIntegrand>> = Vec::new();
    for i in 0..12 {
        let x = i as f64;
        functions.push(Box::new(Disk::new(0.05 + 0.035 * x, [0.5, 0.37]).unwrap()));
        functions.push(Box::new(HalfPlane::new(7.0 + 31.0 * x, 0.06 * x - 0.4).unwrap()));
        functions.push(Box::new(HalfPlane::new(90.0 * (x % 4.0), 0.07 * x - 0.4).unwrap()));
        let texel = |k: usize| (k * 7919 % (31 + i)) as f64;
        let (width, height) = (3 + i, 5);
        let texels: Vec<f64> = (0..width * height).map(texel).collect();
        let image = |interpolation| SquareImage::new(width, height, texels.clone(), interpolation);
        functions.push(Box::new(image(Interpolation::Constant).unwrap()));
        functions.push(Box::new(image(Interpolation::Bilinear).unwrap()));
    }
    let (mut outside, mut total) = (0, 0);
    for (i, f) in functions.iter().enumerate() {
        let found = adaptive(f, 150_000);
        assert!(found.exact().is_none() && found.n_evaluations() <= 150_000);
        let (known, got) = (energies(f, 40, 40), energies(&found, 40, 40));
        // The last grid has 181 points along a side or more, the first that counts half as many.
        let kmax = got.bands().radius(got.per_band().len() - 1);
        assert!((22.0..=32.0).contains(&kmax), "{i}: {kmax}");
        let (integral, stated) = found.integral_estimate().unwrap();
        let mut check = |what: &str, got: f64, expected: f64, stated: f64| {
            let error = (got - expected).abs();
            let rounding = 1e-12 * known.total();
            assert!(error <= 4.0 * stated + rounding, "{i} {what}: {error:e} of {stated:e}");
            total += 1;
            outside += usize::from(error > stated + rounding);
        };
        check("integral", integral, f.exact().unwrap(), stated);
        for strata in [1e-9, 16.0, 64.0] {
            let (expected, _) = variance(&known, strata, kmax);
            let (sum, error) = variance(&got, strata, kmax);
            check("variance", sum, expected, error);
        }
        for class in 0..3 {
            let (total, expected) = (got.centred().get(class), known.centred().get(class));
            check("total", total, expected, got.centred_stderr().get(class));
        }
    }
    assert!(outside * 10 <= total, "{outside} of {total}");
}

#[test]
fn values_without_energies_are_errors() {
    let of = |f: fn([f64; 2]) -> f64| AdaptiveSquareFunction::new(f, Tolerance::default());
    let message = |f: fn([f64; 2]) -> f64| of(f).unwrap_err().to_string();
    let nan = message(|[u, v]| if u + v < 0.02 { f64::NAN } else { u });
    assert!(nan.contains("its value at u = 0.00") && nan.contains("is NaN"), "{nan}");
    assert!(matches!(of(|_| 1e200), Err(Error::Magnitude { .. })));
    assert!(matches!(of(|[u, _]| 1e-170 * u), Err(Error::Magnitude { .. })));
    let tolerance = Tolerance { max_evaluations: 100, ..Tolerance::default() };
    let few = AdaptiveSquareFunction::new(|[u, _]: [f64; 2]| u, tolerance);
    assert!(matches!(few, Err(Error::Parameter { .. })));
    // A closure alone has no energies.
    let closure = |[u, v]: [f64; 2]| u + v;
    let energy = closure.energy(&Frequencies::new(2).unwrap());
    assert!(matches!(energy, Err(Error::NoEnergy { .. })));
}
