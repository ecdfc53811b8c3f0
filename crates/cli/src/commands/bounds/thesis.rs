//! The bounds that the thesis states for a sampler, checked against its spectrum.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_bounds::{Bound, BoundVerdict, MeasuredSpectrum, thesis_bounds};

use super::record::break_at;
use crate::error::CliError;
use crate::report::{Column, number};

/// A bound of the thesis and whether it holds.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ThesisRecord {
    /// `upper` or `lower`.
    side: &'static str,
    /// The family of the profile.
    family: &'static str,
    /// The break of the profile, a degree divided by `sqrt(N)`.
    alpha: f64,
    /// The power at which it levels off.
    gamma: f64,
    /// `holds` if the data prove it, `not refuted` if they allow it, or `broken`.
    verdict: &'static str,
    /// The degree that speaks most against the bound, in standard errors.
    worst_degree: usize,
    /// `worst_degree / sqrt(N)`.
    worst_omega: f64,
    /// Power over bound at `worst_degree`.
    #[schemars(with = "Option<f64>")]
    worst_ratio: f64,
    /// The excess at `worst_degree` in standard errors; null where the spectrum is exact.
    #[schemars(with = "Option<f64>")]
    z: f64,
    /// The limit of `z` at the requested confidence.
    #[schemars(with = "Option<f64>")]
    critical_z: f64,
    /// The degree that comes closest to the bound or lies farthest beyond it.
    extreme_degree: usize,
    /// `extreme_degree / sqrt(N)`.
    extreme_omega: f64,
    /// Power over bound at `extreme_degree`.
    #[schemars(with = "Option<f64>")]
    extreme_ratio: f64,
}

impl ThesisRecord {
    /// Checks the upper and the lower bound, if the thesis states them for this sampler.
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

    /// Returns the columns of a table.
    pub(super) fn columns() -> Vec<Column<'static, Self>> {
        vec![
            Column::text("thesis", |r: &Self| r.side.to_owned()),
            Column::text("profile", |r: &Self| r.family.to_owned()),
            Column::number("alpha", |r: &Self| {
                number::optional(break_at(r.family, r.alpha), number::value)
            }),
            Column::number("gamma", |r: &Self| number::value(r.gamma)),
            Column::text("verdict", |r: &Self| r.verdict.to_owned()),
            Column::number("worst l", |r: &Self| r.worst_degree.to_string()),
            Column::number("omega", |r: &Self| number::value(r.worst_omega)),
            Column::number("ratio", |r: &Self| number::ratio(r.worst_ratio)),
            Column::number("z", |r: &Self| {
                if r.z.is_finite() { number::score(r.z) } else { "exact".to_owned() }
            }),
            Column::number("extreme l", |r: &Self| r.extreme_degree.to_string()),
            Column::number("omega", |r: &Self| number::value(r.extreme_omega)),
            Column::number("ratio", |r: &Self| number::ratio(r.extreme_ratio)),
        ]
    }

    /// Returns the largest `z` that chance explains.
    pub(super) fn critical_z(&self) -> f64 {
        self.critical_z
    }
}
