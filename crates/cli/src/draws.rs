//! The numbered sets of a sampler, as `sphvar sample` draws them.

use glam::{DQuat, DVec3};
use sphvar_integrands::{Heuristic, Strategy};
use sphvar_samplers::{
    Domain, Ensemble, Error, Pattern, PointSet, Progress, Purpose, Realizations, RotationGroup,
    RotationPattern, RotationRealizations, RotationSampler, RotationSet, Sampler, SetDistribution,
    Square, SquareDistribution, SquarePattern, SquareRealizations, SquareSampler, Streams, rotate,
    shift,
};
use sphvar_variance::{WarpedPattern, WarpedRealizations};

use crate::embedding::Failure;
use crate::error::CliError;
use crate::flags::missing_count;
use crate::integrands::strategies_of;
use crate::patterns::{self, DirectionSampler};
use crate::session::Session;

/// What is drawn: a sampler of directions, of points of the unit square or of rotations with its
/// options.
#[derive(Clone, Debug, Default)]
pub struct DrawRequest {
    /// The sampler, as the command accepts it.
    pub sampler: String,
    /// The number of points; `None` for samplers with a number of their own.
    pub n: Option<usize>,
    /// Use the valid number of points nearest to `n`.
    pub nearest: bool,
    /// Use the hemisphere instead of the sphere; only directions have it.
    pub hemisphere: bool,
    /// Apply an independent uniform random rotation to every set or, on the square, a shift.
    pub is_randomized: bool,
    /// The seed of all random numbers.
    pub seed: u64,
}

/// Which of the given sets of a file a numbered set is; other samplers have no given sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GivenSets {
    /// One of them, drawn uniformly.
    Drawn,
    /// That of the same number, modulo their number.
    InOrder,
}

/// The numbered sets of a sampler: directions, points `[u, v]` of the unit square or rotations. Set `i`
/// is a function of the request and `i` alone.
pub struct Draws<P = DVec3> {
    /// The sampler with its parameters.
    pub(crate) sampler: String,
    /// The name in titles and progress.
    pub(crate) label: String,
    n_points: usize,
    n_given: Option<usize>,
    nominal_work: f64,
    /// No set has power at any degree from 1 to this, for patterns that are made so.
    pub(crate) last_empty_degree: Option<usize>,
    /// A remark for the files.
    pub(crate) remark: Option<String>,
    sets: Box<dyn NumberedSets<P>>,
}

impl<P> std::fmt::Debug for Draws<P> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Draws")
            .field("sampler", &self.sampler)
            .field("n_points", &self.n_points)
            .finish_non_exhaustive()
    }
}

/// The sets of [`Draws`], which own their sampler.
trait NumberedSets<P>: Send + Sync {
    fn realize_into(
        &self,
        index: u64,
        given: GivenSets,
        set: &mut PointSet<P>,
        progress: &dyn Progress,
    ) -> Result<(), Error>;
}

impl Session {
    /// Returns the sets of directions of a sampler.
    ///
    /// # Errors
    ///
    /// Those of the command `sample` in its words.
    pub fn directions(&self, request: &DrawRequest) -> Result<Draws, Failure> {
        self.drawn(request, Draws::new)
    }

    /// Returns the sets of a sampler of the unit square.
    ///
    /// # Errors
    ///
    /// Those of the command `sample --square` in its words.
    pub fn square_points(&self, request: &DrawRequest) -> Result<Draws<[f64; 2]>, Failure> {
        self.drawn(request, Draws::square)
    }

    /// Returns the sets of a pattern of rotations.
    ///
    /// # Errors
    ///
    /// Those of the command `rotations` in its words.
    pub fn rotations(&self, request: &DrawRequest) -> Result<Draws<DQuat>, Failure> {
        self.drawn(request, Draws::rotations)
    }

    fn drawn<P>(
        &self,
        request: &DrawRequest,
        new: impl FnOnce(&DrawRequest, &Self) -> Result<Draws<P>, CliError>,
    ) -> Result<Draws<P>, Failure> {
        let run = self.run(&[]);
        new(request, &run).map_err(|error| Failure::of_run(error, &run))
    }
}

impl<P> Draws<P> {
    /// Returns the sampler with its parameters.
    #[must_use]
    pub fn sampler(&self) -> &str {
        &self.sampler
    }

    /// Returns the number of points of every set; where it varies, the requested or the mean number.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.n_points
    }

    /// Returns the number of given sets, at least 1, or `None` for samplers without given sets.
    #[must_use]
    pub fn n_given(&self) -> Option<usize> {
        self.n_given
    }

    /// Returns the nominal work of a set.
    #[must_use]
    pub fn nominal_work(&self) -> f64 {
        self.nominal_work
    }

    /// Replaces `set` by set `index`, and ticks its nominal work.
    ///
    /// # Errors
    ///
    /// If the set cannot be generated, and [`Error::Stopped`] if `progress` stopped the work.
    pub fn realize_into(
        &self,
        index: u64,
        given: GivenSets,
        set: &mut PointSet<P>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        self.sets.realize_into(index, given, set, progress)
    }
}

impl Draws {
    /// Returns the sets of directions of a sampler. Reports remarks on files.
    ///
    /// # Errors
    ///
    /// If the request is invalid or a file cannot be read.
    pub(crate) fn new(request: &DrawRequest, session: &Session) -> Result<Self, CliError> {
        let domain = if request.hemisphere { Domain::Hemisphere } else { Domain::Sphere };
        match patterns::parse_sampler(&request.sampler, session)? {
            DirectionSampler::Uniform(pattern) => Self::uniform(&pattern, request, domain, session),
            DirectionSampler::Warped(pattern) => Self::warped(&pattern, request, domain, session),
            DirectionSampler::Adapted(pattern) => Err(CliError::Usage(format!(
                "{pattern}: sample has patterns with warp=; lights writes the sites of {pattern} for a map"
            ))),
        }
    }

    fn uniform(
        pattern: &Pattern,
        request: &DrawRequest,
        domain: Domain,
        session: &Session,
    ) -> Result<Self, CliError> {
        let sampler =
            patterns::nearest_sampler(pattern, request.n, domain, request.nearest, session)?;
        let last_empty_degree = sampler.last_empty_degree();
        let n_given = match sampler.distribution() {
            SetDistribution::OneOf(sets) => Some(sets.len()),
            _ => None,
        };
        Ok(Self {
            sampler: pattern.to_string(),
            label: pattern.label(),
            n_points: sampler.n_points(),
            n_given,
            nominal_work: sampler.nominal_work(),
            last_empty_degree,
            remark: last_empty_degree.map(|last| no_power(last, domain)),
            sets: Box::new(DirectionSets {
                streams: streams(sampler.sequence_group(), sampler.stream_group(), request.seed),
                sampler,
                is_rotated: request.is_randomized,
            }),
        })
    }

    fn warped(
        pattern: &WarpedPattern,
        request: &DrawRequest,
        domain: Domain,
        session: &Session,
    ) -> Result<Self, CliError> {
        if request.is_randomized {
            let advice =
                "warped patterns are shifted on the square before they are mapped, not rotated";
            return Err(CliError::Usage(format!("--rotate does not apply to {pattern}: {advice}")));
        }
        let requested = request.n.or(pattern.own_count()).ok_or_else(missing_count)?;
        let (n_points, samplers) = patterns::build_warped(pattern, requested, request.nearest)?;
        if n_points != requested {
            let label = pattern.label();
            let remark = format!(
                "{label}: {n_points} points, the valid count nearest to the requested {requested}"
            );
            session.say(&remark);
        }
        let strategies = strategies_of(&[&pattern.warp], domain, session)?.concat();
        Ok(Self {
            sampler: pattern.to_string(),
            label: pattern.label(),
            n_points,
            n_given: None,
            nominal_work: pattern.trial_work(n_points),
            last_empty_degree: None,
            remark: Some("weights 1/(N p)".to_owned()),
            sets: Box::new(WarpedSets {
                strategies,
                heuristic: pattern.heuristic,
                samplers,
                seed: request.seed,
            }),
        })
    }
}

impl Draws<[f64; 2]> {
    /// Returns the sets of a sampler of the unit square, which has no hemisphere. Reports remarks on
    /// files.
    ///
    /// # Errors
    ///
    /// If the request is invalid or a file cannot be read.
    pub(crate) fn square(request: &DrawRequest, session: &Session) -> Result<Self, CliError> {
        let DrawRequest { sampler, n, nearest, .. } = request;
        let (pattern, sampler) =
            patterns::sampler_of::<SquarePattern, _>(sampler, *n, Square, *nearest, session)?;
        let n_given = match sampler.distribution() {
            SquareDistribution::OneOf(sets) => Some(sets.len()),
            _ => None,
        };
        Ok(Self {
            sampler: pattern.to_string(),
            label: pattern.label(),
            n_points: sampler.n_points(),
            n_given,
            nominal_work: sampler.nominal_work(),
            last_empty_degree: None,
            remark: None,
            sets: Box::new(SquareSets {
                streams: streams(sampler.sequence_group(), sampler.stream_group(), request.seed),
                sampler,
                is_shifted: request.is_randomized,
            }),
        })
    }
}

impl Draws<DQuat> {
    /// Returns the sets of a pattern of rotations. Reports remarks.
    ///
    /// # Errors
    ///
    /// If the request is invalid.
    pub(crate) fn rotations(request: &DrawRequest, session: &Session) -> Result<Self, CliError> {
        let DrawRequest { sampler, n, nearest, seed, .. } = request;
        let (pattern, sampler) = patterns::sampler_of::<RotationPattern, _>(
            sampler,
            *n,
            RotationGroup,
            *nearest,
            session,
        )?;
        let n_points = sampler.n_points();
        Ok(Self {
            sampler: pattern.to_string(),
            label: pattern.to_string(),
            n_points,
            n_given: None,
            nominal_work: n_points as f64,
            last_empty_degree: None,
            remark: None,
            sets: Box::new(RotationSets {
                sampler,
                is_rotated: request.is_randomized,
                seed: *seed,
            }),
        })
    }
}

/// Returns the realizations of a sampler of rotations.
pub(crate) fn rotation_realizations(
    sampler: &dyn RotationSampler,
    is_rotated: bool,
    seed: u64,
) -> RotationRealizations<'_> {
    let streams = streams(sampler.sequence_group(), sampler.stream_group(), seed);
    if is_rotated {
        RotationRealizations::rotated(sampler, streams)
    } else {
        RotationRealizations::unrotated(sampler, streams)
    }
}

struct DirectionSets {
    sampler: Box<dyn Sampler>,
    streams: Streams,
    is_rotated: bool,
}

impl NumberedSets<DVec3> for DirectionSets {
    fn realize_into(
        &self,
        index: u64,
        given: GivenSets,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let drawn = if self.is_rotated {
            Realizations::rotated(&*self.sampler, self.streams)
        } else {
            Realizations::unrotated(&*self.sampler, self.streams)
        };
        match self.sampler.distribution() {
            SetDistribution::OneOf(sets) if given == GivenSets::InOrder => {
                sets.realize_into(index % sets.len() as u64, set, progress)?;
                rotate(drawn.rotation(index), self.sampler.domain(), &mut set.points);
                Ok(())
            }
            _ => drawn.realize_into(index, set, progress),
        }
    }
}

struct WarpedSets {
    strategies: Vec<Strategy>,
    heuristic: Heuristic,
    samplers: Vec<Box<dyn SquareSampler>>,
    seed: u64,
}

impl NumberedSets<DVec3> for WarpedSets {
    fn realize_into(
        &self,
        index: u64,
        _: GivenSets,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let Self { strategies, heuristic, samplers, seed } = self;
        WarpedRealizations::new(strategies, *heuristic, samplers, *seed, Purpose::Pattern)
            .of_prefixes()
            .realize_into(index, set, progress)
    }
}

struct SquareSets {
    sampler: Box<dyn SquareSampler>,
    streams: Streams,
    is_shifted: bool,
}

impl NumberedSets<[f64; 2]> for SquareSets {
    fn realize_into(
        &self,
        index: u64,
        given: GivenSets,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let drawn = if self.is_shifted {
            SquareRealizations::shifted(&*self.sampler, self.streams)
        } else {
            SquareRealizations::unshifted(&*self.sampler, self.streams)
        };
        match self.sampler.distribution() {
            SquareDistribution::OneOf(sets) if given == GivenSets::InOrder => {
                sets.realize_into(index % sets.len() as u64, set, progress)?;
                shift(drawn.shift(index), &mut set.points);
                Ok(())
            }
            _ => drawn.realize_into(index, set, progress),
        }
    }
}

struct RotationSets {
    sampler: Box<dyn RotationSampler>,
    is_rotated: bool,
    seed: u64,
}

impl NumberedSets<DQuat> for RotationSets {
    fn realize_into(
        &self,
        index: u64,
        _: GivenSets,
        set: &mut RotationSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        rotation_realizations(&*self.sampler, self.is_rotated, self.seed)
            .realize_into(index, set, progress)
    }
}

/// Returns the streams of the sequence that all numbers of points share, or of the sets of one number
/// of points where the pattern is no sequence.
fn streams(sequence_group: Option<usize>, set_group: usize, seed: u64) -> Streams {
    Streams::new(seed, Purpose::Pattern, sequence_group.unwrap_or(set_group))
}

/// Returns the remark on sets without power at the degrees up to `last`.
fn no_power(last: usize, domain: Domain) -> String {
    match (last, domain) {
        (0, _) => "power at every degree".to_owned(),
        (_, Domain::Sphere) => format!("no power at degrees 1 to {last}"),
        (_, Domain::Hemisphere) => format!("no power at even degrees 2 to {last}"),
    }
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::PointSet;

    use super::{DVec3, DrawRequest, Draws, GivenSets};
    use crate::given::PointTable;
    use crate::session::Session;

    fn realized(draws: &Draws, index: u64, given: GivenSets) -> Vec<DVec3> {
        let mut set = PointSet::default();
        draws.realize_into(index, given, &mut set, &()).unwrap();
        set.points
    }

    #[test]
    fn given_sets_repeat_with_new_rotations() {
        let session = Session::of_process(&[], true, None);
        let coordinates = vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let table =
            PointTable { coordinates, dimension: 3, sets: Some(3), ..PointTable::default() };
        session.add_points("axes", table).unwrap();
        let draws = |is_randomized| {
            let sampler = "file:axes".to_owned();
            let request = DrawRequest { sampler, is_randomized, ..DrawRequest::default() };
            session.directions(&request).unwrap()
        };
        let (plain, rotated) = (draws(false), draws(true));
        assert_eq!((plain.n_points(), plain.n_given()), (1, Some(3)));
        for (index, axis) in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::X].into_iter().enumerate() {
            assert_eq!(realized(&plain, index as u64, GivenSets::InOrder), [axis]);
        }
        let first = realized(&rotated, 0, GivenSets::InOrder);
        assert_eq!(first, realized(&rotated, 0, GivenSets::InOrder));
        assert_ne!(first, realized(&rotated, 3, GivenSets::InOrder));
        // Drawn sets are those of the command with -m.
        let drawn = |index| realized(&plain, index, GivenSets::Drawn)[0];
        assert!((0..20).any(|index| drawn(index) == DVec3::Z));
    }

    #[test]
    fn requests_that_cannot_be_are_errors_in_the_words_of_the_command() {
        let session = Session::of_process(&[], true, None);
        let message = |sampler: &str, n, is_randomized| {
            let sampler = sampler.to_owned();
            let request = DrawRequest { sampler, n, is_randomized, ..DrawRequest::default() };
            session.directions(&request).unwrap_err().message
        };
        assert!(message("fibonacci", None, false).contains("-n/--count"));
        assert!(message("healpix", Some(13), false).contains("use --nearest"));
        assert!(message("sobol:warp=cosine", Some(16), true).contains("--rotate does not apply"));
        assert!(message("super-fibonacci", Some(16), false).contains("a pattern of rotations"));
    }
}
