//! The pieces of the work, computed here or taken from where they are kept.

use std::collections::HashSet;

use sphvar_thesis::{Error, Job, JobPiece, Results, Store, run_pieces};

use crate::error::CliError;
use crate::files::PieceStore;
use crate::progress::Progress;
use crate::shards::Tasks;

/// The source of pieces.
pub(super) enum Pieces {
    /// The folder of the run: pieces that it lacks are computed.
    Stored(PieceStore),
    /// The tasks of a run whose results are kept by `--save`. The folder, if the run has one, receives
    /// its pieces; pieces of earlier runs in it are not used, because they may be of a machine that
    /// rounds differently.
    Kept { tasks: Tasks, store: Option<PieceStore>, known: HashSet<String> },
    /// Merged parts, which have completed the jobs. The folder receives their pieces.
    Merged { tasks: Tasks, store: PieceStore },
}

impl Pieces {
    /// Completes the jobs missing from `results`, except in a run that keeps only a part of the work.
    ///
    /// # Errors
    ///
    /// Those of the computation, and if a piece cannot be kept.
    pub(super) fn run(
        &mut self,
        jobs: &[Job],
        results: &mut Results,
        progress: &Progress,
    ) -> Result<(), CliError> {
        match self {
            Self::Stored(store) => run_pieces(jobs, results, |piece| {
                let bytes = piece.load_or_compute(store)?;
                progress.advance(piece.work())?;
                Ok(Some(bytes))
            }),
            Self::Kept { tasks, store, known } => run_pieces(jobs, results, |piece| {
                // Figures share pieces.
                if !known.insert(piece.key().to_owned()) {
                    return Ok(store.as_ref().and_then(|store| store.load(piece.key())));
                }
                let bytes = tasks.once(piece.key(), || {
                    let bytes = piece.compute()?;
                    progress.advance(piece.work())?;
                    Ok(bytes)
                })?;
                if let (Some(bytes), Some(store)) = (&bytes, &store) {
                    save(store, piece, bytes)?;
                }
                Ok(bytes)
            }),
            Self::Merged { tasks, store } => {
                run_pieces(jobs, &mut Results::new(results.setting()), |piece| {
                    if let Some(bytes) = merged(piece, tasks)? {
                        save(store, piece, &bytes)?;
                    }
                    Ok(None)
                })
            }
        }
    }
}

/// Completes jobs with the pieces of merged parts; jobs of which a partial merge lacks a piece remain
/// missing.
///
/// # Errors
///
/// If a piece is missing from merged files or damaged.
pub(super) fn merge(jobs: &[Job], results: &mut Results, tasks: &Tasks) -> Result<(), CliError> {
    run_pieces(jobs, results, |piece| merged(piece, tasks))
}

fn merged(piece: &JobPiece<'_>, tasks: &Tasks) -> Result<Option<Vec<u8>>, CliError> {
    tasks.once(piece.key(), || Ok(piece.compute()?))
}

/// Writes a piece unless the folder has it.
fn save(store: &PieceStore, piece: &JobPiece<'_>, bytes: &[u8]) -> Result<(), CliError> {
    if store.load(piece.key()).as_deref() == Some(bytes) {
        return Ok(());
    }
    let saved = store.save(piece.key(), bytes);
    Ok(saved.map_err(|reason| Error::Store { reason })?)
}
