use std::f64::consts::PI;

use sphvar_grammar::{Declaration, Parametric};
use sphvar_sh::{ByAxis, Frequencies};

use super::SquareDefinition;
use super::energy::energy_of_coefficients;
use super::turns::cos_turns;
use crate::{Energy, Error, IntegrandResolver, SquareIntegrand};

/// A cosine of one integer frequency, `cos(2 pi (k1 u + k2 v))`, whose whole variance of 1/2 is in
/// the band of k; (0, 0) is the constant 1.
///
/// Under random shifts the variance of its integral is the power of the point set at k, divided by
/// 2N.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wave {
    k: [i32; 2],
}

impl Wave {
    /// The largest magnitude of both numbers of the frequency.
    pub const MAX_FREQUENCY: i32 = 1 << 24;

    /// Returns the cosine of frequency `k`, both numbers from -2^24 to 2^24.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn new(k: [i32; 2]) -> Result<Self, Error> {
        let valid = -Self::MAX_FREQUENCY..=Self::MAX_FREQUENCY;
        for (name, k) in [("k1", k[0]), ("k2", k[1])] {
            if !valid.contains(&k) {
                let range = "a whole number from -16777216 to 16777216";
                return Err(Error::Parameter { name, range, got: f64::from(k) });
            }
        }
        Ok(Self { k })
    }

    /// Returns the frequency.
    #[must_use]
    pub fn frequency(&self) -> [i32; 2] {
        self.k
    }
}

impl SquareIntegrand for Wave {
    fn eval(&self, [u, v]: [f64; 2]) -> f64 {
        let [k1, k2] = self.k.map(f64::from);
        // The turns of each product are reduced on their own, so that neither loses the digits of
        // the other.
        let turns = |x: f64| x - x.round();
        cos_turns(turns(k1 * u) + turns(k2 * v))
    }

    fn exact(&self) -> Option<f64> {
        Some(if self.k == [0, 0] { 1.0 } else { 0.0 })
    }

    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        let mut centred = ByAxis::default();
        match self.k {
            [0, 0] => (),
            [_, 0] => centred.u = 0.5,
            [0, _] => centred.v = 0.5,
            _ => centred.off = 0.5,
        }
        let opposite = self.k.map(|k| -k);
        let mean = if self.k == [0, 0] { 1.0 } else { 0.0 };
        energy_of_coefficients(frequencies, mean, centred, |k| {
            if k == self.k || k == opposite { 0.25 } else { 0.0 }
        })
    }

    /// Returns half of the shorter period.
    fn feature_size(&self) -> Option<f64> {
        let k = self.k[0].abs().max(self.k[1].abs());
        Some(if k == 0 { 1.0 } else { 0.5 / f64::from(k) })
    }

    /// Returns that of a cosine, 3/2; `None` for the constant.
    fn kurtosis(&self) -> Option<f64> {
        (self.k != [0, 0]).then_some(1.5)
    }

    fn band_limit(&self) -> Option<usize> {
        let [k1, k2] = self.k.map(|k| u64::from(k.unsigned_abs()).pow(2));
        let floor = (k1 + k2).isqrt();
        let ceil = if floor * floor < k1 + k2 { floor + 1 } else { floor };
        usize::try_from(ceil).ok()
    }

    /// Returns `8 pi |k1 k2| + 4 |k1| + 4 |k2|`: the mean of |cos| and of |sin| is 2/pi.
    fn variation(&self) -> Option<f64> {
        let [k1, k2] = self.k.map(|k| f64::from(k.abs()));
        Some(8.0 * PI * k1 * k2 + 4.0 * (k1 + k2))
    }
}

/// Parameters of a [`Wave`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WaveParameters {
    /// The frequency along u.
    pub k1: i32,
    /// The frequency along v.
    pub k2: i32,
}

/// An example.
impl Default for WaveParameters {
    fn default() -> Self {
        Self { k1: 3, k2: 2 }
    }
}

impl Parametric for WaveParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let max = i64::from(Wave::MAX_FREQUENCY);
        d.required_integer("k1", [-max, max], "periods along u", &mut self.k1);
        d.required_integer("k2", [-max, max], "periods along v", &mut self.k2);
    }
}

impl SquareDefinition for WaveParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn SquareIntegrand>, Error> {
        Ok(Box::new(Wave::new([self.k1, self.k2])?))
    }
}
