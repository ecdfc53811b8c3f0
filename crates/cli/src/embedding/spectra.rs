//! Spectra with their sums, which another program merges and stores.

use serde::{Deserialize, Serialize};
use sphvar_spectrum::SpectrumAccumulator;

use super::{Failure, Session, other_command};
use crate::args::Command;
use crate::commands::spectrum::{
    self, EstimatedSums, SpectrumArgs, SpectrumBody, SquareResult, SquareSpectrumBody, SquareSums,
};
use crate::error::CliError;
use crate::global::Global;
use crate::report::{Document, Provenance};
use crate::shards::Part;

/// A spectrum: the document of `sphvar spectrum --json`, and the exact sums of its realizations.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SpectrumAnswer {
    document: String,
    /// The data that make the result reproducible.
    provenance: Provenance,
    /// The time that the spectrum took.
    seconds: f64,
    sums: Sums,
}

/// The sums of a spectrum.
#[derive(Clone, Debug, Serialize, Deserialize)]
enum Sums {
    /// There are no realizations.
    ClosedForm,
    Sphere(Box<EstimatedSums<SpectrumAccumulator>>),
    Square(Box<EstimatedSums<SquareSums>>),
}

/// The first bytes of a stored spectrum; the version changes with the form of what follows.
const FORM: &[u8] = b"sphvar spectrum 1\n";

impl Session {
    /// Returns the spectrum that `sphvar spectrum` computes for the words of
    /// [`answer`](Self::answer). With `[i, k]` as `part` it is the mean of part i of k equal parts of
    /// the realizations, counted from 1.
    ///
    /// # Errors
    ///
    /// As for [`answer`](Self::answer), and if there is no such part.
    pub fn spectrum(
        &self,
        words: &[String],
        part: Option<[u64; 2]>,
    ) -> Result<SpectrumAnswer, Failure> {
        self.run_with(words, |command, global| {
            let Command::Spectrum(args) = command else {
                return Err(other_command("spectrum"));
            };
            let mut only = None;
            if let Some([i, k]) = part {
                let parsed = format!("{i}/{k}").parse();
                only = Some(parsed.map_err(|error| CliError::Usage(format!("--shard: {error}")))?);
                check_parts(&args)?;
            }
            SpectrumAnswer::compute(&args, global, only)
        })
    }
}

impl SpectrumAnswer {
    /// Returns the spectrum that the arguments of the command describe.
    fn compute(args: &SpectrumArgs, global: &Global, only: Option<Part>) -> Result<Self, CliError> {
        let kept = || CliError::Usage("--save does not apply to a spectrum in memory".to_owned());
        let provenance = Provenance::new(&global.session, global.seed);
        if args.square.square {
            let computed = spectrum::compute_square(args, global, only)?.ok_or_else(kept)?;
            let spectrum::SquareComputed { name, result, remarks, sums, seconds } = computed;
            let body = SquareSpectrumBody::new(&name, &result, &remarks, seconds);
            let document = Document::new(&body, &provenance).json()?;
            let sums = sums.map_or(Sums::ClosedForm, |sums| Sums::Square(Box::new(sums)));
            return Ok(Self { document, provenance, seconds, sums });
        }
        let computed = spectrum::compute(args, global, only)?.ok_or_else(kept)?;
        let spectrum::Computed { name, spectrum, remarks, sums, seconds, .. } = computed;
        let body = SpectrumBody::new(&name, &spectrum, remarks, seconds);
        let document = Document::new(&body, &provenance).json()?;
        let sums = sums.map_or(Sums::ClosedForm, |sums| Sums::Sphere(Box::new(sums)));
        Ok(Self { document, provenance, seconds, sums })
    }

    /// Returns the document of `sphvar spectrum --json`.
    #[must_use]
    pub fn document(&self) -> &str {
        &self.document
    }

    /// Returns the spectrum of the realizations of both, bit-identical to that of one run, in any
    /// order. Pair correlations are not merged.
    ///
    /// # Errors
    ///
    /// If they are of different samplers, numbers of points or realizations, degrees, accuracies,
    /// seeds, versions or instruction sets; if a realization is in both; if one is a closed form.
    pub fn merged(&self, other: &Self) -> Result<Self, Failure> {
        Ok(self.merge(other)?)
    }

    fn merge(&self, other: &Self) -> Result<Self, CliError> {
        let names = ["the spectrum", "the other"];
        let sums = match (&self.sums, &other.sums) {
            (Sums::Sphere(a), Sums::Sphere(b)) => {
                Sums::Sphere(Box::new((**a).clone().merged((**b).clone(), names)?))
            }
            (Sums::Square(a), Sums::Square(b)) => {
                Sums::Square(Box::new((**a).clone().merged((**b).clone(), names)?))
            }
            (Sums::ClosedForm, _) | (_, Sums::ClosedForm) => {
                return Err(CliError::Usage(
                    "a spectrum in closed form has no realizations to merge".to_owned(),
                ));
            }
            _ => {
                return Err(CliError::Usage(
                    "cannot merge spectra of the unit square and of the sphere".to_owned(),
                ));
            }
        };
        let (seconds, provenance) = (self.seconds + other.seconds, self.provenance.clone());
        let document = sums.document(seconds, &provenance)?;
        Ok(Self { document, provenance, seconds, sums })
    }

    /// Returns the spectrum in bytes, for [`of_bytes`](Self::of_bytes).
    ///
    /// # Errors
    ///
    /// If the memory does not suffice.
    pub fn bytes(&self) -> Result<Vec<u8>, Failure> {
        let body = postcard::to_stdvec(self).map_err(CliError::failed)?;
        Ok([FORM, &body].concat())
    }

    /// Returns the spectrum of [`bytes`](Self::bytes).
    ///
    /// # Errors
    ///
    /// If the bytes are of another version of sphvar, or incomplete.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, Failure> {
        let wrong = |got: &str| {
            Failure::usage(format!(
                "expected a stored spectrum of this version of sphvar, got {got}"
            ))
        };
        let body = bytes.strip_prefix(FORM).ok_or_else(|| wrong("another form"))?;
        let read: Self = postcard::from_bytes(body).map_err(|_| wrong("other content"))?;
        if read.sums.are_whole() {
            Ok(read)
        } else {
            Err(wrong("sums that do not fit its realizations"))
        }
    }
}

impl Sums {
    /// Returns the document of the spectrum of these sums.
    fn document(&self, seconds: f64, provenance: &Provenance) -> Result<String, CliError> {
        match self {
            Self::ClosedForm => Err(CliError::usage(sphvar_spectrum::Error::NoRealizations)),
            Self::Sphere(sums) => {
                let (ensemble, remarks) = (&sums.shard.ensemble, sums.remarks());
                let spectrum = sums.shard.sums.finish()?;
                let spectrum = if ensemble.is_random { spectrum } else { spectrum.into_exact() };
                let body = SpectrumBody::new(&ensemble.sampler, &spectrum, remarks, seconds);
                Document::new(&body, provenance).json()
            }
            Self::Square(sums) => {
                let (ensemble, remarks) = (&sums.shard.ensemble, sums.remarks());
                let result = SquareResult::of_sums(&sums.shard.sums, !ensemble.is_random)?;
                let body = SquareSpectrumBody::new(&ensemble.sampler, &result, &remarks, seconds);
                Document::new(&body, provenance).json()
            }
        }
    }

    fn are_whole(&self) -> bool {
        match self {
            Self::ClosedForm => true,
            Self::Sphere(sums) => sums.shard.is_whole(),
            Self::Square(sums) => sums.shard.is_whole(),
        }
    }
}

/// Rejects a part of what has none.
fn check_parts(args: &SpectrumArgs) -> Result<(), CliError> {
    let without_parts = [
        ("a spectrum in closed form", args.exact),
        ("the pair correlation", args.pairs.pairs),
        ("a spectrum of given points", !args.sets.files.files.is_empty()),
    ];
    match without_parts.iter().find(|(_, is_given)| *is_given) {
        Some((what, _)) => Err(CliError::Usage(format!("--shard: {what} has no parts"))),
        None => Ok(()),
    }
}
