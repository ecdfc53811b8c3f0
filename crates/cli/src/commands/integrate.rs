//! `sphvar integrate`: the integral of a function to a tolerance.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_integrands::VectorIntegrand;
use sphvar_samplers::{Domain, Pattern, PointSet};
use sphvar_variance::{Integral, IntegrationOptions, StopReason, integrate, integrate_vector};

use super::weights::check_weighted_points;
use crate::counts::{parse_number, parse_one_count};
use crate::error::CliError;
use crate::files::write_points;
use crate::flags::{DomainArgs, IntegrandArgs, SamplerArgs};
use crate::global::Global;
use crate::integrands::parse_integrand;
use crate::memory::check_memory;
use crate::patterns::parse_pattern;
use crate::progress::Progress;
use crate::report::{Document, Provenance, is_stdout, number};
use crate::share::parse_share_or_zero;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar integrate --integrand vmf:kappa=20 --rtol 1e-4
  sphvar integrate --integrand cosine --rtol 0.1% --hemisphere --nodes nodes.npz
  sphvar integrate --integrand ylm:l=7,m=3 --atol 1e-6 --sampler healpix

The value is the mean over 16 independently rotated copies of a set of N points. N doubles until the error is at most \
the larger of --atol and --rtol times the value. The error is the half width of a 95 % interval from the spread of the \
copies, corrected for stopping at the first one that is sufficiently short. An integral of 0 needs --atol. The error is \
unknown while the variance of the values is spread over fewer than 16 evaluations, as it is for features that few points \
hit, or while all values are equal. If the tolerance is not met, the result is printed and the exit status is 1, except \
that equal values suffice if the exact integral is known and within the tolerance. With --nodes, the sum of the weights times the values at the nodes is the value.";

/// The memory of one point of a set: its direction, a value and a weight.
const BYTES_PER_POINT: f64 = 40.0;

#[derive(Debug, Args)]
#[command(
    mut_arg("integrand", |integrand| integrand.required(true)),
    mut_arg("sampler", |sampler| sampler.long("sampler").default_value("fibonacci"))
)]
pub(crate) struct IntegrateArgs {
    #[command(flatten)]
    pub(crate) integrand: IntegrandArgs,
    #[command(flatten)]
    pub(crate) sampler: SamplerArgs,
    /// Relative tolerance, such as 1e-4 or 0.01% [default: 1e-4, or none with --atol]
    #[arg(long, value_name = "E", value_parser = parse_share_or_zero, allow_negative_numbers = true)]
    pub(crate) rtol: Option<f64>,
    /// Absolute tolerance [default: none]
    #[arg(long, value_name = "E", value_parser = parse_number, allow_negative_numbers = true)]
    pub(crate) atol: Option<f64>,
    /// Maximum number of evaluations, summed over all copies and all values of N
    #[arg(long, value_name = "N", default_value = "10M", value_parser = parse_one_count)]
    pub(crate) max_points: usize,
    #[command(flatten)]
    pub(crate) domain: DomainArgs,
    /// Write the nodes with their weights to a file: .csv, .npz or .ply; - is CSV on standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) nodes: Option<PathBuf>,
}

/// The integral of a function to a tolerance: `integrate --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct IntegrateBody {
    /// The integrand.
    integrand: String,
    /// The sampler with its parameters.
    sampler: String,
    /// The estimated integral.
    value: f64,
    /// The half width of the 95 % interval for the integral, or null where the values do not
    /// determine it: all are equal, or too few contribute to their variance.
    error: Option<f64>,
    /// The exact integral, if it is known.
    exact: Option<f64>,
    /// Whether the error is within the tolerance; with equal values, whether the difference from
    /// the exact integral is, if it is known.
    converged: bool,
    /// Why the integration ended: `tolerance`, `rounding` (more points would not reduce the error),
    /// `max-points`, `largest-set` (the sampler has no larger sets), or `equal-values` (all values
    /// are equal, at as many points as the limits allow).
    stop: &'static str,
    /// What limits the validity of the result.
    remarks: Vec<String>,
    /// The relative tolerance.
    rtol: f64,
    /// The absolute tolerance.
    atol: f64,
    /// The number of points of each copy at the last level.
    n: usize,
    /// The number of rotated copies.
    copies: usize,
    /// The number of evaluations at all levels.
    evaluations: u64,
    /// The elapsed time of the integration in seconds.
    seconds: f64,
}

pub(crate) fn run(args: &IntegrateArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.nodes {
        check_weighted_points(path)?;
        if global.json && is_stdout(path) {
            return Err(CliError::Usage(
                "standard output holds one document: use either --nodes - or --json".to_owned(),
            ));
        }
    }
    let integrated = Integrated::new(args, global, None)?;
    let Integrated { body, provenance, failure, .. } = &integrated;
    let to_stdout = args.nodes.as_deref().is_some_and(is_stdout);
    if let Some(path) = args.nodes.as_deref() {
        write_points(path, None, &[integrated.nodes()?], Some(&provenance.line()))?;
    }
    if global.json {
        Document::new(body, provenance).print(&global.session)?;
    } else if !to_stdout {
        global.session.print(&body.text())?;
    }
    body.remarks.iter().for_each(|remark| global.session.say(remark));
    failure.clone().map_or(Ok(()), |failure| Err(CliError::Failed(failure)))
}

/// An integration that has ended.
pub(crate) struct Integrated {
    pub(crate) integral: Integral,
    pub(crate) body: IntegrateBody,
    pub(crate) provenance: Provenance,
    /// Why the tolerance is not met, if it is not.
    pub(crate) failure: Option<String>,
    pattern: Pattern,
    domain: Domain,
    seed: u64,
}

impl Integrated {
    /// Integrates the integrand of the arguments, or the function `vector` in place of it.
    pub(crate) fn new(
        args: &IntegrateArgs,
        global: &Global,
        vector: Option<&dyn VectorIntegrand>,
    ) -> Result<Self, CliError> {
        let text = args.integrand.required()?;
        let integrand = match vector {
            None => Some(parse_integrand(text, &global.session)?),
            Some(_) => None,
        };
        let pattern = match args.sampler.sampler.as_deref() {
            Some(text) => parse_pattern(text, &global.session)?,
            None => Pattern::FIBONACCI,
        };
        let base = IntegrationOptions::default();
        let options = IntegrationOptions {
            rtol: args.rtol.unwrap_or(if args.atol.is_some() { 0.0 } else { base.rtol }),
            atol: args.atol.unwrap_or(base.atol),
            max_points: args.max_points as u64,
            pattern: &pattern,
            domain: args.domain.domain(),
            seed: global.seed,
            ..base
        };
        // The sets of the last level have at most half of all evaluations.
        let largest = args.max_points as f64 / 2.0 / 16.0;
        let in_memory = rayon::current_num_threads().min(16) as f64;
        check_memory("--max-points", BYTES_PER_POINT * largest * in_memory)?;
        let progress = Progress::new(0.0, &global.session);
        progress.stage(&pattern.label());
        let start = Instant::now();
        let integral = match (&integrand, vector) {
            (Some(integrand), _) => integrate(&*integrand.function, &options, &progress),
            (None, Some(vector)) => integrate_vector(vector, &options, &progress),
            (None, None) => return Err(CliError::Usage("no integrand is given".to_owned())),
        };
        let integral = integral.map_err(of_options)?;
        let seconds = start.elapsed().as_secs_f64();
        drop(progress);
        let exact = integrand.as_ref().and_then(|known| known.function.exact(options.domain));
        let outcome = Outcome::new(&integral, exact, &options);
        let body = IntegrateBody {
            integrand: integrand.map_or_else(|| text.to_owned(), |integrand| integrand.name),
            sampler: pattern.to_string(),
            value: integral.value(),
            error: Some(integral.error()).filter(|error| error.is_finite()),
            exact,
            converged: outcome.is_met,
            stop: word(integral.stop),
            remarks: outcome.remarks,
            rtol: options.rtol,
            atol: options.atol,
            n: integral.n_points,
            copies: integral.copies,
            evaluations: integral.evaluations,
            seconds,
        };
        let failure = (!outcome.is_met).then(|| failure(&integral, &pattern, args));
        let (domain, seed) = (options.domain, options.seed);
        let provenance = Provenance::new(&global.session, global.seed);
        Ok(Self { integral, body, provenance, failure, pattern, domain, seed })
    }

    /// Returns the nodes with their weights.
    pub(crate) fn nodes(&self) -> Result<PointSet, CliError> {
        let options = IntegrationOptions {
            pattern: &self.pattern,
            domain: self.domain,
            seed: self.seed,
            ..IntegrationOptions::default()
        };
        Ok(options.nodes(self.integral.n_points)?)
    }
}

/// Whether a result meets the tolerance, and what limits its validity.
struct Outcome {
    is_met: bool,
    remarks: Vec<String>,
}

impl Outcome {
    fn new(integral: &Integral, exact: Option<f64>, options: &IntegrationOptions<'_>) -> Self {
        let (value, error) = (integral.value(), integral.error());
        let mut remarks = Vec::new();
        let evaluations = number::count(integral.evaluations as f64);
        if integral.stop == StopReason::EqualValues {
            let share = number::ratio(integral.unseen_share());
            remarks.push(format!(
                "all {evaluations} values are equal, so the error is unknown: features on less than {share} of the \
                 domain may be missed"
            ));
        } else if integral.estimates.iter().any(|estimate| estimate.error.is_nan()) {
            remarks.push(format!(
                "the error is unknown: too few of {evaluations} values contribute to the variance, as for features \
                 that few points hit"
            ));
        }
        // Where the error is unknown, the known integral decides.
        let tolerance = options.atol.max(options.rtol * value.abs());
        let allowed = if error.is_nan() { tolerance } else { error };
        let difference = exact.map(|exact| (value - exact).abs());
        if difference.is_some_and(|difference| difference > allowed) {
            let name =
                if error.is_nan() { "the tolerance around the value" } else { "the 95 % interval" };
            remarks.push(format!("the exact integral is outside {name}"));
        }
        let is_exact = difference.is_some_and(|difference| difference <= tolerance);
        let is_met =
            integral.has_converged() || integral.stop == StopReason::EqualValues && is_exact;
        Self { is_met, remarks }
    }
}

/// Returns an error of the options as a usage error.
fn of_options(error: sphvar_variance::Error) -> CliError {
    match error {
        sphvar_variance::Error::Parameter { .. } => CliError::usage(error),
        other => other.into(),
    }
}

fn word(stop: StopReason) -> &'static str {
    match stop {
        StopReason::Tolerance => "tolerance",
        StopReason::Rounding => "rounding",
        StopReason::MaxPoints => "max-points",
        StopReason::EqualValues => "equal-values",
        // A reason that a later version adds is a limit of the sampler too.
        _ => "largest-set",
    }
}

/// Returns the message for a tolerance that is not met.
fn failure(integral: &Integral, pattern: &Pattern, args: &IntegrateArgs) -> String {
    let is_known = integral.error().is_finite();
    let error = if is_known { number::uncertainty(integral.error()) } else { "unknown".to_owned() };
    let evaluations = integral.evaluations;
    let missed =
        format!("the tolerance is not met: the error is {error} after {evaluations} evaluations");
    let limit = match integral.stop {
        StopReason::Rounding => ", which is due to rounding".to_owned(),
        StopReason::EqualValues => ", because all values are equal".to_owned(),
        StopReason::LargestSet => {
            format!(
                ", and {} has no set of more than {} points",
                pattern.label(),
                integral.n_points
            )
        }
        _ => format!(", and twice the points would exceed --max-points {}", args.max_points),
    };
    // An interval that contains 0 suggests an integral of 0.
    let may_be_zero = is_known && integral.value().abs() <= integral.error();
    let advice = if may_be_zero { "; if the integral may be 0, give --atol" } else { "" };
    missed + &limit + advice
}

/// Returns a value with its error, if it is known: with all digits where tables show too few, which
/// are six.
fn with_error(value: f64, error: Option<f64>) -> String {
    const MIN_RELATIVE: f64 = 1e-5;
    let Some(error) = error else {
        return format!("{} (error unknown)", number::full(value));
    };
    if error >= MIN_RELATIVE * value.abs() && error <= value.abs() {
        number::with_uncertainty(value, error)
    } else {
        format!("{} +- {}", number::full(value), number::uncertainty(error))
    }
}

impl IntegrateBody {
    fn text(&self) -> String {
        let exact = self.exact.map_or(String::new(), |exact| {
            format!(
                "exact        {} (difference {})\n",
                number::value(exact),
                number::uncertainty(self.value - exact)
            )
        });
        format!(
            "integral     {}\n{exact}\
             points       {} copies of {} ({})\n\
             evaluations  {}\n\
             time         {}\n",
            with_error(self.value, self.error),
            self.copies,
            self.n,
            self.sampler,
            number::count(self.evaluations as f64),
            number::seconds(self.seconds),
        )
    }
}
