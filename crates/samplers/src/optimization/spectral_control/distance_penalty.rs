use glam::{DVec2, DVec3};
use sphvar_healpix::Cell;

use crate::search::{Grid, SquareGrid};
use crate::square::turns::wrapped;
use crate::vector::Vector;
use crate::{Domain, Square};

/// A penalty for pairs nearer than the chord `sigma`:
/// `(kappa/2) sum_{pairs, r < sigma} (sigma - r)^2`.
///
/// With kappa = 1/2 a unit step along the negative gradient moves an isolated pair exactly to the
/// distance sigma.
///
/// On the square distances are toroidal, those of the nearest periodic image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DistancePenalty<S> {
    pub(crate) space: S,
    /// The chord or distance, or 0 for no penalty.
    pub(crate) sigma: f64,
}

/// A space in which pairs of near points are found.
pub(crate) trait PenaltySpace: Copy {
    type Point: Vector;

    /// The points by location.
    type Near;

    /// Returns the points by location for queries within `distance`, and the location of each.
    fn locate(self, points: &[Self::Point], distance: f64) -> (Self::Near, Vec<u32>);

    /// Returns the numbers of all images of points that can lie within the distance of a point
    /// with the given location, itself among them; a number may be repeated.
    fn near(near: &Self::Near, location: u32) -> impl Iterator<Item = u32>;

    /// Returns the index of the point whose image has that number, and the factor -1 if the image
    /// is the antipode.
    fn owner(self, image: u32) -> (usize, f64);

    /// Returns `a - b`, on the torus from the nearest periodic image of b.
    fn apart(a: Self::Point, b: Self::Point) -> Self::Point;
}

impl PenaltySpace for Domain {
    type Point = DVec3;
    type Near = Grid;

    fn locate(self, points: &[DVec3], distance: f64) -> (Grid, Vec<u32>) {
        let mut grid = Grid::new(self, distance, points.len() as f64);
        let nside = grid.nside();
        let places: Vec<u32> =
            points.iter().map(|&p| grid.place(Cell::containing(nside, p))).collect();
        for (&place, &point) in places.iter().zip(points) {
            grid.insert(place, point);
        }
        (grid, places)
    }

    fn near(grid: &Grid, location: u32) -> impl Iterator<Item = u32> {
        grid.near_numbers(location)
    }

    #[inline]
    fn owner(self, image: u32) -> (usize, f64) {
        match self {
            Self::Sphere => (image as usize, 1.0),
            Self::Hemisphere => (image as usize / 2, 1.0 - 2.0 * f64::from(image % 2)),
        }
    }

    #[inline]
    fn apart(a: DVec3, b: DVec3) -> DVec3 {
        a - b
    }
}

impl PenaltySpace for Square {
    type Point = DVec2;
    type Near = SquareGrid;

    fn locate(self, points: &[DVec2], distance: f64) -> (SquareGrid, Vec<u32>) {
        let mut grid = SquareGrid::new(true, distance, points.len() as f64);
        let places: Vec<u32> = points.iter().map(|&p| grid.index_of(wrapped(p))).collect();
        for (&place, &point) in places.iter().zip(points) {
            grid.insert(place, wrapped(point));
        }
        (grid, places)
    }

    fn near(grid: &SquareGrid, location: u32) -> impl Iterator<Item = u32> {
        grid.near_numbers(location)
    }

    #[inline]
    fn owner(self, image: u32) -> (usize, f64) {
        (image as usize, 1.0)
    }

    #[inline]
    fn apart(a: DVec2, b: DVec2) -> DVec2 {
        let difference = a - b;
        difference - difference.round()
    }
}

const KAPPA: f64 = 0.5;

/// How far beyond sigma the pairs of a list reach, relative to sigma. Larger lists are valid for
/// longer.
const MARGIN: f64 = 0.25;

impl<S: PenaltySpace> DistancePenalty<S> {
    /// Returns the energy relative to that of `n_points` coincident pairs.
    pub(crate) fn relative(&self, energy: f64, n_points: usize) -> f64 {
        if self.sigma > 0.0 {
            energy / (0.5 * KAPPA * self.sigma.powi(2) * n_points as f64)
        } else {
            0.0
        }
    }
}

/// The pairs that can contribute to a penalty: those nearer than sigma and a margin when the list
/// was made. It is valid until a point has moved by half the margin (Verlet 1967).
pub(crate) struct NearPairs<S: PenaltySpace> {
    penalty: DistancePenalty<S>,
    /// The points when the list was made.
    origin: Vec<S::Point>,
    /// The index of a point and the number of the image of one of larger index.
    pairs: Vec<[u32; 2]>,
}

impl<S: PenaltySpace> NearPairs<S> {
    pub(crate) fn new(penalty: DistancePenalty<S>) -> Self {
        Self { penalty, origin: Vec::new(), pairs: Vec::new() }
    }

    /// Returns the energy of the penalty and adds its gradient to `gradient`.
    ///
    /// Coincident points contribute to the energy like others, but they have no direction of
    /// separation and contribute no force.
    pub(crate) fn add(&mut self, points: &[S::Point], gradient: &mut [S::Point]) -> f64 {
        let DistancePenalty { space, sigma } = self.penalty;
        if sigma <= 0.0 {
            return 0.0;
        }
        if !self.is_valid(points) {
            self.update(points);
        }
        let mut energy = 0.0;
        for &[a, image] in &self.pairs {
            let (a, (b, sign)) = (a as usize, space.owner(image));
            let apart = S::apart(points[a], points[b] * sign);
            let r = apart.length();
            if r < sigma {
                let overlap = sigma - r;
                energy += 0.5 * KAPPA * overlap * overlap;
                if r > 0.0 {
                    let force = apart * (KAPPA * overlap / r);
                    gradient[a] -= force;
                    gradient[b] += force * sign;
                }
            }
        }
        energy
    }

    fn is_valid(&self, points: &[S::Point]) -> bool {
        let half = 0.5 * MARGIN * self.penalty.sigma;
        let mut moves = points.iter().zip(&self.origin);
        points.len() == self.origin.len() && moves.all(|(p, o)| (*p - *o).length() <= half)
    }

    fn update(&mut self, points: &[S::Point]) {
        let DistancePenalty { space, sigma } = self.penalty;
        let reach = sigma * (1.0 + MARGIN);
        self.origin.clear();
        self.origin.extend_from_slice(points);
        self.pairs.clear();
        let (near, locations) = space.locate(points, reach);
        let mut images = Vec::new();
        for ((a, &location), &point) in (0..).zip(&locations).zip(points) {
            images.clear();
            images.extend(S::near(&near, location).filter(|&image| {
                let (b, sign) = space.owner(image);
                b > a as usize && S::apart(point, points[b] * sign).length() < reach
            }));
            images.sort_unstable();
            images.dedup();
            self.pairs.extend(images.iter().map(|&image| [a, image]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{DVec2, DVec3, DistancePenalty, Domain, NearPairs, Square};

    fn energy(core: DistancePenalty<Domain>, points: &[DVec3]) -> (f64, Vec<DVec3>) {
        let mut gradient = vec![DVec3::ZERO; points.len()];
        (NearPairs::new(core).add(points, &mut gradient), gradient)
    }

    /// Computes the energy over all pairs, by the definition.
    fn definition(core: DistancePenalty<Domain>, points: &[DVec3]) -> f64 {
        let mut sum = 0.0;
        for (i, p) in points.iter().enumerate() {
            for q in &points[..i] {
                let mut chords = vec![p.distance(*q)];
                if core.space == Domain::Hemisphere {
                    chords.push(p.distance(-*q));
                }
                let overlaps = chords.iter().map(|r| core.sigma - r);
                sum +=
                    overlaps.filter(|o| *o > 0.0).map(|o| 0.5 * super::KAPPA * o * o).sum::<f64>();
            }
        }
        sum
    }

    #[test]
    fn it_matches_the_sum_over_pairs_and_its_derivative() {
        let mut points: Vec<DVec3> = (0..40)
            .map(|k| {
                let t = f64::from(k);
                DVec3::new((2.1 * t).sin(), (3.3 * t).cos(), (1.7 * t).sin()).normalize()
            })
            .collect();
        points.extend([DVec3::Z, -DVec3::Z, DVec3::X]);
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            for sigma in [0.0, 0.1, 0.5, 1.2] {
                let core = DistancePenalty { space: domain, sigma };
                let (got, gradient) = energy(core, &points);
                let expected = definition(core, &points);
                assert!(
                    (got - expected).abs() <= 1e-13 * expected,
                    "{domain}, {sigma}: {got}, {expected}"
                );
                for k in 0..points.len() {
                    for axis in DVec3::AXES {
                        let h = 1e-6;
                        let at = |step: f64| {
                            let mut moved = points.clone();
                            moved[k] += step * axis;
                            definition(core, &moved)
                        };
                        let slope = (at(h) - at(-h)) / (2.0 * h);
                        let off = (slope - gradient[k].dot(axis)).abs();
                        // The second derivative jumps where the distance of a pair reaches sigma.
                        assert!(off < 1e-5, "{domain}, {sigma}, point {k}: {slope}, {gradient:?}");
                    }
                }
            }
        }
    }

    /// Toroidal distances, by the definition; points need not be in the square.
    #[test]
    fn on_the_square_it_matches_the_sum_over_pairs_of_nearest_images() {
        let squared = |p: DVec2, q: DVec2| {
            let d = p - q;
            (d - d.round()).length_squared()
        };
        let mut points: Vec<DVec2> = (0..40)
            .map(|k| DVec2::new((2.1 * f64::from(k)).sin(), 2.0 * (3.3 * f64::from(k)).cos()))
            .collect();
        points.extend([[0.03, 0.999], [0.999, 0.002], [0.5, 0.999]].map(DVec2::from));
        for sigma in [0.0, 0.05, 0.2, 0.5] {
            let core = DistancePenalty { space: Square, sigma };
            let definition = |points: &[DVec2]| {
                let pairs = (0..points.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
                let overlaps = pairs.map(|(i, j)| sigma - squared(points[i], points[j]).sqrt());
                overlaps.filter(|o| *o > 0.0).map(|o| 0.5 * super::KAPPA * o * o).sum::<f64>()
            };
            let mut gradient = vec![DVec2::ZERO; points.len()];
            let (got, expected) =
                (NearPairs::new(core).add(&points, &mut gradient), definition(&points));
            assert!((got - expected).abs() <= 1e-13 * expected, "{sigma}: {got}, {expected}");
            for k in 0..points.len() {
                for axis in DVec2::AXES {
                    let at = |step: f64| {
                        let mut moved = points.clone();
                        moved[k] += step * axis;
                        definition(&moved)
                    };
                    let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
                    // The second derivative jumps where the distance of a pair reaches sigma.
                    let off = (slope - gradient[k].dot(axis)).abs();
                    assert!(off < 1e-5, "{sigma}, point {k}: {slope}, {}", gradient[k]);
                }
            }
        }
    }

    #[test]
    fn coincident_points_are_handled() {
        let core = DistancePenalty { space: Domain::Sphere, sigma: 0.3 };
        let (got, gradient) = energy(core, &[DVec3::Z, DVec3::Z]);
        assert!((got - 0.5 * super::KAPPA * 0.09).abs() < 1e-15, "{got}");
        assert!(gradient.iter().all(|g| *g == DVec3::ZERO), "{gradient:?}");
    }

    /// Small moves keep the list, large ones replace it; either way the sums are those of a new
    /// list. The order of the pairs may differ.
    #[test]
    fn moved_points_have_the_sums_of_a_new_list() {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let core = DistancePenalty { space: domain, sigma: 0.4 };
            let mut pairs = NearPairs::new(core);
            let mut kept = 0;
            for step in 0..40 {
                let points: Vec<DVec3> = (0..60)
                    .map(|k| {
                        let t = f64::from(k) + 1e-4 * f64::from(step * step);
                        DVec3::new((2.1 * t).sin(), (3.3 * t).cos(), (1.7 * t).sin()).normalize()
                    })
                    .collect();
                let before = pairs.origin.clone();
                let mut gradient = vec![DVec3::ZERO; points.len()];
                let got = pairs.add(&points, &mut gradient);
                kept += u32::from(before == pairs.origin);
                let (expected, of_new_list) = energy(core, &points);
                assert!((got - expected).abs() < 1e-14, "{domain}, {step}: {got}, {expected}");
                for (g, e) in gradient.iter().zip(&of_new_list) {
                    assert!(g.distance(*e) < 1e-14, "{domain}, {step}: {g}, {e}");
                }
            }
            assert!((10..36).contains(&kept), "{domain}: kept {kept} times");
        }
    }
}
