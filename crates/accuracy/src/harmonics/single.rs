use crate::reference::{
    AcuteAngle, DoubleDouble, LegendreRow, LegendreTable, LegendreValue, lambda as exact_lambda,
};
use glam::DVec3;
use num_complex::Complex;
use sphvar_sh::{Colatitude, Error, lambda, ylm, ylm_at};

use super::{COLATITUDES, TWICE, documented_bound, orders, trial};
use crate::{Errors, Subject, Trial};

/// A longitude that is not a simple fraction of 2 pi.
const PHI: f64 = 2.345678901234;

/// Returns trials of `lambda` for every row of the 25-digit table, degree by degree.
pub(super) fn tables() -> Vec<Trial> {
    let mut rows: Vec<_> = LegendreTable::rows().collect();
    rows.sort_by_key(|row| row.l);
    let of_degree = |rows: &[LegendreRow]| {
        let (l, count) = (rows[0].l, rows.len());
        let single = Single {
            arguments: rows.iter().map(|&row| (l, row.m, Tabulated::new(row))).collect(),
            evaluate: |l, m, row| Ok(lambda(l, m, row.colatitude?).into()),
            exact: |l, m, row| [row.exact(l, m), ZERO],
            name: |row| theta_name(row.row.theta),
            out: vec![Complex::ZERO; count],
        };
        let case = format!("l = {l}, {count} rows");
        trial("lambda, table", case, count, documented_bound(l), "25-digit table", single)
    };
    rows.chunk_by(|a, b| a.l == b.l).map(of_degree).collect()
}

/// Returns trials of `lambda`, `ylm` and `ylm_at` at degree `l`.
pub(super) fn trials(l: usize) -> Vec<Trial> {
    let arguments =
        || orders(l).into_iter().flat_map(move |m| COLATITUDES.map(|theta| (l, m, theta)));
    let of_theta: Vec<_> = arguments().collect();
    let of_colatitude: Vec<_> = arguments()
        .map(|(l, m, theta)| (l, m, Given { theta, colatitude: Colatitude::from_theta(theta) }))
        .collect();
    let of_direction: Vec<_> = of_colatitude
        .iter()
        .map(|&(l, m, given)| (l, m, direction(given.colatitude.expect("a colatitude"))))
        .collect();
    let (count, case) = (of_theta.len(), format!("l = {l}"));
    let out = vec![Complex::ZERO; count];

    // cos and sin of m phi and their product with the value: two EPSILON for each part.
    let harmonic = documented_bound(l) + 4.0 * f64::EPSILON;
    // The error of the longitude, about one EPSILON, is multiplied by m.
    let at_direction = harmonic + f64::EPSILON * l as f64;
    let lambdas = Single {
        arguments: of_colatitude,
        evaluate: |l, m, given: Given| Ok(lambda(l, m, given.colatitude?).into()),
        exact: |l, m, given| {
            [exact_lambda(l as u64, m as u64, AcuteAngle::from_theta(given.theta)), ZERO]
        },
        name: |given| theta_name(given.theta),
        out: out.clone(),
    };
    let harmonics = Single {
        arguments: of_theta,
        evaluate: |l, m, theta| ylm(l, signed(m), theta, PHI),
        exact: |l, m, theta| {
            exact_ylm(l, m, AcuteAngle::from_theta(theta), DoubleDouble::from(PHI))
        },
        name: theta_name,
        out: out.clone(),
    };
    let at_directions = Single {
        arguments: of_direction,
        evaluate: |l, m, dir| ylm_at(l, signed(m), dir),
        exact: |l, m, dir: DVec3| {
            let phi = DoubleDouble::atan2(dir.y.into(), dir.x.into());
            exact_ylm(l, m, AcuteAngle::from_direction(dir.to_array()), phi)
        },
        name: |dir| format!("direction {:?}", dir.to_array()),
        out,
    };
    vec![
        trial("lambda", case.clone(), count, documented_bound(l), TWICE, lambdas),
        trial("ylm", case.clone(), count, harmonic, TWICE, harmonics),
        trial("ylm_at", case, count, at_direction, TWICE, at_directions),
    ]
}

/// The imaginary part of a real number.
const ZERO: LegendreValue =
    LegendreValue { value: DoubleDouble::ZERO, amplitude: DoubleDouble::ONE };

fn theta_name(theta: f64) -> String {
    format!("theta = {theta:?}")
}

/// Returns the orders here are far below the maximum, beyond which they would be rejected.
fn signed(m: usize) -> i64 {
    i64::try_from(m).unwrap_or(i64::MAX)
}

fn direction(c: Colatitude) -> DVec3 {
    DVec3::new(c.sin() * PHI.cos(), c.sin() * PHI.sin(), c.cos())
}

fn exact_ylm(l: usize, m: usize, angle: AcuteAngle, phi: DoubleDouble) -> [LegendreValue; 2] {
    let LegendreValue { value, amplitude } = exact_lambda(l as u64, m as u64, angle);
    let (sin, cos) = (DoubleDouble::from(m as u64) * phi).sin_cos();
    [cos, sin].map(|factor| LegendreValue { value: value * factor, amplitude })
}

/// A colatitude in the representations of both implementations.
#[derive(Clone, Copy, Debug)]
struct Given {
    theta: f64,
    colatitude: Result<Colatitude, Error>,
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
struct Tabulated {
    row: LegendreRow,
    colatitude: Result<Colatitude, Error>,
}

impl Tabulated {
    fn new(row: LegendreRow) -> Self {
        Self { row, colatitude: Colatitude::from_theta(row.theta) }
    }

    fn exact(self, l: usize, m: usize) -> LegendreValue {
        let angle = AcuteAngle::from_theta(self.row.theta);
        LegendreValue { value: self.row.value, ..exact_lambda(l as u64, m as u64, angle) }
    }
}

/// A function of degree, order and position, evaluated once per argument.
struct Single<A> {
    arguments: Vec<(usize, usize, A)>,
    evaluate: fn(usize, usize, A) -> Result<Complex<f64>, Error>,
    /// Real and imaginary part.
    exact: fn(usize, usize, A) -> [LegendreValue; 2],
    name: fn(A) -> String,
    out: Vec<Complex<f64>>,
}

impl<A: Copy + Send> Subject for Single<A> {
    fn run(&mut self) {
        for (slot, &(l, m, place)) in self.out.iter_mut().zip(&self.arguments) {
            // An unexpected error of a valid call must appear in the errors.
            *slot = (self.evaluate)(l, m, place).unwrap_or(Complex::new(f64::NAN, f64::NAN));
        }
    }

    fn errors(&mut self) -> Errors {
        let mut errors = Errors::default();
        for (got, &(l, m, place)) in self.out.iter().zip(&self.arguments) {
            let [re, im] = (self.exact)(l, m, place);
            let error = re.error_in_f64(got.re).hypot(im.error_in_f64(got.im));
            errors.push(error, || format!("l = {l}, m = {m}, {}", (self.name)(place)));
        }
        errors
    }
}
