//! Sets with weights against sets in which points are repeated, the definition of whole weights.

use glam::DVec3;
use sphvar_samplers::grammar::ResolveError;
use sphvar_samplers::{
    Domain, FileResolver, Pattern, PointFile, PointFileParameters, PointSet, ProfileTable, Purpose,
    Streams,
};
use sphvar_scene::{DirectionMode, DirectionPlan, Estimator, Integral};

use super::spot::{Spot, covered_share, horizontal};

/// One file of these sets.
struct OneFile(Vec<PointSet>);

impl FileResolver for OneFile {
    fn profile(&self, _: &std::path::Path) -> Result<ProfileTable, ResolveError> {
        Err(ResolveError::new("no profile"))
    }

    fn points(&self, _: &PointFileParameters) -> Result<Vec<PointFile>, ResolveError> {
        let name = "memory".to_owned();
        Ok(vec![PointFile { name, sets: self.0.clone(), ..PointFile::default() }])
    }
}

fn pattern(set: PointSet) -> Pattern {
    Pattern::parse("file:memory", &OneFile(vec![set])).unwrap()
}

fn plan(set: &PointSet, mode: DirectionMode) -> DirectionPlan {
    let pattern = pattern(set.clone());
    let n = DirectionPlan::nearest_count(&pattern, 1, mode);
    DirectionPlan::new(pattern, n, mode, 0).unwrap()
}

/// Returns 25 directions of white noise with weights 1, 2 and 3, and the same points repeated as
/// often as their weights say.
fn weighted_and_repeated(domain: Domain) -> (PointSet, PointSet) {
    let sampler = Pattern::WhiteNoise.build(25, domain).unwrap();
    let mut rng = Streams::new(4, Purpose::Pattern, 0).realization(0);
    let points = sampler.sample(&mut rng).unwrap().points;
    let times = |k: usize| k % 3 + 1;
    let weights = (0..points.len()).map(|k| times(k) as f64).collect();
    let repeated = points.iter().enumerate().flat_map(|(k, &p)| vec![p; times(k)]);
    (PointSet { points: points.clone(), weights }, PointSet::new(repeated.collect()))
}

#[test]
fn whole_weights_are_repeated_points() {
    let spot = Spot::with(vec![horizontal([-0.3, 2.2], [0.1, 1.9], 0.8)]);
    let lamp = horizontal([-9.0, 9.0], [9.0, -9.0], 3.0);
    let integrals = [
        Integral::AmbientOcclusion { max_distance: f64::INFINITY, cosine: false },
        Integral::AmbientOcclusion { max_distance: f64::INFINITY, cosine: true },
        Integral::Irradiance { radiance: &|dir: DVec3| 1.5 + dir.x, albedo: 0.5 },
        Integral::Light { light: &lamp, albedo: 0.5 },
    ];
    let (weighted, repeated) = weighted_and_repeated(Domain::Sphere);
    let scaled = weighted.weights.iter().map(|w| w * 2f64.powi(-900)).collect();
    let scaled = PointSet { weights: scaled, ..weighted.clone() };
    for integral in &integrals {
        for estimator in Estimator::ALL {
            // Sets with other contents are rotated differently, except in this mode.
            let pixel = |set: &PointSet| {
                let sets = plan(set, DirectionMode::Shared).prepare(0).unwrap();
                let image = spot.render(integral, estimator, &sets, 1);
                (image.values[0], image.spreads[0])
            };
            let expected = pixel(&repeated);
            assert!(expected.0 > 0.0, "{integral:?}");
            for set in [&weighted, &scaled] {
                let got = pixel(set);
                // Sums of 50 numbers of about 1.
                let near = |x: f64, y: f64| (x - y).abs() <= 1e-14 * (1.0 + y.abs());
                let agree = near(got.0, expected.0) && near(got.1, expected.1);
                assert!(agree, "{integral:?} {estimator:?}: {got:?}, {expected:?}");
            }
        }
    }
}

/// The weighted estimators are unbiased over rotations, for weights of mixed sign and any scale and
/// for an odd number of points.
#[test]
fn weighted_sets_are_unbiased() {
    let spot = Spot::with(vec![horizontal([-0.3, 2.2], [0.1, 1.9], 0.8)]);
    let exact = 1.0 - covered_share([-0.3, 2.2], [0.1, 1.9], 0.8);
    let ambient = Integral::AmbientOcclusion { max_distance: f64::INFINITY, cosine: false };
    for mode in [DirectionMode::Rotated, DirectionMode::Antipodal, DirectionMode::Fresh] {
        for weights in [[1.0, 3.0, 2.0, 0.5, -1.0], [1e300, 3e300, 2e300, 1e299, -1e300]] {
            let (mut set, _) = weighted_and_repeated(mode.domain());
            set.weights = weights.into_iter().cycle().take(set.len()).collect();
            let sets = plan(&set, mode).prepare(0).unwrap();
            let image = spot.render(&ambient, Estimator::Unbiased, &sets, 48);
            let (mean, error) = super::spot::mean_and_error(&image.values);
            // 6 scores at 4.5 standard errors: one fails by chance for 4e-5 of seeds.
            assert!(
                error > 0.0 && (mean - exact).abs() < 4.5 * error,
                "{mode} {weights:?}: {mean} +- {error}, {exact}"
            );
        }
    }
}

/// Sphere sets need no even number of points, and the modes of hemisphere sets reject points below.
#[test]
fn numbers_of_directions_are_those_of_the_file() {
    let (sphere, _) = weighted_and_repeated(Domain::Sphere);
    let plan = plan(&sphere, DirectionMode::Rotated);
    assert_eq!((plan.n_points(), plan.set_points()), (13, 25));
    assert!(!plan.has_table());
    let hemisphere = pattern(weighted_and_repeated(Domain::Hemisphere).0);
    for mode in DirectionMode::ALL {
        let n = DirectionPlan::nearest_count(&hemisphere, 1000, mode);
        assert_eq!(n, if mode.domain() == Domain::Sphere { 13 } else { 25 }, "{mode}");
    }
}
