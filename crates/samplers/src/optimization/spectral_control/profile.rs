use std::f64::consts::PI;
use std::sync::Arc;

use sphvar_grammar::Range;

use super::noise_colour::NoiseColour;
use super::single_peak::SinglePeak;
use super::target::SpectralTarget;
use super::{correlation_target, in_range};
use crate::{Domain, Error, count};

/// The prescribed power of a pattern, for any number of points.
#[derive(Clone, Debug, PartialEq)]
pub enum PowerProfile {
    /// `P = offset + gamma min(1, (omega/alpha)^exponent)` for `omega = l/sqrt(N)` up to `to` (2N
    /// instead of N on the hemisphere); a constant for exponent 0.
    Polynomial {
        /// The power of omega, at least 0.
        exponent: f64,
        /// The omega at which the profile becomes constant.
        alpha: f64,
        /// The height of the constant part above the offset.
        gamma: f64,
        /// The value at degree 0.
        offset: f64,
        /// The omega at which the target ends.
        to: f64,
    },
    /// A colour of noise.
    Colour(NoiseColour),
    /// A step and a peak without oscillations, for `omega = l/sqrt(N)`.
    SinglePeak(SinglePeak),
    /// The power that corresponds to a pair correlation g(gamma), up to omega = 2. The angles do
    /// not depend on the number of points; on the sphere and the hemisphere only.
    PairCorrelation {
        /// The source of the table, for names and messages.
        name: Arc<str>,
        /// Angles in radians, in ascending order, and values, which are interpolated linearly:
        /// constant before the first angle, 1 beyond the last.
        g: Arc<[[f64; 2]]>,
    },
    /// A power for every degree, independent of the number of points.
    Table {
        /// The source of the table, for names and messages.
        name: Arc<str>,
        /// Powers by degree from 0; degree 0 is ignored.
        power: Arc<[f64]>,
    },
}

impl PowerProfile {
    /// The profile `min(1, omega^2)` up to omega = 2.
    pub const QUADRATIC: Self =
        Self::Polynomial { exponent: 2.0, alpha: 1.0, gamma: 1.0, offset: 0.0, to: 2.0 };

    /// The valid range of the end of a target, in units of sqrt(N).
    pub const TO_RANGE: Range = Range::left_open(0.0, 8.0);

    /// Returns the target for `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless exponent, gamma and offset are finite and at least 0, alpha is
    /// positive, `to` in (0, 8], there are 1 to `u32::MAX` points, and a table's powers are finite
    /// and at least 0; [`Error::Infeasible`] if a pair correlation is invalid or requires a negative
    /// power.
    pub fn target(&self, n_points: usize, domain: Domain) -> Result<SpectralTarget, Error> {
        match self {
            Self::Table { power, .. } => SpectralTarget::new(power.to_vec()),
            Self::Colour(colour) => {
                sampled(n_points, domain, colour.end(), |omega| colour.power(omega))
            }
            &Self::Polynomial { exponent, alpha, gamma, offset, to } => {
                Self::check_polynomial(exponent, alpha, gamma, offset, to)?;
                let power = polynomial(exponent, alpha, gamma, offset);
                sampled(n_points, domain, to, power)
            }
            Self::SinglePeak(profile) => {
                check_end(profile.to)?;
                sampled(n_points, domain, profile.to, profile.power(1.0)?)
            }
            Self::PairCorrelation { g, .. } => {
                let last = degrees(n_points, domain, CORRELATION_END)?.len() - 1;
                correlation_target::target(g, n_points, last, domain)
            }
        }
    }

    /// Returns the last |k| of the target for `n_points` points of the square, and the power as a
    /// function of |k|: `omega = |k|/sqrt(N)`, for a colour `omega = sqrt(pi) |k|/sqrt(N)`, which
    /// makes the number of frequencies below omega that of harmonics on the sphere. A table has the
    /// powers of |k| rounded to an integer.
    ///
    /// # Errors
    ///
    /// Those of [`Self::target`], and [`Error::Infeasible`] for a pair correlation.
    pub(crate) fn radial(&self, n_points: usize) -> Result<(f64, RadialPower<'_>), Error> {
        let root = f64::from(count::checked(n_points)?).sqrt();
        match self {
            Self::Table { power, .. } => {
                SpectralTarget::new(power.to_vec())?;
                let last = power.len().saturating_sub(1);
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "at least 0"
                )]
                let at = move |radius: f64| power[(radius.round() as usize).min(last)];
                Ok((last as f64, Box::new(at)))
            }
            Self::Colour(colour) => {
                let root = root / PI.sqrt();
                Ok((colour.end() * root, Box::new(move |radius| colour.power(radius / root))))
            }
            &Self::Polynomial { exponent, alpha, gamma, offset, to } => {
                Self::check_polynomial(exponent, alpha, gamma, offset, to)?;
                let power = polynomial(exponent, alpha, gamma, offset);
                Ok((to * root, Box::new(move |radius| power(radius / root))))
            }
            Self::SinglePeak(profile) => {
                check_end(profile.to)?;
                let power = profile.power(PI)?;
                Ok((profile.to * root, Box::new(move |radius| power(radius / root))))
            }
            Self::PairCorrelation { .. } => Err(Error::Infeasible {
                pattern: "profile-square",
                n_points,
                reason: "a pair correlation of angles is for the sphere and the hemisphere"
                    .to_owned(),
            }),
        }
    }

    fn check_polynomial(
        exponent: f64,
        alpha: f64,
        gamma: f64,
        offset: f64,
        to: f64,
    ) -> Result<(), Error> {
        for (name, got) in [("the exponent b", exponent), ("gamma", gamma), ("offset", offset)] {
            if !(got.is_finite() && got >= 0.0) {
                return Err(Error::Parameter { name, range: "finite and at least 0", got });
            }
        }
        if !(alpha.is_finite() && alpha > 0.0) {
            return Err(Error::Parameter {
                name: "alpha",
                range: "finite and above 0",
                got: alpha,
            });
        }
        check_end(to)
    }
}

/// The omega at which the target of a pair correlation ends.
const CORRELATION_END: f64 = 2.0;

/// Rejects the end of a target outside its range.
fn check_end(to: f64) -> Result<(), Error> {
    in_range("to", "in (0, 8]", to, PowerProfile::TO_RANGE)
}

/// A power as a function of |k|.
pub(crate) type RadialPower<'a> = Box<dyn Fn(f64) -> f64 + 'a>;

/// Returns `offset + gamma min(1, (omega/alpha)^exponent)` as a function of omega.
fn polynomial(exponent: f64, alpha: f64, gamma: f64, offset: f64) -> impl Fn(f64) -> f64 {
    move |omega| offset + gamma * (omega / alpha).powf(exponent).min(1.0)
}

/// Returns the target with a power for every degree up to the frequency `to`.
fn sampled(
    n_points: usize,
    domain: Domain,
    to: f64,
    power: impl Fn(f64) -> f64,
) -> Result<SpectralTarget, Error> {
    SpectralTarget::new(degrees(n_points, domain, to)?.into_iter().map(power).collect())
}

/// Returns `l/sqrt(N)` for the degrees from 0 up to `to`.
fn degrees(n_points: usize, domain: Domain, to: f64) -> Result<Vec<f64>, Error> {
    // Checked here, before a vector with one entry per degree is allocated.
    count::checked(n_points)?;
    let root = domain.count_on_sphere(n_points).sqrt();
    Ok((0_u32..).map(|l| f64::from(l) / root).take_while(|&omega| omega <= to).collect())
}
