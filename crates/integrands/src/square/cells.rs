//! Functions on the square that are smooth between given lines, resolved by Gauss-Legendre rules on
//! cells that are divided where the function is not smooth.

mod division;
mod line;
mod panels;
mod rules;
mod spectrum;

use sphvar_warps::Warp;

use super::doubling::values_into;
use crate::{Error, SquareIntegrand};
use line::Intervals;
use rules::{ORDERS, Rules};
pub(super) use spectrum::{CellSpectrum, Variance};

/// Values that are requested together.
const BATCH: usize = 1 << 17;
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
/// for the breaks `b_p` and a share `[s_0, s_1]` of the interval between two of them, so that a function
/// that is smooth between the breaks is smooth in x and y. Orders of the product rules follow from
/// the extents of cells in wavelengths of `kmax`.
pub(super) struct Cells<'a> {
    function: &'a dyn SquareIntegrand,
    warp: &'a dyn Warp,
    kmax: usize,
    min_order: usize,
    /// Of the breaks of the warp, every `stride`-th is kept.
    stride: usize,
    /// Values of u and of v across which the function is not smooth, besides the breaks.
    lines: [Vec<f64>; 2],
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

/// Where a function is known not to be smooth.
#[derive(Default)]
pub(super) struct Known {
    /// Values of u and of v.
    pub(super) lines: [Vec<f64>; 2],
    pub(super) features: Vec<Feature>,
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
    /// variance, if that is possible; those at known features are at most as large. `origin` is near the
    /// mean.
    pub(super) fn new(
        function: &'a dyn SquareIntegrand,
        warp: &'a dyn Warp,
        known: Known,
        origin: f64,
        (relative, max): (f64, usize),
    ) -> Result<Self, Error> {
        let mut cells = Self {
            function,
            warp,
            kmax: 0,
            min_order: ORDERS[0],
            stride: 1,
            lines: known.lines,
            rules: Rules::new()?,
            panels: Vec::new(),
            list: Vec::new(),
            nodes: Vec::new(),
            u_intervals: Intervals::default(),
            v_intervals: None,
            origin,
        };
        cells.choose_resolution(max - max / 8);
        cells.add_panels()?;
        for feature in &known.features {
            cells.divide_at(feature)?;
        }
        cells.divide(relative, max)?;
        Ok(cells)
    }

    /// Adds cells that share an interval in u.
    fn add_cells(&mut self, u: usize, panel: usize, places: &[Place]) -> Result<(), Error> {
        let at = |u: f64| self.edges(panel, u);
        let lines: Vec<Vec<f64>> = self.nodes_of_interval(u).into_iter().map(at).collect();
        self.add_on_lines(u, panel, places, &lines)
    }

    /// Returns the order of the rule on an interval in u.
    fn order_of_interval(&self, [low, high]: [f64; 2]) -> usize {
        Rules::order((high - low) * self.kmax as f64, self.min_order)
    }

    fn nodes_of_interval(&self, u: usize) -> Vec<f64> {
        let [low, high] = self.u_intervals.ends(u);
        let rule = self.rules.of_order(self.order_of_interval([low, high]));
        rule.nodes.iter().map(|x| (low + x * (high - low)).min(1.0f64.next_down())).collect()
    }

    /// Adds cells that share an interval in u, with the edges in v at its nodes.
    fn add_on_lines(
        &mut self,
        u: usize,
        panel: usize,
        places: &[Place],
        lines: &[Vec<f64>],
    ) -> Result<(), Error> {
        let [low, high] = self.u_intervals.ends(u);
        let u_nodes = self.nodes_of_interval(u);
        let order = u_nodes.len();
        let rule = self.rules.of_order(order);
        // The start and the extent of a place on a line; edges that are missing have none.
        let extent = |line: &[f64], Place { piece, share, .. }: Place| {
            let edge = |i: usize| line.get(i).copied().unwrap_or(1.0);
            let (first, width) = (edge(piece), edge(piece + 1) - edge(piece));
            (first + share[0] * width, (share[1] - share[0]) * width)
        };
        let widest =
            |place: Place| lines.iter().map(|line| extent(line, place).1).fold(0.0, f64::max);
        let orders: Vec<usize> = places
            .iter()
            .map(|place| Rules::order(widest(*place) * self.kmax as f64, self.min_order))
            .collect();
        // Line by line, because warps are faster at equal u.
        let mut points = Vec::new();
        let mut weights = Vec::new();
        for ((u, w), line) in u_nodes.iter().zip(&rule.weights).zip(lines) {
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

    /// Returns the nodes of all cells that are not divided.
    pub(super) fn nodes(&self) -> impl Iterator<Item = &Node> + Clone {
        let cells = self.list.iter().filter(|cell| !cell.is_divided);
        cells.flat_map(|cell| &self.nodes[cell.first..cell.first + cell.len()])
    }
}
