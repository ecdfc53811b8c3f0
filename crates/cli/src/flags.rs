//! Flags that several subcommands share: each has the same name, meaning and help everywhere.

pub(crate) mod retired;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use clap::Args;
use clap::builder::TypedValueParser;
use sphvar_grammar::split_outside;
use sphvar_integrands::HarmonicProjection;
use sphvar_samplers::Domain;
use sphvar_spectrum::Resolution;

use crate::counts::{Counts, parse_one_count};
use crate::error::CliError;
use crate::integrands::{FORMS, SquareForms};
use crate::spec::{Spec, argument};

/// One number of points.
#[derive(Debug, Args)]
pub(crate) struct CountArgs {
    /// Number of points N: 1000, 1e4 or 10k
    #[arg(short = 'n', long, value_name = "N", value_parser = parse_one_count)]
    pub(crate) count: Option<usize>,
}

/// Several numbers of points.
#[derive(Debug, Args)]
pub(crate) struct CountsArgs {
    /// Numbers of points N: a list such as 100,400 or 1e3,10k, or a range such as 16..1024, which doubles
    #[arg(short = 'n', long = "count", value_name = "N")]
    pub(crate) counts: Option<Counts>,
}

impl CountArgs {
    /// Returns the number of points, which the subcommand requires.
    pub(crate) fn required(&self) -> Result<usize, CliError> {
        self.count.ok_or_else(missing_count)
    }
}

impl CountsArgs {
    /// Returns the numbers of points, none if they are not given; samplers from files have their
    /// own.
    pub(crate) fn list(&self) -> &[usize] {
        self.counts.as_ref().map_or(&[], Counts::all)
    }
}

pub(crate) fn missing_count() -> CliError {
    CliError::Usage("missing required option -n/--count, the number of points".to_owned())
}

/// The sampler where one makes sense.
#[derive(Debug, Args)]
pub(crate) struct SamplerArgs {
    #[arg(
        value_parser = one_sampler(),
        help = "Sampler: name or name:key=value,key=value; file:PATH is your own points"
    )]
    pub(crate) sampler: Option<String>,
}

/// Samplers where several make sense, as arguments or as the value of a flag.
#[derive(Debug, Args)]
#[group(multiple = false)]
pub(crate) struct SamplersArgs {
    #[arg(value_name = "SAMPLERS", id = "positional_samplers", help = Self::HELP, value_parser = argument())]
    positional: Vec<String>,
    /// Samplers, as a flag instead of arguments
    #[arg(long, value_name = "SAMPLERS", value_parser = argument())]
    samplers: Option<String>,
}

impl SamplersArgs {
    /// The help of the arguments, to which a subcommand adds its default.
    pub(crate) const HELP: &str = "Samplers, separated by commas or blanks: name or name:key=value,key=value; file:PATH is your own points; all is every built-in sampler";

    /// Returns the help of the arguments of a subcommand that also takes warped patterns.
    pub(crate) fn help_with_warps() -> String {
        format!(
            "{}; name:warp=DENSITY maps a pattern of the unit square to directions of a density (list warps)",
            Self::HELP
        )
    }

    /// Returns the list of samplers, if there is one.
    pub(crate) fn list(&self) -> Option<String> {
        let given: Vec<&str> = match &self.samplers {
            Some(text) => split_outside(text, " "),
            None => self.positional.iter().map(String::as_str).collect(),
        };
        // A comma at the end of a piece divides it from the next one, as the blank does.
        let pieces: Vec<&str> = given
            .into_iter()
            .map(|piece| piece.strip_suffix(',').unwrap_or(piece))
            .filter(|piece| !piece.is_empty())
            .collect();
        (!pieces.is_empty()).then(|| pieces.join(","))
    }

    /// Returns the list of samplers, which the subcommand requires or has a default for.
    pub(crate) fn required(&self) -> Result<String, CliError> {
        self.list().ok_or_else(|| CliError::Usage("missing samplers, such as jittered".to_owned()))
    }
}

/// Returns the parser of the argument of a subcommand that takes one sampler.
pub(crate) fn one_sampler() -> impl TypedValueParser<Value = String> {
    argument().try_map(|text| check_one(&text).map(|()| text))
}

fn check_one(text: &str) -> Result<(), String> {
    let several = if text == "all" {
        "all".to_owned()
    } else {
        match Spec::parse_list(text) {
            Ok(list) if list.len() > 1 => list.len().to_string(),
            // A text that is not a list is an error of the sampler, which is reported where it is
            // built.
            _ => return Ok(()),
        }
    };
    Err(format!("expected one sampler, got {several}; compare, variance and choose take several"))
}

/// The function that is integrated.
#[derive(Debug, Args)]
pub(crate) struct IntegrandArgs {
    #[arg(long, allow_hyphen_values = true, value_parser = argument(), help = format!("Integrand: {FORMS}"))]
    pub(crate) integrand: Option<String>,
}

impl IntegrandArgs {
    /// Returns the integrand, which the subcommand requires or has a default for.
    pub(crate) fn required(&self) -> Result<&str, CliError> {
        let missing = || CliError::Usage("missing required option --integrand".to_owned());
        self.integrand.as_deref().ok_or_else(missing)
    }
}

/// The projection of the integrand onto spherical harmonics.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct ProjectArgs {
    /// Estimate the coefficients of the integrand in the real spherical harmonics of degrees up to L, and the irradiance over all normals that follows from them: 2 for 9 coefficients, 3 for 16, 4 for 25
    #[arg(long, value_name = "L", conflicts_with = "hemisphere", value_parser = parse_projection_degree)]
    pub(crate) project: Option<usize>,
}

/// Parses the degree of a projection.
fn parse_projection_degree(text: &str) -> Result<usize, String> {
    let max = HarmonicProjection::MAX_DEGREE;
    let degree = text.parse().ok().filter(|degree| *degree <= max);
    degree.ok_or_else(|| format!("the degree must be a whole number from 0 to {max}, got {text}"))
}

/// Sphere or hemisphere.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct DomainArgs {
    /// Use the hemisphere z >= 0 instead of the sphere; only even degrees exist there
    #[arg(long)]
    pub(crate) hemisphere: bool,
}

impl DomainArgs {
    /// Returns the domain.
    pub(crate) fn domain(self) -> Domain {
        if self.hemisphere { Domain::Hemisphere } else { Domain::Sphere }
    }
}

/// The unit square instead of the sphere.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct SquareArgs {
    /// Use the unit square instead of the sphere: patterns and integrands of the square, with toroidal shifts instead of rotations
    #[arg(long)]
    pub(crate) square: bool,
}

/// The largest frequency on the square.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct KmaxArgs {
    /// Maximum length |k| of the frequencies on the square, inclusive
    #[arg(long, value_name = "K", requires = "square", value_parser = parse_one_count)]
    pub(crate) kmax: Option<usize>,
}

/// Returns the help of --integrand of subcommands with --square.
pub(crate) fn integrand_help_with_square() -> String {
    format!(
        "Integrand: {FORMS}; with --square: {SquareForms}, combined in the same way but not rotated; sphvar list \
         integrands --square explains them"
    )
}

/// Returns the help of --kmax with its default in words.
pub(crate) fn kmax_help(default: &str) -> String {
    format!("Maximum length |k| of the frequencies on the square, inclusive [default: {default}]")
}

/// The default of --kmax in words, for spectra that predict variances.
pub(crate) fn spectra_kmax_help() -> String {
    kmax_help(&format!(
        "{}; for lattices up to {LATTICE_FACTOR} times that; the axes extend further",
        natural_degree_in_words()
    ))
}

impl SquareArgs {
    /// Rejects options of the sphere with `--square`: each with whether it is given and the words
    /// that say what to use instead.
    pub(crate) fn without(self, options: &[(&str, bool, &str)]) -> Result<(), CliError> {
        match options.iter().find(|(_, is_given, _)| self.square && *is_given) {
            Some((option, _, instead)) => {
                Err(CliError::Usage(format!("{option} does not apply to --square; {instead}")))
            }
            None => Ok(()),
        }
    }
}

/// The words for an option of the sphere that the square does not have, for
/// [`SquareArgs::without`].
pub(crate) const USE_KMAX: &str = "use --kmax, the largest frequency, instead of a degree";
pub(crate) const ONE_DOMAIN: &str = "the square is a domain of its own";
pub(crate) const NO_HARMONICS: &str = "functions on the square have Fourier series";
pub(crate) const SHIFTED: &str = "patterns of the square are shifted, not rotated";

/// The treatment of a number of points that is not valid for a pattern.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct NearestArgs {
    /// Use the valid number of points nearest to N
    #[arg(long)]
    pub(crate) nearest: bool,
}

/// The largest degree of spectra.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct LmaxArgs {
    /// Maximum degree, inclusive
    #[arg(long, value_name = "L", value_parser = parse_one_count)]
    pub(crate) lmax: Option<usize>,
}

/// Returns the help of --lmax with its default in words.
pub(crate) fn lmax_help(default: &str) -> String {
    format!("Maximum degree, inclusive [default: {default}]")
}

/// The spectra of lattices extend to this multiple of the degree at which those of random patterns
/// have converged, because they have peaks at all degrees.
pub(crate) const LATTICE_FACTOR: usize = 10;

/// The default of --lmax in words, for spectra that predict or bound variances.
pub(crate) fn spectra_lmax_help() -> String {
    lmax_help(&format!("{}; for lattices {LATTICE_FACTOR} times that", natural_degree_in_words()))
}

/// The default of --lmax in words: the degree by which spectra of random patterns have settled.
pub(crate) fn natural_degree_in_words() -> String {
    let at_least = Resolution::natural_degree(1);
    // The factor is computed for a number of points with an integer square root.
    let factor = Resolution::natural_degree(1_000_000) / 1000;
    format!("{factor} sqrt(N), at least {at_least}")
}

/// The file of results with its plot.
#[derive(Debug, Args)]
pub(crate) struct OutArgs {
    /// Write the results to a file: .csv, .json, or a plot as .svg or .png
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}
