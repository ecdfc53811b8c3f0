use sphvar_samplers::{CcvtParameters, MassPoints, Pattern, PoissonDiskParameters};

/// A pattern of the thesis, with the same colour and name in every figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ThesisPattern {
    /// Independent directions.
    WhiteNoise,
    /// One direction in each HEALPix pixel.
    Jittered,
    /// Exactly N directions, no two nearer than the chord of the program of the thesis.
    PoissonDisk,
    /// Capacity-constrained Voronoi tessellations with random mass points.
    CcvtRandom,
    /// Capacity-constrained Voronoi tessellations of the mass points of a Fibonacci lattice.
    CcvtFibonacci,
    /// HEALPix centres.
    Healpix,
    /// The spherical Fibonacci lattice.
    Fibonacci,
}

/// The number of mass points of a site of CCVT, which the thesis does not state.
pub(crate) const CAPACITY: usize = 64;
/// The colour of bounds.
pub(crate) const BOUND_COLOUR: usize = 6;
/// The colour of series that are neither patterns nor bounds: that of HEALPix, which never occurs
/// in the same figure.
pub(crate) const OTHER_COLOUR: usize = 4;

impl ThesisPattern {
    /// Returns the sampling pattern.
    pub(crate) fn pattern(self) -> Pattern {
        match self {
            Self::WhiteNoise => Pattern::WhiteNoise,
            Self::Jittered => Pattern::Jittered,
            Self::PoissonDisk => Pattern::PoissonDisk(PoissonDiskParameters::DEFAULT),
            Self::CcvtRandom => Self::ccvt(MassPoints::White),
            Self::CcvtFibonacci => Self::ccvt(MassPoints::Fibonacci),
            Self::Healpix => Pattern::Healpix,
            Self::Fibonacci => Pattern::FIBONACCI,
        }
    }

    fn ccvt(mass: MassPoints) -> Pattern {
        Pattern::Ccvt(CcvtParameters { capacity: CAPACITY, mass })
    }

    /// Returns whether it is one of the kinds of CCVT.
    pub(crate) const fn is_ccvt(self) -> bool {
        matches!(self, Self::CcvtRandom | Self::CcvtFibonacci)
    }

    /// Its name in claims: one for both kinds of CCVT, because the thesis has only one.
    pub(crate) const fn subject(self) -> &'static str {
        if self.is_ccvt() { "CCVT" } else { self.label() }
    }

    /// Returns the number of its colour.
    pub(crate) const fn colour(self) -> usize {
        match self {
            Self::WhiteNoise => 0,
            Self::Jittered => 1,
            Self::PoissonDisk => 2,
            Self::CcvtRandom => 3,
            Self::Healpix => 4,
            // They never occur in the same figure.
            Self::Fibonacci | Self::CcvtFibonacci => 5,
        }
    }

    /// Its entry in legends.
    pub(crate) const fn label(self) -> &'static str {
        match self {
            Self::WhiteNoise => "white noise",
            Self::Jittered => "jittered",
            Self::PoissonDisk => "Poisson disk",
            Self::CcvtRandom => "CCVT, random mass",
            Self::CcvtFibonacci => "CCVT, Fibonacci mass",
            Self::Healpix => "HEALPix regular",
            Self::Fibonacci => "Fibonacci",
        }
    }

    /// Its part of panel names.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::WhiteNoise => "white-noise",
            Self::Jittered => "jittered",
            Self::PoissonDisk => "poisson-disk",
            Self::CcvtRandom => "ccvt-random",
            Self::CcvtFibonacci => "ccvt-fibonacci",
            Self::Healpix => "healpix",
            Self::Fibonacci => "fibonacci",
        }
    }
}
