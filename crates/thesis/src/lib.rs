//! The figures of Singh's thesis (*Sampling and Variance Analysis for Monte Carlo Integration in
//! Spherical Domain*, 2015) and the numbers it states, recomputed.
//!
//! ```text
//! FigureId --jobs--> [Job] --run, piece by piece, kept in a Store--> Results --compose--> Figure { panels, claims }
//! ```
//!
//! A [`Job`] is an ensemble with the statistics computed from it. Figures share jobs, a job
//! consists of pieces of some seconds, and a [`Store`] keeps finished pieces, so an interrupted run
//! resumes where it stopped; [`run_pieces`] takes pieces that other processes have computed. Sums
//! are exact, so results are bit-identical for any division into pieces. A figure contains numbers;
//! callers draw them.
//!
//! ```
//! use sphvar_thesis::{FigureId, NoStore, Results, Scale, Setting, run};
//! let id: FigureId = "C.1".parse()?;
//! let setting = Setting { scale: Scale::Quick, seed: 0 };
//! let mut results = Results::new(setting);
//! run(&id.jobs(setting), &NoStore, &mut results, &())?;
//! let figure = id.compose(&results)?;
//! assert!(!figure.panels.is_empty() && !figure.claims.is_empty());
//! # Ok::<(), sphvar_thesis::Error>(())
//! ```

mod claim;
mod content;
mod ensemble;
mod erratum;
mod error;
mod figure;
mod figure_id;
mod figures;
mod job;
mod pictures;
mod piece;
mod plane_ensemble;
mod plane_spectrum;
mod quantity;
mod results;
mod run;
mod setting;
mod store;
mod test_integrand;
mod verdict;
mod visible_half;

pub use claim::{ChoiceOption, Claim, OpenChoice, Stated};
pub use content::{
    Axis, Content, Curve, Curves, Directions, Field, Mark, Palette, Picture, SquarePoints,
};
pub use ensemble::{Points, ThesisEnsemble};
pub use erratum::Erratum;
pub use error::Error;
pub use figure::{Figure, Panel};
pub use figure_id::FigureId;
pub use job::Job;
pub use pictures::{Lighting, Pictures};
pub use plane_ensemble::PlaneEnsemble;
pub use plane_spectrum::PlaneSpectrum;
pub use quantity::Quantity;
pub use results::Results;
pub use run::{JobPiece, run, run_pieces, work};
pub use setting::{Scale, Setting};
pub use store::{NoStore, Store};
pub use test_integrand::TestIntegrand;
pub use verdict::Verdict;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
