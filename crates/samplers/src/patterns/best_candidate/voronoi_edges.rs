use std::mem;

use glam::DVec3;

use super::bisector::{Arc, Bisector};

/// The edges of the Voronoi diagram of a growing set of sites: the arcs of bisectors on which both
/// sites are nearest.
///
/// A new site changes only the edges around it. They are found from its nearest site through edges
/// that it cuts, of which every cell that loses directions to the new one has some. Rounding can
/// only decide about parts of edges that are as short as its errors.
#[derive(Debug, Default)]
pub(super) struct VoronoiEdges {
    sites: Vec<DVec3>,
    /// The edges of the cell of each site.
    edges_of: Vec<Vec<u32>>,
    edges: Vec<Edge>,
    /// The largest distance of an edge from its sites, 0 for those that no longer exist.
    tops: Vec<f64>,
    unused: Vec<u32>,
    /// The edges that the last site changed.
    changed: Vec<u32>,
    /// The sites whose cells it made smaller.
    neighbours: Vec<u32>,
}

/// An edge between the cells of two sites.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) sites: [u32; 2],
    pub(super) arc: Arc,
}

impl VoronoiEdges {
    pub(super) fn n_sites(&self) -> usize {
        self.sites.len()
    }

    pub(super) fn site(&self, site: u32) -> DVec3 {
        self.sites[site as usize]
    }

    pub(super) fn edge(&self, edge: u32) -> (Edge, Bisector) {
        let edge = self.edges[edge as usize];
        let [a, b] = edge.sites.map(|site| self.site(site));
        (edge, Bisector::new(a, b))
    }

    /// Returns the largest distances of the edges from their sites, as in [`Bisector`]; 0 for edges
    /// that do not exist.
    pub(super) fn tops(&self) -> &[f64] {
        &self.tops
    }

    /// Returns the edges that the last site changed, removed or added.
    pub(super) fn changed(&self) -> &[u32] {
        &self.changed
    }

    /// Adds a site that is nearest to site number `nearest`. One that coincides with it changes
    /// nothing.
    pub(super) fn insert(&mut self, site: DVec3, nearest: u32) {
        let number = count(&self.sites);
        self.changed.clear();
        self.neighbours.clear();
        let is_new = self.sites.get(nearest as usize).is_some_and(|&other| other != site);
        self.sites.push(site);
        self.edges_of.push(Vec::new());
        if !is_new {
            return;
        }
        self.neighbours.push(nearest);
        let mut next = 0;
        while let Some(&cell) = self.neighbours.get(next) {
            next += 1;
            self.cut_cell(cell, site, next);
        }
        // By rounding, a site at the same place has no cell.
        if self.neighbours.len() == 1 && !self.edges_of[nearest as usize].is_empty() {
            return;
        }
        for index in 0..self.neighbours.len() {
            self.add_edge(self.neighbours[index], number);
        }
    }

    /// Removes from the edges of a cell what is nearer to a new site, if that has not been done for
    /// the cell on the other side: one of the first `n_done` neighbours.
    fn cut_cell(&mut self, cell: u32, new: DVec3, n_done: usize) {
        let mut edges = mem::take(&mut self.edges_of[cell as usize]);
        edges.retain(|&number| {
            if self.tops[number as usize] == 0.0 {
                // Removed on the other side.
                self.unused.push(number);
                return false;
            }
            let [a, b] = self.edges[number as usize].sites;
            let other = if a == cell { b } else { a };
            if self.neighbours[..n_done].contains(&other) {
                return true;
            }
            let (edge, bisector) = self.edge(number);
            let arc = bisector.clip(edge.arc, self.site(a) - new);
            if arc == Some(edge.arc) {
                return true;
            }
            self.changed.push(number);
            if !self.neighbours[n_done..].contains(&other) {
                self.neighbours.push(other);
            }
            match arc {
                Some(arc) => {
                    self.edges[number as usize].arc = arc;
                    self.tops[number as usize] = bisector.top(arc);
                }
                None => self.tops[number as usize] = 0.0,
            }
            arc.is_some()
        });
        self.edges_of[cell as usize] = edges;
    }

    /// Adds the edge between the last site and another one, if there is any.
    fn add_edge(&mut self, other: u32, last: u32) {
        let (from, to) = (self.site(other), self.site(last));
        let bisector = Bisector::new(from, to);
        let mut arc = Arc::Circle;
        for &third in self.neighbours.iter().filter(|&&third| third != other) {
            match bisector.clip(arc, from - self.site(third)) {
                Some(rest) => arc = rest,
                None => return,
            }
        }
        let edge = Edge { sites: [other, last], arc };
        let number = self.unused.pop().unwrap_or_else(|| {
            self.edges.push(edge);
            self.tops.push(0.0);
            count(&self.edges) - 1
        });
        self.edges[number as usize] = edge;
        self.tops[number as usize] = bisector.top(arc);
        self.edges_of[other as usize].push(number);
        self.edges_of[last as usize].push(number);
        self.changed.push(number);
    }
}

/// Returns the number of items, which are at most a few times `u32::MAX`, as are points.
fn count<T>(items: &[T]) -> u32 {
    u32::try_from(items.len()).unwrap_or(u32::MAX)
}
