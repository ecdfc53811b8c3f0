use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;
use num_complex::Complex;
use sphvar_nufft::parts::{Fft, FftDirection, Real, good_size};
use sphvar_sh::{Alm, Colatitude, Domain, Error, GaussLegendre};

use super::harmonics::project;
use crate::{FastTransform, Method, RingTransform, RingWorkspace, Transform, TransformWorkspace};

/// The matrix `B D B^T` of all harmonics B at points, with a diagonal D of one factor for each
/// point, which is applied without the points.
///
/// An entry is the integral of a product of two harmonics over the measure
/// `mu = sum_k d_k delta(x, x_k)`. The product has at most degree 2L, so the coefficients of mu to
/// degree 2L determine the matrix, and the function with these coefficients can replace mu. The
/// integrand then has at most degree 4L, which a grid of 2L + 2 Gauss-Legendre rings of more than
/// 4L nodes integrates exactly: synthesis on the grid, multiplication by the function, analysis.
///
/// One pair of transforms of scattered points gives the function; each product with the matrix then
/// costs two Legendre stages and two Fourier transforms of the grid, whatever the number of points.
pub(crate) struct NormalMatrix<'a> {
    points: &'a [DVec3],
    domain: Domain,
    /// The transform of the points to degree 2L.
    transform: Transform,
    workspace: TransformWorkspace,
    measure: Alm,
    measure_rings: RingTransform,
    rings: RingTransform,
    ring_workspace: RingWorkspace,
    colatitudes: Vec<Colatitude>,
    ring_weights: Vec<f64>,
    n_phi: usize,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// The function on the grid times the quadrature weights; real and imaginary parts are two
    /// successive rings, as in `pair`.
    density: Vec<Complex<f64>>,
    /// Fourier coefficients by ring and order.
    spectra: Vec<Complex<f64>>,
    pair: Vec<Complex<f64>>,
    fft_scratch: Vec<Complex<f64>>,
}

impl<'a> NormalMatrix<'a> {
    /// Returns the matrix to degree `lmax` of no points; [`Self::set_factors`] sets it.
    pub(crate) fn new(points: &'a [DVec3], domain: Domain, lmax: usize) -> Result<Self, Error> {
        let epsilon = FastTransform::MIN_EPSILON;
        let transform = Transform::new(Method::Auto, 2 * lmax, points.len(), epsilon)?;
        let rule = GaussLegendre::new(2 * lmax + 2)?;
        let n_phi = good_size((4 * lmax + 1) as f64, 1.05);
        let colatitude =
            |z: f64| Colatitude::from_direction(DVec3::new(((1.0 - z) * (1.0 + z)).sqrt(), 0.0, z));
        let [forward, inverse] =
            [FftDirection::Forward, FftDirection::Inverse].map(|way| f64::fourier_plan(n_phi, way));
        let n_scratch = forward.get_inplace_scratch_len().max(inverse.get_inplace_scratch_len());
        Ok(Self {
            points,
            domain,
            transform,
            workspace: TransformWorkspace::parallel(),
            measure: Alm::zeros(2 * lmax)?,
            measure_rings: RingTransform::new(2 * lmax)?,
            rings: RingTransform::new(lmax)?,
            ring_workspace: RingWorkspace::default(),
            colatitudes: rule.nodes().iter().map(|&z| colatitude(z)).collect(),
            ring_weights: rule.weights().to_vec(),
            n_phi,
            forward,
            inverse,
            density: vec![Complex::ZERO; (lmax + 1) * n_phi],
            spectra: vec![Complex::ZERO; (2 * lmax + 2) * (2 * lmax + 1)],
            pair: vec![Complex::ZERO; n_phi],
            fft_scratch: vec![Complex::ZERO; n_scratch],
        })
    }

    /// Sets the diagonal D; `None` means factors of 1.
    pub(crate) fn set_factors(&mut self, factors: Option<&[f64]>) {
        let Self { measure, spectra, ring_workspace, colatitudes, .. } = self;
        let outs = std::slice::from_mut(measure);
        self.transform.adjoint_batch_into(&[(self.points, factors)], &mut self.workspace, outs);
        project(self.domain, measure);
        synthesize(&self.measure_rings, colatitudes, measure, spectra, ring_workspace);
        let n_orders = self.measure_rings.lmax() + 1;
        let pairs = spectra.chunks_exact(2 * n_orders).zip(self.ring_weights.chunks_exact(2));
        let scale = TAU / self.n_phi as f64;
        for (density, (spectra, weights)) in self.density.chunks_exact_mut(self.n_phi).zip(pairs) {
            fill(density, spectra);
            self.inverse.process_with_scratch(density, &mut self.fft_scratch);
            for z in density {
                *z = Complex { re: z.re * weights[0] * scale, im: z.im * weights[1] * scale };
            }
        }
    }

    /// Writes the product of the matrix with `alm`.
    pub(crate) fn apply(&mut self, alm: &Alm, out: &mut Alm) {
        let Self { spectra, ring_workspace, colatitudes, pair, fft_scratch, .. } = self;
        synthesize(&self.rings, colatitudes, alm, spectra, ring_workspace);
        let n_orders = self.rings.lmax() + 1;
        let rows = spectra.chunks_exact_mut(2 * n_orders);
        for (spectra, density) in rows.zip(self.density.chunks_exact(self.n_phi)) {
            fill(pair, spectra);
            self.inverse.process_with_scratch(pair, fft_scratch);
            for (z, d) in pair.iter_mut().zip(density) {
                *z = Complex { re: z.re * d.re, im: z.im * d.im };
            }
            self.forward.process_with_scratch(pair, fft_scratch);
            separate(pair, spectra);
        }
        let fourier = |m: usize, terms: &mut [Complex<f64>]| {
            for (term, row) in terms.iter_mut().zip(spectra.chunks_exact(n_orders)) {
                *term = row[m];
            }
        };
        self.rings.adjoint_into(colatitudes.iter().copied(), fourier, ring_workspace, out);
        project(self.domain, out);
    }
}

/// Writes the Fourier coefficients of a function by ring and order.
fn synthesize(
    rings: &RingTransform,
    colatitudes: &[Colatitude],
    alm: &Alm,
    spectra: &mut [Complex<f64>],
    workspace: &mut RingWorkspace,
) {
    let n_orders = rings.lmax() + 1;
    let emit = |m: usize, column: &[Complex<f64>]| {
        for (row, f) in spectra.chunks_exact_mut(n_orders).zip(column) {
            row[m] = *f;
        }
    };
    rings.synthesis_batch_into(colatitudes.iter().copied(), &[alm], emit, workspace);
}

/// Writes the spectrum of `a + i b` for real functions a and b with the coefficients `spectra`, one
/// after the other, of orders from 0.
fn fill(pair: &mut [Complex<f64>], spectra: &[Complex<f64>]) {
    let (n, (a, b)) = (pair.len(), spectra.split_at(spectra.len() / 2));
    pair.fill(Complex::ZERO);
    pair[0] = Complex { re: a[0].re, im: b[0].re };
    for (m, (a, b)) in a.iter().zip(b).enumerate().skip(1) {
        pair[m] = Complex { re: a.re - b.im, im: a.im + b.re };
        pair[n - m] = Complex { re: a.re + b.im, im: b.re - a.im };
    }
}

/// Writes the coefficients of a and b from the spectrum of `a + i b`: the inverse of [`fill`].
fn separate(pair: &[Complex<f64>], spectra: &mut [Complex<f64>]) {
    let (n, n_orders) = (pair.len(), spectra.len() / 2);
    let (a, b) = spectra.split_at_mut(n_orders);
    for (m, (a, b)) in a.iter_mut().zip(b).enumerate() {
        let (here, there) = (pair[m], pair[(n - m) % n].conj());
        *a = 0.5 * (here + there);
        let difference = 0.5 * (here - there);
        *b = Complex { re: difference.im, im: -difference.re };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normal_equations::harmonics::{Harmonics, dot};

    /// The definition: synthesis at the points, multiplication by the factors, adjoint.
    #[test]
    fn products_match_the_definition() {
        let spiral = |n: usize| {
            (0..n).map(move |k| {
                let (z, phi) = (1.0 - (2 * k + 1) as f64 / n as f64, 2.4 * k as f64);
                let sin = (1.0 - z * z).sqrt();
                DVec3::new(sin * phi.cos(), sin * phi.sin(), z)
            })
        };
        let poles = [DVec3::Z, -DVec3::Z, DVec3::X, DVec3::X, -DVec3::X];
        let cluster = spiral(50).map(|p| (1e-4 * p + DVec3::Y).normalize());
        let sets: [Vec<DVec3>; 4] = [
            spiral(600).collect(),
            poles.to_vec(),
            spiral(30).chain(poles).chain(cluster).collect(),
            vec![DVec3::new(0.48, 0.6, 0.64)],
        ];
        for (set, points) in sets.iter().enumerate() {
            for (lmax, domain) in [
                (0, Domain::Sphere),
                (1, Domain::Sphere),
                (2, Domain::Hemisphere),
                (13, Domain::Sphere),
                (24, Domain::Hemisphere),
            ] {
                let factors: Vec<f64> = (0..points.len()).map(|k| (k % 3) as f64 - 0.5).collect();
                let mut harmonics = Harmonics::new(points, domain, lmax).unwrap();
                let mut matrix = NormalMatrix::new(points, domain, lmax).unwrap();
                let seed: Vec<f64> = (0..points.len()).map(|k| (k as f64).sin() + 0.2).collect();
                let (mut alm, mut expected) =
                    (harmonics.zeros().unwrap(), harmonics.zeros().unwrap());
                harmonics.coefficients(&seed, &mut alm);
                for factors in [None, Some(factors.as_slice())] {
                    let mut values = vec![0.0; points.len()];
                    harmonics.values(&alm, &mut values);
                    if let Some(factors) = factors {
                        values.iter_mut().zip(factors).for_each(|(v, f)| *v *= f);
                    }
                    harmonics.coefficients(&values, &mut expected);
                    let mut got = harmonics.zeros().unwrap();
                    matrix.set_factors(factors);
                    matrix.apply(&alm, &mut got);
                    // The 2-norm of the matrix is at most its trace.
                    let trace = points.len() as f64 * ((lmax + 1) * (lmax + 1)) as f64 / 2.0 / TAU;
                    let limit = 1e-13 * trace * dot(&alm, &alm).sqrt();
                    for (got, expected) in got.values().iter().zip(expected.values()) {
                        let error = (got - expected).norm();
                        assert!(error <= limit, "set {set}, {lmax}, {domain:?}: {error:e}");
                    }
                }
            }
        }
    }
}
