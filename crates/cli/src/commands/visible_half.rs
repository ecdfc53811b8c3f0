//! Visible halves of sphere sets compared with hemisphere patterns, for `variance --visible-half`.

use clap::ValueEnum;
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_integrands::{VisibleHalfEstimator, VisibleHalfIntegrand};
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Sampler, Streams};
use sphvar_spectrum::Resolution;
use sphvar_variance::{
    BiasTest, CutAxis, Error, Measurement, Prediction, VisibleHalfMeasurement, prediction_degree,
    trial_work, visible_half_estimates,
};

use super::cases::Case;
use super::rows::{Plan, Row};
use crate::error::CliError;
use crate::memory::check_transform;
use crate::patterns::{self, SamplerName};
use crate::progress::Progress;
use crate::report::{Column, number};

/// The axis of the visible half of sphere sets: +z, or uniformly random for an antipodal integrand, to which all halves
/// are equivalent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum HalfAxis {
    Random,
    Equator,
}

/// The visible half of a sphere pattern with one estimator. Unavailable numbers are null.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct VisibleHalfRecord {
    /// The sampler with its parameters.
    sampler: String,
    /// The number of points on the whole sphere.
    m: usize,
    /// The estimate of the integral over the hemisphere, as a formula.
    estimator: &'static str,
    /// The axis of the visible half: `random`, or `equator` for the half above the equator.
    axis: &'static str,
    /// Trials from which the variance was measured.
    trials: usize,
    /// The predicted variance of the estimate, if the axis is `equator` and the energies of the
    /// integrand are known.
    predicted: Option<f64>,
    /// The standard error of `predicted`, due to those of the spectrum and of the energies.
    predicted_stderr: Option<f64>,
    /// The measured variance of the estimate.
    #[schemars(with = "Option<f64>")]
    measured: f64,
    /// The standard error of `measured`.
    #[schemars(with = "Option<f64>")]
    measured_stderr: f64,
    /// The lower end of the 95 % interval of the measured variance.
    #[schemars(with = "Option<f64>")]
    measured_low: f64,
    /// The upper end of the 95 % interval of the measured variance.
    #[schemars(with = "Option<f64>")]
    measured_high: f64,
    /// The measured variance divided by that of the hemisphere pattern of the same name.
    #[schemars(with = "Option<f64>")]
    over_hemisphere: f64,
    /// The standard error of `over_hemisphere`.
    #[schemars(with = "Option<f64>")]
    over_hemisphere_stderr: f64,
    /// The mean estimate of the integral over the trials.
    #[schemars(with = "Option<f64>")]
    mean: f64,
    /// The exact integral over the hemisphere.
    exact: Option<f64>,
    /// Mean minus exact integral, in standard errors.
    bias_z: Option<f64>,
    /// The probability of a `bias_z` of this size without a bias.
    bias_p: Option<f64>,
    /// The mean number of points in the visible half.
    n_visible: f64,
    /// The variance of the number of points in the visible half.
    n_visible_variance: f64,
    /// Trials without a point in the visible half, whose ratio estimates are 0.
    empty: usize,
    /// The part of `predicted` beyond the largest degree of the spectrum.
    predicted_tail: Option<f64>,
    /// The error of `predicted` due to degrees beyond the spectrum.
    predicted_tail_error: Option<f64>,
}

/// Returns both estimators for every case, whose rows on the hemisphere are `rows`; none if this run
/// has no rows, because it keeps only a part of the work.
pub(super) fn run(
    plan: &Plan<'_>,
    half: HalfAxis,
    cases: &[&Case],
    rows: Option<&[Row]>,
) -> Result<Vec<VisibleHalfRecord>, CliError> {
    if let Some(case) = cases.iter().find(|c| matches!(c.pattern, Pattern::PointFile(_))) {
        return Err(CliError::Usage(format!(
            "--visible-half needs sphere sets and hemisphere sets of one pattern, which {} does not have",
            case.pattern.label()
        )));
    }
    let sphere: Vec<Box<dyn Sampler>> = cases
        .iter()
        .map(|c| patterns::build(&c.pattern, c.n_points().saturating_mul(2), Domain::Sphere, true))
        .collect::<Result<_, _>>()?;
    let row_of = |case: &Case| {
        let name = SamplerName::of(&case.pattern);
        let is_its = |row: &&Row| row.sampler == name && row.requested == case.requested;
        rows?.iter().find(is_its)
    };
    // With --until-rel, the number of trials follows from the row.
    let trials = |case: &Case| {
        let planned = plan.effort.trials_of::<Domain>(case.sampler());
        let of_row = |row: &Row| row.comparison.measurement.estimates().len() as u64;
        planned.until.and_then(|_| row_of(case)).map_or(planned.count, of_row)
    };
    let work = sphere.iter().zip(cases).map(|(s, c)| trials(c) as f64 * trial_work(&**s)).sum();
    let progress = Progress::new(work, plan.effort.session);
    let mut records = Vec::new();
    for (sampler, case) in sphere.iter().zip(cases) {
        let m = sampler.n_points();
        let name = format!("{} M = {m}, visible half", case.pattern);
        progress.stage(&name);
        let group = sampler.stream_group();
        let streams = Streams::new(plan.effort.seed, Purpose::Trial, group);
        let axis = match half {
            HalfAxis::Equator => CutAxis::Equator,
            HalfAxis::Random => {
                CutAxis::Random(Streams::new(plan.effort.seed, Purpose::Resample, group))
            }
        };
        let ensemble = Realizations::rotated(&**sampler, streams);
        let function = &*plan.integrand.function;
        let size = (trials(case), trial_work(&**sampler));
        let compute =
            |range| Ok(visible_half_estimates(&ensemble, function, axis, range, &progress)?);
        let estimates = plan.effort.estimates(&name, size, &progress, Vec::extend, compute)?;
        let measured = estimates.map(|rows: Vec<[f64; 3]>| VisibleHalfMeasurement::new(&rows));
        for (estimator_name, estimator) in [
            ("(4 pi/M) sum f", VisibleHalfEstimator::Unbiased),
            ("(2 pi/n) sum f", VisibleHalfEstimator::Ratio),
        ] {
            let predicted = match half {
                HalfAxis::Equator => {
                    let name = format!("{estimator_name} of {name}");
                    let compute = || predicted(plan, &**sampler, estimator);
                    plan.effort.predicted(&name, compute)?
                }
                HalfAxis::Random => Some(None),
            };
            if let (Some(measured), Some(predicted), Some(row)) =
                (&measured, predicted, row_of(case))
            {
                let name = estimator_name;
                let estimates = match estimator {
                    VisibleHalfEstimator::Unbiased => &measured.unbiased,
                    VisibleHalfEstimator::Ratio => &measured.ratio,
                };
                records.push(VisibleHalfRecord::new(
                    name, estimates, predicted, half, m, measured, row,
                ));
            }
        }
    }
    Ok(records)
}

/// Returns the variance of an estimate from the half above the equator, by the formula of the
/// sphere, or `None` if the energies of the integrand on that half are unknown.
fn predicted(
    plan: &Plan<'_>,
    sampler: &dyn Sampler,
    estimator: VisibleHalfEstimator,
) -> Result<Option<Prediction>, CliError> {
    let visible = VisibleHalfIntegrand::new(&*plan.integrand.function, estimator);
    let Some(visible) = if_known(visible.map_err(Error::from))? else {
        return Ok(None);
    };
    let lmax = prediction_degree(sampler, &visible);
    let realizations = plan.spectrum_realizations(sampler, lmax);
    check_transform(Resolution::new(lmax, sampler.n_points()), realizations)?;
    let predictor = plan.predictor_of(&visible, Domain::Sphere);
    let point = if_known(predictor.and_then(|mut predictor| predictor.predict(sampler, &())))?;
    Ok(point.map(|point| point.prediction))
}

/// Returns the computed value, or `None` if the energies of the integrand are unknown; other errors
/// are passed on.
fn if_known<T>(computed: Result<T, Error>) -> Result<Option<T>, CliError> {
    match computed {
        Err(Error::Integrand(sphvar_integrands::Error::NoEnergy { .. })) => Ok(None),
        computed => Ok(Some(computed?)),
    }
}

impl VisibleHalfRecord {
    fn new(
        estimator: &'static str,
        estimates: &Measurement,
        predicted: Option<Prediction>,
        half: HalfAxis,
        m: usize,
        all: &VisibleHalfMeasurement,
        row: &Row,
    ) -> Self {
        let itself = &row.comparison.measurement;
        let (error, of_itself) = (estimates.relative_error(), row.comparison.error());
        // Trials without a sample in the support of the integrand carry no information, for
        // the visible half as for the hemisphere pattern.
        let is_known = error.is_known()
            && estimates.variance() > row.comparison.rounding
            && !row.comparison.has_too_few_hits();
        let known = |x: f64| if is_known { x } else { f64::NAN };
        let over_hemisphere = known(estimates.variance() / itself.variance());
        let bias: Option<BiasTest> = row
            .comparison
            .exact
            .filter(|_| is_known)
            .map(|exact| estimates.bias(exact, row.comparison.rounding));
        let interval = estimates.variance_interval(0.95).filter(|_| is_known);
        let (measured_low, measured_high) = interval.unwrap_or((f64::NAN, f64::NAN));
        Self {
            sampler: row.sampler.text.clone(),
            m,
            estimator,
            axis: if half == HalfAxis::Equator { "equator" } else { "random" },
            trials: estimates.estimates().len(),
            predicted: predicted.map(|p| p.variance),
            predicted_stderr: predicted.map(|p| p.stderr).filter(|e| e.is_finite()),
            measured: estimates.variance(),
            measured_stderr: known(estimates.variance() * error.relative()),
            measured_low,
            measured_high,
            over_hemisphere,
            over_hemisphere_stderr: over_hemisphere * error.relative().hypot(of_itself.relative()),
            mean: estimates.mean(),
            exact: row.comparison.exact,
            bias_z: bias.map(|b| b.z),
            bias_p: bias.map(|b| b.p_value),
            n_visible: all.n_visible.mean(),
            n_visible_variance: all.n_visible.variance(),
            empty: all.n_visible.estimates().iter().filter(|n| **n < 0.5).count(),
            predicted_tail: predicted.map(|p| p.tail),
            predicted_tail_error: predicted.map(|p| p.tail_error).filter(|e| e.is_finite()),
        }
    }

    /// Returns the columns of a table.
    pub(super) fn columns() -> Vec<Column<'static, Self>> {
        vec![
            Column::text("sphere sampler", |r: &Self| r.sampler.clone()),
            Column::number("M", |r: &Self| r.m.to_string()),
            Column::number("n", |r: &Self| {
                let spread = number::uncertainty(r.n_visible_variance.sqrt());
                format!("{} +- {spread}", number::count(r.n_visible))
            }),
            Column::text("estimate", |r: &Self| r.estimator.to_owned()),
            Column::number("predicted", |r: &Self| number::optional(r.predicted, number::value)),
            Column::number("measured", |r: &Self| number::value(r.measured)),
            Column::number("half/hemisphere", |r: &Self| {
                number::with_uncertainty(r.over_hemisphere, r.over_hemisphere_stderr)
            }),
            Column::number("bias z", |r: &Self| number::optional(r.bias_z, number::score)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::{Error, if_known};

    #[test]
    fn only_unknown_energies_are_tolerated() {
        let unknown = sphvar_integrands::Error::NoEnergy { reason: "it is a closure" };
        assert!(if_known::<f64>(Err(unknown.into())).unwrap().is_none());
        let magnitude = sphvar_integrands::Error::Magnitude { got: 1e200 };
        for error in [magnitude.into(), Error::from(sphvar_samplers::Stopped)] {
            let message = error.to_string();
            assert_eq!(if_known::<f64>(Err(error)).unwrap_err().to_string(), message);
        }
        assert_eq!(if_known(Ok(2.0)).unwrap(), Some(2.0));
    }
}
