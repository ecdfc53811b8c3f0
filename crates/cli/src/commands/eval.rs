//! `sphvar eval`: single values of the basic functions.

use clap::{Args, Subcommand};
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_integrands::{Cap, Integrand};
use sphvar_samplers::Domain;
use sphvar_sh::{Colatitude, lambda_scaled, ylm};

use crate::counts::{parse_integer, parse_number, parse_one_count};
use crate::error::CliError;
use crate::flags::CountArgs;
use crate::global::Global;
use crate::memory::{check_degree, check_memory};
use crate::profiles::parse_profile;
use crate::report::{Document, Provenance, csv_rows, full};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar eval legendre --l 20000 --m 100 --theta 1e-3
  sphvar eval ylm --l 4 --m -3 --theta 1.1 --phi 0.2
  sphvar eval cap-power --degrees 60 --lmax 10
  sphvar eval profile --profile poly:b=2,alpha=0.5 -n 1024 --lmax 40";

#[derive(Debug, Args)]
pub(crate) struct EvalArgs {
    #[command(subcommand)]
    function: Function,
}

#[derive(Debug, Subcommand)]
enum Function {
    /// Evaluate the orthonormal associated Legendre function `lambda_lm(theta)`, Condon-Shortley phase
    Legendre {
        /// Degree
        #[arg(long, value_parser = parse_one_count)]
        l: usize,
        /// Order, -l to l
        #[arg(long, allow_negative_numbers = true, value_parser = parse_integer)]
        m: i64,
        /// Colatitude in radians, 0 to pi
        #[arg(long, allow_negative_numbers = true, value_parser = parse_number)]
        theta: f64,
    },
    /// Evaluate the complex orthonormal spherical harmonic `Y_lm(theta, phi)`
    Ylm {
        /// Degree
        #[arg(long, value_parser = parse_one_count)]
        l: usize,
        /// Order, -l to l
        #[arg(long, allow_negative_numbers = true, value_parser = parse_integer)]
        m: i64,
        /// Colatitude in radians, 0 to pi
        #[arg(long, allow_negative_numbers = true, value_parser = parse_number)]
        theta: f64,
        /// Longitude in radians
        #[arg(long, allow_negative_numbers = true, value_parser = parse_number)]
        phi: f64,
    },
    /// Evaluate the energy per degree of a spherical cap
    CapPower {
        /// Angle from the axis to the rim, in (0, 180]
        #[arg(long, value_parser = parse_number)]
        degrees: f64,
        /// Maximum degree, inclusive
        #[arg(long, value_name = "L", value_parser = parse_one_count)]
        lmax: usize,
    },
    /// Evaluate the power per degree of a profile
    #[command(mut_arg("count", |count| count.required(true)))]
    Profile {
        /// Profile: constant, step, linear, quadratic or poly:b=B, each with alpha=, gamma= and offset=
        #[arg(long)]
        profile: String,
        #[command(flatten)]
        count: CountArgs,
        /// Maximum degree, inclusive
        #[arg(long, value_name = "L", value_parser = parse_one_count)]
        lmax: usize,
    },
}

/// A value of the orthonormal associated Legendre function: `eval legendre --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct LegendreBody {
    /// The value; 0 where it is below the range of f64.
    value: f64,
    /// `log10 |value|`, which also tells the size of values below the range of f64; null where the
    /// function is 0.
    log10_abs: Option<f64>,
}

/// A value of the complex orthonormal spherical harmonic: `eval ylm --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct HarmonicBody {
    /// The real part.
    re: f64,
    /// The imaginary part.
    im: f64,
}

/// The energy per degree of a spherical cap: `eval cap-power --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct CapBody {
    /// The degrees from 0.
    l: Vec<usize>,
    /// The energy of each degree.
    energy: Vec<f64>,
    /// The energy of all degrees, also of those that are not listed: the area of the cap.
    total: f64,
}

/// The power per degree of a profile: `eval profile --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ProfileBody {
    /// The degrees from 0.
    l: Vec<usize>,
    /// The power of each degree; white noise has 1.
    power: Vec<f64>,
}

/// The energy of one degree.
#[derive(Serialize, JsonSchema)]
struct DegreeEnergy {
    l: usize,
    energy: f64,
}

/// The power of one degree.
#[derive(Serialize, JsonSchema)]
struct DegreePower {
    l: usize,
    power: f64,
}

pub(crate) fn run(args: &EvalArgs, global: &Global) -> Result<(), CliError> {
    match &args.function {
        &Function::Legendre { l, m, theta } => legendre(l, m, theta, global),
        &Function::Ylm { l, m, theta, phi } => {
            let y = ylm(l, m, theta, phi).map_err(CliError::usage)?;
            let text = format!("{} {}\n", full(y.re), full(y.im));
            output(global, &HarmonicBody { re: y.re, im: y.im }, text)
        }
        &Function::CapPower { degrees, lmax } => {
            check_size("--lmax", lmax)?;
            let cap = Cap::from_degrees(degrees).map_err(CliError::usage)?;
            let energy = cap.energy(Domain::Sphere, lmax)?;
            let values = energy.per_band().to_vec();
            let rows = values.iter().enumerate().map(|(l, &energy)| DegreeEnergy { l, energy });
            let text = csv_rows(&rows.collect::<Vec<_>>())?;
            let l = (0..=lmax).collect();
            output(global, &CapBody { l, energy: values, total: energy.total() }, text)
        }
        Function::Profile { profile, count, lmax } => {
            check_size("--lmax", *lmax)?;
            let profile = parse_profile(profile)?.profile;
            let n = count.required()?;
            if n == 0 {
                return Err(CliError::Usage("-n must be at least 1, got 0".to_owned()));
            }
            let power: Vec<f64> = (0..=*lmax).map(|l| profile.power(l, n)).collect();
            let rows = power.iter().enumerate().map(|(l, &power)| DegreePower { l, power });
            let text = csv_rows(&rows.collect::<Vec<_>>())?;
            output(global, &ProfileBody { l: (0..=*lmax).collect(), power }, text)
        }
    }
}

fn legendre(l: usize, m: i64, theta: f64, global: &Global) -> Result<(), CliError> {
    check_size("--l", l)?;
    if m.unsigned_abs() > l as u64 {
        return Err(CliError::Usage(format!("--m must satisfy |m| <= l, got l = {l}, m = {m}")));
    }
    let colatitude = Colatitude::from_theta(theta).map_err(CliError::usage)?;
    let order = usize::try_from(m.unsigned_abs()).map_err(CliError::usage)?;
    let scaled = lambda_scaled(l, order, colatitude);
    // lambda_{l,-m} = (-1)^m lambda_lm.
    let sign = if m < 0 && order % 2 == 1 { -1.0 } else { 1.0 };
    let value = sign * scaled.value();
    let log10 = scaled.log10_abs();
    let body = LegendreBody { value, log10_abs: log10.is_finite().then_some(log10) };
    output(global, &body, full(value) + "\n")
}

fn check_size(what: &str, l: usize) -> Result<(), CliError> {
    check_degree(what, l)?;
    check_memory(&format!("{what} {l}"), 16.0 * l as f64)
}

fn output(global: &Global, body: &impl Serialize, text: String) -> Result<(), CliError> {
    if global.json {
        Document::new(body, &Provenance::new(&global.session, global.seed)).print(&global.session)
    } else {
        global.session.print(&text)
    }
}
