use std::f64::consts::PI;

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{Method, Transform, TransformWorkspace};

use super::near_field::NearField;
use super::splitting::Splitting;
use super::{KernelJob, RieszEnergy};
use crate::Domain;
use crate::optimization::descent::ManifoldPoint;
use crate::optimization::transforms;

/// The accuracy of the transforms.
const EPSILON: f64 = 1e-11;

/// The number of points below which all pairs are summed.
const MIN_POINTS: usize = 2048;

/// The cut-off distances considered, in units of the spacing `sqrt(4 pi/N)`: with fewer pairs the
/// far part has higher degrees. The small ones are for points that cluster.
const CUTOFFS: [f64; 8] = [2.0, 3.0, 4.5, 6.0, 7.5, 9.0, 11.0, 14.0];

/// The largest cut-off distance: a degree of 48.
const MAX_CUTOFF: f64 = 1.0;

/// Nominal work of a pair of the direct sum, of a near pair, and of the transforms of one
/// evaluation in units of one transform of lower accuracy.
const DIRECT_PAIR: f64 = 0.04;
const NEAR_PAIR: f64 = 0.08;
const TRANSFORMS: f64 = 8.0;

/// Maximum deviation from 1 of the squared length of points: the far part depends on directions
/// only.
const UNIT: f64 = 1e-14;

/// Computes Riesz energies and tangent gradients in about linear time: the near part of the kernel
/// over pairs of neighbours, the far part from the coefficients of the points,
///
/// ```text
/// sum_ij far(p_i . p_j) = 4 pi sum_l k_l sum_m |a_lm|^2
/// ```
pub(super) struct SplitEnergy {
    energy: RieszEnergy,
    cutoff: f64,
    splitting: Splitting,
    transform: Transform,
    workspace: TransformWorkspace,
    alms: [Alm; 1],
    forces: Vec<DVec3>,
    values: Vec<f64>,
}

impl SplitEnergy {
    /// Returns the method with a cut-off for sets such as `points`, or `None` if the direct sum
    /// takes less work or applies to more inputs: any exponent, points off the sphere.
    pub(super) fn for_points(energy: RieszEnergy, points: &[DVec3]) -> Option<Self> {
        let is_unit = |p: &DVec3| (p.length_squared() - 1.0).abs() <= UNIT;
        let is_possible = points.len() >= MIN_POINTS
            && (0.0..=4.0).contains(&energy.s)
            && points.iter().all(is_unit);
        if !is_possible {
            return None;
        }
        let on_sphere = energy.domain.count_on_sphere(points.len());
        let antipodal = energy.domain == Domain::Hemisphere;
        let mut best = DIRECT_PAIR * points.len() as f64 * on_sphere;
        let mut cutoff = None;
        for multiple in CUTOFFS {
            let distance = (multiple * (4.0 * PI / on_sphere).sqrt()).min(MAX_CUTOFF);
            let degree = Splitting::last_degree(distance);
            let far = TRANSFORMS * Method::Fast.nominal_work(points.len(), degree);
            // Pairs are counted only where the far part alone is not too much work.
            if far < best {
                let pairs = NearField::new(distance, points, antipodal).n_pairs();
                let work = far + NEAR_PAIR * pairs;
                if work < best {
                    (best, cutoff) = (work, Some(distance));
                }
            }
        }
        Self::with_cutoff(energy, cutoff?, points.len())
    }

    /// Returns the method with a cut-off distance in (0, 2]; `None` if memory is insufficient.
    pub(super) fn with_cutoff(energy: RieszEnergy, cutoff: f64, n_points: usize) -> Option<Self> {
        let degree = Splitting::last_degree(cutoff);
        Some(Self {
            energy,
            cutoff,
            splitting: Splitting::new(energy.s, cutoff)?,
            transform: Transform::new(Method::Fast, degree, n_points, EPSILON).ok()?,
            workspace: transforms::workspace(n_points),
            alms: [Alm::zeros(degree).ok()?],
            forces: Vec::new(),
            values: Vec::new(),
        })
    }

    fn is_antipodal(&self) -> bool {
        self.energy.domain == Domain::Hemisphere
    }

    /// Returns the factors of `|a_lm|^2` in twice the far part, by degree.
    fn factors(&self) -> Vec<f64> {
        let of_degree = |(l, k): (usize, &f64)| match (self.energy.domain, l % 2) {
            (Domain::Sphere, _) => 4.0 * PI * k,
            // Points and antipodes.
            (Domain::Hemisphere, 0) => 8.0 * PI * k,
            (Domain::Hemisphere, _) => 0.0,
        };
        self.splitting.coefficients.iter().enumerate().map(of_degree).collect()
    }

    pub(super) fn energy(&mut self, points: &[DVec3]) -> f64 {
        let field = NearField::new(self.cutoff, points, self.is_antipodal());
        let splitting = &self.splitting;
        let near = self.energy.with_kernel(NearSum { field, splitting, forces: &mut self.forces });
        let sets = [(points, None)];
        self.transform.adjoint_batch_into(&sets, &mut self.workspace, &mut self.alms);
        // The largest coefficient is known.
        let n = points.len() as f64;
        self.alms[0].column_mut(0)[0] = (n / (4.0 * PI).sqrt()).into();
        let by_degree = self.alms[0].energy_per_degree();
        let with_own: f64 = by_degree.iter().zip(self.factors()).map(|(e, f)| e * f).sum();
        let antipode = if self.is_antipodal() { self.splitting.at_antipode } else { 0.0 };
        0.5 * (near + with_own - n * (self.splitting.at_zero + antipode))
    }

    /// Replaces `gradient` by the tangent gradient at the points of the last call of
    /// [`Self::energy`], once for each.
    pub(super) fn gradient(&mut self, points: &[DVec3], gradient: &mut Vec<DVec3>) {
        let factors = self.factors();
        let alm = &mut self.alms[0];
        for m in 0..=alm.lmax() {
            for (a, factor) in alm.column_mut(m).iter_mut().zip(&factors[m..]) {
                *a *= factor;
            }
        }
        gradient.resize(points.len(), DVec3::ZERO);
        self.values.resize(points.len(), 0.0);
        self.transform.gradient_into(
            &self.alms[0],
            points,
            &mut self.workspace,
            &mut self.values,
            gradient,
        );
        let factor = self.energy.force_factor();
        for ((gradient, force), &p) in gradient.iter_mut().zip(&self.forces).zip(points) {
            *gradient += DVec3::tangent(factor * *force, p);
        }
    }
}

/// The arguments of [`NearField::sum`].
struct NearSum<'a> {
    field: NearField,
    splitting: &'a Splitting,
    forces: &'a mut Vec<DVec3>,
}

impl KernelJob for NearSum<'_> {
    fn run<K: super::Kernel>(self, kernel: K) -> f64 {
        self.field.sum(kernel, self.splitting, self.forces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pattern, Purpose, Streams};

    const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];
    const EXPONENTS: [f64; 7] = [0.0, 0.3, 1.0, 1.7, 2.0, 3.0, 4.0];
    /// Exponents and cut-off distances.
    const CASES: [(f64, f64); 6] =
        [(0.0, 0.4), (0.0, 1.0), (1.0, 0.4), (1.7, 1.0), (2.0, 0.8), (4.0, 0.4)];

    fn white(n: usize, domain: Domain) -> Vec<DVec3> {
        let mut rng = Streams::new(9, Purpose::Pattern, n).realization(0);
        Pattern::WhiteNoise.build(n, domain).unwrap().sample(&mut rng).unwrap().points
    }

    /// Sets that crowd cells, pairs of nearby points, poles, edges of bands and sectors, antipodes.
    fn hostile_sets(domain: Domain) -> Vec<(&'static str, Vec<DVec3>)> {
        let random = white(150, domain);
        let around = |centre: DVec3, size: f64| {
            let to = |p: &DVec3| (centre + size * *p).normalize();
            random.iter().map(to).collect::<Vec<_>>()
        };
        let unit = |(x, y, z)| DVec3::new(x, y, z).normalize();
        let mut pairs = random.clone();
        pairs.extend(around(DVec3::X, 1e-7).into_iter().take(20));
        pairs.extend(random.iter().map(|p| (*p + DVec3::new(1e-6, -2e-6, 1e-6)).normalize()));
        let mut at_poles = around(DVec3::Z, 0.3);
        at_poles.extend(around(-DVec3::Z, 0.01));
        at_poles.extend([(0.0, 0.0, 1.0), (1e-3, 0.0, 1.0), (0.0, 1e-2, -1.0)].map(unit));
        let mut at_edges = around(DVec3::NEG_X, 0.2);
        at_edges.extend((0..63_u32).map(|k| {
            let (sin, cos) = (2.0 * PI * (f64::from(k) + 0.25) / 63.0).sin_cos();
            DVec3::new(cos, sin, 0.0)
        }));
        at_edges.extend([(-1.0, -0.0, 0.0), (-1.0, 1e-3, 0.0)].map(unit));
        let mut antipodes = random.clone();
        antipodes.extend(random.iter().map(|p| (-*p + DVec3::splat(1e-3)).normalize()));
        vec![
            ("random", random.clone()),
            ("cluster", around(DVec3::new(0.6, 0.0, -0.8), 1e-3)),
            ("pairs", pairs),
            ("poles", at_poles),
            ("edges", at_edges),
            ("antipodes", antipodes),
            ("two", vec![DVec3::X, DVec3::Y]),
            ("one", vec![DVec3::Y]),
        ]
    }

    fn norm(vectors: &[DVec3]) -> f64 {
        vectors.iter().map(|v| v.length_squared()).sum::<f64>().sqrt()
    }

    /// Returns the errors of energy and tangent gradient, relative to the sum of the magnitudes of
    /// energies of pairs and to the norm of the gradient; at least to those of the far part of two
    /// near points, which every point has with itself.
    fn errors(energy: RieszEnergy, split: &mut SplitEnergy, points: &[DVec3]) -> [f64; 2] {
        let (mut fast, mut slow) = (Vec::new(), Vec::new());
        let got = split.energy(points);
        split.gradient(points, &mut fast);
        let expected = energy.direct(points, &mut slow);
        for (slow, &p) in slow.iter_mut().zip(points) {
            *slow = DVec3::tangent(*slow, p);
        }
        let n = points.len() as f64;
        let own = split.splitting.at_zero.abs().max(1.0);
        let scale = expected.abs().max(n * n).max(n * own);
        let off: Vec<_> = fast.iter().zip(&slow).map(|(a, b)| *a - *b).collect();
        let size = norm(&slow);
        [(got - expected).abs() / scale, norm(&off) / size.max(own / split.cutoff)]
    }

    #[test]
    fn split_sums_match_the_direct_sum() {
        for domain in DOMAINS {
            for (name, points) in hostile_sets(domain) {
                for (s, cutoff) in CASES {
                    let energy = RieszEnergy::new(domain, s);
                    let split = SplitEnergy::with_cutoff(energy, cutoff, points.len());
                    let [of_energy, of_gradient] = errors(energy, &mut split.unwrap(), &points);
                    let text = format!("{domain}, {name}, s = {s}, cut-off {cutoff}");
                    assert!(of_energy < 1e-10, "{text}: energy {of_energy:e}");
                    assert!(of_gradient < 1e-9, "{text}: gradient {of_gradient:e}");
                }
            }
        }
    }

    #[test]
    fn large_sets_are_split_and_accurate() {
        for domain in DOMAINS {
            for s in [0.0, 1.0, 4.0] {
                let energy = RieszEnergy::new(domain, s);
                let points = white(4000, domain);
                let mut split = SplitEnergy::for_points(energy, &points).unwrap();
                let [of_energy, of_gradient] = errors(energy, &mut split, &points);
                assert!(of_energy < 1e-11, "{domain}, s = {s}: energy {of_energy:e}");
                assert!(of_gradient < 1e-10, "{domain}, s = {s}: gradient {of_gradient:e}");
            }
        }
    }

    #[test]
    fn inputs_without_a_split_are_summed_directly() {
        let is_split = |points: &[DVec3], s| {
            SplitEnergy::for_points(RieszEnergy::new(Domain::Sphere, s), points).is_some()
        };
        let mut points = white(4000, Domain::Sphere);
        assert!(is_split(&points, 1.0) && is_split(&points, 0.0));
        assert!(
            !is_split(&points, -1.0) && !is_split(&points, 4.1) && !is_split(&points, f64::NAN)
        );
        assert!(!is_split(&points[..1000], 1.0));
        // All pairs are near pairs.
        let crowd: Vec<_> = points.iter().map(|p| (DVec3::X + 1e-4 * *p).normalize()).collect();
        assert!(!is_split(&crowd, 1.0));
        points[7] *= 1.0 + 1e-9;
        assert!(!is_split(&points, 1.0));
        points[7] = DVec3::NAN;
        assert!(!is_split(&points, 1.0));
    }

    #[test]
    fn coincident_points_have_no_finite_energy() {
        let mut points = white(3000, Domain::Sphere);
        points[2000] = points[1000];
        for s in EXPONENTS {
            let energy = crate::riesz_energy(&points, Domain::Sphere, s);
            assert!(!energy.is_finite(), "s = {s}: {energy}");
        }
    }

    #[test]
    fn results_do_not_depend_on_the_number_of_threads() {
        let points = white(3000, Domain::Hemisphere);
        let energy = RieszEnergy::new(Domain::Hemisphere, 1.0);
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut split = SplitEnergy::for_points(energy, &points).unwrap();
                let mut gradient = Vec::new();
                let value = split.energy(&points);
                split.gradient(&points, &mut gradient);
                (value, gradient)
            })
        });
        assert_eq!(one, three);
    }
}
