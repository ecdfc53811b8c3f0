//! The flags that say how point sets are transformed.

use clap::{Args, ValueEnum};
use sphvar_spectrum::{Method, Resolution};

use crate::error::CliError;

/// How coefficients of point sets are computed.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct TransformArgs {
    /// How point sets are transformed: by the definition, fast to an accuracy, or whichever is
    /// expected to take less time
    #[arg(long, value_enum, default_value_t = MethodArg::Auto)]
    method: MethodArg,
    /// Relative accuracy of the coefficients by the fast method, 1e-13 to 1e-1 [default: 1e-12]
    #[arg(long, default_value_t = Resolution::EPSILON, hide_default_value = true)]
    epsilon: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodArg {
    Auto,
    Exact,
    Fast,
}

impl TransformArgs {
    /// The method and its accuracy.
    pub(crate) fn checked(self) -> Result<(Method, f64), CliError> {
        let (min, max) = (Resolution::MIN_EPSILON, Resolution::MAX_EPSILON);
        if !(min..=max).contains(&self.epsilon) {
            let got = self.epsilon;
            let message = format!("--epsilon must be in [{min:e}, {max:e}], got {got}");
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
