//! Mean squared errors against the number of directions, with rates and crossovers.

mod chart;

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_variance::{RateFit, VariancePoint, fit_rate_of_few};

use super::RenderArgs;
use super::reference::Reference;
use super::sampler::RenderSampler;
use super::single::ErrorRecord;
use super::stage::STUDY_SIZE;
use super::trials::{DEFAULT_RENDERS, Trials};
use crate::commands::crossovers::{CrossoverRecord, crossovers};
use crate::counts::Counts;
use crate::error::CliError;
use crate::global::Global;
use crate::patterns::SamplerName;
use crate::progress::Progress;
use crate::report::{Column, Forms, Provenance, check_result, csv_of, emit, number, table_of};

/// The default numbers of directions.
pub(super) const DEFAULT_RANGE: (usize, usize) = (16, 1024);

/// Mean squared errors over the number of directions: `render --study --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct StudyBody {
    /// Every sampler at every number of directions.
    rows: Vec<StudyRecord>,
    /// Every sampler over all its numbers of directions.
    samplers: Vec<StudyRates>,
    /// Significant crossings of curves of the mean squared error.
    crossovers: Vec<CrossoverRecord>,
    /// Directions of each pixel of the reference image.
    reference_n: usize,
    /// The number of pixels in which a surface is visible.
    pixels: usize,
    /// Occlusion rays of all renders.
    rays: u64,
    /// The time of the rays, in seconds.
    seconds: f64,
}

/// A pattern at one number of directions.
#[derive(Debug, Serialize, JsonSchema)]
struct StudyRecord {
    /// The sampler with its parameters.
    sampler: String,
    /// The name of the sampler in tables.
    #[serde(skip)]
    label: String,
    /// The mapping of point sets to directions at each shading point.
    mode: &'static str,
    /// The number of directions requested.
    n_requested: usize,
    /// The number of directions on the visible hemisphere of each point.
    n: usize,
    /// Different sets in all renders together: 1 of lattices, 0 if every pixel has its own.
    sets: u64,
    /// The number of renders from which errors are estimated.
    renders: u64,
    #[serde(flatten)]
    errors: ErrorRecord,
}

/// A fitted exponent b of the error as N^b.
#[derive(Debug, Serialize, JsonSchema)]
struct Rate {
    /// The exponent.
    rate: f64,
    /// Its 95 % interval.
    #[schemars(with = "(Option<f64>, Option<f64>)")]
    interval: (f64, f64),
}

impl From<RateFit> for Rate {
    fn from(fit: RateFit) -> Self {
        Self { rate: fit.slope, interval: fit.interval }
    }
}

/// A sampler over all its numbers of directions.
#[derive(Debug, Serialize, JsonSchema)]
struct StudyRates {
    /// The sampler with its parameters.
    sampler: String,
    /// The name of the sampler in tables.
    #[serde(skip)]
    label: String,
    /// The rate over all numbers; null if there are too few.
    all: Option<Rate>,
    /// The rate over the numbers from the geometric mean of the least and the largest on.
    tail: Option<Rate>,
}

pub(super) fn run(args: &RenderArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out {
        check_result(path, true)?;
    }
    let renders = args.realizations.unwrap_or(DEFAULT_RENDERS);
    if renders < 2 {
        return Err(CliError::Usage(format!(
            "a study requires errors, so -m must be at least 2, got {renders}"
        )));
    }
    let list = args.samplers.as_ref().ok_or_else(|| {
        CliError::Usage("missing required option --samplers, the samplers of the study".to_owned())
    })?;
    let counts =
        args.counts.counts.clone().unwrap_or(Counts::doubling(DEFAULT_RANGE.0, DEFAULT_RANGE.1));
    let mut samplers: Vec<RenderSampler> = Vec::new();
    for sampler in RenderSampler::parse_list(list, args.mode()?, &global.session)? {
        if !samplers.contains(&sampler) {
            samplers.push(sampler);
        }
    }
    args.check_mode(&samplers)?;
    let stage = args.stage.stage(STUDY_SIZE, &global.session)?;
    let mut cases: Vec<Trials> = Vec::new();
    for sampler in &samplers {
        for &n in counts.all() {
            let case = Trials::new(args, sampler, &stage, n, renders, global)?;
            let same = |other: &Trials| {
                other.name.text == case.name.text && other.plan.n_points() == case.plan.n_points()
            };
            if !cases.iter().any(same) {
                cases.push(case);
            }
        }
    }
    Trials::check_sets(args, &cases)?;
    for case in &cases {
        case.check(&stage)?;
    }
    let is_warped = samplers.iter().any(RenderSampler::is_warped);
    let reference = Reference::new(args, &stage, is_warped, global)?;
    reference.remark(cases.iter().map(|case| case.plan.n_points()).max().unwrap_or(0));
    let reference = reference.image_of_run(&stage)?;
    let costs: Result<Vec<f64>, CliError> = cases.iter().map(|c| c.work(&stage)).collect();
    let progress = Progress::new(costs?.iter().sum(), &global.session);
    let tasks = global.session.tasks();
    let (mut rows, mut rays, mut seconds) = (Vec::new(), 0, 0.0);
    for case in &cases {
        let kept = case.kept(&stage, tasks, &progress)?;
        let Some((kept, reference)) = kept.zip(reference.as_ref()) else { continue };
        rays += kept.rays;
        seconds += kept.seconds;
        let renders = kept.count();
        let errors = case.errors(&kept.errors(reference)?, reference);
        rows.push(StudyRecord {
            sampler: case.name.text.clone(),
            label: case.name.label.clone(),
            mode: case.mode,
            n_requested: case.requested,
            n: case.plan.n_points(),
            sets: case.plan.distinct_sets(renders),
            renders,
            errors: ErrorRecord::new(&errors),
        });
    }
    if tasks.is_part() {
        return Ok(());
    }
    let reference = reference.ok_or_else(Reference::missing)?;
    drop(progress);
    let names: Vec<SamplerName> = samplers.iter().map(RenderSampler::name).collect();
    let curves: Vec<Curve<'_>> = names.iter().map(|name| Curve::new(name, &rows)).collect();
    let samplers: Vec<StudyRates> = curves.iter().map(Curve::rates).collect();
    let errors: Vec<_> = curves.iter().map(|c| (c.name.clone(), c.points())).collect();
    let crossovers = crossovers(&errors, global.seed);
    let provenance = Provenance::new(&global.session, global.seed);
    let [reference_n, pixels] = [reference.n_points, reference.n_hits()];
    let body = StudyBody { rows, samplers, crossovers, reference_n, pixels, rays, seconds };
    let chart = || {
        let curves: Vec<Curve<'_>> =
            names.iter().map(|name| Curve::new(name, &body.rows)).collect();
        Ok(chart::chart(&curves, &body))
    };
    let forms = Forms {
        csv: &|| csv_of(&provenance, &body.rows),
        chart: Some(&chart),
        text: &|| text(&body),
    };
    emit(args.out.as_deref(), global, &provenance, &body, &forms)
}

impl StudyRecord {
    /// Returns the columns of a table.
    fn columns() -> [Column<'static, Self>; 10] {
        let score = |t: Option<f64>| number::optional(t, number::ratio);
        [
            Column::text("sampler", |r: &Self| r.label.clone()),
            Column::number("N requested", |r: &Self| r.n_requested.to_string()),
            Column::number("N", |r: &Self| r.n.to_string()),
            Column::number("mse", |r: &Self| number::value(r.errors.mse)),
            Column::number("+-", |r: &Self| number::uncertainty(r.errors.mse_stderr)),
            Column::number("reduction", |r: &Self| number::ratio(r.errors.variance_reduction)),
            Column::number("firefly", |r: &Self| number::ratio(r.errors.firefly)),
            Column::number("structured error", |r: &Self| number::ratio(r.errors.structured_error)),
            Column::number("largest |t|", move |r: &Self| score(r.errors.bias_t)),
            Column::number("99 % limit", move |r: &Self| score(r.errors.bias_limit)),
        ]
    }
}

impl StudyRates {
    /// Returns the columns of a table.
    fn columns() -> [Column<'static, Self>; 5] {
        let rate = |rate: &Option<Rate>| number::optional(rate.as_ref(), |r| number::rate(r.rate));
        let interval =
            |rate: &Option<Rate>| number::interval(rate.as_ref().map(|r| r.interval), number::rate);
        [
            Column::text("sampler", |s: &Self| s.label.clone()),
            Column::number("rate", move |s: &Self| rate(&s.all)),
            Column::number("95 %", move |s: &Self| interval(&s.all)),
            Column::number("upper half", move |s: &Self| rate(&s.tail)),
            Column::number("95 %", move |s: &Self| interval(&s.tail)),
        ]
    }
}

/// The rows of one sampler, by number of directions.
struct Curve<'a> {
    name: &'a SamplerName,
    rows: Vec<&'a StudyRecord>,
}

impl<'a> Curve<'a> {
    fn new(name: &'a SamplerName, rows: &'a [StudyRecord]) -> Self {
        let mut rows: Vec<&StudyRecord> =
            rows.iter().filter(|row| row.sampler == name.text).collect();
        rows.sort_by_key(|row| row.n);
        Self { name, rows }
    }

    fn points(&self) -> Vec<VariancePoint> {
        let point = |row: &&StudyRecord| VariancePoint {
            n_points: row.n as f64,
            variance: row.errors.mse,
            stderr: row.errors.mse_stderr,
        };
        self.rows.iter().map(point).collect()
    }

    fn rates(&self) -> StudyRates {
        let points = self.points();
        let middle = match (points.first(), points.last()) {
            (Some(first), Some(last)) => (first.n_points * last.n_points).sqrt(),
            _ => 0.0,
        };
        let tail: Vec<VariancePoint> =
            points.iter().copied().filter(|p| p.n_points >= middle).collect();
        // Errors come from the renders at each number of points.
        let renders = self.rows.iter().map(|row| row.renders).min().unwrap_or(0);
        let dof = renders.saturating_sub(1) as f64;
        StudyRates {
            sampler: self.name.text.clone(),
            label: self.name.label.clone(),
            all: fit_rate_of_few(&points, dof).map(Rate::from),
            tail: fit_rate_of_few(&tail, dof).map(Rate::from),
        }
    }
}

fn text(body: &StudyBody) -> String {
    let mut text = table_of(&StudyRecord::columns(), &body.rows);
    text += "\nreduction: the exact mean squared error of white noise divided by this one. firefly: the largest error of a pixel over the root\nmean square, 4 to 5 for normal errors of equal size, more where sizes vary. structured error: 1 for \
             independent\npixels, 64 for errors that are the same over 8 by 8. |t|: the bias of a pixel over its standard error;\nthe \
             largest of a picture exceeds the limit by chance in 1 % of pictures.\n\n";
    text += &table_of(&StudyRates::columns(), &body.samplers);
    text.push('\n');
    if !body.crossovers.is_empty() {
        text += "last crossing of each pair within the range:\n";
    }
    text.extend(body.crossovers.iter().map(CrossoverRecord::line));
    text
}
