use glam::DVec3;
use num_complex::Complex;
use sphvar_nufft::parts::magnitude;
use sphvar_sh::{Alm, Colatitude, Error};

use crate::generators::{RotationDerivatives, tangent_gradients};
use crate::{RingTransform, RingWorkspace};

/// The exact transforms between scattered points and coefficients: the adjoint
/// `a_lm = sum_k w_k conj Y_lm(x_k)`, the synthesis `f(x_k) = sum_lm a_lm Y_lm(x_k)`, and the gradient.
///
/// They evaluate the definition by recurrences in difference form, which keep their
/// accuracy at the poles and at the equator, several points to a vector register; the instruction set is chosen
/// at run time. Points at the poles, repeated points and N = 0 are ordinary inputs: sums over points are made of
/// short ones, which keep their accuracy for any number of points at one place (tested to 10^6). They are the oracle
/// for faster transforms.
///
/// Cost: about `N (lmax + 1)^2 / 4` steps of seven vector operations; memory: the coefficients
/// and some 150 bytes per point in the workspace.
#[derive(Clone, Debug)]
pub struct ExactTransform {
    rings: RingTransform,
}

/// Scratch memory of [`ExactTransform`]; grows to the largest set it has seen.
#[derive(Clone, Debug, Default)]
pub struct ExactWorkspace {
    rings: RingWorkspace,
    /// `e^{-i phi}` and `w e^{-i m phi}` of each point.
    turn: Vec<Complex<f64>>,
    terms: Vec<Complex<f64>>,
    /// By point and function.
    values: Vec<f64>,
    derivatives: Option<RotationDerivatives>,
}

impl ExactTransform {
    /// The transform to degree `lmax`, inclusive. Builds no tables.
    ///
    /// # Errors
    ///
    /// [`Error::DegreeTooLarge`] if `lmax` is beyond what coefficients can be indexed for.
    pub fn new(lmax: usize) -> Result<Self, Error> {
        Ok(Self { rings: RingTransform::new(lmax)? })
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
    /// As [`Self::adjoint_into`].
    pub fn adjoint(&self, points: &[DVec3], weights: Option<&[f64]>) -> Result<Alm, Error> {
        let mut alm = Alm::zeros(self.lmax())?;
        self.adjoint_into(points, weights, &mut ExactWorkspace::default(), &mut alm);
        Ok(alm)
    }

    /// Replaces `out` by the coefficients of the points.
    ///
    /// The points are unit vectors: their norms enter as rounding errors would. With a workspace
    /// that has seen as many points before, nothing is allocated.
    ///
    /// # Panics
    ///
    /// If `weights` and `points` differ in length, or `out` is not of this transform's lmax.
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
        let ExactWorkspace { rings, turn, terms, .. } = workspace;
        load_turns(points, turn);
        terms.clear();
        let size = weights.map_or(1.0, |w| magnitude(w.iter().copied()));
        let weight = |k: usize| weights.map_or(1.0, |w| w[k] / size);
        terms.extend((0..points.len()).map(|k| Complex::new(weight(k), 0.0)));
        // Every point is a ring of its own, with one Dirac on it.
        let colatitudes = points.iter().map(|&p| Colatitude::from_direction(p));
        self.rings.adjoint_into(
            colatitudes,
            |m, fourier| {
                if m > 0 {
                    for (term, turn) in terms.iter_mut().zip(&*turn) {
                        *term *= turn;
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
    /// If `out` and `points` differ in length, or `alm` is not of this transform's lmax.
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

    /// Writes values and tangent gradients of the function with coefficients `alm` at the points, as
    /// [`FastTransform::gradient_into`](crate::FastTransform::gradient_into).
    ///
    /// # Panics
    ///
    /// If `values` or `gradients` differ from `points` in length, or `alm` is not of this transform's
    /// lmax.
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

    /// Leaves the values of every function at each point in turn in the workspace.
    fn values_by_point(&self, alms: &[&Alm], points: &[DVec3], workspace: &mut ExactWorkspace) {
        let ExactWorkspace { rings, turn, terms, values, .. } = workspace;
        load_turns(points, turn);
        terms.clear();
        terms.resize(points.len(), Complex::ONE);
        values.clear();
        values.resize(points.len() * alms.len(), 0.0);
        let colatitudes = points.iter().map(|&p| Colatitude::from_direction(p));
        let emit = |m: usize, fourier: &[Complex<f64>]| {
            if m > 0 {
                for (term, turn) in terms.iter_mut().zip(&*turn) {
                    *term *= turn;
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

/// `e^{-i phi}` of each point; 1 at a pole, where only m = 0 counts, whatever the longitude.
fn load_turns(points: &[DVec3], turn: &mut Vec<Complex<f64>>) {
    turn.clear();
    turn.extend(points.iter().map(|p| {
        let sin_theta = p.x.hypot(p.y);
        if sin_theta > 0.0 { Complex::new(p.x / sin_theta, -p.y / sin_theta) } else { Complex::ONE }
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use sphvar_sh::lambda;

    /// The definition, point by point.
    fn definition(points: &[DVec3], weights: &[f64], lmax: usize) -> Alm {
        let mut alm = Alm::zeros(lmax).unwrap();
        for (p, w) in points.iter().zip(weights) {
            let phi = p.y.atan2(p.x);
            for m in 0..=lmax {
                let turn = Complex::cis(-(m as f64) * phi) * w;
                for (l, a) in (m..).zip(alm.column_mut(m)) {
                    *a += turn * lambda(l, m, Colatitude::from_direction(*p));
                }
            }
        }
        alm
    }

    fn unit(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z).normalize()
    }

    #[test]
    fn it_is_the_definition_on_hostile_points() {
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
                // lambda is good to 4 EPSILON (l+1), e^{i m phi} to about EPSILON m, |lambda| up
                // to sqrt((2l+1)/4 pi).
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
    fn values_below_the_range_of_f64_come_back() {
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
