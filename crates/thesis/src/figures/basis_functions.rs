use std::f64::consts::{PI, TAU};

use num_complex::Complex;
use sphvar_sh::{GaussLegendre, ylm, ylm_at};

use super::Recipe;
use super::point_panel::{VIEWPOINT, view_axes};
use crate::{
    Axis, Claim, Error, Field, Figure, Job, Palette, Quantity, Results, Setting, Stated, Verdict,
};

/// Figure 3.1: the real parts of the first harmonics, each on a sphere seen from outside.
pub(crate) struct BasisFunctions;

/// The last degree shown.
const LMAX: u32 = 4;
/// Pixels per sphere and the gap between spheres.
const CELL: u32 = 60;
/// The radius of a sphere in parts of its cell.
const RADIUS: f64 = 0.46;
/// Tolerance of the quadrature: it is exact for these degrees up to the rounding of some hundred
/// products of numbers below 2.
const ROUNDING: f64 = 200.0 * f64::EPSILON;

impl Recipe for BasisFunctions {
    fn title(&self) -> &'static str {
        "Real parts of spherical harmonics"
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        Vec::new()
    }

    fn compose(&self, _: Setting, _: &Results, figure: &mut Figure) -> Result<(), Error> {
        figure.panel("harmonics", "Re Y_lm, l from 0 to 4 down, m from -l to l across", spheres()?);
        let norms = squared_norms()?;
        let plain = |wanted: bool| norms.iter().filter(move |n| (n.order == 0) == wanted);
        let zonal = plain(true).map(|n| n.value).fold(1.0, farther_from_1);
        let other = plain(false).map(|n| n.value).fold(1.0, farther_from_1);
        figure.claims.push(
            Claim::number(
                "squared norm of the harmonics 3.10 without (2 - delta_0m), the farthest from 1",
                Stated::About { value: 1.0, tolerance: ROUNDING },
                Quantity::exact(farther_from_1(zonal, other)),
            )
            .because("\"orthonormal basis functions\"; 25 functions by quadrature")
            .by_construction(),
        );
        figure.claims.push(
            Claim::number(
                "squared norm of the harmonics as 3.10 prints them, m not 0",
                Stated::About { value: 1.0, tolerance: ROUNDING },
                Quantity::exact(2.0 * other),
            )
            .erratum_if(Verdict::Wrong, 1)
            .because("the factor (2 - delta_0m) belongs to real harmonics, cos and sin for m > 0"),
        );
        figure.claims.push(
            Claim::number(
                "squared norm of Y_lm in 7.1, mu(S^2)",
                Stated::About { value: 4.0 * PI, tolerance: ROUNDING },
                Quantity::exact(zonal),
            )
            .erratum_if(Verdict::Wrong, 33)
            .because(
                "3.10 has norm 1 for m = 0, with which 7.1 and 7.2 are 4 pi too large (erratum 2 lists the three norms)",
            ),
        );
        let overlap = largest_overlap()?;
        figure.claims.push(
            Claim::number(
                "largest inner product of two different harmonics up to degree 4",
                Stated::About { value: 0.0, tolerance: ROUNDING },
                Quantity::exact(overlap),
            )
            .because("\"orthonormal basis functions\"; by quadrature")
            .by_construction(),
        );
        figure.note(
            "Each sphere is seen from the same place, with +z up; the other half is not shown.",
        );
        Ok(())
    }
}

fn farther_from_1(a: f64, b: f64) -> f64 {
    if (a - 1.0).abs() > (b - 1.0).abs() { a } else { b }
}

/// Returns all spheres as one field, in a triangle.
fn spheres() -> Result<Field, Error> {
    let (columns, rows) = ((2 * LMAX + 1) * CELL, (LMAX + 1) * CELL);
    let [right, up, towards] = view_axes(VIEWPOINT);
    let mut values = Vec::with_capacity((columns * rows) as usize);
    for row in 0..rows {
        let (l, y) = (row / CELL, place(row));
        for column in 0..columns {
            let (m, x) = (i64::from(column / CELL) - i64::from(LMAX), place(column));
            let depth = 1.0 - x * x - y * y;
            values.push(if m.abs() <= i64::from(l) && depth >= 0.0 {
                let dir = right * x - up * y + towards * depth.sqrt();
                ylm_at(l as usize, m, dir)?.re
            } else {
                f64::NAN
            });
        }
    }
    let edge = f64::from(LMAX) + 0.5;
    Ok(Field {
        size: [columns as usize, rows as usize],
        values,
        label: "Re Y_lm".to_owned(),
        palette: Palette::Signed,
        x: Axis::linear("order m").over(-edge, edge),
        y: Axis::linear("degree l").over(-0.5, edge),
        rings: Vec::new(),
    })
}

/// Returns the position of the middle of a pixel in its sphere: -1 and 1 are the rims.
fn place(pixel: u32) -> f64 {
    ((f64::from(pixel % CELL) + 0.5) / f64::from(CELL) - 0.5) / RADIUS
}

/// The squared norm of a harmonic.
struct SquaredNorm {
    order: i64,
    value: f64,
}

fn squared_norms() -> Result<Vec<SquaredNorm>, Error> {
    let square = |(l, m)| {
        let value = inner_product((l, m), (l, m))?.re;
        Ok(SquaredNorm { order: m, value })
    };
    harmonics().map(square).collect()
}

fn largest_overlap() -> Result<f64, Error> {
    let mut largest = 0.0_f64;
    for a in harmonics() {
        for b in harmonics().take_while(|&b| b != a) {
            largest = largest.max(inner_product(a, b)?.norm());
        }
    }
    Ok(largest)
}

fn harmonics() -> impl Iterator<Item = (usize, i64)> {
    (0..=LMAX).flat_map(|l| {
        let last = i64::from(l);
        (-last..=last).map(move |m| (l as usize, m))
    })
}

/// `int Y_a conj Y_b` by a rule that is exact to degree `2 LMAX`.
fn inner_product(a: (usize, i64), b: (usize, i64)) -> Result<Complex<f64>, Error> {
    const MERIDIANS: u32 = 2 * LMAX + 1;
    let rule = GaussLegendre::new(LMAX as usize + 1)?;
    let mut sum = Complex::ZERO;
    for (z, weight) in rule.nodes().iter().zip(rule.weights()) {
        let theta = z.acos();
        for k in 0..MERIDIANS {
            let phi = TAU * f64::from(k) / f64::from(MERIDIANS);
            let product = ylm(a.0, a.1, theta, phi)? * ylm(b.0, b.1, theta, phi)?.conj();
            sum += product * (weight * TAU / f64::from(MERIDIANS));
        }
    }
    Ok(sum)
}
