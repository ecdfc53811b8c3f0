//! Mean squared errors over the number of directions, their rates and crossovers.

mod chart;

use serde::Serialize;
use sphvar_samplers::Pattern;
use sphvar_variance::{RateFit, VariancePoint, fit_rate_of_few};

use super::RenderArgs;
use super::reference::Reference;
use super::single::{ErrorRecord, plain};
use super::trials::{Trials, USUAL_RENDERS};
use crate::commands::crossovers::{CrossoverRecord, crossovers};
use crate::counts::Counts;
use crate::error::CliError;
use crate::global::Global;
use crate::patterns::parse_patterns;
use crate::plots::ImageFormat;
use crate::progress::Progress;
use crate::report::{
    Provenance, check_result, csv, full, is_stdout, print, print_json, short, table, write_result,
};

/// Pixels on a side, unless others are wished.
const USUAL_SIZE: usize = 128;
/// Directions, unless others are wished.
const USUAL_RANGE: (usize, usize) = (16, 1024);

/// The document of `--json`.
#[derive(Debug, Serialize)]
struct Document<'a> {
    rows: &'a [Row],
    samplers: &'a [Summary],
    crossovers: &'a [CrossoverRecord],
    reference_n: usize,
    pixels: usize,
    rays: u64,
    seconds: f64,
    provenance: &'a Provenance,
}

/// One pattern at one number of directions.
#[derive(Debug, Serialize)]
struct Row {
    sampler: String,
    mode: &'static str,
    asked: usize,
    n: usize,
    /// Different sets in all renders together: 1 of lattices, 0 if every pixel has its own.
    sets: u64,
    renders: u64,
    #[serde(flatten)]
    errors: ErrorRecord,
}

/// A fitted exponent with its 95 % interval.
#[derive(Debug, Serialize)]
struct Rate {
    rate: f64,
    interval: (f64, f64),
}

impl From<RateFit> for Rate {
    fn from(fit: RateFit) -> Self {
        Self { rate: fit.slope, interval: fit.interval }
    }
}

/// What is said about one sampler over all its numbers.
#[derive(Debug, Serialize)]
struct Summary {
    sampler: String,
    /// Over all numbers.
    all: Option<Rate>,
    /// Over the numbers from the geometric mean of the least and the largest on.
    tail: Option<Rate>,
}

pub(super) fn run(args: &RenderArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out {
        check_result(path, true)?;
    }
    let renders = args.realizations.unwrap_or(USUAL_RENDERS);
    if renders < 2 {
        return Err(CliError::Usage(format!(
            "a study needs errors, so -m from 2 on, got {renders}"
        )));
    }
    let list = args.samplers.as_ref().ok_or_else(|| {
        CliError::Usage("--samplers is missing: which ones are studied?".to_owned())
    })?;
    let counts = args.points.clone().unwrap_or(Counts::doubling(USUAL_RANGE.0, USUAL_RANGE.1));
    let mode = args.mode()?;
    let mut patterns: Vec<Pattern> = Vec::new();
    let mut cases: Vec<Trials> = Vec::new();
    for pattern in parse_patterns(list)? {
        if patterns.contains(&pattern) {
            continue;
        }
        for &n in counts.all() {
            let case = Trials::new(args, pattern.clone(), mode, n, renders, global.seed)?;
            let same = |c: &Trials| c.plan == case.plan;
            if !cases.iter().any(same) {
                cases.push(case);
            }
        }
        patterns.push(pattern);
    }
    Trials::check_sets(args, &cases)?;
    let stage = args.stage.stage(USUAL_SIZE, global.quiet)?;
    for case in &cases {
        case.check(&stage)?;
    }
    let reference = Reference::new(args, &stage, global)?;
    reference.remark(cases.iter().map(|case| case.plan.n_points()).max().unwrap_or(0));
    let reference = reference.image(&stage)?;
    let costs: Result<Vec<f64>, CliError> = cases.iter().map(|c| c.work(&stage)).collect();
    let progress = Progress::new(costs?.iter().sum(), global.quiet);
    let (mut rows, mut rays, mut seconds) = (Vec::new(), 0, 0.0);
    for case in &cases {
        let outcome = case.run(&stage, Some(&reference), &progress)?;
        rays += outcome.rays;
        seconds += outcome.seconds;
        rows.extend(outcome.errors.as_ref().map(|errors| Row {
            sampler: case.plan.pattern().to_string(),
            mode: mode.name(),
            asked: case.asked,
            n: case.plan.n_points(),
            sets: case.plan.distinct_sets(renders),
            renders,
            errors: ErrorRecord::new(errors),
        }));
    }
    drop(progress);
    let curves: Vec<Curve<'_>> = patterns.iter().map(|p| Curve::new(p, &rows)).collect();
    let summaries: Vec<Summary> = curves.iter().map(Curve::summary).collect();
    let errors: Vec<_> = curves.iter().map(|c| (c.pattern.clone(), c.points())).collect();
    let crossovers = crossovers(&errors, global.seed);
    let provenance = Provenance::new(global.seed);
    let document = Document {
        rows: &rows,
        samplers: &summaries,
        crossovers: &crossovers,
        reference_n: reference.n_points,
        pixels: reference.n_hits(),
        rays,
        seconds,
        provenance: &provenance,
    };
    if let Some(path) = &args.out
        && !(global.json && is_stdout(path))
    {
        if ImageFormat::of_path(path).is_some() {
            chart::chart(&curves, &document).render(path)?;
        } else {
            let cells: Vec<_> = rows.iter().map(Row::record).collect();
            write_result(path, &document, &|| csv(&provenance, Row::COLUMNS, &cells))?;
        }
    }
    if global.json {
        print_json(&document)
    } else if args.out.as_deref().is_some_and(is_stdout) {
        Ok(())
    } else {
        print(&text(&document))
    }
}

impl Row {
    /// The heading of [`Self::record`].
    const COLUMNS: &'static str = "sampler,mode,asked,n,sets,renders,mse,mse_stderr,variance,\
         variance_stderr,bias_squared,bias_squared_stderr,white_noise,gain,structured_error,\
         structured_error_stderr,autocorrelation,bias_t,bias_limit,biased_pixels";

    /// The row of a CSV file.
    fn record(&self) -> Vec<String> {
        let e = &self.errors;
        let mut cells = vec![self.sampler.clone(), self.mode.to_owned()];
        cells.extend(
            [self.asked as u64, self.n as u64, self.sets, self.renders].map(|n| n.to_string()),
        );
        let numbers = [
            e.mse,
            e.mse_stderr,
            e.variance,
            e.variance_stderr,
            e.bias_squared,
            e.bias_squared_stderr,
            e.white_noise,
            e.gain,
            e.structured_error,
            e.structured_error_stderr,
            e.autocorrelation,
            e.bias_t.unwrap_or(f64::NAN),
            e.bias_limit.unwrap_or(f64::NAN),
        ];
        cells.extend(numbers.map(full));
        cells.push(e.biased_pixels.map_or_else(String::new, |n| n.to_string()));
        cells
    }

    /// The row of a table for people.
    fn cells(&self) -> Vec<String> {
        let e = &self.errors;
        vec![
            self.sampler.clone(),
            self.asked.to_string(),
            self.n.to_string(),
            short(e.mse),
            short(e.mse_stderr),
            plain(e.gain, 3),
            plain(e.structured_error, 2),
            e.bias_t.map_or("-".to_owned(), |t| format!("{t:.1}")),
            e.bias_limit.map_or("-".to_owned(), |t| format!("{t:.1}")),
        ]
    }
}

/// The rows of one pattern, by number of directions.
struct Curve<'a> {
    pattern: String,
    rows: Vec<&'a Row>,
}

impl<'a> Curve<'a> {
    fn new(pattern: &Pattern, rows: &'a [Row]) -> Self {
        let pattern = pattern.to_string();
        let mut rows: Vec<&Row> = rows.iter().filter(|row| row.sampler == pattern).collect();
        rows.sort_by_key(|row| row.n);
        Self { pattern, rows }
    }

    fn points(&self) -> Vec<VariancePoint> {
        let point = |row: &&Row| VariancePoint {
            n_points: row.n as f64,
            variance: row.errors.mse,
            stderr: row.errors.mse_stderr,
        };
        self.rows.iter().map(point).collect()
    }

    fn summary(&self) -> Summary {
        let points = self.points();
        let middle = match (points.first(), points.last()) {
            (Some(first), Some(last)) => (first.n_points * last.n_points).sqrt(),
            _ => 0.0,
        };
        let tail: Vec<VariancePoint> =
            points.iter().copied().filter(|p| p.n_points >= middle).collect();
        // Errors come from the renders of each number of points.
        let renders = self.rows.iter().map(|row| row.renders).min().unwrap_or(0);
        let dof = renders.saturating_sub(1) as f64;
        Summary {
            sampler: self.pattern.clone(),
            all: fit_rate_of_few(&points, dof).map(Rate::from),
            tail: fit_rate_of_few(&tail, dof).map(Rate::from),
        }
    }
}

fn text(document: &Document<'_>) -> String {
    let heading = [
        "sampler",
        "N asked",
        "N",
        "mse",
        "+-",
        "gain",
        "structured error",
        "largest |t|",
        "99 % limit",
    ];
    let mut text = table(&heading, document.rows.iter().map(Row::cells).collect(), 1);
    text += "\ngain: white noise's exact mean squared error over this one. structured error: 1 for \
             independent\npixels, 64 for errors that are the same over 8 by 8. |t|: the bias of a pixel over its standard error;\nthe \
             largest of a picture exceeds the limit by chance in 1 % of pictures.\n\n";
    let rate = |rate: &Option<Rate>| match rate {
        Some(Rate { rate, interval: (from, to) }) => {
            [format!("{rate:.2}"), format!("{from:.2} to {to:.2}")]
        }
        None => ["-".to_owned(), "-".to_owned()],
    };
    let cells = |s: &Summary| {
        let [all, tail] = [rate(&s.all), rate(&s.tail)];
        [vec![s.sampler.clone()], all.to_vec(), tail.to_vec()].concat()
    };
    let heading = ["sampler", "rate", "95 %", "upper half", "95 %"];
    text += &table(&heading, document.samplers.iter().map(cells).collect(), 1);
    text.push('\n');
    if !document.crossovers.is_empty() {
        text += "last crossing of each pair within the range:\n";
    }
    text.extend(document.crossovers.iter().map(CrossoverRecord::line));
    text
}
