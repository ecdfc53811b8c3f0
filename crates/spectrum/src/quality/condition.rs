use glam::DVec3;
use num_complex::Complex;
use rand::{Rng, RngExt};
use sphvar_samplers::{PointSet, Progress, Purpose, Streams};
use sphvar_sh::{Alm, Domain};
use sphvar_sht::{FastTransform, FastWorkspace};

use super::Unavailable;
use super::tridiagonal::Tridiagonal;
use crate::{Error, Resolution};

/// The maximum condition number that is determined: the transforms know its square to 1e-13.
pub const MAX_CONDITION: f64 = 1e5;

/// Relative accuracy of eigenvalues.
const ACCURACY: f64 = 1e-4;
/// Maximum number of Lanczos steps.
const MAX_STEPS: usize = 1000;
/// Number of steps between tests of convergence.
const STEPS_BETWEEN_TESTS: usize = 8;

/// Returns the condition number of fitting harmonics to degree `lmax` to values at the points: the
/// ratio of the largest to the smallest singular value of the matrix `sqrt(w_k) Y_lm(x_k)`. On the
/// hemisphere the harmonics are those of even degrees. It is 1 for a quadrature rule that is exact
/// to degree `2 lmax`.
///
/// The singular values are the roots of the extreme eigenvalues of the Gram matrix, which the
/// Lanczos method (Lanczos 1950) finds from products with it, a synthesis and an adjoint transform
/// each. They are accurate to 1e-4, and to 1e-3 near [`MAX_CONDITION`].
///
/// [`Unavailable`] if there are more harmonics than points, so that the matrix is singular; if the
/// condition number exceeds [`MAX_CONDITION`], or is not determined after 1000 steps; if a weight
/// is negative, so that there is no fit.
///
/// # Errors
///
/// [`Error::Transform`] if a transform cannot be made, [`Error::Sampler`] if `progress` stops the
/// work.
///
/// # Performance
///
/// Tens of pairs of transforms for well separated points, hundreds near `(lmax + 1)^2 = N`.
///
/// # References
///
/// C. Lanczos, "An iteration method for the solution of the eigenvalue problem", J. Res. Nat. Bur.
/// Standards 45(4), 1950; C. C. Paige, "Accuracy and effectiveness of the Lanczos algorithm",
/// Linear Algebra Appl. 34, 1980, on extreme eigenvalues without reorthogonalization.
pub fn condition_number(
    set: &PointSet,
    domain: Domain,
    lmax: usize,
    progress: &dyn Progress,
) -> Result<Result<f64, Unavailable>, Error> {
    let harmonics = n_harmonics(domain, lmax);
    if harmonics > set.len() as u128 {
        let reason = format!("{harmonics} harmonics to degree {lmax} exceed {} points", set.len());
        return Ok(Err(Unavailable::new(reason)));
    }
    if set.weights.iter().any(|w| *w < 0.0) {
        return Ok(Err(Unavailable::new("weights are negative")));
    }
    let mut gram = Gram::new(set, domain, lmax)?;
    let mut current = gram.random_start()?;
    let mut previous = Alm::zeros(lmax)?;
    let mut product = Alm::zeros(lmax)?;
    let mut matrix = Tridiagonal::default();
    let mut coupling = 0.0;
    for step in 1..=MAX_STEPS {
        progress.tick(0.0)?;
        gram.apply(&current, &mut product);
        let diagonal = inner_product(&current, &product);
        subtract(&mut product, diagonal, &current);
        subtract(&mut product, coupling, &previous);
        coupling = inner_product(&product, &product).sqrt();
        matrix.push(diagonal, coupling);
        // All harmonics that the start vector contains are found, up to rounding.
        let is_complete = coupling <= 1e-13 * matrix.diagonal_max();
        if step % STEPS_BETWEEN_TESTS == 0 || step == MAX_STEPS || is_complete {
            let (smallest, largest) = matrix.extremes();
            // Estimates of the smallest eigenvalue never rise. One of rounding may be NaN.
            let squared = largest / smallest.max(0.0);
            if squared.is_nan() || squared > MAX_CONDITION * MAX_CONDITION {
                let reason = format!("the condition number exceeds {MAX_CONDITION:e}");
                return Ok(Err(Unavailable::new(reason)));
            }
            let is_accurate = |end: f64| matrix.residual(end) <= ACCURACY * end;
            if is_complete || is_accurate(smallest) && is_accurate(largest) {
                return Ok(Ok((largest / smallest).sqrt()));
            }
        }
        for z in product.values_mut() {
            *z /= coupling;
        }
        std::mem::swap(&mut previous, &mut current);
        std::mem::swap(&mut current, &mut product);
    }
    Ok(Err(Unavailable::new(format!("not determined after {MAX_STEPS} steps"))))
}

/// Returns the number of harmonics to degree `lmax` in the domain.
fn n_harmonics(domain: Domain, lmax: usize) -> u128 {
    let l = lmax as u128;
    match domain {
        Domain::Sphere => (l + 1).saturating_mul(l + 1),
        Domain::Hemisphere => (l / 2 + 1).saturating_mul(2 * (l / 2) + 1),
    }
}

/// The Gram matrix of the harmonics at the points, `sum_k w_k conj Y_lm(x_k) Y_l'm'(x_k)`.
struct Gram<'a> {
    points: &'a [DVec3],
    /// Weights with the largest near 1; empty if equal.
    weights: Vec<f64>,
    domain: Domain,
    transform: FastTransform,
    workspace: FastWorkspace,
    values: Vec<f64>,
}

impl<'a> Gram<'a> {
    fn new(set: &'a PointSet, domain: Domain, lmax: usize) -> Result<Self, Error> {
        let mut scaled: PointSet = PointSet { points: Vec::new(), weights: set.weights.clone() };
        scaled.normalize_weights();
        Ok(Self {
            points: &set.points,
            weights: scaled.weights,
            domain,
            transform: FastTransform::new(lmax, Resolution::MIN_EPSILON)?,
            workspace: FastWorkspace::parallel(),
            values: vec![0.0; set.len()],
        })
    }

    /// Returns a random function of unit norm, the same one for each degree.
    fn random_start(&self) -> Result<Alm, Error> {
        let mut rng = Streams::new(0, Purpose::Resample, 0).realization(0);
        let mut start = Alm::zeros(self.transform.lmax())?;
        for m in 0..=self.transform.lmax() {
            for (l, z) in (m..).zip(start.column_mut(m)) {
                let draw = random_coefficient(&mut rng);
                if self.domain.has_degree(l) {
                    *z = if m == 0 { Complex::new(draw.re, 0.0) } else { draw };
                }
            }
        }
        let norm = inner_product(&start, &start).sqrt();
        start.values_mut().iter_mut().for_each(|z| *z /= norm);
        Ok(start)
    }

    /// Replaces `out` by the product with `function`.
    fn apply(&mut self, function: &Alm, out: &mut Alm) {
        let Self { points, weights, domain, transform, workspace, values } = self;
        transform.synthesis_into(function, points, workspace, values);
        values.iter_mut().zip(weights.iter()).for_each(|(v, w)| *v *= w);
        transform.adjoint_into(points, Some(values), workspace, out);
        for m in 0..=transform.lmax() {
            for (l, z) in (m..).zip(out.column_mut(m)) {
                if !domain.has_degree(l) {
                    *z = Complex::ZERO;
                } else if m == 0 {
                    // The rounding error of an imaginary part would be an eigenvector of 0.
                    z.im = 0.0;
                }
            }
        }
    }
}

fn random_coefficient(rng: &mut impl Rng) -> Complex<f64> {
    Complex::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0))
}

/// Returns the integral of the product of two real functions.
fn inner_product(f: &Alm, g: &Alm) -> f64 {
    let column = |m: usize| -> f64 {
        f.column(m).iter().zip(g.column(m)).map(|(a, b)| a.re * b.re + a.im * b.im).sum()
    };
    // Orders m and -m contribute alike.
    column(0) + 2.0 * (1..=f.index().lmax()).map(column).sum::<f64>()
}

fn subtract(f: &mut Alm, factor: f64, g: &Alm) {
    for (a, b) in f.values_mut().iter_mut().zip(g.values()) {
        *a -= factor * b;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sphvar_samplers::{Pattern, PointSet, Purpose, Streams};
    use sphvar_sh::{Colatitude, Domain, lambda};

    use super::condition_number;
    use crate::quality::test_sets::icosahedron;

    fn condition(set: &PointSet, domain: Domain, lmax: usize) -> Option<f64> {
        condition_number(set, domain, lmax, &()).unwrap().ok()
    }

    /// Returns the condition number by singular values of the dense matrix (Hestenes 1958):
    /// rotations make its columns orthogonal, one pair after the other.
    fn definition(set: &PointSet, domain: Domain, lmax: usize) -> f64 {
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let root = |k: usize| set.weights.get(k).map_or(1.0, |w| w.sqrt());
        for l in (0..=lmax).step_by(domain.degree_step()) {
            for m in 0..=l {
                let value = |k: usize, wave: fn(f64) -> f64| {
                    let p: DVec3 = set.points[k];
                    let angle = m as f64 * p.y.atan2(p.x);
                    let copies = if m == 0 { 1.0 } else { 2f64.sqrt() };
                    root(k) * copies * lambda(l, m, Colatitude::from_direction(p)) * wave(angle)
                };
                columns.push((0..set.len()).map(|k| value(k, f64::cos)).collect());
                if m > 0 {
                    columns.push((0..set.len()).map(|k| value(k, f64::sin)).collect());
                }
            }
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for _ in 0..30 {
            for i in 0..columns.len() {
                for j in 0..i {
                    let (left, right) = columns.split_at_mut(i);
                    let (a, b) = (&mut left[j], &mut right[0]);
                    let (aa, bb, ab) = (dot(a, a), dot(b, b), dot(a, b));
                    if ab.abs() <= 1e-16 * (aa * bb).sqrt() {
                        continue;
                    }
                    let (sin, cos) = (0.5 * (2.0 * ab).atan2(aa - bb)).sin_cos();
                    for (a, b) in a.iter_mut().zip(b) {
                        (*a, *b) = (cos * *a + sin * *b, cos * *b - sin * *a);
                    }
                }
            }
        }
        let norms: Vec<f64> = columns.iter().map(|c| dot(c, c).sqrt()).collect();
        let largest = norms.iter().copied().fold(0.0, f64::max);
        largest / norms.iter().copied().fold(f64::INFINITY, f64::min)
    }

    fn pattern(pattern: Pattern, n: usize, domain: Domain) -> PointSet {
        let mut rng = Streams::new(6, Purpose::Pattern, n).realization(0);
        pattern.build(n, domain).unwrap().sample(&mut rng).unwrap()
    }

    #[test]
    fn it_matches_dense_singular_values() {
        let mut weighted = pattern(Pattern::FIBONACCI, 90, Domain::Sphere);
        weighted.weights = (0..90).map(|k| 1e-200 * (1.0 + f64::from(k % 7))).collect();
        let mut uneven = pattern(Pattern::WhiteNoise, 60, Domain::Sphere);
        uneven.weights = (0..60).map(|k| if k == 3 { 1e3 } else { 0.1 }).collect();
        let cases = [
            (PointSet::new(icosahedron()), Domain::Sphere, 2),
            (PointSet::new(vec![DVec3::Z]), Domain::Sphere, 0),
            (pattern(Pattern::FIBONACCI, 60, Domain::Sphere), Domain::Sphere, 6),
            (pattern(Pattern::WhiteNoise, 60, Domain::Sphere), Domain::Sphere, 5),
            (pattern(Pattern::Healpix, 48, Domain::Sphere), Domain::Sphere, 4),
            (pattern(Pattern::FIBONACCI, 60, Domain::Hemisphere), Domain::Hemisphere, 6),
            (pattern(Pattern::WhiteNoise, 40, Domain::Hemisphere), Domain::Hemisphere, 5),
            (weighted, Domain::Sphere, 6),
            (uneven, Domain::Sphere, 3),
        ];
        for (set, domain, lmax) in cases {
            let expected = definition(&set, domain, lmax);
            let n = set.len();
            let got = condition_number(&set, domain, lmax, &()).unwrap();
            let got = got.unwrap_or_else(|reason| panic!("{n}, {lmax}: {reason}, {expected}"));
            assert!((got / expected - 1.0).abs() < 2e-4, "{n}, {lmax}: {got}, {expected}");
        }
    }

    #[test]
    fn what_is_singular_has_none() {
        let set = pattern(Pattern::FIBONACCI, 80, Domain::Sphere);
        assert!(condition(&set, Domain::Sphere, 9).is_none());
        assert!(condition(&set, Domain::Sphere, usize::MAX).is_none());
        let mut signed = set.clone();
        signed.weights = vec![1.0; 80];
        signed.weights[3] = -0.1;
        assert!(condition(&signed, Domain::Sphere, 2).is_none());
        // Twelve directions, repeated: harmonics of degree 3 are 16.
        let repeated = PointSet::new([icosahedron(), icosahedron()].concat());
        let reason = condition_number(&repeated, Domain::Sphere, 3, &()).unwrap().unwrap_err();
        assert!(reason.to_string().contains("exceeds 1e5"), "{reason}");
        // On a great circle half of the harmonics of degree 1 vanish.
        let ring = |k: u32| DVec3::new(f64::from(k).cos(), f64::from(k).sin(), 0.0);
        assert!(
            condition(&PointSet::new((0..30).map(ring).collect()), Domain::Sphere, 1).is_none()
        );
    }
}
