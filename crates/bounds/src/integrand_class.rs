use crate::degree_run::DegreeRun;
use crate::error::{not_negative, positive};
use crate::{ConvergenceRate, Domain, Error, Profile};

/// A class of integrands, given by the energy `E(l) = (2l+1) P_F(l)` of its representative, with
/// closed-form variances.
///
/// | constructor | energy for `l >= 1` | |
/// |---|---|---|
/// | [`band_limited`](Self::band_limited) | `(2l+1) a_F` for `l <= l0`, else 0 | best case |
/// | [`power_law`](Self::power_law) | `c l^-p` | worst case, thesis `p = 2` |
/// | [`cubic_power`](Self::cubic_power) | `c' (2l+1) l^-3` | exactly `P_F = c' l^-3` |
/// | [`flat_then_power_law`](Self::flat_then_power_law) | `(2l+1) a_F` for `l <= l0`, `c l^-p` beyond | both |
///
/// On the hemisphere the same energies describe the even extension, at even degrees only.
///
/// # Examples
///
/// The quadratic profile gives `N^-2` for band-limited integrands and `N^-1.5` in the worst case:
///
/// ```
/// use sphvar_bounds::{ConvergenceRate, Domain, IntegrandClass, Profile};
/// let profile = Profile::quadratic(1.0, 1.0)?;
/// let smooth = IntegrandClass::band_limited(1.0, 4)?;
/// let jump = IntegrandClass::power_law(1.0, 2.0)?;
/// let expected = ConvergenceRate::Algebraic { exponent: -2.0, log: false };
/// assert_eq!(smooth.rate(&profile, Domain::Sphere), expected);
/// let expected = ConvergenceRate::Algebraic { exponent: -1.5, log: false };
/// assert_eq!(jump.rate(&profile, Domain::Sphere), expected);
/// let slope = (jump.variance(&profile, 1_000_000, Domain::Sphere)
///     / jump.variance(&profile, 10_000, Domain::Sphere)).log(100.0);
/// assert!((slope + 1.5).abs() < 0.01);
/// # Ok::<(), sphvar_bounds::Error>(())
/// ```
///
/// # References
///
/// G. Singh 2015, chapter 6, equations 6.1 to 6.8, with the corrected weights `2l+1` and the
/// prefactor `4 pi / N`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntegrandClass(Kind);

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    BandLimited { power: f64, last: usize },
    PowerLaw { scale: f64, decay: f64 },
    CubicPower { scale: f64 },
    FlatThenPowerLaw { power: f64, last: usize, scale: f64, decay: f64 },
}

impl IntegrandClass {
    /// Returns the best case: constant power `a_F` for `1 <= l <= last`, none beyond.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `power` is finite and at least 0.
    pub fn band_limited(power: f64, last: usize) -> Result<Self, Error> {
        Ok(Self(Kind::BandLimited { power: not_negative("power", power)?, last }))
    }

    /// Returns the worst case: energy `scale * l^-decay`. A jump along a curve has `decay = 2`.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `scale` is finite and at least 0, and `decay` finite and
    /// above 1 (a finite energy).
    pub fn power_law(scale: f64, decay: f64) -> Result<Self, Error> {
        Ok(Self(Kind::PowerLaw { scale: not_negative("scale", scale)?, decay: summable(decay)? }))
    }

    /// Returns the model with power `P_F(l) = scale * l^-3`, hence energy
    /// `scale * (2 l^-2 + l^-3)`.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `scale` is finite and at least 0.
    pub fn cubic_power(scale: f64) -> Result<Self, Error> {
        Ok(Self(Kind::CubicPower { scale: not_negative("scale", scale)? }))
    }

    /// Returns the class with constant power up to `last` and energy `scale * l^-decay` beyond.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`IntegrandClass::band_limited`] and [`IntegrandClass::power_law`].
    pub fn flat_then_power_law(
        power: f64,
        last: usize,
        scale: f64,
        decay: f64,
    ) -> Result<Self, Error> {
        Ok(Self(Kind::FlatThenPowerLaw {
            power: not_negative("power", power)?,
            last,
            scale: not_negative("scale", scale)?,
            decay: summable(decay)?,
        }))
    }

    /// Returns the energy `E(l)`; zero for `l = 0`, which enters no variance.
    #[must_use]
    pub fn energy(&self, l: usize) -> f64 {
        let x = l as f64;
        match self.0 {
            _ if l == 0 => 0.0,
            Kind::BandLimited { power, last } | Kind::FlatThenPowerLaw { power, last, .. }
                if l <= last =>
            {
                (2.0 * x + 1.0) * power
            }
            Kind::BandLimited { .. } => 0.0,
            Kind::PowerLaw { scale, decay } | Kind::FlatThenPowerLaw { scale, decay, .. } => {
                scale * x.powf(-decay)
            }
            Kind::CubicPower { scale } => scale * (2.0 * x + 1.0) / (x * x * x),
        }
    }

    /// Returns the variance of this class under a profile: the variance formula with the profile as
    /// the pattern's power.
    ///
    /// ```text
    /// Var = prefactor * sum_l E(l) P(l)      all degrees, no truncation
    /// ```
    ///
    /// With an upper (lower) bound of the spectrum as profile it is an upper (lower) bound of the
    /// variance of every integrand whose energies are at most (at least) these. With
    /// `L = alpha sqrt N`, `n = floor(L)`, `gamma = 1`, the sums on the sphere are
    ///
    /// ```text
    /// band-limited, l0 <= L   a_F [2 H(l0,-b-1) + H(l0,-b)] / L^b
    /// band-limited, l0 >  L   a_F ([2 H(n,-b-1) + H(n,-b)] / L^b + l0(l0+2) - n(n+2))
    /// power law               c (H(n,p-b) / L^b + zeta(p,n+1))
    /// step                    a_F ((l0+1)^2 - ceil(L)^2)  or  c zeta(p, ceil(L))
    /// ```
    ///
    /// and on the hemisphere the same with `l = 2j`. Infinite for `n_points = 0`.
    ///
    /// The relative error is below 1e-13 for moderate exponents, apart from that of `L` itself,
    /// which is magnified `b` times.
    ///
    /// # Performance
    ///
    /// A few hundred powers at most, for any N.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_bounds::{Domain, IntegrandClass, Profile};
    /// use std::f64::consts::PI;
    /// // White noise: (4 pi / N) c zeta(2).
    /// let variance = IntegrandClass::power_law(3.0, 2.0)?.variance(&Profile::constant(1.0)?, 100, Domain::Sphere);
    /// assert!((variance - 4.0 * PI / 100.0 * 3.0 * PI * PI / 6.0).abs() < 1e-15);
    /// # Ok::<(), sphvar_bounds::Error>(())
    /// ```
    #[must_use]
    pub fn variance(&self, profile: &Profile, n_points: usize, domain: Domain) -> f64 {
        if n_points == 0 {
            return f64::INFINITY;
        }
        let sum: f64 = self.runs().iter().map(|run| run.sum(profile, n_points, domain)).sum();
        domain.variance_factor(n_points) * sum
    }

    /// Returns the large-N form of the variance, or `None` where it is not yet valid.
    ///
    /// With `L = alpha sqrt N` and `gamma = 1`, `g0 = 0` on the sphere, the power law `c l^-p` has
    ///
    /// ```text
    /// b != p-1   c [ zeta(p-b) L^-b + b / ((p-1)(b-p+1)) L^{1-p} ]         remainder c b/12 L^{-p-1}
    /// b  = p-1   c [ ln L + 0.57721... + 1/(p-1) ] L^{1-p}                 remainder c b/12 L^{-p-1}
    /// step       c L^{1-p} / (p-1)                                         remainder c/2 L^{-p}
    /// ```
    ///
    /// and is evaluated without cancellation between the two terms. A band-limited class is exact
    /// (remainder 0). The form holds once `L >= p + b` (step: `L >= p`) and the whole flat band
    /// lies below the break; a constant profile is exact for every N. On the hemisphere `L` is
    /// replaced by `L / 2`.
    #[must_use]
    pub fn asymptotic_variance(
        &self,
        profile: &Profile,
        n_points: usize,
        domain: Domain,
    ) -> Option<Asymptotic> {
        if n_points == 0 {
            return None;
        }
        let prefactor = domain.variance_factor(n_points);
        let mut total = Asymptotic { variance: 0.0, remainder: 0.0 };
        for run in self.runs() {
            let (value, remainder) = run.asymptotic(profile, n_points, domain)?;
            total.variance += prefactor * value;
            total.remainder += prefactor * remainder;
        }
        Some(total)
    }

    /// Returns the rate at which the variance under a profile falls with N.
    ///
    /// ```text
    /// profile                    band-limited      power law l^-p
    /// constant, or g0 > 0        N^-1              N^-1
    /// polynomial b               N^(-1-b/2)        N^(-1-min(b,p-1)/2), times ln N if b = p-1
    /// step                       0 eventually      N^(-1-(p-1)/2)
    /// ```
    ///
    /// A flat head before a power law does not change the rate of the power law. A class without
    /// energy, or a profile that is zero, has variance 0 for every N.
    #[must_use]
    pub fn rate(&self, profile: &Profile, domain: Domain) -> ConvergenceRate {
        let step = domain.degree_step();
        let (band, decay) = match self.0 {
            Kind::BandLimited { power, last } => {
                (if power > 0.0 { last / step * step } else { 0 }, None)
            }
            Kind::PowerLaw { scale, decay } => (0, (scale > 0.0).then_some(decay)),
            Kind::CubicPower { scale } => (0, (scale > 0.0).then_some(2.0)),
            Kind::FlatThenPowerLaw { power, last, scale, decay } => {
                (if power > 0.0 { last / step * step } else { 0 }, (scale > 0.0).then_some(decay))
            }
        };
        let b = profile.exponent();
        let plain = |exponent| ConvergenceRate::Algebraic { exponent, log: false };
        if profile.supremum() == 0.0 || (band == 0 && decay.is_none()) {
            return ConvergenceRate::Zero { beyond: 0.0 };
        }
        if profile.offset() > 0.0 || b == 0.0 {
            return plain(-1.0);
        }
        match decay {
            Some(p) => {
                // p - 1 is rounded, so b = p - 1 is tested to within a few units in the last place.
                let log = (b - (p - 1.0)).abs() <= 4.0 * f64::EPSILON * p;
                ConvergenceRate::Algebraic { exponent: -1.0 - 0.5 * b.min(p - 1.0), log }
            }
            None if b.is_infinite() => {
                ConvergenceRate::Zero { beyond: (band as f64 / profile.alpha()).powi(2) }
            }
            None => plain(-1.0 - 0.5 * b),
        }
    }

    /// Returns the runs of pure powers that make up the energy.
    fn runs(&self) -> Vec<DegreeRun> {
        let flat = |power: f64, last: usize| {
            [(2.0 * power, -1.0), (power, 0.0)].map(|(coefficient, decay)| DegreeRun {
                coefficient,
                decay,
                first: 1.0,
                last: last as f64,
            })
        };
        let tail = |coefficient, decay, first| DegreeRun {
            coefficient,
            decay,
            first,
            last: f64::INFINITY,
        };
        match self.0 {
            Kind::BandLimited { power, last } => flat(power, last).to_vec(),
            Kind::PowerLaw { scale, decay } => vec![tail(scale, decay, 1.0)],
            Kind::CubicPower { scale } => vec![tail(2.0 * scale, 2.0, 1.0), tail(scale, 3.0, 1.0)],
            Kind::FlatThenPowerLaw { power, last, scale, decay } => {
                let mut runs = flat(power, last).to_vec();
                runs.push(tail(scale, decay, last as f64 + 1.0));
                runs
            }
        }
    }
}

/// The large-N form of a variance, with the size of the neglected terms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asymptotic {
    /// The two leading terms.
    pub variance: f64,
    /// Size of the first neglected term; the error stays below twice this, apart from rounding.
    pub remainder: f64,
}

fn summable(decay: f64) -> Result<f64, Error> {
    match positive("decay", decay) {
        Ok(value) if value > 1.0 => Ok(value),
        _ => Err(Error::Parameter {
            name: "decay",
            got: decay,
            expected: "finite and above 1, so that the energy is finite",
        }),
    }
}
