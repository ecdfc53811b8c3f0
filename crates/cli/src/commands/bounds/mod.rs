//! `sphvar bounds`: variance bounds and convergence rates from spectral profiles.

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_bounds::{Bound, Criterion, Error, Family, Offset, Side};

use self::record::{BoundRecord, Consequences};
use self::source::Measured;
use self::thesis::ThesisRecord;
use crate::counts::{parse_number, parse_one_count, parse_realizations};
use crate::error::CliError;
use crate::flags::{
    CountArgs, DomainArgs, IntegrandArgs, LmaxArgs, NearestArgs, OutArgs, SamplerArgs,
    spectra_lmax_help,
};
use crate::global::Global;
use crate::integrands::parse_integrand;
use crate::plots::Chart;
use crate::profiles::{ParsedProfile, parse_profile};
use crate::report::{Forms, Provenance, check_result, csv_of, emit, number, table_of};

mod chart;
mod record;
mod source;
mod thesis;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar bounds jittered -n 972                                  (fit every family of profiles)
  sphvar bounds poisson-disk -n 1024 --offset fit -o bounds.png   (fitted offset; plot)
  sphvar bounds --spectrum s.csv --integrand cap:degrees=60
  sphvar bounds jittered -n 972 --profile poly:b=2,alpha=0.2,gamma=1
  sphvar bounds --profile poly:b=2,alpha=0.5,gamma=1 -n 1024     (rates and bounds of a profile)

A profile bounds the mean spectrum from above or below: constant, step, linear, quadratic or poly:b=B, \
each with alpha (the start of the plateau, in units of sqrt(N)) and gamma (the level of the plateau). Without --profile the \
tightest profile of each family is fitted: among the profiles outside the joint confidence limits of all degrees, the upper one \
with the minimum and the lower one with the maximum worst-case variance. The plateau is assumed to continue beyond the maximum degree. \
The bounds stated by the thesis are checked. With --profile, alpha and gamma are fitted where omitted; \
a profile with both is checked. With --integrand, the variance of its integral is bounded too.";

#[derive(Debug, Args)]
#[command(
    group(ArgGroup::new("bounded").args(["sampler", "spectrum", "profile"]).required(true).multiple(true)),
    mut_arg("sampler", |sampler| sampler.conflicts_with("spectrum")),
    mut_arg("lmax", |lmax| lmax.help(spectra_lmax_help()))
)]
pub(crate) struct BoundsArgs {
    #[command(flatten)]
    pub(crate) sampler: SamplerArgs,
    /// Spectrum file to bound instead of a sampler (CSV: l,power and, if known, stderr), whose power of degree 0 is N unless -n is given; - is standard input
    #[arg(long, value_name = "FILE")]
    pub(crate) spectrum: Option<PathBuf>,
    /// Profile: constant, step, linear, quadratic or poly:b=B, each with alpha=, gamma= and offset=; without it one of each family is fitted
    #[arg(long)]
    pub(crate) profile: Option<String>,
    #[command(flatten)]
    pub(crate) count: CountArgs,
    #[command(flatten)]
    pub(crate) nearest: NearestArgs,
    #[arg(short = 'm', long, value_name = "M", value_parser = parse_realizations, help = format!(
        "Number of realizations from which the spectrum is estimated [default: {}, none where a closed form is available]",
        source::REALIZATIONS
    ))]
    pub(crate) realizations: Option<u64>,
    #[command(flatten)]
    pub(crate) lmax: LmaxArgs,
    /// Confidence of fits and checks, over all degrees together
    #[arg(long, value_name = "C", default_value_t = 0.99, value_parser = parse_number)]
    pub(crate) confidence: f64,
    /// Offset of the fitted profiles: a power, or fit [default: 0]
    #[arg(long, value_name = "G0|fit", conflicts_with = "profile", allow_hyphen_values = true)]
    pub(crate) offset: Option<String>,
    /// Band limit of the best case, a flat spectrum up to this degree
    #[arg(long, default_value = "10", value_name = "L0", value_parser = parse_one_count)]
    pub(crate) band: usize,
    /// Decay p of the worst case, energy l^-p; 2 for integrands with a jump
    #[arg(long, default_value_t = 2.0, value_name = "P", value_parser = parse_number)]
    pub(crate) decay: f64,
    #[command(flatten)]
    pub(crate) integrand: IntegrandArgs,
    #[command(flatten)]
    pub(crate) domain: DomainArgs,
    #[command(flatten)]
    pub(crate) out: OutArgs,
}

/// A family without a profile that bounds the spectrum.
#[derive(Debug, Serialize, JsonSchema)]
struct Missing {
    /// `upper` or `lower`.
    side: &'static str,
    /// The family of profiles.
    family: &'static str,
    /// The reason why there is none.
    reason: String,
}

/// Variance bounds and convergence rates from spectral profiles: `bounds --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct BoundsBody {
    /// The number of points.
    n: usize,
    /// The effective number of weighted points, `(sum w)^2 / sum w^2`.
    #[serde(skip_serializing_if = "Option::is_none")]
    n_effective: Option<f64>,
    /// `sphere` or `hemisphere`.
    domain: &'static str,
    /// The confidence of fits and checks, over all degrees together.
    confidence: f64,
    /// The largest degree of the spectrum.
    lmax: Option<usize>,
    /// The variance that the spectrum predicts for the integrand, if a sampler and an integrand are
    /// given.
    #[serde(skip_serializing_if = "Option::is_none")]
    predicted: Option<f64>,
    /// The standard error of `predicted`, due to those of the spectrum and of the energies.
    #[serde(skip_serializing_if = "Option::is_none")]
    predicted_stderr: Option<f64>,
    /// The error of `predicted` due to degrees beyond the spectrum.
    #[serde(skip_serializing_if = "Option::is_none")]
    predicted_tail_error: Option<f64>,
    /// The bounds.
    bounds: Vec<BoundRecord>,
    /// Families without a bound.
    none: Vec<Missing>,
    /// The bounds that the thesis gives for the sampler, checked; empty for other samplers and files.
    thesis: Vec<ThesisRecord>,
}

pub(crate) fn run(args: &BoundsArgs, global: &Global) -> Result<(), CliError> {
    let domain = args.domain.domain();
    let parsed = args.profile.as_deref().map(parse_profile).transpose()?;
    let offset = parse_offset(args.offset.as_deref())?;
    if args.count.count == Some(0) {
        return Err(CliError::Usage("-n must be at least 1, got 0".to_owned()));
    }
    if !(args.confidence > 0.0 && args.confidence < 1.0) {
        return Err(CliError::Usage(format!(
            "--confidence must be above 0 and below 1, got {}",
            args.confidence
        )));
    }
    if let Some(path) = &args.out.out {
        check_result(path, true)?;
    }
    let measured = Measured::of_args(args, domain, global)?;
    let n_points = match &measured {
        Some(measured) => measured.n_points,
        None => args.count.required()?,
    };
    let n_effective = measured.as_ref().map_or(n_points as f64, |m| m.n_effective);
    let integrand =
        args.integrand.integrand.as_deref().map(|text| parse_integrand(text, &global.session));
    let integrand = integrand.transpose()?;
    let consequences = Consequences::new(args, integrand.as_ref(), domain, n_points, n_effective)?;
    let predicted = match &integrand {
        Some(integrand) => source::predicted(measured.as_ref(), args, integrand, domain, global)?,
        None => None,
    };
    let (mut records, mut none, mut thesis) = (Vec::new(), Vec::new(), Vec::new());
    match (&measured, &parsed) {
        (Some(measured), Some(parsed)) => {
            for side in [Side::Upper, Side::Lower] {
                records.push(against_spectrum(side, parsed, measured, args, &consequences)?);
            }
        }
        (Some(measured), None) => {
            let criterion = Criterion { confidence: args.confidence, decay: args.decay, offset };
            (records, none) = tightest(measured, criterion, &consequences)?;
            if let Some(name) = measured.sampler {
                let spectrum = measured.spectrum()?;
                thesis = ThesisRecord::of_sampler(name, &spectrum, args.confidence)?;
            }
        }
        (None, Some(parsed)) => {
            records.push(consequences.record(&parsed.profile, "given", "given")?);
        }
        (None, None) => {}
    }
    let provenance = Provenance::new(&global.session, global.seed);
    let body = BoundsBody {
        n: n_points,
        n_effective: (n_effective.to_bits() != (n_points as f64).to_bits()).then_some(n_effective),
        domain: domain.name(),
        confidence: args.confidence,
        lmax: measured.as_ref().map(Measured::lmax),
        predicted: predicted.map(|p| p.variance),
        predicted_stderr: predicted.map(|p| p.stderr),
        predicted_tail_error: predicted.map(|p| p.tail_error),
        bounds: records,
        none,
        thesis,
    };
    let chart = || {
        let label = measured.as_ref().map_or("a profile", |m| &m.label);
        Ok(Chart {
            title: format!("Bounds of {label}, N = {n_points}"),
            ..chart::chart(&body.bounds, measured.as_ref(), n_points)?
        })
    };
    let forms = Forms {
        csv: &|| csv_of(&provenance, &body.bounds),
        chart: Some(&chart),
        text: &|| text(args, &body, parsed.is_none()),
    };
    emit(args.out.out.as_deref(), global, &provenance, &body, &forms)
}

/// Returns the tables for the terminal, with their assumptions.
fn text(args: &BoundsArgs, body: &BoundsBody, fitted: bool) -> String {
    let columns = BoundRecord::columns(fitted, args.integrand.integrand.is_some());
    let mut text = table_of(&columns, &body.bounds);
    for missing in &body.none {
        text += &format!("no {} {}: {}\n", missing.side, missing.family, missing.reason);
    }
    text += &format!(
        "\nN = {}{}. best: band limit {}, power 1. worst: energy l^-{}.\n",
        body.n,
        body.n_effective.map_or(String::new(), |n| format!(", N_eff = {}", number::value(n))),
        args.band,
        args.decay
    );
    if let Some(lmax) = body.lmax {
        text += &format!(
            "Confidence {} for all degrees up to {lmax} together; degrees beyond it were not measured.\n",
            args.confidence
        );
    }
    if let (Some(variance), Some(stderr), Some(tail_error)) =
        (body.predicted, body.predicted_stderr, body.predicted_tail_error)
    {
        let variance = number::with_uncertainty(variance, stderr.hypot(tail_error));
        text += &format!("Predicted variance of the integrand: {variance}.\n");
    }
    if let Some(first) = body.thesis.first() {
        text += &format!("\n{}", table_of(&ThesisRecord::columns(), &body.thesis));
        let critical = number::ratio(first.critical_z());
        text += &format!("A bound is broken where z is above {critical}.\n");
    }
    text
}

fn parse_offset(text: Option<&str>) -> Result<Offset, CliError> {
    match text {
        None => Ok(Offset::Given(0.0)),
        Some("fit") => Ok(Offset::Fitted),
        Some(text) => match text.parse::<f64>() {
            Ok(g) if g >= 0.0 && g.is_finite() => Ok(Offset::Given(g)),
            _ => Err(CliError::Usage(format!(
                "--offset must be \"fit\" or a finite number from 0, got \"{text}\""
            ))),
        },
    }
}

/// Returns the tightest profile of every family on both sides, and the families without one.
fn tightest(
    measured: &Measured,
    criterion: Criterion,
    consequences: &Consequences,
) -> Result<(Vec<BoundRecord>, Vec<Missing>), CliError> {
    let spectrum = measured.spectrum()?;
    let (mut records, mut none) = (Vec::new(), Vec::new());
    for side in [Side::Upper, Side::Lower] {
        for family in Family::ALL {
            match Bound::tightest(side, family, &spectrum, criterion) {
                Ok(fit) => {
                    let verdict = fit
                        .bound
                        .check(&spectrum, criterion.confidence)
                        .map_err(CliError::usage)?;
                    let record = consequences.judged(&fit.bound, "fitted", &verdict)?;
                    records.push(record.with_fit(family, fit.touching, fit.gap));
                }
                Err(
                    error @ (Error::PowerBelowStep { .. }
                    | Error::OnlyZero { .. }
                    | Error::NoFit { .. }
                    | Error::NoDegrees { .. }),
                ) => none.push(Missing {
                    side: side.name(),
                    family: family.name(),
                    reason: error.to_string(),
                }),
                Err(error) => return Err(CliError::usage(error)),
            }
        }
    }
    Ok((records, none))
}

fn against_spectrum(
    side: Side,
    parsed: &ParsedProfile,
    measured: &Measured,
    args: &BoundsArgs,
    consequences: &Consequences,
) -> Result<BoundRecord, CliError> {
    let spectrum = measured.spectrum()?;
    let bound = Bound { side, profile: parsed.profile };
    let (origin, bound) = match (parsed.has_alpha, parsed.has_gamma) {
        (true, true) => ("checked", Ok(bound)),
        (_, false) => ("fitted gamma", bound.fit_gamma(&spectrum, args.confidence)),
        (false, true) => ("fitted alpha", bound.fit_alpha(&spectrum, args.confidence)),
    };
    let bound = bound.map_err(CliError::failed)?;
    let verdict = bound.check(&spectrum, args.confidence).map_err(CliError::usage)?;
    consequences.judged(&bound, origin, &verdict)
}
