//! `sphvar lights`: an environment map as directional lights.

mod environment;
mod light_sampler;
mod light_table;
mod picture;

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::Progress as _;
use sphvar_scene::{DirectionalLight, IrradianceError, IrradianceReference};

use self::environment::LightProbe;
use self::light_sampler::{LightSampler, Setting};
use self::light_table::{AXES, COLOURS, LightRow, TableFormat, comments, glsl};
use self::picture::Panel;
use crate::counts::parse_realizations;
use crate::error::CliError;
use crate::flags::{CountsArgs, NearestArgs};
use crate::global::Global;
use crate::progress::Progress;
use crate::report::{Column, Forms, Provenance, csv_rows, emit, number, table_of, write_text};
use crate::spec::argument;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar lights data/city.exr -n 64 -o lights.csv
  sphvar lights env:data/city.exr,up=y -n 16 -o lights.glsl
  sphvar lights data/city.exr --samplers white-noise,median-cut,ccvt:density=luminance -n 64,256 --picture lights.png

A light is a direction x,y,z and the irradiance r,g,b of a surface that faces it. Without up=, the pole of the map is +z, the \
left edge of the picture at +y and its middle at -y. Samplers:
  ccvt:density=luminance[,capacity=K]   cells of equal luminance with a light at their means, K mass points each [default: 64]
  median-cut                            rows and columns divided into parts of equal luminance (Debevec 2005)
  PATTERN:warp=luminance                a pattern of the square, mapped to directions by the luminance of the map
  PATTERN:warp=WARP                     the same by any other density, as in sobol:warp=cylinder
  PATTERN                               a pattern of uniform directions of the sphere

The error is that of the irradiance of surfaces, over all normals, relative to its root mean square: the mean over the \
realizations, of the luminance and of each channel.";

/// The number of lights without -n.
const DEFAULT_COUNT: usize = 64;
/// The sampler with the least error.
const DEFAULT_SAMPLER: &str = "ccvt:density=luminance";

#[derive(Debug, Args)]
#[command(
    mut_arg("counts", |counts| counts.help(format!(
        "Numbers of points N: one, or a list such as 16,64,256 or a range such as 16..1024, which doubles [default: {DEFAULT_COUNT}]"
    )))
)]
pub(crate) struct LightsArgs {
    /// Environment map: a file, OpenEXR or Radiance HDR, or env:FILE with the parameters of the integrand env
    #[arg(value_name = "ENVIRONMENT")]
    pub(crate) environment: OsString,
    #[command(flatten)]
    pub(crate) counts: CountsArgs,
    /// Samplers, separated by commas
    #[arg(long, value_name = "SAMPLERS", default_value = DEFAULT_SAMPLER, value_parser = argument())]
    pub(crate) samplers: String,
    #[command(flatten)]
    pub(crate) nearest: NearestArgs,
    /// Number of realizations; errors are means over them, and the lights are those of the first
    #[arg(short = 'm', long, value_name = "M", default_value = "8", value_parser = parse_realizations)]
    pub(crate) realizations: u64,
    /// Write the results to a file: lights as .csv or .glsl, arrays for a shader, or all as .json; - is CSV on standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Write a picture of a white sphere in the map and under the lights of each sampler in the first realization, with the differences and the error, as .png
    #[arg(long, value_name = "FILE")]
    pub(crate) picture: Option<PathBuf>,
}

/// Lights of an environment map: `lights --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct LightsBody {
    /// The environment map with its parameters.
    environment: String,
    /// The frame of directions, and where the picture lies in it.
    axes: &'static str,
    /// The unit of the colours of lights.
    colours: &'static str,
    /// The lights of a single sampler and number of points; null for several.
    rows: Option<Vec<LightRow>>,
    /// The error of the irradiance of `rows` over all normals, of the luminance, relative to its root
    /// mean square.
    irradiance_error: Option<f64>,
    /// The errors of all samplers and numbers of points.
    irradiance_errors: Vec<ErrorRow>,
}

/// Errors of the irradiance over all normals, relative to its root mean square: means over the
/// realizations.
#[derive(Clone, Debug, Serialize, JsonSchema)]
struct ErrorRow {
    /// The sampler with its parameters.
    sampler: String,
    /// The number of lights.
    n: usize,
    /// The number of realizations; 1 for samplers without randomness.
    realizations: u64,
    /// The error of the luminance; null for a map without luminance.
    error: Option<f64>,
    /// The standard error of `error`; null for a single realization.
    error_stderr: Option<f64>,
    /// The error of the red channel; null where it has no light.
    red: Option<f64>,
    /// The error of the green channel.
    green: Option<f64>,
    /// The error of the blue channel.
    blue: Option<f64>,
    /// The mean time to compute the lights, in seconds.
    seconds: f64,
}

/// The lights and errors of a sampler and a number of points.
struct Outcome {
    row: ErrorRow,
    /// Those of the first realization.
    lights: Vec<DirectionalLight>,
    error: IrradianceError,
}

pub(crate) fn run(args: &LightsArgs, global: &Global) -> Result<(), CliError> {
    if args.realizations == 0 {
        return Err(CliError::Usage("-m must be at least 1, got 0".to_owned()));
    }
    let counts = match args.counts.list() {
        [] => &[DEFAULT_COUNT],
        counts => counts,
    };
    let format = args.out.as_deref().map(TableFormat::of_path).transpose()?;
    let samplers = LightSampler::parse_list(&args.samplers, &global.session)?;
    let is_single = samplers.len() == 1 && counts.len() == 1;
    if matches!(format, Some(TableFormat::Csv | TableFormat::Glsl)) && !is_single {
        return Err(CliError::Usage(
            "-o writes the lights of one sampler and one number of points; .json has the errors of several"
                .to_owned(),
        ));
    }
    if let Some(path) = &args.picture {
        picture::check(path, samplers.len() * counts.len())?;
    }
    let LightProbe { name, pole, environment } =
        LightProbe::read(&args.environment, &global.session)?;
    let setting =
        Setting { environment: &environment, nearest: args.nearest.nearest, seed: global.seed };
    let progress = Progress::new(0.0, &global.session);
    progress.stage("irradiance of the map");
    let reference = IrradianceReference::new(&environment).map_err(CliError::failed)?;
    let mut outcomes = Vec::new();
    for sampler in &samplers {
        for &n in counts {
            progress.stage(&sampler.to_string());
            outcomes.push(outcome(sampler, n, args.realizations, setting, &reference, &progress)?);
        }
    }
    drop(progress);
    let provenance = Provenance::new(&global.session, global.seed);
    if let Some(path) = &args.picture {
        let panels: Vec<Panel<'_>> = outcomes.iter().map(Outcome::panel).collect();
        picture::write(path, pole, &reference, &panels, &provenance)?;
    }
    let single = outcomes.first().filter(|_| is_single);
    let body = LightsBody {
        environment: name,
        axes: AXES,
        colours: COLOURS,
        rows: single.map(|single| single.lights.iter().map(LightRow::from).collect()),
        irradiance_error: single.and_then(|single| single.error.luminance),
        irradiance_errors: outcomes.iter().map(|outcome| outcome.row.clone()).collect(),
    };
    let rows = body.rows.as_deref().unwrap_or_default();
    let mut out = args.out.as_deref();
    if let (Some(TableFormat::Glsl), Some(path)) = (format, out) {
        write_text(path, &glsl(rows, &comments("//", &body.environment, &provenance)))?;
        out = None;
    }
    let head = comments("#", &body.environment, &provenance);
    let csv = || csv_rows(rows).map(|table| format!("{head}{table}"));
    let text = || body.text(args.out.is_none());
    emit(out, global, &provenance, &body, &Forms { csv: &csv, chart: None, text: &text })
}

fn outcome(
    sampler: &LightSampler,
    n: usize,
    realizations: u64,
    setting: Setting<'_>,
    reference: &IrradianceReference,
    progress: &Progress,
) -> Result<Outcome, CliError> {
    let source = sampler.source(n, setting)?;
    let realizations = if source.is_random() { realizations } else { 1 };
    progress.expect(source.nominal_work() * realizations as f64);
    let realize = |index: u64| -> Result<_, CliError> {
        let start = Instant::now();
        let lights = source.lights(index, progress)?;
        let seconds = start.elapsed().as_secs_f64();
        let error = reference.relative_error(&lights).map_err(CliError::failed)?;
        Ok((error, seconds, (index == 0).then_some(lights)))
    };
    let realized =
        (0..realizations).into_par_iter().map(realize).collect::<Result<Vec<_>, CliError>>()?;
    let errors: Vec<IrradianceError> = realized.iter().map(|(error, ..)| *error).collect();
    let seconds = realized.iter().map(|(_, seconds, _)| seconds).sum::<f64>();
    let lights = realized.into_iter().find_map(|(.., lights)| lights).unwrap_or_default();
    let (mean, error_stderr) = IrradianceError::mean(&errors);
    let [red, green, blue] = mean.channels;
    let row = ErrorRow {
        sampler: sampler.to_string(),
        n: lights.len(),
        realizations,
        error: mean.luminance,
        error_stderr,
        red,
        green,
        blue,
        seconds: seconds / realizations as f64,
    };
    Ok(Outcome { row, lights, error: errors[0] })
}

impl Outcome {
    fn panel(&self) -> Panel<'_> {
        Panel { sampler: &self.row.sampler, lights: &self.lights, error: self.error.luminance }
    }
}

impl LightsBody {
    fn text(&self, has_hint: bool) -> String {
        let share = |x: Option<f64>| number::optional(x, number::percent);
        let columns = [
            Column::text("sampler", |row: &ErrorRow| row.sampler.clone()),
            Column::number("N", |row: &ErrorRow| row.n.to_string()),
            Column::number("error", |row: &ErrorRow| share(row.error)),
            Column::number("+-", |row: &ErrorRow| share(row.error_stderr)),
            Column::number("red", |row: &ErrorRow| share(row.red)),
            Column::number("green", |row: &ErrorRow| share(row.green)),
            Column::number("blue", |row: &ErrorRow| share(row.blue)),
            Column::number("time", |row: &ErrorRow| number::seconds(row.seconds)),
        ];
        let mut text = table_of(&columns, &self.irradiance_errors);
        text += "\nerror: of the irradiance over all normals, relative to its root mean square, of the luminance, with its\n\
                 standard error; red, green, blue: of these channels; time: of one realization\n";
        if has_hint && self.rows.is_some() {
            text += "-o FILE.csv or FILE.glsl writes the lights.\n";
        }
        text
    }
}
