//! Integrals over the sphere or the hemisphere of functions whose shape is known.

mod panel_rule;
mod rings;

use glam::DVec3;
use sphvar_samplers::Domain;
use sphvar_sh::{Alm, Colatitude, LegendrePlan};
use sphvar_sht::{Method, Transform, TransformWorkspace};

use crate::shape::{Fold, Shape};
use crate::{Coefficients, Error};
pub(crate) use panel_rule::node_count;
use rings::Rings;

/// Nodes that are transformed at a time, at least; as many as fill the memory of the transform if that is more.
const BATCH: usize = 1 << 20;
/// The accuracy of transforms, relative to the coefficients of the absolute values.
const EPSILON: f64 = 1e-13;

/// The integral over the domain of `power` of a function, 1 or 2.
fn moment(
    shape: &Shape,
    domain: Domain,
    power: i32,
    eval: &dyn Fn(DVec3) -> f64,
) -> Result<f64, Error> {
    let degree = shape.degree() * power.unsigned_abs() as usize;
    // The integral over the hemisphere of an even function is half of that over the sphere.
    let (domain, factor) = match shape.fold(domain) {
        Fold::Even => (Domain::Sphere, 0.5),
        Fold::Above => (Domain::Sphere, 1.0),
        Fold::Whole | Fold::Cut => (domain, 1.0),
    };
    let mut sum = Sum::default();
    Rings::new(shape, domain, degree)?.for_each(|dir, w| sum.add(w * eval(dir).powi(power)))?;
    Ok(factor * sum.value())
}

/// `int f` over the domain.
pub(crate) fn integral(
    shape: &Shape,
    domain: Domain,
    eval: &dyn Fn(DVec3) -> f64,
) -> Result<f64, Error> {
    moment(shape, domain, 1, eval)
}

/// `int F^2` over the sphere, of the even extension on the hemisphere.
pub(crate) fn square(
    shape: &Shape,
    domain: Domain,
    eval: &dyn Fn(DVec3) -> f64,
) -> Result<f64, Error> {
    let copies = if domain == Domain::Sphere { 1.0 } else { 2.0 };
    Ok(copies * moment(shape, domain, 2, eval)?)
}

/// The coefficients of F to degree `lmax`.
pub(crate) fn coefficients(
    shape: &Shape,
    domain: Domain,
    lmax: usize,
    eval: &dyn Fn(DVec3) -> f64,
) -> Result<Coefficients, Error> {
    let fold = shape.fold(domain);
    let domain = if fold == Fold::Cut { domain } else { Domain::Sphere };
    let rings = Rings::new(shape, domain, shape.degree() + lmax)?;
    let part = if rings.is_zonal() {
        let plan = LegendrePlan::new(lmax)?;
        let mut column = vec![0.0; lmax + 1];
        let mut sums = vec![0.0; lmax + 1];
        rings.for_each_colatitude(|theta, w| {
            let value = w * eval(rings.direction(theta, 0.0));
            if let Ok(colatitude) = Colatitude::from_theta(theta)
                && value != 0.0
            {
                plan.column_into(0, colatitude, &mut column);
                sums.iter_mut().zip(&column).for_each(|(s, lambda)| *s += value * lambda);
            }
        })?;
        Coefficients::zonal(rings.axis(), sums)?
    } else {
        let mut batches = Batches::new(lmax)?;
        let mut failure = Ok(());
        rings.for_each(|dir, w| {
            if failure.is_ok() {
                failure = batches.push(dir, w * eval(dir));
            }
        })?;
        failure?;
        Coefficients::general(batches.finish()?)
    };
    Ok(match fold {
        Fold::Whole => part,
        Fold::Even => part.even_part(),
        Fold::Above | Fold::Cut => part.even_extension(),
    })
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

/// A sum with the rounding of its terms carried along (Neumaier 1974): millions of nodes are added.
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
