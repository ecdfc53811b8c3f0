//! Sets of directions: typical ones, and difficult ones.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};

/// A linear congruential generator with the constants of Knuth's MMIX.
pub(crate) struct Lcg(u64);

impl Lcg {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns a number in [0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 * 2f64.powi(-53)
    }

    /// Returns a number in [-1, 1).
    pub(crate) fn signed(&mut self) -> f64 {
        2.0 * self.uniform() - 1.0
    }

    pub(crate) fn signed_numbers(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.signed()).collect()
    }

    pub(crate) fn direction(&mut self) -> DVec3 {
        let (z, phi) = (self.signed(), TAU * self.uniform());
        on_parallel(z, phi)
    }

    pub(crate) fn directions(&mut self, n: usize) -> Vec<DVec3> {
        (0..n).map(|_| self.direction()).collect()
    }

    /// Returns a uniform rotation, by rejection from the cube around the unit quaternions.
    pub(crate) fn rotation(&mut self) -> DQuat {
        loop {
            let q = DQuat::from_xyzw(self.signed(), self.signed(), self.signed(), self.signed());
            if (0.01..1.0).contains(&q.length_squared()) {
                return q.normalize();
            }
        }
    }
}

fn on_parallel(z: f64, phi: f64) -> DVec3 {
    let s = ((1.0 - z) * (1.0 + z)).sqrt();
    DVec3::new(s * phi.cos(), s * phi.sin(), z)
}

/// A named set of directions.
pub(crate) struct Set {
    pub(crate) name: &'static str,
    pub(crate) points: Vec<DVec3>,
}

/// Returns sets of about `n` distinct points.
pub(crate) fn distinct(n: usize) -> Vec<Set> {
    let mut rng = Lcg::new(7);
    let mut offset = || DVec3::new(rng.signed(), rng.signed(), rng.signed());
    let centre = DVec3::new(0.36, -0.48, 0.8);
    // Within 1e-3, where functions of degrees up to 2000 vary little, and on the equator itself.
    let equatorial = (0..n)
        .map(|k| {
            let v = offset();
            let z = if k % 2 == 0 { 0.0 } else { 1e-3 * v.z };
            DVec3::new(v.x, v.y, z * v.x.hypot(v.y)).normalize()
        })
        .collect();
    let clustered = (0..n).map(|_| (centre + 5e-4 * offset()).normalize()).collect();
    let polar = (0..n)
        .map(|_| {
            let v = offset();
            DVec3::new(v.x * 1e-9, v.y * 1e-9, v.z.signum())
        })
        .collect();
    vec![
        Set { name: "random", points: Lcg::new(1).directions(n) },
        Set { name: "clustered", points: clustered },
        Set { name: "polar", points: polar },
        Set { name: "equatorial", points: equatorial },
        Set { name: "Fibonacci lattice", points: fibonacci(n) },
        Set { name: "parallels and meridians", points: parallels(n) },
    ]
}

/// Returns small sets at numerically difficult positions.
pub(crate) fn difficult() -> Vec<Set> {
    let place = DVec3::new(-0.6, 0.0, 0.8);
    let set = |name, points| Set { name, points };
    vec![
        set("none", vec![]),
        set("one", vec![DVec3::new(0.48, 0.6, 0.64)]),
        set("axes", vec![DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y]),
        set("repeated", Lcg::new(3).directions(9).repeat(11)),
        set("all at one place", vec![place; 150]),
        set("all at the north pole", vec![DVec3::Z; 33]),
        set("all at the south pole", vec![-DVec3::Z; 34]),
        set("seam", seam()),
        set("near the poles", near_poles()),
    ]
}

/// Returns every kind of set, the large ones with about `n` points.
pub(crate) fn all(n: usize) -> Vec<Set> {
    let mut sets = distinct(n);
    sets.extend(difficult());
    sets
}

/// Returns the Fibonacci lattice: `z = 1 - (2k + 1)/n` at successive golden angles.
fn fibonacci(n: usize) -> Vec<DVec3> {
    let golden_angle = PI * (3.0 - 5f64.sqrt());
    (0..n)
        .map(|k| {
            on_parallel(
                1.0 - (2 * k + 1) as f64 / n as f64,
                (k as f64 * golden_angle).rem_euclid(TAU),
            )
        })
        .collect()
}

/// Returns a grid of longitudes and latitudes without the poles, on meridians that also occur in
/// transform grids.
fn parallels(n: usize) -> Vec<DVec3> {
    let rows = ((n as f64 / 2.0).sqrt().floor()).max(1.0);
    let columns = 2.0 * rows;
    (0..n)
        .map(|k| {
            let (row, column) = ((k as f64 / columns).floor(), k as f64 % columns);
            let theta = PI * (row + 0.5) / (rows + 1.0);
            let phi = TAU * column / columns - PI;
            DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        })
        .collect()
}

/// Returns points on both sides of the meridians phi = 0 and phi = pi, and of the equator.
fn seam() -> Vec<DVec3> {
    let mut points = Vec::new();
    for y in [0.0, -0.0, 1e-300, -1e-300, 1e-17, -1e-17, 1e-9, -1e-9] {
        for x in [-1.0, 1.0] {
            points.push(DVec3::new(x, y, 0.0));
            points.push(DVec3::new(x, 0.0, y));
            points.push(DVec3::new(0.6 * x, y, -0.8));
            points.push(DVec3::new(0.28 * x, y, 0.96));
        }
    }
    points
}

/// Returns points at distances of 1e-160, of the smallest number and of rounding from either pole.
fn near_poles() -> Vec<DVec3> {
    let mut points = Vec::new();
    for distance in [1e-160, 5e-324, 1e-308, 1e-17, 1.2e-16] {
        for (x, y) in [(1.0, 0.0), (-1.0, -0.0), (0.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            for z in [1.0, -1.0] {
                points.push(DVec3::new(distance * x, distance * y, z));
            }
        }
    }
    points
}
