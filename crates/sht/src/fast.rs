use std::fmt;

use glam::DVec3;
use pulp::Arch;
use sphvar_nufft::parts::{Design, Threads};
use sphvar_sh::{Alm, Error};

use crate::engine::{Engine, Scratch};
use crate::generators::{RotationDerivatives, tangent_gradients};
use crate::legendre::Arithmetic;
use crate::{Method, RingTransform};

/// Fast transforms between scattered points and coefficients to a requested accuracy: the adjoint
/// `a_lm = sum_k w_k conj Y_lm(x_k)`, the synthesis `f(x_k) = sum_lm a_lm Y_lm(x_k)`, and the
/// gradient.
///
/// The sphere covers the torus twice, theta in [0, 2 pi), where a function of degree L is a
/// trigonometric polynomial. The adjoint spreads the points onto a regular grid with a window. A
/// Fourier transform, divided by that of the window, yields Fourier coefficients on L + 2 rings of
/// constant theta (Clenshaw-Curtis nodes). A Legendre transform that is exact for degree L yields
/// the coefficients. Synthesis is the transpose, step by step.
///
/// For `epsilon >= 5e-7` the grids are in f32. From 2e-7 on so are the values and short sums of the
/// Legendre stage except near the equator; its recurrence and long sums are always in f64.
///
/// # Performance
///
/// The cost is O(N log^2(1/epsilon) + L^3), compared with O(N L^2) of
/// [`ExactTransform`](crate::ExactTransform). Calls on one thread do not allocate once the
/// workspace has been used for inputs of the same size.
///
/// A workspace of [`FastWorkspace::parallel`] divides each stage among the threads of the current
/// rayon pool: points and rows of tiles, rows of the grid, and blocks of eight orders.
#[derive(Clone)]
pub struct FastTransform {
    rings: RingTransform,
    design: Design,
    engine: Precision,
}

/// The minimum nominal work of a call that is divided among threads, about a millisecond.
const MIN_SHARED_WORK: f64 = 2e4;

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

/// Workspace of [`FastTransform`]; grows to the largest input so far.
///
/// A default workspace uses the caller's thread, for callers that divide many sets among threads.
#[derive(Debug, Default)]
pub struct FastWorkspace {
    threads: Threads,
    single: Scratch<f32>,
    double: Scratch<f64>,
    derivatives: Option<RotationDerivatives>,
}

impl FastWorkspace {
    /// Returns a workspace for transforms of one set, or a batch of few, on all threads of the
    /// current rayon pool. Results are bit-identical for any number of threads.
    #[must_use]
    pub fn parallel() -> Self {
        Self { threads: Threads::Pool, ..Self::default() }
    }

    /// Sets whether the next transforms run on all threads, as with [`Self::parallel`], or on the
    /// caller's. The buffers are kept.
    pub fn set_parallel(&mut self, is_parallel: bool) {
        self.threads = if is_parallel { Threads::Pool } else { Threads::Caller };
    }
}

impl FastTransform {
    /// The minimum epsilon, limited by rounding.
    pub const MIN_EPSILON: f64 = sphvar_nufft::MIN_EPSILON;

    /// The maximum epsilon.
    pub const MAX_EPSILON: f64 = sphvar_nufft::MAX_EPSILON;

    /// Returns the plan for degree `lmax`, inclusive, and relative accuracy `epsilon` in
    /// [1e-13, 1e-1].
    ///
    /// For weights of one sign the error `||a - a_exact||` is at most `epsilon ||a_exact||`. For
    /// weights of mixed sign, it is relative to the norm for their absolute values. Rounding in the
    /// recurrence over the degree limits the error to about `lmax EPSILON/3` for points at the
    /// equator, measured at degree 2048, so beyond degree 1000 it can exceed an epsilon of 1e-13.
    ///
    /// # Errors
    ///
    /// [`Error::Accuracy`] if `epsilon` is NaN or out of range; [`Error::DegreeTooLarge`] if `lmax`
    /// exceeds the limit of the coefficient index.
    pub fn new(lmax: usize, epsilon: f64) -> Result<Self, Error> {
        Self::with_arch(lmax, epsilon, Arch::new())
    }

    pub(crate) fn with_arch(lmax: usize, epsilon: f64, arch: Arch) -> Result<Self, Error> {
        let design = Self::design(epsilon)?;
        let arithmetic = Arithmetic::new(epsilon, lmax);
        let rings = RingTransform::with_arch(lmax, arch, arithmetic)?;
        let engine = if design.single {
            Precision::Single(Engine::new(lmax, design, arch))
        } else {
            Precision::Double(Engine::new(lmax, design, arch))
        };
        Ok(Self { rings, design, engine })
    }

    /// Checks that `epsilon` is between [`Self::MIN_EPSILON`] and [`Self::MAX_EPSILON`].
    ///
    /// # Errors
    ///
    /// [`Error::Accuracy`] if it is NaN or out of range.
    pub fn check_epsilon(epsilon: f64) -> Result<(), Error> {
        Self::design(epsilon).map(|_| ())
    }

    fn design(epsilon: f64) -> Result<Design, Error> {
        let (min, max) = (Self::MIN_EPSILON, Self::MAX_EPSILON);
        Design::in_norm(epsilon).map_err(|_| Error::Accuracy { epsilon, min, max })
    }

    /// Returns the maximum degree, inclusive.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.rings.lmax()
    }

    /// Returns the coefficients of the points; `weights` of `None` means unit weights.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfMemory`] if allocation of the coefficients fails.
    ///
    /// # Panics
    ///
    /// Panics if `weights` and `points` differ in length.
    pub fn adjoint(&self, points: &[DVec3], weights: Option<&[f64]>) -> Result<Alm, Error> {
        let mut alm = Alm::zeros(self.lmax())?;
        self.adjoint_into(points, weights, &mut FastWorkspace::default(), &mut alm);
        Ok(alm)
    }

    /// Replaces `out` by the coefficients of the points; `weights` of `None` means unit weights.
    ///
    /// # Panics
    ///
    /// Panics if `weights` and `points` differ in length, or the lmax of `out` differs from that of
    /// the plan.
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
    /// Results are bit-identical whether sets are transformed singly or in a batch.
    ///
    /// # Panics
    ///
    /// Panics if `outs` and `sets` differ in length, or under the conditions of
    /// [`Self::adjoint_into`].
    ///
    /// # Performance
    ///
    /// Up to four sets share a pass of the Legendre recurrence, so batches are most efficient in
    /// multiples of four.
    pub fn adjoint_batch_into(
        &self,
        sets: &[(&[DVec3], Option<&[f64]>)],
        workspace: &mut FastWorkspace,
        outs: &mut [Alm],
    ) {
        assert_eq!(sets.len(), outs.len(), "one output per set");
        for (points, weights) in sets {
            let n_weights = weights.map_or(points.len(), <[f64]>::len);
            assert_eq!(n_weights, points.len(), "one weight per point");
        }
        let n_points = sets.iter().map(|(points, _)| points.len()).sum();
        let threads = self.threads(workspace, n_points, sets.len());
        let FastWorkspace { single, double, .. } = workspace;
        let rings = &self.rings;
        threads.enter(|| match &self.engine {
            Precision::Single(engine) => engine.adjoint(rings, sets, threads, single, outs),
            Precision::Double(engine) => engine.adjoint(rings, sets, threads, double, outs),
        });
    }

    /// Writes the values of the real function with coefficients `alm` at the points.
    ///
    /// The error at a point is at most `epsilon ||a|| (lmax + 1)/sqrt(4 pi)`, epsilon times the
    /// maximum value of any function with this norm; `||a||` counts both m and -m.
    ///
    /// # Panics
    ///
    /// Panics if `out` and `points` differ in length, or the lmax of `alm` differs from that of the
    /// plan.
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
    /// # Panics
    ///
    /// Panics if the length of `out` is not `alms.len() * points.len()`, or the lmax of one of
    /// `alms` differs from that of the plan.
    ///
    /// # Performance
    ///
    /// Functions share the recurrence in groups of four, and the window values of the points.
    pub fn synthesis_batch_into(
        &self,
        alms: &[&Alm],
        points: &[DVec3],
        workspace: &mut FastWorkspace,
        out: &mut [f64],
    ) {
        assert_eq!(out.len(), alms.len() * points.len(), "one value per function and point");
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

    /// Writes the values and tangent gradients of the function with coefficients `alm` at the
    /// points. The tangent gradient is `grad f(x) - x (x . grad f(x))` of any extension of f off
    /// the sphere.
    ///
    /// It is computed from the derivatives with respect to rotations about the three axes, which
    /// are functions of the same degree with known coefficients. The poles therefore need no
    /// special treatment.
    ///
    /// # Panics
    ///
    /// Panics if `values` or `gradients` differ from `points` in length, or the lmax of `alm`
    /// differs from that of the plan.
    ///
    /// # Performance
    ///
    /// The cost is that of a synthesis of four functions.
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

    /// Returns the threads for a call: only the caller's if there is little work, which would take
    /// less time than to wake others.
    fn threads(&self, workspace: &FastWorkspace, n_points: usize, n_sets: usize) -> Threads {
        let grids = Method::Fast.nominal_work(0, self.lmax()) * n_sets as f64;
        if n_points as f64 + grids < MIN_SHARED_WORK { Threads::Caller } else { workspace.threads }
    }

    fn values_by_point<'w>(
        &self,
        alms: &[&Alm],
        points: &[DVec3],
        workspace: &'w mut FastWorkspace,
    ) -> &'w [f64] {
        let threads = self.threads(workspace, points.len(), alms.len());
        let FastWorkspace { single, double, .. } = workspace;
        let rings = &self.rings;
        threads.enter(|| match &self.engine {
            Precision::Single(engine) => {
                engine.synthesis(rings, alms, points, threads, single);
                single.values()
            }
            Precision::Double(engine) => {
                engine.synthesis(rings, alms, points, threads, double);
                double.values()
            }
        })
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
    fn batched_and_single_transforms_are_bit_identical() {
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
    fn the_requested_accuracy_is_met() {
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
    fn the_portable_code_meets_the_requested_accuracy() {
        let mut workspace = FastWorkspace::default();
        for (name, points) in sets() {
            let weights: Vec<f64> = (0..points.len()).map(|k| 1.0 - 0.1 * (k % 7) as f64).collect();
            let exact = ExactTransform::new(70).unwrap();
            let exact = exact.adjoint(&points, Some(&weights)).unwrap();
            let size = exact.values().iter().map(|a| a.norm_sqr()).sum::<f64>().sqrt();
            for epsilon in [1e-4, 1e-6, 1e-9, 1e-13] {
                let plan = FastTransform::with_arch(70, epsilon, Arch::Scalar).unwrap();
                let mut alms = [Alm::zeros(70).unwrap(), Alm::zeros(70).unwrap()];
                // Once alone, and once in a group of four.
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
                // Synthesis is the transpose: <A x, y> = <x, A* y> for this instruction set as
                // well.
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
