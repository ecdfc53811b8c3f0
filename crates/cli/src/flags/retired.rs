//! Spellings that earlier versions had, or that subcommands do not share: the error names what is written instead.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};

/// A flag that a subcommand does not have, or no longer has.
struct Retired {
    old: &'static str,
    /// The identifiers of what is written instead; the first one that a subcommand has counts.
    new: &'static [&'static str],
}

/// All of them.
const RETIRED: [Retired; 5] = [
    Retired { old: "--points", new: &["count", "counts"] },
    Retired { old: "--n-points", new: &["count", "counts"] },
    Retired { old: "--max-points", new: &["max_count"] },
    Retired { old: "--reference-n", new: &["reference_count"] },
    Retired { old: "--sampler", new: &["samplers", "sampler"] },
];

/// Adds what is written instead to an error about an old spelling; `words` are the arguments.
pub(crate) fn explain(error: &mut clap::Error, command: &Command, words: &[String]) {
    if error.kind() != ErrorKind::UnknownArgument {
        return;
    }
    let Some(ContextValue::String(unknown)) = error.get(ContextKind::InvalidArg) else { return };
    let Some(retired) = RETIRED.iter().find(|retired| retired.old == unknown) else { return };
    let Some(new) = replacement(subcommand(command, words), retired) else { return };
    let tip = tip(retired, new);
    // What is merely similar would contradict it.
    error.remove(ContextKind::SuggestedArg);
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
}

/// The subcommand that the words name.
fn subcommand<'a>(command: &'a Command, words: &[String]) -> &'a Command {
    words.iter().fold(command, |command, word| command.find_subcommand(word).unwrap_or(command))
}

fn replacement<'a>(command: &'a Command, retired: &Retired) -> Option<&'a Arg> {
    let of = |id: &&str| command.get_arguments().find(|arg| arg.get_id() == *id);
    retired.new.iter().find_map(of)
}

fn tip(retired: &Retired, new: &Arg) -> String {
    let old = retired.old;
    match (new.get_short(), new.get_long()) {
        (Some(short), Some(long)) => format!("use '-{short}' or '--{long}' instead of '{old}'"),
        (None, Some(long)) => format!("use '--{long}' instead of '{old}'"),
        (_, None) => format!("give {new} without '{old}'"),
    }
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::{RETIRED, explain, replacement, tip};
    use crate::args::Cli;

    /// Every old spelling, in every subcommand that has what is written instead, and in no other.
    #[test]
    fn old_spellings_name_the_new_ones() {
        let root = Cli::command();
        for retired in &RETIRED {
            let mut explained = 0;
            for command in root.get_subcommands() {
                let is_there =
                    command.get_arguments().any(|a| a.get_long() == Some(&retired.old[2..]));
                // Where there are subcommands of a subcommand, flags belong to these.
                if is_there || command.has_subcommands() {
                    continue;
                }
                let words: Vec<String> =
                    ["sphvar", command.get_name(), retired.old, "12"].map(str::to_owned).into();
                let mut error = Cli::try_parse_from(&words).unwrap_err();
                explain(&mut error, &root, &words[1..]);
                let text = error.to_string();
                let Some(new) = replacement(command, retired) else {
                    assert!(!text.contains("instead"), "{words:?}: {text}");
                    continue;
                };
                assert!(text.contains(&tip(retired, new)), "{words:?}: {text}");
                assert!(!text.contains("similar"), "{words:?}: {text}");
                explained += 1;
            }
            assert!(explained > 0, "{} is explained nowhere", retired.old);
        }
    }
}
