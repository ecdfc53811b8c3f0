//! Sums of a function of the angle over the pairs of points of prefixes.

use std::f64::consts::SQRT_2;

use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{PointSet, Progress, Stopped};
use sphvar_sh::ByParity;

/// The number of coefficients of a polynomial, one cache line.
const COEFFICIENTS: usize = 8;
/// The interpolation error relative to the sum of the coefficients.
const ACCURACY: f64 = 1e-12;
/// The maximum width of a cell.
const MAX_WIDTH: f64 = 0.25;
/// The nominal work of a degree in a cell.
const CELL_WORK: f64 = 0.25;
/// The number of pairs whose chords are computed together.
const BLOCK: usize = 32;
/// `1.5 * 2^52`: the sum with a number below 2^31 has its nearest integer in the last bits.
const SHIFT: f64 = 6_755_399_441_055_744.0;
/// The square of the distance up to which [`tail_power`](sphvar_spectrum::tail_power) counts points
/// as coincident.
const SAME_SQUARED: f64 = (16.0 * f32::EPSILON as f64) * (16.0 * f32::EPSILON as f64);

/// The function `f(t) = sum_l c_l P_l(t)` of the cosine t, as polynomials in the shorter one of the
/// chords `s = |x - y| = sqrt(2 - 2 t)` and `|x + y| = sqrt(2 + 2 t)`.
///
/// Up to s = sqrt(2) the phase of `P_l` changes by at most `sqrt(2) (l + 1/2)` per unit of s. The
/// polynomials of degree 7 through the Chebyshev points of cells of width h therefore differ from f
/// by at most
///
/// ```text
/// 2 sum_l |c_l| (sqrt(2) (l + 4) h/4)^8/8!
/// ```
///
/// where 4 instead of 1/2 covers small degrees. The width follows from this bound.
#[derive(Debug)]
pub(super) struct ChordKernel {
    /// For every multiple of the width, the polynomials for t >= 0 and for t < 0.
    cells: Vec<Cell>,
    /// The number of cells per unit of s.
    density: f64,
    /// f(1).
    at_one: f64,
}

/// The coefficients of a polynomial in `2 (s/h - k)`, within [-1, 1].
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Cell([f64; COEFFICIENTS]);

/// The sums over pairs `j <= i` that the points i = 0, 1, ... add to the double sum over all pairs of
/// a prefix.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Row {
    /// Of `w_i w_j f(x_i . x_j)`.
    pub(super) kernel: f64,
    /// Of `w_i w_j (1 +- 1)`, where the points coincide or are antipodes.
    pub(super) coincidences: ByParity,
}

impl ChordKernel {
    /// Returns the kernel with coefficients by degree from 0, all of them positive or 0. Ticks
    /// [`Self::work`].
    ///
    /// # Errors
    ///
    /// Returns an error if `progress` stops the work.
    pub(super) fn new(coefficients: &[f64], progress: &dyn Progress) -> Result<Self, Stopped> {
        let (width, last) = grid(coefficients);
        let each = CELL_WORK * coefficients.len() as f64;
        let of_place = |k: usize| {
            progress.tick(each)?;
            Ok(cells(coefficients, k, width))
        };
        let cells = (0..=last).into_par_iter().map(of_place).collect::<Result<Vec<_>, _>>()?;
        let at_one = coefficients.iter().sum();
        Ok(Self { cells: cells.concat(), density: 1.0 / width, at_one })
    }

    /// Returns the nominal work of [`Self::new`].
    pub(super) fn work(coefficients: &[f64]) -> f64 {
        let (_, last) = grid(coefficients);
        CELL_WORK * coefficients.len() as f64 * (last as f64 + 1.0)
    }

    /// Returns the sums of row `i`.
    pub(super) fn row(&self, points: &Columns, i: usize) -> Row {
        let [x, y, z] = points.point(i);
        let (mut kernel, mut coincidences) = (0.0, ByParity::both(0.0));
        for start in (0..i).step_by(BLOCK) {
            let block = start..start + BLOCK;
            let [xs, ys, zs] = points.coordinates.each_ref().map(|all| &all[block.clone()]);
            let weights = &points.weights[block.clone()];
            let (mut cosines, mut squares) = ([0.0; BLOCK], [0.0; BLOCK]);
            for k in 0..BLOCK {
                cosines[k] = x * xs[k] + y * ys[k] + z * zs[k];
                squares[k] = (2.0 - 2.0 * cosines[k].abs()).max(0.0);
            }
            // Points after the row have no weight.
            let n = BLOCK.min(i - start);
            let mut sums = [0.0; 2];
            for k in 0..n {
                let place = squares[k].sqrt() * self.density;
                let shifted = place + SHIFT;
                let r = 2.0 * (place - (shifted - SHIFT));
                let side = cosines[k].to_bits() >> 63;
                #[expect(clippy::cast_possible_truncation, reason = "the last 32 bits")]
                let cell = 2 * (shifted.to_bits() as u32 as usize) + side as usize;
                let [even, odd] = self.cells[cell].halves(r * r);
                sums[0] += weights[k] * even;
                sums[1] += weights[k] * r * odd;
            }
            kernel += sums[0] + sums[1];
            if squares[..n].iter().fold(f64::INFINITY, |min, s| min.min(*s)) <= SAME_SQUARED {
                for k in (0..n).filter(|&k| squares[k] <= SAME_SQUARED) {
                    coincidences.even += weights[k];
                    coincidences.odd += weights[k].copysign(weights[k] * cosines[k]);
                }
            }
        }
        let weight = points.weights[i];
        Row {
            kernel: weight * (weight * self.at_one + 2.0 * kernel),
            coincidences: coincidences.map(|sum| weight * (weight + 2.0 * sum)),
        }
    }
}

impl Cell {
    /// Returns the parts a and b of the polynomial `a(r^2) + r b(r^2)`.
    #[inline]
    fn halves(&self, square: f64) -> [f64; 2] {
        let c = &self.0;
        let mut halves = [c[6], c[7]];
        for pair in [[c[4], c[5]], [c[2], c[3]], [c[0], c[1]]] {
            halves = [halves[0] * square + pair[0], halves[1] * square + pair[1]];
        }
        halves
    }
}

/// The coordinates and weights of points, followed by points without weight up to a whole block.
#[derive(Debug)]
pub(super) struct Columns {
    coordinates: [Vec<f64>; 3],
    weights: Vec<f64>,
}

impl Columns {
    /// Returns the columns of a set.
    pub(super) fn new(set: &PointSet) -> Self {
        let len = set.len() + BLOCK;
        let column = |values: &mut dyn Iterator<Item = f64>| {
            let mut column: Vec<f64> = values.collect();
            column.resize(len, 0.0);
            column
        };
        let weight = |k: usize| set.weights.get(k).copied().unwrap_or(1.0);
        Self {
            coordinates: [0, 1, 2].map(|axis| column(&mut set.points.iter().map(|p| p[axis]))),
            weights: column(&mut (0..set.len()).map(weight)),
        }
    }

    fn point(&self, i: usize) -> [f64; 3] {
        self.coordinates.each_ref().map(|all| all[i])
    }
}

/// Returns the width of the cells and the number of the last one.
fn grid(coefficients: &[f64]) -> (f64, usize) {
    let at_one: f64 = coefficients.iter().sum();
    let eighth_power = |(l, c): (usize, &f64)| c / at_one * (l as f64 + 4.0).powi(8);
    let moment: f64 = coefficients.iter().enumerate().map(eighth_power).sum();
    // 8!/2 (4/sqrt(2))^8 = 20160 * 4096. Without coefficients the moment is NaN.
    let width = (ACCURACY * 20_160.0 * 4096.0 / moment).powf(0.125).min(MAX_WIDTH);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
    let last = (SQRT_2 / width).ceil() as usize;
    (width, last)
}

/// Returns the polynomials of cell k for t >= 0 and t < 0.
fn cells(coefficients: &[f64], k: usize, width: f64) -> [Cell; 2] {
    let angle = |node: usize| std::f64::consts::PI * (node as f64 + 0.5) / COEFFICIENTS as f64;
    let chords: [f64; COEFFICIENTS] =
        std::array::from_fn(|node| width * (k as f64 + 0.5 * angle(node).cos()));
    let parts = parities(coefficients, chords.map(|s| 0.5 * s * s));
    let cell = |sign: f64| {
        let value = |node: usize| parts[0][node] + sign * parts[1][node];
        polynomial(std::array::from_fn(value))
    };
    [cell(1.0), cell(-1.0)]
}

/// Returns the sums over even and over odd degrees of `c_l P_l(1 - v)`.
fn parities(coefficients: &[f64], v: [f64; COEFFICIENTS]) -> [[f64; COEFFICIENTS]; 2] {
    let mut sums = [[0.0; COEFFICIENTS]; 2];
    let (mut value, mut difference) = ([1.0; COEFFICIENTS], [0.0; COEFFICIENTS]);
    for (l, c) in coefficients.iter().enumerate() {
        let sum = &mut sums[l % 2];
        let r = l as f64 / (l as f64 + 1.0);
        for node in 0..COEFFICIENTS {
            sum[node] += c * value[node];
            // The recurrence for differences does not lose digits near t = 1.
            difference[node] = r * difference[node] - (1.0 + r) * v[node] * value[node];
            value[node] += difference[node];
        }
    }
    sums
}

/// Returns the polynomial through values at the Chebyshev points `cos(pi (k + 1/2)/8)`.
fn polynomial(values: [f64; COEFFICIENTS]) -> Cell {
    let n = COEFFICIENTS;
    let node = |k: usize| std::f64::consts::PI * (k as f64 + 0.5) / n as f64;
    let mut coefficients = [0.0; COEFFICIENTS];
    // The Chebyshev polynomials T_j and T_(j+1) in powers.
    let (mut this, mut next) = ([0.0; COEFFICIENTS], [0.0; COEFFICIENTS]);
    (this[0], next[1]) = (1.0, 1.0);
    for j in 0..n {
        let projection: f64 =
            values.iter().enumerate().map(|(k, f)| f * (j as f64 * node(k)).cos()).sum();
        let factor = if j == 0 { 1.0 } else { 2.0 } / n as f64 * projection;
        for (c, power) in coefficients.iter_mut().zip(&this) {
            *c += factor * power;
        }
        let mut after = this.map(|power| -power);
        for power in 1..n {
            after[power] += 2.0 * next[power - 1];
        }
        (this, next) = (next, after);
    }
    Cell(coefficients)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sphvar_samplers::PointSet;
    use sphvar_sh::legendre_p_into;

    use super::{ACCURACY, ChordKernel, Columns};

    /// Returns `sum_l c_l P_l(t)`.
    fn sum(coefficients: &[f64], t: f64) -> f64 {
        let mut values = vec![0.0; coefficients.len()];
        legendre_p_into(t.clamp(-1.0, 1.0), &mut values).unwrap();
        coefficients.iter().zip(values).map(|(c, p)| c * p).sum()
    }

    /// The polynomials against Legendre polynomials, for pairs with a point that moves from pole to
    /// pole in steps that do not divide the cells, and for the double sum over all pairs.
    #[test]
    fn kernels_are_sums_of_legendre_polynomials() {
        let decaying = |lmax: usize, power: i32| -> Vec<f64> {
            (0..=lmax).map(|l| if l == 0 { 0.0 } else { (l as f64).powi(-power) }).collect()
        };
        let mut single = vec![0.0; 401];
        single[400] = 1.0;
        for coefficients in
            [decaying(700, 2), decaying(60, 0), single, vec![0.0, 2.0, 0.0], vec![0.0]]
        {
            let kernel = ChordKernel::new(&coefficients, &()).unwrap();
            let n = 100;
            let mut points = vec![DVec3::Z];
            for k in 0..=n {
                let theta = std::f64::consts::PI * f64::from(k) / f64::from(n);
                points.push(DVec3::new(theta.sin(), 0.0, theta.cos()));
            }
            // Rounding of the recurrence and of the cosine, whose effect grows as the degree.
            let rounding = 4.0 * f64::EPSILON * coefficients.len() as f64;
            let bound = (ACCURACY + rounding) * kernel.at_one;
            for (k, point) in points.iter().enumerate().skip(1) {
                let pair = Columns::new(&PointSet::new(vec![DVec3::Z, *point]));
                let got = 0.5 * (kernel.row(&pair, 1).kernel - kernel.at_one);
                let expected = sum(&coefficients, point.z);
                assert!((got - expected).abs() <= bound, "{k}: {got}, {expected}, {bound:e}");
            }
            let columns = Columns::new(&PointSet::new(points.clone()));
            let whole: f64 = (0..points.len()).map(|i| kernel.row(&columns, i).kernel).sum();
            let pairs = points.iter().flat_map(|x| points.iter().map(move |y| x.dot(*y)));
            let expected: f64 = pairs.map(|t| sum(&coefficients, t)).sum();
            let bound = bound * (points.len() as f64).powi(2);
            assert!((whole - expected).abs() <= bound, "{whole}, {expected}, {bound:e}");
        }
    }
}
