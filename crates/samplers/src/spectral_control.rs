mod energy;
mod profile;
mod soft_core;
mod target;

use glam::DVec3;
use rand::Rng;

use crate::descent::Descent;
use crate::{Domain, Error, Sampler, count, white_noise};
use energy::SpectralEnergy;
pub use profile::PowerProfile;
use soft_core::SoftCore;
pub use target::SpectralTarget;

/// Points whose power has a chosen value at every degree of a target, in every realization: white
/// noise that is moved until it does.
///
/// Where the target is 0 the power falls to 1e-20, so that every integrand of those degrees is
/// integrated exactly, as by a spherical design; where it is not, the power is met to 1e-6. A *soft core*
/// keeps points apart: no two are nearer than the chord that is asked for.
///
/// The distance of amplitudes, weighted as the logarithmic energy, and the overlap of cores are
/// brought to zero together by a limited-memory BFGS method over the fast transforms, in about
/// `8 (1 + sqrt f)/(1 - sqrt f)` steps, whatever N, where f is the number of coefficients that
/// vanish over the 2N - 3 degrees of freedom. A set that comes to rest before is thrown away and begun
/// again; a target that cannot be met is an error.
///
/// On the hemisphere the points and their antipodes have the spectrum: even degrees only.
///
/// ```
/// use sphvar_samplers::{Domain, Purpose, Sampler, SpectralControl, Streams};
/// let step = SpectralControl::step(100, Domain::Sphere, 1.0, None)?;
/// assert_eq!(step.target().constraints(Domain::Sphere), 99);
/// let points = step.sample(&mut Streams::new(0, Purpose::Pattern, 100).realization(0))?;
/// // No power at degree 1: the points balance.
/// let sum: glam::DVec3 = points.iter().sum();
/// assert!(sum.length() < 1e-8);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
///
/// # References
/// Graef and Potts 2011, doi:10.1007/s00211-011-0399-7, for designs by nonlinear optimisation over
/// fast transforms; the weights, the amplitudes and the core are of this project.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralControl {
    n: u32,
    domain: Domain,
    name: &'static str,
    target: SpectralTarget,
    /// The chord of the soft core.
    sigma: f64,
}

impl SpectralControl {
    /// Constraints over degrees of freedom beyond which descents do not arrive in reasonable time.
    pub const MOST_CONSTRAINED: f64 = 0.97;

    /// The largest alpha of a step.
    pub const MOST_ALPHA: f64 = 1.38;

    /// The chord of the soft core of [`Self::step`] in units of the spacing of a hexagonal lattice.
    pub const STEP_CORE: f64 = 0.3;

    /// That of [`Self::blue`].
    pub const BLUE_CORE: f64 = 0.75;

    /// Fewer points have no freedom left for a flat spectrum beyond a step.
    const FEWEST_FLAT: usize = 32;

    /// Steps of one descent, and how many are begun.
    const MOST_STEPS: u32 = 3000;
    const MOST_STARTS: u32 = 4;

    /// No power at all up to the last degree t with `(t+1)^2 - 1 <= alpha^2 N`, about alpha sqrt(N),
    /// and that of white noise from there to `flat sqrt(N)`, where points are no nearer than 0.3 of a
    /// hexagonal lattice's. If not given, `flat` is 2 for alpha up to 1 and 32 points or more, else 0.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn step(
        n_points: usize,
        domain: Domain,
        alpha: f64,
        flat: Option<f64>,
    ) -> Result<Self, Error> {
        let usual = if alpha <= 1.0 && n_points >= Self::FEWEST_FLAT { 2.0 } else { 0.0 };
        let flat = flat.unwrap_or(usual);
        Self::new("step", n_points, Self::step_target(n_points, domain, alpha, flat)?, domain)?
            .with_core(Self::STEP_CORE)
    }

    /// The step of `alpha` with nothing asked for beyond but points no nearer than 0.75 of a hexagonal
    /// lattice's: blue noise that is exact at low degrees.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn blue(n_points: usize, domain: Domain, alpha: f64) -> Result<Self, Error> {
        Self::new("blue", n_points, Self::step_target(n_points, domain, alpha, 0.0)?, domain)?
            .with_core(Self::BLUE_CORE)
    }

    /// The power of a profile, met at every degree of every realization.
    ///
    /// # Errors
    ///
    /// As [`PowerProfile::target`] and [`Self::new`].
    pub fn profile(n_points: usize, domain: Domain, profile: &PowerProfile) -> Result<Self, Error> {
        Self::new("profile", n_points, profile.target(n_points, domain)?, domain)
    }

    /// The target of a step to alpha, and of white noise from there to `flat sqrt(N)`.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless alpha is in [0, 1.38] and flat in [0, 8].
    pub fn step_target(
        n_points: usize,
        domain: Domain,
        alpha: f64,
        flat: f64,
    ) -> Result<SpectralTarget, Error> {
        let in_range = |name, range, got: f64, most| {
            if (0.0..=most).contains(&got) {
                Ok(())
            } else {
                Err(Error::Parameter { name, range, got })
            }
        };
        in_range(
            "alpha",
            "in [0, 1.38]: beyond there are more constraints than freedom",
            alpha,
            Self::MOST_ALPHA,
        )?;
        in_range("flat", "in [0, 8]", flat, 8.0)?;
        count::checked(n_points)?;
        // On the hemisphere half of the harmonics of a degree are left, as half of 2N points are.
        let density = domain.count_on_sphere(n_points);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a degree")]
        let degree = |x: f64| x.max(0.0) as usize;
        let mut last = degree((alpha * alpha * density + 1.0).sqrt() - 1.0);
        let target = |last: usize| {
            let end = last.max(degree(flat * density.sqrt()));
            SpectralTarget::new((0..=end).map(|l| if l <= last { 0.0 } else { 1.0 }).collect())
        };
        // Few points have less freedom than alpha promises.
        while last > 0 && too_constrained(&target(last)?, n_points, domain) {
            last -= 1;
        }
        target(last)
    }

    /// The pattern of `n_points` points with the target's power, and no core; `name` is for messages.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless there are 1 to `u32::MAX` points; [`Error::Infeasible`] with the
    /// reason if more coefficients are to vanish than there is freedom for.
    pub fn new(
        name: &'static str,
        n_points: usize,
        target: SpectralTarget,
        domain: Domain,
    ) -> Result<Self, Error> {
        let n = count::checked(n_points)?;
        let infeasible = |reason| Err(Error::Infeasible { pattern: name, n_points, reason });
        if too_constrained(&target, n_points, domain) {
            return infeasible(format!(
                "{} coefficients cannot vanish with {} degrees of freedom: at most {:.0} can",
                target.constraints(domain),
                freedom(n_points),
                Self::MOST_CONSTRAINED * freedom(n_points)
            ));
        }
        Ok(Self { n, domain, name, target, sigma: 0.0 })
    }

    /// The same, with no two points nearer than `core` times the spacing of a hexagonal lattice,
    /// `sqrt(8 pi/(sqrt(3) N))` (2N on the hemisphere).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `core` is in [0, 0.95].
    pub fn with_core(mut self, core: f64) -> Result<Self, Error> {
        if !(0.0..=0.95).contains(&core) {
            return Err(Error::Parameter { name: "core", range: "in [0, 0.95]", got: core });
        }
        let cell = self.domain.area() / f64::from(self.n);
        let hexagonal = (2.0 * cell / 3.0_f64.sqrt()).sqrt();
        // Few points have no room for a flat lattice.
        self.sigma = (core * hexagonal).min(1.2);
        Ok(self)
    }

    /// What the spectrum is to be.
    #[must_use]
    pub fn target(&self) -> &SpectralTarget {
        &self.target
    }

    /// The chord that separates all points.
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

    fn is_random(&self) -> bool {
        true
    }

    fn sample_into(&self, rng: &mut dyn Rng, points: &mut Vec<DVec3>) -> Result<(), Error> {
        let core = SoftCore { domain: self.domain, sigma: self.sigma };
        let g2 = self.target.pair_correlation_at_zero(self.n_points(), self.domain);
        // Power beyond the target can make up for a little.
        let starts = if g2 < -0.5 { 1 } else { Self::MOST_STARTS };
        let mut reached = [0.0; 2];
        for _ in 0..starts {
            points.clear();
            points.extend((0..self.n).map(|_| white_noise::uniform_direction(self.domain, rng)));
            let mut energy = SpectralEnergy::new(self.domain, &self.target, core, self.n_points())?;
            let spacing = (self.domain.area() / f64::from(self.n)).sqrt();
            let descent = Descent {
                iterations: Self::MOST_STEPS,
                scale: 1.0,
                is_adaptive: false,
                reach: 8.0 * spacing,
            };
            descent.run(points, &mut energy);
            if energy.has_arrived() {
                for p in points.iter_mut() {
                    *p = self.domain.representative(*p);
                }
                return Ok(());
            }
            reached = energy.residuals();
        }
        Err(Error::Infeasible {
            pattern: self.name,
            n_points: self.n_points(),
            reason: format!(
                "{starts} descents came to rest before their aim, the last with power {:.1e} where there \
                 should be none and {:.1e} off elsewhere. With white noise beyond the target the pair \
                 correlation at distance 0 would be {g2:.3}; no pattern has one below 0. Ask for a smaller \
                 alpha, core or range",
                reached[0], reached[1]
            ),
        })
    }
}

/// `2N - 3`, or 0.
fn freedom(n_points: usize) -> f64 {
    (2.0 * n_points as f64 - 3.0).max(0.0)
}

fn too_constrained(target: &SpectralTarget, n_points: usize, domain: Domain) -> bool {
    target.constraints(domain) as f64 > SpectralControl::MOST_CONSTRAINED * freedom(n_points)
}
