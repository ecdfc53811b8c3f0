//! The transforms by their definition: point by point, degree by degree, to about 1e-16.

use std::f64::consts::PI;

use glam::DVec3;
use pulp::{Arch, NullaryFnOnce};
use sphvar_sh::{Alm, Colatitude, lambda};

use crate::legendre::{Group, LANES, Lanes, Order, orders};
use crate::points::Lcg;

/// Reference transforms of a set of points by the definition.
///
/// At degree 2048 the Legendre functions of `sphvar_sh` have an accuracy of 1e-13, that of the
/// transforms. Here, Legendre functions, powers of `e^{-i phi}` and sums over points use
/// double-double arithmetic. The transforms under test share no code with this reference.
pub(crate) struct Definition {
    groups: Vec<Group>,
    n_points: usize,
}

impl Definition {
    pub(crate) fn new(points: &[DVec3]) -> Self {
        Self { groups: points.chunks(LANES).map(Group::new).collect(), n_points: points.len() }
    }

    /// Returns `sum_k w_k conj Y_lm(x_k)`.
    pub(crate) fn adjoint(&self, weights: Option<&[f64]>, lmax: usize) -> Alm {
        let mut alm = Alm::zeros(lmax).unwrap();
        let mut groups = self.groups.clone();
        let ones = vec![1.0; self.n_points];
        let weights = weights.unwrap_or(&ones);
        for (m, order) in orders(lmax).enumerate() {
            let mut sums = vec![[Lanes::default(); 2]; lmax + 1 - m];
            for (group, weights) in groups.iter_mut().zip(weights.chunks(LANES)) {
                Arch::new().dispatch(AddColumn { group, weights, order: &order, sums: &mut sums });
                group.advance();
            }
            for (a, [re, im]) in alm.column_mut(m).iter_mut().zip(&sums) {
                (a.re, a.im) = (re.total(), im.total());
            }
        }
        alm
    }

    /// Returns `sum_lm a_lm Y_lm(x_k)` over orders of both signs, for each point.
    pub(crate) fn synthesis(&self, alm: &Alm) -> Vec<f64> {
        let mut groups: Vec<_> =
            self.groups.iter().map(|g| (g.clone(), Lanes::default())).collect();
        for (m, order) in orders(alm.lmax()).enumerate() {
            for (group, values) in &mut groups {
                Arch::new().dispatch(SumColumn { group, order: &order, alm, m, values });
                group.advance();
            }
        }
        let values =
            groups.iter().flat_map(|(_, v)| (0..LANES).map(|i| v.lane(i).hi + v.lane(i).lo));
        values.take(self.n_points).collect()
    }
}

/// Adds points to the sums over points at one order, by degree.
struct AddColumn<'a> {
    group: &'a Group,
    weights: &'a [f64],
    order: &'a Order,
    sums: &'a mut [[Lanes; 2]],
}

impl NullaryFnOnce for AddColumn<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { group, weights, order, sums } = self;
        let mut factors = [[0.0; LANES]; 2];
        for (part, factors) in factors.iter_mut().enumerate() {
            for (i, (factor, weight)) in factors.iter_mut().zip(weights).enumerate() {
                *factor = group.power[part].lane(i).hi * weight;
            }
        }
        group.for_each_degree(order, |n, lambdas| {
            for (sum, factors) in sums[n].iter_mut().zip(&factors) {
                let mut terms = [0.0; LANES];
                for i in 0..LANES {
                    terms[i] = lambdas[i] * factors[i];
                }
                sum.add(&terms);
            }
        });
    }
}

/// Adds one order to the values at points.
struct SumColumn<'a> {
    group: &'a Group,
    order: &'a Order,
    alm: &'a Alm,
    m: usize,
    values: &'a mut Lanes,
}

impl NullaryFnOnce for SumColumn<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { group, order, alm, m, values } = self;
        let copies = if m == 0 { 1.0 } else { 2.0 };
        let column = alm.column(m);
        group.for_each_degree(order, |n, lambdas| {
            let a = column[n] * copies;
            let mut terms = [0.0; LANES];
            for i in 0..LANES {
                // Re(a e^{i m phi}); the stored power is e^{-i m phi}.
                let rotated = a.re * group.power[0].lane(i).hi + a.im * group.power[1].lane(i).hi;
                terms[i] = lambdas[i] * rotated;
            }
            values.add(&terms);
        });
    }
}

#[test]
fn it_matches_the_functions_of_sphvar_sh() {
    let lmax = 2048;
    for p in [DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.028, 0.096, -0.995)] {
        let p = p.normalize();
        let alm = Definition::new(&[p]).adjoint(None, lmax);
        let colatitude = Colatitude::from_direction(p);
        let phi = p.y.atan2(p.x);
        for m in (0..=lmax).step_by(67) {
            for l in (m..=lmax).step_by(41) {
                let value = lambda(l, m, colatitude);
                let expected = num_complex::Complex::cis(-(m as f64) * phi) * value;
                // The stated accuracy of lambda, for values up to about sqrt(l), and the rounding
                // of m phi.
                let tolerance = 4.0 * f64::EPSILON * (l as f64 + 1.0) * (l as f64 + 1.0).sqrt();
                let got = alm[(l, m)];
                assert!((got - expected).norm() <= tolerance, "{p}, ({l}, {m}): {got} {expected}");
            }
        }
    }
}

#[test]
fn it_satisfies_the_addition_theorem_to_rounding() {
    // sum_m |Y_lm|^2 = (2l + 1)/(4 pi)
    for p in Lcg::new(5).directions(1).into_iter().chain([DVec3::new(1e-9, 0.0, -1.0), DVec3::Y]) {
        let energies = Definition::new(&[p]).adjoint(None, 2048).energy_per_degree();
        for (l, energy) in energies.into_iter().enumerate() {
            let expected = (2 * l + 1) as f64 / (4.0 * PI);
            // Independent rounding errors of the terms and of the sum by `energy_per_degree`.
            let tolerance = 4.0 * f64::EPSILON * (l as f64 + 1.0).sqrt() * expected;
            assert!((energy - expected).abs() <= tolerance, "{p}, l = {l}: {energy} {expected}");
        }
    }
}
