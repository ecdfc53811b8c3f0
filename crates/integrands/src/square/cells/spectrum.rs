//! Energies of the values on cells, with errors from their misfits.

use sphvar_nufft::{TorusCoefficients, TorusTransform, TorusWorkspace};
use sphvar_sh::{Bands, ByAxis, Frequencies, TailClasses};

use super::line::{Intervals, LineFunction, LineTransform, transform_error};
use super::rules::{LINE_NODES, Rules};
use super::{Cell, Cells};
use crate::square::energy::{check_values, zeros};
use crate::{Energy, Error, quadrature};

/// The accuracy of Fourier coefficients, relative to the mean of absolute values.
const EPSILON: f64 = 1e-8;
/// That of the coefficients of shifts, of which some digits are enough.
const SHIFT_EPSILON: f64 = 1e-3;
/// The standard errors by which an independent estimate of the variance differs significantly: one in
/// 16 000 does by chance.
const SIGNIFICANT: f64 = 4.0;
/// The other estimates that are compared, which add the misfit of each cell to its values, with
/// signs that are independent, equal at equal u, or equal at equal v.
const OTHERS: usize = 3;

/// Integral and energies of a function from values on [`Cells`].
///
/// Rules of n nodes are exact for polynomials of degree 2n - 1, and the component of degree n - 1,
/// the misfit, is what a cell may not resolve. The error of energies is that which the misfits with
/// random signs would cause, an upper estimate for smooth functions and the size of the true error at jumps.
#[derive(Clone, Debug)]
pub(in crate::square) struct CellSpectrum {
    estimates: Vec<Estimate>,
    /// Another estimate of the variance off the axes, if it differs significantly.
    other_off: Option<f64>,
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
    /// `|G_k|^2` of (0, k), continued by `decay/k^2` beyond the last.
    Squares {
        squares: Vec<f64>,
        decay: f64,
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
        let known = Frequencies::new(cells.kmax)?;
        let fields = Fields::new(cells);
        let transforms = fields.transforms(cells.kmax)?;
        let along_u = fields.along(0, &cells.rules, &cells.u_intervals, |cell| cell.u);
        let along_v = cells.v_intervals.as_ref().map(|intervals| {
            fields.along(1, &cells.rules, intervals, |cell| cell.place.v).map(AlongV::Line)
        });
        let last = i32::try_from(cells.kmax).unwrap_or(i32::MAX);
        let mut along_v = along_v.into_iter().flatten();
        let mut estimates = Vec::new();
        let mut of_mean = 0.0f64;
        for (j, along_u) in along_u.into_iter().enumerate() {
            let coefficient = |k: [i32; 2]| {
                let at = |j: usize| transforms[j].get(k[0], k[1]).unwrap_or_default();
                if j == 0 { at(0) } else { at(0) + at(j) }
            };
            let squares = (0..known.len()).map(|b| coefficient(known.frequency(b)).norm_sqr());
            let (mean, own) = fields.moments(cells.origin, j);
            of_mean = of_mean.max(mean.abs());
            let total = match variance {
                Variance::Exact(exact) => exact,
                Variance::Estimate(..) => own,
            };
            let u = along_u.variance(&cells.rules).min(total);
            let along_v = along_v.next().unwrap_or_else(|| {
                AlongV::new((0..=last).map(|k| coefficient([0, k]).norm_sqr()).collect())
            });
            let v = along_v.variance(&cells.rules).min(total - u);
            let variances = ByAxis { off: total - u - v, u, v };
            estimates.push(Estimate { squares: squares.collect(), along_u, along_v, variances });
        }
        let mut other_off = None;
        if let Variance::Estimate(other, error) = variance {
            let own = estimates[0].variances;
            let excess = other - own.sum();
            other_off = (excess.abs() > SIGNIFICANT * error).then(|| (own.off + excess).max(0.0));
        }
        let largest = cells.nodes().fold((0.0, [0.5; 2]), |(largest, at), node| {
            if node.value.abs() > largest { (node.value.abs(), node.point) } else { (largest, at) }
        });
        let exceeding = cells.nodes().filter(|node| node.value.abs() > 0.5 * largest.0);
        Ok(Self {
            estimates,
            other_off,
            known,
            integral: (fields.mean, of_mean),
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
        let limit = self.known.kmax() as f64;
        let n_bands = if frequencies.kmax() <= self.known.kmax() {
            frequencies.len()
        } else {
            (0..frequencies.len()).take_while(|b| frequencies.radius(*b) <= limit).count()
        };
        let axis = frequencies.axis_max();
        let mut transform = LineTransform::new(axis)?;
        let mut all = Vec::new();
        for estimate in &self.estimates {
            let along_u = transform.squares(&estimate.along_u)?;
            let along_v = match &estimate.along_v {
                AlongV::Line(line) => transform.squares(line)?,
                AlongV::Squares { squares, decay } => {
                    let beyond = (squares.len()..=axis).map(|k| decay / (k as f64).powi(2));
                    squares.iter().copied().chain(beyond).collect()
                }
            };
            let mut per_band = zeros(n_bands)?;
            per_band[0] = self.integral.0.powi(2);
            all.push((estimate, along_u, along_v, per_band));
        }
        for band in 1..n_bands {
            let k = frequencies.frequency(band);
            let [k1, k2] = k.map(|k| k.unsigned_abs() as usize);
            let off = if k1 == 0 || k2 == 0 { None } else { self.known.band_of(k) };
            for (estimate, along_u, along_v, per_band) in &mut all {
                per_band[band] = 2.0
                    * match [k1, k2] {
                        [k, 0] => along_u[k],
                        [0, k] => along_v[k],
                        _ => off.map_or(0.0, |b| estimate.squares[b]),
                    };
            }
        }
        let energy = |(estimate, _, _, per_band): (&Estimate, _, _, Vec<f64>)| {
            Energy::new(frequencies.clone(), per_band, estimate.variances)
        };
        let mut energies: Vec<_> = all.into_iter().map(energy).collect();
        if let Some(off) = self.other_off {
            let centred = ByAxis { off, ..energies[0].centred() };
            let per_band = energies[0].per_band().to_vec();
            energies.push(Energy::new(frequencies.clone(), per_band, centred));
        }
        let energy = energies.remove(0).with_estimates(&energies);
        let (mean, error) = self.integral;
        Ok(energy.with_mean(mean, error))
    }
}

impl AlongV {
    /// Returns the function with these `|G_k|^2`; those beyond fall as those of a function that
    /// jumps from v = 1 to 0.
    fn new(squares: Vec<f64>) -> Self {
        let last = squares.len() - 1;
        let octave = last / 2 + 1..=last;
        let n = octave.clone().count().max(1) as f64;
        let decay = octave.map(|k| (k as f64).powi(2) * squares[k]).sum::<f64>() / n;
        Self::Squares { squares, decay }
    }

    fn variance(&self, rules: &Rules) -> f64 {
        match self {
            Self::Line(line) => line.variance(rules),
            Self::Squares { squares, decay } => {
                let beyond = decay / (squares.len() as f64 - 0.5);
                2.0 * (squares.iter().skip(1).sum::<f64>() + beyond)
            }
        }
    }
}

/// The values without their mean, and a shift of each cell for every other estimate.
struct Fields<'c> {
    cells: Vec<&'c Cell>,
    points: Vec<[f64; 2]>,
    /// The values times their weights.
    weighted: Vec<f64>,
    /// For every other estimate, the misfits of the cells with its signs.
    shifts: [Vec<f64>; OTHERS],
    mean: f64,
}

impl<'c> Fields<'c> {
    fn new(all: &'c Cells<'_>) -> Self {
        let mean = all.integral();
        let cells: Vec<&Cell> = all.live().collect();
        let mut shifts: [Vec<f64>; OTHERS] = Default::default();
        for cell in &cells {
            let misfit = (cell.misfit[0] + cell.misfit[1]).sqrt();
            let u = all.u_intervals.ends(cell.u)[0].to_bits();
            let place = cell.place.share[0].to_bits() ^ ((cell.place.piece as u64) << 32);
            let signs = [sign(u ^ place.rotate_left(17)), sign(u), sign(place)];
            for (shifts, sign) in shifts.iter_mut().zip(signs) {
                shifts.push(sign * misfit);
            }
        }
        let points = all.nodes().map(|node| node.point).collect();
        let weighted = all.nodes().map(|node| node.weight * (node.value - mean)).collect();
        Self { cells, points, weighted, shifts, mean }
    }

    /// Returns the shift of a cell in an estimate, of which 0 are the values.
    fn shift(&self, estimate: usize, cell: usize) -> f64 {
        if estimate == 0 { 0.0 } else { self.shifts[estimate - 1][cell] }
    }

    /// Returns the mean of an estimate without that of the values, and its variance.
    fn moments(&self, origin: f64, estimate: usize) -> (f64, f64) {
        let (mut first, mut second) = (0.0, 0.0);
        for (i, cell) in self.cells.iter().enumerate() {
            // Moments about the mean from those about the origin.
            let (shift, offset) = (self.shift(estimate, i), self.mean - origin);
            let centred = cell.moments[0] - cell.area * offset;
            let square = cell.moments[1] - offset * (cell.moments[0] + centred);
            first += centred + cell.area * shift;
            second += square + shift * (2.0 * centred + cell.area * shift);
        }
        (first, (second - first * first).max(0.0))
    }

    /// Returns the Fourier coefficients of the values, and of the shifts as masses at the centres of
    /// cells.
    fn transforms(&self, kmax: usize) -> Result<Vec<TorusCoefficients>, Error> {
        let centre = |(cell, first): (&&Cell, usize)| {
            let middle = (cell.orders[0] / 2) * cell.orders[1] + cell.orders[1] / 2;
            self.points[first + middle]
        };
        let mut before = 0;
        let starts = self.cells.iter().map(|cell| {
            before += cell.len();
            before - cell.len()
        });
        let centres: Vec<[f64; 2]> = self.cells.iter().zip(starts).map(centre).collect();
        let masses = |shifts: &Vec<f64>| -> Vec<f64> {
            self.cells.iter().zip(shifts).map(|(cell, shift)| cell.area * shift).collect()
        };
        let masses = self.shifts.each_ref().map(masses);
        let mut out: Vec<TorusCoefficients> = (0..=OTHERS)
            .map(|_| TorusCoefficients::zeros(kmax))
            .collect::<Result<_, _>>()
            .map_err(transform_error)?;
        let workspace = &mut TorusWorkspace::default();
        TorusTransform::new(kmax, EPSILON)
            .and_then(|transform| {
                let weights = Some(&self.weighted[..]);
                transform.adjoint_into(&self.points, weights, workspace, &mut out[0])
            })
            .map_err(transform_error)?;
        TorusTransform::new(kmax, SHIFT_EPSILON)
            .and_then(|transform| {
                let weights = masses.each_ref().map(Vec::as_slice);
                transform.adjoint_batch_into(&centres, &weights, workspace, &mut out[1..])
            })
            .map_err(transform_error)?;
        Ok(out)
    }

    /// Returns the integral over the other coordinate of an estimate, from the intervals of this one
    /// (0 for u, 1 for v) and that of each cell.
    fn along(
        &self,
        coordinate: usize,
        rules: &Rules,
        intervals: &Intervals,
        interval: impl Fn(&Cell) -> usize,
    ) -> [LineFunction; 1 + OTHERS] {
        let mut sums: [Vec<[f64; LINE_NODES]>; 1 + OTHERS] = Default::default();
        for sums in &mut sums {
            sums.resize(intervals.len(), [0.0; LINE_NODES]);
        }
        let mut first = 0;
        for (i, cell) in self.cells.iter().enumerate() {
            let own = interval(cell);
            let [low, high] = intervals.ends(own);
            let order = cell.orders[coordinate];
            let rule = rules.of_order(order);
            let mut line = [0.0; LINE_NODES];
            for (k, weighted) in self.weighted[first..first + cell.len()].iter().enumerate() {
                let place = if coordinate == 0 { k / cell.orders[1] } else { k % cell.orders[1] };
                line[place] += weighted / (rule.weights[place] * (high - low));
            }
            let at = rule.to_line(&line[..order]);
            let extent = cell.area / (high - low);
            for (estimate, sums) in sums.iter_mut().enumerate() {
                let shift = self.shift(estimate, i) * extent;
                sums[own].iter_mut().zip(at).for_each(|(sum, x)| *sum += x + shift);
            }
            first += cell.len();
        }
        sums.map(|sums| intervals.sum(rules, sums))
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
