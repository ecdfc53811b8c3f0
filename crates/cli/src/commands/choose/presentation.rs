//! The answer as table, JSON, CSV and plot.

use serde::Serialize;
use sphvar_variance::{PredictedPoint, Predictor, RequiredPoints};

use super::ChooseArgs;
use super::candidate::{MAX_FACTOR, TimedCandidate, recommended};
use super::chart::chart;
use super::crossings::{self, CrossingRecord};
use super::question::{Asked, Question};
use super::reason::Reason;
use super::recommendation::recommendation;
use crate::error::CliError;
use crate::global::Global;
use crate::plots::ImageFormat;
use crate::report::{
    Provenance, csv, full, is_stdout, print, print_json, short, table, write_result,
};

/// A sampler that was not considered.
#[derive(Debug, Serialize)]
pub(super) struct LeftOut {
    pub(super) sampler: String,
    pub(super) reason: String,
}

/// What is said of one sampler.
#[derive(Debug, Serialize)]
struct Row {
    rank: usize,
    sampler: String,
    /// The number of points needed, or the legal one nearest to that at hand.
    n: Option<usize>,
    /// `predicted`, `extrapolated`, `out of reach`, or `behind`: more than 4 times the points of the best.
    basis: &'static str,
    /// The largest number of points tried that does not suffice.
    too_few: Option<usize>,
    /// The predicted variance of the integral and its standard error, which is nothing for an
    /// extrapolation.
    variance: Option<f64>,
    variance_stderr: Option<f64>,
    /// The standard error of the integral, `sqrt(variance)`, and the same over the integral.
    error: Option<f64>,
    relative_error: Option<f64>,
    /// How many times less variance than white noise with the same number of points.
    gain: Option<f64>,
    /// The exponent of the variance against N near this N and its 95 % interval.
    rate: Option<f64>,
    rate_interval: Option<(f64, f64)>,
    /// Seconds for making a set on one core; scaled from a smaller one if `seconds_are_scaled`.
    seconds_per_set: Option<f64>,
    seconds_are_scaled: bool,
    /// The same with the values of the integrand, if their cost was given.
    seconds_in_all: Option<f64>,
    /// Of the spectrum at n.
    lmax: Option<usize>,
    realizations: Option<u64>,
    /// Up to which degree the pattern has no power at n, where it is made so.
    last_empty_degree: Option<usize>,
    /// Every prediction that was made.
    curve: Vec<CurvePoint>,
}

#[derive(Debug, Serialize)]
struct CurvePoint {
    n: usize,
    variance: f64,
    variance_stderr: f64,
}

/// The document of `--json`.
#[derive(Debug, Serialize)]
struct Document<'a> {
    integrand: &'a str,
    domain: &'static str,
    /// The exact integral; nothing if it is unknown or 0.
    integral: Option<f64>,
    /// The standard error asked for, in units of the integral.
    error_asked: Option<f64>,
    points_asked: Option<usize>,
    max_points: Option<usize>,
    cost_per_sample: Option<f64>,
    /// The number of points that white noise needs for the error asked for, exactly, however many.
    white_noise_points: Option<f64>,
    rows: &'a [Row],
    left_out: &'a [LeftOut],
    crossovers: &'a [CrossingRecord],
    reason: &'a Option<Reason>,
    recommendation: &'a str,
    provenance: &'a Provenance,
}

/// The whole answer.
pub(super) struct Answer<'a> {
    question: &'a Question,
    candidates: &'a [TimedCandidate],
    rows: Vec<Row>,
    left_out: Vec<LeftOut>,
    crossovers: Vec<CrossingRecord>,
    reason: Option<Reason>,
    recommendation: String,
    white_noise_points: Option<f64>,
    /// Of one point.
    white_variance: f64,
}

impl<'a> Answer<'a> {
    pub(super) fn new(
        question: &'a Question,
        predictor: &mut Predictor<'_>,
        candidates: &'a [TimedCandidate],
        left_out: Vec<LeftOut>,
        seed: u64,
    ) -> Result<Self, CliError> {
        let row = |(i, c): (usize, &TimedCandidate)| row(i + 1, c, question, predictor);
        let rows = candidates.iter().enumerate().map(row).collect();
        let best = recommended(candidates, question);
        let (reason, recommendation) = recommendation(best, question, predictor)?;
        let crossovers = crossings::between(candidates, seed);
        let white_noise_points = question.white_noise_points(predictor);
        Ok(Self {
            question,
            candidates,
            rows,
            left_out,
            crossovers,
            reason,
            recommendation,
            white_noise_points,
            white_variance: predictor.white_variance(1),
        })
    }

    /// Writes and prints the answer in the form asked for.
    pub(super) fn emit(&self, args: &ChooseArgs, global: &Global) -> Result<(), CliError> {
        let provenance = Provenance::new(global.seed);
        let (error_asked, points_asked, max_points) = match self.question.asked {
            Asked::Error { standard_error, max_points, .. } => {
                (Some(standard_error), None, Some(max_points))
            }
            Asked::Points(n) => (None, Some(n), None),
        };
        let document = Document {
            integrand: &self.question.integrand,
            domain: self.question.domain.name(),
            integral: self.question.integral,
            error_asked,
            points_asked,
            max_points,
            cost_per_sample: self.question.cost_per_sample,
            white_noise_points: self.white_noise_points,
            rows: &self.rows,
            left_out: &self.left_out,
            crossovers: &self.crossovers,
            reason: &self.reason,
            recommendation: &self.recommendation,
            provenance: &provenance,
        };
        let out = args.out.as_deref();
        if let Some(path) = out
            && !(global.json && is_stdout(path))
        {
            if ImageFormat::of_path(path).is_some() {
                let chart = chart(self.question, self.candidates, self.white_variance);
                chart.with_note(provenance.line()).render(path)?;
            } else {
                let cells: Vec<_> = self.rows.iter().map(Row::record).collect();
                write_result(path, &document, &|| csv(&provenance, Row::COLUMNS, &cells))?;
            }
        }
        if global.json {
            print_json(&document)
        } else if out.is_some_and(is_stdout) {
            Ok(())
        } else {
            print(&self.text())
        }
    }

    fn text(&self) -> String {
        let question = self.question;
        let mut text = match &question.asked {
            Asked::Error { text, standard_error, .. } => {
                let asked = match question.integral {
                    Some(integral) if question.relative(*standard_error).is_some() => {
                        format!(
                            "{text}, {} of the integral {}",
                            short(*standard_error),
                            short(integral)
                        )
                    }
                    _ => text.clone(),
                };
                format!("Points for a standard error of {asked}: {}\n\n", question.integrand)
            }
            Asked::Points(n) => {
                format!("Standard errors with about {n} points: {}\n\n", question.integrand)
            }
        };
        let mut heading = vec!["sampler", "N", "error", "+-", "gain", "rate", "s/set"];
        if question.cost_per_sample.is_some() {
            heading.push("s in all");
        }
        heading.push("by");
        let (reached, out_of_reach): (Vec<&Row>, Vec<&Row>) =
            self.rows.iter().partition(|row| row.n.is_some());
        if !reached.is_empty() {
            let cells = reached.iter().map(|row| row.cells(question)).collect();
            text += &table(&heading, cells, 1);
            text += "\nerror: one standard error of the integral";
            text += if question.integral.is_some() { ", relative to it" } else { "" };
            text += "; +-: what is not known of it. gain: how many times less\nvariance than white noise \
                     with as many points. rate: exponent of the variance against N near this N.\n\n";
        }
        if let (Asked::Error { max_points, .. }, false) = (&question.asked, out_of_reach.is_empty())
        {
            let is_behind = |row: &&Row| row.basis == "behind";
            let (behind, beyond): (Vec<&Row>, Vec<&Row>) =
                out_of_reach.into_iter().partition(is_behind);
            let names =
                |rows: &[&Row]| rows.iter().map(|row| &*row.sampler).collect::<Vec<_>>().join(", ");
            if !behind.is_empty() {
                text += &format!(
                    "Need more than {MAX_FACTOR} times the points of the best: {}\n",
                    names(&behind)
                );
            }
            if !beyond.is_empty() {
                text += &format!(
                    "Out of reach with {max_points} points (--max-points): {}\n",
                    names(&beyond)
                );
            }
        }
        let empty = |row: &Row| {
            let last = row.last_empty_degree.filter(|&last| last > 0)?;
            Some(format!("{} {last}", row.sampler))
        };
        let empty: Vec<String> = self.rows.iter().filter_map(empty).collect();
        if !empty.is_empty() {
            text += &format!("Last degree without any power: {}\n", empty.join(", "));
        }
        for left in &self.left_out {
            text += &format!("Left out: {} ({})\n", left.sampler, left.reason);
        }
        for crossing in self.crossovers.iter().filter(|c| c.matters()).take(8) {
            text += &crossing.crossover.line();
        }
        text + &self.recommendation + "\n"
    }
}

fn row(
    rank: usize,
    candidate: &TimedCandidate,
    question: &Question,
    predictor: &Predictor<'_>,
) -> Row {
    let curve = &candidate.answer.curve;
    let point = candidate.answer.n_points.and_then(|n| curve.at(n));
    let rate = match candidate.answer.required {
        Some(RequiredPoints::Extrapolated { fit, .. }) => Some(fit),
        _ => candidate.answer.n_points.and_then(|n| curve.rate_near(n)),
    };
    let variance = candidate.answer.variance.map(|v| v.0);
    let white = candidate.answer.n_points.map(|n| predictor.white_variance(n));
    let finite = |x: &f64| x.is_finite();
    let curve_point = |p: &PredictedPoint| CurvePoint {
        n: p.n_points(),
        variance: p.prediction.variance,
        variance_stderr: p.prediction.total_stderr(),
    };
    // A constant has rounding for variance, whose gains and rates mean nothing.
    let varies = predictor.white_variance(1) > 0.0;
    let (rate, white) = (rate.filter(|_| varies), white.filter(|_| varies));
    Row {
        rank,
        sampler: curve.pattern().to_string(),
        n: candidate.answer.n_points,
        basis: candidate.basis(),
        too_few: match candidate.answer.required {
            Some(RequiredPoints::Predicted { too_few, .. }) => too_few,
            _ => None,
        },
        variance,
        variance_stderr: candidate.answer.variance.map(|v| v.1).filter(finite),
        error: variance.map(f64::sqrt),
        relative_error: variance.and_then(|v| question.relative(v.sqrt())),
        gain: white.zip(variance).map(|(white, v)| white / v).filter(finite),
        rate: rate.map(|fit| fit.slope),
        rate_interval: rate.map(|fit| fit.interval).filter(|i| (i.1 - i.0).is_finite()),
        seconds_per_set: candidate.making.map(|m| m.seconds),
        seconds_are_scaled: candidate.making.is_some_and(|m| m.is_scaled),
        seconds_in_all: candidate.seconds_in_all,
        lmax: point.map(|p| p.spectrum.lmax()),
        realizations: point.map(|p| p.spectrum.realizations()),
        last_empty_degree: candidate
            .answer
            .n_points
            .and_then(|n| curve.pattern().last_empty_degree(n, question.domain)),
        curve: curve.points().iter().map(curve_point).collect(),
    }
}

impl Row {
    /// The row of a table for people.
    fn cells(&self, question: &Question) -> Vec<String> {
        let show = |x: Option<f64>, f: &dyn Fn(f64) -> String| x.map_or("-".to_owned(), f);
        let approximate = if self.basis == "extrapolated" { "~" } else { "" };
        let percent = self.relative_error.is_some();
        let error = |e: f64| match 100.0 * e {
            p if !percent => short(p / 100.0),
            p if p > 0.0 && p < 0.1 => format!("{p:.1e} %"),
            p => format!("{p:.3} %"),
        };
        let shown = self.relative_error.or(self.error);
        // Half the relative error of the variance is that of its root.
        let half = self.variance_stderr.zip(self.variance).map(|(e, v)| 0.5 * e / v.max(e));
        let unknown = shown.zip(half).map(|(e, half)| e * half).filter(|e| e.is_finite());
        let scaled = if self.seconds_are_scaled { "~" } else { "" };
        let mut cells = vec![
            self.sampler.clone(),
            self.n.map_or("-".to_owned(), |n| format!("{approximate}{n}")),
            show(shown, &error),
            show(unknown, &error),
            show(self.gain, &|g| if g < 1e5 { format!("{g:.1}") } else { format!("{g:.1e}") }),
            match self.variance {
                Some(v) if v <= 0.0 => "exact".to_owned(),
                _ => show(self.rate, &|r| format!("{r:.2}")),
            },
            show(self.seconds_per_set, &|s| format!("{scaled}{s:.1e}")),
        ];
        if question.cost_per_sample.is_some() {
            cells.push(show(self.seconds_in_all, &|s| format!("{s:.2e}")));
        }
        cells.push(self.basis.to_owned());
        cells
    }

    /// The heading of [`Self::record`].
    const COLUMNS: &'static str = "rank,sampler,n,basis,too_few,variance,variance_stderr,error,\
         relative_error,gain,rate,rate_low,rate_high,seconds_per_set,seconds_are_scaled,\
         seconds_in_all,lmax,realizations,last_empty_degree";

    /// The row of a CSV file.
    fn record(&self) -> Vec<String> {
        let number = |x: Option<f64>| full(x.unwrap_or(f64::NAN));
        let count = |x: Option<usize>| x.map_or(String::new(), |x| x.to_string());
        vec![
            self.rank.to_string(),
            self.sampler.clone(),
            count(self.n),
            self.basis.to_owned(),
            count(self.too_few),
            number(self.variance),
            number(self.variance_stderr),
            number(self.error),
            number(self.relative_error),
            number(self.gain),
            number(self.rate),
            number(self.rate_interval.map(|i| i.0)),
            number(self.rate_interval.map(|i| i.1)),
            number(self.seconds_per_set),
            self.seconds_are_scaled.to_string(),
            number(self.seconds_in_all),
            count(self.lmax),
            self.realizations.map_or(String::new(), |r| r.to_string()),
            count(self.last_empty_degree),
        ]
    }
}

/// A candidate in a line, before all are known.
pub(super) fn line(
    candidate: &TimedCandidate,
    question: &Question,
    predictor: &Predictor<'_>,
) -> String {
    let row = row(0, candidate, question, predictor);
    let cells = row.cells(question);
    match row.n {
        Some(_) => format!("{:<28} N = {:<8} error {}", cells[0], cells[1], cells[2]),
        None => format!("{:<28} {}", cells[0], row.basis),
    }
}
