//! The question: a requested error, or a number of points.

use sphvar_variance::{Goal, IntegrationSpace, PredictorOn};

use super::args::ChooseArgs;
use crate::error::CliError;
use crate::share::parse_share;

/// The question together with the known properties of the integrand.
pub(super) struct Question {
    /// The integrand as it was written.
    pub(super) integrand: String,
    /// What is estimated, in texts.
    pub(super) quantity: &'static str,
    /// The integral, where it is known to 0.1 % or better and not 0.
    pub(super) integral: Option<f64>,
    pub(super) requested: Requested,
    /// Seconds for a value of the integrand.
    pub(super) cost_per_sample: Option<f64>,
}

/// The requested quantity.
pub(super) enum Requested {
    /// At most this standard error of the integral, with a limited number of points.
    Error {
        /// The error as the user wrote it.
        text: String,
        standard_error: f64,
        max_points: usize,
    },
    /// The smallest error with about this number of points.
    Points(usize),
}

impl Question {
    /// Returns the question about an integrand whose integral is estimated with an error, and by the
    /// Cauchy-Schwarz inequality at most `largest`.
    pub(super) fn new(
        args: &ChooseArgs,
        integrand: &str,
        quantity: &'static str,
        estimate: Option<(f64, f64)>,
        largest: f64,
    ) -> Result<Self, CliError> {
        // An estimate serves as the unit of relative errors if it is accurate to their two digits.
        let is_accurate = |&(integral, error): &(f64, f64)| error <= 1e-3 * f64::abs(integral);
        let known = estimate.filter(is_accurate).map(|(integral, _)| integral);
        // An integral that rounds to 0 relative to the largest possible one is 0.
        let integral = known.filter(|i| i.abs() > 1e-12 * largest);
        let requested = match (&args.error, args.count.count) {
            (Some(text), _) => {
                if args.max_count == 0 {
                    let message = "--max-count must be at least 1, got 0".to_owned();
                    return Err(CliError::Usage(message));
                }
                let standard_error = standard_error(text, args.absolute, integral, known)?;
                Requested::Error { text: text.clone(), standard_error, max_points: args.max_count }
            }
            (None, Some(0)) => {
                return Err(CliError::Usage("-n must be at least 1, got 0".to_owned()));
            }
            (None, Some(n)) => Requested::Points(n),
            (None, None) => {
                return Err(CliError::Usage(
                    "missing required option: --error E or -n N".to_owned(),
                ));
            }
        };
        let cost_per_sample = args.cost_per_sample;
        let integrand = integrand.to_owned();
        Ok(Self { integrand, quantity, integral, requested, cost_per_sample })
    }

    /// Returns the question for the library, with at most `max_points` points.
    pub(super) fn goal(&self, max_points: usize) -> Goal {
        match self.requested {
            Requested::Error { standard_error, .. } => {
                Goal::Variance { variance: standard_error * standard_error, max_points }
            }
            Requested::Points(n) => Goal::Points(n),
        }
    }

    /// Returns the requested number of points.
    pub(super) fn points(&self) -> Option<usize> {
        match self.requested {
            Requested::Error { .. } => None,
            Requested::Points(n) => Some(n),
        }
    }

    /// Returns the maximum number of points.
    pub(super) fn max_points(&self) -> usize {
        match self.requested {
            Requested::Error { max_points, .. } => max_points,
            Requested::Points(_) => usize::MAX,
        }
    }

    /// Returns the exact number of points that white noise needs for the requested error.
    pub(super) fn white_noise_points<S: IntegrationSpace>(
        &self,
        predictor: &PredictorOn<'_, S>,
    ) -> Option<f64> {
        match self.requested {
            Requested::Error { standard_error, .. } => {
                Some(predictor.white_points(standard_error * standard_error))
                    .filter(|n| n.is_finite())
            }
            Requested::Points(_) => None,
        }
    }

    /// Returns a standard error relative to the integral, if the integral is known and not 0.
    pub(super) fn relative(&self, standard_error: f64) -> Option<f64> {
        self.integral.map(|i| standard_error / i.abs())
    }
}

/// Returns the standard error that `text` requests.
fn standard_error(
    text: &str,
    absolute: bool,
    integral: Option<f64>,
    exact: Option<f64>,
) -> Result<f64, CliError> {
    // An absolute error has the unit of the integral, in which any positive number is valid.
    let is_plain = |e: &f64| *e > 0.0 && e.is_finite();
    let share = match text.trim().parse().ok().filter(is_plain) {
        Some(plain) if absolute => Some(plain),
        Some(_) => {
            let usage = |e| CliError::Usage(format!("--error: {e}"));
            Some(parse_share(text).map_err(usage)?)
        }
        None => parse_share(text).ok(),
    };
    let Some(share) = share.filter(|e| e * e > 0.0) else {
        return Err(CliError::Usage(format!(
            "--error must be a positive number such as 1% or 0.01, at least 1e-150, got \"{text}\""
        )));
    };
    if absolute {
        if text.contains('%') {
            return Err(CliError::Usage(format!(
                "--error {text} is a relative error; --absolute requires a number in units of the integral"
            )));
        }
        return Ok(share);
    }
    match (integral, exact) {
        (Some(integral), _) => Ok(share * integral.abs()),
        (None, Some(_)) => Err(CliError::Usage(format!(
            "--error {text}: relative error is undefined for a zero integral; use --absolute"
        ))),
        (None, None) => Err(CliError::Usage(format!(
            "--error {text}: relative error is undefined because the integral is unknown; use \
             --absolute"
        ))),
    }
}
