//! `sphvar list`: samplers, integrands and formats, from their registries.

mod entry;
mod page;

use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::Pattern;

use self::entry::{FormatEntry, IntegrandEntry, SamplerEntry};
use self::page::Page;
use crate::error::CliError;
use crate::files::formats;
use crate::flags::{CountArgs, DomainArgs};
use crate::global::Global;
use crate::report::{Document, Provenance, print};
use crate::spec::unknown_name;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar list
  sphvar list samplers poisson-disk step
  sphvar list samplers -n 500        (with the largest degree without power)
  sphvar list integrands --json";

#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    /// Kind to list in detail; if omitted, everything with one line each
    pub(crate) kind: Option<Kind>,
    /// Names; all if omitted
    #[arg(value_name = "NAME")]
    pub(crate) names: Vec<String>,
    #[command(flatten)]
    pub(crate) count: CountArgs,
    #[command(flatten)]
    pub(crate) domain: DomainArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    /// Patterns of directions
    Samplers,
    /// Functions of direction
    Integrands,
    /// File formats
    Formats,
}

/// Samplers, integrands and file formats: `list --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ListBody {
    /// Patterns of directions.
    #[serde(skip_serializing_if = "Option::is_none")]
    samplers: Option<Vec<SamplerEntry>>,
    /// Functions of direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    integrands: Option<Vec<IntegrandEntry>>,
    /// Formats of files.
    #[serde(skip_serializing_if = "Option::is_none")]
    formats: Option<Vec<FormatEntry>>,
}

/// Numbers of points for which last empty degrees are listed by default.
const LISTED_COUNTS: [usize; 3] = [100, 1000, 10_000];

pub(crate) fn run(args: &ListArgs, global: &Global) -> Result<(), CliError> {
    let domain = args.domain.domain();
    let counts = args.count.count.map_or(LISTED_COUNTS.to_vec(), |n| vec![n]);
    let is_listed = |kind| args.kind.is_none_or(|listed| listed == kind);
    let samplers = is_listed(Kind::Samplers)
        .then(|| Pattern::known().map(|p| SamplerEntry::new(&p, &counts, domain)).collect())
        .map(|all| chosen(all, "sampler", &args.names, |entry| entry.name))
        .transpose()?;
    let integrands = is_listed(Kind::Integrands)
        .then(IntegrandEntry::all)
        .map(|all| chosen(all, "integrand", &args.names, |entry| entry.name))
        .transpose()?;
    let formats = is_listed(Kind::Formats)
        .then(|| formats().into_iter().map(FormatEntry).collect())
        .map(|all| chosen(all, "format", &args.names, |entry: &FormatEntry| entry.0.name))
        .transpose()?;
    if global.json {
        let body = ListBody { samplers, integrands, formats };
        return Document::new(&body, &Provenance::new(global.seed)).print();
    }
    let mut page = Page::default();
    if args.kind.is_none() {
        page.heading("Samplers");
        samplers.iter().flatten().for_each(|entry| page.line(entry.name, entry.summary));
        page.heading("Integrands");
        integrands.iter().flatten().for_each(|entry| page.line(entry.name, entry.summary));
        page.heading("File formats");
        formats.iter().flatten().for_each(|entry| page.line(entry.0.name, &entry.line()));
        page.paragraph("sphvar list samplers|integrands|formats [NAME...] shows the details.");
    } else {
        samplers.iter().flatten().for_each(|entry| entry.show(&mut page));
        integrands.iter().flatten().for_each(|entry| entry.show(&mut page));
        formats.iter().flatten().for_each(|entry| entry.show(&mut page));
    }
    print(page.text())
}

/// Returns the entries with these names, in this order, or all entries if there are no names.
fn chosen<T>(
    all: Vec<T>,
    what: &str,
    names: &[String],
    name_of: impl Fn(&T) -> &'static str,
) -> Result<Vec<T>, CliError> {
    let known: Vec<&str> = all.iter().map(&name_of).collect();
    if let Some(name) = names.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(unknown_name(what, name, &known));
    }
    let is_chosen = |entry: &T| names.is_empty() || names.iter().any(|name| name == name_of(entry));
    Ok(all.into_iter().filter(is_chosen).collect())
}
