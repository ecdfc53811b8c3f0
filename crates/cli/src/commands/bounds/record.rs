//! A bound and what it implies, for tables, CSV and JSON.

use serde::Serialize;
use sphvar_bounds::{Bound, BoundVerdict, Family, IntegrandClass, Profile, Rate, variance_bound};
use sphvar_samplers::Domain;
use sphvar_sh::MAX_DEGREE;

use super::BoundsArgs;
use crate::error::CliError;
use crate::integrands::{NamedIntegrand, check_domain};
use crate::report::full;

/// A bound and what it implies, as scripts see it.
#[derive(Debug, Serialize)]
pub(super) struct BoundRecord {
    /// `upper`, `lower`, or `given` without a spectrum.
    side: &'static str,
    /// How it came about: `given`, `checked`, `fitted gamma`, `fitted alpha`, `fitted`.
    origin: &'static str,
    family: &'static str,
    /// The exponent b; null for a step.
    exponent: Option<f64>,
    alpha: f64,
    gamma: f64,
    offset: f64,
    /// Whether the spectrum is within the bound; null without a spectrum.
    holds: Option<bool>,
    worst_degree: Option<usize>,
    worst_ratio: Option<f64>,
    /// Where the profile meets the confidence limits, if all of it was fitted.
    touching: Vec<usize>,
    /// How much better the best of the family can be at most, if all of it was fitted.
    gap: Option<f64>,
    best_rate: String,
    worst_rate: String,
    best_variance: f64,
    worst_variance: f64,
    /// The variance of the integrand asked for lies on the bound's side of this range.
    integrand_variance: Option<(f64, f64)>,
    #[serde(skip)]
    pub(super) profile: Profile,
}

/// What the variance of integrands is to be derived for.
pub(super) struct Consequences {
    n_points: usize,
    domain: Domain,
    best: IntegrandClass,
    worst: IntegrandClass,
    /// Energies of the integrand asked for, and what lies beyond them.
    energy: Option<(Vec<f64>, f64)>,
}

impl Consequences {
    pub(super) fn new(
        args: &BoundsArgs,
        integrand: Option<&NamedIntegrand>,
        domain: Domain,
        n_points: usize,
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
                Some((range.lower, range.upper))
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
            best_variance: self.best.variance(profile, n, domain),
            worst_variance: self.worst.variance(profile, n, domain),
            integrand_variance,
            profile: *profile,
        })
    }

    /// A bound of a spectrum with what a check of it says.
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

    /// The heading of [`Self::cells`].
    pub(super) const COLUMNS: &'static str = "side,origin,family,exponent,alpha,gamma,offset,holds,\
         worst_degree,worst_ratio,touching,gap,best_rate,best_variance,worst_rate,worst_variance,\
         integrand_variance";

    /// The row of a CSV file.
    pub(super) fn cells(&self) -> Vec<String> {
        let optional = |x: Option<String>| x.unwrap_or_default();
        vec![
            self.side.to_owned(),
            self.origin.to_owned(),
            self.family.to_owned(),
            optional(self.exponent.map(full)),
            full(self.alpha),
            full(self.gamma),
            full(self.offset),
            optional(self.holds.map(|h| yes(h).to_owned())),
            optional(self.worst_degree.map(|l| l.to_string())),
            optional(self.worst_ratio.map(full)),
            degrees(&self.touching),
            optional(self.gap.map(full)),
            self.best_rate.clone(),
            full(self.best_variance),
            self.worst_rate.clone(),
            full(self.worst_variance),
            optional(self.on_side().map(full)),
        ]
    }

    /// The heading of [`Self::row`]: fits hold by construction, so that these columns say where they touch.
    pub(super) fn heading(fitted: bool, integrand: bool) -> Vec<&'static str> {
        let mut heading = vec!["side"];
        if !fitted {
            heading.push("origin");
        }
        heading.extend(["profile", "alpha", "gamma", "offset"]);
        heading.extend(if fitted { &["touches l"][..] } else { &["holds", "worst l", "ratio"] });
        heading.extend(["best rate", "variance", "worst rate", "variance"]);
        if integrand {
            heading.push("integrand's");
        }
        heading
    }

    /// The row of a table for people.
    pub(super) fn row(&self, fitted: bool) -> Vec<String> {
        let optional = |x: Option<String>| x.unwrap_or_else(|| "-".to_owned());
        let mut row = vec![self.side.to_owned()];
        if !fitted {
            row.push(self.origin.to_owned());
        }
        let break_at =
            if self.family == "constant" { "-".to_owned() } else { readable(self.alpha) };
        row.extend([self.profile_name(), break_at, readable(self.gamma), readable(self.offset)]);
        if fitted {
            row.push(first_degrees(&self.touching));
        } else {
            row.push(optional(self.holds.map(|h| yes(h).to_owned())));
            row.push(optional(self.worst_degree.map(|l| l.to_string())));
            row.push(optional(self.worst_ratio.map(readable)));
        }
        row.extend([
            self.best_rate.clone(),
            readable(self.best_variance),
            self.worst_rate.clone(),
            readable(self.worst_variance),
        ]);
        row.extend(self.on_side().map(readable));
        row
    }

    /// The name of the profile, with the exponent where the name does not say it.
    pub(super) fn profile_name(&self) -> String {
        match self.exponent {
            Some(b) if self.family == "poly" => format!("poly b={}", readable(b)),
            _ => self.family.to_owned(),
        }
    }

    pub(super) fn side(&self) -> &'static str {
        self.side
    }

    pub(super) fn family(&self) -> &'static str {
        self.family
    }

    /// The end of the integrand's range that the bound vouches for.
    fn on_side(&self) -> Option<f64> {
        self.integrand_variance.map(|(least, most)| if self.side == "lower" { least } else { most })
    }
}

fn yes(holds: bool) -> &'static str {
    if holds { "yes" } else { "no" }
}

/// Degrees divided by blanks, which CSV need not quote.
fn degrees(list: &[usize]) -> String {
    list.iter().map(usize::to_string).collect::<Vec<_>>().join(" ")
}

/// Returns the first degrees of a long list, and how many there are: a flat spectrum touches at many.
fn first_degrees(list: &[usize]) -> String {
    const SHOWN: usize = 4;
    if list.len() <= SHOWN {
        return degrees(list);
    }
    format!("{} ... ({} in all)", degrees(&list[..SHOWN]), list.len())
}

/// A rate with the digits that a fitted exponent has.
fn rate_text(rate: Rate) -> String {
    match rate {
        Rate::Algebraic { exponent, log } => {
            Rate::Algebraic { exponent: (exponent * 1e3).round() / 1e3, log }.to_string()
        }
        // A whole number lies beyond this one exactly if it lies beyond its whole part.
        Rate::Zero { beyond } => Rate::Zero { beyond: beyond.floor() }.to_string(),
    }
}

/// A number with four digits, without a power of ten where it can be read without one.
pub(super) fn readable(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if !x.is_finite() {
        return "-".to_owned();
    }
    match x.abs() {
        size if (1e-3..1.0).contains(&size) => format!("{x:.4}"),
        size if (1.0..1e4).contains(&size) => format!("{x:.3}"),
        _ => format!("{x:.3e}"),
    }
}
