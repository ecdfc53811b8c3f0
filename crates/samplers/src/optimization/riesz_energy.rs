use glam::DVec3;
use pulp::NullaryFnOnce;

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
/// result is infinite or NaN if points coincide or `s` is NaN. The cost is N^2 pairs, 2 N^2 on the
/// hemisphere.
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
    RieszEnergy::new(domain, s).evaluate(points, &mut Vec::new())
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

    /// Returns the energy, and replaces `gradient` by its derivatives with respect to each point in
    /// space.
    pub(crate) fn evaluate(&self, points: &[DVec3], gradient: &mut Vec<DVec3>) -> f64 {
        let is = |whole: f64| self.s.to_bits() == whole.to_bits();
        if self.s.abs() <= 0.0 {
            self.sum(Logarithm, points, gradient)
        } else if is(1.0) {
            self.sum(HalfPower::<3>, points, gradient)
        } else if is(2.0) {
            self.sum(HalfPower::<4>, points, gradient)
        } else if is(3.0) {
            self.sum(HalfPower::<5>, points, gradient)
        } else if is(4.0) {
            self.sum(HalfPower::<6>, points, gradient)
        } else {
            self.sum(RealPower(-0.5 * self.s - 1.0), points, gradient)
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
        let mut downhill = Downhill { energy: self, gradient: Vec::new() };
        descent.run(points, &mut downhill, tick)?;
        Ok(())
    }

    fn sum<K: Kernel>(&self, kernel: K, points: &[DVec3], gradient: &mut Vec<DVec3>) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|d: usize| points.iter().map(|p| p[d]).collect::<Vec<_>>());
        let antipodal = self.domain == Domain::Hemisphere;
        let fields =
            Fields { kernel, points, coordinates: [&x, &y, &z], antipodal, forces: gradient };
        let twice = pulp::Arch::new().dispatch(fields);
        let factor = if self.s.abs() <= 0.0 { -1.0 } else { -self.s };
        gradient.iter_mut().for_each(|force| *force *= factor);
        twice / 2.0
    }
}

/// Energy and gradient come from the same pairs, so they are computed together.
struct Downhill {
    energy: RieszEnergy,
    gradient: Vec<DVec3>,
}

impl Objective<DVec3> for Downhill {
    fn energy(&mut self, points: &[DVec3]) -> f64 {
        self.energy.evaluate(points, &mut self.gradient)
    }

    fn gradient(&mut self, _: &[DVec3], gradient: &mut Vec<DVec3>) {
        std::mem::swap(gradient, &mut self.gradient);
    }
}

/// The arguments of [`RieszEnergy::sum`]: all points in the field of all others.
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
trait Kernel: Copy {
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
        let dx = x.map(|x| p.x - x);
        let dy = y.map(|y| p.y - y);
        let dz = z.map(|z| p.z - z);
        let mut d2 = [0.0; LANES];
        for k in 0..LANES {
            d2[k] = dx[k] * dx[k] + dy[k] * dy[k] + dz[k] * dz[k];
        }
        let weights = d2.map(|d2| kernel.weight(d2));
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
                    let fast = RieszEnergy::new(domain, s).evaluate(&points, &mut Vec::new());
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
                energy.evaluate(&points, &mut gradient);
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
