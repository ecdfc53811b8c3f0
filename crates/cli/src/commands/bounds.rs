//! `sphvar bounds`: variance bounds and convergence rates from spectral profiles.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use sphvar_bounds::{Bound, IntegrandClass, MeasuredSpectrum, Profile, Side, variance_bound};
use sphvar_samplers::{Domain, Purpose, Realizations, Streams};
use sphvar_sh::MAX_DEGREE;
use sphvar_spectrum::{Resolution, estimate};

use crate::error::CliError;
use crate::files::read_spectrum;
use crate::global::Global;
use crate::integrands::{FORMS, check_domain, parse_integrand};
use crate::memory::{check_degree, check_transform};
use crate::patterns;
use crate::profiles::{ParsedProfile, parse_profile};
use crate::progress::Progress;
use crate::report::{
    Provenance, check_result, csv, full, is_stdout, print, print_json, short, table, write_result,
};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar bounds --profile poly:b=2,alpha=0.5,gamma=1 -n 1024     (rates and bounds of a profile)
  sphvar bounds jittered -n 972 --profile poly:b=2               (fit it to a sampler's spectrum)
  sphvar bounds jittered -n 972 --profile poly:b=2,alpha=0.2,gamma=1 --integrand cap:degrees=60

A profile bounds the mean spectrum from above or below: constant, step, linear, quadratic or poly:b=B,
each with alpha (where it levels off, in units of sqrt(N)) and gamma (its level). With a sampler or a
spectrum file, what is left out of alpha and gamma is fitted, and what is given in full is checked, for
all degrees together at the stated confidence.";

#[derive(Debug, Args)]
pub(crate) struct BoundsArgs {
    /// The sampler whose spectrum is to be bounded
    #[arg(conflicts_with = "spectrum")]
    pub(crate) sampler: Option<String>,
    /// A spectrum file (CSV: l,power and, if it is known, stderr) to be bounded; - is standard input
    #[arg(long, value_name = "FILE")]
    pub(crate) spectrum: Option<PathBuf>,
    /// The profile
    #[arg(long)]
    pub(crate) profile: String,
    /// Number of points
    #[arg(short = 'n', long = "points", value_name = "N")]
    pub(crate) points: usize,
    /// Realizations of the sampler
    #[arg(short = 'm', long, default_value_t = 300, value_name = "M")]
    pub(crate) realizations: u64,
    /// Largest degree of the spectrum [default: 4 sqrt(N)]
    #[arg(long)]
    pub(crate) lmax: Option<usize>,
    /// Confidence of fits and checks, over all degrees together
    #[arg(long, default_value_t = 0.99)]
    pub(crate) confidence: f64,
    /// Band limit of the best case, a flat spectrum up to this degree
    #[arg(long, default_value_t = 10, value_name = "L0")]
    pub(crate) band: usize,
    /// Decay p of the worst case, energy l^-p; 2 for integrands with a jump
    #[arg(long, default_value_t = 2.0, value_name = "P")]
    pub(crate) decay: f64,
    #[arg(long, help = format!("Bound the variance of this integrand too: {FORMS}"))]
    pub(crate) integrand: Option<String>,
    /// The hemisphere z >= 0
    #[arg(long)]
    pub(crate) hemisphere: bool,
    /// Take the nearest number of points that the pattern has
    #[arg(long)]
    pub(crate) nearest: bool,
    /// Write the bounds to a file, .csv or .json
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// A bound and what it implies, as scripts see it.
#[derive(Debug, Serialize)]
struct BoundRecord {
    /// `upper`, `lower`, or `given` without a spectrum.
    side: &'static str,
    /// How it came about: `given`, `checked`, `fitted gamma`, `fitted alpha`.
    origin: &'static str,
    alpha: f64,
    gamma: f64,
    offset: f64,
    /// Whether the spectrum is within the bound; null without a spectrum.
    holds: Option<bool>,
    worst_degree: Option<usize>,
    worst_ratio: Option<f64>,
    best_rate: String,
    worst_rate: String,
    best_variance: f64,
    worst_variance: f64,
    /// The variance of the integrand asked for lies on the bound's side of this range.
    integrand_variance: Option<(f64, f64)>,
}

/// The document of `--json`.
#[derive(Debug, Serialize)]
struct Document<'a> {
    n: usize,
    domain: &'static str,
    confidence: f64,
    bounds: &'a [BoundRecord],
    provenance: &'a Provenance,
}

/// A mean spectrum, index l.
struct Measured {
    n_points: usize,
    power: Vec<f64>,
    stderr: Vec<f64>,
}

pub(crate) fn run(args: &BoundsArgs, global: &Global) -> Result<(), CliError> {
    let domain = super::domain(args.hemisphere);
    let parsed = parse_profile(&args.profile)?;
    if args.points == 0 {
        return Err(CliError::Usage("-n must be at least 1, got 0".to_owned()));
    }
    if !(args.confidence > 0.0 && args.confidence < 1.0) {
        return Err(CliError::Usage(format!(
            "--confidence must be above 0 and below 1, got {}",
            args.confidence
        )));
    }
    if let Some(path) = &args.out {
        check_result(path, false)?;
    }
    let measured = measured(args, domain, global)?;
    let n_points = measured.as_ref().map_or(args.points, |m| m.n_points);
    let consequences = Consequences::new(args, domain, n_points)?;
    let records = match &measured {
        None => vec![consequences.record(&parsed.profile, "given", "given")?],
        Some(measured) => [Side::Upper, Side::Lower]
            .into_iter()
            .map(|side| {
                against_spectrum(side, &parsed, measured, domain, args.confidence, &consequences)
            })
            .collect::<Result<_, _>>()?,
    };
    let provenance = Provenance::new(global.seed);
    let document = Document {
        n: n_points,
        domain: domain.name(),
        confidence: args.confidence,
        bounds: &records,
        provenance: &provenance,
    };
    if let Some(path) = &args.out
        && !(global.json && is_stdout(path))
    {
        let cells: Vec<_> = records.iter().map(|r| r.cells(&full)).collect();
        let heading = HEADING.join(",").replace(' ', "_");
        write_result(path, &document, &|| csv(&provenance, &heading, &cells))?;
    }
    if global.json {
        return print_json(&document);
    }
    if args.out.is_some() {
        return Ok(());
    }
    let cells = records.iter().map(|r| r.cells(&short)).collect();
    print(&table(&HEADING, cells, 2))?;
    print(&format!(
        "\nN = {n_points}. best: band limit {}, power 1. worst: energy l^-{}.\n",
        args.band, args.decay
    ))
}

fn measured(
    args: &BoundsArgs,
    domain: Domain,
    global: &Global,
) -> Result<Option<Measured>, CliError> {
    if let Some(path) = &args.spectrum {
        return from_file(path, args.points).map(Some);
    }
    let Some(name) = &args.sampler else {
        return Ok(None);
    };
    let pattern = patterns::parse_pattern(name)?;
    let sampler = patterns::build(&pattern, args.points, domain, args.nearest)?;
    let n_points = sampler.n_points();
    let lmax = args.lmax.unwrap_or_else(|| Resolution::natural_degree(n_points));
    check_degree("--lmax", lmax)?;
    check_transform(Resolution::new(lmax, n_points), args.realizations)?;
    if sampler.is_random() && args.realizations == 1 {
        let message = "-m must be at least 2 for an error of the spectrum, got 1";
        return Err(CliError::Usage(message.to_owned()));
    }
    let group = pattern.stream_group(n_points);
    let ensemble =
        Realizations::rotated(&*sampler, Streams::new(global.seed, Purpose::Pattern, group));
    let progress = Progress::new(args.realizations as f64, global.quiet);
    progress.stage(&pattern.to_string());
    let spectrum = estimate(&ensemble, lmax, args.realizations, &|| progress.advance(1.0))?;
    Ok(Some(Measured {
        n_points,
        power: spectrum.power().to_vec(),
        stderr: spectrum.stderr().to_vec(),
    }))
}

fn from_file(path: &Path, n_points: usize) -> Result<Measured, CliError> {
    let rows = read_spectrum(path)?;
    let lmax = rows.iter().map(|r| r.l).max().unwrap_or(0);
    let (mut power, mut stderr) = (vec![f64::NAN; lmax + 1], vec![0.0; lmax + 1]);
    for row in rows {
        power[row.l] = row.power;
        stderr[row.l] = row.stderr;
    }
    // P(0) = N holds for every set and is often left out.
    power[0] = n_points as f64;
    Ok(Measured { n_points, power, stderr })
}

fn against_spectrum(
    side: Side,
    parsed: &ParsedProfile,
    measured: &Measured,
    domain: Domain,
    confidence: f64,
    consequences: &Consequences,
) -> Result<BoundRecord, CliError> {
    let spectrum =
        MeasuredSpectrum::new(measured.n_points, domain, &measured.power, &measured.stderr)
            .map_err(CliError::failed)?;
    let wish = Bound { side, profile: parsed.profile };
    let (origin, bound) = match (parsed.has_alpha, parsed.has_gamma) {
        (true, true) => ("checked", Ok(wish)),
        (_, false) => ("fitted gamma", wish.fit_gamma(&spectrum, confidence)),
        (false, true) => ("fitted alpha", wish.fit_alpha(&spectrum, confidence)),
    };
    let bound = bound.map_err(CliError::failed)?;
    let verdict = bound.check(&spectrum, confidence).map_err(CliError::usage)?;
    let name = match side {
        Side::Upper => "upper",
        Side::Lower => "lower",
    };
    let record = consequences.record(&bound.profile, name, origin)?;
    Ok(BoundRecord {
        holds: Some(verdict.holds),
        worst_degree: Some(verdict.worst_degree),
        worst_ratio: Some(verdict.worst_ratio),
        ..record
    })
}

/// What the variance of integrands is to be derived for.
struct Consequences {
    n_points: usize,
    domain: Domain,
    best: IntegrandClass,
    worst: IntegrandClass,
    /// Energies of the integrand asked for, and what lies beyond them.
    energy: Option<(Vec<f64>, f64)>,
}

impl Consequences {
    fn new(args: &BoundsArgs, domain: Domain, n_points: usize) -> Result<Self, CliError> {
        let energy = match &args.integrand {
            None => None,
            Some(text) => {
                let integrand = parse_integrand(text)?;
                check_domain(&integrand, domain)?;
                let lmax = integrand
                    .function
                    .band_limit()
                    .or(integrand.function.resolved_degree())
                    .unwrap_or_else(|| (40 * n_points.isqrt()).clamp(64, MAX_DEGREE));
                let energy = integrand.function.energy(domain, lmax)?;
                Some((energy.per_degree().to_vec(), energy.beyond(lmax)))
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

    fn record(
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
        Ok(BoundRecord {
            side,
            origin,
            alpha: profile.alpha(),
            gamma: profile.gamma(),
            offset: profile.offset(),
            holds: None,
            worst_degree: None,
            worst_ratio: None,
            best_rate: self.best.rate(profile, domain).to_string(),
            worst_rate: self.worst.rate(profile, domain).to_string(),
            best_variance: self.best.variance(profile, n, domain),
            worst_variance: self.worst.variance(profile, n, domain),
            integrand_variance,
        })
    }
}

const HEADING: [&str; 13] = [
    "side",
    "origin",
    "alpha",
    "gamma",
    "offset",
    "holds",
    "worst l",
    "ratio",
    "best rate",
    "best variance",
    "worst rate",
    "worst variance",
    "integrand variance",
];

impl BoundRecord {
    fn cells(&self, number: &dyn Fn(f64) -> String) -> Vec<String> {
        let optional = |x: Option<String>| x.unwrap_or_else(|| "-".to_owned());
        vec![
            self.side.to_owned(),
            self.origin.to_owned(),
            number(self.alpha),
            number(self.gamma),
            number(self.offset),
            optional(self.holds.map(|h| if h { "yes" } else { "no" }.to_owned())),
            optional(self.worst_degree.map(|l| l.to_string())),
            optional(self.worst_ratio.map(number)),
            self.best_rate.clone(),
            number(self.best_variance),
            self.worst_rate.clone(),
            number(self.worst_variance),
            optional(self.integrand_variance.map(|(a, b)| match self.side {
                "lower" => number(a),
                _ => number(b),
            })),
        ]
    }
}
