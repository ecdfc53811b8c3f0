//! Runs `progressive` on the sphere, the hemisphere or the square.

use serde::{Deserialize, Serialize};
use sphvar_samplers::{Domain, Pattern, Progress as _, Share, Square, SquarePattern};
use sphvar_variance::{
    Experiment, IntegrationSpace, Precision, PredictionBudget, Predictor, ProgressiveCurve,
    ProgressivePoint, ProgressivePredictor, ProgressiveSpace, Randomized, SquarePredictor, Trials,
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
use crate::memory::check_memory;
use crate::patterns::{PredictedPattern, parse_patterns, parse_samplers};
use crate::progress::Progress;
use crate::session::Session;
use crate::shards::Divided;

/// The errors on one integral.
pub(super) struct IntegralErrors {
    pub(super) name: IntegralName,
    pub(super) sequences: Vec<SequenceErrors>,
    pub(super) reference: Reference,
}

/// What the results of all sequences on one integral need.
#[derive(Serialize, Deserialize)]
struct Common {
    /// What is known of the trials of every prefix of every sequence.
    experiments: Vec<Vec<Experiment>>,
    /// The predictions of every reference pattern.
    references: Vec<Vec<ProgressivePoint>>,
}

/// The predictors of one integral.
struct IntegralPredictors<'a, S: ProgressiveSpace> {
    name: IntegralName,
    /// The exact integral, which a part does not report.
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

    /// Returns the nominal work of the trials of a sequence.
    fn work<P: PredictedPattern<Space: ProgressiveSpace>>(self, sequence: &Sequence<P>) -> f64 {
        let count = self.count(sequence);
        let together = ProgressivePredictor::<P::Space>::prefixes_together(count);
        let blocks = sequence.prefixes.computed.len().div_ceil(together);
        blocks as f64 * Trials::new(count).work_of::<P::Space>(sequence.sampler())
    }

    /// Returns the number of estimates by the trials of a sequence.
    fn estimates<P: PredictedPattern>(self, sequence: &Sequence<P>) -> f64 {
        self.count(sequence) as f64 * sequence.prefixes.computed.len() as f64
    }
}

/// The sequences of a run with the reference patterns.
struct Study<P: PredictedPattern> {
    space: P::Space,
    sequences: Vec<SpaceSequence<P>>,
    reference: Vec<ReferencePattern<P>>,
    counts: ReferenceCounts,
    trials: PrefixTrials,
    /// Whether all estimates are kept, in a file of a part.
    is_saved: bool,
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
            if !session.tasks().is_part() {
                integral.integrand.announce_bias(domain, session);
            }
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
        if session.tasks().is_part() {
            return Ok(());
        }
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
    let is_part = session.tasks().is_part();
    let predictors = IntegralPredictors {
        name: IntegralName { name: integrand.name.clone(), label: None, is_main: true },
        exact: if is_part { None } else { Square.integral(function) },
        own: ProgressivePredictor::new(predictor.map_err(wrong)?),
        warped: Vec::new(),
    };
    let errors = study.run(vec![predictors])?;
    if is_part {
        return Ok(());
    }
    Results::new(errors, integrand.subject()).emit(args, global)
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
        let (is_saved, session) = (args.sharding.save.is_some(), session.clone());
        Ok(Self { space, sequences, reference, counts, trials, is_saved, session })
    }

    /// Runs all integrals, with one progress bar.
    fn run(
        &self,
        mut integrals: Vec<IntegralPredictors<'_, P::Space>>,
    ) -> Result<Vec<IntegralErrors>, CliError> {
        let tasks = self.session.tasks();
        if self.is_saved || tasks.is_merge() {
            let estimates: f64 = self.sequences.iter().map(|s| self.estimates(s)).sum();
            let bytes = 8.0 * integrals.len() as f64 * estimates / tasks.part().parts as f64;
            check_memory("keeping the estimates of all trials (-m) from all prefixes (-n)", bytes)?;
        }
        let mut work = 0.0;
        for integral in &mut integrals {
            work += self.sequences.iter().map(|sequence| self.trial_work(sequence)).sum::<f64>();
            // A part announces the predictions that it makes; the work of others needs energies.
            if !tasks.is_part() && !tasks.is_merge() {
                work += self.prediction_work(integral)?;
            }
        }
        let progress = Progress::new(work, &self.session);
        let errors = integrals.iter_mut().map(|integral| self.errors(integral, &progress));
        let errors: Vec<IntegralErrors> = errors.collect::<Result<_, _>>()?;
        if !tasks.is_part() && errors.iter().all(|errors| errors.sequences.is_empty()) {
            let text = "the given parts have no sequence with its prediction, its trials and the references";
            return Err(CliError::File(text.to_owned()));
        }
        Ok(errors)
    }

    /// Returns the nominal work of the trials of a sequence.
    fn trial_work(&self, sequence: &SpaceSequence<P>) -> f64 {
        match sequence {
            SpaceSequence::Own(sequence) => self.trials.work(sequence),
            SpaceSequence::Warped(_, sequence) => self.trials.work(sequence),
        }
    }

    /// Returns the number of estimates by the trials of a sequence.
    fn estimates(&self, sequence: &SpaceSequence<P>) -> f64 {
        match sequence {
            SpaceSequence::Own(sequence) => self.trials.estimates(sequence),
            SpaceSequence::Warped(_, sequence) => self.trials.estimates(sequence),
        }
    }

    /// Returns the maximum nominal work of the predictions for an integral.
    fn prediction_work(
        &self,
        integral: &mut IntegralPredictors<'_, P::Space>,
    ) -> Result<f64, CliError> {
        let mut work = 0.0;
        for pattern in &self.reference {
            work += pattern.work(&mut integral.own)?;
        }
        let mut warped = integral.warped.iter_mut();
        for sequence in &self.sequences {
            work += match sequence {
                SpaceSequence::Own(sequence) => self.work(&mut integral.own, sequence)?,
                SpaceSequence::Warped(_, sequence) => {
                    warped.next().map_or(Ok(0.0), |predictor| self.work(predictor, sequence))?
                }
            };
        }
        Ok(work)
    }

    /// Returns the maximum nominal work of the predictions of a sequence.
    fn work<Q: PredictedPattern<Space: ProgressiveSpace>>(
        &self,
        predictor: &mut ProgressivePredictor<'_, Q::Space>,
        sequence: &Sequence<Q>,
    ) -> Result<f64, CliError> {
        Ok(predictor.work(sequence.sampler(), &sequence.prefixes.computed, 0)?)
    }

    /// Returns the errors on an integral: of all sequences, or in a partial merge of those whose
    /// results are known. A run that keeps only a part has none.
    fn errors(
        &self,
        integral: &mut IntegralPredictors<'_, P::Space>,
        progress: &Progress,
    ) -> Result<IntegralErrors, CliError> {
        let common = self.common(integral, progress)?;
        let counts = || {
            let is_many = self.reference.iter().any(|pattern| pattern.is_together);
            self.counts.all(is_many)
        };
        let reference = common.as_ref().map_or_else(Reference::default, |common| {
            let both = self.reference.iter().zip(&common.references);
            let curves = both.map(|(pattern, points)| pattern.curve(points)).collect();
            Reference { curves, counts: counts() }
        });
        let mut warped = integral.warped.iter_mut();
        let mut sequences = Vec::new();
        for (at, sequence) in self.sequences.iter().enumerate() {
            let sampler = sequence.name();
            progress.stage(&sampler.label);
            let of = format!("{} of {}", sampler.text, integral.name.name);
            let known = common.as_ref().map(|common| &*common.experiments[at]);
            let curve = match sequence {
                SpaceSequence::Own(own) => {
                    self.curve(&mut integral.own, own, known, &of, progress)?
                }
                SpaceSequence::Warped(_, of_square) => {
                    let Some(predictor) = warped.next() else { continue };
                    self.curve(predictor, of_square, known, &of, progress)?
                }
            };
            let Some(curve) = curve else { continue };
            let origin = Origin {
                sampler,
                prefixes: sequence.prefixes(),
                integral: &integral.name,
                domain: self.space.to_string(),
                exact: integral.exact,
            };
            sequences.push(SequenceErrors::new(origin, &curve, &reference));
        }
        Ok(IntegralErrors { name: integral.name.clone(), sequences, reference })
    }

    /// Returns what the results of all sequences on an integral need, which one process computes.
    /// `None` if this run keeps only a part, or if it is missing from a partial merge.
    fn common(
        &self,
        integral: &mut IntegralPredictors<'_, P::Space>,
        progress: &Progress,
    ) -> Result<Option<Common>, CliError> {
        let tasks = self.session.tasks();
        let name = format!("energies and references of {}", integral.name.name);
        let found = tasks.once(&name, || {
            if tasks.is_part() {
                // Roundings are those of the energies that one run has computed before.
                self.prediction_work(integral)?;
            }
            let experiments = self.experiments(integral)?;
            let mut references = Vec::new();
            for pattern in &self.reference {
                progress.stage(&format!("reference {}", pattern.name.label));
                let work = pattern.work(&mut integral.own)?;
                if tasks.is_part() {
                    progress.expect(work);
                }
                let share = Share::new(progress, work);
                references.push(pattern.points(&mut integral.own, &share)?);
                share.finish().map_err(CliError::failed)?;
            }
            Ok(Common { experiments, references })
        })?;
        let Some(found) = found else { return Ok(None) };
        let computed = self.sequences.iter().map(|s| s.prefixes().computed.len());
        let is_complete = found.references.len() == self.reference.len()
            && found.experiments.iter().map(Vec::len).eq(computed);
        if is_complete { Ok(Some(found)) } else { Err(of_another_form(&name)) }
    }

    /// Returns what is known of the trials of every prefix of every sequence.
    fn experiments(
        &self,
        integral: &IntegralPredictors<'_, P::Space>,
    ) -> Result<Vec<Vec<Experiment>>, CliError> {
        let mut warped = integral.warped.iter();
        let mut all = Vec::new();
        for sequence in &self.sequences {
            all.push(match sequence {
                SpaceSequence::Own(own) => {
                    let computed = &own.prefixes.computed;
                    integral.own.experiments(own.sampler(), own.group(), computed)?
                }
                SpaceSequence::Warped(_, of_square) => {
                    let Some(predictor) = warped.next() else { continue };
                    let computed = &of_square.prefixes.computed;
                    predictor.experiments(of_square.sampler(), of_square.group(), computed)?
                }
            });
        }
        Ok(all)
    }

    /// Returns the predicted and measured variances of the prefixes of a sequence, given what is known
    /// of their trials; `of` names the sequence and the integral. `None` without that, without the
    /// prediction or with too few trials, if this run keeps only a part or a merge is partial.
    fn curve<Q: PredictedPattern<Space: ProgressiveSpace>>(
        &self,
        predictor: &mut ProgressivePredictor<'_, Q::Space>,
        sequence: &Sequence<Q>,
        known: Option<&[Experiment]>,
        of: &str,
        progress: &Progress,
    ) -> Result<Option<ProgressiveCurve>, CliError> {
        let predicted = self.predicted(predictor, sequence, of, progress)?;
        let (sampler, group, count) =
            (sequence.sampler(), sequence.group(), self.trials.count(sequence));
        let (randomized, work) =
            (self.trials.randomized, Trials::new(1).work_of::<Q::Space>(sampler));
        let together = ProgressivePredictor::<Q::Space>::prefixes_together(count);
        let mut points = Vec::new();
        for (k, computed) in sequence.prefixes.computed.chunks(together).enumerate() {
            let name = format!("trials of {of} from N = {}", computed[0]);
            let append = |estimates: &mut Vec<f64>, others: Vec<f64>| {
                estimates.extend(others);
                Ok(())
            };
            let task = Divided { name: &name, count, work };
            let estimates = self.session.tasks().divided(task, progress, append, |range| {
                let share = Share::new(progress, work * (range.end - range.start) as f64);
                let estimates =
                    predictor.estimates(sampler, group, computed, range, randomized, &share)?;
                share.finish().map_err(CliError::failed)?;
                Ok(estimates)
            })?;
            let min = Precision::MIN_TRIALS * computed.len() as u64;
            let estimates = estimates.filter(|estimates| estimates.len() as u64 >= min);
            let (Some(curve), Some(known), Some(estimates)) = (&predicted, known, estimates) else {
                continue;
            };
            let block = k * together..k * together + computed.len();
            let predicted = ProgressiveCurve {
                points: curve.points[block.clone()].to_vec(),
                realizations: curve.realizations,
            };
            let measured = predicted.measured(&known[block], &estimates, randomized, progress)?;
            points.extend(measured.points);
        }
        let predicted = predicted.filter(|curve| points.len() == curve.points.len());
        Ok(predicted.map(|curve| ProgressiveCurve { points, ..curve }))
    }

    /// Returns the predicted variances of the prefixes of a sequence, which one process computes.
    /// `None` if this run keeps only a part, or if they are missing from a partial merge.
    fn predicted<Q: PredictedPattern<Space: ProgressiveSpace>>(
        &self,
        predictor: &mut ProgressivePredictor<'_, Q::Space>,
        sequence: &Sequence<Q>,
        of: &str,
        progress: &Progress,
    ) -> Result<Option<ProgressiveCurve>, CliError> {
        let (sampler, group, randomized) =
            (sequence.sampler(), sequence.group(), self.trials.randomized);
        let computed = &sequence.prefixes.computed;
        let is_predicted = ProgressivePredictor::<Q::Space>::is_predicted(sampler, randomized);
        let tasks = self.session.tasks();
        let name = format!("prediction of {of}");
        let found = tasks.once(&name, || {
            // The bar of a whole run has the work of all predictions, whether they are made or not.
            let is_counted = is_predicted || !tasks.is_part();
            let work = if is_counted { self.work(predictor, sequence)? } else { 0.0 };
            if tasks.is_part() {
                progress.expect(work);
            }
            let share = Share::new(progress, work);
            let curve = predictor.predict_known(sampler, group, computed, randomized, &share)?;
            share.finish().map_err(CliError::failed)?;
            Ok(curve)
        })?;
        let is_other = |curve: &ProgressiveCurve| {
            !curve.points.iter().map(|point| &point.n_points).eq(computed)
        };
        if found.as_ref().is_some_and(is_other) { Err(of_another_form(&name)) } else { Ok(found) }
    }
}

/// Returns the error of a saved result with other numbers of points, such as that of a damaged file.
fn of_another_form(name: &str) -> CliError {
    CliError::File(format!("the saved result of {name} has another form"))
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
        let (budget, is_part) = (PredictionBudget::DEFAULT, self.session.tasks().is_part());
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
                exact: if is_part { None } else { self.space.integral(function) },
                own: ProgressivePredictor::new(predictor),
                warped: warped.collect::<Result<_, _>>()?,
            });
        }
        Ok(all)
    }
}
