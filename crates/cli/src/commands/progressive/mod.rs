//! `sphvar progressive`: predicted and measured errors of every prefix of sequences.

mod chart;
mod prefixes;
pub(crate) mod record;
mod reference;
mod sequence;
mod sequence_errors;
mod study;
mod text;

use clap::Args;

use super::effort::{parse_trials, trials_help};
use crate::error::CliError;
use crate::flags::{
    CountsArgs, DomainArgs, IntegrandArgs, ONE_DOMAIN, OutArgs, SamplersArgs, SquareArgs,
    integrand_help_with_square,
};
use crate::global::Global;
use crate::report::check_result;
use crate::shards::ShardArgs;
use crate::spec::argument;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar progressive sobol,halton -n 1024 --integrand cap:degrees=60
  sphvar progressive sobol,white-noise -n 4096 --integrand env:data/city.exr -m 100 -o errors.svg
  sphvar progressive halton -n 100,200,1000 --integrand vmf:kappa=20 --reference healpix,spiral
  sphvar progressive sobol,halton -n 256 --integrand cap:degrees=60 --no-rotate --reference none
  sphvar progressive sobol,r2,pmj02 --square -n 64 --integrand disk:radius=0.3 -m 100
  sphvar progressive sobol,halton -n 1024 --integrand cosine -m 200 --shard 3/16 --save third.shard

A sequence is a pattern whose first N points, for every N, are a set of the pattern: more points can be added to those that \
are there, as progressive rendering does. sphvar list shows which patterns are sequences. The command computes the error of integrating with the \
first N points, for every N up to the one of -n, or at the listed N. The points of file:PATH are a sequence in the \
order of the file.

Predictions are variances over uniform rotations of the sequence (on the square, over toroidal shifts), \
computed from the power spectra of its prefixes. Measurements are from independent trials; each trial has all prefixes of \
one realization. Tables and plots have standard errors, the square roots of the variances in files and --json.

factor is the standard error divided by that of the reference with as many points, a pattern that is made for each N: what it costs that \
more points can follow. A pattern that has no set of N points has the largest one below; of several patterns the best is used at every N. \
Nothing is interpolated. A list has a factor at every N. With every prefix, patterns of fixed sets that are quickly made are predicted at every N to 256, \
then about every 4 %, and lists with any other at the powers of 2 and halfway between; other N have no factor. Tables show some of \
the N, files all of them.

Different randomizations of a sequence are different samplers: sobol,sobol:randomization=digital compares Owen scrambling \
and digital shifts, each followed by a rotation. --no-rotate leaves out the rotation, or on the square the shift: nothing predicts the error then, unless \
the points are uniform and independent by themselves, and that of a deterministic sequence is the error of one estimate. \
There is no factor then: the reference is predicted over rotations.

--shard divides the trials; each sequence is predicted by one part, and so are the references of each integrand.";

#[derive(Debug, Args)]
#[command(
    mut_group("SamplersArgs", |samplers| samplers.required(true)),
    mut_arg("positional_samplers", |samplers| samplers.help(sequences_help())),
    mut_arg("counts", |counts| {
        counts.help(
            "Numbers of points N: one number for every prefix up to it; a list such as 100,400 or a range such as \
             16..1024, which doubles, for those prefixes",
        )
    }),
    mut_arg("integrand", |integrand| {
        integrand.required(true).help(integrand_help_with_square())
    })
)]
pub(crate) struct ProgressiveArgs {
    #[command(flatten)]
    pub(crate) samplers: SamplersArgs,
    #[command(flatten)]
    pub(crate) counts: CountsArgs,
    #[command(flatten)]
    pub(crate) integrand: IntegrandArgs,
    #[arg(short = 'm', long, value_name = "M", value_parser = parse_trials, help = trials_help(""))]
    pub(crate) realizations: Option<u64>,
    /// Patterns with which sequences are compared at every N, or none
    #[arg(long, value_name = "SAMPLERS", value_parser = argument(), default_value = "fibonacci",
        default_value_if("square", "true", "fibonacci-lattice"))]
    pub(crate) reference: String,
    /// Keep the orientation of the patterns, on the square their position: errors are measured only
    #[arg(long)]
    pub(crate) no_rotate: bool,
    #[command(flatten)]
    pub(crate) domain: DomainArgs,
    #[command(flatten)]
    pub(crate) square: SquareArgs,
    #[command(flatten)]
    pub(crate) out: OutArgs,
    #[command(flatten)]
    pub(crate) sharding: ShardArgs,
}

fn sequences_help() -> String {
    SamplersArgs::help_with_warps()
        .replace("all is every built-in sampler", "all is every built-in sequence")
}

pub(crate) fn run(args: &ProgressiveArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out.out {
        check_result(path, true)?;
    }
    args.square.without(&[("--hemisphere", args.domain.hemisphere, ONE_DOMAIN)])?;
    if args.square.square {
        study::run_square(args, global)
    } else {
        study::run_sphere(args, global)
    }
}
