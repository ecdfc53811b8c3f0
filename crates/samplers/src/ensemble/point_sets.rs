use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use rand::{Rng, RngExt};

use crate::{
    Domain, Ensemble, Error, PointSet, Progress, Sampler, SamplerFamily, SetDistribution,
    ValidCounts,
};

/// Given point sets, with or without weights, as a sampler that draws one of them uniformly.
///
/// As an [`Ensemble`] it yields the sets in their order, without rotation. As a [`SamplerFamily`]
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
pub struct PointSets {
    name: Arc<str>,
    sets: Arc<[PointSet]>,
    domain: Domain,
    group: usize,
}

impl PointSets {
    /// Returns the sampler of one or more sets of one or more points each. Points are normalized to
    /// length 1; on the hemisphere, those with z < 0 are replaced by their antipodes.
    ///
    /// # Errors
    ///
    /// [`Error::Given`] if there are no sets, or if a set is empty, has a number of weights other
    /// than 0 or its number of points, or contains a zero or non-finite vector, a weight that is
    /// not finite, or only zero weights.
    pub fn new(mut sets: Vec<PointSet>, domain: Domain) -> Result<Self, Error> {
        if sets.is_empty() {
            return Err(Error::Given { reason: "there is no set".to_owned() });
        }
        for (i, set) in sets.iter_mut().enumerate() {
            check(set).map_err(|reason| Error::Given { reason: format!("set {i} {reason}") })?;
            for p in &mut set.points {
                // Unit vectors stay bit-identical.
                let is_unit = (p.length_squared() - 1.0).abs() <= 4.0 * f64::EPSILON;
                let unit = if is_unit { *p } else { direction(*p).unwrap_or(*p) };
                *p = domain.representative(unit);
            }
        }
        let group = hash(&sets);
        Ok(Self { name: "point sets".into(), sets: sets.into(), domain, group })
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

    /// Returns the sets.
    #[must_use]
    pub fn sets(&self) -> &[PointSet] {
        &self.sets
    }
}

/// Rejects invalid sets.
fn check(set: &PointSet) -> Result<(), String> {
    set.check_lengths()?;
    if let Some(k) = set.points.iter().position(|p| direction(*p).is_none()) {
        return Err(format!("has no direction at point {k} (0-based): {:?}", set.points[k]));
    }
    set.check_weights()?;
    if !set.weights.is_empty() && set.weights.iter().all(|&w| w == 0.0) {
        return Err("has no weight: every weight is 0".to_owned());
    }
    Ok(())
}

/// Returns the unit vector along a vector of any length.
fn direction(p: DVec3) -> Option<DVec3> {
    (p / p.abs().max_element()).try_normalize()
}

/// Returns a hash of all numbers (64-bit FNV-1a, by words).
#[expect(clippy::cast_possible_truncation, reason = "any bits of a hash suffice")]
fn hash(sets: &[PointSet]) -> usize {
    let step = |hash: u64, word: u64| (hash ^ word).wrapping_mul(0x0100_0000_01b3);
    let mut hash = 0xcbf2_9ce4_8422_2325;
    for set in sets {
        hash = step(hash, set.points.len() as u64);
        let numbers =
            set.points.iter().flat_map(|p| p.to_array()).chain(set.weights.iter().copied());
        hash = numbers.fold(hash, |hash, x| step(hash, x.to_bits().rotate_left(32)));
    }
    (hash ^ (hash >> 32)) as usize
}

/// Omits the points, which can be numerous.
impl fmt::Debug for PointSets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PointSets")
            .field("name", &self.name)
            .field("sets", &self.sets.len())
            .field("n_points", &self.n_points())
            .field("domain", &self.domain)
            .field("group", &self.group)
            .finish()
    }
}

/// Writes the name.
impl fmt::Display for PointSets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.name)
    }
}

/// The sets at their own number of points, the only valid count.
impl SamplerFamily for PointSets {
    /// # Errors
    ///
    /// [`Error::InvalidCount`] for another number of points, and [`Error::Given`] for another
    /// domain.
    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        if domain != self.domain {
            let reason = format!("{self} are on the {}, not on the {domain}", self.domain);
            return Err(Error::Given { reason });
        }
        let nearest = self.n_points();
        if n_points != nearest {
            let (pattern, requested) = (self.name.to_string(), n_points);
            let rule = ValidCounts::Listed(vec![nearest].into());
            return Err(Error::InvalidCount { pattern, domain, requested, nearest, rule });
        }
        Ok(Box::new(self.clone()))
    }

    fn nearest_count(&self, _requested: usize, _domain: Domain) -> usize {
        self.n_points()
    }
}

impl Sampler for PointSets {
    /// Returns the mean number of points of the sets, rounded.
    fn n_points(&self) -> usize {
        let total: usize = self.sets.iter().map(PointSet::len).sum();
        (total + self.sets.len() / 2) / self.sets.len()
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        SetDistribution::OneOf(&self.sets)
    }

    fn stream_group(&self) -> usize {
        self.group
    }

    /// Returns `true` if all sets are single points. A mean number of points of 1 is no proof.
    fn is_independent(&self) -> bool {
        self.sets.iter().all(|set| set.len() == 1)
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        let at = if self.sets.len() == 1 { 0 } else { rng.random_range(0..self.sets.len()) };
        set.clone_from(&self.sets[at]);
        Ok(())
    }
}

impl Ensemble for PointSets {
    /// # Errors
    ///
    /// [`Error::Given`] if there is no set of that number.
    fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        Ensemble::realize_into(&self.sets(), index, set, progress)
    }
}

/// The given sets in their order; they take no work to generate.
impl Ensemble for &[PointSet] {
    /// # Errors
    ///
    /// [`Error::Given`] if no set has that index, or the set is invalid.
    fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet,
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
