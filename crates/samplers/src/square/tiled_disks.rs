use rand::Rng;
use sphvar_grammar::{Declaration, Parametric, Range};

use super::jittered_square::within;
use crate::definition::Definition;
use crate::{
    CostOrder, DiskMode, Error, PatternFacts, PointSet, PoissonDiskSquare, Progress, Rate, Square,
    SquareSampler, ValidCounts,
};

const NAME: &str = "tiled-disks";

/// One toroidal set of Poisson disks, reduced in size and repeated in `repeats x repeats` tiles:
/// [`PoissonDiskSquare`] of `N/repeats^2` points.
///
/// With K repeats the set is periodic with period 1/K in both coordinates, so all its power lies at
/// frequencies that are multiples of K,
///
/// ```text
/// P(K k) = K^2 P_tile(k),    P(k) = 0 elsewhere.
/// ```
///
/// Integrands whose frequencies are below K are therefore integrated exactly, although the tile has
/// power near 0; the mean power over all frequencies is that without repetition, in peaks of K^2
/// times the height. Minimum distances hold across the edges of the tiles.
///
/// ```
/// use sphvar_samplers::{Purpose, SquareSampler, Streams, TiledDisks};
/// let tiled = TiledDisks::new(144, 4, None)?;
/// let set = tiled.sample(&mut Streams::new(0, Purpose::Pattern, 144).realization(0))?;
/// let phases = set.points.iter().map(|p| std::f64::consts::TAU * (3.0 * p[0] + 2.0 * p[1]));
/// assert!(phases.map(f64::cos).sum::<f64>().abs() < 1e-10);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiledDisks {
    tile: PoissonDiskSquare,
    repeats: u32,
}

impl TiledDisks {
    /// The default number of repeats along each side.
    pub const DEFAULT_REPEATS: u32 = 4;

    /// The largest valid number of repeats.
    pub const MAX_REPEATS: u32 = 10_000;

    /// Returns the pattern of `n_points` points in `repeats^2` tiles, with disks of
    /// `radius/sqrt(n_points)` or of [`PoissonDiskSquare::default_radius`].
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `repeats` is from 1 to [`Self::MAX_REPEATS`];
    /// [`Error::InvalidCount`] unless `n_points` is a multiple of `repeats^2`; those of
    /// [`PoissonDiskSquare::new`] for the tile.
    pub fn new(n_points: usize, repeats: u32, radius: Option<f64>) -> Result<Self, Error> {
        if !(1..=Self::MAX_REPEATS).contains(&repeats) {
            let (name, range) = ("repeats", "a whole number from 1 to 10000");
            return Err(Error::Parameter { name, range, got: f64::from(repeats) });
        }
        if n_points == 0 {
            return Err(Error::NoPoints { pattern: NAME.to_owned() });
        }
        let tiles = tiles(repeats);
        if !n_points.is_multiple_of(tiles) {
            let rule = ValidCounts::Multiples { of: tiles };
            return Err(Error::InvalidCount {
                pattern: NAME.to_owned(),
                space: Square.to_string(),
                requested: n_points,
                nearest: rule.nearest(n_points),
                rule,
            });
        }
        let tile = PoissonDiskSquare::new(n_points / tiles, DiskMode::Exact, true, radius)?;
        Ok(Self { tile, repeats })
    }

    /// Returns the pattern of a tile, before it is reduced in size.
    #[must_use]
    pub fn tile(&self) -> PoissonDiskSquare {
        self.tile
    }

    /// Returns the number of tiles along each side.
    #[must_use]
    pub fn repeats(&self) -> u32 {
        self.repeats
    }
}

fn tiles(repeats: u32) -> usize {
    (repeats as usize).pow(2)
}

impl SquareSampler for TiledDisks {
    fn n_points(&self) -> usize {
        self.tile.n_points() * tiles(self.repeats)
    }

    fn nominal_work(&self) -> f64 {
        self.tile.nominal_work() + self.n_points() as f64
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let mut tile = PointSet::default();
        self.tile.sample_watched(rng, &mut tile, progress)?;
        let points = set.start();
        for row in 0..self.repeats {
            progress.tick(0.0)?;
            for column in 0..self.repeats {
                points.extend(tile.points.iter().map(|&[u, v]| {
                    [within(column, self.repeats, u), within(row, self.repeats, v)]
                }));
            }
        }
        Ok(())
    }
}

/// Parameters of the pattern [`TiledDisks`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiledDisksParameters {
    /// The number of tiles along each side.
    pub repeats: u32,
    /// The minimum distance times sqrt(N), or [`PoissonDiskSquare::default_radius`].
    pub radius: Option<f64>,
}

impl TiledDisksParameters {
    /// The default parameters.
    pub const DEFAULT: Self = Self { repeats: TiledDisks::DEFAULT_REPEATS, radius: None };
}

impl Default for TiledDisksParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for TiledDisksParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let range = [1, i64::from(TiledDisks::MAX_REPEATS)];
        d.integer("repeats", range, "tiles along each side", &mut self.repeats);
        let summary = "minimum distance times sqrt(N)";
        d.optional_number("radius", Range::POSITIVE, summary, "by N", &mut self.radius);
    }
}

impl Definition<Square> for TiledDisksParameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "0 except at multiples of the repeats",
            smooth_rate: Rate::power(-1.0),
            jump_rate: Rate::power(-1.0),
            is_extensible: false,
            source: "Singh 2015, section 8.1",
        }
    }

    fn valid_counts(&self, _: Square) -> ValidCounts {
        ValidCounts::Multiples { of: tiles(self.repeats) }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(TiledDisks::new(n_points, self.repeats, self.radius)?))
    }
}
