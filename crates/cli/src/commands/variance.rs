//! `sphvar variance`: predicted and measured variance of patterns on one integrand.

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::Square;

use super::cases::{Case, DirectionCase};
use super::compare::{Curve, variance_chart};
use super::effort::EffortArgs;
use super::fixed_orientation::{self, FixedOrientationRecord};
use super::over_rotations::{self, OverRotationsBody, OverRotationsRecord};
use super::row_record::RowRecord;
use super::rows::{self, Parts, Plan, Row};
use super::square_rows;
use super::visible_half::{self, HalfAxis, VisibleHalfRecord};
use crate::error::CliError;
use crate::flags::{
    CountsArgs, IntegrandArgs, NearestArgs, OutArgs, ProjectArgs, SHIFTED, SamplersArgs,
    integrand_help_with_square,
};
use crate::global::Global;
use crate::integrands::{Integrals, parse_integrands, parse_square_integrand, with_integrals};
use crate::patterns::{parse_patterns, parse_samplers};
use crate::report::{
    Forms, Provenance, check_result, csv_of, csv_of_present, emit, is_stdout, table_of,
};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar variance jittered,white-noise -n 192,768 --integrand cap:degrees=60 -m 2000
  sphvar variance --samplers all -n 1k --nearest --integrand vmf:kappa=20 -m 100
  sphvar variance jittered -n 192 --integrand cap:degrees=60 -m 100 --until-rel 10%
  sphvar variance fibonacci,healpix -n 48,768 --integrand vmf:kappa=20 --predict-only
  sphvar variance jittered,fibonacci -n 48..768 --nearest --integrand cap:degrees=60 -o v.svg
  sphvar variance fibonacci,jittered -n 192 --integrand ylm:l=4,m=0 -m 200 --no-rotate
  sphvar variance fibonacci -n 30 --integrand vmf:kappa=4 -m 4096 --rotations super-fibonacci
  sphvar variance jittered -n 48 --integrand env:data/city.exr --project 2 -m 100
  sphvar variance jittered-square,sobol --square -n 16,64 --integrand disk:radius=0.3 -m 100
  sphvar variance fibonacci,sobol:warp=cosine --hemisphere -n 64 --integrand phong:n=5 -m 100
  sphvar variance jittered -n 768 --integrand cap:degrees=60 -m 2000 --shard 2/3 --save second.shard

Columns: the variance that the spectra predict and the one measured on independent, uniformly \
rotated realizations, each with its standard error (that of the prediction with the error of the \
degrees beyond the spectrum); ratio is measured/predicted, z their difference in standard errors, \
bias z that of the mean estimate and the exact integral. 95 % intervals are in files and --json. \
Where too few trials sample the support of the integrand, the measured variance has no error, ratio or z; where \
all trials agree, it has an upper limit only.

env:FILE,channel=rgb has a row for red, green, blue and luminance, all estimated from the same directions. --project 2 \
has a row for each of the 9 coefficients of a light probe, the integrals of the integrand times the real harmonics to \
degree 2, and one for the irradiance over all normals that they give: its mean squared error integrated over normals, \
and relative error with respect to its root mean square. It does not include the truncation error, from leaving out higher degrees.

--predict-only omits the trials and --measure-only the spectra; in files and --json the other numbers are null then.

--no-rotate gives the errors in the orientation that a pattern has. For a set that is always the same these are \
its signed error and the distribution of errors over uniformly random orientations; for a random pattern, the mean \
error (its bias) and the distribution over realizations, whose variance may differ from that of rotated ones.

--rotations rotates the realizations by sets of rotations of low discrepancy (list rotations) instead of independent ones: the -m trials are 8 sets, each multiplied by a uniformly random rotation, and the error of the measured variance follows from the spread of the 8. For smooth integrands and patterns that are always the same it is much smaller, for integrands with jumps it is not.

--square has patterns of the unit square (sphvar list), shifted by a uniformly random vector modulo 1 in each realization: the \
variance is then the sum over all frequencies k of the power of the pattern times that of the integrand, divided by N.

warp= maps a pattern of the unit square to directions of a density p (sphvar list warps), for importance sampling: \
sobol:warp=cosine, or sobol:warp=\"env:FILE * cosine\". Points have the weights 1/(N p), and the variance is predicted on the unit \
square, from the integrand f divided by p. A sum of warps is multiple importance sampling: \
sobol:warp=\"0.3 * cosine + 0.7 * env:FILE\",heuristic=balance|power, with the numbers as shares of N, has independent points \
for each. max f/p is the largest known ratio; if few trials have a point near it, the measured variance is uncertain.

ccvt:density=WARP[,capacity=64] has the sites of tessellations into cells of equal mass. They are measured with the weights \
1/(N p) too, but nothing predicts their variance, and estimates are biased.

--shard I/K --save FILE computes one of K parts of the work; merge writes what one run would write, bit-identically.";

#[derive(Debug, Args)]
#[command(
    mut_group("SamplersArgs", |samplers| samplers.required(true)),
    mut_arg("positional_samplers", |samplers| samplers.help(SamplersArgs::help_with_warps())),
    mut_arg("integrand", |integrand| {
        integrand.required(true).help(integrand_help_with_square())
    })
)]
pub(crate) struct VarianceArgs {
    #[command(flatten)]
    pub(crate) samplers: SamplersArgs,
    #[command(flatten)]
    pub(crate) counts: CountsArgs,
    #[command(flatten)]
    pub(crate) nearest: NearestArgs,
    #[command(flatten)]
    pub(crate) integrand: IntegrandArgs,
    #[command(flatten)]
    pub(crate) project: ProjectArgs,
    #[command(flatten)]
    pub(crate) effort: EffortArgs,
    /// Also measure the visible half of sphere sets of 2N points with both estimators; the half has a random axis, for antipodal integrands (random, used without a value), or lies above the equator (equator)
    #[arg(long, value_name = "AXIS", num_args = 0..=1, require_equals = true,
        default_missing_value = "random", hide_possible_values = true, requires = "hemisphere")]
    pub(crate) visible_half: Option<HalfAxis>,
    /// Keep the orientation of the patterns: the signed error of sets that are always the same with its distribution over orientations, and the variance and the bias of random patterns
    #[arg(long, conflicts_with_all = ["visible_half", "until_rel"])]
    pub(crate) no_rotate: bool,
    /// Rotate the realizations by sets of a pattern of rotations, such as super-fibonacci, instead of independently
    #[arg(long, value_name = "ROTATIONS", conflicts_with_all = ["visible_half", "until_rel", "no_rotate"])]
    pub(crate) rotations: Option<String>,
    /// Predict variances without trials
    #[arg(long, conflicts_with_all = ["measure_only", "realizations", "until_rel", "max_realizations", "visible_half", "no_rotate", "rotations"])]
    pub(crate) predict_only: bool,
    /// Measure variances without spectra
    #[arg(long, conflicts_with_all = ["spectrum_realizations", "lmax", "kmax", "method", "epsilon", "visible_half", "no_rotate", "rotations"])]
    pub(crate) measure_only: bool,
    #[command(flatten)]
    pub(crate) out: OutArgs,
}

impl VarianceArgs {
    /// Returns what is computed.
    fn parts(&self) -> Parts {
        match (self.predict_only, self.measure_only) {
            (true, _) => Parts::Predicted,
            (_, true) => Parts::Measured,
            _ => Parts::Both,
        }
    }
}

/// Predicted and measured variances: `variance --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct VarianceBody {
    /// Every sampler at every number of points.
    rows: Vec<RowRecord>,
    /// Visible halves of sphere sets, with `--visible-half` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    visible_half: Option<Vec<VisibleHalfRecord>>,
}

pub(crate) fn run(args: &VarianceArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out.out {
        check_result(path, args.rotations.is_none())?;
        let is_json = path.extension().is_some_and(|e| e == "json");
        if args.visible_half.is_some() && !is_json && !(global.json && is_stdout(path)) {
            let message = "--visible-half produces two tables: use --json or a .json file";
            return Err(CliError::Usage(message.to_owned()));
        }
    }
    if args.effort.square.square {
        return run_square(args, global);
    }
    let functions = parse_integrands(args.integrand.required()?, &global.session)?;
    with_integrals(&functions, args.project.project, |integrals| {
        run_integrals(args, global, integrals)
    })
}

fn run_integrals(
    args: &VarianceArgs,
    global: &Global,
    integrals: &Integrals<'_>,
) -> Result<(), CliError> {
    let domain = args.effort.domain.domain();
    let samplers = parse_samplers(&args.samplers.required()?, &global.session)?;
    let cases = DirectionCase::all(&samplers, args.counts.list(), domain, args.nearest.nearest)?;
    let mut plan = args.effort.plan(integrals, global, false)?;
    plan.effort.parts = args.parts();
    if args.no_rotate {
        let option = "--no-rotate";
        integrals.only(option)?;
        return run_fixed(
            args,
            global,
            &plan,
            &DirectionCase::all_uniform(&cases, option, SHIFTED)?,
        );
    }
    if let Some(rotations) = &args.rotations {
        let option = "--rotations";
        integrals.only(option)?;
        let cases = DirectionCase::all_uniform(&cases, option, SHIFTED)?;
        let body = over_rotations::run(rotations, &plan, &cases)?;
        return body.map_or(Ok(()), |body| run_over_rotations(args, global, &body));
    }
    let halves = match args.visible_half {
        Some(axis) => {
            let option = "--visible-half";
            integrals.only(option)?;
            Some((axis, DirectionCase::all_uniform(&cases, option, ONLY_ROTATED)?))
        }
        None => None,
    };
    let rows = rows::run(&plan, &cases)?.map(|(rows, _)| rows);
    let halves = halves
        .map(|(axis, uniform)| visible_half::run(&plan, axis, &uniform, rows.as_deref()))
        .transpose()?;
    let Some(rows) = rows else {
        return global.session.tasks().without_results();
    };
    write(args, global, &rows, &plan.subject(), halves)
}

/// Why `--visible-half` does not apply to warped patterns.
const ONLY_ROTATED: &str = "it has no sets on the sphere";

/// Predicts and measures variances on the unit square.
fn run_square(args: &VarianceArgs, global: &Global) -> Result<(), CliError> {
    let other = [
        ("--no-rotate", args.no_rotate, SHIFTED),
        ("--rotations", args.rotations.is_some(), SHIFTED),
    ];
    let mut effort = square_rows::settings(&args.effort, args.project, &other, global, false)?;
    effort.parts = args.parts();
    let integrand = parse_square_integrand(args.integrand.required()?, &global.session)?;
    let patterns = parse_patterns(&args.samplers.required()?, &global.session)?;
    let cases = Case::all(&patterns, args.counts.list(), Square, args.nearest.nearest)?;
    let Some((rows, _)) = square_rows::run(&integrand, &effort, &cases)? else {
        return global.session.tasks().without_results();
    };
    write(args, global, &rows, &integrand.subject(), None)
}

/// Writes the variances of patterns in the requested form.
fn write(
    args: &VarianceArgs,
    global: &Global,
    rows: &[Row],
    subject: &str,
    visible_half: Option<Vec<VisibleHalfRecord>>,
) -> Result<(), CliError> {
    let provenance = Provenance::new(&global.session, global.seed);
    let body = VarianceBody { rows: rows.iter().map(RowRecord::new).collect(), visible_half };
    let chart = || Ok(variance_chart(&Curve::all(rows), subject));
    let forms = Forms {
        csv: &|| csv_of_present(&provenance, &body.rows),
        chart: Some(&chart),
        text: &|| text(&body, args.parts()),
    };
    emit(args.out.out.as_deref(), global, &provenance, &body, &forms)
}

/// Writes the errors of patterns that are not rotated.
fn run_fixed(
    args: &VarianceArgs,
    global: &Global,
    plan: &Plan<'_>,
    cases: &[&Case],
) -> Result<(), CliError> {
    let Some((body, chart)) = fixed_orientation::run(plan, cases)? else {
        return global.session.tasks().without_results();
    };
    let provenance = Provenance::new(&global.session, global.seed);
    let forms = Forms {
        csv: &|| csv_of(&provenance, &body.rows),
        chart: Some(&|| Ok(chart.clone())),
        text: &|| table_of(&FixedOrientationRecord::columns(), &body.rows),
    };
    emit(args.out.out.as_deref(), global, &provenance, &body, &forms)
}

/// Writes variances over sets of rotations.
fn run_over_rotations(
    args: &VarianceArgs,
    global: &Global,
    body: &OverRotationsBody,
) -> Result<(), CliError> {
    let provenance = Provenance::new(&global.session, global.seed);
    let forms = Forms {
        csv: &|| csv_of(&provenance, &body.rows),
        chart: None,
        text: &|| table_of(&OverRotationsRecord::columns(), &body.rows),
    };
    emit(args.out.out.as_deref(), global, &provenance, body, &forms)
}

fn text(body: &VarianceBody, parts: Parts) -> String {
    let mut text = table_of(&RowRecord::columns(&body.rows, parts), &body.rows);
    text += &RowRecord::remarks(&body.rows);
    if let Some(halves) = &body.visible_half {
        text.push('\n');
        text += &table_of(&VisibleHalfRecord::columns(), halves);
    }
    text
}
