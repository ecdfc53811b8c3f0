use super::exponential_integral::ExponentialIntegrals;
use super::kernel::{Kernel, ORDER};
use super::power_series::{Series, quotient, value};

/// The number of terms of expansions in gamma^2, which converge for gamma < pi. At the largest
/// radius used, 1.2, the rest is 1e-18.
const TERMS: usize = 28;

/// The short-range parts of all kernels for one splitting time t.
///
/// The heat kernel of the unit sphere with mean 1 is, for small tau,
///
/// ```text
/// sum_l (2l+1) exp(-l(l+1) tau) P_l(cos gamma) = exp(-gamma^2/(4 tau)) sum_j a_j(gamma) tau^(j-1)
/// ```
///
/// so that the part of tau < t of a kernel with density `rho = exp(tau/4) sum_i r_i tau^(p+i)` is
///
/// ```text
/// sum_n c_n(gamma) t^(p+n) E_(p+n+1)(gamma^2/(4 t)),   c_n = sum_(i+j=n) r_i a_j
/// ```
#[derive(Clone, Debug)]
pub(super) struct ShortRange {
    t: f64,
    /// The series of each `a_j` in gamma^2.
    heat: [Series<TERMS>; ORDER],
    /// p and the `r_i` of each kernel.
    densities: [(f64, Series<ORDER>); Kernel::ALL.len()],
}

impl ShortRange {
    /// Returns the parts for t of at most 0.01.
    pub(super) fn new(t: f64) -> Self {
        Self { t, heat: heat_coefficients(), densities: Kernel::ALL.map(Kernel::density) }
    }

    /// Returns the parts at `v = sin^2(gamma/2)`, a quarter of the squared chord, v > 0.
    pub(super) fn at(&self, v: f64) -> [f64; Kernel::ALL.len()] {
        let gamma = 2.0 * v.sqrt().asin();
        let square = gamma * gamma;
        let heat = self.heat.each_ref().map(|series| value(series, square));
        let integrals = ExponentialIntegrals::new(square / (4.0 * self.t));
        self.densities
            .each_ref()
            .map(|(p, density)| self.sum(*p, density, &heat, |twice_nu| integrals.of(twice_nu)))
    }

    /// Returns the parts at gamma = 0 of the kernels that are finite there, and 0 for energies.
    pub(super) fn at_zero(&self) -> [f64; Kernel::ALL.len()] {
        let heat = self.heat.each_ref().map(|series| series[0]);
        // E_nu(0) = 1/(nu - 1).
        let at = |twice_nu: usize| 1.0 / (0.5 * twice_nu as f64 - 1.0);
        self.densities.each_ref().map(
            |(p, density)| {
                if *p > 0.0 { self.sum(*p, density, &heat, at) } else { 0.0 }
            },
        )
    }

    /// Returns the means over the sphere of the kernels that have p > 0, and 0 for energies.
    pub(super) fn means(&self) -> [f64; Kernel::ALL.len()] {
        // The heat kernel has mean 1: a_0 = tau in place of the expansion.
        let heat = std::array::from_fn(|j| if j == 0 { self.t } else { 0.0 });
        let at = |twice_nu: usize| 2.0 / twice_nu as f64;
        self.densities.each_ref().map(
            |(p, density)| {
                if *p > 0.0 { self.sum(*p, density, &heat, at) } else { 0.0 }
            },
        )
    }

    /// Returns `sum_n (sum_(i+j=n) r_i a_j) t^(p+n) E(p+n+1)`; `integral` takes twice the order.
    fn sum(
        &self,
        p: f64,
        density: &Series<ORDER>,
        heat: &[f64; ORDER],
        integral: impl Fn(usize) -> f64,
    ) -> f64 {
        // p is half of a whole number from -1 on.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 8")]
        let twice_nu = (2.0 * p + 2.0) as usize;
        let coefficients = super::power_series::product(density, heat);
        let mut power = self.t.powf(p);
        let mut sum = 0.0;
        for (n, c) in coefficients.into_iter().enumerate() {
            sum += c * power * integral(twice_nu + 2 * n);
            power *= self.t;
        }
        sum
    }
}

/// Returns the series of `a_j` in gamma^2.
///
/// Inserting the expansion into `d/dtau = d^2/dgamma^2 + cot(gamma) d/dgamma` gives, with
/// `b = gamma cot(gamma)`,
///
/// ```text
/// gamma a_j' + (j - 1/2 + b/2) a_j = a_(j-1)'' + cot(gamma) a_(j-1)',   a_0(0) = 1
/// ```
fn heat_coefficients() -> [Series<TERMS>; ORDER] {
    let b = cotangent();
    let mut all = [[0.0; TERMS]; ORDER];
    for j in 0..ORDER {
        let source = if j == 0 { [0.0; TERMS] } else { laplacian(&all[j - 1], &b) };
        for n in 0..TERMS {
            let mixed: f64 = (1..=n).map(|m| b[m] * all[j][n - m]).sum();
            all[j][n] =
                if j + n == 0 { 1.0 } else { (source[n] - 0.5 * mixed) / (2 * n + j) as f64 };
        }
    }
    all
}

/// Returns the series of `gamma cot(gamma)` in gamma^2.
fn cotangent() -> Series<TERMS> {
    let mut term = 1.0;
    let cosine = std::array::from_fn(|n| {
        let value = term;
        term /= -(((2 * n + 1) * (2 * n + 2)) as f64);
        value
    });
    let sinc = std::array::from_fn(|n: usize| cosine[n] / (2 * n + 1) as f64);
    quotient(&cosine, &sinc)
}

/// Returns the series of `f'' + cot(gamma) f'`; the last term, which needs more of f, is 0.
fn laplacian(f: &Series<TERMS>, b: &Series<TERMS>) -> Series<TERMS> {
    let derivative = |n: usize| (2 * n) as f64 * f[n];
    std::array::from_fn(|n| {
        if n + 1 == TERMS {
            return 0.0;
        }
        let second = derivative(n + 1) * (2 * n + 1) as f64;
        second + (0..=n).map(|m| b[m] * derivative(n + 1 - m)).sum::<f64>()
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use sphvar_sh::legendre_p_into;

    use super::super::kernel::Kernel;
    use super::{ShortRange, heat_coefficients};
    use crate::quality::power_series::value;

    #[test]
    fn expansions_are_the_heat_kernel() {
        let coefficients = heat_coefficients();
        let mut legendre = vec![0.0; 400];
        for tau in [3e-4_f64, 3e-3, 0.01] {
            for gamma in [0.0_f64, 0.01, 0.1, 0.4, 0.9] {
                legendre_p_into(gamma.cos(), &mut legendre).unwrap();
                let series = legendre.iter().enumerate();
                let expected: f64 = series
                    .map(|(l, p)| (2 * l + 1) as f64 * (-((l * (l + 1)) as f64) * tau).exp() * p)
                    .sum();
                let values = coefficients.map(|a| value(&a, gamma * gamma));
                let got = (-gamma * gamma / (4.0 * tau)).exp() * value(&values, tau) / tau;
                assert!((got - expected).abs() < 2e-13 / tau, "{tau} {gamma}: {got}, {expected}");
            }
        }
    }

    /// Closed forms and series to high degrees with both parts.
    #[test]
    fn parts_add_up_to_the_kernels() {
        const LAST: usize = 700;
        let mut legendre = vec![0.0; LAST + 1];
        for t in [4e-4, 8e-3] {
            let short = ShortRange::new(t);
            for gamma in [1e-6_f64, 1e-3, 0.02, 0.1, 0.5, 1.0] {
                legendre_p_into(gamma.cos(), &mut legendre).unwrap();
                let u = (0.5 * gamma).sin();
                let parts = short.at(u * u);
                let means = short.means();
                for (i, kernel) in Kernel::ALL.into_iter().enumerate() {
                    let first = usize::from(!kernel.is_energy());
                    let smooth: f64 = (first..=LAST)
                        .map(|l| {
                            let k = kernel.smooth_coefficient(l, t);
                            (2 * l + 1) as f64 * k * legendre[l]
                        })
                        .sum();
                    let got = smooth + parts[i] - means[i];
                    let expected = match kernel {
                        Kernel::Cap => 1.0 / 3.0 - 0.5 * u,
                        Kernel::CuiFreeden => 1.0 - 2.0 * u.ln_1p(),
                        Kernel::Logarithm => -(2.0 * u).ln(),
                        Kernel::Coulomb => 0.5 / u,
                        Kernel::InverseSquare => 0.25 / (u * u),
                        // Tested below.
                        Kernel::Sobolev(_) => continue,
                    };
                    let tolerance = 2e-13 * expected.abs().max(1.0);
                    let context = format!("{kernel:?}, t = {t}, gamma = {gamma}");
                    assert!((got - expected).abs() < tolerance, "{context}: {got}, {expected}");
                }
            }
        }
    }

    /// The series has terms of about l^(1/2 - 2s) at gamma > 0; its rest at 0 is an integral.
    #[test]
    fn smooth_and_short_parts_are_the_series_of_sobolev_kernels() {
        const LAST: usize = 60_000;
        let t = 5e-3;
        let short = ShortRange::new(t);
        let mut legendre = vec![0.0; LAST + 1];
        for gamma in [0.0_f64, 0.03, 0.3, 1.0] {
            legendre_p_into(gamma.cos(), &mut legendre).unwrap();
            let v = (0.5 * gamma).sin().powi(2);
            let parts = if v > 0.0 { short.at(v) } else { short.at_zero() };
            let means = short.means();
            for (i, kernel) in Kernel::ALL.into_iter().enumerate() {
                let Kernel::Sobolev(s) = kernel else { continue };
                let term = |l: usize, k: f64| (2 * l + 1) as f64 * k * legendre[l];
                let smooth: f64 = (1..=400).map(|l| term(l, kernel.smooth_coefficient(l, t))).sum();
                let full: f64 =
                    (1..=LAST).rev().map(|l| term(l, (1.0 + (l * (l + 1)) as f64).powf(-s))).sum();
                // sum over l > L of (2l+1) (1 + l(l+1))^-s, about an integral over mu.
                let end = (LAST as f64 + 1.0).powi(2);
                let rest = if gamma > 0.0 { 0.0 } else { end.powf(1.0 - s) / (s - 1.0) };
                let got = smooth + parts[i] - means[i];
                // Dropped terms oscillate: the last one, times the degrees of half a period.
                let last = (LAST as f64).powf(0.5 - 2.0 * s + 1.0) / gamma.max(1e-3).powf(1.5);
                let tolerance = 1e-14 + if gamma > 0.0 { PI * last } else { 0.0 };
                let expected = full + rest;
                let context = format!("s = {s}, gamma = {gamma}");
                assert!((got - expected).abs() < tolerance, "{context}: {got}, {expected}");
            }
        }
    }
}
