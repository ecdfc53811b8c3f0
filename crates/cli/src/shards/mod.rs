//! Work that is divided among processes, kept on the disk, and added.
//!
//! ```text
//! part:   words -> command -> Tasks --results of this part--> FILE.unfinished -> FILE
//! merge:  FILEs -> words -> command -> Tasks --results of all parts--> report
//! ```
//!
//! A command states its expensive work as named tasks (`Tasks::once`, `Tasks::divided`), which do not
//! depend on each other's results. A part computes its share of every task, and a merge runs the same
//! command with the results of all parts, so it writes every form that the command writes.

mod args;
mod file;
mod fingerprint;
mod part;
mod request;
mod tasks;
mod unfinished;

#[cfg(test)]
pub(crate) use args::PartBody;
pub(crate) use args::ShardArgs;
pub(crate) use file::ShardFile;
pub(crate) use part::Part;
pub(crate) use request::{Request, without_threads};
pub(crate) use tasks::{Divided, Tasks};
pub(crate) use unfinished::UnfinishedWork;
