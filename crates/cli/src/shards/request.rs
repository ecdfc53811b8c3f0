//! What a shard file answers.

use serde::{Deserialize, Serialize};

use super::{Part, ShardArgs};
use crate::error::CliError;
use crate::instruction_set::instruction_set;
use crate::message;

/// The question that the results of a shard file answer, and which parts of the answer it has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Request {
    /// The version of this program.
    pub(crate) version: String,
    /// The instruction set of the machine, because others round differently.
    pub(crate) instruction_set: String,
    /// The words of the command without those that do not change results.
    pub(crate) words: Vec<String>,
    /// The parts that the file has, in order, counted from 1.
    pub(crate) parts: Vec<u64>,
    /// The number of all parts.
    pub(crate) of: u64,
}

impl Request {
    /// Returns what a run with these words after the name of the command computes.
    pub(crate) fn new(words: &[String], args: &ShardArgs) -> Self {
        let Part { part, parts } = args.part();
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            instruction_set: instruction_set(),
            words: Self::words_of(words),
            parts: vec![part],
            of: parts,
        }
    }

    /// Returns the words of a command that its results depend on.
    pub(crate) fn words_of(words: &[String]) -> Vec<String> {
        without(&OWN, words)
    }

    /// Returns the command in one line.
    pub(crate) fn command(&self) -> String {
        let words: Vec<String> =
            self.words.iter().map(|word| message::escape(word).into_owned()).collect();
        format!("sphvar {}", words.join(" "))
    }

    /// Returns an error unless the other file answers the same question.
    ///
    /// # Errors
    ///
    /// If it does not; `names` are those of the files.
    pub(crate) fn check_same(&self, other: &Self, names: [&str; 2]) -> Result<(), CliError> {
        let facts = |request: &Self| {
            [
                ("versions of sphvar", request.version.clone()),
                ("instruction sets", request.instruction_set.clone()),
                ("commands", request.command()),
                ("numbers of parts", request.of.to_string()),
            ]
        };
        let pairs = facts(self).into_iter().zip(facts(other));
        match pairs.into_iter().find(|((_, a), (_, b))| a != b) {
            None => Ok(()),
            Some(((what, a), (_, b))) => Err(CliError::File(format!(
                "{} and {} are of different {what}: {a} and {b}",
                names[0], names[1]
            ))),
        }
    }
}

/// The flags of the number of threads, and whether a value follows.
const THREADS: [(&str, bool); 2] = [("--threads", true), ("-j", true)];

/// The flags that do not change results, and whether a value follows.
const OWN: [(&str, bool); 9] = [
    ("--shard", true),
    ("--save", true),
    ("--threads", true),
    ("-j", true),
    ("--log", true),
    ("--wait", false),
    ("--memory", true),
    ("--json", false),
    ("--quiet", false),
];

/// Returns the words of a command without the number of threads.
pub(crate) fn without_threads(words: &[String]) -> Vec<String> {
    without(&THREADS, words)
}

/// Returns the words without some flags and their values.
fn without(flags: &[(&str, bool)], words: &[String]) -> Vec<String> {
    let mut kept = Vec::new();
    let mut words = words.iter();
    while let Some(word) = words.next() {
        let own = flags.iter().find(|(flag, has_value)| {
            let is_joined = *has_value
                && word.strip_prefix(flag).is_some_and(|rest| {
                    rest.starts_with('=') || (!flag.starts_with("--") && !rest.is_empty())
                });
            word == flag || is_joined
        });
        match own {
            Some((flag, true)) if word == flag => {
                words.next();
            }
            Some(_) => {}
            None => kept.push(word.clone()),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::{OWN, without};

    #[test]
    fn words_that_change_no_result_are_left_out() {
        let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        for text in [
            "spectrum jittered -n 4 --shard 1/2 --save a --wait",
            "spectrum --json jittered -j 3 -n 4 --shard=1/2 --save=a --quiet",
            "-j3 spectrum jittered --threads 2 -n 4 --log x",
            "spectrum jittered -n 4 --threads=2 --log=x",
        ] {
            assert_eq!(without(&OWN, &words(text)), words("spectrum jittered -n 4"), "{text}");
        }
        let all = words("variance jittered -n 4 --integrand x --epsilon=1 -s 3 --jitter");
        assert_eq!(without(&OWN, &all), all);
    }
}
