//! The command language: a flag has the same meaning everywhere, help agrees with the code, and
//! every documented command line is accepted.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use clap::{Command, CommandFactory, Parser};
use sphvar_integrands::Cap;
use sphvar_samplers::{Domain, Pattern};
use sphvar_spectrum::Resolution;
use sphvar_variance::prediction_degree;

use super::{LATTICE_FACTOR, natural_degree_in_words};
use crate::args::Cli;

/// Returns every subcommand, including those of `eval`, with the words that select it.
fn subcommands() -> Vec<(String, Command)> {
    fn collect(command: &Command, words: &str, all: &mut Vec<(String, Command)>) {
        for sub in command.get_subcommands().filter(|sub| sub.get_name() != "help") {
            let words = format!("{words} {}", sub.get_name());
            all.push((words.trim().to_owned(), sub.clone()));
            collect(sub, &words, all);
        }
    }
    let mut root = Cli::command();
    root.build();
    let mut all = Vec::new();
    collect(&root, "", &mut all);
    all
}

/// Returns the first words of the help of every flag, with the subcommands in which they appear.
fn meanings() -> BTreeMap<String, BTreeMap<String, Vec<String>>> {
    let mut meanings = BTreeMap::<_, BTreeMap<_, Vec<String>>>::new();
    for (name, command) in subcommands() {
        for arg in command.get_arguments() {
            let (Some(long), Some(help)) = (arg.get_long(), arg.get_help()) else { continue };
            let help = help.to_string();
            let begin = help.split([';', ':', '[', ',', '.', '(']).next().unwrap_or_default();
            let names = meanings.entry(long.to_owned()).or_default();
            names.entry(begin.trim().to_owned()).or_default().push(name.clone());
        }
    }
    meanings
}

#[test]
fn a_flag_has_one_meaning() {
    for (flag, meanings) in meanings() {
        let allowed: &[&str] = match flag.as_str() {
            "count" => &[
                "Number of points N",
                "Numbers of points N",
                "Numbers of points N on the visible hemisphere of each shading point",
            ],
            "realizations" => &[
                "Number of realizations",
                "Number of realizations from which the spectrum is estimated",
                "Trials per measured variance",
                "Renders from which errors are estimated",
            ],
            "out" => &[
                "Write the results to a file",
                "Write the points to a file",
                "Write the rotations to a file",
                "Write the picture to a file",
                "Folder for tables and plots",
                "Folder for the results",
                "Folder of the plan",
                "Where the command writes its results",
            ],
            "sampler" => &["Sampler", "Sampler of the directions at each shading point"],
            "samplers" => &["Samplers", "Samplers of a study"],
            // The conversions of `healpix` and the angle of a cap.
            "degrees" => &[
                "Angle from the axis to the rim",
                "Interpret angles as longitude and latitude in degrees",
            ],
            // A requested error, and a file of errors.
            "error" => &["Requested standard error", "Write the squared error of each pixel"],
            "save" => {
                &["Keep the work in a file", "Save the results of all given parts in one file"]
            }
            "quick" => &["Use fewer points and realizations", "Use smaller inputs"],
            _ => &[],
        };
        assert!(!meanings.contains_key(""), "--{flag} has no help: {meanings:?}");
        if allowed.is_empty() {
            assert_eq!(meanings.len(), 1, "--{flag}: {meanings:?}");
        }
        for meaning in meanings.keys() {
            let is_known = allowed.is_empty() || allowed.contains(&meaning.as_str());
            assert!(is_known, "--{flag}: {meaning}");
        }
    }
}

#[test]
fn shared_flags_have_their_letters_everywhere() {
    for (name, command) in subcommands() {
        for arg in command.get_arguments() {
            let letter = match arg.get_long() {
                Some("count") => Some('n'),
                Some("realizations") => Some('m'),
                Some("out") => Some('o'),
                Some("seed") => Some('s'),
                Some("threads") => Some('j'),
                Some("help") => Some('h'),
                Some("version") => Some('V'),
                _ => None,
            };
            assert_eq!(arg.get_short(), letter, "{name}: {arg}");
        }
    }
}

#[test]
fn every_subcommand_has_one_sentence_and_every_argument_help() {
    for (name, command) in subcommands() {
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        let is_sentence = about.starts_with(char::is_uppercase) && !about.ends_with('.');
        assert!(is_sentence && !about.contains('\n') && about.len() < 100, "{name}: {about:?}");
        for arg in command.get_arguments() {
            let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
            assert!(help.starts_with(char::is_uppercase), "{name}: {arg}: {help:?}");
            assert!(!help.ends_with('.') && !help.contains('\n'), "{name}: {arg}: {help:?}");
        }
    }
}

/// Defaults are written concisely, without long rows of zeros.
#[test]
fn defaults_are_short_and_true() {
    for (name, command) in subcommands() {
        for arg in command.get_arguments() {
            for value in arg.get_default_values() {
                let value = value.to_string_lossy();
                assert!(!value.contains("0.000"), "{name}: {arg}: {value}");
            }
            if arg.get_id() == "epsilon" {
                let stated = arg.get_default_values()[0].to_string_lossy().parse::<f64>();
                assert_eq!(stated, Ok(Resolution::EPSILON), "{name}");
            }
        }
    }
    assert_eq!(natural_degree_in_words(), "4 sqrt(N), at least 32");
    for (n, degree) in [(1, 32), (10_000, 400)] {
        assert_eq!(Resolution::natural_degree(n), degree);
        let fibonacci = Pattern::FIBONACCI.build(n, Domain::Sphere).unwrap();
        let cap = Cap::from_degrees(60.0).unwrap();
        assert_eq!(prediction_degree(&*fibonacci, &cap), LATTICE_FACTOR * degree);
    }
}

/// Returns the words of a command line; double quotes keep spaces together.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut is_quoted = false;
    for c in line.chars() {
        match c {
            '"' => is_quoted = !is_quoted,
            ' ' if !is_quoted => words.push(String::new()),
            c => words.last_mut().unwrap().push(c),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

fn assert_accepted(place: &str, line: &str) {
    let accepted = Cli::try_parse_from(words(line));
    let shown = accepted.as_ref().err().map(|error| (error.use_stderr(), error.to_string()));
    assert!(shown.as_ref().is_none_or(|(is_error, _)| !is_error), "{place}: {line}\n{shown:?}");
}

#[test]
fn examples_of_help_are_accepted() {
    for (name, command) in subcommands().into_iter().filter(|(name, _)| !name.contains(' ')) {
        let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        let examples = help.lines().filter_map(|line| {
            let start = line.find("sphvar ").filter(|_| line.starts_with("  "))?;
            // Redirections and remarks may follow an example.
            let line = line[start..].split("   ").next()?.split(" > ").next();
            line.filter(|line| line.starts_with("sphvar "))
        });
        let examples: Vec<&str> = examples.collect();
        assert!(
            examples.iter().any(|e| e.starts_with(&format!("sphvar {name}"))),
            "{name}: {help}"
        );
        examples.iter().for_each(|example| assert_accepted(&name, example));
    }
}

/// Returns the documents of the repository that contain command lines.
fn documents() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let docs = fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let mut all: Vec<PathBuf> = docs.filter(|p| p.extension().is_some_and(|e| e == "md")).collect();
    all.extend(["README.md", "justfile", "data/README.md"].map(|name| root.join(name)));
    all
}

#[test]
fn command_lines_of_documents_are_accepted() {
    let mut count = 0;
    for path in documents() {
        let text = fs::read_to_string(&path).unwrap();
        for line in text.lines().map(str::trim) {
            let run = line.find("cargo run --release -- ").filter(|_| line.starts_with("cargo"));
            let line = match run {
                Some(start) => {
                    format!("sphvar {}", &line[start + "cargo run --release -- ".len()..])
                }
                None => line.to_owned(),
            };
            // Prose may begin with the name of the command too.
            let is_code = line.starts_with("sphvar ") && !line.contains('`');
            // Without comments and redirections.
            let line = line.split(" # ").next().unwrap().split(" > ").next().unwrap();
            let line = line.replace("{{ARGS}}", "");
            let first = line.split(' ').nth(1).unwrap_or_default();
            if is_code && subcommands().iter().any(|(name, _)| name == first) {
                assert_accepted(&path.display().to_string(), line.trim());
                count += 1;
            }
        }
        for old in ["--n-points", "--max-points", "--reference-n ", "--points N", "--points 1"] {
            assert!(!text.contains(old), "{}: {old}", path.display());
        }
    }
    assert!(count > 30, "{count} command lines were found");
}
