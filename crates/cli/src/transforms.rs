//! The flags for the transforms of point sets.

use clap::{Args, ValueEnum};
use sphvar_spectrum::{Method, Resolution};

use crate::counts::parse_number;
use crate::error::CliError;

/// The computation of the coefficients of point sets.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct TransformArgs {
    /// Transform of point sets: exact (by the definition), fast (to --epsilon), or auto, the one with less work
    #[arg(long, value_enum, hide_possible_values = true, default_value_t = MethodArg::Auto)]
    method: MethodArg,
    #[arg(
        long,
        value_name = "E",
        value_parser = parse_number,
        default_value = format!("{:e}", Resolution::EPSILON),
        help = format!(
            "Relative accuracy of the fast transform, from {:e} to {}", Resolution::MIN_EPSILON, Resolution::MAX_EPSILON
        )
    )]
    epsilon: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodArg {
    Auto,
    Exact,
    Fast,
}

impl TransformArgs {
    /// Returns whether a method other than the default is chosen.
    pub(crate) fn is_method_chosen(self) -> bool {
        self.method != MethodArg::Auto
    }

    /// Returns the method and its accuracy, or an error if the accuracy is out of range.
    pub(crate) fn checked(self) -> Result<(Method, f64), CliError> {
        let (min, max) = (Resolution::MIN_EPSILON, Resolution::MAX_EPSILON);
        if !(min..=max).contains(&self.epsilon) {
            let got = self.epsilon;
            let message = format!("--epsilon must be in [{min:e}, {max}], got {got:?}");
            return Err(CliError::Usage(message));
        }
        let method = match self.method {
            MethodArg::Auto => Method::Auto,
            MethodArg::Exact => Method::Exact,
            MethodArg::Fast => Method::Fast,
        };
        Ok((method, self.epsilon))
    }
}
