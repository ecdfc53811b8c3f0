//! A bound and its consequences, for tables, CSV and JSON.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_bounds::{
    Bound, BoundVerdict, ConvergenceRate, Family, IntegrandClass, Profile, Side, variance_bound,
};
use sphvar_samplers::Domain;
use sphvar_sh::MAX_DEGREE;

use super::BoundsArgs;
use crate::error::CliError;
use crate::integrands::{NamedIntegrand, check_domain};
use crate::report::{Column, number};

/// A profile that bounds the mean spectrum, and what follows from it. A number that cannot be given
/// is null.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct BoundRecord {
    /// `upper`, `lower`, or `given` without a spectrum.
    side: &'static str,
    /// The origin: `given`, `checked`, `fitted gamma`, `fitted alpha`, `fitted`.
    origin: &'static str,
    /// The family: `constant`, `step`, `linear`, `quadratic` or `poly`.
    family: &'static str,
    /// The exponent b; null for a step.
    exponent: Option<f64>,
    /// The break of the profile, a degree divided by `sqrt(N)`.
    alpha: f64,
    /// The power at which it levels off.
    gamma: f64,
    /// The power that is added at all degrees.
    offset: f64,
    /// Whether the spectrum is within the bound; null without a spectrum.
    holds: Option<bool>,
    /// The degree that speaks most against the bound.
    worst_degree: Option<usize>,
    /// Power over bound at `worst_degree`.
    worst_ratio: Option<f64>,
    /// The degrees at which the profile meets the confidence limits, if all of it was fitted.
    touching: Vec<usize>,
    /// The share by which the best profile of the family can be better at most, if all of it was
    /// fitted.
    gap: Option<f64>,
    /// The convergence rate for the best case, a band-limited integrand, as a power of N.
    best_rate: String,
    /// The variance for the best case.
    #[schemars(with = "Option<f64>")]
    best_variance: f64,
    /// The convergence rate for the worst case, energies that fall as l^-p, as a power of N.
    worst_rate: String,
    /// The variance for the worst case.
    #[schemars(with = "Option<f64>")]
    worst_variance: f64,
    /// The range of the variance of the integrand under the profile, from the least to the
    /// greatest; the end on the bound's side is the bound.
    integrand_variance: Option<(f64, f64)>,
    /// That end: the variance of the integrand is at most (upper bounds) or at least (lower bounds)
    /// this.
    integrand_bound: Option<f64>,
    #[serde(skip)]
    #[schemars(skip)]
    pub(super) profile: Profile,
}

/// The integrands for which variances are derived.
pub(super) struct Consequences {
    n_points: usize,
    /// The number of points over the effective one, by which weights multiply variances.
    weighting: f64,
    domain: Domain,
    best: IntegrandClass,
    worst: IntegrandClass,
    /// Energies of the requested integrand, and the energy beyond them.
    energy: Option<(Vec<f64>, f64)>,
}

impl Consequences {
    pub(super) fn new(
        args: &BoundsArgs,
        integrand: Option<&NamedIntegrand<'_>>,
        domain: Domain,
        n_points: usize,
        n_effective: f64,
    ) -> Result<Self, CliError> {
        let energy = match integrand {
            None => None,
            Some(integrand) => {
                check_domain(integrand, domain)?;
                let lmax = integrand
                    .function
                    .band_limit()
                    .or(integrand.function.resolved_degree())
                    .unwrap_or_else(|| (40 * n_points.isqrt()).clamp(64, MAX_DEGREE));
                let energy = integrand.function.energy(domain, lmax)?;
                Some((energy.per_band().to_vec(), energy.beyond(lmax)))
            }
        };
        Ok(Self {
            n_points,
            weighting: n_points as f64 / n_effective,
            domain,
            best: IntegrandClass::band_limited(1.0, args.band).map_err(CliError::usage)?,
            worst: IntegrandClass::power_law(1.0, args.decay).map_err(CliError::usage)?,
            energy,
        })
    }

    pub(super) fn record(
        &self,
        profile: &Profile,
        side: &'static str,
        origin: &'static str,
    ) -> Result<BoundRecord, CliError> {
        let (n, domain) = (self.n_points, self.domain);
        let integrand_variance = match &self.energy {
            None => None,
            Some((energy, tail)) => {
                let range =
                    variance_bound(profile, n, domain, energy, *tail).map_err(CliError::failed)?;
                Some((self.weighting * range.lower, self.weighting * range.upper))
            }
        };
        let exponent = Some(profile.exponent()).filter(|b| b.is_finite());
        Ok(BoundRecord {
            side,
            origin,
            family: profile.family().name(),
            exponent,
            alpha: profile.alpha(),
            gamma: profile.gamma(),
            offset: profile.offset(),
            holds: None,
            worst_degree: None,
            worst_ratio: None,
            touching: Vec::new(),
            gap: None,
            best_rate: rate_text(self.best.rate(profile, domain)),
            worst_rate: rate_text(self.worst.rate(profile, domain)),
            best_variance: self.weighting * self.best.variance(profile, n, domain),
            worst_variance: self.weighting * self.worst.variance(profile, n, domain),
            integrand_variance,
            integrand_bound: integrand_variance
                .map(|(min, max)| if side == Side::Lower.name() { min } else { max }),
            profile: *profile,
        })
    }

    /// Returns the record of a bound together with the result of its check.
    pub(super) fn judged(
        &self,
        bound: &Bound,
        origin: &'static str,
        verdict: &BoundVerdict,
    ) -> Result<BoundRecord, CliError> {
        Ok(BoundRecord {
            holds: Some(verdict.holds),
            worst_degree: Some(verdict.worst_degree),
            worst_ratio: Some(verdict.worst_ratio),
            ..self.record(&bound.profile, bound.side.name(), origin)?
        })
    }
}

impl BoundRecord {
    pub(super) fn with_fit(self, family: Family, touching: Vec<usize>, gap: f64) -> Self {
        Self { family: family.name(), touching, gap: Some(gap), ..self }
    }

    /// Returns the columns of a table. Fits hold by construction, so their table shows the degrees
    /// at which they touch the limits.
    pub(super) fn columns(fitted: bool, integrand: bool) -> Vec<Column<'static, Self>> {
        let mut columns = vec![Column::text("side", |r: &Self| r.side.to_owned())];
        if !fitted {
            columns.push(Column::text("origin", |r: &Self| r.origin.to_owned()));
        }
        columns.extend([
            Column::text("profile", Self::profile_name),
            Column::number("alpha", |r: &Self| {
                number::optional(break_at(r.family, r.alpha), number::value)
            }),
            Column::number("gamma", |r: &Self| number::value(r.gamma)),
            Column::number("offset", |r: &Self| number::value(r.offset)),
        ]);
        if fitted {
            columns.push(Column::text("touches l", |r: &Self| first_degrees(&r.touching)));
        } else {
            columns.extend([
                Column::text("holds", |r: &Self| {
                    number::optional(r.holds, |holds| if holds { "yes" } else { "no" }.to_owned())
                }),
                Column::number("worst l", |r: &Self| {
                    number::optional(r.worst_degree, |l| l.to_string())
                }),
                Column::number("ratio", |r: &Self| number::optional(r.worst_ratio, number::ratio)),
            ]);
        }
        columns.extend([
            Column::text("best rate", |r: &Self| r.best_rate.clone()),
            Column::number("variance", |r: &Self| number::value(r.best_variance)),
            Column::text("worst rate", |r: &Self| r.worst_rate.clone()),
            Column::number("variance", |r: &Self| number::value(r.worst_variance)),
        ]);
        if integrand {
            columns.push(Column::number("integrand's", |r: &Self| {
                number::optional(r.integrand_bound, number::value)
            }));
        }
        columns
    }

    /// Returns the name of the profile, with the exponent where the name does not include it.
    pub(super) fn profile_name(&self) -> String {
        match self.exponent {
            Some(b) if self.family == "poly" => format!("poly b={}", number::value(b)),
            _ => self.family.to_owned(),
        }
    }

    pub(super) fn side(&self) -> &'static str {
        self.side
    }

    pub(super) fn family(&self) -> &'static str {
        self.family
    }
}

/// Returns the frequency at which a profile levels off, or `None` for a constant.
pub(super) fn break_at(family: &str, alpha: f64) -> Option<f64> {
    (family != "constant").then_some(alpha)
}

/// Returns degrees separated by spaces.
fn degrees(list: &[usize]) -> String {
    list.iter().map(usize::to_string).collect::<Vec<_>>().join(" ")
}

/// Returns the first degrees of a long list and their number: a flat spectrum touches at many.
fn first_degrees(list: &[usize]) -> String {
    const SHOWN: usize = 4;
    if list.len() <= SHOWN {
        return degrees(list);
    }
    format!("{} ... ({} in all)", degrees(&list[..SHOWN]), list.len())
}

/// Returns a rate with the digits that a fitted exponent has.
fn rate_text(rate: ConvergenceRate) -> String {
    match rate {
        ConvergenceRate::Algebraic { exponent, log } => {
            ConvergenceRate::Algebraic { exponent: (exponent * 1e3).round() / 1e3, log }.to_string()
        }
        // A whole number exceeds this one exactly if it exceeds its integer part.
        ConvergenceRate::Zero { beyond } => {
            ConvergenceRate::Zero { beyond: beyond.floor() }.to_string()
        }
    }
}
