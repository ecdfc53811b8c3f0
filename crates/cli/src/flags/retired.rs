//! Spellings of earlier versions, or of other subcommands: the error names the replacement.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};

use crate::error::CliError;
use crate::spec::unknown_name;

/// A flag that a subcommand does not have, or no longer has.
struct Retired {
    old: &'static str,
    /// The identifiers of the replacements; the first one that a subcommand has is named.
    new: &'static [&'static str],
}

/// All such spellings.
const RETIRED: [Retired; 6] = [
    Retired { old: "--points", new: &["count", "counts"] },
    Retired { old: "--n-points", new: &["count", "counts"] },
    Retired { old: "--max-points", new: &["max_count"] },
    Retired { old: "--reference-n", new: &["reference_count"] },
    Retired { old: "--sampler", new: &["samplers", "sampler"] },
    Retired { old: "--cut-sphere", new: &["visible_half"] },
];

/// A value of an option that an earlier version had under another name.
struct RetiredValue {
    option: &'static str,
    old: &'static str,
    new: &'static str,
}

/// All such values.
const RETIRED_VALUES: [RetiredValue; 1] =
    [RetiredValue { option: "mode", old: "projective", new: "antipodal" }];

/// Returns the error about a value that an option does not have: it names the replacement of a
/// spelling of earlier versions, or else the `known` values.
pub(crate) fn unknown_value(option: &str, value: &str, known: &[&str]) -> CliError {
    let is_it = |retired: &&RetiredValue| retired.option == option && retired.old == value;
    match RETIRED_VALUES.iter().find(is_it) {
        Some(retired) => {
            CliError::Usage(format!("{option} \"{value}\" is now named \"{}\"", retired.new))
        }
        None => unknown_name(option, value, known),
    }
}

/// Adds the replacement to an error about an old spelling, and the subcommands of the square to those
/// about `--square` and `--shard`; `words` are the arguments.
pub(crate) fn explain(error: &mut clap::Error, command: &Command, words: &[String]) {
    if error.kind() != ErrorKind::UnknownArgument {
        return;
    }
    let Some(ContextValue::String(unknown)) = error.get(ContextKind::InvalidArg) else { return };
    if let Some(tip) = unsupported(unknown, command, words) {
        error.remove(ContextKind::SuggestedArg);
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
        return;
    }
    let Some(retired) = RETIRED.iter().find(|retired| retired.old == unknown) else { return };
    let Some(new) = replacement(subcommand(command, words), retired) else { return };
    let tip = tip(retired, new);
    // A suggestion of a similar flag would contradict the replacement.
    error.remove(ContextKind::SuggestedArg);
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
}

/// Returns what to say about a flag that other subcommands have, if it is `--square` or `--shard`.
fn unsupported(flag: &str, command: &Command, words: &[String]) -> Option<String> {
    let having = || {
        let has = |c: &&Command| c.get_arguments().any(|arg| arg.get_long() == flag.get(2..));
        let names: Vec<&str> =
            command.get_subcommands().filter(has).map(Command::get_name).collect();
        names.join(", ")
    };
    match flag {
        "--square" => Some(format!("the unit square is supported by {}", having())),
        "--shard" if subcommand(command, words).get_name() == "choose" => Some(format!(
            "choose stops by itself, when the results so far decide the ranking, so its work cannot be divided; \
             compare ranks by trials, and {} have {flag}",
            having()
        )),
        "--shard" => Some(format!("work can be divided by {}", having())),
        _ => None,
    }
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

    use super::{RETIRED, RETIRED_VALUES, explain, replacement, tip, unknown_value};
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

    /// Every subcommand has --square or names those that have it.
    #[test]
    fn the_square_is_where_it_is_supported() {
        let root = Cli::command();
        let has_square =
            |c: &&clap::Command| c.get_arguments().any(|arg| arg.get_long() == Some("square"));
        let names: Vec<&str> =
            root.get_subcommands().filter(has_square).map(clap::Command::get_name).collect();
        assert!(names.contains(&"choose") && !names.contains(&"audit"), "{names:?}");
        for command in root.get_subcommands().filter(|c| !has_square(c) && !c.has_subcommands()) {
            let words: Vec<String> =
                ["sphvar", command.get_name(), "--square"].map(str::to_owned).into();
            let mut error = Cli::try_parse_from(&words).unwrap_err();
            explain(&mut error, &root, &words[1..]);
            let text = error.to_string();
            assert!(text.contains(&names.join(", ")) && !text.contains("similar"), "{text}");
        }
    }

    /// Where work cannot be divided, the error names the commands whose work can; that of `choose`
    /// has the reason.
    #[test]
    fn commands_without_shards_name_those_that_have_them() {
        let root = Cli::command();
        let text = |name: &str| {
            let words = ["sphvar", name, "--shard", "1/2"].map(str::to_owned);
            let mut error = Cli::try_parse_from(&words).unwrap_err();
            explain(&mut error, &root, &words[1..]);
            error.to_string()
        };
        for name in ["choose", "bounds"] {
            let text = text(name);
            assert!(text.contains("compare") && text.contains("variance"), "{text}");
            assert!(!text.contains("similar"), "{text}");
        }
        assert!(text("choose").contains("stops by itself"), "{}", text("choose"));
    }

    #[test]
    fn old_values_name_the_new_ones() {
        for retired in &RETIRED_VALUES {
            let text = unknown_value(retired.option, retired.old, &["a"]).to_string();
            assert!(text.contains(&format!("is now named \"{}\"", retired.new)), "{text}");
            let text = unknown_value(retired.option, "b", &["a"]).to_string();
            assert!(text.contains("unknown") && !text.contains(retired.new), "{text}");
        }
    }
}
