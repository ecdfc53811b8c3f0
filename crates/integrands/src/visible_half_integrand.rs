use std::f64::consts::PI;

use glam::DVec3;
use sphvar_sh::Domain;

use crate::quadrature::Estimates;
use crate::{Cap, Energy, Error, Integrand, Shape};

/// The estimator of an integral over the hemisphere from the n points above the equator of a sphere
/// set of M points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VisibleHalfEstimator {
    /// `(4 pi/M) sum f`: unbiased.
    Unbiased,
    /// `(2 pi/n) sum f`: a ratio estimate, whose bias is of the order 1/M.
    Ratio,
}

/// The function that replaces f over the whole sphere for the visible half of a sphere set: `f 1_H`
/// for the unbiased estimate and, to first order in 1/M, `(f - mean f) 1_H` for the ratio estimate;
/// H is the hemisphere z >= 0.
///
/// Its energies on the sphere and the spectrum of the sphere set predict the variance of the
/// estimate (`sphvar_variance::predict`). The equator is an edge of this function unless f vanishes
/// there, so energies fall as l^-2 even if f is smooth.
pub struct VisibleHalfIntegrand<'a> {
    function: &'a dyn Integrand,
    /// 0, or the mean of f over the hemisphere.
    offset: f64,
    half: Cap,
    estimates: Estimates,
}

impl std::fmt::Debug for VisibleHalfIntegrand<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("VisibleHalfIntegrand").field("offset", &self.offset).finish_non_exhaustive()
    }
}

impl<'a> VisibleHalfIntegrand<'a> {
    /// Returns the function that `estimator` integrates in place of `function`.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if the ratio estimate requires an unknown integral over the hemisphere.
    pub fn new(
        function: &'a dyn Integrand,
        estimator: VisibleHalfEstimator,
    ) -> Result<Self, Error> {
        let offset = match estimator {
            VisibleHalfEstimator::Unbiased => 0.0,
            VisibleHalfEstimator::Ratio => {
                let unknown =
                    Error::NoEnergy { reason: "its integral over the hemisphere is not known" };
                function.exact(Domain::Hemisphere).ok_or(unknown)? / (2.0 * PI)
            }
        };
        Ok(Self { function, offset, half: Cap::half_space(0.0)?, estimates: Estimates::default() })
    }
}

impl Integrand for VisibleHalfIntegrand<'_> {
    fn eval(&self, dir: DVec3) -> f64 {
        self.half.eval(dir) * (self.function.eval(dir) - self.offset)
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        self.function.eval_into(dirs, values)?;
        for (value, &dir) in values.iter_mut().zip(dirs) {
            *value = self.half.eval(dir) * (*value - self.offset);
        }
        Ok(())
    }

    fn shape(&self) -> Result<Shape, Error> {
        // A constant has no zeros, so the sum with it loses the support of the function.
        let constant = (self.offset != 0.0).then(|| Shape::smooth(0).zonal(DVec3::Z).even());
        let function = self.function.shape()?;
        let whole = constant.map_or(function.clone(), |constant| function.sum(&constant));
        Ok(whole.product(&self.half.shape()?))
    }

    /// Returns estimates with their errors where exact energies would need too many values.
    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        self.estimates.energy(self, domain, lmax)
    }

    fn feature_degree(&self) -> Option<usize> {
        self.function.feature_degree()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::DQuat;
    use sphvar_sh::Domain;

    use super::{VisibleHalfEstimator, VisibleHalfIntegrand};
    use crate::{Cap, ClampedCosine, Harmonic, Integrand, Rotated};

    /// `int (f 1_H)^2` is half that of the even extension, and the centred one is smaller by
    /// `(int f)^2/(2 pi)`. A function that vanishes below the equator is its own upper half.
    #[test]
    fn energies_are_those_of_the_upper_half() {
        let cap = Cap::from_degrees(60.0).unwrap();
        let across = Rotated::new(cap, DQuat::from_rotation_x(1.0)).unwrap();
        let functions: [(&str, &dyn Integrand); 4] = [
            ("cap", &cap),
            ("cosine", &ClampedCosine),
            ("cap across the equator", &across),
            ("Y_42", &Harmonic::new(4, 2).unwrap()),
        ];
        for (name, function) in functions {
            let cut = |estimator| {
                let cut = VisibleHalfIntegrand::new(function, estimator).unwrap();
                cut.energy(Domain::Sphere, 400).unwrap()
            };
            let (unbiased, ratio) =
                (cut(VisibleHalfEstimator::Unbiased), cut(VisibleHalfEstimator::Ratio));
            let square = 0.5 * function.square(Domain::Hemisphere).unwrap();
            let integral = function.exact(Domain::Hemisphere).unwrap();
            // The quadrature is exact up to a few hundred roundings.
            let same = |got: f64, expected: f64| (got - expected).abs() <= 1e-12 * square;
            assert!(same(unbiased.total(), square), "{name}: {unbiased:?}");
            let centred = square - integral * integral / (2.0 * PI);
            assert!(same(ratio.total(), centred), "{name}: {}, {centred}", ratio.total());
            // The mean of the centred function is 0.
            assert!(ratio.per_band()[0] <= 1e-24 * square, "{name}: {}", ratio.per_band()[0]);
            if name == "cap" || name == "cosine" {
                let itself = function.energy(Domain::Sphere, 400).unwrap();
                for (a, b) in unbiased.per_band().iter().zip(itself.per_band()) {
                    assert!(same(*a, *b), "{name}: {a}, {b}");
                }
            }
        }
    }

    #[test]
    fn an_unknown_integral_is_an_error() {
        let closure = |dir: glam::DVec3| dir.x;
        assert!(VisibleHalfIntegrand::new(&closure, VisibleHalfEstimator::Unbiased).is_ok());
        assert!(VisibleHalfIntegrand::new(&closure, VisibleHalfEstimator::Ratio).is_err());
    }
}
