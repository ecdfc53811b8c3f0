//! `sphvar compare`, the main job: which pattern integrates this best, and why.

mod result_folder;

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use sphvar_samplers::Pattern;
use sphvar_variance::{Energy, RateFit, VariancePoint, fit_rate};

use self::result_folder::{RECORD, ResultFolder};
use super::crossovers::{CrossoverRecord, crossovers};
use super::power_chart::{power_chart, power_series};
use super::rows::{self, Case, EffortArgs, Plan, Row, RowRecord};
use crate::error::CliError;
use crate::global::Global;
use crate::integrands::{FORMS, parse_integrand};
use crate::patterns::parse_patterns;
use crate::plots::{Chart, Scale, Series, Style};
use crate::report::{
    Provenance, csv, full, is_stdout, print, print_json, say, short, table, write_text,
};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar compare
  sphvar compare jittered,fibonacci -n 100,1000 --integrand cap:degrees=60 -o cap
  sphvar compare --hemisphere --integrand cosine -o cosine

Every sampler takes the number of points nearest to the one asked for. Into the output folder go
comparison.csv and .json, spectra.csv, and the plots spectra, variance and integrand as .svg and .png.
The same command run again replaces its own files, since it gives the same results; the results of another
command are overwritten only with --force. Two runs cannot write to one folder at the same time.";

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// Samplers, separated by commas [default: all]
    pub(crate) samplers: Option<String>,
    /// Numbers of points, separated by commas
    #[arg(
        short = 'n',
        long = "points",
        value_delimiter = ',',
        default_values_t = [48, 108, 192, 432, 768, 1728, 3072],
        hide_default_value = true,
        value_name = "N"
    )]
    pub(crate) points: Vec<usize>,
    #[arg(long, default_value = "env:data/city.exr", help = format!("Integrand: {FORMS}"))]
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
    /// Exponent of the measured variance and its 95 % interval.
    rate: Option<f64>,
    rate_interval: Option<(f64, f64)>,
    /// By how much the exponent changes from the smallest to the largest number of points, and the
    /// probability of as much where the law is a power.
    rate_change: Option<f64>,
    rate_change_p: Option<f64>,
    /// Whether that is below 0.1 %: the exponent is not the asymptotic one yet.
    pre_asymptotic: bool,
    /// Exponent of the predicted variance.
    predicted_rate: Option<f64>,
    /// At the largest number of points: white noise's exact variance over the measured one.
    n: usize,
    /// Nothing where the measured variance is no more than rounding.
    gain: Option<f64>,
    gain_stderr: Option<f64>,
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
    let integrand = parse_integrand(&args.integrand)?;
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
        for &n in &args.points {
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
    let measured: Vec<_> = curves.iter().map(|c| (c.pattern.to_string(), c.measured())).collect();
    let crossovers = crossovers(&measured, global.seed);
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
struct Curve<'a> {
    pattern: &'a Pattern,
    rows: Vec<&'a Row>,
}

impl<'a> Curve<'a> {
    fn new(pattern: &'a Pattern, rows: &'a [Row]) -> Self {
        let mut rows: Vec<&Row> = rows.iter().filter(|r| r.pattern == *pattern).collect();
        rows.sort_by_key(|r| r.comparison.spectrum.n_points());
        Self { pattern, rows }
    }

    fn measured(&self) -> Vec<VariancePoint> {
        self.rows.iter().map(|r| r.comparison.measured_point()).collect()
    }

    fn predicted(&self) -> Vec<VariancePoint> {
        self.rows.iter().map(|r| r.comparison.predicted_point()).collect()
    }

    fn summary(&self, energy: &Energy) -> Option<Summary> {
        let last = self.rows.last()?;
        let n = last.comparison.spectrum.n_points();
        let fit: Option<RateFit> = fit_rate(&self.measured());
        let white = energy.domain().variance_factor(n) * energy.beyond(0);
        let measured = last.comparison.measured_point();
        let gain = white / measured.variance;
        let is_measurable = gain.is_finite();
        // Predictions lie closer to their curve than the curve to a power law: all weigh the same.
        let exact: Vec<VariancePoint> =
            self.predicted().into_iter().map(|p| VariancePoint { stderr: 0.0, ..p }).collect();
        let known = |x: Option<f64>| x.filter(|x| x.is_finite());
        Some(Summary {
            sampler: self.pattern.to_string(),
            rate: fit.map(|f| f.slope),
            rate_interval: fit.map(|f| f.interval),
            rate_change: known(fit.map(|f| f.slope_change)),
            rate_change_p: known(fit.map(|f| f.slope_change_p)),
            pre_asymptotic: fit.is_some_and(|f| f.is_pre_asymptotic()),
            predicted_rate: fit_rate(&exact).map(|f| f.slope),
            n,
            gain: is_measurable.then_some(gain),
            gain_stderr: is_measurable.then_some(gain * measured.stderr / measured.variance),
            power_seen: last.comparison.predicted_point().variance / white,
        })
    }
}

fn text(document: &Document<'_>, plan: &Plan<'_>) -> String {
    let mut text = format!("Variance of integrating {}\n\n", plan.integrand.name);
    text += &table(&RowRecord::HEADING, document.rows.iter().map(RowRecord::cells).collect(), 1);
    // Without a score no trial saw the integrand.
    let scores: Vec<f64> =
        document.rows.iter().map(RowRecord::z).filter(|z| z.is_finite()).collect();
    let agreeing = scores.iter().filter(|z| z.abs() <= 3.0).count();
    let n_rows = scores.len();
    text += &format!(
        "\nPredicted and measured agree within 3 standard errors in {agreeing} of {n_rows} rows.\n\n"
    );
    let optional = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2}"));
    let cells = |s: &Summary| {
        let interval = s.rate_interval.map_or("-".to_owned(), |(a, b)| format!("{a:.2} to {b:.2}"));
        vec![
            s.sampler.to_owned(),
            optional(s.rate) + if s.pre_asymptotic { " *" } else { "" },
            interval,
            optional(s.predicted_rate),
            s.n.to_string(),
            short(s.power_seen),
            s.gain.zip(s.gain_stderr).map_or("-".to_owned(), |(g, e)| format!("{g:.1} +- {e:.1}")),
        ]
    };
    let heading =
        ["sampler", "rate", "95 %", "predicted", "at N", "power seen", "gain over white noise"];
    text += &table(&heading, document.samplers.iter().map(cells).collect(), 1);
    text += "\nrate: exponent b of variance ~ N^b. power seen: the pattern's power, averaged over the \
             degrees\nwith the integrand's energies; white noise has 1. gain: how many times the \
             variance is smaller.\n";
    if document.samplers.iter().any(|s| s.pre_asymptotic) {
        text += "*: the rate changes over these numbers of points (false alarms: 0.1 %), it is not the \
                 asymptotic one yet.\n";
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
    let Some((gain, stderr)) = best.gain.zip(best.gain_stderr).filter(|_| best.power_seen > 0.0)
    else {
        let exact: Vec<&str> =
            samplers.iter().filter(|s| s.gain.is_none()).map(|s| s.sampler.as_str()).collect();
        return format!("Exact to rounding: {}.\n", exact.join(", "));
    };
    format!(
        "Largest gain: {} with N = {}, {:.1} times less variance than white noise as predicted, \
         {gain:.1} +- {stderr:.1} as measured.\n",
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
        let chart = Chart { notes: vec![provenance.line()], ..chart };
        chart.render(&folder.join(format!("{name}.svg")))?;
        chart.render(&folder.join(format!("{name}.png")))?;
    }
    let json = serde_json::to_string_pretty(document).map_err(CliError::failed)?;
    write_text(&folder.join(RECORD), &(json + "\n"))
}

fn spectrum_records(rows: &[Row]) -> Vec<Vec<String>> {
    let mut records = Vec::new();
    for row in rows {
        let spectrum = &row.comparison.spectrum;
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

/// The spectra at the largest number of points.
fn spectra_chart(curves: &[Curve<'_>]) -> Chart {
    let series = curves.iter().enumerate().filter_map(|(i, curve)| {
        let spectrum = &curve.rows.last()?.comparison.spectrum;
        let label = format!("{}, N = {}", curve.pattern, spectrum.n_points());
        // Beyond 4 sqrt(N) only lattices are computed, and they only wobble.
        Some(power_series(&label, spectrum, 4.0, i))
    });
    Chart { title: "Angular power spectra".to_owned(), ..power_chart(series.collect()) }
}

fn variance_chart(curves: &[Curve<'_>], plan: &Plan<'_>) -> Chart {
    let points = |p: &[VariancePoint]| p.iter().map(|p| (p.n_points, p.variance)).collect();
    let mut series = Vec::new();
    for (colour, curve) in curves.iter().enumerate() {
        series.push(Series {
            label: format!("{}, predicted", curve.pattern),
            points: points(&curve.predicted()),
            error: None,
            style: Style::Line,
            colour,
        });
        let measured = curve.measured();
        series.push(Series {
            label: format!("{}, measured", curve.pattern),
            points: points(&measured),
            error: Some(measured.iter().map(|p| p.stderr).collect()),
            style: Style::Markers,
            colour,
        });
    }
    Chart {
        title: format!("Variance of integrating {}", plan.integrand.name),
        x_label: "number of points N".to_owned(),
        y_label: "variance".to_owned(),
        x_scale: Scale::Log,
        y_scale: Scale::Log,
        series,
        notes: Vec::new(),
    }
}

fn integrand_chart(energy: &Energy, plan: &Plan<'_>) -> Chart {
    let total = energy.total();
    let degrees = energy.per_degree().iter().enumerate().skip(1);
    Chart {
        title: format!("Energy per degree of {}", plan.integrand.name),
        x_label: "degree l".to_owned(),
        y_label: format!("E(l) / total, total = {}", short(total)),
        x_scale: Scale::Log,
        y_scale: Scale::Log,
        series: vec![Series {
            label: plan.integrand.name.clone(),
            points: degrees.map(|(l, e)| (l as f64, e / total)).collect(),
            error: None,
            style: Style::Line,
            colour: 0,
        }],
        notes: Vec::new(),
    }
}
