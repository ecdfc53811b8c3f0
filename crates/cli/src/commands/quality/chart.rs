//! The chart of measures in units of those of white noise, beside reference patterns.

use sphvar_samplers::{Domain, Pattern, PointSet, Progress as _, Purpose, Realizations, Streams};
use sphvar_spectrum::quality::{MAX_POINTS_OF_COVERING, Measure, SetQuality};
use sphvar_spectrum::{Error, Moments};

use super::Measured;
use super::rank::realizations;
use crate::error::CliError;
use crate::global::Global;
use crate::plots::{Chart, Ink, Panel, Scale, Series, Spread, Style};
use crate::progress::Progress;

/// The measures of the chart with the names at its axis.
const MEASURES: [(Measure, &str); 9] = [
    (Measure::Separation, "1/sep."),
    (Measure::CoveringRadius, "covering"),
    (Measure::MeshRatio, "mesh"),
    (Measure::CapDiscrepancy, "cap disc."),
    (Measure::GeneralizedDiscrepancy, "gen. disc."),
    (Measure::WorstCaseError(0), "s = 1.5"),
    (Measure::WorstCaseError(1), "s = 2"),
    (Measure::WorstCaseError(2), "s = 3"),
    (Measure::WorstCaseError(3), "s = 4"),
];

/// The names at the axis.
const NAMES: [&str; 9] = {
    let mut names = [""; 9];
    let mut k = 0;
    while k < 9 {
        names[k] = MEASURES[k].1;
        k += 1;
    }
    names
};

/// The mean scaled measures of reference patterns; a measure is NaN where it is unknown.
pub(super) struct References {
    white: [f64; 9],
    patterns: Vec<(String, [f64; 9])>,
}

impl References {
    /// Measures white noise, and the reference patterns that are not among the sets, at the number
    /// of points of the first of the sets.
    pub(super) fn new(
        measured: &[Measured],
        domain: Domain,
        global: &Global,
        progress: &Progress,
    ) -> Result<Self, CliError> {
        let n = measured.first().map_or(1, Measured::n_points);
        let white = values(&Pattern::WhiteNoise, n, domain, global, progress)?;
        let patterns = ["jittered", "poisson-disk", "sobol", "healpix", "fibonacci"];
        let patterns = patterns.iter().filter_map(|name| name.parse::<Pattern>().ok());
        let is_new = |p: &Pattern| measured.iter().all(|m| m.source.text != p.to_string());
        let mut found = Vec::new();
        for pattern in patterns.filter(is_new) {
            progress.stage(&format!("reference: {pattern}"));
            found.push((pattern.to_string(), values(&pattern, n, domain, global, progress)?));
        }
        Ok(Self { white, patterns: found })
    }
}

/// Returns the mean scaled measures of a pattern of about `n` points.
fn values(
    pattern: &Pattern,
    n: usize,
    domain: Domain,
    global: &Global,
    progress: &Progress,
) -> Result<[f64; 9], CliError> {
    let is_white = *pattern == Pattern::WhiteNoise;
    let closed = MEASURES.map(|(measure, _)| {
        let closed = measure.white_noise(n, domain).filter(|_| is_white);
        closed.map_or(f64::NAN, |value| value * measure.scale(n, domain))
    });
    let n = pattern.nearest_count(n, domain);
    let sampler = pattern.build(n, domain).map_err(CliError::failed)?;
    if n > MAX_POINTS_OF_COVERING {
        return Ok(closed);
    }
    let streams = Streams::new(global.seed, Purpose::Pattern, pattern.stream_group(n));
    let sets = Realizations::unrotated(&*sampler, streams);
    let count = realizations(&*sampler);
    progress.expect(count as f64 * sampler.nominal_work());
    let mut means: [Moments; 9] = Default::default();
    let mut set = PointSet::default();
    for index in 0..count {
        sets.realize_into(index, &mut set, progress).map_err(Error::from)?;
        let quality = SetQuality::new(&set, domain, &[], progress)?;
        for (mean, (measure, _)) in means.iter_mut().zip(MEASURES) {
            mean.push(measure.scaled(&quality).unwrap_or(f64::NAN));
        }
    }
    let mut values = closed;
    for (value, mean) in values.iter_mut().zip(means) {
        // Closed forms of white noise are better than a few sets of it.
        if value.is_nan() {
            *value = mean.mean();
        }
    }
    Ok(values)
}

/// Returns the chart.
pub(super) fn chart(measured: &[Measured], references: &References) -> Chart {
    let own = measured.iter().enumerate().map(|(rank, m)| {
        let scaled =
            MEASURES.map(|(measure, _)| m.quality.mean_scaled(measure).unwrap_or(f64::NAN));
        series(&m.source.name, scaled, references, Ink::Rank(rank))
    });
    let others = references.patterns.iter().enumerate().map(|(k, (name, scaled))| {
        series(name, *scaled, references, Ink::Rank(measured.len() + k))
    });
    let n = measured.first().map_or(0, Measured::n_points);
    let panel = Panel {
        reference: Some(1.0),
        side_by_side: true,
        ..Panel::log("measure / white noise", own.chain(others).collect())
    };
    Chart {
        title: format!("Quality of point sets, N = {n}"),
        x_label: "distances, discrepancies, worst-case errors in H^s".to_owned(),
        x_scale: Scale::Names(&NAMES),
        panels: vec![panel],
        notes: vec![
            "Smaller is better, 1 is white noise; sep. is the separation, mesh the mesh ratio, gen. disc. the generalized discrepancy. Values are scaled by powers of N, so that patterns with other \
             numbers of points are comparable."
                .to_owned(),
        ],
    }
}

/// Returns the ratios of one pattern to white noise.
fn series(name: &str, scaled: [f64; 9], references: &References, ink: Ink) -> Series {
    let places = (1..).map(f64::from);
    let ratios =
        scaled.iter().zip(references.white).zip(MEASURES).map(|((own, white), measure)| {
            if measure.0.is_larger_better() { white / own } else { own / white }
        });
    Series {
        label: name.to_owned(),
        points: places.zip(ratios).collect(),
        spread: Spread::None,
        style: Style::Markers,
        ink,
    }
}
