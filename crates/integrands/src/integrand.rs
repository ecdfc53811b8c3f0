use glam::DVec3;
use sphvar_sh::ByParity;
use sphvar_sh::Domain;

use crate::{Coefficients, Energy, EnvironmentMap, Error, Shape, quadrature};

/// A real function of direction, to be integrated over the sphere or the hemisphere.
///
/// Only [`eval`](Self::eval) is required, and closures `Fn(DVec3) -> f64` are integrands; further
/// known properties allow tests of measurements (the exact integral) or predictions (the energy).
/// If the [`shape`](Self::shape) is known, everything else follows by quadrature, to rounding;
/// implementations with closed forms override the corresponding methods.
///
/// On the hemisphere F is the even extension of f from z >= 0 to the sphere.
///
/// Coefficients, squares and [`exact`](Self::exact) integrals are exact to rounding or unavailable.
/// Only [`integral_estimate`](Self::integral_estimate) and [`energy`](Self::energy) may return estimates, with their [`errors`](Energy::errors); a function with such energies has no
/// coefficients and no shape, so that no sum or product of it loses the errors.
pub trait Integrand: Sync {
    /// Returns the value at a unit vector; on the hemisphere only vectors with z >= 0 are
    /// evaluated.
    fn eval(&self, dir: DVec3) -> f64;

    /// Writes the values at many unit vectors to `values`, equal to those of [`eval`](Self::eval).
    /// Implement it for integrands that are evaluated faster in batches, or whose evaluation can
    /// fail.
    ///
    /// # Errors
    ///
    /// [`Error::Evaluation`] if values are unavailable.
    ///
    /// # Panics
    ///
    /// May panic if `values` and `dirs` differ in length.
    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        for (value, &dir) in values.iter_mut().zip(dirs) {
            *value = self.eval(dir);
        }
        Ok(())
    }

    /// Returns the edges of the function and its degree elsewhere.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if the shape is unknown.
    fn shape(&self) -> Result<Shape, Error> {
        Err(Error::NoEnergy {
            reason: "only its values are known; wrap it in `AdaptiveFunction` or `SampledFunction`, or \
                     implement `Integrand::shape`",
        })
    }

    /// Returns the environment map that the function is, if it is one: products with functions of z
    /// follow from its rows.
    fn environment_map(&self) -> Option<&EnvironmentMap> {
        None
    }

    /// Returns the exact integral of f over the domain, if it is known.
    fn exact(&self, domain: Domain) -> Option<f64> {
        quadrature::integral(&self.shape().ok()?, domain, &|dirs, values| {
            self.eval_into(dirs, values)
        })
        .ok()
    }

    /// Returns the integral of f over the domain and its error, 0 if it is exact to rounding; `None`
    /// if neither is known.
    fn integral_estimate(&self, domain: Domain) -> Option<(f64, f64)> {
        self.exact(domain).map(|integral| (integral, 0.0))
    }

    /// Returns the coefficients `F_lm` for l = 0 ..= `lmax`.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if they are not known, [`Error::Harmonics`] if `lmax` is out of range or
    /// memory is exhausted.
    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        quadrature::coefficients(&self.shape()?, domain, lmax, &|dirs, values| {
            self.eval_into(dirs, values)
        })
    }

    /// `int (F - mean F)^2` over the sphere of the even part `(F(x) + F(-x))/2` and of the odd part
    /// `(F(x) - F(-x))/2` of F: the energy of all even degrees from 2 on, and of all odd degrees.
    ///
    /// Implementations must not subtract the square of the mean from `int F^2`, which loses all
    /// digits for nearly constant functions, nor one parity from the total, which leaves rounding
    /// errors for functions of a single parity.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if it is not known.
    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        quadrature::centred_square(&self.shape()?, domain, &|dirs, values| {
            self.eval_into(dirs, values)
        })
    }

    /// `int F^2` over the sphere; on the hemisphere twice the integral of f^2.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if it is not known.
    fn square(&self, domain: Domain) -> Result<f64, Error> {
        let centred = self.centred_square(domain)?.sum();
        let unknown = Error::NoEnergy { reason: "its integral is not known" };
        let integral = self.exact(domain).ok_or(unknown)?;
        // The even extension has twice the integral over the hemisphere.
        let copies = if domain == Domain::Sphere { 1.0 } else { 2.0 };
        Ok(copies * integral * integral / domain.area() + centred)
    }

    /// Returns the coefficients to degree `lmax`, on the sphere, of the squares of the even part
    /// `(f(x) + f(-x))/2` and of the odd part `(f(x) - f(-x))/2` of f, from which the energies of
    /// products with other functions follow.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if they are not known, [`Error::Harmonics`] if `lmax` is out of range or
    /// memory is exhausted.
    fn squared_parts(&self, lmax: usize) -> Result<[Coefficients; 2], Error> {
        let both = self.shape()?.symmetrized();
        let square = both.product(&both);
        let part = |sign: f64| {
            quadrature::coefficients(&square, Domain::Sphere, lmax, &|dirs, values| {
                let antipodes: Vec<DVec3> = dirs.iter().map(|dir| -dir).collect();
                let mut opposite = vec![0.0; dirs.len()];
                self.eval_into(dirs, values)?;
                self.eval_into(&antipodes, &mut opposite)?;
                for (value, opposite) in values.iter_mut().zip(opposite) {
                    *value = (0.5 * (*value + sign * opposite)).powi(2);
                }
                Ok(())
            })
        };
        Ok([part(1.0)?, part(-1.0)?])
    }

    /// Returns the kurtosis of the value at a uniformly distributed direction of the domain, to
    /// some percent, if it is available at moderate cost: `E (f - E f)^4/(E (f - E f)^2)^2`.
    ///
    /// Its inverse is about the fraction of the domain that contributes to the variance, which
    /// determines the number of trials that can detect it. It does not depend on the scale of the
    /// function.
    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        quadrature::kurtosis(&self.shape().ok()?, domain, &|dirs, values| {
            self.eval_into(dirs, values)
        })
    }

    /// Returns the energy of F per degree up to `lmax`, and the total; estimated energies and those of
    /// functions with an [`energy_degree`](Self::energy_degree) may end at a lower degree.
    ///
    /// # Errors
    ///
    /// Those of [`coefficients`](Self::coefficients) and [`centred_square`](Self::centred_square).
    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        let per_degree = self.coefficients(domain, lmax)?.energy_per_degree()?;
        Ok(Energy::new(domain, per_degree, self.centred_square(domain)?))
    }

    /// Returns the largest degree up to `lmax` to which [`energy`](Self::energy) computes the energy
    /// per degree in moderate time; the energy of higher degrees is known in total only. Lower than
    /// `lmax` for functions with crossing edges.
    fn energy_degree(&self, _domain: Domain, lmax: usize) -> usize {
        lmax
    }

    /// Returns the approximate time in seconds of [`energy`](Self::energy) on one core, for
    /// progress only; 0 if it is small or unknown.
    fn energy_seconds(&self, _domain: Domain, _lmax: usize) -> f64 {
        0.0
    }

    /// Returns the degree of polynomials whose lobes are as narrow as the narrowest feature of the
    /// function: rules of half as many rings or more have nodes in it. `None` if it is unknown.
    fn feature_degree(&self) -> Option<usize> {
        self.shape().ok().map(|shape| shape.feature_degree())
    }

    /// Returns the degree beyond which the integrand has no energy, if there is one.
    fn band_limit(&self) -> Option<usize> {
        None
    }

    /// Returns a degree beyond which energies fall so fast (as l^-3 or faster) that a variance need
    /// not be summed much further, if there is one.
    fn resolved_degree(&self) -> Option<usize> {
        None
    }
}

impl<F: Fn(DVec3) -> f64 + Sync> Integrand for F {
    fn eval(&self, dir: DVec3) -> f64 {
        self(dir)
    }
}

/// Implements every method of [`Integrand`] by that of the function to which the type dereferences.
macro_rules! forwarded {
    () => {
        fn eval(&self, dir: DVec3) -> f64 {
            (**self).eval(dir)
        }

        fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
            (**self).eval_into(dirs, values)
        }

        fn shape(&self) -> Result<Shape, Error> {
            (**self).shape()
        }

        fn environment_map(&self) -> Option<&EnvironmentMap> {
            (**self).environment_map()
        }

        fn exact(&self, domain: Domain) -> Option<f64> {
            (**self).exact(domain)
        }

        fn integral_estimate(&self, domain: Domain) -> Option<(f64, f64)> {
            (**self).integral_estimate(domain)
        }

        fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
            (**self).coefficients(domain, lmax)
        }

        fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
            (**self).centred_square(domain)
        }

        fn square(&self, domain: Domain) -> Result<f64, Error> {
            (**self).square(domain)
        }

        fn squared_parts(&self, lmax: usize) -> Result<[Coefficients; 2], Error> {
            (**self).squared_parts(lmax)
        }

        fn kurtosis(&self, domain: Domain) -> Option<f64> {
            (**self).kurtosis(domain)
        }

        fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
            (**self).energy(domain, lmax)
        }

        fn energy_degree(&self, domain: Domain, lmax: usize) -> usize {
            (**self).energy_degree(domain, lmax)
        }

        fn energy_seconds(&self, domain: Domain, lmax: usize) -> f64 {
            (**self).energy_seconds(domain, lmax)
        }

        fn feature_degree(&self) -> Option<usize> {
            (**self).feature_degree()
        }

        fn band_limit(&self) -> Option<usize> {
            (**self).band_limit()
        }

        fn resolved_degree(&self) -> Option<usize> {
            (**self).resolved_degree()
        }
    };
}
pub(crate) use forwarded;

impl Integrand for Box<dyn Integrand + '_> {
    forwarded!();
}
