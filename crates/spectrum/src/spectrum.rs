use sphvar_samplers::Domain;
use sphvar_sh::ByParity;

use crate::{Accumulator, Error, Moments, Realization};

/// The mean angular power per degree of an ensemble, with the standard error of that mean.
///
/// `P(l) = (4 pi / N) 1/(2l+1) sum_m |sum_k conj Y_lm(s_k)|^2`, so that white noise has P(l) = 1
/// for l >= 1 and every set has P(0) = N (`docs/conventions.md`). On the hemisphere only even
/// degrees exist; the entries of odd degrees are 0 and mean nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    domain: Domain,
    n_points: usize,
    realizations: u64,
    power: Vec<f64>,
    stderr: Vec<f64>,
    tail: ByParity,
    tail_stderr: ByParity,
}

impl Spectrum {
    /// A mean power per degree that is known without sampling: no realizations, standard errors of 0.
    ///
    /// `power` is indexed by l from 0; its first entry is replaced by N, which every set has, and odd
    /// degrees of the hemisphere by 0. The [`tail`](Self::tail) is that of points in general position, 1.
    ///
    /// # Panics
    ///
    /// If `power` is empty.
    #[must_use]
    pub fn exact(domain: Domain, n_points: usize, mut power: Vec<f64>) -> Self {
        assert!(!power.is_empty(), "the power of degree 0 is always there");
        power[0] = n_points as f64;
        for (l, p) in power.iter_mut().enumerate() {
            if !domain.has_degree(l) {
                *p = 0.0;
            }
        }
        let stderr = vec![0.0; power.len()];
        let tail_stderr = ByParity::both(0.0);
        let spectrum = Self {
            domain,
            n_points,
            realizations: 0,
            power,
            stderr,
            tail: tail_stderr,
            tail_stderr,
        };
        spectrum.with_tail(ByParity::both(1.0))
    }

    /// The same spectrum with another mean power beyond its degrees, known without error.
    #[must_use]
    pub fn with_tail(mut self, tail: ByParity) -> Self {
        self.tail = existing(self.domain, tail);
        self.tail_stderr = ByParity::both(0.0);
        self
    }

    /// The mean power of even and of odd degrees beyond those of the spectrum, to which any pattern tends in the mean
    /// over degrees: 1 unless points coincide or are antipodes, see [`tail_power`](crate::tail_power).
    ///
    /// On the hemisphere that of odd degrees is 0 and has no meaning.
    #[must_use]
    pub fn tail(&self) -> ByParity {
        self.tail
    }

    /// The standard error of the [`tail`](Self::tail).
    #[must_use]
    pub fn tail_stderr(&self) -> ByParity {
        self.tail_stderr
    }

    /// Whether the power of every degree is known without error.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.stderr.iter().all(|&e| e == 0.0)
    }

    /// Where the points live.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.domain
    }

    /// The number of points of a realization.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// How many realizations the mean is taken over; 0 of a spectrum that is known without sampling.
    #[must_use]
    pub fn realizations(&self) -> u64 {
        self.realizations
    }

    /// The largest degree, inclusive.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.power.len() - 1
    }

    /// The mean power, index l from 0.
    #[must_use]
    pub fn power(&self) -> &[f64] {
        &self.power
    }

    /// The standard error of the mean power, index l from 0: 0 where the power is known exactly, NaN
    /// where one realization tells nothing of it.
    #[must_use]
    pub fn stderr(&self) -> &[f64] {
        &self.stderr
    }

    /// The same power as an exact one, with standard errors of 0: a pattern that is not random has
    /// the power of any of its realizations, and so has a set of points that is of interest itself.
    #[must_use]
    pub fn into_exact(mut self) -> Self {
        self.stderr.fill(0.0);
        self.tail_stderr = ByParity::both(0.0);
        self
    }

    /// The degrees that exist, from 0 on, each with its mean power and standard error.
    pub fn rows(&self) -> impl Iterator<Item = (usize, f64, f64)> {
        let rows = self.power.iter().zip(&self.stderr).enumerate();
        rows.map(|(l, (&p, &e))| (l, p, e)).filter(|row| self.domain.has_degree(row.0))
    }
}

/// The values of parities whose degrees exist, and 0.
fn existing(domain: Domain, value: ByParity) -> ByParity {
    ByParity {
        even: if domain.has_degree(0) { value.even } else { 0.0 },
        odd: if domain.has_degree(1) { value.odd } else { 0.0 },
    }
}

/// Accumulates the power per degree; the [`Spectrum`] in the making.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SpectrumAccumulator {
    domain: Domain,
    n_points: usize,
    degrees: Vec<Moments>,
    tail: ByParity<Moments>,
}

impl SpectrumAccumulator {
    /// An empty accumulator for degrees up to `lmax` of sets of `n_points`.
    ///
    /// # Panics
    ///
    /// If `lmax + 1` moments do not fit in memory; degrees beyond [`MAX_DEGREE`](sphvar_sh::MAX_DEGREE) have no
    /// transforms.
    #[must_use]
    pub fn new(domain: Domain, n_points: usize, lmax: usize) -> Self {
        let degrees = vec![Moments::default(); lmax.saturating_add(1)];
        Self { domain, n_points, degrees, tail: ByParity::default() }
    }

    /// Where the points live.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.domain
    }

    /// The number of points of a realization.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// The largest degree, inclusive; `None` if there are no degrees, as only sums from elsewhere can be.
    #[must_use]
    pub fn lmax(&self) -> Option<usize> {
        self.degrees.len().checked_sub(1)
    }

    /// How many realizations have been taken in; `None` if degrees disagree, which only sums from elsewhere do.
    #[must_use]
    pub fn realizations(&self) -> Option<u64> {
        let count = self.degrees.first()?.count();
        let tails = [&self.tail.even, &self.tail.odd];
        let mut all = self.degrees.iter().chain(tails);
        all.all(|moments| moments.count() == count).then_some(count)
    }

    /// Adds the realizations of another accumulator, exactly.
    ///
    /// # Errors
    ///
    /// [`Error::Mismatch`] if the two differ in the number of points or degrees.
    pub fn try_merge(&mut self, other: &Self) -> Result<(), Error> {
        let pairs = [
            ("numbers of points", self.n_points, other.n_points),
            ("numbers of degrees", self.degrees.len(), other.degrees.len()),
            (
                "domains",
                usize::from(self.domain == Domain::Sphere),
                usize::from(other.domain == Domain::Sphere),
            ),
        ];
        for (what, left, right) in pairs {
            if left != right {
                return Err(Error::Mismatch { what, left, right });
            }
        }
        self.merge(other);
        Ok(())
    }

    /// The mean and its standard error, which is NaN for a single realization; see
    /// [`Spectrum::into_exact`] for a realization that is the whole ensemble.
    ///
    /// # Errors
    ///
    /// [`Error::NoRealizations`] if nothing was accumulated.
    pub fn finish(&self) -> Result<Spectrum, Error> {
        let realizations = self.degrees.first().map_or(0, Moments::count);
        if realizations == 0 {
            return Err(Error::NoRealizations);
        }
        let exists = |l: usize, x: f64| if self.domain.has_degree(l) { x } else { 0.0 };
        let by_degree = |f: &dyn Fn(&Moments) -> f64| -> Vec<f64> {
            self.degrees.iter().enumerate().map(|(l, m)| exists(l, f(m))).collect()
        };
        Ok(Spectrum {
            domain: self.domain,
            n_points: self.n_points,
            realizations,
            power: by_degree(&Moments::mean),
            stderr: by_degree(&Moments::standard_error),
            tail: existing(self.domain, self.tail.as_ref().map(Moments::mean)),
            tail_stderr: existing(self.domain, self.tail.as_ref().map(Moments::standard_error)),
        })
    }
}

impl Accumulator for SpectrumAccumulator {
    fn push(&mut self, realization: &Realization<'_>) {
        for (moments, power) in self.degrees.iter_mut().zip(realization.power()) {
            moments.push(power);
        }
        let tail = realization.tail();
        self.tail.even.push(tail.even);
        self.tail.odd.push(tail.odd);
    }

    fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.degrees.iter_mut().zip(&other.degrees) {
            mine.merge(theirs);
        }
        self.tail.even.merge(&other.tail.even);
        self.tail.odd.merge(&other.tail.odd);
    }
}
