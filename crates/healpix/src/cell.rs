use crate::{Error, Nside};

/// Number of faces, the equal-area base pixels of resolution 1.
pub(crate) const N_FACES: u8 = 12;

/// A pixel given by its face and its position in the grid of that face, independent of a numbering.
///
/// Faces 0..4 touch the north pole, 4..8 lie on the equator, 8..12 touch the south pole; each row
/// is numbered eastwards. Within a face, `ix` counts from 0 towards north-east and `iy` towards
/// north-west, so `(0, 0)` is the southern corner and `(nside - 1, nside - 1)` the northern one.
/// Both pixel orders are numberings of cells, and cells implement all geometry.
///
/// # Examples
///
/// ```
/// use sphvar_healpix::{Cell, Nside};
///
/// let cell = Cell::new(Nside::new(4)?, 0, 3, 3)?;
/// assert_eq!(cell.ring(), 1);
/// assert!(Cell::new(Nside::new(4)?, 12, 0, 0).is_err());
/// # Ok::<(), sphvar_healpix::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Cell {
    nside: Nside,
    face: u8,
    ix: u32,
    iy: u32,
}

impl Cell {
    /// Returns the cell at `(ix, iy)` of `face`.
    ///
    /// # Errors
    ///
    /// [`Error::CellOutOfRange`] unless `face < 12` and `ix, iy < nside`.
    pub const fn new(nside: Nside, face: u8, ix: u32, iy: u32) -> Result<Self, Error> {
        if face < N_FACES && ix < nside.value() && iy < nside.value() {
            Ok(Self { nside, face, ix, iy })
        } else {
            Err(Error::CellOutOfRange { face, ix, iy, nside: nside.value() })
        }
    }

    /// Returns the cell with coordinates that the caller guarantees to be in range.
    #[inline]
    pub(crate) fn in_range(nside: Nside, face: u8, ix: u32, iy: u32) -> Self {
        debug_assert!(
            Self::new(nside, face, ix, iy).is_ok(),
            "face {face}, ix {ix}, iy {iy} at nside {nside}"
        );
        Self { nside, face, ix, iy }
    }

    /// Returns the resolution that the cell belongs to.
    #[inline]
    pub const fn nside(self) -> Nside {
        self.nside
    }

    /// Returns the face, 0..12.
    #[inline]
    pub const fn face(self) -> u8 {
        self.face
    }

    /// Returns the coordinate towards north-east, 0..nside.
    #[inline]
    pub const fn ix(self) -> u32 {
        self.ix
    }

    /// Returns the coordinate towards north-west, 0..nside.
    #[inline]
    pub const fn iy(self) -> u32 {
        self.iy
    }

    /// Returns the ring of the centre of the cell, from 1 at the north pole to `4 nside - 1` at the
    /// south pole.
    ///
    /// ```text
    /// ring = (2 + face / 4) nside - ix - iy - 1
    /// ```
    #[inline]
    pub const fn ring(self) -> u32 {
        // Ordered so that no intermediate result is negative: ix + iy + 1 <= 2 nside - 1. The
        // product is at most 2^31.
        (2 + self.face as u32 / 4) * self.nside.value() - (self.ix + self.iy + 1)
    }

    /// Returns the antipodal cell; no cell is its own antipode.
    ///
    /// The centre of the antipode is the negative of the centre of the cell. The same holds for all
    /// points: `(u, v)` maps to `(1 - v, 1 - u)`.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_healpix::{Cell, Nside};
    ///
    /// let cell = Cell::new(Nside::new(5)?, 6, 4, 1)?;
    /// assert!((cell.centre() + cell.antipode().centre()).length() < 1e-15);
    /// assert_eq!(cell.antipode().antipode(), cell);
    /// # Ok::<(), sphvar_healpix::Error>(())
    /// ```
    #[inline]
    pub const fn antipode(self) -> Self {
        let opposite_column = (self.face % 4 + 2) % 4;
        let last = self.nside.value() - 1;
        Self {
            nside: self.nside,
            // Rows 0 and 2 are exchanged.
            face: (8 - self.face / 4 * 4) + opposite_column,
            ix: last - self.iy,
            iy: last - self.ix,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_checked() {
        let nside = Nside::new(3).unwrap();
        assert!(Cell::new(nside, 11, 2, 2).is_ok());
        for (face, ix, iy) in [(12, 0, 0), (0, 3, 0), (0, 0, 3), (255, u32::MAX, u32::MAX)] {
            assert_eq!(
                Cell::new(nside, face, ix, iy),
                Err(Error::CellOutOfRange { face, ix, iy, nside: 3 })
            );
        }
    }

    #[test]
    fn rings_end_at_the_poles() {
        for n in [1, 2, 5, Nside::MAX] {
            let nside = Nside::new(n).unwrap();
            assert_eq!(Cell::new(nside, 0, n - 1, n - 1).unwrap().ring(), 1);
            assert_eq!(Cell::new(nside, 8, 0, 0).unwrap().ring(), nside.n_rings());
        }
    }
}
