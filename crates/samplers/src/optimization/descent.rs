//! Minimization over unit vectors or points of the plane.

use std::collections::VecDeque;
use std::ops::Range;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::Stopped;
use crate::ensemble::progress::Tick;
use crate::vector::Vector;

/// Number of past steps whose gradient changes the method stores.
const MEMORY: usize = 6;

/// The fraction of the decrease predicted by the slope that a step must achieve (Armijo 1966).
const SUFFICIENT: f64 = 1e-4;

/// Maximum number of step reductions before the method abandons a direction.
const MAX_TRIALS: u32 = 30;

/// Vectors of more points are divided into parts of this size, one for each thread at a time. Sums are
/// those of the parts, added in their order, for any number of threads.
const PART: usize = 16384;

/// A point of the unit sphere or of the plane, as a vector; so are tangent vectors.
pub(crate) trait ManifoldPoint: Vector + Send + Sync {
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
        let mut squared_slope = project(points, &mut gradient);
        let mut memory = Memory { pairs: VecDeque::new() };
        let (mut step, mut trial, mut trial_gradient) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..self.iterations {
            tick()?;
            if objective.is_final(here, squared_slope) {
                break;
            }
            let mut slope = self.step_into(&memory, points, &gradient, &mut step);
            if slope >= 0.0 {
                // If the stored steps give an ascent direction they are dropped; the negative
                // gradient is always a descent direction.
                memory.clear();
                slope = self.step_into(&memory, points, &gradient, &mut step);
            }
            let mut t = 1.0;
            let mut trials = 0;
            let there = loop {
                trial.resize(points.len(), P::ZERO);
                by_parts(&mut trial, |range, trial| {
                    let moves = points[range.clone()].iter().zip(&step[range]);
                    trial.iter_mut().zip(moves).for_each(|(to, (&p, &d))| *to = p.moved(d * t));
                    []
                });
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
                squared_slope = project(points, &mut gradient);
                if memory.clear() {
                    continue;
                }
                break;
            };
            objective.gradient(&trial, &mut trial_gradient);
            squared_slope = project(&trial, &mut trial_gradient);
            memory.remember(points, &trial, &gradient, &trial_gradient);
            std::mem::swap(points, &mut trial);
            std::mem::swap(&mut gradient, &mut trial_gradient);
            here = there;
        }
        Ok(here)
    }

    /// Computes the next step, tangent and nowhere longer than `reach`, and returns its product with
    /// the gradient.
    fn step_into<P: ManifoldPoint>(
        self,
        memory: &Memory<P>,
        points: &[P],
        gradient: &[P],
        step: &mut Vec<P>,
    ) -> f64 {
        memory.direction_into(gradient, self, step);
        let [slope] = by_parts(step, |range, step| {
            for (d, &p) in step.iter_mut().zip(&points[range.clone()]) {
                *d = P::tangent(*d, p).clamp_length_max(self.reach);
            }
            [dot(&gradient[range], step)]
        });
        slope
    }
}

/// Returns the minimum of the parabola through both energies and the slope, in units of the step,
/// clamped to [1/10, 1/2].
fn shortening(here: f64, there: f64, slope: f64) -> f64 {
    let minimum = -slope / (2.0 * (there - here - slope));
    // There is no such parabola if an energy is infinite or NaN.
    if minimum > 0.1 { minimum.min(0.5) } else { 0.1 }
}

/// Projects vectors onto the tangent planes; returns the sum of their squares.
fn project<P: ManifoldPoint>(points: &[P], vectors: &mut [P]) -> f64 {
    let [square] = by_parts(vectors, |range, vectors| {
        for (v, p) in vectors.iter_mut().zip(&points[range]) {
            *v = P::tangent(*v, *p);
        }
        [dot(vectors, vectors)]
    });
    square
}

fn dot<P: Vector>(a: &[P], b: &[P]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// Calls `change` for parts of the vectors and their range among all; returns the sums of what it
/// returns.
fn by_parts<P: Send, const K: usize>(
    vectors: &mut [P],
    change: impl Fn(Range<usize>, &mut [P]) -> [f64; K] + Sync,
) -> [f64; K] {
    if vectors.len() <= PART {
        return change(0..vectors.len(), vectors);
    }
    let parts = vectors.par_chunks_mut(PART).enumerate();
    let sums = parts.map(|(i, part)| change(i * PART..i * PART + part.len(), part));
    let sums: Vec<[f64; K]> = sums.collect();
    std::array::from_fn(|k| sums.iter().map(|sums| sums[k]).sum())
}

/// A step s and the change of the gradient y along it.
#[derive(Default)]
struct Pair<P> {
    step: Vec<P>,
    change: Vec<P>,
    /// `s.y`.
    curvature: f64,
    /// `y.y`.
    squared_change: f64,
}

/// The latest steps with s.y > 0, oldest first.
struct Memory<P> {
    pairs: VecDeque<Pair<P>>,
}

impl<P: ManifoldPoint> Memory<P> {
    /// Clears the memory; returns whether it was not empty.
    fn clear(&mut self) -> bool {
        let had_any = !self.pairs.is_empty();
        self.pairs.clear();
        had_any
    }

    fn remember(&mut self, from: &[P], to: &[P], before: &[P], after: &[P]) {
        let oldest = if self.pairs.len() == MEMORY { self.pairs.pop_front() } else { None };
        let (mut step, mut change) = oldest.map_or_else(Default::default, |p| (p.step, p.change));
        step.resize(to.len(), P::ZERO);
        change.resize(to.len(), P::ZERO);
        let [squared_step] = by_parts(&mut step, |range, step| {
            for (s, (&a, &b)) in step.iter_mut().zip(from[range.clone()].iter().zip(&to[range])) {
                *s = P::tangent(b - a, b);
            }
            [dot(step, step)]
        });
        let [curvature, squared_change] = by_parts(&mut change, |range, change| {
            let gradients = before[range.clone()].iter().zip(&after[range.clone()]);
            for (y, ((&a, &b), &at)) in change.iter_mut().zip(gradients.zip(&to[range.clone()])) {
                *y = b - P::tangent(a, at);
            }
            [dot(&step[range], change), dot(change, change)]
        });
        if curvature > f64::EPSILON * squared_change.sqrt() * squared_step.sqrt() {
            self.pairs.push_back(Pair { step, change, curvature, squared_change });
        }
    }

    /// Computes minus the approximate inverse Hessian times the gradient by the two-loop recursion
    /// of Nocedal 1980. Each pass over the vectors adds one term and takes the product with the
    /// next.
    fn direction_into(&self, gradient: &[P], descent: Descent, direction: &mut Vec<P>) {
        let known = self.pairs.back().filter(|_| descent.is_adaptive);
        let scale = known.map_or(descent.scale, |pair| pair.curvature / pair.squared_change);
        direction.clear();
        direction.extend_from_slice(gradient);
        let Some(last) = self.pairs.len().checked_sub(1) else {
            direction.iter_mut().for_each(|d| *d = -*d * scale);
            return;
        };
        // Replaces d by (d + c v) scale; returns its product with `next`.
        let mut add = |c: f64, v: &[P], scale: f64, next: &[P]| {
            let [product] = by_parts(direction, |range, direction| {
                let mut product = 0.0;
                let vectors = v[range.clone()].iter().zip(&next[range]);
                for (d, (&v, &next)) in direction.iter_mut().zip(vectors) {
                    *d = (*d + v * c) * scale;
                    product += next.dot(*d);
                }
                [product]
            });
            product
        };
        let mut product = add(0.0, gradient, -1.0, &self.pairs[last].step);
        let mut parts = [0.0; MEMORY];
        for k in (1..=last).rev() {
            let Pair { change, curvature, .. } = &self.pairs[k];
            parts[k] = product / curvature;
            product = add(-parts[k], change, 1.0, &self.pairs[k - 1].step);
        }
        let Pair { change, curvature, .. } = &self.pairs[0];
        parts[0] = product / curvature;
        product = add(-parts[0], change, scale, change);
        for (k, Pair { step, curvature, .. }) in self.pairs.iter().enumerate() {
            let corrected = parts[k] - product / curvature;
            let next = &self.pairs[(k + 1).min(last)].change;
            product = add(corrected, step, 1.0, next);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{DVec3, Descent, Objective, PART, by_parts, dot};

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

    /// Many points are divided into parts. The steps are those of few points in every place, and
    /// bit-identical for any number of threads.
    #[test]
    fn parts_are_independent_of_the_number_of_threads() {
        let some = [(1.0, 2.0, 0.1), (-0.3, 0.2, -0.9), (0.5, 0.5, 0.5)]
            .map(|(x, y, z)| DVec3::new(x, y, z).normalize());
        let many: Vec<DVec3> = some.into_iter().cycle().take(3 * PART - 3).collect();
        let run = |points: &[DVec3], iterations| {
            let mut points = points.to_vec();
            let mut form = Form(DVec3::new(3.0, 1.0, 0.25));
            let descent = Descent { iterations, ..descent(true) };
            let minimum = descent.run(&mut points, &mut form, &|| Ok(())).unwrap();
            (points, minimum)
        };
        let mut previous: Option<(Vec<DVec3>, f64)> = None;
        for threads in [1, 2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let got = pool.install(|| run(&many, 8));
            let (few, minimum) = run(&some, 8);
            for (got, expected) in got.0.iter().zip(few.iter().cycle()) {
                assert!(got.distance(*expected) < 1e-9, "{got} instead of {expected}");
            }
            let off = got.1 / (minimum * (PART - 1) as f64) - 1.0;
            assert!(off.abs() < 1e-9, "{off:e}");
            assert!(previous.is_none_or(|previous| previous == got), "{threads} threads");
            previous = Some(got);
        }

        let mut vectors = many.clone();
        let [sum, count] = by_parts(&mut vectors, |range, part| {
            assert!(range.len() == part.len() && part == &many[range.clone()]);
            part.iter_mut().for_each(|v| *v = -*v);
            [dot(part, &many[range]), part.len() as f64]
        });
        assert!(
            (sum + count).abs() < 1e-6 && (count - many.len() as f64).abs() < 0.5,
            "{sum} {count}"
        );
        assert!(vectors.iter().zip(&many).all(|(a, b)| *a == -*b));
    }
}
