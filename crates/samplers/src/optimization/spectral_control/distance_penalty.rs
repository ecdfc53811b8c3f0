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
/// On the square distances are toroidal.
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

    /// Returns the points by location for queries within `sigma`, and the location of each.
    fn locate(self, points: &[Self::Point], sigma: f64) -> (Self::Near, Vec<u32>);

    /// Returns all points that can lie within `sigma` of a point with the given location, itself
    /// among them, at the images nearest to its [`Self::own_image`].
    fn near(near: &Self::Near, location: u32) -> impl Iterator<Item = Self::Point>;

    /// Returns the image of a point at its location.
    fn own_image(point: Self::Point) -> Self::Point;
}

impl PenaltySpace for Domain {
    type Point = DVec3;
    type Near = Grid;

    fn locate(self, points: &[DVec3], sigma: f64) -> (Grid, Vec<u32>) {
        let mut grid = Grid::new(self, sigma, points.len() as f64);
        let nside = grid.nside();
        let places: Vec<u32> =
            points.iter().map(|&p| grid.place(Cell::containing(nside, p))).collect();
        for (&place, &point) in places.iter().zip(points) {
            grid.insert(place, point);
        }
        (grid, places)
    }

    fn near(grid: &Grid, location: u32) -> impl Iterator<Item = DVec3> {
        grid.near(location)
    }

    fn own_image(point: DVec3) -> DVec3 {
        point
    }
}

impl PenaltySpace for Square {
    type Point = DVec2;
    type Near = SquareGrid;

    fn locate(self, points: &[DVec2], sigma: f64) -> (SquareGrid, Vec<u32>) {
        let mut grid = SquareGrid::new(true, sigma, points.len() as f64);
        let places: Vec<u32> = points.iter().map(|&p| grid.index_of(wrapped(p))).collect();
        for (&place, &point) in places.iter().zip(points) {
            grid.insert(place, wrapped(point));
        }
        (grid, places)
    }

    fn near(grid: &SquareGrid, location: u32) -> impl Iterator<Item = DVec2> {
        grid.near(location)
    }

    fn own_image(point: DVec2) -> DVec2 {
        wrapped(point)
    }
}

const KAPPA: f64 = 0.5;

impl<S: PenaltySpace> DistancePenalty<S> {
    /// Returns the energy and adds its gradient to `gradient`.
    ///
    /// Coincident points contribute to the energy like others, but they have no direction of
    /// separation and contribute no force.
    pub(crate) fn add(&self, points: &[S::Point], gradient: &mut [S::Point]) -> f64 {
        if self.sigma <= 0.0 {
            return 0.0;
        }
        let (near, locations) = self.space.locate(points, self.sigma);
        let mut energy = 0.0;
        for ((&location, &point), gradient) in locations.iter().zip(points).zip(gradient) {
            let point = S::own_image(point);
            let mut met_itself = false;
            for other in S::near(&near, location) {
                let apart = point - other;
                let r = apart.length();
                if r == 0.0 && !met_itself {
                    met_itself = true;
                } else if r < self.sigma {
                    let overlap = self.sigma - r;
                    // Every pair is visited from both its points.
                    energy += 0.25 * KAPPA * overlap * overlap;
                    if r > 0.0 {
                        *gradient -= apart * (KAPPA * overlap / r);
                    }
                }
            }
        }
        energy
    }

    /// Returns the energy relative to that of `n_points` coincident pairs.
    pub(crate) fn relative(&self, energy: f64, n_points: usize) -> f64 {
        if self.sigma > 0.0 {
            energy / (0.5 * KAPPA * self.sigma.powi(2) * n_points as f64)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{DVec2, DVec3, DistancePenalty, Domain, Square};

    fn energy(core: DistancePenalty<Domain>, points: &[DVec3]) -> (f64, Vec<DVec3>) {
        let mut gradient = vec![DVec3::ZERO; points.len()];
        (core.add(points, &mut gradient), gradient)
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
            let (got, expected) = (core.add(&points, &mut gradient), definition(&points));
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
}
