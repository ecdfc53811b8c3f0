use sphvar_sh::Frequencies;
use sphvar_spectrum::{RadialSpectrum, Spectrum, frequency_grid};

use crate::figures::square_patterns::PlanePattern;
use crate::plane_spectrum::PlaneSums;
use crate::{
    Axis, Curve, Error, Field, Figure, Job, Mark, Palette, PlaneSpectrum, Setting, SquarePoints,
};

/// The number of points of spectra, as in the thesis.
pub(super) const N_POINTS: usize = 4096;
/// The number of points of pictures of point sets, as in the thesis.
pub(super) const N_SHOWN: usize = 1024;
/// The largest norm of frequencies of spectra, omega = 2.5.
pub(super) const KMAX: usize = 160;
/// The largest displayed power: higher peaks would leave everything else dark.
const MAX_POWER: f64 = 2.0;
/// Peaks of at least this part of N have rings in pictures, where each is a single cell.
pub(super) const RINGED: f64 = 0.1;

/// Returns the spectrum of set `index` by itself.
pub(super) fn single_spectrum(
    pattern: PlanePattern,
    setting: Setting,
    index: u64,
) -> Result<Spectrum<Frequencies>, Error> {
    let ensemble = pattern.ensemble(N_POINTS);
    let sums = PlaneSums::run(&ensemble, KMAX, setting.seed, index..index + 1)?;
    Ok(sums.finish(true)?.spectrum)
}

/// Returns the mean spectrum; that of the only set if there is only one.
pub(super) fn mean_spectrum(pattern: PlanePattern, setting: Setting) -> Job {
    let sets = if pattern.is_deterministic() { 1 } else { realizations(setting) };
    Job::PlaneSpectrum { ensemble: pattern.ensemble(N_POINTS), kmax: KMAX, sets }
}

/// Returns the number of sets in the mean spectra of random patterns.
pub(super) fn realizations(setting: Setting) -> u64 {
    setting.scale.pick(100, 1000)
}

/// Adds a picture of the first point set.
pub(super) fn points_panel(
    pattern: PlanePattern,
    setting: Setting,
    figure: &mut Figure,
) -> Result<(), Error> {
    let set = points_of(pattern, setting, 0)?;
    let title = format!("{}, N = {}", pattern.label(), set.points.len());
    figure.panel(&format!("{}-points", pattern.name()), title, set);
    Ok(())
}

/// Returns a picture of point set `index`.
pub(super) fn points_of(
    pattern: PlanePattern,
    setting: Setting,
    index: u64,
) -> Result<SquarePoints, Error> {
    Ok(SquarePoints { points: pattern.ensemble(N_SHOWN).set(setting.seed, index)? })
}

/// Powers of frequencies as a picture.
pub(super) struct SpectrumView {
    /// The largest |k1| and |k2|.
    pub(super) half: usize,
    pub(super) palette: Palette,
}

impl SpectrumView {
    /// All frequencies in grey, as the thesis shows power spectra.
    pub(super) const WHOLE: Self = Self { half: KMAX, palette: Palette::Grey };
    /// All frequencies as a heat map.
    pub(super) const HEAT: Self = Self { half: KMAX, palette: Palette::Heat };
    /// The frequencies around 0, omega to 1/2.
    pub(super) const LOW: Self = Self { half: 32, palette: Palette::Grey };

    /// Returns the picture, k1 to the right and k2 upwards, with rings around `peaks` and the
    /// frequency 0. That frequency, whose power is N, and those beyond the spectrum are empty.
    pub(super) fn field(&self, spectrum: &Spectrum<Frequencies>, peaks: &[[f64; 2]]) -> Field {
        let values = frequency_grid(spectrum.bands(), spectrum.power(), self.half);
        let is_cut = values.iter().any(|p| *p > MAX_POWER);
        let edge = self.half as f64 + 0.5;
        let is_inside = |k: &[f64; 2]| k.iter().all(|k| k.abs() < edge);
        Field {
            size: [2 * self.half + 1; 2],
            // NaN remains.
            values: values.into_iter().map(|p| if p > MAX_POWER { MAX_POWER } else { p }).collect(),
            label: if is_cut {
                format!("power P(k), clipped at {MAX_POWER}")
            } else {
                "power P(k)".to_owned()
            },
            palette: self.palette,
            x: Axis::linear("frequency k1").over(-edge, edge),
            y: Axis::linear("frequency k2").over(edge, -edge),
            rings: std::iter::once([0.0; 2])
                .chain(peaks.iter().copied().filter(is_inside))
                .collect(),
        }
    }
}

/// Returns the frequencies other than 0 with at least this power, both k and -k.
pub(super) fn peaks(spectrum: &Spectrum<Frequencies>, least: f64) -> Vec<[f64; 2]> {
    let bands = spectrum.bands();
    let high = spectrum.rows().filter(|row| row.0 > 0 && row.1 >= least);
    high.flat_map(|(band, ..)| {
        let [k1, k2] = bands.frequency(band).map(f64::from);
        [[k1, k2], [-k1, -k2]]
    })
    .collect()
}

/// Returns the largest power of a frequency other than 0.
pub(super) fn largest_power(spectrum: &Spectrum<Frequencies>) -> f64 {
    spectrum.power().iter().skip(1).copied().fold(0.0, f64::max)
}

/// Returns the radial mean over omega = rho/sqrt(N), with standard errors.
pub(super) fn radial_curve(
    label: impl Into<String>,
    colour: usize,
    mark: Mark,
    radial: &RadialSpectrum,
    n_points: usize,
) -> Curve {
    let root = (n_points as f64).sqrt();
    let rows = radial.rows().map(|(rho, power, stderr, _)| [rho as f64 / root, power, stderr]);
    Curve::new(label, colour, mark, rows)
}

/// Returns the axis of radial means.
pub(super) fn omega_axis() -> Axis {
    Axis::linear("omega = rho/sqrt(N)")
}

/// Returns the mean power of the frequencies with omega in a range, and its standard error for
/// independent rings.
pub(super) fn mean_power(plane: &PlaneSpectrum, omega: std::ops::Range<f64>) -> (f64, f64) {
    let root = plane.spectrum.n_effective().sqrt();
    let (mut sum, mut variance, mut count) = (0.0, 0.0, 0.0);
    for (rho, power, stderr, _) in plane.radial.rows() {
        let rho = rho as f64;
        if omega.contains(&(rho / root)) {
            sum += rho * power;
            variance += (rho * stderr).powi(2);
            count += rho;
        }
    }
    (sum / count, f64::sqrt(variance) / count)
}
