use std::f64::consts::{FRAC_1_PI, PI, TAU};
use std::fmt;
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use sphvar_warps::{
    CosineHemisphere, DensityMap, Interpolation, OctahedralSphere, PhongLobe, SphericalRectangle,
    SphericalTriangle, UniformCap, VonMisesFisherLobe, Warp, WarpSample,
};

use super::luminance::Luminance;
use crate::{Errors, Subject};

pub(super) const VALID: &str = "valid parameters";

/// A density as a function of the point of the square and its image.
type Reference = Box<dyn Fn([f64; 2], DVec3) -> f64 + Send + Sync>;

/// A map with a reference of its density.
type Case = (Box<dyn Warp>, Reference);

/// A map, created at its first use, so that listing trials costs nothing.
pub(super) struct Input {
    pub(super) name: String,
    pub(super) bound: f64,
    count: usize,
    create: Box<dyn Fn() -> Case + Send + Sync>,
    case: OnceLock<Case>,
}

impl fmt::Debug for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Input").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Input {
    fn case(&self) -> &Case {
        self.case.get_or_init(&self.create)
    }

    fn warp(&self) -> &dyn Warp {
        self.case().0.as_ref()
    }

    /// Adds the error of a density, relative to its reference.
    fn push(&self, errors: &mut Errors, density: f64, point: [f64; 2]) {
        let dir = self.warp().map(point);
        let reference = (self.case().1)(point, dir);
        errors.push(density / reference - 1.0, || format!("{}, {point:?}", self.name));
    }
}

/// Returns the points of the square of every trial, by an additive recurrence.
pub(super) fn points(count: usize) -> Vec<[f64; 2]> {
    const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    (0..count).map(|k| STEPS.map(|step| (0.5 + k as f64 * step).fract())).collect()
}

/// Returns the maps, with luminance maps of this number of rows.
///
/// The bounds: lobes have u up to 1 - 1e-5, where rounding of the height is multiplied by ln(1e5) =
/// 12; in triangles and rectangles a rounding of the direction is divided by the distance from the
/// collapsed vertex, sqrt(1e-5), or by an extent of 0.5; luminance maps magnify a rounding of
/// angles by 100 per texel, over the smallest texel, and by the tangent of theta next to the
/// horizon.
pub(super) fn inputs(height: usize, count: usize) -> Vec<Input> {
    let input = |name: String, bound, create: Box<dyn Fn() -> Case + Send + Sync>| Input {
        name,
        bound,
        count,
        create,
        case: OnceLock::new(),
    };
    let simple =
        |name: &str, bound, create: fn() -> Case| input(name.to_owned(), bound, Box::new(create));
    let mut inputs = vec![
        simple("cylinder", 4e-15, || (Box::new(UniformCap::SPHERE), constant(4.0 * PI))),
        simple("octahedral", 4e-15, || (Box::new(OctahedralSphere), constant(4.0 * PI))),
        simple("cosine", 4e-15, || {
            // z^2 = (1 - r)(1 + r), with r the larger of |2u - 1| and |2v - 1|.
            let z = |[u, v]: [f64; 2]| {
                let r = (2.0 * u - 1.0).abs().max((2.0 * v - 1.0).abs());
                ((1.0 - r) * (1.0 + r)).sqrt()
            };
            (Box::new(CosineHemisphere), Box::new(move |point, _| z(point) * FRAC_1_PI))
        }),
        simple("cap of 0.01 rad", 4e-15, || {
            let cap = UniformCap::new(0.01).expect(VALID);
            (Box::new(cap), constant(4.0 * PI * 0.005f64.sin().powi(2)))
        }),
        simple("Phong, n = 50", 2e-14, || {
            let lobe = PhongLobe::new(50.0).expect(VALID);
            (Box::new(lobe), Box::new(|[u, _], _| 51.0 / TAU * (1.0 - u).powf(50.0 / 51.0)))
        }),
        simple("von Mises-Fisher, kappa = 100", 2e-14, || von_mises_fisher(100.0)),
        simple("triangle", 2e-13, || {
            // A right triangle at x with legs of 1: tan(E/2) = tan(1/2)^2.
            let (sin, cos) = 1.0f64.sin_cos();
            let vertices = [DVec3::new(cos, sin, 0.0), DVec3::X, DVec3::new(cos, 0.0, sin)];
            let solid_angle = 2.0 * 0.5f64.tan().powi(2).atan();
            (Box::new(SphericalTriangle::new(vertices).expect(VALID)), constant(solid_angle))
        }),
        simple("rectangle", 2e-13, || {
            let corner = DVec3::new(-1.0, -1.0, 1.0);
            let rectangle = SphericalRectangle::new(corner, 2.0 * DVec3::X, 2.0 * DVec3::Y);
            (Box::new(rectangle.expect(VALID)), constant(2.0 * PI / 3.0))
        }),
    ];
    for (interpolation, has_cosine, name) in [
        (Interpolation::Constant, false, "constant"),
        (Interpolation::Bilinear, false, "bilinear"),
        (Interpolation::Bilinear, true, "bilinear * cosine"),
    ] {
        let name = format!("{} x {height} texels, {name}", 2 * height);
        let create = move || {
            luminance(
                &Luminance::with_sun(height, interpolation, has_cosine),
                interpolation,
                has_cosine,
            )
        };
        inputs.push(input(name, 4e-14 * height as f64, Box::new(create)));
    }
    inputs
}

fn constant(solid_angle: f64) -> Reference {
    Box::new(move |_, _| 1.0 / solid_angle)
}

/// Returns the lobe with its density as a function of u: kappa/(2 pi) (1/(1 - e^(-2 kappa)) - u).
pub(super) fn von_mises_fisher(kappa: f64) -> Case {
    let lobe = VonMisesFisherLobe::new(kappa).expect(VALID);
    let top = -1.0 / (-2.0 * kappa).exp_m1();
    (Box::new(lobe), Box::new(move |[u, _], _| kappa / TAU * (top - u)))
}

fn luminance(map: &Luminance, interpolation: Interpolation, has_cosine: bool) -> Case {
    let (width, height) = (map.width, map.height);
    let texels = map.texels.clone();
    let warp = DensityMap::new(width, height, texels.clone(), interpolation).expect(VALID);
    let warp = if has_cosine { warp.times_cosine().expect(VALID) } else { warp };
    let map = Luminance::new(width, height, texels, interpolation, has_cosine);
    (Box::new(warp), Box::new(move |_, dir| map.density(dir)))
}

/// Samples with their density.
#[derive(Debug)]
pub(super) struct Samples {
    input: Arc<Input>,
    points: Vec<[f64; 2]>,
    samples: Vec<WarpSample>,
}

impl Samples {
    pub(super) fn new(input: Arc<Input>) -> Self {
        let points = points(input.count);
        Self { input, points, samples: Vec::new() }
    }

    fn sample(&mut self) {
        self.input.warp().sample_into(&self.points, &mut self.samples);
    }
}

impl Subject for Samples {
    fn run(&mut self) {
        self.sample();
    }

    fn errors(&mut self) -> Errors {
        let mut errors = Errors::default();
        errors.push_length(self.samples.len(), self.points.len());
        for (point, sample) in self.points.iter().zip(&self.samples) {
            self.input.push(&mut errors, sample.density, *point);
        }
        errors
    }
}

/// Densities at directions.
#[derive(Debug)]
pub(super) struct Densities {
    samples: Samples,
    densities: Vec<f64>,
}

impl Densities {
    pub(super) fn new(input: Arc<Input>) -> Self {
        Self { samples: Samples::new(input), densities: Vec::new() }
    }
}

impl Subject for Densities {
    fn run(&mut self) {
        if self.samples.samples.is_empty() {
            self.samples.sample();
        }
        let warp = self.samples.input.warp();
        self.densities.clear();
        self.densities.extend(self.samples.samples.iter().map(|sample| warp.density(sample.point)));
    }

    fn errors(&mut self) -> Errors {
        let mut errors = Errors::default();
        errors.push_length(self.densities.len(), self.samples.points.len());
        for (point, density) in self.samples.points.iter().zip(&self.densities) {
            self.samples.input.push(&mut errors, *density, *point);
        }
        errors
    }
}

/// Points of the square of directions.
#[derive(Debug)]
pub(super) struct Inverses {
    samples: Samples,
    inverses: Vec<Option<[f64; 2]>>,
}

impl Inverses {
    pub(super) fn new(input: Arc<Input>) -> Self {
        Self { samples: Samples::new(input), inverses: Vec::new() }
    }
}

impl Subject for Inverses {
    fn run(&mut self) {
        if self.samples.samples.is_empty() {
            self.samples.sample();
        }
        let warp = self.samples.input.warp();
        self.inverses.clear();
        self.inverses.extend(self.samples.samples.iter().map(|sample| warp.inverse(sample.point)));
    }

    fn errors(&mut self) -> Errors {
        let mut errors = Errors::default();
        errors.push_length(self.inverses.len(), self.samples.points.len());
        for (point, inverse) in self.samples.points.iter().zip(&self.inverses) {
            errors.push(distance(*point, *inverse), || {
                format!("{}, {point:?}", self.samples.input.name)
            });
        }
        errors
    }
}

/// Returns the largest difference of the coordinates, on a circle for the second; NaN without an
/// inverse.
pub(super) fn distance(point: [f64; 2], inverse: Option<[f64; 2]>) -> f64 {
    inverse.map_or(f64::NAN, |inverse| {
        let difference = (point[1] - inverse[1]).abs();
        (point[0] - inverse[0]).abs().max(difference.min(1.0 - difference))
    })
}
