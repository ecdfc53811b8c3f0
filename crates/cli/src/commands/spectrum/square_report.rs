//! The output of a spectrum on the square: table, JSON, CSV or plot.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_sh::Frequencies;
use sphvar_spectrum::{RadialSpectrum, Spectrum};

use super::report::{Remarks, text_of_weights, thinned};
use super::saved::SquareSums;
use super::square_chart::plot;
use crate::error::CliError;
use crate::global::Global;
use crate::plots::ImageFormat;
use crate::point_sets::WeightSums;
use crate::report::{self, Column, Forms, Provenance, csv_of, number, table_of};

/// A spectrum on the square with its radial mean.
#[derive(Debug)]
pub(crate) struct SquareResult {
    pub(super) spectrum: Spectrum<Frequencies>,
    pub(super) radial: RadialSpectrum,
}

impl SquareResult {
    /// Returns the result of a spectrum in closed form.
    pub(super) fn exact(spectrum: Spectrum<Frequencies>) -> Self {
        Self { radial: RadialSpectrum::of(&spectrum), spectrum }
    }

    /// Returns the result of sums; without errors, and with 0 for powers that are rounding errors,
    /// if one set determines the spectrum.
    pub(crate) fn of_sums(sums: &SquareSums, is_exact: bool) -> Result<Self, CliError> {
        let spectrum = sums.spectrum.finish()?;
        if is_exact {
            return Ok(Self::exact(spectrum.into_exact().without_rounding()));
        }
        let radial = RadialSpectrum::of(&spectrum).with_errors(&sums.radial)?;
        Ok(Self { spectrum, radial })
    }

    /// Returns the power of every frequency, without errors if they are meaningless.
    fn rows(&self, has_no_error: bool) -> Vec<FrequencyRecord> {
        let realizations = self.spectrum.realizations();
        let row = |(band, power, stderr)| {
            let [k1, k2] = self.spectrum.bands().frequency(band);
            let stderr = if has_no_error { f64::NAN } else { stderr };
            FrequencyRecord { k1, k2, power, stderr, realizations }
        };
        self.spectrum.rows().map(row).collect()
    }

    /// Returns the means over rings, without errors if they are meaningless.
    fn rings(&self, has_no_error: bool) -> Vec<Ring> {
        let n = self.spectrum.n_points() as f64;
        let ring = |(radius, power, stderr, anisotropy)| Ring {
            radius,
            omega: radius as f64 / n.sqrt(),
            power,
            stderr: if has_no_error { f64::NAN } else { stderr },
            anisotropy,
        };
        self.radial.rows().map(ring).collect()
    }
}

/// The mean power spectrum of a pattern of the unit square or of points in files: `spectrum --square
/// --json`, and `merge --json` of its shards.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SquareSpectrumBody {
    /// The sampler with its parameters, or the files.
    sampler: String,
    /// `square`.
    domain: &'static str,
    /// The number of points.
    n: usize,
    /// The largest length |k| of the frequencies, inclusive.
    kmax: usize,
    /// Realizations of which this is the mean; 0 for a closed form.
    realizations: u64,
    #[serde(flatten)]
    weights: Option<WeightSums>,
    /// The first component of every frequency; of k and -k, which have the same power, one is given.
    k1: Vec<i32>,
    /// The second component of every frequency, at least 0.
    k2: Vec<i32>,
    /// The mean power of each frequency; white noise has 1, and (0, 0) has N.
    power: Vec<f64>,
    /// The standard error of each power; 0 where it is exact, null where there is none.
    #[schemars(with = "Vec<Option<f64>>")]
    stderr: Vec<f64>,
    /// The radii r of rings of frequencies, r - 1/2 <= |k| < r + 1/2, from 1.
    radius: Vec<usize>,
    /// The mean power of each ring.
    radial_power: Vec<f64>,
    /// The standard error of each mean over a ring; 0 where it is exact, null where there is none.
    #[schemars(with = "Vec<Option<f64>>")]
    radial_stderr: Vec<f64>,
    /// The relative variance of the mean power over each ring; M realizations of white noise have
    /// 1/M, and it is null where the ring has no power.
    #[schemars(with = "Vec<Option<f64>>")]
    anisotropy: Vec<f64>,
    /// The mean power off the axes at frequencies beyond `kmax`.
    tail: f64,
    /// The mean power of (k1, 0) beyond `kmax`.
    tail_u: f64,
    /// The mean power of (0, k2) beyond `kmax`.
    tail_v: f64,
    /// The time that the spectrum took, in seconds.
    seconds: f64,
}

/// The spectrum at one frequency.
#[derive(Debug, Serialize, JsonSchema)]
struct FrequencyRecord {
    /// The first component of the frequency.
    k1: i32,
    /// The second component of the frequency.
    k2: i32,
    /// The mean power.
    power: f64,
    /// The standard error of `power`.
    #[schemars(with = "Option<f64>")]
    stderr: f64,
    /// Realizations of which this is the mean.
    realizations: u64,
}

/// The mean over a ring of frequencies.
struct Ring {
    radius: usize,
    omega: f64,
    power: f64,
    stderr: f64,
    anisotropy: f64,
}

impl SquareSpectrumBody {
    /// Returns the document of the spectrum of `name`.
    pub(crate) fn new(name: &str, result: &SquareResult, remarks: &Remarks, seconds: f64) -> Self {
        let (rows, rings) = (result.rows(remarks.has_no_error), result.rings(remarks.has_no_error));
        let spectrum = &result.spectrum;
        let tail = spectrum.tail();
        Self {
            sampler: name.to_owned(),
            domain: "square",
            n: spectrum.n_points(),
            kmax: spectrum.bands().kmax(),
            realizations: spectrum.realizations(),
            weights: remarks.weights,
            k1: rows.iter().map(|row| row.k1).collect(),
            k2: rows.iter().map(|row| row.k2).collect(),
            power: rows.iter().map(|row| row.power).collect(),
            stderr: rows.iter().map(|row| row.stderr).collect(),
            radius: rings.iter().map(|ring| ring.radius).collect(),
            radial_power: rings.iter().map(|ring| ring.power).collect(),
            radial_stderr: rings.iter().map(|ring| ring.stderr).collect(),
            anisotropy: rings.iter().map(|ring| ring.anisotropy).collect(),
            tail: tail.off,
            tail_u: tail.u,
            tail_v: tail.v,
            seconds,
        }
    }
}

/// Writes the spectrum of `name` to `out`, and prints it as JSON or its radial mean as a table.
pub(crate) fn emit_square(
    out: Option<&Path>,
    global: &Global,
    name: &str,
    result: &SquareResult,
    remarks: &Remarks,
    seconds: f64,
    provenance: &Provenance,
) -> Result<(), CliError> {
    let (rows, rings) = (result.rows(remarks.has_no_error), result.rings(remarks.has_no_error));
    let body = SquareSpectrumBody::new(name, result, remarks, seconds);
    let picture = out.filter(|path| ImageFormat::of_path(path).is_some());
    if let Some(path) = picture {
        plot(name, result, remarks.has_no_error, provenance).render(path)?;
    }
    let forms =
        Forms { csv: &|| csv_of(provenance, &rows), chart: None, text: &|| text(&rings, remarks) };
    let other = if picture.is_some() { None } else { out };
    report::emit(other, global, provenance, &body, &forms)?;
    let shown = thinned(&rings).len();
    if shown < rings.len() && out.is_none() && !global.json {
        let remark = format!(
            "{shown} of {} radii; all of them: --json; all frequencies: -o FILE.csv",
            rings.len()
        );
        global.session.say(&remark);
    }
    Ok(())
}

/// Returns the table of the radial mean for the terminal.
fn text(rings: &[Ring], remarks: &Remarks) -> String {
    let columns = [
        Column::number("|k|", |r: &Ring| r.radius.to_string()),
        Column::number("|k|/sqrt(N)", |r: &Ring| number::value(r.omega)),
        Column::number("power", |r: &Ring| number::value(r.power)),
        Column::number("+-", |r: &Ring| number::uncertainty(r.stderr)),
        Column::number("anisotropy", |r: &Ring| number::value(r.anisotropy)),
    ];
    let note = match remarks.has_no_error {
        true => "\nOne set has no standard error; several sets of the same process have one.\n",
        false => "",
    };
    table_of(&columns, thinned(rings)) + note + &text_of_weights(remarks.weights)
}
