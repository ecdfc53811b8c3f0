//! The command of a plan.

use clap::{Command, CommandFactory};

use crate::args::Cli;
use crate::error::CliError;
use crate::report::quoted;
use crate::shards::without_threads;

/// A command whose work can be divided.
pub(super) struct PlannedWords {
    words: Vec<String>,
    /// The words of a part: those of the command without the number of threads.
    of_part: Vec<String>,
    /// The place of the name of the subcommand, after which the options of a part stand.
    name: usize,
    /// The number of threads, if the command states it; 0 for one per core.
    pub(super) threads: Option<usize>,
    pub(super) is_json: bool,
    pub(super) is_quiet: bool,
}

impl PlannedWords {
    /// Returns the command with these words.
    ///
    /// # Errors
    ///
    /// If they are no command, its work cannot be divided, or it has options of a part.
    pub(super) fn new(words: Vec<String>) -> Result<Self, CliError> {
        let cli = Cli::of_words(&words, false).map_err(|error| of_command(&words, &error))?;
        let Some(sharding) = cli.command.sharding() else {
            return Err(of_command(
                &words,
                &format!("its work cannot be divided; that of these can: {}", divisible()),
            ));
        };
        let own = [
            ("--shard", sharding.shard.is_some()),
            ("--save", sharding.save.is_some()),
            ("--wait", sharding.wait),
            ("--log", cli.global.log.is_some()),
        ];
        if let Some((option, _)) = own.iter().find(|(_, is_given)| *is_given) {
            return Err(of_command(&words, &format!("the plan sets {option} of every part")));
        }
        // The values of common options are numbers, so a word that is the name is the name.
        let names: Vec<String> =
            Cli::command().get_subcommands().map(|command| command.get_name().to_owned()).collect();
        let of_part = without_threads(&words);
        let name = of_part.iter().position(|word| names.contains(word)).unwrap_or(0);
        let has_threads = of_part.len() < words.len();
        Ok(Self {
            name,
            of_part,
            threads: has_threads.then_some(cli.global.threads),
            is_json: cli.global.json,
            is_quiet: cli.global.quiet,
            words,
        })
    }

    /// Returns the words.
    pub(super) fn words(&self) -> &[String] {
        &self.words
    }

    /// Returns the words for a shell, with the options of a part, which are text for the shell, and
    /// the number of threads.
    pub(super) fn with_own(&self, own: &str, threads: usize) -> Vec<String> {
        let (before, after) = self.of_part.split_at(self.name + 1);
        let quoted_words =
            |words: &[String]| words.iter().map(|word| quoted(word)).collect::<Vec<_>>();
        let own = vec![own.to_owned(), format!("--threads {threads}")];
        [quoted_words(before), own, quoted_words(after)].concat()
    }

    /// Returns the command of one of `parts` parts that keeps its results in a file.
    ///
    /// # Errors
    ///
    /// If the options of a part conflict with those of the command.
    pub(super) fn of_part(&self, parts: u64, save: &str) -> Result<(Vec<String>, Cli), CliError> {
        let mut words = self.of_part.clone();
        let own =
            ["--shard".to_owned(), format!("1/{parts}"), "--save".to_owned(), save.to_owned()];
        words.splice(self.name + 1..self.name + 1, own);
        let cli = Cli::of_words(&words, false).map_err(|error| of_command(&self.words, &error))?;
        Ok((words, cli))
    }
}

/// Returns the error about a command.
fn of_command(words: &[String], reason: &impl std::fmt::Display) -> CliError {
    let words: Vec<String> = words.iter().map(|word| quoted(word)).collect();
    CliError::Usage(format!("sphvar {}: {reason}", words.join(" ")))
}

/// Returns the names of the commands whose work can be divided.
fn divisible() -> String {
    let command = Cli::command();
    let has_parts = |command: &&Command| command.get_arguments().any(|arg| arg.get_id() == "shard");
    let names: Vec<&str> =
        command.get_subcommands().filter(has_parts).map(Command::get_name).collect();
    names.join(", ")
}
