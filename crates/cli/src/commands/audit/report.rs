//! What an audit found, for people and for scripts.

use serde::Serialize;
use sphvar_spectrum::{AuditFamily, AuditSettings, AuditVerdict, Finding, HomogeneityAudit};

use crate::report::{Provenance, full, short, table};

/// The document of `--json`.
#[derive(Debug, Serialize)]
pub(super) struct Document<'a> {
    pub(super) sampler: &'a str,
    pub(super) domain: &'static str,
    pub(super) n: usize,
    pub(super) realizations: u64,
    pub(super) lmax: usize,
    pub(super) alpha: f64,
    pub(super) tolerance: f64,
    pub(super) copies: u64,
    pub(super) audits: Vec<AuditRecord>,
    pub(super) provenance: &'a Provenance,
}

/// One audit as scripts see it.
#[derive(Debug, Serialize)]
pub(super) struct AuditRecord {
    ensemble: &'static str,
    verdict: &'static str,
    conclusion: String,
    /// Infinite where nothing can be seen, which is null in JSON.
    detectable: f64,
    vanishing: Vec<usize>,
    tests: Vec<TestRecord>,
    ratios: Vec<RatioRecord>,
    bias: Option<BiasRecord>,
}

#[derive(Debug, Serialize)]
struct TestRecord {
    test: &'static str,
    compared: usize,
    statistic: f64,
    p_value: f64,
    adjusted: f64,
    rejected: bool,
    worst: String,
    value: f64,
}

#[derive(Debug, Serialize)]
struct RatioRecord {
    l: usize,
    m: usize,
    ratio: f64,
    stderr: f64,
    low: f64,
    high: f64,
}

#[derive(Debug, Serialize)]
struct BiasRecord {
    l: usize,
    m: usize,
    share: f64,
}

/// What is known of the rotations of an ensemble.
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

impl Document<'_> {
    /// The heading of [`Self::rows`].
    pub(super) const COLUMNS: &'static str =
        "ensemble,test,compared,statistic,p_value,adjusted,rejected,worst,value,verdict";

    /// The rows of a CSV file, one for each test.
    pub(super) fn rows(&self) -> Vec<Vec<String>> {
        let row = |audit: &AuditRecord, t: &TestRecord| {
            vec![
                audit.ensemble.to_owned(),
                t.test.to_owned(),
                t.compared.to_string(),
                full(t.statistic),
                full(t.p_value),
                full(t.adjusted),
                t.rejected.to_string(),
                t.worst.clone(),
                full(t.value),
                audit.verdict.to_owned(),
            ]
        };
        self.audits.iter().flat_map(|a| a.tests.iter().map(move |t| row(a, t))).collect()
    }

    /// The report for people.
    pub(super) fn text(&self) -> String {
        let parts: Vec<String> = self.audits.iter().map(|audit| text(self, audit)).collect();
        parts.join("\n")
    }
}

impl AuditRecord {
    /// The record of one audit.
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

/// What the findings mean, in a sentence or three.
fn conclusion(ensemble: Ensemble, audit: &HomogeneityAudit, settings: &AuditSettings) -> String {
    let seen = format!(
        "an error of {} of the variance of any Y_lm, l <= {}, would have been seen in 9 of 10 audits",
        percent(audit.detectable),
        audit.lmax
    );
    match audit.verdict {
        AuditVerdict::Homogeneous => format!("The variance formula may be used: {seen}."),
        AuditVerdict::Undecided if audit.ratios.is_empty() => {
            "Not enough to tell: no degree that was looked at has any power.".to_owned()
        }
        AuditVerdict::Undecided => {
            let factor = (audit.detectable / settings.tolerance).powi(2);
            let needed = (factor * audit.realizations as f64 / 100.0).ceil() * 100.0;
            format!(
                "Not enough realizations to tell: only {seen}; for {} take about {needed} of them.",
                percent(settings.tolerance)
            )
        }
        AuditVerdict::Inhomogeneous => objection(ensemble, audit),
    }
}

fn objection(ensemble: Ensemble, audit: &HomogeneityAudit) -> String {
    let rejected = |family| audit.finding(family).is_some_and(|f| f.rejected);
    let mut text = match ensemble {
        Ensemble::AsDrawn { random: false } => {
            "The variance formula may not be used: this is one fixed set, so the error is no chance \
             at all; turn every realization by a uniform rotation."
        }
        Ensemble::AsDrawn { random: true } => {
            "The variance formula may not be used: turn every realization by a uniform rotation."
        }
        Ensemble::Rotated => "The variance formula may not be used: the rotations are not uniform.",
        Ensemble::FromFiles => {
            "The variance formula may not be used, unless these sets are turned by uniform rotations."
        }
    }
    .to_owned();
    if let Some(w) = audit.worst_ratio() {
        let (l, m) = (w.l, w.m);
        text += &format!(
            " Worst factor of the mean squared error: {:.3} for Y_{l},{m} ({:.3} to {:.3}, all orders \
             together at 1 - alpha).",
            w.ratio, w.low, w.high
        );
    }
    if rejected(AuditFamily::Means)
        && let Some(b) = audit.bias
    {
        let (l, m) = (b.l, b.m);
        text += &format!(" Bias: {} of the formula's variance for Y_{l},{m}.", percent(b.share));
    }
    if rejected(AuditFamily::Covariances) {
        text += " Integrands of several coefficients have cross terms besides.";
    }
    text
}

/// A share in percent, to two digits.
fn percent(x: f64) -> String {
    let percent = 100.0 * x;
    if percent >= 10.0 { format!("{percent:.0} %") } else { format!("{percent:.1} %") }
}

/// The report on one ensemble for people.
fn text(document: &Document<'_>, audit: &AuditRecord) -> String {
    let Document { sampler, n, realizations, lmax, copies, .. } = document;
    let mut text = format!(
        "{sampler}, N = {n}, {}: {realizations} realizations, degrees to {lmax}, {copies} turned copies\n",
        audit.ensemble
    );
    let cells = audit.tests.iter().map(|t| {
        let verdict = match (t.compared, t.rejected) {
            (0, _) => "nothing to test",
            (_, true) => "objects",
            (_, false) => "no objection",
        };
        vec![
            t.test.to_owned(),
            t.compared.to_string(),
            if t.compared > 0 { format!("{:.2}", t.statistic) } else { "-".to_owned() },
            short(t.p_value),
            t.worst.clone(),
            if t.value.is_finite() { format!("{:.4}", t.value) } else { "-".to_owned() },
            verdict.to_owned(),
        ]
    });
    let heading = ["test", "compared", "largest score", "p", "where", "value", "verdict"];
    text += &table(&heading, cells.collect(), 1);
    if !audit.tests.iter().any(|t| t.test == AuditFamily::Rotations.name()) {
        text += match audit.ensemble {
            "from files" => "rotations: not known of points from files\n",
            _ => "rotations: none were used\n",
        };
    }
    if !audit.vanishing.is_empty() {
        let degrees: Vec<String> = audit.vanishing.iter().map(ToString::to_string).collect();
        text += &format!("left out, without power: l = {}\n", degrees.join(", "));
    }
    text + &audit.conclusion + "\n"
}
