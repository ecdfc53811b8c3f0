//! Charts of angular power, for `spectrum`, `compare` and `bounds`.

use sphvar_integrands::Energy;
use sphvar_sh::{Bands, Domain, Frequencies};
use sphvar_spectrum::{RadialSpectrum, Spectrum};

use crate::plots::{Binned, Chart, Ink, Panel, Scale, Series, Spread, Style};

/// Power below this is 0 to rounding and cannot be drawn on a logarithmic axis.
const ROUNDING: f64 = 1e-20;
/// With more curves than this, the bands would cover each other.
const MAX_BANDS: usize = 3;

/// The titles and styles of charts over the radii of bands.
#[derive(Debug)]
pub(super) struct BandTexts {
    /// The title of charts of spectra.
    pub(super) title: &'static str,
    /// The axis of radii divided by sqrt(N).
    frequency: &'static str,
    /// The axis of power.
    power: &'static str,
    /// The name of a radius.
    pub(super) unit: &'static str,
    /// The axis of radii.
    pub(super) radius: &'static str,
    /// The axis of energies, before the total.
    pub(super) energy: &'static str,
    /// The note of a chart with bins, with or without their ranges.
    pub(super) binned: [&'static str; 2],
    /// How curves that lack the radii with power 0 are drawn.
    with_gaps: Style,
}

/// Bands whose spectra and energies are drawn against their radius.
pub(super) trait ShownBands: Bands {
    /// The titles and styles of their charts.
    const TEXTS: &BandTexts;

    /// Returns the radii from 0 with mean power and standard error.
    fn power_by_radius(spectrum: &Spectrum<Self>) -> Vec<(usize, f64, f64)>;

    /// Returns the energy by radius from 0.
    fn energy_by_radius(energy: &Energy<Self>) -> Vec<f64>;

    /// Returns the bands up to a radius, in words.
    fn range(radius: f64) -> String;
}

/// Returns the largest radius up to which a spectrum has all bands: the largest degree.
pub(super) fn largest_radius<B: Bands>(spectrum: &Spectrum<B>) -> usize {
    radius(spectrum.bands(), spectrum.lmax())
}

/// Returns the largest frequency of a prediction, whose spectrum may be of band 0 alone.
pub(super) fn largest_frequency(spectrum: &Spectrum<Frequencies>) -> usize {
    radius(spectrum.bands(), spectrum.bands().len() - 1)
}

/// Returns the radius up to which bands 0 to `last` are all bands.
pub(super) fn radius<B: Bands>(bands: &B, last: usize) -> usize {
    // Only the last class of bands may extend further.
    whole(bands.extent(0, last))
}

/// Returns a radius rounded up.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a degree")]
pub(super) fn whole(radius: f64) -> usize {
    radius.ceil() as usize
}

impl ShownBands for Domain {
    const TEXTS: &BandTexts = &BandTexts {
        title: "Angular power spectra",
        frequency: "frequency l / \u{221a}N",
        power: "power P(l), white noise = 1",
        unit: "degree",
        radius: "degree l",
        energy: "energy E(l) / total",
        binned: [Binned::NOTE, Binned::NOTE_OF_MEANS],
        with_gaps: Style::Line,
    };

    fn power_by_radius(spectrum: &Spectrum) -> Vec<(usize, f64, f64)> {
        spectrum.rows().collect()
    }

    fn energy_by_radius(energy: &Energy) -> Vec<f64> {
        energy.per_band().to_vec()
    }

    fn range(radius: f64) -> String {
        match whole(radius) {
            1 => "degree 1".to_owned(),
            l => format!("degrees <= {l}"),
        }
    }
}

impl ShownBands for Frequencies {
    const TEXTS: &BandTexts = &BandTexts {
        title: "Radial means of power spectra",
        frequency: "frequency |k| / \u{221a}N",
        power: "radial mean of the power, white noise = 1",
        unit: "ring of |k|",
        radius: "frequency |k|",
        energy: "energy of all k with this |k| / total",
        binned: [Binned::NOTE_OF_RINGS, Binned::NOTE_OF_MEANS_OF_RINGS],
        // A line would connect the peaks of a lattice across rings without power.
        with_gaps: Style::Markers,
    };

    fn power_by_radius(spectrum: &Spectrum<Self>) -> Vec<(usize, f64, f64)> {
        let zero = (0, spectrum.power()[0], 0.0);
        let radial = RadialSpectrum::of(spectrum);
        std::iter::once(zero).chain(radial.rows().map(|(k, p, e, _)| (k, p, e))).collect()
    }

    /// Each frequency counts in the ring rho - 1/2 <= |k| < rho + 1/2, up to kmax - 1.
    fn energy_by_radius(energy: &Energy<Self>) -> Vec<f64> {
        let bands = energy.bands();
        let mut rings = vec![0.0; bands.kmax().max(1)];
        for (band, e) in energy.per_band().iter().enumerate() {
            let norm = |k: i32| u64::from(k.unsigned_abs()).pow(2);
            let [k1, k2] = bands.frequency(band);
            // |k| >= rho - 1/2 for the integer |k|^2 > rho^2 - rho.
            let root = (norm(k1) + norm(k2)).isqrt();
            let is_above = norm(k1) + norm(k2) > root * (root + 1);
            let ring = usize::try_from(root + u64::from(is_above)).unwrap_or(usize::MAX);
            if let Some(sum) = rings.get_mut(ring) {
                *sum += e;
            }
        }
        rings
    }

    fn range(radius: f64) -> String {
        format!("frequencies |k| <= {}", whole(radius))
    }
}

/// One spectrum of a chart.
#[derive(Debug)]
pub(super) struct PowerCurve {
    /// Its name; may be empty.
    pub(super) label: String,
    pub(super) n_points: usize,
    /// Degree, power and its standard error.
    pub(super) rows: Vec<(usize, f64, f64)>,
    pub(super) ink: Ink,
}

impl PowerCurve {
    /// Returns the curve of the degrees l >= 1 up to `max_frequency` sqrt(N).
    pub(super) fn new(
        label: impl Into<String>,
        n_points: usize,
        power_by_radius: &[(usize, f64, f64)],
        max_frequency: f64,
        ink: Ink,
    ) -> Self {
        let last = max_frequency * (n_points as f64).sqrt();
        let rows = power_by_radius.iter().skip(1);
        let rows = rows.filter(|row| row.0 as f64 <= last).copied().collect();
        Self { label: label.into(), n_points, rows, ink }
    }
}

/// Returns the chart of spectra against l/sqrt(N) beneath other series over the same axes, with
/// notes on the curves; the caller sets the title. Degrees whose power is 0 to rounding are
/// skipped.
pub(super) fn power_chart(texts: &BandTexts, curves: &[PowerCurve], over: Vec<Series>) -> Chart {
    let has_bands = curves.len() <= MAX_BANDS;
    let (mut is_binned, mut has_errors) = (false, false);
    let mut series = Vec::new();
    for curve in curves {
        let scale = (curve.n_points as f64).sqrt();
        let points: Vec<_> = curve.rows.iter().map(|row| (row.0 as f64, row.1)).collect();
        let has_gaps = points.iter().any(|point| point.1 <= ROUNDING);
        let Binned { points, ranges } = Binned::new(&points, ROUNDING);
        is_binned |= ranges.is_some();
        let spread = match ranges {
            _ if !has_bands => Spread::None,
            Some(ranges) => Spread::Ranges(ranges),
            None => {
                let shown = curve.rows.iter().filter(|row| row.1 > ROUNDING);
                let errors: Vec<f64> = shown.map(|row| row.2).collect();
                has_errors |= errors.iter().any(|&error| error > 0.0);
                Spread::Errors(errors)
            }
        };
        series.push(Series {
            label: curve.label.clone(),
            points: points.into_iter().map(|(l, power)| (l / scale, power)).collect(),
            spread,
            style: if has_gaps { texts.with_gaps } else { Style::Line },
            ink: curve.ink,
        });
    }
    series.extend(over);
    let notes = [
        (is_binned && has_bands).then_some(texts.binned[0]),
        (is_binned && !has_bands).then_some(texts.binned[1]),
        has_errors.then_some("Bands: one standard error to either side."),
    ];
    Chart {
        title: String::new(),
        x_label: texts.frequency.to_owned(),
        x_scale: Scale::Log,
        panels: vec![Panel::log(texts.power, series)],
        notes: notes.into_iter().flatten().map(str::to_owned).collect(),
    }
}
