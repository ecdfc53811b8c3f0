use std::f64::consts::PI;

use num_complex::Complex;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use sphvar_samplers::{
    Lattice, PointSet, Progress, Purpose, SquareDistribution, SquareRealizations, SquareSampler,
    Streams,
};
use sphvar_sh::{ByAxis, Frequencies, TailClasses};

use super::transform::SquareTransform;
use crate::accumulate::SetTransform;
use crate::exact::EPSILON;
use crate::{Error, Realization, Spectrum, SquareResolution, Workspaces};

/// Number of given sets whose powers are computed together.
const BATCH: usize = 16;

/// Mean power of a sampler of the square in closed form: no realizations, standard errors of 0.
///
/// - Independent uniform points have power 1 at every k != 0.
/// - One uniform point in each cell of a grid of R x C cells has
///   `P(k) = 1 - sinc^2(k1/R) sinc^2(k2/C)` with `sinc x = sin(pi x)/(pi x)`.
/// - A Latin hypercube of N points has `P(k, 0) = P(0, k) = 1 - sinc^2(k/N)` on the axes and
///   `P(k) = 1 + sinc^2(k1/N) sinc^2(k2/N)/(N - 1)` off them.
/// - A lattice of N points has the power N at the frequencies of its dual lattice and 0 elsewhere:
///   a regular grid at multiples of its sides, the rank-1 lattice (j/N, j g/N) where k1 + g k2 is a
///   multiple of N.
/// - Another fixed set has the power of its one set, transformed to `1e-13 N`; a choice between
///   several given sets has their mean power.
///
/// # Examples
///
/// ```
/// use sphvar_samplers::SquarePattern;
/// use sphvar_sh::Frequencies;
/// use sphvar_spectrum::ExactSquareSpectrum;
///
/// let jittered = SquarePattern::JitteredSquare.build(64)?;
/// let frequencies = Frequencies::new(16)?;
/// let spectrum = ExactSquareSpectrum::of(&*jittered).expect("has cells").to(&frequencies, &())?;
/// // 1 - (sin(pi/8)/(pi/8))^2.
/// let band = frequencies.band_of([1, 0]).expect("is in range");
/// assert!((spectrum.power()[band] - 0.0503588).abs() < 1e-7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ExactSquareSpectrum<'a> {
    sampler: &'a dyn SquareSampler,
    kind: Kind<'a>,
}

/// The kind of distribution, which determines the closed form.
#[derive(Debug)]
enum Kind<'a> {
    White,
    Jittered([usize; 2]),
    LatinHypercube(usize),
    Lattice(Lattice),
    Fixed,
    Sets(&'a [PointSet<[f64; 2]>]),
}

impl<'a> ExactSquareSpectrum<'a> {
    /// Returns the spectrum of a sampler; `None` if its distribution has no closed form here.
    #[must_use]
    pub fn of(sampler: &'a dyn SquareSampler) -> Option<Self> {
        let kind = match sampler.distribution() {
            SquareDistribution::Independent => Kind::White,
            SquareDistribution::Jittered { rows, columns } => Kind::Jittered([rows, columns]),
            SquareDistribution::LatinHypercube => Kind::LatinHypercube(sampler.n_points()),
            SquareDistribution::Lattice(lattice) => Kind::Lattice(lattice),
            SquareDistribution::Fixed => Kind::Fixed,
            SquareDistribution::OneOf(sets) => Kind::Sets(sets),
            _ => return None,
        };
        Some(Self { sampler, kind })
    }

    /// Returns the power of all bands. Ticks `progress` with [`Self::work`] in total. The result is
    /// bit-identical for any number of threads.
    ///
    /// # Errors
    ///
    /// [`Error::Sampler`] if the set cannot be generated or `progress` stops the work;
    /// [`Error::SquareTransform`] if memory of the transform cannot be allocated.
    pub fn to(
        &self,
        frequencies: &Frequencies,
        progress: &dyn Progress,
    ) -> Result<Spectrum<Frequencies>, Error> {
        self.to_with(&Workspaces::default(), frequencies, progress)
    }

    /// Returns the result of [`Self::to`], with buffers that are kept for other calls.
    ///
    /// # Errors
    ///
    /// The errors of [`Self::to`].
    pub fn to_with(
        &self,
        workspaces: &Workspaces,
        frequencies: &Frequencies,
        progress: &dyn Progress,
    ) -> Result<Spectrum<Frequencies>, Error> {
        let of_bands = |f: &dyn Fn([i32; 2]) -> f64| {
            let power = (0..frequencies.len()).map(|band| f(frequencies.frequency(band)));
            Spectrum::exact(frequencies.clone(), self.sampler.n_points(), power.collect())
        };
        Ok(match &self.kind {
            Kind::White => of_bands(&|_| 1.0),
            Kind::Jittered(sides) => of_bands(&|k| of_cells(*sides, k)),
            Kind::LatinHypercube(n) => of_bands(&|k| of_hypercube(*n, k)),
            Kind::Lattice(lattice) => {
                let n = lattice.n_points() as f64;
                let [u, v] = lattice.coordinate_multiplicities().map(|count| count as f64);
                of_bands(&|k| if lattice.is_dual(k) { n } else { 0.0 }).with_tail(ByAxis {
                    off: 1.0,
                    u,
                    v,
                })
            }
            Kind::Fixed => {
                let streams = Streams::new(0, Purpose::Pattern, 0);
                let mut set = PointSet::default();
                SquareRealizations::unshifted(self.sampler, streams)
                    .realize_into(0, &mut set, progress)?;
                self.of_sets(workspaces, &[set], frequencies, progress)?
            }
            Kind::Sets(sets) => self.of_sets(workspaces, sets, frequencies, progress)?,
        })
    }

    /// Returns the nominal work of [`Self::to`].
    #[must_use]
    pub fn work(&self, frequencies: &Frequencies) -> f64 {
        let resolution = SquareResolution::new(frequencies.clone());
        match &self.kind {
            Kind::Fixed => {
                let n_points = self.sampler.n_points();
                self.sampler.nominal_work() + resolution.nominal_work(n_points)
            }
            Kind::Sets(sets) => sets.iter().map(|set| resolution.nominal_work(set.len())).sum(),
            _ => 0.0,
        }
    }

    /// Returns the memory in bytes that [`Self::to`] needs on `threads` threads: a lower bound that
    /// includes all large allocations.
    #[must_use]
    pub fn bytes(&self, frequencies: &Frequencies, threads: usize) -> f64 {
        let resolution = SquareResolution::new(frequencies.clone());
        let n_sets = match &self.kind {
            Kind::Fixed => 1,
            Kind::Sets(sets) => sets.len(),
            _ => 0,
        };
        let batch = n_sets.min(BATCH) as f64;
        let transforms = resolution.bytes(self.sampler.n_points(), n_sets as u64, threads);
        16.0 * frequencies.len() as f64 * (1.0 + 1.5 * batch)
            + if n_sets > 0 { transforms } else { 0.0 }
    }

    /// Returns the mean power of sets, each normalized by its own number of points. It is invariant
    /// under shifts.
    fn of_sets(
        &self,
        workspaces: &Workspaces,
        sets: &[PointSet<[f64; 2]>],
        frequencies: &Frequencies,
        progress: &dyn Progress,
    ) -> Result<Spectrum<Frequencies>, Error> {
        let resolution = SquareResolution { frequencies: frequencies.clone(), epsilon: EPSILON };
        let transform = SquareTransform::new(&resolution)?;
        let of_set = |set: &PointSet<[f64; 2]>| {
            let mut set = set.clone();
            set.normalize_weights();
            let mut coefficients: [Vec<Complex<f64>>; 1] = [transform.zeros()?];
            let sets = std::slice::from_ref(&set);
            let mut workspace = workspaces.square.take();
            transform.prepare(&mut workspace, sets.len() == 1);
            transform.run(sets, &mut workspace, &mut coefficients)?;
            workspaces.square.put(workspace);
            let realization = Realization::<Frequencies>::new(0, &set, &coefficients[0]);
            progress.tick(resolution.nominal_work(set.len()))?;
            Ok((realization.n_effective(), realization.power().collect(), realization.tail()))
        };
        let share = 1.0 / sets.len() as f64;
        let (mut n_effective, mut tail) = (0.0, ByAxis::all(0.0));
        let mut mean = vec![0.0; frequencies.len()];
        // The sets are summed in their order, whichever thread transforms them.
        for batch in sets.chunks(BATCH) {
            let of_batch: Result<Vec<(f64, Vec<f64>, ByAxis)>, Error> =
                batch.par_iter().map(of_set).collect();
            for (n, powers, of_tail) in of_batch? {
                n_effective += share * n;
                tail = ByAxis::from_fn(|class| tail.get(class) + share * of_tail.get(class));
                mean.iter_mut().zip(powers).for_each(|(mean, power)| *mean += share * power);
            }
        }
        let spectrum = Spectrum::exact(frequencies.clone(), self.sampler.n_points(), mean);
        Ok(spectrum.with_tail(tail).with_n_effective(n_effective))
    }
}

/// Returns `1 - sinc^2(k1/R) sinc^2(k2/C)` for a grid of R x C cells, with the relative accuracy of
/// small values.
fn of_cells(sides: [usize; 2], k: [i32; 2]) -> f64 {
    let [a, b] = [0, 1].map(|axis| missing(k[axis], sides[axis]));
    a + b - a * b
}

/// Returns the power of a Latin hypercube of n points: two points are in different strips of both
/// coordinates, and independent otherwise.
fn of_hypercube(n: usize, k: [i32; 2]) -> f64 {
    let [a, b] = k.map(|k| missing(k, n));
    match k {
        [_, 0] => a,
        [0, _] => b,
        // A single point has no pairs: both factors are 0.
        _ => 1.0 + (1.0 - a) * (1.0 - b) / (n.max(2) - 1) as f64,
    }
}

/// Returns `1 - sinc^2(k/n)`.
fn missing(k: i32, n: usize) -> f64 {
    let x = PI * f64::from(k.unsigned_abs()) / n as f64;
    // The series of 1 - (sin x/x)^2 to x^14; the next term is below 1e-17 of the first.
    if x < 0.25 {
        let coefficients = [
            1.0 / 3.0,
            -2.0 / 45.0,
            1.0 / 315.0,
            -2.0 / 14_175.0,
            2.0 / 467_775.0,
            -4.0 / 42_567_525.0,
            1.0 / 638_512_875.0,
        ];
        let y = x * x;
        return y * coefficients.iter().rev().fold(0.0, |sum, c| sum * y + c);
    }
    // The angle modulo pi is exact before rounding, so that zeros of the sine are zeros.
    let rest = k.unsigned_abs() as usize % n;
    1.0 - ((PI * rest as f64 / n as f64).sin() / x).powi(2)
}

#[cfg(test)]
mod tests {
    use super::missing;

    #[test]
    fn the_power_of_cells_is_accurate_near_0() {
        // 1 - sinc^2 by its series with sixty digits.
        for (k, n, expected) in [
            (1, 1_000_000, 3.289_868_133_692_123_4e-12),
            (1, 100, 3.289_435_234_921_921_5e-4),
            (5, 63, 2.055_126_902_510_014_2e-2),
            (7, 88, 2.064_401_180_338_847_5e-2),
            (3, 4, 0.909_936_725_651_255_3),
        ] {
            let got = missing(k, n);
            assert!((got / expected - 1.0).abs() < 4e-15, "{k}/{n}: {got:e}, {expected:e}");
        }
        for k in [7, -14, 700] {
            assert!((missing(k, 7) - 1.0).abs() <= 0.0, "{k}");
        }
    }
}
