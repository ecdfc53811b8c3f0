//! The chart of `progressive`: errors against the number of points.

use super::record::PrefixRecord;
use super::reference::Reference;
use super::sequence_errors::SequenceErrors;
use crate::plots::{
    Binned, Chart, Ink, MAX_COLOURS, NOTE_OF_OWN, Panel, Scale, Series, Spread, Style, inks,
};

/// With more curves than this, bands and markers of measured errors would cover each other.
const MAX_DETAILED: usize = 3;
/// If all factors are within this one of 1, the axis is linear.
const LINEAR_FACTOR: f64 = 5.0;

/// Returns the standard errors of sequences and references against N, with the factors between them
/// below.
pub(super) fn chart(
    curves: &[SequenceErrors],
    reference: Option<&Reference>,
    subject: &str,
) -> Chart {
    let last = |curve: &SequenceErrors| {
        let last = curve.rows.last();
        last.and_then(|row| Some(row.variance()? * row.n as f64)).unwrap_or(f64::NAN)
    };
    let values: Vec<f64> = curves.iter().map(last).collect();
    let are_own: Vec<bool> = curves.iter().map(|curve| curve.sampler.is_file).collect();
    let mut notes = Notes::default();
    let (mut errors, mut measured, mut factors) = (Vec::new(), Vec::new(), Vec::new());
    for (curve, ink) in curves.iter().zip(inks(&values, &are_own)) {
        let label = curve.sampler.label.clone();
        let is_detailed = curves.len() <= MAX_DETAILED;
        let error = |row: &PrefixRecord| row.variance().map(f64::sqrt);
        errors.push(line(&label, curve, ink, is_detailed, &error, &mut notes));
        factors.push(line("", curve, ink, is_detailed, &|row| row.factor, &mut notes));
        if is_detailed {
            measured.extend(markers(curve, ink));
        }
    }
    notes.has_markers = !measured.is_empty();
    errors.extend(measured);
    let name = reference.and_then(Reference::name).unwrap_or_default();
    if let Some(reference) = reference
        && !name.is_empty()
    {
        errors.push(reference_line(&name, curves, reference));
    }
    let mut shown = factors.iter().flat_map(|series| &series.points).map(|point| point.1);
    let is_wide = shown.any(|factor| !(1.0 / LINEAR_FACTOR..=LINEAR_FACTOR).contains(&factor));
    let mut panels = vec![Panel::log("standard error", errors)];
    if factors.iter().any(|series| !series.points.is_empty()) {
        panels.push(Panel {
            reference: Some(1.0),
            y_scale: if is_wide { Scale::Log } else { Scale::Linear },
            ..Panel::log(format!("error / {name}"), factors)
        });
    }
    let n_own = are_own.iter().filter(|is_own| **is_own).count();
    notes.has_greys = curves.len() - n_own > MAX_COLOURS;
    notes.has_own = n_own > 0;
    Chart {
        title: format!("Error of every prefix: {subject}"),
        x_label: "number of points N".to_owned(),
        x_scale: Scale::Log,
        panels,
        notes: notes.lines(),
    }
}

/// Returns the least errors of the reference patterns at the prefixes that are shown.
fn reference_line(name: &str, curves: &[SequenceErrors], reference: &Reference) -> Series {
    let mut shown: Vec<usize> =
        curves.iter().flat_map(|curve| curve.prefixes.shown.iter().copied()).collect();
    shown.sort_unstable();
    shown.dedup();
    let point = |n: usize| Some((n as f64, reference.variance_at(n)?.sqrt()));
    Series {
        label: name.to_owned(),
        points: shown.into_iter().filter_map(point).collect(),
        spread: Spread::None,
        style: Style::Dashed,
        ink: Ink::Black,
    }
}

/// Returns a quantity of all prefixes as a line, with the range of each bin as a band.
fn line(
    label: &str,
    curve: &SequenceErrors,
    ink: Ink,
    has_bands: bool,
    value: &dyn Fn(&PrefixRecord) -> Option<f64>,
    notes: &mut Notes,
) -> Series {
    let points = curve.rows.iter().filter_map(|row| Some((row.n as f64, value(row)?)));
    let Binned { points, ranges } = Binned::new(&points.collect::<Vec<_>>(), 0.0);
    notes.is_binned |= ranges.is_some();
    notes.has_bands |= ranges.is_some() && has_bands;
    let ranges = ranges.filter(|_| has_bands);
    Series {
        label: label.to_owned(),
        points,
        spread: ranges.map_or(Spread::None, Spread::Ranges),
        style: Style::Line,
        ink,
    }
}

/// Returns the measured errors of the prefixes that are shown, if they differ from the line.
fn markers(curve: &SequenceErrors, ink: Ink) -> Option<Series> {
    let rows = curve.rows.iter().filter(|row| curve.prefixes.shown.contains(&row.n));
    let rows = rows.filter(|row| row.predicted.is_some());
    let (points, errors): (Vec<_>, Vec<_>) = rows
        .filter_map(|row| {
            let error = row.measured?.sqrt();
            Some(((row.n as f64, error), row.measured_stderr.map_or(f64::NAN, |e| 0.5 * e / error)))
        })
        .unzip();
    let is_empty = points.is_empty();
    (!is_empty).then(|| Series {
        label: String::new(),
        points,
        spread: Spread::Errors(errors),
        style: Style::Markers,
        ink,
    })
}

/// What the lines at the foot explain.
#[derive(Default)]
struct Notes {
    has_markers: bool,
    is_binned: bool,
    has_bands: bool,
    has_greys: bool,
    has_own: bool,
}

impl Notes {
    fn lines(&self) -> Vec<String> {
        let colours = format!("In colour: the {MAX_COLOURS} with the smallest N \u{d7} variance.");
        let binned = match self.has_bands {
            true => {
                "Where prefixes are many, lines are means over bins of log N and bands their ranges."
            }
            false => "Where prefixes are many, lines are means over bins of log N.",
        };
        let lines = [
            self.has_markers.then_some(
                "Lines: predicted. Markers: measured at some of the prefixes, with one standard error.",
            ),
            self.is_binned.then_some(binned),
            self.has_greys.then_some(&*colours),
            self.has_own.then_some(NOTE_OF_OWN),
        ];
        lines.into_iter().flatten().map(str::to_owned).collect()
    }
}
