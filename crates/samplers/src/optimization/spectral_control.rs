mod correlation_target;
mod distance_penalty;
mod energy;
mod freedom;
mod noise_colour;
mod profile;
mod search;
mod single_peak;
mod sphere_bands;
mod staged;
mod target;

use glam::DVec3;
use rand::Rng;
use sphvar_grammar::Range;

use crate::patterns::poisson_disk::greatest_chord;
use crate::patterns::white_noise;
use crate::{Domain, Error, PointSet, Progress, Sampler, count};
pub(super) use distance_penalty::DistancePenalty;
#[cfg(test)]
pub(super) use distance_penalty::NearPairs;
pub(super) use energy::{ACCURACIES, Band, BandTransform, SpectralEnergy};
pub(super) use freedom::MAX_SHARE;
pub(super) use freedom::degree_within;
use freedom::{coefficients, degrees_of_freedom};
pub use noise_colour::NoiseColour;
pub use profile::PowerProfile;
pub(super) use search::{
    MIN_STAGED, Search, descent_steps, infeasible_power, relative_steps, starts,
};
pub use single_peak::SinglePeak;
pub(super) use sphere_bands::SphereBands;
pub(super) use staged::StagedEnergy;
pub use target::SpectralTarget;

/// Point sets with a prescribed power at every degree of a target, in every realization, obtained
/// by optimizing a white-noise set.
///
/// Where the target is 0 the power falls to 1e-20, so that integrands of those degrees are
/// integrated exactly, as by a spherical design. Elsewhere the power matches the target to 1e-6. A
/// *minimum-distance penalty* keeps any two points at least the requested chord apart.
///
/// A limited-memory BFGS method over the fast transforms minimizes the sum of the deviation of the
/// amplitudes, weighted as in the logarithmic energy, and the penalty. It takes about
/// `8 r (1 + r/25)` steps for any N, where `r = (1 + sqrt f)/(1 - sqrt f)` and f is the ratio of the
/// number of vanishing coefficients to the 2N - 3 degrees of freedom: 60 for alpha = 1, some 5000 for
/// the largest alpha. The accuracy of the transforms increases as the
/// deviation decreases; if the target is 0 up to some degree only, the last steps of 1024 points or
/// more transform these degrees alone. A set that stalls is discarded and restarted; a
/// target that cannot be met is an error.
///
/// On the hemisphere the spectrum is that of the points and their antipodes: even degrees only.
///
/// ```
/// use sphvar_samplers::{Domain, Purpose, Sampler, SpectralControl, Streams};
/// let step = SpectralControl::step(100, Domain::Sphere, None, None)?;
/// assert_eq!(step.last_empty_degree(), 10);
/// let set = step.sample(&mut Streams::new(0, Purpose::Pattern, 100).realization(0))?;
/// // No power at degree 1: the points sum to zero.
/// let sum: glam::DVec3 = set.points.iter().sum();
/// assert!(sum.length() < 1e-8);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
///
/// # References
///
/// Graef and Potts 2011, doi:10.1007/s00211-011-0399-7, for designs by nonlinear optimization over
/// fast transforms. The weights, the amplitudes and the penalty are original to this project.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralControl {
    n: u32,
    domain: Domain,
    name: &'static str,
    target: SpectralTarget,
    /// The minimum chord, enforced by the penalty.
    sigma: f64,
    /// The nominal work per point without a minimum distance.
    work: f64,
}

impl SpectralControl {
    /// The ratio of vanishing coefficients to degrees of freedom beyond which descents do not
    /// converge in reasonable time.
    pub const MAX_CONSTRAINED: f64 = MAX_SHARE;

    /// The default alpha of a step.
    pub const DEFAULT_ALPHA: f64 = 1.0;

    /// The largest alpha of a step over all numbers of points; [`Self::max_alpha`] is that for N
    /// points.
    pub const MAX_ALPHA: f64 = 1.38;

    /// The valid alphas of a step over all numbers of points.
    pub const ALPHA_RANGE: Range = Range::closed(0.0, Self::MAX_ALPHA);

    /// The valid values of `flat`.
    pub const FLAT_RANGE: Range = Range::closed(0.0, 8.0);

    /// The valid values of `core`.
    pub const CORE_RANGE: Range = Range::closed(0.0, 0.95);

    /// The minimum chord of [`Self::step`] in units of the spacing of a hexagonal lattice.
    pub const STEP_CORE: f64 = 0.3;

    /// The minimum chord of [`Self::blue`] in the same units.
    pub const BLUE_CORE: f64 = 0.75;

    /// Fewer points do not have enough degrees of freedom for a flat spectrum beyond a step.
    const MIN_FLAT: usize = 32;

    /// The nominal factor in time for a set with a minimum distance.
    const CORE_WORK: f64 = 2.5;

    /// Returns the approximate number of steps of a descent.
    fn expected_steps(&self) -> f64 {
        let share =
            self.target.constraints(self.domain) as f64 / degrees_of_freedom(self.n_points());
        descent_steps(share)
    }

    /// Returns the pattern with no power at any degree `1 <= l <= alpha sqrt(N)` (2N and even
    /// degrees on the hemisphere), the power of white noise from there to `flat sqrt(N)`, and a
    /// minimum distance of 0.3 times the spacing of a hexagonal lattice. If not given, `flat` is 2
    /// for alpha up to 1 and 32 points or more, else 0.
    ///
    /// If not given, alpha is 1, or the largest feasible value where few points have too few
    /// degrees of freedom: no set of 1, 5 or 9 points has zero power up to sqrt(N).
    /// [`Self::last_empty_degree`] returns the last empty degree.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless alpha is in [0, 1.38] and flat in [0, 8]; [`Error::Infeasible`]
    /// with the largest alpha of N points if alpha exceeds it; those of [`Self::new`].
    pub fn step(
        n_points: usize,
        domain: Domain,
        alpha: Option<f64>,
        flat: Option<f64>,
    ) -> Result<Self, Error> {
        let is_flat = alpha.unwrap_or(Self::DEFAULT_ALPHA) <= 1.0 && n_points >= Self::MIN_FLAT;
        let flat = flat.unwrap_or(if is_flat { 2.0 } else { 0.0 });
        Self::empty_to_alpha("step", n_points, domain, alpha, flat, 320.0)?
            .with_core(Self::STEP_CORE)
    }

    /// Returns the step of `alpha` with no target beyond it and a minimum distance of 0.75 times
    /// the spacing of a hexagonal lattice: blue noise that is exact at low degrees.
    ///
    /// # Errors
    ///
    /// Those of [`Self::step`].
    pub fn blue(n_points: usize, domain: Domain, alpha: Option<f64>) -> Result<Self, Error> {
        Self::empty_to_alpha("blue", n_points, domain, alpha, 0.0, 180.0)?
            .with_core(Self::BLUE_CORE)
    }

    /// Returns the pattern with the power of a profile at every degree of every realization.
    ///
    /// # Errors
    ///
    /// Those of [`PowerProfile::target`] and [`Self::new`].
    pub fn profile(n_points: usize, domain: Domain, profile: &PowerProfile) -> Result<Self, Error> {
        Self::new("profile", n_points, profile.target(n_points, domain)?, domain)
    }

    /// Returns the last degree up to which sets of `n_points` points can have zero power, from the
    /// count of coefficients and degrees of freedom.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless there are 1 to `u32::MAX` points.
    pub fn max_empty_degree(n_points: usize, domain: Domain) -> Result<usize, Error> {
        count::checked(n_points)?;
        Ok(freedom::max_empty_degree(n_points, domain))
    }

    /// Returns the largest alpha of a step of `n_points` points, rounded down to six digits.
    ///
    /// # Errors
    ///
    /// Those of [`Self::max_empty_degree`].
    pub fn max_alpha(n_points: usize, domain: Domain) -> Result<f64, Error> {
        count::checked(n_points)?;
        Ok(freedom::max_alpha(n_points, domain).min(Self::MAX_ALPHA))
    }

    /// Returns the pattern with zero power up to alpha and that of white noise from there to
    /// `flat sqrt(N)`; `work` is the nominal work per point for alpha up to 1, beyond which it grows
    /// with the size of the transforms and the number of steps.
    fn empty_to_alpha(
        name: &'static str,
        n_points: usize,
        domain: Domain,
        alpha: Option<f64>,
        flat: f64,
        work: f64,
    ) -> Result<Self, Error> {
        let given = alpha.unwrap_or(Self::DEFAULT_ALPHA);
        let range = "in [0, 1.38]: beyond there are more constraints than freedom";
        in_range("alpha", range, given, Self::ALPHA_RANGE)?;
        in_range("flat", "in [0, 8]", flat, Self::FLAT_RANGE)?;
        let n = count::checked(n_points)?;
        let last = degree_within(given, n_points, domain);
        let max_degree = freedom::max_empty_degree(n_points, domain);
        if let Some(alpha) = alpha.filter(|_| last > max_degree) {
            return Err(Error::Infeasible {
                pattern: name,
                n_points,
                reason: format!(
                    "alpha = {alpha} requires {} coefficients to vanish (degrees up to {last}) with {} \
                     degrees of freedom; the largest alpha of {n_points} points on the {domain} is {} \
                     (degrees up to {max_degree})",
                    coefficients(last, domain),
                    degrees_of_freedom(n_points),
                    Self::max_alpha(n_points, domain)?
                ),
            });
        }
        let last = last.min(max_degree);
        let end = last.max(degree_within(flat, n_points, domain));
        let power = (0..=end).map(|l| if l <= last { 0.0 } else { 1.0 });
        let target = SpectralTarget::new(power.collect())?;
        let default = Self::DEFAULT_ALPHA;
        let relative = if given > default {
            let share = target.constraints(domain) as f64 / degrees_of_freedom(n_points).max(1.0);
            (given / default).powi(2) * relative_steps(share)
        } else {
            1.0
        };
        Ok(Self { n, domain, name, target, sigma: 0.0, work: work * relative })
    }

    /// Returns the pattern of `n_points` points with the power of the target and no minimum
    /// distance; `name` is for messages.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless there are 1 to `u32::MAX` points; [`Error::Infeasible`] with the
    /// reason if the number of vanishing coefficients exceeds what the degrees of freedom allow.
    pub fn new(
        name: &'static str,
        n_points: usize,
        target: SpectralTarget,
        domain: Domain,
    ) -> Result<Self, Error> {
        let n = count::checked(n_points)?;
        let (constraints, freedom) = (target.constraints(domain), degrees_of_freedom(n_points));
        let max_zeros = Self::MAX_CONSTRAINED * freedom;
        if constraints as f64 > max_zeros {
            return Err(Error::Infeasible {
                pattern: name,
                n_points,
                reason: infeasible_power(constraints as f64, freedom),
            });
        }
        let share = if freedom > 0.0 { constraints as f64 / freedom } else { 0.0 };
        Ok(Self { n, domain, name, target, sigma: 0.0, work: 130.0 * relative_steps(share) })
    }

    /// Returns the same pattern with a minimum distance of `core` times the spacing of a hexagonal
    /// lattice, `sqrt(8 pi/(sqrt(3) N))` (2N on the hemisphere), or of the Fejes Toth bound for the
    /// minimum distance of N points if that is smaller, as for few points; see
    /// [`Self::core_chord`].
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `core` is in [0, 0.95].
    pub fn with_core(mut self, core: f64) -> Result<Self, Error> {
        in_range("core", "in [0, 0.95]", core, Self::CORE_RANGE)?;
        let cell = self.domain.area() / f64::from(self.n);
        let hexagonal = (2.0 * cell / 3.0_f64.sqrt()).sqrt();
        // A single point has no distance to keep.
        self.sigma = match self.n_points() {
            1 => 0.0,
            n => (core * hexagonal).min(greatest_chord(n, self.domain)),
        };
        Ok(self)
    }

    /// Returns the last degree t such that no realization has power at any degree `1 <= l <= t` of
    /// the domain; 0 if there is none.
    #[must_use]
    pub fn last_empty_degree(&self) -> usize {
        let degrees = self.target.degrees(self.domain);
        degrees.take_while(|(_, power)| *power == 0.0).last().map_or(0, |(l, _)| l)
    }

    /// Returns the target spectrum.
    #[must_use]
    pub fn target(&self) -> &SpectralTarget {
        &self.target
    }

    /// Returns the minimum chord between any two points.
    #[must_use]
    pub fn core_chord(&self) -> f64 {
        self.sigma
    }
}

impl Sampler for SpectralControl {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn last_empty_degree(&self) -> Option<usize> {
        Some(Self::last_empty_degree(self))
    }

    fn nominal_work(&self) -> f64 {
        let core = if self.sigma > 0.0 { Self::CORE_WORK } else { 1.0 };
        self.work * core * f64::from(self.n)
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let points = set.start();
        let n = self.n_points();
        let core = DistancePenalty { space: self.domain, sigma: self.sigma };
        let g2 = self.target.pair_correlation_at_zero(n, self.domain);
        // Free power beyond the target can balance a slightly negative value, and any value if the
        // target has only zeros.
        let has_tail = self.target.last_degree() > Self::last_empty_degree(self);
        let starts = if has_tail && g2 < -0.5 { 1 } else { starts(self.n) };
        let step = self.nominal_work() / self.expected_steps();
        let search = Search { starts, spacing: (self.domain.area() / n as f64).sqrt() };
        let start = |points: &mut Vec<DVec3>| {
            points.extend((0..n).map(|_| white_noise::uniform_direction(self.domain, rng)));
        };
        let bands = SphereBands::targets(&self.target, self.domain);
        let of_degrees = |last: usize, bands: Vec<Band>| {
            Ok(SpectralEnergy::new(SphereBands::new(last, n)?, bands, core, n))
        };
        let last = Self::last_empty_degree(self);
        let is_staged = n >= MIN_STAGED.0
            && last > 0
            && self.target.last_degree() as f64 >= MIN_STAGED.1 * last as f64;
        let staged = || {
            if !is_staged {
                return Ok(None);
            }
            let of_low = bands.iter().copied().filter(|band| band.index <= last).collect();
            let vanishing = of_degrees(last, of_low)?;
            let all = of_degrees(self.target.last_degree(), bands.clone())?;
            Ok(Some(StagedEnergy::new(all, vanishing)))
        };
        let energy = || of_degrees(self.target.last_degree(), bands.clone());
        let reached = search.run(points, start, staged, energy, &|| progress.tick(step))?;
        let Some(reached) = reached else {
            for p in points.iter_mut() {
                *p = self.domain.representative(*p);
            }
            return Ok(());
        };
        let reason = search.failure(reached, g2);
        Err(Error::Infeasible { pattern: self.name, n_points: n, reason })
    }
}

/// Rejects numbers outside a range, which is `words` in messages.
pub(super) fn in_range(
    name: &'static str,
    words: &'static str,
    got: f64,
    range: Range,
) -> Result<(), Error> {
    if range.contains(got) { Ok(()) } else { Err(Error::Parameter { name, range: words, got }) }
}
