//! `sphvar choose`: which pattern reaches a requested error with the fewest points, or has the
//! smallest error with a given number of points.

mod args;
mod candidate;
mod chart;
mod crossings;
mod presentation;
mod question;
mod reason;
mod recommendation;
pub(crate) mod record;

use sphvar_samplers::{EqualAreaParameters, Pattern, Placement, Riesz, RieszParameters};
use sphvar_variance::{Domain, PredictionBudget, Predictor};

pub(crate) use self::args::ChooseArgs;
use self::candidate::TimedCandidate;
use self::presentation::Answer;
use self::question::Question;
use self::record::LeftOut;
use crate::error::CliError;
use crate::global::Global;
use crate::integrands::{check_domain, parse_integrand};
use crate::memory::check_memory;
use crate::patterns::parse_patterns;
use crate::progress::Progress;
use crate::report::{check_result, number};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar choose --integrand env:data/city.exr --error 1%
  sphvar choose --integrand cap:degrees=60 -n 1000 -o errors.png
  sphvar choose jittered,fibonacci --integrand ylm:l=4 --absolute --error 0.01
  sphvar choose fibonacci,spiral --integrand band:lmax=40 --error 0.1%

The last example asks how many directions a function of bandwidth 40 needs: band:lmax=40 is a random \
function with mean 1 and variance 1 over the sphere and equal power in all degrees up to 40. The error \
scales with the ratio of standard deviation and mean of your function.

The error is one standard error of the integral, the root of the predicted variance, over uniform \
rotations of the pattern. Predictions come from spectra, in closed form or estimated until the variance is \
known to 2 %; they are those of variance and compare. Predictions that serve only to fit rates are \
known to about 6 %. With --error, expensive patterns are not tried with more than 4 times the points of the best. \
Patterns for which predictions are too expensive at the requested N are extrapolated by their rate, as column basis \
states. Where step or blue with another alpha would be better than all other samplers, it is shown with that alpha. \
The seconds per set are measured on one core, the median of up to five.";

/// A default sampler is omitted if a single prediction takes more work than this number of budgets.
const MAX_BUDGETS: f64 = 10.0;
/// The number of points at which patterns are ordered by cost if the user gives none.
const TYPICAL_POINTS: usize = 1024;
/// The minimum memory of a point of a transformed set, in bytes.
const BYTES_PER_POINT: f64 = 24.0;

pub(crate) fn run(args: &ChooseArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out.out {
        check_result(path, true)?;
    }
    let integrand = parse_integrand(args.integrand.required()?, global.quiet)?;
    let domain = args.domain.domain();
    check_domain(&integrand, domain)?;
    integrand.announce_bias(domain, global.quiet);
    if let Some(cost) = args.cost_per_sample
        && !(cost >= 0.0 && cost.is_finite())
    {
        let message = format!("--cost-per-sample must be finite and at least 0, got {cost}");
        return Err(CliError::Usage(message));
    }
    let named = args.samplers.list();
    let patterns = match &named {
        Some(list) => parse_patterns(list, global.quiet)?,
        None => considered(),
    };
    let function = &*integrand.function;
    let announce = |lmax: usize| integrand.announce_energies(domain, lmax, global.quiet);
    let mut predictor = Predictor::new(function, domain, global.seed, PredictionBudget::DEFAULT)
        .map_err(CliError::usage)?
        .on_energies(&announce);
    let question = Question::new(args, &integrand, predictor.energy())?;
    if let Some(n) = args.count.count {
        check_memory(&format!("-n {n}"), BYTES_PER_POINT * n as f64)?;
    }

    let typical = args.count.count.unwrap_or(TYPICAL_POINTS);
    let mut patterns = patterns;
    // Inexpensive patterns come first. The order depends on nominal work rather than on time, and
    // so is the same on every machine.
    patterns.sort_by(|a, b| a.nominal_work(typical).total_cmp(&b.nominal_work(typical)));
    patterns.dedup();
    let shares: Vec<f64> = patterns.iter().map(|p| share(p, typical, domain)).collect();
    let progress = Progress::new(shares.iter().sum(), global.quiet);
    let (mut candidates, mut left_out) = (Vec::<TimedCandidate>::new(), Vec::new());
    let (mut best, mut min_points) = (f64::INFINITY, None);
    for (pattern, share) in patterns.into_iter().zip(shares) {
        if candidates.iter().any(|c| *c.answer.curve.pattern() == pattern) {
            continue;
        }
        progress.stage(&pattern.label());
        let budgets = args.count.count.map_or(0.0, |n| budgets(&pattern, n));
        if named.is_none() && budgets > MAX_BUDGETS {
            left_out.push(LeftOut {
                sampler: pattern.to_string(),
                label: pattern.label(),
                reason: format!(
                    "a prediction costs {} times the work budget; name the sampler to include it",
                    number::count(budgets)
                ),
            });
        } else {
            // A pattern that the user names is kept unchanged, however far behind it is.
            let is_named = named.is_some();
            let limit = min_points.filter(|_| !is_named && args.cost_per_sample.is_none());
            let candidate =
                TimedCandidate::new(pattern.clone(), limit, &question, &mut predictor, global.seed)
                    .and_then(|c| {
                        if is_named {
                            Ok(c)
                        } else {
                            c.tuned(&question, &mut predictor, best, global.seed)
                        }
                    });
            match candidate {
                Ok(candidate) => {
                    best = best.min(candidate.answer.variance.map_or(f64::INFINITY, |v| v.0));
                    if candidate.basis() == "predicted" {
                        min_points = candidate.answer.n_points.into_iter().chain(min_points).min();
                    }
                    progress.line(&presentation::line(&candidate, &question, &predictor));
                    candidates.push(candidate);
                }
                Err(error) => left_out.push(LeftOut {
                    sampler: pattern.to_string(),
                    label: pattern.label(),
                    reason: error.to_string(),
                }),
            }
        }
        progress.advance(share);
    }
    drop(progress);
    if candidates.is_empty() {
        let reasons: Vec<String> =
            left_out.iter().map(|l| format!("{}: {}", l.label, l.reason)).collect();
        return Err(CliError::Failed(reasons.join("; ")));
    }
    candidate::rank(&mut candidates, &question);
    Answer::new(&question, &mut predictor, &candidates, left_out, global.seed)?.emit(args, global)
}

/// Returns all patterns, and parameter variants that are the best for some integrands: centred
/// equal-area points for caps, the logarithmic energy for lobes.
fn considered() -> Vec<Pattern> {
    let mut patterns = Pattern::ALL.to_vec();
    patterns.push(Pattern::EqualArea(EqualAreaParameters { placement: Placement::Centred }));
    patterns
        .push(Pattern::Riesz(RieszParameters { s: 0.0, iterations: Riesz::DEFAULT_ITERATIONS }));
    patterns
}

/// Returns the work of the minimum number of realizations of a prediction, in budgets.
fn budgets(pattern: &Pattern, n_points: usize) -> f64 {
    let min_work = PredictionBudget::MIN_REALIZATIONS as f64 * pattern.nominal_work(n_points);
    min_work / PredictionBudget::DEFAULT.work
}

/// Returns whether a single prediction for a pattern takes more than 10 budgets, so that it is
/// considered only if it is named.
pub(crate) fn is_expensive(pattern: &Pattern, n_points: usize) -> bool {
    budgets(pattern, n_points) > MAX_BUDGETS
}

/// Returns the share of a pattern in the total time, for the progress bar.
fn share(pattern: &Pattern, n_points: usize, domain: Domain) -> f64 {
    // Closed forms and single sets take hardly any time.
    const KNOWN: f64 = 0.02;
    let is_estimated = pattern.build(n_points, domain).is_ok_and(|sampler| sampler.is_random())
        && !matches!(pattern, Pattern::WhiteNoise | Pattern::Jittered);
    let is_designed = matches!(pattern, Pattern::Step { .. } | Pattern::Blue { .. });
    // A budget, or the minimum number of realizations; designed patterns are also tuned.
    match (is_estimated, is_designed) {
        (false, _) => KNOWN,
        (true, false) => budgets(pattern, n_points).max(1.0),
        (true, true) => 8.0 * budgets(pattern, n_points).max(1.0),
    }
}
