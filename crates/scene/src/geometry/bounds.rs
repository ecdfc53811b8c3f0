use glam::DVec3;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The smallest coordinates.
    pub min: DVec3,
    /// The largest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// Returns the smallest box around points; without points it is inverted, from infinity to
    /// minus infinity.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::NONE, |b, p| b.and(Self { min: p, max: p }))
    }

    /// Returns the centre of the box.
    pub fn center(&self) -> DVec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// Returns the length of the longest side.
    pub fn size(&self) -> f64 {
        (self.max - self.min).max_element()
    }

    /// Returns the largest absolute value of a coordinate.
    pub fn magnitude(&self) -> f64 {
        self.min.abs().max(self.max.abs()).max_element()
    }

    /// The empty box.
    pub(crate) const NONE: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// Returns the smallest box around two boxes.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Returns whether the box is empty.
    pub(crate) fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }
}
