mod freedom;
mod torus_bands;

use std::f64::consts::FRAC_2_SQRT_PI;

use glam::DVec2;
use rand::{Rng, RngExt};
use sphvar_grammar::Range;

use super::spectral_control::{
    DistancePenalty, MIN_STAGED, PowerProfile, Search, SpectralControl, SpectralEnergy,
    StagedEnergy, descent_steps, in_range, infeasible_power, relative_steps, starts,
};
use crate::square::poisson_disk_square::greatest_distance;
use crate::square::turns::wrapped;
use crate::{Error, PointSet, Progress, Square, SquareSampler, count};
use freedom::{degrees_of_freedom, frequencies_within, square_within};
use torus_bands::{RadialTarget, TorusBands};

/// Point sets of the square with a prescribed power at every frequency of a target, in every
/// realization, obtained by optimizing a white-noise set.
///
/// The target depends on |k| alone. Where it is 0 the power of every frequency falls to 1e-20, so
/// that integrands of those frequencies are integrated exactly. Elsewhere the mean power of each
/// ring of frequencies, `|k|` rounded to an integer, matches the target to 1e-6. A
/// *minimum-distance penalty* keeps any two points at least the requested toroidal distance apart.
///
/// The method is that of [`SpectralControl`] on the sphere, with the eigenvalues `4 pi^2 |k|^2` of
/// the Laplacian in place of `l(l+1)`. N points have 2N - 2 degrees of freedom modulo shifts; each
/// pair of frequencies k and -k without power takes two of them, so about pi/2 alpha^2 of them are
/// needed for zero power up to `alpha sqrt(N)`.
///
/// ```
/// use sphvar_samplers::{Purpose, SquareSampler, SquareSpectralControl, Streams};
/// let step = SquareSpectralControl::step(100, None, None)?;
/// assert_eq!(step.last_empty_square(), 31); // 100/pi
/// let set = step.sample(&mut Streams::new(0, Purpose::Pattern, 100).realization(0))?;
/// // No power at k = (5, 2), |k|^2 = 29.
/// let phases = set.points.iter().map(|p| std::f64::consts::TAU * (5.0 * p[0] + 2.0 * p[1]));
/// let sum: f64 = phases.map(f64::cos).sum();
/// assert!(sum.abs() < 1e-8);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SquareSpectralControl {
    n: u32,
    name: &'static str,
    target: RadialTarget,
    /// The largest `|k|^2` without power.
    last_empty_square: u64,
    /// The minimum distance, enforced by the penalty.
    sigma: f64,
    /// The nominal work per point without a minimum distance.
    work: f64,
}

impl SquareSpectralControl {
    /// The default alpha of a step, `1/sqrt(pi)`: about as many frequencies without power as points.
    pub const DEFAULT_ALPHA: f64 = 0.5 * FRAC_2_SQRT_PI;

    /// The largest alpha of a step over all numbers of points; [`Self::max_alpha`] is that for N
    /// points.
    pub const MAX_ALPHA: f64 = 0.82;

    /// The valid alphas of a step over all numbers of points.
    pub const ALPHA_RANGE: Range = Range::closed(0.0, Self::MAX_ALPHA);

    /// The default end of the flat part of a step, twice the default alpha.
    const DEFAULT_FLAT: f64 = FRAC_2_SQRT_PI;

    /// Fewer points do not have enough degrees of freedom for a flat spectrum beyond a step.
    const MIN_FLAT: usize = 32;

    /// The nominal factor in time for a set with a minimum distance.
    const CORE_WORK: f64 = 2.0;

    /// Returns the pattern with no power at any frequency `0 < |k| <= alpha sqrt(N)`, the power of
    /// white noise from there to `flat sqrt(N)`, and a minimum distance of 0.3 times the spacing of
    /// a hexagonal lattice. If not given, `flat` is 1.128 for alpha up to the default and 32 points
    /// or more, else 0.
    ///
    /// If not given, alpha is [`Self::DEFAULT_ALPHA`], or the largest feasible value where few
    /// points have too few degrees of freedom. [`Self::last_empty_square`] returns the last
    /// frequency without power.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if a parameter is out of its range or unless there are 1 to `u32::MAX`
    /// points; [`Error::Infeasible`] with the reason if alpha is too large for the number of points.
    pub fn step(n_points: usize, alpha: Option<f64>, flat: Option<f64>) -> Result<Self, Error> {
        let is_flat =
            alpha.is_none_or(|alpha| alpha <= Self::DEFAULT_ALPHA) && n_points >= Self::MIN_FLAT;
        let flat = flat.unwrap_or(if is_flat { Self::DEFAULT_FLAT } else { 0.0 });
        Self::empty_to_alpha("step-square", n_points, alpha, flat, 430.0)?
            .with_core(SpectralControl::STEP_CORE)
    }

    /// Returns the step of `alpha` with no target beyond it and a minimum distance of 0.75 times
    /// the spacing of a hexagonal lattice: blue noise that is exact at low frequencies.
    ///
    /// # Errors
    ///
    /// Those of [`Self::step`].
    pub fn blue(n_points: usize, alpha: Option<f64>) -> Result<Self, Error> {
        Self::empty_to_alpha("blue-square", n_points, alpha, 0.0, 430.0)?
            .with_core(SpectralControl::BLUE_CORE)
    }

    /// Returns the pattern with the power of a profile in every ring of frequencies of every
    /// realization: of a polynomial in `omega = |k|/sqrt(N)`, of a colour of
    /// `omega = sqrt(pi) |k|/sqrt(N)`, below which there are as many frequencies as harmonics on the
    /// sphere, or of a table by |k| rounded to an integer.
    ///
    /// # Errors
    ///
    /// Those of [`PowerProfile::target`]; [`Error::Infeasible`] with the reason if the number of
    /// vanishing coefficients exceeds what the degrees of freedom allow.
    pub fn profile(n_points: usize, profile: &PowerProfile) -> Result<Self, Error> {
        let name = "profile-square";
        let n = count::checked(n_points)?;
        let (last, power) = profile.radial(n_points)?;
        let target = RadialTarget::new(last, power)?;
        let (constraints, freedom) = (target.constraints(), degrees_of_freedom(n_points));
        let max_zeros = SpectralControl::MAX_CONSTRAINED * freedom;
        if constraints > max_zeros {
            let reason = infeasible_power(constraints, freedom);
            return Err(Error::Infeasible { pattern: name, n_points, reason });
        }
        let share = if freedom > 0.0 { constraints / freedom } else { 0.0 };
        let work = 200.0 * relative_steps(share);
        Ok(Self { n, name, target, last_empty_square: 0, sigma: 0.0, work })
    }

    /// Returns the largest alpha of a step of `n_points` points, rounded down to six digits.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless there are 1 to `u32::MAX` points.
    pub fn max_alpha(n_points: usize) -> Result<f64, Error> {
        count::checked(n_points)?;
        Ok(freedom::max_alpha(n_points).min(Self::MAX_ALPHA))
    }

    /// Returns the pattern with zero power up to alpha and that of white noise from there to
    /// `flat sqrt(N)`; `work` is the nominal work per point for the default alpha.
    fn empty_to_alpha(
        name: &'static str,
        n_points: usize,
        alpha: Option<f64>,
        flat: f64,
        work: f64,
    ) -> Result<Self, Error> {
        let given = alpha.unwrap_or(Self::DEFAULT_ALPHA);
        let range = "in [0, 0.82]: beyond there are more constraints than freedom";
        in_range("alpha", range, given, Self::ALPHA_RANGE)?;
        in_range("flat", "in [0, 8]", flat, SpectralControl::FLAT_RANGE)?;
        let n = count::checked(n_points)?;
        let last = square_within(given, n_points);
        let max = freedom::max_empty_square(n_points);
        if let Some(alpha) = alpha.filter(|_| last > max) {
            return Err(Error::Infeasible {
                pattern: name,
                n_points,
                reason: format!(
                    "alpha = {alpha} requires {} coefficients to vanish (|k|^2 up to {last}) with {} \
                     degrees of freedom; the largest alpha of {n_points} points is {} (|k|^2 up to \
                     {max})",
                    frequencies_within(last),
                    degrees_of_freedom(n_points),
                    Self::max_alpha(n_points)?
                ),
            });
        }
        let last = last.min(max);
        let end = last.max(square_within(flat, n_points)) as f64;
        let empty = last as f64 + 0.5;
        let power = |radius: f64| if radius * radius < empty { 0.0 } else { 1.0 };
        // Half of an integer more is clear of rounding.
        let target = RadialTarget::new((end + 0.5).sqrt(), power)?;
        let default = Self::DEFAULT_ALPHA;
        let relative = if given > default {
            let share = target.constraints() / degrees_of_freedom(n_points).max(1.0);
            (given / default).powi(2) * relative_steps(share)
        } else {
            1.0
        };
        let work = work * relative;
        Ok(Self { n, name, target, last_empty_square: last, sigma: 0.0, work })
    }

    /// Returns the target of the frequencies without power alone, if a transform of only these
    /// takes less time than that of all.
    fn vanishing_target(&self) -> Result<Option<RadialTarget>, Error> {
        let last = (self.last_empty_square as f64 + 0.5).sqrt();
        let is_large = self.target.last() as f64 >= MIN_STAGED.1 * last;
        if self.n_points() < MIN_STAGED.0 || self.last_empty_square == 0 || !is_large {
            return Ok(None);
        }
        RadialTarget::new(last, |_| 0.0).map(Some)
    }

    /// Returns the same pattern with a minimum distance of `core` times the spacing of a hexagonal
    /// lattice, `sqrt(2/(sqrt(3) N))`, or of an upper bound on the toroidal distance of N points if
    /// that is smaller, as for two points; see [`Self::core_distance`].
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `core` is in [0, 0.95].
    pub fn with_core(mut self, core: f64) -> Result<Self, Error> {
        in_range("core", "in [0, 0.95]", core, SpectralControl::CORE_RANGE)?;
        let hexagonal = (2.0 / (3.0_f64.sqrt() * f64::from(self.n))).sqrt();
        // A single point has no distance to keep.
        self.sigma = match self.n_points() {
            1 => 0.0,
            n => (core * hexagonal).min(greatest_distance(n, true)),
        };
        Ok(self)
    }

    /// Returns the largest integer m such that no realization has power at any frequency with
    /// `0 < |k|^2 <= m`; 0 if there is none, and for profiles.
    #[must_use]
    pub fn last_empty_square(&self) -> u64 {
        self.last_empty_square
    }

    /// Returns the minimum toroidal distance between any two points.
    #[must_use]
    pub fn core_distance(&self) -> f64 {
        self.sigma
    }
}

impl SquareSampler for SquareSpectralControl {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn nominal_work(&self) -> f64 {
        let core = if self.sigma > 0.0 { Self::CORE_WORK } else { 1.0 };
        self.work * core * f64::from(self.n)
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let n = self.n_points();
        let core = DistancePenalty { space: Square, sigma: self.sigma };
        let g2 = self.target.pair_correlation_at_zero(n);
        // Free power beyond the target can balance a slightly negative value, and any value if the
        // target has only zeros.
        let starts = if self.target.has_powers() && g2 < -0.5 { 1 } else { starts(self.n) };
        let share = self.target.constraints() / degrees_of_freedom(n).max(1.0);
        let step = self.nominal_work() / descent_steps(share);
        let search = Search { starts, spacing: (n as f64).sqrt().recip() };
        let start = |points: &mut Vec<DVec2>| {
            points.extend((0..n).map(|_| DVec2::from(rng.random::<[f64; 2]>())));
        };
        let vanishing = self.vanishing_target()?;
        let of_bands = |target| {
            let bands = RadialTarget::bands(target).to_vec();
            Ok(SpectralEnergy::new(TorusBands::new(target)?, bands, core, n))
        };
        let staged = || match &vanishing {
            Some(vanishing) => {
                Ok(Some(StagedEnergy::new(of_bands(&self.target)?, of_bands(vanishing)?)))
            }
            None => Ok(None),
        };
        let energy = || of_bands(&self.target);
        let mut points = Vec::with_capacity(n);
        let stalled = search.run(&mut points, start, staged, energy, &|| progress.tick(step))?;
        let Some(reached) = stalled else {
            set.start().extend(points.iter().map(|&p| wrapped(p).to_array()));
            return Ok(());
        };
        let reason = search.failure(reached, g2);
        Err(Error::Infeasible { pattern: self.name, n_points: n, reason })
    }
}
