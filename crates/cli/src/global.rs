//! The flags that all subcommands share, and the session of the run.

use std::path::PathBuf;

use clap::Args;

use crate::session::Session;

/// The heading in help texts, which keeps them together below the flags of the subcommand.
const HEADING: &str = "Common options";

/// Flags of every subcommand.
#[derive(Debug, Args)]
pub(crate) struct Global {
    /// Print exactly one JSON document to standard output
    #[arg(long, global = true, help_heading = HEADING)]
    pub(crate) json: bool,
    /// Print no progress and no remarks
    #[arg(long, global = true, help_heading = HEADING)]
    pub(crate) quiet: bool,
    /// Seed of all random numbers; the same seed gives the same bytes
    #[arg(
        short, long, global = true, default_value_t = 0, value_name = "SEED", help_heading = HEADING
    )]
    pub(crate) seed: u64,
    /// Number of threads, 0 for one per core; results do not depend on it
    #[arg(
        short = 'j',
        long,
        global = true,
        default_value_t = 0,
        value_name = "THREADS",
        help_heading = HEADING,
        value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(0..=1024)
    )]
    pub(crate) threads: usize,
    /// Append what the run does to a file, one line of JSON each: start, progress, end or error
    #[arg(long, global = true, value_name = "FILE", help_heading = HEADING)]
    pub(crate) log: Option<PathBuf>,
    /// Memory that point readers and transforms may hold, such as 500M or 8G; results do not depend on it [default: all that is free, and half of it for point files that are read in blocks]
    #[arg(
        long,
        global = true,
        value_name = "SIZE",
        help_heading = HEADING,
        value_parser = crate::memory::parse_size
    )]
    pub(crate) memory: Option<u64>,
    /// Where the run reports, and the arrays that it reads besides files.
    #[arg(skip)]
    pub(crate) session: Session,
}
