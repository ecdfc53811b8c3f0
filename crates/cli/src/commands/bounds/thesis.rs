//! The bounds that the thesis draws for a sampler, against its spectrum.

use serde::Serialize;
use sphvar_bounds::{Bound, BoundVerdict, MeasuredSpectrum, thesis_bounds};

use super::record::readable;
use crate::error::CliError;

/// A bound of the thesis and whether it holds, as scripts see it.
#[derive(Debug, Serialize)]
pub(super) struct ThesisRecord {
    side: &'static str,
    family: &'static str,
    alpha: f64,
    gamma: f64,
    /// `holds` if the data prove it, `not refuted` if they allow it, or `broken`.
    verdict: &'static str,
    /// The degree that speaks most against it in standard errors, with power over bound there.
    worst_degree: usize,
    worst_omega: f64,
    worst_ratio: f64,
    /// Excess there in standard errors; null where the spectrum is exact.
    z: f64,
    /// What `z` may reach at the confidence asked for.
    critical_z: f64,
    /// The degree that comes closest or lies farthest beyond, with power over bound there.
    extreme_degree: usize,
    extreme_omega: f64,
    extreme_ratio: f64,
}

impl ThesisRecord {
    /// Checks of the upper and the lower bound, if the thesis has them for this sampler.
    pub(super) fn of_sampler(
        name: &str,
        spectrum: &MeasuredSpectrum<'_>,
        confidence: f64,
    ) -> Result<Vec<Self>, CliError> {
        let Some(known) = thesis_bounds().into_iter().find(|b| b.sampler == name) else {
            return Ok(Vec::new());
        };
        [Bound::upper(known.upper), Bound::lower(known.lower)]
            .into_iter()
            .map(|bound| {
                let verdict = bound.check(spectrum, confidence).map_err(CliError::usage)?;
                Ok(Self::new(&bound, &verdict, spectrum.n_points()))
            })
            .collect()
    }

    fn new(bound: &Bound, verdict: &BoundVerdict, n_points: usize) -> Self {
        let omega = |l: usize| l as f64 / (n_points as f64).sqrt();
        Self {
            side: bound.side.name(),
            family: bound.profile.family().name(),
            alpha: bound.profile.alpha(),
            gamma: bound.profile.gamma(),
            verdict: match (verdict.proved, verdict.holds) {
                (true, _) => "holds",
                (false, true) => "not refuted",
                (false, false) => "broken",
            },
            worst_degree: verdict.worst_degree,
            worst_omega: omega(verdict.worst_degree),
            worst_ratio: verdict.worst_ratio,
            z: verdict.z,
            critical_z: verdict.critical_z,
            extreme_degree: verdict.extreme_degree,
            extreme_omega: omega(verdict.extreme_degree),
            extreme_ratio: verdict.extreme_ratio,
        }
    }

    /// The heading of [`Self::row`].
    pub(super) const HEADING: [&'static str; 12] = [
        "thesis",
        "profile",
        "alpha",
        "gamma",
        "verdict",
        "worst l",
        "omega",
        "ratio",
        "z",
        "extreme l",
        "omega",
        "ratio",
    ];

    /// The row of a table for people.
    pub(super) fn row(&self) -> Vec<String> {
        let break_at =
            if self.family == "constant" { "-".to_owned() } else { readable(self.alpha) };
        vec![
            self.side.to_owned(),
            self.family.to_owned(),
            break_at,
            readable(self.gamma),
            self.verdict.to_owned(),
            self.worst_degree.to_string(),
            readable(self.worst_omega),
            readable(self.worst_ratio),
            if self.z.is_finite() { format!("{:+.1}", self.z) } else { "exact".to_owned() },
            self.extreme_degree.to_string(),
            readable(self.extreme_omega),
            readable(self.extreme_ratio),
        ]
    }

    /// The largest `z` that chance explains.
    pub(super) fn critical_z(&self) -> f64 {
        self.critical_z
    }
}
