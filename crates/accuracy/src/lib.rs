//! Measures the errors of sphvar's results against more accurate references.
//!
//! A [`Trial`] is one method on one input. Callers that measure speed time [`Subject::run`];
//! [`Subject::errors`] compares the results of the last run with a 25-digit table, twice the
//! working precision or a closed form. A [`HardCase`] is an extreme input at the limits of
//! floating-point numbers, with the bound of its error.
//!
//! ```
//! use sphvar_accuracy::{Area, Effort, hard_cases, trials};
//!
//! let mut trial = trials(Area::Harmonics, Effort::Quick).swap_remove(0);
//! trial.subject.run();
//! let errors = trial.subject.errors();
//! assert!(errors.count() > 0 && errors.max() <= trial.bound, "{trial:?}: {}", errors.worst());
//!
//! let cases = hard_cases(Area::Indexing);
//! let case = cases.iter().find(|case| case.name.contains("seams")).unwrap();
//! assert!((case.measure)().max() <= case.bound);
//! ```
//!
//! # Bounds
//!
//! The bound is the documented accuracy of a method if there is one; otherwise it is
//! `k EPSILON growth`, with its derivation in the code. References are independent of the tested
//! code and more accurate: a table of 25 digits, twice the working precision ([`mod@reference`]),
//! integers, or a closed form.

mod area;
mod errors;
mod fits;
mod hard_case;
mod harmonics;
mod indexing;
mod predictions;
mod quality;
pub mod reference;
mod spectra;
mod square;
mod transforms;
mod trial;
mod warps;
mod weights;

pub use area::Area;
pub use errors::Errors;
pub use hard_case::{HardCase, hard_cases};
pub use trial::{Effort, Subject, Trial, trials};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
