//! `sphvar quality --square`: measures of point sets of the unit square.

use sphvar_samplers::{
    Ensemble, Purpose, Square, SquareDistribution, SquarePattern, SquareRealizations,
    SquareSampler, Streams,
};
use sphvar_spectrum::quality::SquareQuality;

use super::QualityArgs;
use super::source::patterns_and_files;
use super::square_record::{SquareMeasureRow, SquareQualityBody, SquareQualityRecord, text};
use crate::error::CliError;
use crate::flags::ONE_DOMAIN;
use crate::global::Global;
use crate::patterns::nearest_sampler;
use crate::progress::Progress;
use crate::report::{Forms, Provenance, check_result, csv_of, emit};

pub(super) fn run(args: &QualityArgs, global: &Global) -> Result<(), CliError> {
    args.square.without(&[
        ("--hemisphere", args.domain.hemisphere, ONE_DOMAIN),
        ("--lmax", args.lmax.is_some(), "fits of harmonics are for directions"),
        ("--rank", args.rank, "ranks are for directions"),
    ])?;
    if let Some(path) = &args.out.out {
        check_result(path, false)?;
    }
    if args.realizations == 0 {
        return Err(CliError::Usage("-m must be at least 1, got 0".to_owned()));
    }
    let patterns: Vec<SquarePattern> =
        patterns_and_files(&args.samplers.required()?, &global.session)?;
    let (n, nearest) = (args.count.count, args.nearest.nearest);
    let samplers = patterns
        .iter()
        .map(|pattern| nearest_sampler(pattern, n, Square, nearest, &global.session))
        .collect::<Result<Vec<_>, _>>()?;
    let work = |sampler: &dyn SquareSampler| match sampler.distribution() {
        SquareDistribution::OneOf(_) => 0.0,
        _ if sampler.is_random() => args.realizations as f64 * sampler.nominal_work(),
        _ => sampler.nominal_work(),
    };
    let progress =
        Progress::new(samplers.iter().map(|sampler| work(&**sampler)).sum(), &global.session);
    let mut records = Vec::new();
    for (pattern, sampler) in patterns.iter().zip(&samplers) {
        progress.stage(&pattern.label());
        let streams = Streams::new(global.seed, Purpose::Pattern, sampler.stream_group());
        let drawn = SquareRealizations::unshifted(&**sampler, streams);
        let given = match sampler.distribution() {
            SquareDistribution::OneOf(sets) => Some(sets),
            _ => None,
        };
        let (sets, count): (&dyn Ensemble<[f64; 2]>, u64) = match &given {
            Some(sets) => (sets, sets.len() as u64),
            None if sampler.is_random() => (&drawn, args.realizations),
            None => (&drawn, 1),
        };
        let qualities = SquareQuality::of(sets, count, &progress)?;
        records.push(SquareQualityRecord::new(pattern.to_string(), pattern.label(), &qualities));
    }
    drop(progress);
    let provenance = Provenance::new(&global.session, global.seed);
    let rows: Vec<SquareMeasureRow> = records.iter().flat_map(SquareMeasureRow::all).collect();
    let body = SquareQualityBody::new(records);
    let forms =
        Forms { csv: &|| csv_of(&provenance, &rows), chart: None, text: &|| text(&body.records()) };
    emit(args.out.out.as_deref(), global, &provenance, &body, &forms)
}
