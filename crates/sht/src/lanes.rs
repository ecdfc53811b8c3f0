use std::f64::consts::PI;

use num_complex::Complex;
use sphvar_sh::Colatitude;

/// Rings are padded, with values 0, to a multiple of this: the most that one pass of any
/// instruction set takes at once.
const PADDING: usize = 32;

/// Values are carried as `x 2^(SCALE_BITS k)`, k <= 0, while they are too small for an f64.
pub(crate) const SCALE_BITS: i32 = 512;

/// The rings of one hemisphere as structure of arrays, at one order m at a time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lanes {
    /// The caller's number of the ring.
    ring: Vec<usize>,
    sin_theta: Vec<f64>,
    /// `lambda_mm = mantissa 2^exponent`.
    mantissa: Vec<f64>,
    exponent: Vec<i32>,
    /// 1 - |cos theta|.
    pub(crate) versine: Vec<f64>,
    /// The Fourier coefficient of the order.
    pub(crate) re: Vec<f64>,
    pub(crate) im: Vec<f64>,
    /// `lambda_mm = start 2^(SCALE_BITS scale)`, and `|start|` is up to `2^(SCALE_BITS/2)`.
    pub(crate) start: Vec<f64>,
    pub(crate) scale: Vec<f64>,
}

impl Lanes {
    pub(crate) fn clear(&mut self) {
        self.ring.clear();
        self.exponent.clear();
        for column in [
            &mut self.sin_theta,
            &mut self.mantissa,
            &mut self.versine,
            &mut self.re,
            &mut self.im,
            &mut self.start,
            &mut self.scale,
        ] {
            column.clear();
        }
    }

    /// Adds a ring, of which only the mirror image in the northern hemisphere is kept.
    pub(crate) fn push(&mut self, ring: usize, colatitude: Colatitude) {
        self.ring.push(ring);
        self.push_geometry(colatitude.versine(), colatitude.sin());
    }

    /// Fills up with rings that carry nothing.
    pub(crate) fn pad(&mut self) {
        while !self.versine.len().is_multiple_of(PADDING) {
            self.push_geometry(0.0, 0.0);
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.ring.is_empty()
    }

    fn push_geometry(&mut self, versine: f64, sin_theta: f64) {
        self.versine.push(versine);
        self.sin_theta.push(sin_theta);
        self.re.push(0.0);
        self.im.push(0.0);
        self.mantissa.push(0.0);
        self.exponent.push(0);
        self.start.push(0.0);
        self.scale.push(0.0);
    }

    /// Prepares order `m`, which follows m - 1: start values and the rings' Fourier coefficients.
    pub(crate) fn start_order(&mut self, m: usize, fourier: &[Complex<f64>]) {
        for ((re, im), &ring) in self.re.iter_mut().zip(&mut self.im).zip(&self.ring) {
            *re = fourier[ring].re;
            *im = fourier[ring].im;
        }
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
