//! A sheet of pictures with their errors below.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_scene::Image;

use super::colours::grey;
use super::exposure::white;
use super::reference::Reference;
use super::sampler::RenderSampler;
use super::single::ErrorRecord;
use super::stage::{PANEL_SIZE, Stage};
use super::trials::{Outcome, Trials};
use super::{RenderArgs, parse_mode};
use crate::error::CliError;
use crate::files::{AtomicFile, PictureFormat, write_png};
use crate::global::Global;
use crate::memory::check_memory;
use crate::plots::{ContactSheet, SheetPanel};
use crate::progress::Progress;
use crate::report::{Column, Document, Provenance, is_stdout, number, table_of};
use crate::spec::Spec;

/// The default number of directions.
pub(super) const DEFAULT_COUNT: usize = 256;
/// The default number of renders of a panel: the picture itself has a considerable part in its
/// error.
pub(super) const DEFAULT_RENDERS: u64 = 2;

/// The content of a panel.
enum Requested {
    Reference,
    Pattern(Box<Trials>),
}

/// Pictures side by side with their errors: `render --sheet --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SheetBody {
    /// The pictures, without the reference image.
    panels: Vec<PanelRecord>,
    /// Directions of each pixel of the reference image.
    reference_n: usize,
}

/// One picture of a sheet.
#[derive(Debug, Serialize, JsonSchema)]
struct PanelRecord {
    /// The sampler with its parameters.
    sampler: String,
    /// The name of the sampler in tables.
    #[serde(skip)]
    label: String,
    /// The mapping of point sets to directions at each shading point.
    mode: &'static str,
    /// The number of directions on the visible hemisphere of each point.
    n: usize,
    #[serde(flatten)]
    errors: ErrorRecord,
}

impl PanelRecord {
    /// Returns the columns of a table.
    fn columns() -> [Column<'static, Self>; 8] {
        [
            Column::text("sampler", |r: &Self| r.label.clone()),
            Column::text("mode", |r: &Self| r.mode.to_owned()),
            Column::number("N", |r: &Self| r.n.to_string()),
            Column::number("mse", |r: &Self| number::value(r.errors.mse)),
            Column::number("+-", |r: &Self| number::uncertainty(r.errors.mse_stderr)),
            Column::number("firefly", |r: &Self| number::ratio(r.errors.firefly)),
            Column::number("structured error", |r: &Self| number::ratio(r.errors.structured_error)),
            Column::number("correlation", |r: &Self| number::ratio(r.errors.autocorrelation)),
        ]
    }
}

pub(super) fn run(args: &RenderArgs, panels: &str, global: &Global) -> Result<(), CliError> {
    let Some(path) = &args.out else {
        return Err(CliError::Usage(
            "missing required option -o, the .png of the sheet".to_owned(),
        ));
    };
    if PictureFormat::of_path(path)? != PictureFormat::Png {
        return Err(CliError::Usage(format!("{}: sheets are written as .png", path.display())));
    }
    if global.json && is_stdout(path) {
        return Err(CliError::Usage(
            "standard output holds one document: use either -o - or --json".to_owned(),
        ));
    }
    AtomicFile::check(path)?;
    let counts = args.counts.counts.as_ref().map_or(&[DEFAULT_COUNT][..], |counts| counts.all());
    let panels: Result<Vec<_>, CliError> =
        Spec::parse_list(panels)?.iter().map(|spec| sampler(args, &spec.text, global)).collect();
    let panels = panels?;
    let samplers = || panels.iter().flatten();
    args.check_mode(samplers())?;
    let stage = args.stage.stage(PANEL_SIZE, &global.session)?;
    let renders = args.realizations.unwrap_or(DEFAULT_RENDERS);
    let mut requests = Vec::new();
    for &n in counts {
        for panel in &panels {
            requests.push(match panel {
                None => Requested::Reference,
                Some(sampler) => {
                    let trials = Trials::new(args, sampler, &stage, n, renders, global)?;
                    Requested::Pattern(Box::new(trials))
                }
            });
        }
    }
    let region = stage.view()?.region();
    check_memory("the sheet", ContactSheet::bytes([region.width, region.height], requests.len()))?;
    let mut max_points = 0;
    for trials in patterns(&requests) {
        trials.check(&stage)?;
        max_points = max_points.max(trials.plan.n_points());
    }
    Trials::check_sets(args, patterns(&requests))?;
    let is_warped = samplers().any(RenderSampler::is_warped);
    let reference = Reference::new(args, &stage, is_warped, global)?;
    reference.remark(max_points);
    let reference = reference.image(&stage)?;
    let white = white(args.white, &stage, &reference, &global.session);
    let mut cost = 0.0;
    for trials in patterns(&requests) {
        cost += trials.work(&stage)?;
    }
    let progress = Progress::new(cost, &global.session);
    let (mut pictures, mut records) = (Vec::new(), Vec::new());
    for requested in &requests {
        match requested {
            Requested::Reference => {
                let caption = vec![format!("reference, N = {}", reference.n_points)];
                pictures.push(panel(&reference, white, caption));
            }
            Requested::Pattern(trials) => {
                let (panel, record) = rendered(trials, &stage, &reference, white, &progress)?;
                pictures.push(panel);
                records.extend(record);
            }
        }
    }
    drop(progress);
    let provenance = Provenance::new(&global.session, global.seed);
    let columns = requests.len() / counts.len();
    let sheet = ContactSheet { panels: pictures, columns };
    let (size, colours) = sheet.pixels()?;
    write_png(path, size, &colours, &provenance.line())?;
    if global.json {
        let body = SheetBody { panels: records, reference_n: reference.n_points };
        return Document::new(&body, &provenance).print(&global.session);
    }
    if is_stdout(path) {
        return Ok(());
    }
    global.session.print(&table_of(&PanelRecord::columns(), &records))
}

/// Parses `SAMPLER@MODE`, `SAMPLER` in the mode of `--mode`, or `reference`, which is `None`.
fn sampler(
    args: &RenderArgs,
    text: &str,
    global: &Global,
) -> Result<Option<RenderSampler>, CliError> {
    if text == "reference" {
        return Ok(None);
    }
    // A quote belongs to the name of a file or to a density.
    let split = text.rsplit_once('@').filter(|(_, mode)| !mode.contains('"'));
    let (name, mode) = match split {
        Some((name, mode)) => (name, Some(parse_mode(mode)?)),
        None => (text, None),
    };
    let sampler =
        RenderSampler::parse(name, mode.map_or_else(|| args.mode(), Ok)?, &global.session)?;
    if mode.is_some() && sampler.is_warped() {
        return Err(CliError::Usage(format!(
            "{text}: directions of densities have no mode; their sets are shifted at each point"
        )));
    }
    Ok(Some(sampler))
}

/// Returns the panels that show a pattern.
fn patterns(requests: &[Requested]) -> impl Iterator<Item = &Trials> {
    requests.iter().filter_map(|requested| match requested {
        Requested::Reference => None,
        Requested::Pattern(trials) => Some(&**trials),
    })
}

fn panel(image: &Image, white: f64, caption: Vec<String>) -> SheetPanel {
    let colour = grey(white);
    let pixels = image.values.iter().zip(&image.coverage);
    let colours = pixels.flat_map(|(&x, coverage)| colour(x * coverage)).collect();
    SheetPanel { size: [image.width, image.height], colours, caption }
}

fn rendered(
    trials: &Trials,
    stage: &Stage,
    reference: &Image,
    white: f64,
    progress: &Progress,
) -> Result<(SheetPanel, Option<PanelRecord>), CliError> {
    let Outcome { picture, errors, .. } = trials.run(stage, Some(reference), progress)?;
    let plan = &trials.plan;
    let mut caption =
        vec![format!("{}, {}, N = {}", trials.name.label, trials.mode, plan.n_points())];
    let record = errors.as_ref().map(|errors| PanelRecord {
        sampler: trials.name.text.clone(),
        label: trials.name.label.clone(),
        mode: trials.mode,
        n: plan.n_points(),
        errors: ErrorRecord::new(errors),
    });
    caption.extend(record.as_ref().map(|record| {
        let ErrorRecord { mse, structured_error, .. } = record.errors;
        format!("MSE {}, structure {}", number::ratio(mse), number::ratio(structured_error))
    }));
    Ok((panel(&picture, white, caption), record))
}
