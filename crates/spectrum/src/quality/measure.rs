use std::f64::consts::PI;

use sphvar_samplers::Domain;

use super::{RIESZ_EXPONENTS, SetQuality, WORST_CASE_SMOOTHNESS};

/// One number that measures a point set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// The least chord between two points.
    Separation,
    /// The largest chord from a direction to its nearest point.
    CoveringRadius,
    /// Twice the covering radius over the separation.
    MeshRatio,
    /// The L2 spherical cap discrepancy.
    CapDiscrepancy,
    /// The generalized discrepancy of Cui and Freeden.
    GeneralizedDiscrepancy,
    /// The worst-case error in H^s, by the index of s in [`WORST_CASE_SMOOTHNESS`].
    WorstCaseError(usize),
    /// The Riesz energy, by the index of s in [`RIESZ_EXPONENTS`].
    RieszEnergy(usize),
}

impl Measure {
    /// All measures.
    pub const ALL: [Self; 12] = [
        Self::Separation,
        Self::CoveringRadius,
        Self::MeshRatio,
        Self::CapDiscrepancy,
        Self::GeneralizedDiscrepancy,
        Self::WorstCaseError(0),
        Self::WorstCaseError(1),
        Self::WorstCaseError(2),
        Self::WorstCaseError(3),
        Self::RieszEnergy(0),
        Self::RieszEnergy(1),
        Self::RieszEnergy(2),
    ];

    /// Returns the name in words.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Separation => "separation".to_owned(),
            Self::CoveringRadius => "covering radius".to_owned(),
            Self::MeshRatio => "mesh ratio".to_owned(),
            Self::CapDiscrepancy => "L2 cap discrepancy".to_owned(),
            Self::GeneralizedDiscrepancy => "generalized discrepancy".to_owned(),
            Self::WorstCaseError(i) => {
                format!("worst-case error, s = {}", WORST_CASE_SMOOTHNESS[i])
            }
            Self::RieszEnergy(i) => format!("Riesz energy, s = {}", RIESZ_EXPONENTS[i]),
        }
    }

    /// Returns the value for a set, if it has one.
    #[must_use]
    pub fn value(self, set: &SetQuality) -> Option<f64> {
        let sums = set.sums.as_ref().ok();
        match self {
            Self::Separation => set.separation,
            Self::CoveringRadius => set.covering_radius.as_ref().ok().copied(),
            Self::MeshRatio => set.mesh_ratio(),
            Self::CapDiscrepancy => Some(sums?.cap_discrepancy_l2),
            Self::GeneralizedDiscrepancy => Some(sums?.generalized_discrepancy),
            Self::WorstCaseError(i) => Some(sums?.worst_case_error[i]),
            Self::RieszEnergy(i) => sums?.riesz_energy[i],
        }
    }

    /// Returns the value times the power of N that makes it comparable between numbers of points:
    /// with this power, the values of good sets tend to a constant. N counts points on the sphere,
    /// two for a line of the hemisphere. Energies are given by the constants of their second terms,
    /// [`PairSums::riesz_constants`](super::PairSums::riesz_constants).
    #[must_use]
    pub fn scaled(self, set: &SetQuality) -> Option<f64> {
        if let Self::RieszEnergy(i) = self {
            let sums = set.sums.as_ref().ok()?;
            return sums.riesz_constants(set.n_effective, set.domain)[i];
        }
        self.value(set).map(|value| value * self.scale(set.n_points, set.domain))
    }

    /// Returns the factor of [`Self::scaled`] for sets of `n_points`; 1 for energies.
    #[must_use]
    pub fn scale(self, n_points: usize, domain: Domain) -> f64 {
        domain.count_on_sphere(n_points).powf(self.power())
    }

    /// Returns the power of N of [`Self::scaled`].
    #[must_use]
    pub fn power(self) -> f64 {
        match self {
            Self::Separation | Self::CoveringRadius => 0.5,
            Self::MeshRatio | Self::RieszEnergy(_) => 0.0,
            Self::CapDiscrepancy | Self::GeneralizedDiscrepancy => 0.75,
            Self::WorstCaseError(i) => 0.5 * WORST_CASE_SMOOTHNESS[i],
        }
    }

    /// Returns [`Self::scaled`] of a hexagonal lattice, which is the limit for large N that no set
    /// is known to exceed: proven for separation and covering (Toth), conjectured for the others.
    ///
    /// With the Epstein zeta function `Z(2s) = 6 (3/4)^(s/2) zeta(s) L(s)` of the lattice of unit
    /// area, L that of the character modulo 3, `wce^2 N^s` tends to `pi^-s Z(2s)`. The squared
    /// discrepancies, whose kernels at high degrees are multiples of that of s = 3/2, tend to 1/8
    /// and `1/(8 pi)` of its limit over `N^1.5`.
    ///
    /// # References
    ///
    /// Brauchart, Hardin and Saff 2012, arXiv:1202.4037, on energies.
    #[must_use]
    pub fn hexagonal_limit(self) -> f64 {
        /// `sqrt(pi^-s Z(2s))` for s of [`WORST_CASE_SMOOTHNESS`].
        const WORST_CASE: [f64; 4] =
            [1.263_733_555_926, 0.765_491_221_160, 0.365_461_185_530, 0.187_752_398_208];
        match self {
            Self::Separation => (8.0 * PI / 3f64.sqrt()).sqrt(),
            Self::CoveringRadius => (8.0 * PI / 27f64.sqrt()).sqrt(),
            Self::MeshRatio => 2.0 / 3f64.sqrt(),
            Self::CapDiscrepancy => WORST_CASE[0] / 8f64.sqrt(),
            Self::GeneralizedDiscrepancy => WORST_CASE[0] / (8.0 * PI).sqrt(),
            Self::WorstCaseError(i) => WORST_CASE[i],
            Self::RieszEnergy(i) => [-0.027_802_653, -0.553_051_3, -0.042_884_205][i],
        }
    }

    /// Returns whether a larger value is better.
    #[must_use]
    pub fn is_larger_better(self) -> bool {
        self == Self::Separation
    }

    /// Returns the root mean square of the value over sets of independent uniform points, where it
    /// has a closed form: for discrepancies and worst-case errors.
    #[must_use]
    pub fn white_noise(self, n_points: usize, domain: Domain) -> Option<f64> {
        let per_point = match self {
            Self::CapDiscrepancy => super::UniformityStatistic::CapDiscrepancy.mean(domain),
            Self::GeneralizedDiscrepancy => {
                super::UniformityStatistic::GeneralizedDiscrepancy.mean(domain)
            }
            Self::WorstCaseError(i) => sobolev_sum(WORST_CASE_SMOOTHNESS[i], domain),
            _ => return None,
        };
        Some((per_point / n_points as f64).sqrt())
    }
}

/// Returns `sum_(l>=1) (2l+1) (1 + l(l+1))^-s` over the degrees of the domain.
fn sobolev_sum(s: f64, domain: Domain) -> f64 {
    const LAST: usize = 2000;
    let step = domain.degree_step();
    let term = |l: usize| (2 * l + 1) as f64 * (1.0 + (l * (l + 1)) as f64).powf(-s);
    let sum: f64 = (step..LAST + 1).step_by(step).rev().map(term).sum();
    // Of the terms 2x^(1-2s), x = l + 1/2, beyond: the midpoint rule, to 1e-7 of the rest.
    let edge = LAST as f64 + 0.5 + 0.5 * step as f64;
    sum + edge.powf(2.0 - 2.0 * s) / ((s - 1.0) * step as f64)
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::Domain;

    use super::{Measure, sobolev_sum};
    use crate::quality::WORST_CASE_SMOOTHNESS;

    #[test]
    fn hexagonal_limits_are_lattice_sums() {
        // The lattice of unit area out to a radius; beyond it the sum is an integral.
        let side = (2.0 / 3f64.sqrt()).sqrt();
        let radius = 300.0_f64;
        for (i, s) in WORST_CASE_SMOOTHNESS.into_iter().enumerate() {
            let mut zeta = 0.0;
            for a in -400_i32..=400 {
                for b in -400_i32..=400 {
                    let (a, b) = (f64::from(a), f64::from(b));
                    let squared = side * side * (a * a + a * b + b * b);
                    if squared > 0.0 && squared < radius * radius {
                        zeta += squared.powf(-s);
                    }
                }
            }
            zeta += std::f64::consts::PI * radius.powf(2.0 - 2.0 * s) / (s - 1.0);
            let expected = (std::f64::consts::PI.powf(-s) * zeta).sqrt();
            let got = Measure::WorstCaseError(i).hexagonal_limit();
            assert!((got / expected - 1.0).abs() < 2e-6, "{s}: {got}, {expected:.10}");
        }
        let packing = Measure::Separation.hexagonal_limit();
        let covering = Measure::CoveringRadius.hexagonal_limit();
        assert!((2.0 * covering / packing - Measure::MeshRatio.hexagonal_limit()).abs() < 1e-9);
        // Points of a hexagonal lattice with one point per area 4 pi/N are this far apart.
        assert!((packing - side * (4.0 * std::f64::consts::PI).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn sums_of_white_noise() {
        for s in WORST_CASE_SMOOTHNESS {
            for domain in [Domain::Sphere, Domain::Hemisphere] {
                let step = domain.degree_step();
                let term = |l: usize| (2 * l + 1) as f64 * (1.0 + (l * (l + 1)) as f64).powf(-s);
                let slow: f64 = (step..4_000_000).step_by(step).rev().map(term).sum();
                assert!((sobolev_sum(s, domain) / slow - 1.0).abs() < 1e-6, "{s}, {domain}");
            }
        }
    }
}
