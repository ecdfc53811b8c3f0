//! Random numbers.

use glam::DVec3;

/// A mixed Weyl sequence (Steele et al. 2014, `SplitMix64`).
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a number from 0 to below n"
    )]
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    #[allow(dead_code, reason = "not used by every test")]
    pub(crate) fn direction(&mut self) -> DVec3 {
        let (z, phi) = (2.0 * self.unit() - 1.0, std::f64::consts::TAU * self.unit());
        (1.0 - z * z).sqrt() * DVec3::new(phi.cos(), phi.sin(), 0.0) + z * DVec3::Z
    }

    #[allow(dead_code, reason = "not used by every test")]
    pub(crate) fn inside(&mut self, min: DVec3, max: DVec3) -> DVec3 {
        min + (max - min) * DVec3::new(self.unit(), self.unit(), self.unit())
    }
}
