use sphvar_samplers::{PoissonDiskSquareParameters, SquarePattern};

use super::patterns::ThesisPattern;
use crate::PlaneEnsemble;

/// A pattern of the unit square of chapter 4.1, with the colour of its counterpart on the sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlanePattern {
    /// Independent points.
    WhiteNoise,
    /// One point in each cell of a square grid.
    Jittered,
    /// Exactly N points, no two nearer than the disks' radius on the torus.
    PoissonDisk,
    /// The same with plain distances within the square.
    UnwrappedDisk,
    /// The centres of the cells of a square grid.
    Regular,
    /// Halton points in bases 2 and 3.
    Halton,
    /// Hammersley points in base 2.
    Hammersley,
    /// The Fibonacci lattice.
    Fibonacci,
}

impl PlanePattern {
    /// Returns sets of about `n_points` points; a Fibonacci number of them for Fibonacci lattices.
    pub(crate) fn ensemble(self, n_points: usize) -> PlaneEnsemble {
        let n_points = match self {
            Self::Fibonacci => nearest_fibonacci_number(n_points),
            _ => n_points,
        };
        PlaneEnsemble::new(self.pattern(), n_points)
    }

    fn pattern(self) -> SquarePattern {
        match self {
            Self::WhiteNoise => SquarePattern::WhiteSquare,
            Self::Jittered => SquarePattern::JitteredSquare,
            Self::PoissonDisk => Self::disks(true),
            Self::UnwrappedDisk => Self::disks(false),
            Self::Regular => SquarePattern::RegularSquare,
            Self::Halton => SquarePattern::HALTON,
            Self::Hammersley => SquarePattern::HAMMERSLEY,
            Self::Fibonacci => SquarePattern::FibonacciLattice,
        }
    }

    fn disks(is_wrapped: bool) -> SquarePattern {
        SquarePattern::PoissonDiskSquare(PoissonDiskSquareParameters {
            is_wrapped,
            ..PoissonDiskSquareParameters::DEFAULT
        })
    }

    /// Returns whether there is one set of each number of points.
    pub(crate) fn is_deterministic(self) -> bool {
        matches!(self, Self::Regular | Self::Halton | Self::Hammersley | Self::Fibonacci)
    }

    /// Returns the number of its colour.
    pub(crate) const fn colour(self) -> usize {
        match self {
            Self::WhiteNoise => ThesisPattern::WhiteNoise.colour(),
            Self::Jittered => ThesisPattern::Jittered.colour(),
            Self::PoissonDisk | Self::UnwrappedDisk => ThesisPattern::PoissonDisk.colour(),
            Self::Regular => ThesisPattern::Healpix.colour(),
            Self::Halton => 3,
            Self::Hammersley => 6,
            Self::Fibonacci => ThesisPattern::Fibonacci.colour(),
        }
    }

    /// Returns its name in titles and claims.
    pub(crate) const fn label(self) -> &'static str {
        match self {
            Self::WhiteNoise => "white noise",
            Self::Jittered => "jittered",
            Self::PoissonDisk => "Poisson disk, wrapped",
            Self::UnwrappedDisk => "Poisson disk, unwrapped",
            Self::Regular => "regular",
            Self::Halton => "Halton",
            Self::Hammersley => "Hammersley",
            Self::Fibonacci => "Fibonacci lattice",
        }
    }

    /// Returns its part of panel names.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::WhiteNoise => "white-noise",
            Self::Jittered => "jittered",
            Self::PoissonDisk => "wrapped",
            Self::UnwrappedDisk => "unwrapped",
            Self::Regular => "regular",
            Self::Halton => "halton",
            Self::Hammersley => "hammersley",
            Self::Fibonacci => "fibonacci",
        }
    }
}

fn nearest_fibonacci_number(n: usize) -> usize {
    let (mut low, mut high) = (1, 2);
    while high < n {
        (low, high) = (high, low + high);
    }
    if n.abs_diff(low) < high.abs_diff(n) { low } else { high }
}

#[cfg(test)]
mod tests {
    use super::nearest_fibonacci_number;

    #[test]
    fn fibonacci_numbers_are_nearest() {
        for (n, expected) in [(1, 1), (2, 2), (4, 5), (1024, 987), (4096, 4181), (65536, 75025)] {
            assert_eq!(nearest_fibonacci_number(n), expected, "{n}");
        }
    }
}
