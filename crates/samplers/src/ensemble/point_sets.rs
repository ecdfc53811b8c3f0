use std::fmt;
use std::sync::Arc;

use rand::{Rng, RngExt};

use crate::space::internal;
use crate::{
    Domain, Ensemble, Error, Point, PointSet, Progress, Sampler, SamplerFamily, SetDistribution,
    Space, Square, SquareDistribution, SquareSampler, ValidCounts,
};

/// Given point sets, with or without weights, as a sampler that draws one of them uniformly.
///
/// As an [`Ensemble`] it yields the sets in their order, without rotation or shift. As a [`SamplerFamily`]
/// it can be ranked beside patterns, at its own number of points; clones share the points.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_samplers::{Domain, PointSet, PointSets, Sampler};
///
/// let axes = PointSet::new(vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z]);
/// let octahedron = PointSets::new(vec![axes], Domain::Sphere)?;
/// assert!(octahedron.n_points() == 6 && !octahedron.is_random());
/// assert_eq!(octahedron.with_name("octahedron").to_string(), "octahedron");
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone)]
pub struct PointSets<S: Space = Domain> {
    name: Arc<str>,
    sets: Arc<[PointSet<S::Point>]>,
    space: S,
    group: usize,
}

impl<S: Space> PointSets<S> {
    /// Returns the sampler of one or more sets of one or more points each. Directions are normalized
    /// to length 1; on the hemisphere, those with z < 0 are replaced by their antipodes.
    ///
    /// # Errors
    ///
    /// [`Error::Given`] if there are no sets, or if a set is empty, has a number of weights other
    /// than 0 or its number of points, or contains a zero or non-finite vector, a point outside
    /// `[0, 1)^2`, a weight that is not finite, or only zero weights.
    pub fn new(mut sets: Vec<PointSet<S::Point>>, space: S) -> Result<Self, Error> {
        if sets.is_empty() {
            return Err(Error::Given { reason: "there is no set".to_owned() });
        }
        for (i, set) in sets.iter_mut().enumerate() {
            let wrong = |reason| Error::Given { reason: format!("set {i} {reason}") };
            set.check_lengths().map_err(wrong)?;
            for (k, point) in set.points.iter_mut().enumerate() {
                *point = space.located(*point).ok_or_else(|| {
                    let fault = <S::Point as internal::Point>::NOWHERE;
                    wrong(format!("has {fault} at point {k} (0-based): {point:?}"))
                })?;
            }
            check_weights(set).map_err(wrong)?;
        }
        let group = hash(&sets);
        Ok(Self { name: "point sets".into(), sets: sets.into(), space, group })
    }

    /// Returns the same sets with a name for tables and messages, the `Display` text. The default
    /// is `point sets`.
    #[must_use]
    pub fn with_name(self, name: &str) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Returns a hash of all points and weights.
    pub(crate) fn group(&self) -> usize {
        self.group
    }

    /// Returns the mean number of points of the sets, rounded.
    pub(crate) fn mean_count(&self) -> usize {
        let total: usize = self.sets.iter().map(PointSet::len).sum();
        (total + self.sets.len() / 2) / self.sets.len()
    }

    /// Replaces the content of `set` by one of the sets, drawn uniformly.
    pub(crate) fn draw(&self, rng: &mut dyn Rng, set: &mut PointSet<S::Point>) {
        let at = if self.sets.len() == 1 { 0 } else { rng.random_range(0..self.sets.len()) };
        set.clone_from(&self.sets[at]);
    }

    /// Returns whether all sets are single points. A mean number of points of 1 is no proof.
    fn are_single(&self) -> bool {
        self.sets.iter().all(|set| set.len() == 1)
    }

    /// Returns the sets.
    #[must_use]
    pub fn sets(&self) -> &[PointSet<S::Point>] {
        &self.sets
    }
}

/// Rejects invalid weights.
fn check_weights<P>(set: &PointSet<P>) -> Result<(), String> {
    set.check_weights()?;
    if !set.weights.is_empty() && set.weights.iter().all(|&w| w == 0.0) {
        return Err("has no weight: every weight is 0".to_owned());
    }
    Ok(())
}

/// Returns a hash of all numbers (64-bit FNV-1a, by words).
#[expect(clippy::cast_possible_truncation, reason = "any bits of a hash suffice")]
fn hash<P: Point>(sets: &[PointSet<P>]) -> usize {
    let step = |hash: u64, word: u64| (hash ^ word).wrapping_mul(0x0100_0000_01b3);
    let mut hash = 0xcbf2_9ce4_8422_2325;
    for set in sets {
        hash = step(hash, set.points.len() as u64);
        let numbers = set
            .points
            .iter()
            .flat_map(|p| internal::Point::coordinates(p))
            .chain(set.weights.iter().copied());
        hash = numbers.fold(hash, |hash, x| step(hash, x.to_bits().rotate_left(32)));
    }
    (hash ^ (hash >> 32)) as usize
}

/// Omits the points, which can be numerous.
impl<S: Space> fmt::Debug for PointSets<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PointSets")
            .field("name", &self.name)
            .field("sets", &self.sets.len())
            .field("n_points", &self.mean_count())
            .field("domain", &self.space)
            .field("group", &self.group)
            .finish()
    }
}

/// Writes the name.
impl<S: Space> fmt::Display for PointSets<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.name)
    }
}

/// The sets at their own number of points, the only valid count.
impl<S: Space> SamplerFamily<S> for PointSets<S> {
    /// # Errors
    ///
    /// [`Error::InvalidCount`] for another number of points, and [`Error::Given`] for another
    /// domain.
    fn build(&self, n_points: usize, space: S) -> Result<Box<S::Sampler>, Error> {
        if space != self.space {
            let reason = format!("{self} are on the {}, not on the {space}", self.space);
            return Err(Error::Given { reason });
        }
        let nearest = self.mean_count();
        if n_points != nearest {
            return Err(Error::InvalidCount {
                pattern: self.name.to_string(),
                space: space.to_string(),
                requested: n_points,
                nearest,
                rule: ValidCounts::Listed(vec![nearest].into()),
            });
        }
        Ok(S::boxed(self.clone()))
    }

    fn nearest_count(&self, _requested: usize, _space: S) -> usize {
        self.mean_count()
    }
}

impl Sampler for PointSets {
    /// Returns the mean number of points of the sets, rounded.
    fn n_points(&self) -> usize {
        self.mean_count()
    }

    fn domain(&self) -> Domain {
        self.space
    }

    fn distribution(&self) -> SetDistribution<'_> {
        SetDistribution::OneOf(&self.sets)
    }

    fn stream_group(&self) -> usize {
        self.group
    }

    fn is_independent(&self) -> bool {
        self.are_single()
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        self.draw(rng, set);
        Ok(())
    }
}

impl SquareSampler for PointSets<Square> {
    /// Returns the mean number of points of the sets, rounded.
    fn n_points(&self) -> usize {
        self.mean_count()
    }

    fn distribution(&self) -> SquareDistribution<'_> {
        SquareDistribution::OneOf(&self.sets)
    }

    fn stream_group(&self) -> usize {
        self.group
    }

    fn is_independent(&self) -> bool {
        self.are_single()
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        self.draw(rng, set);
        Ok(())
    }
}

impl<S: Space> Ensemble<S::Point> for PointSets<S> {
    /// # Errors
    ///
    /// [`Error::Given`] if there is no set of that number.
    fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet<S::Point>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        Ensemble::realize_into(&self.sets(), index, set, progress)
    }
}

/// The given sets in their order; they take no work to generate.
impl<P: Point> Ensemble<P> for &[PointSet<P>] {
    /// # Errors
    ///
    /// [`Error::Given`] if no set has that index, or the set is invalid.
    fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet<P>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let given = usize::try_from(index).ok().and_then(|i| self.get(i));
        let given = given.ok_or_else(|| Error::Given {
            reason: format!(
                "set {index} (0-based) is requested, but there are {} sets",
                self.len()
            ),
        })?;
        let wrong = |reason| Error::Given { reason: format!("set {index} {reason}") };
        given.check_points().map_err(wrong)?;
        set.clone_from(given);
        Ok(progress.tick(0.0)?)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::PointSets;
    use crate::{Domain, PointSet, Purpose, Realizations, Sampler, Streams};

    #[test]
    fn what_is_no_set_is_an_error() {
        let set = |points: &[DVec3], weights: &[f64]| PointSet {
            points: points.to_vec(),
            weights: weights.to_vec(),
        };
        let cases = [
            (vec![], "no set"),
            (vec![set(&[], &[])], "no points"),
            (vec![set(&[DVec3::X], &[1.0, 2.0])], "1 points and 2 weights"),
            (vec![set(&[DVec3::X], &[]), set(&[DVec3::ZERO], &[])], "set 1 has no direction"),
            (vec![set(&[DVec3::NAN], &[])], "no direction at point 0"),
            (vec![set(&[DVec3::X], &[f64::NAN])], "not finite"),
            (vec![set(&[DVec3::X, DVec3::Y], &[0.0, -0.0])], "every weight is 0"),
        ];
        for (sets, expected) in cases {
            let error = PointSets::new(sets, Domain::Sphere).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn every_set_is_drawn_as_often_and_streams_follow_the_points() {
        let one = |x: f64| PointSet::new(vec![DVec3::new(x, 0.0, 1.0), DVec3::X]);
        let sets = PointSets::new(vec![one(0.0), one(0.5), one(1.0)], Domain::Hemisphere).unwrap();
        let drawn = Realizations::unrotated(&sets, Streams::new(0, Purpose::Pattern, 0));
        let mut counts = [0_u32; 3];
        for i in 0..3000 {
            let set = drawn.realize(i).unwrap();
            counts[sets.sets().iter().position(|s| *s == set).unwrap()] += 1;
        }
        // 1000 each with a standard deviation of 26: beyond 5 by chance in 2e-6 of seeds.
        assert!(counts.iter().all(|c| c.abs_diff(1000) < 130), "{counts:?}");
        let other = PointSets::new(vec![one(0.0), one(0.5), one(1.1)], Domain::Hemisphere).unwrap();
        assert_ne!(sets.stream_group(), other.stream_group());
    }
}
