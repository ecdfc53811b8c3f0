//! Spellings of earlier versions, or of other subcommands: the error names the replacement.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};

/// A flag that a subcommand does not have, or no longer has.
struct Retired {
    old: &'static str,
    /// The identifiers of the replacements; the first one that a subcommand has is named.
    new: &'static [&'static str],
}

/// All such spellings.
const RETIRED: [Retired; 5] = [
    Retired { old: "--points", new: &["count", "counts"] },
    Retired { old: "--n-points", new: &["count", "counts"] },
    Retired { old: "--max-points", new: &["max_count"] },
    Retired { old: "--reference-n", new: &["reference_count"] },
    Retired { old: "--sampler", new: &["samplers", "sampler"] },
];

/// Adds the replacement to an error about an old spelling; `words` are the arguments.
pub(crate) fn explain(error: &mut clap::Error, command: &Command, words: &[String]) {
    if error.kind() != ErrorKind::UnknownArgument {
        return;
    }
    let Some(ContextValue::String(unknown)) = error.get(ContextKind::InvalidArg) else { return };
    let Some(retired) = RETIRED.iter().find(|retired| retired.old == unknown) else { return };
    let Some(new) = replacement(subcommand(command, words), retired) else { return };
    let tip = tip(retired, new);
    // A suggestion of a similar flag would contradict the replacement.
    error.remove(ContextKind::SuggestedArg);
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
}

/// Returns the subcommand that the words name.
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

    /// Every old spelling is explained in the subcommands that have its replacement, and in no
    /// other.
    #[test]
    fn old_spellings_name_the_new_ones() {
        let root = Cli::command();
        for retired in &RETIRED {
            let mut explained = 0;
            for command in root.get_subcommands() {
                let is_there =
                    command.get_arguments().any(|a| a.get_long() == Some(&retired.old[2..]));
                // Where a subcommand has subcommands, flags belong to these.
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
