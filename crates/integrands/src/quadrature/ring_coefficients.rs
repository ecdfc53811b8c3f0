//! Coefficients from the Fourier coefficients of a function on rings.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex;
use sphvar_nufft::parts::{Fft, FftDirection, Real, good_size};
use sphvar_nufft::{CircleTransform, CircleWorkspace};
use sphvar_sh::{Colatitude, Domain};
use sphvar_sht::{RingTransform, RingWorkspace};

use super::rings::{Longitudes, Rings, candidate_axes, orders};
use super::{EPSILON, EvalInto};
use crate::shape::{Fold, Shape};
use crate::{Coefficients, Error};

/// The values that are taken together, at least.
const BATCH: usize = 1 << 16;
/// The products of Legendre functions with values on rings that take as long as a value of a simple
/// function.
const LEGENDRE_PER_VALUE: f64 = 100.0;
/// The largest number of such products of energies, about a second.
const MAX_LEGENDRE: f64 = 4e9;
/// The degree to which energies are computed in any case.
const MIN_AFFORDABLE: usize = 256;
/// The share of the square of the function below which an order is rounding.
const NEGLIGIBLE: f64 = 1e-31;

/// Returns the coefficients to degree `lmax` of the function itself on the domain, not of an even
/// extension.
///
/// On every ring between its edges, the function is resolved by its own degree; rings that edges
/// intersect have nodes between these for all orders. Only orders that carry more than rounding are
/// transformed, so a function that is smooth around the axis of the rings takes time proportional to
/// lmax^2 instead of lmax^3.
pub(super) fn coefficients(
    shape: &Shape,
    domain: Domain,
    lmax: usize,
    eval_into: &EvalInto<'_>,
) -> Result<Coefficients, Error> {
    let rings = rings(shape, domain, lmax)?;
    let nodes = rings.coefficient_work(ring_degree(shape, lmax), lmax).nodes;
    rings.check_cost(nodes, shape.cost())?;
    let spectra = Spectra::new(&rings, shape, lmax, eval_into)?;
    let mut columns = Vec::new();
    let carried = spectra.carried_orders();
    let Some(&last) = carried.last() else {
        return Coefficients::zonal(rings.axis(), vec![0.0; lmax + 1]);
    };
    let fourier = |m: usize, values: &mut [Complex<f64>]| {
        let is_carried = carried.binary_search(&m).is_ok();
        if is_carried {
            spectra.write_order(m, values);
        }
        is_carried
    };
    RingTransform::new(lmax)?.adjoint_by_order(
        spectra.colatitudes.iter().copied(),
        last,
        fourier,
        &mut RingWorkspace::default(),
        |m, column| columns.push((m, column.to_vec())),
    );
    Ok(Coefficients::in_frame(rings.frame(), lmax, columns))
}

/// Returns the largest degree up to `lmax` to which the coefficients of a function on a domain take
/// moderate time; at least 256.
pub(crate) fn affordable_degree(shape: &Shape, domain: Domain, lmax: usize) -> usize {
    let domain = if shape.fold(domain) == Fold::Cut { domain } else { Domain::Sphere };
    let work = |degree: usize| {
        let rings = rings(shape, domain, degree)?;
        let work = rings.coefficient_work(ring_degree(shape, degree), degree);
        Ok::<_, Error>(if rings.is_zonal() { 0.0 } else { work.legendre })
    };
    let mut degree = lmax;
    while degree > MIN_AFFORDABLE && !work(degree).is_ok_and(|work| work <= MAX_LEGENDRE) {
        degree = (degree - degree / 8).max(MIN_AFFORDABLE);
    }
    degree
}

/// Returns the degree that resolves a function on rings without edges. Powers at an edge that is
/// close to a ring have none.
fn ring_degree(shape: &Shape, lmax: usize) -> usize {
    if shape.is_fractional() { shape.degree() + lmax } else { shape.degree() }
}

/// Returns the rings of the least work.
fn rings(shape: &Shape, domain: Domain, lmax: usize) -> Result<Rings, Error> {
    let mut best: Option<(f64, Rings)> = None;
    for axis in candidate_axes(shape) {
        let rings = Rings::unchecked(axis, shape, domain, shape.degree() + lmax)?;
        let work = rings.coefficient_work(ring_degree(shape, lmax), lmax);
        let total = work.legendre + LEGENDRE_PER_VALUE * shape.cost() * work.nodes;
        if best.as_ref().is_none_or(|(least, _)| total < *least) {
            best = Some((total, rings));
        }
    }
    let unknown = Error::NoEnergy { reason: "its shape has no axis" };
    best.map(|(_, rings)| rings).ok_or(unknown)
}

/// The Fourier coefficients `int f e^{-i m phi} dphi` on rings, times the weights of the rings.
struct Spectra {
    lmax: usize,
    colatitudes: Vec<Colatitude>,
    weights: Vec<f64>,
    /// Of ring r from order 0 on, from the r-th start on.
    values: Vec<Complex<f64>>,
    starts: Vec<usize>,
}

/// A ring whose values are not known yet.
struct Pending {
    weight: f64,
    /// The number of Fourier coefficients.
    len: usize,
    nodes: Nodes,
}

enum Nodes {
    Equidistant(usize),
    /// Longitudes in turns, with weights.
    Places(Vec<(f64, f64)>),
}

impl Nodes {
    fn len(&self) -> usize {
        match self {
            Self::Equidistant(n) => *n,
            Self::Places(places) => places.len(),
        }
    }
}

impl Spectra {
    fn new(
        rings: &Rings,
        shape: &Shape,
        lmax: usize,
        eval_into: &EvalInto<'_>,
    ) -> Result<Self, Error> {
        let mut spectra = Self {
            lmax,
            colatitudes: Vec::new(),
            weights: Vec::new(),
            values: Vec::new(),
            starts: vec![0],
        };
        let mut fourier = Fourier::default();
        let (mut pending, mut dirs, mut values) = (Vec::new(), Vec::new(), Vec::new());
        let mut flush = |spectra: &mut Self, dirs: &mut Vec<DVec3>, pending: &mut Vec<Pending>| {
            values.resize(dirs.len(), 0.0);
            eval_into(dirs, &mut values)?;
            let mut rest = &mut values[..];
            for ring in pending.drain(..) {
                let (own, others) = rest.split_at_mut(ring.nodes.len());
                rest = others;
                spectra.add(&ring, own, &mut fourier)?;
            }
            dirs.clear();
            Ok::<_, Error>(())
        };
        rings.for_each_ring(ring_degree(shape, lmax), |theta, weight, longitudes| {
            let (nodes, max_order) = match longitudes {
                Longitudes::Whole(max_order) => {
                    let n = good_size(2.0 * max_order + 2.0, 1.25);
                    let longitude = |j: usize| TAU * (j as f64 + 0.5) / n as f64;
                    dirs.extend((0..n).map(|j| rings.direction(theta, longitude(j))));
                    (Nodes::Equidistant(n), max_order)
                }
                Longitudes::Pieces(nodes) => {
                    dirs.extend(nodes.iter().map(|&(phi, _)| rings.direction(theta, phi)));
                    let turns = |&(phi, w): &(f64, f64)| ((phi / TAU).rem_euclid(1.0).fract(), w);
                    (Nodes::Places(nodes.iter().map(turns).collect()), orders(lmax, theta))
                }
            };
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "an order, not negative"
            )]
            let len = (max_order as usize).min(lmax) + 1;
            spectra.colatitudes.push(Colatitude::from_theta(theta.clamp(0.0, PI))?);
            pending.push(Pending { weight, len, nodes });
            if dirs.len() >= BATCH { flush(&mut spectra, &mut dirs, &mut pending) } else { Ok(()) }
        })?;
        flush(&mut spectra, &mut dirs, &mut pending)?;
        Ok(spectra)
    }

    fn add(&mut self, ring: &Pending, values: &[f64], fourier: &mut Fourier) -> Result<(), Error> {
        match &ring.nodes {
            Nodes::Equidistant(n) => {
                let buffer = fourier.of_equidistant(*n, values);
                let step = TAU / *n as f64;
                self.values.extend((0..ring.len).map(|m| {
                    // The first node is half a step from the origin.
                    buffer[m] * Complex::from_polar(ring.weight * step, -0.5 * step * m as f64)
                }));
            }
            Nodes::Places(places) => {
                let out = fourier.of_places(ring.len - 1, places, values)?;
                self.values.extend(out[..ring.len].iter().map(|c| c * ring.weight));
            }
        }
        self.starts.push(self.values.len());
        self.weights.push(ring.weight);
        Ok(())
    }

    /// Returns the orders whose coefficients exceed rounding: all if some are infinite or NaN.
    fn carried_orders(&self) -> Vec<usize> {
        // Relative to the largest one, so that no square overflows or underflows.
        let size = |c: &Complex<f64>| c.re.abs().max(c.im.abs());
        let largest = self.values.iter().map(size).fold(0.0, f64::max);
        let mut squares = vec![0.0; self.lmax + 1];
        for (ends, weight) in self.starts.windows(2).zip(&self.weights) {
            if *weight > 0.0 {
                for (square, c) in squares.iter_mut().zip(&self.values[ends[0]..ends[1]]) {
                    *square += (c / largest).norm_sqr() / weight;
                }
            }
        }
        let total: f64 = squares.iter().sum();
        let is_rounding = |m: &usize| largest == 0.0 || squares[*m] <= NEGLIGIBLE * total;
        (0..squares.len()).filter(|m| !is_rounding(m)).collect()
    }

    /// Writes the coefficients of an order on every ring.
    fn write_order(&self, m: usize, out: &mut [Complex<f64>]) {
        for (out, ends) in out.iter_mut().zip(self.starts.windows(2)) {
            *out = self.values[ends[0]..ends[1]].get(m).copied().unwrap_or(Complex::ZERO);
        }
    }
}

/// Fourier transforms of rings, by their size.
#[derive(Default)]
struct Fourier {
    plans: BTreeMap<usize, Arc<dyn Fft<f64>>>,
    buffer: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
    circles: BTreeMap<usize, CircleTransform>,
    workspace: CircleWorkspace,
    points: Vec<f64>,
    weights: Vec<f64>,
}

impl Fourier {
    /// Returns `sum_j f_j e^{-2 pi i m j/n}`.
    fn of_equidistant(&mut self, n: usize, values: &[f64]) -> &[Complex<f64>] {
        let plan =
            self.plans.entry(n).or_insert_with(|| f64::fourier_plan(n, FftDirection::Forward));
        self.buffer.clear();
        self.buffer.extend(values.iter().map(|&value| Complex::new(value, 0.0)));
        self.scratch.resize(plan.get_inplace_scratch_len(), Complex::ZERO);
        plan.process_with_scratch(&mut self.buffer, &mut self.scratch);
        &self.buffer
    }

    /// Returns `sum_j w_j f_j e^{-2 pi i m u_j}` for orders to `max_order` or beyond.
    fn of_places(
        &mut self,
        max_order: usize,
        places: &[(f64, f64)],
        values: &[f64],
    ) -> Result<&[Complex<f64>], Error> {
        // Eight sizes per octave, so that plans are few.
        let step = (max_order.next_power_of_two() / 16).max(16);
        let kmax = max_order.next_multiple_of(step);
        let failed = |_| Error::NoEnergy { reason: "values on a ring are not finite or too many" };
        if let Entry::Vacant(place) = self.circles.entry(kmax) {
            place.insert(CircleTransform::new(kmax, EPSILON).map_err(failed)?);
        }
        self.points.clear();
        self.points.extend(places.iter().map(|place| place.0));
        self.weights.clear();
        self.weights.extend(places.iter().zip(values).map(|(place, value)| place.1 * value));
        self.buffer.resize(kmax + 1, Complex::ZERO);
        let (points, weights) = (&self.points[..], Some(&self.weights[..]));
        let out = &mut self.buffer[..=kmax];
        self.circles[&kmax]
            .adjoint_into(points, weights, &mut self.workspace, out)
            .map_err(failed)?;
        Ok(&self.buffer)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};
    use sphvar_sh::{Alm, Domain};

    use super::affordable_degree;
    use crate::quadrature::{coefficients_of_nodes, for_each_value, rings::Rings};
    use crate::{
        Cap, ClampedCosine, Coefficients, Error, Integrand, PhongLobe, Product, Rotated,
        VonMisesFisher,
    };

    /// The definition: a sum over the nodes of a quadrature for the degree.
    fn by_nodes(f: &dyn Integrand, domain: Domain, lmax: usize) -> Result<Alm, Error> {
        let shape = f.shape()?;
        let rings = Rings::new(&shape, domain, shape.degree() + lmax)?;
        let values = |dirs: &[DVec3], values: &mut [f64]| f.eval_into(dirs, values);
        let part = coefficients_of_nodes(lmax, |add| {
            for_each_value(&rings, &values, |dir, w, f| add(dir, w * f))
        })?;
        let part = if domain == Domain::Sphere { part } else { part.even_extension() };
        part.to_alm()
    }

    fn tilted<I: Integrand>(function: I, degrees: f64) -> Rotated<I> {
        let axis = DVec3::new(0.6, -0.8, 0.0);
        Rotated::new(function, DQuat::from_axis_angle(axis, degrees.to_radians())).unwrap()
    }

    fn cap(degrees: f64) -> Cap {
        Cap::from_degrees(degrees).unwrap()
    }

    /// Against the definition, for edges that do not meet, cross, touch each other or a pole, contain
    /// each other, and nearly agree; in degrees that the functions resolve and beyond.
    #[test]
    fn coefficients_from_rings_are_those_of_nodes() {
        let cosine = ClampedCosine;
        let lobe = |kappa: f64| VonMisesFisher::new(kappa).unwrap();
        let phong = PhongLobe::new(2.5).unwrap();
        let functions: Vec<(&str, Box<dyn Integrand>)> = vec![
            ("above the horizon", Box::new(Product::new(tilted(cap(25.0), 30.0), cosine))),
            ("across the horizon", Box::new(Product::new(tilted(cap(25.0), 80.0), cosine))),
            ("touching the horizon", Box::new(Product::new(tilted(cap(25.0), 65.0), cosine))),
            ("through a pole", Box::new(Product::new(tilted(cap(40.0), 40.0), cap(70.0)))),
            ("crossing caps", Box::new(Product::new(tilted(cap(50.0), 60.0), cap(40.0)))),
            ("a cap in a cap", Box::new(Product::new(tilted(cap(10.0), 5.0), cap(40.0)))),
            ("nearly equal caps", Box::new(Product::new(tilted(cap(35.0), 1e-7), cap(35.0)))),
            ("great circles", Box::new(Product::new(tilted(cap(90.0), 90.0), cap(90.0)))),
            ("a narrow lobe", Box::new(Product::new(tilted(lobe(400.0), 70.0), cosine))),
            ("a wide lobe", Box::new(Product::new(tilted(lobe(3.0), 20.0), tilted(cosine, 50.0)))),
            ("powers at an edge", Box::new(Product::new(tilted(phong, 45.0), cosine))),
        ];
        for (name, f) in functions {
            for (domain, lmax) in [(Domain::Sphere, 90), (Domain::Hemisphere, 40)] {
                let got = f.coefficients(domain, lmax).unwrap();
                let expected = by_nodes(&*f, domain, lmax).unwrap();
                let size = expected.energy_per_degree().iter().sum::<f64>().sqrt();
                let alm = got.to_alm().unwrap();
                let errors =
                    alm.values().iter().zip(expected.values()).map(|(a, b)| (a - b).norm());
                let error = errors.fold(0.0, f64::max) / size;
                assert!(error < 2e-12, "{name}, {domain}: {error:e}");
                // Without a rotation.
                let energies = got.energy_per_degree().unwrap();
                for (e, of_nodes) in energies.iter().zip(expected.energy_per_degree()) {
                    let error = (e.sqrt() - of_nodes.sqrt()).abs() / size;
                    assert!(error < 1e-12, "{name}, {domain}: {error:e}");
                }
            }
        }
    }

    /// Sums of parts in frames of their own and of zonal parts, against coefficients of all orders.
    #[test]
    fn parts_in_other_frames_combine() {
        let domain = Domain::Sphere;
        let of = |f: &dyn Integrand| f.coefficients(domain, 24).unwrap();
        let first = of(&Product::new(tilted(cap(25.0), 30.0), ClampedCosine));
        let second = of(&Product::new(tilted(cap(10.0), 5.0), cap(40.0)));
        let zonal = of(&tilted(cap(60.0), 110.0));
        let general = |c: &Coefficients| Coefficients::general(c.to_alm().unwrap());
        let rotation = glam::DMat3::from_quat(DQuat::from_rotation_y(0.3));
        let sums = [
            first.clone().plus(-0.7, &zonal).unwrap(),
            first.clone().plus(2.0, &second).unwrap().plus(0.3, &zonal).unwrap(),
            first.clone().plus(0.5, &first).unwrap().even_part(),
            general(&first).plus(1.5, &second).unwrap(),
            zonal.plus(1.0, &second).unwrap().rotated(rotation).unwrap(),
        ];
        for (i, sum) in sums.iter().enumerate() {
            let whole = general(sum);
            let near = |a: &[f64], b: &[f64]| {
                a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-13) && a.len() == b.len()
            };
            let energies = sum.energy_per_degree().unwrap();
            assert!(near(&energies, &whole.energy_per_degree().unwrap()), "{i}");
            assert!((sum.mean() - whole.mean()).abs() < 1e-14, "{i}");
            for other in &sums {
                let inner = sum.inner_per_degree(other).unwrap();
                let expected = whole.inner_per_degree(&general(other)).unwrap();
                assert!(near(&inner, &expected), "{i}: {inner:?}, {expected:?}");
            }
            let at = DVec3::new(0.48, 0.6, 0.64);
            let (values, expected) = (sum.values_per_degree(at), whole.values_per_degree(at));
            assert!(near(&values.unwrap(), &expected.unwrap()), "{i}");
        }
    }

    #[test]
    fn energies_of_crossing_edges_end_at_an_affordable_degree() {
        let crossing = Product::new(tilted(cap(80.0), 60.0), ClampedCosine);
        let shape = crossing.shape().unwrap();
        let degree = affordable_degree(&shape, Domain::Sphere, 12_288);
        assert!((1000..6000).contains(&degree), "{degree}");
        assert_eq!(affordable_degree(&shape, Domain::Sphere, 300), 300);
        let apart = Product::new(tilted(cap(25.0), 30.0), ClampedCosine);
        assert_eq!(apart.energy_degree(Domain::Sphere, 12_288), 12_288);
        let energy = apart.energy(Domain::Sphere, 3000).unwrap();
        // A jump of the mean square m along a circle of length c has the energy m c/(pi l) beyond
        // degree l.
        let mean_square = (30f64.to_radians().cos() * 25f64.to_radians().cos()).powi(2)
            + 0.5 * (30f64.to_radians().sin() * 25f64.to_radians().sin()).powi(2);
        let length = std::f64::consts::TAU * 25f64.to_radians().sin();
        let beyond = energy.beyond(2500);
        let expected = mean_square * length / (std::f64::consts::PI * 2500.0);
        assert!((beyond / expected - 1.0).abs() < 0.01, "{beyond:e}, {expected:e}");
    }
}
