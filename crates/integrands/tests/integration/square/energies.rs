use sphvar_sh::{Bands, ByAxis, TailClasses};

use super::cases::{cases, energies};

/// Coefficients and integrals against quadrature of the values.
#[test]
fn energies_are_those_of_fourier_integrals() {
    let frequencies = [
        [1, 0],
        [0, 1],
        [1, 1],
        [-1, 1],
        [2, 3],
        [-3, 2],
        [7, -5],
        [13, 0],
        [0, 20],
        [-21, 20],
        [6, 3],
        [12, 0],
        [24, 9],
        [-18, 30],
        [0, 33],
    ];
    for case in cases() {
        let (energy, size) = (energies(&*case.integrand, 40, 40), case.size());
        let integral = case.coefficient([0, 0])[0];
        let exact = case.integrand.exact().unwrap();
        assert!((exact - integral).abs() < 1e-13 * size, "{}: {exact}, {integral}", case.name);
        let of_mean = energy.per_band()[0];
        assert!((of_mean - exact * exact).abs() < 1e-14 * size * size, "{}: {of_mean}", case.name);
        for k in frequencies {
            let [re, im] = case.coefficient(k);
            let got = energy.per_band()[energy.bands().band_of(k).unwrap()];
            let expected = 2.0 * (re * re + im * im);
            let error = (got - expected).abs();
            let tolerance = 1e-14 * size * (expected.sqrt() + 1e-14 * size) * 4.0;
            assert!(error <= tolerance, "{} at {k:?}: {got:e} and {expected:e}", case.name);
        }
    }
}

/// Parseval's theorem off and on the axes: the energies add up to the totals, but for a rest beyond
/// the last frequency that halves where that doubles, or less.
#[test]
fn energies_add_up_to_the_totals() {
    for case in cases() {
        let energy = energies(&*case.integrand, 160, 1 << 16);
        let (bands, total) = (energy.bands(), energy.centred());
        let rest = |kmax: f64, axis_max: f64| {
            let mut sums = [0.0; 3];
            for (band, e) in energy.per_band().iter().enumerate().skip(1) {
                let class = bands.tail_class(band);
                if bands.radius(band) <= if class == 0 { kmax } else { axis_max } {
                    sums[class] += e;
                }
            }
            ByAxis::from_fn(|class| total.get(class) - sums[class])
        };
        let rounding = 1e-12 * total.sum();
        let (full, half) = (rest(160.0, 65536.0), rest(80.0, 32768.0));
        for class in 0..3 {
            let (full, half, total) = (full.get(class), half.get(class), total.get(class));
            assert!(full >= -rounding, "{} {class}: {full:e} of {total:e}", case.name);
            let (share, ratio) = if class == 0 { (0.07, 0.56) } else { (3e-5, 0.51) };
            assert!(full <= share * total + rounding, "{} {class}: {full:e}", case.name);
            assert!(full <= ratio * half + rounding, "{} {class}: {full:e} {half:e}", case.name);
        }
    }
}

/// The kurtosis against that of the values on a grid.
#[test]
fn the_kurtosis_is_that_of_the_values() {
    const N: usize = 400;
    for case in cases() {
        let at = |i: usize| ((i as f64 + 0.5) / N as f64).clamp(0.0, 1.0);
        let points = (0..N * N).map(|k| [at(k % N), at(k / N)]);
        let values: Vec<f64> = points.map(|point| case.integrand.eval(point)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let moment =
            |p| values.iter().map(|x| (x - mean).powi(p)).sum::<f64>() / values.len() as f64;
        let Some(kurtosis) = case.integrand.kurtosis() else {
            assert!(moment(2) < 1e-20, "{}", case.name);
            continue;
        };
        let expected = moment(4) / moment(2).powi(2);
        assert!((kurtosis / expected - 1.0).abs() < 0.04, "{}: {kurtosis}, {expected}", case.name);
    }
}
