use std::f64::consts::TAU;

use glam::DVec3;

use sphvar_warps::archimedes;

/// A zonal rectangle: the directions between two heights and two longitudes; a polar cap or a whole
/// zone if the longitudes span the full circle.
///
/// Its area is `(z_max - z_min) (phi_max - phi_min)` (Archimedes), so that a uniform point is
/// uniform in (z, phi).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// 1 - z at the upper and the lower edge: full relative precision at the north pole.
    drop: [f64; 2],
    phi: [f64; 2],
}

impl Region {
    /// Returns the region between `drop[0] <= 1 - z <= drop[1]` and `phi[0] <= phi <= phi[1]`.
    pub(crate) fn new(drop: [f64; 2], phi: [f64; 2]) -> Self {
        Self { drop, phi }
    }

    /// Returns the heights `[z_min, z_max]`, within [-1, 1].
    #[must_use]
    pub fn z(&self) -> [f64; 2] {
        [1.0 - self.drop[1], 1.0 - self.drop[0]]
    }

    /// Returns the longitudes `[phi_min, phi_max]` in radians, within [0, 2 pi].
    #[must_use]
    pub fn phi(&self) -> [f64; 2] {
        self.phi
    }

    /// Returns the colatitudes `[theta_min, theta_max]` in radians, within [0, pi].
    #[must_use]
    pub fn theta(&self) -> [f64; 2] {
        self.drop.map(colatitude)
    }

    /// Returns the area in steradian.
    #[must_use]
    pub fn area(&self) -> f64 {
        (self.drop[1] - self.drop[0]) * (self.phi[1] - self.phi[0])
    }

    /// Returns the direction at the fractions `u` of the height, from the upper edge down, and `v`
    /// of the longitude; both in [0, 1]. Uniform in the region if (u, v) is uniform in the square.
    #[must_use]
    pub fn uniform_point(&self, u: f64, v: f64) -> DVec3 {
        let [top, bottom] = self.drop;
        let [west, east] = self.phi;
        // The sum may exceed the edge by rounding.
        let drop = (top + (bottom - top) * u).min(bottom);
        archimedes(drop, west + (east - west) * v)
    }

    /// Returns the direction in the middle of the colatitudes and the longitudes; the pole of a cap
    /// (Leopardi 2006, section 3). The whole sphere is centred at the north pole.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        let full_turn = self.phi[1] - self.phi[0] >= TAU;
        if full_turn && self.drop[0] <= 0.0 {
            return DVec3::Z;
        }
        if full_turn && self.drop[1] >= 2.0 {
            return DVec3::NEG_Z;
        }
        let [top, bottom] = self.theta();
        let (sin_theta, cos_theta) = f64::midpoint(top, bottom).sin_cos();
        let (sin_phi, cos_phi) = f64::midpoint(self.phi[0], self.phi[1]).sin_cos();
        DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
    }
}

/// Returns the colatitude of the height 1 - `drop`, to rounding at both poles.
fn colatitude(drop: f64) -> f64 {
    2.0 * drop.sqrt().atan2((2.0 - drop).sqrt())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    use super::{DVec3, Region};

    #[test]
    fn corners_and_centre_of_an_octant() {
        let octant = Region::new([0.0, 1.0], [0.0, FRAC_PI_2]);
        for (u, v, corner) in [(0.0, 0.3, DVec3::Z), (1.0, 0.0, DVec3::X), (1.0, 1.0, DVec3::Y)] {
            let p = octant.uniform_point(u, v);
            // The sine and cosine of a rounded pi/2.
            assert!((p - corner).length() < f64::EPSILON, "({u}, {v}) gave {p}");
        }
        let centre = octant.centre();
        let expected = DVec3::new(0.5, 0.5, 0.5f64.sqrt());
        assert!((centre - expected).length() < 4.0 * f64::EPSILON, "{centre}");
        assert!((octant.area() - FRAC_PI_2).abs() < f64::EPSILON);
    }

    #[test]
    fn caps_are_centred_at_their_poles() {
        let north = Region::new([0.0, 0.25], [0.0, TAU]);
        let south = Region::new([1.75, 2.0], [0.0, TAU]);
        assert_eq!((north.centre(), south.centre()), (DVec3::Z, DVec3::NEG_Z));
        let [top, bottom] = Region::new([0.0, 2.0], [0.0, TAU]).theta();
        assert!(top.abs() + (bottom - PI).abs() < f64::EPSILON, "{top}, {bottom}");
    }
}
