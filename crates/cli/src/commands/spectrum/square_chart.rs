//! The plot of a spectrum on the square: a map over both frequencies, and the radial mean.

use sphvar_sh::Frequencies;
use sphvar_spectrum::{Spectrum, frequency_grid};

use super::square_report::SquareResult;
use crate::plots::{
    Binned, Chart, Colours, Edges, HeatMap, Ink, MapAndChart, Panel, Scale, Series, Spread, Style,
};
use crate::report::Provenance;

/// Powers below this are 0 to rounding and cannot be drawn on a logarithmic axis.
const ROUNDING: f64 = 1e-20;
/// Powers over more than this ratio between the largest and the median have a logarithmic scale.
const WIDE: f64 = 20.0;
/// With at most this number of frequencies of most of the power, each is marked by a ring.
const MAX_RINGS: usize = 120;

/// Returns the plot of the spectrum of `name`.
pub(super) fn plot(
    name: &str,
    result: &SquareResult,
    has_no_error: bool,
    provenance: &Provenance,
) -> MapAndChart {
    let SquareResult { spectrum, .. } = result;
    let n = spectrum.n_points();
    MapAndChart {
        map: map(format!("Power spectrum of {name}, N = {n}, on the unit square"), spectrum),
        chart: chart(result, has_no_error).with_note(provenance.line()),
    }
}

/// Returns the map of the power over both components of the frequency.
fn map(title: String, spectrum: &Spectrum<Frequencies>) -> HeatMap {
    let bands = spectrum.bands();
    let half = bands.kmax();
    let edge = half as f64 + 0.5;
    let edges = |label: &str, range| Edges { label: label.to_owned(), range };
    let peaks = peaks(spectrum);
    let mut powers: Vec<f64> =
        spectrum.power().iter().skip(1).copied().filter(|&p| p > ROUNDING).collect();
    powers.sort_unstable_by(f64::total_cmp);
    let is_wide = match (powers.get(powers.len() / 2), powers.last()) {
        (Some(median), Some(largest)) => *largest > WIDE * median,
        _ => false,
    };
    HeatMap {
        title,
        notes: Vec::new(),
        size: [2 * half + 1; 2],
        values: frequency_grid(bands, spectrum.power(), half),
        label: "power P(k), white noise = 1".to_owned(),
        colours: Colours::Heat,
        scale: if is_wide { Scale::Log } else { Scale::Linear },
        x: edges("frequency k\u{2081}", (-edge, edge)),
        y: edges("frequency k\u{2082}", (edge, -edge)),
        rings: peaks,
    }
}

/// Returns the frequencies of the peaks of a lattice, which are single cells of the map: those of at
/// least a tenth of N, if there are few of them and others have far less.
fn peaks(spectrum: &Spectrum<Frequencies>) -> Vec<(f64, f64)> {
    let limit = 0.1 * spectrum.n_effective();
    if limit < WIDE {
        return Vec::new();
    }
    let is_peak = |row: &(usize, f64, f64)| row.0 > 0 && row.1 >= limit;
    let peaks = spectrum.rows().filter(is_peak).flat_map(|(band, ..)| {
        let [k1, k2] = spectrum.bands().frequency(band).map(f64::from);
        [(k1, k2), (-k1, -k2)]
    });
    let peaks: Vec<(f64, f64)> = peaks.take(MAX_RINGS + 1).collect();
    if peaks.len() > MAX_RINGS { Vec::new() } else { peaks }
}

/// Returns the chart of the radial mean and of the anisotropy.
fn chart(result: &SquareResult, has_no_error: bool) -> Chart {
    let SquareResult { spectrum, radial } = result;
    let scale = (spectrum.n_points() as f64).sqrt();
    let rows: Vec<_> = radial.rows().collect();
    let means: Vec<(f64, f64)> =
        rows.iter().map(|(radius, power, ..)| (*radius as f64, *power)).collect();
    let Binned { points, ranges } = Binned::new(&means, ROUNDING);
    let is_binned = ranges.is_some();
    let has_empty = means.iter().any(|(_, power)| *power <= ROUNDING);
    let shown = rows.iter().filter(|row| row.1 > ROUNDING);
    let errors: Vec<f64> = shown.map(|row| row.2).collect();
    let has_errors = !has_no_error && !is_binned && errors.iter().any(|&e| e > 0.0);
    let spread = match ranges {
        Some(ranges) => Spread::Ranges(ranges),
        None if has_errors => Spread::Errors(errors),
        None => Spread::None,
    };
    // A line would connect rings across others without power.
    let style = if has_empty { Style::Markers } else { Style::Line };
    let series = |points: Vec<(f64, f64)>, spread| Series {
        label: String::new(),
        points: points.into_iter().map(|(radius, y)| (radius / scale, y)).collect(),
        spread,
        style,
        ink: Ink::Rank(0),
    };
    let has_anisotropy = |row: &&(usize, f64, f64, f64)| row.1 > ROUNDING && row.3 > ROUNDING;
    let ratios: Vec<(f64, f64)> =
        rows.iter().filter(has_anisotropy).map(|row| (row.0 as f64, row.3)).collect();
    // White noise in closed form has none.
    let has_ratios = !ratios.is_empty();
    // The anisotropy of white noise.
    let is_sampled = spectrum.realizations() > 0 && !spectrum.is_exact();
    let white = is_sampled.then(|| 1.0 / spectrum.realizations() as f64);
    let anisotropy =
        Panel { reference: white, ..Panel::log("anisotropy", vec![series(ratios, Spread::None)]) };
    let notes = [
        is_binned.then_some("Lines are means over bins of log |k|, and bands their ranges."),
        has_empty.then_some("Rings without power (to rounding) are left out."),
        has_errors.then_some("Bands: one standard error to either side."),
        white.is_some().then_some("Grey line of the anisotropy: white noise."),
    ];
    Chart {
        title: String::new(),
        x_label: "frequency |k| / \u{221a}N".to_owned(),
        x_scale: Scale::Log,
        panels: std::iter::once(Panel::log("radial mean of P(k)", vec![series(points, spread)]))
            .chain(has_ratios.then_some(anisotropy))
            .collect(),
        notes: notes.into_iter().flatten().map(str::to_owned).collect(),
    }
}
