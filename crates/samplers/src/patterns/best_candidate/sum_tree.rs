/// Weights in a binary tree of their sums. A sum is always that of the present weights, so that
/// rounding errors do not accumulate.
#[derive(Debug)]
pub(super) struct SumTree {
    /// The root is at 1, the children of node k at 2 k and 2 k + 1, and the second half are the
    /// weights.
    nodes: Vec<f64>,
}

impl SumTree {
    /// Returns a tree of these weights.
    pub(super) fn new(weights: &[f64]) -> Self {
        // Memory for as many more.
        let leaves = (2 * weights.len()).next_power_of_two().max(2);
        let mut nodes = vec![0.0; 2 * leaves];
        nodes[leaves..leaves + weights.len()].copy_from_slice(weights);
        for node in (1..leaves).rev() {
            nodes[node] = nodes[2 * node] + nodes[2 * node + 1];
        }
        Self { nodes }
    }

    pub(super) fn total(&self) -> f64 {
        self.nodes[1]
    }

    /// Sets the weights 2 k and 2 k + 1.
    pub(super) fn set_pair(&mut self, k: usize, pair: [f64; 2]) {
        let leaves = self.nodes.len() / 2;
        if 2 * k >= leaves {
            let weights = self.nodes.split_off(leaves);
            *self = Self::new(&weights);
            return self.set_pair(k, pair);
        }
        let mut node = leaves + 2 * k;
        self.nodes[node..node + 2].copy_from_slice(&pair);
        while node > 1 {
            node /= 2;
            self.nodes[node] = self.nodes[2 * node] + self.nodes[2 * node + 1];
        }
    }

    /// Returns the index of the weight at a place among all weights in turn, from 0 to their total.
    /// It is not zero unless all are.
    pub(super) fn find(&self, mut place: f64) -> usize {
        let leaves = self.nodes.len() / 2;
        let mut node = 1;
        while node < leaves {
            node *= 2;
            // Rounding does not lead to weights of zero.
            if place >= self.nodes[node] && self.nodes[node + 1] > 0.0 {
                place -= self.nodes[node];
                node += 1;
            }
        }
        node - leaves
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lead_to_their_weights() {
        let weights = [0.0, 3.0, 0.5, 0.0, 0.0, 2.0, 0.0];
        let mut tree = SumTree::new(&weights);
        assert!((tree.total() - 5.5).abs() < 1e-15);
        for (place, expected) in [(0.0, 1), (2.9, 1), (3.0, 2), (3.6, 5), (5.5, 5), (9.0, 5)] {
            assert_eq!(tree.find(place), expected, "{place}");
        }
        // Beyond the first leaves.
        tree.set_pair(40, [1.0, 4.0]);
        tree.set_pair(0, [0.25, 0.0]);
        assert!((tree.total() - 7.75).abs() < 1e-15);
        for (place, expected) in [(0.2, 0), (0.25, 2), (1.0, 5), (2.75, 80), (3.75, 81)] {
            assert_eq!(tree.find(place), expected, "{place}");
        }
        assert!((SumTree::new(&[]).total() - 0.0).abs() < 1e-15);
    }
}
