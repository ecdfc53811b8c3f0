//! Integrals over the sphere or the hemisphere of functions whose shape is known.

mod adaptive;
mod doubling;
mod estimates;
mod finite_values;
mod panel_rule;
mod product_rule;
mod ring_coefficients;
mod rings;

use std::f64::consts::PI;

use glam::DVec3;
use sphvar_sh::Domain;
use sphvar_sh::{Alm, ByParity, Colatitude, LegendrePlan};
use sphvar_sht::{Method, Transform, TransformWorkspace};

use crate::shape::{Fold, Shape};
use crate::{Coefficients, Error};
pub(crate) use adaptive::{AdaptiveCells, Cell, Patch, PatchNode};
pub(crate) use doubling::{Estimate, FIRST_NODES, doubled};
pub(crate) use estimates::{Estimates, MAX_FEATURE_DEGREE, exact_energy};
pub(crate) use finite_values::{finite_values, finite_values_at};
pub(crate) use panel_rule::node_count;
pub(crate) use ring_coefficients::affordable_degree;
use rings::Rings;

/// Minimum number of nodes per transform; the actual number fills the memory of the transform if
/// that is larger.
const BATCH: usize = 1 << 20;
/// The accuracy of transforms, relative to the coefficients of the absolute values.
const EPSILON: f64 = 1e-13;

/// See [`Integrand::eval_into`](crate::Integrand::eval_into).
pub(crate) type EvalInto<'a> = dyn Fn(&[DVec3], &mut [f64]) -> Result<(), Error> + 'a;

/// `int f` over the domain.
pub(crate) fn integral(
    shape: &Shape,
    domain: Domain,
    eval_into: &EvalInto<'_>,
) -> Result<f64, Error> {
    // The integral over the hemisphere of an even function is half of that over the sphere.
    let (domain, factor) = match shape.fold(domain) {
        Fold::Even => (Domain::Sphere, 0.5),
        Fold::Above => (Domain::Sphere, 1.0),
        Fold::Whole | Fold::Cut => (domain, 1.0),
    };
    let rings = Rings::new(shape, domain, shape.degree())?;
    Ok(factor * sum(&rings, eval_into, |f| f)?)
}

/// Returns the integral of a function of the values of a function of the shape of the rings.
fn sum(
    rings: &Rings,
    eval_into: &EvalInto<'_>,
    of_value: impl Fn(f64) -> f64,
) -> Result<f64, Error> {
    let mut sum = Sum::default();
    for_each_value(rings, eval_into, |_, w, f| sum.add(w * of_value(f)))?;
    Ok(sum.value())
}

/// Calls `action` with direction, weight and value of every node.
fn for_each_value(
    rings: &Rings,
    eval_into: &EvalInto<'_>,
    mut action: impl FnMut(DVec3, f64, f64),
) -> Result<(), Error> {
    let mut values = Vec::new();
    rings.for_each_batch(|dirs, weights| {
        values.resize(dirs.len(), 0.0);
        eval_into(dirs, &mut values)?;
        dirs.iter().zip(weights).zip(&values).for_each(|((&dir, &w), &f)| action(dir, w, f));
        Ok(())
    })
}

/// `int (F - mean)^2` over the sphere of the even and the odd part of F, which is the even
/// extension on the hemisphere.
///
/// Means are subtracted and parts formed value by value, so vanishing parts leave only the square
/// of the rounding error.
pub(crate) fn centred_square(
    shape: &Shape,
    domain: Domain,
    eval_into: &EvalInto<'_>,
) -> Result<ByParity, Error> {
    let even = |even: f64| ByParity { even, odd: 0.0 };
    let variation = |domain, area| variation(shape, domain, area, eval_into);
    let hemisphere = Domain::Hemisphere.area();
    Ok(match shape.fold(domain) {
        Fold::Even => even(variation(Domain::Sphere, 4.0 * PI)?),
        Fold::Whole if shape.is_even() => even(variation(domain, 4.0 * PI)?),
        Fold::Above => even(2.0 * variation(Domain::Sphere, hemisphere)?),
        Fold::Cut => even(2.0 * variation(domain, hemisphere)?),
        Fold::Whole if shape.is_apart_from(&shape.mirrored()) => {
            // Both parts have half the values here and half the values, up to the sign, at the
            // antipodes.
            let rings = Rings::new(shape, domain, 2 * shape.degree())?;
            let odd = sum(&rings, eval_into, |f| 0.5 * f.powi(2))?;
            ByParity { even: 0.5 * variation(domain, 2.0 * PI)?, odd }
        }
        Fold::Whole => {
            let mean = integral(shape, domain, eval_into)? / (4.0 * PI);
            let rings = Rings::new(&shape.symmetrized(), domain, 2 * shape.degree())?;
            let mut sums = [Sum::default(); 2];
            let (mut here, mut there, mut antipodes) = (Vec::new(), Vec::new(), Vec::new());
            rings.for_each_batch(|dirs, weights| {
                antipodes.clear();
                antipodes.extend(dirs.iter().map(|&dir| -dir));
                for (dirs, values) in [(dirs, &mut here), (&antipodes, &mut there)] {
                    values.resize(dirs.len(), 0.0);
                    eval_into(dirs, values)?;
                }
                for ((w, here), there) in weights.iter().zip(&here).zip(&there) {
                    let (here, there) = (here - mean, there - mean);
                    sums[0].add(w * (0.5 * (here + there)).powi(2));
                    sums[1].add(w * (0.5 * (here - there)).powi(2));
                }
                Ok(())
            })?;
            ByParity { even: sums[0].value(), odd: sums[1].value() }
        }
    })
}

/// Returns `int (f - mean)^2` over a region of the given area that contains the support of f.
fn variation(
    shape: &Shape,
    domain: Domain,
    area: f64,
    eval_into: &EvalInto<'_>,
) -> Result<f64, Error> {
    /// The relative rounding error of the total area of the rings.
    const ROUNDING: f64 = 1e-13;
    let rings = Rings::new(shape, domain, 2 * shape.degree())?;
    let (mut integral, mut covered) = (Sum::default(), Sum::default());
    for_each_value(&rings, eval_into, |_, w, f| {
        integral.add(w * f);
        covered.add(w);
    })?;
    let mean = integral.value() / area;
    let beyond = 1.0 - covered.value() / area;
    // Rings about an axis other than that of the support may cover more than the region.
    let beyond = if beyond.abs() > ROUNDING { beyond * area } else { 0.0 };
    Ok(sum(&rings, eval_into, |f| (f - mean).powi(2))? + mean * mean * beyond)
}

/// Maximum number of nodes for a kurtosis, some hundredths of a second.
const KURTOSIS_NODES: f64 = 1e6;

/// Returns the kurtosis of the value of a function at a uniformly distributed direction of the
/// domain; `None` for a constant, and if it would take more than a million values.
pub(crate) fn kurtosis(shape: &Shape, domain: Domain, eval_into: &EvalInto<'_>) -> Option<f64> {
    let rings = Rings::new(shape, domain, 4 * shape.degree()).ok()?;
    if rings.cost() > KURTOSIS_NODES {
        return None;
    }
    let (mut dirs, mut weights) = (Vec::new(), Vec::new());
    let mut add = |dir, w| {
        dirs.push(dir);
        weights.push(w);
    };
    if rings.is_zonal() {
        rings.for_each_colatitude(|theta, w| add(rings.direction(theta, 0.0), w)).ok()?;
    } else {
        rings.for_each(add).ok()?;
    }
    let mut values = vec![0.0; dirs.len()];
    eval_into(&dirs, &mut values).ok()?;
    // The function is 0 beyond its support, which the nodes omit; their weights are rounded.
    let beyond = domain.area() - weights.iter().sum::<f64>();
    if beyond > 1e-12 * domain.area() {
        weights.push(beyond);
        values.push(0.0);
    }
    weighted_kurtosis(|| weights.iter().copied().zip(values.iter().copied()))
}

/// [`kurtosis`] of a function whose shape is unknown or too complicated, from its values on a grid
/// of half a million places: features smaller than a third of a degree may be missed.
pub(crate) fn kurtosis_of_values(
    shape: Option<&Shape>,
    domain: Domain,
    eval_into: &EvalInto<'_>,
) -> Option<f64> {
    const ROWS: usize = 512;
    if let Some(kurtosis) = shape.and_then(|shape| kurtosis(shape, domain, eval_into)) {
        return Some(kurtosis);
    }
    let rows = if domain == Domain::Sphere { ROWS } else { ROWS / 2 };
    let angle = |k: usize| PI * (k as f64 + 0.5) / ROWS as f64;
    let longitudes: Vec<(f64, f64)> = (0..2 * ROWS).map(|j| angle(j).sin_cos()).collect();
    let rings: Vec<(f64, f64)> = (0..rows).map(|i| angle(i).sin_cos()).collect();
    let row = |&(st, ct): &(f64, f64)| {
        longitudes.iter().map(move |(sp, cp)| DVec3::new(st * cp, st * sp, ct))
    };
    let dirs: Vec<DVec3> = rings.iter().flat_map(row).collect();
    let mut values = vec![0.0; dirs.len()];
    eval_into(&dirs, &mut values).ok()?;
    let weight = |k: usize| rings[k / longitudes.len()].0;
    weighted_kurtosis(|| values.iter().enumerate().map(|(k, &value)| (weight(k), value)))
}

/// Returns the kurtosis of values with weights, `None` if they are all the same or not finite.
pub(crate) fn weighted_kurtosis<I: Iterator<Item = (f64, f64)>>(
    values: impl Fn() -> I,
) -> Option<f64> {
    let (total, first) = values().fold((0.0, 0.0), |(t, s), (w, x)| (t + w, s + w * x));
    let mean = first / total;
    let largest = values().fold(0.0, |max: f64, (_, x)| max.max((x - mean).abs()));
    let square = |x: f64| ((x - mean) / largest).powi(2);
    let (second, fourth) = values()
        .fold((0.0, 0.0), |(s, f), (w, x)| (s + w * square(x), f + w * square(x) * square(x)));
    let is_constant = largest <= 16.0 * f64::EPSILON * mean.abs();
    Some(total * fourth / (second * second)).filter(|k| k.is_finite() && !is_constant)
}

/// Returns the coefficients of F to degree `lmax`.
pub(crate) fn coefficients(
    shape: &Shape,
    domain: Domain,
    lmax: usize,
    eval_into: &EvalInto<'_>,
) -> Result<Coefficients, Error> {
    let fold = shape.fold(domain);
    let domain = if fold == Fold::Cut { domain } else { Domain::Sphere };
    let about = |axis| Rings::unchecked(axis, shape, domain, shape.degree() + lmax);
    let part = match shape.axis().map(about).transpose()?.filter(Rings::is_zonal) {
        Some(rings) => {
            rings.check_cost(rings.cost(), shape.cost())?;
            zonal_coefficients(&rings, lmax, eval_into)?
        }
        None => ring_coefficients::coefficients(shape, domain, lmax, eval_into)?,
    };
    Ok(match fold {
        Fold::Whole => part,
        Fold::Even => part.even_part(),
        Fold::Above | Fold::Cut => part.even_extension(),
    })
}

/// Returns the coefficients of a function that is constant on rings.
fn zonal_coefficients(
    rings: &Rings,
    lmax: usize,
    eval_into: &EvalInto<'_>,
) -> Result<Coefficients, Error> {
    let mut sums = ZonalSums::new(lmax)?;
    let mut nodes = Vec::new();
    rings.for_each_colatitude(|theta, w| nodes.push((theta, w)))?;
    let dirs: Vec<DVec3> = nodes.iter().map(|&(theta, _)| rings.direction(theta, 0.0)).collect();
    let mut values = vec![0.0; dirs.len()];
    eval_into(&dirs, &mut values)?;
    for ((theta, w), value) in nodes.into_iter().zip(values) {
        if let Ok(colatitude) = Colatitude::from_theta(theta) {
            sums.add(colatitude, w * value);
        }
    }
    Coefficients::zonal(rings.axis(), sums.sums)
}

/// Calls a function with every direction of a rule and the weight times the value there.
type Nodes<'a> = dyn FnMut(DVec3, f64) + 'a;

/// Returns the coefficients to degree `lmax` of the function whose weighted values `for_each`
/// enumerates.
pub(crate) fn coefficients_of_nodes(
    lmax: usize,
    for_each: impl FnOnce(&mut Nodes<'_>) -> Result<(), Error>,
) -> Result<Coefficients, Error> {
    let mut batches = Batches::new(lmax)?;
    let mut failure = Ok(());
    for_each(&mut |dir, weighted| {
        if failure.is_ok() {
            failure = batches.push(dir, weighted);
        }
    })?;
    failure?;
    Ok(Coefficients::general(batches.finish()?))
}

/// Returns the coefficients of a function of z alone; weights include the length of the ring.
pub(crate) fn zonal_coefficients_of_nodes(
    lmax: usize,
    for_each: impl FnOnce(&mut Nodes<'_>) -> Result<(), Error>,
) -> Result<Coefficients, Error> {
    let mut sums = ZonalSums::new(lmax)?;
    for_each(&mut |dir, weighted| sums.add(Colatitude::from_direction(dir), weighted))?;
    Coefficients::zonal(DVec3::Z, sums.sums)
}

/// Sums of `Y_l0` of weighted colatitudes.
struct ZonalSums {
    plan: LegendrePlan,
    column: Vec<f64>,
    sums: Vec<f64>,
}

impl ZonalSums {
    fn new(lmax: usize) -> Result<Self, Error> {
        let zeros = vec![0.0; lmax + 1];
        Ok(Self { plan: LegendrePlan::new(lmax)?, column: zeros.clone(), sums: zeros })
    }

    fn add(&mut self, colatitude: Colatitude, value: f64) {
        if value != 0.0 {
            self.plan.column_into(0, colatitude, &mut self.column);
            self.sums.iter_mut().zip(&self.column).for_each(|(s, lambda)| *s += value * lambda);
        }
    }
}

/// Sums of coefficients of weighted points.
struct Batches {
    points: Vec<DVec3>,
    weights: Vec<f64>,
    workspace: TransformWorkspace,
    batch: Alm,
    sum: Alm,
}

impl Batches {
    fn new(lmax: usize) -> Result<Self, Error> {
        Ok(Self {
            points: vec![],
            weights: vec![],
            workspace: TransformWorkspace::default(),
            batch: Alm::zeros(lmax)?,
            sum: Alm::zeros(lmax)?,
        })
    }

    fn push(&mut self, dir: DVec3, weight: f64) -> Result<(), Error> {
        if weight != 0.0 {
            self.points.push(dir);
            self.weights.push(weight);
        }
        let degrees = self.sum.lmax() + 1;
        if self.points.len() >= BATCH.max(2 * degrees * degrees) { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), Error> {
        let transform = Transform::new(Method::Auto, self.sum.lmax(), self.points.len(), EPSILON)?;
        transform.adjoint_batch_into(
            &[(&self.points, Some(&self.weights))],
            &mut self.workspace,
            std::slice::from_mut(&mut self.batch),
        );
        for (s, a) in self.sum.values_mut().iter_mut().zip(self.batch.values()) {
            *s += a;
        }
        self.points.clear();
        self.weights.clear();
        Ok(())
    }

    fn finish(mut self) -> Result<Alm, Error> {
        if !self.points.is_empty() {
            self.flush()?;
        }
        Ok(self.sum)
    }
}

/// A compensated sum (Neumaier 1974), because millions of nodes are added.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    sum: f64,
    rest: f64,
}

impl Sum {
    fn add(&mut self, x: f64) {
        let sum = self.sum + x;
        self.rest +=
            if self.sum.abs() >= x.abs() { (self.sum - sum) + x } else { (x - sum) + self.sum };
        self.sum = sum;
    }

    fn value(self) -> f64 {
        self.sum + self.rest
    }
}
