//! The coefficients of a function in real spherical harmonics as integrals, and their errors.

mod coefficient;
mod harmonic_products;
mod irradiance;
mod real_harmonics;

use std::collections::BTreeMap;
use std::f64::consts::{PI, SQRT_2};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use glam::DVec3;
use sphvar_sh::{Alm, ByParity, Domain};

use self::harmonic_products::for_each_product;
use self::real_harmonics::{RealHarmonics, orders};
use crate::{Coefficients, Energy, Error, Integrand, VectorIntegrand};

pub use self::coefficient::ProjectedCoefficient;
pub use self::irradiance::Irradiance;

/// The projection of a function onto the real spherical harmonics to a degree: the integrals
/// `F_lm = int f Y_lm` over the sphere, estimated from the same directions, as a light probe does
/// with its rays.
///
/// It is a [`VectorIntegrand`] with the component `f Y_lm` at the index `l (l + 1) + m`; the
/// harmonics are those of [`Harmonic`](crate::Harmonic). Each component is an integrand of its own
/// ([`coefficient`](Self::coefficient)), whose energies follow from the coefficients of f and of
/// the squares of its even and odd parts, without a grid. [`irradiance`](Self::irradiance) is their
/// sum for the error of the irradiance over all normals.
///
/// # Performance
///
/// Energies of all components to a degree L take one transform of f to L plus the degree of the
/// projection and one pass over its coefficients for each component; they are computed together
/// and kept.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{Cap, Domain, HarmonicProjection, Integrand};
///
/// let cap = Cap::half_space(0.0)?;
/// let probe = HarmonicProjection::new(&cap, 2)?;
/// // int_0^1 sqrt(3/(4 pi)) z 2 pi dz
/// let pi = std::f64::consts::PI;
/// let f_10 = probe.coefficient(1, 0)?;
/// assert!((f_10.exact(Domain::Sphere).unwrap() - (0.75 * pi).sqrt()).abs() < 1e-14);
/// // int_0^1 3/(4 pi) z^2 2 pi dz
/// let square = f_10.square(Domain::Sphere)?;
/// assert!((square - 0.5).abs() < 1e-13);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
pub struct HarmonicProjection<'a> {
    function: &'a dyn Integrand,
    degree: usize,
    harmonics: RealHarmonics,
    /// The coefficients, if they are known.
    exact: Option<Vec<f64>>,
    /// Energies of the components, by largest degree.
    energies: Mutex<BTreeMap<usize, Arc<Vec<Vec<f64>>>>>,
    centred: OnceLock<Result<Vec<ByParity>, Error>>,
    /// Values of the function for kurtoses.
    grid: OnceLock<Option<Vec<(DVec3, f64, f64)>>>,
}

impl std::fmt::Debug for HarmonicProjection<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("HarmonicProjection").field("degree", &self.degree).finish_non_exhaustive()
    }
}

impl<'a> HarmonicProjection<'a> {
    /// The largest degree of a projection.
    pub const MAX_DEGREE: usize = 10;

    /// Returns the projection of a function onto the harmonics of degrees up to `degree`.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] beyond [`MAX_DEGREE`](Self::MAX_DEGREE).
    pub fn new(function: &'a dyn Integrand, degree: usize) -> Result<Self, Error> {
        if degree > Self::MAX_DEGREE {
            let name = "the degree of a projection";
            return Err(Error::Parameter { name, range: "at most 10", got: degree as f64 });
        }
        let mut projection = Self {
            function,
            degree,
            harmonics: RealHarmonics::new(degree),
            exact: None,
            energies: Mutex::default(),
            centred: OnceLock::new(),
            grid: OnceLock::new(),
        };
        projection.exact = projection.exact_coefficients().ok();
        Ok(projection)
    }

    /// Returns the largest degree.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Returns degree and order of the components in their order, l = 0, 1, ... and m = -l ..= l.
    pub fn orders(&self) -> impl Iterator<Item = (usize, i64)> {
        orders(self.degree).map(|(l, m)| (usize::try_from(l).unwrap_or(0), m))
    }

    /// Returns the exact coefficients `F_lm`, if they are known.
    #[must_use]
    pub fn exact(&self) -> Option<&[f64]> {
        self.exact.as_deref()
    }

    /// Returns the integrand `f Y_lm` of one coefficient.
    ///
    /// # Errors
    ///
    /// [`Error::Order`] unless |m| <= l, [`Error::Parameter`] if l exceeds the degree.
    pub fn coefficient(&self, l: usize, m: i64) -> Result<ProjectedCoefficient<'_>, Error> {
        if m.unsigned_abs() > l as u64 {
            return Err(Error::Order { l, m });
        }
        if l > self.degree {
            let range = "at most the degree of the projection";
            return Err(Error::Parameter { name: "l", range, got: l as f64 });
        }
        let index = self.orders().position(|order| order == (l, m)).unwrap_or(0);
        Ok(ProjectedCoefficient::new(self, index, l, m))
    }

    /// Returns the irradiance over all normals.
    #[must_use]
    pub fn irradiance(&self) -> Irradiance<'_> {
        Irradiance::new(self)
    }

    /// Returns the real coefficients from those of the function.
    fn exact_coefficients(&self) -> Result<Vec<f64>, Error> {
        let alm = self.alm(self.degree)?;
        let of_order = |(l, m): (usize, i64)| {
            let a = alm[(l, usize::try_from(m.unsigned_abs()).unwrap_or(0))];
            match m {
                0 => a.re,
                1.. => SQRT_2 * a.re,
                _ => -SQRT_2 * a.im,
            }
        };
        Ok(self.orders().map(of_order).collect())
    }

    fn alm(&self, lmax: usize) -> Result<Alm, Error> {
        self.function.coefficients(Domain::Sphere, lmax)?.to_alm()
    }

    /// Returns the energies of every component to degree `lmax`.
    fn energies_to(&self, lmax: usize) -> Result<Arc<Vec<Vec<f64>>>, Error> {
        let mut energies = self.energies.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = energies.get(&lmax) {
            return Ok(known.clone());
        }
        let mut all = vec![Vec::new(); self.components()];
        // A harmonic of degree l connects degrees that differ by at most l.
        let f = self.alm(lmax + self.degree)?;
        for_each_product(&f, self.degree, |l, m, product| {
            let mut per_degree = product.energy_per_degree();
            per_degree.truncate(lmax + 1);
            all[index(l, m)] = per_degree;
        })?;
        let all = Arc::new(all);
        energies.insert(lmax, all.clone());
        Ok(all)
    }

    /// Returns the coefficients of `f Y_lm` to degree `lmax`.
    fn product(&self, l: usize, m: i64, lmax: usize) -> Result<Alm, Error> {
        let f = self.alm(lmax + self.degree)?;
        let mut wanted = Alm::zeros(lmax)?;
        for_each_product(&f, self.degree, |of_l, of_m, product| {
            if (of_l, of_m) == (l, m) {
                for m in 0..=lmax {
                    let column = wanted.column_mut(m);
                    column.copy_from_slice(&product.column(m)[..lmax + 1 - m]);
                }
            }
        })?;
        Ok(wanted)
    }

    /// Returns the approximate time in seconds of the energies of all components.
    fn energy_seconds(&self, domain: Domain, lmax: usize) -> f64 {
        /// The time for a coefficient of a product, in seconds.
        const EACH: f64 = 10e-9;
        let coefficients = 0.5 * ((lmax + self.degree) as f64).powi(2);
        let products = EACH * coefficients * self.components() as f64;
        self.function.energy_seconds(domain, lmax + self.degree) + products
    }

    /// Returns `int (F - mean F)^2` of the even and the odd part of every component.
    fn centred_squares(&self) -> Result<&[ByParity], Error> {
        let known = self.centred.get_or_init(|| match self.function.band_limit() {
            Some(limit) => self.centred_squares_within(limit + self.degree),
            None => self.centred_squares_of_parts(),
        });
        known.as_deref().map_err(Clone::clone)
    }

    /// Sums the energies of components without energy beyond `lmax`.
    fn centred_squares_within(&self, lmax: usize) -> Result<Vec<ByParity>, Error> {
        let sum = |energies: &Vec<f64>| {
            let mut sum = ByParity::both(0.0);
            for (l, e) in energies.iter().enumerate().skip(1) {
                *sum.of_mut(l) += e;
            }
            sum
        };
        Ok(self.energies_to(lmax)?.iter().map(sum).collect())
    }

    /// Returns `int f_even^2 Y_lm^2` and `int f_odd^2 Y_lm^2` without the means. The square of a
    /// harmonic has no coefficients beyond degree 2l, so those of the squares of f suffice.
    fn centred_squares_of_parts(&self) -> Result<Vec<ByParity>, Error> {
        let squares = self.function.squared_parts(2 * self.degree)?;
        let squares = [squares[0].to_alm()?, squares[1].to_alm()?].map(Coefficients::general);
        let means = self.exact_coefficients()?;
        let mut all = Vec::new();
        for ((l, m), mean) in self.orders().zip(means) {
            if l == 0 {
                // Nearly constant functions lose no digits this way.
                let centred = self.function.centred_square(Domain::Sphere)?;
                all.push(centred.map(|square| square / (4.0 * PI)));
                continue;
            }
            let harmonic = Coefficients::general(squared_harmonic(l, m)?);
            let inner = |square: &Coefficients| -> Result<f64, Error> {
                Ok(square.inner_per_degree(&harmonic)?.iter().sum())
            };
            let (even, odd) = (inner(&squares[0])?, inner(&squares[1])?);
            // An odd harmonic exchanges the parts.
            let (even, odd) = if l.is_multiple_of(2) { (even, odd) } else { (odd, even) };
            let even = even - mean * mean / (4.0 * PI);
            all.push(ByParity { even: even.max(0.0), odd: odd.max(0.0) });
        }
        Ok(all)
    }

    /// Returns directions with weights and the values of the function, for kurtoses: features
    /// smaller than a degree may be missed. Without values there is no grid.
    fn grid(&self) -> Option<&[(DVec3, f64, f64)]> {
        const ROWS: usize = 192;
        let grid = self.grid.get_or_init(|| {
            let angle = |k: usize| PI * (k as f64 + 0.5) / ROWS as f64;
            let rows = (0..ROWS).flat_map(|i| (0..2 * ROWS).map(move |j| (i, j)));
            let cells = rows.map(|(i, j)| {
                let ((st, ct), (sp, cp)) = (angle(i).sin_cos(), angle(j).sin_cos());
                (DVec3::new(st * cp, st * sp, ct), st)
            });
            let (dirs, weights): (Vec<DVec3>, Vec<f64>) = cells.unzip();
            let mut values = vec![0.0; dirs.len()];
            self.function.eval_into(&dirs, &mut values).ok()?;
            let nodes = dirs.into_iter().zip(weights).zip(values);
            Some(nodes.map(|((dir, weight), value)| (dir, weight, value)).collect())
        });
        grid.as_deref()
    }

    /// Returns an [`Energy`] from sums over the components with weights.
    fn weighted_energy(
        &self,
        domain: Domain,
        lmax: usize,
        weights: &[(usize, f64)],
    ) -> Result<Energy, Error> {
        check_domain(domain)?;
        let (energies, centred) = (self.energies_to(lmax)?, self.centred_squares()?);
        let mut per_degree = vec![0.0; lmax + 1];
        let mut total = ByParity::both(0.0);
        for &(component, weight) in weights {
            for (sum, e) in per_degree.iter_mut().zip(&energies[component]) {
                *sum += weight * e;
            }
            total = total.zip(centred[component]).map(|(sum, e)| sum + weight * e);
        }
        Ok(Energy::new(domain, per_degree, total))
    }
}

/// Rejects the hemisphere, over which the harmonics are not orthogonal.
fn check_domain(domain: Domain) -> Result<(), Error> {
    if domain == Domain::Sphere {
        return Ok(());
    }
    Err(Error::NoEnergy { reason: "coefficients of harmonics are integrals over the whole sphere" })
}

/// Returns the index of the component of degree l and order m.
fn index(l: usize, m: i64) -> usize {
    (l * (l + 1)).saturating_add_signed(isize::try_from(m).unwrap_or(0))
}

/// Returns the coefficients of `Y_lm^2`, which end at degree 2l.
fn squared_harmonic(l: usize, m: i64) -> Result<Alm, Error> {
    let harmonic = crate::Harmonic::new(l, m)?.coefficients(Domain::Sphere, 3 * l)?.to_alm()?;
    let mut square = Alm::zeros(2 * l)?;
    for_each_product(&harmonic, l, |of_l, of_m, product| {
        if (of_l, of_m) == (l, m) {
            square.clone_from(product);
        }
    })?;
    Ok(square)
}

impl VectorIntegrand for HarmonicProjection<'_> {
    fn components(&self) -> usize {
        (self.degree + 1) * (self.degree + 1)
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        let mut of_function = vec![0.0; dirs.len()];
        self.function.eval_into(dirs, &mut of_function)?;
        let rows = values.chunks_exact_mut(self.components());
        for ((row, &dir), f) in rows.zip(dirs).zip(of_function) {
            self.harmonics.values_into(dir, row);
            row.iter_mut().for_each(|value| *value *= f);
        }
        Ok(())
    }
}
