//! The results of `quality --square`.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_spectrum::Moments;
use sphvar_spectrum::quality::{SquareQuality, Unavailable};

use crate::report::{number, table};

/// Measures of point sets of the unit square: `quality --square --json`. Those of one sampler or file
/// are at the top level, those of several under `rows`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SquareQualityBody {
    #[serde(flatten)]
    one: Option<SquareQualityRecord>,
    /// The measures of each sampler or file, where there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    rows: Vec<SquareQualityRecord>,
}

impl SquareQualityBody {
    pub(super) fn new(mut rows: Vec<SquareQualityRecord>) -> Self {
        let one = if rows.len() == 1 { rows.pop() } else { None };
        Self { one, rows }
    }

    /// Returns all records.
    pub(super) fn records(&self) -> Vec<&SquareQualityRecord> {
        self.one.iter().chain(&self.rows).collect()
    }
}

/// The measures of a sampler or file of the unit square, means over its realizations. A number that
/// cannot honestly be given is null; `remarks` say why.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SquareQualityRecord {
    /// The name in tables.
    #[serde(skip)]
    label: String,
    /// The sampler with its parameters, or the file.
    sampler: String,
    /// `square`.
    domain: &'static str,
    /// The number of points; of sets of different sizes the mean, rounded.
    n: usize,
    /// `(sum w)^2 / sum w^2`, the number of equal points with the same white noise.
    n_effective: f64,
    /// The number of realizations.
    realizations: usize,
    #[serde(flatten)]
    values: SquareValues,
    /// The standard errors of the means; null for a single set.
    stderr: Option<SquareValues>,
    /// The least t for which each set is a (t, m, 2)-net in base 2; null unless the number of points
    /// is a power of two.
    net_t: Option<u32>,
    /// Why numbers are null.
    remarks: Vec<String>,
}

/// The measures that every set of the unit square has.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
struct SquareValues {
    /// The least toroidal distance between two points, 0 if points coincide.
    separation: Option<f64>,
    /// The separation relative to that of a hexagonal lattice of N points per unit area.
    relative_separation: Option<f64>,
    /// The star discrepancy.
    star_discrepancy: Option<f64>,
    /// The L2 star discrepancy of Warnock.
    l2_star_discrepancy: Option<f64>,
    /// The wrap-around L2 discrepancy of Hickernell.
    wraparound_l2_discrepancy: Option<f64>,
}

/// A measure of a set of the square, if it has one.
type Measure = fn(&SquareQuality) -> Option<f64>;

/// A measure of a set of the square that may be unavailable.
type Discrepancy = fn(&SquareQuality) -> &Result<f64, Unavailable>;

/// The measures with their names, in the order of the fields of [`SquareValues`].
const MEASURES: [(&str, Measure); 5] = [
    ("separation", |set| set.separation),
    ("relative separation", SquareQuality::relative_separation),
    ("star discrepancy", |set| set.star_discrepancy.clone().ok()),
    ("L2 star discrepancy", |set| set.l2_star_discrepancy.clone().ok()),
    ("wrap-around L2 discrepancy", |set| set.wraparound_l2_discrepancy.clone().ok()),
];

impl SquareValues {
    fn new(value: impl Fn(Measure) -> Option<f64>) -> Self {
        let [separation, relative_separation, star, l2, wraparound] =
            MEASURES.map(|(_, measure)| value(measure));
        Self {
            separation,
            relative_separation,
            star_discrepancy: star,
            l2_star_discrepancy: l2,
            wraparound_l2_discrepancy: wraparound,
        }
    }

    /// Returns the values in the order of [`MEASURES`].
    fn list(&self) -> [Option<f64>; 5] {
        [
            self.separation,
            self.relative_separation,
            self.star_discrepancy,
            self.l2_star_discrepancy,
            self.wraparound_l2_discrepancy,
        ]
    }
}

impl SquareQualityRecord {
    pub(super) fn new(sampler: String, label: String, sets: &[SquareQuality]) -> Self {
        let moments = |measure: Measure| {
            let mut moments = Moments::default();
            sets.iter().try_for_each(|set| measure(set).map(|x| moments.push(x)))?;
            Some(moments)
        };
        let count = sets.len().max(1);
        let total: usize = sets.iter().map(|set| set.n_points).sum();
        let net = sets.iter().map(|set| set.net_parameter).collect::<Option<Vec<_>>>();
        let mut remarks = Vec::new();
        let discrepancies: [(&str, Discrepancy); 3] = [
            ("star discrepancy", |set| &set.star_discrepancy),
            ("L2 star discrepancy", |set| &set.l2_star_discrepancy),
            ("wrap-around L2 discrepancy", |set| &set.wraparound_l2_discrepancy),
        ];
        for (name, discrepancy) in discrepancies {
            let reason = sets.iter().find_map(|set| discrepancy(set).as_ref().err());
            remarks.extend(reason.map(|reason| format!("{name}: {reason}")));
        }
        if sets.iter().any(|set| set.separation.is_none()) {
            remarks.push("separation: a single point has none".to_owned());
        }
        if net.is_none() {
            remarks.push("(t,m,2)-net: the number of points is not a power of two".to_owned());
        }
        Self {
            label,
            sampler,
            domain: "square",
            n: (total + count / 2) / count,
            n_effective: sets.iter().map(|set| set.n_effective).sum::<f64>() / count as f64,
            realizations: sets.len(),
            values: SquareValues::new(|measure| moments(measure).map(|m| m.mean())),
            stderr: (sets.len() > 1)
                .then(|| SquareValues::new(|measure| moments(measure).map(|m| m.standard_error()))),
            net_t: net.and_then(|all| all.into_iter().max()),
            remarks,
        }
    }
}

/// One measure of a sampler or file of the unit square: a row of `quality --square -o FILE.csv`.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct SquareMeasureRow {
    /// The sampler with its parameters, or the file.
    sampler: String,
    /// The number of points.
    n: usize,
    /// The measure.
    measure: &'static str,
    /// Its mean over the realizations.
    value: Option<f64>,
    /// The standard error of the mean.
    stderr: Option<f64>,
}

impl SquareMeasureRow {
    pub(super) fn all(record: &SquareQualityRecord) -> Vec<Self> {
        let errors = record.stderr.map_or([None; 5], |stderr| stderr.list());
        let values = record.values.list().into_iter().zip(errors);
        let row = |((measure, _), (value, stderr)): ((&'static str, Measure), _)| Self {
            sampler: record.sampler.clone(),
            n: record.n,
            measure,
            value,
            stderr,
        };
        MEASURES.into_iter().zip(values).map(row).collect()
    }
}

/// Returns the table of measures, with a column for each sampler or file, and the remarks.
pub(super) fn text(records: &[&SquareQualityRecord]) -> String {
    let mut heading = vec!["measure"];
    heading.extend(records.iter().map(|record| record.label.as_str()));
    let row = |name: &str, cell: &dyn Fn(&SquareQualityRecord) -> String| {
        std::iter::once(name.to_owned()).chain(records.iter().map(|r| cell(r))).collect::<Vec<_>>()
    };
    let mut rows = vec![row("points N", &|record| record.n.to_string())];
    for (i, (name, _)) in MEASURES.into_iter().enumerate() {
        let cell = |record: &SquareQualityRecord| {
            let stderr = record.stderr.and_then(|stderr| stderr.list()[i]);
            match (record.values.list()[i], stderr) {
                (Some(value), Some(stderr)) => number::with_uncertainty(value, stderr),
                (value, _) => number::optional(value, number::value),
            }
        };
        rows.push(row(name, &cell));
    }
    rows.push(row("t of the (t,m,2)-net", &|record| {
        record.net_t.map_or(number::MISSING.to_owned(), |t| t.to_string())
    }));
    let mut text = table(&heading, rows, 1);
    for record in records {
        for remark in &record.remarks {
            let of = if records.len() == 1 { String::new() } else { format!("{}: ", record.label) };
            text += &format!("{of}{remark}\n");
        }
    }
    text
}
