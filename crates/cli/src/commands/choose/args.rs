use clap::{ArgGroup, Args};

use crate::counts::{parse_number, parse_one_count};
use crate::flags::{
    CountArgs, DomainArgs, IntegrandArgs, OutArgs, ProjectArgs, SamplersArgs, SquareArgs,
    integrand_help_with_square,
};

#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("question").args(["error", "count"]).required(true)),
    mut_arg("integrand", |integrand| {
        integrand.required(true).help(integrand_help_with_square())
    }),
    mut_arg("positional_samplers", |samplers| {
        samplers.help(format!("{} [default: those for which predictions are inexpensive]", SamplersArgs::HELP))
    }),
    mut_arg("count", |count| {
        count.help("Number of points N: 1000, 1e4 or 10k; each sampler uses its largest valid count not exceeding N")
    })
)]
pub(crate) struct ChooseArgs {
    #[command(flatten)]
    pub(crate) samplers: SamplersArgs,
    #[command(flatten)]
    pub(crate) integrand: IntegrandArgs,
    #[command(flatten)]
    pub(crate) project: ProjectArgs,
    /// Requested standard error, relative to the integral: 1% or 0.01; above 50 % with a % sign
    #[arg(long, value_name = "E")]
    pub(crate) error: Option<String>,
    #[command(flatten)]
    pub(crate) count: CountArgs,
    /// Interpret --error as an absolute error, in units of the integral
    #[arg(long, requires = "error")]
    pub(crate) absolute: bool,
    #[command(flatten)]
    pub(crate) domain: DomainArgs,
    #[command(flatten)]
    pub(crate) square: SquareArgs,
    /// Maximum number of points considered for --error
    #[arg(long, default_value = "100000", value_name = "N", value_parser = parse_one_count,
        conflicts_with = "count")]
    pub(crate) max_count: usize,
    /// Time to evaluate the integrand once, in seconds: rank by the total time for the set and all values
    #[arg(long, value_name = "SECONDS", requires = "error", value_parser = parse_number)]
    pub(crate) cost_per_sample: Option<f64>,
    #[command(flatten)]
    pub(crate) out: OutArgs,
}
