mod near_field;
mod split_energy;
mod splitting;

use glam::DVec3;
use pulp::NullaryFnOnce;

use self::split_energy::SplitEnergy;
use super::descent::{Descent, Objective};
use crate::ensemble::progress::Tick;
use crate::{Domain, Stopped};

/// Number of pairs processed together, independent of the register width so that sums do not depend
/// on it.
const LANES: usize = 8;

/// Returns the Riesz energy of exponent `s` of `points`, or the logarithmic energy for `s = 0`.
///
/// ```text
/// E_s = sum_(i<j) |p_i - p_j|^-s,    E_0 = - sum_(i<j) log |p_i - p_j|
/// ```
///
/// On the hemisphere each pair of points contributes with both `|p_i - p_j|` and `|p_i + p_j|`; the
/// distance of a point to its own antipode does not contribute. Distances are chords, not arcs. The
/// result is infinite or NaN if points coincide or `s` is NaN.
///
/// From 2048 unit vectors and for s in [0, 4], where that takes less work, the kernel is split into
/// a near part, summed over pairs of neighbours, and a smooth far part, a sum over spherical
/// harmonics (Ewald 1921): about linear time, and errors of at most 1e-11 of the sum of the
/// magnitudes of the energies of pairs. Otherwise the cost is N^2 pairs, 2 N^2 on the hemisphere;
/// so it is for points most of which lie in small clusters.
///
/// ```
/// use glam::DVec3;
/// use sphvar_samplers::{Domain, riesz_energy};
/// // The octahedron solves Thomson's problem for six charges: 12/sqrt 2 + 3/2.
/// let mut charges = DVec3::AXES.to_vec();
/// charges.extend(DVec3::AXES.map(|p| -p));
/// assert!((riesz_energy(&charges, Domain::Sphere, 1.0) - 9.985281374).abs() < 1e-9);
/// ```
#[must_use]
pub fn riesz_energy(points: &[DVec3], domain: Domain, s: f64) -> f64 {
    Downhill::new(RieszEnergy::new(domain, s), points).energy(points)
}

/// Computes the energy of [`riesz_energy`] with its gradient.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RieszEnergy {
    domain: Domain,
    s: f64,
}

impl RieszEnergy {
    pub(crate) fn new(domain: Domain, s: f64) -> Self {
        Self { domain, s }
    }

    /// Returns the energy by the sum over all pairs, and replaces `gradient` by its derivatives with
    /// respect to each point in space.
    pub(crate) fn direct(&self, points: &[DVec3], gradient: &mut Vec<DVec3>) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|d: usize| points.iter().map(|p| p[d]).collect::<Vec<_>>());
        let antipodal = self.domain == Domain::Hemisphere;
        let coordinates = [x.as_slice(), &y, &z];
        let twice = self.with_kernel(AllPairs { points, coordinates, antipodal, forces: gradient });
        let factor = self.force_factor();
        gradient.iter_mut().for_each(|force| *force *= factor);
        twice / 2.0
    }

    /// Returns the derivative of the energy of a pair with respect to one of the points, over
    /// `|p - q|^(-s-2) (p - q)`.
    fn force_factor(&self) -> f64 {
        if self.s.abs() <= 0.0 { -1.0 } else { -self.s }
    }

    fn with_kernel(&self, job: impl KernelJob) -> f64 {
        let is = |whole: f64| self.s.to_bits() == whole.to_bits();
        if self.s.abs() <= 0.0 {
            job.run(Logarithm)
        } else if is(1.0) {
            job.run(HalfPower::<3>)
        } else if is(2.0) {
            job.run(HalfPower::<4>)
        } else if is(3.0) {
            job.run(HalfPower::<5>)
        } else if is(4.0) {
            job.run(HalfPower::<6>)
        } else {
            job.run(RealPower(-0.5 * self.s - 1.0))
        }
    }

    /// Moves the points by a number of steps downhill. Before each, `tick` returns whether to
    /// continue.
    pub(crate) fn descend(
        self,
        points: &mut Vec<DVec3>,
        iterations: u32,
        tick: Tick<'_>,
    ) -> Result<(), Stopped> {
        let spacing = (self.domain.area() / points.len() as f64).sqrt();
        // The curvature of one neighbour's energy at that spacing, s(s+1)/spacing^(s+2), six times.
        let curvature = 6.0 * (self.s * (self.s + 1.0)).max(1.0) * spacing.powf(-self.s - 2.0);
        let descent =
            Descent { iterations, scale: 1.0 / curvature, is_adaptive: true, reach: spacing / 3.0 };
        let mut downhill = Downhill::new(self, points);
        descent.run(points, &mut downhill, tick)?;
        Ok(())
    }
}

/// A sum with any of the kernels.
trait KernelJob {
    fn run<K: Kernel>(self, kernel: K) -> f64;
}

/// The objective of a descent, by the method that takes less work at its first points: the sum of
/// all pairs, from which energy and gradient come together, or the split sum.
enum Downhill {
    Direct { energy: RieszEnergy, gradient: Vec<DVec3> },
    Split(Box<SplitEnergy>),
}

impl Downhill {
    fn new(energy: RieszEnergy, points: &[DVec3]) -> Self {
        match SplitEnergy::for_points(energy, points) {
            Some(split) => Self::Split(Box::new(split)),
            None => Self::Direct { energy, gradient: Vec::new() },
        }
    }
}

impl Objective<DVec3> for Downhill {
    fn energy(&mut self, points: &[DVec3]) -> f64 {
        match self {
            Self::Direct { energy, gradient } => energy.direct(points, gradient),
            Self::Split(split) => split.energy(points),
        }
    }

    fn gradient(&mut self, points: &[DVec3], out: &mut Vec<DVec3>) {
        match self {
            Self::Direct { gradient, .. } => std::mem::swap(out, gradient),
            Self::Split(split) => split.gradient(points, out),
        }
    }
}

/// All points in the field of all others.
struct AllPairs<'a> {
    points: &'a [DVec3],
    coordinates: [&'a [f64]; 3],
    antipodal: bool,
    forces: &'a mut Vec<DVec3>,
}

impl KernelJob for AllPairs<'_> {
    fn run<K: Kernel>(self, kernel: K) -> f64 {
        let Self { points, coordinates, antipodal, forces } = self;
        pulp::Arch::new().dispatch(Fields { kernel, points, coordinates, antipodal, forces })
    }
}

/// The arguments of [`AllPairs`] with a kernel.
struct Fields<'a, K> {
    kernel: K,
    points: &'a [DVec3],
    coordinates: [&'a [f64]; 3],
    antipodal: bool,
    forces: &'a mut Vec<DVec3>,
}

impl<K: Kernel> NullaryFnOnce for Fields<'_, K> {
    type Output = f64;

    // Inlined so that it is compiled for the dispatched instruction set.
    #[inline(always)]
    fn call(self) -> f64 {
        let mut twice = 0.0;
        self.forces.clear();
        for (i, &p) in self.points.iter().enumerate() {
            let mut force = DVec3::ZERO;
            for others in [self.coordinates.map(|c| &c[..i]), self.coordinates.map(|c| &c[i + 1..])]
            {
                let (energy, on_point) = field(self.kernel, p, others);
                twice += energy;
                force += on_point;
                if self.antipodal {
                    let (energy, on_antipode) = field(self.kernel, -p, others);
                    twice += energy;
                    force -= on_antipode;
                }
            }
            self.forces.push(force);
        }
        twice
    }
}

/// The energy and force between two points as functions of their squared distance.
trait Kernel: Copy + Send + Sync {
    /// `d2^(-s/2 - 1)`.
    fn weight(self, d2: f64) -> f64;

    /// Returns the contributions of pairs to the energy, distributed over the lanes in any way.
    #[inline(always)]
    fn energies(self, d2: [f64; LANES], weights: [f64; LANES]) -> [f64; LANES] {
        let mut energies = d2;
        for (energy, weight) in energies.iter_mut().zip(weights) {
            *energy *= weight;
        }
        energies
    }

    /// Returns the contribution of one pair to the energy.
    #[inline(always)]
    fn energy(self, d2: f64, weight: f64) -> f64 {
        d2 * weight
    }
}

/// `d2^(-K/2)`: whole s = K - 2.
#[derive(Clone, Copy)]
struct HalfPower<const K: u32>;

impl<const K: u32> Kernel for HalfPower<K> {
    #[inline(always)]
    fn weight(self, d2: f64) -> f64 {
        let mut power = if K % 2 == 1 { d2.sqrt() } else { 1.0 };
        for _ in 0..K / 2 {
            power *= d2;
        }
        1.0 / power
    }
}

/// `d2` to any power.
#[derive(Clone, Copy)]
struct RealPower(f64);

impl Kernel for RealPower {
    #[inline(always)]
    fn weight(self, d2: f64) -> f64 {
        d2.powf(self.0)
    }
}

#[derive(Clone, Copy)]
struct Logarithm;

impl Kernel for Logarithm {
    #[inline(always)]
    fn weight(self, d2: f64) -> f64 {
        1.0 / d2
    }

    /// Takes one logarithm of the product; squared distances of at least 1e-33 cannot underflow.
    #[inline(always)]
    fn energies(self, d2: [f64; LANES], _: [f64; LANES]) -> [f64; LANES] {
        let mut energies = [0.0; LANES];
        energies[0] = -0.5 * d2.iter().product::<f64>().ln();
        energies
    }

    #[inline(always)]
    fn energy(self, d2: f64, _: f64) -> f64 {
        -0.5 * d2.ln()
    }
}

/// Returns the energy of `p` among `others` and the sum of weight times (p - other).
#[inline(always)]
fn field<K: Kernel>(kernel: K, p: DVec3, others: [&[f64]; 3]) -> (f64, DVec3) {
    let [(xs, x_rest), (ys, y_rest), (zs, z_rest)] = others.map(<[f64]>::as_chunks::<LANES>);
    let [mut energy, mut fx, mut fy, mut fz] = [[0.0; LANES]; 4];
    for ((x, y), z) in xs.iter().zip(ys).zip(zs) {
        // Loops over arrays, because `array::map` is a call where it is not inlined.
        let [mut dx, mut dy, mut dz, mut d2, mut weights] = [[0.0; LANES]; 5];
        for k in 0..LANES {
            (dx[k], dy[k], dz[k]) = (p.x - x[k], p.y - y[k], p.z - z[k]);
            d2[k] = dx[k] * dx[k] + dy[k] * dy[k] + dz[k] * dz[k];
        }
        for k in 0..LANES {
            weights[k] = kernel.weight(d2[k]);
        }
        let energies = kernel.energies(d2, weights);
        for k in 0..LANES {
            energy[k] += energies[k];
            fx[k] += weights[k] * dx[k];
            fy[k] += weights[k] * dy[k];
            fz[k] += weights[k] * dz[k];
        }
    }
    let [mut energy, fx, fy, fz] = [energy, fx, fy, fz].map(|lanes| lanes.iter().sum::<f64>());
    let mut force = DVec3::new(fx, fy, fz);
    for ((&x, &y), &z) in x_rest.iter().zip(y_rest).zip(z_rest) {
        let d = p - DVec3::new(x, y, z);
        let d2 = d.length_squared();
        let weight = kernel.weight(d2);
        energy += kernel.energy(d2, weight);
        force += weight * d;
    }
    (energy, force)
}

#[cfg(test)]
mod tests {
    use super::{DVec3, Domain, RieszEnergy};
    use crate::{Pattern, Purpose, Streams};

    const EXPONENTS: [f64; 8] = [0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 3.7, 4.0];

    fn white(n: usize, domain: Domain) -> Vec<DVec3> {
        let mut rng = Streams::new(8, Purpose::Pattern, n).realization(0);
        Pattern::WhiteNoise.build(n, domain).unwrap().sample(&mut rng).unwrap().points
    }

    fn by_definition(points: &[DVec3], domain: Domain, s: f64) -> f64 {
        let f = |d: f64| if s > 0.0 { d.powf(-s) } else { -d.ln() };
        let mut energy = 0.0;
        for (i, &p) in points.iter().enumerate() {
            for &q in &points[..i] {
                energy += f(p.distance(q));
                if domain == Domain::Hemisphere {
                    energy += f(p.distance(-q));
                }
            }
        }
        energy
    }

    #[test]
    fn energies_match_the_definition() {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            for n in [1, 2, 3, 9, 40] {
                let points = white(n, domain);
                for s in EXPONENTS {
                    let fast = RieszEnergy::new(domain, s).direct(&points, &mut Vec::new());
                    let slow = by_definition(&points, domain, s);
                    // There are n^2 terms; logarithms of both signs add up to about n^2/3 in
                    // magnitude.
                    let scale = slow.abs().max((n * n) as f64);
                    let tolerance = 16.0 * f64::EPSILON * scale;
                    assert!((fast - slow).abs() < tolerance, "{domain} {n} {s}: {fast}, {slow}");
                }
            }
        }
    }

    #[test]
    fn gradients_match_finite_differences_of_energies() {
        const H: f64 = 1e-5;
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let points = white(21, domain);
            for s in EXPONENTS {
                let energy = RieszEnergy::new(domain, s);
                let mut gradient = Vec::new();
                energy.direct(&points, &mut gradient);
                for i in [0, 10, 20] {
                    for axis in DVec3::AXES {
                        let at = |t: f64| {
                            let mut moved = points.clone();
                            moved[i] += t * axis;
                            by_definition(&moved, domain, s)
                        };
                        let slope = (at(H) - at(-H)) / (2.0 * H);
                        let off = slope - gradient[i].dot(axis);
                        // Third derivatives grow as 1/d^2 with d at least 0.05, so the error is
                        // (H/d)^2 of the closest pair's force.
                        let scale = gradient.iter().map(|g| g.length()).fold(1.0, f64::max);
                        assert!(off.abs() < 1e-5 * scale, "{domain}, s = {s}: {off} of {scale}");
                    }
                }
            }
        }
    }
}
