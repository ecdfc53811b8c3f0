use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2, TAU};

use rand::{Rng, RngExt};

/// Applies uniform random rotations to vectors of coefficients, without transforming points.
///
/// The components are real; those of degree l start at l^2: `S_l0`, `sqrt(2) Re S_lm` for
/// m = 1 ..= l, then `sqrt(2) Im S_lm`. A rotation acts on them by an orthogonal matrix. Every
/// rotation is `Rz(alpha) Ry(pi/2) Rz(beta) Ry(-pi/2) Rz(gamma)`, where only the rotations by pi/2
/// mix orders; they need two fixed matrices per degree. The three inner factors are a rotation by
/// beta about x, so the product is uniform if alpha and gamma are uniform on the circle and
/// cos(beta) is uniform on [-1, 1].
///
/// # Performance
///
/// A rotation takes about `8/3 lmax^3` operations.
#[derive(Debug)]
pub(super) struct Rotator {
    quarters: Vec<QuarterRotation>,
}

/// `Ry(pi/2)` on one degree, row-major: among the real parts, l+1 rows, and among the imaginary
/// parts, l rows.
#[derive(Debug)]
struct QuarterRotation {
    real: Vec<f64>,
    imaginary: Vec<f64>,
}

impl Rotator {
    /// Returns the matrices for degrees up to `lmax`: (2/3) lmax^3 numbers.
    pub(super) fn new(lmax: usize) -> Self {
        let mut quarters: Vec<QuarterRotation> = (0..=lmax)
            .map(|l| QuarterRotation {
                real: vec![0.0; (l + 1) * (l + 1)],
                imaginary: vec![0.0; l * l],
            })
            .collect();
        for row in 0..=lmax {
            for column in 0..=lmax {
                let (plus, minus) = (
                    wigner_elements(row, column, false, lmax),
                    wigner_elements(row, column, true, lmax),
                );
                let scale = |m: usize| if m == 0 { 1.0 } else { SQRT_2 };
                // Negative orders enter through S_{l,-m} = (-1)^m conj S_lm.
                let parity = if column.is_multiple_of(2) { 1.0 } else { -1.0 };
                for l in row.max(column)..=lmax {
                    let (p, q) = (plus[l], parity * minus[l]);
                    let quarter = &mut quarters[l];
                    let both = if column == 0 { p } else { p + q };
                    quarter.real[row * (l + 1) + column] = both * scale(row) / scale(column);
                    if row > 0 && column > 0 {
                        quarter.imaginary[(row - 1) * l + column - 1] = p - q;
                    }
                }
            }
        }
        Self { quarters }
    }

    /// Rotates `components` by a uniform random rotation; degree 0 is unchanged.
    pub(super) fn rotate(&self, rng: &mut dyn Rng, components: &mut [f64], spare: &mut Vec<f64>) {
        let mut circle = || (TAU * rng.random::<f64>()).sin_cos();
        let (first, last) = (circle(), circle());
        let cos = 2.0 * rng.random::<f64>() - 1.0;
        let middle = ((1.0 - cos * cos).max(0.0).sqrt(), cos);
        spare.resize(components.len(), 0.0);
        self.about_axis(first, components);
        self.quarter(false, components, spare);
        self.about_axis(middle, spare);
        self.quarter(true, spare, components);
        self.about_axis(last, components);
    }

    /// Rotates about z by the angle with this sine and cosine.
    fn about_axis(&self, (sin, cos): (f64, f64), components: &mut [f64]) {
        for l in 1..self.quarters.len() {
            let (real, imaginary) = components[l * l..(l + 1) * (l + 1)].split_at_mut(l + 1);
            let (mut s, mut c) = (sin, cos);
            for (x, y) in real[1..].iter_mut().zip(imaginary) {
                (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
                (s, c) = (s * cos + c * sin, c * cos - s * sin);
            }
        }
    }

    /// Rotates about y by pi/2 or -pi/2, from one buffer into another.
    fn quarter(&self, inverse: bool, from: &[f64], to: &mut [f64]) {
        for (l, quarter) in self.quarters.iter().enumerate() {
            let block = l * l..(l + 1) * (l + 1);
            let (from, to) = (&from[block.clone()], &mut to[block]);
            let ((x, y), (u, v)) = (from.split_at(l + 1), to.split_at_mut(l + 1));
            for (matrix, from, to) in [(&quarter.real, x, u), (&quarter.imaginary, y, v)] {
                multiply(matrix, inverse, from, to);
            }
        }
    }
}

/// Computes `to = M from`, or with the transpose of M; M is square and row-major.
fn multiply(matrix: &[f64], transposed: bool, from: &[f64], to: &mut [f64]) {
    if from.is_empty() {
        return;
    }
    if transposed {
        to.fill(0.0);
        for (row, x) in matrix.chunks_exact(from.len()).zip(from) {
            for (t, a) in to.iter_mut().zip(row) {
                *t += a * x;
            }
        }
    } else {
        for (row, t) in matrix.chunks_exact(from.len()).zip(to) {
            *t = row.iter().zip(from).map(|(a, x)| a * x).sum();
        }
    }
}

/// Returns Wigner's `d^l_{m', m}(pi/2)` for l from 0 to `lmax` (0 for l below the orders), where
/// m is `column` or its negative.
///
/// ```text
/// d^{l+1} = -((2l+1) m' m/l d^l + (l+1)/l q_l d^{l-1})/q_{l+1},
/// q_l = sqrt((l^2 - m^2)(l^2 - m'^2))
/// ```
///
/// The recurrence (Kostelec and Rockmore 2008, section 3.3, at beta = pi/2) is stable upwards from
/// `d^l_{l, m} = (-1)^{l-m} 2^-l sqrt(binomial(2l, l+m))`.
fn wigner_elements(row: usize, column: usize, negative: bool, lmax: usize) -> Vec<f64> {
    let mut d = vec![0.0; lmax + 1];
    let start = row.max(column);
    let lesser = row.min(column);
    // 2^-l sqrt(binomial(2l, l + m)), as a product without large numbers.
    let central = (1..=start).map(|k| FRAC_1_SQRT_2 * (2.0 - 1.0 / k as f64).sqrt());
    let side = (1..=lesser).map(|k| ((start + 1 - k) as f64 / (start + k) as f64).sqrt());
    let size: f64 = central.product::<f64>() * side.product::<f64>();
    // d_{m'm} = (-1)^{m-m'} d_{mm'} = d_{-m,-m'} reduces each case to m' = l.
    let odd = if row >= column || negative { row + column } else { 0 };
    d[start] = if odd.is_multiple_of(2) { size } else { -size };
    let product = row as f64 * column as f64 * if negative { -1.0 } else { 1.0 };
    let q = |l: usize| {
        let part = |m: usize| ((l - m) * (l + m)) as f64;
        (part(row) * part(column)).sqrt()
    };
    for l in start..lmax {
        let before = if l > start { q(l) * (l + 1) as f64 / l as f64 * d[l - 1] } else { 0.0 };
        // At l = 0 the product is 0.
        let here = (2 * l + 1) as f64 * product / l.max(1) as f64 * d[l];
        d[l + 1] = -(here + before) / q(l + 1);
    }
    d
}

#[cfg(test)]
mod tests {
    use std::f64::consts::SQRT_2;

    use glam::{DMat3, DVec3};
    use sphvar_samplers::{Domain, Pattern, Purpose, Streams};
    use sphvar_sht::ExactTransform;

    use super::Rotator;

    const LMAX: usize = 12;

    /// Returns the components of the sum of delta functions at these points.
    fn components(points: &[DVec3]) -> Vec<f64> {
        let alm = ExactTransform::new(LMAX).unwrap().adjoint(points, None).unwrap();
        let mut components = vec![0.0; (LMAX + 1) * (LMAX + 1)];
        for (l, m) in alm.index().iter() {
            let scale = if m == 0 { 1.0 } else { SQRT_2 };
            components[l * l + m] = scale * alm[(l, m)].re;
            if m > 0 {
                components[l * l + l + m] = scale * alm[(l, m)].im;
            }
        }
        components
    }

    /// Returns the direction of a single point, from degree 1: `S_10 ~ z`, `S_11 ~ -(x - i y)`.
    fn direction(c: &[f64]) -> DVec3 {
        DVec3::new(-c[2], c[3], c[1]).normalize()
    }

    /// The rotation is determined from the images of the axes and then applied to points.
    #[test]
    fn rotated_coefficients_are_those_of_rotated_points() {
        let rotator = Rotator::new(LMAX);
        let sampler = Pattern::WhiteNoise.build(7, Domain::Sphere).unwrap();
        for seed in 0..20 {
            let streams = Streams::new(seed, Purpose::Resample, 0);
            let rotated = |points: &[DVec3]| {
                let mut c = components(points);
                rotator.rotate(&mut streams.realization(0), &mut c, &mut Vec::new());
                c
            };
            let axes = DVec3::AXES.map(|axis| direction(&rotated(&[axis])));
            let rotation = DMat3::from_cols(axes[0], axes[1], axes[2]);
            assert!((rotation.determinant() - 1.0).abs() < 1e-13, "{rotation}");
            let points = sampler.sample(&mut streams.realization(1)).unwrap().points;
            let expected: Vec<DVec3> = points.iter().map(|&p| rotation * p).collect();
            // Sums of 7 values of size sqrt((2l+1)/(4 pi)) <= 1.5; an error of a few EPSILON in the
            // angles is multiplied by l.
            let bound = 40.0 * f64::EPSILON * 7.0 * 1.5 * LMAX as f64;
            for (i, (a, b)) in rotated(&points).iter().zip(components(&expected)).enumerate() {
                assert!((a - b).abs() < bound, "seed {seed}, component {i}: {a}, not {b}");
            }
        }
    }

    /// In every degree the mean is 0 and the second moments are those of Schur's lemma.
    /// 8 + 36 means over `N` rotations of numbers below 5 in size: |z| < 5 for all fails by chance
    /// for 3e-5 of seeds.
    #[test]
    fn rotations_are_uniform_in_degrees_1_and_2() {
        const N: u32 = 20_000;
        let rotator = Rotator::new(2);
        let streams = Streams::new(0, Purpose::Resample, 0);
        let mut rng = streams.realization(0);
        // Unit components in both degrees.
        let start = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.6, 0.0, -0.8];
        let (mut means, mut products) = ([0.0; 9], [[0.0; 9]; 9]);
        let mut spare = Vec::new();
        for _ in 0..N {
            let mut c = start;
            rotator.rotate(&mut rng, &mut c, &mut spare);
            for i in 1..9 {
                means[i] += c[i];
                for (product, other) in products[i].iter_mut().zip(c) {
                    *product += c[i] * other;
                }
            }
        }
        let n = f64::from(N);
        for i in 1..9 {
            let l = if i < 4 { 1.0 } else { 2.0 };
            let z = means[i] / (n / (2.0 * l + 1.0)).sqrt();
            assert!(z.abs() < 5.0, "mean of component {i}: {z} sigma");
            for (j, product) in products[i].iter().enumerate().take(i + 1).skip(1) {
                let expected = if i == j { 1.0 / (2.0 * l + 1.0) } else { 0.0 };
                // |c_i c_j| <= 1, and its mean square is at most E c_i^2 <= 1/3.
                let z = (product / n - expected) * (3.0 * n).sqrt();
                assert!(z.abs() < 5.0, "product of {i} and {j}: {z} sigma");
            }
        }
    }

    /// Rotations preserve the power of every degree up to rounding, tested with 1000 of them.
    #[test]
    fn rotations_are_orthogonal_to_rounding() {
        const ROTATIONS: usize = 1000;
        let lmax = 64;
        let rotator = Rotator::new(lmax);
        let mut rng = Streams::new(3, Purpose::Resample, 0).realization(0);
        let mut c: Vec<f64> =
            (0..(lmax + 1) * (lmax + 1)).map(|i| (1.0 + i as f64).sin()).collect();
        let power =
            |c: &[f64], l: usize| c[l * l..(l + 1) * (l + 1)].iter().map(|x| x * x).sum::<f64>();
        let before: Vec<f64> = (0..=lmax).map(|l| power(&c, l)).collect();
        let mut spare = Vec::new();
        for _ in 0..ROTATIONS {
            rotator.rotate(&mut rng, &mut c, &mut spare);
        }
        for (l, before) in before.iter().enumerate() {
            let relative = (power(&c, l) / before - 1.0).abs();
            // Each rotation rounds two products of length l and l plane rotations.
            let bound = 8.0 * f64::EPSILON * (l + 1) as f64 * ROTATIONS as f64;
            assert!(relative <= bound, "degree {l}: {relative:e}");
        }
    }
}
