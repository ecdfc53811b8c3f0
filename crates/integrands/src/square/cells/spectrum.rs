//! Energies of the values on cells, with errors from their misfits.

use sphvar_nufft::{TorusCoefficients, TorusTransform, TorusWorkspace};
use sphvar_sh::{Bands, ByAxis, Frequencies, TailClasses};

use super::Cells;
use super::line::{LineFunction, transform_error};
use super::rules::{LINE_NODES, Rules};
use crate::square::energy::{check_values, zeros};
use crate::{Energy, Error, quadrature};

/// The accuracy of Fourier coefficients, relative to the mean of absolute values.
const EPSILON: f64 = 1e-8;
/// That of the fields of misfits, of which some digits are enough.
const MISFIT_EPSILON: f64 = 1e-3;
/// The standard errors by which an independent estimate of the variance differs significantly: one in
/// 16 000 does by chance.
const SIGNIFICANT: f64 = 4.0;
/// The estimates that are compared: the values, and three that add the misfit of each cell to its
/// values, with signs that are independent, equal at equal u, or equal at equal v.
const ESTIMATES: usize = 4;

/// Integral and energies of a function from values on [`Cells`].
///
/// Rules of n nodes are exact for polynomials of degree 2n - 1, and the component of degree n - 1,
/// the misfit, is what a cell may not resolve. The error of energies is that which the misfits with
/// random signs would cause, an upper estimate for smooth functions and the size of the true error at jumps.
#[derive(Clone, Debug)]
pub(in crate::square) struct CellSpectrum {
    estimates: Vec<Estimate>,
    known: Frequencies,
    pub(in crate::square) integral: (f64, f64),
    pub(in crate::square) kurtosis: Option<f64>,
    /// The largest absolute value, its point, and the area where half of it is exceeded.
    pub(in crate::square) largest: (f64, [f64; 2], f64),
}

/// What is known of the variance of a function apart from its values on cells.
#[derive(Clone, Copy, Debug)]
pub(in crate::square) enum Variance {
    Exact(f64),
    /// An independent estimate with its standard error.
    Estimate(f64, f64),
}

#[derive(Clone, Debug)]
struct Estimate {
    /// `|G_k|^2` of the known bands.
    squares: Vec<f64>,
    along_u: LineFunction,
    along_v: AlongV,
    variances: ByAxis,
}

/// The mean over u.
#[derive(Clone, Debug)]
enum AlongV {
    Line(LineFunction),
    /// `|G_k|^2` of (0, k), continued by `law/k^2` beyond the last.
    Squares {
        squares: Vec<f64>,
        law: f64,
    },
}

impl CellSpectrum {
    /// Returns the energies of the values, with the variance of the function as far as it is known.
    ///
    /// # Errors
    ///
    /// [`Error::Magnitude`] for values whose squares overflow or underflow, [`Error::Harmonics`] and
    /// [`Error::Evaluation`] if memory is exhausted.
    pub(in crate::square) fn new(cells: &Cells<'_>, variance: Variance) -> Result<Self, Error> {
        let values: Vec<f64> = cells.nodes().map(|node| node.value).collect();
        check_values(&values)?;
        let mean = cells.nodes().map(|n| n.weight * (n.value - cells.origin)).sum::<f64>();
        let known = Frequencies::new(cells.kmax)?;
        let fields = Fields::new(cells, cells.origin + mean)?;
        let transforms = fields.transforms(cells.kmax)?;
        let mut estimates = Vec::new();
        for j in 0..ESTIMATES {
            let coefficient = |k: [i32; 2]| {
                let at = |j: usize| transforms[j].get(k[0], k[1]).unwrap_or_default();
                if j == 0 { at(0) } else { at(0) + at(j) }
            };
            let squares = (0..known.len()).map(|b| coefficient(known.frequency(b)).norm_sqr());
            let along_u = fields.along_u(cells, j);
            let total = match variance {
                Variance::Exact(exact) => exact,
                _ => fields.variance(j),
            };
            let u = along_u.variance(&cells.rules).min(total);
            let along_v = match fields.along_v(cells, j) {
                Some(line) => AlongV::Line(line),
                None => {
                    let last = i32::try_from(cells.kmax).unwrap_or(i32::MAX);
                    AlongV::new((0..=last).map(|k| coefficient([0, k]).norm_sqr()).collect())
                }
            };
            let v = along_v.variance(&cells.rules).min(total - u);
            let variances = ByAxis { off: total - u - v, u, v };
            estimates.push(Estimate { squares: squares.collect(), along_u, along_v, variances });
        }
        if let Variance::Estimate(other, error) = variance {
            let mut estimate = estimates[0].clone();
            let excess = other - estimate.variances.sum();
            if excess.abs() > SIGNIFICANT * error {
                estimate.variances.off = (estimate.variances.off + excess).max(0.0);
                estimates.push(estimate);
            }
        }
        let of_mean = (1..ESTIMATES).map(|j| fields.mean(j).abs()).fold(0.0, f64::max);
        let largest = cells.nodes().fold((0.0, [0.5; 2]), |(largest, at), node| {
            if node.value.abs() > largest { (node.value.abs(), node.point) } else { (largest, at) }
        });
        let exceeding = cells.nodes().filter(|node| node.value.abs() > 0.5 * largest.0);
        Ok(Self {
            estimates,
            known,
            integral: (cells.origin + mean, of_mean),
            kurtosis: quadrature::weighted_kurtosis(|| {
                cells.nodes().map(|node| (node.weight, node.value))
            }),
            largest: (largest.0, largest.1, exceeding.map(|node| node.weight).sum()),
        })
    }

    /// Returns the energies with their errors, off the axes to the largest known frequency.
    pub(in crate::square) fn energy(
        &self,
        frequencies: &Frequencies,
    ) -> Result<Energy<Frequencies>, Error> {
        let rules = Rules::new()?;
        let limit = self.known.kmax() as f64;
        let n_bands = if frequencies.kmax() <= self.known.kmax() {
            frequencies.len()
        } else {
            (0..frequencies.len()).take_while(|b| frequencies.radius(*b) <= limit).count()
        };
        let energies = self.estimates.iter().map(|estimate| {
            let axis = frequencies.axis_max();
            let along_u = squares(&estimate.along_u, &rules, axis)?;
            let along_v = match &estimate.along_v {
                AlongV::Line(line) => squares(line, &rules, axis)?,
                AlongV::Squares { squares, law } => {
                    let beyond = (squares.len()..=axis).map(|k| law / (k as f64).powi(2));
                    squares.iter().copied().chain(beyond).collect()
                }
            };
            let mut per_band = zeros(n_bands)?;
            per_band[0] = self.integral.0.powi(2);
            for (band, energy) in per_band.iter_mut().enumerate().skip(1) {
                let k = frequencies.frequency(band);
                *energy = 2.0
                    * match k.map(|k| k.unsigned_abs() as usize) {
                        [k, 0] => along_u[k],
                        [0, k] => along_v[k],
                        _ => self.known.band_of(k).map_or(0.0, |b| estimate.squares[b]),
                    };
            }
            Ok(Energy::new(frequencies.clone(), per_band, estimate.variances))
        });
        let mut energies = energies.collect::<Result<Vec<_>, Error>>()?;
        let energy = energies.remove(0).with_estimates(&energies);
        let (mean, error) = self.integral;
        Ok(energy.with_mean(mean, error))
    }
}

fn squares(line: &LineFunction, rules: &Rules, kmax: usize) -> Result<Vec<f64>, Error> {
    Ok(line.coefficients(rules, kmax)?.iter().map(|c| c.norm_sqr()).collect())
}

impl AlongV {
    /// Returns the function with these `|G_k|^2`; those beyond fall as those of a function that
    /// jumps from v = 1 to 0.
    fn new(squares: Vec<f64>) -> Self {
        let last = squares.len() - 1;
        let octave = last / 2 + 1..=last;
        let n = octave.clone().count().max(1) as f64;
        let law = octave.map(|k| (k as f64).powi(2) * squares[k]).sum::<f64>() / n;
        Self::Squares { squares, law }
    }

    fn variance(&self, rules: &Rules) -> f64 {
        match self {
            Self::Line(line) => line.variance(rules),
            Self::Squares { squares, law } => {
                let beyond = law / (squares.len() as f64 - 0.5);
                2.0 * (squares.iter().skip(1).sum::<f64>() + beyond)
            }
        }
    }
}

/// The values without their mean, and the misfits of the cells with signs.
struct Fields<'c> {
    points: Vec<[f64; 2]>,
    /// The weights of the nodes.
    weights: Vec<f64>,
    /// For every estimate, the values at the nodes of its own field.
    values: [Vec<f64>; ESTIMATES],
    cells: Vec<&'c super::Cell>,
}

impl<'c> Fields<'c> {
    fn new(cells: &'c Cells<'_>, mean: f64) -> Result<Self, Error> {
        let live: Vec<&super::Cell> = cells.live().collect();
        let n: usize = live.iter().map(|cell| cell.len()).sum();
        let mut points = Vec::with_capacity(n);
        let mut weights = Vec::with_capacity(n);
        let mut values: [Vec<f64>; ESTIMATES] = Default::default();
        for values in &mut values {
            *values = zeros(n)?;
        }
        for cell in &live {
            let misfit = (cell.misfit[0] + cell.misfit[1]).sqrt();
            let u = cells.u_intervals.ends(cell.u)[0].to_bits();
            let place = cell.place.share[0].to_bits() ^ ((cell.place.piece as u64) << 32);
            let signs = [sign(u ^ place.rotate_left(17)), sign(u), sign(place)];
            for node in &cells.nodes[cell.first..cell.first + cell.len()] {
                let i = points.len();
                points.push(node.point);
                weights.push(node.weight);
                values[0][i] = node.value - mean;
                for (values, sign) in values[1..].iter_mut().zip(signs) {
                    values[i] = sign * misfit;
                }
            }
        }
        Ok(Self { points, weights, values, cells: live })
    }

    /// Returns the value of an estimate at a node.
    fn value(&self, estimate: usize, i: usize) -> f64 {
        let own = if estimate == 0 { 0.0 } else { self.values[estimate][i] };
        self.values[0][i] + own
    }

    fn mean(&self, estimate: usize) -> f64 {
        self.weights.iter().enumerate().map(|(i, w)| w * self.value(estimate, i)).sum()
    }

    fn variance(&self, estimate: usize) -> f64 {
        let mean = self.mean(estimate);
        let square = |(i, w): (usize, &f64)| w * (self.value(estimate, i) - mean).powi(2);
        self.weights.iter().enumerate().map(square).sum()
    }

    /// Returns the Fourier coefficients of the values and of the fields of misfits.
    fn transforms(&self, kmax: usize) -> Result<Vec<TorusCoefficients>, Error> {
        let weighted = |values: &Vec<f64>| -> Vec<f64> {
            values.iter().zip(&self.weights).map(|(x, w)| x * w).collect()
        };
        let weighted: Vec<Vec<f64>> = self.values.iter().map(weighted).collect();
        let weights: Vec<&[f64]> = weighted.iter().map(Vec::as_slice).collect();
        let mut out: Vec<TorusCoefficients> = (0..ESTIMATES)
            .map(|_| TorusCoefficients::zeros(kmax))
            .collect::<Result<_, _>>()
            .map_err(transform_error)?;
        let workspace = &mut TorusWorkspace::default();
        for (epsilon, range) in [(EPSILON, 0..1), (MISFIT_EPSILON, 1..ESTIMATES)] {
            let transform = TorusTransform::new(kmax, epsilon).map_err(transform_error)?;
            transform
                .adjoint_batch_into(
                    &self.points,
                    &weights[range.clone()],
                    workspace,
                    &mut out[range],
                )
                .map_err(transform_error)?;
        }
        Ok(out)
    }

    /// Returns the integral over v of an estimate.
    fn along_u(&self, cells: &Cells<'_>, estimate: usize) -> LineFunction {
        let mut sums = vec![[0.0; LINE_NODES]; cells.u_intervals.len()];
        let mut first = 0;
        for cell in &self.cells {
            let [low, high] = cells.u_intervals.ends(cell.u);
            let rule = cells.rules.of_order(cell.orders[0]);
            let mut line = [0.0; LINE_NODES];
            for (i, w) in rule.weights.iter().enumerate() {
                let start = first + i * cell.orders[1];
                let sum: f64 = (start..start + cell.orders[1])
                    .map(|k| self.weights[k] * self.value(estimate, k))
                    .sum();
                line[i] = sum / (w * (high - low));
            }
            let at = rule.to_line(&line[..cell.orders[0]]);
            sums[cell.u].iter_mut().zip(at).for_each(|(sum, x)| *sum += x);
            first += cell.len();
        }
        cells.u_intervals.sum(&cells.rules, sums)
    }

    /// Returns the integral over u of an estimate if all cells are rectangles.
    fn along_v(&self, cells: &Cells<'_>, estimate: usize) -> Option<LineFunction> {
        let intervals = cells.v_intervals.as_ref()?;
        let mut sums = vec![[0.0; LINE_NODES]; intervals.len()];
        let mut first = 0;
        for cell in &self.cells {
            let [low, high] = intervals.ends(cell.place.v);
            let rule = cells.rules.of_order(cell.orders[1]);
            let mut line = [0.0; LINE_NODES];
            for (j, w) in rule.weights.iter().enumerate() {
                let column = (first + j..first + cell.len()).step_by(cell.orders[1]);
                let sum: f64 = column.map(|k| self.weights[k] * self.value(estimate, k)).sum();
                line[j] = sum / (w * (high - low));
            }
            let at = rule.to_line(&line[..cell.orders[1]]);
            sums[cell.place.v].iter_mut().zip(at).for_each(|(sum, x)| *sum += x);
            first += cell.len();
        }
        Some(intervals.sum(&cells.rules, sums))
    }
}

/// Returns a sign that is as good as random (the mixing function of splitmix64; Steele, Lea and
/// Flood 2014).
fn sign(key: u64) -> f64 {
    let mut z = key.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    if (z ^ (z >> 31)) & 1 == 0 { 1.0 } else { -1.0 }
}
