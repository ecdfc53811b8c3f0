//! How large the errors of sphvar's numbers are, against references that are better than what is measured.
//!
//! A [`Trial`] is one method on one input: whoever holds a clock times [`Subject::run`], and [`Subject::errors`]
//! compares what the last run gave with a 25-digit table, twice the working precision or a closed form. A [`HardCase`] is an
//! input at the edge of what numbers can hold, with the bound that its error keeps.
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
//! Where a method promises an accuracy, that is its bound; elsewhere it is `k EPSILON growth` with the reason beside it. References are
//! independent of what is measured and better than it: a table of 25 digits, twice the working precision
//! ([`mod@reference`]), integers, or a closed form.

mod area;
mod errors;
mod hard_case;
mod harmonics;
mod indexing;
mod predictions;
pub mod reference;
mod spectra;
mod transforms;
mod trial;

pub use area::Area;
pub use errors::Errors;
pub use hard_case::{HardCase, hard_cases};
pub use trial::{Effort, Subject, Trial, trials};
