use rand::Rng;
use sphvar_grammar::Choice;
use sphvar_healpix::Nside;

use crate::{
    Domain, Error, Fibonacci, HealpixRegular, PointSet, Sampler, WhiteNoise, rotate,
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
            Self::Fibonacci => Fibonacci::new(count, domain).sample_into(rng, mass)?,
            Self::Healpix => {
                HealpixRegular::new(nside(count, domain)?, domain).sample_into(rng, mass)?;
            }
        }
        rotate(uniform_rotation(rng), domain, &mut mass.points);
        Ok(())
    }
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
