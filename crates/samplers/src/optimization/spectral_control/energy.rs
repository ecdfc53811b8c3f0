use std::f64::consts::PI;

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{Method, Transform, TransformWorkspace};

use super::distance_penalty::DistancePenalty;
use super::target::SpectralTarget;
use crate::optimization::descent::Objective;
use crate::{Domain, Error};

/// Accuracies of the initial and the final transforms. The smallest residual that a transform
/// resolves is a tenth of the square of its accuracy.
const ACCURACIES: [f64; 2] = [1e-5, 1e-10];

/// The residual below which the finer transform is used.
const ROUGH: f64 = 1e-9;

/// Threshold below which a power, or a penalty relative to its maximum, counts as zero.
const VANISHED: f64 = 5e-21;

/// Tolerance of a power with a nonzero target.
const NEAR: f64 = 1e-6;

/// A descent has stalled if its slope `|grad E|^2/(2E)` is below `STALLED` for `PATIENCE` steps in
/// a row; it stays above 4e-4 in descents that converge.
const STALLED: f64 = 1e-5;
const PATIENCE: u32 = 5;

/// The deviation of the amplitudes `|c_l|` of a set of points from those of a target,
///
/// ```text
/// E = 1/2 (4 pi/N) sum_l (|c_l| - a_l)^2/(l(l+1)) + core,   |c_l|^2 = sum_m |c_lm|^2,
/// a_l^2 = N/(4 pi) (2l+1) P*(l),
/// ```
///
/// with the weights of the logarithmic energy, so that a unit step along the negative gradient is
/// nearly a Newton step.
pub(crate) struct SpectralEnergy<'a> {
    domain: Domain,
    target: &'a SpectralTarget,
    core: DistancePenalty,
    n_points: usize,
    /// One for each of `ACCURACIES`.
    transforms: [Transform; 2],
    is_fine: bool,
    workspace: TransformWorkspace,
    alms: [Alm; 1],
    /// `|c_l|^2` by degree.
    squares: Vec<f64>,
    core_energy: f64,
    core_gradient: Vec<DVec3>,
    values: Vec<f64>,
    stalled_for: u32,
}

impl<'a> SpectralEnergy<'a> {
    pub(crate) fn new(
        domain: Domain,
        target: &'a SpectralTarget,
        core: DistancePenalty,
        n_points: usize,
    ) -> Result<Self, Error> {
        let lmax = target.last_degree();
        let transform = |epsilon| {
            Transform::new(Method::Auto, lmax, n_points, epsilon)
                .map_err(|error| Error::Degree { last: lmax, reason: error.to_string() })
        };
        let alm = Alm::zeros(lmax)
            .map_err(|error| Error::Degree { last: lmax, reason: error.to_string() })?;
        Ok(Self {
            domain,
            target,
            core,
            n_points,
            transforms: [transform(ACCURACIES[0])?, transform(ACCURACIES[1])?],
            is_fine: false,
            workspace: TransformWorkspace::default(),
            alms: [alm],
            squares: vec![0.0; lmax + 1],
            core_energy: 0.0,
            core_gradient: Vec::new(),
            values: vec![0.0; n_points],
            stalled_for: 0,
        })
    }

    /// Returns `4 pi/N`, the factor that makes the mean square of the coefficients of white noise
    /// 1.
    fn normalization(&self) -> f64 {
        4.0 * PI / self.n_points as f64
    }

    /// Returns `a_l` for a target power.
    fn amplitude(&self, l: usize, target: f64) -> f64 {
        ((2 * l + 1) as f64 * target / self.normalization()).sqrt()
    }

    /// Returns the largest power where the target is 0, and the largest deviation from the target
    /// elsewhere.
    pub(crate) fn residuals(&self) -> [f64; 2] {
        let mut residuals = [0.0; 2];
        for (l, target) in self.target.degrees(self.domain) {
            let power = self.normalization() * self.squares[l] / (2 * l + 1) as f64;
            let of_kind = &mut residuals[usize::from(target > 0.0)];
            *of_kind = f64::max(*of_kind, (power - target).abs());
        }
        residuals
    }

    /// Returns whether the points of the last call have the target spectrum and the minimum
    /// distance.
    pub(crate) fn has_arrived(&self) -> bool {
        let [vanishing, others] = self.residuals();
        let overlap = self.core.relative(self.core_energy, self.n_points);
        vanishing <= VANISHED && others <= NEAR && overlap <= VANISHED
    }
}

impl Objective for SpectralEnergy<'_> {
    fn energy(&mut self, points: &[DVec3]) -> f64 {
        let transform = &self.transforms[usize::from(self.is_fine)];
        transform.adjoint_batch_into(&[(points, None)], &mut self.workspace, &mut self.alms);
        self.squares = self.alms[0].energy_per_degree();
        let mut sum = 0.0;
        for (l, target) in self.target.degrees(self.domain) {
            let off = self.squares[l].sqrt() - self.amplitude(l, target);
            sum += off * off / (l * (l + 1)) as f64;
        }
        self.core_gradient.clear();
        self.core_gradient.resize(points.len(), DVec3::ZERO);
        self.core_energy = self.core.add(points, &mut self.core_gradient);
        0.5 * self.normalization() * sum + self.core_energy
    }

    fn gradient(&mut self, points: &[DVec3], gradient: &mut Vec<DVec3>) {
        // The gradient of E with respect to the points is that of the function with coefficients (4
        // pi/N) (1 - a_l/|c_l|) c_lm/(l(l+1)).
        let mut factors = vec![0.0; self.squares.len()];
        let normalization = self.normalization();
        for (l, target) in self.target.degrees(self.domain) {
            let size = self.squares[l].sqrt();
            // A zero amplitude has no direction of increase.
            let ratio = if size > 0.0 { self.amplitude(l, target) / size } else { 0.0 };
            factors[l] = normalization * (1.0 - ratio) / (l * (l + 1)) as f64;
        }
        let alm = &mut self.alms[0];
        for m in 0..=alm.lmax() {
            for (a, factor) in alm.column_mut(m).iter_mut().zip(&factors[m..]) {
                *a *= factor;
            }
        }
        gradient.resize(points.len(), DVec3::ZERO);
        let transform = &self.transforms[usize::from(self.is_fine)];
        transform.gradient_into(alm, points, &mut self.workspace, &mut self.values, gradient);
        for (gradient, core) in gradient.iter_mut().zip(&self.core_gradient) {
            *gradient += *core;
        }
    }

    fn is_final(&mut self, energy: f64, squared_slope: f64) -> bool {
        let [vanishing, others] = self.residuals();
        if !self.is_fine && vanishing < ROUGH && others < 100.0 * NEAR {
            self.is_fine = true;
            return false;
        }
        let is_slow = squared_slope < STALLED * 2.0 * energy;
        self.stalled_for = if is_slow { self.stalled_for + 1 } else { 0 };
        self.is_fine && self.has_arrived() || self.stalled_for >= PATIENCE
    }
}

#[cfg(test)]
mod tests {
    use super::{DVec3, DistancePenalty, Domain, Objective, PI, SpectralEnergy, SpectralTarget};
    use crate::optimization::descent::Descent;
    use crate::{Pattern, Purpose, SpectralControl, Streams};

    const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

    fn white(n: usize, domain: Domain, realization: u64) -> Vec<DVec3> {
        let mut rng = Streams::new(11, Purpose::Pattern, n).realization(realization);
        Pattern::WhiteNoise.build(n, domain).unwrap().sample(&mut rng).unwrap().points
    }

    /// Returns a target with zeros and powers, and a penalty that some of 20 points incur.
    fn mixed(domain: Domain) -> (SpectralTarget, DistancePenalty) {
        let power = vec![7.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.5, 0.0, 2.0];
        (SpectralTarget::new(power).unwrap(), DistancePenalty { domain, sigma: 0.5 })
    }

    fn fine<'a>(target: &'a SpectralTarget, core: DistancePenalty, n: usize) -> SpectralEnergy<'a> {
        let mut energy = SpectralEnergy::new(core.domain, target, core, n).unwrap();
        energy.is_fine = true;
        energy
    }

    /// Returns `|c_l|^2 = (2l+1)/(4 pi) sum_ij P_l(p_i.p_j)` from all pairs, by the addition
    /// theorem.
    fn squares(points: &[DVec3], last: usize) -> Vec<f64> {
        let mut sums = vec![0.0; last + 1];
        for p in points {
            for q in points {
                let x = p.dot(*q);
                let (mut before, mut legendre) = (0.0, 1.0);
                for (l, sum) in sums.iter_mut().enumerate() {
                    *sum += (2 * l + 1) as f64 / (4.0 * PI) * legendre;
                    let l = l as f64;
                    let next = ((2.0 * l + 1.0) * x * legendre - l * before) / (l + 1.0);
                    (before, legendre) = (legendre, next);
                }
            }
        }
        sums
    }

    /// Computes the energy by its definition. The penalty comes from its own code, which is tested
    /// separately.
    fn definition(target: &SpectralTarget, core: DistancePenalty, points: &[DVec3]) -> f64 {
        let normalization = 4.0 * PI / points.len() as f64;
        let squares = squares(points, target.last_degree());
        let mut sum = 0.0;
        for (l, power) in target.degrees(core.domain) {
            let amplitude = ((2 * l + 1) as f64 * power / normalization).sqrt();
            sum += (squares[l].max(0.0).sqrt() - amplitude).powi(2) / (l * (l + 1)) as f64;
        }
        0.5 * normalization * sum + core.add(points, &mut vec![DVec3::ZERO; points.len()])
    }

    #[test]
    fn the_energy_matches_the_definition() {
        for domain in DOMAINS {
            let (target, core) = mixed(domain);
            for n in [1, 2, 20, 300] {
                let points = white(n, domain, 0);
                let mut energy = fine(&target, core, n);
                let (fast, slow) = (energy.energy(&points), definition(&target, core, &points));
                // The accuracy of the finer transform's coefficients, with a margin for energies of
                // order 1 computed from them.
                assert!((fast - slow).abs() < 1e-9 * (1.0 + slow), "{domain} {n}: {fast}, {slow}");

                energy.is_fine = false;
                let rough = energy.energy(&points);
                assert!(
                    (rough - slow).abs() < 1e-4 * (1.0 + slow),
                    "{domain} {n}: {rough}, {slow}"
                );
            }
        }
    }

    #[test]
    fn the_gradient_matches_finite_differences_of_energies() {
        const H: f64 = 1e-5;
        for domain in DOMAINS {
            let (target, core) = mixed(domain);
            let points = white(20, domain, 0);
            let mut energy = fine(&target, core, points.len());
            let mut gradient = Vec::new();
            energy.energy(&points);
            energy.gradient(&points, &mut gradient);
            assert!(energy.core_energy > 0.0, "{domain}: no points overlap");

            let scale = gradient.iter().map(|g| g.length()).fold(0.0, f64::max);
            for (k, &p) in points.iter().enumerate() {
                let (u, v) = p.any_orthonormal_pair();
                for tangent in [u, v, (u + v).normalize()] {
                    let at = |step: f64| {
                        let mut moved = points.clone();
                        moved[k] = (p + step * tangent).normalize();
                        definition(&target, core, &moved)
                    };
                    let slope = (at(H) - at(-H)) / (2.0 * H);
                    let off = (slope - gradient[k].dot(tangent)).abs();
                    // Third derivatives grow by l^2 = 64, which leaves an error of H^2/6 times
                    // that, 1e-9. Energies of order 1 round to 1e-15, which division by H turns
                    // into 1e-10. Amplitudes near 0 have a larger curvature.
                    assert!(
                        off < 1e-7 * scale,
                        "{domain}, point {k}: {slope} by difference, off by {off} of {scale}"
                    );
                }
            }
        }
    }

    /// An objective that counts its evaluations.
    struct Counted<'a>(SpectralEnergy<'a>, u32);

    impl Objective for Counted<'_> {
        fn energy(&mut self, points: &[DVec3]) -> f64 {
            self.1 += 1;
            self.0.energy(points)
        }

        fn gradient(&mut self, points: &[DVec3], gradient: &mut Vec<DVec3>) {
            self.0.gradient(points, gradient);
        }

        fn is_final(&mut self, energy: f64, squared_slope: f64) -> bool {
            self.0.is_final(energy, squared_slope)
        }
    }

    /// Returns the number of energy evaluations of one descent for a step without further
    /// requirements.
    fn evaluations(n: usize, domain: Domain, realization: u64) -> u32 {
        let step = SpectralControl::step(n, domain, None, Some(0.0)).unwrap();
        let target = step.target();
        let core = DistancePenalty { domain, sigma: 0.0 };
        let energy = SpectralEnergy::new(domain, target, core, n).unwrap();
        let mut counted = Counted(energy, 0);
        let mut points = white(n, domain, realization);
        let reach = 8.0 * (domain.area() / n as f64).sqrt();
        let descent = Descent { iterations: 3000, scale: 1.0, is_adaptive: false, reach };
        descent.run(&mut points, &mut counted, &|| Ok(())).unwrap();
        assert!(counted.0.has_arrived(), "{domain} {n}: {:?}", counted.0.residuals());
        counted.1
    }

    /// `8 (1 + sqrt f)/(1 - sqrt f)` is 47 if the vanishing coefficients are half the degrees of
    /// freedom, for any N.
    #[test]
    fn the_number_of_steps_does_not_grow_with_the_number_of_points() {
        for domain in DOMAINS {
            for n in [100, 400, 1600] {
                let mean = f64::from((0..4).map(|k| evaluations(n, domain, k)).sum::<u32>()) / 4.0;
                assert!((30.0..64.0).contains(&mean), "{domain} {n}: {mean} evaluations");
            }
        }
    }
}
