//! Runs `progressive` on the sphere, the hemisphere or the square.

use sphvar_samplers::{Domain, Pattern, Share, Square, SquarePattern};
use sphvar_variance::{
    IntegrationSpace, PredictionBudget, Predictor, ProgressiveCurve, ProgressivePredictor,
    ProgressiveSpace, Randomized, SquarePredictor, Trials,
};

use super::ProgressiveArgs;
use super::prefixes::{MAX_EVERY, Prefixes};
use super::reference::{Reference, ReferenceCounts, ReferencePattern};
use super::sequence::{Sequence, SpaceSequence, with_all};
use super::sequence_errors::{Origin, SequenceErrors};
use super::text::Results;
use crate::commands::warped_rows::WarpedIntegrals;
use crate::error::CliError;
use crate::global::Global;
use crate::integrands::{
    Integral, IntegralName, Integrals, check_domain, parse_integrands, parse_square_integrand,
    with_integrals,
};
use crate::patterns::{PredictedPattern, parse_patterns, parse_samplers};
use crate::progress::Progress;
use crate::session::Session;

/// The errors on one integral.
pub(super) struct IntegralErrors {
    pub(super) name: IntegralName,
    pub(super) sequences: Vec<SequenceErrors>,
    pub(super) reference: Reference,
}

/// The predictors of one integral.
struct IntegralPredictors<'a, S: ProgressiveSpace> {
    name: IntegralName,
    exact: Option<f64>,
    /// The predictor of patterns of the space.
    own: ProgressivePredictor<'a, S>,
    /// One for each warped sequence.
    warped: Vec<ProgressivePredictor<'a, Square>>,
}

/// The number and the kind of trials.
#[derive(Clone, Copy)]
struct PrefixTrials {
    count: Option<u64>,
    randomized: Randomized,
}

impl PrefixTrials {
    /// Returns the number of trials of a sequence: the user's or the default.
    fn count<P: PredictedPattern>(self, sequence: &Sequence<P>) -> u64 {
        self.count.unwrap_or_else(|| Trials::default_of::<P::Space>(sequence.sampler()).count)
    }

    /// Returns the maximum nominal work of [`Self::curve`].
    fn work<P: PredictedPattern<Space: ProgressiveSpace>>(
        self,
        predictor: &mut ProgressivePredictor<'_, P::Space>,
        sequence: &Sequence<P>,
    ) -> Result<f64, CliError> {
        let computed = &sequence.prefixes.computed;
        Ok(predictor.work(sequence.sampler(), computed, self.count(sequence))?)
    }

    fn curve<P: PredictedPattern<Space: ProgressiveSpace>>(
        self,
        predictor: &mut ProgressivePredictor<'_, P::Space>,
        sequence: &Sequence<P>,
        progress: &Progress,
    ) -> Result<ProgressiveCurve, CliError> {
        let share = Share::new(progress, self.work(predictor, sequence)?);
        let (sampler, computed) = (sequence.sampler(), &sequence.prefixes.computed);
        let (group, count) = (sequence.group(), self.count(sequence));
        let curve = predictor.curve(sampler, group, computed, count, self.randomized, &share)?;
        share.finish().map_err(CliError::failed)?;
        Ok(curve)
    }
}

/// The sequences of a run with the reference patterns.
struct Study<P: PredictedPattern> {
    space: P::Space,
    sequences: Vec<SpaceSequence<P>>,
    reference: Vec<ReferencePattern<P>>,
    counts: ReferenceCounts,
    trials: PrefixTrials,
    session: Session,
}

/// Computes errors on the sphere or the hemisphere.
pub(super) fn run_sphere(args: &ProgressiveArgs, global: &Global) -> Result<(), CliError> {
    let (domain, session) = (args.domain.domain(), &global.session);
    let functions = parse_integrands(args.integrand.required()?, session)?;
    let samplers = with_all::<Pattern>(&args.samplers.required()?)?;
    let samplers = parse_samplers(&samplers, session)?;
    let sequences = SpaceSequence::of_directions(&samplers, args.counts.list(), domain)?;
    let study = Study::new(args, domain, sequences, session)?;
    with_integrals(&functions, None, |integrals| {
        for integral in integrals.all() {
            check_domain(integral.integrand, domain)?;
            integral.integrand.announce_bias(domain, session);
        }
        let patterns = study.sequences.iter().filter_map(SpaceSequence::warped);
        let warped = WarpedIntegrals::new(integrals, domain, session, patterns)?;
        let announce = |integral: &'_ Integral<'_>, lmax: usize| {
            integral.integrand.announce_energies(domain, lmax, session);
        };
        let on_energies: Vec<_> =
            integrals.all().iter().map(|i| move |lmax: usize| announce(i, lmax)).collect();
        let predictors = study.on_sphere(integrals, &warped, &on_energies, global.seed)?;
        let errors = study.run(predictors)?;
        let subject = format!("integrating {}", integrals.main().name);
        Results::new(errors, subject).emit(args, global)
    })
}

/// Computes errors on the unit square.
pub(super) fn run_square(args: &ProgressiveArgs, global: &Global) -> Result<(), CliError> {
    let session = &global.session;
    let integrand = parse_square_integrand(args.integrand.required()?, session)?;
    let patterns = with_all::<SquarePattern>(&args.samplers.required()?)?;
    let patterns = parse_patterns::<SquarePattern>(&patterns, session)?;
    let sequences = SpaceSequence::of_patterns(&patterns, args.counts.list(), Square)?;
    let study = Study::new(args, Square, sequences, session)?;
    let function = &*integrand.function;
    let wrong = |e| CliError::Usage(format!("{}: {e}", integrand.name));
    let predictor = SquarePredictor::new(function, global.seed, PredictionBudget::DEFAULT);
    let predictors = IntegralPredictors {
        name: IntegralName { name: integrand.name.clone(), label: None, is_main: true },
        exact: Square.integral(function),
        own: ProgressivePredictor::new(predictor.map_err(wrong)?),
        warped: Vec::new(),
    };
    Results::new(study.run(vec![predictors])?, integrand.subject()).emit(args, global)
}

impl<P: PredictedPattern<Space: ProgressiveSpace>> Study<P> {
    fn new(
        args: &ProgressiveArgs,
        space: P::Space,
        sequences: Vec<SpaceSequence<P>>,
        session: &Session,
    ) -> Result<Self, CliError> {
        let prefixes = || sequences.iter().map(SpaceSequence::prefixes);
        if prefixes().any(Prefixes::has_gaps) {
            let text = format!(
                "with more than {MAX_EVERY} points, only the prefixes in the table are computed; list others with -n"
            );
            session.say(&text);
        }
        let counts = ReferenceCounts::of(sequences.iter().map(SpaceSequence::prefixes));
        let reference = ReferencePattern::all(&args.reference, &counts, space, session)?;
        let randomized = if args.no_rotate { Randomized::AsDrawn } else { Randomized::Rotated };
        let trials = PrefixTrials { count: args.realizations, randomized };
        Ok(Self { space, sequences, reference, counts, trials, session: session.clone() })
    }

    /// Runs all integrals, with one progress bar.
    fn run(
        &self,
        mut integrals: Vec<IntegralPredictors<'_, P::Space>>,
    ) -> Result<Vec<IntegralErrors>, CliError> {
        let mut work = 0.0;
        for integral in &mut integrals {
            work += self.work(integral)?;
        }
        let progress = Progress::new(work, &self.session);
        integrals.iter_mut().map(|integral| self.errors(integral, &progress)).collect()
    }

    /// Returns the maximum nominal work for an integral.
    fn work(&self, integral: &mut IntegralPredictors<'_, P::Space>) -> Result<f64, CliError> {
        let mut work = 0.0;
        for pattern in &self.reference {
            work += pattern.work(&mut integral.own)?;
        }
        let mut warped = integral.warped.iter_mut();
        for sequence in &self.sequences {
            work += match (sequence, &mut integral.own) {
                (SpaceSequence::Own(sequence), own) => self.trials.work(own, sequence)?,
                (SpaceSequence::Warped(_, sequence), _) => warped
                    .next()
                    .map_or(Ok(0.0), |predictor| self.trials.work(predictor, sequence))?,
            };
        }
        Ok(work)
    }

    /// Returns the errors on an integral.
    fn errors(
        &self,
        integral: &mut IntegralPredictors<'_, P::Space>,
        progress: &Progress,
    ) -> Result<IntegralErrors, CliError> {
        let mut curves = Vec::new();
        for pattern in &self.reference {
            progress.stage(&format!("reference {}", pattern.name.label));
            let share = Share::new(progress, pattern.work(&mut integral.own)?);
            curves.push(pattern.curve(&mut integral.own, &share)?);
            share.finish().map_err(CliError::failed)?;
        }
        let is_many = self.reference.iter().any(|pattern| pattern.is_together);
        let reference = Reference { curves, counts: self.counts.all(is_many) };
        let mut warped = integral.warped.iter_mut();
        let mut sequences = Vec::new();
        for sequence in &self.sequences {
            let sampler = sequence.name();
            progress.stage(&sampler.label);
            let (curve, trials) = match sequence {
                SpaceSequence::Own(own) => {
                    let curve = self.trials.curve(&mut integral.own, own, progress)?;
                    (curve, self.trials.count(own))
                }
                SpaceSequence::Warped(_, of_square) => {
                    let Some(predictor) = warped.next() else { continue };
                    let curve = self.trials.curve(predictor, of_square, progress)?;
                    (curve, self.trials.count(of_square))
                }
            };
            let origin = Origin {
                sampler,
                prefixes: sequence.prefixes(),
                integral: &integral.name,
                domain: self.space.to_string(),
                exact: integral.exact,
                trials,
            };
            sequences.push(SequenceErrors::new(origin, &curve, &reference));
        }
        Ok(IntegralErrors { name: integral.name.clone(), sequences, reference })
    }
}

impl Study<Pattern> {
    /// Returns the predictors of all integrals on the sphere or the hemisphere.
    fn on_sphere<'a>(
        &self,
        integrals: &'a Integrals<'_>,
        warped: &'a WarpedIntegrals<'_>,
        on_energies: &'a [impl Fn(usize)],
        seed: u64,
    ) -> Result<Vec<IntegralPredictors<'a, Domain>>, CliError> {
        let budget = PredictionBudget::DEFAULT;
        let mut all = Vec::new();
        let named = integrals.all().iter().zip(integrals.in_rows());
        for (at, ((integral, name), on_energies)) in named.zip(on_energies).enumerate() {
            let function = &*integral.integrand.function;
            let predictor = Predictor::new(function, self.space, seed, budget)?;
            let predictor = predictor.on_energies(on_energies);
            let of_sequence = |sequence: &SpaceSequence<Pattern>| {
                let function = warped.only_strategy(sequence.warped()?, at)?;
                Some(SquarePredictor::new(function, seed, budget).map(ProgressivePredictor::new))
            };
            let warped = self.sequences.iter().filter_map(of_sequence);
            all.push(IntegralPredictors {
                name,
                exact: self.space.integral(function),
                own: ProgressivePredictor::new(predictor),
                warped: warped.collect::<Result<_, _>>()?,
            });
        }
        Ok(all)
    }
}
