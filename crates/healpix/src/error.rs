use thiserror::Error;

/// Error for an invalid argument.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// The resolution parameter is zero or above 2^29.
    #[error("nside {nside} is out of range: it must be from 1 to {max}")]
    NsideOutOfRange {
        /// The value given.
        nside: u32,
        /// The maximum value.
        max: u32,
    },

    /// Nested order was requested for a resolution that is not a power of two.
    #[error(
        "nested order requires nside to be a power of two, got {nside}; \
         the nearest are {below} and {above}; ring order supports any nside"
    )]
    NotPowerOfTwo {
        /// The value given.
        nside: u32,
        /// The largest power of two below it.
        below: u32,
        /// The smallest power of two above it.
        above: u32,
    },

    /// The count is not `12 nside^2` for any valid nside.
    #[error(
        "{n_pixels} is not a HEALPix pixel count 12 nside^2; the nearest valid count is {nearest} (nside {nside})"
    )]
    NotPixelCount {
        /// The count given.
        n_pixels: u64,
        /// The nearest valid count.
        nearest: u64,
        /// The nside of that count.
        nside: u32,
    },

    /// A pixel index is not below the number of pixels.
    #[error("pixel {pixel} is out of range: the grid has {n_pixels} pixels, numbered from 0")]
    PixelOutOfRange {
        /// The index given.
        pixel: u64,
        /// The number of pixels of the grid.
        n_pixels: u64,
    },

    /// A ring index is zero or above `4 nside - 1`.
    #[error("ring {ring} is out of range: rings are numbered from 1 (north) to {n_rings} (south)")]
    RingOutOfRange {
        /// The index given.
        ring: u32,
        /// The number of rings of the grid.
        n_rings: u32,
    },

    /// The face or the coordinates within the face do not exist at this resolution.
    #[error(
        "cell (face {face}, ix {ix}, iy {iy}) does not exist: face must be below 12, ix and iy below nside {nside}"
    )]
    CellOutOfRange {
        /// The face given.
        face: u8,
        /// The north-east coordinate given.
        ix: u32,
        /// The north-west coordinate given.
        iy: u32,
        /// The resolution.
        nside: u32,
    },

    /// The colatitude is outside `[0, pi]` or NaN.
    #[error("colatitude theta = {theta} is out of range: it must be from 0 to pi radians")]
    ThetaOutOfRange {
        /// The value given.
        theta: f64,
    },

    /// The longitude is infinite or NaN.
    #[error("longitude phi = {phi} is not finite: any finite angle in radians is accepted")]
    PhiNotFinite {
        /// The value given.
        phi: f64,
    },

    /// The vector has no direction: it is zero, infinite or NaN.
    #[error("({x}, {y}, {z}) has no direction: a finite vector other than zero is needed")]
    NoDirection {
        /// Its first component.
        x: f64,
        /// Its second component.
        y: f64,
        /// Its third component.
        z: f64,
    },
}
