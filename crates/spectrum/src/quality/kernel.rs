use std::f64::consts::{LN_2, PI};

use libm::{erf, erfc, tgamma};

use super::exponential_integral::{EULER_GAMMA, first};
use super::power_series::{Series, exponential, product};

/// A zonal kernel of a pair sum, `K(gamma) = sum_l (2l+1) k_l P_l(cos gamma)`.
///
/// With `mu = (l + 1/2)^2`, every `k_l` is a Laplace transform, `k_l = int_0^inf rho(tau)
/// exp(-mu tau) dtau`, so that K is an integral over heat kernels. The part of `tau < t` is short
/// in range, that of `tau > t` is smooth: Ewald's splitting, on the sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kernel {
    /// `1/3 - r/4`; `k_l = 1/((2l+1)(2l-1)(2l+3)) = mu^(-1/2)/(8 (mu - 1))`.
    Cap,
    /// `1 - 2 ln(1 + r/2)`; `k_l = 1/((2l+1) l (l+1)) = mu^(-1/2)/(2 (mu - 1/4))`.
    CuiFreeden,
    /// `k_l = (1 + l(l+1))^-s = (mu + 3/4)^-s`; s is half of a whole number.
    Sobolev(f64),
    /// `-ln r`; `k_l = 1/(2 l (l+1))`, `k_0 = 1/2 - ln 2`.
    Logarithm,
    /// `1/r`; `k_l = 1/(2l+1)`.
    Coulomb,
    /// `1/r^2`; `k_l = -psi(l + 1)/2` but for a constant, which affects coincident points only.
    InverseSquare,
}

/// The number of terms of expansions in tau.
pub(super) const ORDER: usize = 9;

/// The first degree at which the asymptotic series of psi is accurate to rounding.
const ASYMPTOTIC: usize = 8;

impl Kernel {
    /// Every kernel, in the order of the sums.
    pub(super) const ALL: [Self; 9] = [
        Self::Cap,
        Self::CuiFreeden,
        Self::Sobolev(super::WORST_CASE_SMOOTHNESS[0]),
        Self::Sobolev(super::WORST_CASE_SMOOTHNESS[1]),
        Self::Sobolev(super::WORST_CASE_SMOOTHNESS[2]),
        Self::Sobolev(super::WORST_CASE_SMOOTHNESS[3]),
        Self::Logarithm,
        Self::Coulomb,
        Self::InverseSquare,
    ];

    /// Returns whether the sum excludes the pairs of a point with itself.
    pub(super) fn is_energy(self) -> bool {
        matches!(self, Self::Logarithm | Self::Coulomb | Self::InverseSquare)
    }

    /// Returns the kernel of an energy at the chord 2.
    pub(super) fn at_antipode(self) -> Option<f64> {
        match self {
            Self::Logarithm => Some(-LN_2),
            Self::Coulomb => Some(0.5),
            Self::InverseSquare => Some(0.25),
            Self::Cap | Self::CuiFreeden | Self::Sobolev(_) => None,
        }
    }

    /// Returns p, half of a whole number, and the series of `rho(tau) exp(-tau/4) tau^-p`.
    pub(super) fn density(self) -> (f64, Series<ORDER>) {
        let scaled = |factor: f64, series: Series<ORDER>| series.map(|c| factor * c);
        match self {
            // rho = exp(tau) erf(sqrt tau)/8.
            Self::Cap => {
                let series = product(&exponential(-0.25), &odd_factorials(2.0));
                (0.5, scaled(0.25 / PI.sqrt(), series))
            }
            // rho = exp(tau/4) erf(sqrt(tau)/2).
            Self::CuiFreeden => {
                let series = product(&exponential(-0.25), &odd_factorials(0.5));
                (0.5, scaled(1.0 / PI.sqrt(), series))
            }
            // rho = tau^(s-1) exp(-3 tau/4)/Gamma(s).
            Self::Sobolev(s) => (s - 1.0, scaled(1.0 / tgamma(s), exponential(-1.0))),
            // rho = exp(tau/4)/2.
            Self::Logarithm => (0.0, scaled(0.5, exponential(0.0))),
            // rho = 1/(2 sqrt(pi tau)).
            Self::Coulomb => (-0.5, scaled(0.5 / PI.sqrt(), exponential(-0.25))),
            // rho = 1/(4 tau) + sum_j c_j tau^(j-1)/(j-1)!, where c_j mu^-j are the terms of
            // -psi/2.
            Self::InverseSquare => {
                let mut series = [0.25; ORDER];
                let mut factorial = 1.0;
                for (j, c) in digamma_terms().into_iter().enumerate().skip(1) {
                    series[j] = c / factorial;
                    factorial *= j as f64;
                }
                (-1.0, product(&series, &exponential(-0.25)))
            }
        }
    }

    /// Returns `int_t^inf rho(tau) exp(-mu tau) dtau`, the coefficient of the smooth part at degree
    /// l. Of kernels other than those of energies l is at least 1.
    pub(super) fn smooth_coefficient(self, l: usize, t: f64) -> f64 {
        let l_real = l as f64;
        let eigenvalue = l_real * (l_real + 1.0);
        let root = l_real + 0.5;
        let mu = root * root;
        let complement = || erfc((mu * t).sqrt()) / root;
        match self {
            Self::Cap => {
                let above = eigenvalue - 0.75;
                ((-above * t).exp() * erf(t.sqrt()) + complement()) / (8.0 * above)
            }
            Self::CuiFreeden => {
                let decayed = (-eigenvalue * t).exp() * erf(0.5 * t.sqrt());
                (decayed + 0.5 * complement()) / eigenvalue
            }
            Self::Sobolev(s) => {
                let base = 1.0 + eigenvalue;
                base.powf(-s) * upper_gamma(s, base * t)
            }
            Self::Logarithm if l == 0 => 0.5 - LN_2 - 0.5 * t,
            Self::Logarithm => (-eigenvalue * t).exp() / (2.0 * eigenvalue),
            Self::Coulomb => 0.5 * complement(),
            Self::InverseSquare => 0.25 * first(mu * t) + digamma_rest(l, mu, t),
        }
    }
}

/// Returns the series `sum_k (rate x)^k/(2k+1)!!`.
fn odd_factorials(rate: f64) -> Series<ORDER> {
    let mut term = 1.0;
    std::array::from_fn(|k| {
        if k > 0 {
            term *= rate / (2 * k + 1) as f64;
        }
        term
    })
}

/// Returns `Gamma(s, x)/Gamma(s)`, s half of a whole number from 1, by its finite sum.
pub(super) fn upper_gamma(s: f64, x: f64) -> f64 {
    let is_whole = s.fract() <= 0.0;
    let (mut order, mut term, mut sum) = if is_whole {
        (1.0, (-x).exp(), (-x).exp())
    } else {
        let term = 2.0 * (x / PI).sqrt() * (-x).exp();
        (1.5, term, erfc(x.sqrt()) + term)
    };
    while order < s {
        term *= x / order;
        sum += term;
        order += 1.0;
    }
    sum
}

/// Returns `c_j` of `-psi(l + 1)/2 ~ -ln(mu)/4 + sum_j c_j mu^-j` for j >= 1; the first is 0.
///
/// `c_j = -(1 - 2^(1-2j)) B_2j/(4j)` (DLMF 5.11.2 with 5.5.8).
fn digamma_terms() -> Series<ORDER> {
    const BERNOULLI: [f64; ORDER] = [
        0.0,
        1.0 / 6.0,
        -1.0 / 30.0,
        1.0 / 42.0,
        -1.0 / 30.0,
        5.0 / 66.0,
        -691.0 / 2730.0,
        7.0 / 6.0,
        -3617.0 / 510.0,
    ];
    let mut power = 2.0;
    std::array::from_fn(|j| {
        if j == 0 {
            return 0.0;
        }
        power /= 4.0;
        -(1.0 - power) * BERNOULLI[j] / (4.0 * j as f64)
    })
}

/// Returns `-psi(l + 1)/2 + ln(mu)/4` less the part of tau < t of its Laplace transform.
fn digamma_rest(l: usize, mu: f64, t: f64) -> f64 {
    let terms = digamma_terms();
    let x = mu * t;
    if l >= ASYMPTOTIC {
        let power = |j: usize| mu.powi(-i32::try_from(j).unwrap_or(i32::MAX));
        return (1..ORDER).map(|j| terms[j] * power(j) * upper_gamma(j as f64, x)).sum();
    }
    let harmonic: f64 = (1..=l).map(|k| 1.0 / k as f64).sum();
    let whole = 0.25 * mu.ln() - 0.5 * (harmonic - EULER_GAMMA);
    // int_0^t tau^(j-1)/(j-1)! exp(-mu tau) dtau = t^j exp(-x) sum_k x^k/(j + k)!.
    let mut factor = (-x).exp();
    let part: f64 = (1..ORDER)
        .map(|j| {
            factor *= t / j as f64;
            let mut term = 1.0;
            let sum: f64 = (1..60)
                .map(|k| {
                    term *= x / (j + k) as f64;
                    term
                })
                .sum();
            terms[j] * factor * (1.0 + sum)
        })
        .sum();
    whole - part
}
