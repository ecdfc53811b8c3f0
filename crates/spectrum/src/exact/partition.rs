use sphvar_healpix::{Cell, Nside};
use sphvar_samplers::{Region, Strata};

use super::quadrature::{Quadrature, gauss_nodes, is_full_turn, turn_nodes};
use crate::Error;

/// A cut of the sphere, or of the hemisphere, into strata of equal area, known by one stratum of each
/// class of congruent ones.
///
/// Degrees are even on the hemisphere, and a cell and its antipode are alike to them: half of the HEALPix cells
/// have the classes of all.
#[derive(Clone, Debug)]
pub(super) enum Partition {
    Healpix(Nside),
    /// One region of each class with the size of the class, and the number of regions.
    Zonal(Vec<(Region, u32)>, usize),
}

/// A stratum and the share of all strata that are congruent to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct CongruentStrata {
    pub(super) share: f64,
    shape: Shape,
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    Cell(Cell),
    /// A cell that must be cut along u + v = 1.
    CutCell(Cell),
    Region(Region),
}

/// Half the longest edge of a HEALPix cell times nside: where a meridian bounds a polar face, an edge is
/// sheared to `sqrt(2/3 + (pi/2)^2 2/3) = 1.52`.
const HALF_EDGE: f64 = 0.77;

/// The longest chord in a HEALPix cell times nside, with a margin of 3 %: 2.14 at the ends of the ring
/// |z| = 2/3.
const LONGEST_CHORD: f64 = 2.2;

impl Partition {
    /// The classes of a cut, of `n_points` strata.
    pub(super) fn of(strata: Strata<'_>, n_points: usize) -> Option<Self> {
        match strata {
            Strata::Healpix(nside) => Some(Self::Healpix(nside)),
            Strata::EqualArea(regions) => {
                Some(Self::Zonal(regions.congruent_regions().collect(), n_points))
            }
            // Cuts that are added to the list have no classes until they are written down here.
            _ => None,
        }
    }

    /// The number of rows, the unit of parallel work.
    pub(super) fn n_rows(&self) -> usize {
        match self {
            Self::Healpix(nside) => 2 * nside.value() as usize,
            Self::Zonal(regions, _) => regions.len(),
        }
    }

    /// The classes of a row, from 0: of HEALPix a ring from the pole to the equator, of a zonal partition a
    /// zone.
    pub(super) fn row(&self, row: usize) -> Vec<CongruentStrata> {
        match self {
            Self::Healpix(nside) => ring_classes(*nside, row),
            Self::Zonal(regions, n) => {
                let (region, count) = regions[row];
                let share = f64::from(count) / *n as f64;
                vec![CongruentStrata { share, shape: Shape::Region(region) }]
            }
        }
    }

    /// The numbers of nodes that quadrature takes to degree `lmax`, each with the number of classes that
    /// take as many.
    pub(super) fn nodes(&self, lmax: usize) -> Vec<(f64, usize)> {
        match self {
            Self::Healpix(nside) => {
                let n = f64::from(nside.value());
                let edge = cell_nodes(*nside, lmax);
                let square = edge.saturating_mul(edge);
                // The polar cap has ceil(i/2) classes in ring i.
                let first = if nside.value() > 1 { 1.0 } else { 0.0 };
                let smooth = (n * n / 4.0).floor() - first + n;
                let cut = (n / 2.0).ceil() + first;
                vec![(smooth, square), (cut, square.saturating_mul(2))]
            }
            Self::Zonal(regions, _) => regions
                .iter()
                .map(|(region, _)| {
                    let [theta, phi] = region_nodes(region, lmax);
                    (1.0, theta.saturating_mul(phi))
                })
                .collect(),
        }
    }

    /// The largest of the numbers of nodes.
    pub(super) fn most_nodes(&self, lmax: usize) -> usize {
        self.nodes(lmax).into_iter().map(|(_, nodes)| nodes).max().unwrap_or(1)
    }

    /// A bound of the squared distance of two points of one stratum, at most 4.
    pub(super) fn longest_chord_squared(&self) -> f64 {
        match self {
            Self::Healpix(nside) => (LONGEST_CHORD / f64::from(nside.value())).powi(2).min(4.0),
            Self::Zonal(regions, _) => {
                let squares = regions.iter().map(|(region, _)| {
                    let [[top, bottom], [west, east]] = [region.theta(), region.phi()];
                    let along = (0.5 * (bottom - top)).sin();
                    let half_turn = std::f64::consts::FRAC_PI_2;
                    let across = (0.5 * (east - west)).min(half_turn).sin() * largest_sine(region);
                    4.0 * (along * along + across * across)
                });
                squares.fold(0.0, f64::max).min(4.0)
            }
        }
    }
}

impl CongruentStrata {
    /// The rule for functions to degree `lmax` on the stratum.
    pub(super) fn quadrature(&self, lmax: usize) -> Result<Quadrature, Error> {
        Ok(match self.shape {
            Shape::Cell(cell) => Quadrature::of_cell(cell, cell_nodes(cell.nside(), lmax))?,
            Shape::CutCell(cell) => Quadrature::of_cut_cell(cell, cell_nodes(cell.nside(), lmax))?,
            Shape::Region(region) => {
                let [theta, phi] = region_nodes(&region, lmax);
                Quadrature::of_region(&region, theta, phi)?
            }
        })
    }
}

/// The classes of ring `row + 1`, from the north pole to the equator.
///
/// The symmetries of the grid are quarter turns about z, the mirror at the equator and that of the two halves
/// of a quadrant. In the cap, and in ring nside which reaches into it, they leave `ceil(i/2)` classes in ring
/// i; in the belt below the cells are alike up to rotations about z.
fn ring_classes(nside: Nside, row: usize) -> Vec<CongruentStrata> {
    let n = nside.value();
    let n_cells = nside.n_pixels() as f64;
    #[expect(clippy::cast_possible_truncation, reason = "a ring, at most 2 nside")]
    let ring = row as u32 + 1;
    if ring > n {
        // Face 4 has cells of all rings of the belt along one edge.
        let sum = 3 * n - 1 - ring;
        let halves = if ring < 2 * n { 2.0 } else { 1.0 };
        let share = halves * 4.0 * f64::from(n) / n_cells;
        let cell = Cell::new(nside, 4, n - 1, sum - (n - 1));
        return cell
            .map(|c| CongruentStrata { share, shape: Shape::Cell(c) })
            .into_iter()
            .collect();
    }
    (0..ring.div_ceil(2))
        .filter_map(|west| {
            let east = ring - 1 - west;
            let cell = Cell::new(nside, 0, n - 1 - west, n - 1 - east).ok()?;
            let mirrors = if west == east { 1.0 } else { 2.0 };
            let share = mirrors * 8.0 / n_cells;
            let is_cut = ring == 1 || ring == n;
            let shape = if is_cut { Shape::CutCell(cell) } else { Shape::Cell(cell) };
            Some(CongruentStrata { share, shape })
        })
        .collect()
}

/// Nodes along an edge of a HEALPix cell.
///
/// Where the map is nearest to its singularities, in the second ring and in cells collapsed to the pole, these lie
/// one edge beyond the cell, at 3 in units of half an edge from its middle; at nside 1 the belt ends half
/// an edge from the pole, at 2. The ellipse has `rho = x + sqrt(x^2 - 1)`, and stays clear of them.
fn cell_nodes(nside: Nside, lmax: usize) -> usize {
    let farthest = if nside.value() == 1 { 3.5 } else { 5.6 };
    gauss_nodes(lmax as f64, HALF_EDGE / f64::from(nside.value()), farthest)
}

/// Nodes in colatitude and longitude of a region, where the map is entire.
fn region_nodes(region: &Region, lmax: usize) -> [usize; 2] {
    const FARTHEST: f64 = 20.0;
    let [[top, bottom], [west, east]] = [region.theta(), region.phi()];
    let sine = largest_sine(region);
    let degree = (lmax as f64).max(1.0);
    let across = if is_full_turn(region) {
        turn_nodes(lmax, sine)
    } else {
        gauss_nodes(degree * sine, 0.5 * (east - west), FARTHEST)
    };
    [gauss_nodes(degree, 0.5 * (bottom - top), FARTHEST), across]
}

/// The largest sin(theta) in the region.
fn largest_sine(region: &Region) -> f64 {
    let [top, bottom] = region.theta();
    if top <= std::f64::consts::FRAC_PI_2 && bottom >= std::f64::consts::FRAC_PI_2 {
        1.0
    } else {
        top.sin().max(bottom.sin())
    }
}
