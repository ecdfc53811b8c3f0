use glam::DVec3;
use sphvar_sh::{Alm, Error};

use crate::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace};

/// How coefficients are to be computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Whichever is of less [nominal work](Method::nominal_work).
    #[default]
    Auto,
    /// From the definition, to rounding: [`ExactTransform`].
    Exact,
    /// To the accuracy asked for: [`FastTransform`].
    Fast,
}

impl Method {
    /// Returns the nominal work of transforming one set of `n_points` to degree `lmax`, in units of what the fast
    /// transform does for one point, some 60 ns of one core.
    ///
    /// [`Method::Auto`] takes the method of less work, and numbers of realizations follow from it: it is a policy with
    /// constants that were fitted once, not a measurement.
    ///
    /// ```text
    /// exact   (L + 1)^2 (max(N, 32)/480 + 1/20)            a step for each point and coefficient, and the recurrence
    /// fast    N + (L + 1)^2 (11/20 + (L + 1)/1500) + 333   spreading, the grid, and the recurrence on its rings
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
    /// The method that [`Method::Auto`] stands for; another stands for itself.
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

    /// The bytes that the transform of `sets` sets at a time takes, points and coefficients included;
    /// an estimate from below that misses no large part.
    #[must_use]
    pub fn bytes(self, n_points: usize, lmax: usize, sets: u64) -> f64 {
        let (n, degrees) = (n_points as f64, lmax as f64 + 1.0);
        let copies = sets as f64;
        let coefficients = 8.0 * degrees * degrees * copies;
        match self {
            Self::Auto => self.chosen(n_points, lmax).bytes(n_points, lmax, sets),
            Self::Exact => coefficients + (24.0 * copies + 150.0) * n,
            // The grid is twice oversampled in either direction, its columns are kept for each set.
            Self::Fast => {
                let grid = (64.0 + 32.0 * copies) * degrees * degrees;
                coefficients + grid + (24.0 * copies + 80.0) * n
            }
        }
    }
}

/// The transforms by either method.
#[derive(Clone, Debug)]
pub struct Transform(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Exact(ExactTransform),
    Fast(Box<FastTransform>),
}

/// Scratch memory of [`Transform`].
#[derive(Debug, Default)]
pub struct TransformWorkspace {
    exact: ExactWorkspace,
    fast: FastWorkspace,
}

impl Transform {
    /// The transform to degree `lmax` for sets of about `n_points`; `epsilon` is the relative
    /// accuracy of the fast method, checked whichever is used.
    ///
    /// # Errors
    ///
    /// [`Error::Accuracy`] as [`FastTransform::new`], [`Error::DegreeTooLarge`] if `lmax` is beyond what coefficients can be indexed for.
    pub fn new(method: Method, lmax: usize, n_points: usize, epsilon: f64) -> Result<Self, Error> {
        FastTransform::check_epsilon(epsilon)?;
        Ok(Self(if method.chosen(n_points, lmax) == Method::Fast {
            Kind::Fast(Box::new(FastTransform::new(lmax, epsilon)?))
        } else {
            Kind::Exact(ExactTransform::new(lmax)?)
        }))
    }

    /// Whether the fast method is used.
    #[must_use]
    pub fn is_fast(&self) -> bool {
        matches!(self.0, Kind::Fast(_))
    }

    /// Replaces each of `outs` by the coefficients of one weighted set of points, whatever the
    /// company to the same bits.
    ///
    /// # Panics
    ///
    /// If there are not as many `outs` as `sets`, a set has not as many weights as points, or one of
    /// `outs` is of another lmax.
    pub fn adjoint_batch_into(
        &self,
        sets: &[(&[DVec3], Option<&[f64]>)],
        workspace: &mut TransformWorkspace,
        outs: &mut [Alm],
    ) {
        match &self.0 {
            Kind::Fast(plan) => plan.adjoint_batch_into(sets, &mut workspace.fast, outs),
            Kind::Exact(transform) => {
                assert_eq!(sets.len(), outs.len(), "one place for coefficients per set");
                for ((points, weights), out) in sets.iter().zip(outs) {
                    transform.adjoint_into(points, *weights, &mut workspace.exact, out);
                }
            }
        }
    }

    /// Writes values and tangent gradients of a function at the points, as
    /// [`FastTransform::gradient_into`].
    ///
    /// # Panics
    ///
    /// If `values` or `gradients` differ from `points` in length, or `alm` is of another lmax.
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
}

#[cfg(test)]
mod tests {
    use super::{Method, Transform};

    #[test]
    fn auto_is_fast_for_many_points_and_exact_for_few() {
        let is_fast = |n, lmax| Transform::new(Method::Auto, lmax, n, 1e-12).unwrap().is_fast();
        assert!(is_fast(4096, 256) && is_fast(100_000, 512));
        assert!(!is_fast(12, 128) && !is_fast(4096, 4) && !is_fast(0, 0));
        assert!(Transform::new(Method::Fast, 4, 12, 1e-5).unwrap().is_fast());
        assert!(!Transform::new(Method::Exact, 512, 100_000, 1e-5).unwrap().is_fast());
    }
}
