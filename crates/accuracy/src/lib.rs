//! How large the errors of sphvar's numbers are, against references that are better than what is measured.
//!
//! A [`Trial`] is one method on one input: whoever holds a clock times [`Subject::run`], and [`Subject::errors`]
//! compares what the last run gave with a 25-digit table, twice the working precision or a closed form. A [`HardCase`] is an
//! input at the edge of what numbers can hold, with the bound that its error keeps.

mod area;
mod errors;
mod hard_case;
mod harmonics;
mod indexing;
mod predictions;
mod spectra;
mod transforms;
mod trial;

pub use area::Area;
pub use errors::Errors;
pub use hard_case::{HardCase, hard_cases};
pub use trial::{Effort, Subject, Trial, trials};
