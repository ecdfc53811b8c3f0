use glam::DQuat;
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSlice};
use sphvar_samplers::{Progress, RotationSet, Stopped};

/// The number of rotations that are advanced together.
const LANES: usize = 8;

/// The number of parts into which a set is divided; the sums do not depend on threads.
const MAX_PARTS: usize = 64;

/// The fewest rotations of a part.
const MIN_PART: usize = 256;

/// One number for each of the rotations that are advanced together.
type Lane = [f64; LANES];

/// Returns, for the degrees from 0 to `lmax`, `sum_mk |sum_j w_j D^l_mk(R_j)|^2` with the
/// matrices D of the irreducible representations of SO(3).
///
/// `2 lmax` steps lead from the matrix of spin n/2 to that of spin (n+1)/2: with the polynomials
/// `x^(n-q) y^q/sqrt((n-q)! q!)` as the basis, each entry is a sum of two of the matrix before, with
/// coefficients of at most sqrt(2), so that errors do not grow.
///
/// # Performance
///
/// About 4 lmax^3 additions and multiplications for each rotation.
pub(super) fn squared_moments(
    set: &RotationSet,
    lmax: usize,
    progress: &dyn Progress,
) -> Result<Vec<f64>, Stopped> {
    let part = MIN_PART.max(set.len().div_ceil(MAX_PARTS)).next_multiple_of(LANES);
    let work = work_per_rotation(lmax);
    let sums = set.points.par_chunks(part).enumerate().map(|(i, rotations)| {
        let weights = set.weights.get(i * part..i * part + rotations.len());
        let mut matrices = Matrices::new(lmax);
        for (k, lanes) in rotations.chunks(LANES).enumerate() {
            let weight = |at: usize| match weights {
                Some(weights) => weights[k * LANES + at],
                None => 1.0,
            };
            matrices.add(lanes, weight);
            if k % 32 == 0 {
                progress.tick(32.0 * LANES as f64 * work)?;
            }
        }
        Ok(matrices.sums)
    });
    let parts = sums.collect::<Result<Vec<_>, Stopped>>()?;
    let mut squares = vec![0.0; lmax + 1];
    for (l, square) in squares.iter_mut().enumerate() {
        for entry in 0..(2 * l + 1).pow(2) {
            let sum = parts.iter().fold([0.0; 2], |[re, im], part| {
                let [a, b] = part[l][entry];
                [re + a, im + b]
            });
            *square += sum[0].powi(2) + sum[1].powi(2);
        }
    }
    Ok(squares)
}

/// Returns the nominal work of the matrices up to a degree.
pub(super) fn work_per_rotation(lmax: usize) -> f64 {
    // Measured: 1.5 ns for each entry of a matrix.
    let n = (2 * lmax + 1) as f64;
    0.025 * n.powi(3) / 3.0
}

/// The matrices of spins 0, 1/2, 1, ... of several rotations, and the sums of those of whole spins.
struct Matrices {
    lmax: usize,
    /// Row p, column q of the matrix of spin n/2 is entry p (n + 1) + q.
    current: Vec<[Lane; 2]>,
    next: Vec<[Lane; 2]>,
    sums: Vec<Vec<[f64; 2]>>,
}

impl Matrices {
    fn new(lmax: usize) -> Self {
        let entries = (2 * lmax + 1).pow(2);
        let zero = [[0.0; LANES]; 2];
        Self {
            lmax,
            current: vec![zero; entries],
            next: vec![zero; entries],
            sums: (0..=lmax).map(|l| vec![[0.0; 2]; (2 * l + 1).pow(2)]).collect(),
        }
    }

    /// Adds the matrices of at most [`LANES`] rotations, with their weights.
    fn add(&mut self, rotations: &[DQuat], weight: impl Fn(usize) -> f64) {
        let lane =
            |of: &dyn Fn(&DQuat) -> f64| std::array::from_fn(|k| rotations.get(k).map_or(0.0, of));
        let weights: Lane =
            std::array::from_fn(|k| if k < rotations.len() { weight(k) } else { 0.0 });
        // The matrix of spin 1/2: the images of x and y.
        let alpha = [lane(&|q| q.w), lane(&|q| -q.z)];
        let beta = [lane(&|q| -q.y), lane(&|q| -q.x)];
        let gamma = [lane(&|q| q.y), lane(&|q| -q.x)];
        let delta = [lane(&|q| q.w), lane(&|q| q.z)];
        self.current[0] = [[1.0; LANES], [0.0; LANES]];
        self.accumulate(0, &weights);
        for n in 1..=2 * self.lmax {
            for p in 0..=n {
                let (down, along) = (((n - p) as f64).sqrt(), (p as f64).sqrt());
                for q in 0..=n {
                    // The division by the larger number keeps the coefficients small.
                    let (first, second, column, divisor) =
                        if 2 * q <= n { (alpha, gamma, q, n - q) } else { (beta, delta, q - 1, q) };
                    let scale = 1.0 / (divisor as f64).sqrt();
                    let mut entry = [[0.0; LANES]; 2];
                    if p < n {
                        add_product(&mut entry, down * scale, first, self.current[p * n + column]);
                    }
                    if p > 0 {
                        let above = self.current[(p - 1) * n + column];
                        add_product(&mut entry, along * scale, second, above);
                    }
                    self.next[p * (n + 1) + q] = entry;
                }
            }
            std::mem::swap(&mut self.current, &mut self.next);
            if n % 2 == 0 {
                self.accumulate(n / 2, &weights);
            }
        }
    }

    fn accumulate(&mut self, l: usize, weights: &Lane) {
        for (sum, entry) in self.sums[l].iter_mut().zip(&self.current) {
            for (sum, part) in sum.iter_mut().zip(entry) {
                *sum += part.iter().zip(weights).map(|(x, w)| x * w).sum::<f64>();
            }
        }
    }
}

/// Adds `scale a b`, of complex numbers.
#[inline]
fn add_product(sum: &mut [Lane; 2], scale: f64, a: [Lane; 2], b: [Lane; 2]) {
    for k in 0..LANES {
        sum[0][k] += scale * (a[0][k] * b[0][k] - a[1][k] * b[1][k]);
        sum[1][k] += scale * (a[0][k] * b[1][k] + a[1][k] * b[0][k]);
    }
}
