//! Measures of sets of rotations.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::{RotationSampler, RotationSet};
use sphvar_spectrum::{Moments, RotationQuality, matrix_fisher_coefficients};

use super::{Case, RotationsArgs};
use crate::error::CliError;
use crate::global::Global;
use crate::progress::Progress;
use crate::report::{Column, number, table_of};

/// The degrees whose powers the table has.
const SHOWN_DEGREES: usize = 6;

/// The time of the separation, the covering radius and the exact degree of a rotation, in seconds.
const SECONDS_PER_ROTATION: f64 = 75e-6;

/// The time of a unit of the nominal work of powers, in seconds.
const SECONDS_PER_WORK: f64 = 60e-9;

/// Measures of patterns of rotations: `rotations --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct MeasuresBody {
    /// The measures of each pattern at each number of rotations.
    pub(super) rows: Vec<MeasuresRecord>,
}

/// The measures of a pattern of rotations, means over its realizations.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct MeasuresRecord {
    /// The pattern with its parameters.
    sampler: String,
    /// The number of rotations.
    n: usize,
    /// `(sum w)^2 / sum w^2`, the number of rotations of equal weight with the same noise.
    n_effective: f64,
    /// The number of realizations that were measured, 1 where all are the same.
    realizations: u64,
    /// The least angle between two rotations, in degrees; null for one.
    separation_degrees: Option<f64>,
    /// The largest angle from any rotation to the nearest one of the set, in degrees.
    covering_radius_degrees: f64,
    /// The largest degree up to which all functions have their means over SO(3), in every realization.
    exact_degree: usize,
    /// The power of each degree, from 0; 1 for independent uniform rotations, 0 up to the exact degree.
    power: Vec<f64>,
    /// The standard errors of the powers; null for a single realization.
    power_stderr: Option<Vec<f64>>,
    /// The concentration of the function whose mean has the error; null without --kappa.
    kappa: Option<f64>,
    /// The root mean square error of the mean over a randomly rotated set, relative to the mean over SO(3);
    /// null without --kappa.
    error: Option<f64>,
    /// The standard error of `error` over realizations; null for a single realization and without --kappa.
    error_stderr: Option<f64>,
    /// The expected error of n independent uniform rotations; null without --kappa.
    error_of_uniform: Option<f64>,
}

impl MeasuresRecord {
    pub(super) fn new(
        case: &Case,
        args: &RotationsArgs,
        lmax: usize,
        global: &Global,
        progress: &Progress,
    ) -> Result<Self, CliError> {
        let sampler = case.pattern.to_string();
        progress.stage(&sampler);
        let realizations = measured_sets(&*case.sampler, args);
        let ensemble = case.ensemble(args, global);
        let mut set = RotationSet::default();
        let (mut separation, mut covering) = (Moments::default(), Moments::default());
        let (mut effective, mut squared_error) = (Moments::default(), Moments::default());
        let mut powers = vec![Moments::default(); lmax + 1];
        let mut exact_degree = usize::MAX;
        for index in 0..realizations {
            ensemble.realize_into(index, &mut set, progress).map_err(CliError::failed)?;
            let quality = RotationQuality::new(&set, lmax, progress).map_err(CliError::failed)?;
            separation.push(quality.separation.unwrap_or(f64::NAN));
            covering.push(quality.covering_radius);
            effective.push(quality.n_effective);
            exact_degree = exact_degree.min(quality.exact_degree);
            powers.iter_mut().zip(&quality.power).for_each(|(all, p)| all.push(*p));
            if let Some(kappa) = args.kappa {
                let error = RotationQuality::matrix_fisher_error(&set, kappa, progress);
                squared_error.push(error.map_err(CliError::failed)?.powi(2));
            }
        }
        // Up to the exact degree the powers are rounding errors.
        let power = powers
            .iter()
            .enumerate()
            .map(|(l, power)| if (1..=exact_degree).contains(&l) { 0.0 } else { power.mean() });
        let error = args.kappa.map(|_| squared_error.mean().sqrt());
        Ok(Self {
            sampler,
            n: case.sampler.n_points(),
            n_effective: effective.mean(),
            realizations,
            separation_degrees: (case.sampler.n_points() > 1)
                .then(|| separation.mean().to_degrees()),
            covering_radius_degrees: covering.mean().to_degrees(),
            exact_degree,
            power: power.collect(),
            power_stderr: (realizations > 1)
                .then(|| powers.iter().map(Moments::standard_error).collect()),
            kappa: args.kappa,
            error,
            // That of the square, divided by the derivative of the square.
            error_stderr: error
                .filter(|error| realizations > 1 && *error > 0.0)
                .map(|error| squared_error.standard_error() / (2.0 * error)),
            error_of_uniform: args
                .kappa
                .map(|kappa| error_of_uniform(kappa, case.sampler.n_points())),
        })
    }
}

/// Returns the expected root mean square error of the mean of the function of `--kappa` over
/// independent uniform rotations, relative to its mean over SO(3).
fn error_of_uniform(kappa: f64, n: usize) -> f64 {
    // The square of the function is that of twice the concentration.
    let mean =
        |kappa: f64| matrix_fisher_coefficients(kappa, 0).first().copied().unwrap_or(f64::NAN);
    ((mean(2.0 * kappa) / mean(kappa).powi(2) - 1.0).max(0.0) / n as f64).sqrt()
}

/// Returns the nominal work of the powers of a set for the powers that are shown and for errors.
fn work_of_powers(n: usize, args: &RotationsArgs, lmax: usize) -> f64 {
    // Energies decrease as exp(-l^2/kappa): beyond this degree they are below 1e-20.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most that of the largest kappa"
    )]
    let degree = |kappa: f64| 10 + (6.8 * kappa.sqrt()).ceil() as usize;
    let errors = args.kappa.map(|kappa| RotationQuality::nominal_work(n, degree(kappa)));
    RotationQuality::nominal_work(n, lmax) + errors.unwrap_or(0.0)
}

/// Returns the number of sets of a pattern that are measured.
fn measured_sets(sampler: &dyn RotationSampler, args: &RotationsArgs) -> u64 {
    // No measure depends on a rotation of the set.
    if sampler.is_random() { args.realizations } else { 1 }
}

/// Returns the expected time of the measures of a pattern, in seconds.
pub(super) fn expected_seconds(
    sampler: &dyn RotationSampler,
    args: &RotationsArgs,
    lmax: usize,
) -> f64 {
    let n = sampler.n_points();
    let powers = SECONDS_PER_WORK * work_of_powers(n, args, lmax);
    measured_sets(sampler, args) as f64 * (SECONDS_PER_ROTATION * n as f64 + powers)
}

/// Returns the nominal work of the measures of a pattern.
pub(super) fn nominal_work(
    sampler: &dyn RotationSampler,
    args: &RotationsArgs,
    lmax: usize,
) -> f64 {
    let n = sampler.n_points();
    measured_sets(sampler, args) as f64 * (n as f64 + work_of_powers(n, args, lmax))
}

impl MeasuresBody {
    /// Returns the table.
    pub(super) fn text(&self) -> String {
        let degrees = self.rows.first().map_or(0, |row| row.power.len().saturating_sub(1));
        let headings: Vec<String> =
            (1..=degrees.min(SHOWN_DEGREES)).map(|l| format!("P({l})")).collect();
        let mut columns = vec![
            Column::text("sampler", |row: &MeasuresRecord| row.sampler.clone()),
            Column::number("N", |row: &MeasuresRecord| row.n.to_string()),
            Column::number("separation", |row: &MeasuresRecord| {
                number::optional(row.separation_degrees, number::value)
            }),
            Column::number("covering radius", |row: &MeasuresRecord| {
                number::value(row.covering_radius_degrees)
            }),
            Column::number("exact degree", |row: &MeasuresRecord| row.exact_degree.to_string()),
        ];
        for (k, heading) in headings.iter().enumerate() {
            columns.push(Column::number(heading, move |row: &MeasuresRecord| {
                let stderr = row.power_stderr.as_ref().map(|stderr| stderr[k + 1]);
                match stderr {
                    Some(stderr) => number::with_uncertainty(row.power[k + 1], stderr),
                    None => number::value(row.power[k + 1]),
                }
            }));
        }
        if self.rows.iter().any(|row| row.error.is_some()) {
            columns.push(Column::number("error", |row: &MeasuresRecord| {
                number::optional(row.error, number::percent)
            }));
        }
        if self.rows.iter().any(|row| row.error_stderr.is_some()) {
            columns.push(Column::number("+-", |row: &MeasuresRecord| {
                number::optional(row.error_stderr, number::percent)
            }));
        }
        let table = table_of(&columns, &self.rows);
        let best = self.min_errors();
        format!("{table}\nangles in degrees; -o FILE writes the rotations\n{best}")
    }

    /// Returns a line for each number of rotations with the sampler of the least error.
    fn min_errors(&self) -> String {
        let mut counts: Vec<usize> = self.rows.iter().map(|row| row.n).collect();
        counts.sort_unstable();
        counts.dedup();
        counts.into_iter().filter_map(|n| self.min_error(n)).collect()
    }

    /// Returns the line of the sampler of the least error with `n` rotations; `None` without errors, and where
    /// the function is constant.
    fn min_error(&self, n: usize) -> Option<String> {
        let errors = self.rows.iter().filter(|row| row.n == n);
        let errors = errors.filter_map(|row| Some((row, row.error?, row.error_of_uniform?)));
        let (row, error, uniform) = errors.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let ratio = uniform / error;
        (uniform > 0.0 && ratio.is_finite()).then(|| {
            let sampler = &row.sampler;
            let (ratio, error, uniform) =
                (number::ratio(ratio), number::percent(error), number::percent(uniform));
            format!(
                "N = {n}: the least error is that of {sampler}, {error}; independent uniform rotations have {uniform} on average, {ratio} times as much\n"
            )
        })
    }
}
