use std::f64::consts::PI;
use std::fmt;

use glam::DVec3;

/// The domain of the directions of a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Domain {
    /// The unit sphere, area 4 pi; every degree exists.
    Sphere,
    /// The hemisphere z >= 0, area 2 pi, with antipodal (projective) symmetry: a direction and its
    /// antipode are one point, represented by the one with z >= 0, so only even degrees exist.
    Hemisphere,
}

impl Domain {
    /// Returns the name of the domain: `sphere` or `hemisphere`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Hemisphere => "hemisphere",
        }
    }

    /// Returns the area of the domain in steradians: 4 pi or 2 pi.
    #[must_use]
    pub fn area(self) -> f64 {
        match self {
            Self::Sphere => 4.0 * PI,
            Self::Hemisphere => 2.0 * PI,
        }
    }

    /// Returns whether functions on the domain have coefficients of degree `l`: all degrees on the
    /// sphere, the even ones on the hemisphere.
    #[must_use]
    #[inline]
    pub fn has_degree(self, l: usize) -> bool {
        l.is_multiple_of(self.degree_step())
    }

    /// Returns the distance between two existing degrees, which is also the first degree that
    /// contributes to a variance: 1 on the sphere, 2 on the hemisphere.
    #[must_use]
    pub const fn degree_step(self) -> usize {
        match self {
            Self::Sphere => 1,
            Self::Hemisphere => 2,
        }
    }

    /// Returns the factor k of `Var = k sum_{l >= 1} (2l+1) <P(l)> P_F(l)` for `n_points` samples:
    /// 4 pi/N on the sphere, pi/N on the hemisphere, where `P_F` is that of the even extension.
    #[must_use]
    pub fn variance_factor(self, n_points: usize) -> f64 {
        let pi = match self {
            Self::Sphere => 4.0 * PI,
            Self::Hemisphere => PI,
        };
        pi / n_points as f64
    }

    /// Returns the number of points of the same density on the whole sphere, N or 2N on the
    /// hemisphere. Its square root is the unit of spacings and frequencies.
    #[must_use]
    pub fn count_on_sphere(self, n_points: usize) -> f64 {
        match self {
            Self::Sphere => n_points as f64,
            Self::Hemisphere => 2.0 * n_points as f64,
        }
    }

    /// Returns the representative of a direction: itself on the sphere; on the hemisphere, the one
    /// of `dir` and `-dir` with z >= 0.
    #[must_use]
    #[inline]
    pub fn representative(self, dir: DVec3) -> DVec3 {
        match self {
            Self::Hemisphere if dir.z < 0.0 => -dir,
            // -0.0 satisfies z >= 0 but prints a sign.
            Self::Hemisphere => DVec3::new(dir.x, dir.y, dir.z.abs()),
            Self::Sphere => dir,
        }
    }
}

impl fmt::Display for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::{DVec3, Domain};

    #[test]
    fn the_representative_is_one_of_the_pair_with_positive_z() {
        for dir in [
            DVec3::new(0.6, 0.0, -0.8),
            DVec3::new(0.6, 0.0, 0.8),
            DVec3::new(1.0, 0.0, -0.0),
            -DVec3::Z,
        ] {
            let up = Domain::Hemisphere.representative(dir);
            assert!(up == dir || up == -dir, "{dir} gave {up}");
            assert!(up.z.is_sign_positive(), "{dir} gave {up}");
            assert_eq!(Domain::Sphere.representative(dir), dir);
        }
    }
}
