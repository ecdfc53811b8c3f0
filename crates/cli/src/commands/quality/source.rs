//! The point sets that are measured: realizations of a sampler, or those of a file.

use std::path::Path;

use sphvar_grammar::{Spec, quote};
use sphvar_samplers::{
    Domain, Ensemble, Pattern, PointSet, Purpose, Realizations, Sampler, SetDistribution, Streams,
};
use sphvar_spectrum::quality::Quality;

use super::QualityArgs;
use crate::error::CliError;
use crate::global::Global;
use crate::patterns::{self, PatternKind, parse_patterns};
use crate::progress::Progress;
use crate::session::Session;

/// A sampler with the number of its realizations.
pub(super) struct Source {
    /// The name in tables.
    pub(super) name: String,
    pub(super) sampler: Box<dyn Sampler>,
    pub(super) streams: Streams,
    pub(super) count: u64,
    /// The sampler as text, with which reference patterns are compared.
    pub(super) text: String,
}

impl Source {
    /// Returns the sources of a list of samplers and of files that exist.
    pub(super) fn all(
        list: &str,
        args: &QualityArgs,
        global: &Global,
    ) -> Result<Vec<Self>, CliError> {
        let (domain, nearest) = (args.domain.domain(), args.nearest.nearest);
        let patterns = patterns_and_files(list, &global.session)?;
        let sources = patterns.into_iter().map(|pattern: Pattern| {
            let n = args.count.count;
            let sampler = patterns::nearest_sampler(&pattern, n, domain, nearest, &global.session)?;
            let count = match given_sets(&*sampler) {
                Some(sets) => sets.len() as u64,
                None if sampler.is_random() => args.realizations,
                None => 1,
            };
            let group = pattern.stream_group(sampler.n_points());
            let streams = Streams::new(global.seed, Purpose::Pattern, group);
            let text = pattern.to_string();
            Ok(Self { name: pattern.label(), text, count, sampler, streams })
        });
        sources.collect()
    }

    /// Measures the realizations; those of a file are its sets in their order.
    pub(super) fn measure(
        &self,
        domain: Domain,
        degrees: Option<&[usize]>,
        progress: &Progress,
    ) -> Result<Quality, CliError> {
        let realizations = Realizations::unrotated(&*self.sampler, self.streams);
        let given = given_sets(&*self.sampler);
        let sets: &dyn Ensemble = match &given {
            Some(sets) => sets,
            None => &realizations,
        };
        Ok(Quality::of(sets, self.count, domain, degrees, progress)?)
    }
}

/// Returns the patterns of a list, in which an existing file needs no `file:`.
pub(super) fn patterns_and_files<P: PatternKind>(
    list: &str,
    session: &Session,
) -> Result<Vec<P>, CliError> {
    let texts: Vec<String> = Spec::parse_list(list)?
        .into_iter()
        .map(|spec| match Path::new(&spec.text).is_file() {
            true => format!("file:{}", quote(&spec.text)),
            false => spec.text,
        })
        .collect();
    // Together, so that files of the same name have different labels.
    parse_patterns(&texts.join(","), session)
}

/// Returns the sets of a file.
fn given_sets(sampler: &dyn Sampler) -> Option<&[PointSet]> {
    match sampler.distribution() {
        SetDistribution::OneOf(sets) => Some(sets),
        _ => None,
    }
}
