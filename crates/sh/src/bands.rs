use std::fmt::Debug;

use crate::{ByParity, Domain, TailClasses};

/// Bands in which the spectrum of a homogeneous ensemble is constant.
///
/// An ensemble whose distribution is invariant under the motions of its space (rotations of the
/// sphere, shifts of the torus) has one mean power per band: a degree of the sphere, or a pair of
/// frequencies k and -k of the torus. Spectra, predictions, sums and tables are generic over this
/// trait:
///
/// ```text
/// Var = factor(N) sum_{bands b >= 1} multiplicity(b) <P(b)> P_F(b)
/// ```
///
/// Bands are numbered by radius from 0, the band of the constant. [`Domain`] implements the degrees
/// of the sphere and the even degrees of the hemisphere, [`Frequencies`](crate::Frequencies) the
/// pairs of frequencies of the unit square.
///
/// # Examples
///
/// ```
/// use sphvar_sh::{Bands, Domain};
///
/// assert_eq!(Domain::Sphere.multiplicity(3), 7.0);
/// assert!(!Domain::Hemisphere.has_band(3));
/// ```
pub trait Bands: Clone + Debug + PartialEq + Send + Sync {
    /// One value for each class of bands whose mean power at large radii can differ.
    type Tail: TailClasses;

    /// Returns the column heading of the band in tables: `l` for degrees.
    fn label(&self) -> &'static str;

    /// Returns whether functions of the space can have power in the band. Bands without power, such
    /// as odd degrees of the hemisphere, keep the numbering simple.
    fn has_band(&self, band: usize) -> bool;

    /// Returns the number of coefficients of the band: 2l+1 for degree l.
    fn multiplicity(&self, band: usize) -> f64;

    /// Returns the length of the frequency of the band, l for degree l; nondecreasing in `band`,
    /// and 0 only for band 0.
    fn radius(&self, band: usize) -> f64;

    /// Returns the class of the band, below [`TailClasses::COUNT`] of [`Self::Tail`]; the class of
    /// band 0 has no meaning.
    fn tail_class(&self, band: usize) -> usize;

    /// Returns the area of the space over which functions of the bands are integrated.
    fn area(&self) -> f64;

    /// Returns `factor(N)`, inversely proportional to N: 4 pi/N on the sphere.
    fn factor(&self, n_points: usize) -> f64;

    /// Returns the width in radius over which the peaks of lattices and the oscillations of random
    /// patterns of N points average out, for bands of a class: sqrt(N) on the sphere.
    fn spacing_radius(&self, class: usize, n_points: usize) -> f64;

    /// Returns whether bands of a class exist. The default implementation returns true.
    fn has_class(&self, _class: usize) -> bool {
        true
    }

    /// Returns the radius up to which bands 0 to `last` contain all bands of a class. The default
    /// implementation returns the radius of `last`.
    fn extent(&self, _class: usize, last: usize) -> f64 {
        self.radius(last)
    }
}

impl Bands for Domain {
    type Tail = ByParity;

    fn label(&self) -> &'static str {
        "l"
    }

    fn has_band(&self, band: usize) -> bool {
        self.has_degree(band)
    }

    fn multiplicity(&self, band: usize) -> f64 {
        (2 * band + 1) as f64
    }

    fn radius(&self, band: usize) -> f64 {
        band as f64
    }

    /// Coincident and antipodal points change the power of even and of odd degrees differently.
    fn tail_class(&self, band: usize) -> usize {
        band % 2
    }

    fn has_class(&self, class: usize) -> bool {
        self.has_degree(class)
    }

    fn area(&self) -> f64 {
        Self::area(*self)
    }

    fn factor(&self, n_points: usize) -> f64 {
        self.variance_factor(n_points)
    }

    fn spacing_radius(&self, _class: usize, n_points: usize) -> f64 {
        self.count_on_sphere(n_points).sqrt()
    }
}
