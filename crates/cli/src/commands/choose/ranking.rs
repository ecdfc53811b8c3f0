//! The samplers for one integral, best first.

use sphvar_integrands::{Expression, Integrand, WarpExpression};
use sphvar_samplers::{Pattern, SquarePattern};
use sphvar_variance::{
    PredictionBudget, Predictor, SquarePredictor, WarpedPattern, predict, settled_degree_of,
};

use super::args::ChooseArgs;
use super::candidate::{EXPENSIVE, TimedCandidate};
use super::choosable::{Density, patterns, share, square_patterns, square_share};
use super::contest::Contest;
use super::question::Question;
use super::record::{CoefficientRecord, LeftOut};
use super::row::{Row, rank};
use super::warped::WarpedIntegral;
use crate::error::CliError;
use crate::global::Global;
use crate::integrands::{Integral, NamedSquareIntegrand, check_domain};
use crate::memory::check_memory;
use crate::patterns::{DirectionSampler, UNPREDICTED, parse_patterns, parse_samplers};
use crate::progress::Progress;
use crate::report::number;

/// The number of points at which patterns are ordered by cost if the user gives none.
const TYPICAL_POINTS: usize = 1024;
/// The minimum memory of a point of a transformed set, in bytes.
const BYTES_PER_POINT: f64 = 24.0;

/// The samplers for one integral, best first.
pub(super) struct Ranking<'a> {
    pub(super) question: Question,
    pub(super) domain: String,
    pub(super) rows: Vec<Row>,
    pub(super) left_out: Vec<LeftOut>,
    /// The variance of white noise with one point.
    pub(super) white_variance: f64,
    /// The number of points with which white noise has the requested error.
    pub(super) white_noise_points: Option<f64>,
    /// On the sphere and the hemisphere, which have a degree beyond which every pattern has the mean
    /// power of white noise.
    uniform: Option<Predictor<'a>>,
}

/// A coefficient of a projection.
struct Coefficient<'a> {
    l: usize,
    m: i64,
    exact: Option<f64>,
    predictor: Predictor<'a>,
}

impl<'a> Ranking<'a> {
    /// Returns the candidates for an integral over the sphere or the hemisphere: those that the user
    /// names, or all patterns and the densities proposed for an integrand.
    pub(super) fn on_sphere(
        args: &ChooseArgs,
        global: &Global,
        integral: &'a Integral<'_>,
        coefficients: &'a [Integral<'_>],
        proposed: Option<&Expression>,
        announce: &'a dyn Fn(usize),
    ) -> Result<Self, CliError> {
        let (integrand, domain) = (integral.integrand, args.domain.domain());
        check_domain(integrand, domain)?;
        let named = args.samplers.list();
        let named = named.map(|list| parse_samplers(&list, &global.session)).transpose()?;
        let of = |function: &'a dyn Integrand| {
            Predictor::new(function, domain, global.seed, PredictionBudget::DEFAULT)
                .map_err(CliError::usage)
        };
        let mut predictor = of(&*integrand.function)?.on_energies(announce);
        let quantity = if integral.is_irradiance() { "irradiance" } else { "integral" };
        let estimate = integrand.function.integral_estimate(domain);
        let largest = (domain.area() * predictor.energy().total()).sqrt();
        let question = Question::new(args, &integrand.name, quantity, estimate, largest)?;
        let coefficient = |integral: &'a Integral<'_>| {
            let (l, m) = integral.order.unwrap_or_default();
            let function = &*integral.integrand.function;
            let exact = function.exact(domain);
            Ok(Coefficient { l, m, exact, predictor: of(function)? })
        };
        let mut coefficients =
            coefficients.iter().map(coefficient).collect::<Result<Vec<_>, CliError>>()?;

        let is_named = named.is_some();
        let (uniform, warped) = match named {
            Some(named) => split(named)?,
            None => (patterns(), Vec::new()),
        };
        if let (Some(warped), true) = (warped.first(), integral.is_irradiance()) {
            return Err(CliError::Usage(format!(
                "--project does not apply to {warped}; name a coefficient as \"f * ylm:l=2,m=1\""
            )));
        }
        let typical = typical_points(args)?;
        // White noise is predicted in no time, so that a first row is shown at once.
        let work = |p: &Pattern| match p {
            Pattern::WhiteNoise => 0.0,
            _ => p.nominal_work(typical),
        };
        let (uniform, shares) = in_order(uniform, work, |p| share(p, typical, domain));
        let expression = proposed;
        let proposed = proposed.filter(|_| !is_named && !integral.is_irradiance());
        let n_densities =
            proposed.map_or(warped.len(), |p| WarpExpression::proposed(p, domain).len());
        let progress =
            Progress::new(shares.iter().sum::<f64>() + n_densities as f64, &global.session);
        let mut contest = Contest::new(question, global.seed, is_named, &progress);
        // Patterns that are expensive to generate come after the densities, with which they must
        // compete.
        let is_expensive = |p: &Pattern| p.nominal_work(typical) >= EXPENSIVE * typical as f64;
        let n_inexpensive = uniform.iter().take_while(|p| !is_expensive(p)).count();
        let mut all = uniform.into_iter().zip(shares);
        // The patterns with their rows, which are predicted fully once all others are known.
        let mut surveyed = Vec::new();
        let white_of = |predictor: &Predictor<'_>, n: usize| predictor.white_variance(n);
        let mut add = |contest: &mut Contest<'_>, predictor: &mut Predictor<'a>, count: usize| {
            for (pattern, share) in all.by_ref().take(count) {
                let index = contest.rows.len();
                if let Some(candidate) = contest.survey(pattern, predictor, white_of) {
                    surveyed.push((index, candidate));
                }
                progress.advance(share)?;
            }
            Ok::<_, CliError>(())
        };
        add(&mut contest, &mut predictor, n_inexpensive)?;
        let (function, seed, session) = (&*integrand.function, global.seed, &global.session);
        let of_warps = WarpedIntegral { function, integrand: expression, domain, seed, session };
        let white = |n: usize| predictor.white_variance(n);
        of_warps.add_named(&mut contest, warped, &progress, &white)?;
        if let Some(proposed) = proposed {
            of_warps.add_proposed(&mut contest, proposed, &progress, &white)?;
        }
        match contest.lead_of_warped() {
            Some(ratio) => {
                for (pattern, _) in all {
                    let reason = format!(
                        "a pattern mapped from the square has {} times less variance than the inexpensive patterns \
                         of the sphere; name the sampler to include it",
                        number::ratio(ratio)
                    );
                    contest.leave_out(pattern.to_string(), pattern.label(), reason);
                }
            }
            None => add(&mut contest, &mut predictor, usize::MAX)?,
        }
        surveyed.sort_by(|a, b| contest.rows[a.0].merit.total_cmp(&contest.rows[b.0].merit));
        while let Some((index, candidate)) =
            surveyed.iter_mut().find(|(i, candidate)| contest.needs_refinement(*i, candidate))
        {
            contest.refine(*index, candidate, &mut predictor, white_of);
        }
        for (index, candidate) in &surveyed {
            let record = &mut contest.rows[*index].record;
            record.coefficients = coefficients_of(candidate, &mut coefficients)?;
        }
        let Contest { question, rows, left_out, .. } = contest;
        Self {
            domain: domain.to_string(),
            white_variance: predictor.white_variance(1),
            white_noise_points: question.white_noise_points(&predictor),
            question,
            rows,
            left_out,
            uniform: Some(predictor),
        }
        .ranked()
    }

    /// Returns the candidates for an integral over the unit square.
    pub(super) fn on_square(
        args: &ChooseArgs,
        global: &Global,
        integrand: &'a NamedSquareIntegrand,
    ) -> Result<Self, CliError> {
        let named = args.samplers.list();
        let named: Option<Vec<SquarePattern>> =
            named.map(|list| parse_patterns(&list, &global.session)).transpose()?;
        let function = &*integrand.function;
        let budget = PredictionBudget::DEFAULT;
        let mut predictor = SquarePredictor::new(function, global.seed, budget)
            .map_err(|e| CliError::Usage(format!("{}: {e}", integrand.name)))?;
        let largest = predictor.energy().total().sqrt();
        let estimate = function.integral_estimate();
        let question = Question::new(args, &integrand.name, "integral", estimate, largest)?;
        let is_named = named.is_some();
        let typical = typical_points(args)?;
        let (patterns, shares) = in_order(
            named.unwrap_or_else(square_patterns),
            |p| p.nominal_work(typical),
            |p| square_share(p, typical),
        );
        let progress = Progress::new(shares.iter().sum(), &global.session);
        let mut contest = Contest::new(question, global.seed, is_named, &progress);
        let white = |predictor: &SquarePredictor<'_>, n: usize| predictor.white_variance(n);
        for (pattern, share) in patterns.into_iter().zip(shares) {
            contest.add(pattern, &mut predictor, white);
            progress.advance(share)?;
        }
        let Contest { question, rows, left_out, .. } = contest;
        Self {
            domain: predictor.space().to_string(),
            white_variance: predictor.white_variance(1),
            white_noise_points: question.white_noise_points(&predictor),
            question,
            rows,
            left_out,
            uniform: None,
        }
        .ranked()
    }

    /// Sorts the rows, of which there must be one.
    fn ranked(mut self) -> Result<Self, CliError> {
        if self.rows.is_empty() {
            let reasons: Vec<String> =
                self.left_out.iter().map(|l| format!("{}: {}", l.label, l.reason)).collect();
            return Err(CliError::Failed(reasons.join("; ")));
        }
        rank(&mut self.rows);
        Ok(self)
    }

    /// Returns a remark if most of the variance lies in degrees in which no pattern has less power
    /// than white noise.
    pub(super) fn beyond_help(&mut self, n_points: usize) -> Result<String, CliError> {
        let Some(predictor) = &mut self.uniform else { return Ok(String::new()) };
        let settled = settled_degree_of(n_points, predictor.domain());
        let share = predictor.share_beyond(settled)?;
        let is_uniform = |row: &Row| row.density == Density::Uniform;
        let which = if self.rows.iter().all(is_uniform) { "" } else { " of uniform directions" };
        Ok(if share > 0.5 {
            format!(
                " No pattern{which} can: {} of the variance lies beyond degree {settled}, where every pattern of \
                 {n_points} points has the mean power of white noise.",
                number::percent(share)
            )
        } else {
            String::new()
        })
    }
}

/// Returns the patterns of the sphere and the warped ones.
fn split(samplers: Vec<DirectionSampler>) -> Result<(Vec<Pattern>, Vec<WarpedPattern>), CliError> {
    let (mut uniform, mut warped) = (Vec::new(), Vec::new());
    for sampler in samplers {
        match sampler {
            DirectionSampler::Uniform(pattern) => uniform.push(pattern),
            DirectionSampler::Warped(pattern) => warped.push(pattern),
            DirectionSampler::Adapted(pattern) => {
                let measured = "variance and compare measure it";
                return Err(CliError::Usage(format!("{pattern}: {UNPREDICTED}; {measured}")));
            }
        }
    }
    Ok((uniform, warped))
}

/// Returns the number of points at which patterns are ordered by cost, if memory suffices for it.
fn typical_points(args: &ChooseArgs) -> Result<usize, CliError> {
    if let Some(n) = args.count.count {
        check_memory(&format!("-n {n}"), BYTES_PER_POINT * n as f64)?;
    }
    Ok(args.count.count.unwrap_or(TYPICAL_POINTS))
}

/// Returns different patterns, inexpensive ones first, with their shares in the progress.
///
/// The order depends on nominal work rather than on time, and so is the same on every machine.
fn in_order<P: PartialEq>(
    mut patterns: Vec<P>,
    work: impl Fn(&P) -> f64,
    share: impl Fn(&P) -> f64,
) -> (Vec<P>, Vec<f64>) {
    patterns.sort_by(|a, b| work(a).total_cmp(&work(b)));
    patterns.dedup();
    let shares = patterns.iter().map(share).collect();
    (patterns, shares)
}

/// Returns the errors of the coefficients with the number of points of a candidate, from the
/// spectrum by which the irradiance is predicted.
fn coefficients_of(
    candidate: &TimedCandidate<Pattern>,
    coefficients: &mut [Coefficient<'_>],
) -> Result<Option<Vec<CoefficientRecord>>, CliError> {
    let answer = &candidate.answer;
    let Some(point) = answer.n_points.and_then(|n| answer.curve.at(n)) else {
        return Ok(None);
    };
    if coefficients.is_empty() {
        return Ok(None);
    }
    let mut records = Vec::new();
    for Coefficient { l, m, exact, predictor } in coefficients {
        let energy = predictor.energy_to(point.spectrum.lmax())?;
        let variance = predict(&point.spectrum, energy).variance;
        let variance = if variance <= predictor.rounding() { 0.0 } else { variance };
        records.push(CoefficientRecord {
            l: *l,
            m: *m,
            exact: *exact,
            variance,
            error: variance.sqrt(),
        });
    }
    Ok(Some(records))
}
