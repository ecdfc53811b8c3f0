//! The spaces of points in files: the sphere with its directions, and the unit square.

use std::ops::Range;

use glam::DVec3;
use serde::de::DeserializeOwned;
use sphvar_samplers::Point;

use super::collector::{Cell, PointCollector, Row};
use super::lengths::Lengths;
use super::roles::{SPHERE_SYSTEMS, SQUARE_SYSTEMS, role_of};
use crate::files::file_error::{FileError, Place};

/// The space of the points of a file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Space {
    /// Directions.
    #[default]
    Sphere,
    /// Points `u,v` in [0, 1).
    Square,
}

impl Space {
    /// Returns the combinations of roles that form a point.
    pub(super) fn systems(self) -> &'static [&'static [&'static str]] {
        match self {
            Self::Sphere => &SPHERE_SYSTEMS,
            Self::Square => &SQUARE_SYSTEMS,
        }
    }

    /// Returns the same for messages.
    pub(super) fn systems_in_words(self) -> &'static str {
        match self {
            Self::Sphere => {
                "x,y,z or theta,phi (radians) or lon,lat or ra,dec or glon,glat or l,b (degrees)"
            }
            Self::Square => "u,v or x,y (points of the unit square)",
        }
    }

    /// Returns what the points are, for messages.
    pub(super) fn points_in_words(self) -> &'static str {
        match self {
            Self::Sphere => "directions",
            Self::Square => "points",
        }
    }

    /// Returns the roles of the columns of files without names.
    pub(super) fn default_roles(self) -> &'static [&'static str] {
        self.systems()[0]
    }

    /// Returns the role of a column name; `u` and `v` often denote something else in files of
    /// directions, such as magnitudes.
    pub(super) fn role_of(self, name: &str) -> Option<&'static str> {
        role_of(name).filter(|role| self == Self::Square || !matches!(*role, "u" | "v"))
    }

    /// Returns the arrays of points without names, for messages.
    pub(super) fn shapes(self) -> &'static str {
        match self {
            Self::Sphere => "an array of shape (N, 3) or (M, N, 3)",
            Self::Square => "an array of shape (N, 2) or (M, N, 2)",
        }
    }

    /// Returns an example of a value of `--columns` with weights.
    pub(super) fn weighted_example(self) -> &'static str {
        match self {
            Self::Sphere => "ra,dec,w",
            Self::Square => "u,v,w",
        }
    }
}

/// A point as files contain it.
pub(crate) trait FilePoint: Point {
    /// The space of the points.
    const SPACE: Space;

    /// The numbers of a point in files.
    type Numbers: AsRef<[f64]> + IntoIterator<Item = f64> + DeserializeOwned;

    /// Returns the coordinates, which are columns with the names of [`Space::default_roles`].
    fn numbers(&self) -> Self::Numbers;

    /// Returns the point of a row; `cell` returns the content of each of the layout's slots.
    ///
    /// # Errors
    ///
    /// If the row has no valid point, weight or value.
    fn of_row<'c>(
        points: &mut PointCollector<'_, Self>,
        place: Place,
        cell: &impl Fn(usize) -> Cell<'c>,
    ) -> Result<Row<Self>, FileError>;

    /// Returns the point with these coordinates, or `None` if it needs a message or another change than
    /// that of its length. It is that of [`of_row`](Self::of_row).
    fn of_coordinates(coordinates: &[f64], place: Place, lengths: &mut Lengths) -> Option<Self>;

    /// Returns z, if the point lies below the plane z = 0 by more than rounding, so that the
    /// hemisphere does not have it.
    fn below(&self) -> Option<f64> {
        None
    }
}

/// The depth below the plane z = 0 that counts as rounding on the hemisphere: coordinates printed
/// with seven digits may be off by this much.
const BELOW_SLACK: f64 = 1e-6;

impl FilePoint for DVec3 {
    const SPACE: Space = Space::Sphere;

    type Numbers = [f64; 3];

    fn numbers(&self) -> [f64; 3] {
        self.to_array()
    }

    fn of_row<'c>(
        points: &mut PointCollector<'_, Self>,
        place: Place,
        cell: &impl Fn(usize) -> Cell<'c>,
    ) -> Result<Row<Self>, FileError> {
        points.direction(place, cell)
    }

    fn of_coordinates(coordinates: &[f64], place: Place, lengths: &mut Lengths) -> Option<Self> {
        let vector = Self::from_array(coordinates.try_into().ok()?);
        if vector.is_finite() { lengths.direction(vector, place) } else { None }
    }

    fn below(&self) -> Option<f64> {
        (self.z < -BELOW_SLACK).then_some(self.z)
    }
}

/// Coordinates on the square and its neighbours. Others are rather in units of their own.
const NEAR: Range<f64> = -1.0..2.0;

impl FilePoint for [f64; 2] {
    const SPACE: Space = Space::Square;

    type Numbers = [f64; 2];

    fn numbers(&self) -> [f64; 2] {
        *self
    }

    fn of_row<'c>(
        points: &mut PointCollector<'_, Self>,
        place: Place,
        cell: &impl Fn(usize) -> Cell<'c>,
    ) -> Result<Row<Self>, FileError> {
        let mut is_far = false;
        let mut coordinate = |slot: usize| {
            let mut value = points.number(place, slot, cell(slot))?;
            let is_near = NEAR.contains(&value);
            if points.options().normalize {
                is_far |= !is_near;
                // The remainder of a tiny negative number rounds to 1.
                value = value.rem_euclid(1.0) % 1.0;
            }
            if (0.0..1.0).contains(&value) {
                return Ok(value);
            }
            let expected = if (1.0..=1.0).contains(&value) {
                "a coordinate in [0, 1), which excludes 1 (the same place as 0 on the torus)"
            } else if is_near {
                "a coordinate in [0, 1)"
            } else {
                "a coordinate in [0, 1); divide coordinates in a periodic box by its period"
            };
            let option = points.options().spelling.on("normalize");
            let remedy = format!(" ({option} takes coordinates modulo 1)");
            let expected = format!("{expected}{}", if is_near { &remedy } else { "" });
            Err(points.slot_error(place, slot, &expected, &cell(slot)))
        };
        let point = [coordinate(0)?, coordinate(1)?];
        points.tally.n_far += usize::from(is_far);
        let (weight, value) = points.weight_and_value(place, cell)?;
        Ok(Row { point, weight, value })
    }

    fn of_coordinates(coordinates: &[f64], _: Place, _: &mut Lengths) -> Option<Self> {
        let point: Self = coordinates.try_into().ok()?;
        point.iter().all(|value| (0.0..1.0).contains(value)).then_some(point)
    }
}
