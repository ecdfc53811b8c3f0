//! The flags that all subcommands share.

use clap::Args;

/// Flags of every subcommand.
#[derive(Debug, Args)]
pub(crate) struct Global {
    /// Print exactly one JSON document to standard output
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Show no progress and no remarks
    #[arg(long, global = true)]
    pub(crate) quiet: bool,
    /// Seed of all random numbers; the same seed gives the same bytes
    #[arg(short, long, global = true, default_value_t = 0, value_name = "SEED")]
    pub(crate) seed: u64,
    /// Number of threads, 0 for one per core; results do not depend on it
    #[arg(
        short = 'j',
        long,
        global = true,
        default_value_t = 0,
        value_name = "THREADS",
        value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(0..=1024)
    )]
    pub(crate) threads: usize,
}
