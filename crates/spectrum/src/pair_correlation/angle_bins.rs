use std::f64::consts::{FRAC_PI_2, PI};

use sphvar_samplers::Domain;

use crate::Error;

/// Equal bins of the angle between two points, from 0 to a largest angle in radians.
///
/// On the hemisphere the angle is that between two lines, at max pi/2.
///
/// # Examples
///
/// ```
/// use sphvar_samplers::Domain;
/// use sphvar_spectrum::AngleBins;
///
/// let bins = AngleBins::new(Domain::Sphere, 1.0, 4)?;
/// assert_eq!(bins.centres(), [0.125, 0.375, 0.625, 0.875]);
/// assert!(AngleBins::new(Domain::Hemisphere, 2.0, 4).is_err());
/// # Ok::<(), sphvar_spectrum::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleBins {
    domain: Domain,
    max_angle: f64,
    count: usize,
}

impl AngleBins {
    /// The maximum number of bins.
    pub const MAX_COUNT: usize = 10_000;

    /// Returns `count` bins up to `max_angle`.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless `max_angle` is above 0 and at max pi, pi/2 on the hemisphere, and
    /// `count` from 1 to [`MAX_COUNT`](Self::MAX_COUNT).
    pub fn new(domain: Domain, max_angle: f64, count: usize) -> Result<Self, Error> {
        let expected = match domain {
            Domain::Sphere => "above 0 and at max pi (180 degrees)",
            Domain::Hemisphere => "above 0 and at max pi/2 (90 degrees)",
        };
        if !(max_angle > 0.0 && max_angle <= Self::limit(domain)) {
            return Err(Error::Setting { what: "the largest angle", expected, got: max_angle });
        }
        if !(1..=Self::MAX_COUNT).contains(&count) {
            let (what, expected) = ("the number of bins", "from 1 to 10000");
            return Err(Error::Setting { what, expected, got: count as f64 });
        }
        Ok(Self { domain, max_angle, count })
    }

    /// Returns 100 bins up to five times the mean spacing `sqrt(area/N)`, or the whole range of
    /// angles if that is smaller.
    #[must_use]
    pub fn natural(domain: Domain, n_points: usize) -> Self {
        let spacing = (domain.area() / n_points.max(1) as f64).sqrt();
        Self { domain, max_angle: Self::limit(domain).min(5.0 * spacing), count: 100 }
    }

    /// Returns the largest angle of the domain: pi, or pi/2 between lines.
    pub(super) fn limit(domain: Domain) -> f64 {
        if domain == Domain::Sphere { PI } else { FRAC_PI_2 }
    }

    /// Returns the domain of the points.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.domain
    }

    /// Returns the largest angle.
    #[must_use]
    pub fn max_angle(&self) -> f64 {
        self.max_angle
    }

    /// Returns the number of bins.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns the middle of every bin.
    #[must_use]
    pub fn centres(&self) -> Vec<f64> {
        (0..self.count).map(|i| self.at(i as f64 + 0.5)).collect()
    }

    /// Returns the upper edge of every bin.
    #[must_use]
    pub fn upper_edges(&self) -> Vec<f64> {
        (1..=self.count).map(|i| self.at(i as f64)).collect()
    }

    fn at(&self, position: f64) -> f64 {
        self.max_angle * (position / self.count as f64)
    }

    /// Returns the bin of an angle; the last one includes its upper edge.
    #[inline]
    pub(super) fn bin(&self, angle: f64) -> Option<usize> {
        // A right angle between lines may be rounded up.
        if angle > self.max_angle * (1.0 + 4.0 * f64::EPSILON) {
            return None;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the number of bins"
        )]
        let bin = (angle / self.max_angle * self.count as f64) as usize;
        Some(bin.min(self.count - 1))
    }

    /// Returns the share of the domain within `angle` of a point.
    pub(super) fn cap_share(domain: Domain, angle: f64) -> f64 {
        // (1 - cos)/2 on the sphere, 1 - cos between lines, without cancellation.
        let half = (0.5 * angle).sin().powi(2);
        if domain == Domain::Sphere { half } else { 2.0 * half }
    }

    /// Returns the share of the domain in every bin around a point.
    pub(super) fn shares(&self) -> Vec<f64> {
        let factor = if self.domain == Domain::Sphere { 1.0 } else { 2.0 };
        // cos a - cos b = 2 sin((a + b)/2) sin((b - a)/2)
        let thickness = (0.5 * self.at(1.0)).sin();
        self.centres().into_iter().map(|centre| factor * centre.sin() * thickness).collect()
    }
}

/// Finds the bin of a pair from the square of its chord, without an arcsine.
#[derive(Clone, Debug)]
pub(super) struct ChordBins {
    /// The squares of the chords at the upper edges of the bins.
    edges: Vec<f64>,
    /// The bin at the beginning of each of equal intervals of the squared chord.
    first: Vec<u32>,
    intervals_per_unit: f64,
}

impl ChordBins {
    /// Intervals for each bin: bins of small angles are narrow in the squared chord.
    const INTERVALS: usize = 16;

    pub(super) fn new(bins: &AngleBins) -> Self {
        let squared_chord = |angle: f64| 4.0 * (0.5 * angle).sin().powi(2);
        let mut edges: Vec<f64> = bins.upper_edges().into_iter().map(squared_chord).collect();
        if let Some(last) = edges.last_mut() {
            // A right angle between lines may be rounded up.
            *last *= 1.0 + 8.0 * f64::EPSILON;
        }
        let max = edges.last().copied().unwrap_or(0.0);
        let count = Self::INTERVALS * bins.count();
        let first = (0..=count).map(|i| {
            let square = max * (i as f64 / count as f64);
            // At max MAX_COUNT bins.
            u32::try_from(edges.partition_point(|edge| *edge <= square)).unwrap_or(u32::MAX)
        });
        let first = first.collect();
        Self { first, intervals_per_unit: count as f64 / max, edges }
    }

    /// Returns the bin of a squared chord; the last one includes its upper edge.
    #[inline]
    pub(super) fn bin(&self, square: f64) -> Option<usize> {
        let max = *self.edges.last()?;
        if square >= max {
            return (square <= max).then_some(self.edges.len() - 1);
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the number of intervals"
        )]
        let interval = (square * self.intervals_per_unit) as usize;
        let first = self.first.get(interval).map_or(0, |&first| first as usize);
        let mut bin = first.min(self.edges.len() - 1);
        while square >= self.edges[bin] {
            bin += 1;
        }
        // The interval may be rounded up across an edge.
        while bin > 0 && square < self.edges[bin - 1] {
            bin -= 1;
        }
        Some(bin)
    }
}

/// Returns the angle between two directions from the square of their chord.
#[inline]
pub(super) fn angle_of_chord(chord_squared: f64) -> f64 {
    2.0 * (0.5 * chord_squared.sqrt()).min(1.0).asin()
}
