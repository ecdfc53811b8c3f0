use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::{DMat3, DQuat, DVec3};
use num_complex::Complex;
use sphvar_nufft::parts::{FftDirection, Real};
use sphvar_sh::{Alm, ByParity, Colatitude, Domain, GaussLegendre};
use sphvar_sht::{RingTransform, RingWorkspace};

use super::{Sum, finite_values_at, weighted_kurtosis};
use crate::{Error, Integrand};

/// The number of values that are requested together.
const BATCH: usize = 1 << 17;

/// A product rule on `n` rings of `2 n` nodes: Gauss-Legendre in z on the domain, equidistant in
/// longitude. The integral is exact for polynomials of degree `2 n - 1`, so coefficients, energies
/// and squares are exact for functions of degree `n - 1`.
///
/// On the sphere the rule is rotated, on the hemisphere about z alone, by an angle of its own for
/// every `n`: no two rules share nodes, and nodes are no zeros of a single harmonic.
pub(crate) struct ProductRule {
    domain: Domain,
    n_rings: usize,
    frame: DMat3,
    /// Nodes and weights in z.
    rings: Vec<(f64, f64)>,
}

/// Integrals of one function by a [`ProductRule`].
pub(crate) struct RuleSums {
    /// `int f` over the domain.
    pub(crate) integral: f64,
    /// `int (F - mean)^2` over the sphere by parity.
    pub(crate) centred: ByParity,
    /// The energies of the degrees from 0 to `n - 1`.
    pub(crate) per_degree: Vec<f64>,
    pub(crate) kurtosis: Option<f64>,
    /// The largest absolute value.
    pub(crate) largest: f64,
}

impl ProductRule {
    /// Returns the rule with `n_rings` rings.
    pub(crate) fn new(domain: Domain, n_rings: usize) -> Result<Self, Error> {
        let rule = GaussLegendre::new(n_rings)?;
        let (scale, offset) = if domain == Domain::Sphere { (1.0, 0.0) } else { (0.5, 0.5) };
        let z = rule.nodes().iter().map(|x| offset + scale * x);
        let rings = z.zip(rule.weights().iter().map(|w| scale * w)).collect();
        // Fractional parts of irrational multiples are spread evenly and in no relation to a
        // symmetry of the function.
        let share = |irrational: f64| (n_rings as f64 * irrational).fract();
        let turn = DQuat::from_rotation_z(TAU * share(2f64.sqrt()));
        let rotation = match domain {
            Domain::Hemisphere => turn,
            Domain::Sphere => {
                let tilt = (1.0 - 2.0 * share(3f64.sqrt())).acos();
                DQuat::from_rotation_z(TAU * share(5f64.sqrt()))
                    * DQuat::from_rotation_y(tilt)
                    * turn
            }
        };
        Ok(Self { domain, n_rings, frame: DMat3::from_quat(rotation), rings })
    }

    /// Returns the number of nodes, `2 n^2`.
    pub(crate) const fn n_nodes(n_rings: usize) -> usize {
        n_rings.saturating_mul(n_rings).saturating_mul(2)
    }

    /// Returns the integrals of a function, from one value at every node.
    ///
    /// # Errors
    ///
    /// [`Error::Evaluation`] with the direction for a value that is NaN or infinite or whose
    /// evaluation panics, and the errors of [`Integrand::eval_into`].
    pub(crate) fn sums(&self, function: &dyn Integrand) -> Result<RuleSums, Error> {
        let width = 2 * self.n_rings;
        let mut values = vec![0.0; self.n_rings * width];
        let rings_per_batch = (BATCH / width).max(1);
        for (i, batch) in values.chunks_mut(rings_per_batch * width).enumerate() {
            let first = i * rings_per_batch;
            let dirs = self.directions(first..first + batch.len() / width);
            finite_values_at(function, &dirs, batch)?;
        }
        let largest = values.iter().fold(0.0, |max: f64, v| max.max(v.abs()));
        let weight = |i: usize| self.rings[i / width].1 * TAU / width as f64;
        let mut sum = Sum::default();
        values.iter().enumerate().for_each(|(i, v)| sum.add(weight(i) * v));
        let integral = sum.value();
        let mean = integral / self.domain.area();
        values.iter_mut().for_each(|v| *v -= mean);
        let kurtosis =
            weighted_kurtosis(|| values.iter().enumerate().map(|(i, &v)| (weight(i), v)));
        let centred = self.centred(&values, weight);
        let copies = if self.domain == Domain::Sphere { 1.0 } else { 2.0 };
        let mut per_degree = self.energies(&values)?;
        per_degree[0] = (copies * integral).powi(2) / (4.0 * PI);
        Ok(RuleSums { integral, centred, per_degree, kurtosis, largest })
    }

    fn directions(&self, rings: Range<usize>) -> Vec<DVec3> {
        let width = 2 * self.n_rings;
        let ring = |&(z, _): &(f64, f64)| {
            let radius = ((1.0 - z) * (1.0 + z)).sqrt();
            (0..width).map(move |j| {
                let (sin, cos) = (PI * j as f64 / self.n_rings as f64).sin_cos();
                let dir = (self.frame * DVec3::new(radius * cos, radius * sin, z)).normalize();
                // Rounding of the lowest nodes must not leave the hemisphere.
                if self.domain == Domain::Hemisphere {
                    DVec3::new(dir.x, dir.y, dir.z.abs())
                } else {
                    dir
                }
            })
        };
        self.rings[rings].iter().flat_map(ring).collect()
    }

    /// Returns the squares of even and odd part of values without their mean; the antipode of every
    /// node of the sphere is a node.
    fn centred(&self, values: &[f64], weight: impl Fn(usize) -> f64) -> ByParity {
        let width = 2 * self.n_rings;
        let mut sums = [Sum::default(); 2];
        for (i, &here) in values.iter().enumerate() {
            if self.domain == Domain::Hemisphere {
                sums[0].add(2.0 * weight(i) * here * here);
                continue;
            }
            let (ring, column) = (i / width, i % width);
            let antipode = (self.n_rings - 1 - ring) * width + (column + self.n_rings) % width;
            let there = values[antipode];
            sums[0].add(weight(i) * (0.5 * (here + there)).powi(2));
            sums[1].add(weight(i) * (0.5 * (here - there)).powi(2));
        }
        ByParity { even: sums[0].value(), odd: sums[1].value() }
    }

    /// Returns the energies of the degrees below `n`; rotations do not change them.
    fn energies(&self, values: &[f64]) -> Result<Vec<f64>, Error> {
        let (n, width) = (self.n_rings, 2 * self.n_rings);
        let plan = f64::fourier_plan(width, FftDirection::Forward);
        let mut spectra = Vec::with_capacity(n * n);
        for (row, &(_, weight)) in values.chunks(width).zip(&self.rings) {
            let mut row: Vec<_> = row.iter().map(|&v| Complex::new(v, 0.0)).collect();
            plan.process(&mut row);
            spectra.extend(row[..n].iter().map(|f| *f * (weight * TAU / width as f64)));
        }
        let mut alm = Alm::zeros(n - 1)?;
        let colatitude = |&(z, _): &(f64, f64)| {
            let radius = ((1.0 - z) * (1.0 + z)).sqrt();
            Colatitude::from_direction(DVec3::new(radius, 0.0, z))
        };
        RingTransform::new(n - 1)?.adjoint_into(
            self.rings.iter().map(colatitude),
            |m, fourier| {
                for (f, spectrum) in fourier.iter_mut().zip(spectra.chunks(n)) {
                    *f = spectrum[m];
                }
            },
            &mut RingWorkspace::default(),
            &mut alm,
        );
        let mut energies = alm.energy_per_degree();
        if self.domain == Domain::Hemisphere {
            // The even extension has twice the coefficients of the upper half in even degrees.
            for (l, e) in energies.iter_mut().enumerate() {
                *e *= if l.is_multiple_of(2) { 4.0 } else { 0.0 };
            }
        }
        Ok(energies)
    }
}
