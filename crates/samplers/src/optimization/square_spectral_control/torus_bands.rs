use std::f64::consts::PI;

use glam::DVec2;
use sphvar_nufft::{MAX_KMAX, TorusCoefficients, TorusTransform, TorusWorkspace};

use crate::Error;
use crate::optimization::spectral_control::{ACCURACIES, Band, BandTransform};
use crate::square::turns::wrapped;

/// No band.
const NONE: u32 = u32::MAX;

/// The frequencies of the square with a target, in bands: each pair of k and -k whose target is 0 by
/// itself, the others in rings of `|k|` rounded to an integer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RadialTarget {
    kmax: usize,
    /// The band of every coefficient with k2 >= 0, in the order of [`TorusCoefficients::values`].
    band_of: Vec<u32>,
    bands: Vec<Band>,
}

impl RadialTarget {
    /// Returns the target `power(|k|)` for `0 < |k| <= last`. The target of a ring is the mean over
    /// its frequencies.
    ///
    /// # Errors
    ///
    /// [`Error::Degree`] if there are too many frequencies for a transform or for memory.
    pub(super) fn new(last: f64, power: impl Fn(f64) -> f64) -> Result<Self, Error> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 0")]
        let kmax = last as usize;
        let mut band_of = Vec::new();
        let failed = |reason: String| Error::Degree { last: kmax, reason };
        if kmax > MAX_KMAX {
            return Err(failed(format!("the largest supported frequency is {MAX_KMAX}")));
        }
        let len = (2 * kmax + 1) * (kmax + 1);
        band_of.try_reserve_exact(len).map_err(|error| failed(error.to_string()))?;
        band_of.resize(len, NONE);
        let mut target = Self { kmax, band_of, bands: Vec::new() };
        let mut rings = vec![NONE; kmax + 2];
        let mut n_bands = 0;
        for index in 0..target.band_of.len() {
            let [k1, k2] = target.frequency(index);
            let square = k1 * k1 + k2 * k2;
            let radius = square.sqrt();
            // Of the pairs on the axis k2 = 0 both frequencies are stored.
            if square == 0.0 || radius > last || k2 == 0.0 && k1 < 0.0 {
                continue;
            }
            let power = power(radius);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
            let ring = &mut rings[radius.round() as usize];
            let is_known = power > 0.0 && *ring != NONE;
            let band = if is_known { *ring } else { n_bands };
            if !is_known {
                let index = target.bands.len();
                target.bands.push(Band { index, target: 0.0, multiplicity: 0.0, eigenvalue: 0.0 });
                n_bands += 1;
            }
            if power > 0.0 {
                *ring = band;
            }
            target.band_of[index] = band;
            let band = &mut target.bands[band as usize];
            band.multiplicity += 2.0;
            band.target += 2.0 * power;
            band.eigenvalue += 8.0 * PI * PI * square;
        }
        for band in &mut target.bands {
            band.target /= band.multiplicity;
            band.eigenvalue /= band.multiplicity;
        }
        for k1 in 1..=kmax {
            target.band_of[(kmax - k1) * (kmax + 1)] = target.band_of[(kmax + k1) * (kmax + 1)];
        }
        Ok(target)
    }

    fn frequency(&self, index: usize) -> [f64; 2] {
        let [line, column] = [index / (self.kmax + 1), index % (self.kmax + 1)];
        [line as f64 - self.kmax as f64, column as f64]
    }

    /// Returns the last frequency along an axis.
    pub(super) fn last(&self) -> usize {
        self.kmax
    }

    pub(super) fn bands(&self) -> &[Band] {
        &self.bands
    }

    /// Returns the number of real coefficients that must vanish.
    pub(super) fn constraints(&self) -> f64 {
        self.bands.iter().filter(|band| band.target == 0.0).map(|band| band.multiplicity).sum()
    }

    /// Returns whether a frequency has a target above 0.
    pub(super) fn has_powers(&self) -> bool {
        self.bands.iter().any(|band| band.target > 0.0)
    }

    /// Returns the pair correlation at distance 0 that the target implies, with white noise beyond
    /// it,
    ///
    /// ```text
    /// g2(0) = 1 + 1/(N-1) sum over k of (P(k) - 1).
    /// ```
    pub(super) fn pair_correlation_at_zero(&self, n_points: usize) -> f64 {
        let excess: f64 = self.bands.iter().map(|b| b.multiplicity * (b.target - 1.0)).sum();
        1.0 + excess / (n_points as f64 - 1.0).max(1.0)
    }
}

/// The transforms between points of the square and coefficients.
pub(super) struct TorusBands<'a> {
    target: &'a RadialTarget,
    /// One for each of `ACCURACIES`.
    transforms: [TorusTransform; ACCURACIES.len()],
    workspace: TorusWorkspace,
    coefficients: TorusCoefficients,
    points: Vec<[f64; 2]>,
    values: Vec<[f64; 3]>,
}

impl<'a> TorusBands<'a> {
    pub(super) fn new(target: &'a RadialTarget) -> Result<Self, Error> {
        let kmax = target.kmax;
        let failed =
            |error: sphvar_nufft::Error| Error::Degree { last: kmax, reason: error.to_string() };
        let transform = |epsilon| TorusTransform::new(kmax, epsilon).map_err(failed);
        let [a, b, c, d] = ACCURACIES;
        Ok(Self {
            target,
            transforms: [transform(a)?, transform(b)?, transform(c)?, transform(d)?],
            workspace: TorusWorkspace::default(),
            coefficients: TorusCoefficients::zeros(kmax).map_err(failed)?,
            points: Vec::new(),
            values: Vec::new(),
        })
    }
}

impl BandTransform for TorusBands<'_> {
    type Point = DVec2;

    const AREA: f64 = 1.0;

    fn analyze(&mut self, points: &[DVec2], level: usize, squares: &mut Vec<f64>) {
        let Self { target, transforms, workspace, coefficients, points: turns, .. } = self;
        turns.clear();
        turns.extend(points.iter().map(|&p| wrapped(p).to_array()));
        squares.clear();
        squares.resize(target.bands.len(), 0.0);
        let transform = &transforms[level];
        if transform.adjoint_into(turns, None, workspace, coefficients).is_err() {
            // Out of memory: such points are never accepted.
            squares.fill(f64::INFINITY);
            return;
        }
        let columns = target.kmax + 1;
        for (index, (c, &band)) in coefficients.values().iter().zip(&target.band_of).enumerate() {
            if let Some(square) = squares.get_mut(band as usize) {
                // A coefficient with k2 > 0 represents that of -k too.
                let represented = if index.is_multiple_of(columns) { 1.0 } else { 2.0 };
                *square += represented * c.norm_sqr();
            }
        }
    }

    /// The points are those of the last call of [`Self::analyze`].
    fn gradient_into(&mut self, factors: &[f64], _points: &[DVec2], gradient: &mut [DVec2]) {
        let Self { target, transforms, workspace, coefficients, points, values } = self;
        for (c, &band) in coefficients.values_mut().iter_mut().zip(&target.band_of) {
            *c *= factors.get(band as usize).copied().unwrap_or(0.0);
        }
        values.resize(points.len(), [0.0; 3]);
        let [transform, ..] = transforms;
        if transform.gradient_into(coefficients, points, workspace, values).is_err() {
            values.fill([0.0; 3]);
        }
        for (gradient, &[_, du, dv]) in gradient.iter_mut().zip(&*values) {
            *gradient = DVec2::new(du, dv);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::{DVec2, Error, RadialTarget, TorusBands};
    use crate::Square;
    use crate::optimization::descent::Objective;
    use crate::optimization::spectral_control::{DistancePenalty, NearPairs, SpectralEnergy};
    use crate::{Purpose, Streams};
    use rand::RngExt;

    /// Zeros, a gap and powers; frequencies to 6.3.
    fn target() -> RadialTarget {
        RadialTarget::new(6.3, |radius| if radius < 3.2 { 0.0 } else { 0.3 * (radius - 3.0) })
            .unwrap()
    }

    fn white(n: usize) -> Vec<DVec2> {
        let mut rng = Streams::new(3, Purpose::Pattern, n).realization(0);
        (0..n).map(|_| rng.random::<[f64; 2]>().into()).collect()
    }

    const CORE: DistancePenalty<Square> = DistancePenalty { space: Square, sigma: 0.13 };

    /// Computes the energy by its definition, a sum over all frequencies of the plane. The penalty
    /// comes from its own code, which is tested separately.
    fn definition(points: &[DVec2]) -> f64 {
        let n = points.len() as f64;
        let (mut zeros, mut rings) = (0.0, vec![[0.0; 4]; 8]);
        for k1 in -6..=6_i32 {
            for k2 in -6..=6_i32 {
                let k = DVec2::new(f64::from(k1), f64::from(k2));
                let radius = k.length();
                if radius == 0.0 || radius > 6.3 {
                    continue;
                }
                let terms = points.iter().map(|p| (TAU * k.dot(*p)).sin_cos());
                let (sin, cos) = terms.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
                let square = sin * sin + cos * cos;
                let eigenvalue = (TAU * radius).powi(2);
                if radius < 3.2 {
                    zeros += square / eigenvalue;
                } else {
                    #[expect(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "at most 6"
                    )]
                    let ring = &mut rings[(radius + 0.5).floor() as usize];
                    let power = 0.3 * (radius - 3.0);
                    for (sum, term) in ring.iter_mut().zip([1.0, square, power, eigenvalue]) {
                        *sum += term;
                    }
                }
            }
        }
        let powers = rings.iter().filter(|ring| ring[0] > 0.0);
        let off: f64 = powers
            .map(|[count, square, power, eigenvalue]| {
                (square.sqrt() - (n * power).sqrt()).powi(2) * count / eigenvalue
            })
            .sum();
        0.5 / n * (zeros + off)
            + NearPairs::new(CORE).add(points, &mut vec![DVec2::ZERO; points.len()])
    }

    #[test]
    fn the_energy_matches_the_definition() {
        let target = target();
        for n in [1, 2, 20, 300] {
            let points = white(n);
            for (is_fine, accuracy) in [(false, 1e-2), (true, 1e-9)] {
                let transform = TorusBands::new(&target).unwrap();
                let bands = target.bands().to_vec();
                let mut energy = SpectralEnergy::new(transform, bands, CORE, n);
                if is_fine {
                    energy = energy.into_fine();
                }
                let (fast, slow) = (energy.energy(&points), definition(&points));
                // The accuracy of the coefficients, with a margin for energies computed from them.
                assert!((fast - slow).abs() < accuracy * (1.0 + slow), "{n}: {fast}, {slow}");
            }
        }
    }

    #[test]
    fn the_gradient_matches_finite_differences_of_energies() {
        const H: f64 = 1e-5;
        let (target, points) = (target(), white(20));
        let transform = TorusBands::new(&target).unwrap();
        let bands = target.bands().to_vec();
        let mut energy = SpectralEnergy::new(transform, bands, CORE, 20).into_fine();
        let mut gradient = Vec::new();
        // The energy is periodic; points need not be in the square.
        let shifted: Vec<DVec2> = points.iter().map(|&p| p - DVec2::new(3.0, -1.0)).collect();
        energy.energy(&shifted);
        energy.gradient(&shifted, &mut gradient);
        let scale = gradient.iter().map(|g| g.length()).fold(0.0, f64::max);
        for k in 0..points.len() {
            for axis in DVec2::AXES {
                let at = |step: f64| {
                    let mut moved = points.clone();
                    moved[k] += step * axis;
                    definition(&moved)
                };
                let slope = (at(H) - at(-H)) / (2.0 * H);
                let off = (slope - gradient[k].dot(axis)).abs();
                // The accuracy of gradients.
                assert!(off < 1e-3 * scale, "point {k}: {slope}, off by {off} of {scale}");
            }
        }
    }

    #[test]
    fn targets_are_even_and_zeros_are_bands_of_their_own() {
        let target = target();
        assert_eq!(target.kmax, 6);
        // 36 frequencies to 3.2, 120 to 6.3.
        let total: f64 = target.bands().iter().map(|b| b.multiplicity).sum();
        assert!((target.constraints() - 36.0).abs() < 0.5, "{}", target.constraints());
        assert!((total - 120.0).abs() < 0.5 && target.has_powers(), "{total}");
        assert!(!RadialTarget::new(0.9, |_| 1.0).unwrap().has_powers());
        let white = RadialTarget::new(9.0, |_| 1.0).unwrap();
        assert!((white.pair_correlation_at_zero(50) - 1.0).abs() < 1e-15);
        let zeros = RadialTarget::new(2.0, |_| 0.0).unwrap();
        assert!(matches!(RadialTarget::new(5e4, |_| 0.0), Err(Error::Degree { .. })));
        assert!((zeros.pair_correlation_at_zero(13)).abs() < 1e-15, "12 of 12 frequencies");
    }
}
