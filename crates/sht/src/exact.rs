use glam::DVec3;
use num_complex::Complex;
use sphvar_nufft::parts::magnitude;
use sphvar_sh::{Alm, Colatitude, Error};

use crate::generators::{RotationDerivatives, tangent_gradients};
use crate::{RingTransform, RingWorkspace};

/// Exact transforms between scattered points and coefficients: the adjoint
/// `a_lm = sum_k w_k conj Y_lm(x_k)`, the synthesis `f(x_k) = sum_lm a_lm Y_lm(x_k)`, and the
/// gradient.
///
/// The definition is evaluated by recurrences in difference form, which are accurate at the poles
/// and at the equator, for several points per vector register; the instruction set is selected at
/// run time. Points at the poles, repeated points and N = 0 are valid. Sums over points are split
/// into short partial sums, which are accurate for any number of points at one place (tested to
/// 10^6). The exact transforms are the reference for faster ones.
///
/// # Performance
///
/// About `N (lmax + 1)^2 / 4` steps of seven vector operations. The memory is that of the
/// coefficients and about 150 bytes per point in the workspace.
#[derive(Clone, Debug)]
pub struct ExactTransform {
    rings: RingTransform,
}

/// Workspace of [`ExactTransform`]; grows to the largest set so far.
#[derive(Clone, Debug, Default)]
pub struct ExactWorkspace {
    rings: RingWorkspace,
    /// `e^{-i phi}` of each point.
    phases: Vec<Complex<f64>>,
    /// `w e^{-i m phi}` of each point.
    terms: Vec<Complex<f64>>,
    /// Indexed by point and function.
    values: Vec<f64>,
    derivatives: Option<RotationDerivatives>,
}

impl ExactTransform {
    /// Returns the transform to degree `lmax`, inclusive. Builds no tables.
    ///
    /// # Errors
    ///
    /// [`Error::DegreeTooLarge`] if `lmax` exceeds the limit of the coefficient index.
    pub fn new(lmax: usize) -> Result<Self, Error> {
        Ok(Self { rings: RingTransform::new(lmax)? })
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
    /// Panics under the conditions of [`Self::adjoint_into`].
    pub fn adjoint(&self, points: &[DVec3], weights: Option<&[f64]>) -> Result<Alm, Error> {
        let mut alm = Alm::zeros(self.lmax())?;
        self.adjoint_into(points, weights, &mut ExactWorkspace::default(), &mut alm);
        Ok(alm)
    }

    /// Replaces `out` by the coefficients of the points.
    ///
    /// The points must be unit vectors; the relative error of a norm has the effect of a rounding
    /// error of that size. Nothing is allocated if the workspace has been used with at least as
    /// many points.
    ///
    /// # Panics
    ///
    /// Panics if `weights` and `points` differ in length, or the lmax of `out` differs from that of
    /// the transform.
    pub fn adjoint_into(
        &self,
        points: &[DVec3],
        weights: Option<&[f64]>,
        workspace: &mut ExactWorkspace,
        out: &mut Alm,
    ) {
        if let Some(weights) = weights {
            assert_eq!(weights.len(), points.len(), "one weight per point");
        }
        let ExactWorkspace { rings, phases, terms, .. } = workspace;
        load_phases(points, phases);
        terms.clear();
        let size = weights.map_or(1.0, |w| magnitude(w.iter().copied()));
        let weight = |k: usize| weights.map_or(1.0, |w| w[k] / size);
        terms.extend((0..points.len()).map(|k| Complex::new(weight(k), 0.0)));
        // Every point is a ring of its own with a single Dirac delta.
        let colatitudes = points.iter().map(|&p| Colatitude::from_direction(p));
        self.rings.adjoint_into(
            colatitudes,
            |m, fourier| {
                if m > 0 {
                    for (term, phase) in terms.iter_mut().zip(&*phases) {
                        *term *= phase;
                    }
                }
                fourier.copy_from_slice(terms);
            },
            rings,
            out,
        );
        if weights.is_some() {
            for a in out.values_mut() {
                *a *= size;
            }
        }
    }

    /// Writes the values of the real function with coefficients `alm` at the points,
    /// `f(x_k) = sum_lm a_lm Y_lm(x_k)`.
    ///
    /// # Panics
    ///
    /// Panics if `out` and `points` differ in length, or the lmax of `alm` differs from that of the
    /// transform.
    pub fn synthesis_into(
        &self,
        alm: &Alm,
        points: &[DVec3],
        workspace: &mut ExactWorkspace,
        out: &mut [f64],
    ) {
        assert_eq!(out.len(), points.len(), "one value per point");
        self.values_by_point(&[alm], points, workspace);
        out.copy_from_slice(&workspace.values);
    }

    /// Writes values and tangent gradients of the function with coefficients `alm` at the points,
    /// as [`FastTransform::gradient_into`](crate::FastTransform::gradient_into) does.
    ///
    /// # Panics
    ///
    /// Panics if `values` or `gradients` differ from `points` in length, or the lmax of `alm`
    /// differs from that of the transform.
    pub fn gradient_into(
        &self,
        alm: &Alm,
        points: &[DVec3],
        workspace: &mut ExactWorkspace,
        values: &mut [f64],
        gradients: &mut [DVec3],
    ) {
        let derivatives = RotationDerivatives::of(alm, workspace.derivatives.take());
        self.values_by_point(&derivatives.functions(alm), points, workspace);
        tangent_gradients(&workspace.values, points, values, gradients);
        workspace.derivatives = Some(derivatives);
    }

    /// Leaves the values of all functions at each point, point by point, in the workspace.
    fn values_by_point(&self, alms: &[&Alm], points: &[DVec3], workspace: &mut ExactWorkspace) {
        let ExactWorkspace { rings, phases, terms, values, .. } = workspace;
        load_phases(points, phases);
        terms.clear();
        terms.resize(points.len(), Complex::ONE);
        values.clear();
        values.resize(points.len() * alms.len(), 0.0);
        let colatitudes = points.iter().map(|&p| Colatitude::from_direction(p));
        let emit = |m: usize, fourier: &[Complex<f64>]| {
            if m > 0 {
                for (term, phase) in terms.iter_mut().zip(&*phases) {
                    *term *= phase;
                }
            }
            // Orders m and -m are complex conjugates.
            let copies = if m == 0 { 1.0 } else { 2.0 };
            for (b, of_function) in fourier.chunks_exact(points.len().max(1)).enumerate() {
                for (k, (f, term)) in of_function.iter().zip(&*terms).enumerate() {
                    values[k * alms.len() + b] += copies * (f.re * term.re + f.im * term.im);
                }
            }
        };
        self.rings.synthesis_batch_into(colatitudes, alms, emit, rings);
    }
}

/// Computes `e^{-i phi}` of each point; 1 at a pole, where only m = 0 contributes.
fn load_phases(points: &[DVec3], phases: &mut Vec<Complex<f64>>) {
    phases.clear();
    phases.extend(points.iter().map(|p| {
        let sin_theta = p.x.hypot(p.y);
        if sin_theta > 0.0 { Complex::new(p.x / sin_theta, -p.y / sin_theta) } else { Complex::ONE }
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use sphvar_sh::lambda;

    /// Returns the coefficients by the definition, point by point.
    fn definition(points: &[DVec3], weights: &[f64], lmax: usize) -> Alm {
        let mut alm = Alm::zeros(lmax).unwrap();
        for (p, w) in points.iter().zip(weights) {
            let phi = p.y.atan2(p.x);
            for m in 0..=lmax {
                let phase = Complex::cis(-(m as f64) * phi) * w;
                for (l, a) in (m..).zip(alm.column_mut(m)) {
                    *a += phase * lambda(l, m, Colatitude::from_direction(*p));
                }
            }
        }
        alm
    }

    fn unit(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z).normalize()
    }

    #[test]
    fn it_matches_the_definition_on_hostile_points() {
        let tiny = 1e-160;
        let sets: Vec<(&str, Vec<DVec3>)> = vec![
            ("none", vec![]),
            ("one", vec![unit(0.3, -0.4, 0.5)]),
            ("poles", vec![DVec3::Z, -DVec3::Z, unit(tiny, tiny, 1.0), unit(-1e-9, 1e-12, -1.0)]),
            ("equator", vec![DVec3::X, -DVec3::Y, unit(1.0, 1.0, 1e-17), unit(1.0, -2.0, -0.0)]),
            ("repeated", vec![unit(1.0, 2.0, 3.0); 41]),
            (
                "spiral",
                (0..77)
                    .map(|k| {
                        let t = f64::from(k) * 0.7;
                        unit(t.cos(), t.sin(), 0.05 * (f64::from(k) - 38.0))
                    })
                    .collect(),
            ),
        ];
        for (name, points) in sets {
            let weights: Vec<f64> =
                (0..points.len()).map(|k| 1.0 - 0.3 * (k as f64).sin()).collect();
            for lmax in [0, 1, 2, 9, 180] {
                let fast =
                    ExactTransform::new(lmax).unwrap().adjoint(&points, Some(&weights)).unwrap();
                let slow = definition(&points, &weights, lmax);
                let size: f64 = weights.iter().map(|w| w.abs()).sum();
                // The error of lambda is 4 EPSILON (l+1), that of e^{i m phi} about EPSILON m, and
                // |lambda| is up to sqrt((2l+1)/4 pi).
                let lmax_f = lmax as f64;
                let tolerance = 8.0 * f64::EPSILON * (lmax_f + 1.0) * (lmax_f + 1.0).sqrt() * size;
                for ((l, m), (a, b)) in
                    slow.index().iter().zip(fast.values().iter().zip(slow.values()))
                {
                    assert!((a - b).norm() <= tolerance, "{name}, l = {l}, m = {m}: {a} and {b}");
                }
            }
        }
    }

    #[test]
    fn values_below_the_range_of_f64_are_recovered() {
        // lambda_mm of these points is below 1e-308 for most m, while lambda_lm is not for large l.
        let points: Vec<DVec3> = [0.01, 0.05, 0.1, 0.3, 3.1]
            .iter()
            .map(|&t: &f64| DVec3::new(t.sin(), 0.0, t.cos()))
            .collect();
        let lmax = 3000;
        let alm = ExactTransform::new(lmax).unwrap().adjoint(&points, None).unwrap();
        for m in [150, 299, 300, 301, 800, 890, 1200] {
            for l in (m..=lmax).step_by(137).chain([lmax]) {
                let expected: f64 =
                    points.iter().map(|&p| lambda(l, m, Colatitude::from_direction(p))).sum();
                let got = alm.column(m)[l - m];
                let tolerance = 8.0 * f64::EPSILON * (l as f64 + 1.0) * (l as f64).sqrt() * 5.0;
                assert!(
                    (got - expected).norm() < tolerance,
                    "l = {l}, m = {m}: {got}, expected {expected}"
                );
            }
        }
    }
}
