use std::fmt;

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace};

/// What f32 grids are asked for.
pub(crate) const SINGLE: [f64; 5] = [1e-3, 1e-4, 1e-5, 1e-6, 5e-7];
/// What f64 grids are asked for.
pub(crate) const DOUBLE: [f64; 7] = [1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13];

/// How accurately a transform is asked to compute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Accuracy {
    /// To rounding.
    Exact,
    /// To this epsilon, by the fast transform.
    Epsilon(f64),
}

impl Accuracy {
    /// Every accuracy that is tried.
    pub(super) fn ladder() -> impl Iterator<Item = Self> {
        let fast = SINGLE.into_iter().chain(DOUBLE).map(Self::Epsilon);
        std::iter::once(Self::Exact).chain(fast)
    }

    /// The transform that computes so: grids are of f32 down to 5e-7.
    pub(super) fn kind(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Epsilon(epsilon) if epsilon >= 5e-7 => "fast f32",
            Self::Epsilon(_) => "fast f64",
        }
    }

    /// The end of a case's name.
    pub(super) fn words(self) -> String {
        match self {
            Self::Exact => String::new(),
            Self::Epsilon(epsilon) => format!(", epsilon = {epsilon:e}"),
        }
    }

    /// What the error of coefficients, relative to the norm of all, must not exceed.
    ///
    /// Exact coefficients of points at one place have an error from `e^{-i phi}`, which is right to some 2/3 EPSILON,
    /// and its power m to m times that; from the Legendre function of degree l, to a part of l EPSILON; and from sums
    /// and constants. Those of points all over the sphere go either way.
    pub(super) fn bound(self, lmax: usize) -> f64 {
        match self {
            Self::Exact => f64::EPSILON * (lmax as f64 + 32.0),
            Self::Epsilon(epsilon) => epsilon,
        }
    }

    /// [`Self::bound`] for points all over the sphere.
    pub(super) fn bound_all_over(self, lmax: usize) -> f64 {
        if self == Self::Exact { 0.5 * self.bound(lmax) } else { self.bound(lmax) }
    }

    /// The transform and its memory.
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

/// A transform with the memory that it works in.
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
