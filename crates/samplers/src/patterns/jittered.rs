use rand::{Rng, RngExt};
use sphvar_grammar::Parametric;
use sphvar_healpix::Nside;

use super::healpix::{n_strata, nside, strata, valid_counts};
use crate::definition::Definition;
use crate::{
    CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, SetDistribution, Strata,
    ValidCounts,
};

/// One uniform direction in every HEALPix pixel, for any nside; on the hemisphere one in every
/// antipodal pair of pixels, replaced by its antipode where it lies below.
///
/// The pixels have equal areas, so this is stratified sampling:
/// `<P(l)> = 1 - (1/N) sum_k E P_l(x.y)` over pairs x, y in pixel k, at most 1, and about
/// 1.1186 l(l+1)/N for small l.
#[derive(Clone, Copy, Debug)]
pub struct HealpixJittered {
    nside: Nside,
    domain: Domain,
}

impl HealpixJittered {
    /// Returns the pattern of resolution `nside`.
    #[must_use]
    pub fn new(nside: Nside, domain: Domain) -> Self {
        Self { nside, domain }
    }
}

impl Sampler for HealpixJittered {
    fn n_points(&self) -> usize {
        n_strata(self.nside, self.domain)
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        SetDistribution::Stratified(Strata::Healpix(self.nside))
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        let points = set.start();
        points.extend(strata(self.nside, self.domain).map(|cell| {
            let (u, v) = (rng.random(), rng.random());
            self.domain.representative(cell.uniform_point(u, v))
        }));
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
            low_degrees: "1.1186 l(l+1)/N",
            smooth_rate: Rate::power(-2.0),
            jump_rate: Rate::power(-1.5),
            is_extensible: false,
            source: "Gorski et al. 2005 (cells); Singh 2015",
        }
    }

    fn valid_counts(&self, domain: Domain) -> ValidCounts {
        valid_counts(domain)
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(HealpixJittered::new(nside("jittered", n_points, domain)?, domain)))
    }
}
