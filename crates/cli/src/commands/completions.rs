//! `sphvar completions`: what shells complete arguments with.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::args::Cli;
use crate::error::CliError;
use crate::report::print;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar completions bash > ~/.local/share/bash-completion/completions/sphvar
  sphvar completions fish > ~/.config/fish/completions/sphvar.fish";

#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// The shell
    pub(crate) shell: Shell,
}

pub(crate) fn run(args: &CompletionsArgs) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "sphvar", &mut script);
    print(&String::from_utf8_lossy(&script))
}
