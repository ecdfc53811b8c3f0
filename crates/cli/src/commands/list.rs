//! `sphvar list`: samplers, integrands, warps and formats, from their registries.

mod entry;
mod page;

use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_integrands::{SquareTerm, Term};
use sphvar_samplers::{Pattern, RotationPattern, SquarePattern};

use self::entry::{FormatEntry, FunctionEntry, SamplerEntry};
use self::page::Page;
use crate::error::CliError;
use crate::files::formats;
use crate::flags::{CountArgs, DomainArgs, ONE_DOMAIN, SquareArgs};
use crate::global::Global;
use crate::report::{Document, Provenance};
use crate::spec::unknown_name;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar list
  sphvar list samplers poisson-disk step
  sphvar list samplers -n 500        (with the largest degree without power)
  sphvar list samplers --square      (patterns of the unit square)
  sphvar list warps env
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
    #[command(flatten)]
    pub(crate) square: SquareArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    /// Patterns of directions
    Samplers,
    /// Functions of direction
    Integrands,
    /// Patterns of rotations
    Rotations,
    /// Densities of importance sampling
    Warps,
    /// File formats
    Formats,
}

/// Samplers, integrands, warps and file formats: `list --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ListBody {
    /// Patterns of directions.
    #[serde(skip_serializing_if = "Option::is_none")]
    samplers: Option<Vec<SamplerEntry>>,
    /// Functions of direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    integrands: Option<Vec<FunctionEntry>>,
    /// Patterns of the unit square.
    #[serde(skip_serializing_if = "Option::is_none")]
    square_samplers: Option<Vec<SamplerEntry>>,
    /// Functions on the unit square.
    #[serde(skip_serializing_if = "Option::is_none")]
    square_integrands: Option<Vec<FunctionEntry>>,
    /// Patterns of rotations.
    #[serde(skip_serializing_if = "Option::is_none")]
    rotations: Option<Vec<SamplerEntry>>,
    /// Maps from the unit square to directions, by which patterns of the square sample densities.
    #[serde(skip_serializing_if = "Option::is_none")]
    warps: Option<Vec<FunctionEntry>>,
    /// Formats of files.
    #[serde(skip_serializing_if = "Option::is_none")]
    formats: Option<Vec<FormatEntry>>,
}

/// Numbers of points for which last empty degrees are listed by default.
const LISTED_COUNTS: [usize; 3] = [100, 1000, 10_000];

pub(crate) fn run(args: &ListArgs, global: &Global) -> Result<(), CliError> {
    args.square.without(&[("--hemisphere", args.domain.hemisphere, ONE_DOMAIN)])?;
    let domain = args.domain.domain();
    let counts = args.count.count.map_or(LISTED_COUNTS.to_vec(), |n| vec![n]);
    let is_listed = |kind| args.kind.is_none_or(|listed| listed == kind);
    let of_sphere = |kind| is_listed(kind) && !args.square.square;
    let of_square = |kind| is_listed(kind) && (args.square.square || args.kind.is_none());
    let of_both = |kind, sphere, square| {
        if is_listed(kind) { check_space(&args.names, sphere, square, args.square) } else { Ok(()) }
    };
    of_both(
        Kind::Samplers,
        Pattern::known().map(|p| p.name()).collect(),
        SquarePattern::known().map(|p| p.name()).collect(),
    )?;
    of_both(
        Kind::Integrands,
        Term::all().iter().map(Term::name).collect(),
        SquareTerm::all().iter().map(SquareTerm::name).collect(),
    )?;
    let samplers = of_sphere(Kind::Samplers)
        .then(|| Pattern::known().map(|p| SamplerEntry::new(&p, &counts, domain)).collect())
        .map(|all| chosen(all, "sampler", &args.names, |entry| entry.name))
        .transpose()?;
    let integrands = of_sphere(Kind::Integrands)
        .then(FunctionEntry::integrands)
        .map(|all| chosen(all, "integrand", &args.names, |entry| entry.name))
        .transpose()?;
    let square_samplers = of_square(Kind::Samplers)
        .then(|| SquarePattern::known().map(|p| SamplerEntry::of_square(&p)).collect())
        .map(|all| chosen(all, "sampler", &args.names, |entry| entry.name))
        .transpose()?;
    let square_integrands = of_square(Kind::Integrands)
        .then(FunctionEntry::square_integrands)
        .map(|all| chosen(all, "integrand", &args.names, |entry| entry.name))
        .transpose()?;
    let rotations = is_listed(Kind::Rotations)
        .then(|| RotationPattern::ALL.iter().map(SamplerEntry::of_rotations).collect())
        .map(|all| chosen(all, "pattern of rotations", &args.names, |entry| entry.name))
        .transpose()?;
    let warps = is_listed(Kind::Warps)
        .then(FunctionEntry::warps)
        .map(|all| chosen(all, "warp", &args.names, |entry| entry.name))
        .transpose()?;
    let formats = is_listed(Kind::Formats)
        .then(|| formats().into_iter().map(FormatEntry).collect())
        .map(|all| chosen(all, "format", &args.names, |entry: &FormatEntry| entry.0.name))
        .transpose()?;
    if global.json {
        let body = ListBody {
            samplers,
            integrands,
            square_samplers,
            square_integrands,
            rotations,
            warps,
            formats,
        };
        return Document::new(&body, &Provenance::new(&global.session, global.seed))
            .print(&global.session);
    }
    let mut page = Page::default();
    if args.kind.is_none() {
        let mut section = |heading, entries: &mut dyn Iterator<Item = (&str, &str)>| {
            let mut entries = entries.peekable();
            if entries.peek().is_some() {
                page.heading(heading);
                entries.for_each(|(name, summary)| page.line(name, summary));
            }
        };
        let of_samplers = |entry: &'_ SamplerEntry| (entry.name, entry.summary);
        let of_functions = |entry: &'_ FunctionEntry| (entry.name, entry.summary);
        section("Samplers", &mut samplers.iter().flatten().map(of_samplers));
        section("Integrands", &mut integrands.iter().flatten().map(of_functions));
        let (samplers, integrands) = (square_samplers.iter(), square_integrands.iter());
        section(
            "Samplers of the unit square, with --square",
            &mut samplers.flatten().map(of_samplers),
        );
        section(
            "Integrands on the unit square, with --square",
            &mut integrands.flatten().map(of_functions),
        );
        section(
            "Patterns of rotations, for the command rotations",
            &mut rotations.iter().flatten().map(of_samplers),
        );
        section(
            "Warps, densities for samplers of the unit square: sobol:warp=NAME",
            &mut warps.iter().flatten().map(of_functions),
        );
        page.heading("File formats");
        formats.iter().flatten().for_each(|entry| page.line(entry.0.name, &entry.line()));
        page.paragraph(
            "sphvar list samplers|integrands|rotations|warps|formats [NAME...] [--square] shows the details.",
        );
    } else {
        samplers.iter().flatten().for_each(|entry| entry.show(&mut page));
        integrands.iter().flatten().for_each(|entry| entry.show(&mut page));
        square_samplers.iter().flatten().for_each(|entry| entry.show(&mut page));
        square_integrands.iter().flatten().for_each(|entry| entry.show(&mut page));
        rotations.iter().flatten().for_each(|entry| entry.show(&mut page));
        warps.iter().flatten().for_each(|entry| entry.show(&mut page));
        formats.iter().flatten().for_each(|entry| entry.show(&mut page));
    }
    global.session.print(page.text())
}

/// Rejects names of the other space.
fn check_space(
    names: &[String],
    sphere: Vec<&str>,
    square: Vec<&str>,
    listed: SquareArgs,
) -> Result<(), CliError> {
    let (own, other, place) = match listed.square {
        true => (square, sphere, "the sphere: omit --square"),
        false => (sphere, square, "the unit square: use --square"),
    };
    let is_other = |name: &&String| !own.contains(&name.as_str()) && other.contains(&name.as_str());
    match names.iter().find(is_other) {
        Some(name) => Err(CliError::Usage(format!("{name} is of {place}"))),
        None => Ok(()),
    }
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
