//! Reads the words of a question.

use std::sync::LazyLock;

use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory, FromArgMatches};

use super::Failure;
use crate::args::{Cli, Command, usage_message};
use crate::global::Global;

/// The identifiers of options that write files, and of the number of threads, which is that of the
/// embedding program.
const REJECTED: [(&str, &str); 10] = [
    ("out", WRITES),
    ("force", WRITES),
    ("save", WRITES),
    ("log", WRITES),
    ("shard", WRITES),
    ("per_order", WRITES),
    ("coefficient", WRITES),
    ("nodes", WRITES),
    ("picture", WRITES),
    ("threads", "the number of threads is that of the program"),
];

const WRITES: &str = "it writes a file, and results are returned here";

/// Commands without an answer.
const WITHOUT_ANSWER: [&str; 6] =
    ["sample", "render", "reproduce", "accuracy", "plan", "completions"];

/// Returns the subcommand of the words after the name of the command, `--json` among them, and the
/// common options.
pub(super) fn parse(words: &[String]) -> Result<(Command, Global), Failure> {
    if let Some(name) = words.first().filter(|word| WITHOUT_ANSWER.contains(&&***word)) {
        return Err(Failure::usage(format!(
            "{name} writes files; use the command `sphvar {name}`"
        )));
    }
    let all = std::iter::once("sphvar".to_owned()).chain(words.iter().cloned());
    let parser = parser_of(words.first().map_or("", |name| name));
    let matches = parser.try_get_matches_from(all).map_err(|error| failure(error, words))?;
    let Some((_, of_command)) = matches.subcommand() else {
        return Err(Failure::usage("expected the name of a subcommand"));
    };
    check(of_command)?;
    let cli = Cli::from_arg_matches(&matches).map_err(|error| failure(error, words))?;
    Ok((cli.command, cli.global))
}

/// Returns the parser of the command with only the subcommand of this name, if there is one: a copy
/// of all subcommands would take most of the time of a short question.
fn parser_of(name: &str) -> clap::Command {
    static WHOLE: LazyLock<clap::Command> = LazyLock::new(Cli::command);
    let Some(subcommand) = WHOLE.find_subcommand(name) else { return WHOLE.clone() };
    clap::Command::new(WHOLE.get_name().to_owned())
        .subcommand_required(true)
        .args(WHOLE.get_arguments().cloned())
        .subcommand(subcommand.clone())
}

/// Rejects options that an embedded run does not have.
fn check(matches: &ArgMatches) -> Result<(), Failure> {
    for id in matches.ids() {
        let rejected = REJECTED.iter().find(|(rejected, _)| *rejected == id.as_str());
        if let Some((_, reason)) = rejected
            && matches.value_source(id.as_str()) == Some(ValueSource::CommandLine)
        {
            let option = id.as_str().replace('_', "-");
            return Err(Failure::usage(format!("--{option} is not available: {reason}")));
        }
    }
    Ok(())
}

/// Returns the failure of words that are no valid command line, without the usage and advice for a
/// terminal.
fn failure(error: clap::Error, words: &[String]) -> Failure {
    Failure::usage(usage_message(error, words))
}

#[cfg(test)]
mod tests {
    use std::any::TypeId;
    use std::path::PathBuf;

    use clap::CommandFactory;

    use super::{Cli, REJECTED, WITHOUT_ANSWER};

    /// The options whose files are read.
    const READ: [&str; 2] = ["points_from", "spectrum"];

    #[test]
    fn every_option_that_writes_a_file_is_rejected() {
        let command = Cli::command();
        let mut options = Vec::new();
        for command in command.get_subcommands() {
            for option in command.get_arguments().filter(|option| !option.is_positional()) {
                let (name, id) = (command.get_name(), option.get_id().as_str());
                options.push(id.to_owned());
                let takes_file = option.get_value_parser().type_id() == TypeId::of::<PathBuf>();
                let is_known = READ.contains(&id) || REJECTED.iter().any(|(other, _)| *other == id);
                let is_decided = is_known || WITHOUT_ANSWER.contains(&name);
                assert!(!takes_file || is_decided, "{name} --{id}");
            }
        }
        let common = command.get_arguments().map(|option| option.get_id().to_string());
        options.extend(common);
        for (id, _) in REJECTED {
            assert!(options.iter().any(|option| option == id), "{id} is no option");
        }
    }
}
