//! Where the edges of an integrand lie on the square.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use sphvar_warps::Warp;

use crate::square::cells::{Feature, Known};
use crate::{Circle, Integrand};

/// Functions with more edges are maps, whose kinks need not be known.
const MAX_EDGES: usize = 64;
/// Larger features are found without their place.
const MAX_SIZE: f64 = 0.2;
/// The points at which an edge is examined.
const POINTS: u32 = 16;
/// The deviation of coordinates that are equal to rounding.
const ROUNDING: f64 = 1e-10;

/// Returns the edges of an integrand that are lines of constant u or v, and its small features.
pub(super) fn known(integrand: &dyn Integrand, warp: &dyn Warp) -> Known {
    let mut known = Known::default();
    let Ok(shape) = integrand.shape() else { return known };
    if shape.edges().len() > MAX_EDGES {
        return known;
    }
    known.features =
        shape.edges().iter().copied().chain(shape.support()).filter_map(feature).collect();
    for edge in shape.edges() {
        let points: Vec<[f64; 2]> = points(*edge).filter_map(|dir| warp.inverse(dir)).collect();
        for (coordinate, lines) in known.lines.iter_mut().enumerate() {
            let values = distinct(points.iter().map(|point| point[coordinate]).collect());
            // A great circle through the poles has two longitudes.
            if values.len() <= 1 + coordinate && points.len() > values.len() {
                lines.extend(values.into_iter().filter(|x| *x > ROUNDING && *x < 1.0 - ROUNDING));
            }
        }
    }
    known
}

fn feature(circle: Circle) -> Option<Feature> {
    let (size, sign) =
        if circle.angle < FRAC_PI_2 { (circle.angle, 1.0) } else { (PI - circle.angle, -1.0) };
    (size < MAX_SIZE && size > 0.0).then(|| Feature { dir: sign * circle.axis, size })
}

/// Returns directions on a circle.
fn points(circle: Circle) -> impl Iterator<Item = DVec3> {
    let (x, y) = circle.axis.any_orthonormal_pair();
    let (sin, cos) = circle.angle.sin_cos();
    (0..POINTS).map(move |i| {
        let (s, c) = (TAU * (f64::from(i) + 0.3) / f64::from(POINTS)).sin_cos();
        (cos * circle.axis + sin * (c * x + s * y)).normalize()
    })
}

/// Returns the values that differ by more than rounding, ascending.
fn distinct(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| (*a - *b).abs() <= ROUNDING);
    values
}
