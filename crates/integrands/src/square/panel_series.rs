use num_complex::Complex;
use sphvar_sh::{GaussLegendre, legendre_p_into};

use super::energy::zeros;
use super::spherical_bessel::spherical_bessel;
use super::turns::cis_turns;
use crate::Error;

/// The number of Legendre coefficients on a panel.
const TERMS: usize = 48;

/// The largest number of bisections from the interval to a panel.
const MAX_DEPTH: u32 = 40;

/// Functions of one coordinate on [0, 1], as constants and Legendre series on panels that all
/// functions share.
///
/// Panels are intervals `[j, j + 1]/2^d`, so that k times their middles and lengths is exact and the
/// Fourier coefficients have the period of their phases to the last digit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PanelSeries {
    means: Vec<f64>,
    /// The means of the series.
    series_means: Vec<f64>,
    panels: Vec<Panel>,
}

/// An interval with the Legendre coefficients of every function on it.
#[derive(Clone, Debug, PartialEq)]
struct Panel {
    middle: f64,
    half: f64,
    series: Vec<[f64; TERMS]>,
}

/// A function as a constant plus a function that is evaluated without cancellation.
pub(super) struct Offset<'a> {
    /// The constant.
    pub(super) constant: f64,
    /// The function minus the constant, at the sum of its arguments: the middle of a panel and the
    /// distance from it.
    pub(super) deviation: &'a (dyn Fn(f64, f64) -> f64 + 'a),
}

impl PanelSeries {
    /// Returns the series of functions on panels [a, b] for which `is_resolved(a, b)`: there every
    /// function must be a polynomial of degree 47 to rounding, as `e^{ix}` is over an interval of 28
    /// radians and `e^{-x^2/2}` over one of 8.
    pub(super) fn new(
        functions: &[Offset<'_>],
        is_resolved: impl Fn(f64, f64) -> bool,
    ) -> Result<Self, Error> {
        let rule = GaussLegendre::new(TERMS)?;
        let mut panels: Vec<Panel> = Vec::new();
        let mut pending = vec![(0.5, 0.5, 0)];
        while let Some((middle, half, depth)) = pending.pop() {
            if depth < MAX_DEPTH && !is_resolved(middle - half, middle + half) {
                let quarter: f64 = 0.5 * half;
                pending.push((middle + quarter, quarter, depth + 1));
                pending.push((middle - quarter, quarter, depth + 1));
                continue;
            }
            let series = |function: &Offset<'_>| series(&rule, middle, half, function.deviation);
            let series = functions.iter().map(series).collect::<Result<_, _>>()?;
            panels.push(Panel { middle, half, series });
        }
        // Panels of equal lengths share the Bessel functions.
        panels.sort_by(|a, b| b.half.total_cmp(&a.half));
        let mean =
            |r: usize| panels.iter().map(|panel| 2.0 * panel.half * panel.series[r][0]).sum();
        let series_means: Vec<f64> = (0..functions.len()).map(mean).collect();
        let means = functions.iter().zip(&series_means).map(|(f, mean)| f.constant + mean);
        Ok(Self { means: means.collect(), series_means, panels })
    }

    /// Returns the means of the functions.
    pub(super) fn means(&self) -> &[f64] {
        &self.means
    }

    /// Returns the single function `sum_r weights[r] f_r`.
    pub(super) fn combined(&self, weights: &[f64]) -> Self {
        let combine = |panel: &Panel| {
            let mut sum = [0.0; TERMS];
            for (series, weight) in panel.series.iter().zip(weights) {
                sum.iter_mut().zip(series).for_each(|(sum, c)| *sum += weight * c);
            }
            Panel { series: vec![sum], ..*panel }
        };
        let sum = |means: &[f64]| {
            vec![means.iter().zip(weights).map(|(mean, weight)| mean * weight).sum()]
        };
        let panels = self.panels.iter().map(combine).collect();
        Self { means: sum(&self.means), series_means: sum(&self.series_means), panels }
    }

    /// Returns the covariance of two functions, the integral of their product without the means.
    pub(super) fn covariance(&self, r: usize, s: usize) -> f64 {
        let of_panel = |panel: &Panel| {
            let (a, b) = (&panel.series[r], &panel.series[s]);
            let first = (a[0] - self.series_means[r]) * (b[0] - self.series_means[s]);
            let terms = a.iter().zip(b).enumerate().skip(1);
            let rest: f64 = terms.map(|(n, (a, b))| a * b / (2 * n + 1) as f64).sum();
            2.0 * panel.half * (first + rest)
        };
        self.panels.iter().map(of_panel).sum()
    }

    /// Returns weights that add up to 1, and the values of every function without its mean, at
    /// Gauss-Legendre nodes of every panel.
    pub(super) fn values(&self, nodes_per_panel: usize) -> Result<Vec<(f64, Vec<f64>)>, Error> {
        let rule = GaussLegendre::new(nodes_per_panel)?;
        let nodes = || rule.nodes().iter().zip(rule.weights());
        let polynomials = nodes().map(|(&x, _)| legendre(x)).collect::<Result<Vec<_>, _>>()?;
        let at = |panel: &Panel, p: &[f64; TERMS]| {
            let value =
                |c: &[f64; TERMS]| c[1..].iter().zip(&p[1..]).map(|(c, p)| c * p).sum::<f64>();
            let of_functions = panel.series.iter().zip(&self.series_means);
            of_functions.map(|(c, mean)| (c[0] - mean) + value(c)).collect()
        };
        let of_panel = |panel: &'_ Panel| -> Vec<(f64, Vec<f64>)> {
            let of_nodes = nodes().zip(&polynomials);
            of_nodes.map(|((_, w), p)| (w * panel.half, at(panel, p))).collect()
        };
        Ok(self.panels.iter().flat_map(of_panel).collect())
    }

    /// Returns the number of panels.
    pub(super) fn n_panels(&self) -> usize {
        self.panels.len()
    }

    /// Returns the Fourier coefficients `int f(x) exp(-2 pi i k x) dx` for k = 0 ..= `kmax` of every
    /// function without its mean.
    ///
    /// A Legendre polynomial has the transform `2 (-i)^n j_n`, so that rounding errors fall with k
    /// as the coefficients of a jump do.
    ///
    /// Cost: some 50 multiplications per panel, frequency and function.
    pub(super) fn coefficients(&self, kmax: usize) -> Result<Vec<Vec<Complex<f64>>>, Error> {
        let mut coefficients =
            (0..self.means.len()).map(|_| zeros(kmax + 1)).collect::<Result<Vec<_>, _>>()?;
        let mut bessel = [0.0; TERMS];
        let is_zero = |panel: &Panel| panel.series.as_flattened().iter().all(|c| *c == 0.0);
        let panels: Vec<&Panel> = self.panels.iter().filter(|panel| !is_zero(panel)).collect();
        for same in panels.chunk_by(|a, b| a.half.to_bits() == b.half.to_bits()) {
            let half = same[0].half;
            let roots = RootsOfUnity::new(half, kmax);
            for k in 1..=kmax {
                let frequency = k as f64;
                spherical_bessel(frequency * half, &mut bessel);
                for panel in same {
                    let phase = roots.at(frequency * panel.middle) * (2.0 * half);
                    for (series, out) in panel.series.iter().zip(&mut coefficients) {
                        out[k] += phase * transform(series, &bessel);
                    }
                }
            }
        }
        Ok(coefficients)
    }
}

/// The numbers `exp(-2 pi i t)` at multiples t of a power of 1/2.
struct RootsOfUnity {
    /// The number of roots, the reciprocal of that power.
    count: f64,
    /// The roots; none if they are too many to be worth a table.
    table: Vec<Complex<f64>>,
}

impl RootsOfUnity {
    /// Returns the roots at multiples of `step`, a table of them unless they are more than `kmax`.
    fn new(step: f64, kmax: usize) -> Self {
        let count = 1.0 / step;
        let indices = (0..=kmax).map(|i| i as f64).take_while(|i| *i < count);
        let is_small = count <= kmax as f64;
        let table = indices.filter(|_| is_small).map(|i| cis_turns(-i * step)).collect();
        Self { count, table }
    }

    /// Returns the root at t >= 0.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the fraction of a turn is an index of the table"
    )]
    fn at(&self, t: f64) -> Complex<f64> {
        let index = (t - t.floor()) * self.count;
        self.table.get(index as usize).copied().unwrap_or_else(|| cis_turns(-t))
    }
}

/// Returns the Legendre coefficients of a function on a panel from its values at the nodes of a
/// rule.
fn series(
    rule: &GaussLegendre,
    middle: f64,
    half: f64,
    function: impl Fn(f64, f64) -> f64,
) -> Result<[f64; TERMS], Error> {
    let mut series = [0.0; TERMS];
    for (&x, &weight) in rule.nodes().iter().zip(rule.weights()) {
        let value = 0.5 * weight * function(middle, half * x);
        for (n, (c, p)) in series.iter_mut().zip(legendre(x)?).enumerate() {
            *c += (2 * n + 1) as f64 * value * p;
        }
    }
    Ok(series)
}

/// Returns the Legendre polynomials of all orders at x.
fn legendre(x: f64) -> Result<[f64; TERMS], Error> {
    let mut p = [0.0; TERMS];
    legendre_p_into(x, &mut p)?;
    Ok(p)
}

/// Returns `sum_n (-i)^n c_n j_n`.
fn transform(series: &[f64; TERMS], bessel: &[f64; TERMS]) -> Complex<f64> {
    let mut sums = [0.0; 4];
    for (c, j) in series.as_chunks::<4>().0.iter().zip(bessel.as_chunks::<4>().0) {
        for ((sum, c), j) in sums.iter_mut().zip(c).zip(j) {
            *sum += c * j;
        }
    }
    Complex::new(sums[0] - sums[2], sums[3] - sums[1])
}
