use std::sync::OnceLock;

use num_complex::Complex as Rounded;
use rand::RngExt;
use sphvar_nufft::TorusCoefficients;
use sphvar_samplers::{Purpose, Streams};

use super::definition::{Definition, value_at};
use crate::Errors;
use crate::reference::DoubleDouble;
use crate::transforms::Complex;

/// The seed of points, frequencies and coefficients.
const SEED: u64 = 7;
/// The number of compared frequencies or points.
const COMPARED: usize = 24;

/// The numbers of points and frequencies of a trial.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    pub(super) n: usize,
    pub(super) kmax: usize,
    /// The maximum frequency of single coordinates.
    pub(super) axis_max: usize,
}

/// Independent uniform points of the square, and references for some results.
#[derive(Debug)]
pub(super) struct Input {
    size: Size,
    points: Vec<[f64; 2]>,
    coordinates: Vec<f64>,
    coefficients: OnceLock<Vec<([i32; 2], Complex)>>,
    on_axis: OnceLock<Vec<([i32; 2], Complex)>>,
    function: OnceLock<TorusCoefficients>,
    values: OnceLock<Vec<DoubleDouble>>,
}

impl Input {
    pub(super) fn new(size: Size) -> Self {
        let points = points(size.n);
        let coordinates = points.iter().map(|p| p[0]).collect();
        let (coefficients, on_axis, function, values) = Default::default();
        Self { size, points, coordinates, coefficients, on_axis, function, values }
    }

    pub(super) fn size(&self) -> Size {
        self.size
    }

    pub(super) fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Returns the first coordinate of each point.
    pub(super) fn coordinates(&self) -> &[f64] {
        &self.coordinates
    }

    /// Returns random coefficients of a real function.
    pub(super) fn function(&self) -> &TorusCoefficients {
        self.function.get_or_init(|| {
            let mut rng = Streams::new(SEED, Purpose::Pattern, self.size.n).realization(1);
            let mut series = TorusCoefficients::zeros(self.size.kmax).expect("some hundreds");
            for c in series.values_mut() {
                *c = Rounded::new(rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5);
            }
            series
        })
    }

    /// Returns the errors of coefficients, relative to the root mean square of those compared.
    pub(super) fn errors_of_coefficients(&self, got: &TorusCoefficients) -> Errors {
        let exact = self.coefficients.get_or_init(|| {
            let definition = Definition::new(&self.points, None);
            let exact = |k: [i32; 2]| (k, definition.coefficient(k[0], k[1]));
            frequencies(self.size.kmax).into_iter().map(exact).collect()
        });
        let get = |k: [i32; 2]| got.get(k[0], k[1]).unwrap_or(Rounded::new(f64::NAN, 0.0));
        relative_norm(exact.iter().map(|(k, exact)| (get(*k), *exact)))
    }

    /// Returns the errors of coefficients of the first coordinate in the same way.
    pub(super) fn errors_on_axis(&self, got: &[Rounded<f64>]) -> Errors {
        let exact = self.on_axis.get_or_init(|| {
            let definition = Definition::new(&self.points, None);
            let exact = |[k, _]: [i32; 2]| ([k.abs(), 0], definition.coefficient(k.abs(), 0));
            frequencies(self.size.axis_max).into_iter().map(exact).collect()
        });
        let get = |k: i32| {
            let value = usize::try_from(k).ok().and_then(|k| got.get(k));
            value.copied().unwrap_or(Rounded::new(f64::NAN, 0.0))
        };
        let mut errors = relative_norm(exact.iter().map(|([k, _], exact)| (get(*k), *exact)));
        errors.push_length(got.len(), self.size.axis_max + 1);
        errors
    }

    /// Returns the errors of values at the first points, relative to the root mean square of those
    /// compared.
    pub(super) fn errors_of_values(&self, got: &[f64]) -> Errors {
        let exact = self.values.get_or_init(|| {
            let values = self.function().values();
            let compared = self.points.iter().take(COMPARED);
            compared.map(|p| value_at(*p, self.size.kmax, values)).collect()
        });
        let exact = exact.iter().map(|value| Complex { re: *value, im: DoubleDouble::ZERO });
        let mut errors = relative_norm(got.iter().map(|x| Rounded::new(*x, 0.0)).zip(exact));
        errors.push_length(got.len(), self.points.len());
        errors
    }
}

/// Returns `||a - b||/||b||` of pairs (a, b).
fn relative_norm(pairs: impl Iterator<Item = (Rounded<f64>, Complex)>) -> Errors {
    let (mut squares, mut energy, mut count) = (0.0, 0.0, 0);
    for (got, exact) in pairs {
        squares += difference(got, exact).powi(2);
        energy += exact.re.value().powi(2) + exact.im.value().powi(2);
        count += 1;
    }
    let mut errors = Errors::default();
    errors.push((squares / energy).sqrt(), || format!("all {count} compared"));
    errors
}

/// Returns the modulus of the difference from an exact number.
pub(super) fn difference(got: Rounded<f64>, exact: Complex) -> f64 {
    let parts = [(got.re, exact.re), (got.im, exact.im)];
    let [re, im] = parts.map(|(got, exact)| (DoubleDouble::from(got) - exact).value());
    re.hypot(im)
}

/// Returns independent uniform points.
pub(super) fn points(n: usize) -> Vec<[f64; 2]> {
    let mut rng = Streams::new(SEED, Purpose::Pattern, n).realization(0);
    (0..n).map(|_| [rng.random(), rng.random()]).collect()
}

/// Returns random frequencies, half of them with components within a tenth of the highest.
fn frequencies(kmax: usize) -> Vec<[i32; 2]> {
    let mut rng = Streams::new(SEED, Purpose::Pattern, kmax).realization(2);
    let last = i32::try_from(kmax).expect("below 2^20");
    let mut frequency = |i: usize| {
        let first = if i.is_multiple_of(2) { 0 } else { last - last / 10 };
        [(); 2].map(|()| {
            let k = rng.random_range(first..=last);
            if rng.random() { k } else { -k }
        })
    };
    (0..COMPARED).map(&mut frequency).collect()
}
