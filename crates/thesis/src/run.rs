use std::collections::HashSet;

use sphvar_samplers::Progress;

use crate::piece::Piece;
use crate::{Error, Job, Results, Setting, Store};

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
    let setting = results.setting();
    for job in jobs {
        if results.contains(job) {
            continue;
        }
        let mut pieces = Vec::new();
        for sets in job.pieces() {
            let (length, key) = (sets.end - sets.start, piece_key(job, setting, &sets));
            let kept = store.load(&key).and_then(|bytes| postcard::from_bytes(&bytes).ok());
            pieces.push(match kept.filter(|piece: &Piece| piece.fits(job, length)) {
                Some(piece) => piece,
                None => {
                    let piece = job.work(setting.seed, sets)?;
                    keep(store, &key, &piece)?;
                    piece
                }
            });
            let work = job.work_of_set() * length as f64;
            progress.tick(work).map_err(sphvar_samplers::Error::from)?;
        }
        results.insert(job, job.finish(pieces)?);
    }
    Ok(())
}

fn keep(store: &dyn Store, key: &str, piece: &Piece) -> Result<(), Error> {
    let bytes =
        postcard::to_stdvec(piece).map_err(|error| Error::Store { reason: error.to_string() })?;
    store.save(key, &bytes).map_err(|reason| Error::Store { reason })
}

/// Returns a piece is made by this version from this seed: pieces of other versions may differ.
fn piece_key(job: &Job, setting: Setting, sets: &std::ops::Range<u64>) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let seed = setting.seed;
    format!("{} sets={}..{} seed={seed} sphvar={version}", job.key_of_set(), sets.start, sets.end)
}
