//! `sphvar choose`: which pattern reaches a requested error with the fewest points, or has the
//! smallest error with a given number of points.

mod args;
mod benefit;
mod candidate;
mod chart;
mod choosable;
mod contest;
mod crossings;
mod importance;
mod presentation;
mod question;
mod ranking;
mod reason;
mod recommendation;
pub(crate) mod record;
mod row;
mod set_time;
mod warped;

use sphvar_integrands::Expression;
use sphvar_samplers::Pattern;
use sphvar_variance::PredictionBudget;

pub(crate) use self::args::ChooseArgs;
use self::presentation::Answer;
use self::ranking::Ranking;
use crate::error::CliError;
use crate::flags::{NO_HARMONICS, ONE_DOMAIN};
use crate::global::Global;
use crate::integrands::{parse_integrands, parse_square_integrand, with_integrals};
use crate::report::check_result;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar choose --integrand env:data/city.exr --error 1%
  sphvar choose --integrand cap:degrees=60 -n 1000 -o errors.png
  sphvar choose jittered,fibonacci --integrand ylm:l=4 --absolute --error 0.01
  sphvar choose fibonacci,spiral --integrand band:lmax=40 --error 0.1%
  sphvar choose jittered,fibonacci --integrand env:data/city.exr --project 2 -n 64
  sphvar choose fibonacci,sobol:warp=cosine --integrand vmf:kappa=9 --hemisphere -n 64
  sphvar choose jittered-square,sobol --square --integrand exponential:a=1,b=2 -n 64

The fourth example asks how many directions a function of bandwidth 40 needs: band:lmax=40 is a random \
function with mean 1 and variance 1 over the sphere and equal power in all degrees up to 40. The error \
scales with the ratio of standard deviation and mean of your function.

The error is one standard error of the integral, the root of the predicted variance, over uniform \
rotations of the pattern, or shifts of a pattern of the square. Predictions come from spectra, in closed form or estimated; column +- states the error. The samplers that you name, and \
of all others those that may be within 10 % of the best, are predicted until the variance is \
known to 2 %, where that is affordable (the error may be larger for patterns mapped to densities), with the results of variance and compare. \
The others are predicted to about 18 %, or more precisely until they are known to be further behind. Predictions that serve only to fit rates are \
known to about 6 %, those of more points than the answer to about 18 %. Rows whose variance is not known to 25 % are recommended only where no other is. \
With --error, expensive and warped patterns are not tried with more than 4 times the points of the best; with -n, expensive ones not at all \
where a warped pattern has less than a quarter of the variance of all inexpensive patterns of the sphere, or where four sets take more than \
about a second. \
Patterns for which predictions are too expensive at the requested N are extrapolated by their rate, as column basis \
states. Where step or blue with another alpha would be better than all other samplers, it is shown with that alpha. \
The seconds per set are measured on one core, the median of up to five; those of sets that take longer than about 0.02 s \
follow from their nominal work and are marked ~. Which sampler is the least expensive follows \
from the nominal work of a set, because measured times vary.

Beside the patterns of the sphere, whose directions are uniform, it ranks patterns of the square that are mapped to \
directions of a density (importance sampling), as sobol:warp=cosine: the uniform maps, the cosine, and densities that \
resemble the integrand, such as env:FILE * cosine for a map times the cosine. Of each density it tries three patterns, \
sobol, r2 and jittered-square; of the two densities that are best with these, all inexpensive patterns of the square; one row of the table stands for all \
patterns of a density that are no better than independent points. Several \
densities (multiple importance sampling, \"0.3 * cosine + 0.7 * env:FILE\") have the shares of the points that give the \
least variance, in steps of 5 %; where you name a sampler with several densities, such a row is added. Where a density is the integrand itself, f/p is constant and its normalization is the \
integral: such rows, with the basis \"known integral\", have next to no error and are not recommended, since nobody \
would sample a known integral. They say what remains where unknown factors, such as visibility, are ignored; \
the best of the other densities, such as texels of constant density, shows what an approximate density achieves.

env:FILE,channel=rgb ranks samplers for luminance and for each channel. With --project 2 the error is that of the \
irradiance over all normals which follows from the 9 coefficients of a light probe, relative to its root mean square; \
--json has the error of each coefficient.";

/// A default sampler is omitted if a single prediction takes more work than this number of budgets.
const MAX_BUDGETS: f64 = 2.0;

pub(crate) fn run(args: &ChooseArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out.out {
        check_result(path, true)?;
    }
    if let Some(cost) = args.cost_per_sample
        && !(cost >= 0.0 && cost.is_finite())
    {
        let message = format!("--cost-per-sample must be finite and at least 0, got {cost}");
        return Err(CliError::Usage(message));
    }
    if args.square.square {
        return run_square(args, global);
    }
    let functions = parse_integrands(args.integrand.required()?, &global.session)?;
    with_integrals(&functions, args.project.project, |integrals| {
        let (domain, session) = (args.domain.domain(), &global.session);
        functions.iter().for_each(|function| function.announce_bias(domain, session));
        let ranked = integrals.ranked().map(|(integral, _)| integral.integrand);
        let announce: Vec<_> = ranked
            .map(|integrand| move |lmax: usize| integrand.announce_energies(domain, lmax, session))
            .collect();
        // All channels are sampled by the densities for luminance.
        let proposed: Option<Expression> = integrals.main().name.parse().ok();
        let rankings = integrals
            .ranked()
            .zip(&announce)
            .map(|((integral, coefficients), announce)| {
                Ranking::on_sphere(
                    args,
                    global,
                    integral,
                    coefficients,
                    proposed.as_ref(),
                    announce,
                )
            })
            .collect::<Result<Vec<_>, _>>()?;
        Answer::new(rankings, global.seed)?.emit(args, global)
    })
}

/// Ranks the patterns of the unit square.
fn run_square(args: &ChooseArgs, global: &Global) -> Result<(), CliError> {
    args.square.without(&[
        ("--hemisphere", args.domain.hemisphere, ONE_DOMAIN),
        ("--project", args.project.project.is_some(), NO_HARMONICS),
    ])?;
    let integrand = parse_square_integrand(args.integrand.required()?, &global.session)?;
    let ranking = Ranking::on_square(args, global, &integrand)?;
    Answer::new(vec![ranking], global.seed)?.emit(args, global)
}

/// Returns the work of the minimum number of realizations of a prediction, in budgets, for sets of a
/// nominal work.
fn budgets(work: f64) -> f64 {
    PredictionBudget::MIN_REALIZATIONS as f64 * work / PredictionBudget::DEFAULT.work
}

/// Returns whether a few sets of a pattern take more than 10 budgets, so that its sets are measured only
/// if it is named.
pub(crate) fn is_expensive(pattern: &Pattern, n_points: usize) -> bool {
    const MAX_BUDGETS: f64 = 10.0;
    budgets(pattern.nominal_work(n_points)) > MAX_BUDGETS
}
