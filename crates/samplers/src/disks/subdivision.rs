use std::fmt::Debug;

/// Bit k of a mask of children represents child k of a cell.
pub(crate) const ALL_CHILDREN: u32 = 0b1111;

/// A domain divided into the cells of a grid, all of one area, each of which is recursively divided
/// into four children; and the centres of the disks on it, indexed by the cells of the grid.
///
/// Every point within the radius of the disks of a cell of the grid lies in that cell or in one of
/// its neighbours.
pub(crate) trait Subdivision {
    /// A point of the domain.
    type Point: Copy + Debug;
    /// The form of a point in a point set.
    type Output;
    /// The position of a cell among those of its resolution.
    type Place: Copy + Debug;
    /// The cells between which and whose children subdivision steps.
    type Resolution: Copy;
    /// A cell with the data to test whether a disk covers its children.
    type Quarters;

    /// Returns the cells of the grid, each with its index.
    fn grid_cells(&self) -> impl Iterator<Item = (Self::Place, u32)>;

    /// Returns the resolution of cells `level` subdivisions below the grid; `None` beyond the
    /// finest.
    fn resolution(&self, level: u32) -> Option<Self::Resolution>;

    /// Returns the area of a cell `level` subdivisions below the grid.
    fn cell_area(&self, level: u32) -> f64;

    /// Returns child 0 to 3 of a cell, at the next resolution.
    fn child(&self, place: Self::Place, child: u32) -> Self::Place;

    /// Returns the point at the coordinates u and v in [0, 1) of a cell, uniform if they are.
    fn point_in(
        &self,
        place: Self::Place,
        resolution: Self::Resolution,
        u: f64,
        v: f64,
    ) -> Option<Self::Point>;

    /// Returns the quarters of a cell `level` subdivisions below the grid, and the index of the
    /// grid cell that contains it.
    fn quarters(
        &self,
        place: Self::Place,
        resolution: Self::Resolution,
        level: u32,
    ) -> Option<(Self::Quarters, u32)>;

    /// Replaces the content of `near` by those of `points` whose disks can intersect the cell, in
    /// their order.
    fn select(
        &self,
        quarters: &Self::Quarters,
        points: &[Self::Point],
        near: &mut Vec<Self::Point>,
    );

    /// Returns a mask of the children that lie within one disk around one of `points`.
    fn covered(&self, quarters: &Self::Quarters, points: &[Self::Point]) -> u32;

    /// Replaces the content of `near` by the centres of all disks that can intersect the grid cell
    /// of that index, as seen from the cell: `overlap` needs no periodic images.
    fn gather(&self, grid_place: u32, near: &mut Vec<Self::Point>);

    /// Returns whether a point lies within the disk around another.
    fn overlap(&self, a: Self::Point, b: Self::Point) -> bool;

    /// Returns whether a point of the grid cell of that index lies within a disk.
    fn is_covered(&self, grid_place: u32, point: Self::Point) -> bool;

    /// Adds the disk around a point of the grid cell of that index.
    fn insert(&mut self, grid_place: u32, point: Self::Point);

    /// Returns the point in a point set: of those that the domain identifies, its representative.
    fn output(&self, point: Self::Point) -> Self::Output;
}
