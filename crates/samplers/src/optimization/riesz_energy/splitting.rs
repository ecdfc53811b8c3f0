use std::f64::consts::{FRAC_PI_2, PI};

use sphvar_sh::{GaussLegendre, legendre_p_into};

/// The argument x of the kernel's incomplete gamma functions at the cut-off of the near part, which
/// leaves `exp(-x)` of the kernel.
const CUTOFF: f64 = 24.0;

/// The number of terms of the polynomials of the far part, whose largest error is 7e-13 of its
/// value at distance 0.
pub(super) const TERMS: usize = 27;

/// Above this argument `exp(-x)` is negligible beside 1.
const LARGE: f64 = 50.0;

/// Euler's constant.
const EULER: f64 = 0.577_215_664_901_532_9;

/// The Riesz kernel `d^-s`, for `s = 0` `-log d`, as the sum of a near part that ends at a cut-off
/// distance and of a far part that is smooth on the sphere (Ewald 1921).
///
/// With the regularized incomplete gamma functions P and Q = 1 - P, and `x = alpha^2 d^2`,
///
/// ```text
/// d^-s = d^-s Q(s/2, x) + d^-s P(s/2, x)
/// -log d = E1(x)/2 - (log d + E1(x)/2)
/// ```
///
/// The first terms decrease as `exp(-x)`; the second are entire functions of `d^2`, whose Legendre
/// coefficients decrease as `exp(-l^2/(4 alpha^2))`. The near part is computed as the difference of
/// kernel and far part.
#[derive(Debug)]
pub(super) struct Splitting {
    /// The square of the cut-off distance.
    pub(super) cutoff_squared: f64,
    /// The far part of the energy as a polynomial in `2 d^2/cutoff^2 - 1`, the highest power first.
    pub(super) energy: [f64; TERMS],
    /// The same of the weight: the far part of `d^(-s-2)`, of whose product with the difference of
    /// the points forces consist.
    pub(super) weight: [f64; TERMS],
    /// The far part at distance 0 and at the antipode.
    pub(super) at_zero: f64,
    pub(super) at_antipode: f64,
    /// `k_l` of the far part `sum_l (2l + 1) k_l P_l(cos)`.
    pub(super) coefficients: Vec<f64>,
}

impl Splitting {
    /// Returns the last degree of the far part for a cut-off distance: `CUTOFF` is its exponent as
    /// well.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
    pub(super) fn last_degree(cutoff: f64) -> usize {
        (2.0 * CUTOFF / cutoff).ceil() as usize
    }

    /// Returns the parts of the kernel of exponent `s` in [0, 4] for a cut-off distance in (0, 2].
    /// `None` if memory is insufficient.
    pub(super) fn new(s: f64, cutoff: f64) -> Option<Self> {
        let far = Far { s, alpha_squared: CUTOFF / (cutoff * cutoff) };
        let last = Self::last_degree(cutoff);
        // The far part has degree `last`, so the integrands have twice that; the margin is for
        // the degrees beyond, of size exp(-CUTOFF).
        let rule = GaussLegendre::new(last + 16).ok()?;
        let mut legendre = vec![0.0; last + 1];
        let mut coefficients = vec![0.0; last + 1];
        for (&t, &weight) in rule.nodes().iter().zip(rule.weights()) {
            legendre_p_into(t, &mut legendre).ok()?;
            let value = 0.5 * weight * far.energy(far.alpha_squared * (2.0 - 2.0 * t));
            for (sum, p) in coefficients.iter_mut().zip(&legendre) {
                *sum += value * p;
            }
        }
        Some(Self {
            cutoff_squared: cutoff * cutoff,
            energy: polynomial(|x| far.energy(x)),
            weight: polynomial(|x| far.weight(x)),
            at_zero: far.energy(0.0),
            at_antipode: far.energy(4.0 * far.alpha_squared),
            coefficients,
        })
    }
}

/// The far part of a kernel as a function of `x = alpha^2 d^2`.
#[derive(Clone, Copy)]
struct Far {
    s: f64,
    alpha_squared: f64,
}

impl Far {
    fn energy(self, x: f64) -> f64 {
        if self.s > 0.0 {
            self.alpha_squared.powf(0.5 * self.s) * lower_gamma(0.5 * self.s, x)
        } else {
            0.5 * (EULER + self.alpha_squared.ln() - exponential_integral(x))
        }
    }

    fn weight(self, x: f64) -> f64 {
        let a = 0.5 * self.s + 1.0;
        self.alpha_squared.powf(a) * lower_gamma(a, x)
    }
}

/// Returns `x^-a P(a, x)`, a > 0, by the series `exp(-x) sum_n x^n/Gamma(a + n + 1)`, whose terms
/// are positive.
fn lower_gamma(a: f64, x: f64) -> f64 {
    if x > LARGE {
        return x.powf(-a);
    }
    let (mut term, mut sum, mut n) = (1.0, 0.0, 0.0);
    while term > f64::EPSILON * sum {
        sum += term;
        n += 1.0;
        term *= x / (a + n);
    }
    (-x).exp() * sum / libm::tgamma(a + 1.0)
}

/// Returns `Ein(x) = E1(x) + log x + Euler's constant`, by the series `exp(-x) sum_n H_n x^n/n!`
/// with harmonic numbers H.
fn exponential_integral(x: f64) -> f64 {
    if x > LARGE {
        return EULER + x.ln();
    }
    let (mut power, mut harmonic, mut sum, mut n) = (1.0, 0.0, 0.0, 0.0);
    // The terms increase up to n = x.
    while n <= x || power * harmonic > f64::EPSILON * sum {
        n += 1.0;
        power *= x / n;
        harmonic += 1.0 / n;
        sum += power * harmonic;
    }
    (-x).exp() * sum
}

/// Returns the coefficients of the polynomial in z in [-1, 1] that interpolates a function of
/// `x = CUTOFF (1 + z)/2` at the Chebyshev nodes, the highest power first.
///
/// Powers of z are as accurate as Chebyshev polynomials here: the coefficients are at most 100
/// times the function.
fn polynomial(f: impl Fn(f64) -> f64) -> [f64; TERMS] {
    let angle = |j: usize| PI * (j as f64 + 0.5) / TERMS as f64;
    let values: [f64; TERMS] = std::array::from_fn(|j| f(0.5 * CUTOFF * (1.0 + (angle(j)).cos())));
    let mut sum = [0.0; TERMS];
    // The powers of T_(k-1) and T_k, the lowest first.
    let (mut before, mut own) = ([0.0; TERMS], [0.0; TERMS]);
    own[0] = 1.0;
    for k in 0..TERMS {
        let of_k = |j: usize| (k as f64 * angle(j)).cos();
        let projection: f64 = values.iter().enumerate().map(|(j, v)| v * of_k(j)).sum();
        let factor = if k == 0 { 1.0 } else { 2.0 } / TERMS as f64;
        for (sum, own) in sum.iter_mut().zip(own) {
            *sum += factor * projection * own;
        }
        let next = std::array::from_fn(|i| {
            let raised = if i > 0 { own[i - 1] } else { 0.0 };
            if k == 0 { raised } else { 2.0 * raised - before[i] }
        });
        (before, own) = (own, next);
    }
    sum.reverse();
    sum
}

/// Returns the angle of a chord of at most 2.
pub(super) fn angle_of(chord: f64) -> f64 {
    if chord < 2.0 { 2.0 * libm::asin(0.5 * chord) } else { 2.0 * FRAC_PI_2 }
}
