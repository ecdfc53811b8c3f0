use glam::DVec3;
use rand::RngExt;
use sphvar_samplers::{Domain, PointSet, PointSets};

use super::{BOTH, angle, given, hostile_sets, pairs_of, streams};
use crate::pair_correlation::{AngleBins, DifferentialAccumulator, Differentials, LocalDensity};
use crate::{Error, Resolution, accumulate};

/// Draws points with density 1 + 0.7 z.
fn sloping_set(n: usize, index: u64) -> PointSet {
    let mut rng = streams(6).realization(index);
    let mut set = PointSet::default();
    while set.len() < n {
        let p = sphvar_samplers::uniform_rotation(&mut rng).z_axis;
        if rng.random::<f64>() * 1.7 < 1.0 + 0.7 * p.z {
            set.weights.push(3.0 / (1.0 + 0.7 * p.z));
            set.points.push(p);
        }
    }
    set
}

fn differentials_of(
    sets: &PointSets,
    bins: AngleBins,
    density: LocalDensity<'_>,
) -> Result<Differentials, Error> {
    let empty = DifferentialAccumulator::new(bins, density, &());
    let count = sets.sets().len() as u64;
    accumulate(sets, Resolution::new(4, 100), 0..count, &empty, &()).unwrap().finish()
}

#[test]
fn differentials_at_uniform_density_are_angles() {
    for domain in BOTH {
        for set in hostile_sets() {
            let sets = given(PointSet::new(set.points), domain);
            let bins = AngleBins::new(domain, 1.1, 9).unwrap();
            let g = pairs_of(&sets, bins, 4, 1).g;
            let got = differentials_of(&sets, bins, LocalDensity::Function(&|_| 1.0)).unwrap();
            for (a, b) in got.g.iter().zip(g) {
                assert!((a - b).abs() <= 1e-12 * b, "{domain}: {a}, {b}");
            }
        }
    }
}

/// Independent points of a sloping density: 1 in every bin of small angles. Two pairs with a point
/// in common are hardly correlated, so that counts of 1000 and more are nearly normal: |z| < 5 in
/// 10 bins fails by chance in 6e-6 of seeds. A slope of 0.7 per radian contributes 1e-4.
#[test]
fn differentials_of_independent_points_do_not_depend_on_density() {
    const SETS: u64 = 40;
    let sets: Vec<PointSet> = (0..SETS).map(|i| sloping_set(500, i)).collect();
    let sets = PointSets::new(sets, Domain::Sphere).unwrap();
    let bins = AngleBins::new(Domain::Sphere, 0.15, 10).unwrap();
    let slope = |p: DVec3| 1.0 + 0.7 * p.z;
    let got = differentials_of(&sets, bins, LocalDensity::Function(&slope)).unwrap();
    for (g, error) in got.g.iter().zip(&got.g_stderr) {
        assert!((g - 1.0).abs() < 5.0 * error + 0.005, "{g} +- {error}");
    }
    // Weights 1/p of any scale estimate the same density, up to their mean over the points.
    let weighted = differentials_of(&sets, bins, LocalDensity::InverseWeights).unwrap();
    for ((a, b), error) in weighted.g.iter().zip(&got.g).zip(&got.g_stderr) {
        assert!((a - b).abs() < 2.0 * error + 0.01, "{a}, {b}");
    }
    // Without scaling there are more close pairs, E lambda^2 = 1 + 0.49/3 of uniform points.
    let unscaled = pairs_of(
        &PointSets::new(
            sets.sets().iter().map(|set| PointSet::new(set.points.clone())).collect(),
            Domain::Sphere,
        )
        .unwrap(),
        bins,
        4,
        SETS,
    );
    assert!((unscaled.g[9] - 1.163).abs() < 5.0 * unscaled.g_stderr[9], "{}", unscaled.g[9]);
}

/// Candidates are accepted at a distance of 0.2 in units of the local scale, which varies by a
/// factor of 2.4: the scaled distribution has the gap, the plain one has not.
#[test]
fn adapted_disks_have_a_hard_core_of_scaled_angles() {
    let density = |p: DVec3| 1.0 + 0.7 * p.z;
    let mut rng = streams(7).realization(0);
    let mut points: Vec<DVec3> = Vec::new();
    for _ in 0..4000 {
        let p = sphvar_samplers::uniform_rotation(&mut rng).z_axis;
        let scale = |p: DVec3| density(p).sqrt().recip();
        let is_far = |q: &DVec3| angle(p, *q, Domain::Sphere) > 0.1 * (scale(p) + scale(*q));
        if points.iter().all(is_far) {
            points.push(p);
        }
    }
    let sets = given(PointSet::new(points), Domain::Sphere);
    let bins = AngleBins::new(Domain::Sphere, 0.4, 40).unwrap();
    let scaled = differentials_of(&sets, bins, LocalDensity::Function(&density)).unwrap();
    assert!(scaled.g[..20].iter().all(|g| *g == 0.0) && scaled.g[20] > 1.0, "{:?}", scaled.g);
    let plain = pairs_of(&sets, bins, 4, 1);
    assert!(plain.g[..20].iter().any(|g| *g > 0.0), "{:?}", plain.g);
}

#[test]
fn densities_that_are_not_positive_are_errors() {
    let sets = given(PointSet::new(vec![DVec3::X, DVec3::Y]), Domain::Sphere);
    let bins = AngleBins::natural(Domain::Sphere, 2);
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = differentials_of(&sets, bins, LocalDensity::Function(&|_| wrong)).unwrap_err();
        assert!(error.to_string().contains("local density"), "{error}");
    }
}
