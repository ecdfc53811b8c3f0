use std::fmt;

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace};

/// The requested accuracies for f32 grids.
pub(crate) const SINGLE: [f64; 5] = [1e-3, 1e-4, 1e-5, 1e-6, 5e-7];
/// The requested accuracies for f64 grids.
pub(crate) const DOUBLE: [f64; 7] = [1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13];

/// The requested accuracy of a transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Accuracy {
    /// To rounding.
    Exact,
    /// To this epsilon, with the fast transform.
    Epsilon(f64),
}

impl Accuracy {
    /// Returns every accuracy tested.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        let fast = SINGLE.into_iter().chain(DOUBLE).map(Self::Epsilon);
        std::iter::once(Self::Exact).chain(fast)
    }

    /// Returns the transform for this accuracy: grids are of f32 down to 5e-7.
    pub(super) fn kind(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Epsilon(epsilon) if epsilon >= 5e-7 => "fast f32",
            Self::Epsilon(_) => "fast f64",
        }
    }

    /// Returns the end of a case's name.
    pub(super) fn words(self) -> String {
        match self {
            Self::Exact => String::new(),
            Self::Epsilon(epsilon) => format!(", epsilon = {epsilon:e}"),
        }
    }

    /// Returns the error bound of coefficients, relative to the norm of all.
    ///
    /// The error of exact coefficients for points at one place has several sources: `e^{-i phi}`,
    /// accurate to about 2/3 EPSILON, whose power m multiplies the error by m; the Legendre
    /// function of degree l, with a fraction of l EPSILON; sums and constants. For points all over
    /// the sphere these errors partly cancel.
    pub(super) fn bound(self, lmax: usize) -> f64 {
        match self {
            Self::Exact => f64::EPSILON * (lmax as f64 + 32.0),
            Self::Epsilon(epsilon) => epsilon,
        }
    }

    /// Returns [`Self::bound`] for points all over the sphere.
    pub(super) fn bound_all_over(self, lmax: usize) -> f64 {
        if self == Self::Exact { 0.5 * self.bound(lmax) } else { self.bound(lmax) }
    }

    /// Returns the transform with its memory.
    pub(super) fn plan(self, lmax: usize) -> Plan {
        const DEGREE: &str = "a degree of some thousands";
        match self {
            Self::Exact => Plan::Exact(ExactTransform::new(lmax).expect(DEGREE), Box::default()),
            Self::Epsilon(epsilon) => {
                let transform = FastTransform::new(lmax, epsilon).expect(DEGREE);
                Plan::Fast(Box::new(transform), Box::default())
            }
        }
    }
}

/// A transform with its workspace.
pub(super) enum Plan {
    Exact(ExactTransform, Box<ExactWorkspace>),
    Fast(Box<FastTransform>, Box<FastWorkspace>),
}

impl fmt::Debug for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exact(transform, _) => transform.fmt(f),
            Self::Fast(transform, _) => transform.fmt(f),
        }
    }
}

impl Plan {
    /// Replaces `out` by the coefficients of points.
    pub(super) fn adjoint(&mut self, points: &[DVec3], weights: Option<&[f64]>, out: &mut Alm) {
        match self {
            Self::Exact(transform, space) => transform.adjoint_into(points, weights, space, out),
            Self::Fast(transform, space) => transform.adjoint_into(points, weights, space, out),
        }
    }

    /// Replaces `out` by the values of a function.
    pub(super) fn synthesis(&mut self, alm: &Alm, points: &[DVec3], out: &mut [f64]) {
        match self {
            Self::Exact(transform, space) => transform.synthesis_into(alm, points, space, out),
            Self::Fast(transform, space) => transform.synthesis_into(alm, points, space, out),
        }
    }
}
