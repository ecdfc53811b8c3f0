use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use rayon::prelude::*;
use sphvar_integrands::{ClampedCosine, Integrand};
use sphvar_samplers::Domain;
use sphvar_sh::{Alm, LmIndex};
use sphvar_sht::{Method, Transform, TransformWorkspace};
use statrs::statistics::Statistics;

use super::environment::RgbEnvironment;
use super::gram::Gram;
use super::{DirectionalLight, LUMINANCE};
use crate::Error;

/// The irradiance of surfaces of all orientations in an environment, and the error of lights that
/// replace it.
///
/// With the coefficients `L_lm` of the radiance, the irradiance of a surface with normal n is
/// (Ramamoorthi and Hanrahan 2001, equation 7)
///
/// ```text
/// E(n) = int L(d) max(0, n . d) dd = sum_lm A_l L_lm Y_lm(n),
/// A_0 = pi, A_1 = 2 pi/3, A_2 = pi/4, A_3 = 0, A_4 = -pi/24, ...
/// ```
///
/// and lights of irradiance `c_i` in directions `d_i` have the coefficients
/// `sum_i c_i conj Y_lm(d_i)`. The mean squared error over all normals is the sum over degrees of
/// `A_l^2` times the energy of the difference. Degrees up to a largest one are summed. Beyond, the
/// energy of the lights is the rest of their sum over pairs, which is known in closed form for the
/// angle gamma between two lights,
///
/// ```text
/// int max(0, n . d_i) max(0, n . d_j) dn = 2/3 (sin gamma + (pi - gamma) cos gamma),
/// ```
///
/// and that of the map is left out. Relative to the squared norm it is below `1/(pi lmax^3)`. The
/// largest degree is twice the width of the map, from 128 to 512, so it is below 1e-10 for widths
/// to 256 texels, where the Fourier transform of a texel is small beyond, and below 3e-9 for
/// others.
///
/// # References
///
/// Cho and Saul 2009, equation 6, for the integral over normals.
#[derive(Debug)]
pub struct IrradianceReference {
    /// `A_l`.
    factors: Vec<f64>,
    /// `L_lm` of each channel.
    radiance: [Alm; 3],
    norm: Gram,
    /// From directions of the environment to those of the maps.
    to_map: DQuat,
}

/// Errors of the irradiance relative to its root mean square, over all normals; `None` where the
/// irradiance is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrradianceError {
    /// The error of the luminance.
    pub luminance: Option<f64>,
    /// The errors of red, green and blue.
    pub channels: [Option<f64>; 3],
}

impl IrradianceError {
    /// Returns the mean of errors and the standard error of that of the luminance, which is unknown
    /// for a single one.
    #[must_use]
    pub fn mean(errors: &[Self]) -> (Self, Option<f64>) {
        let mean = |of: &dyn Fn(&Self) -> Option<f64>| {
            let sum = errors.iter().map(of).sum::<Option<f64>>()?;
            (!errors.is_empty()).then(|| sum / errors.len() as f64)
        };
        let luminance = mean(&|error| error.luminance);
        let channels = [0, 1, 2].map(|c| mean(&|error: &Self| error.channels[c]));
        let values: Vec<f64> = errors.iter().filter_map(|error| error.luminance).collect();
        let stderr = (values.len() > 1 && values.len() == errors.len())
            .then(|| values.iter().std_dev() / (values.len() as f64).sqrt());
        (Self { luminance, channels }, stderr)
    }
}

/// The limits of the largest degree.
const MIN_LMAX: usize = 128;
const MAX_LMAX: usize = 512;

/// The relative accuracy of the transforms.
const EPSILON: f64 = 1e-12;

impl IrradianceReference {
    /// Returns the reference for an environment.
    ///
    /// Cost: a transform of each map, 0.1 s for 128 x 64 texels.
    ///
    /// # Errors
    ///
    /// [`Error::Integrand`] if memory is exhausted.
    pub fn new(environment: &RgbEnvironment) -> Result<Self, Error> {
        let width = environment.channels()[0].width();
        Self::of_degree(environment, width.saturating_mul(2).clamp(MIN_LMAX, MAX_LMAX))
    }

    fn of_degree(environment: &RgbEnvironment, lmax: usize) -> Result<Self, Error> {
        let cosine = ClampedCosine.coefficients(Domain::Sphere, lmax)?;
        let zonal = cosine.as_zonal().map(|(_, zonal)| zonal.to_vec()).unwrap_or_default();
        let factor = |(l, c): (usize, f64)| c * (4.0 * PI / (2 * l + 1) as f64).sqrt();
        let factors: Vec<f64> = zonal.into_iter().enumerate().map(factor).collect();
        let [r, g, b] = environment.channels().each_ref().map(|map| map.alm(Domain::Sphere, lmax));
        let radiance = [r?, g?, b?];
        let norm = energy(&factors, &radiance);
        Ok(Self { factors, radiance, norm, to_map: environment.to_map() })
    }

    fn lmax(&self) -> usize {
        self.factors.len() - 1
    }

    /// Returns the errors of the irradiance of lights.
    ///
    /// Cost: a transform of the lights and 10 ns for each pair of them.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if memory is exhausted.
    pub fn relative_error(&self, lights: &[DirectionalLight]) -> Result<IrradianceError, Error> {
        let directions: Vec<DVec3> =
            lights.iter().map(|light| self.to_map * light.direction).collect();
        let channels =
            [0, 1, 2].map(|c| lights.iter().map(|light| light.irradiance[c]).collect::<Vec<_>>());
        let sets = channels.each_ref().map(|values| (&directions[..], Some(&values[..])));
        let zeros = || Alm::zeros(self.lmax());
        let mut of_lights = [zeros()?, zeros()?, zeros()?];
        let transform = Transform::new(Method::Auto, self.lmax(), lights.len(), EPSILON)?;
        transform.adjoint_batch_into(&sets, &mut TransformWorkspace::default(), &mut of_lights);
        let low_degrees = energy(&self.factors, &of_lights);
        for (of_lights, radiance) in of_lights.iter_mut().zip(&self.radiance) {
            for (a, b) in of_lights.values_mut().iter_mut().zip(radiance.values()) {
                *a -= b;
            }
        }
        let difference = energy(&self.factors, &of_lights);
        let all_degrees = pair_sum(lights);
        let relative = |weights| {
            let high_degrees = all_degrees.square(weights) - low_degrees.square(weights);
            let square = difference.square(weights) + high_degrees.max(0.0);
            let norm = self.norm.square(weights);
            (norm > 0.0).then(|| (square / norm).sqrt())
        };
        Ok(IrradianceError {
            luminance: relative(LUMINANCE),
            channels: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(relative),
        })
    }

    /// Returns the irradiance of surfaces with these normals.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if memory is exhausted.
    pub fn irradiance(&self, normals: &[DVec3]) -> Result<Vec<[f64; 3]>, Error> {
        let normals: Vec<DVec3> = normals.iter().map(|&normal| self.to_map * normal).collect();
        let transform = Transform::new(Method::Auto, self.lmax(), normals.len(), EPSILON)?;
        let index = LmIndex::new(self.lmax())?;
        let mut colours = vec![[0.0; 3]; normals.len()];
        let mut values = vec![0.0; normals.len()];
        for (channel, radiance) in self.radiance.iter().enumerate() {
            let mut alm = radiance.clone();
            for ((l, _), value) in index.iter().zip(alm.values_mut()) {
                *value *= self.factors[l];
            }
            transform.synthesis_into(
                &alm,
                &normals,
                &mut TransformWorkspace::default(),
                &mut values,
            );
            for (colour, value) in colours.iter_mut().zip(&values) {
                colour[channel] = *value;
            }
        }
        Ok(colours)
    }
}

/// Returns the inner products over all normals of the irradiances of three channels of radiance.
fn energy(factors: &[f64], channels: &[Alm; 3]) -> Gram {
    let lmax = factors.len() - 1;
    let mut sum = Gram::default();
    for m in 0..=lmax {
        let columns = channels.each_ref().map(|alm| alm.column(m));
        let multiplicity = if m == 0 { 1.0 } else { 2.0 };
        let mut of_order = Gram::default();
        for (i, factor) in factors[m..].iter().enumerate() {
            let [re, im] = [columns.map(|column| column[i].re), columns.map(|column| column[i].im)];
            let square = factor * factor;
            of_order.add(square, re, re);
            of_order.add(square, im, im);
        }
        sum = sum.plus(multiplicity, of_order);
    }
    sum
}

/// Returns the inner products over all normals of the irradiances of lights.
fn pair_sum(lights: &[DirectionalLight]) -> Gram {
    let row = |(i, a): (usize, &DirectionalLight)| {
        let mut sum = Gram::default();
        let mut others = [0.0; 3];
        for b in &lights[i + 1..] {
            let kernel = kernel(a.direction, b.direction);
            others = [0, 1, 2].map(|c| others[c] + kernel * b.irradiance[c]);
        }
        sum.add(1.0, a.irradiance, others);
        sum.add(1.0, others, a.irradiance);
        sum.add(kernel(a.direction, a.direction), a.irradiance, a.irradiance);
        sum
    };
    // Rows are added in order, so the sum does not depend on the number of threads.
    let rows: Vec<Gram> = lights.par_iter().enumerate().map(row).collect();
    rows.into_iter().fold(Gram::default(), |sum, row| sum.plus(1.0, row))
}

/// Returns `int max(0, n . a) max(0, n . b) dn`: a function of the cosine with bounded derivative.
fn kernel(a: DVec3, b: DVec3) -> f64 {
    let cosine = a.dot(b).clamp(-1.0, 1.0);
    let sine = (1.0 - cosine * cosine).sqrt();
    2.0 / 3.0 * (sine + (PI - cosine.acos()) * cosine)
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use sphvar_integrands::EnvironmentMap;
    use sphvar_samplers::{AdaptedCcvt, Purpose, Streams};

    use super::{IrradianceReference, RgbEnvironment};

    /// The light of a single texel, from lights within it, is the case in which high degrees matter
    /// most.
    #[test]
    fn degrees_beyond_the_largest_do_not_matter() {
        let texels = (0..64 * 32).map(|k| if k == 64 * 9 + 5 { 1.0 } else { 0.0 }).collect();
        let map = EnvironmentMap::new(64, 32, texels).unwrap();
        let environment =
            RgbEnvironment::new([map.clone(), map.clone(), map], DQuat::IDENTITY).unwrap();
        let ccvt = AdaptedCcvt::new(64, 64, environment.luminance_warp()).unwrap();
        let mut rng = Streams::new(3, Purpose::Pattern, 0).realization(0);
        let tessellation = ccvt.tessellate(&mut rng, &()).unwrap();
        let lights = environment.cell_lights(&tessellation);
        let square = |reference: IrradianceReference| {
            reference.relative_error(&lights).unwrap().luminance.unwrap().powi(2)
        };
        let got = square(IrradianceReference::new(&environment).unwrap());
        let expected = square(IrradianceReference::of_degree(&environment, 600).unwrap());
        assert!((got - expected).abs() < 1e-10, "{got:e} {expected:e}");
    }
}
