//! `sphvar compare`, the main job: which pattern integrates this best, and why.

mod charts;
mod result_folder;

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use sphvar_integrands::Energy;
use sphvar_samplers::Pattern;
use sphvar_variance::{Comparison, RateFit, VariancePoint, fit_exact_rate, fit_rate};

pub(super) use self::charts::variance_chart;
use self::charts::{integrand_chart, spectra_chart};
use self::result_folder::{RECORD, ResultFolder};
use super::crossovers::{CrossoverRecord, crossovers};
use super::rows::{self, Case, EffortArgs, Plan, Row, RowRecord};
use crate::counts::Counts;
use crate::error::CliError;
use crate::global::Global;
use crate::integrands::{self, FORMS, parse_integrand};
use crate::patterns::parse_patterns;
use crate::report::{
    Provenance, csv, full, is_stdout, print, print_json, say, short, table, write_text,
};
use crate::spec::argument;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar compare
  sphvar compare jittered,fibonacci -n 100,1000 --integrand cap:degrees=60 -o cap
  sphvar compare --hemisphere --integrand cosine -o cosine

Every sampler takes the number of points nearest to the one asked for. Into the output folder go \
comparison.csv and .json, spectra.csv, and the plots spectra, variance and integrand as .svg and .png. \
The same command run again replaces its own files, since it gives the same results; the results of another \
command are overwritten only with --force. Two runs cannot write to one folder at the same time.";

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// Samplers, separated by commas, or all [default: white-noise, jittered, healpix, fibonacci]
    pub(crate) samplers: Option<String>,
    /// Numbers of points: 48,108 or 16..1024 for doubling [default: 48 to 3072, seven of them]
    #[arg(
        short = 'n',
        long = "points",
        default_value = "48,108,192,432,768,1728,3072",
        hide_default_value = true,
        value_name = "N"
    )]
    pub(crate) points: Counts,
    #[arg(long, allow_hyphen_values = true, value_parser = argument(), default_value = integrands::CITY, help = format!("Integrand: {FORMS}"))]
    pub(crate) integrand: String,
    #[command(flatten)]
    pub(crate) effort: EffortArgs,
    /// Folder for tables and plots
    #[arg(short, long, default_value = "out", value_name = "FOLDER")]
    pub(crate) out: PathBuf,
    /// Overwrite the results of another run in the folder
    #[arg(long)]
    pub(crate) force: bool,
}

/// What is said about one sampler over all its numbers of points.
#[derive(Debug, Serialize)]
struct Summary {
    sampler: String,
    /// Where rate and gain come from, the more precise one at every N: `predicted`, `measured` or `both`.
    basis: &'static str,
    /// Exponent of the variance and its 95 % interval.
    rate: Option<f64>,
    rate_interval: Option<(f64, f64)>,
    /// By how much the exponent changes from the smallest to the largest number of points, and the
    /// probability of as much where the law is a power, if that is measured.
    rate_change: Option<f64>,
    rate_change_p: Option<f64>,
    /// Whether that is significant: the exponent is not the asymptotic one yet.
    pre_asymptotic: bool,
    /// Exponents of the predicted and of the measured variance, the latter with its 95 % interval.
    predicted_rate: Option<f64>,
    measured_rate: Option<f64>,
    measured_rate_interval: Option<(f64, f64)>,
    /// At the largest number of points: white noise's exact variance over this one.
    n: usize,
    /// Nothing where the variance is no more than rounding.
    gain: Option<f64>,
    gain_stderr: Option<f64>,
    /// The same by the measured variance, where enough trials see the integrand.
    measured_gain: Option<f64>,
    measured_gain_stderr: Option<f64>,
    /// The pattern's power as the integrand weighs it: predicted over white noise's variance.
    power_seen: f64,
}

/// The document of `--json` and of comparison.json.
#[derive(Debug, Serialize)]
struct Document<'a> {
    rows: &'a [RowRecord],
    samplers: &'a [Summary],
    crossovers: &'a [CrossoverRecord],
    provenance: &'a Provenance,
}

pub(crate) fn run(args: &CompareArgs, global: &Global) -> Result<(), CliError> {
    if is_stdout(&args.out) {
        return Err(CliError::Usage(
            "-o must name a folder, not - (the table goes to standard output, with --json as JSON)"
                .to_owned(),
        ));
    }
    let integrand = parse_integrand(&args.integrand, global.quiet)?;
    let domain = super::domain(args.effort.hemisphere);
    let listed = match &args.samplers {
        Some(list) => parse_patterns(list)?,
        None => Pattern::ELEMENTARY.to_vec(),
    };
    let mut patterns: Vec<Pattern> = Vec::new();
    for pattern in listed {
        if !patterns.contains(&pattern) {
            patterns.push(pattern);
        }
    }
    let mut cases: Vec<Case> = Vec::new();
    for pattern in &patterns {
        for &n in args.points.all() {
            let case = Case::new(pattern.clone(), n, domain, true)?;
            let same = |c: &Case| c.pattern == *pattern && c.n_points() == case.n_points();
            if !cases.iter().any(same) {
                cases.push(case);
            }
        }
    }
    let plan = args.effort.plan(&integrand, global, true)?;
    rows::check(&plan, &cases)?;
    let provenance = Provenance::new(global.seed);
    let folder = ResultFolder::open(&args.out, &provenance, args.force)?;
    let (rows, energy) = rows::run(&plan, &cases)?;

    let curves: Vec<Curve<'_>> = patterns.iter().map(|p| Curve::new(p, &rows)).collect();
    let summaries: Vec<Summary> = curves.iter().filter_map(|c| c.summary(&energy)).collect();
    let best: Vec<_> = curves.iter().map(|c| (c.pattern.to_string(), c.best())).collect();
    let crossovers = crossovers(&best, global.seed);
    let records: Vec<RowRecord> = rows.iter().map(|row| RowRecord::new(row, &plan)).collect();
    let document = Document {
        rows: &records,
        samplers: &summaries,
        crossovers: &crossovers,
        provenance: &provenance,
    };
    folder.write(|folder| write_files(folder, &document, &rows, &curves, &energy, &plan))?;
    if global.json {
        return print_json(&document);
    }
    print(&text(&document, &plan))?;
    say(global.quiet, &format!("Tables and plots are in {}", args.out.display()));
    Ok(())
}

/// The rows of one pattern, by number of points.
pub(super) struct Curve<'a> {
    pattern: &'a Pattern,
    rows: Vec<&'a Row>,
}

impl<'a> Curve<'a> {
    pub(super) fn new(pattern: &'a Pattern, rows: &'a [Row]) -> Self {
        let mut rows: Vec<&Row> = rows.iter().filter(|r| r.pattern == *pattern).collect();
        rows.sort_by_key(|r| r.comparison.predicted.spectrum.n_points());
        Self { pattern, rows }
    }

    fn measured(&self) -> Vec<VariancePoint> {
        self.rows.iter().map(|r| r.comparison.measured_point()).collect()
    }

    fn predicted(&self) -> Vec<VariancePoint> {
        self.rows.iter().map(|r| r.comparison.predicted_point()).collect()
    }

    /// The more precise of both at every number of points, as far as its error is known.
    fn best(&self) -> Vec<VariancePoint> {
        let points = self.rows.iter().map(|r| r.comparison.best_point());
        points.filter(|p| p.stderr.is_finite()).collect()
    }

    fn summary(&self, energy: &Energy) -> Option<Summary> {
        let last = self.rows.last()?;
        let n = last.comparison.predicted.spectrum.n_points();
        let white = energy.domain().variance_factor(n) * energy.beyond(0);
        let by_prediction = |c: &Comparison| c.is_prediction_more_precise();
        let n_predicted = self.rows.iter().filter(|r| by_prediction(&r.comparison)).count();
        let (basis, fit) = match n_predicted {
            0 => ("measured", fit_rate(&self.best())),
            all if all == self.rows.len() => ("predicted", fit_exact_rate(&self.best())),
            _ => ("both", fit_rate(&self.best())),
        };
        let measured: Option<RateFit> = fit_rate(&self.measured());
        let gain = |point: VariancePoint| {
            let gain = white / point.variance;
            let stderr = gain * point.stderr / point.variance;
            (gain.is_finite() && stderr.is_finite()).then_some((gain, stderr))
        };
        let best_gain = gain(last.comparison.best_point());
        let measured_gain = gain(last.comparison.measured_point());
        let known = |x: Option<f64>| x.filter(|x| x.is_finite());
        let finite = |i: Option<(f64, f64)>| i.filter(|i| i.0.is_finite() && i.1.is_finite());
        Some(Summary {
            sampler: self.pattern.to_string(),
            basis,
            rate: fit.map(|f| f.slope),
            rate_interval: finite(fit.map(|f| f.interval)),
            rate_change: known(fit.map(|f| f.slope_change)),
            rate_change_p: known(fit.map(|f| f.slope_change_p)),
            pre_asymptotic: fit.is_some_and(|f| f.is_pre_asymptotic()),
            predicted_rate: fit_exact_rate(&self.predicted()).map(|f| f.slope),
            measured_rate: measured.map(|f| f.slope),
            measured_rate_interval: finite(measured.map(|f| f.interval)),
            n,
            gain: best_gain.map(|g| g.0),
            gain_stderr: best_gain.map(|g| g.1),
            measured_gain: measured_gain.map(|g| g.0),
            measured_gain_stderr: measured_gain.map(|g| g.1),
            power_seen: last.comparison.predicted_point().variance / white,
        })
    }
}

/// A measured rate is shown with its interval: of few trials it can be anything.
fn rate_with_interval(rate: Option<f64>, interval: Option<(f64, f64)>) -> String {
    match (rate, interval) {
        (Some(rate), Some((low, high))) => format!("{rate:.2} ({low:.2} to {high:.2})"),
        _ => "-".to_owned(),
    }
}

fn text(document: &Document<'_>, plan: &Plan<'_>) -> String {
    let mut text = format!("Variance of integrating {}\n\n", plan.integrand.name);
    text += &table(&RowRecord::HEADING, document.rows.iter().map(RowRecord::cells).collect(), 1);
    text += &RowRecord::remarks(document.rows);
    // Without a score there is no verdict.
    let scores: Vec<f64> =
        document.rows.iter().map(RowRecord::z).filter(|z| z.is_finite()).collect();
    let agreeing = scores.iter().filter(|z| z.abs() <= 3.0).count();
    let n_rows = scores.len();
    let without = document.rows.len() - n_rows;
    let agreement = format!(
        "Predicted and measured agree within 3 standard errors in {agreeing} of {n_rows} rows"
    );
    text += &match (n_rows, without) {
        (0, _) => "\nNo row has a verdict: too few trials see the integrand.\n\n".to_owned(),
        (_, 0) => format!("\n{agreement}.\n\n"),
        _ => format!("\n{agreement}; {without} have no verdict.\n\n"),
    };
    let optional = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2}"));
    let cells = |s: &Summary| {
        let interval = s.rate_interval.map_or("-".to_owned(), |(a, b)| format!("{a:.2} to {b:.2}"));
        vec![
            s.sampler.to_owned(),
            optional(s.rate) + if s.pre_asymptotic { " *" } else { "" },
            interval,
            rate_with_interval(s.measured_rate, s.measured_rate_interval),
            s.n.to_string(),
            short(s.power_seen),
            s.gain.zip(s.gain_stderr).map_or("-".to_owned(), |(g, e)| format!("{g:.2} +- {e:.2}")),
        ]
    };
    let heading = [
        "sampler",
        "rate",
        "95 %",
        "measured (95 %)",
        "at N",
        "effective power",
        "gain over white noise",
    ];
    text += &table(&heading, document.samplers.iter().map(cells).collect(), 1);
    text += "\nrate: exponent b of variance ~ N^b; it and the gain are from predicted or measured variances, \
             whichever are\nthe more precise. effective power: the pattern's power averaged over the \
             degrees with the integrand's energies;\nwhite noise has 1. gain: how many times the \
             variance is smaller.\n";
    if document.samplers.iter().any(|s| s.pre_asymptotic) {
        text +=
            "*: the rate changes over these numbers of points, it is not the asymptotic one yet.\n";
    }
    text += "\n";
    text.extend(document.crossovers.iter().map(CrossoverRecord::line));
    text + &verdict(document.samplers)
}

/// Which sampler gains most at its largest number of points. Predictions decide: they are more precise
/// than measurements.
fn verdict(samplers: &[Summary]) -> String {
    let with_variance = samplers.iter().filter(|s| s.power_seen.is_finite());
    let Some(best) = with_variance.min_by(|a, b| a.power_seen.total_cmp(&b.power_seen)) else {
        return "The integrand has no variance with any pattern: it is constant.\n".to_owned();
    };
    if best.gain.is_none() || best.power_seen <= 0.0 {
        let exact: Vec<&str> =
            samplers.iter().filter(|s| s.gain.is_none()).map(|s| s.sampler.as_str()).collect();
        return format!("Exact to rounding: {}.\n", exact.join(", "));
    }
    let measured = best.measured_gain.zip(best.measured_gain_stderr);
    let measured =
        measured.map_or(String::new(), |(g, e)| format!(", {g:.1} +- {e:.1} as measured"));
    format!(
        "Largest gain: {} with N = {}, {:.1} times less variance than white noise as predicted{measured}.\n",
        best.sampler,
        best.n,
        1.0 / best.power_seen,
    )
}

fn write_files(
    folder: &Path,
    document: &Document<'_>,
    rows: &[Row],
    curves: &[Curve<'_>],
    energy: &Energy,
    plan: &Plan<'_>,
) -> Result<(), CliError> {
    let provenance = document.provenance;
    let cells: Vec<_> = document.rows.iter().map(RowRecord::record).collect();
    write_text(&folder.join("comparison.csv"), &csv(provenance, RowRecord::COLUMNS, &cells))?;
    let spectra = csv(provenance, "sampler,n,l,omega,power,stderr", &spectrum_records(rows));
    write_text(&folder.join("spectra.csv"), &spectra)?;
    let charts = [
        ("spectra", spectra_chart(curves)),
        ("variance", variance_chart(curves, plan)),
        ("integrand", integrand_chart(energy, plan)),
    ];
    for (name, chart) in charts {
        let chart = chart.with_note(provenance.line());
        chart.render(&folder.join(format!("{name}.svg")))?;
        chart.render(&folder.join(format!("{name}.png")))?;
    }
    let json = serde_json::to_string_pretty(document).map_err(CliError::failed)?;
    write_text(&folder.join(RECORD), &(json + "\n"))
}

fn spectrum_records(rows: &[Row]) -> Vec<Vec<String>> {
    let mut records = Vec::new();
    for row in rows {
        let spectrum = &row.comparison.predicted.spectrum;
        let n = spectrum.n_points();
        for (l, power, stderr) in spectrum.rows() {
            let omega = l as f64 / (n as f64).sqrt();
            records.push(vec![
                row.pattern.to_string(),
                n.to_string(),
                l.to_string(),
                full(omega),
                full(power),
                full(stderr),
            ]);
        }
    }
    records
}
