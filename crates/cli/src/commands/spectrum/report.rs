//! The output of a spectrum: table, JSON, CSV or plot.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_spectrum::Spectrum;

use super::chart::chart;
use super::pairs::PairBody;
use crate::error::CliError;
use crate::global::Global;
use crate::point_sets::WeightSums;
use crate::report::{self, Column, Forms, Provenance, csv_of, number, table_of};

/// The mean angular power spectrum of a pattern or of points in files: `spectrum --json`, `merge
/// --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SpectrumBody {
    /// The sampler with its parameters, or the files.
    sampler: String,
    /// `sphere` or `hemisphere`.
    domain: &'static str,
    /// The number of points.
    n: usize,
    /// The largest degree, inclusive.
    lmax: usize,
    /// Realizations of which this is the mean; 0 for a closed form.
    realizations: u64,
    #[serde(flatten)]
    weights: Option<WeightSums>,
    /// The degrees from 0; on the hemisphere the even ones.
    l: Vec<usize>,
    /// The mean power of each degree; white noise has 1, and degree 0 has N.
    power: Vec<f64>,
    /// The standard error of each power; 0 where it is exact, null where there is none.
    #[schemars(with = "Vec<Option<f64>>")]
    stderr: Vec<f64>,
    /// The mean power of even degrees beyond `lmax`; null if it is not known.
    #[schemars(with = "Option<f64>")]
    tail_even: f64,
    /// The mean power of odd degrees beyond `lmax`, which the hemisphere does not have.
    #[serde(skip_serializing_if = "Option::is_none")]
    tail_odd: Option<f64>,
    /// Pair correlation and Ripley's functions, with `--pairs`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pairs: Option<PairBody>,
    /// The time that the spectrum took, in seconds.
    seconds: f64,
}

/// The spectrum at one degree.
#[derive(Debug, Serialize, JsonSchema)]
struct PowerRecord {
    /// The degree.
    l: usize,
    /// `l / sqrt(N)`.
    omega: f64,
    /// The mean power.
    power: f64,
    /// The standard error of `power`.
    #[schemars(with = "Option<f64>")]
    stderr: f64,
    /// Realizations of which this is the mean.
    realizations: u64,
}

/// What is reported with a spectrum.
#[derive(Clone, Debug, Default)]
pub(crate) struct Remarks {
    /// Whether errors are meaningless because the spectrum is that of one given set.
    pub(crate) has_no_error: bool,
    /// The sums of the weights, if there are any.
    pub(crate) weights: Option<WeightSums>,
    /// The pair correlation, if it was estimated; tables, CSV files and plots then show it.
    pub(crate) pairs: Option<PairBody>,
}

impl SpectrumBody {
    /// Returns the document of the spectrum of `name`.
    pub(crate) fn new(name: &str, spectrum: &Spectrum, remarks: Remarks, seconds: f64) -> Self {
        let rows = records(spectrum, remarks.has_no_error);
        Self {
            sampler: name.to_owned(),
            domain: spectrum.domain().name(),
            n: spectrum.n_points(),
            lmax: spectrum.lmax(),
            realizations: spectrum.realizations(),
            weights: remarks.weights,
            l: rows.iter().map(|r| r.l).collect(),
            power: rows.iter().map(|r| r.power).collect(),
            stderr: rows.iter().map(|r| r.stderr).collect(),
            tail_even: spectrum.tail().even,
            tail_odd: spectrum.domain().has_degree(1).then_some(spectrum.tail().odd),
            pairs: remarks.pairs,
            seconds,
        }
    }
}

/// Returns the rows of a spectrum, without errors if they are meaningless.
fn records(spectrum: &Spectrum, has_no_error: bool) -> Vec<PowerRecord> {
    let (n, realizations) = (spectrum.n_points(), spectrum.realizations());
    let record = |(l, power, stderr)| PowerRecord {
        l,
        omega: l as f64 / (n as f64).sqrt(),
        power,
        stderr: if has_no_error { f64::NAN } else { stderr },
        realizations,
    };
    spectrum.rows().map(record).collect()
}

/// Writes the spectrum of `name` to `out`, and prints it as JSON or as a table.
pub(crate) fn emit(
    out: Option<&Path>,
    global: &Global,
    name: &str,
    spectrum: &Spectrum,
    remarks: Remarks,
    seconds: f64,
    provenance: &Provenance,
) -> Result<(), CliError> {
    let n = spectrum.n_points();
    let rows = records(spectrum, remarks.has_no_error);
    let weights = remarks.weights;
    let body = SpectrumBody::new(name, spectrum, remarks, seconds);
    let (shown, all, what) = if let Some(pairs) = &body.pairs {
        let rows = pairs.rows();
        let forms = Forms {
            csv: &|| csv_of(provenance, &rows),
            chart: Some(&|| Ok(pairs.chart(name, n))),
            text: &|| pairs.text(thinned(&rows)) + &text_of_weights(weights),
        };
        report::emit(out, global, provenance, &body, &forms)?;
        (thinned(&rows).len(), rows.len(), "bins")
    } else {
        let forms = Forms {
            csv: &|| csv_of(provenance, &rows),
            chart: Some(&|| Ok(chart(name, spectrum))),
            text: &|| text(&rows, weights),
        };
        report::emit(out, global, provenance, &body, &forms)?;
        (thinned(&rows).len(), rows.len(), "degrees")
    };
    if shown < all && out.is_none() && !global.json {
        let remark = format!("{shown} of {all} {what}; all of them: -o FILE.csv");
        global.session.say(&remark);
    }
    Ok(())
}

/// Returns the table for the terminal.
fn text(rows: &[PowerRecord], weights: Option<WeightSums>) -> String {
    let columns = [
        Column::number("l", |r: &PowerRecord| r.l.to_string()),
        Column::number("l/sqrt(N)", |r: &PowerRecord| number::value(r.omega)),
        Column::number("power", |r: &PowerRecord| number::value(r.power)),
        Column::number("+-", |r: &PowerRecord| number::uncertainty(r.stderr)),
    ];
    table_of(&columns, thinned(rows)) + &text_of_weights(weights)
}

/// Returns a line on the weights, if there are any.
pub(super) fn text_of_weights(weights: Option<WeightSums>) -> String {
    weights.map_or(String::new(), |WeightSums { n_effective, sum_w, sum_w2 }| {
        let [n, sum, squares] = [n_effective, sum_w, sum_w2].map(number::value);
        format!("N_eff = {n} (sum w = {sum}, sum w^2 = {squares})\n")
    })
}

/// Returns all rows of a short list, or about 40 of a long one with increasing spacing.
pub(super) fn thinned<R>(rows: &[R]) -> Vec<&R> {
    const FEW: usize = 40;
    let mut next = 0;
    rows.iter()
        .enumerate()
        .filter(|&(i, _)| {
            let take = rows.len() <= FEW || i == next || i + 1 == rows.len();
            if i == next {
                next = (i + 1).max(i * 9 / 8);
            }
            take
        })
        .map(|(_, row)| row)
        .collect()
}
