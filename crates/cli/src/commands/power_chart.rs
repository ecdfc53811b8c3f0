//! Charts of angular power, for `spectrum` and `compare`.

use sphvar_spectrum::Spectrum;

use crate::plots::{Chart, Scale, Series, Style};

/// Power below this is 0 to rounding and has no place on a logarithmic axis.
const ROUNDING: f64 = 1e-20;

/// The power of l >= 1 against l/sqrt(N) up to `most`, as a line with its error as a band. Degrees
/// whose power is 0 to rounding are passed over.
pub(super) fn power_series(label: &str, spectrum: &Spectrum, most: f64, colour: usize) -> Series {
    let scale = (spectrum.n_points() as f64).sqrt();
    let shown = |r: &(usize, f64, f64)| r.1 > ROUNDING && r.0 as f64 <= most * scale;
    let rows: Vec<(usize, f64, f64)> = spectrum.rows().skip(1).filter(shown).collect();
    Series {
        label: label.to_owned(),
        points: rows.iter().map(|r| (r.0 as f64 / scale, r.1)).collect(),
        error: Some(rows.iter().map(|r| r.2).collect()),
        style: Style::Line,
        colour,
    }
}

/// A chart of spectra; title and notes are left to be filled in.
pub(super) fn power_chart(series: Vec<Series>) -> Chart {
    Chart {
        title: String::new(),
        x_label: "frequency l / \u{221a}N".to_owned(),
        y_label: "power P(l), white noise = 1".to_owned(),
        x_scale: Scale::Log,
        y_scale: Scale::Log,
        series,
        notes: Vec::new(),
    }
}
