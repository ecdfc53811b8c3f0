use super::subdivision::{ALL_CHILDREN, Subdivision};

/// A set of cells of one resolution that contains the region that disks leave free.
#[derive(Debug)]
pub(crate) struct FreeRegion<S: Subdivision> {
    pub(crate) space: S,
    front: Vec<S::Place>,
    level: u32,
}

/// The children of a cell that no single disk covers.
#[derive(Debug)]
pub(crate) struct LiveChildren<'a, S: Subdivision> {
    pub(crate) children: &'a [S::Place],
    pub(crate) resolution: S::Resolution,
    /// The centres of all disks that can intersect the cell.
    pub(crate) near: &'a [S::Point],
    /// The index of the grid cell that contains them.
    pub(crate) grid_place: u32,
}

impl<S: Subdivision> FreeRegion<S> {
    /// Returns the region of all cells of the grid.
    pub(crate) fn whole(space: S) -> Self {
        let front = space.grid_cells().map(|(place, _)| place).collect();
        Self { space, front, level: 0 }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.front.is_empty()
    }

    /// Returns whether the cells have the finest resolution.
    pub(crate) fn is_finest(&self) -> bool {
        self.space.resolution(self.level + 1).is_none()
    }

    /// Returns the area of the cells.
    pub(crate) fn area(&self) -> f64 {
        self.front.len() as f64 * self.space.cell_area(self.level)
    }

    /// Divides the cells, drops the children that one disk covers, and calls `each` for the others
    /// of every cell, in order.
    pub(crate) fn refine(&mut self, mut each: impl FnMut(&S, &LiveChildren<'_, S>)) {
        let space = &self.space;
        let resolutions = (space.resolution(self.level), space.resolution(self.level + 1));
        let (Some(coarse), Some(fine)) = resolutions else { return };
        let mut children = Vec::with_capacity(2 * self.front.len());
        let (mut around, mut near, mut near_place) = (Vec::new(), Vec::new(), None);
        for &place in &self.front {
            let Some((quarters, grid_place)) = space.quarters(place, coarse, self.level) else {
                continue;
            };
            // Cells of one grid cell are consecutive.
            if near_place != Some(grid_place) {
                near_place = Some(grid_place);
                space.gather(grid_place, &mut around);
            }
            space.select(&quarters, &around, &mut near);
            let live = ALL_CHILDREN & !space.covered(&quarters, &near);
            if live == 0 {
                continue;
            }
            let (mut live_children, mut rest) = ([place; 4], live);
            let live_children = &mut live_children[..live.count_ones() as usize];
            for child in &mut *live_children {
                *child = space.child(place, rest.trailing_zeros());
                rest &= rest - 1;
            }
            children.extend_from_slice(live_children);
            let (children, near) = (&*live_children, &*near);
            each(space, &LiveChildren { children, resolution: fine, near, grid_place });
        }
        self.front = children;
        self.level += 1;
    }
}
