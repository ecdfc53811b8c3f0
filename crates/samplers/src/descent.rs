//! Minimisation over unit vectors.

use std::collections::VecDeque;

use glam::DVec3;

/// Steps of which the method remembers the change of the gradient.
const MEMORY: usize = 8;

/// The share of the slope's promise that a step must keep (Armijo 1966).
const SUFFICIENT: f64 = 1e-4;

/// Shortenings of one step before the method gives up on a direction.
const MOST_TRIALS: u32 = 30;

/// Moves unit vectors downhill by at most `iterations` steps of the limited-memory BFGS method
/// (Liu and Nocedal 1989) on the product of spheres, and returns the energy reached.
///
/// Gradients and steps live in the tangent planes; a step ends by normalisation. `energy` fills in
/// the gradient in space. No step increases the energy, moves a point by more than `reach`, or
/// ends where the energy is no number. The first step, and any after a failure, is `scale` times
/// the gradient. Ends early where no shorter step goes down any more.
pub(crate) fn minimize(
    points: &mut Vec<DVec3>,
    iterations: u32,
    scale: f64,
    reach: f64,
    energy: impl Fn(&[DVec3], &mut Vec<DVec3>) -> f64,
) -> f64 {
    let mut gradient = Vec::new();
    let mut here = energy(points, &mut gradient);
    project(points, &mut gradient);
    let mut memory = Memory::default();
    let (mut trial, mut trial_gradient) = (Vec::new(), Vec::new());
    for _ in 0..iterations {
        let mut step = memory.direction(&gradient, scale);
        project(points, &mut step);
        limit(&mut step, reach);
        let mut slope = dot(&gradient, &step);
        if slope >= 0.0 {
            // Memory that points uphill is worth nothing; the gradient itself never does.
            memory.clear();
            step = memory.direction(&gradient, scale);
            limit(&mut step, reach);
            slope = dot(&gradient, &step);
        }
        let mut t = 1.0;
        let mut trials = 0;
        let there = loop {
            trial.clear();
            trial.extend(points.iter().zip(&step).map(|(&p, &d)| (p + t * d).normalize_or(p)));
            let there = energy(&trial, &mut trial_gradient);
            if there <= here + SUFFICIENT * t * slope {
                break Some(there);
            }
            trials += 1;
            if trials == MOST_TRIALS {
                break None;
            }
            t *= shortening(here, there, t * slope);
        };
        let Some(there) = there.filter(|_| slope < 0.0) else {
            if memory.clear() {
                continue;
            }
            break;
        };
        project(&trial, &mut trial_gradient);
        memory.remember(points, &trial, &gradient, &trial_gradient);
        std::mem::swap(points, &mut trial);
        std::mem::swap(&mut gradient, &mut trial_gradient);
        here = there;
    }
    here
}

/// Where the parabola through both energies and the slope has its minimum, in units of the step,
/// kept between 1/10 and 1/2.
fn shortening(here: f64, there: f64, slope: f64) -> f64 {
    let minimum = -slope / (2.0 * (there - here - slope));
    // An energy that is infinite or no number has no such parabola.
    if minimum > 0.1 { minimum.min(0.5) } else { 0.1 }
}

/// Removes the parts of vectors that are normal to the sphere.
fn project(points: &[DVec3], vectors: &mut [DVec3]) {
    for (v, p) in vectors.iter_mut().zip(points) {
        *v -= v.dot(*p) * *p;
    }
}

/// Shortens vectors longer than `reach`.
fn limit(vectors: &mut [DVec3], reach: f64) {
    for v in vectors {
        *v = v.clamp_length_max(reach);
    }
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// The latest steps s and changes of the gradient y with s.y > 0, oldest first.
#[derive(Default)]
struct Memory {
    pairs: VecDeque<(Vec<DVec3>, Vec<DVec3>, f64)>,
}

impl Memory {
    /// Forgets all; whether there was anything.
    fn clear(&mut self) -> bool {
        let had_any = !self.pairs.is_empty();
        self.pairs.clear();
        had_any
    }

    fn remember(&mut self, from: &[DVec3], to: &[DVec3], before: &[DVec3], after: &[DVec3]) {
        let mut step: Vec<DVec3> = to.iter().zip(from).map(|(b, a)| *b - *a).collect();
        let mut change = before.to_vec();
        project(to, &mut step);
        project(to, &mut change);
        change.iter_mut().zip(after).for_each(|(y, g)| *y = *g - *y);
        let curvature = dot(&step, &change);
        if curvature > f64::EPSILON * dot(&change, &change).sqrt() * dot(&step, &step).sqrt() {
            if self.pairs.len() == MEMORY {
                self.pairs.pop_front();
            }
            self.pairs.push_back((step, change, curvature));
        }
    }

    /// Minus the inverse Hessian, as far as it is known, times the gradient: the two loops of
    /// Nocedal 1980.
    fn direction(&self, gradient: &[DVec3], scale: f64) -> Vec<DVec3> {
        let mut direction: Vec<DVec3> = gradient.iter().map(|g| -*g).collect();
        let add = |to: &mut [DVec3], c: f64, v: &[DVec3]| {
            to.iter_mut().zip(v).for_each(|(d, v)| *d += c * *v);
        };
        let mut parts = Vec::with_capacity(MEMORY);
        for (step, change, curvature) in self.pairs.iter().rev() {
            let part = dot(step, &direction) / curvature;
            add(&mut direction, -part, change);
            parts.push(part);
        }
        let scale = self.pairs.back().map_or(scale, |(_, y, curvature)| curvature / dot(y, y));
        direction.iter_mut().for_each(|d| *d *= scale);
        for ((step, change, curvature), part) in self.pairs.iter().zip(parts.iter().rev()) {
            let corrected = part - dot(change, &direction) / curvature;
            add(&mut direction, corrected, step);
        }
        direction
    }
}

#[cfg(test)]
mod tests {
    use super::{DVec3, minimize};

    /// A quadratic form on one sphere goes down to its smallest eigenvalue; an energy that is
    /// no number is left where it is.
    #[test]
    fn a_quadratic_form_ends_at_its_least_axis() {
        let axes = DVec3::new(3.0, 1.0, 0.25);
        let energy = |p: &[DVec3], g: &mut Vec<DVec3>| {
            *g = vec![2.0 * axes * p[0]];
            (axes * p[0]).dot(p[0])
        };
        let mut points = vec![DVec3::new(1.0, 2.0, 0.1).normalize()];
        let least = minimize(&mut points, 60, 0.1, 0.3, energy);
        assert!((least - 0.25).abs() < 4.0 * f64::EPSILON, "{least} at {}", points[0]);
        // The angle left over shows in the energy squared.
        assert!(points[0].z.abs() > 1.0 - 1e-14, "{}", points[0]);

        let start = points.clone();
        let nan = |_: &[DVec3], g: &mut Vec<DVec3>| {
            *g = vec![DVec3::NAN];
            f64::NAN
        };
        assert!(minimize(&mut points, 5, 0.1, 0.3, nan).is_nan());
        assert_eq!(points, start);
    }
}
