use std::f64::consts::PI;

use num_complex::Complex;
use sphvar_sh::Colatitude;

/// Rings come in blocks of this many, the last filled up with rings that carry nothing: a multiple
/// of what one pass of any instruction set takes at once.
pub(crate) const BLOCK: usize = 32;

/// Values are carried as `x 2^(SCALE_BITS k)`, k <= 0, while they are too small for an f64.
pub(crate) const SCALE_BITS: i32 = 512;

/// The values of one function on a block at one order: real and imaginary part of what multiplies
/// `lambda_lm` for even l + m, then for odd.
pub(crate) const PARTS: usize = 4;

/// Rings of the northern hemisphere as structure of arrays, at one order m at a time.
///
/// A ring of the south is kept as its mirror image in the equator, where `lambda_lm` only changes
/// sign with the parity of l + m; two rings that mirror each other share a lane.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lanes {
    /// Which of the caller's rings a lane stands for.
    rings: Vec<Members>,
    sin_theta: Vec<f64>,
    /// `lambda_mm = mantissa 2^exponent`.
    mantissa: Vec<f64>,
    exponent: Vec<i32>,
    /// 1 - |cos theta|.
    pub(crate) versine: Vec<f64>,
    /// `lambda_mm = start 2^(SCALE_BITS scale)`, and `|start|` is up to `2^(SCALE_BITS/2)`.
    pub(crate) start: Vec<f64>,
    pub(crate) scale: Vec<f64>,
    /// By block, function, part and ring.
    pub(crate) terms: Vec<f64>,
}

/// The caller's rings behind a lane, at least one.
#[derive(Clone, Copy, Debug)]
struct Members {
    north: Option<usize>,
    south: Option<usize>,
    colatitude: Colatitude,
}

impl Lanes {
    /// Takes the caller's rings in. Returns their number.
    pub(crate) fn load(&mut self, colatitudes: impl Iterator<Item = Colatitude>) -> usize {
        self.rings.clear();
        self.rings.extend(colatitudes.enumerate().map(|(ring, colatitude)| {
            let south = colatitude.is_south();
            Members { north: (!south).then_some(ring), south: south.then_some(ring), colatitude }
        }));
        let n_rings = self.rings.len();
        self.share_lanes();
        // Neighbours in colatitude come into the range of f64 at about the same degree, which lets
        // whole groups skip what is below it.
        self.rings.sort_by(|a, b| b.colatitude.sin().total_cmp(&a.colatitude.sin()));
        self.lay_out();
        n_rings
    }

    /// Joins ring i and ring n - 1 - i where each is the mirror image of the other to the last bit.
    fn share_lanes(&mut self) {
        let n = self.rings.len();
        let mirrored = |a: &Members, b: &Members| {
            a.colatitude.versine().to_bits() == b.colatitude.versine().to_bits()
                && a.colatitude.is_south() != b.colatitude.is_south()
        };
        if n < 2 || !(0..n / 2).all(|i| mirrored(&self.rings[i], &self.rings[n - 1 - i])) {
            return;
        }
        for i in 0..n / 2 {
            let other = self.rings[n - 1 - i];
            let ring = &mut self.rings[i];
            ring.north = ring.north.or(other.north);
            ring.south = ring.south.or(other.south);
        }
        self.rings.truncate(n.div_ceil(2));
    }

    fn lay_out(&mut self) {
        let n = self.rings.len().next_multiple_of(BLOCK);
        let Self { rings, sin_theta, mantissa, exponent, versine, start, scale, .. } = self;
        for column in [&mut *sin_theta, mantissa, versine, start, scale] {
            column.clear();
            column.resize(n, 0.0);
        }
        exponent.clear();
        exponent.resize(n, 0);
        for (lane, ring) in rings.iter().enumerate() {
            versine[lane] = ring.colatitude.versine();
            sin_theta[lane] = ring.colatitude.sin();
        }
    }

    /// Prepares order `m`, which follows m - 1: start values, and terms from `fourier`, which holds
    /// `f_m` of function b on ring r at `b * n_rings + r`.
    pub(crate) fn start_order(&mut self, m: usize, fourier: &[Complex<f64>], n_rings: usize) {
        self.set_terms(fourier, n_rings);
        if m == 0 {
            let lambda_00 = 0.5 / PI.sqrt();
            self.mantissa.fill(lambda_00);
            self.exponent.fill(0);
            self.start.fill(lambda_00);
            self.scale.fill(0.0);
        } else {
            self.advance(m);
        }
    }

    fn set_terms(&mut self, fourier: &[Complex<f64>], n_rings: usize) {
        let n_functions = fourier.len() / n_rings.max(1);
        self.terms.clear();
        self.terms.resize(self.versine.len() * n_functions * PARTS, 0.0);
        for (function, values) in fourier.chunks_exact(n_rings.max(1)).enumerate() {
            for (lane, ring) in self.rings.iter().enumerate() {
                let north = ring.north.map_or(Complex::ZERO, |r| values[r]);
                let south = ring.south.map_or(Complex::ZERO, |r| values[r]);
                let (even, odd) = (north + south, north - south);
                let block = (lane / BLOCK * n_functions + function) * PARTS * BLOCK + lane % BLOCK;
                for (part, value) in [even.re, even.im, odd.re, odd.im].into_iter().enumerate() {
                    self.terms[block + part * BLOCK] = value;
                }
            }
        }
    }

    /// `lambda_mm` from `lambda_{m-1,m-1}`.
    fn advance(&mut self, m: usize) {
        let m = m as f64;
        let ratio = -((2.0 * m + 1.0) / (2.0 * m)).sqrt();
        for k in 0..self.versine.len() {
            let (mantissa, exponent) = split(self.mantissa[k] * (ratio * self.sin_theta[k]));
            // Saturation stands for a value too small for any degree to bring back.
            let exponent = self.exponent[k].saturating_add(exponent);
            let scale = exponent.saturating_add(SCALE_BITS / 2).div_euclid(SCALE_BITS).min(0);
            self.mantissa[k] = mantissa;
            self.exponent[k] = exponent;
            self.start[k] = mantissa * power_of_two(exponent - scale * SCALE_BITS);
            self.scale[k] = f64::from(scale);
        }
    }
}

/// `x = mantissa 2^exponent` with |mantissa| in [1, 2); zero is (0, 0). A subnormal `x`, from a
/// sine below 1e-308, counts as zero.
fn split(x: f64) -> (f64, i32) {
    let bits = x.to_bits();
    let biased = ((bits >> 52) & 0x7ff) as i32;
    if biased == 0 {
        return (0.0, 0);
    }
    (f64::from_bits(bits & !(0x7ff << 52) | (1023 << 52)), biased - 1023)
}

/// 2^k for k in [-1022, 1023].
#[expect(clippy::cast_sign_loss, reason = "the biased exponent is positive in the range")]
fn power_of_two(k: i32) -> f64 {
    f64::from_bits(((1023 + k) as u64) << 52)
}
