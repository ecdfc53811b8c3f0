//! The spectrum of one large point set in files, in blocks of which a few are in memory at a time.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use serde::{Deserialize, Serialize};
use sphvar_samplers::{Domain, PointSet, Space};
use sphvar_spectrum::{
    BlockSums, BlockTotal, BlockTransform, CoefficientSamples, OrderAccumulator, Resolution,
    SpectrumAccumulator, TransformWorkspace,
};

use super::coefficient::parse_coefficient;
use super::{Computed, EstimatedSums, Origin, SavedEnsemble, Shard, SpectrumArgs, check_part};
use crate::error::CliError;
use crate::files::{
    Block, BlockStream, BlockedFiles, FilePoint, FileSurvey, ReadOptions, RowTally, survey,
};
use crate::global::Global;
use crate::instruction_set::instruction_set;
use crate::memory::{available_memory, check_degree, check_memory, memory_limit, size_in_words};
use crate::point_sets::{FileSets, SetFacts, WeightTotals, below_remark, check_joined_weights};
use crate::progress::Progress;
use crate::report::Provenance;
use crate::session::lock;
use crate::shards::{Divided, Part};

/// The point sets of files as they are used.
pub(super) enum Opened {
    /// One set that is transformed in blocks.
    Catalogue(Catalogue),
    /// Sets that are transformed as they are; `None` if their results are known.
    Sets(Box<SetFacts>, Option<FileSets>),
}

/// What is known of files without reading their points, so that results can be merged without them.
#[derive(Clone, Debug, Serialize, Deserialize)]
enum Facts {
    Catalogue(CatalogueFacts),
    Sets(Box<SetFacts>),
}

/// What is known of a catalogue without its points.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct CatalogueFacts {
    /// The names of the files.
    name: String,
    /// The number of rows of all files.
    rows: u64,
    /// The name of each file for messages, with remarks on its columns.
    files: Vec<(String, Vec<String>)>,
}

/// One set that is transformed in blocks.
pub(super) struct Catalogue {
    facts: CatalogueFacts,
    source: Source,
    options: ReadOptions,
    lmax: usize,
}

/// Where the blocks of a catalogue come from.
enum Source {
    Files(Arc<BlockedFiles>),
    /// A set that had to be read as a whole.
    Held(FileSets),
    /// The results are known.
    Known,
}

/// The sums over blocks, with what is reported on their rows.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct CatalogueSums {
    blocks: BlockSums,
    /// The number of points with z < 0 on the hemisphere.
    below: usize,
    /// The counts over rows by the number of the file.
    tallies: BTreeMap<usize, RowTally>,
}

impl CatalogueSums {
    /// Adds the sums over later blocks.
    fn append(&mut self, later: Self) -> Result<(), CliError> {
        self.blocks.merge(later.blocks)?;
        self.below = self.below.saturating_add(later.below);
        for (file, tally) in later.tallies {
            self.tallies.entry(file).or_default().append(tally);
        }
        Ok(())
    }
}

/// Returns the facts of the sets of files, and the sets unless their results are known.
///
/// # Errors
///
/// Those of `read`, and if the facts are not in the merged files.
pub(super) fn open_sets<S: Space<Point: FilePoint>>(
    global: &Global,
    read: impl FnOnce() -> Result<FileSets<S>, CliError>,
) -> Result<(SetFacts, Option<FileSets<S>>), CliError> {
    let (session, tasks) = (&global.session, global.session.tasks());
    if tasks.is_merge() {
        let Facts::Sets(facts) = known_facts(global)? else {
            return Err(CliError::File(format!("the saved result of {TASK} has another form")));
        };
        facts.remarks.iter().for_each(|remark| session.say(remark));
        return Ok((*facts, None));
    }
    let sets = read()?;
    let facts = sets.facts();
    tasks.once(TASK, || Ok(Facts::Sets(Box::new(facts.clone()))))?;
    Ok((facts, Some(sets)))
}

/// Returns the facts that are in merged files.
fn known_facts(global: &Global) -> Result<Facts, CliError> {
    let missing =
        || CliError::File("part 1 is needed: it has the numbers of points of the files".to_owned());
    global.session.tasks().once(TASK, || Err(missing()))?.ok_or_else(missing)
}

/// Rejects parts of points on standard input.
///
/// # Errors
///
/// If it is among the files and the work is divided.
pub(super) fn check_input(args: &SpectrumArgs) -> Result<(), CliError> {
    let is_stdin = |path: &PathBuf| path.as_os_str() == "-";
    if args.sharding.shard.is_some() && args.sets.files.files.iter().any(is_stdin) {
        return Err(CliError::Usage(
            "--points - cannot be divided by --shard: every part reads the points, and standard input can be read only \
             once; name a file"
                .to_owned(),
        ));
    }
    Ok(())
}

/// The task that keeps what is known of files.
const TASK: &str = "the point files";

/// Opens the files of points: one set of more than a block, where the degree is given, is not read.
///
/// # Errors
///
/// If the files cannot be read or contain no valid sets, or if standard input is divided.
pub(super) fn open(
    args: &SpectrumArgs,
    domain: Domain,
    global: &Global,
) -> Result<Opened, CliError> {
    check_input(args)?;
    let (session, files, tasks) = (&global.session, &args.sets.files, global.session.tasks());
    // Pairs of points are not kept.
    let keeps = !args.pairs.pairs;
    if tasks.is_merge()
        && keeps
        && let Facts::Catalogue(facts) = known_facts(global)?
    {
        let (options, lmax) = (files.options(), args.lmax.lmax.unwrap_or(0));
        return Ok(Opened::Catalogue(Catalogue { facts, source: Source::Known, options, lmax }));
    }
    let lmax = args.lmax.lmax.filter(|_| keeps && !tasks.is_merge());
    if let Some(lmax) = lmax {
        check_degree("--lmax", lmax)?;
        if let Some(catalogue) = surveyed(args, lmax, global)? {
            tasks.once(TASK, || Ok(Facts::Catalogue(catalogue.facts.clone())))?;
            return Ok(Opened::Catalogue(catalogue));
        }
    }
    let read = || {
        FileSets::read(files, domain, session).map_err(|error| match error {
            CliError::Memory(text) if lmax.is_none() && keeps => {
                CliError::Memory(format!("{text}; with --lmax a single set is read in blocks"))
            }
            other => other,
        })
    };
    if lmax.is_none() {
        let (facts, sets) = if keeps {
            open_sets(global, read)?
        } else {
            let sets = read()?;
            (sets.facts(), Some(sets))
        };
        return Ok(Opened::Sets(Box::new(facts), sets));
    }
    let sets = read()?;
    let facts = sets.facts();
    let n = facts.mean_size;
    if let Some(lmax) = lmax.filter(|lmax| facts.count == 1 && n > BlockTransform::size(*lmax)) {
        let SetFacts { name, remarks, .. } = facts;
        let files = vec![(name.clone(), remarks)];
        let facts = CatalogueFacts { name, rows: n as u64, files };
        tasks.once(TASK, || Ok(Facts::Catalogue(facts.clone())))?;
        let (options, source) = (args.sets.files.options(), Source::Held(sets));
        return Ok(Opened::Catalogue(Catalogue { facts, source, options, lmax }));
    }
    let facts = Box::new(facts);
    tasks.once(TASK, || Ok(Facts::Sets(facts.clone())))?;
    Ok(Opened::Sets(facts, Some(sets)))
}

/// Returns the catalogue of files whose rows can be counted and read in blocks, if they are one set of
/// more than a block.
fn surveyed(
    args: &SpectrumArgs,
    lmax: usize,
    global: &Global,
) -> Result<Option<Catalogue>, CliError> {
    let files = &args.sets.files;
    let options = files.options();
    if files.files.len() > 1 && !files.join {
        return Ok(None);
    }
    let mut surveys: Vec<FileSurvey> = Vec::new();
    for path in &files.files {
        let is_given = global.session.given.points(path).is_some();
        let found = if is_given { None } else { survey::<DVec3>(path, &options) };
        // Joined files may have several sets, which follow each other.
        let Some(survey) = found.filter(|survey| {
            survey.is_streamed && survey.rows > 0 && (!survey.has_sets || files.join)
        }) else {
            return Ok(None);
        };
        surveys.push(survey);
    }
    let size = BlockTransform::size(lmax) as u64;
    let rows: Vec<u64> = surveys.iter().map(|survey| survey.rows).collect();
    let total = rows.iter().fold(0_u64, |sum, rows| sum.saturating_add(*rows));
    if total <= size {
        return Ok(None);
    }
    if let Some(first) = surveys.first() {
        for (survey, path) in surveys.iter().zip(&files.files) {
            let path = path.display().to_string();
            check_joined_weights(first.has_weights, survey.has_weights, &path)?;
        }
    }
    let named = surveys.into_iter().map(|survey| (survey.name, survey.remarks)).collect();
    let facts = CatalogueFacts { name: files.name(), rows: total, files: named };
    let blocked = BlockedFiles { files: files.files.clone(), rows, options: options.clone(), size };
    let source = Source::Files(Arc::new(blocked));
    Ok(Some(Catalogue { facts, source, options, lmax }))
}

impl Catalogue {
    /// Returns the spectrum; `None` if this run keeps only a part of the work.
    ///
    /// # Errors
    ///
    /// If the points cannot be read, most are not directions, or the memory does not suffice.
    pub(super) fn compute(
        self,
        args: &SpectrumArgs,
        domain: Domain,
        global: &Global,
        only: Option<Part>,
    ) -> Result<Option<Computed>, CliError> {
        let (lmax, session) = (self.lmax, &global.session);
        if let Some(part) = only {
            check_part(part, 1)?;
        }
        let coefficient =
            args.coefficient.as_deref().map(|c| parse_coefficient(c, lmax, domain)).transpose()?;
        let (method, epsilon) = args.transform.checked()?;
        let size = BlockTransform::size(lmax);
        let resolution = Resolution { lmax, n_points: size, method, epsilon };
        let transform = BlockTransform::new(resolution, domain)?;
        let started = Instant::now();
        let count = self.facts.rows.div_ceil(size as u64);
        let work = method.nominal_work(size, lmax);
        let progress = Progress::new(count as f64 * work, session);
        progress.stage(&self.facts.name);
        let mut reader = Reader {
            catalogue: &self,
            transform: &transform,
            domain,
            of_part: session.tasks().part().range(count),
            size,
            work,
            stream: None,
        };
        let task = Divided { name: &self.facts.name, count, work };
        let sums = session.tasks().divided(task, &progress, CatalogueSums::append, |range| {
            reader.sums(range, &progress)
        })?;
        drop((reader, progress));
        let Some(sums) = sums else { return Ok(None) };
        let total = self.conclude(sums, domain, global)?;
        let n_points = usize::try_from(total.n_points).unwrap_or(usize::MAX);
        let mut spectrum = SpectrumAccumulator::new(domain, n_points, lmax);
        spectrum.push_powers(total.n_effective, total.powers(), total.tail);
        let orders = args.per_order.is_some().then(|| OrderAccumulator::new(lmax)).transpose()?;
        let orders = orders.map(|mut orders| {
            orders.push_alm(&total.alm, total.normalization);
            orders
        });
        let coefficient = coefficient.map(|coefficient| {
            let mut samples = CoefficientSamples::new(coefficient.l, coefficient.m);
            samples.push_alm(0, &total.alm);
            (coefficient, samples)
        });
        let ensemble = SavedEnsemble {
            sampler: self.facts.name.clone(),
            is_random: false,
            domain,
            lmax,
            transform: format!("{method:?} {epsilon:e}"),
            seed: global.seed,
            realizations: 1,
            version: Provenance::new(session, global.seed).version.to_string(),
            instruction_set: instruction_set(),
        };
        let exact = spectrum.finish()?.into_exact();
        let shard = Shard { ensemble, parts: vec![only.unwrap_or(Part::WHOLE)], sums: spectrum };
        let sums = EstimatedSums {
            shard,
            origin: Origin::Given(Box::new(WeightTotals::of_blocks(&total))),
        };
        Ok(Some(Computed {
            name: self.facts.name,
            spectrum: exact,
            remarks: sums.remarks(),
            sums: Some(sums),
            seconds: started.elapsed().as_secs_f64(),
            orders,
            coefficient,
        }))
    }

    /// Reports what was found in the rows and returns the coefficients.
    fn conclude(
        &self,
        sums: CatalogueSums,
        domain: Domain,
        global: &Global,
    ) -> Result<BlockTotal, CliError> {
        let CatalogueSums { blocks, below, mut tallies } = sums;
        let session = &global.session;
        // The counts of rows that were read as a whole have been reported by then.
        if !matches!(self.source, Source::Held(_)) {
            for (file, (name, remarks)) in self.facts.files.iter().enumerate() {
                if let Some(tally) = tallies.remove(&file) {
                    for warning in tally.conclude(name, &self.options)? {
                        session.say(&format!("warning: {warning}"));
                    }
                }
                remarks.iter().for_each(|remark| session.say(remark));
            }
            if let Some(remark) = below_remark(below) {
                session.say(&remark);
            }
        }
        let total = blocks.total(domain)?;
        if total.has_weights && total.normalization == 0.0 {
            let name = &self.facts.name;
            return Err(CliError::File(format!("{name}: all weights of set 0 (0-based) are 0")));
        }
        Ok(total)
    }
}

/// Reads and transforms blocks.
struct Reader<'a> {
    catalogue: &'a Catalogue,
    transform: &'a BlockTransform,
    domain: Domain,
    /// The blocks of this part, if there are as many as parts.
    of_part: Range<u64>,
    size: usize,
    work: f64,
    stream: Option<BlockStream<DVec3>>,
}

impl Reader<'_> {
    /// Returns the sums over some blocks.
    fn sums(&mut self, range: Range<u64>, progress: &Progress) -> Result<CatalogueSums, CliError> {
        let workers = self.workers(range.end - range.start)?;
        let stream = match &self.catalogue.source {
            Source::Files(files) => {
                if self.stream.as_ref().is_none_or(|stream| stream.next != range.start) {
                    // The previous thread ends before another one starts.
                    self.stream = None;
                    let is_of_part = self.of_part.contains(&range.start);
                    let end = if is_of_part { self.of_part.end.max(range.end) } else { range.end };
                    let started = BlockStream::start(files, range.start..end);
                    self.stream = Some(started.map_err(CliError::failed)?);
                }
                self.stream.take()
            }
            Source::Held(_) | Source::Known => None,
        };
        let blocks = Mutex::new(Blocks { next: range.start, end: range.end, stream });
        let empty = BlockSums::new(self.catalogue.lmax);
        let done = Mutex::new((empty, BTreeMap::new()));
        let result = (0..workers).into_par_iter().try_for_each(|_| -> Result<(), CliError> {
            let mut workspace = TransformWorkspace::default();
            loop {
                let next = lock(&blocks).next(&self.catalogue.source, self.size)?;
                let Some(Block { number, set, tallies }) = next else { return Ok(()) };
                let below = match self.domain {
                    Domain::Sphere => 0,
                    Domain::Hemisphere => set.points.iter().filter(|p| p.z < 0.0).count(),
                };
                // All rows of a block may be invalid.
                let sums = if set.is_empty() {
                    None
                } else {
                    Some(self.transform.sums(number, set, &mut workspace)?)
                };
                progress.advance(self.work)?;
                let mut done = lock(&done);
                sums.map_or(Ok(()), |sums| done.0.merge(sums))?;
                done.1.insert(number, (below, tallies));
            }
        });
        self.stream = blocks.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).stream;
        if result.is_err() {
            self.stream = None;
        }
        result?;
        let (blocks, by_block) =
            done.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        let mut sums = CatalogueSums { blocks, below: 0, tallies: BTreeMap::new() };
        // The order of the rows, whichever thread was first.
        for (below, tallies) in by_block.into_values() {
            let blocks = BlockSums::new(self.catalogue.lmax);
            sums.append(CatalogueSums { blocks, below, tallies })?;
        }
        Ok(sums)
    }

    /// Returns the number of blocks that are transformed at a time.
    ///
    /// # Errors
    ///
    /// If the memory does not suffice for one.
    fn workers(&self, count: u64) -> Result<usize, CliError> {
        let lmax = self.catalogue.lmax;
        let block = self.transform.bytes();
        // Nodes of the tree, those of a sum with its parts, and the block that is being read.
        let levels = 2.0 * (count as f64 + 2.0).log2().ceil();
        let held = match &self.catalogue.source {
            Source::Files(_) => size_of::<[f64; 4]>() as f64 * self.size as f64,
            Source::Held(_) | Source::Known => 0.0,
        };
        let fixed = levels * BlockSums::bytes(lmax) + held;
        let min_bytes = fixed + block;
        let allowed = match memory_limit() {
            Some(limit) if min_bytes > limit => {
                return Err(CliError::Memory(format!(
                    "--memory must be at least {} for a spectrum to degree {lmax} (--lmax) of blocks of {} points, got {}",
                    size_in_words(min_bytes),
                    self.size,
                    size_in_words(limit)
                )));
            }
            Some(limit) => limit,
            None => {
                check_memory(&format!("a spectrum to degree {lmax} (--lmax)"), min_bytes)?;
                available_memory().map_or(min_bytes, |free| 0.5 * free)
            }
        };
        let threads = rayon::current_num_threads().max(1);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let fitting = ((allowed - fixed) / block) as usize;
        let blocks = usize::try_from(count).unwrap_or(usize::MAX);
        Ok(fitting.clamp(1, threads).min(blocks.max(1)))
    }
}

/// Blocks that are still to be transformed.
struct Blocks {
    next: u64,
    end: u64,
    stream: Option<BlockStream<DVec3>>,
}

impl Blocks {
    /// Returns the next block; `None` after the last one.
    fn next(&mut self, source: &Source, size: usize) -> Result<Option<Block<DVec3>>, CliError> {
        if self.next >= self.end {
            return Ok(None);
        }
        let number = self.next;
        self.next += 1;
        match (source, &mut self.stream) {
            (_, Some(stream)) => Ok(Some(stream.take()?)),
            (Source::Held(sets), None) => {
                let all = &sets.sets().sets()[0];
                let start = usize::try_from(number).unwrap_or(usize::MAX).saturating_mul(size);
                let range = start.min(all.len())..start.saturating_add(size).min(all.len());
                let weights = all.weights.get(range.clone()).unwrap_or_default().to_vec();
                let set = PointSet { points: all.points[range].to_vec(), weights };
                Ok(Some(Block { number, set, tallies: BTreeMap::new() }))
            }
            (Source::Files(_) | Source::Known, None) => Ok(None),
        }
    }
}
