//! Comparison of associated Legendre functions with the table of 25-digit values and other exact
//! ones.

use core::fmt;

use sphvar_accuracy::reference::{AcuteAngle, DoubleDouble, LegendreTable, LegendreValue, lambda};
use sphvar_sh::{Colatitude, lambda_scaled};

/// The documented bound of the crate, in units of `EPSILON (l + 1)` times the amplitude.
const BOUND: f64 = 4.0;

/// The region of the sphere in which a row lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Region {
    /// `sin theta < m / (l + 1/2)`: the function decays; errors are relative to the value.
    Evanescent,
    /// Oscillating, `sin theta < 0.01`.
    Polar,
    /// Oscillating, `|cos theta| < 0.01`.
    Equatorial,
    /// Oscillating, elsewhere.
    Middle,
}

impl Region {
    pub(crate) const ALL: [Self; 4] =
        [Self::Evanescent, Self::Polar, Self::Equatorial, Self::Middle];

    fn of(l: usize, m: usize, c: Colatitude) -> Self {
        if c.sin() * (l as f64 + 0.5) < m as f64 {
            Self::Evanescent
        } else if c.sin() < 0.01 {
            Self::Polar
        } else if c.cos().abs() < 0.01 {
            Self::Equatorial
        } else {
            Self::Middle
        }
    }
}

/// One compared value.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Comparison {
    l: usize,
    m: usize,
    theta: f64,
    pub(crate) region: Region,
    /// The error divided by the documented bound: at most 1.
    pub(crate) of_bound: f64,
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { l, m, theta, region, of_bound } = self;
        let region = format!("{region:?}").to_lowercase();
        write!(f, "l = {l}, m = {m}, theta = {theta:?} ({region}): {of_bound:.4} of the bound")
    }
}

/// Compares one value with an exact one.
///
/// The error is relative to the amplitude of the reference. Near the poles this is more than the
/// value of the degree below, since both have nearly the same zeros.
pub(crate) fn compare(l: usize, m: usize, theta: f64, exact: DoubleDouble) -> Comparison {
    let c = Colatitude::from_theta(theta).unwrap();
    let got = lambda_scaled(l, m, c);
    let angle = AcuteAngle::from_theta(theta);
    let amplitude = lambda(l as u64, m as u64, angle).amplitude;
    let error = LegendreValue { value: exact, amplitude }
        .error(DoubleDouble::scaled(got.mantissa, got.exponent))
        .abs();
    Comparison {
        l,
        m,
        theta,
        region: Region::of(l, m, c),
        of_bound: error / (BOUND * f64::EPSILON * (l as f64 + 1.0)),
    }
}

/// Compares every row of the table.
pub(crate) fn compare_table() -> Vec<Comparison> {
    LegendreTable::rows().map(|row| compare(row.l, row.m, row.theta, row.value)).collect()
}
