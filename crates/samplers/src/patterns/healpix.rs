use rand::Rng;
use sphvar_grammar::Parametric;
use sphvar_healpix::{Cell, Nside};

use crate::definition::Definition;
use crate::{
    CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, SetDistribution, ValidCounts,
};

/// The centres of the HEALPix pixels (Gorski et al. 2005), 12 nside^2 of them; on the hemisphere
/// one of each antipodal pair, 6 nside^2.
///
/// Odd degrees vanish exactly because the set is antipodally symmetric; even ones do not, so it is
/// not a spherical design. The pattern is deterministic: all realizations are the same set.
#[derive(Clone, Copy, Debug)]
pub struct HealpixRegular {
    nside: Nside,
    domain: Domain,
}

impl HealpixRegular {
    /// Returns the pattern of resolution `nside`.
    #[must_use]
    pub fn new(nside: Nside, domain: Domain) -> Self {
        Self { nside, domain }
    }
}

impl Sampler for HealpixRegular {
    fn n_points(&self) -> usize {
        n_strata(self.nside, self.domain)
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        SetDistribution::Fixed
    }

    fn sample_into(&self, _: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        let points = set.start();
        points.extend(
            strata(self.nside, self.domain).map(|c| self.domain.representative(c.centre())),
        );
        Ok(())
    }
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "0 (odd l), c_l/N (even l)",
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Gorski et al. 2005",
        }
    }

    fn valid_counts(&self, domain: Domain) -> ValidCounts {
        valid_counts(domain)
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(HealpixRegular::new(nside("healpix", n_points, domain)?, domain)))
    }
}

/// Returns the number of base faces whose cells are the strata. Faces 0 to 3 surround the north
/// pole, 4 to 7 lie on the equator; the antipode of face 4 is 6, of 5 is 7, of 0 to 3 are 8 to 11.
/// The first six therefore hold one cell of every antipodal pair.
fn strata_faces(domain: Domain) -> u8 {
    match domain {
        Domain::Sphere => 12,
        Domain::Hemisphere => 6,
    }
}

pub(super) fn n_strata(nside: Nside, domain: Domain) -> usize {
    let nside = nside.value() as usize;
    usize::from(strata_faces(domain)) * nside * nside
}

/// Returns the valid numbers of points of patterns with one point per stratum.
pub(super) fn valid_counts(domain: Domain) -> ValidCounts {
    ValidCounts::Squares { unit: usize::from(strata_faces(domain)), root: "nside" }
}

/// Returns the resolution for `n_points`, a valid count; `pattern` is for messages.
pub(super) fn nside(
    pattern: &'static str,
    n_points: usize,
    domain: Domain,
) -> Result<Nside, Error> {
    let faces = usize::from(strata_faces(domain));
    let nside = u32::try_from((n_points / faces).isqrt()).ok();
    // The largest nside is 2^29.
    let max = faces << 58;
    nside.and_then(|nside| Nside::new(nside).ok()).ok_or(Error::TooManyPoints {
        pattern,
        requested: n_points,
        max,
    })
}

/// Returns the cells of the strata, face by face.
pub(crate) fn strata(nside: Nside, domain: Domain) -> impl Iterator<Item = Cell> {
    let side = 0..nside.value();
    (0..strata_faces(domain)).flat_map(move |face| {
        let side = side.clone();
        side.clone().flat_map(move |iy| {
            side.clone().filter_map(move |ix| Cell::new(nside, face, ix, iy).ok())
        })
    })
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::{Domain, HealpixRegular, Nside, Sampler, strata};
    use crate::{HealpixJittered, Purpose, Streams};

    #[test]
    fn the_hemisphere_has_one_cell_of_every_antipodal_pair() {
        for n in [1, 2, 3, 8] {
            let nside = Nside::new(n).unwrap();
            let half: HashSet<_> = strata(nside, Domain::Hemisphere).collect();
            assert_eq!(half.len(), 6 * (n * n) as usize);
            for cell in strata(nside, Domain::Sphere) {
                assert!(half.contains(&cell) != half.contains(&cell.antipode()), "{cell:?}");
            }
        }
    }

    #[test]
    fn every_stratum_has_one_direction() {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let nside = Nside::new(9).unwrap();
            let mut rng = Streams::new(3, Purpose::Pattern, 0).realization(0);
            for sampler in [
                &HealpixRegular::new(nside, domain) as &dyn Sampler,
                &HealpixJittered::new(nside, domain),
            ] {
                let points = sampler.sample(&mut rng).unwrap().points;
                assert_eq!(points.len(), sampler.n_points());
                let strata: HashSet<_> = points
                    .iter()
                    .map(|&p| {
                        let cell = sphvar_healpix::Cell::containing(nside, p);
                        // An antipodal pair is identified by the cell with the smaller face.
                        if domain == Domain::Hemisphere && cell.face() >= 6 {
                            cell.antipode()
                        } else {
                            cell
                        }
                    })
                    .collect();
                assert_eq!(strata.len(), sampler.n_points(), "{sampler:?}");
            }
        }
    }
}
