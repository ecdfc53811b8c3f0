mod region;

use std::cmp::Ordering;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rand::{Rng, RngExt};
use sphvar_grammar::{Choice, Declaration, Parametric};

pub use self::region::Region;
use crate::definition::Definition;
use crate::{
    CostOrder, Domain, Error, PatternFacts, PointSet, Rate, Sampler, SetDistribution, Strata, count,
};

/// The position of a point in its region.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Placement {
    /// Uniform in the region, independently of the others: stratified sampling.
    #[default]
    Jittered,
    /// At the region's centre; see [`Region::centre`].
    Centred,
}

impl Choice for Placement {
    const CHOICES: &'static [(&'static str, Self)] =
        &[(Self::Jittered.name(), Self::Jittered), (Self::Centred.name(), Self::Centred)];
}

impl Placement {
    /// Returns the placement's name: `jittered` or `centred`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Jittered => "jittered",
            Self::Centred => "centred",
        }
    }
}

/// One point in each of N regions of equal area: the recursive zonal equal-area partition
/// EQ(2, N) (Leopardi 2006), for any N.
///
/// The partition consists of two polar caps of one region each and, between them, collars cut into
/// regions that are as square as the count allows. With `theta_c = 2 asin(N^-1/2)` the colatitude
/// of a cap and `n = max(1, round((pi - 2 theta_c) sqrt(N / 4 pi)))` collars of equal height, the
/// number of regions above the i-th parallel is rounded to
///
/// ```text
/// k_i = round(N sin^2(theta_i / 2)),   theta_i = theta_c + i (pi - 2 theta_c)/n,
/// ```
///
/// which is Leopardi's rounding with carried remainder in summed form; the parallel then moves to
/// `z = 1 - 2 k_i/N`, so that areas are exact. A half at the equator, which is every odd N with an
/// even number of collars, rounds up.
///
/// On the hemisphere, where antipodes are identified, the partition is that of `z >= 0` itself: one
/// cap `theta_c = 2 asin((2N)^-1/2)` and collars from it down to the equator by the same rule, with
/// `z = 1 - k_i/N`.
///
/// Regions start at longitude 0 in every collar. Their diameters are below `7/sqrt(N)`
/// (tested up to N = 100 and for a few larger). Jittered points give
/// `<P(l)> = 1 - (1/N) sum_k E P_l(x.y)` over pairs x, y in region k; centred ones are not random.
///
/// ```
/// use sphvar_samplers::{Domain, EqualArea, Placement, Sampler};
/// let pattern = EqualArea::new(33, Domain::Sphere, Placement::Jittered)?;
/// assert_eq!(pattern.zones().collect::<Vec<_>>(), [1, 6, 10, 9, 6, 1]);
/// let area = 4.0 * std::f64::consts::PI / 33.0;
/// assert!(pattern.regions().all(|r| (r.area() / area - 1.0).abs() < 1e-14));
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct EqualArea {
    /// The number of regions above each parallel, from 0 at the north pole to N.
    above: Box<[u32]>,
    domain: Domain,
    placement: Placement,
}

impl EqualArea {
    /// Returns the pattern of `n_points` regions.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize, domain: Domain, placement: Placement) -> Result<Self, Error> {
        let n = count::checked(n_points)?;
        let above = match domain {
            Domain::Sphere => parallels_of_sphere(n),
            Domain::Hemisphere => parallels_of_hemisphere(n),
        };
        Ok(Self { above, domain, placement })
    }

    /// Returns the number of regions in each zone, from the north pole down.
    pub fn zones(&self) -> impl Iterator<Item = u32> {
        self.above.windows(2).map(|k| k[1] - k[0])
    }

    /// Returns the first region of each zone with the number of regions that are congruent to it:
    /// those of its zone and, on the sphere, those of the zone mirrored at the equator, which is
    /// then omitted.
    ///
    /// ```
    /// use sphvar_samplers::{Domain, EqualArea, Placement};
    /// let pattern = EqualArea::new(34, Domain::Sphere, Placement::Jittered)?;
    /// assert_eq!(pattern.zones().collect::<Vec<_>>(), [1, 6, 10, 10, 6, 1]);
    /// let counts: Vec<_> = pattern.congruent_regions().map(|(_, count)| count).collect();
    /// assert_eq!(counts, [2, 12, 20]);
    /// # Ok::<(), sphvar_samplers::Error>(())
    /// ```
    pub fn congruent_regions(&self) -> impl Iterator<Item = (Region, u32)> {
        let n_zones = self.above.len() - 1;
        let n = self.above[n_zones];
        (0..n_zones).filter_map(move |i| {
            let [top, bottom] = [self.above[i], self.above[i + 1]];
            let j = n_zones - 1 - i;
            let is_mirrored = self.domain == Domain::Sphere
                && (self.above[j], self.above[j + 1]) == (n - bottom, n - top);
            let region = self.zone_regions(top, bottom).next()?;
            match (is_mirrored, i.cmp(&j)) {
                (true, Ordering::Greater) => None,
                (true, Ordering::Less) => Some((region, 2 * (bottom - top))),
                _ => Some((region, bottom - top)),
            }
        })
    }

    /// Returns the regions in the order of the points: zone by zone from the north pole, each from
    /// longitude 0 eastwards. The shared edges of neighbours are bit-identical.
    pub fn regions(&self) -> impl Iterator<Item = Region> {
        self.above.windows(2).flat_map(|k| self.zone_regions(k[0], k[1]))
    }

    /// Returns the regions between two parallels, given by the numbers of regions above them.
    fn zone_regions(&self, top: u32, bottom: u32) -> impl Iterator<Item = Region> + use<> {
        let height = match self.domain {
            Domain::Sphere => 2.0,
            Domain::Hemisphere => 1.0,
        };
        let n = self.n_points() as f64;
        let drop = [top, bottom].map(|k| height * f64::from(k) / n);
        let regions = bottom - top;
        let meridian = move |j: u32| TAU * (f64::from(j) / f64::from(regions));
        (0..regions).map(move |j| Region::new(drop, [meridian(j), meridian(j + 1)]))
    }
}

impl Sampler for EqualArea {
    fn n_points(&self) -> usize {
        self.above.last().map_or(0, |&n| n as usize)
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        match self.placement {
            Placement::Jittered => SetDistribution::Stratified(Strata::EqualArea(self)),
            Placement::Centred => SetDistribution::Fixed,
        }
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        let points = set.start();
        match self.placement {
            Placement::Jittered => points.extend(self.regions().map(|region| {
                let (u, v) = (rng.random(), rng.random());
                region.uniform_point(u, v)
            })),
            Placement::Centred => points.extend(self.regions().map(|region| region.centre())),
        }
        Ok(())
    }
}

/// Parameters of the pattern [`EqualArea`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EqualAreaParameters {
    /// The position of a point in its region.
    pub placement: Placement,
}

impl EqualAreaParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { placement: Placement::Jittered };
}

impl Default for EqualAreaParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for EqualAreaParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.choice("placement", "uniform in the region or at its centre", &mut self.placement);
    }
}

impl Definition for EqualAreaParameters {
    fn facts(&self) -> PatternFacts {
        let (low_degrees, smooth_rate, jump_rate) = match self.placement {
            Placement::Jittered => ("1.0472 l(l+1)/N", Rate::power(-2.0), Rate::power(-1.5)),
            Placement::Centred => ("irregular", Rate::Depends, Rate::Depends),
        };
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees,
            smooth_rate,
            jump_rate,
            is_extensible: false,
            source: "Leopardi 2006",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(EqualArea::new(n_points, domain, self.placement)?))
    }
}

/// Returns the number of regions above each parallel of the sphere.
fn parallels_of_sphere(n: u32) -> Box<[u32]> {
    if n <= 2 {
        return (0..=n).collect();
    }
    let n_real = f64::from(n);
    let cap = 2.0 * n_real.recip().sqrt().asin();
    let span = PI - 2.0 * cap;
    let collars = n_collars(span, 4.0 * PI / n_real);
    let inner = (1..collars).map(|i| {
        if 2 * i == collars {
            // At the equator, odd N gives a tie that rounding errors must not decide.
            n.div_ceil(2)
        } else {
            nearest(n_real * drop_at(cap + span * f64::from(i) / f64::from(collars)) / 2.0)
        }
    });
    [0, 1].into_iter().chain(inner).chain([n - 1, n]).collect()
}

/// Returns the number of regions above each parallel of the hemisphere.
fn parallels_of_hemisphere(n: u32) -> Box<[u32]> {
    if n == 1 {
        return [0, 1].into();
    }
    let n_real = f64::from(n);
    let cap = 2.0 * (2.0 * n_real).recip().sqrt().asin();
    let span = FRAC_PI_2 - cap;
    let collars = n_collars(span, TAU / n_real);
    let inner = (1..collars)
        .map(|i| nearest(n_real * drop_at(cap + span * f64::from(i) / f64::from(collars))));
    [0, 1].into_iter().chain(inner).chain([n]).collect()
}

/// Returns the number of collars in `span` of colatitude whose height is nearest to the side of a
/// square of `area`, at least 1.
fn n_collars(span: f64, area: f64) -> u32 {
    nearest(span / area.sqrt()).max(1)
}

/// 1 - cos(theta), the distance of a parallel's plane from the pole.
fn drop_at(theta: f64) -> f64 {
    2.0 * (theta / 2.0).sin().powi(2)
}

/// The integer nearest to `x`, which lies in [0, `u32::MAX`].
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a count of regions, rounded"
)]
fn nearest(x: f64) -> u32 {
    x.round() as u32
}
