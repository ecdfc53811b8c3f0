use sphvar_samplers::{PointSet, Progress, toroidal_separation};

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
        })
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
    }
}
