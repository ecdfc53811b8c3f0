use std::fmt;

use sphvar_healpix::Nside;

use crate::hash::fnv1a;
use crate::of_pattern::OfPattern;
use crate::{
    BestCandidate, Ccvt, DiskMode, Domain, EqualArea, Error, Fibonacci, GeneralizedSpiral, Halton,
    Hammersley, HealpixJittered, HealpixRegular, Lloyd, MassPoints, OnSphere, Placement,
    PoissonDisk, PowerProfile, Riesz, Sampler, Sobol, SpectralControl, WhiteNoise,
};

/// The patterns this crate makes, by name, with their parameters.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Pattern {
    /// Independent uniform directions.
    WhiteNoise,
    /// One uniform direction in every HEALPix pixel.
    Jittered,
    /// The centres of the HEALPix pixels.
    Healpix,
    /// The spherical Fibonacci lattice.
    Fibonacci,
    /// [`PoissonDisk`].
    PoissonDisk {
        /// When a set is complete.
        mode: DiskMode,
        /// The chord times sqrt(N), or that of [`PoissonDisk::default_radius`].
        radius: Option<f64>,
    },
    /// [`Ccvt`].
    Ccvt {
        /// Mass points to a site.
        capacity: usize,
        /// What the mass is.
        mass: MassPoints,
    },
    /// [`SpectralControl::step`].
    Step {
        /// No power at any degree up to alpha sqrt(N); if not given, what [`SpectralControl::step`]
        /// does.
        alpha: Option<f64>,
        /// White noise's power from there to flat sqrt(N); if not given, what
        /// [`SpectralControl::step`] does.
        flat: Option<f64>,
        /// The least distance in units of a hexagonal lattice's.
        core: f64,
    },
    /// [`SpectralControl::blue`].
    Blue {
        /// As that of a step.
        alpha: Option<f64>,
        /// The least distance in units of a hexagonal lattice's.
        core: f64,
    },
    /// [`SpectralControl::profile`].
    Profile {
        /// The power at each degree.
        profile: PowerProfile,
        /// The least distance in units of a hexagonal lattice's.
        core: f64,
    },
    /// [`EqualArea`].
    EqualArea {
        /// Where a point lies in its region.
        placement: Placement,
    },
    /// [`GeneralizedSpiral`].
    Spiral,
    /// [`BestCandidate`].
    BestCandidate {
        /// Candidates for each point that there is already.
        factor: u32,
    },
    /// [`Lloyd`].
    Lloyd {
        /// Steps of the relaxation.
        iterations: u32,
    },
    /// [`Riesz`].
    Riesz {
        /// The exponent.
        s: f64,
        /// Steps downhill.
        iterations: u32,
    },
    /// [`Sobol`] by the area-preserving map.
    Sobol,
    /// [`Halton`] by the area-preserving map.
    Halton,
    /// [`Hammersley`] by the area-preserving map.
    Hammersley,
}

impl Pattern {
    /// Every pattern, with its parameters as they are unless others are asked for, in the order in which
    /// tables show them.
    pub const ALL: [Self; 17] = [
        Self::WhiteNoise,
        Self::Jittered,
        Self::Healpix,
        Self::Fibonacci,
        Self::PoissonDisk { mode: DiskMode::Exact, radius: None },
        Self::Ccvt { capacity: 64, mass: MassPoints::Fibonacci },
        Self::Step { alpha: None, flat: None, core: SpectralControl::STEP_CORE },
        Self::Blue { alpha: None, core: SpectralControl::BLUE_CORE },
        Self::Profile { profile: PowerProfile::QUADRATIC, core: 0.0 },
        Self::EqualArea { placement: Placement::Jittered },
        Self::Spiral,
        Self::BestCandidate { factor: BestCandidate::DEFAULT_FACTOR },
        Self::Lloyd { iterations: Lloyd::DEFAULT_ITERATIONS },
        Self::Riesz { s: Riesz::DEFAULT_S, iterations: Riesz::DEFAULT_ITERATIONS },
        Self::Sobol,
        Self::Halton,
        Self::Hammersley,
    ];

    /// Those of which a thousand large realizations cost little and that have no parameters: what a
    /// comparison begins with.
    pub const ELEMENTARY: [Self; 4] =
        [Self::WhiteNoise, Self::Jittered, Self::Healpix, Self::Fibonacci];

    /// The name by which commands and files know the pattern.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::WhiteNoise => "white-noise",
            Self::Jittered => "jittered",
            Self::Healpix => "healpix",
            Self::Fibonacci => "fibonacci",
            Self::PoissonDisk { .. } => "poisson-disk",
            Self::Ccvt { .. } => "ccvt",
            Self::Step { .. } => "step",
            Self::Blue { .. } => "blue",
            Self::Profile { .. } => "profile",
            Self::EqualArea { .. } => "equal-area",
            Self::Spiral => "spiral",
            Self::BestCandidate { .. } => "best-candidate",
            Self::Lloyd { .. } => "lloyd",
            Self::Riesz { .. } => "riesz",
            Self::Sobol => "sobol",
            Self::Halton => "halton",
            Self::Hammersley => "hammersley",
        }
    }

    /// The pattern of a name with its usual parameters, if there is one.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|p| p.name() == name)
    }

    /// A number for [`Streams::new`](crate::Streams::new) that tells the ensembles of one run apart: of
    /// this pattern and number of points, by a hash of its text (FNV-1a, 32 bits).
    #[must_use]
    pub fn stream_group(&self, n_points: usize) -> usize {
        fnv1a(self.to_string().as_bytes()) as usize ^ n_points
    }

    /// The rule that the number of points obeys on `domain`, in words.
    #[must_use]
    pub fn legal_counts(&self, domain: Domain) -> &'static str {
        match (self, domain) {
            (Self::Healpix | Self::Jittered, Domain::Sphere) => "12 nside^2 (12, 48, 108, ...)",
            (Self::Healpix | Self::Jittered, Domain::Hemisphere) => "6 nside^2 (6, 24, 54, ...)",
            _ => "any number from 1",
        }
    }

    /// The legal number of points nearest to `asked`, the smaller one of two equally near; never
    /// 0.
    #[must_use]
    pub fn nearest_count(&self, asked: usize, domain: Domain) -> usize {
        match self {
            Self::Healpix | Self::Jittered => {
                let nside = nearest_nside(asked, domain);
                pixels_per_nside_squared(domain).saturating_mul(nside * nside)
            }
            _ => asked.max(1),
        }
    }

    /// The sampler of this pattern with exactly `n_points` points; of saturated Poisson disks, that
    /// many in the mean.
    ///
    /// ```
    /// use sphvar_samplers::{Domain, Error, Pattern};
    /// assert_eq!(Pattern::Jittered.build(972, Domain::Sphere)?.n_points(), 972);
    /// let refused = Pattern::Jittered.build(1024, Domain::Sphere).unwrap_err();
    /// assert!(matches!(refused, Error::IllegalCount { nearest: 972, .. }));
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NoPoints`] for 0 points, [`Error::IllegalCount`] with the nearest legal number
    /// if the pattern does not exist with `n_points`, [`Error::TooManyPoints`] or
    /// [`Error::Parameter`] beyond the range of its indices and of its parameters,
    /// [`Error::Infeasible`] if it cannot exist.
    pub fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        if n_points == 0 {
            return Err(Error::NoPoints { pattern: self.clone() });
        }
        let nearest = self.nearest_count(n_points, domain);
        if nearest != n_points {
            let (asked, rule) = (n_points, self.legal_counts(domain));
            let pattern = self.clone();
            return Err(Error::IllegalCount { pattern, domain, asked, nearest, rule });
        }
        let n = n_points;
        let sampler: Box<dyn Sampler> = match self {
            Self::WhiteNoise => Box::new(WhiteNoise::new(n, domain)),
            Self::Fibonacci => Box::new(Fibonacci::new(n, domain)),
            Self::Healpix => Box::new(HealpixRegular::new(self.nside(n, domain)?, domain)),
            Self::Jittered => Box::new(HealpixJittered::new(self.nside(n, domain)?, domain)),
            Self::PoissonDisk { mode, radius } => {
                Box::new(PoissonDisk::new(n, domain, *mode, *radius)?)
            }
            Self::Ccvt { capacity, mass } => Box::new(Ccvt::new(n, domain, *capacity, *mass)?),
            Self::Step { alpha, flat, core } => {
                Box::new(SpectralControl::step(n, domain, *alpha, *flat)?.with_core(*core)?)
            }
            Self::Blue { alpha, core } => {
                Box::new(SpectralControl::blue(n, domain, *alpha)?.with_core(*core)?)
            }
            Self::Profile { profile, core } => {
                Box::new(SpectralControl::profile(n, domain, profile)?.with_core(*core)?)
            }
            Self::EqualArea { placement } => Box::new(EqualArea::new(n, domain, *placement)?),
            Self::Spiral => Box::new(GeneralizedSpiral::new(n, domain)?),
            Self::BestCandidate { factor } => Box::new(BestCandidate::new(n, domain, *factor)?),
            Self::Lloyd { iterations } => Box::new(Lloyd::new(n, domain, *iterations)?),
            Self::Riesz { s, iterations } => Box::new(Riesz::new(n, domain, *s, *iterations)?),
            Self::Sobol => Box::new(OnSphere::new(Sobol::new(n)?, domain)),
            Self::Halton => Box::new(OnSphere::new(Halton::new(n)?, domain)),
            Self::Hammersley => Box::new(OnSphere::new(Hammersley::new(n)?, domain)),
        };
        Ok(Box::new(OfPattern::new(sampler, self)))
    }

    /// Returns [`Sampler::last_empty_degree`] of the sampler of `n_points` points; `None` if there is none.
    #[must_use]
    pub fn last_empty_degree(&self, n_points: usize, domain: Domain) -> Option<usize> {
        self.build(n_points, domain).ok()?.last_empty_degree()
    }

    /// The resolution of `n_points`, a legal number.
    fn nside(&self, n_points: usize, domain: Domain) -> Result<Nside, Error> {
        u32::try_from(nearest_nside(n_points, domain)).ok().and_then(|n| Nside::new(n).ok()).ok_or(
            Error::TooManyPoints {
                pattern: self.name(),
                asked: n_points,
                most: pixels_per_nside_squared(domain) << 58,
            },
        )
    }

    /// The parameters, as `key=value`, that differ from those of [`Self::ALL`].
    fn parameters(&self) -> Vec<String> {
        let usual = Self::from_name(self.name()).unwrap_or(Self::WhiteNoise);
        let all = self.all_parameters();
        all.into_iter().filter(|parameter| !usual.all_parameters().contains(parameter)).collect()
    }

    /// Every parameter as `key=value`.
    #[must_use]
    pub fn all_parameters(&self) -> Vec<String> {
        let given = |key: &str, value: Option<f64>| value.map(|value| format!("{key}={value}"));
        match self {
            Self::PoissonDisk { mode, radius } => {
                [Some(format!("mode={mode}")), given("radius", *radius)]
                    .into_iter()
                    .flatten()
                    .collect()
            }
            Self::Ccvt { capacity, mass } => {
                vec![format!("capacity={capacity}"), format!("mass={}", mass.name())]
            }
            Self::Step { alpha, flat, core } => {
                let given = [given("alpha", *alpha), given("flat", *flat)];
                given.into_iter().flatten().chain([format!("core={core}")]).collect()
            }
            Self::Blue { alpha, core } => {
                given("alpha", *alpha).into_iter().chain([format!("core={core}")]).collect()
            }
            Self::Profile { profile, core } => {
                profile.parameters().into_iter().chain([format!("core={core}")]).collect()
            }
            Self::EqualArea { placement } => vec![format!("placement={}", placement.name())],
            Self::BestCandidate { factor } => vec![format!("factor={factor}")],
            Self::Lloyd { iterations } => vec![format!("iterations={iterations}")],
            Self::Riesz { s, iterations } => {
                vec![format!("s={s}"), format!("iterations={iterations}")]
            }
            _ => Vec::new(),
        }
    }
}

/// The name, and after a colon the parameters that are not the usual ones.
impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parameters = self.parameters();
        if parameters.is_empty() {
            f.pad(self.name())
        } else {
            f.pad(&format!("{}:{}", self.name(), parameters.join(",")))
        }
    }
}

fn pixels_per_nside_squared(domain: Domain) -> usize {
    match domain {
        Domain::Sphere => 12,
        Domain::Hemisphere => 6,
    }
}

/// The nside whose number of points is nearest to `asked`, at least 1.
fn nearest_nside(asked: usize, domain: Domain) -> usize {
    let unit = pixels_per_nside_squared(domain);
    let below = (asked / unit).isqrt().max(1);
    let above = below + 1;
    let distance = |nside: usize| unit.saturating_mul(nside * nside).abs_diff(asked);
    if distance(above) < distance(below) { above } else { below }
}

#[cfg(test)]
mod tests {
    use super::{DiskMode, Domain, Error, Pattern, SpectralControl, pixels_per_nside_squared};

    #[test]
    fn names_lead_back_to_their_pattern() {
        for pattern in Pattern::ALL {
            assert_eq!(Pattern::from_name(pattern.name()), Some(pattern));
        }
        assert_eq!(Pattern::from_name("bluish"), None);
    }

    #[test]
    fn a_pattern_shows_what_is_unusual_about_it() {
        for pattern in Pattern::ALL {
            assert_eq!(pattern.to_string(), pattern.name());
        }
        let disks = Pattern::PoissonDisk { mode: DiskMode::Saturated, radius: Some(2.5) };
        assert_eq!(disks.to_string(), "poisson-disk:mode=saturated,radius=2.5");
        let step =
            Pattern::Step { alpha: Some(0.5), flat: Some(0.0), core: SpectralControl::STEP_CORE };
        assert_eq!(step.to_string(), "step:alpha=0.5,flat=0");
    }

    #[test]
    fn the_nearest_count_is_the_nearest_of_all_legal_counts() {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let unit = pixels_per_nside_squared(domain);
            for asked in 0..3000 {
                let nearest = Pattern::Healpix.nearest_count(asked, domain);
                let best = (1..40).map(|k| (unit * k * k).abs_diff(asked)).min();
                assert_eq!(Some(nearest.abs_diff(asked)), best, "asked {asked}, got {nearest}");
            }
        }
    }

    #[test]
    fn counts_that_do_not_exist_are_refused() {
        for pattern in Pattern::ALL {
            let refused = pattern.build(0, Domain::Sphere).unwrap_err();
            assert_eq!(refused, Error::NoPoints { pattern: pattern.clone() });
            // No overflow, no allocation: the largest counts are answered too.
            for n in [usize::MAX, usize::MAX / 12, 1 << 62] {
                let _ = pattern.build(n, Domain::Sphere);
            }
        }
        let refused = Pattern::Healpix.build(13, Domain::Hemisphere).unwrap_err();
        let message = refused.to_string();
        assert!(message.contains("nearest is 6") && message.contains("6 nside^2"), "{message}");
    }
}
