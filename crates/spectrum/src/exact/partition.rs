use sphvar_healpix::{Cell, Nside};
use sphvar_samplers::{Region, Strata};

use super::quadrature::{Quadrature, circle_nodes, gauss_nodes, is_full_circle};
use crate::Error;

/// A partition of the sphere or hemisphere into strata of equal area, represented by one stratum of
/// each class of congruent strata.
///
/// Degrees are even on the hemisphere, so a cell and its antipode are equivalent: the classes of
/// half of the HEALPix cells are those of all cells.
#[derive(Clone, Debug)]
pub(super) enum Partition {
    Healpix(Nside),
    /// One region of each class with the size of the class, and the total number of regions.
    Zonal(Vec<(Region, u32)>, usize),
}

/// A stratum and the fraction of all strata that are congruent to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct CongruentStrata {
    pub(super) share: f64,
    shape: StratumShape,
}

/// A stratum, by the quadrature that it needs.
#[derive(Clone, Copy, Debug)]
pub(super) enum StratumShape {
    Cell(Cell),
    /// A cell that must be split along u + v = 1.
    CutCell(Cell),
    Region(Region),
}

/// Half the longest edge of a HEALPix cell times nside. At meridians that bound a polar face an
/// edge is sheared to `sqrt(2/3 + (pi/2)^2 2/3) = 1.52`.
const HALF_EDGE: f64 = 0.77;

/// The longest chord in a HEALPix cell times nside, with a margin of 3 %. The maximum is 2.14, at
/// the ends of the ring |z| = 2/3.
const LONGEST_CHORD: f64 = 2.2;

impl Partition {
    /// Returns the classes of a partition into `n_points` strata; `None` for unknown kinds.
    pub(super) fn of(strata: Strata<'_>, n_points: usize) -> Option<Self> {
        match strata {
            Strata::Healpix(nside) => Some(Self::Healpix(nside)),
            Strata::EqualArea(regions) => {
                Some(Self::Zonal(regions.congruent_regions().collect(), n_points))
            }
            // Kinds of strata added later need their classes here.
            _ => None,
        }
    }

    /// Returns the number of rows, the unit of parallel work.
    pub(super) fn n_rows(&self) -> usize {
        match self {
            Self::Healpix(nside) => 2 * nside.value() as usize,
            Self::Zonal(regions, _) => regions.len(),
        }
    }

    /// Returns the classes of a row, 0-based: for HEALPix a ring, counted from the pole to the
    /// equator; for a zonal partition one class of regions.
    pub(super) fn row(&self, row: usize) -> Vec<CongruentStrata> {
        match self {
            Self::Healpix(nside) => ring_classes(*nside, row),
            Self::Zonal(regions, n) => {
                let (region, count) = regions[row];
                let share = f64::from(count) / *n as f64;
                vec![CongruentStrata { share, shape: StratumShape::Region(region) }]
            }
        }
    }

    /// Returns the numbers of quadrature nodes for degree `lmax`, each with the number of classes
    /// that use it.
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

    /// Returns the largest number of nodes.
    pub(super) fn max_nodes(&self, lmax: usize) -> usize {
        self.nodes(lmax).into_iter().map(|(_, nodes)| nodes).max().unwrap_or(1)
    }

    /// Returns an upper bound of the squared distance between two points of one stratum, at most 4.
    pub(super) fn longest_chord_squared(&self) -> f64 {
        match self {
            Self::Healpix(nside) => (LONGEST_CHORD / f64::from(nside.value())).powi(2).min(4.0),
            Self::Zonal(regions, _) => {
                let squares = regions.iter().map(|(region, _)| {
                    let [[top, bottom], [west, east]] = [region.theta(), region.phi()];
                    let along = (0.5 * (bottom - top)).sin();
                    let quarter_circle = std::f64::consts::FRAC_PI_2;
                    let across =
                        (0.5 * (east - west)).min(quarter_circle).sin() * largest_sine(region);
                    4.0 * (along * along + across * across)
                });
                squares.fold(0.0, f64::max).min(4.0)
            }
        }
    }
}

impl CongruentStrata {
    /// Returns the quadrature rule on the stratum for functions up to degree `lmax`.
    pub(super) fn quadrature(&self, lmax: usize) -> Result<Quadrature, Error> {
        self.shape.quadrature(lmax)
    }
}

impl StratumShape {
    /// Returns the shape of any HEALPix cell.
    pub(super) fn of_cell(cell: Cell) -> Self {
        let n = cell.nside().value();
        // The ring of a polar face, counted from its pole; belt cells need no cut.
        let ring = match cell.face() {
            0..=3 => 2 * n - 1 - cell.ix() - cell.iy(),
            4..=7 => return Self::Cell(cell),
            _ => cell.ix() + cell.iy() + 1,
        };
        if ring == 1 || ring == n { Self::CutCell(cell) } else { Self::Cell(cell) }
    }

    /// Returns the quadrature rule on the stratum for functions up to degree `lmax`.
    pub(super) fn quadrature(self, lmax: usize) -> Result<Quadrature, Error> {
        Ok(match self {
            Self::Cell(cell) => Quadrature::of_cell(cell, cell_nodes(cell.nside(), lmax))?,
            Self::CutCell(cell) => Quadrature::of_cut_cell(cell, cell_nodes(cell.nside(), lmax))?,
            Self::Region(region) => {
                let [theta, phi] = region_nodes(&region, lmax);
                Quadrature::of_region(&region, theta, phi)?
            }
        })
    }
}

/// Returns the classes of ring `row + 1`, counted from the north pole to the equator.
///
/// The symmetries of the grid are rotations by pi/2 about z, the reflection at the equator, and the
/// reflection that exchanges the two halves of a quadrant. In the cap, and in ring nside, which
/// extends into it, they leave `ceil(i/2)` classes in ring i. In the belt below, the cells of a
/// ring are congruent by rotations about z.
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
            .map(|c| CongruentStrata { share, shape: StratumShape::Cell(c) })
            .into_iter()
            .collect();
    }
    (0..ring.div_ceil(2))
        .filter_map(|west| {
            let east = ring - 1 - west;
            let cell = Cell::new(nside, 0, n - 1 - west, n - 1 - east).ok()?;
            let mirrors = if west == east { 1.0 } else { 2.0 };
            let share = mirrors * 8.0 / n_cells;
            Some(CongruentStrata { share, shape: StratumShape::of_cell(cell) })
        })
        .collect()
}

/// Returns the number of nodes along an edge of a HEALPix cell.
///
/// The map is nearest to its singularities in the second ring and in cells collapsed to the pole.
/// There they lie one edge beyond the cell, at 3 in units of half an edge from its centre. At
/// nside 1 the belt ends half an edge from the pole, at 2. The Bernstein ellipse has
/// `rho = x + sqrt(x^2 - 1)`, and a margin is left to these values.
fn cell_nodes(nside: Nside, lmax: usize) -> usize {
    let farthest = if nside.value() == 1 { 3.5 } else { 5.6 };
    gauss_nodes(lmax as f64, HALF_EDGE / f64::from(nside.value()), farthest)
}

/// Returns the numbers of nodes in colatitude and longitude of a region, where the map is entire.
fn region_nodes(region: &Region, lmax: usize) -> [usize; 2] {
    const FARTHEST: f64 = 20.0;
    let [[top, bottom], [west, east]] = [region.theta(), region.phi()];
    let sine = largest_sine(region);
    let degree = (lmax as f64).max(1.0);
    let across = if is_full_circle(region) {
        circle_nodes(lmax, sine)
    } else {
        gauss_nodes(degree * sine, 0.5 * (east - west), FARTHEST)
    };
    [gauss_nodes(degree, 0.5 * (bottom - top), FARTHEST), across]
}

/// Returns the maximum of sin(theta) in the region.
fn largest_sine(region: &Region) -> f64 {
    let [top, bottom] = region.theta();
    if top <= std::f64::consts::FRAC_PI_2 && bottom >= std::f64::consts::FRAC_PI_2 {
        1.0
    } else {
        top.sin().max(bottom.sin())
    }
}
