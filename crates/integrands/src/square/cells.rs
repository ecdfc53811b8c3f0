//! Functions on the square that are smooth between given lines, resolved by Gauss-Legendre rules on
//! cells that are divided where the function is not smooth.

mod line;
mod rules;
mod spectrum;

use std::collections::BTreeMap;

use sphvar_warps::Warp;

use super::doubling::values_into;
use crate::{Error, SquareIntegrand};
use line::Intervals;
use rules::{MAX_WAVELENGTHS, Rules};
pub(super) use spectrum::{CellSpectrum, Variance};

/// The largest frequencies that are tried for the first cells.
const FREQUENCIES: [usize; 3] = [256, 128, 64];
/// Values that are requested together.
const BATCH: usize = 1 << 17;
/// Cells are not divided further than this fraction of the square.
const MIN_AREA: f64 = 1e-15;
/// The points around the direction of a feature that are examined.
const FEATURE_POINTS: u32 = 200;
/// The angle that divides a turn by the golden section.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
/// The rounds of division.
const MAX_ROUNDS: usize = 100;

/// A rule with values of a function, whose nodes follow the lines across which a warp is not
/// smooth.
///
/// Panels in u lie between the breaks of the warp in u. In each, cells lie between its breaks in v,
/// which may depend on u: a cell is the image of `[0, 1]^2` under
///
/// ```text
/// u = u_0 + x (u_1 - u_0),   v = b_p(u) + (s_0 + y (s_1 - s_0)) (b_{p+1}(u) - b_p(u))
/// ```
///
/// for the breaks b_p and a share [s_0, s_1] of the interval between two of them, so that a function
/// that is smooth between the breaks is smooth in x and y. Orders of the product rules follow from
/// the extents of cells in wavelengths of `kmax`.
pub(super) struct Cells<'a> {
    function: &'a dyn SquareIntegrand,
    warp: &'a dyn Warp,
    kmax: usize,
    /// Of the breaks of the warp, every `stride`-th is kept.
    stride: usize,
    rules: Rules,
    panels: Vec<Panel>,
    list: Vec<Cell>,
    nodes: Vec<Node>,
    u_intervals: Intervals,
    /// If no break in v depends on u, so that all cells are rectangles.
    v_intervals: Option<Intervals>,
    /// A value near the mean, from which moments are taken.
    origin: f64,
}

/// The cells between two values of u.
struct Panel {
    /// The edges in v, if their number at the nodes differs; otherwise they follow u.
    edges: Option<Vec<f64>>,
}

/// A place between edges in v.
#[derive(Clone, Copy)]
struct Place {
    piece: usize,
    share: [f64; 2],
    /// The interval in v, where these are kept.
    v: usize,
}

struct Cell {
    panel: usize,
    /// The interval in u.
    u: usize,
    place: Place,
    orders: [usize; 2],
    /// The first node; those of equal u are consecutive.
    first: usize,
    area: f64,
    /// The mean squares of the components of the highest degree in u and in v.
    misfit: [f64; 2],
    /// The weighted sums of the values and their squares, relative to the origin.
    moments: [f64; 2],
    is_divided: bool,
}

/// A point with its weight and the value there.
#[derive(Clone, Copy)]
pub(super) struct Node {
    pub(super) point: [f64; 2],
    pub(super) weight: f64,
    pub(super) value: f64,
}

/// A direction near which a function has a feature of a size in radians.
pub(super) struct Feature {
    pub(super) dir: glam::DVec3,
    pub(super) size: f64,
}

impl Cell {
    /// Returns the integral of the squared misfit.
    fn error(&self) -> f64 {
        self.area * (self.misfit[0] + self.misfit[1])
    }

    fn len(&self) -> usize {
        self.orders[0] * self.orders[1]
    }
}

impl<'a> Cells<'a> {
    /// Returns cells of at most `max` values in which the misfit is at most `relative` of the
    /// variance, if that is possible; those at `features` are at most as large.
    pub(super) fn new(
        function: &'a dyn SquareIntegrand,
        warp: &'a dyn Warp,
        features: &[Feature],
        relative: f64,
        max: usize,
    ) -> Result<Self, Error> {
        let mut cells = Self {
            function,
            warp,
            kmax: 0,
            stride: 1,
            rules: Rules::new()?,
            panels: Vec::new(),
            list: Vec::new(),
            nodes: Vec::new(),
            u_intervals: Intervals::default(),
            v_intervals: None,
            origin: function.eval([0.5, 0.5]),
        };
        cells.choose_resolution(max - max / 8);
        cells.add_panels()?;
        for feature in features {
            cells.divide_at(feature)?;
        }
        cells.divide(relative, max)?;
        Ok(cells)
    }

    /// Chooses the largest frequency and the breaks that are kept for the first cells.
    fn choose_resolution(&mut self, max: usize) {
        let len = |edges: &[f64], kmax: usize| -> usize {
            let panels = edges.windows(2).map(|pair| {
                let (parts, wavelengths) = parts(pair[1] - pair[0], kmax);
                parts * Rules::order(wavelengths)
            });
            panels.sum()
        };
        let last = FREQUENCIES.len() - 1;
        for stride in (0..).map(|i| 1usize << i) {
            self.stride = stride;
            let u = self.thinned(self.warp.breaks_in_u());
            let v = [0.2, 0.5, 0.8].map(|u| self.thinned(self.warp.breaks_in_v(u)));
            for kmax in FREQUENCIES {
                self.kmax = kmax;
                let along_v = v.iter().map(|edges| len(edges, kmax)).max().unwrap_or(1);
                if len(&u, kmax).saturating_mul(along_v) <= max {
                    return;
                }
            }
            // Without breaks there is nothing to thin.
            if u.len() == 2 && v.iter().all(|edges| edges.len() == 2) {
                self.kmax = FREQUENCIES[last];
                return;
            }
        }
    }

    /// Returns the breaks that are kept, with both ends of [0, 1].
    fn thinned(&self, breaks: Vec<f64>) -> Vec<f64> {
        let kept = breaks.into_iter().skip(self.stride - 1).step_by(self.stride);
        std::iter::once(0.0).chain(kept).chain([1.0]).collect()
    }

    /// Adds the first cells.
    fn add_panels(&mut self) -> Result<(), Error> {
        let has_breaks = |u: f64| !self.warp.breaks_in_v(u).is_empty();
        let is_rectangular = ![0.1, 0.3, 0.5, 0.7, 0.9].into_iter().any(has_breaks);
        let mut intervals = is_rectangular.then(Intervals::default);
        let edges = self.thinned(self.warp.breaks_in_u());
        for pair in edges.windows(2) {
            let (parts_of_u, _) = parts(pair[1] - pair[0], self.kmax);
            for [low, high] in divided([pair[0], pair[1]], parts_of_u) {
                let u = self.u_intervals.push([low, high]);
                let places = self.first_places([low, high], intervals.as_mut());
                self.add_cells(u, self.panels.len() - 1, &places)?;
            }
        }
        self.v_intervals = intervals;
        Ok(())
    }

    /// Adds a panel in u, and returns the places of its cells.
    fn first_places(&mut self, u: [f64; 2], intervals: Option<&mut Intervals>) -> Vec<Place> {
        let order = Rules::order((u[1] - u[0]) * self.kmax as f64);
        let at = |x: f64| self.thinned(self.warp.breaks_in_v(u[0] + x * (u[1] - u[0])));
        let lines: Vec<Vec<f64>> =
            self.rules.of_order(order).nodes.iter().map(|x| at(*x)).collect();
        let is_consistent = lines.iter().all(|line| line.len() == lines[0].len());
        let middle = &lines[order / 2];
        let widest = |piece: usize| {
            let width = |line: &Vec<f64>| line.get(piece + 1).map_or(0.0, |v| v - line[piece]);
            if is_consistent { lines.iter().map(width).fold(0.0, f64::max) } else { width(middle) }
        };
        let mut places = Vec::new();
        for piece in 0..middle.len() - 1 {
            let n = parts(widest(piece), self.kmax).0;
            places.extend(divided([0.0, 1.0], n).map(|share| Place { piece, share, v: 0 }));
        }
        if let Some(intervals) = intervals {
            // The only piece is [0, 1], so all panels have the same places.
            let is_first = intervals.len() == 0;
            for (i, place) in places.iter_mut().enumerate() {
                place.v = if is_first { intervals.push(place.share) } else { i };
            }
        }
        let edges = (!is_consistent).then(|| middle.clone());
        self.panels.push(Panel { edges });
        places
    }

    /// Returns the edges in v at a value of u in a panel.
    fn edges(&self, panel: usize, u: f64) -> Vec<f64> {
        let edges = self.panels[panel].edges.clone();
        edges.unwrap_or_else(|| self.thinned(self.warp.breaks_in_v(u)))
    }

    /// Adds cells that share an interval in u.
    fn add_cells(&mut self, u: usize, panel: usize, places: &[Place]) -> Result<(), Error> {
        let [low, high] = self.u_intervals.ends(u);
        let order = Rules::order((high - low) * self.kmax as f64);
        let rule = self.rules.of_order(order);
        let at = |x: &f64| (low + x * (high - low)).min(1.0f64.next_down());
        let u_nodes: Vec<f64> = rule.nodes.iter().map(at).collect();
        let lines: Vec<Vec<f64>> = u_nodes.iter().map(|u| self.edges(panel, *u)).collect();
        // The start and the extent of a place on a line; edges that are missing have none.
        let extent = |line: &[f64], Place { piece, share, .. }: Place| {
            let edge = |i: usize| line.get(i).copied().unwrap_or(1.0);
            let (first, width) = (edge(piece), edge(piece + 1) - edge(piece));
            (first + share[0] * width, (share[1] - share[0]) * width)
        };
        let widest =
            |place: Place| lines.iter().map(|line| extent(line, place).1).fold(0.0, f64::max);
        let orders: Vec<usize> =
            places.iter().map(|place| Rules::order(widest(*place) * self.kmax as f64)).collect();
        // Line by line, because warps are faster at equal u.
        let mut points = Vec::new();
        let mut weights = Vec::new();
        for ((u, w), line) in u_nodes.iter().zip(&rule.weights).zip(&lines) {
            for (place, order) in places.iter().zip(&orders) {
                let (start, width) = extent(line, *place);
                let across = self.rules.of_order(*order);
                for (y, along) in across.nodes.iter().zip(&across.weights) {
                    points.push([*u, (start + y * width).min(1.0f64.next_down())]);
                    weights.push((high - low) * w * width * along);
                }
            }
        }
        let mut values = vec![0.0; points.len()];
        for (points, values) in points.chunks(BATCH).zip(values.chunks_mut(BATCH)) {
            values_into(self.function, points, values)?;
        }
        let per_line: usize = orders.iter().sum();
        let mut before = 0;
        for (place, of_v) in places.iter().zip(orders) {
            let first = self.nodes.len();
            for i in 0..order {
                let start = i * per_line + before;
                self.nodes.extend((start..start + of_v).map(|k| Node {
                    point: points[k],
                    weight: weights[k],
                    value: values[k],
                }));
            }
            before += of_v;
            let cell = self.cell(u, panel, *place, [order, of_v], first);
            if cell.area > 0.0 {
                self.list.push(cell);
            } else {
                self.nodes.truncate(first);
            }
        }
        Ok(())
    }

    fn cell(&self, u: usize, panel: usize, place: Place, orders: [usize; 2], first: usize) -> Cell {
        let nodes = &self.nodes[first..];
        let [along_u, along_v] = orders.map(|order| self.rules.of_order(order));
        let mut misfit = [0.0; 2];
        for (line, w) in nodes.chunks_exact(orders[1]).zip(&along_u.weights) {
            let top: f64 = line.iter().zip(&along_v.top).map(|(node, t)| t * node.value).sum();
            misfit[1] += w * top * top;
        }
        for (j, w) in along_v.weights.iter().enumerate() {
            let column = nodes.iter().skip(j).step_by(orders[1]);
            let top: f64 = column.zip(&along_u.top).map(|(node, t)| t * node.value).sum();
            misfit[0] += w * top * top;
        }
        let mut moments = [0.0; 2];
        for node in nodes {
            let value = node.value - self.origin;
            moments[0] += node.weight * value;
            moments[1] += node.weight * value * value;
        }
        let area = nodes.iter().map(|node| node.weight).sum();
        Cell { panel, u, place, orders, first, area, misfit, moments, is_divided: false }
    }

    /// Returns the cells that are not divided.
    fn live(&self) -> impl Iterator<Item = &Cell> {
        self.list.iter().filter(|cell| !cell.is_divided)
    }

    /// Returns the first two moments relative to the origin.
    fn moments(&self) -> (f64, f64) {
        let add = |(a, b): (f64, f64), cell: &Cell| (a + cell.moments[0], b + cell.moments[1]);
        self.live().fold((0.0, 0.0), add)
    }

    /// Returns the integral of the function.
    pub(super) fn integral(&self) -> f64 {
        self.origin + self.moments().0
    }

    /// Divides the cells of the largest misfits.
    fn divide(&mut self, relative: f64, max: usize) -> Result<(), Error> {
        for _ in 0..MAX_ROUNDS {
            let (first, second) = self.moments();
            let variance = second - first * first;
            let error: f64 = self.live().map(Cell::error).sum();
            if error <= relative * variance || error <= f64::EPSILON * f64::EPSILON * second {
                break;
            }
            let is_divisible = |cell: &&Cell| cell.area > MIN_AREA;
            let largest = self.live().filter(is_divisible).map(Cell::error).fold(0.0, f64::max);
            let mut chosen: Vec<usize> = (0..self.list.len())
                .filter(|i| {
                    let cell = &self.list[*i];
                    !cell.is_divided && is_divisible(&cell) && cell.error() > 0.25 * largest
                })
                .collect();
            // Halves have fewer nodes than their cell each.
            let mut room = max.saturating_sub(self.nodes.len());
            chosen.retain(|i| {
                let len = 2 * self.list[*i].len();
                let fits = len <= room;
                room -= if fits { len } else { room };
                fits
            });
            if chosen.is_empty() {
                break;
            }
            self.halve(&chosen)?;
        }
        Ok(())
    }

    /// Divides cells along the coordinate of their larger misfit.
    fn halve(&mut self, cells: &[usize]) -> Result<(), Error> {
        let along: Vec<(usize, usize)> = cells
            .iter()
            .map(|i| (*i, usize::from(self.list[*i].misfit[1] > self.list[*i].misfit[0])))
            .collect();
        self.halve_along(&along)
    }

    fn halve_along(&mut self, cells: &[(usize, usize)]) -> Result<(), Error> {
        let mut groups: BTreeMap<(usize, usize), Vec<Place>> = BTreeMap::new();
        for &(i, coordinate) in cells {
            let cell = &mut self.list[i];
            cell.is_divided = true;
            let (place, u, panel) = (cell.place, cell.u, cell.panel);
            if coordinate == 0 {
                for half in self.u_intervals.halves(u) {
                    groups.entry((half, panel)).or_default().push(place);
                }
                continue;
            }
            let middle = f64::midpoint(place.share[0], place.share[1]);
            let halves = self.v_intervals.as_mut().map_or([0; 2], |all| all.halves(place.v));
            let shares = [[place.share[0], middle], [middle, place.share[1]]];
            let both = shares.into_iter().zip(halves);
            let both = both.map(|(share, v)| Place { piece: place.piece, share, v });
            groups.entry((u, panel)).or_default().extend(both);
        }
        groups.into_iter().try_for_each(|((u, panel), places)| self.add_cells(u, panel, &places))
    }

    /// Divides the cells around a direction until they are no larger than a feature there.
    fn divide_at(&mut self, feature: &Feature) -> Result<(), Error> {
        // A Fibonacci spiral over the disk around the direction, because a pole of the warp is the
        // side of many cells.
        let (x, y) = feature.dir.any_orthonormal_pair();
        let dirs = (0..FEATURE_POINTS).map(|i| {
            let radius = feature.size * ((f64::from(i) + 0.5) / f64::from(FEATURE_POINTS)).sqrt();
            let (sin, cos) = (GOLDEN_ANGLE * f64::from(i)).sin_cos();
            (feature.dir + radius * (cos * x + sin * y)).normalize()
        });
        let warp = self.warp;
        for [u, v] in dirs.filter_map(|dir| warp.inverse(dir)) {
            for _ in 0..MAX_ROUNDS {
                let Some(i) = self.cell_of([u, v]) else { break };
                let cell = &self.list[i];
                let nodes = &self.nodes[cell.first..cell.first + cell.len()];
                let map = |k: usize| self.warp.map(nodes[k].point);
                let (first, last) = (map(0), cell.len() - 1);
                let extents = [map(last - (cell.orders[1] - 1)), map(cell.orders[1] - 1)]
                    .map(|dir| dir.distance(first));
                if cell.area <= MIN_AREA || extents[0].max(extents[1]) <= 0.5 * feature.size {
                    break;
                }
                self.halve_along(&[(i, usize::from(extents[1] > extents[0]))])?;
            }
        }
        Ok(())
    }

    /// Returns the cell that contains a point.
    fn cell_of(&self, [u, v]: [f64; 2]) -> Option<usize> {
        let mut edges: Option<(usize, Vec<f64>)> = None;
        self.list.iter().position(|cell| {
            let [low, high] = self.u_intervals.ends(cell.u);
            if cell.is_divided || !(low..high).contains(&u) {
                return false;
            }
            if edges.as_ref().is_none_or(|(panel, _)| *panel != cell.panel) {
                edges = Some((cell.panel, self.edges(cell.panel, u)));
            }
            let Place { piece, share, .. } = cell.place;
            edges.as_ref().and_then(|(_, edges)| edges.get(piece..piece + 2)).is_some_and(|pair| {
                let place = (v - pair[0]) / (pair[1] - pair[0]);
                (share[0]..share[1]).contains(&place)
            })
        })
    }

    /// Returns the nodes of all cells that are not divided.
    pub(super) fn nodes(&self) -> impl Iterator<Item = &Node> + Clone {
        let cells = self.list.iter().filter(|cell| !cell.is_divided);
        cells.flat_map(|cell| &self.nodes[cell.first..cell.first + cell.len()])
    }
}

/// Returns the number of parts of a panel of this width, and the wavelengths in each.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a positive number of some hundred"
)]
fn parts(width: f64, kmax: usize) -> (usize, f64) {
    let wavelengths = width * kmax as f64;
    let parts = (wavelengths / MAX_WAVELENGTHS).ceil().max(1.0);
    (parts as usize, wavelengths / parts)
}

/// Returns equal parts of an interval.
fn divided([low, high]: [f64; 2], n: usize) -> impl Iterator<Item = [f64; 2]> {
    let edge = move |i: usize| if i == n { high } else { low + (high - low) * i as f64 / n as f64 };
    (0..n).map(move |i| [edge(i), edge(i + 1)])
}
