use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use rand::Rng;
use sphvar_grammar::{Choice, Declaration, Parametric};
use sphvar_healpix::{Cell, Nside};

use super::POINTS_PER_TICK;
use crate::cube_layers::LayeredCell;
use crate::definition::Definition;
use crate::patterns::healpix::strata;
use crate::{
    CostOrder, Domain, Error, PatternFacts, Progress, Rate, RotationGroup, RotationSampler,
    RotationSet, ValidCounts, count,
};

/// The directions and the twists of the coarsest grid.
const BASE_PIXELS: u32 = 12;
const BASE_TWISTS: u32 = 6;

/// One grid of rotations, or grids of all resolutions one after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum HopfOrder {
    /// One grid.
    #[default]
    Grid,
    /// The grids of nside 1, 2, 4 and so on, a sequence.
    Layered,
}

impl Choice for HopfOrder {
    const CHOICES: &'static [(&'static str, Self)] =
        &[("grid", Self::Grid), ("layered", Self::Layered)];
}

/// The product of the HEALPix directions and equally spaced twists by the Hopf map (Yershova, Jain,
/// `LaValle` and Mitchell 2010): cells of equal volume.
///
/// The rotation of pixel centre d and twist `psi = 2 pi (k + 1/2)/(6 nside)` first rotates about z by
/// psi, then takes z to d by the shortest rotation. The grid of resolution nside has
/// `12 nside^2` directions with `6 nside` twists each, 72 nside^3 rotations. Layered, the sequence
/// has the 72 rotations of nside 1, the 576 of nside 2, the 4608 of nside 4 and so on; of each
/// layer, the first `72 * 8^k` are in different cells of the grid of nside `2^k`. The publication
/// visits the cells of a layer in another order of the same kind.
///
/// # References
///
/// A. Yershova, S. Jain, S. M. `LaValle` and J. C. Mitchell, "Generating uniform incremental grids on
/// SO(3) using the Hopf fibration", International Journal of Robotics Research 29(7), 2010.
#[derive(Clone, Copy, Debug)]
pub struct HealpixHopf {
    n: u32,
    /// The resolution of a single grid.
    nside: Option<Nside>,
}

impl HealpixHopf {
    /// Returns the grid of resolution `nside`, `72 nside^3` rotations.
    ///
    /// # Errors
    ///
    /// [`Error::TooManyPoints`] beyond `u32::MAX` rotations, at nside 391.
    pub fn grid(nside: Nside) -> Result<Self, Error> {
        let n = u64::from(BASE_PIXELS * BASE_TWISTS) * u64::from(nside.value()).pow(3);
        let n = u32::try_from(n).map_err(|_| Error::TooManyPoints {
            pattern: "healpix-hopf",
            requested: usize::try_from(n).unwrap_or(usize::MAX),
            max: 72 * 390 * 390 * 390,
        })?;
        Ok(Self { n, nside: Some(nside) })
    }

    /// Returns the first `n_points` rotations of the sequence of grids.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn layered(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)?, nside: None })
    }
}

impl RotationSampler for HealpixHopf {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn is_random(&self) -> bool {
        false
    }

    fn sample_into(
        &self,
        _: &mut dyn Rng,
        set: &mut RotationSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let rotations = set.start();
        if let Some(nside) = self.nside {
            let twists = BASE_TWISTS * nside.value();
            for cell in strata(nside, Domain::Sphere) {
                progress.tick(0.0)?;
                let swing = shortest_rotation_of_z(cell.centre());
                rotations.extend((0..twists).map(|k| swing * twist(k, twists)));
            }
            return Ok(());
        }
        for i in 0..self.n {
            if i.is_multiple_of(POINTS_PER_TICK) {
                progress.tick(0.0)?;
            }
            rotations.extend(layered_element(i));
        }
        Ok(())
    }
}

/// Returns element `i` of the sequence of grids; there always is one.
#[expect(clippy::cast_possible_truncation, reason = "below 12, below 6")]
fn layered_element(i: u32) -> Option<DQuat> {
    let cell = LayeredCell::<3>::new(u64::from(BASE_PIXELS * BASE_TWISTS), u64::from(i));
    let (turn, step) = (cell.cube as u32 / BASE_PIXELS, cell.cube as u32 % BASE_PIXELS);
    // Faces in the order 0, 7, 2, 9, 4, 11, ...: north, equator, south; twists 3 apart first.
    let face = 7 * step % BASE_PIXELS;
    let base_twist = (3 * turn + turn / 2 + 2 * step) % BASE_TWISTS;
    let side = 1 << cell.level;
    let [ix, iy, part] = cell.place;
    let pixel = Cell::new(Nside::new(side).ok()?, face as u8, ix, iy).ok()?;
    let swing = shortest_rotation_of_z(pixel.centre());
    Some(swing * twist(base_twist * side + part, BASE_TWISTS * side))
}

/// Returns the shortest rotation from z to a direction; from z to -z, the one about y.
fn shortest_rotation_of_z(to: DVec3) -> DQuat {
    // The half angle from hypot and z, both accurate at the poles.
    let half = 0.5 * to.x.hypot(to.y).atan2(to.z);
    let phi = to.y.atan2(to.x);
    let (sin_half, cos_half) = half.sin_cos();
    let (sin_phi, cos_phi) = phi.sin_cos();
    DQuat::from_xyzw(-sin_half * sin_phi, sin_half * cos_phi, 0.0, cos_half)
}

/// Returns the rotation about z by the centre of part `k` of `parts` equal parts of a turn.
fn twist(k: u32, parts: u32) -> DQuat {
    DQuat::from_rotation_z(TAU * (f64::from(k) + 0.5) / f64::from(parts))
}

/// Parameters of the pattern `healpix-hopf`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HealpixHopfParameters {
    /// One grid, or the sequence of grids.
    pub order: HopfOrder,
}

impl HealpixHopfParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { order: HopfOrder::Grid };
}

impl Default for HealpixHopfParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for HealpixHopfParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.choice("order", "one grid, or a sequence of ever finer grids", &mut self.order);
    }
}

impl Definition<RotationGroup> for HealpixHopfParameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "irregular",
            smooth_rate: Rate::power(-1.33),
            jump_rate: Rate::Depends,
            is_extensible: self.order == HopfOrder::Layered,
            source: "Yershova, Jain, LaValle and Mitchell 2010",
        }
    }

    fn valid_counts(&self, _: RotationGroup) -> ValidCounts {
        match self.order {
            HopfOrder::Grid => {
                ValidCounts::Cubes { unit: (BASE_PIXELS * BASE_TWISTS) as usize, root: "nside" }
            }
            HopfOrder::Layered => ValidCounts::Any,
        }
    }

    fn build(
        &self,
        n_points: usize,
        space: RotationGroup,
    ) -> Result<Box<dyn RotationSampler>, Error> {
        if self.order == HopfOrder::Layered {
            return Ok(Box::new(HealpixHopf::layered(n_points)?));
        }
        let too_many = Error::TooManyPoints {
            pattern: "healpix-hopf",
            requested: n_points,
            max: 72 * 390 * 390 * 390,
        };
        let nside = self.valid_counts(space).size("healpix-hopf", n_points)?;
        Ok(Box::new(HealpixHopf::grid(Nside::new(nside).map_err(|_| too_many)?)?))
    }
}
