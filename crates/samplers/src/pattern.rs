use std::fmt;

use sphvar_healpix::Nside;

use crate::{Domain, Error, Fibonacci, HealpixJittered, HealpixRegular, Sampler, WhiteNoise};

/// The patterns this crate makes, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
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
}

impl Pattern {
    /// Every pattern, in the order in which tables show them.
    pub const ALL: [Self; 4] = [Self::WhiteNoise, Self::Jittered, Self::Healpix, Self::Fibonacci];

    /// The name by which commands and files know the pattern.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::WhiteNoise => "white-noise",
            Self::Jittered => "jittered",
            Self::Healpix => "healpix",
            Self::Fibonacci => "fibonacci",
        }
    }

    /// The pattern of a name, if there is one.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|p| p.name() == name)
    }

    /// A number for [`Streams::new`](crate::Streams::new) that tells the ensembles of one run apart: of
    /// this pattern and number of points, by a hash of the name (FNV-1a, 32 bits).
    #[must_use]
    pub fn stream_group(self, n_points: usize) -> usize {
        let step = |hash: u32, byte: u8| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        let hash = self.name().bytes().fold(0x811c_9dc5, step);
        hash as usize ^ n_points
    }

    /// The rule that the number of points obeys on `domain`, in words.
    #[must_use]
    pub fn legal_counts(self, domain: Domain) -> &'static str {
        match (self, domain) {
            (Self::WhiteNoise | Self::Fibonacci, _) => "any number from 1",
            (Self::Healpix | Self::Jittered, Domain::Sphere) => "12 nside^2 (12, 48, 108, ...)",
            (Self::Healpix | Self::Jittered, Domain::Hemisphere) => "6 nside^2 (6, 24, 54, ...)",
        }
    }

    /// The legal number of points nearest to `asked`, the smaller one of two equally near; never
    /// 0.
    #[must_use]
    pub fn nearest_count(self, asked: usize, domain: Domain) -> usize {
        match self {
            Self::WhiteNoise | Self::Fibonacci => asked.max(1),
            Self::Healpix | Self::Jittered => {
                let nside = nearest_nside(asked, domain);
                pixels_per_nside_squared(domain).saturating_mul(nside * nside)
            }
        }
    }

    /// The sampler of this pattern with exactly `n_points` points.
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
    /// if the pattern does not exist with `n_points`, [`Error::TooManyPoints`] beyond the range
    /// of its indices.
    pub fn build(self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        if n_points == 0 {
            return Err(Error::NoPoints { pattern: self });
        }
        let nearest = self.nearest_count(n_points, domain);
        if nearest != n_points {
            let (asked, rule) = (n_points, self.legal_counts(domain));
            return Err(Error::IllegalCount { pattern: self, domain, asked, nearest, rule });
        }
        Ok(match self {
            Self::WhiteNoise => Box::new(WhiteNoise::new(n_points, domain)),
            Self::Fibonacci => Box::new(Fibonacci::new(n_points, domain)),
            Self::Healpix => Box::new(HealpixRegular::new(self.nside(n_points, domain)?, domain)),
            Self::Jittered => Box::new(HealpixJittered::new(self.nside(n_points, domain)?, domain)),
        })
    }

    /// The resolution of `n_points`, a legal number.
    fn nside(self, n_points: usize, domain: Domain) -> Result<Nside, Error> {
        u32::try_from(nearest_nside(n_points, domain)).ok().and_then(|n| Nside::new(n).ok()).ok_or(
            Error::TooManyPoints {
                pattern: self,
                asked: n_points,
                most: pixels_per_nside_squared(domain) << 58,
            },
        )
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
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
    use super::{Domain, Error, Pattern, pixels_per_nside_squared};

    #[test]
    fn names_lead_back_to_their_pattern() {
        for pattern in Pattern::ALL {
            assert_eq!(Pattern::from_name(pattern.name()), Some(pattern));
        }
        assert_eq!(Pattern::from_name("blue"), None);
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
            assert_eq!(refused, Error::NoPoints { pattern });
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
