//! Weights and fits of points, with their arrays.

use sphvar_sh::Alm;

use super::{Failure, Session, other_command};
use crate::args::Command;
use crate::commands::{fit, weights};
use crate::report::{Document, Provenance};

impl Session {
    /// Returns the document of `sphvar weights --json` without the weights, and the weights.
    /// `words` are those of [`answer`](Self::answer).
    ///
    /// # Errors
    ///
    /// As for [`answer`](Self::answer).
    pub fn weights(&self, words: &[String]) -> Result<(String, Vec<f64>), Failure> {
        self.run_with(words, |command, global| {
            let Command::Weights(args) = command else { return Err(other_command("weights")) };
            let (body, weighted) = weights::compute(&args, global)?;
            let provenance = Provenance::new(&global.session, global.seed);
            Ok((Document::new(&body, &provenance).json()?, weighted.weights))
        })
    }

    /// Returns the document of `sphvar fit --json`, and the coefficients of the fit. `words` are
    /// those of [`answer`](Self::answer).
    ///
    /// # Errors
    ///
    /// As for [`answer`](Self::answer).
    pub fn fit(&self, words: &[String]) -> Result<(String, Alm), Failure> {
        self.run_with(words, |command, global| {
            let Command::Fit(args) = command else { return Err(other_command("fit")) };
            let (body, alm) = fit::compute(&args, global)?;
            let provenance = Provenance::new(&global.session, global.seed);
            Ok((Document::new(&body, &provenance).json()?, alm))
        })
    }
}
