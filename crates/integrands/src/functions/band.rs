use std::f64::consts::PI;

use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_sh::LmIndex;

use super::RandomField;
use crate::definition::Definition;
use crate::{Error, Integrand, IntegrandResolver};

/// Parameters of a random function of limited bandwidth.
///
/// Its variance over the sphere is 1, `E(l)` is proportional to `(2l+1) l^-decay` for l = 1 to
/// `lmax` and 0 beyond, so that all directions and, without decay, all harmonics up to `lmax` are
/// equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandParameters {
    /// The largest degree, at least 1.
    pub lmax: usize,
    /// The exponent p of the power `E(l)/(2l+1) ~ l^-p`, -20 to 20.
    pub decay: f64,
    /// The mean over the sphere.
    pub mean: f64,
    /// The number of the random field.
    pub field: u64,
}

impl BandParameters {
    const MAX_DECAY: f64 = 20.0;

    /// Returns the energies of degrees 1 to `lmax`.
    fn energies(&self) -> Vec<f64> {
        let shape = |l: usize| (2 * l + 1) as f64 * (l as f64).powf(-self.decay);
        let sum: f64 = (1..=self.lmax).map(shape).sum();
        (1..=self.lmax).map(|l| 4.0 * PI * shape(l) / sum).collect()
    }
}

/// An example.
impl Default for BandParameters {
    fn default() -> Self {
        Self { lmax: 40, decay: 0.0, mean: 1.0, field: 0 }
    }
}

impl Parametric for BandParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.required_integer("lmax", [1, 1_000_000], "largest degree", &mut self.lmax);
        let range = Range::closed(-Self::MAX_DECAY, Self::MAX_DECAY);
        d.number("decay", range, "p of energies (2l+1) l^-p, variance 1", &mut self.decay);
        d.number("mean", Range::closed(-1e150, 1e150), "mean over the sphere", &mut self.mean);
        d.integer("field", [0, i64::MAX], "number of the random field", &mut self.field);
    }
}

impl Definition for BandParameters {
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        // The degree is checked before the energies take memory.
        LmIndex::new(self.lmax)?;
        let parameter = |name, range, got| Err(Error::Parameter { name, range, got });
        if self.lmax == 0 {
            return parameter("lmax", "at least 1", 0.0);
        }
        if self.decay.is_nan() || self.decay.abs() > Self::MAX_DECAY {
            return parameter("decay", "in [-20, 20]", self.decay);
        }
        let field = RandomField::new(self.mean, &self.energies(), self.field)?;
        Ok(Box::new(field.with_memory_check(files.memory_check())))
    }
}
