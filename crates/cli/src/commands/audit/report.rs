//! The results of an audit, as text, CSV and JSON.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_spectrum::{AuditFamily, AuditSettings, AuditVerdict, Finding, HomogeneityAudit};

use crate::error::CliError;
use crate::report::{Column, Provenance, csv_of, number, table_of};

/// The test of rotation invariance, the assumption of the variance formula: `audit --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct AuditBody {
    /// The sampler with its parameters, or the files.
    pub(super) sampler: String,
    /// `sphere` or `hemisphere`.
    pub(super) domain: &'static str,
    /// The number of points; for files the mean number.
    pub(super) n: usize,
    /// The effective number of weighted points, `(sum w)^2 / sum w^2`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) n_effective: Option<f64>,
    /// The number of realizations.
    pub(super) realizations: u64,
    /// The largest degree, inclusive.
    pub(super) lmax: usize,
    /// The probability that a rotation-invariant ensemble is rejected.
    pub(super) alpha: f64,
    /// The relative error of a variance that must be detectable for the verdict `yes`.
    pub(super) tolerance: f64,
    /// The number of randomly rotated copies that tests compare with.
    pub(super) copies: u64,
    /// The audits: as drawn, rotated, or from files.
    pub(super) audits: Vec<AuditRecord>,
}

/// One audit.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct AuditRecord {
    /// `as drawn`, `rotated` or `from files`.
    ensemble: &'static str,
    /// Whether the variance formula is valid: `yes`, `no` or `undecided`.
    verdict: &'static str,
    /// The conclusion from the tests, in sentences.
    conclusion: String,
    /// The relative error of a variance that 9 of 10 audits would detect; null where none would.
    #[schemars(with = "Option<f64>")]
    detectable: f64,
    /// Degrees without power, which are not tested.
    vanishing: Vec<usize>,
    /// The tests.
    tests: Vec<TestRecord>,
    /// Mean squared errors of the integrals of single harmonics, divided by the predicted variance.
    ratios: Vec<RatioRecord>,
    /// The largest bias, if any.
    bias: Option<BiasRecord>,
}

/// One test of an audit.
#[derive(Debug, Serialize, JsonSchema)]
struct TestRecord {
    /// The name of the test.
    test: &'static str,
    /// The number of comparisons.
    compared: usize,
    /// The largest score of a comparison.
    #[schemars(with = "Option<f64>")]
    statistic: f64,
    /// The probability of a score of this size in a rotation-invariant ensemble.
    #[schemars(with = "Option<f64>")]
    p_value: f64,
    /// `p_value`, adjusted for the number of tests.
    #[schemars(with = "Option<f64>")]
    adjusted: f64,
    /// Whether the test rejects rotation invariance.
    rejected: bool,
    /// The location of the largest score.
    worst: String,
    /// The tested quantity at this location.
    #[schemars(with = "Option<f64>")]
    value: f64,
}

/// A test with its audit, a row of CSV.
#[derive(Serialize, JsonSchema)]
struct TestRow<'a> {
    /// `as drawn`, `rotated` or `from files`.
    ensemble: &'static str,
    #[serde(flatten)]
    test: &'a TestRecord,
    /// The verdict of the audit.
    verdict: &'static str,
}

/// The mean squared error of the integral of one harmonic, divided by the predicted variance.
#[derive(Debug, Serialize, JsonSchema)]
struct RatioRecord {
    /// The degree.
    l: usize,
    /// The order.
    m: usize,
    /// The mean squared error divided by the predicted variance.
    #[schemars(with = "Option<f64>")]
    ratio: f64,
    /// The standard error of `ratio`.
    #[schemars(with = "Option<f64>")]
    stderr: f64,
    /// The lower end of the interval, simultaneous for all orders at 1 - alpha.
    #[schemars(with = "Option<f64>")]
    low: f64,
    /// The upper end of the interval.
    #[schemars(with = "Option<f64>")]
    high: f64,
}

/// The bias of the integral of one harmonic.
#[derive(Debug, Serialize, JsonSchema)]
struct BiasRecord {
    /// The degree.
    l: usize,
    /// The order.
    m: usize,
    /// The squared bias divided by the predicted variance.
    #[schemars(with = "Option<f64>")]
    share: f64,
}

/// The known facts about the rotations of an ensemble.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Ensemble {
    AsDrawn { random: bool },
    Rotated,
    FromFiles,
}

impl Ensemble {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::AsDrawn { .. } => "as drawn",
            Self::Rotated => "rotated",
            Self::FromFiles => "from files",
        }
    }
}

impl AuditBody {
    /// Returns CSV with a row for each test.
    pub(super) fn csv(&self, provenance: &Provenance) -> Result<String, CliError> {
        let rows: Vec<TestRow<'_>> = self.audits.iter().flat_map(AuditRecord::rows).collect();
        csv_of(provenance, &rows)
    }

    /// Returns the report for the terminal.
    pub(super) fn text(&self) -> String {
        let parts: Vec<String> = self.audits.iter().map(|audit| text(self, audit)).collect();
        parts.join("\n")
    }
}

impl AuditRecord {
    /// Returns the rows of CSV.
    fn rows(&self) -> impl Iterator<Item = TestRow<'_>> {
        let (ensemble, verdict) = (self.ensemble, self.verdict);
        self.tests.iter().map(move |test| TestRow { ensemble, test, verdict })
    }

    /// Returns the record of one audit.
    pub(super) fn new(
        ensemble: Ensemble,
        audit: &HomogeneityAudit,
        settings: &AuditSettings,
    ) -> Self {
        let test = |f: &Finding| TestRecord {
            test: f.family.name(),
            compared: f.comparisons,
            statistic: f.statistic,
            p_value: f.p_value,
            adjusted: f.adjusted,
            rejected: f.rejected,
            worst: f.worst.clone(),
            value: f.value,
        };
        let ratios = audit.ratios.iter().map(|r| RatioRecord {
            l: r.l,
            m: r.m,
            ratio: r.ratio,
            stderr: r.stderr,
            low: r.low,
            high: r.high,
        });
        Self {
            ensemble: ensemble.name(),
            verdict: match audit.verdict {
                AuditVerdict::Homogeneous => "yes",
                AuditVerdict::Inhomogeneous => "no",
                AuditVerdict::Undecided => "undecided",
            },
            conclusion: conclusion(ensemble, audit, settings),
            detectable: audit.detectable,
            vanishing: audit.vanishing.clone(),
            tests: audit.findings.iter().map(test).collect(),
            ratios: ratios.collect(),
            bias: audit.bias.map(|b| BiasRecord { l: b.l, m: b.m, share: b.share }),
        }
    }
}

impl TestRecord {
    /// Returns the columns of a table.
    fn columns() -> [Column<'static, Self>; 7] {
        [
            Column::text("test", |t: &Self| t.test.to_owned()),
            Column::number("compared", |t: &Self| t.compared.to_string()),
            Column::number("largest score", |t: &Self| {
                number::optional((t.compared > 0).then_some(t.statistic), number::ratio)
            }),
            Column::number("p", |t: &Self| number::ratio(t.p_value)),
            Column::text("where", |t: &Self| t.worst.clone()),
            Column::number("value", |t: &Self| number::value(t.value)),
            Column::text("verdict", |t: &Self| {
                match (t.compared, t.rejected) {
                    (0, _) => "not applicable",
                    (_, true) => "rejected",
                    (_, false) => "not rejected",
                }
                .to_owned()
            }),
        ]
    }
}

/// Returns the meaning of the results, in one to three sentences.
fn conclusion(ensemble: Ensemble, audit: &HomogeneityAudit, settings: &AuditSettings) -> String {
    let seen = format!(
        "an error of {} of the variance of any Y_lm, l <= {}, would be detected in 9 of 10 audits",
        number::percent(audit.detectable),
        audit.lmax
    );
    match audit.verdict {
        AuditVerdict::Homogeneous => format!("The variance formula is valid: {seen}."),
        AuditVerdict::Undecided if audit.ratios.is_empty() => {
            "Undecided: no tested degree has power.".to_owned()
        }
        AuditVerdict::Undecided => {
            let factor = (audit.detectable / settings.tolerance).powi(2);
            let needed = (factor * audit.realizations as f64 / 100.0).ceil() * 100.0;
            format!(
                "Undecided: only {seen}; detecting {} requires about {needed} realizations.",
                number::percent(settings.tolerance)
            )
        }
        AuditVerdict::Inhomogeneous => objection(ensemble, audit),
    }
}

fn objection(ensemble: Ensemble, audit: &HomogeneityAudit) -> String {
    let rejected = |family| audit.finding(family).is_some_and(|f| f.rejected);
    let mut text = match ensemble {
        Ensemble::AsDrawn { random: false } => {
            "The variance formula is not valid: this is a single fixed set, so its error is not random; \
             apply a uniform random rotation to every realization."
        }
        Ensemble::AsDrawn { random: true } => {
            "The variance formula is not valid: apply a uniform random rotation to every realization."
        }
        Ensemble::Rotated => "The variance formula is not valid: the rotations are not uniform.",
        Ensemble::FromFiles => {
            "The variance formula is not valid unless a uniform random rotation is applied to each of these sets."
        }
    }
    .to_owned();
    if let Some(w) = audit.worst_ratio() {
        let (l, m) = (w.l, w.m);
        text += &format!(
            " Largest deviation of the mean squared error: factor {} for Y_{l},{m} (simultaneous interval at \
             1 - alpha: {}).",
            number::ratio(w.ratio),
            number::interval(Some((w.low, w.high)), number::ratio)
        );
    }
    if rejected(AuditFamily::Means)
        && let Some(b) = audit.bias
    {
        let (l, m) = (b.l, b.m);
        text += &format!(
            " Bias: {} of the predicted variance for Y_{l},{m}.",
            number::percent(b.share)
        );
    }
    if rejected(AuditFamily::Covariances) {
        text += " Integrands with several coefficients also have cross terms.";
    }
    text
}

/// Returns the report on one ensemble for the terminal.
fn text(body: &AuditBody, audit: &AuditRecord) -> String {
    let AuditBody { sampler, n, realizations, lmax, copies, .. } = body;
    let mut text = format!(
        "{sampler}, N = {n}, {}: {realizations} realizations, degrees to {lmax}, {copies} rotated copies\n",
        audit.ensemble
    );
    text += &table_of(&TestRecord::columns(), &audit.tests);
    if !audit.tests.iter().any(|t| t.test == AuditFamily::Rotations.name()) {
        text += match audit.ensemble {
            "from files" => "rotations: unknown for points from files\n",
            _ => "rotations: none were used\n",
        };
    }
    if !audit.vanishing.is_empty() {
        let degrees: Vec<String> = audit.vanishing.iter().map(ToString::to_string).collect();
        text += &format!("not tested, without power: l = {}\n", degrees.join(", "));
    }
    text + &audit.conclusion + "\n"
}
