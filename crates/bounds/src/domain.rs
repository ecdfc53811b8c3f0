use std::f64::consts::PI;

/// Where the directions live: the whole sphere, or the hemisphere read as the projective plane.
///
/// On the hemisphere the integrand is its even extension, so only even degrees exist; `N` counts points on the
/// hemisphere. The variance of an integral over the surface is
///
/// ```text
/// sphere      Var = (4 pi / N) sum_{l = 1, 2, 3, ...} E(l) P(l)
/// hemisphere  Var = (  pi / N) sum_{l = 2, 4, 6, ...} E(l) P(l)
/// ```
///
/// with `E(l) = (2l+1) P_F(l)` the integrand's energy of degree `l` (on the hemisphere: of the even extension) and
/// `P(l)` the pattern's power, 1 for white noise.
///
/// ```
/// use sphvar_bounds::Domain;
/// assert_eq!(Domain::Sphere.first_degree(), 1);
/// assert_eq!(Domain::Hemisphere.first_degree(), 2);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Domain {
    /// All directions, area 4 pi.
    #[default]
    Sphere,
    /// Directions with `z >= 0`, area 2 pi; lines through the origin.
    Hemisphere,
}

impl Domain {
    /// Returns the lowest degree that enters the variance: 1 on the sphere, 2 on the hemisphere.
    #[must_use]
    pub const fn first_degree(self) -> usize {
        self.degree_step()
    }

    /// Returns the distance between two degrees that enter the variance: 1 or 2.
    #[must_use]
    pub const fn degree_step(self) -> usize {
        match self {
            Self::Sphere => 1,
            Self::Hemisphere => 2,
        }
    }

    /// Returns the factor before the sum of the variance, `4 pi / N` or `pi / N`; infinite for `n_points = 0`.
    ///
    /// ```
    /// use sphvar_bounds::Domain;
    /// use std::f64::consts::PI;
    /// assert_eq!(Domain::Sphere.prefactor(4), PI);
    /// assert_eq!(Domain::Hemisphere.prefactor(1), PI);
    /// ```
    #[must_use]
    pub fn prefactor(self, n_points: usize) -> f64 {
        let numerator = match self {
            Self::Sphere => 4.0 * PI,
            Self::Hemisphere => PI,
        };
        numerator / n_points as f64
    }
}
