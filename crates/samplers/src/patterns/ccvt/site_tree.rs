use glam::DVec3;

/// Maximum number of sites of a leaf; testing two smaller nodes costs more than testing their
/// pairs.
const LEAF: usize = 4;

/// A range of sites and a ball that encloses the balls of their mass points. Distances are chords,
/// not angles: the Euclidean distance, or the smaller of two up to sign, is a metric on both
/// domains.
#[derive(Clone, Copy, Debug)]
struct Node {
    start: usize,
    end: usize,
    /// The two children; 0 for a leaf.
    children: [usize; 2],
    centre: DVec3,
    radius: f64,
}

/// A tree over the sites, in their order, that finds pairs whose balls of mass points intersect.
#[derive(Clone, Debug, Default)]
pub(super) struct SiteTree {
    nodes: Vec<Node>,
}

/// Returns the chord between two sites, or the smallest between the sites and their antipodes.
#[inline(always)]
pub(super) fn chord(antipodal: bool, a: DVec3, b: DVec3) -> f64 {
    let square = a.distance_squared(b);
    if antipodal { square.min((a + b).length_squared()).sqrt() } else { square.sqrt() }
}

impl SiteTree {
    /// Calls `pair(i, j)` for each i < j with chord(i, j) < radii[i] + radii[j] + `slack`, in an
    /// order that depends on the arguments alone.
    pub(super) fn find(
        &mut self,
        antipodal: bool,
        sites: &[DVec3],
        radii: &[f64],
        slack: f64,
        mut pair: impl FnMut(usize, usize),
    ) {
        self.nodes.clear();
        self.build(antipodal, sites, radii, 0, sites.len());
        let nodes = &self.nodes;
        Query { nodes, antipodal, sites, radii, slack }.within(0, &mut pair);
    }

    fn build(
        &mut self,
        antipodal: bool,
        sites: &[DVec3],
        radii: &[f64],
        start: usize,
        end: usize,
    ) -> usize {
        let mut sum = sites[start];
        for &s in &sites[start + 1..end] {
            sum += if antipodal && s.dot(sum) < 0.0 { -s } else { s };
        }
        let centre = sum / (end - start) as f64;
        let reach = |k: usize| chord(antipodal, centre, sites[k]) + radii[k];
        let radius = (start..end).map(reach).fold(0.0, f64::max);
        let at = self.nodes.len();
        self.nodes.push(Node { start, end, children: [0; 2], centre, radius });
        if end - start > LEAF {
            let middle = usize::midpoint(start, end);
            let low = self.build(antipodal, sites, radii, start, middle);
            let high = self.build(antipodal, sites, radii, middle, end);
            self.nodes[at].children = [low, high];
        }
        at
    }
}

struct Query<'a> {
    nodes: &'a [Node],
    antipodal: bool,
    sites: &'a [DVec3],
    radii: &'a [f64],
    slack: f64,
}

impl Query<'_> {
    fn test(&self, i: usize, j: usize, pair: &mut impl FnMut(usize, usize)) {
        let reach = self.radii[i] + self.radii[j] + self.slack;
        if chord(self.antipodal, self.sites[i], self.sites[j]) < reach {
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
        if chord(self.antipodal, low.centre, high.centre) >= reach {
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
    use rand::RngExt;

    use super::{SiteTree, chord};
    use crate::{Domain, Purpose, Sampler, Streams, WhiteNoise};

    #[test]
    fn the_pairs_match_an_exhaustive_search() {
        let mut rng = Streams::new(2, Purpose::Pattern, 0).realization(0);
        for (n, scale) in [(1, 1.0), (2, 3.0), (5, 1.0), (150, 0.1), (151, 1.0)] {
            let mut sites = WhiteNoise::new(n, Domain::Sphere).sample(&mut rng).unwrap().points;
            sites.sort_by(|a, b| a.x.total_cmp(&b.x));
            let radii: Vec<f64> = (0..n).map(|_| scale * rng.random::<f64>()).collect();
            for antipodal in [false, true] {
                let mut found = Vec::new();
                SiteTree::default()
                    .find(antipodal, &sites, &radii, 0.05, |i, j| found.push((i, j)));
                found.sort_unstable();
                let mut all = Vec::new();
                for i in 0..n {
                    for j in i + 1..n {
                        if chord(antipodal, sites[i], sites[j]) < radii[i] + radii[j] + 0.05 {
                            all.push((i, j));
                        }
                    }
                }
                assert_eq!(found, all, "n = {n}, antipodal: {antipodal}");
            }
        }
    }
}
