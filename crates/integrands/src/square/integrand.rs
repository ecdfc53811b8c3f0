use sphvar_sh::Frequencies;

use crate::{Energy, Error};

/// A real function G on the unit square, to be integrated over it.
///
/// Points [u, v] are in [0, 1)^2. The Fourier coefficients of G, extended with period 1 in both
/// coordinates, are
///
/// ```text
/// G_k = int int G(u, v) exp(-2 pi i (k1 u + k2 v)) du dv
/// ```
///
/// and the energy of the pair of frequencies {k, -k} is `|G_k|^2 + |G_-k|^2 = 2 |G_k|^2`. The
/// variance of an integral from a point set with a random toroidal shift is their sum, weighted with
/// the power of the set (Cranley and Patterson 1976).
///
/// Only [`eval`](Self::eval) is required, and closures `Fn([f64; 2]) -> f64` are integrands; further
/// known properties allow tests of measurements (the exact integral) or predictions (the energy).
pub trait SquareIntegrand: Sync {
    /// Returns the value at a point of [0, 1)^2.
    fn eval(&self, point: [f64; 2]) -> f64;

    /// Writes the values at many points to `values`, equal to those of [`eval`](Self::eval).
    /// Implement it for integrands that are evaluated faster in batches, or whose evaluation can
    /// fail.
    ///
    /// # Errors
    ///
    /// [`Error::Evaluation`] if values are unavailable.
    ///
    /// # Panics
    ///
    /// May panic if `values` and `points` differ in length.
    fn eval_into(&self, points: &[[f64; 2]], values: &mut [f64]) -> Result<(), Error> {
        for (value, &point) in values.iter_mut().zip(points) {
            *value = self.eval(point);
        }
        Ok(())
    }

    /// Returns the integral over the square to rounding, if it is known.
    fn exact(&self) -> Option<f64> {
        None
    }

    /// Returns the integral and its error, 0 if it is exact to rounding; `None` if neither is known.
    fn integral_estimate(&self) -> Option<(f64, f64)> {
        self.exact().map(|integral| (integral, 0.0))
    }

    /// Returns the energy of every band, and the totals of the bands off the axes, of (k, 0) and of
    /// (0, k), which are the variances of three uncorrelated parts of the function:
    ///
    /// ```text
    /// G(u, v) = mean + a(u) + b(v) + c(u, v),   a(u) = int G(u, v) dv - mean,   b likewise
    /// ```
    ///
    /// Estimated energies may end at a lower band.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if the energies are not known, [`Error::Harmonics`] if memory is
    /// exhausted.
    fn energy(&self, _frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        Err(Error::NoEnergy {
            reason: "only its values are known; implement `SquareIntegrand::energy`",
        })
    }

    /// Returns the kurtosis of the value at a uniformly distributed point, `E (G - E G)^4/(E (G - E
    /// G)^2)^2`, to some percent, if it is known; its inverse is about the fraction of the square
    /// that contributes to the variance.
    fn kurtosis(&self) -> Option<f64> {
        None
    }

    /// Returns the width of the narrowest feature, at most 1: more than two points in it along both
    /// coordinates do not miss it. `None` if it is unknown.
    fn feature_size(&self) -> Option<f64> {
        None
    }

    /// Returns a length of frequencies beyond which the integrand has no energy, if there is one.
    fn band_limit(&self) -> Option<usize> {
        None
    }

    /// Returns the variation in the sense of Hardy and Krause, if it is finite and known: the
    /// variation of Vitali on the square plus the variations along the sides u = 1 and v = 1.
    ///
    /// The error of the mean over a point set is at most this times its star discrepancy
    /// (Koksma and Hlawka; Niederreiter 1992, theorem 2.11).
    fn variation(&self) -> Option<f64> {
        None
    }
}

impl<F: Fn([f64; 2]) -> f64 + Sync> SquareIntegrand for F {
    fn eval(&self, point: [f64; 2]) -> f64 {
        self(point)
    }
}

impl SquareIntegrand for Box<dyn SquareIntegrand + '_> {
    fn eval(&self, point: [f64; 2]) -> f64 {
        (**self).eval(point)
    }

    fn eval_into(&self, points: &[[f64; 2]], values: &mut [f64]) -> Result<(), Error> {
        (**self).eval_into(points, values)
    }

    fn exact(&self) -> Option<f64> {
        (**self).exact()
    }

    fn integral_estimate(&self) -> Option<(f64, f64)> {
        (**self).integral_estimate()
    }

    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        (**self).energy(frequencies)
    }

    fn kurtosis(&self) -> Option<f64> {
        (**self).kurtosis()
    }

    fn feature_size(&self) -> Option<f64> {
        (**self).feature_size()
    }

    fn band_limit(&self) -> Option<usize> {
        (**self).band_limit()
    }

    fn variation(&self) -> Option<f64> {
        (**self).variation()
    }
}
