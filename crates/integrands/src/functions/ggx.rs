use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_sh::{ByParity, Domain};

use super::closed_form::{ClosedForm, from_closed_form};
use crate::definition::Definition;
use crate::quadrature::{self, AdaptiveCells, Cell, Patch, PatchNode};
use crate::{Circle, Coefficients, Error, Integrand, IntegrandResolver, Shape};

/// The specular lobe of a rough surface with normal +z: the BRDF of the GGX (Trowbridge-Reitz)
/// distribution of microfacets times the cosine, as a function of the incident direction i, for a
/// fixed view direction o and a Fresnel reflectance of 1.
///
/// The view direction is in the xz-plane on the side of +x, so the lobe leans towards -x. With the
/// half vector `h = (i + o)/|i + o|` and alpha = roughness^2,
///
/// ```text
/// f(i) = D(h) G2(i, o)/(4 cos o) for z > 0, else 0
/// D(h) = alpha^2/(pi (1 + (alpha^2 - 1) h_z^2)^2)
/// G2 = 1/(1 + L(i) + L(o)),   L(v) = (sqrt(1 + alpha^2 tan^2 v) - 1)/2
/// ```
///
/// where G2 is the height-correlated masking and shadowing of Smith (Walter et al. 2007, equations
/// 20 and 33; Heitz 2014, equation 99). The integral is the directional albedo, at most 1: the
/// energy that a single reflection keeps. The value falls linearly to 0 at the horizon.
///
/// All results come from rules in the coordinates of half vectors, bisected until they are exact to
/// rounding: some 10^5 values for the integral and the square, and about lmax^2 more for
/// coefficients; views along the normal, which are zonal, take lmax.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{Domain, GgxLobe, Integrand};
///
/// // The albedo for alpha = 1 and a view along the normal is 1 - ln 2.
/// let lobe = GgxLobe::new(1.0, 0.0)?;
/// let albedo = lobe.exact(Domain::Hemisphere).unwrap();
/// assert!((albedo - (1.0 - 2f64.ln())).abs() < 1e-14);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct GgxLobe {
    surface: Surface,
    cells: AdaptiveCells,
    /// `int f`.
    integral: f64,
    /// `int (f - mean)^2` over the hemisphere.
    variation: f64,
}

/// Roughness and view.
#[derive(Clone, Copy, Debug)]
struct Surface {
    alpha: f64,
    /// The angle between the view and the normal, radians.
    view: f64,
    sin_view: f64,
    cos_view: f64,
}

/// Half vectors whose ring about the normal reflects the view above the horizon everywhere.
const WHOLE_RINGS: usize = 0;
/// Half vectors whose ring the horizon cuts.
const CUT_RINGS: usize = 1;

impl GgxLobe {
    /// The smallest roughness, a lobe of about 10^-4 degrees.
    pub const MIN_ROUGHNESS: f64 = 1e-3;

    /// Returns the lobe of a roughness in [0.001, 1] for a view direction at `view_degrees` in [0,
    /// 90) from the normal.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the ranges; roughness 0 is a mirror, whose lobe is a Dirac mass.
    pub fn new(roughness: f64, view_degrees: f64) -> Result<Self, Error> {
        if !(Self::MIN_ROUGHNESS..=1.0).contains(&roughness) {
            let range = "in [0.001, 1] (0 is a mirror: a Dirac mass, of infinite variance)";
            return Err(Error::Parameter { name: "roughness", range, got: roughness });
        }
        if !(0.0..90.0).contains(&view_degrees) {
            let range = "in [0, 90) degrees";
            return Err(Error::Parameter { name: "view", range, got: view_degrees });
        }
        let view = view_degrees.to_radians();
        let (sin_view, cos_view) = view.sin_cos();
        let surface = Surface { alpha: roughness * roughness, view, sin_view, cos_view };
        let cells = AdaptiveCells::new(&surface, surface.first_cells())?;
        let integral = cells.sum(&surface, |node| node.value)?;
        let mean = integral / Domain::Hemisphere.area();
        let variation = cells.sum(&surface, |node| (node.value - mean).powi(2))?;
        Ok(Self { surface, cells, integral, variation })
    }

    fn is_zonal(&self) -> bool {
        self.surface.view == 0.0
    }
}

impl Surface {
    /// Returns the value for an incident direction of height `z > 0` and for a half vector with the
    /// given square of the tangent of its angle to the normal.
    fn value(&self, z: f64, tangent_square: f64) -> f64 {
        let square = self.alpha * self.alpha;
        let density = square * ((1.0 + tangent_square) / (square + tangent_square)).powi(2) / PI;
        // cos v (1 + 2 L(v)); the cosines of G2/(4 cos o) cancel.
        let masking = |cos: f64, sin_square: f64| (cos * cos + square * sin_square).sqrt();
        let view = masking(self.cos_view, self.sin_view * self.sin_view);
        let incident = masking(z, (1.0 - z) * (1.0 + z));
        density * z / (2.0 * (view * z + incident * self.cos_view))
    }

    /// Returns the coordinate `asinh(tan(angle)/alpha)` of a half vector, in which the distribution
    /// is analytic in a strip of half-width pi/2 for every alpha.
    fn coordinate(&self, angle: f64) -> f64 {
        (angle.tan() / self.alpha).asinh()
    }

    /// Returns the coordinates between which the horizon cuts rings of half vectors.
    fn cut(&self) -> [f64; 2] {
        [FRAC_PI_2 - self.view, FRAC_PI_2 + self.view].map(|twice| self.coordinate(0.5 * twice))
    }

    /// Returns the largest longitude at which a half vector, at half of `twice` from the normal,
    /// reflects the view above the horizon: an angle of the triangle of normal, view and reflected
    /// direction by its halves, which avoids cancellation.
    fn half_width(&self, twice: f64) -> f64 {
        let half_sin = |x: f64| (0.5 * x).sin();
        let (difference, sum) = (twice - self.view, twice + self.view);
        let below = half_sin(FRAC_PI_2 + difference) * half_sin(FRAC_PI_2 - difference);
        let above = half_sin(sum + FRAC_PI_2) * half_sin(sum - FRAC_PI_2);
        2.0 * below.max(0.0).sqrt().atan2(above.max(0.0).sqrt())
    }

    /// Returns the degree that resolves a width of the lobe.
    ///
    /// Poles at a distance d from the half vectors make coefficients fall as `e^{-2 d l}`.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, and brought into range"
    )]
    fn degree(width: f64) -> usize {
        /// `-ln` of rounding, with a margin for the algebraic factors of the coefficients.
        const DIGITS: f64 = 50.0;
        (0.5 * DIGITS / width).min(1e15).ceil() as usize + 24
    }

    fn first_cells(&self) -> Vec<Cell> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "coordinates are at most 40"
        )]
        let split = |panel: usize, range: [f64; 2], coordinates: f64| {
            let n = coordinates.ceil() as usize;
            let at = move |i: usize| range[0] + (range[1] - range[0]) * i as f64 / n as f64;
            (0..n).map(move |i| Cell { panel, u: [at(i), at(i + 1)], v: [0.0, 1.0] })
        };
        let [from, to] = self.cut();
        let whole = split(WHOLE_RINGS, [0.0, from], from);
        whole.chain(split(CUT_RINGS, [0.0, 1.0], to - from)).collect()
    }
}

/// u is the coordinate of the half vector's angle to the normal, v the share of the half circle of
/// its longitude; areas count both halves.
impl Patch for Surface {
    fn node(&self, panel: usize, u: f64, v: f64) -> PatchNode {
        let is_cut = panel == CUT_RINGS;
        let (coordinate, du) = if is_cut {
            // Longitudes begin and end with square roots, which this makes analytic.
            let [from, to] = self.cut();
            let (sin, cos) = (FRAC_PI_2 * u).sin_cos();
            (from + (to - from) * sin * sin, (to - from) * PI * sin * cos)
        } else {
            (u, 1.0)
        };
        let tangent = self.alpha * coordinate.sinh();
        let cos_square = 1.0 / (1.0 + tangent * tangent);
        let (cos, sin) = (cos_square.sqrt(), tangent * cos_square.sqrt());
        let twice = 2.0 * tangent.atan();
        let width = if is_cut { self.half_width(twice) } else { PI };
        let (sin_phi, cos_phi) = (width * v).sin_cos();
        let toward = self.cos_view * cos + self.sin_view * sin * cos_phi;
        // The height of the reflected direction as a product of positive factors, because values
        // are proportional to it.
        let slope = self.sin_view * 2.0 * sin * cos;
        let height = if is_cut {
            let half = 0.5 * width;
            slope * 2.0 * (half * (1.0 + v)).sin() * (half * (1.0 - v)).sin()
        } else {
            let above = (FRAC_PI_2 - self.view - twice).sin();
            above + slope * 2.0 * (0.5 * width * v).cos().powi(2)
        };
        let across = 2.0 * toward * sin;
        let dir = DVec3::new(across * cos_phi - self.sin_view, across * sin_phi, height);
        // d(angle)/d(coordinate), and 4 cos(o, h) from half vectors to directions.
        let slope = self.alpha * coordinate.cosh() * cos_square;
        let area = 4.0 * toward * sin * slope * du * 2.0 * width;
        PatchNode { dir: dir.normalize(), area, value: self.value(height, tangent * tangent) }
    }
}

impl ClosedForm for GgxLobe {
    fn sphere_integral(&self) -> Option<f64> {
        Some(self.integral)
    }

    /// Both parts have half the values above the horizon and, up to the sign, below it.
    fn sphere_centred_square(&self) -> Result<ByParity, Error> {
        let mean_square = self.integral * self.integral / Domain::Hemisphere.area();
        let even = 0.5 * self.variation;
        Ok(ByParity { even, odd: even + 0.5 * mean_square })
    }

    fn sphere_coefficients(&self, lmax: usize) -> Result<Coefficients, Error> {
        let (cells, surface) = (&self.cells, &self.surface);
        if self.is_zonal() {
            return quadrature::zonal_coefficients_of_nodes(lmax, |add| {
                cells.for_each(surface, lmax, false, |node| add(node.dir, node.area * node.value))
            });
        }
        quadrature::coefficients_of_nodes(lmax, |add| {
            cells.for_each(surface, lmax, true, |node| {
                let half = 0.5 * node.area * node.value;
                add(node.dir, half);
                add(DVec3::new(node.dir.x, -node.dir.y, node.dir.z), half);
            })
        })
    }
}

impl Integrand for GgxLobe {
    /// Accurate to some 1e-16/alpha, the rounding of directions, relative to the peak.
    fn eval(&self, dir: DVec3) -> f64 {
        if dir.z <= 0.0 {
            return 0.0;
        }
        let Surface { sin_view, cos_view, .. } = self.surface;
        let half = dir + DVec3::new(sin_view, 0.0, cos_view);
        let tangent_square = (half.x * half.x + half.y * half.y) / (half.z * half.z);
        self.surface.value(dir.z, tangent_square)
    }

    /// The degree is that of the smallest width of the lobe: that across the plane of view at the
    /// horizon.
    fn shape(&self) -> Result<Shape, Error> {
        let Surface { alpha, cos_view, .. } = self.surface;
        // For alpha = 1 the distribution is constant.
        let across = if alpha < 1.0 { cos_view } else { 1.0 };
        let degree = Surface::degree(alpha * across);
        let mut shape = Shape::smooth(degree).with_edge(Circle::EQUATOR);
        // The value at grazing views has a pole at z = -cos(view), close to the horizon. Panels as
        // wide as their distance from it resolve it.
        let mut height = cos_view;
        while height < alpha {
            shape = shape.with_edge(Circle { axis: DVec3::Z, angle: height.acos() });
            height *= 3.0;
        }
        let shape = shape.within(Circle::EQUATOR);
        Ok(if self.is_zonal() { shape.zonal(DVec3::Z) } else { shape })
    }

    from_closed_form!();

    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        let mut nodes = Vec::new();
        self.cells
            .for_each(&self.surface, 0, true, |node| nodes.push((node.area, node.value)))
            .ok()?;
        if domain == Domain::Sphere {
            nodes.push((Domain::Hemisphere.area(), 0.0));
        }
        quadrature::weighted_kurtosis(|| nodes.iter().copied())
    }

    /// The degree from which only the kink at the horizon has energy, which falls as l^-4.
    fn resolved_degree(&self) -> Option<usize> {
        Some(Surface::degree(self.surface.alpha))
    }
}

/// Parameters of a [`GgxLobe`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GgxParameters {
    /// The roughness, the square root of alpha.
    pub roughness: f64,
    /// The angle between view and normal, in degrees.
    pub view: f64,
}

/// An example.
impl Default for GgxParameters {
    fn default() -> Self {
        Self { roughness: 0.5, view: 0.0 }
    }
}

impl Parametric for GgxParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary =
            "square root of the width alpha of the GGX distribution (0 would be a mirror)";
        d.required_number(
            "roughness",
            Range::closed(GgxLobe::MIN_ROUGHNESS, 1.0),
            summary,
            &mut self.roughness,
        );
        let summary = "angle between view and normal in degrees";
        d.number("view", Range::right_open(0.0, 90.0), summary, &mut self.view);
    }
}

impl Definition for GgxParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        Ok(Box::new(GgxLobe::new(self.roughness, self.view)?))
    }
}
