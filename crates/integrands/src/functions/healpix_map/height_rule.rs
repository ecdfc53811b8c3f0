use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::ops::Range;

use glam::DVec3;
use num_complex::Complex;
use sphvar_sh::{Colatitude, GaussLegendre};

use crate::Error;

/// Gauss-Legendre quadrature over the height of the northern half, with panels between the centres
/// of consecutive rings of pixels, the first of which is the pole and the last the equator.
///
/// In a panel the coefficients are integrals of analytic functions: those of its edges, straight
/// lines in (z, phi) near the equator and hyperbolas near the poles, times a harmonic.
pub(super) struct HeightRule {
    n: usize,
    /// The nodes of each panel.
    panels: Vec<Range<usize>>,
    nodes: Vec<HeightNode>,
}

/// A node of a [`HeightRule`].
#[derive(Clone, Copy, Debug)]
pub(super) struct HeightNode {
    pub(super) colatitude: Colatitude,
    /// The weight in z.
    pub(super) weight: f64,
    /// The position within the panel, from 0 to 1.
    pub(super) share: f64,
}

/// `-ln` of the accuracy of the integrals over a panel, 1e-17, relative to the maximum of the
/// integrand.
const DIGITS: f64 = 39.0;

impl HeightRule {
    /// Returns the rule for degrees up to `lmax` and a map of `n = nside`.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if memory is exhausted.
    pub(super) fn new(n: usize, lmax: usize) -> Result<Self, Error> {
        let side = n as f64;
        let mut rules: BTreeMap<usize, GaussLegendre> = BTreeMap::new();
        let mut rule = Self { n, panels: Vec::new(), nodes: Vec::new() };
        let belt = node_count(lmax, &belt_growth(side));
        for panel in 0..2 * n {
            let from = panel as f64;
            let count = if panel < n { node_count(lmax, &cap_growth(side, from)) } else { belt };
            if let Entry::Vacant(place) = rules.entry(count) {
                place.insert(GaussLegendre::new(count)?);
            }
            let first = rule.nodes.len();
            let gauss = &rules[&count];
            for (&x, &w) in gauss.nodes().iter().zip(gauss.weights()) {
                let (share, w) = (0.5 * (1.0 + x), 0.5 * w);
                let (sin, z, slope) = if panel < n {
                    // 1 - z = s^2/(3 nside^2)
                    let s = from + share;
                    let half_sin = s / (side * 6f64.sqrt());
                    let sin = 2.0 * half_sin * (1.0 - half_sin * half_sin).sqrt();
                    (sin, 1.0 - 2.0 * half_sin * half_sin, 2.0 * s / (3.0 * side * side))
                } else {
                    let step = 2.0 / (3.0 * side);
                    let z = (2.0 * side - (from + share)) * step;
                    (((1.0 - z) * (1.0 + z)).sqrt(), z, step)
                };
                let colatitude = Colatitude::from_direction(DVec3::new(sin, 0.0, z));
                rule.nodes.push(HeightNode { colatitude, weight: w * slope, share });
            }
            rule.panels.push(first..rule.nodes.len());
        }
        Ok(rule)
    }

    pub(super) fn colatitudes(&self) -> impl Iterator<Item = Colatitude> {
        self.nodes.iter().map(|node| node.colatitude)
    }

    /// Returns the nodes of a panel and the number of nodes before it.
    pub(super) fn panel(&self, panel: usize) -> (usize, &[HeightNode]) {
        let range = self.panels[panel].clone();
        (range.start, &self.nodes[range])
    }

    pub(super) fn nside(&self) -> usize {
        self.n
    }
}

/// Returns the number of nodes with which the integral over a panel is exact to rounding.
///
/// For a function that is analytic within the ellipse of the sum of half-axes rho about the panel
/// and bounded there by M, the error of n nodes is below a small multiple of `M rho^(-2n)`
/// (Trefethen 2008, doi:10.1137/060659831). A harmonic of degree l along an edge of a pixel grows
/// as `exp(l x)` with the imaginary part x of the length of the edge. `growth` returns x for an
/// ellipse, and `None` if it contains a singularity.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "positive, and at most a few times the degree"
)]
fn node_count(lmax: usize, growth: &impl Fn(f64) -> Option<f64>) -> usize {
    let ellipses = (1..160).map(|k| 1.1_f64.powi(k));
    let needed = ellipses.map_while(|rho| {
        growth(rho).map(|growth| (lmax as f64 * growth + DIGITS) / (2.0 * rho.ln()))
    });
    needed.fold(f64::INFINITY, f64::min).min(1e9).ceil() as usize
}

/// Points of the upper half of the ellipse about [0, 1] of the sum of half-axes rho.
fn ellipse(rho: f64) -> impl Iterator<Item = Complex<f64>> {
    (0..=8).map(move |k| {
        let u = Complex::from_polar(rho, PI * f64::from(k) / 8.0);
        0.5 + 0.25 * (u + u.inv())
    })
}

/// Returns the modulus of the imaginary part of the arc cosine.
fn imaginary_angle(cos: Complex<f64>) -> f64 {
    (0.5 * ((cos - 1.0).norm() + (cos + 1.0).norm())).acosh()
}

/// The growth in any panel of the belt, which is greatest in the first one.
fn belt_growth(side: f64) -> impl Fn(f64) -> Option<f64> {
    move |rho| {
        ellipse(rho).try_fold(0.0, |growth: f64, x| {
            let z = 2.0 / 3.0 * (1.0 - x / side);
            // A function of odd order has a branch point at the pole.
            (z.re < 1.0).then(|| growth.max(imaginary_angle(z).hypot(FRAC_PI_4 / side * x.im)))
        })
    }
}

/// The growth in the panel of a cap at the distance `from` from the pole.
fn cap_growth(side: f64, from: f64) -> impl Fn(f64) -> Option<f64> {
    move |rho| {
        ellipse(rho).try_fold(0.0, |growth: f64, x| {
            let s = from + x;
            // phi = pi/2 k/s with k <= from + 1; in the first panel it is constant.
            if from > 0.0 && s.re < 0.25 * (from + 0.5) {
                return None;
            }
            let turn = if from > 0.0 { FRAC_PI_2 * (from + 1.0) * s.inv().im } else { 0.0 };
            let half_sin = s / (side * 6f64.sqrt());
            let cos = 1.0 - 2.0 * half_sin * half_sin;
            let sin = 2.0 * half_sin.norm().min(FRAC_PI_4.sin());
            (half_sin.norm() < 1.0).then(|| growth.max(imaginary_angle(cos).hypot(turn * sin)))
        })
    }
}
