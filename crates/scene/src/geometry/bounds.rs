use glam::DVec3;

/// A box with sides along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The smallest coordinates.
    pub min: DVec3,
    /// The largest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// The smallest box around points; inverted, from infinity to minus infinity, if there are none.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::NONE, |b, p| b.and(Self { min: p, max: p }))
    }

    /// The middle of the box.
    pub fn center(&self) -> DVec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// Length of the longest side.
    pub fn size(&self) -> f64 {
        (self.max - self.min).max_element()
    }

    /// The largest absolute value of a coordinate.
    pub fn magnitude(&self) -> f64 {
        self.min.abs().max(self.max.abs()).max_element()
    }

    /// The box of no points.
    pub(crate) const NONE: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The smallest box around two.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether it is around no points.
    pub(crate) fn is_empty(&self) -> bool {
        self.min.x > self.max.x
    }
}
