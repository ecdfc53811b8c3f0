use std::fmt;

use glam::DVec3;
use pulp::Arch;
use sphvar_nufft::parts::Design;
use sphvar_sh::{Alm, Error};

use crate::engine::{Engine, Scratch};
use crate::generators::{RotationDerivatives, tangent_gradients};
use crate::legendre::ValueRange;
use crate::{RingTransform, RingWorkspace};

/// The fast transforms between scattered points and coefficients to a requested accuracy: the adjoint
/// `a_lm = sum_k w_k conj Y_lm(x_k)`, the synthesis `f(x_k) = sum_lm a_lm Y_lm(x_k)`, and the gradient.
///
/// The sphere is laid twice on the torus, theta in [0, 2 pi), where a function of degree L is a
/// trigonometric polynomial. Points are spread onto a regular grid by a window; Fourier transforms,
/// divided by that of the window, take the grid to L + 2 rings of constant theta (Clenshaw-Curtis
/// nodes); from there a Legendre transform that is exact for degree L leads to the coefficients.
/// Synthesis is the transpose, step by step.
///
/// For an accuracy down to 5e-7 the grids are of f32; the Legendre stage is always of f64.
///
/// Cost O(N log^2(1/epsilon) + L^3) against O(N L^2) of [`ExactTransform`](crate::ExactTransform).
/// Calls allocate nothing once the workspace has seen as much.
#[derive(Clone)]
pub struct FastTransform {
    rings: RingTransform,
    design: Design,
    engine: Precision,
}

#[derive(Clone)]
enum Precision {
    Single(Engine<f32>),
    Double(Engine<f64>),
}

impl fmt::Debug for FastTransform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (kind, n_phi) = match &self.engine {
            Precision::Single(engine) => ("f32", engine.n_phi()),
            Precision::Double(engine) => ("f64", engine.n_phi()),
        };
        f.debug_struct("FastTransform")
            .field("lmax", &self.lmax())
            .field("window_width", &self.design.window.width())
            .field("grid", &(kind, n_phi))
            .finish_non_exhaustive()
    }
}

/// Scratch memory of [`FastTransform`]; grows to the largest input it has seen.
#[derive(Debug, Default)]
pub struct FastWorkspace {
    rings: RingWorkspace,
    single: Scratch<f32>,
    double: Scratch<f64>,
    derivatives: Option<RotationDerivatives>,
}

impl FastTransform {
    /// The smallest epsilon: rounding leaves no better accuracy.
    pub const MIN_EPSILON: f64 = sphvar_nufft::MIN_EPSILON;

    /// The largest epsilon.
    pub const MAX_EPSILON: f64 = sphvar_nufft::MAX_EPSILON;

    /// The plan for degree `lmax`, inclusive, and relative accuracy `epsilon` in [1e-13, 1e-1]: for
    /// weights of one sign the error `||a - a_exact||` is at most `epsilon ||a_exact||`. With weights
    /// that cancel, the norm is that of their absolute values.
    ///
    /// # Errors
    ///
    /// [`Error::Accuracy`] if `epsilon` is NaN or outside its range, [`Error::DegreeTooLarge`] if `lmax`
    /// is beyond what coefficients can be indexed for.
    pub fn new(lmax: usize, epsilon: f64) -> Result<Self, Error> {
        Self::with_arch(lmax, epsilon, Arch::new())
    }

    pub(crate) fn with_arch(lmax: usize, epsilon: f64, arch: Arch) -> Result<Self, Error> {
        let design = Self::design(epsilon)?;
        // Legendre functions of a thousandth of the accuracy do not show.
        let range = ValueRange::counting_from(0.001 * epsilon);
        let rings = RingTransform::with_arch(lmax, arch, range)?;
        let engine = if design.single {
            Precision::Single(Engine::new(lmax, design, arch))
        } else {
            Precision::Double(Engine::new(lmax, design, arch))
        };
        Ok(Self { rings, design, engine })
    }

    /// Accepts an `epsilon` from [`Self::MIN_EPSILON`] to [`Self::MAX_EPSILON`].
    ///
    /// # Errors
    ///
    /// [`Error::Accuracy`] if it is NaN or outside that range.
    pub fn check_epsilon(epsilon: f64) -> Result<(), Error> {
        Self::design(epsilon).map(|_| ())
    }

    fn design(epsilon: f64) -> Result<Design, Error> {
        let (min, max) = (Self::MIN_EPSILON, Self::MAX_EPSILON);
        Design::in_norm(epsilon).map_err(|_| Error::Accuracy { epsilon, min, max })
    }

    /// The largest degree, inclusive.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.rings.lmax()
    }

    /// The coefficients of the points, with unit weights if `weights` is `None`.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if the coefficients do not fit.
    ///
    /// # Panics
    ///
    /// If `weights` and `points` differ in length.
    pub fn adjoint(&self, points: &[DVec3], weights: Option<&[f64]>) -> Result<Alm, Error> {
        let mut alm = Alm::zeros(self.lmax())?;
        self.adjoint_into(points, weights, &mut FastWorkspace::default(), &mut alm);
        Ok(alm)
    }

    /// Replaces `out` by the coefficients of the points, with unit weights if `weights` is `None`.
    ///
    /// # Panics
    ///
    /// If `weights` and `points` differ in length, or `out` is not of this plan's lmax.
    pub fn adjoint_into(
        &self,
        points: &[DVec3],
        weights: Option<&[f64]>,
        workspace: &mut FastWorkspace,
        out: &mut Alm,
    ) {
        self.adjoint_batch_into(&[(points, weights)], workspace, std::slice::from_mut(out));
    }

    /// Replaces each of `outs` by the coefficients of one weighted set of points.
    ///
    /// The result for a set does not depend on its company, to the last bit, but the Legendre
    /// recurrence is shared: sets cost least in multiples of four.
    ///
    /// # Panics
    ///
    /// If there are not as many `outs` as `sets`, or as [`Self::adjoint_into`].
    pub fn adjoint_batch_into(
        &self,
        sets: &[(&[DVec3], Option<&[f64]>)],
        workspace: &mut FastWorkspace,
        outs: &mut [Alm],
    ) {
        assert_eq!(sets.len(), outs.len(), "one place for coefficients per set");
        for (points, weights) in sets {
            let n_weights = weights.map_or(points.len(), <[f64]>::len);
            assert_eq!(n_weights, points.len(), "one weight per point");
        }
        let FastWorkspace { rings, single, double, .. } = workspace;
        match &self.engine {
            Precision::Single(engine) => engine.adjoint(&self.rings, sets, rings, single, outs),
            Precision::Double(engine) => engine.adjoint(&self.rings, sets, rings, double, outs),
        }
    }

    /// Writes the values of the real function with coefficients `alm` at the points.
    ///
    /// The error at a point is at most `epsilon ||a|| (lmax + 1)/sqrt(4 pi)`, the largest value that a
    /// function with these coefficients could have, times epsilon; `||a||` counts m and -m.
    ///
    /// # Panics
    ///
    /// If `out` and `points` differ in length, or `alm` is not of this plan's lmax.
    pub fn synthesis_into(
        &self,
        alm: &Alm,
        points: &[DVec3],
        workspace: &mut FastWorkspace,
        out: &mut [f64],
    ) {
        self.synthesis_batch_into(&[alm], points, workspace, out);
    }

    /// Writes the values of several functions at the same points: function b at point k to
    /// `out[b * points.len() + k]`.
    ///
    /// Functions share the recurrence in groups of four, and the windows of the points.
    ///
    /// # Panics
    ///
    /// If `out` is not of length `alms.len() * points.len()`, or one of `alms` is not of this plan's
    /// lmax.
    pub fn synthesis_batch_into(
        &self,
        alms: &[&Alm],
        points: &[DVec3],
        workspace: &mut FastWorkspace,
        out: &mut [f64],
    ) {
        assert_eq!(out.len(), alms.len() * points.len(), "one place per function and point");
        if out.is_empty() {
            return;
        }
        let values = self.values_by_point(alms, points, workspace);
        for (b, out) in out.chunks_exact_mut(points.len()).enumerate() {
            for (out, values) in out.iter_mut().zip(values.chunks_exact(alms.len())) {
                *out = values[b];
            }
        }
    }

    /// Writes the values and the tangent gradients, `grad f(x) - x (x . grad f(x))` of any
    /// continuation off the sphere, of the function with coefficients `alm` at the points.
    ///
    /// The gradient comes from the derivatives for rotations about the three axes, which are functions
    /// of the same degree with known coefficients, so that poles are points as any other. Cost: a
    /// synthesis of four functions.
    ///
    /// # Panics
    ///
    /// If `values` or `gradients` differ from `points` in length, or `alm` is not of this plan's lmax.
    pub fn gradient_into(
        &self,
        alm: &Alm,
        points: &[DVec3],
        workspace: &mut FastWorkspace,
        values: &mut [f64],
        gradients: &mut [DVec3],
    ) {
        let derivatives = RotationDerivatives::of(alm, workspace.derivatives.take());
        let functions = self.values_by_point(&derivatives.functions(alm), points, workspace);
        tangent_gradients(functions, points, values, gradients);
        workspace.derivatives = Some(derivatives);
    }

    fn values_by_point<'w>(
        &self,
        alms: &[&Alm],
        points: &[DVec3],
        workspace: &'w mut FastWorkspace,
    ) -> &'w [f64] {
        let FastWorkspace { rings, single, double, .. } = workspace;
        match &self.engine {
            Precision::Single(engine) => {
                engine.synthesis(&self.rings, alms, points, rings, single);
                single.values()
            }
            Precision::Double(engine) => {
                engine.synthesis(&self.rings, alms, points, rings, double);
                double.values()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::ExactTransform;

    fn sets() -> Vec<(&'static str, Vec<DVec3>)> {
        let mut state = 1u64;
        let mut uniform = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 * 2f64.powi(-53)
        };
        let mut direction = move || {
            let (z, phi) = (1.0 - 2.0 * uniform(), TAU * uniform());
            let s = (1.0 - z * z).sqrt();
            DVec3::new(s * phi.cos(), s * phi.sin(), z)
        };
        let random: Vec<DVec3> = (0..300).map(|_| direction()).collect();
        let clustered = random.iter().map(|p| (*p * 1e-3 + DVec3::Y).normalize()).collect();
        let polar =
            random.iter().map(|p| DVec3::new(p.x * 1e-9, p.y * 1e-9, p.z.signum())).collect();
        vec![
            ("random", random),
            ("clustered", clustered),
            ("polar", polar),
            ("axes", vec![DVec3::Z, -DVec3::Z, DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y]),
            ("one", vec![DVec3::new(0.48, 0.6, 0.64)]),
            ("none", vec![]),
        ]
    }

    #[test]
    fn a_set_does_not_feel_its_company() {
        let plan = FastTransform::new(40, 1e-9).unwrap();
        let sets = sets();
        let weights: Vec<f64> = (0..300).map(|k| 1.0 + 0.1 * f64::from(k % 7)).collect();
        // Six sets: a full pass of the shared recurrence and two single ones.
        let batch: Vec<(&[DVec3], Option<&[f64]>)> = sets
            .iter()
            .map(|(_, p)| (p.as_slice(), (p.len() == 300).then_some(weights.as_slice())))
            .collect();
        let mut workspace = FastWorkspace::default();
        let mut together = vec![Alm::zeros(40).unwrap(); batch.len()];
        plan.adjoint_batch_into(&batch, &mut workspace, &mut together);
        for ((points, weights), together) in batch.iter().zip(&together) {
            let mut alone = Alm::zeros(40).unwrap();
            plan.adjoint_into(points, *weights, &mut workspace, &mut alone);
            assert_eq!(&alone, together);
            let exact = ExactTransform::new(40).unwrap().adjoint(points, *weights).unwrap();
            let size: f64 = exact.values().iter().map(|a| a.norm_sqr()).sum::<f64>().sqrt();
            for (a, b) in exact.values().iter().zip(alone.values()) {
                assert!((a - b).norm() <= 1e-9 * size, "{a} and {b}");
            }
        }
    }

    #[test]
    fn the_accuracy_asked_for_is_met() {
        let mut workspace = FastWorkspace::default();
        for (name, points) in sets() {
            for lmax in [0, 1, 2, 15, 200] {
                let exact = ExactTransform::new(lmax).unwrap().adjoint(&points, None).unwrap();
                let norm = exact.values().iter().map(|a| a.norm_sqr()).sum::<f64>().sqrt();
                for epsilon in [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-12, 1e-13] {
                    let mut fast = Alm::zeros(lmax).unwrap();
                    let plan = FastTransform::new(lmax, epsilon).unwrap();
                    plan.adjoint_into(&points, None, &mut workspace, &mut fast);
                    let error = exact
                        .values()
                        .iter()
                        .zip(fast.values())
                        .map(|(a, b)| (a - b).norm_sqr())
                        .sum::<f64>()
                        .sqrt();
                    assert!(
                        error <= epsilon * norm,
                        "{name}, lmax {lmax}, {epsilon:e}: {:e}",
                        error / norm
                    );
                }
            }
        }
    }

    #[test]
    fn the_portable_code_meets_the_accuracy_too() {
        let mut workspace = FastWorkspace::default();
        for (name, points) in sets() {
            let weights: Vec<f64> = (0..points.len()).map(|k| 1.0 - 0.1 * (k % 7) as f64).collect();
            let exact = ExactTransform::new(70).unwrap();
            let exact = exact.adjoint(&points, Some(&weights)).unwrap();
            let size = exact.values().iter().map(|a| a.norm_sqr()).sum::<f64>().sqrt();
            for epsilon in [1e-4, 1e-6, 1e-9, 1e-13] {
                let plan = FastTransform::with_arch(70, epsilon, Arch::Scalar).unwrap();
                let mut alms = [Alm::zeros(70).unwrap(), Alm::zeros(70).unwrap()];
                // One by itself, and one in a group of four.
                plan.adjoint_into(&points, Some(&weights), &mut workspace, &mut alms[0]);
                let mut group = vec![Alm::zeros(70).unwrap(); 4];
                let set = (points.as_slice(), Some(weights.as_slice()));
                plan.adjoint_batch_into(&[set; 4], &mut workspace, &mut group);
                alms[1].clone_from(&group[3]);
                for alm in &alms {
                    let differences = exact.values().iter().zip(alm.values());
                    let error = differences.map(|(a, b)| (a - b).norm_sqr()).sum::<f64>().sqrt();
                    assert!(error <= epsilon * size, "{name}, {epsilon:e}: {:e}", error / size);
                }
                // Synthesis is the transpose: <A x, y> = <x, A* y> with the other instructions too.
                let mut values = vec![0.0; points.len()];
                plan.synthesis_into(&exact, &points, &mut workspace, &mut values);
                let by_points: f64 = values.iter().zip(&weights).map(|(v, w)| v * w).sum();
                let by_degrees: f64 = (0..=70)
                    .map(|m| {
                        let copies = if m == 0 { 1.0 } else { 2.0 };
                        copies * exact.column(m).iter().map(|a| a.norm_sqr()).sum::<f64>()
                    })
                    .sum();
                let off = (by_points - by_degrees).abs();
                assert!(off <= 4.0 * epsilon * by_degrees, "{name}, {epsilon:e}: {off:e}");
            }
        }
    }
}
