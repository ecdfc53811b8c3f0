/// The end of a chain.
const NONE: u32 = u32::MAX;

/// Points in the cells of a grid: each cell is the head of a chain of its points.
///
/// Memory: 4 bytes per cell and 8 per point beside the point itself.
#[derive(Debug)]
pub(super) struct Chains<P> {
    heads: Vec<u32>,
    nodes: Vec<Node<P>>,
}

#[derive(Clone, Copy, Debug)]
struct Node<P> {
    point: P,
    next: u32,
}

impl<P: Copy> Chains<P> {
    /// Returns empty chains of `n_cells` cells.
    pub(super) fn new(n_cells: usize) -> Self {
        Self { heads: vec![NONE; n_cells], nodes: Vec::new() }
    }

    /// Inserts a point into the cell of that index.
    #[inline]
    pub(super) fn insert(&mut self, cell: u32, point: P) {
        let head = &mut self.heads[cell as usize];
        let node = Node { point, next: *head };
        // The number of points is limited to a quarter of what u32 counts.
        #[expect(clippy::cast_possible_truncation, reason = "fewer than 2^32 nodes")]
        let index = self.nodes.len() as u32;
        *head = index;
        self.nodes.push(node);
    }

    /// Returns the points of the cell of that index, the last inserted first.
    #[inline]
    pub(super) fn points(&self, cell: u32) -> impl Iterator<Item = P> {
        let mut at = self.heads[cell as usize];
        std::iter::from_fn(move || {
            let node = self.nodes.get(at as usize)?;
            at = node.next;
            Some(node.point)
        })
    }

    /// Returns how many points had been inserted before each point of the cell of that index.
    #[inline]
    pub(super) fn numbers(&self, cell: u32) -> impl Iterator<Item = u32> {
        let mut at = self.heads[cell as usize];
        std::iter::from_fn(move || {
            let number = at;
            at = self.nodes.get(at as usize)?.next;
            Some(number)
        })
    }
}
