//! Legendre stage: between values on rings and coefficients by degree, one order m at a time.
//!
//! [`Lanes`] holds the rings and [`Order`] the coefficients of the recurrence. [`Adjoint`] and
//! [`Synthesis`] are the two directions of the product with the matrix of Legendre functions.

mod kernel;
mod lanes;
mod number;
mod order;

pub(crate) use kernel::{Adjoint, Columns, Synthesis};
pub(crate) use lanes::{Arithmetic, Lanes, last_order};
use order::Form;
pub(crate) use order::Order;

/// Number of rings that pass through the recurrence together.
const RINGS: usize = 32;

/// Number of functions that share one pass of the recurrence.
pub(crate) const FUNCTIONS: usize = 4;

/// Numbers per function and ring: real and imaginary part for even l + m, then for odd l + m.
const PARTS: usize = 4;

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use num_complex::Complex;
    use pulp::Arch;
    use sphvar_sh::{Alm, Colatitude};

    use super::Arithmetic;
    use crate::{RingTransform, RingWorkspace};

    /// Rings at and near poles and equator, at the limits between the forms of the recurrence, and
    /// elsewhere.
    fn rings() -> Vec<Colatitude> {
        let near_pole = [0.0, 1e-200, 1e-9, 1e-4, 0.01, 0.1, 0.126, 0.127, 0.3, 0.78, 0.79];
        let near_equator = [0.0, 1e-17, 1e-9, 1e-4, 0.003, 0.02, 0.05, 0.126, 0.127, 0.4, 0.5];
        let near_pole = near_pole.map(|angle: f64| DVec3::new(angle.sin(), 0.0, -angle.cos()));
        let near_equator = near_equator.map(|angle: f64| DVec3::new(angle.cos(), 0.0, angle.sin()));
        near_pole.into_iter().chain(near_equator).map(Colatitude::from_direction).collect()
    }

    fn norm(values: impl Iterator<Item = Complex<f64>>) -> f64 {
        values.map(|a| a.norm_sqr()).sum::<f64>().sqrt()
    }

    #[test]
    fn every_arithmetic_has_its_accuracy_on_every_ring() {
        let mut workspace = RingWorkspace::default();
        let values = |m: usize| Complex::new(1.0, 0.01 * m as f64 - 0.5);
        let fourier = |m, out: &mut [Complex<f64>]| out.fill(values(m));
        for lmax in [0, 1, 2, 33, 130, 300] {
            let exact = RingTransform::new(lmax).unwrap();
            let archs = if lmax < 100 { 2 } else { 1 };
            for ring in rings() {
                let ring = || std::iter::once(ring);
                let [mut expected, mut got] = [(); 2].map(|()| Alm::zeros(lmax).unwrap());
                exact.adjoint_into(ring(), fourier, &mut workspace, &mut expected);
                let size = norm(expected.values().iter().copied());
                for epsilon in [1e-3, 1e-5, 5e-7, 2e-7, 1e-9, 1e-12] {
                    for arch in [Arch::new(), Arch::Scalar].into_iter().take(archs) {
                        let arithmetic = Arithmetic::new(epsilon, lmax);
                        let transform = RingTransform::with_arch(lmax, arch, arithmetic).unwrap();
                        transform.adjoint_into(ring(), fourier, &mut workspace, &mut got);
                        let pairs = expected.values().iter().zip(got.values());
                        let off = norm(pairs.map(|(a, b)| a - b));
                        assert!(
                            off <= 0.4 * epsilon * size,
                            "lmax {lmax}, {epsilon:e}, {:?}: {:e}",
                            ring().next(),
                            off / size
                        );
                        // Synthesis is the transpose: <A x, y> = <x, A* y>.
                        let mut by_ring = Complex::ZERO;
                        let emit =
                            |m: usize, f: &[Complex<f64>]| by_ring += f[0] * values(m).conj();
                        transform.synthesis_batch_into(ring(), &[&expected], emit, &mut workspace);
                        let off = (by_ring - size * size).norm();
                        assert!(off <= epsilon * size * size, "lmax {lmax}, {epsilon:e}: {off:e}");
                    }
                }
            }
        }
    }
}
