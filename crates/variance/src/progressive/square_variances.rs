//! Variances of all prefixes of a set of points of the square.

use std::f64::consts::TAU;
use std::ops::Range;

use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use sphvar_integrands::Energy;
use sphvar_samplers::{PointSet, Progress};
use sphvar_sh::{ByAxis, Frequencies, TailClasses};
use sphvar_spectrum::square_tail_power;

use super::space::PrefixVariances;
use crate::Error;

/// The number of frequencies of a row of an axis.
const AXIS_ROW: i32 = 256;
/// The distance of exponentials that are computed without products.
const STEP: i32 = 16;
/// The number of points that are added to a row together.
const BLOCK: usize = 16;
/// The number of parts whose sums are computed in parallel.
const PARTS: usize = 16;
/// The number of partial sums of a row, which allow vector instructions.
const LANES: usize = 4;
/// The nominal work of a frequency of a point.
const FREQUENCY_WORK: f64 = 0.06;

/// The variances of integrating a function of known energies with every prefix of a set.
///
/// Under uniform shifts the variance is the sum of squares
///
/// ```text
/// V_N = sum_b E(b) |S_b|^2/(sum w)^2,   S_k = sum_{j <= N} w_j exp(-2 pi i k . p_j)
/// ```
///
/// over the bands b, to which a point adds one term per frequency. Frequencies beyond the known ones
/// have the power of points with equal coordinates, as in [`predict`](crate::predict).
#[derive(Debug)]
pub(super) struct SquareVariances {
    /// Rows of frequencies, in parts of similar size.
    parts: Vec<Vec<Row>>,
    /// The number of frequencies in the rows.
    n_frequencies: usize,
    /// The largest frequency within a row.
    reach: i32,
    /// The energy beyond the last band.
    tail: ByAxis,
    /// Whether the energies are estimates.
    has_estimates: bool,
}

/// Consecutive frequencies with a common factor of their exponentials.
#[derive(Debug)]
struct Row {
    /// The coordinate of the frequencies, 0 or 1, and the first of them.
    along: usize,
    first: i32,
    /// The coordinate and the frequency of the common factor.
    across: usize,
    frequency: i32,
    energies: Vec<f64>,
}

impl SquareVariances {
    /// Returns the variances for energies of some frequencies.
    pub(super) fn new(energy: &Energy<Frequencies>, frequencies: &Frequencies) -> Self {
        let n_bands = frequencies.len().min(energy.per_band().len());
        let tail = energy.beyond_by_class(n_bands - 1);
        let at = |k: [i32; 2]| {
            let band = frequencies.band_of(k).filter(|band| *band < n_bands);
            band.map_or(0.0, |band| energy.per_band()[band])
        };
        let limit = |k: usize| i32::try_from(k).unwrap_or(i32::MAX);
        let (kmax, axis_max) = (limit(frequencies.kmax()), limit(frequencies.axis_max()));
        let mut rows = Vec::new();
        for axis in [0, 1] {
            let of_axis = |k: i32| if axis == 0 { at([k, 0]) } else { at([0, k]) };
            for start in (0..axis_max).step_by(AXIS_ROW as usize) {
                let last = (start + AXIS_ROW).min(axis_max);
                let energies = (start + 1..=last).map(of_axis).collect();
                rows.push(Row { along: axis, first: 1, across: axis, frequency: start, energies });
            }
        }
        for k2 in 1..=kmax {
            let within =
                |k1: i32| i64::from(k1).pow(2) + i64::from(k2).pow(2) <= i64::from(kmax).pow(2);
            let reach = (0..=kmax).rev().find(|k1| within(*k1)).unwrap_or(0);
            // The frequency on the axis has its own row.
            let of_row = |k1: i32| if k1 == 0 { 0.0 } else { at([k1, k2]) };
            let energies = (-reach..=reach).map(of_row).collect();
            rows.push(Row { along: 0, first: -reach, across: 1, frequency: k2, energies });
        }
        rows.retain(|row| row.energies.iter().any(|e| *e != 0.0));
        let n_frequencies: usize = rows.iter().map(|row| row.energies.len()).sum();
        let (mut parts, mut part): (Vec<Vec<Row>>, Vec<Row>) = (Vec::new(), Vec::new());
        let (mut size, share) = (0, (n_frequencies / PARTS).max(1));
        for row in rows {
            size += row.energies.len();
            part.push(row);
            if size >= share {
                parts.push(std::mem::take(&mut part));
                size = 0;
            }
        }
        parts.push(part);
        let (reach, has_estimates) = (kmax.max(AXIS_ROW), energy.errors().is_some());
        Self { parts, n_frequencies, reach, tail, has_estimates }
    }

    /// Returns the sums `sum_b E(b) |S_b|^2` over the rows of a part for each prefix.
    fn sums(
        &self,
        part: &[Row],
        set: &PointSet<[f64; 2]>,
        last: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Error> {
        let size: usize = part.iter().map(|row| row.energies.len()).sum();
        let mut coefficients: Vec<[Vec<f64>; 2]> =
            part.iter().map(|row| [0, 1].map(|_| vec![0.0; row.energies.len()])).collect();
        let mut sums = vec![0.0; last];
        for start in (0..last).step_by(BLOCK) {
            let points = start..(start + BLOCK).min(last);
            let phases: Vec<[Phases; 2]> =
                points.clone().map(|j| set.points[j].map(|u| Phases::new(u, self.reach))).collect();
            for (row, coefficients) in part.iter().zip(&mut coefficients) {
                for (j, phases) in points.clone().zip(&phases) {
                    let weight = set.weights.get(j).copied().unwrap_or(1.0);
                    let [cos, sin] = phase(set.points[j][row.across], row.frequency);
                    let along = &phases[row.along];
                    sums[j] += row.add([weight * cos, weight * sin], along, coefficients);
                }
            }
            progress.tick(FREQUENCY_WORK * (size * points.len()) as f64)?;
        }
        Ok(sums)
    }

    /// Returns the mean power beyond the last band of each prefix.
    fn tails(
        &self,
        set: &PointSet<[f64; 2]>,
        counts: &[usize],
        progress: &dyn Progress,
    ) -> Result<Vec<ByAxis>, Error> {
        let is_distinct = !self.has_tail() || square_tail_power(set) == ByAxis::all(1.0);
        if is_distinct {
            return Ok(vec![ByAxis::all(1.0); counts.len()]);
        }
        let of_prefix = |&count: &usize| {
            progress.tick(0.0)?;
            let weights = set.weights.iter().take(count).copied().collect();
            Ok(square_tail_power(&PointSet { points: set.points[..count].to_vec(), weights }))
        };
        counts.par_iter().map(of_prefix).collect()
    }
}

impl PrefixVariances<[f64; 2]> for SquareVariances {
    fn has_tail(&self) -> bool {
        self.tail.sum() > 0.0
    }

    fn has_estimates(&self) -> bool {
        self.has_estimates
    }

    fn work(&self, n_points: usize) -> f64 {
        n_points as f64 * FREQUENCY_WORK * self.n_frequencies as f64
    }

    fn of_set(
        &self,
        set: &PointSet<[f64; 2]>,
        counts: &[usize],
        progress: &dyn Progress,
    ) -> Result<Vec<[f64; 2]>, Error> {
        let mut set = set.clone();
        set.normalize_weights();
        let last = counts.last().copied().unwrap_or(0);
        let parts = self.parts.par_iter().map(|part| self.sums(part, &set, last, progress));
        let parts = parts.collect::<Result<Vec<_>, Error>>()?;
        let tails = self.tails(&set, counts, progress)?;
        let (mut weights, mut magnitudes, mut squares, mut next) = (0.0, 0.0, 0.0, 0);
        let of_count = |(&count, power): (&usize, ByAxis)| {
            for k in next..count {
                let weight = set.weights.get(k).copied().unwrap_or(1.0);
                weights += weight;
                magnitudes += f64::abs(weight);
                squares += weight * weight;
            }
            next = count;
            if f64::abs(weights) <= f64::EPSILON * magnitudes {
                return [f64::NAN; 2];
            }
            let sum: f64 = parts.iter().map(|sums| sums[count - 1]).sum();
            let tail = self.tail.dot(power) * squares;
            [(sum + tail) / (weights * weights), tail / (weights * weights)]
        };
        Ok(counts.iter().zip(tails).map(of_count).collect())
    }
}

/// The exponentials `exp(-2 pi i k u)` for |k| up to a limit.
struct Phases {
    reach: i32,
    parts: [Vec<f64>; 2],
}

impl Phases {
    /// Computes every [`STEP`]th exponential and the first ones, and their products.
    fn new(u: f64, reach: i32) -> Self {
        let small: Vec<[f64; 2]> = (0..STEP).map(|k| phase(u, k)).collect();
        let middle = usize::try_from(reach).unwrap_or(0);
        let mut parts = [vec![0.0; 2 * middle + 1], vec![0.0; 2 * middle + 1]];
        for start in (0..=reach).step_by(STEP as usize) {
            let [c, s] = phase(u, start);
            for (k, [cos, sin]) in (start..=reach).zip(&small) {
                let (re, im) = (c * cos - s * sin, c * sin + s * cos);
                let k = usize::try_from(k).unwrap_or(0);
                (parts[0][middle + k], parts[1][middle + k]) = (re, im);
                (parts[0][middle - k], parts[1][middle - k]) = (re, -im);
            }
        }
        Self { reach, parts }
    }

    /// Returns the real and the imaginary parts for consecutive k.
    fn range(&self, first: i32, len: usize) -> [&[f64]; 2] {
        let start = usize::try_from(first + self.reach).unwrap_or(0);
        let range: Range<usize> = start..start + len;
        self.parts.each_ref().map(|part| &part[range.clone()])
    }
}

/// Returns the real and the imaginary part of `exp(-2 pi i k u)`.
fn phase(u: f64, k: i32) -> [f64; 2] {
    // The product in two parts, so that its fraction is accurate.
    let product = u * f64::from(k);
    let rest = u.mul_add(f64::from(k), -product);
    let (sin, cos) = (TAU * (product - product.round() + rest)).sin_cos();
    [cos, -sin]
}

impl Row {
    /// Adds a point to the coefficients, given the common factor with the weight, and returns the
    /// sum of their squares times the energies.
    fn add(&self, [re, im]: [f64; 2], along: &Phases, coefficients: &mut [Vec<f64>; 2]) -> f64 {
        let len = self.energies.len();
        let [cos, sin] = along.range(self.first, len);
        let [real, imaginary] = coefficients;
        let mut sums = [0.0; LANES];
        let whole = len - len % LANES;
        for start in (0..whole).step_by(LANES) {
            let lanes = start..start + LANES;
            let (a, b) = (&mut real[lanes.clone()], &mut imaginary[lanes.clone()]);
            let (c, s, e) = (&cos[lanes.clone()], &sin[lanes.clone()], &self.energies[lanes]);
            for k in 0..LANES {
                a[k] += c[k] * re - s[k] * im;
                b[k] += c[k] * im + s[k] * re;
                sums[k] += e[k] * (a[k] * a[k] + b[k] * b[k]);
            }
        }
        for k in whole..len {
            real[k] += cos[k] * re - sin[k] * im;
            imaginary[k] += cos[k] * im + sin[k] * re;
            sums[0] += self.energies[k] * (real[k].powi(2) + imaginary[k].powi(2));
        }
        sums.iter().sum()
    }
}
