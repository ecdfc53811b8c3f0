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
        let none = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        points.into_iter().fold(none, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
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

    /// The distances, in lengths of `dir` and not below 0, at which a ray enters and leaves the box.
    pub(crate) fn crossing(&self, origin: DVec3, dir: DVec3) -> Option<[f64; 2]> {
        let mut range = [0.0, f64::INFINITY];
        for axis in 0..3 {
            let (o, d) = (origin[axis], dir[axis]);
            if d == 0.0 {
                if o < self.min[axis] || o > self.max[axis] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((self.min[axis] - o) / d, (self.max[axis] - o) / d);
            range = [f64::max(range[0], a.min(b)), f64::min(range[1], a.max(b))];
        }
        (range[0] <= range[1]).then_some(range)
    }
}
