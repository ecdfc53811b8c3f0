//! `sphvar rotations`: sets of rotations and their measures.

pub(crate) mod measures;
pub(crate) mod sets;

use std::path::PathBuf;

use clap::Args;
use sphvar_samplers::{RotationGroup, RotationPattern, RotationRealizations, RotationSampler};

use self::measures::{MeasuresBody, MeasuresRecord};
use self::sets::WrittenSets;
use crate::counts::{parse_number, parse_realizations};
use crate::draws::rotation_realizations;
use crate::error::CliError;
use crate::files::RotationFormat;
use crate::flags::{CountsArgs, LmaxArgs, NearestArgs, SamplersArgs, lmax_help, missing_count};
use crate::global::Global;
use crate::memory::check_memory;
use crate::patterns::{nearest_sampler, parse_patterns};
use crate::progress::Progress;
use crate::report::{Document, Provenance, number};

/// The degree of the powers without --lmax.
const DEFAULT_LMAX: usize = 4;

/// The largest degree of powers: the matrices of larger ones take minutes for each set.
const MAX_LMAX: usize = 200;

/// The largest concentration for which errors are computed, of functions a degree wide.
const MAX_KAPPA: f64 = 3000.0;

/// Measures whose expected time is longer are announced, in seconds.
const LONG_SECONDS: f64 = 5.0;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar rotations super-fibonacci -n 1000 -o rotations.csv       (quaternions w,x,y,z)
  sphvar rotations healpix-hopf -n 576 --format euler-degrees -o orientations.csv
  sphvar rotations sukharev:weights=cell -n 500 --format matrices -o rotations.json
  sphvar rotations super-fibonacci -n 100 -m 8 --rotate -o replicates.npy
  sphvar rotations uniform,super-fibonacci,sukharev:weights=cell,healpix-hopf -n 72,576 --kappa 2
  sphvar list rotations

Rotations are active: the matrix R takes a vector v of the body to R v in the laboratory. Quaternions q and \
-q are the same rotation. Euler angles are those of R = Rz(alpha) Ry(beta) Rz(gamma), intrinsic z-y'-z'': alpha and beta are \
the longitude and the colatitude of the image of z, gamma is the rotation about z that comes first.

Without -o, the sets are measured. The separation is the least angle between two rotations, the covering radius \
(dispersion) the largest angle from any rotation to the nearest of the set. P(l) is the power of degree l of the \
matrices D^l of SO(3), 1 for independent uniform rotations; all functions of the degrees up to the exact degree have the mean that they \
have over SO(3). Layers of sukharev are complete at 4, 36, 292, 2340, ... rotations, those of healpix-hopf:order=layered \
at 72, 648, 5256, ...; between them errors are larger. Replicates with --rotate have the right mean on average, so their spread is the error. \
--kappa adds the root mean square error of the mean of exp(kappa (cos w - 1)) over a randomly rotated set, relative to its mean over SO(3), \
w the angle of R or of R times a fixed rotation, and the sampler of the least error at each N.";

#[derive(Debug, Args)]
#[command(
    mut_group("SamplersArgs", |samplers| samplers.required(true)),
    mut_arg("positional_samplers", |samplers| {
        samplers.help("Patterns of rotations, separated by commas or blanks: name or name:key=value,key=value (list rotations); all is every one")
    }),
    mut_arg("lmax", |lmax| lmax.help(lmax_help(&DEFAULT_LMAX.to_string())))
)]
pub(crate) struct RotationsArgs {
    #[command(flatten)]
    pub(crate) samplers: SamplersArgs,
    #[command(flatten)]
    pub(crate) counts: CountsArgs,
    #[command(flatten)]
    pub(crate) nearest: NearestArgs,
    /// Number of realizations [default: 1]
    #[arg(short = 'm', long, value_name = "M", default_value = "1", hide_default_value = true, value_parser = parse_realizations)]
    pub(crate) realizations: u64,
    /// Apply an independent uniform random rotation to every realization
    #[arg(long)]
    pub(crate) rotate: bool,
    #[command(flatten)]
    pub(crate) lmax: LmaxArgs,
    /// Concentration of the function whose mean has the error in the column `error`
    #[arg(long, value_name = "KAPPA", value_parser = parse_number, allow_negative_numbers = true)]
    pub(crate) kappa: Option<f64>,
    /// How rotations are written: quaternions, matrices, euler (radians) or euler-degrees
    #[arg(
        long,
        value_enum,
        hide_possible_values = true,
        value_name = "FORMAT",
        default_value = "quaternions",
        requires = "out"
    )]
    pub(crate) format: RotationFormat,
    /// Write the rotations to a file: .csv, .npy, .npz or .json; - is CSV on standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// A pattern at a number of rotations.
pub(crate) struct Case {
    pattern: RotationPattern,
    sampler: Box<dyn RotationSampler>,
}

impl Case {
    /// Returns the ensemble of the realizations.
    fn ensemble(&self, args: &RotationsArgs, global: &Global) -> RotationRealizations<'_> {
        rotation_realizations(&*self.sampler, args.rotate, global.seed)
    }
}

pub(crate) fn run(args: &RotationsArgs, global: &Global) -> Result<(), CliError> {
    if args.realizations == 0 {
        return Err(CliError::Usage("-m must be at least 1, got 0".to_owned()));
    }
    let lmax = args.lmax.lmax.unwrap_or(DEFAULT_LMAX);
    if lmax > MAX_LMAX {
        let message = format!("--lmax must be at most {MAX_LMAX}, got {lmax}");
        return Err(CliError::Usage(message));
    }
    if let Some(kappa) = args.kappa
        && !(0.0..=MAX_KAPPA).contains(&kappa)
    {
        let message = format!("--kappa must be from 0 to {MAX_KAPPA}, got {kappa}");
        return Err(CliError::Usage(message));
    }
    if args.counts.list().is_empty() {
        return Err(missing_count());
    }
    let patterns: Vec<RotationPattern> =
        parse_patterns(&args.samplers.required()?, &global.session)?;
    let mut cases = Vec::new();
    for pattern in patterns {
        for &n in args.counts.list() {
            let nearest = args.nearest.nearest;
            let sampler =
                nearest_sampler(&pattern, Some(n), RotationGroup, nearest, &global.session)?;
            cases.push(Case { pattern: pattern.clone(), sampler });
        }
    }
    for case in &cases {
        let n = case.sampler.n_points();
        let bytes = 32.0 * n as f64 * args.realizations as f64;
        check_memory(&format!("{} sets of {n} rotations", args.realizations), bytes)?;
    }
    let provenance = Provenance::new(&global.session, global.seed);
    if let Some(path) = &args.out {
        let [case] = &cases[..] else {
            let message =
                "-o writes the rotations of one pattern and one N; omit it to compare several";
            return Err(CliError::Usage(message.to_owned()));
        };
        return WrittenSets::realize(case, args, global)?.write(path, &provenance, global);
    }
    let expected = cases.iter().map(|case| measures::expected_seconds(&*case.sampler, args, lmax));
    let expected: f64 = expected.sum();
    if expected > LONG_SECONDS {
        let time = number::seconds(expected);
        global
            .session
            .say(&format!("the measures take about {time}; -o writes the rotations without them"));
    }
    let work = |case: &Case| measures::nominal_work(&*case.sampler, args, lmax);
    let progress = Progress::new(cases.iter().map(work).sum(), &global.session);
    let rows = cases
        .iter()
        .map(|case| MeasuresRecord::new(case, args, lmax, global, &progress))
        .collect::<Result<Vec<_>, _>>()?;
    drop(progress);
    let body = MeasuresBody { rows };
    if global.json {
        return Document::new(&body, &provenance).print(&global.session);
    }
    global.session.print(&body.text())
}
