//! Minimization over unit vectors or points of the plane.

use std::collections::VecDeque;

use glam::{DVec2, DVec3};

use crate::Stopped;
use crate::ensemble::progress::Tick;
use crate::vector::Vector;

/// Number of past steps whose gradient changes the method stores.
const MEMORY: usize = 6;

/// The fraction of the decrease predicted by the slope that a step must achieve (Armijo 1966).
const SUFFICIENT: f64 = 1e-4;

/// Maximum number of step reductions before the method abandons a direction.
const MAX_TRIALS: u32 = 30;

/// A point of the unit sphere or of the plane, as a vector; so are tangent vectors.
pub(crate) trait ManifoldPoint: Vector {
    /// Returns the part of a vector that is tangent at a point.
    fn tangent(vector: Self, at: Self) -> Self;

    /// Returns the point at the end of a step, a tangent vector.
    fn moved(self, step: Self) -> Self;
}

impl ManifoldPoint for DVec3 {
    fn tangent(vector: Self, at: Self) -> Self {
        vector - vector.dot(at) * at
    }

    fn moved(self, step: Self) -> Self {
        (self + step).normalize_or(self)
    }
}

/// The plane is the square with opposite sides joined, unrolled: a point and its periodic images
/// are the same.
impl ManifoldPoint for DVec2 {
    fn tangent(vector: Self, _: Self) -> Self {
        vector
    }

    fn moved(self, step: Self) -> Self {
        self + step
    }
}

/// An objective to minimize.
pub(crate) trait Objective<P> {
    /// Returns the energy of the points, or NaN where it is undefined.
    fn energy(&mut self, points: &[P]) -> f64;

    /// Replaces the content of `gradient` by the gradient in space at the points of the last call
    /// of [`Self::energy`].
    fn gradient(&mut self, points: &[P], gradient: &mut Vec<P>);

    /// Returns whether the descent ends because the points of the last calls are good enough or
    /// cannot improve. Called once for each accepted step.
    fn is_final(&mut self, _energy: f64, _squared_slope: f64) -> bool {
        false
    }
}

/// Parameters of the limited-memory BFGS method (Liu and Nocedal 1989) on a product of spheres or
/// planes.
///
/// Gradients and steps lie in the tangent planes; on spheres each step ends with a normalization. No step
/// increases the energy, moves a point by more than `reach`, or ends where the energy is NaN. The
/// stored steps are used in the tangent planes of the next points without transport, which made no
/// measurable difference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Descent {
    /// Maximum number of steps.
    pub(crate) iterations: u32,
    /// The factor of the gradient in the first step and in the step after a failure.
    pub(crate) scale: f64,
    /// Whether an estimate of the curvature replaces `scale` in later steps.
    pub(crate) is_adaptive: bool,
    pub(crate) reach: f64,
}

impl Descent {
    /// Moves the points until the objective is final or no step decreases it further, and returns
    /// the final energy. The last evaluation of the objective was at the returned points. Before
    /// each step `tick` returns whether to continue.
    pub(crate) fn run<P: ManifoldPoint>(
        self,
        points: &mut Vec<P>,
        objective: &mut impl Objective<P>,
        tick: Tick<'_>,
    ) -> Result<f64, Stopped> {
        let mut gradient = Vec::new();
        let mut here = objective.energy(points);
        objective.gradient(points, &mut gradient);
        project(points, &mut gradient);
        let mut memory = Memory { pairs: VecDeque::new() };
        let (mut step, mut trial, mut trial_gradient) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..self.iterations {
            tick()?;
            if objective.is_final(here, dot(&gradient, &gradient)) {
                break;
            }
            memory.direction_into(&gradient, self, &mut step);
            project(points, &mut step);
            limit(&mut step, self.reach);
            let mut slope = dot(&gradient, &step);
            if slope >= 0.0 {
                // If the stored steps give an ascent direction they are dropped; the negative
                // gradient is always a descent direction.
                memory.clear();
                memory.direction_into(&gradient, self, &mut step);
                limit(&mut step, self.reach);
                slope = dot(&gradient, &step);
            }
            let mut t = 1.0;
            let mut trials = 0;
            let there = loop {
                trial.clear();
                trial.extend(points.iter().zip(&step).map(|(&p, &d)| p.moved(d * t)));
                let there = objective.energy(&trial);
                if there <= here + SUFFICIENT * t * slope {
                    break Some(there);
                }
                trials += 1;
                if trials == MAX_TRIALS {
                    break None;
                }
                t *= shortening(here, there, t * slope);
            };
            let Some(there) = there.filter(|_| slope < 0.0) else {
                here = objective.energy(points);
                objective.gradient(points, &mut gradient);
                project(points, &mut gradient);
                if memory.clear() {
                    continue;
                }
                break;
            };
            objective.gradient(&trial, &mut trial_gradient);
            project(&trial, &mut trial_gradient);
            memory.remember(points, &trial, &gradient, &trial_gradient);
            std::mem::swap(points, &mut trial);
            std::mem::swap(&mut gradient, &mut trial_gradient);
            here = there;
        }
        Ok(here)
    }
}

/// Returns the minimum of the parabola through both energies and the slope, in units of the step,
/// clamped to [1/10, 1/2].
fn shortening(here: f64, there: f64, slope: f64) -> f64 {
    let minimum = -slope / (2.0 * (there - here - slope));
    // There is no such parabola if an energy is infinite or NaN.
    if minimum > 0.1 { minimum.min(0.5) } else { 0.1 }
}

/// Projects vectors onto the tangent planes.
fn project<P: ManifoldPoint>(points: &[P], vectors: &mut [P]) {
    for (v, p) in vectors.iter_mut().zip(points) {
        *v = P::tangent(*v, *p);
    }
}

/// Shortens vectors longer than `reach`.
fn limit<P: Vector>(vectors: &mut [P], reach: f64) {
    for v in vectors {
        *v = v.clamp_length_max(reach);
    }
}

fn dot<P: Vector>(a: &[P], b: &[P]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// The latest steps s and changes of the gradient y with s.y > 0, oldest first.
struct Memory<P> {
    pairs: VecDeque<(Vec<P>, Vec<P>, f64)>,
}

impl<P: ManifoldPoint> Memory<P> {
    /// Clears the memory; returns whether it was not empty.
    fn clear(&mut self) -> bool {
        let had_any = !self.pairs.is_empty();
        self.pairs.clear();
        had_any
    }

    fn remember(&mut self, from: &[P], to: &[P], before: &[P], after: &[P]) {
        let (mut step, mut change, _) =
            if self.pairs.len() == MEMORY { self.pairs.pop_front() } else { None }
                .unwrap_or_default();
        step.clear();
        change.clear();
        step.extend(from.iter().zip(to).map(|(&a, &b)| P::tangent(b - a, b)));
        let gradients = before.iter().zip(after);
        change.extend(gradients.zip(to).map(|((&a, &b), &at)| b - P::tangent(a, at)));
        let curvature = dot(&step, &change);
        if curvature > f64::EPSILON * dot(&change, &change).sqrt() * dot(&step, &step).sqrt() {
            self.pairs.push_back((step, change, curvature));
        }
    }

    /// Computes minus the approximate inverse Hessian times the gradient by the two-loop recursion
    /// of Nocedal 1980.
    fn direction_into(&self, gradient: &[P], descent: Descent, direction: &mut Vec<P>) {
        direction.clear();
        direction.extend(gradient.iter().map(|g| -*g));
        let add = |to: &mut [P], c: f64, v: &[P]| {
            to.iter_mut().zip(v).for_each(|(d, v)| *d += *v * c);
        };
        let mut parts = [0.0; MEMORY];
        for ((step, change, curvature), part) in self.pairs.iter().zip(&mut parts).rev() {
            *part = dot(step, direction) / curvature;
            add(direction, -*part, change);
        }
        let known = self.pairs.back().filter(|_| descent.is_adaptive);
        let scale = known.map_or(descent.scale, |(_, y, curvature)| curvature / dot(y, y));
        if scale.to_bits() != f64::to_bits(1.0) {
            direction.iter_mut().for_each(|d| *d = *d * scale);
        }
        for ((step, change, curvature), part) in self.pairs.iter().zip(parts) {
            let corrected = part - dot(change, direction) / curvature;
            add(direction, corrected, step);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{DVec3, Descent, Objective};

    /// The same quadratic form, with these axes, on every sphere.
    struct Form(DVec3);

    impl Objective<DVec3> for Form {
        fn energy(&mut self, points: &[DVec3]) -> f64 {
            points.iter().map(|p| (self.0 * *p).dot(*p)).sum()
        }

        fn gradient(&mut self, points: &[DVec3], gradient: &mut Vec<DVec3>) {
            gradient.clear();
            gradient.extend(points.iter().map(|p| 2.0 * self.0 * *p));
        }
    }

    fn descent(is_adaptive: bool) -> Descent {
        Descent { iterations: 60, scale: 0.1, is_adaptive, reach: 0.3 }
    }

    #[test]
    fn quadratic_forms_converge_to_their_smallest_axis() {
        for is_adaptive in [true, false] {
            let mut points: Vec<DVec3> = [(1.0, 2.0, 0.1), (-0.3, 0.2, -0.9), (0.5, 0.5, 0.5)]
                .map(|(x, y, z)| DVec3::new(x, y, z).normalize())
                .into();
            let mut form = Form(DVec3::new(3.0, 1.0, 0.25));
            let minimum = descent(is_adaptive).run(&mut points, &mut form, &|| Ok(())).unwrap();
            assert!((minimum - 0.75).abs() < 16.0 * f64::EPSILON, "{minimum} at {points:?}");
            // The energy depends on the square of the remaining angle.
            assert!(points.iter().all(|p| p.z.abs() > 1.0 - 1e-14), "{points:?}");
        }
    }

    /// NaN energies leave the points unchanged.
    #[test]
    fn a_nan_energy_allows_no_step() {
        let start = vec![DVec3::X, DVec3::Y];
        let mut points = start.clone();
        assert!(
            descent(true).run(&mut points, &mut Form(DVec3::NAN), &|| Ok(())).unwrap().is_nan()
        );
        assert_eq!(points, start);
    }
}
