use super::distance_penalty::{DistancePenalty, NearPairs, PenaltySpace};
use crate::optimization::descent::{ManifoldPoint, Objective};
use crate::vector::Vector;

/// Relative accuracies of the coefficients, from the first steps to the last. The smallest residual
/// that a transform resolves is a tenth of the square of its accuracy. Gradients always have the
/// first one: their errors are relative to coefficients that decrease, and even 1e-2 takes no more
/// steps.
pub(crate) const ACCURACIES: [f64; 4] = [1e-3, 1e-5, 1e-7, 1e-10];

/// The residuals, where the target is 0 and elsewhere, below which each accuracy gives way to the
/// next.
const SUFFICIENT_FOR: [[f64; 2]; 3] = [[1e-5, 1e-2], [1e-9, 1e-4], [1e-13, 1e-5]];

/// Threshold below which a power, or a penalty relative to its maximum, counts as zero.
const VANISHED: f64 = 5e-21;

/// Tolerance of a power with a nonzero target.
pub(super) const NEAR: f64 = 1e-6;

/// A descent has stalled if its slope `|grad E|^2/(2E)` is below `STALLED` for `PATIENCE` steps in
/// a row; it stays above 4e-4 in descents that converge.
const STALLED: f64 = 1e-5;
const PATIENCE: u32 = 5;

/// The transforms between points and the coefficients of bands of equal or similar eigenvalues of
/// the Laplacian.
pub(crate) trait BandTransform {
    type Point: ManifoldPoint;

    /// The area of the space: `AREA/N` makes the mean square of the coefficients of white noise 1.
    const AREA: f64;

    /// Replaces `squares` by the sums `|c_b|^2` of the squared moduli of the coefficients of each
    /// band b, with the accuracy `ACCURACIES[level]`.
    fn analyze(&mut self, points: &[Self::Point], level: usize, squares: &mut Vec<f64>);

    /// Replaces `gradient` by that of the function whose coefficients are those of the last points
    /// analyzed, times a factor for each band, with the accuracy `ACCURACIES[0]`.
    /// Consumes the coefficients.
    fn gradient_into(
        &mut self,
        factors: &[f64],
        points: &[Self::Point],
        gradient: &mut [Self::Point],
    );
}

/// A band with a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Band {
    /// The index among the bands of the transform.
    pub(crate) index: usize,
    /// The power P*.
    pub(crate) target: f64,
    /// The number of coefficients.
    pub(crate) multiplicity: f64,
    /// The eigenvalue of minus the Laplacian.
    pub(crate) eigenvalue: f64,
}

/// The deviation of the amplitudes `|c_b|` of a set of points from those of a target,
///
/// ```text
/// E = 1/2 (A/N) sum_b (|c_b| - a_b)^2/lambda_b + core,   |c_b|^2 = sum over band b of |c|^2,
/// a_b^2 = (N/A) n_b P*(b)
/// ```
///
/// for `n_b` coefficients in band b, eigenvalues `lambda_b` of minus the Laplacian and an area A.
/// The weights are those of the logarithmic energy: for scattered points they make the rows of the
/// Jacobian of the coefficients nearly orthonormal, so that a unit step along the negative gradient
/// is nearly a Newton step.
pub(crate) struct SpectralEnergy<T: BandTransform, S: PenaltySpace> {
    transform: T,
    bands: Vec<Band>,
    core: DistancePenalty<S>,
    pairs: NearPairs<S>,
    n_points: usize,
    /// The index of the accuracy.
    level: usize,
    /// `|c_b|^2` by band.
    squares: Vec<f64>,
    core_energy: f64,
    core_gradient: Vec<T::Point>,
    stalled_for: u32,
}

impl<T: BandTransform, S: PenaltySpace<Point = T::Point>> SpectralEnergy<T, S> {
    pub(crate) fn new(
        transform: T,
        bands: Vec<Band>,
        core: DistancePenalty<S>,
        n_points: usize,
    ) -> Self {
        Self {
            transform,
            bands,
            core,
            pairs: NearPairs::new(core),
            n_points,
            level: 0,
            squares: Vec::new(),
            core_energy: 0.0,
            core_gradient: Vec::new(),
            stalled_for: 0,
        }
    }

    /// Returns the energy with the finest transforms from the start.
    pub(crate) fn into_fine(self) -> Self {
        Self { level: ACCURACIES.len() - 1, ..self }
    }

    /// Returns whether the finest transforms are used.
    pub(super) fn is_fine(&self) -> bool {
        self.level + 1 == ACCURACIES.len()
    }

    /// Returns `A/N`.
    fn normalization(&self) -> f64 {
        T::AREA / self.n_points as f64
    }

    /// Returns `a_b`.
    fn amplitude(&self, band: Band) -> f64 {
        (band.multiplicity * band.target / self.normalization()).sqrt()
    }

    /// Returns the largest power where the target is 0, and the largest deviation from the target
    /// elsewhere.
    pub(crate) fn residuals(&self) -> [f64; 2] {
        let mut residuals = [0.0; 2];
        for band in &self.bands {
            let power = self.normalization() * self.squares[band.index] / band.multiplicity;
            let of_kind = &mut residuals[usize::from(band.target > 0.0)];
            *of_kind = f64::max(*of_kind, (power - band.target).abs());
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

impl<T, S> Objective<T::Point> for SpectralEnergy<T, S>
where
    T: BandTransform,
    S: PenaltySpace<Point = T::Point>,
{
    fn energy(&mut self, points: &[T::Point]) -> f64 {
        self.transform.analyze(points, self.level, &mut self.squares);
        let mut sum = 0.0;
        for &band in &self.bands {
            let off = self.squares[band.index].sqrt() - self.amplitude(band);
            sum += off * off / band.eigenvalue;
        }
        self.core_gradient.clear();
        self.core_gradient.resize(points.len(), T::Point::ZERO);
        self.core_energy = self.pairs.add(points, &mut self.core_gradient);
        0.5 * self.normalization() * sum + self.core_energy
    }

    fn gradient(&mut self, points: &[T::Point], gradient: &mut Vec<T::Point>) {
        // The gradient of E with respect to the points is that of the function with coefficients
        // (A/N) (1 - a_b/|c_b|) c/lambda_b.
        let mut factors = vec![0.0; self.squares.len()];
        let normalization = self.normalization();
        for &band in &self.bands {
            let size = self.squares[band.index].sqrt();
            // A zero amplitude has no direction of increase.
            let ratio = if size > 0.0 { self.amplitude(band) / size } else { 0.0 };
            factors[band.index] = normalization * (1.0 - ratio) / band.eigenvalue;
        }
        gradient.resize(points.len(), T::Point::ZERO);
        self.transform.gradient_into(&factors, points, gradient);
        for (gradient, core) in gradient.iter_mut().zip(&self.core_gradient) {
            *gradient += *core;
        }
    }

    fn is_final(&mut self, energy: f64, squared_slope: f64) -> bool {
        let [vanishing, others] = self.residuals();
        if let Some([zero, power]) = SUFFICIENT_FOR.get(self.level)
            && vanishing < *zero
            && others < *power
        {
            self.level += 1;
            return false;
        }
        let is_slow = squared_slope < STALLED * 2.0 * energy;
        self.stalled_for = if is_slow { self.stalled_for + 1 } else { 0 };
        self.is_fine() && self.has_arrived() || self.stalled_for >= PATIENCE
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::DVec3;

    use super::super::sphere_bands::SphereBands;
    use super::{DistancePenalty, NearPairs, Objective};
    use crate::optimization::descent::Descent;
    use crate::{Domain, Pattern, Purpose, SpectralControl, SpectralTarget, Streams};

    type SpectralEnergy = super::SpectralEnergy<SphereBands, Domain>;

    const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

    fn white(n: usize, domain: Domain, realization: u64) -> Vec<DVec3> {
        let mut rng = Streams::new(11, Purpose::Pattern, n).realization(realization);
        Pattern::WhiteNoise.build(n, domain).unwrap().sample(&mut rng).unwrap().points
    }

    /// Returns a target with zeros and powers, and a penalty that some of 20 points incur.
    fn mixed(domain: Domain) -> (SpectralTarget, DistancePenalty<Domain>) {
        let power = vec![7.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.5, 0.0, 2.0];
        (SpectralTarget::new(power).unwrap(), DistancePenalty { space: domain, sigma: 0.5 })
    }

    fn rough(target: &SpectralTarget, core: DistancePenalty<Domain>, n: usize) -> SpectralEnergy {
        let bands = SphereBands::targets(target, core.space);
        let transform = SphereBands::new(target.last_degree(), n).unwrap();
        SpectralEnergy::new(transform, bands, core, n)
    }

    fn fine(target: &SpectralTarget, core: DistancePenalty<Domain>, n: usize) -> SpectralEnergy {
        rough(target, core, n).into_fine()
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
    fn definition(target: &SpectralTarget, core: DistancePenalty<Domain>, points: &[DVec3]) -> f64 {
        let normalization = 4.0 * PI / points.len() as f64;
        let squares = squares(points, target.last_degree());
        let mut sum = 0.0;
        for (l, power) in target.degrees(core.space) {
            let amplitude = ((2 * l + 1) as f64 * power / normalization).sqrt();
            sum += (squares[l].max(0.0).sqrt() - amplitude).powi(2) / (l * (l + 1)) as f64;
        }
        0.5 * normalization * sum
            + NearPairs::new(core).add(points, &mut vec![DVec3::ZERO; points.len()])
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

                energy.level = 0;
                let rough = energy.energy(&points);
                assert!(
                    (rough - slow).abs() < 1e-2 * (1.0 + slow),
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
    struct Counted(SpectralEnergy, u32);

    impl Objective<DVec3> for Counted {
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
        let core = DistancePenalty { space: domain, sigma: 0.0 };
        let energy = rough(target, core, n);
        let mut counted = Counted(energy, 0);
        let mut points = white(n, domain, realization);
        let reach = 8.0 * (domain.area() / n as f64).sqrt();
        let descent = Descent { iterations: 3000, scale: 1.0, is_adaptive: false, reach };
        descent.run(&mut points, &mut counted, &|| Ok(())).unwrap();
        assert!(counted.0.has_arrived(), "{domain} {n}: {:?}", counted.0.residuals());
        counted.1
    }

    /// [`descent_steps`](super::super::search::descent_steps) is 57 if the vanishing coefficients are
    /// half the degrees of freedom, for any N.
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
