use super::mass_space::MassSpace;

/// Maximum number of sites of a leaf; testing two smaller nodes costs more than testing their
/// pairs.
const LEAF: usize = 4;

/// A range of sites and a ball that encloses the balls of their mass points.
#[derive(Clone, Copy, Debug)]
struct Node<P> {
    start: usize,
    end: usize,
    /// The two children; 0 for a leaf.
    children: [usize; 2],
    centre: P,
    radius: f64,
}

/// A tree over the sites, in their order, that finds pairs whose balls of mass points intersect.
#[derive(Clone, Debug)]
pub(super) struct SiteTree<P> {
    nodes: Vec<Node<P>>,
}

impl<P> Default for SiteTree<P> {
    fn default() -> Self {
        Self { nodes: Vec::new() }
    }
}

impl<P: Copy> SiteTree<P> {
    /// Calls `pair(i, j)` for each i < j with distance(i, j) < radii[i] + radii[j] + `slack`, in an
    /// order that depends on the arguments alone.
    pub(super) fn find<S: MassSpace<D, Point = P>, const D: usize>(
        &mut self,
        space: S,
        sites: &[P],
        radii: &[f64],
        slack: f64,
        mut pair: impl FnMut(usize, usize),
    ) {
        self.nodes.clear();
        self.build(space, sites, radii, 0, sites.len());
        let nodes = &self.nodes;
        Query { nodes, space, sites, radii, slack }.within(0, &mut pair);
    }

    fn build<S: MassSpace<D, Point = P>, const D: usize>(
        &mut self,
        space: S,
        sites: &[P],
        radii: &[f64],
        start: usize,
        end: usize,
    ) -> usize {
        let centre = space.middle(&sites[start..end]);
        let reach = |k: usize| space.distance(centre, sites[k]) + radii[k];
        let radius = (start..end).map(reach).fold(0.0, f64::max);
        let at = self.nodes.len();
        self.nodes.push(Node { start, end, children: [0; 2], centre, radius });
        if end - start > LEAF {
            let middle = usize::midpoint(start, end);
            let low = self.build(space, sites, radii, start, middle);
            let high = self.build(space, sites, radii, middle, end);
            self.nodes[at].children = [low, high];
        }
        at
    }
}

struct Query<'a, S: MassSpace<D>, const D: usize> {
    nodes: &'a [Node<S::Point>],
    space: S,
    sites: &'a [S::Point],
    radii: &'a [f64],
    slack: f64,
}

impl<S: MassSpace<D>, const D: usize> Query<'_, S, D> {
    fn test(&self, i: usize, j: usize, pair: &mut impl FnMut(usize, usize)) {
        let reach = self.radii[i] + self.radii[j] + self.slack;
        if self.space.distance(self.sites[i], self.sites[j]) < reach {
            pair(i, j);
        }
    }

    fn within(&self, at: usize, pair: &mut impl FnMut(usize, usize)) {
        let node = self.nodes[at];
        if node.children == [0; 2] {
            for j in node.start..node.end {
                for i in node.start..j {
                    self.test(i, j, pair);
                }
            }
            return;
        }
        let [low, high] = node.children;
        self.within(low, pair);
        self.between(low, high, pair);
        self.within(high, pair);
    }

    fn between(&self, a: usize, b: usize, pair: &mut impl FnMut(usize, usize)) {
        let (low, high) = (self.nodes[a], self.nodes[b]);
        let reach = low.radius + high.radius + self.slack;
        if self.space.distance(low.centre, high.centre) >= reach {
            return;
        }
        let leaf = [low.children == [0; 2], high.children == [0; 2]];
        if leaf == [true; 2] {
            for i in low.start..low.end {
                for j in high.start..high.end {
                    self.test(i, j, pair);
                }
            }
        } else if leaf[1] || (!leaf[0] && low.end - low.start >= high.end - high.start) {
            self.between(low.children[0], b, pair);
            self.between(low.children[1], b, pair);
        } else {
            self.between(a, high.children[0], pair);
            self.between(a, high.children[1], pair);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use rand::RngExt;

    use super::SiteTree;
    use crate::patterns::ccvt::Directions;
    use crate::square::ccvt_square::Torus;
    use crate::tessellation::MassSpace;
    use crate::{Domain, Purpose, Sampler, Streams, WhiteNoise};

    fn check<S: MassSpace<D>, const D: usize>(space: S, sites: &[S::Point], radii: &[f64]) {
        let mut found = Vec::new();
        SiteTree::default().find(space, sites, radii, 0.05, |i, j| found.push((i, j)));
        found.sort_unstable();
        let mut all = Vec::new();
        for j in 0..sites.len() {
            for i in 0..j {
                if space.distance(sites[i], sites[j]) < radii[i] + radii[j] + 0.05 {
                    all.push((i, j));
                }
            }
        }
        all.sort_unstable();
        assert_eq!(found, all, "{space:?}, n = {}", sites.len());
    }

    #[test]
    fn the_pairs_match_an_exhaustive_search() {
        let mut rng = Streams::new(2, Purpose::Pattern, 0).realization(0);
        for (n, scale) in [(1, 1.0), (2, 3.0), (5, 1.0), (150, 0.1), (151, 1.0)] {
            let mut sites = WhiteNoise::new(n, Domain::Sphere).sample(&mut rng).unwrap().points;
            sites.sort_by(|a, b| a.x.total_cmp(&b.x));
            let radii: Vec<f64> = (0..n).map(|_| scale * rng.random::<f64>()).collect();
            for antipodal in [false, true] {
                check(Directions { antipodal }, &sites, &radii);
            }
            let mut sites: Vec<DVec2> = (0..n).map(|_| rng.random::<[f64; 2]>().into()).collect();
            sites.sort_by(|a, b| a.x.total_cmp(&b.x));
            check(Torus, &sites, &radii);
        }
    }
}
