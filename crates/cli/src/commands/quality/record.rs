//! The results of `quality`, for files.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_spectrum::quality::{
    Measure, Quality, RIESZ_EXPONENTS, SetQuality, TailProbabilities, Unavailable,
    WORST_CASE_SMOOTHNESS,
};

use super::Measured;
use super::rank::RankRecord;

/// Measures of point sets: `quality --json`. Those of one sampler or file are at the top level,
/// those of several under `rows`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct QualityBody {
    #[serde(flatten)]
    one: Option<QualityRecord>,
    /// The measures of each sampler or file, where there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    rows: Vec<QualityRecord>,
}

impl QualityBody {
    pub(super) fn new(mut rows: Vec<QualityRecord>) -> Self {
        let one = if rows.len() == 1 { rows.pop() } else { None };
        Self { one, rows }
    }

    /// Returns all records.
    pub(super) fn records(&self) -> Vec<&QualityRecord> {
        self.one.iter().chain(&self.rows).collect()
    }
}

/// The measures of a sampler or file, means over its realizations. A number that cannot honestly be
/// given is null; `remarks` say why.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct QualityRecord {
    /// The sampler with its parameters, or the file.
    sampler: String,
    /// `sphere` or `hemisphere`.
    domain: &'static str,
    /// The number of points; of sets of different sizes the mean, rounded.
    n: usize,
    /// `(sum w)^2 / sum w^2`, the number of equal points with the same white noise.
    n_effective: f64,
    /// The number of realizations.
    realizations: usize,
    #[serde(flatten)]
    values: Values,
    /// The standard errors of the means; null for a single set.
    stderr: Option<Values>,
    /// The values times the powers of N that make them comparable; energies: the constants of their
    /// second terms.
    scaled: Values,
    /// The largest degree to which all harmonics are integrated exactly, the smallest of the sets.
    pub(super) exact_degree: usize,
    /// The condition number of the fit of harmonics, by the degree to which they extend.
    #[schemars(with = "BTreeMap<String, Option<f64>>")]
    pub(super) condition: BTreeMap<usize, Option<f64>>,
    /// How the power falls toward low degrees.
    pub(super) hyperuniformity: HyperuniformityRecord,
    /// The test of independent uniform points.
    pub(super) p_value: PValues,
    /// The place among patterns of this number of points; null without `--rank`.
    pub(super) rank: Option<RankRecord>,
    /// Why numbers are null.
    pub(super) remarks: Vec<String>,
}

/// The measures that every set has.
#[derive(Debug, Serialize, JsonSchema)]
struct Values {
    /// The least chord between two points, 0 if points coincide.
    separation: Option<f64>,
    /// The largest chord from a direction to its nearest point.
    covering_radius: Option<f64>,
    /// Twice the covering radius over the separation.
    mesh_ratio: Option<f64>,
    /// The L2 spherical cap discrepancy.
    cap_discrepancy_l2: Option<f64>,
    /// The generalized discrepancy of Cui and Freeden.
    generalized_discrepancy: Option<f64>,
    /// The worst-case error of the mean in the Sobolev space H^s, by s.
    worst_case_error: BTreeMap<String, Option<f64>>,
    /// The Riesz energy over unordered pairs, by s; null if points coincide.
    riesz_energy: BTreeMap<String, Option<f64>>,
}

impl Values {
    fn new(value: impl Fn(Measure) -> Option<f64>) -> Self {
        let by = |keys: &[f64], measure: fn(usize) -> Measure| {
            let entry = |(i, key): (usize, &f64)| (key.to_string(), value(measure(i)));
            keys.iter().enumerate().map(entry).collect()
        };
        Self {
            separation: value(Measure::Separation),
            covering_radius: value(Measure::CoveringRadius),
            mesh_ratio: value(Measure::MeshRatio),
            cap_discrepancy_l2: value(Measure::CapDiscrepancy),
            generalized_discrepancy: value(Measure::GeneralizedDiscrepancy),
            worst_case_error: by(&WORST_CASE_SMOOTHNESS, Measure::WorstCaseError),
            riesz_energy: by(&RIESZ_EXPONENTS, Measure::RieszEnergy),
        }
    }
}

/// How the power falls toward low degrees.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct HyperuniformityRecord {
    /// The exponent b of the power as l^b at low degrees.
    pub(super) exponent: Option<f64>,
    /// The 95 % interval of `exponent`.
    pub(super) exponent_interval: Option<(f64, f64)>,
    /// `I` (b > 1 or no power), `II` (b = 1), `III` (0 < b < 1) or `none`; null if undecidable.
    pub(super) class: Option<&'static str>,
}

/// Probabilities of discrepancies of independent uniform points, by statistic.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct PValues {
    /// That of the L2 cap discrepancy.
    pub(super) cap_discrepancy_l2: Option<Tails>,
    /// That of the generalized discrepancy.
    pub(super) generalized_discrepancy: Option<Tails>,
}

/// The probabilities of both tails.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
pub(super) struct Tails {
    /// That of a discrepancy as small or smaller: small for points that are more regular.
    pub(super) lower: f64,
    /// That of a discrepancy as large or larger: small for points that cluster.
    pub(super) upper: f64,
}

impl QualityRecord {
    pub(super) fn new(measured: &Measured, rank: Option<Result<RankRecord, Unavailable>>) -> Self {
        let Measured { source, quality } = measured;
        let sets = &quality.sets;
        let moments = |measure: Measure| quality.moments(|set| measure.value(set));
        let mean = |value: fn(&SetQuality) -> f64| {
            sets.iter().map(value).sum::<f64>() / sets.len().max(1) as f64
        };
        let mut remarks = Vec::new();
        let hyperuniformity = hyperuniformity_record(quality, &mut remarks);
        let p_value = p_values(quality, &mut remarks);
        let condition = conditions(quality, &mut remarks);
        remarks.extend(geometry_remarks(quality));
        let sums = sets.iter().find_map(|set| set.sums.as_ref().err());
        remarks.extend(sums.map(|reason| format!("discrepancies, errors and energies: {reason}")));
        let rank = rank.and_then(|rank| {
            rank.inspect_err(|reason| remarks.push(format!("rank: {reason}"))).ok()
        });
        Self {
            sampler: source.name.clone(),
            domain: measured.domain().name(),
            n: measured.n_points(),
            n_effective: mean(|set| set.n_effective),
            realizations: sets.len(),
            values: Values::new(|measure| moments(measure).map(|m| m.mean())),
            stderr: (sets.len() > 1)
                .then(|| Values::new(|measure| moments(measure).map(|m| m.standard_error()))),
            scaled: Values::new(|measure| quality.mean_scaled(measure)),
            exact_degree: sets.iter().map(|set| set.exact_degree).min().unwrap_or(0),
            condition,
            hyperuniformity,
            p_value,
            rank,
            remarks,
        }
    }

    pub(super) fn sampler(&self) -> &str {
        &self.sampler
    }
}

impl Measured {
    /// Returns the number of points, of sets of different sizes the mean.
    pub(super) fn n_points(&self) -> usize {
        let total: usize = self.quality.sets.iter().map(|set| set.n_points).sum();
        let count = self.quality.sets.len().max(1);
        (total + count / 2) / count
    }

    pub(super) fn domain(&self) -> sphvar_samplers::Domain {
        self.source.sampler.domain()
    }
}

/// Returns why distances and energies are missing.
fn geometry_remarks(quality: &Quality) -> Option<String> {
    let covering = quality.sets.iter().find_map(|set| set.covering_radius.as_ref().err());
    let coincide = quality.sets.iter().any(|set| set.separation == Some(0.0));
    let single = quality.sets.iter().any(|set| set.separation.is_none());
    let energies = quality
        .sets
        .iter()
        .any(|set| set.sums.as_ref().is_ok_and(|sums| sums.riesz_energy.contains(&None)));
    if let Some(reason) = covering {
        Some(format!("covering radius: {reason}"))
    } else if coincide || energies {
        Some("points coincide: no mesh ratio and no energies".to_owned())
    } else if single {
        Some("separation: a single point has none".to_owned())
    } else {
        None
    }
}

fn hyperuniformity_record(quality: &Quality, remarks: &mut Vec<String>) -> HyperuniformityRecord {
    let found = &quality.hyperuniformity;
    let reason = found.class.as_ref().err().or(found.exponent.as_ref().err());
    remarks.extend(reason.map(|reason| format!("hyperuniformity: {reason}")));
    let exponent = found.exponent.as_ref().ok();
    HyperuniformityRecord {
        exponent: exponent.map(|e| e.0),
        exponent_interval: exponent.map(|e| e.1),
        class: found.class.as_ref().ok().map(|class| class.name()),
    }
}

fn p_values(quality: &Quality, remarks: &mut Vec<String>) -> PValues {
    let reason = quality.cap_p_value.as_ref().err();
    remarks.extend(reason.map(|reason| format!("p-value: {reason}")));
    let tails = |test: &Result<TailProbabilities, Unavailable>| {
        test.as_ref().ok().map(|t| Tails { lower: t.lower, upper: t.upper })
    };
    PValues {
        cap_discrepancy_l2: tails(&quality.cap_p_value),
        generalized_discrepancy: tails(&quality.generalized_p_value),
    }
}

/// Returns the mean condition numbers of degrees for which every set has one.
fn conditions(quality: &Quality, remarks: &mut Vec<String>) -> BTreeMap<usize, Option<f64>> {
    let mut all = BTreeMap::new();
    let degrees = quality.sets.iter().flat_map(|set| set.condition.iter().map(|c| c.0));
    for degree in degrees.collect::<std::collections::BTreeSet<_>>() {
        let of_set =
            |set: &SetQuality| set.condition.iter().find(|c| c.0 == degree).map(|c| c.1.clone());
        let found: Result<Vec<f64>, Unavailable> = quality.sets.iter().filter_map(of_set).collect();
        match found {
            Ok(found) => {
                all.insert(degree, Some(found.iter().sum::<f64>() / found.len() as f64));
            }
            Err(reason) => {
                remarks.push(format!("condition to degree {degree}: {reason}"));
                all.insert(degree, None);
            }
        }
    }
    all
}

/// One measure of a sampler or file: a row of `quality -o FILE.csv`.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct MeasureRow {
    /// The sampler with its parameters, or the file.
    sampler: String,
    /// The number of points.
    n: usize,
    /// The measure.
    measure: String,
    /// Its mean over the realizations.
    value: Option<f64>,
    /// The standard error of the mean.
    stderr: Option<f64>,
    /// The mean of the scaled values.
    scaled: Option<f64>,
    /// The power of N by which values are scaled.
    power: f64,
    /// The scaled value of the hexagonal lattice.
    hexagonal: f64,
    /// The root mean square of the value for white noise, where it has a closed form.
    white_noise: Option<f64>,
}

impl MeasureRow {
    pub(super) fn all(measured: &Measured) -> Vec<Self> {
        let n = measured.n_points();
        let row = |measure: Measure| {
            let moments = measured.quality.moments(|set| measure.value(set));
            Self {
                sampler: measured.source.name.clone(),
                n,
                measure: measure.name(),
                value: moments.as_ref().map(|m| m.mean()),
                stderr: moments.map(|m| m.standard_error()).filter(|e| e.is_finite()),
                scaled: measured.quality.mean_scaled(measure),
                power: measure.power(),
                hexagonal: measure.hexagonal_limit(),
                white_noise: measure.white_noise(n, measured.domain()),
            }
        };
        Measure::ALL.into_iter().map(row).collect()
    }
}
