//! `sphvar fit`: least-squares fits of spherical harmonics to values at points of a file.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::Resettable;
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_sh::Alm;
use sphvar_spectrum::{Fit, FitError, FittedEnergy, Method};

use super::sets_args::PointFileArgs;
use crate::counts::{parse_number, parse_one_count};
use crate::error::CliError;
use crate::files::{AtomicFile, CoefficientFormat, write_coefficients};
use crate::flags::DomainArgs;
use crate::global::Global;
use crate::memory::check_degree;
use crate::progress::Progress;
use crate::report::{
    Column, Document, Forms, Provenance, check_result, csv_of, emit, number, table_of,
};
use crate::values::Values;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar fit data/stars.csv --columns ra=ra,dec=dec,value=magnitude --lmax 8
  sphvar fit data/stars.csv --columns ra,dec,value --lmax 8 -o alm.npy
  sphvar fit data/stars.csv --columns ra,dec,value --lmax 20 --skip-invalid --json

Coefficients F_lm of the sum over Y_lm that minimize sum w (y - f(x))^2 + R sum |F_lm|^2 are found by conjugate \
gradients. The points need a column value; w are weights, inverse variances up to a common factor, and \
sigma standard errors of the values (w = 1/sigma^2). The residuals give the variance of the noise. The energy of \
a degree is sum_m |F_lm|^2 minus the expected energy of the noise; its standard error is stated. Parts of the function of \
degrees above L are treated as noise. Degree L needs at least (L+1)^2 distinct points, (L+1)(L+2)/2 on the hemisphere, and no \
large gaps between them; a ridge R > 0 shrinks coefficients that the points do not determine, and biases energies \
towards 0. \
-o alm.npy or alm.fits writes the coefficients in the order of healpy, .csv the energies; `values:FILE,lmax=L` is \
the fit as an integrand.";

#[derive(Debug, Args)]
#[command(
    mut_arg("points_from", |arg| {
        arg.long(Resettable::Reset).required(true).help(VALUES_HELP)
    }),
    mut_arg("columns", |arg| arg.conflicts_with(Resettable::Reset).help(COLUMNS_HELP)),
    mut_arg("hdu", |arg| arg.conflicts_with(Resettable::Reset)),
    mut_arg("join", |arg| arg.conflicts_with(Resettable::Reset)),
    mut_arg("skip_invalid", |arg| arg.conflicts_with(Resettable::Reset)),
    mut_arg("normalize", |arg| arg.conflicts_with(Resettable::Reset))
)]
pub(crate) struct FitArgs {
    #[command(flatten)]
    pub(crate) files: PointFileArgs,
    /// Maximum degree, that of the fit
    #[arg(long, value_name = "L", value_parser = parse_one_count)]
    pub(crate) lmax: usize,
    /// Factor of the sum of squared coefficients in the minimized sum; the mean eigenvalue of the normal equations is sum w/(4 pi)
    #[arg(long, value_name = "R", value_parser = parse_number, default_value = "0", allow_negative_numbers = true)]
    pub(crate) ridge: f64,
    #[command(flatten)]
    pub(crate) domain: DomainArgs,
    /// Write the results to a file: coefficients as .npy or .fits, energies as .csv, all numbers as .json
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

const VALUES_HELP: &str = "File of points with values: CSV or other text, .npy of shape (N, 4) (x,y,z,value) or (N, 5) (and w), .npz with points, \
values and possibly weights or sigma, .ply, a FITS table, each possibly gzipped; - is standard input. Several files are \
joined with --join";
const COLUMNS_HELP: &str = "Columns of point files: roles by position, as in ra,dec,_,value (_ skips a column), or by name, as in \
ra=RAJ2000,dec=DEJ2000,value=FLUX. Roles: value; w (weight) or sigma (standard error of the value); x,y,z; theta,phi (radians); \
lon,lat or ra,dec or glon,glat or l,b (degrees)";

/// A least-squares fit to values at points: `fit --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct FitBody {
    /// The names of the files.
    points: String,
    /// The number of points.
    n: usize,
    /// The number of distinct points of positive weight; on the hemisphere antipodes are the same point.
    n_distinct: usize,
    /// The maximum degree.
    lmax: usize,
    /// The ridge.
    ridge: f64,
    /// The root mean square of the residuals, weighted by w.
    residual_rms: f64,
    /// The variance of the noise of a value of weight 1, the reduced chi-square with `sigma`; null without degrees of
    /// freedom.
    noise_variance: Option<f64>,
    /// The number of points of positive weight minus that of coefficients, and what a ridge adds.
    degrees_of_freedom: f64,
    /// The estimated condition number of the least-squares problem.
    condition: f64,
    /// The number of iterations of conjugate gradients.
    iterations: usize,
    /// The energy of each degree.
    energies: Vec<EnergyRow>,
}

/// The energy of a degree.
#[derive(Debug, Serialize, JsonSchema)]
struct EnergyRow {
    /// The degree.
    l: usize,
    /// `sum_m |F_lm|^2` without the energy of the noise; may be negative; null if the noise is unknown.
    energy: Option<f64>,
    /// The standard error of `energy`.
    stderr: Option<f64>,
    /// `sum_m |F_lm|^2` of the fitted coefficients.
    fitted: f64,
    /// The mean energy of the noise.
    noise: Option<f64>,
}

pub(crate) fn run(args: &FitArgs, global: &Global) -> Result<(), CliError> {
    let coefficients = args.out.as_deref().and_then(CoefficientFormat::of_path);
    if let Some(path) = &args.out {
        check_out(path, coefficients)?;
    }
    let (body, alm) = compute(args, global)?;
    let provenance = Provenance::new(&global.session, global.seed);
    if let (Some(format), Some(path)) = (coefficients, &args.out) {
        write_coefficients(path, format, &alm)?;
        return if global.json {
            Document::new(&body, &provenance).print(&global.session)
        } else {
            global.session.print(&body.text())
        };
    }
    let csv = || csv_of(&provenance, &body.energies);
    let forms = Forms { csv: &csv, chart: None, text: &|| body.text() };
    emit(args.out.as_deref(), global, &provenance, &body, &forms)
}

/// Computes the fit that the arguments describe. Returns its document and its coefficients.
pub(crate) fn compute(args: &FitArgs, global: &Global) -> Result<(FitBody, Alm), CliError> {
    check_degree("--lmax", args.lmax)?;
    let domain = args.domain.domain();
    let sources = &args.files.files;
    if sources.len() > 1 && !args.files.join {
        let expected = "one file of values; --join joins several into one set";
        return Err(CliError::Usage(format!("{expected}, got {}", sources.len())));
    }
    let values = Values::read(sources, &args.files.options(), domain, &global.session)?;
    values.remarks.iter().for_each(|remark| global.session.say(remark));
    let name = values.name();
    let error = |error: FitError| match error {
        FitError::TooFewPoints { .. } | FitError::Ridge { .. } => {
            CliError::Usage(format!("{name}: {error}"))
        }
        _ => CliError::Failed(format!("{name}: {error}")),
    };
    let problem = values.problem(domain, args.ridge).map_err(error)?;
    /// The number of iterations of a typical fit, for the progress bar.
    const TYPICAL_ITERATIONS: f64 = 100.0;
    let work = 2.0 * Method::Fast.nominal_work(0, 2 * args.lmax);
    let progress = Progress::new(TYPICAL_ITERATIONS * work, &global.session);
    progress.stage("fit");
    let mut watch = || match progress.advance(work) {
        Ok(()) => ControlFlow::Continue(()),
        Err(_) => ControlFlow::Break(()),
    };
    let fit = problem.solve(args.lmax, &mut watch).map_err(error)?;
    drop(progress);
    let body = FitBody::new(&values, problem.n_distinct(), args, &fit);
    Ok((body, fit.alm))
}

/// Rejects the path of results before the work starts.
fn check_out(path: &Path, coefficients: Option<CoefficientFormat>) -> Result<(), CliError> {
    if coefficients.is_some() {
        return Ok(AtomicFile::check(path)?);
    }
    check_result(path, false).map_err(|error| match error {
        CliError::Usage(_) => CliError::Usage(format!(
            "{}: coefficients are written as .npy or .fits, energies as .csv, all numbers as .json",
            path.display()
        )),
        other => other,
    })
}

impl FitBody {
    fn new(values: &Values, n_distinct: usize, args: &FitArgs, fit: &Fit) -> Self {
        let row = |(l, energy): (usize, &FittedEnergy)| EnergyRow {
            l,
            energy: energy.corrected,
            stderr: energy.stderr,
            fitted: energy.fitted,
            noise: energy.noise,
        };
        Self {
            points: values.name().to_owned(),
            n: values.len(),
            n_distinct,
            lmax: args.lmax,
            ridge: args.ridge,
            residual_rms: fit.residual_rms,
            noise_variance: fit.noise_variance,
            degrees_of_freedom: fit.degrees_of_freedom,
            condition: fit.condition,
            iterations: fit.iterations,
            energies: fit.energies.iter().enumerate().map(row).collect(),
        }
    }

    fn text(&self) -> String {
        /// The number of rows of the table.
        const ROWS: usize = 21;
        let optional = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), number::value);
        let mut text = format!(
            "{} points, fit to degree {}\n\
             rms of residuals  {}\n\
             noise variance    {} (of a value of weight 1; with sigma, the reduced chi-square)\n\
             condition number  {}\n\
             iterations        {}\n\n",
            self.n,
            self.lmax,
            number::value(self.residual_rms),
            optional(self.noise_variance),
            number::ratio(self.condition),
            self.iterations,
        );
        let columns = [
            Column::number("l", |row: &EnergyRow| row.l.to_string()),
            Column::number("energy", |row: &EnergyRow| optional(row.energy)),
            Column::number("+-", |row: &EnergyRow| optional(row.stderr)),
            Column::number("noise", |row: &EnergyRow| optional(row.noise)),
        ];
        text += &table_of(&columns, self.energies.iter().take(ROWS));
        text += "\nenergy: sum over m of |F_lm|^2 without the energy of the noise, in squared units of the values; +-: its\n\
                 standard error; noise: the mean energy of the noise, which is subtracted\n";
        if self.ridge > 0.0 {
            text +=
                "The ridge biases energies towards 0; the standard errors do not include this.\n";
        }
        if self.energies.len() > ROWS {
            text += &format!("-o FILE.csv writes all {} degrees.\n", self.energies.len());
        }
        text
    }
}
