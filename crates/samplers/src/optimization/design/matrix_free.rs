//! Gauss-Newton steps to designs by conjugate gradients, for large degrees.

use std::f64::consts::PI;

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{ConjugateGradients, Method, Transform, TransformWorkspace};

use super::{DesignEquations, Solved};
use crate::optimization::descent::ManifoldPoint;
use crate::optimization::transforms;
use crate::{Error, Progress};

/// The accuracies of the transforms within steps and of those for the residuals. The smallest power
/// that a transform resolves is a tenth of the square of its accuracy.
const STEP_ACCURACY: f64 = 1e-5;
const ACCURACY: f64 = 1e-12;

/// The damping of a step in units of the largest power. The linear equations have a mean eigenvalue
/// of 1; white noise, with a power of 1, is far from a solution, and steps near a solution are not
/// damped.
const DAMPING: f64 = 0.3;

/// The residuals of the linear equations, relative to their right-hand sides: as small as the
/// convergence of the steps suggests (choice 2 of Eisenstat and Walker 1996, with their constants
/// 0.9 and 0.1), and within what the less accurate transforms resolve.
const MAX_FORCING: f64 = 0.3;
const MIN_FORCING: f64 = 1e-3;

/// The smallest part of a step that is tried.
const MIN_PART: f64 = 1.0 / 64.0;

/// The fraction of a step's length by which it must decrease the sum of squares (Armijo 1966).
const SUFFICIENT: f64 = 1e-4;

/// The search has stalled after this number of successive steps that decrease the sum of squares by
/// less than a part of `STALLED`.
const PATIENCE: u32 = 8;
const STALLED: f64 = 0.02;

/// The number of fast transforms of one set that a product of the matrix with a vector costs: the
/// gradient of a function is the synthesis of four, its adjoint has three sets.
const TRANSFORMS: f64 = 7.0;

/// The number of products of a solution in units of `condition^(4/3)`, for random points; measured
/// for degrees of 25 to 200 and 5 to 50 % more degrees of freedom than equations, to a factor of 2.5.
const PRODUCTS: f64 = 20.0;

/// Returns the expected nominal work of [`solve_matrix_free`] from
/// [`perturbed_lattice`](super::start::perturbed_lattice).
pub(crate) fn expected_work(equations: DesignEquations, n_points: usize) -> f64 {
    let share = equations.count() as f64 / (2 * n_points) as f64;
    // As many equations as degrees of freedom are out of reach.
    let root = share.min(1.0 - 1e-6).sqrt();
    let condition = (1.0 + root) / (1.0 - root);
    let products = PRODUCTS * condition.powf(4.0 / 3.0);
    products * TRANSFORMS * Method::Auto.nominal_work(n_points, equations.degree)
}

/// Moves the points until no degree of the equations has more power than `tolerance`.
///
/// The residuals are the coefficients of degree l times `sqrt(4 pi/(N l(l+1)))`, so that the product
/// `J J^T` with their Jacobian has a mean eigenvalue of 1. A step is the least one for which the
/// linearized residuals nearly vanish, `J^T (J J^T + mu)^-1` times them, by the method of conjugate
/// gradients: `J^T` is the gradient of a function at the points, J its adjoint. The steps are
/// inexact and the transforms within them have a low accuracy; only the residuals of each step have
/// a high one.
///
/// The condition number of J is about `(1 + sqrt f)/(1 - sqrt f)` for random points, where f is the
/// ratio of equations to degrees of freedom, and several times as large for regular points. The
/// number of products grows in proportion to it.
///
/// # Errors
///
/// [`Error::Infeasible`] if the steps stall, as where there are nearly as many equations as degrees
/// of freedom; [`Error::Degree`] if the transforms cannot be built; [`Error::Stopped`].
pub(crate) fn solve_matrix_free(
    equations: DesignEquations,
    points: &mut Vec<DVec3>,
    tolerance: f64,
    progress: &dyn Progress,
) -> Result<Solved, Error> {
    let mut system = Linearized::new(equations, points.len())?;
    let mut here = system.residuals(points, progress)?;
    let (mut damping, mut forcing) = (DAMPING, MAX_FORCING);
    let (mut iterations, mut slow) = (0, 0);
    while here.power > tolerance && slow < PATIENCE {
        let step = system.step(points, &here, damping * here.power, forcing, progress)?;
        let mut part = 1.0;
        let accepted = loop {
            let moved: Vec<DVec3> =
                points.iter().zip(&step).map(|(p, s)| p.moved(*s * part)).collect();
            let there = system.residuals(&moved, progress)?;
            if there.square <= here.square * (1.0 - SUFFICIENT * part) {
                break Some((moved, there));
            }
            part *= 0.5;
            if part < MIN_PART {
                break None;
            }
        };
        let Some((moved, there)) = accepted else {
            (damping, forcing, slow) = (16.0 * damping, MAX_FORCING, slow + 1);
            continue;
        };
        let ratio = there.square / here.square;
        slow = if ratio > 1.0 - STALLED { slow + 1 } else { 0 };
        if part < 1.0 {
            damping *= 4.0;
        } else if ratio < 0.1 {
            damping *= 0.25;
        }
        let safeguard = 0.9 * forcing * forcing;
        let suggested = if safeguard > 0.1 { safeguard.max(0.9 * ratio) } else { 0.9 * ratio };
        // The last step need not be more accurate than the tolerance.
        let sufficient = 0.3 * (tolerance / there.power).sqrt();
        forcing = suggested.max(sufficient).clamp(MIN_FORCING, MAX_FORCING);
        *points = moved;
        here = there;
        iterations += 1;
    }
    if here.power <= tolerance {
        return Ok(Solved { residual: here.power, iterations });
    }
    Err(equations.stalled(points.len(), iterations, here.power))
}

/// The residuals of the equations at some points.
struct Residuals {
    scaled: Alm,
    /// The largest power of a degree.
    power: f64,
    /// The sum of squares of the scaled residuals.
    square: f64,
}

/// The linearized equations of a design.
struct Linearized {
    equations: DesignEquations,
    /// `sqrt(4 pi/(N l(l+1)))` by degree; 0 where there is no equation.
    scales: Vec<f64>,
    rough: Transform,
    fine: Transform,
    workspace: TransformWorkspace,
    values: Vec<f64>,
    vectors: Vec<DVec3>,
    /// The nominal work of a transform of one set.
    work: f64,
}

impl Linearized {
    fn new(equations: DesignEquations, n_points: usize) -> Result<Self, Error> {
        let transform = |epsilon| {
            Transform::new(Method::Auto, equations.degree, n_points, epsilon)
                .map_err(|error| of_degree(equations, error))
        };
        let mut scales = vec![0.0; equations.degree + 1];
        for l in equations.degrees() {
            scales[l] = (4.0 * PI / (n_points * l * (l + 1)) as f64).sqrt();
        }
        Ok(Self {
            equations,
            scales,
            rough: transform(STEP_ACCURACY)?,
            fine: transform(ACCURACY)?,
            workspace: transforms::workspace(n_points),
            values: vec![0.0; n_points],
            vectors: vec![DVec3::ZERO; n_points],
            work: Method::Auto.nominal_work(n_points, equations.degree),
        })
    }

    fn zeros(&self) -> Result<Alm, Error> {
        Alm::zeros(self.equations.degree).map_err(|error| of_degree(self.equations, error))
    }

    fn residuals(&mut self, points: &[DVec3], progress: &dyn Progress) -> Result<Residuals, Error> {
        progress.tick(self.work)?;
        let mut outs = [self.zeros()?];
        self.fine.adjoint_batch_into(&[(points, None)], &mut self.workspace, &mut outs);
        let [mut scaled] = outs;
        let power = self.equations.residual(&scaled.energy_per_degree(), points.len());
        scale(&self.scales, &mut scaled);
        let square = scaled.energy_per_degree().iter().sum();
        Ok(Residuals { scaled, power, square })
    }

    /// Returns the step that makes the linearized residuals, except for a part of `forcing` of their
    /// norm, vanish, with a damping of `shift`.
    fn step(
        &mut self,
        points: &[DVec3],
        at: &Residuals,
        shift: f64,
        forcing: f64,
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Error> {
        let zero = self.zeros()?;
        let tolerance = forcing * at.square.sqrt();
        let mut vectors = std::mem::take(&mut self.vectors);
        let solution =
            ConjugateGradients::run(zero, &at.scaled, tolerance, usize::MAX, |x, image| {
                progress.tick(0.5 * TRANSFORMS * self.work)?;
                self.transposed(points, x, &mut vectors);
                progress.tick(0.5 * TRANSFORMS * self.work)?;
                self.product(points, &vectors, image);
                for (image, x) in image.values_mut().iter_mut().zip(x.values()) {
                    *image += shift * x;
                }
                Ok::<(), Error>(())
            })?;
        self.transposed(points, &solution.x, &mut vectors);
        let step = vectors.iter().map(|v| -*v).collect();
        self.vectors = vectors;
        Ok(step)
    }

    /// Writes `J v`: the changes of the scaled coefficients with displacements of the points.
    fn product(&mut self, points: &[DVec3], displacements: &[DVec3], out: &mut Alm) {
        self.rough.gradient_adjoint_into(points, displacements, &mut self.workspace, out);
        scale(&self.scales, out);
    }

    /// Writes `J^T a`: the gradients at the points of the function with the scaled coefficients.
    fn transposed(&mut self, points: &[DVec3], a: &Alm, out: &mut [DVec3]) {
        let mut function = a.clone();
        scale(&self.scales, &mut function);
        self.rough.gradient_into(&function, points, &mut self.workspace, &mut self.values, out);
    }
}

/// Multiplies the coefficients of each degree by a factor, and makes those of order 0 real.
fn scale(factors: &[f64], alm: &mut Alm) {
    for m in 0..=alm.lmax() {
        for (a, factor) in alm.column_mut(m).iter_mut().zip(&factors[m..]) {
            *a *= factor;
        }
    }
    alm.column_mut(0).iter_mut().for_each(|a| a.im = 0.0);
}

fn of_degree(equations: DesignEquations, error: sphvar_sh::Error) -> Error {
    Error::Degree { last: equations.degree, reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::super::start::perturbed_lattice;
    use super::*;
    use crate::ensemble::progress::SECONDS_PER_WORK;
    use crate::{Pattern, Purpose, Stopped, Streams};

    const TOLERANCE: f64 = 1e-22;

    fn equations(degree: usize, is_symmetric: bool) -> DesignEquations {
        DesignEquations { degree, is_symmetric }
    }

    fn white(equations: DesignEquations, n: usize, realization: u64) -> Vec<DVec3> {
        let mut rng = Streams::new(5, Purpose::Pattern, n).realization(realization);
        let sampler = Pattern::WhiteNoise.build(n, equations.domain()).unwrap();
        sampler.sample(&mut rng).unwrap().points
    }

    /// Returns the largest power of a degree by exact transforms.
    fn largest_power(equations: DesignEquations, points: &[DVec3]) -> f64 {
        let transform = sphvar_sht::ExactTransform::new(equations.degree).unwrap();
        let squares = transform.adjoint(points, None).unwrap().energy_per_degree();
        equations.residual(&squares, points.len())
    }

    fn dot(a: &Alm, b: &Alm) -> f64 {
        (0..=a.lmax())
            .map(|m| {
                let pairs = a.column(m).iter().zip(b.column(m));
                let sum: f64 = pairs.map(|(a, b)| a.re * b.re + a.im * b.im).sum();
                if m == 0 { sum } else { 2.0 * sum }
            })
            .sum()
    }

    /// Both kinds of transforms: few and many points.
    #[test]
    fn the_jacobian_and_its_transpose_are_adjoint() {
        for is_symmetric in [false, true] {
            for (degree, n) in [(1, 1), (2, 2), (8, 60), (40, 2000)] {
                let equations = equations(degree, is_symmetric);
                let points = white(equations, n, 0);
                let mut system = Linearized::new(equations, n).unwrap();
                let displacements = white(equations, n, 1);
                let a = system.residuals(&white(equations, n, 2), &()).unwrap().scaled;
                let mut image = system.zeros().unwrap();
                let mut gradients = vec![DVec3::ZERO; n];
                system.product(&points, &displacements, &mut image);
                system.transposed(&points, &a, &mut gradients);
                let pairs = displacements.iter().zip(&gradients);
                let [by_points, scale] = pairs.fold([0.0, 0.0], |[sum, scale], (v, g)| {
                    [sum + v.dot(*g), scale + v.length() * g.length()]
                });
                let off = (dot(&a, &image) - by_points).abs();
                // The grids of the less accurate transforms are in f32.
                let tolerance = 16.0 * f64::from(f32::EPSILON) * scale;
                assert!(off <= tolerance, "{equations:?}, N = {n}: {off:e} of {scale}");
            }
        }
    }

    #[test]
    fn the_jacobian_matches_finite_differences_of_residuals() {
        const H: f64 = 1e-5;
        for is_symmetric in [false, true] {
            for (degree, n) in [(1, 1), (4, 3), (8, 60), (40, 2000)] {
                let equations = equations(degree, is_symmetric);
                let points = white(equations, n, 0);
                let mut system = Linearized::new(equations, n).unwrap();
                let steps: Vec<DVec3> = white(equations, n, 1)
                    .iter()
                    .zip(&points)
                    .map(|(v, p)| DVec3::tangent(*v, *p))
                    .collect();
                let mut residuals = |h: f64| {
                    let moved: Vec<DVec3> =
                        points.iter().zip(&steps).map(|(p, s)| p.moved(h * *s)).collect();
                    system.residuals(&moved, &()).unwrap().scaled
                };
                let (above, below) = (residuals(H), residuals(-H));
                let mut image = system.zeros().unwrap();
                system.product(&points, &steps, &mut image);
                let size = image.energy_per_degree().iter().sum::<f64>().sqrt();
                let mut off = image;
                let differences = above.values().iter().zip(below.values());
                for (off, (a, b)) in off.values_mut().iter_mut().zip(differences) {
                    *off -= (a - b) / (2.0 * H);
                }
                let off = off.energy_per_degree().iter().sum::<f64>().sqrt();
                // The accuracy of the transforms is 1e-5; that of a residual, 1e-12 of its largest
                // possible value, is divided by H, and third derivatives are (l H)^2/6 < 1e-7.
                assert!(off <= 1e-4 * size, "{equations:?}, N = {n}: {off:e} of {size}");
            }
        }
    }

    #[test]
    fn undamped_steps_solve_the_linearized_equations() {
        let equations = equations(12, false);
        let points = white(equations, 150, 0);
        let mut system = Linearized::new(equations, points.len()).unwrap();
        let at = system.residuals(&points, &()).unwrap();
        for forcing in [MAX_FORCING, MIN_FORCING] {
            let step = system.step(&points, &at, 0.0, forcing, &()).unwrap();
            let mut left = system.zeros().unwrap();
            system.product(&points, &step, &mut left);
            for (left, r) in left.values_mut().iter_mut().zip(at.scaled.values()) {
                *left += r;
            }
            let ratio = (left.energy_per_degree().iter().sum::<f64>() / at.square).sqrt();
            assert!(ratio <= 1.01 * forcing, "{ratio} for {forcing}");
        }
    }

    /// From lattices and from white noise, with 10 to 60 % more degrees of freedom than equations.
    #[test]
    fn results_are_designs() {
        for (degree, n, is_symmetric) in [
            (0, 1, false),
            (1, 2, false),
            (3, 10, false),
            (8, 46, false),
            (12, 60, true),
            (16, 180, false),
            (30, 700, false),
        ] {
            let equations = equations(degree, is_symmetric);
            for mut points in [perturbed_lattice(equations, n, 0).unwrap(), white(equations, n, 0)]
            {
                let solved = solve_matrix_free(equations, &mut points, TOLERANCE, &()).unwrap();
                let power = largest_power(equations, &points);
                // The transforms resolve powers of 1e-25.
                let bound = 1.01 * TOLERANCE;
                assert!(power <= bound && solved.residual <= TOLERANCE, "{equations:?}: {power:e}");
                assert!(points.iter().all(|p| p.is_normalized()));
            }
        }
    }

    #[test]
    fn equal_arguments_give_equal_points() {
        let equations = equations(12, false);
        let solve = || {
            let mut points = perturbed_lattice(equations, 120, 0).unwrap();
            solve_matrix_free(equations, &mut points, TOLERANCE, &()).unwrap();
            points
        };
        assert_eq!(solve(), solve());
    }

    /// No 2-design of 5 points, 3-design of 9 or 1-design of one point exists; 40 points have fewer
    /// degrees of freedom than there are equations to degree 12.
    #[test]
    fn impossible_designs_stall() {
        for (degree, n) in [(1, 1), (2, 5), (3, 9), (12, 40)] {
            let equations = equations(degree, false);
            for mut points in [perturbed_lattice(equations, n, 0).unwrap(), white(equations, n, 0)]
            {
                let result = solve_matrix_free(equations, &mut points, TOLERANCE, &());
                assert!(matches!(result, Err(Error::Infeasible { .. })), "{n}: {result:?}");
                assert!(points.iter().all(|p| p.is_normalized()));
            }
        }
    }

    struct StopsAfter(AtomicU32, u32);

    impl Progress for StopsAfter {
        fn tick(&self, _: f64) -> Result<(), Stopped> {
            let n_ticks = self.0.fetch_add(1, Ordering::Relaxed);
            if n_ticks < self.1 { Ok(()) } else { Err(Stopped) }
        }
    }

    #[test]
    fn interrupts_stop_the_work_at_every_tick() {
        let equations = equations(12, false);
        for n_ticks in [0, 1, 2, 5, 40] {
            let mut points = perturbed_lattice(equations, 100, 0).unwrap();
            let progress = StopsAfter(AtomicU32::new(0), n_ticks);
            let result = solve_matrix_free(equations, &mut points, TOLERANCE, &progress);
            assert_eq!(result, Err(Error::Stopped(Stopped)));
            assert_eq!(progress.0.into_inner(), n_ticks + 1);
        }
        // A tick of the largest sets that are practical.
        let between = 0.5 * TRANSFORMS * Method::Auto.nominal_work(1_100_000, 1000);
        assert!(between * SECONDS_PER_WORK < 0.5);
    }
}
