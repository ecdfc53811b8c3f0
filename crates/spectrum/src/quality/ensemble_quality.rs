use sphvar_samplers::{Domain, Ensemble, PointSet, Progress};
use sphvar_sh::Alm;
use sphvar_sht::{Method, Transform, TransformWorkspace};

use super::{
    Hyperuniformity, Measure, ObservedDiscrepancy, SetQuality, TailProbabilities, Unavailable,
    UniformityStatistic, hyperuniformity, hyperuniformity_degree, test_uniformity,
};
use crate::{Accumulator, Error, Moments, Realization, Resolution, SpectrumAccumulator};

/// The measures of an ensemble: those of each realization, and those of all together.
#[derive(Clone, Debug)]
pub struct Quality {
    /// The measures of each realization.
    pub sets: Vec<SetQuality>,
    /// The exponent of the mean power at low degrees.
    pub hyperuniformity: Hyperuniformity,
    /// The test of uniformity by the cap discrepancies.
    pub cap_p_value: Result<TailProbabilities, Unavailable>,
    /// The test of uniformity by the generalized discrepancies.
    pub generalized_p_value: Result<TailProbabilities, Unavailable>,
}

impl Quality {
    /// Returns the measures of the first `count` realizations, with the condition numbers of fits
    /// to each of `degrees`, by default [`SetQuality::default_degrees`].
    ///
    /// # Errors
    ///
    /// [`Error::Sampler`] if a set cannot be generated or `progress` stops the work,
    /// [`Error::NoRealizations`] for a count of 0; those of [`SetQuality::new`].
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
    /// use sphvar_spectrum::quality::{Measure, Quality};
    ///
    /// let lattice = Pattern::FIBONACCI.build(300, Domain::Sphere)?;
    /// let sets = Realizations::rotated(&*lattice, Streams::new(0, Purpose::Pattern, 0));
    /// let quality = Quality::of(&sets, 1, Domain::Sphere, None, &())?;
    /// let scaled = Measure::CapDiscrepancy.scaled(&quality.sets[0]).unwrap();
    /// assert!((scaled - 0.45).abs() < 0.01);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(
        sets: &dyn Ensemble,
        count: u64,
        domain: Domain,
        degrees: Option<&[usize]>,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let mut set = PointSet::default();
        let mut workspace = TransformWorkspace::default();
        let mut of_sets: Vec<SetQuality> = Vec::new();
        let (mut cap, mut generalized) = (Vec::new(), Vec::new());
        let mut spectrum = None;
        for index in 0..count {
            sets.realize_into(index, &mut set, progress)?;
            let chosen;
            let degrees = match degrees {
                Some(degrees) => degrees,
                None => {
                    chosen = SetQuality::default_degrees(set.len(), domain);
                    &chosen
                }
            };
            let quality = SetQuality::new(&set, domain, degrees, progress)?;
            if let Ok(sums) = &quality.sums {
                cap.push(ObservedDiscrepancy::new(&set, sums.cap_discrepancy_l2));
                generalized.push(ObservedDiscrepancy::new(&set, sums.generalized_discrepancy));
            }
            of_sets.push(quality);
            // Sets of different sizes share the degrees of the first one.
            let (lmax, accumulator) = spectrum.get_or_insert_with(|| {
                let lmax = hyperuniformity_degree(set.len(), domain);
                (lmax, SpectrumAccumulator::new(domain, set.len(), lmax))
            });
            set.normalize_weights();
            let alm = coefficients(&set, *lmax, &mut workspace)?;
            accumulator.push(&Realization::new(index, &set, &alm));
            progress.tick(0.0)?;
        }
        let (_, spectrum) = spectrum.ok_or(Error::NoRealizations)?;
        let unavailable = of_sets.iter().find_map(|set| set.sums.as_ref().err());
        let test = |statistic, observed: &[_]| match unavailable {
            Some(reason) => Err(reason.clone()),
            None => test_uniformity(statistic, domain, observed),
        };
        Ok(Self {
            hyperuniformity: hyperuniformity(&spectrum.finish()?)?,
            cap_p_value: test(UniformityStatistic::CapDiscrepancy, &cap),
            generalized_p_value: test(UniformityStatistic::GeneralizedDiscrepancy, &generalized),
            sets: of_sets,
        })
    }

    /// Returns mean and variance of a measure over the sets, scaled or not; `None` unless every set
    /// has it.
    #[must_use]
    pub fn moments(&self, value: impl Fn(&SetQuality) -> Option<f64>) -> Option<Moments> {
        let mut moments = Moments::default();
        for set in &self.sets {
            moments.push(value(set)?);
        }
        Some(moments)
    }

    /// Returns the mean of [`Measure::scaled`].
    #[must_use]
    pub fn mean_scaled(&self, measure: Measure) -> Option<f64> {
        self.moments(|set| measure.scaled(set)).map(|moments| moments.mean())
    }
}

/// Returns the coefficients of a set, whose weights are normalized, to the best accuracy.
pub(super) fn coefficients(
    set: &PointSet,
    lmax: usize,
    workspace: &mut TransformWorkspace,
) -> Result<Alm, Error> {
    let transform = Transform::new(Method::Auto, lmax, set.len(), Resolution::MIN_EPSILON)?;
    let weights = (!set.weights.is_empty()).then_some(&*set.weights);
    let mut alm = Alm::zeros(lmax)?;
    let outs = std::slice::from_mut(&mut alm);
    transform.adjoint_batch_into(&[(&set.points, weights)], workspace, outs);
    Ok(alm)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sphvar_samplers::{Domain, Pattern, PointSet, Purpose, Realizations, Streams};

    use super::Quality;
    use crate::quality::test_sets::icosahedron;
    use crate::quality::{Measure, SetQuality};

    fn one(points: Vec<DVec3>, domain: Domain) -> SetQuality {
        SetQuality::new(&PointSet::new(points), domain, &[1, 2], &()).unwrap()
    }

    #[test]
    fn icosahedron_has_its_known_measures() {
        let set = one(icosahedron(), Domain::Sphere);
        let edge = 4.0 / (10.0 + 2.0 * 5f64.sqrt()).sqrt();
        assert!((set.separation.unwrap() - edge).abs() < 1e-14);
        let covering = 2.0 * (37.377_368_140_649_7f64.to_radians() / 2.0).sin();
        assert!((set.covering_radius.clone().unwrap() - covering).abs() < 1e-14);
        assert!((set.mesh_ratio().unwrap() - 2.0 * covering / edge).abs() < 1e-13);
        assert!((set.sums.unwrap().riesz_energy[1].unwrap() - 49.165_253_058).abs() < 1e-8);
        assert_eq!(set.exact_degree, 5);
        for (_, condition) in set.condition {
            assert!((condition.unwrap() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn degenerate_sets_have_no_ratio_and_no_energy() {
        let single = one(vec![DVec3::Z], Domain::Sphere);
        assert!(single.separation.is_none() && single.mesh_ratio().is_none());
        assert!((single.covering_radius.unwrap() - 2.0).abs() <= 0.0);
        let twice = one(vec![DVec3::Z, DVec3::Z, DVec3::X], Domain::Hemisphere);
        assert_eq!(twice.separation, Some(0.0));
        assert!(twice.mesh_ratio().is_none() && twice.sums.unwrap().riesz_energy == [None; 3]);
    }

    /// Separation, cap discrepancy of sets of 2048 points (Riesz: 200 steps and more).
    #[test]
    fn known_sets_of_2048_points() {
        for (pattern, separation, discrepancy) in
            [("fibonacci", 3.09, 0.4506), ("spiral", 2.00, 0.4512)]
        {
            let pattern: Pattern = pattern.parse().unwrap();
            let sampler = pattern.build(2048, Domain::Sphere).unwrap();
            let sets = Realizations::rotated(&*sampler, Streams::new(0, Purpose::Pattern, 0));
            let quality = Quality::of(&sets, 1, Domain::Sphere, Some(&[]), &()).unwrap();
            let scaled = |measure| quality.mean_scaled(measure).unwrap();
            assert!((scaled(Measure::Separation) - separation).abs() < 0.006, "{pattern}");
            assert!((scaled(Measure::CapDiscrepancy) - discrepancy).abs() < 6e-5, "{pattern}");
            assert!(quality.cap_p_value.unwrap().lower < 1e-100);
        }
    }

    /// Root mean squares of white noise: over 40 sets the squares have relative standard errors
    /// below `sqrt(2/3/40)` each, so that 5 of them are exceeded by chance in 1e-5 of seeds.
    #[test]
    fn white_noise_has_its_closed_form() {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let white = Pattern::WhiteNoise.build(30, domain).unwrap();
            let sets = Realizations::unrotated(&*white, Streams::new(1, Purpose::Pattern, 30));
            let quality = Quality::of(&sets, 40, domain, Some(&[]), &()).unwrap();
            for measure in Measure::ALL {
                let Some(expected) = measure.white_noise(30, domain) else { continue };
                let squares = quality.moments(|set| measure.value(set).map(|d| d * d)).unwrap();
                let ratio = squares.mean() / (expected * expected);
                assert!((ratio - 1.0).abs() < 0.65, "{measure:?}, {domain}: {ratio}");
            }
            // The joint test of all sets.
            let p = quality.cap_p_value.unwrap();
            assert!(p.lower > 1e-4 && p.upper > 1e-4, "{p:?}");
        }
    }
}
