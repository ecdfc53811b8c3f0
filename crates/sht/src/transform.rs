use glam::DVec3;
use sphvar_sh::{Alm, Error};

use crate::generators::{gradient_adjoint, moments_into};
use crate::legendre::FUNCTIONS;
use crate::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace};

/// Method of computing coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The method with less [nominal work](Method::nominal_work).
    #[default]
    Auto,
    /// Evaluates the definition, to rounding: [`ExactTransform`].
    Exact,
    /// Computes to the requested accuracy: [`FastTransform`].
    Fast,
}

impl Method {
    /// Returns the nominal work of transforming one set of `n_points` to degree `lmax`, in units of
    /// the cost of one point in the fast transform, about 60 ns on one core.
    ///
    /// [`Method::Auto`] takes the method with less work, and default numbers of realizations are
    /// derived from it. The constants were fitted once; they define a policy and are not measured
    /// at run time.
    ///
    /// ```text
    /// exact   (L + 1)^2 (max(N, 32)/480 + 1/20)           points x coefficients; recurrence
    /// fast    N + (L + 1)^2 (11/20 + (L + 1)/1500) + 333  spreading; grid; recurrence on rings
    /// ```
    #[must_use]
    pub fn nominal_work(self, n_points: usize, lmax: usize) -> f64 {
        let (n, degrees) = (n_points as f64, lmax as f64 + 1.0);
        let square = degrees * degrees;
        match self {
            Self::Auto => Self::Exact
                .nominal_work(n_points, lmax)
                .min(Self::Fast.nominal_work(n_points, lmax)),
            Self::Exact => square * (n.max(32.0) / 480.0 + 0.05),
            Self::Fast => n + square * (0.55 + degrees / 1500.0) + 333.0,
        }
    }
}

impl Method {
    /// Returns the method that [`Method::Auto`] resolves to; other methods are returned unchanged.
    fn chosen(self, n_points: usize, lmax: usize) -> Self {
        match self {
            Self::Exact | Self::Fast => self,
            Self::Auto => {
                let [exact, fast] =
                    [Self::Exact, Self::Fast].map(|method| method.nominal_work(n_points, lmax));
                if fast < exact { Self::Fast } else { Self::Exact }
            }
        }
    }

    /// Returns the memory in bytes of transforming `sets` sets in a batch, including points and
    /// coefficients: a lower bound that includes all large allocations.
    #[must_use]
    pub fn bytes(self, n_points: usize, lmax: usize, sets: u64) -> f64 {
        let (n, degrees) = (n_points as f64, lmax as f64 + 1.0);
        let copies = sets as f64;
        let coefficients = 8.0 * degrees * degrees * copies;
        match self {
            Self::Auto => self.chosen(n_points, lmax).bytes(n_points, lmax, sets),
            Self::Exact => coefficients + (24.0 * copies + 150.0) * n,
            // The grid is oversampled by 2 in both directions; its columns are stored for each set
            // of a group.
            Self::Fast => {
                let grid = (64.0 + 32.0 * copies.min(FUNCTIONS as f64)) * degrees * degrees;
                coefficients + grid + (24.0 * copies + 80.0) * n
            }
        }
    }
}

/// A transform by either method.
#[derive(Clone, Debug)]
pub struct Transform(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Exact(ExactTransform),
    Fast(Box<FastTransform>),
}

/// Workspace of [`Transform`].
#[derive(Debug, Default)]
pub struct TransformWorkspace {
    exact: ExactWorkspace,
    fast: FastWorkspace,
    moments: [Vec<f64>; 3],
    /// The coefficients of the moments.
    components: Option<[Alm; 3]>,
}

impl TransformWorkspace {
    /// Returns a workspace for transforms of one set, or a batch of few, on all threads of the
    /// current rayon pool by the fast method, as [`FastWorkspace::parallel`]. The exact method,
    /// which is used for little work, uses the caller's thread.
    #[must_use]
    pub fn parallel() -> Self {
        Self { fast: FastWorkspace::parallel(), ..Self::default() }
    }

    /// Sets whether the next transforms run on all threads, as with [`Self::parallel`], or on the
    /// caller's. The buffers are kept.
    pub fn set_parallel(&mut self, is_parallel: bool) {
        self.fast.set_parallel(is_parallel);
    }
}

impl Transform {
    /// Returns the transform to degree `lmax` for sets of about `n_points`. `epsilon` is the
    /// relative accuracy of the fast method; it is validated for every method.
    ///
    /// # Errors
    ///
    /// [`Error::Accuracy`] as for [`FastTransform::new`]; [`Error::DegreeTooLarge`] if `lmax`
    /// exceeds the limit of the coefficient index.
    pub fn new(method: Method, lmax: usize, n_points: usize, epsilon: f64) -> Result<Self, Error> {
        FastTransform::check_epsilon(epsilon)?;
        Ok(Self(if method.chosen(n_points, lmax) == Method::Fast {
            Kind::Fast(Box::new(FastTransform::new(lmax, epsilon)?))
        } else {
            Kind::Exact(ExactTransform::new(lmax)?)
        }))
    }

    /// Returns whether the fast method is used.
    #[must_use]
    pub fn is_fast(&self) -> bool {
        matches!(self.0, Kind::Fast(_))
    }

    /// Replaces each of `outs` by the coefficients of one weighted set of points. Results are
    /// bit-identical whether sets are transformed singly or in a batch.
    ///
    /// # Panics
    ///
    /// Panics if `outs` and `sets` differ in length, the weights of a set and its points differ in
    /// length, or one of `outs` has a different lmax.
    pub fn adjoint_batch_into(
        &self,
        sets: &[(&[DVec3], Option<&[f64]>)],
        workspace: &mut TransformWorkspace,
        outs: &mut [Alm],
    ) {
        match &self.0 {
            Kind::Fast(plan) => plan.adjoint_batch_into(sets, &mut workspace.fast, outs),
            Kind::Exact(transform) => {
                assert_eq!(sets.len(), outs.len(), "one output per set");
                for ((points, weights), out) in sets.iter().zip(outs) {
                    transform.adjoint_into(points, *weights, &mut workspace.exact, out);
                }
            }
        }
    }

    /// Writes the values of the real function with coefficients `alm` at the points, as
    /// [`FastTransform::synthesis_into`] does.
    ///
    /// # Panics
    ///
    /// Panics if `out` and `points` differ in length, or `alm` has a different lmax.
    pub fn synthesis_into(
        &self,
        alm: &Alm,
        points: &[DVec3],
        workspace: &mut TransformWorkspace,
        out: &mut [f64],
    ) {
        match &self.0 {
            Kind::Fast(plan) => plan.synthesis_into(alm, points, &mut workspace.fast, out),
            Kind::Exact(transform) => {
                transform.synthesis_into(alm, points, &mut workspace.exact, out);
            }
        }
    }

    /// Writes values and tangent gradients of a function at the points, as
    /// [`FastTransform::gradient_into`] does.
    ///
    /// # Panics
    ///
    /// Panics if `values` or `gradients` differ from `points` in length, or `alm` has a different
    /// lmax.
    pub fn gradient_into(
        &self,
        alm: &Alm,
        points: &[DVec3],
        workspace: &mut TransformWorkspace,
        values: &mut [f64],
        gradients: &mut [DVec3],
    ) {
        match &self.0 {
            Kind::Fast(plan) => {
                plan.gradient_into(alm, points, &mut workspace.fast, values, gradients);
            }
            Kind::Exact(transform) => {
                transform.gradient_into(alm, points, &mut workspace.exact, values, gradients);
            }
        }
    }

    /// Replaces `out` by the adjoint of [`Self::gradient_into`], the coefficients
    /// `sum_k v_k . grad conj Y_lm(x_k)` of tangent vectors v at the points. Parts of the vectors
    /// that are not tangent have no effect.
    ///
    /// # Panics
    ///
    /// Panics if `vectors` and `points` differ in length, or `out` has a different lmax.
    ///
    /// # Performance
    ///
    /// The cost is that of the coefficients of three weighted sets.
    pub fn gradient_adjoint_into(
        &self,
        points: &[DVec3],
        vectors: &[DVec3],
        workspace: &mut TransformWorkspace,
        out: &mut Alm,
    ) {
        assert_eq!(vectors.len(), points.len(), "one vector per point");
        let mut moments = std::mem::take(&mut workspace.moments);
        moments_into(points, vectors, &mut moments);
        let old = workspace.components.take().filter(|old| old[0].lmax() == out.lmax());
        let mut components = old.unwrap_or_else(|| std::array::from_fn(|_| out.clone()));
        let sets = moments.each_ref().map(|weights| (points, Some(weights.as_slice())));
        self.adjoint_batch_into(&sets, workspace, &mut components);
        gradient_adjoint(&components, out);
        workspace.moments = moments;
        workspace.components = Some(components);
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sphvar_sh::Alm;

    use super::{Method, Transform, TransformWorkspace};

    #[test]
    fn auto_selects_fast_for_many_points_and_exact_for_few() {
        let is_fast = |n, lmax| Transform::new(Method::Auto, lmax, n, 1e-12).unwrap().is_fast();
        assert!(is_fast(4096, 256) && is_fast(100_000, 512));
        assert!(!is_fast(12, 128) && !is_fast(4096, 4) && !is_fast(0, 0));
        assert!(Transform::new(Method::Fast, 4, 12, 1e-5).unwrap().is_fast());
        assert!(!Transform::new(Method::Exact, 512, 100_000, 1e-5).unwrap().is_fast());
    }

    /// `sum_k v_k . grad f(x_k)` by the gradients of f equals the product of the coefficients of f
    /// with the adjoint, for any f and any vectors, tangent or not; poles and repeated points are
    /// among the points.
    #[test]
    fn the_gradient_and_its_adjoint_are_adjoint() {
        let spiral = |k: i32| {
            let (z, phi) = (f64::from(k) / 20.0 - 0.995, 2.4 * f64::from(k));
            let s = (1.0 - z * z).sqrt();
            DVec3::new(s * phi.cos(), s * phi.sin(), z)
        };
        let mut points: Vec<DVec3> = (0..40).map(spiral).collect();
        points.extend([DVec3::Z, -DVec3::Z, points[7], DVec3::X]);
        let vector = |k: usize| spiral(i32::try_from(k * 7 % 40).unwrap()) * (1.0 + k as f64);
        let vectors: Vec<DVec3> = (0..points.len()).map(vector).collect();
        for lmax in [0, 1, 2, 7, 33] {
            for (method, epsilon) in
                [(Method::Exact, 1e-13), (Method::Fast, 1e-12), (Method::Fast, 1e-5)]
            {
                let transform = Transform::new(method, lmax, points.len(), epsilon).unwrap();
                let mut workspace = TransformWorkspace::default();
                let mut alm = Alm::zeros(lmax).unwrap();
                for (i, (l, m)) in alm.index().iter().enumerate() {
                    let imaginary = if m > 0 { (0.3 * i as f64).cos() } else { 0.0 };
                    alm[(l, m)] = num_complex::Complex::new((1.7 * i as f64).sin(), imaginary);
                }
                let mut adjoint = Alm::zeros(lmax).unwrap();
                transform.gradient_adjoint_into(&points, &vectors, &mut workspace, &mut adjoint);
                let (mut values, mut gradients) =
                    (vec![0.0; points.len()], vec![DVec3::ZERO; points.len()]);
                transform.gradient_into(&alm, &points, &mut workspace, &mut values, &mut gradients);
                let by_points: f64 = gradients.iter().zip(&vectors).map(|(g, v)| g.dot(*v)).sum();
                let by_degrees = crate::normal_equations::dot(&alm, &adjoint);
                let scale: f64 =
                    gradients.iter().zip(&vectors).map(|(g, v)| g.length() * v.length()).sum();
                // Both are the same sums of the same approximate harmonics, up to rounding of the
                // grid: f32 for the lowest accuracy.
                let rounding = if epsilon > 1e-6 { f64::from(f32::EPSILON) } else { f64::EPSILON };
                let tolerance = 64.0 * rounding * (lmax + 1) as f64 * scale;
                let off = (by_points - by_degrees).abs();
                assert!(off <= tolerance, "{method:?} {lmax} {epsilon:e}: {off:e} of {scale}");
            }
        }
    }
}
