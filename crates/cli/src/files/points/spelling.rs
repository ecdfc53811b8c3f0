//! How messages write the options for reading points: as flags, or as keys of `file:`.

use sphvar_grammar::quote;

/// The notation in which the user gives [`ReadOptions`](super::ReadOptions).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum OptionSpelling {
    /// Flags of the command, `--columns ra,dec`.
    #[default]
    Flags,
    /// Keys of the sampler `file`, `columns="ra,dec"`.
    Keys,
}

impl OptionSpelling {
    /// Returns the name of an option.
    pub(crate) fn name(self, option: &str) -> String {
        match self {
            Self::Flags => format!("--{option}"),
            Self::Keys => option.to_owned(),
        }
    }

    /// Returns an option that is on.
    pub(super) fn on(self, option: &str) -> String {
        match self {
            Self::Flags => format!("--{option}"),
            Self::Keys => format!("{option}=yes"),
        }
    }

    /// Returns the option `columns` with a value; flags as a shell takes them.
    pub(super) fn columns(self, value: &str) -> String {
        match self {
            Self::Flags => format!("--columns {}", shell_word(value)),
            Self::Keys => format!("columns={}", quote(value)),
        }
    }
}

/// Returns a text as a word of a shell, in quotes if it needs them.
fn shell_word(text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_=,.-+:/".contains(c);
    if text.chars().all(is_plain) { text.to_owned() } else { format!("'{text}'") }
}
