use glam::DVec3;
use sphvar_sh::{Alm, ByParity, Domain};
use sphvar_sht::Fit;

use super::expansion::Expansion;
use crate::energy::norm;
use crate::{Coefficients, Energy, Error, Integrand, Shape};

/// A function known by values at scattered points: the least-squares [`Fit`] to them.
///
/// Fitted coefficients carry the noise of the values. The energy of each degree from 1 is that
/// without the noise, with its standard error; a degree whose estimate is negative has none. The
/// coefficients of a degree are scaled to its energy, so that the function whose integral is
/// measured has the energies from which errors are predicted.
///
/// # Examples
///
/// ```
/// use std::ops::ControlFlow;
/// use glam::DVec3;
/// use sphvar_integrands::{Domain, FittedFunction, Integrand};
/// use sphvar_sht::LeastSquares;
///
/// // Values of 1 + z at the vertices of a cube.
/// let signs = (0..8).map(|k| DVec3::new([1.0, -1.0][k % 2], [1.0, -1.0][k / 2 % 2], [1.0, -1.0][k / 4]));
/// let points: Vec<DVec3> = signs.map(|p| p.normalize()).collect();
/// let values: Vec<f64> = points.iter().map(|p| 1.0 + p.z).collect();
/// let problem = LeastSquares::new(&points, &values, Domain::Sphere).unwrap();
/// let fit = problem.solve(1, &mut || ControlFlow::Continue(())).unwrap();
/// let f = FittedFunction::new(&fit)?;
/// assert!((f.eval(DVec3::Z) - 2.0).abs() < 1e-12);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct FittedFunction {
    expansion: Expansion,
    domain: Domain,
    /// The standard errors of the energies of all degrees.
    stderr: Vec<f64>,
}

impl FittedFunction {
    /// Returns the function of a fit.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if the fit leaves no degrees of freedom, from which the noise is known;
    /// those of [`Expansion::new`].
    pub fn new(fit: &Fit) -> Result<Self, Error> {
        let unknown = Error::NoEnergy {
            reason: "the fit has as many coefficients as points, so that its noise is unknown; use a lower degree",
        };
        let mut alm: Alm = fit.alm.clone();
        let mut stderr = Vec::with_capacity(fit.energies.len());
        let mut factors = Vec::with_capacity(fit.energies.len());
        for (l, energy) in fit.energies.iter().enumerate() {
            let (Some(corrected), Some(error)) = (energy.corrected, energy.stderr) else {
                return Err(unknown);
            };
            let has_factor = l > 0 && energy.fitted > 0.0;
            let share = if has_factor { corrected.max(0.0) / energy.fitted } else { 1.0 };
            factors.push(share.sqrt());
            stderr.push(error);
        }
        for m in 0..=alm.lmax() {
            alm.column_mut(m).iter_mut().zip(&factors[m..]).for_each(|(a, factor)| *a *= factor);
        }
        Ok(Self { expansion: Expansion::new(alm)?, domain: fit.domain, stderr })
    }

    /// Returns a function with the standard errors of the energies per degree that it stands for.
    ///
    /// An even function with exact odd energies is also known on the hemisphere.
    pub(crate) fn of_estimates(expansion: Expansion, mut stderr: Vec<f64>) -> Self {
        let alm = expansion.alm();
        stderr.resize(stderr.len().max(alm.lmax() + 1), 0.0);
        let odd_energy = alm.energy_per_degree().into_iter().skip(1).step_by(2).sum::<f64>();
        let odd_error = stderr.iter().skip(1).step_by(2).sum::<f64>();
        let is_even = odd_energy + odd_error == 0.0;
        let domain = if is_even { Domain::Hemisphere } else { Domain::Sphere };
        Self { expansion, domain, stderr }
    }

    /// Returns the scaled coefficients as a function.
    #[must_use]
    pub fn expansion(&self) -> &Expansion {
        &self.expansion
    }
}

/// Energies of sums, products and filters follow from coefficients and values, whose errors a fit
/// does not state.
const NOT_COMBINED: Error = Error::NoEnergy {
    reason: "energies of values: are estimates with errors, which sums, products, filters and \
             projections do not carry; write the fit by `sphvar fit -o a.npy` and use alm:a.npy",
};

impl Integrand for FittedFunction {
    fn eval(&self, dir: DVec3) -> f64 {
        self.expansion.eval(dir)
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        self.expansion.eval_into(dirs, values)
    }

    fn shape(&self) -> Result<Shape, Error> {
        Err(NOT_COMBINED)
    }

    fn coefficients(&self, _domain: Domain, _lmax: usize) -> Result<Coefficients, Error> {
        Err(NOT_COMBINED)
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        self.expansion.exact(domain)
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        self.expansion.centred_square(domain)
    }

    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        // The even extension of a function on the sphere has other energies, whose errors the fit
        // does not state.
        if (domain, self.domain) == (Domain::Hemisphere, Domain::Sphere) {
            return Err(Error::NoEnergy {
                reason: "its energies were estimated on the sphere; values:...,hemisphere=yes fits values on the \
                         hemisphere",
            });
        }
        let mut per_degree = self.stderr.clone();
        per_degree.resize(lmax + 1, 0.0);
        let total = |first| norm(self.stderr.iter().copied().skip(first).step_by(2));
        let totals = ByParity { even: total(2), odd: total(1) };
        Ok(self.expansion.energy(domain, lmax)?.with_stderr(per_degree, totals))
    }

    fn energy_seconds(&self, domain: Domain, lmax: usize) -> f64 {
        self.expansion.energy_seconds(domain, lmax)
    }

    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        self.expansion.kurtosis(domain)
    }

    fn band_limit(&self) -> Option<usize> {
        self.expansion.band_limit()
    }
}
