use std::collections::HashSet;
use std::ops::Range;

use sphvar_samplers::Progress;

use crate::piece::Piece;
use crate::{Error, Job, Results, Setting, Store};

/// A piece of a job in a setting: the work for a range of its sets.
#[derive(Clone, Debug)]
pub struct JobPiece<'a> {
    job: &'a Job,
    seed: u64,
    sets: Range<u64>,
    key: String,
}

impl<'a> JobPiece<'a> {
    fn new(job: &'a Job, setting: Setting, sets: Range<u64>) -> Self {
        // Pieces of other versions may differ.
        let (version, seed) = (env!("CARGO_PKG_VERSION"), setting.seed);
        let key = format!(
            "{} sets={}..{} seed={seed} sphvar={version}",
            job.key_of_set(),
            sets.start,
            sets.end
        );
        Self { job, seed, sets, key }
    }

    /// Returns a text that distinguishes the piece from all others, those of other seeds and versions
    /// of this crate included.
    #[must_use]
    pub fn key(&self) -> &str {
        &self.key
    }

    /// Returns the nominal work of the piece.
    #[must_use]
    pub fn work(&self) -> f64 {
        self.job.work_of_set() * self.length() as f64
    }

    /// Returns the computed piece as bytes for [`run_pieces`], in this version of this crate.
    ///
    /// # Errors
    ///
    /// The errors of the computation.
    pub fn compute(&self) -> Result<Vec<u8>, Error> {
        let piece = self.job.work(self.seed, self.sets.clone())?;
        postcard::to_stdvec(&piece).map_err(|error| Error::Store { reason: error.to_string() })
    }

    /// Returns the piece that is stored under its key, if it fits its job. Otherwise computes and
    /// stores it.
    ///
    /// # Errors
    ///
    /// [`Error::Store`] if it cannot be stored; the errors of the computation.
    pub fn load_or_compute(&self, store: &dyn Store) -> Result<Vec<u8>, Error> {
        match store.load(&self.key).filter(|bytes| self.decode(bytes).is_some()) {
            Some(bytes) => Ok(bytes),
            None => {
                let bytes = self.compute()?;
                store.save(&self.key, &bytes).map_err(|reason| Error::Store { reason })?;
                Ok(bytes)
            }
        }
    }

    fn decode(&self, bytes: &[u8]) -> Option<Piece> {
        let piece: Piece = postcard::from_bytes(bytes).ok()?;
        piece.fits(self.job, self.length()).then_some(piece)
    }

    fn length(&self) -> u64 {
        self.sets.end - self.sets.start
    }
}

/// Returns the nominal work of the jobs; duplicates count once.
#[must_use]
pub fn work(jobs: &[Job]) -> f64 {
    let mut seen = HashSet::new();
    let distinct = jobs.iter().filter(|job| seen.insert(job.key()));
    // An empty sum would be -0.
    distinct.map(|job| job.work_of_set() * job.sets() as f64).fold(0.0, |a, b| a + b)
}

/// Runs the jobs missing from `results`, in their setting, piece by piece, and stores each piece in
/// `store`. Stored pieces are reused if they fit their job. After each piece its share of [`work`]
/// is ticked.
///
/// # Errors
///
/// [`Error::Store`] if a piece cannot be stored, [`Error::Sampler`] if `progress` stops the work;
/// the errors of the computations.
pub fn run(
    jobs: &[Job],
    store: &dyn Store,
    results: &mut Results,
    progress: &dyn Progress,
) -> Result<(), Error> {
    run_pieces(jobs, results, |piece| {
        let bytes = piece.load_or_compute(store)?;
        progress.tick(piece.work()).map_err(sphvar_samplers::Error::from)?;
        Ok(Some(bytes))
    })
}

/// Completes the jobs missing from `results` with pieces that `bytes_of` returns, those of
/// [`JobPiece::compute`] in this or another process. It is called for all pieces, in the order of
/// jobs and sets; jobs with a piece for which it returns `None` remain missing.
///
/// # Errors
///
/// [`Error::Piece`] if bytes are not of their piece; the errors of `bytes_of`.
pub fn run_pieces<E: From<Error>>(
    jobs: &[Job],
    results: &mut Results,
    mut bytes_of: impl FnMut(&JobPiece<'_>) -> Result<Option<Vec<u8>>, E>,
) -> Result<(), E> {
    let setting = results.setting();
    for job in jobs {
        if results.contains(job) {
            continue;
        }
        let mut pieces = Some(Vec::new());
        for sets in job.pieces() {
            let piece = JobPiece::new(job, setting, sets);
            let Some(bytes) = bytes_of(&piece)? else {
                pieces = None;
                continue;
            };
            if let Some(pieces) = &mut pieces {
                let wrong = || Error::Piece { key: piece.key.clone() };
                pieces.push(piece.decode(&bytes).ok_or_else(wrong)?);
            }
        }
        if let Some(pieces) = pieces {
            results.insert(job, job.finish(pieces)?);
        }
    }
    Ok(())
}
