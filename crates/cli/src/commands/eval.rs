//! `sphvar eval`: single values of the functions that everything is made of.

use clap::{Args, Subcommand};
use serde::Serialize;
use sphvar_integrands::{Cap, Integrand};
use sphvar_samplers::Domain;
use sphvar_sh::{Colatitude, lambda_scaled, ylm};

use crate::counts::parse_count;
use crate::error::CliError;
use crate::global::Global;
use crate::memory::{check_degree, check_memory};
use crate::profiles::parse_profile;
use crate::report::{print, print_json};

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
    /// The orthonormal associated Legendre function `lambda_lm(theta)`, Condon-Shortley phase
    Legendre {
        /// Degree
        #[arg(long)]
        l: usize,
        /// Order, -l to l
        #[arg(long, allow_negative_numbers = true)]
        m: i64,
        /// Colatitude in radians, 0 to pi
        #[arg(long, allow_negative_numbers = true)]
        theta: f64,
    },
    /// The complex orthonormal spherical harmonic `Y_lm(theta, phi)`
    Ylm {
        /// Degree
        #[arg(long)]
        l: usize,
        /// Order, -l to l
        #[arg(long, allow_negative_numbers = true)]
        m: i64,
        /// Colatitude in radians, 0 to pi
        #[arg(long, allow_negative_numbers = true)]
        theta: f64,
        /// Longitude in radians
        #[arg(long, allow_negative_numbers = true)]
        phi: f64,
    },
    /// The energy per degree of a spherical cap
    CapPower {
        /// Angle from the axis to the rim, in (0, 180]
        #[arg(long)]
        degrees: f64,
        /// Largest degree
        #[arg(long)]
        lmax: usize,
    },
    /// The power per degree of a profile
    Profile {
        /// constant | step | linear | quadratic | poly:b=B, each with alpha=, gamma=
        #[arg(long)]
        profile: String,
        /// Number of points
        #[arg(short = 'n', long = "points", value_name = "N", value_parser = parse_count)]
        points: usize,
        /// Largest degree
        #[arg(long)]
        lmax: usize,
    },
}

#[derive(Debug, Serialize)]
struct Value {
    value: f64,
    /// `log10 |value|`, which tells more where the value is below the range of f64.
    log10_abs: Option<f64>,
}

#[derive(Debug, Serialize)]
struct ComplexValue {
    re: f64,
    im: f64,
}

#[derive(Debug, Serialize)]
struct Energies {
    l: Vec<usize>,
    energy: Vec<f64>,
    total: f64,
}

#[derive(Debug, Serialize)]
struct Powers {
    l: Vec<usize>,
    power: Vec<f64>,
}

pub(crate) fn run(args: &EvalArgs, global: &Global) -> Result<(), CliError> {
    match &args.function {
        &Function::Legendre { l, m, theta } => legendre(l, m, theta, global),
        &Function::Ylm { l, m, theta, phi } => {
            let y = ylm(l, m, theta, phi).map_err(CliError::usage)?;
            let text = format!("{:e} {:e}\n", y.re, y.im);
            output(global, &ComplexValue { re: y.re, im: y.im }, &text)
        }
        &Function::CapPower { degrees, lmax } => {
            check_size("--lmax", lmax)?;
            let cap = Cap::from_degrees(degrees).map_err(CliError::usage)?;
            let energy = cap.energy(Domain::Sphere, lmax)?;
            let values = energy.per_band().to_vec();
            let text = listing("l,energy", &values);
            let l = (0..=lmax).collect();
            output(global, &Energies { l, energy: values, total: energy.total() }, &text)
        }
        Function::Profile { profile, points, lmax } => {
            check_size("--lmax", *lmax)?;
            let profile = parse_profile(profile)?.profile;
            if *points == 0 {
                return Err(CliError::Usage("-n must be at least 1, got 0".to_owned()));
            }
            let power: Vec<f64> = (0..=*lmax).map(|l| profile.power(l, *points)).collect();
            let text = listing("l,power", &power);
            output(global, &Powers { l: (0..=*lmax).collect(), power }, &text)
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
    let document = Value { value, log10_abs: log10.is_finite().then_some(log10) };
    output(global, &document, &format!("{value:e}\n"))
}

fn check_size(what: &str, l: usize) -> Result<(), CliError> {
    check_degree(what, l)?;
    check_memory(&format!("{what} {l}"), 16.0 * l as f64)
}

fn listing(heading: &str, values: &[f64]) -> String {
    values
        .iter()
        .enumerate()
        .fold(format!("{heading}\n"), |text, (l, x)| text + &format!("{l},{x:e}\n"))
}

fn output(global: &Global, document: &impl Serialize, text: &str) -> Result<(), CliError> {
    if global.json { print_json(document) } else { print(text) }
}
