//! `sphvar accuracy`: measured errors and times, and the error bounds of extreme inputs.

mod charts;
pub(crate) mod machine;
mod markdown;
pub(crate) mod record;
mod timing;

use std::path::{Path, PathBuf};

use clap::Args;
use sphvar_accuracy::{Area, Effort, hard_cases, trials};
use sphvar_samplers::Progress as _;

use self::charts::{area_chart, chart_name};
use self::machine::{Machine, today};
use self::record::{AccuracyBody, HardCaseRecord, TrialRecord};
use self::timing::median_seconds;
use crate::error::CliError;
use crate::files::AtomicFile;
use crate::global::Global;
use crate::plots::ImageFormat;
use crate::progress::Progress;
use crate::report::{Forms, Provenance, check_result, emit, write_text};
use crate::session::Session;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar accuracy harmonics indexing --quick
  sphvar accuracy transforms --plot transforms.svg
  sphvar accuracy -o docs/accuracy.md --plot docs/images   (everything; minutes)

Areas are harmonics (associated Legendre functions, spherical harmonics), indexing (HEALPix), transforms \
(exact and fast), spectra, predictions, quality (sums over pairs), weights (quadrature weights, weighted sets), fits (least squares), square (transforms on the unit square) and warps (maps from the square to directions). Every method is timed (the median of at least 5 runs, 3 with \
--quick, of at least 0.1 s in all) and compared with a more accurate reference: values with 25 \
digits, twice the working precision, or a closed form. Hard cases are extreme inputs. Every maximum \
error has a bound, and the exit status is 1 if one is exceeded. The seeds of all inputs are fixed, so \
--seed has no effect.";

#[derive(Debug, Args)]
pub(crate) struct AccuracyArgs {
    /// Areas to measure: harmonics, indexing, transforms, spectra, predictions, quality, weights, fits, square, warps [default: all]
    #[arg(value_name = "AREAS", value_parser = parse_area)]
    areas: Vec<Area>,
    /// Use smaller inputs: some seconds per area
    #[arg(long)]
    quick: bool,
    /// Write the results to a file: .md, .json or .csv, or the chart of one area as .svg or .png
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Plot error against time: one area to a file, .svg or .png, or every area to a folder
    #[arg(long, value_name = "FILE|FOLDER")]
    plot: Option<PathBuf>,
}

pub(crate) fn run(args: &AccuracyArgs, global: &Global) -> Result<(), CliError> {
    let areas: Vec<Area> = Area::ALL
        .into_iter()
        .filter(|area| args.areas.is_empty() || args.areas.contains(area))
        .collect();
    let mut plots = plot_paths(args.plot.as_deref(), &areas)?;
    if let Some(path) = &args.out {
        if is_image(path) {
            plots.extend(plot_paths(Some(path), &areas)?);
        } else if is_markdown(path) {
            AtomicFile::check(path)?;
        } else {
            check_out(path)?;
        }
    }
    if cfg!(debug_assertions) {
        global
            .session
            .say("this build has debug assertions: times are longer than those of a release");
    }
    let (trials, hard_cases) = measure(&areas, args.quick, &global.session)?;
    let provenance = Provenance::new(&global.session, global.seed);
    let body = AccuracyBody {
        held: trials.iter().all(|t| t.outcome.held) && hard_cases.iter().all(|c| c.outcome.held),
        quick: args.quick,
        date: today(),
        version: provenance.version.clone(),
        machine: Machine::of_this_run(),
        trials,
        hard_cases,
    };
    for (area, path) in &plots {
        area_chart(*area, &body, &provenance).render(path)?;
    }
    let markdown = args.out.as_deref().filter(|path| is_markdown(path));
    if let Some(path) = markdown {
        write_text(path, &body.markdown(&links(path, &plots), &provenance))?;
    }
    let out = args.out.as_deref().filter(|path| markdown.is_none() && !is_image(path));
    let forms = Forms { csv: &|| body.csv(&provenance), chart: None, text: &|| body.text() };
    emit(out, global, &provenance, &body, &forms)?;
    body.verdict()
}

fn parse_area(text: &str) -> Result<Area, String> {
    Area::ALL.into_iter().find(|area| area.name() == text).ok_or_else(|| {
        let names = Area::ALL.map(Area::name);
        format!("unknown area; valid: {}", names.join(", "))
    })
}

fn is_markdown(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "md")
}

fn is_image(path: &Path) -> bool {
    ImageFormat::of_path(path).is_some()
}

fn check_out(path: &Path) -> Result<(), CliError> {
    check_result(path, false).map_err(|error| match error {
        CliError::Usage(_) => CliError::Usage(format!(
            "{}: results are written as .md, .json or .csv, a chart of one area as .svg or .png",
            path.display()
        )),
        other => other,
    })
}

/// Returns the paths of the charts, and rejects invalid ones before the work starts.
fn plot_paths(plot: Option<&Path>, areas: &[Area]) -> Result<Vec<(Area, PathBuf)>, CliError> {
    let Some(plot) = plot else { return Ok(Vec::new()) };
    let paths = match (ImageFormat::of_path(plot), areas) {
        (Some(_), [area]) => vec![(*area, plot.to_path_buf())],
        (Some(_), _) => {
            return Err(CliError::Usage(format!(
                "{}: a file has the chart of one area; name one, or give --plot a folder",
                plot.display()
            )));
        }
        (None, _) => areas.iter().map(|&area| (area, plot.join(chart_name(area)))).collect(),
    };
    for (_, path) in &paths {
        AtomicFile::check(path)?;
    }
    Ok(paths)
}

/// Runs all trials and extreme inputs.
fn measure(
    areas: &[Area],
    quick: bool,
    session: &Session,
) -> Result<(Vec<TrialRecord>, Vec<HardCaseRecord>), CliError> {
    let effort = if quick { Effort::Quick } else { Effort::Full };
    // The duration of a trial is not known in advance, so each counts as one.
    let progress = Progress::new(0.0, session);
    let (mut records, mut case_records) = (Vec::new(), Vec::new());
    for &area in areas {
        // Areas run one after the other, because the inputs of all would not fit in memory.
        let trials = trials(area, effort);
        let cases = hard_cases(area);
        progress.expect((trials.len() + cases.len()) as f64);
        for mut trial in trials {
            progress.stage(&format!("{}: {}", trial.method, trial.case));
            let seconds = median_seconds(&mut *trial.subject, effort);
            let errors = trial.subject.errors();
            records.push(TrialRecord::new(&trial, seconds, &errors));
            progress.advance(1.0)?;
        }
        for case in cases {
            progress.stage(case.name);
            case_records.push(HardCaseRecord::new(area, &case, &(case.measure)()));
            progress.advance(1.0)?;
        }
    }
    Ok((records, case_records))
}

/// Returns the charts with their paths relative to a document beside or above them.
fn links(document: &Path, plots: &[(Area, PathBuf)]) -> Vec<(Area, String)> {
    // The paths are absolute, so that `./docs` and `docs` are the same folder.
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let document = absolute(document);
    let folder = document.parent().unwrap_or(Path::new(""));
    let link = |path: &Path| {
        let whole = absolute(path);
        whole.strip_prefix(folder).unwrap_or(path).display().to_string()
    };
    plots.iter().map(|(area, path)| (*area, link(path))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_below_the_document_are_named_from_there() {
        let plots = [(Area::Spectra, PathBuf::from("docs/images/a.svg"))];
        for document in ["docs/accuracy.md", "./docs/accuracy.md"] {
            assert_eq!(links(Path::new(document), &plots)[0].1, "images/a.svg", "{document}");
        }
        assert_eq!(links(Path::new("other/accuracy.md"), &plots)[0].1, "docs/images/a.svg");
    }
}
