use glam::{DVec2, DVec3};
use rand::{Rng, RngExt};

/// Two ends closer to antipodes than this are those of a half circle.
const HALF_CIRCLE: f64 = 1e-15 - 1.0;

/// At least a third of the trials of a draw succeed, except in regions that consist of rounding
/// errors.
const MAX_TRIALS: usize = 1000;

/// The great circle of the directions at the same distance from two sites a and b.
///
/// A direction of the circle is given by its angle `theta` from the foot, the direction between the
/// sites, or by the cosine and the sine of that angle or of its half.
///
/// Distances are stated as `q = 1 - cos(r)`, half the squared length of the chord: in polar
/// coordinates around a site areas are `dq dphi`. With the angle h between the foot and a site, the
/// distance of the sites is `q(theta) = 1 - cos(h) cos(theta)`. It decreases nowhere between 0 and
/// pi.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bisector {
    foot: DVec3,
    /// Where `theta` is a right angle.
    quarter: DVec3,
    sin_h: f64,
    cos_h: f64,
}

/// An arc of a bisector, of at most half a circle unless it is the full one.
///
/// The ends are the cosines and sines of their angles, in the direction of ascending angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Arc {
    Circle,
    Between([DVec2; 2]),
}

/// A part of an arc on one side of the foot and its antipode, from the end near the foot to the
/// other. The ends are the cosines and sines of the halves of their angles, whose signs are dropped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// 1 where angles are positive, -1 where they are negative.
    sign: f64,
    ends: [DVec2; 2],
}

/// The part of a piece at which the distance of the sites is at least a level.
#[derive(Clone, Copy, Debug)]
pub(super) struct Region {
    piece: Piece,
    level: f64,
}

impl Bisector {
    pub(super) fn new(a: DVec3, b: DVec3) -> Self {
        let (sum, difference) = (a + b, b - a);
        let (twice_cos, twice_sin) = (sum.length(), difference.length());
        // All directions of the circle are at the same distance from antipodal sites.
        let foot = if twice_cos > 0.0 { sum / twice_cos } else { a.any_orthonormal_vector() };
        let quarter = foot.cross(difference / twice_sin);
        Self { foot, quarter, sin_h: 0.5 * twice_sin, cos_h: 0.5 * twice_cos }
    }

    fn foot_distance(&self) -> f64 {
        self.sin_h * self.sin_h / (1.0 + self.cos_h)
    }

    /// Returns the tangent of half the angle between the foot and a site.
    fn tan_half_h(&self) -> f64 {
        self.sin_h / (1.0 + self.cos_h)
    }

    /// Returns the distance of the sites where the sine of half the angle is `sine`.
    fn distance(&self, sine: f64) -> f64 {
        self.foot_distance() + 2.0 * self.cos_h * (sine * sine)
    }

    /// Returns the part of an arc of directions x with `x.normal >= 0`, or `None` if there is none.
    pub(super) fn clip(&self, arc: Arc, normal: DVec3) -> Option<Arc> {
        let centre = DVec2::new(self.foot.dot(normal), self.quarter.dot(normal));
        let end = || centre.normalize_or(DVec2::X).perp();
        let [from, to] = match arc {
            Arc::Circle => return Some(Arc::Between([-end(), end()])),
            Arc::Between(ends) => ends,
        };
        let keeps_from = from.dot(centre) >= 0.0;
        // Rounding does not decide about both ends of a half circle, which loses exactly one.
        let is_half_circle = from.dot(to) < HALF_CIRCLE;
        let keeps_to = if is_half_circle { !keeps_from } else { to.dot(centre) >= 0.0 };
        match (keeps_from, keeps_to) {
            (true, true) => Some(arc),
            (true, false) => Some(Arc::Between([from, end()])),
            (false, true) => Some(Arc::Between([-end(), to])),
            (false, false) => None,
        }
    }

    /// Returns the largest distance of a site from a direction of the arc.
    pub(super) fn top(&self, arc: Arc) -> f64 {
        let top = |piece: Piece| self.distance(piece.ends[1].y);
        arc.pieces().into_iter().flatten().map(top).fold(0.0, f64::max)
    }

    /// Returns the part of a piece above a level.
    pub(super) fn above(&self, piece: Piece, level: f64) -> Region {
        let [near, far] = piece.ends;
        // The squares of the sine and the cosine at the level.
        let sine = (level - self.foot_distance()) / (2.0 * self.cos_h);
        let cosine = (1.0 + self.cos_h - level) / (2.0 * self.cos_h);
        let near = if sine > near.y * near.y {
            DVec2::new(cosine.max(0.0).sqrt(), sine.min(1.0).sqrt())
        } else {
            near
        };
        Region { piece: Piece { ends: [near, far], ..piece }, level }
    }

    /// Returns the sine and the cosine of the ends of half the areas that radii from a site sweep
    /// from the foot to the ends of a piece.
    ///
    /// The excess E of a right triangle with the legs h and theta has
    /// `tan(E/2) = tan(h/2) tan(theta/2)`.
    fn swept(&self, region: &Region) -> [DVec2; 2] {
        let t = self.tan_half_h();
        region.piece.ends.map(|end| DVec2::new(end.x, t * end.y))
    }

    /// Returns the area of the directions in a region and on the radii from both sites to it,
    /// farther than the level from the nearest site.
    pub(super) fn area(&self, region: &Region) -> f64 {
        let [near, far] = region.piece.ends;
        let half = DVec2::new(near.dot(far), near.perp_dot(far));
        if half.y <= 0.0 {
            return 0.0;
        }
        let [swept_near, swept_far] = self.swept(region);
        let excess = 2.0 * angle_between(swept_near, swept_far);
        // The angles phi at the site: tan(phi) = tan(theta)/sin(h).
        let [near, far] = [near, far]
            .map(|end| DVec2::new((end.x - end.y) * (end.x + end.y), 2.0 * end.x * end.y));
        let sine = self.sin_h * (2.0 * half.x * half.y);
        let cosine = self.sin_h * self.sin_h * (near.x * far.x) + near.y * far.y;
        let azimuth = libm::atan2(sine, cosine);
        (2.0 * (excess - region.level * azimuth)).max(0.0)
    }

    /// Draws a uniform direction of the area of a region that is nearer to one of the sites, which
    /// is given by its distance from the site and the half angle where its radius meets the
    /// bisector.
    pub(super) fn draw(&self, region: &Region, rng: &mut dyn Rng) -> (f64, DVec2) {
        let [near, far] = self.swept(region);
        let (start, range) = (near.normalize(), angle_between(near, far));
        let t = self.tan_half_h();
        let top = self.distance(region.piece.ends[1].y);
        // Radii sweep areas dE; the share above the level is 1 - level/q, which ascends with E.
        let largest_share = 1.0 - region.level / top;
        for _ in 0..MAX_TRIALS {
            let (sine, cosine) = libm::sincos(range * rng.random::<f64>());
            let swept = start.rotate(DVec2::new(cosine, sine));
            let half = DVec2::new(t * swept.x, swept.y).normalize();
            let q = self.distance(half.y);
            let rise = largest_share * rng.random::<f64>() * q;
            if rise < q - region.level {
                return (region.level + rise, half);
            }
        }
        (top, region.piece.ends[1])
    }

    /// Returns the direction at distance `q` from `site`, one of the two, on the radius that meets
    /// the bisector at a half angle in a region.
    pub(super) fn place(&self, site: DVec3, region: &Region, half: DVec2, q: f64) -> DVec3 {
        let cosine = (half.x - half.y) * (half.x + half.y);
        let sine = region.piece.sign * (2.0 * half.x * half.y);
        let end = self.foot * cosine + self.quarter * sine;
        let end_q = self.distance(half.y);
        // At a right angle to the site, of the length sin(r).
        let tangent = (end - site) + site * end_q;
        let scale = ((q * (2.0 - q)) / (end_q * (2.0 - end_q))).sqrt();
        (site * (1.0 - q) + tangent * scale).normalize_or(end)
    }
}

impl Arc {
    /// Returns the parts on the two sides of the foot and its antipode.
    pub(super) fn pieces(self) -> [Option<Piece>; 2] {
        let (foot, antipode) = (DVec2::X, DVec2::Y);
        let piece = |sign: f64, near, far| Some(Piece { sign, ends: [near, far] });
        let Self::Between([from, to]) = self else {
            return [1.0, -1.0].map(|sign| piece(sign, foot, antipode));
        };
        let [half_from, half_to] = [half(from), half(to)];
        match (from.y < 0.0, to.y < 0.0) {
            (false, false) => [piece(1.0, half_from, half_to), None],
            (true, true) => [piece(-1.0, half_to, half_from), None],
            (true, false) => [piece(-1.0, foot, half_from), piece(1.0, foot, half_to)],
            (false, true) => [piece(1.0, half_from, antipode), piece(-1.0, half_to, antipode)],
        }
    }
}

/// Returns the cosine and the sine of half the angle from 0 to pi that has this cosine and, apart
/// from its sign, this sine.
fn half(end: DVec2) -> DVec2 {
    let sine = end.y.abs();
    let half =
        if end.x >= 0.0 { DVec2::new(1.0 + end.x, sine) } else { DVec2::new(sine, 1.0 - end.x) };
    half.normalize()
}

/// Returns the angle from `u` to `v`.
fn angle_between(u: DVec2, v: DVec2) -> f64 {
    libm::atan2(u.perp_dot(v), u.dot(v))
}
