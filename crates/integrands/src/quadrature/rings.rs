use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat3, DVec3};
use sphvar_sh::Domain;

use super::panel_rule::{Ends, PanelRules};
use crate::Error;
use crate::shape::{Circle, Shape, coaxial};

/// Maximum number of nodes of a quadrature, some ten seconds of work.
const MAX_NODES: f64 = 5e7;

/// The number of nodes at which values are taken together.
const BATCH: usize = 1 << 16;

/// Maximum number of pairs of edges of which the crossings are computed; functions with more pairs
/// need more than the maximum number of nodes.
const MAX_PAIRS: usize = 1_000_000;

/// Maximum cost of a quadrature in evaluations of a simple function, some ten seconds.
const MAX_WORK: f64 = 5e8;

const TOO_MANY_NODES: Error = Error::NoEnergy {
    reason: "its values would have to be taken at more than 5e7 places; take wider lobes, lower \
             degrees or fewer factors",
};

/// A quadrature for functions of a given shape over a domain: rings about an axis of the shape,
/// split where they meet its edges.
///
/// Between heights at which an edge begins, ends or crosses another, the integral over a ring is a
/// smooth function of the height, except for square roots where a ring touches an edge. Every panel
/// in colatitude and every piece of a ring therefore has a Gauss-Legendre rule, graded at ends with
/// roots; a ring without edges has equidistant nodes.
pub(super) struct Rings {
    /// From the frame of the rings to that of the function.
    frame: DMat3,
    /// Limits of panels in colatitude.
    breaks: Vec<f64>,
    /// Colatitudes of rings that touch an edge, where the integral over a ring has a root.
    touches: Vec<f64>,
    /// Edges that intersect rings, in the frame of the rings.
    cuts: Vec<Cut>,
    domain: Domain,
    degree: usize,
    zonal: bool,
    /// Whether the function has non-integer powers at its edges.
    fractional: bool,
}

/// The nodes of a ring.
#[derive(Clone, Copy, Debug)]
pub(super) enum Longitudes<'a> {
    /// Equidistant: no edge intersects the ring, and the function has this largest order there.
    Whole(f64),
    /// Longitudes with weights.
    Pieces(&'a [(f64, f64)]),
}

/// The approximate work of coefficients.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CoefficientWork {
    /// The number of values.
    pub(super) nodes: f64,
    /// The number of products of Legendre functions with values on rings.
    pub(super) legendre: f64,
}

/// A circle about another axis than that of the rings.
#[derive(Clone, Copy, Debug)]
struct Cut {
    /// The angle between the axes.
    tilt: f64,
    /// The longitude of the circle's axis.
    longitude: f64,
    angle: f64,
}

impl Cut {
    /// Returns whether the circle is a great circle through both poles, which intersects every ring
    /// at the same longitudes.
    fn is_meridian(self) -> bool {
        let right = |angle: f64| (angle - FRAC_PI_2).abs() < 1e-15;
        right(self.tilt) && right(self.angle)
    }

    /// Returns half the difference of the two longitudes at which the circle intersects the ring at
    /// `theta`, if it does; they are symmetric about that of the axis.
    ///
    /// The angle at the pole of the spherical triangle between pole, axis and point, by half
    /// angles, which avoids cancellation.
    fn half_width(self, theta: f64) -> Option<f64> {
        let half_sin = |x: f64| (0.5 * x).sin();
        let (g, t) = (self.tilt, self.angle);
        let below = half_sin(t + theta - g) * half_sin(t - theta + g);
        let above = half_sin(theta + g + t) * half_sin(theta + g - t);
        (below > 0.0 && above > 0.0).then(|| 2.0 * below.sqrt().atan2(above.sqrt()))
    }
}

impl Rings {
    /// Returns the quadrature for functions of `shape`, as fine as for polynomials of degree
    /// `degree`.
    pub(super) fn new(shape: &Shape, domain: Domain, degree: usize) -> Result<Self, Error> {
        let rings = Self::unchecked(ring_axis(shape), shape, domain, degree)?;
        rings.check_cost(rings.cost(), shape.cost())?;
        Ok(rings)
    }

    /// Returns the quadrature with rings about an axis, whatever the number of its nodes.
    pub(super) fn unchecked(
        axis: DVec3,
        shape: &Shape,
        domain: Domain,
        degree: usize,
    ) -> Result<Self, Error> {
        let frame = frame_about(axis);
        let mut rings = Self {
            frame,
            breaks: vec![0.0, PI],
            touches: vec![],
            cuts: vec![],
            domain,
            degree,
            zonal: shape.axis().is_some_and(|a| coaxial(a, axis).is_some()),
            fractional: shape.is_fractional(),
        };
        for &edge in shape.edges() {
            rings.add_edge(edge);
        }
        let (mut from, mut to) = rings.support(shape.support());
        if domain == Domain::Hemisphere {
            match coaxial(axis, DVec3::Z) {
                Some(sign) if sign > 0.0 => to = f64::min(to, FRAC_PI_2),
                Some(_) => from = f64::max(from, FRAC_PI_2),
                None => {
                    rings.zonal = false;
                    rings.add_edge(Circle::EQUATOR);
                }
            }
        }
        if rings.n_pairs() > MAX_PAIRS {
            return Err(TOO_MANY_NODES);
        }
        rings.add_crossings();
        rings.breaks.iter_mut().for_each(|b| *b = b.clamp(from, to.max(from)));
        rings.breaks.sort_by(f64::total_cmp);
        rings.breaks.dedup_by(|b, a| *b - *a <= 2.0 * f64::EPSILON * *b);
        Ok(rings)
    }

    /// Calls `f` with direction and weight of every node; weights add up to the area of the domain
    /// as far as the function's support goes.
    pub(super) fn for_each(&self, mut f: impl FnMut(DVec3, f64)) -> Result<(), Error> {
        let mut rules = PanelRules::default();
        let mut pieces = PanelRules::default();
        let mut meetings = Vec::new();
        for panel in self.breaks.windows(2) {
            let (from, width) = (panel[0], panel[1] - panel[0]);
            for &(x, w) in rules.rule(self.ends(from, width), self.phase(width))? {
                // Measured from the nearer end, so that nodes stay on their side of a break.
                let theta = from + width * x;
                let weight = w * width * theta.sin();
                self.for_each_on_ring(theta, weight, &mut meetings, &mut pieces, &mut f)?;
            }
        }
        Ok(())
    }

    /// Calls `f` with directions and weights of the nodes, many at once, in the order of
    /// [`for_each`](Self::for_each).
    pub(super) fn for_each_batch(
        &self,
        mut f: impl FnMut(&[DVec3], &[f64]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let (mut dirs, mut weights) = (Vec::new(), Vec::new());
        let mut outcome = Ok(());
        self.for_each(|dir, w| {
            dirs.push(dir);
            weights.push(w);
            if dirs.len() == BATCH {
                if outcome.is_ok() {
                    outcome = f(&dirs, &weights);
                }
                dirs.clear();
                weights.clear();
            }
        })?;
        outcome?;
        f(&dirs, &weights)
    }

    /// The colatitudes of the nodes of a zonal function, with weights that include
    /// `2 pi sin theta`.
    pub(super) fn for_each_colatitude(&self, mut f: impl FnMut(f64, f64)) -> Result<(), Error> {
        let mut rules = PanelRules::default();
        for panel in self.breaks.windows(2) {
            let (from, width) = (panel[0], panel[1] - panel[0]);
            for &(x, w) in rules.rule(self.ends(from, width), self.phase(width))? {
                let theta = from + width * x;
                f(theta, TAU * w * width * theta.sin());
            }
        }
        Ok(())
    }

    /// Returns the behaviour of ring integrals at the ends of a panel. The root of a ring that
    /// touches an edge matters up to a distance of two widths, from where a rule for analytic
    /// functions converges by a factor of 10 per node.
    fn ends(&self, from: f64, width: f64) -> Ends {
        let is_near = |touch: &f64| (from - touch).max(touch - (from + width)) <= 2.0 * width;
        if self.fractional || self.touches.iter().any(is_near) { Ends::Rough } else { Ends::Smooth }
    }

    /// Returns the phase of the fastest oscillation over a panel; `sin theta` of the area adds to
    /// that of the function.
    fn phase(&self, width: f64) -> f64 {
        (self.degree + 2) as f64 * width
    }

    /// Returns the direction at a point in the frame of the rings.
    pub(super) fn direction(&self, theta: f64, phi: f64) -> DVec3 {
        let ((st, ct), (sp, cp)) = (theta.sin_cos(), phi.sin_cos());
        self.frame * DVec3::new(st * cp, st * sp, ct)
    }

    /// Returns the rotation from the frame of the rings, which is about +z, to that of the function.
    pub(super) fn frame(&self) -> DMat3 {
        self.frame
    }

    /// Returns the axis of the rings.
    pub(super) fn axis(&self) -> DVec3 {
        self.frame.z_axis
    }

    /// Returns whether the function is constant on every ring.
    pub(super) fn is_zonal(&self) -> bool {
        self.zonal
    }

    fn for_each_on_ring(
        &self,
        theta: f64,
        weight: f64,
        meetings: &mut Vec<f64>,
        rules: &mut PanelRules,
        f: &mut impl FnMut(DVec3, f64),
    ) -> Result<(), Error> {
        self.find_meetings(theta, meetings);
        let orders = if self.zonal { 0.0 } else { self.orders(theta) };
        if meetings.is_empty() {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative, and at most the degree"
            )]
            let n = (orders + 1.0) as usize;
            if self.is_outside(self.direction(theta, 0.0)) {
                return Ok(());
            }
            for j in 0..n {
                let phi = TAU * (j as f64 + 0.5) / n as f64;
                f(self.direction(theta, phi), weight * TAU / n as f64);
            }
            return Ok(());
        }
        self.for_each_on_pieces(theta, weight, (meetings, rules), |phi, w| {
            f(self.direction(theta, phi), w);
        })
    }

    /// Replaces `meetings` by the longitudes at which edges intersect a ring.
    fn find_meetings(&self, theta: f64, meetings: &mut Vec<f64>) {
        meetings.clear();
        for cut in &self.cuts {
            if let Some(half) = cut.half_width(theta) {
                meetings.push((cut.longitude + half).rem_euclid(TAU));
                meetings.push((cut.longitude - half).rem_euclid(TAU));
            }
        }
    }

    fn is_outside(&self, dir: DVec3) -> bool {
        self.domain == Domain::Hemisphere && dir.z < 0.0
    }

    /// Calls `f` with longitudes and their weights, times `weight`, on the pieces between edges, of
    /// which there are some.
    fn for_each_on_pieces(
        &self,
        theta: f64,
        weight: f64,
        (meetings, rules): (&mut Vec<f64>, &mut PanelRules),
        mut f: impl FnMut(f64, f64),
    ) -> Result<(), Error> {
        let orders = if self.zonal { 0.0 } else { self.orders(theta) };
        meetings.sort_by(f64::total_cmp);
        meetings.push(meetings[0] + TAU);
        let ends = if self.fractional { Ends::Rough } else { Ends::Smooth };
        for piece in meetings.windows(2) {
            let (from, width) = (piece[0], piece[1] - piece[0]);
            if width <= 0.0 || self.is_outside(self.direction(theta, from + 0.5 * width)) {
                continue;
            }
            for &(x, w) in rules.rule(ends, orders * width)? {
                f(from + width * x, weight * w * width);
            }
        }
        Ok(())
    }

    /// Returns the largest order of functions of the degree on a ring.
    fn orders(&self, theta: f64) -> f64 {
        orders(self.degree, theta)
    }

    fn add_edge(&mut self, edge: Circle) {
        let axis = self.frame.transpose() * edge.axis;
        match coaxial(axis, DVec3::Z) {
            Some(sign) if sign > 0.0 => self.breaks.push(edge.angle),
            Some(_) => self.breaks.push(PI - edge.angle),
            None => {
                let tilt = axis.x.hypot(axis.y).atan2(axis.z);
                let cut = Cut { tilt, longitude: axis.y.atan2(axis.x), angle: edge.angle };
                if !cut.is_meridian() {
                    // Where the circle touches rings.
                    let fold = |x: f64| if x > PI { TAU - x } else { x.abs() };
                    let touches = [fold(tilt - edge.angle), fold(tilt + edge.angle)];
                    self.breaks.extend(touches);
                    self.touches.extend(touches);
                }
                self.cuts.push(cut);
            }
        }
    }

    /// Returns the number of pairs of edges that may cross between the poles.
    fn n_pairs(&self) -> usize {
        let pairs = |n: usize| n * n.saturating_sub(1) / 2;
        pairs(self.cuts.len()) - pairs(self.cuts.iter().filter(|cut| cut.is_meridian()).count())
    }

    /// Adds the colatitudes at which edges intersect.
    fn add_crossings(&mut self) {
        for (i, a) in self.cuts.iter().enumerate() {
            for b in &self.cuts[..i] {
                // Meridians intersect at the poles.
                if !(a.is_meridian() && b.is_meridian()) {
                    self.breaks.extend(crossings(*a, *b));
                }
            }
        }
    }

    /// Returns the colatitudes between which a support lies.
    fn support(&self, support: Option<Circle>) -> (f64, f64) {
        let Some(support) = support else {
            return (0.0, PI);
        };
        let axis = self.frame.transpose() * support.axis;
        let tilt = axis.x.hypot(axis.y).atan2(axis.z);
        match coaxial(axis, DVec3::Z) {
            Some(sign) if sign > 0.0 => (0.0, support.angle),
            Some(_) => (PI - support.angle, PI),
            None => ((tilt - support.angle).max(0.0), (tilt + support.angle).min(PI)),
        }
    }

    /// Returns the approximate number of nodes, or of rings for a zonal function.
    pub(super) fn cost(&self) -> f64 {
        let panels = self.breaks.len() as f64;
        let (first, last) = (self.breaks[0], self.breaks[self.breaks.len() - 1]);
        let rings = 0.5 * self.degree as f64 * (last - first) + 30.0 * panels;
        let orders = [first, last, 0.5 * (first + last)].map(|t| self.orders(t));
        let pieces = orders.into_iter().fold(0.0, f64::max) + 20.0 * self.cuts.len() as f64;
        if self.zonal { rings } else { rings * pieces }
    }

    /// Returns the work of coefficients to degree `lmax`; rings without edges resolve functions of
    /// `ring_degree`.
    pub(super) fn coefficient_work(&self, ring_degree: usize, lmax: usize) -> CoefficientWork {
        /// The parts of a panel that are examined.
        const PARTS: u32 = 4;
        let mut work = CoefficientWork::default();
        for panel in self.breaks.windows(2) {
            let (from, width) = (panel[0], panel[1] - panel[0]);
            let len = PanelRules::len(self.ends(from, width), self.phase(width)) as f64;
            for part in 0..PARTS {
                let theta = from + width * (f64::from(part) + 0.5) / f64::from(PARTS);
                let n_cuts = self.cuts.iter().filter_map(|cut| cut.half_width(theta)).count();
                let (nodes, orders) = match n_cuts {
                    0 => {
                        let orders = orders(ring_degree, theta);
                        (2.0 * orders + 2.0, orders.min(lmax as f64))
                    }
                    n => (self.orders(theta) + 40.0 * n as f64, orders(lmax, theta)),
                };
                let rings = len / f64::from(PARTS);
                work.nodes += rings * nodes;
                work.legendre += rings * (orders + 1.0) * (lmax as f64 - 0.5 * orders);
            }
        }
        work
    }

    /// Calls `f` with the colatitude of every ring, its weight, which includes `sin theta`, and its
    /// nodes in longitude. Rings without edges resolve functions of `ring_degree` there.
    pub(super) fn for_each_ring(
        &self,
        ring_degree: usize,
        mut f: impl FnMut(f64, f64, Longitudes<'_>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let (mut rules, mut pieces) = (PanelRules::default(), PanelRules::default());
        let (mut meetings, mut nodes) = (Vec::new(), Vec::new());
        for panel in self.breaks.windows(2) {
            let (from, width) = (panel[0], panel[1] - panel[0]);
            for &(x, w) in rules.rule(self.ends(from, width), self.phase(width))? {
                let theta = from + width * x;
                let weight = w * width * theta.sin();
                self.find_meetings(theta, &mut meetings);
                if meetings.is_empty() {
                    if !self.is_outside(self.direction(theta, 0.0)) {
                        let max_order = orders(ring_degree, theta);
                        f(theta, weight, Longitudes::Whole(max_order))?;
                    }
                    continue;
                }
                nodes.clear();
                let state = (&mut meetings, &mut pieces);
                self.for_each_on_pieces(theta, 1.0, state, |phi, w| nodes.push((phi, w)))?;
                f(theta, weight, Longitudes::Pieces(&nodes))?;
            }
        }
        Ok(())
    }

    /// Checks the number of nodes; `cost` is that of a value relative to a simple function.
    pub(super) fn check_cost(&self, nodes: f64, cost: f64) -> Result<(), Error> {
        if nodes > MAX_NODES {
            return Err(TOO_MANY_NODES);
        }
        if cost > 1.0 && nodes * cost > MAX_WORK {
            return Err(Error::NoEnergy {
                reason: "a quadrature over its values would take minutes; take lower degrees of \
                         harmonics or fewer terms",
            });
        }
        Ok(())
    }
}

/// Returns the largest order of functions of a degree on a ring: beyond `degree sin(theta)` they
/// decay like Airy functions, on the scale of the cube root of the degree.
pub(super) fn orders(degree: usize, theta: f64) -> f64 {
    let degree = degree as f64;
    degree.min((degree * theta.sin() + 9.0 * degree.cbrt() + 16.0).ceil())
}

/// Returns the axes about which rings for coefficients may take the least work: that of integrals
/// and, unless they are many, those of the edges and of the support.
pub(super) fn candidate_axes(shape: &Shape) -> Vec<DVec3> {
    const MAX_AXES: usize = 4;
    let mut axes = vec![ring_axis(shape)];
    let edges = shape.edges();
    let support = shape.support();
    let more = edges.iter().chain(&support).map(|circle| circle.axis);
    let more = more.take(if edges.len() <= 2 * MAX_AXES { usize::MAX } else { 0 });
    for axis in more {
        let is_known = axes.iter().any(|known| coaxial(*known, axis).is_some());
        if !is_known && axes.len() < MAX_AXES {
            axes.push(axis);
        }
    }
    axes
}

/// Returns the axis for the rings: that of most edges if they are many, else that of the support,
/// which may be narrow, else that of an edge.
fn ring_axis(shape: &Shape) -> DVec3 {
    /// More edges than any closed form has.
    const MANY: usize = 4;
    let about =
        |axis: DVec3| shape.edges().iter().filter(|e| coaxial(e.axis, axis).is_some()).count();
    // Few axes are tried, because the edges about one axis are consecutive.
    let common = shape.edges().iter().step_by(MANY).max_by_key(|e| about(e.axis)).map(|e| e.axis);
    let narrowest = shape.edges().iter().min_by(|a, b| a.angle.sin().total_cmp(&b.angle.sin()));
    shape
        .axis()
        .or(common.filter(|&axis| about(axis) >= MANY))
        .or(shape.support().map(|s| s.axis))
        .or(narrowest.map(|e| e.axis))
        .unwrap_or(DVec3::Z)
}

/// Returns a rotation that carries +z to `axis`.
fn frame_about(axis: DVec3) -> DMat3 {
    if coaxial(axis, DVec3::Z).is_some_and(|sign| sign > 0.0) {
        return DMat3::IDENTITY;
    }
    let axis = axis.normalize();
    let (x, y) = axis.any_orthonormal_pair();
    DMat3::from_cols(x, y, axis)
}

/// Returns the colatitudes of the intersections of two circles.
fn crossings(a: Cut, b: Cut) -> impl Iterator<Item = f64> {
    let axis = |c: Cut| {
        let ((sin, cos), (s, k)) = (c.tilt.sin_cos(), c.longitude.sin_cos());
        DVec3::new(sin * k, sin * s, cos)
    };
    let (u, v) = (axis(a), axis(b));
    let (p, q, k) = (a.angle.cos(), b.angle.cos(), u.dot(v));
    let normal = u.cross(v);
    let square = normal.length_squared();
    // x = alpha u + beta v + gamma u x v.
    let middle = u * ((p - k * q) / square) + v * ((q - k * p) / square);
    let rest = (1.0 - middle.length_squared()) / square;
    // If slightly below 0, the circles touch to rounding.
    let gamma = rest.max(0.0).sqrt();
    let points = [middle + normal * gamma, middle - normal * gamma];
    let real = square > f64::EPSILON && rest > -1e-9;
    points.into_iter().filter(move |_| real).map(|x| x.x.hypot(x.y).atan2(x.z))
}
