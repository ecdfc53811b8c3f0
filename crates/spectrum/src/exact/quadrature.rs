use std::f64::consts::TAU;

use glam::DVec3;
use sphvar_healpix::Cell;
use sphvar_samplers::Region;
use sphvar_sh::{Error, GaussLegendre};

/// Nodes and weights for the uniform distribution on a stratum.
#[derive(Clone, Debug, Default)]
pub(super) struct Quadrature {
    pub(super) points: Vec<DVec3>,
    /// The weights, with sum 1.
    pub(super) weights: Vec<f64>,
}

impl Quadrature {
    /// Returns the rule of `n * n` nodes on a HEALPix cell in whose interior the map is smooth.
    pub(super) fn of_cell(cell: Cell, n: usize) -> Result<Self, Error> {
        let unit = unit_rule(n)?;
        let mut rule = Self::default();
        for &(u, wu) in &unit {
            for &(v, wv) in &unit {
                rule.push(cell.uniform_point(u, v), wu * wv);
            }
        }
        Ok(rule)
    }

    /// Returns the rule of `2 n n` nodes on a HEALPix cell split along u + v = 1, where the map
    /// changes form in cells that touch |z| = 2/3. Each triangle is collapsed to its far corner,
    /// which may be a pole, so that the integrand is smooth there too.
    pub(super) fn of_cut_cell(cell: Cell, n: usize) -> Result<Self, Error> {
        let unit = unit_rule(n)?;
        let mut rule = Self::default();
        for &(s, ws) in &unit {
            for &(t, wt) in &unit {
                let (u, v, w) = (s * t, s * (1.0 - t), ws * wt * s);
                rule.push(cell.uniform_point(u, v), w);
                rule.push(cell.uniform_point(1.0 - u, 1.0 - v), w);
            }
        }
        Ok(rule)
    }

    /// Returns the rule of `n_theta * n_phi` nodes on a zonal rectangle: Gauss-Legendre in the
    /// colatitude, which unlike z is smooth at the poles, and in the longitude; equidistant nodes
    /// if the longitudes span the full circle.
    pub(super) fn of_region(region: &Region, n_theta: usize, n_phi: usize) -> Result<Self, Error> {
        let [top, bottom] = region.theta();
        let [west, east] = region.phi();
        let longitudes: Vec<(f64, f64)> = if is_full_circle(region) {
            (0..n_phi).map(|j| (TAU * j as f64 / n_phi as f64, 1.0 / n_phi as f64)).collect()
        } else {
            unit_rule(n_phi)?.iter().map(|(x, w)| (west + (east - west) * x, *w)).collect()
        };
        let colatitudes = unit_rule(n_theta)?;
        let colatitudes = colatitudes.iter().map(|(x, w)| (top + (bottom - top) * x, *w));
        let colatitudes: Vec<(f64, f64)> = colatitudes.collect();
        let mut rule = Self::default();
        let area: f64 = colatitudes.iter().map(|(theta, w)| theta.sin() * w).sum();
        for (theta, w_theta) in colatitudes {
            let (sin_theta, z) = theta.sin_cos();
            for &(phi, w_phi) in &longitudes {
                let (sin, cos) = phi.sin_cos();
                let point = DVec3::new(sin_theta * cos, sin_theta * sin, z);
                rule.push(point, sin_theta * w_theta / area * w_phi);
            }
        }
        Ok(rule)
    }

    fn push(&mut self, point: DVec3, weight: f64) {
        self.points.push(point);
        self.weights.push(weight);
    }
}

/// Returns whether the longitudes of a region span the full circle.
pub(super) fn is_full_circle(region: &Region) -> bool {
    let [west, east] = region.phi();
    east - west >= TAU
}

/// Returns Gauss-Legendre nodes and weights on the interval [0, 1].
fn unit_rule(n: usize) -> Result<Vec<(f64, f64)>, Error> {
    let rule = GaussLegendre::new(n)?;
    Ok(rule.nodes().iter().zip(rule.weights()).map(|(x, w)| (0.5 + 0.5 * x, 0.5 * w)).collect())
}

/// -ln of the target error of a rule, 2e-16.
const DIGITS: f64 = 36.0;

/// Returns the number of Gauss-Legendre nodes on a width of `2 * half_width` (radians) for
/// functions of degree `degree` under a map that is analytic in the ellipse `rho <= farthest`.
///
/// The error of a rule of n nodes is at most about `M rho^-2n`, with M the maximum modulus in the
/// Bernstein ellipse of rho (Trefethen 2008, theorem 4.5). At a distance y from the real sphere a
/// function of degree l grows by `cosh(l y) <= e^(l y)`, and so
///
/// ```text
/// n = min over rho of (36 + l sinh(h (rho - 1/rho)/2))/(2 ln rho)
/// ```
///
/// where the sinh allows for maps that are themselves trigonometric.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a positive number of nodes; a cast saturates"
)]
pub(super) fn gauss_nodes(degree: f64, half_width: f64, farthest: f64) -> usize {
    const STEPS: u32 = 64;
    const NEAREST: f64 = 1e-3;
    let ratio = ((farthest - 1.0) / NEAREST).powf(1.0 / f64::from(STEPS));
    let min = (0..=STEPS)
        .map(|k| {
            let beyond = NEAREST * ratio.powi(k.cast_signed());
            let rho = 1.0 + beyond;
            let growth = degree * (half_width * 0.5 * (rho - 1.0 / rho)).sinh();
            (DIGITS + growth) / (2.0 * beyond.ln_1p())
        })
        .fold(f64::INFINITY, f64::min);
    (min.ceil() as usize).min(GaussLegendre::MAX_NODES)
}

/// Returns the number of equidistant longitudes at which a function of degree `lmax` at
/// `sin(theta) <= sin_theta` is not aliased: its component of order m is at most
/// `(l sin(theta)/2)^m/m!`, and no order is above lmax.
pub(super) fn circle_nodes(lmax: usize, sin_theta: f64) -> usize {
    let log_half = (0.5 * lmax as f64 * sin_theta).ln();
    let mut log_order = 0.0;
    let mut m = 1;
    while m <= lmax {
        log_order += log_half - (m as f64).ln();
        // Past the maximum of the sequence, and below the target error.
        if log_order < -DIGITS && log_half < (m as f64).ln() {
            break;
        }
        m += 1;
    }
    m
}
