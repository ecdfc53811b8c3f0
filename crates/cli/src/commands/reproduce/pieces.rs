//! The pieces of the work, computed here or taken from where they are kept.

use std::collections::HashSet;

use sphvar_thesis::{Error, JobPiece, Store};

use crate::error::CliError;
use crate::files::PieceStore;
use crate::progress::Progress;
use crate::shards::Tasks;

/// The source of pieces.
pub(super) enum Pieces {
    /// The folder of the run: pieces that it lacks are computed.
    Stored(PieceStore),
    /// The tasks of a run whose results are kept by `--save` or merged. The folder, if the run has
    /// one, receives its pieces; pieces of earlier runs in it are not used, because they may be of a
    /// machine that rounds differently.
    Tasks { tasks: Tasks, store: Option<PieceStore>, known: HashSet<String> },
}

impl Pieces {
    /// Returns a piece as bytes; `None` if this run keeps only a part of the work, or if a partial
    /// merge does not have it.
    ///
    /// # Errors
    ///
    /// Those of the computation, and if the piece cannot be kept or is missing from merged files.
    pub(super) fn bytes_of(
        &mut self,
        piece: &JobPiece<'_>,
        progress: &Progress,
    ) -> Result<Option<Vec<u8>>, CliError> {
        let (tasks, store, known) = match self {
            Self::Stored(store) => {
                let bytes = piece.load_or_compute(store)?;
                progress.advance(piece.work())?;
                return Ok(Some(bytes));
            }
            Self::Tasks { tasks, store, known } => (tasks, store, known),
        };
        // Figures share pieces.
        if !known.insert(piece.key().to_owned()) && !tasks.is_merge() {
            return Ok(store.as_ref().and_then(|store| store.load(piece.key())));
        }
        let bytes = tasks.once(piece.key(), || {
            let bytes = piece.compute()?;
            progress.advance(piece.work())?;
            Ok(bytes)
        })?;
        if let (Some(bytes), Some(store)) = (&bytes, store)
            && store.load(piece.key()).as_ref() != Some(bytes)
        {
            let saved = store.save(piece.key(), bytes);
            saved.map_err(|reason| Error::Store { reason })?;
        }
        Ok(bytes)
    }
}
