//! The samplers of the command line.

mod predicted;
mod sampler_name;

use std::path::Path;

use glam::DVec3;
use sphvar_grammar::{ResolveError, quote};
use sphvar_samplers::{
    Domain, Error, FileResolver, Pattern, PointFile, PointFileParameters, SamplerFamily, Space,
    Square, SquarePattern, SquarePointFileParameters,
};

use crate::error::CliError;
use crate::files::{
    FilePoint, OptionSpelling, ReadOptions, point_files, read_points, read_spectrum,
};
use crate::flags::missing_count;
use crate::memory::check_points;
use crate::report::say;
use crate::spec::Spec;

pub(crate) use self::predicted::{BandsOf, PredictedPattern, SamplerRef, n_effective};
pub(crate) use self::sampler_name::SamplerName;

/// The name of all patterns together, for subcommands that accept several.
const ALL: &str = "all";

/// The patterns of the sphere, or those of the unit square.
pub(crate) trait PatternKind: SamplerFamily<Self::Space> + Sized {
    type Space: Space;

    /// Returns every built-in pattern.
    fn all() -> Vec<Self>;

    /// Reads a text with the files that it names.
    fn parse(text: &str, files: &PatternFiles) -> Result<Self, Error>;

    /// Returns the name in tables.
    fn label(&self) -> String;

    /// Has the label show the whole path of a file.
    fn use_long_label(&mut self);

    /// Returns the number of points of a single file.
    fn own_count(&self) -> Option<usize>;

    /// Returns whether a pattern has the name.
    fn is_name(name: &str) -> bool;

    /// Returns the error for the name of a pattern of the other kind.
    fn other_kind(name: &str) -> Option<String>;
}

impl PatternKind for Pattern {
    type Space = Domain;

    fn all() -> Vec<Self> {
        Self::ALL.to_vec()
    }

    fn parse(text: &str, files: &PatternFiles) -> Result<Self, Error> {
        Self::parse(text, files)
    }

    fn label(&self) -> String {
        self.label()
    }

    fn use_long_label(&mut self) {
        if let Self::PointFile(file) = self {
            file.has_long_label = true;
        }
    }

    fn own_count(&self) -> Option<usize> {
        self.own_count()
    }

    fn is_name(name: &str) -> bool {
        Self::known().any(|pattern| pattern.name() == name)
    }

    fn other_kind(name: &str) -> Option<String> {
        SquarePattern::is_name(name).then(|| {
            format!(
                "{name} is a pattern of the unit square, for the option --square of sample, spectrum, quality, \
                 variance, compare and choose"
            )
        })
    }
}

impl PatternKind for SquarePattern {
    type Space = Square;

    fn all() -> Vec<Self> {
        Self::ALL.to_vec()
    }

    fn parse(text: &str, files: &PatternFiles) -> Result<Self, Error> {
        Self::parse(text, files)
    }

    fn label(&self) -> String {
        self.label()
    }

    fn use_long_label(&mut self) {
        if let Self::PointFile(file) = self {
            file.has_long_label = true;
        }
    }

    fn own_count(&self) -> Option<usize> {
        self.own_count()
    }

    fn is_name(name: &str) -> bool {
        Self::known().any(|pattern| pattern.name() == name)
    }

    fn other_kind(name: &str) -> Option<String> {
        Pattern::is_name(name).then(|| {
            let known: Vec<&str> = Self::ALL.iter().map(Self::name).collect();
            let known = known.join(", ");
            format!("{name} is a pattern of the sphere; with --square the patterns are {known}")
        })
    }
}

/// Returns the patterns of a list such as `jittered,white-noise`, or of `all`. Prints remarks on
/// files unless `quiet`.
pub(crate) fn parse_patterns<P: PatternKind>(text: &str, quiet: bool) -> Result<Vec<P>, CliError> {
    let mut patterns = Vec::new();
    for spec in Spec::parse_list(text)? {
        if spec.text == ALL {
            patterns.extend(P::all());
        } else {
            patterns.push(parse_pattern(&spec.text, quiet)?);
        }
    }
    distinguish(&mut patterns);
    Ok(patterns)
}

/// Returns the pattern of one name. Prints remarks on files unless `quiet`.
pub(crate) fn parse_pattern<P: PatternKind>(text: &str, quiet: bool) -> Result<P, CliError> {
    P::parse(text, &PatternFiles { quiet }).map_err(|error| match error {
        Error::File(source) => CliError::of_resolver(&source),
        Error::Given { .. } => CliError::failed(error),
        other if Path::new(text).is_file() => {
            CliError::Usage(format!("{other}; a file is a sampler as file:{}", quote(text)))
        }
        other => {
            let name = text.split(':').next().unwrap_or_default();
            let of_other_kind = P::other_kind(name).filter(|_| !P::is_name(name));
            of_other_kind.map_or_else(|| CliError::usage(other), CliError::Usage)
        }
    })
}

/// Gives files of the same name labels with their paths.
fn distinguish<P: PatternKind>(patterns: &mut [P]) {
    let named: Vec<(String, String)> =
        patterns.iter().map(|pattern| (pattern.label(), pattern.to_string())).collect();
    for (pattern, (label, text)) in patterns.iter_mut().zip(&named) {
        if named.iter().any(|other| other.0 == *label && other.1 != *text) {
            pattern.use_long_label();
        }
    }
}

/// Reads the files that patterns name: `profile:FILE` as the command reads spectra, `file:FILE` as
/// it reads `--points`.
pub(crate) struct PatternFiles {
    quiet: bool,
}

impl FileResolver for PatternFiles {
    /// Returns the powers of a file of degrees and powers, which starts at degree 0 or 1 without
    /// gaps.
    fn powers(&self, file: &Path) -> Result<Vec<f64>, ResolveError> {
        let rows = read_spectrum(file).map_err(|error| ResolveError::new(CliError::from(error)))?;
        let first = rows.first().map_or(0, |row| row.l);
        // Degree 0 is ignored.
        Ok((0..first).map(|_| 0.0).chain(rows.iter().map(|row| row.value)).collect())
    }

    fn points(&self, source: &PointFileParameters) -> Result<Vec<PointFile>, ResolveError> {
        self.read(source, PointFile::<DVec3>::check).map_err(ResolveError::new)
    }

    fn square_points(
        &self,
        source: &SquarePointFileParameters,
    ) -> Result<Vec<PointFile<[f64; 2]>>, ResolveError> {
        self.read(source, PointFile::<[f64; 2]>::check).map_err(ResolveError::new)
    }
}

impl PatternFiles {
    fn read<S: Space<Point: FilePoint>>(
        &self,
        source: &PointFileParameters<S>,
        check: fn(&PointFile<S::Point>) -> Result<(), Error>,
    ) -> Result<Vec<PointFile<S::Point>>, CliError> {
        let wrong = |key: &str, reason: String| {
            CliError::Usage(format!("file:{}: {key}: {reason}", source.file().display()))
        };
        let columns = source.columns.as_deref().map(str::parse).transpose();
        let hdu = source.hdu.as_deref().map(str::parse).transpose();
        let options = ReadOptions {
            columns: columns.map_err(|reason| wrong("columns", reason))?,
            hdu: hdu.map_err(|reason| wrong("hdu", reason))?.unwrap_or_default(),
            skip_invalid: source.skip_invalid,
            normalize: source.normalize,
            spelling: OptionSpelling::Keys,
            ..ReadOptions::default()
        };
        let (mut read, mut errors) = (Vec::new(), Vec::new());
        for (stated_count, path) in point_files(source.file())? {
            let file = self.read_one(&path, stated_count, &options);
            if stated_count.is_none() {
                return Ok(vec![file?]);
            }
            // The files of a template are used without each other.
            let checked = file.and_then(|file| match check(&file) {
                Ok(()) => Ok(file),
                Err(error) => Err(CliError::failed(error)),
            });
            match checked {
                Ok(file) => read.push(file),
                Err(error) => errors.push(error),
            }
        }
        if read.is_empty() && !errors.is_empty() {
            return Err(errors.swap_remove(0));
        }
        for error in errors {
            say(self.quiet, &format!("warning: {error}; the file is not used"));
        }
        Ok(read)
    }

    fn read_one<P: FilePoint>(
        &self,
        path: &Path,
        stated_count: Option<usize>,
        options: &ReadOptions,
    ) -> Result<PointFile<P>, CliError> {
        let file = read_points(path, options)?;
        let warnings = file.warnings.iter().map(|warning| format!("warning: {warning}"));
        warnings.chain(file.remarks).for_each(|remark| say(self.quiet, &remark));
        let name = path.display().to_string();
        if file.sets.len() > 1 {
            let count = file.sets.len();
            say(
                self.quiet,
                &format!(
                    "{name}: an ensemble of {count} sets; predictions are exact for these, not for \
                     the ensemble that they come from"
                ),
            );
        }
        let is_weighted = file.sets.iter().any(|set| !set.weights.is_empty());
        // Only weights are checked set by set.
        let starts = if is_weighted { &file.starts[..] } else { &[] };
        Ok(PointFile {
            starts: starts.iter().map(|place| format!("{name}{place}")).collect(),
            name,
            stated_count,
            sets: file.sets,
            first_below: file.first_below,
        })
    }
}

/// Returns the sampler of `n` points or, if `nearest`, of the nearest valid count; for a single
/// file, the sampler of its own number of points.
pub(crate) fn build<P: PatternKind<Space = S>, S: Space>(
    pattern: &P,
    n: usize,
    space: S,
    nearest: bool,
) -> Result<Box<S::Sampler>, CliError> {
    Ok(build_counted(pattern, n, space, nearest)?.1)
}

/// Returns the number of points and the sampler of [`build`].
fn build_counted<P: PatternKind<Space = S>, S: Space>(
    pattern: &P,
    n: usize,
    space: S,
    nearest: bool,
) -> Result<(usize, Box<S::Sampler>), CliError> {
    let nearest = nearest || pattern.own_count().is_some();
    let n = if nearest && n > 0 { pattern.nearest_count(n, space) } else { n };
    let sampler = pattern.build(n, space).map_err(|error| match error {
        Error::InvalidCount { .. } => CliError::Usage(format!("{error} (use --nearest)")),
        Error::Given { .. } => CliError::failed(error),
        _ => CliError::usage(error),
    })?;
    check_points(n)?;
    Ok((n, sampler))
}

/// Returns the pattern that a text names, and its sampler as [`nearest_sampler`] does.
pub(crate) fn sampler_of<P: PatternKind<Space = S>, S: Space>(
    text: &str,
    n: Option<usize>,
    space: S,
    nearest: bool,
    quiet: bool,
) -> Result<(P, Box<S::Sampler>), CliError> {
    let pattern = parse_pattern(text, quiet)?;
    let sampler = nearest_sampler(&pattern, n, space, nearest, quiet)?;
    Ok((pattern, sampler))
}

/// Returns the sampler of `n` points or of the nearest valid count if `nearest`. A single file
/// needs no `n`. Prints a remark if the number of points differs from `n`, unless `quiet`.
pub(crate) fn nearest_sampler<P: PatternKind<Space = S>, S: Space>(
    pattern: &P,
    n: Option<usize>,
    space: S,
    nearest: bool,
    quiet: bool,
) -> Result<Box<S::Sampler>, CliError> {
    let n = n.or(pattern.own_count()).ok_or_else(missing_count)?;
    let (got, sampler) = build_counted(pattern, n, space, nearest)?;
    if got != n {
        let label = pattern.label();
        let why = match pattern.own_count() {
            Some(_) => "as in the file".to_owned(),
            None => format!("the valid count nearest to the requested {n}"),
        };
        say(quiet, &format!("{label}: {got} points, {why}"));
    }
    Ok(sampler)
}
