use std::fmt::Debug;

use glam::DVec3;

use crate::{Cell, Error, Nside};

/// A numbering of the pixels of one resolution: [`Ring`](crate::Ring) or [`Nested`](crate::Nested).
///
/// An order implements two index maps, pixel to [`Cell`] and back; all geometry is implemented by
/// the cell. The trait is dyn-compatible.
///
/// A pixel argument must be below [`n_pixels`](Self::n_pixels); validate untrusted numbers once
/// with [`Nside::check_pixel`]. A direction argument must be a unit vector; normalize untrusted
/// vectors once with [`unit_direction`](crate::unit_direction). With valid arguments no method
/// fails.
///
/// # Examples
///
/// ```
/// use sphvar_healpix::{Nested, Nside, PixelOrder, Ring};
///
/// let nside = Nside::new(4)?;
/// let (ring, nested) = (Ring::new(nside), Nested::new(nside)?);
/// let orders: [&dyn PixelOrder; 2] = [&ring, &nested];
/// for order in orders {
///     let dir = order.centre(17);
///     assert_eq!(order.pixel(dir), 17);
/// }
/// # Ok::<(), sphvar_healpix::Error>(())
/// ```
pub trait PixelOrder: Debug + Send + Sync {
    /// Returns the resolution.
    fn nside(&self) -> Nside;

    /// Returns the cell with the number `pixel`.
    ///
    /// # Panics
    ///
    /// Panics if `pixel >= self.n_pixels()`.
    fn cell(&self, pixel: u64) -> Cell;

    /// Returns the number of `cell`.
    ///
    /// # Panics
    ///
    /// Panics if `cell` has a different resolution.
    fn pixel_of_cell(&self, cell: Cell) -> u64;

    /// Returns the number of pixels, `12 nside^2`.
    #[inline]
    fn n_pixels(&self) -> u64 {
        self.nside().n_pixels()
    }

    /// Returns the pixel that contains the unit vector `dir`; points on an edge are assigned as by
    /// [`Cell::invert_uniform_point`].
    ///
    /// # Panics
    ///
    /// Panics in debug builds if `dir` is not a unit vector. In release builds the result is then
    /// an arbitrary valid pixel.
    #[inline]
    fn pixel(&self, dir: DVec3) -> u64 {
        self.pixel_of_cell(Cell::containing(self.nside(), dir))
    }

    /// Writes the pixel that contains the unit vector `dirs[i]` to `pixels[i]`. Results equal those
    /// of [`pixel`](Self::pixel) on every machine.
    ///
    /// # Panics
    ///
    /// Panics if the slices differ in length; in debug builds also if a direction is not a unit
    /// vector.
    ///
    /// # Performance
    ///
    /// Directions are processed sixteen at a time in vector registers and the rest one by one. This
    /// takes a quarter of the time of [`pixel`](Self::pixel) with registers of 512 bits, and 40 %
    /// of it with 256 bits.
    ///
    /// # Examples
    ///
    /// ```
    /// use glam::DVec3;
    /// use sphvar_healpix::{Nside, PixelOrder, Ring};
    ///
    /// let order = Ring::new(Nside::new(4)?);
    /// let mut pixels = [0; 3];
    /// order.pixels_into(&[DVec3::X, DVec3::Y, DVec3::Z], &mut pixels);
    /// assert_eq!(pixels, [DVec3::X, DVec3::Y, DVec3::Z].map(|dir| order.pixel(dir)));
    /// # Ok::<(), sphvar_healpix::Error>(())
    /// ```
    fn pixels_into(&self, dirs: &[DVec3], pixels: &mut [u64]);

    /// Returns the pixel that contains colatitude `theta` in `[0, pi]` and longitude `phi`, any
    /// finite angle, in radians.
    ///
    /// # Errors
    ///
    /// [`Error::ThetaOutOfRange`] and [`Error::PhiNotFinite`].
    #[inline]
    fn pixel_of_angles(&self, theta: f64, phi: f64) -> Result<u64, Error> {
        Cell::containing_angles(self.nside(), theta, phi).map(|cell| self.pixel_of_cell(cell))
    }

    /// Writes the pixel that contains colatitude and longitude `angles[i]` to `pixels[i]`. Results
    /// equal those of [`pixel_of_angles`](Self::pixel_of_angles) on every machine.
    ///
    /// # Errors
    ///
    /// That of [`pixel_of_angles`](Self::pixel_of_angles) for the first invalid pair; `pixels` is
    /// then unspecified.
    ///
    /// # Panics
    ///
    /// Panics if the slices differ in length.
    ///
    /// # Performance
    ///
    /// As for [`pixels_into`](Self::pixels_into): a quarter of the time of
    /// [`pixel_of_angles`](Self::pixel_of_angles) with registers of 512 bits.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_healpix::{Nside, PixelOrder, Ring};
    ///
    /// let order = Ring::new(Nside::new(4)?);
    /// let mut pixels = [0; 2];
    /// order.pixels_of_angles_into(&[[0.0, 0.0], [1.5, -3.0]], &mut pixels)?;
    /// assert_eq!(pixels, [order.pixel_of_angles(0.0, 0.0)?, order.pixel_of_angles(1.5, -3.0)?]);
    /// assert!(order.pixels_of_angles_into(&[[0.0, f64::NAN]], &mut pixels[..1]).is_err());
    /// # Ok::<(), sphvar_healpix::Error>(())
    /// ```
    fn pixels_of_angles_into(&self, angles: &[[f64; 2]], pixels: &mut [u64]) -> Result<(), Error>;

    /// Returns the direction of the pixel's centre.
    ///
    /// # Panics
    ///
    /// Panics if `pixel >= self.n_pixels()`.
    #[inline]
    fn centre(&self, pixel: u64) -> DVec3 {
        self.cell(pixel).centre()
    }

    /// Returns the colatitude and the longitude of the pixel's centre in radians.
    ///
    /// # Panics
    ///
    /// Panics if `pixel >= self.n_pixels()`.
    #[inline]
    fn centre_angles(&self, pixel: u64) -> (f64, f64) {
        self.cell(pixel).centre_angles()
    }

    /// Returns the direction at `(u, v)` in the pixel, by the area-preserving map of
    /// [`Cell::uniform_point`].
    ///
    /// # Panics
    ///
    /// Panics if `pixel >= self.n_pixels()`; in debug builds also if `u` or `v` is outside
    /// `[0, 1]`.
    #[inline]
    fn uniform_point(&self, pixel: u64, u: f64, v: f64) -> DVec3 {
        self.cell(pixel).uniform_point(u, v)
    }

    /// Returns the density of [`uniform_point`](Self::uniform_point) per steradian, the reciprocal
    /// of the area of a pixel.
    #[inline]
    fn uniform_point_pdf(&self) -> f64 {
        1.0 / self.nside().pixel_area()
    }

    /// Returns the pixel that contains `dir` and the coordinates `(u, v)` in `[0, 1)` of `dir`
    /// within it, by [`Cell::invert_uniform_point`].
    ///
    /// # Panics
    ///
    /// Panics in debug builds if `dir` is not a unit vector.
    #[inline]
    fn invert_uniform_point(&self, dir: DVec3) -> (u64, f64, f64) {
        let (cell, u, v) = Cell::invert_uniform_point(self.nside(), dir);
        (self.pixel_of_cell(cell), u, v)
    }

    /// Returns the directions of the northern, western, southern and eastern corner of the pixel.
    ///
    /// # Panics
    ///
    /// Panics if `pixel >= self.n_pixels()`.
    fn corners(&self, pixel: u64) -> [DVec3; 4] {
        self.cell(pixel).corners()
    }

    /// Returns the neighbours of the pixel towards SW, W, NW, N, NE, E, SE, S; entries are `None`
    /// as in [`Cell::neighbours`].
    ///
    /// # Panics
    ///
    /// Panics if `pixel >= self.n_pixels()`.
    fn neighbours(&self, pixel: u64) -> [Option<u64>; 8] {
        self.cell(pixel).neighbours().map(|cell| cell.map(|cell| self.pixel_of_cell(cell)))
    }

    /// Returns the antipodal pixel, which is never the pixel itself.
    ///
    /// # Panics
    ///
    /// Panics if `pixel >= self.n_pixels()`.
    #[inline]
    fn antipode(&self, pixel: u64) -> u64 {
        self.pixel_of_cell(self.cell(pixel).antipode())
    }
}

/// Panics unless the grid has the pixel; the only check of the index maps, as in slice indexing.
#[inline]
pub(crate) fn assert_pixel(nside: Nside, pixel: u64) {
    assert!(
        pixel < nside.n_pixels(),
        "pixel {pixel} is out of range: nside {nside} has {} pixels",
        nside.n_pixels()
    );
}

/// Panics unless the cell belongs to the grid.
#[inline]
pub(crate) fn assert_resolution(nside: Nside, cell: Cell) {
    assert!(
        cell.nside() == nside,
        "a cell of nside {} was passed to an order of nside {nside}",
        cell.nside()
    );
}
