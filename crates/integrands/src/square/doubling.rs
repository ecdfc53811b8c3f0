use sphvar_sh::{Bands, ByAxis, Frequencies, TailClasses};

use super::energy::{check_values, zeros};
use super::grid::Grid;
use super::legendre_expansion::{LegendreExpansion, RuleValues};
use crate::{Energy, Error, SquareIntegrand, quadrature};

/// The relative error of all energies below which a function counts as known to rounding: the next
/// doubling squares it for smooth functions.
const RESOLVED: f64 = 1e-10;
/// The largest number of nodes along a side of the Gauss-Legendre rules.
const MAX_NODES: usize = 256;
/// The points along a side of the first two grids; each further one has twice those of the last but
/// one.
const FIRST_GRIDS: [usize; 2] = [24, 34];
/// The number of grids that are compared: errors at an edge along a side are the same by chance on
/// two of them in some percent of the cases.
const COMPARED: usize = 4;
/// The values of as many grids, the first ones.
const FIRST_VALUES: usize = 5 * (24 * 24 + 34 * 34);
/// The number of values that are requested together.
const BATCH: usize = 1 << 17;

/// Integral and energies of a function from growing numbers of values.
#[derive(Clone, Debug)]
pub(super) struct SquareEstimate {
    energies: Energies,
    pub(super) integral: (f64, f64),
    pub(super) kurtosis: Option<f64>,
    pub(super) n_evaluations: usize,
    pub(super) relative_error: f64,
    rounding: Rounding,
}

/// The errors of energies that rounding of the values alone produces.
#[derive(Clone, Copy, Debug)]
struct Rounding {
    /// The error of a value, some units of its size, with the mean.
    of_value: f64,
    /// The error of the sum of all energies.
    of_total: f64,
    /// Whether this is too much for energies that count as exact.
    is_relevant: bool,
}

impl Rounding {
    fn new(total: f64, mean: f64) -> Self {
        let of_value = 16.0 * f64::EPSILON * (total + mean * mean).sqrt();
        let of_total = of_value * (total.sqrt() + of_value);
        // Values that are all the same have no error.
        Self { of_value, of_total, is_relevant: total > 0.0 && of_total > RESOLVED * total }
    }

    /// Returns the energies of a function with independent errors of `n` x `n` values on top: those
    /// of the sum of two functions are at most the square of the sum of both roots.
    fn added(self, energy: &Energy<Frequencies>, n: usize) -> Energy<Frequencies> {
        let n = n as f64;
        let sum = |e: f64, share: f64| (e.sqrt() + share.sqrt() * self.of_value).powi(2);
        let bands = energy.bands();
        let of_band = |(band, e): (usize, &f64)| {
            let is_known = band > 0 && bands.radius(band) <= 0.5 * n;
            if is_known { sum(*e, bands.multiplicity(band) / (n * n)) } else { *e }
        };
        let per_band = energy.per_band().iter().enumerate().map(of_band).collect();
        let ByAxis { off, u, v } = energy.centred();
        let centred = ByAxis { off: sum(off, 1.0), u: sum(u, 1.0 / n), v: sum(v, 1.0 / n) };
        Energy::new(bands.clone(), per_band, centred)
    }
}

#[derive(Clone, Debug)]
enum Energies {
    /// Of the polynomial that the function equals to rounding.
    Polynomial {
        fine: LegendreExpansion,
        /// That of half as many nodes along a side, if rounding is relevant.
        coarse: Option<LegendreExpansion>,
    },
    /// Of the last grid and those before, of which the others are compared.
    Estimated(Vec<GridEnergies>),
}

/// The energies of the values of a grid, to the frequencies that all compared grids know.
#[derive(Clone, Debug)]
struct GridEnergies {
    /// The number of points along a side.
    n: usize,
    mean: f64,
    variances: ByAxis,
    /// `|G_k|^2` of the bands of `known`.
    squares: Vec<f64>,
    known: Frequencies,
}

impl SquareEstimate {
    /// Returns the estimate at which the relative error is at most `relative` after at least `min`
    /// values, or the last one within `max`, at least 14290.
    ///
    /// Product rules of 16, 32, ... Gauss-Legendre nodes along a side come first, which resolve
    /// smooth functions, also where they are not periodic; then grids of 24, 34, 48, ... points.
    pub(super) fn new(
        function: &dyn SquareIntegrand,
        relative: f64,
        [min, max]: [usize; 2],
    ) -> Result<Self, Error> {
        match Self::of_polynomial(function, MAX_NODES, [min, max])? {
            (Some(resolved), _) => Ok(resolved),
            (None, n_evaluations) => Self::of_grids(function, relative, [min, max], n_evaluations),
        }
    }

    /// Returns the exact energies of a function that product rules of 16, 32, ... up to `max_nodes`
    /// Gauss-Legendre nodes along a side resolve, and the number of values taken.
    pub(super) fn of_polynomial(
        function: &dyn SquareIntegrand,
        max_nodes: usize,
        [min, max]: [usize; 2],
    ) -> Result<(Option<Self>, usize), Error> {
        let mut n_evaluations = 0;
        let mut coarse: Option<LegendreExpansion> = None;
        let mut len = 16;
        // Most of the values are left for the grids.
        while len <= max_nodes
            && (8 * len * len).max(n_evaluations + len * len + FIRST_VALUES) <= max
        {
            let values =
                RuleValues::new(len, |points, values| values_into(function, points, values))?;
            n_evaluations += len * len;
            let kurtosis = values.kurtosis();
            let fine = values.expansion()?;
            let total = fine.variances().sum();
            let rounding = Rounding::new(total, fine.mean());
            if n_evaluations >= min
                && let Some(previous) = &coarse
                && let error = fine.distance(previous)
                && error <= (RESOLVED * total).max(rounding.of_total)
            {
                let (mut relative_error, mut of_mean) = (error / total, 0.0);
                if rounding.is_relevant {
                    relative_error = rounding.of_total / total;
                    of_mean = rounding.of_value.max((fine.mean() - previous.mean()).abs());
                } else if error <= rounding.of_total {
                    relative_error = 0.0;
                }
                let resolved = Self {
                    integral: (fine.mean(), of_mean),
                    energies: Energies::Polynomial {
                        fine,
                        coarse: coarse.filter(|_| rounding.is_relevant),
                    },
                    kurtosis: kurtosis.filter(|_| total > rounding.of_value.powi(2)),
                    n_evaluations,
                    relative_error,
                    rounding,
                };
                return Ok((Some(resolved), n_evaluations));
            }
            coarse = Some(fine);
            len *= 2;
        }
        Ok((None, n_evaluations))
    }

    fn of_grids(
        function: &dyn SquareIntegrand,
        relative: f64,
        [min, max]: [usize; 2],
        mut n_evaluations: usize,
    ) -> Result<Self, Error> {
        let mut rules: Vec<GridEnergies> = Vec::new();
        let mut sizes = FIRST_GRIDS;
        loop {
            let [n, following] = sizes;
            let grid = grid_values(function, n)?;
            n_evaluations += n * n;
            rules.insert(0, GridEnergies::new(&grid, n)?);
            rules.truncate(COMPARED);
            sizes = [following, 2 * n];
            if rules.len() < COMPARED {
                continue;
            }
            let known = rules[COMPARED - 1].known.clone();
            let mut others = energies_of_grids(&rules, &known)?;
            let energy = others.remove(0).with_estimates(&others);
            let (total, mean) = (rules[0].variances.sum(), rules[0].mean);
            let of_bands = energy.per_band_stderr().unwrap_or_default().iter().skip(1).sum::<f64>();
            let mut error = of_bands + energy.centred_stderr().sum();
            let rounding = Rounding::new(total, mean);
            let is_enough = error <= (relative * total).max(rounding.of_total);
            let is_last = n_evaluations.saturating_add(following * following) > max;
            if (is_enough && n_evaluations >= min) || is_last {
                let deviations = rules.iter().map(|rule| (rule.mean - mean).abs());
                let mut of_mean = deviations.fold(0.0, f64::max);
                if rounding.is_relevant {
                    error = error.max(rounding.of_total);
                    of_mean = of_mean.max(rounding.of_value);
                }
                return Ok(Self {
                    integral: (mean, of_mean),
                    energies: Energies::Estimated(rules),
                    kurtosis: grid.kurtosis().filter(|_| total > rounding.of_value.powi(2)),
                    n_evaluations,
                    relative_error: if total > 0.0 { error / total } else { 0.0 },
                    rounding,
                });
            }
        }
    }

    /// Returns whether the energies are exact to rounding.
    pub(super) fn is_exact(&self) -> bool {
        matches!(self.energies, Energies::Polynomial { .. }) && !self.rounding.is_relevant
    }

    /// Returns the energies; estimates end at an eighth of the points along a side of the last grid.
    pub(super) fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        let (energy, mut others, n) = match &self.energies {
            Energies::Polynomial { fine, coarse } => {
                let others = coarse.iter().map(|coarse| coarse.energy(frequencies));
                (fine.energy(frequencies)?, others.collect::<Result<_, _>>()?, fine.len())
            }
            Energies::Estimated(rules) => {
                let mut energies = energies_of_grids(rules, frequencies)?;
                (energies.remove(0), energies, rules[0].n)
            }
        };
        if self.rounding.is_relevant {
            others.push(self.rounding.added(&energy, n));
        }
        Ok(if others.is_empty() { energy } else { energy.with_estimates(&others) })
    }
}

impl GridEnergies {
    fn new(grid: &Grid, n: usize) -> Result<Self, Error> {
        // The aliases n - k have twice the frequency or more.
        let known = Frequencies::new(n / 3)?;
        let (power, mean, variances) = (grid.power()?, grid.mean, grid.mean_squares());
        let squares = (0..known.len()).map(|band| power.at(known.frequency(band))).collect();
        Ok(Self { n, mean, variances, squares, known })
    }

    /// Returns the energies of the first bands.
    fn energy(
        &self,
        frequencies: &Frequencies,
        n_bands: usize,
    ) -> Result<Energy<Frequencies>, Error> {
        let mut per_band = zeros(n_bands)?;
        per_band[0] = self.mean * self.mean;
        for (band, energy) in per_band.iter_mut().enumerate().skip(1) {
            let known = self.known.band_of(frequencies.frequency(band));
            *energy = 2.0 * known.map_or(0.0, |known| self.squares[known]);
        }
        Ok(Energy::new(frequencies.clone(), per_band, self.variances))
    }
}

/// Returns the energies of every grid, to the last band that all grids know.
fn energies_of_grids(
    rules: &[GridEnergies],
    frequencies: &Frequencies,
) -> Result<Vec<Energy<Frequencies>>, Error> {
    let limits = rules.iter().map(|rule| rule.known.kmax());
    let limit = limits.min().unwrap_or_default() as f64;
    let is_known = |band: &usize| frequencies.radius(*band) <= limit;
    let n_bands = (0..frequencies.len()).take_while(is_known).count();
    rules.iter().map(|rule| rule.energy(frequencies, n_bands)).collect()
}

/// Returns the values on a grid of n x n points. Every n has an offset of its own, so that no two
/// grids have the same errors at edges along the sides.
fn grid_values(function: &dyn SquareIntegrand, n: usize) -> Result<Grid, Error> {
    /// The fraction of the golden ratio.
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let offset = (n as f64 * GOLDEN).fract();
    let place = |i: usize| (i as f64 + offset) / n as f64;
    let mut values = zeros(n * n)?;
    let rows_per_batch = (BATCH / n).max(1);
    for (i, batch) in values.chunks_mut(rows_per_batch * n).enumerate() {
        let first = i * rows_per_batch;
        let rows = first..first + batch.len() / n;
        let points: Vec<[f64; 2]> =
            rows.flat_map(|i| (0..n).map(move |j| [place(j), place(i)])).collect();
        values_into(function, &points, batch)?;
    }
    check_values(&values)?;
    Ok(Grid::new(n, values))
}

/// Writes the values at many points, all of which must be finite.
pub(super) fn values_into(
    function: &dyn SquareIntegrand,
    points: &[[f64; 2]],
    values: &mut [f64],
) -> Result<(), Error> {
    let eval_into = |points: &[[f64; 2]], values: &mut [f64]| function.eval_into(points, values);
    quadrature::finite_values(points, values, eval_into, |[u, v]| format!("u = {u}, v = {v}"))
}
