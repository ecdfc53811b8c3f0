mod density;
mod nodes;
mod rings;
mod square;
mod zonal_product;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use sphvar_sh::Domain;
use sphvar_sh::{Alm, ByParity};

use self::nodes::Node;
pub(crate) use self::zonal_product::ZonalProduct;
use crate::{Circle, Coefficients, Error, Integrand, Shape, quadrature};

/// An equirectangular map of a scalar with W = 2H texels per row, such as the incident light by
/// direction.
///
/// Row 0 is at the north pole; texel (row i, column j) has its centre at theta = pi (i + 1/2)/H,
/// phi = `first_longitude` + 2 pi (j + 1/2)/W, with 0 for the first unless
/// [`with_first_longitude`](Self::with_first_longitude) sets another value. Columns run eastwards,
/// as in a map of the Earth; [`from_picture`](Self::from_picture) accepts pictures, in which they
/// run westwards. Between centres the map is bilinear in (theta, phi), wrapped in phi and constant
/// in theta beyond the first and last row.
///
/// Integral and energies are those of this bilinear function, not of its texels as samples: the
/// Fourier integral over phi is exact in closed form, the integral over theta is Gauss-Legendre
/// quadrature on the intervals between rows, where the integrand is smooth.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    height: usize,
    width: usize,
    texels: Vec<f64>,
    /// The longitude of the left edge of column 0.
    first_longitude: f64,
}

impl EnvironmentMap {
    /// Returns the map of `height` rows of `width` texels, row by row from the north pole.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] unless width = 2 height > 0, [`Error::TexelCount`] and [`Error::Texel`] for
    /// texels that are missing or not finite.
    pub fn new(width: usize, height: usize, texels: Vec<f64>) -> Result<Self, Error> {
        if height == 0 || width != 2 * height {
            return Err(Error::Shape { width, height });
        }
        Self::check_texels(width, height, &texels)?;
        Ok(Self { height, width, texels, first_longitude: 0.0 })
    }

    /// Checks the number of texels and that all are finite.
    pub(crate) fn check_texels(width: usize, height: usize, texels: &[f64]) -> Result<(), Error> {
        if width.checked_mul(height) != Some(texels.len()) {
            return Err(Error::TexelCount { width, height, got: texels.len() });
        }
        match texels.iter().position(|x| !x.is_finite()) {
            Some(i) => Err(Error::Texel { row: i / width, column: i % width, value: texels[i] }),
            None => Ok(()),
        }
    }

    /// Returns the map with the left edge of its first column at another longitude, in radians.
    #[must_use]
    pub fn with_first_longitude(self, first_longitude: f64) -> Self {
        Self { first_longitude, ..self }
    }

    /// Returns the number of texels in a row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Returns the texels, row by row from the north pole.
    #[must_use]
    pub fn texels(&self) -> &[f64] {
        &self.texels
    }

    /// Returns the longitude of the left edge of the first column, in radians.
    #[must_use]
    pub fn first_longitude(&self) -> f64 {
        self.first_longitude
    }

    /// Returns the coefficients `F_lm` of the map on the sphere, or of its upper half alone, to
    /// degree `lmax`.
    ///
    /// Cost: a transform of `lmax` rings, and some 64 operations for each order and each of about
    /// `H (12 + lmax/H)` rings.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if `lmax` is out of range or memory is exhausted.
    pub fn alm(&self, domain: Domain, lmax: usize) -> Result<Alm, Error> {
        self.alm_of_nodes(&self.nodes(domain, lmax)?, lmax)
    }

    /// Returns the coefficients to degree `lmax` of the map with the weights of nodes over theta.
    fn alm_of_nodes(&self, nodes: &[Node], lmax: usize) -> Result<Alm, Error> {
        rings::coefficients(self, nodes, lmax)
    }

    /// `int F` and `int F^2` over the domain.
    fn integrals(&self, domain: Domain) -> (f64, f64) {
        let Ok(nodes) = self.nodes(domain, 2) else {
            return (f64::NAN, f64::NAN);
        };
        let rows: Vec<RowIntegrals> = (0..self.height).map(|i| self.row_integrals(i)).collect();
        nodes.iter().fold((0.0, 0.0), |(integral, square), node| {
            let ((i, j), t) = (node.rows, node.share);
            let s = 1.0 - t;
            // The mixed product is that of a row and the next; beyond the ends both are the same
            // row.
            let mixed = if i == j { rows[i].square } else { rows[i].with_next };
            let value = s * rows[i].value + t * rows[j].value;
            let product = s * s * rows[i].square + 2.0 * s * t * mixed + t * t * rows[j].square;
            (integral + node.weight * value, square + node.weight * product)
        })
    }

    fn row_integrals(&self, i: usize) -> RowIntegrals {
        let row = self.row(i);
        let next = self.row((i + 1).min(self.height - 1));
        let texel = TAU / self.width as f64;
        let product = |a: &[f64], b: &[f64]| -> f64 {
            let terms = (0..self.width).map(|j| {
                let k = (j + 1) % self.width;
                (a[j] * b[j] + a[k] * b[k]) / 3.0 + (a[j] * b[k] + a[k] * b[j]) / 6.0
            });
            texel * terms.sum::<f64>()
        };
        RowIntegrals {
            value: texel * row.iter().sum::<f64>(),
            square: product(row, row),
            with_next: product(row, next),
        }
    }

    /// Returns the texel at the antipode of a texel. The even and the odd part of a map are maps,
    /// because the antipode of a texel's centre is a texel's centre.
    fn opposite(&self, k: usize) -> f64 {
        let (row, column) = (k / self.width, k % self.width);
        let across = (column + self.width / 2) % self.width;
        self.texels[(self.height - 1 - row) * self.width + across]
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.texels[i * self.width..(i + 1) * self.width]
    }
}

/// Integrals over phi along the centre of a row.
struct RowIntegrals {
    value: f64,
    square: f64,
    /// The integral of the product with the next row.
    with_next: f64,
}

impl Integrand for EnvironmentMap {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "texel coordinates are clamped to the map"
    )]
    fn eval(&self, dir: DVec3) -> f64 {
        let theta = dir.x.hypot(dir.y).atan2(dir.z);
        let turns = (dir.y.atan2(dir.x) - self.first_longitude) / TAU;
        let y = (theta / PI * self.height as f64 - 0.5).clamp(0.0, (self.height - 1) as f64);
        let x = (turns - turns.floor()) * self.width as f64 - 0.5;
        let (i, j) = (y as usize, x.floor());
        let (fy, fx) = (y - i as f64, x - j);
        // j is -1 left of the first centre, where the map wraps.
        let left = if j < 0.0 { self.width - 1 } else { j as usize % self.width };
        let right = (left + 1) % self.width;
        let at = |i: usize| {
            let row = self.row(i.min(self.height - 1));
            row[left] + fx * (row[right] - row[left])
        };
        let (above, below) = (at(i), at(i + 1));
        above + fy * (below - above)
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        Some(self.integrals(domain).0)
    }

    fn environment_map(&self) -> Option<&EnvironmentMap> {
        Some(self)
    }

    /// Edges are the rows and columns of texel centres.
    fn shape(&self) -> Result<Shape, Error> {
        let row =
            |i: usize| Circle { axis: DVec3::Z, angle: PI * (i as f64 + 0.5) / self.height as f64 };
        // The column at 180 degrees from it lies on the same great circle.
        let column = |j: usize| {
            let phi = self.first_longitude + TAU * (j as f64 + 0.5) / self.width as f64;
            let (sin, cos) = phi.sin_cos();
            Circle { axis: DVec3::new(-sin, cos, 0.0), angle: FRAC_PI_2 }
        };
        let rows = (0..self.height).map(row);
        let edges = rows.chain((0..self.width / 2).map(column));
        // Between them the map is bilinear in the angles, which resolves like a polynomial of some
        // degree.
        Ok(edges.fold(Shape::smooth(4), Shape::with_edge))
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        // The mean is known without a transform.
        let part = match lmax {
            0 => Coefficients::zonal(DVec3::Z, vec![self.integrals(domain).0 / (4.0 * PI).sqrt()])?,
            _ => Coefficients::general(self.alm(domain, lmax)?),
        };
        Ok(if domain == Domain::Sphere { part } else { part.even_extension() })
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        let mean = self.integrals(domain).0 / domain.area();
        let square = |value: &dyn Fn(usize) -> f64| {
            let texels = (0..self.texels.len()).map(value).collect();
            Self { texels, ..*self }.integrals(domain).1
        };
        if domain == Domain::Hemisphere {
            return Ok(ByParity { even: 2.0 * square(&|k| self.texels[k] - mean), odd: 0.0 });
        }
        Ok(ByParity {
            even: square(&|k| 0.5 * ((self.texels[k] - mean) + (self.opposite(k) - mean))),
            odd: square(&|k| 0.5 * (self.texels[k] - self.opposite(k))),
        })
    }

    fn squared_parts(&self, lmax: usize) -> Result<[Coefficients; 2], Error> {
        let part = |sign: f64| {
            let texel = |k: usize| 0.5 * (self.texels[k] + sign * self.opposite(k));
            let texels = (0..self.texels.len()).map(texel).collect();
            Self { texels, ..*self }.square(lmax)
        };
        Ok([part(1.0)?, part(-1.0)?])
    }

    /// Computed from four values between every four texel centres; within 3 % of the exact moments.
    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        // The Gauss-Legendre nodes on [0, 1].
        let nodes = [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()];
        let step = PI / self.height as f64;
        let end = if domain == Domain::Sphere { PI } else { FRAC_PI_2 };
        let values = || {
            let rows = (0..self.height).flat_map(move |i| nodes.map(|share| (i, share)));
            rows.filter_map(move |(i, share)| {
                let theta = step * (i as f64 + 0.5 + share);
                (theta < end).then(|| {
                    (theta.sin(), share, self.row(i), self.row((i + 1).min(self.height - 1)))
                })
            })
            .flat_map(move |(weight, share, row, next)| {
                let at = move |j: usize| row[j] + share * (next[j] - row[j]);
                (0..self.width).flat_map(move |j| {
                    let (left, right) = (at(j), at((j + 1) % self.width));
                    nodes.map(|x| (weight, left + x * (right - left)))
                })
            })
        };
        quadrature::weighted_kurtosis(values)
    }

    /// Returns that of the texels; those of finer maps count as features of 0.1 degrees, and narrower ones
    /// may be missed.
    fn feature_degree(&self) -> Option<usize> {
        Some(self.width.min(quadrature::MAX_FEATURE_DEGREE))
    }

    fn energy_seconds(&self, _domain: Domain, lmax: usize) -> f64 {
        let (rows, degrees) = (self.height as f64, lmax as f64);
        (12.0 * rows + 0.8 * degrees) * degrees * (0.3e-9 * degrees + 10e-9)
    }

    /// Returns four degrees per texel, and at least 1024: the map is smooth between centres and has
    /// kinks across them, whose energy falls as l^-3 from about l = width/2.
    fn resolved_degree(&self) -> Option<usize> {
        Some((4 * self.width).max(1024))
    }
}
