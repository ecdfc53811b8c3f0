use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{Ensemble, PointSet, Progress, checks, toroidal_separation};

use super::{l2_star_discrepancy, star_discrepancy, wraparound_l2_discrepancy};
use crate::Error;
use crate::quality::Unavailable;

/// The measures of one point set of the square.
#[derive(Clone, Debug)]
pub struct SquareQuality {
    /// The number of points.
    pub n_points: usize,
    /// [`PointSet::n_effective`].
    pub n_effective: f64,
    /// [`toroidal_separation`]; `None` for a single point.
    pub separation: Option<f64>,
    /// [`star_discrepancy`]; unavailable for points with weights.
    pub star_discrepancy: Result<f64, Unavailable>,
    /// [`l2_star_discrepancy`]; unavailable for points with weights.
    pub l2_star_discrepancy: Result<f64, Unavailable>,
    /// [`wraparound_l2_discrepancy`]; unavailable for points with weights.
    pub wraparound_l2_discrepancy: Result<f64, Unavailable>,
    /// [`checks::net_parameter`]: the least t of a (t, m, 2)-net in base 2; `None` unless the number
    /// of points is a power of two.
    pub net_parameter: Option<u32>,
}

impl SquareQuality {
    /// Returns the measures of a set.
    ///
    /// # Errors
    ///
    /// [`Error::Sampler`] if `progress` stops the work.
    pub fn new(set: &PointSet<[f64; 2]>, progress: &dyn Progress) -> Result<Self, Error> {
        let of_weighted = || Ok(Err(Unavailable::new("defined for points without weights")));
        let is_weighted = !set.weights.is_empty();
        let of_set = |f: Discrepancy| {
            if is_weighted { of_weighted() } else { f(&set.points, progress) }
        };
        Ok(Self {
            n_points: set.len(),
            n_effective: set.n_effective(),
            separation: toroidal_separation(&set.points, progress)?,
            star_discrepancy: of_set(star_discrepancy)?,
            l2_star_discrepancy: of_set(l2_star_discrepancy)?,
            wraparound_l2_discrepancy: of_set(wraparound_l2_discrepancy)?,
            net_parameter: checks::net_parameter(&set.points),
        })
    }

    /// Returns the measures of the first `count` realizations of an ensemble.
    ///
    /// # Errors
    ///
    /// [`Error::Sampler`] if a set cannot be generated or `progress` stops the work;
    /// [`Error::NoRealizations`] for a count of 0.
    pub fn of(
        sets: &dyn Ensemble<[f64; 2]>,
        count: u64,
        progress: &dyn Progress,
    ) -> Result<Vec<Self>, Error> {
        if count == 0 {
            return Err(Error::NoRealizations);
        }
        let quality = |index| {
            let mut set = PointSet::default();
            sets.realize_into(index, &mut set, progress)?;
            Self::new(&set, progress)
        };
        (0..count).into_par_iter().map(quality).collect()
    }

    /// Returns the separation relative to that of a hexagonal lattice of the same density,
    /// `sqrt(2/(sqrt(3) N))`: at most 1, because the periodic continuation of the points is a packing
    /// of the plane (Thue 1910). `None` for a single point.
    #[must_use]
    pub fn relative_separation(&self) -> Option<f64> {
        let hexagonal = (2.0 / (3f64.sqrt() * self.n_points as f64)).sqrt();
        Some(self.separation? / hexagonal)
    }
}

/// A measure of points without weights.
type Discrepancy =
    fn(&[[f64; 2]], &dyn Progress) -> Result<Result<f64, Unavailable>, sphvar_samplers::Stopped>;

#[cfg(test)]
mod tests {
    use sphvar_samplers::{PointSet, Purpose, SquarePattern, Streams};

    use super::SquareQuality;

    #[test]
    fn measures_distinguish_patterns_and_weights() {
        let quality = |name: &str| {
            let sampler = name.parse::<SquarePattern>().unwrap().build(64).unwrap();
            let rng = &mut Streams::new(0, Purpose::Pattern, 64).realization(0);
            SquareQuality::new(&sampler.sample(rng).unwrap(), &()).unwrap()
        };
        let [sobol, white] = ["sobol", "white-square"].map(quality);
        assert!(sobol.star_discrepancy.unwrap() < 0.6 * white.star_discrepancy.unwrap());
        assert!(sobol.separation > white.separation);
        let weighted = PointSet { points: vec![[0.1; 2], [0.6; 2]], weights: vec![1.0, 2.0] };
        let quality = SquareQuality::new(&weighted, &()).unwrap();
        assert!(quality.star_discrepancy.is_err() && quality.l2_star_discrepancy.is_err());
        assert!((quality.separation.unwrap() - 0.5f64.hypot(0.5)).abs() < 1e-15);
        assert!((quality.n_effective - 1.8).abs() < 1e-15);
        assert_eq!((sobol.net_parameter, quality.net_parameter), (Some(0), Some(0)));
    }

    #[test]
    fn separations_are_relative_to_the_hexagonal_lattice() {
        // 8 rows of 7 points of a triangular lattice, stretched to fit the square.
        let point = |j: usize| {
            let (row, column) = (j / 7, j % 7);
            let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
            [(column as f64 + shift) / 7.0, row as f64 / 8.0]
        };
        let triangular = PointSet::new((0..56).map(point).collect());
        let relative =
            |set: &PointSet<[f64; 2]>| SquareQuality::new(set, &()).unwrap().relative_separation();
        assert!((relative(&triangular).unwrap() - 0.994_858).abs() < 1e-6);
        assert_eq!(relative(&PointSet::new(vec![[0.5; 2]])), None);
        let sets = [triangular.clone(), PointSet::new(vec![[0.25; 2]; 2])];
        let all = SquareQuality::of(&sets.as_slice(), 2, &()).unwrap();
        assert_eq!(all[1].relative_separation(), Some(0.0));
        assert!(SquareQuality::of(&sets.as_slice(), 0, &()).is_err());
    }
}
