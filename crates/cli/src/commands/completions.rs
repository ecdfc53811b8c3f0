//! `sphvar completions`: shell completions and manual pages, generated from the flags of the help.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;

use crate::args::Cli;
use crate::error::CliError;
use crate::files::{AtomicFile, FolderLock, as_group};
use crate::global::Global;
use crate::report::Provenance;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar completions bash > ~/.local/share/bash-completion/completions/sphvar
  sphvar completions fish > ~/.config/fish/completions/sphvar.fish
  sphvar completions --man ~/.local/share/man/man1

A manual page describes each subcommand: sphvar.1, sphvar-compare.1 and so on.";

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("output").args(["shell", "man"]).required(true)))]
pub(crate) struct CompletionsArgs {
    /// Shell whose completions are printed
    pub(crate) shell: Option<Shell>,
    /// Write the manual pages to a folder instead, which is created if it is missing
    #[arg(long, value_name = "FOLDER")]
    pub(crate) man: Option<PathBuf>,
}

pub(crate) fn run(args: &CompletionsArgs, global: &Global) -> Result<(), CliError> {
    if global.json {
        return Err(CliError::Usage("completions and manual pages have no JSON form".to_owned()));
    }
    if let Some(folder) = &args.man {
        return write_pages(folder, global);
    }
    let Some(shell) = args.shell else {
        return Err(CliError::Usage("missing the shell, or --man FOLDER".to_owned()));
    };
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "sphvar", &mut script);
    global.session.print(&String::from_utf8_lossy(&script))
}

/// Writes all pages; an interrupt is delayed until all are written.
fn write_pages(folder: &Path, global: &Global) -> Result<(), CliError> {
    let lock = FolderLock::take(folder, &Provenance::new(&global.session, global.seed).command)?;
    let mut pages = Vec::new();
    // `help` would have a page for each of the other pages.
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    collect(&command, &mut pages)?;
    as_group(|| {
        pages.iter().try_for_each(|(name, page)| AtomicFile::write_whole(&folder.join(name), page))
    })?;
    drop(lock);
    global.session.say(&format!("{} manual pages are in {}", pages.len(), folder.display()));
    Ok(())
}

/// Adds the page of a command and those of its subcommands, each with its file name.
fn collect(command: &Command, pages: &mut Vec<(String, Vec<u8>)>) -> Result<(), CliError> {
    let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
    let mut page = Vec::new();
    Man::new(command.clone()).render(&mut page).map_err(CliError::failed)?;
    pages.push((format!("{name}.1"), page));
    command.get_subcommands().try_for_each(|command| collect(command, pages))
}
