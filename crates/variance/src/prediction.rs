use std::sync::Arc;

use sphvar_sh::{Bands, ByParity, TailClasses};
use sphvar_spectrum::{
    Accumulator, ClassMoments, ExactSum, Moments, Realization, SpectralBands, Spectrum,
};

use crate::error_moments::{ErrorTerms, PowerMoments};
use crate::student_quantile;
use sphvar_integrands::{Energy, EnergyErrors};

/// A variance predicted from spectra, `k sum_{l >= 1} E(l) <P(l)>`, with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Prediction {
    /// The predicted variance of the estimate of the integral.
    pub variance: f64,
    /// Its standard error, from those of the pattern's spectrum and of the integrand's energies; 0
    /// if both are exact, NaN if the spectrum comes from a single realization of a random pattern.
    pub stderr: f64,
    /// The part of `stderr` due to the errors of the integrand's energies,
    /// [`EnergyErrors::of_sum`]; 0 if they are exact.
    pub energy_stderr: f64,
    /// The contribution to `variance` of the bands beyond the spectrum, where the pattern is
    /// assigned the mean power of the band's class, [`Spectrum::tail`]; on the sphere,
    /// `k (sum_{even l > lmax} E(l) P_even + sum_{odd l > lmax} E(l) P_odd)`.
    pub tail: f64,
    /// The estimated error of the tail: the energies beyond the spectrum times the largest
    /// deviation from the mean power of their class in the upper octave of the spectrum; see
    /// [`predict`].
    pub tail_error: f64,
    /// The degrees of freedom of `stderr`: one less than the number of realizations, and with errors
    /// of energies the effective number of Welch and Satterthwaite; infinite for an exact spectrum.
    pub dof: f64,
}

impl Prediction {
    /// The prediction of a variance that no spectrum predicts: every number is NaN.
    pub const UNKNOWN: Self = Self {
        variance: f64::NAN,
        stderr: f64::NAN,
        energy_stderr: f64::NAN,
        tail: f64::NAN,
        tail_error: f64::NAN,
        dof: f64::NAN,
    };

    /// Returns whether there is no prediction, [`Self::UNKNOWN`].
    #[must_use]
    pub fn is_unknown(&self) -> bool {
        self.variance.is_nan()
    }

    /// Returns the end points of an interval for the variance: Student's interval at `confidence`,
    /// within (0, 1), for the errors of spectrum and energies, widened on both sides by the whole error of
    /// the tail, and never below 0.
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

    /// Returns the standard error of the variance, combined with the tail error as one standard
    /// deviation.
    #[must_use]
    pub fn total_stderr(&self) -> f64 {
        self.stderr.hypot(self.tail_error)
    }

    /// Returns the prediction with the error due to the energies, which is independent of that of
    /// the spectrum: `stderr^2 = s^2 + e^2`.
    ///
    /// The square of s has `dof` degrees of freedom and that of e an infinite number, so that of
    /// the sum has `(s^2 + e^2)^2/(s^4/dof)` (Welch 1947).
    pub(crate) fn with_energy_stderr(self, energy_stderr: f64) -> Self {
        if energy_stderr == 0.0 {
            return self;
        }
        let dof = if self.stderr == 0.0 {
            f64::INFINITY
        } else {
            self.dof * (1.0 + (energy_stderr / self.stderr).powi(2)).powi(2)
        };
        Self { stderr: self.stderr.hypot(energy_stderr), energy_stderr, dof, ..self }
    }

    fn quantile(&self, p: f64) -> f64 {
        if p > 0.5 && p < 1.0 { student_quantile(p, self.dof) } else { f64::NAN }
    }
}

/// Returns the variance `k sum_{l >= 1} E(l) <P(l)>` of integrating a function with energies E by a
/// pattern with spectrum P; k is [`Bands::factor`] of the effective number of points. On other
/// spaces the sum is over their bands.
///
/// Let L be the smaller of the two lmax. Degrees beyond L enter with the limit of the pattern's
/// mean power, separately for each class of bands (on the sphere, even and odd degrees):
/// `T = `[`Spectrum::tail`], which is 1 unless points coincide, are antipodes or share coordinates.
/// The error of this assumption is estimated from the octave below L, for each class below its own
/// last band. It is divided into windows of about `sqrt(N)` degrees, on the axes of the square about N
/// frequencies, over which the peaks of lattices and the oscillations of random patterns average out:
///
/// ```text
/// tail error = k sum_classes E_beyond max_windows |<P>_E - T|,   <P>_E = sum_window E(l) P(l) / sum_window E(l)
/// ```
///
/// The sums run over the bands of one class. If the integrand has no energy of a class in that
/// octave but some beyond, the windows of the other classes are used; if there are none, the tail
/// error equals the tail. Where the power is settled, the mean over the tail is closer to T than
/// the mean of the worst window; where L is far below `sqrt(N)`, the error is nearly the tail
/// itself.
///
/// The standard error treats the errors of different degrees as independent, since a [`Spectrum`]
/// has only one error per degree. [`PredictionAccumulator`] does not need that assumption. Errors of
/// the energies add `k` times [`EnergyErrors::of_sum`] of the mean power, independent of the errors
/// of the spectrum.
///
/// # Panics
///
/// Panics if spectrum and energy belong to different domains.
#[must_use]
pub fn predict<B: Bands>(spectrum: &Spectrum<B>, energy: &Energy<B>) -> Prediction {
    assert_eq!(spectrum.bands(), energy.bands(), "spectra of different domains");
    let weights = Weights::new(energy, spectrum.n_points(), spectrum.lmax());
    let scale = weights.scale * (weights.n_points / spectrum.n_effective());
    let errors = weights.per_band.iter().zip(spectrum.stderr()).map(|(w, e)| w * e);
    let of_tail = |class: usize| weights.tail.get(class) * spectrum.tail_stderr().get(class);
    let errors = errors.chain((0..B::Tail::COUNT).map(of_tail));
    let windows = weights.of_windows(|window| window.mean(spectrum.power()));
    let last = weights.per_band.len().min(spectrum.power().len());
    let of_sum =
        |errors: &EnergyErrors<_>| errors.of_sum(&spectrum.power()[..last], spectrum.tail());
    let energy_error = energy.errors().map_or(0.0, of_sum);
    let prediction = Prediction {
        variance: scale * weights.apply(spectrum.power(), spectrum.tail()),
        stderr: scale * errors.map(|e| e * e).sum::<f64>().sqrt(),
        energy_stderr: 0.0,
        tail: scale * weights.tail.dot(spectrum.tail()),
        tail_error: scale * weights.tail_error(&windows, spectrum.tail()),
        dof: if spectrum.is_exact() {
            f64::INFINITY
        } else {
            spectrum.realizations().saturating_sub(1) as f64
        },
    };
    let factor = energy.bands().factor(spectrum.n_points());
    let relative = weights.n_points / spectrum.n_effective();
    prediction.with_energy_stderr(factor * relative * energy_error)
}

/// The weights with which an integrand sums a pattern's power:
/// `scale (sum_bands per_band P + sum_classes tail T)`.
#[derive(Clone, Debug)]
struct Weights<T> {
    /// The variance with white noise. The weights are relative to it, so that squared products of
    /// weights and powers neither overflow nor underflow for integrands of any size.
    scale: f64,
    /// The number of points that `scale` refers to.
    n_points: f64,
    per_band: Vec<f64>,
    tail: T,
    /// The windows of each class.
    windows: Vec<Vec<Window>>,
}

/// Consecutive bands from `first` on, with weights that sum to 1; bands of other classes have
/// weight 0.
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

impl<T: TailClasses> Weights<T> {
    fn new<B: Bands<Tail = T>>(energy: &Energy<B>, n_points: usize, last: usize) -> Self {
        let last = last.min(energy.lmax());
        let whole = energy.centred().sum();
        let share = |e: f64| if whole > 0.0 { e / whole } else { 0.0 };
        let mut per_band: Vec<f64> = energy.per_band()[..=last].iter().map(|&e| share(e)).collect();
        // The number of points is fixed, so the mean has no variance.
        per_band[0] = 0.0;
        let tail = energy.beyond_by_class(last).map(share);
        let of_class = |class: usize| {
            // Without a tail its error is not needed.
            let has_tail = tail.sum() > 0.0;
            if has_tail { windows(energy, n_points, last, class) } else { Vec::new() }
        };
        let windows = (0..T::COUNT).map(of_class).collect();
        let scale = energy.bands().factor(n_points) * whole;
        Self { scale, n_points: n_points as f64, per_band, tail, windows }
    }

    fn apply(&self, power: &[f64], tail: T) -> f64 {
        let known: f64 = self.per_band.iter().zip(power).map(|(w, p)| w * p).sum();
        known + self.tail.dot(tail)
    }

    /// Returns `f` of the windows of each class.
    fn of_windows<U>(&self, mut f: impl FnMut(&Window) -> U) -> Vec<Vec<U>> {
        self.windows.iter().map(|windows| windows.iter().map(&mut f).collect()).collect()
    }

    /// Returns the error of the tail, relative to `scale`, from the mean powers in windows and
    /// those expected beyond.
    fn tail_error(&self, means: &[Vec<f64>], expected: T) -> f64 {
        let departure = |class: usize| {
            let expected = expected.get(class);
            let departures = means[class].iter().zip(&self.windows[class]).map(|(p, w)| {
                // The weights of a window sum to 1 up to one rounding per degree.
                let rounding = f64::EPSILON * w.weights.len() as f64 * expected.max(1.0);
                let departure = (p - expected).abs();
                if departure <= rounding { 0.0 } else { departure }
            });
            departures.reduce(f64::max)
        };
        let departures: Vec<_> = (0..T::COUNT).map(departure).collect();
        let of_others = departures.iter().copied().flatten().reduce(f64::max).unwrap_or(1.0);
        self.tail.dot(T::from_fn(|class| departures[class].unwrap_or(of_others)))
    }
}

/// Returns the windows of a class in its upper octave, with radii from half the largest one on,
/// with the integrand's energies as weights. Windows without energy are left out.
fn windows<B: Bands>(
    energy: &Energy<B>,
    n_points: usize,
    last: usize,
    class: usize,
) -> Vec<Window> {
    let bands = energy.bands();
    let largest = shell(bands.extent(class, last));
    let shells = largest / 2 + 1..largest + 1;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a number of points or its root"
    )]
    let width = bands.spacing_radius(class, n_points).ceil() as usize;
    // Windows of nearly equal width, so that none is much narrower than the others.
    let count = (shells.len() / width.max(1)).max(1);
    let cut = |i: usize| first_of_shell(bands, shells.start + i * shells.len() / count, last);
    let window = |i: usize| {
        let first = cut(i);
        let energies = energy.per_band().get(first..cut(i + 1))?;
        let of_class =
            |(k, e): (usize, &f64)| if bands.tail_class(first + k) == class { *e } else { 0.0 };
        let energies: Vec<f64> = energies.iter().enumerate().map(of_class).collect();
        let total: f64 = energies.iter().sum();
        let weights = energies.iter().map(|e| e / total).collect();
        (total > 0.0).then_some(Window { first, weights })
    };
    (0..count).filter_map(window).collect()
}

/// Returns a radius rounded up to an integer: each degree is its own shell.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a length")]
fn shell(radius: f64) -> usize {
    radius.ceil() as usize
}

/// Returns the first band of a shell or beyond it, at most the one after `last`.
fn first_of_shell(bands: &impl Bands, wanted: usize, last: usize) -> usize {
    let (mut low, mut high) = (0, last + 1);
    while low < high {
        let middle = low + (high - low) / 2;
        if shell(bands.radius(middle)) < wanted {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

/// Accumulates the predicted variance realization by realization, so that its standard error
/// includes the covariance of the powers of different degrees.
#[derive(Clone, Debug)]
pub struct PredictionAccumulator<T = ByParity> {
    /// Shared by the threads.
    weights: Arc<Weights<T>>,
    /// Of estimated energies.
    errors: Option<ErrorTerms<T>>,
    sums: PredictionMoments<T>,
}

/// The sums over realizations of a [`PredictionAccumulator`], without the integrand's energies.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "T: TailClasses")
)]
pub(crate) struct PredictionMoments<T> {
    /// Moments of the variance relative to that of white noise.
    moments: Moments,
    /// Moments of `r = n_points/N_eff`.
    relative: Moments,
    /// Moments of r times the power beyond the spectrum.
    tail: ClassMoments<T>,
    /// Sums of r times the power in the windows of each class.
    windows: Vec<Vec<ExactSum>>,
    /// With estimated energies.
    power: Option<PowerMoments<T>>,
}

impl<T: TailClasses> PredictionMoments<T> {
    /// Adds the realizations of `other`.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.moments.merge(&other.moments);
        self.relative.merge(&other.relative);
        self.tail.merge(&other.tail);
        if let (Some(mine), Some(theirs)) = (&mut self.power, &other.power) {
            mine.merge(theirs);
        }
        let windows = self.windows.iter_mut().flatten().zip(other.windows.iter().flatten());
        for (mine, theirs) in windows {
            mine.merge(theirs);
        }
    }
}

impl<T: TailClasses> PredictionAccumulator<T> {
    /// Returns an empty accumulator for an integrand of `energy` and patterns of `n_points` whose
    /// spectrum is computed to band number `last`, the largest degree.
    #[must_use]
    pub fn new<B: Bands<Tail = T>>(energy: &Energy<B>, n_points: usize, last: usize) -> Self {
        let weights = Weights::new(energy, n_points, last);
        let windows = weights.of_windows(|_| ExactSum::default());
        let errors = ErrorTerms::new(energy, n_points);
        let sums = PredictionMoments {
            moments: Moments::default(),
            relative: Moments::default(),
            tail: ClassMoments::default(),
            windows,
            power: errors.as_ref().map(|_| PowerMoments::new(weights.per_band.len())),
        };
        Self { weights: Arc::new(weights), errors, sums }
    }

    /// Returns the sums over the realizations.
    pub(crate) fn into_sums(self) -> PredictionMoments<T> {
        self.sums
    }

    /// Adds realizations that were added to another accumulator of the same integrand.
    pub(crate) fn add(&mut self, sums: &PredictionMoments<T>) {
        self.sums.merge(sums);
    }

    /// Returns the prediction; its standard error is NaN for a single realization.
    #[must_use]
    pub fn finish(&self) -> Prediction {
        // Realizations count as in the variance, by 1/N_eff, so powers are means with these weights.
        let sums = &self.sums;
        let relative = sums.relative.mean();
        let scale = self.weights.scale * relative;
        let tail = sums.tail.mean().map(|power| power / relative);
        let mean = |sum: &ExactSum| sum.value() / sums.moments.count() as f64 / relative;
        let windows: Vec<_> = sums.windows.iter().map(|w| w.iter().map(mean).collect()).collect();
        let prediction = Prediction {
            variance: self.weights.scale * sums.moments.mean(),
            stderr: self.spectrum_stderr(),
            energy_stderr: 0.0,
            tail: scale * self.weights.tail.dot(tail),
            tail_error: scale * self.weights.tail_error(&windows, tail),
            dof: sums.moments.count().saturating_sub(1) as f64,
        };
        let errors = self.errors.as_ref().zip(sums.power.as_ref());
        let energy_stderr = errors.map_or(0.0, |(errors, power)| errors.energy_stderr(power));
        prediction.with_energy_stderr(energy_stderr)
    }

    /// Returns the standard error due to that of the spectrum alone.
    pub(crate) fn spectrum_stderr(&self) -> f64 {
        self.weights.scale * self.sums.moments.standard_error()
    }

    /// Adds one realization: its effective number of points, the power of every band from 0, and
    /// the mean power beyond, which is called only if there is energy beyond or energies have errors.
    pub fn push_powers(&mut self, n_effective: f64, powers: &[f64], tail: impl FnOnce() -> T) {
        let has_tail = self.weights.tail.sum() > 0.0 || self.errors.is_some();
        let tail = if has_tail { tail() } else { T::default() };
        let relative = self.weights.n_points / n_effective;
        let sums = &mut self.sums;
        sums.moments.push(relative * self.weights.apply(powers, tail));
        if let Some(power) = &mut sums.power {
            power.push(relative, powers, tail);
        }
        sums.relative.push(relative);
        sums.tail.push(tail.map(|power| relative * power));
        let windows = self.weights.windows.iter().flatten();
        for (sum, window) in sums.windows.iter_mut().flatten().zip(windows) {
            sum.add(relative * window.mean(powers));
        }
    }
}

impl<B: SpectralBands> Accumulator<B> for PredictionAccumulator<B::Tail> {
    fn push(&mut self, realization: &Realization<'_, B>) {
        let power: Vec<f64> = realization.power().collect();
        self.push_powers(realization.n_effective(), &power, || realization.tail());
    }

    fn merge(&mut self, other: &Self) {
        self.sums.merge(&other.sums);
    }
}
