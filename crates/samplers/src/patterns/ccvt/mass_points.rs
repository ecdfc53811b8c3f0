use rand::Rng;
use sphvar_grammar::Choice;
use sphvar_healpix::Nside;

use crate::{
    Domain, Error, Fibonacci, HealpixRegular, PointSet, Sampler, ValidCounts, WhiteNoise, rotate,
    uniform_rotation,
};

/// The kind of mass points of a tessellation; it determines the spectrum at low degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MassPoints {
    /// Independent uniform directions, different in every realization. Their white noise remains:
    /// `P(l) -> 1/capacity` as l -> 0.
    White,
    /// The spherical Fibonacci lattice, rotated uniformly for every realization.
    Fibonacci,
    /// The centres of the HEALPix pixels, rotated uniformly for every realization; capacity times
    /// the number of points must be 12 nside^2, on the hemisphere 6 nside^2.
    Healpix,
}

impl Choice for MassPoints {
    const CHOICES: &'static [(&'static str, Self)] = &[
        (Self::White.name(), Self::White),
        (Self::Fibonacci.name(), Self::Fibonacci),
        (Self::Healpix.name(), Self::Healpix),
    ];
}

impl MassPoints {
    /// Returns the name of the kind: `white`, `fibonacci` or `healpix`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::White => "white",
            Self::Fibonacci => "fibonacci",
            Self::Healpix => "healpix",
        }
    }

    /// Rejects a `count` of mass points that is invalid on `domain`.
    pub(super) fn check(self, count: usize, domain: Domain) -> Result<(), Error> {
        match self {
            Self::White | Self::Fibonacci => Ok(()),
            Self::Healpix => nside(count, domain).map(|_| ()),
        }
    }

    /// Replaces `mass` by `count` mass points.
    pub(super) fn draw_into(
        self,
        count: usize,
        domain: Domain,
        rng: &mut dyn Rng,
        mass: &mut PointSet,
    ) -> Result<(), Error> {
        match self {
            Self::White => return WhiteNoise::new(count, domain).sample_into(rng, mass),
            Self::Fibonacci => Fibonacci::new(count, domain)?.sample_into(rng, mass)?,
            Self::Healpix => {
                HealpixRegular::new(nside(count, domain)?, domain).sample_into(rng, mass)?;
            }
        }
        rotate(uniform_rotation(rng), domain, &mut mass.points);
        Ok(())
    }

    /// Returns the numbers of sites that have `capacity` mass points each.
    ///
    /// HEALPix has 12 nside^2 pixels: the capacity divides that if nside is a multiple of the smallest nside
    /// for which it does, so the valid numbers are multiples of squares.
    pub(super) fn valid_counts(self, capacity: usize, domain: Domain) -> ValidCounts {
        let unit = match domain {
            Domain::Sphere => 12,
            Domain::Hemisphere => 6,
        };
        if self != Self::Healpix || capacity == 0 {
            return ValidCounts::Any;
        }
        let root = smallest_root(capacity / gcd(capacity, unit));
        let pixels = unit as u128 * root as u128 * root as u128;
        usize::try_from(pixels / capacity as u128)
            .map_or(ValidCounts::Any, |unit| ValidCounts::Squares { unit, root: "k" })
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Returns the smallest number whose square `n` divides.
fn smallest_root(mut n: usize) -> usize {
    let (mut root, mut prime) = (1, 2);
    while prime <= n / prime {
        let mut is_squared = false;
        while n.is_multiple_of(prime) {
            n /= prime;
            is_squared = !is_squared;
            if is_squared {
                root *= prime;
            }
        }
        prime += 1;
    }
    root * n
}

/// Returns the resolution at which HEALPix has `count` pixels, or antipodal pairs of pixels.
fn nside(count: usize, domain: Domain) -> Result<Nside, Error> {
    let (pixels, range) = match domain {
        Domain::Sphere => (Some(count), "12 nside^2 (12, 48, 108, ...)"),
        Domain::Hemisphere => (count.checked_mul(2), "6 nside^2 (6, 24, 54, ...)"),
    };
    pixels.and_then(|n| u64::try_from(n).ok()).and_then(|n| Nside::from_n_pixels(n).ok()).ok_or(
        Error::Parameter {
            name: "number of HEALPix mass points (capacity times points)",
            range,
            got: count as f64,
        },
    )
}
