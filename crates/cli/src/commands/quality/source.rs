//! The point sets that are measured: realizations of a sampler, or those of a file.

use std::path::{Path, PathBuf};

use sphvar_samplers::{Domain, PointSets, Purpose, Sampler, Streams};

use super::QualityArgs;
use crate::commands::PointFileArgs;
use crate::error::CliError;
use crate::global::Global;
use crate::patterns;
use crate::point_sets::FileSets;
use crate::report::say;

/// A sampler with the number of its realizations.
pub(super) struct Source {
    pub(super) name: String,
    pub(super) sampler: Box<dyn Sampler>,
    pub(super) streams: Streams,
    /// The sets of a file, which are measured in their order.
    pub(super) given: Option<PointSets>,
    pub(super) count: u64,
    /// The sampler as text, which reference patterns are compared with; the file's name.
    pub(super) text: String,
}

impl Source {
    /// Returns the sources that a text names: one, or all patterns.
    pub(super) fn all(
        text: &str,
        args: &QualityArgs,
        global: &Global,
    ) -> Result<Vec<Self>, CliError> {
        let domain = args.domain.domain();
        if let Some(path) = file(text) {
            return Ok(vec![Self::of_file(path, domain, global)?]);
        }
        let n = args.count.required()?;
        let patterns = patterns::parse_patterns(text)?;
        let sources = patterns.into_iter().map(|pattern| {
            let sampler = patterns::build(&pattern, n, domain, args.nearest.nearest)?;
            let got = sampler.n_points();
            if got != n {
                say(
                    global.quiet,
                    &format!("{pattern}: {got} points, the nearest to the {n} asked for"),
                );
            }
            let group = pattern.stream_group(got);
            Ok(Self {
                name: pattern.to_string(),
                text: pattern.to_string(),
                count: if sampler.is_random() { args.realizations } else { 1 },
                sampler,
                streams: Streams::new(global.seed, Purpose::Pattern, group),
                given: None,
            })
        });
        sources.collect()
    }

    fn of_file(path: PathBuf, domain: Domain, global: &Global) -> Result<Self, CliError> {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let files = PointFileArgs {
            files: vec![path],
            columns: None,
            hdu: None,
            join: false,
            skip_invalid: false,
            normalize: false,
        };
        let read = FileSets::read(&files, domain, global.quiet)?;
        Ok(Self {
            name,
            text: read.name().to_owned(),
            count: read.count(),
            sampler: Box::new(read.sets().clone()),
            streams: Streams::new(global.seed, Purpose::Pattern, read.sets().stream_group()),
            given: Some(read.sets().clone()),
        })
    }
}

/// Returns the path of a text that names a file: one that exists.
fn file(text: &str) -> Option<PathBuf> {
    let path = Path::new(text);
    path.is_file().then(|| path.to_owned())
}
