//! A spectrum on its way out: table, JSON, CSV or plot.

use std::path::Path;

use serde::Serialize;
use sphvar_spectrum::Spectrum;

use super::chart::chart;
use crate::error::CliError;
use crate::global::Global;
use crate::plots::ImageFormat;
use crate::point_sets::WeightSums;
use crate::report::{
    Provenance, csv, full, is_stdout, print, print_json, say, short, table, write_result,
};

/// The document of `--json`.
#[derive(Debug, Serialize)]
struct Document<'a> {
    sampler: &'a str,
    domain: &'static str,
    n: usize,
    lmax: usize,
    realizations: u64,
    #[serde(flatten)]
    weights: Option<WeightSums>,
    l: Vec<usize>,
    power: Vec<f64>,
    /// NaN, which becomes null, where there is no error.
    stderr: Vec<f64>,
    /// The mean power of even and of odd degrees beyond `lmax`; odd ones do not exist on the hemisphere.
    tail_even: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    tail_odd: Option<f64>,
    seconds: f64,
    provenance: &'a Provenance,
}

/// What is said of a spectrum besides its numbers.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Remarks {
    /// Whether an error would mean nothing, because this is the spectrum of one given set.
    pub(crate) has_no_error: bool,
    /// The sums of the weights, if there are any.
    pub(crate) weights: Option<WeightSums>,
}

/// Writes the spectrum of `name` to `out`, prints it as JSON, or shows a table if neither is asked for.
pub(crate) fn emit(
    out: Option<&Path>,
    global: &Global,
    name: &str,
    spectrum: &Spectrum,
    remarks: Remarks,
    seconds: f64,
    provenance: &Provenance,
) -> Result<(), CliError> {
    let mut rows: Vec<(usize, f64, f64)> = spectrum.rows().collect();
    if remarks.has_no_error {
        rows.iter_mut().for_each(|row| row.2 = f64::NAN);
    }
    let document = Document {
        sampler: name,
        domain: spectrum.domain().name(),
        n: spectrum.n_points(),
        lmax: spectrum.lmax(),
        realizations: spectrum.realizations(),
        weights: remarks.weights,
        l: rows.iter().map(|r| r.0).collect(),
        power: rows.iter().map(|r| r.1).collect(),
        stderr: rows.iter().map(|r| r.2).collect(),
        tail_even: spectrum.tail().even,
        tail_odd: spectrum.domain().has_degree(1).then_some(spectrum.tail().odd),
        seconds,
        provenance,
    };
    let scale = (spectrum.n_points() as f64).sqrt();
    if let Some(path) = out
        && !(global.json && is_stdout(path))
    {
        if ImageFormat::of_path(path).is_some() {
            chart(name, spectrum).with_note(provenance.line()).render(path)?;
        } else {
            let cells: Vec<_> = rows
                .iter()
                .map(|&(l, p, e)| {
                    vec![
                        l.to_string(),
                        full(l as f64 / scale),
                        full(p),
                        full(e),
                        spectrum.realizations().to_string(),
                    ]
                })
                .collect();
            write_result(path, &document, &|| {
                csv(provenance, "l,omega,power,stderr,realizations", &cells)
            })?;
        }
    }
    if global.json {
        return print_json(&document);
    }
    if out.is_some() {
        return Ok(());
    }
    let shown = thinned(&rows);
    let cells = shown
        .iter()
        .map(|&&(l, p, e)| {
            vec![l.to_string(), format!("{:.4}", l as f64 / scale), short(p), short(e)]
        })
        .collect();
    print(&table(&["l", "l/sqrt(N)", "power", "+-"], cells, 0))?;
    if let Some(WeightSums { n_effective, sum_w, sum_w2 }) = remarks.weights {
        print(&format!("N_eff = {n_effective:.6} (sum w = {sum_w:e}, sum w^2 = {sum_w2:e})\n"))?;
    }
    if shown.len() < rows.len() {
        let remark = format!("{} of {} degrees; all of them: -o FILE.csv", shown.len(), rows.len());
        say(global.quiet, &remark);
    }
    Ok(())
}

/// All of a short list, or some 40 rows of a long one, ever farther apart.
fn thinned(rows: &[(usize, f64, f64)]) -> Vec<&(usize, f64, f64)> {
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
