use sphvar_spectrum::{Accumulator, Moments, Realization, Spectrum};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::Energy;

/// A variance computed from spectra, `k sum_{l >= 1} E(l) <P(l)>`, with what is not known of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// The predicted variance of the estimate of the integral.
    pub variance: f64,
    /// Its standard error, from that of the pattern's spectrum; 0 if that is exact, NaN if it comes from a
    /// single realization of a random pattern.
    pub stderr: f64,
    /// The part of `variance` that belongs to degrees beyond the spectrum, where the pattern's power
    /// is taken to be 1: `k (int F^2 - sum_{l <= lmax} E(l))`.
    pub tail: f64,
    /// By how much the tail may be wrong: `tail` times the largest departure from 1 of the pattern's mean power
    /// in the upper octave of the spectrum; see [`predict`].
    pub tail_error: f64,
    /// Realizations less one, the degrees of freedom of `stderr`; infinite for an exact spectrum.
    pub dof: f64,
}

impl Prediction {
    /// The end points of an interval for the variance: Student's at `confidence`, within (0, 1), for the error of the
    /// spectrum, widened on both sides by the whole error of the tail, and never below 0.
    ///
    /// NaN for a confidence out of range or an unknown error.
    #[must_use]
    pub fn interval(&self, confidence: f64) -> (f64, f64) {
        let half = self.quantile(0.5 + 0.5 * confidence) * self.stderr + self.tail_error;
        if half.is_nan() {
            return (f64::NAN, f64::NAN);
        }
        ((self.variance - half).max(0.0), self.variance + half)
    }

    /// The standard error of the variance with that of the tail, taken for one standard deviation.
    #[must_use]
    pub fn total_stderr(&self) -> f64 {
        self.stderr.hypot(self.tail_error)
    }

    fn quantile(&self, p: f64) -> f64 {
        if !(p > 0.5 && p < 1.0) {
            f64::NAN
        } else if self.dof.is_finite() {
            StudentsT::new(0.0, 1.0, self.dof).map_or(f64::NAN, |t| t.inverse_cdf(p))
        } else {
            Normal::standard().inverse_cdf(p)
        }
    }
}

/// The variance `k sum_{l >= 1} E(l) <P(l)>` of integrating a function of energies E with a pattern
/// of spectrum P; k is [`Domain::variance_factor`](sphvar_samplers::Domain::variance_factor).
///
/// Degrees beyond the smaller of the two lmax, L, enter with P = 1, the mean power that any pattern
/// tends to. How far that may be off is judged by the octave below: it is cut into windows of about
/// `sqrt(N)` degrees, over which the peaks of lattices and the oscillations of random patterns level
/// out,
///
/// ```text
/// tail error = tail max_windows |<P>_E - 1|,   <P>_E = sum_window E(l) P(l) / sum_window E(l)
/// ```
///
/// and where the integrand has no energy in that octave, but has some beyond, the whole tail is its error. Where
/// the power is settled the mean of the tail is closer to 1 than that of the worst window; where L is far below
/// `sqrt(N)` the error is nearly the tail itself.
///
/// The standard error treats the errors of different degrees as independent, since a [`Spectrum`] has one
/// error per degree only; [`PredictionAccumulator`] does without that assumption.
///
/// # Panics
///
/// If spectrum and energy belong to different domains.
#[must_use]
pub fn predict(spectrum: &Spectrum, energy: &Energy) -> Prediction {
    assert_eq!(spectrum.domain(), energy.domain(), "spectra of different domains");
    let weights = Weights::new(energy, spectrum.n_points(), spectrum.lmax());
    let errors = weights.per_degree.iter().zip(spectrum.stderr()).map(|(w, e)| w * e);
    let windows: Vec<f64> = weights.windows.iter().map(|w| w.mean(spectrum.power())).collect();
    Prediction {
        variance: weights.apply(spectrum.power()) + weights.tail,
        stderr: errors.map(|e| e * e).sum::<f64>().sqrt(),
        tail: weights.tail,
        tail_error: weights.tail_error(&windows),
        dof: if spectrum.is_exact() {
            f64::INFINITY
        } else {
            spectrum.realizations().saturating_sub(1) as f64
        },
    }
}

/// What one integrand makes of a pattern's power: `sum_l per_degree[l] P(l) + tail`.
#[derive(Clone, Debug)]
struct Weights {
    per_degree: Vec<f64>,
    tail: f64,
    windows: Vec<Window>,
}

/// Consecutive degrees from `first` on, with weights whose sum is 1.
#[derive(Clone, Debug)]
struct Window {
    first: usize,
    weights: Vec<f64>,
}

impl Window {
    fn mean(&self, power: &[f64]) -> f64 {
        self.weights.iter().zip(&power[self.first..]).map(|(w, p)| w * p).sum()
    }
}

impl Weights {
    fn new(energy: &Energy, n_points: usize, lmax: usize) -> Self {
        let factor = energy.domain().variance_factor(n_points);
        let lmax = lmax.min(energy.lmax());
        let mut per_degree: Vec<f64> =
            energy.per_degree()[..=lmax].iter().map(|e| factor * e).collect();
        // The number of points is fixed, so the mean has no variance.
        per_degree[0] = 0.0;
        let tail = factor * energy.beyond(lmax);
        // Without a tail nobody asks for its error.
        let windows = if tail > 0.0 { windows(energy, n_points, lmax) } else { Vec::new() };
        Self { per_degree, tail, windows }
    }

    fn apply(&self, power: &[f64]) -> f64 {
        self.per_degree.iter().zip(power).map(|(w, p)| w * p).sum()
    }

    fn tail_error(&self, windows: &[f64]) -> f64 {
        // The weights of a window add up to 1 with a rounding for each degree.
        let rounding = |w: &Window| f64::EPSILON * w.weights.len() as f64;
        let departures = windows.iter().zip(&self.windows).map(|(p, w)| {
            let departure = (p - 1.0).abs();
            if departure <= rounding(w) { 0.0 } else { departure }
        });
        self.tail * departures.reduce(f64::max).unwrap_or(1.0)
    }
}

/// The windows of the upper octave, `lmax/2 < l <= lmax`, with the integrand's energies as weights; those without
/// energy are left out.
fn windows(energy: &Energy, n_points: usize, lmax: usize) -> Vec<Window> {
    let degrees = lmax / 2 + 1..lmax + 1;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the root of a number of points"
    )]
    let width = energy.domain().count_on_sphere(n_points).sqrt().ceil() as usize;
    // Of nearly equal width, so that no window is a scrap.
    let count = (degrees.len() / width.max(1)).max(1);
    let cut = |i: usize| degrees.start + i * degrees.len() / count;
    (0..count)
        .filter_map(|i| {
            let energies = energy.per_degree().get(cut(i)..cut(i + 1))?;
            let total: f64 = energies.iter().sum();
            (total > 0.0).then(|| Window {
                first: cut(i),
                weights: energies.iter().map(|e| e / total).collect(),
            })
        })
        .collect()
}

/// Accumulates the predicted variance realization by realization, so that its standard error knows
/// how the powers of different degrees vary together.
#[derive(Clone, Debug)]
pub struct PredictionAccumulator {
    weights: Weights,
    moments: Moments,
    windows: Vec<Moments>,
}

impl PredictionAccumulator {
    /// An empty accumulator for an integrand of `energy` and patterns of `n_points` whose spectrum is
    /// computed to `lmax`.
    #[must_use]
    pub fn new(energy: &Energy, n_points: usize, lmax: usize) -> Self {
        let weights = Weights::new(energy, n_points, lmax);
        let windows = vec![Moments::default(); weights.windows.len()];
        Self { weights, moments: Moments::default(), windows }
    }

    /// The prediction; its standard error is NaN for a single realization.
    #[must_use]
    pub fn finish(&self) -> Prediction {
        let tail = self.weights.tail;
        let windows: Vec<f64> = self.windows.iter().map(Moments::mean).collect();
        Prediction {
            variance: self.moments.mean() + tail,
            stderr: self.moments.standard_error(),
            tail,
            tail_error: self.weights.tail_error(&windows),
            dof: self.moments.count().saturating_sub(1) as f64,
        }
    }
}

impl Accumulator for PredictionAccumulator {
    fn push(&mut self, realization: &Realization<'_>) {
        let power: Vec<f64> = realization.power().collect();
        self.moments.push(self.weights.apply(&power));
        for (moments, window) in self.windows.iter_mut().zip(&self.weights.windows) {
            moments.push(window.mean(&power));
        }
    }

    fn merge(&mut self, other: &Self) {
        self.moments.merge(&other.moments);
        for (mine, theirs) in self.windows.iter_mut().zip(&other.windows) {
            mine.merge(theirs);
        }
    }
}
