use std::f64::consts::PI;

use glam::DVec3;
use sphvar_samplers::{
    Domain, Pattern, PointSet, Progress, Purpose, Stopped, Streams, riesz_energy,
};
use sphvar_sh::{CompensatedSum, legendre_p_into};

use super::{Measure, Nodes, PairSums, RIESZ_EXPONENTS, SetQuality, WORST_CASE_SMOOTHNESS};
use crate::Error;

fn sample(pattern: Pattern, n: usize, domain: Domain) -> PointSet {
    let mut rng = Streams::new(11, Purpose::Pattern, n).realization(0);
    pattern.build(n, domain).unwrap().sample(&mut rng).unwrap()
}

fn fibonacci(n: usize) -> PointSet {
    sample(Pattern::FIBONACCI, n, Domain::Sphere)
}

fn white(n: usize) -> PointSet {
    sample(Pattern::WhiteNoise, n, Domain::Sphere)
}

/// Weights of both signs whose sizes differ by a factor of 1000.
fn weighted(mut set: PointSet) -> PointSet {
    let weight = |k: usize| (1.0 - 1.3 * (k % 3) as f64) * 10f64.powf((k % 4) as f64) + 400.0;
    set.weights = (0..set.len()).map(weight).collect();
    set
}

fn octahedron() -> Vec<DVec3> {
    DVec3::AXES.into_iter().flat_map(|p| [p, -p]).collect()
}

/// The six measures that are finite for all sets.
fn finite(sums: &PairSums) -> Vec<f64> {
    let mut all = vec![sums.cap_discrepancy_l2, sums.generalized_discrepancy];
    all.extend(sums.worst_case_error);
    all
}

fn assert_near(got: &PairSums, expected: &PairSums, tolerance: f64, context: &str) {
    for (i, (a, b)) in finite(got).into_iter().zip(finite(expected)).enumerate() {
        let off = (a / b - 1.0).abs();
        assert!(off <= tolerance, "{context}: measure {i}: {a}, {b}, {off:.1e}");
    }
    for (i, (a, b)) in got.riesz_energy.into_iter().zip(expected.riesz_energy).enumerate() {
        let (Some(a), Some(b)) = (a, b) else {
            assert_eq!(a, b, "{context}: energy {i}");
            continue;
        };
        // The logarithmic energy has terms of both signs.
        let off = (a - b).abs() / b.abs().max(1.0);
        assert!(off <= tolerance, "{context}: energy {i}: {a}, {b}");
    }
}

#[test]
fn fast_sums_match_direct_ones() {
    let mut cases = vec![
        ("one point", white(1), Domain::Sphere),
        ("antipodes", PointSet::new(vec![DVec3::Z, DVec3::NEG_Z]), Domain::Sphere),
        ("octahedron", PointSet::new(octahedron()), Domain::Sphere),
        ("lattice", fibonacci(10_000), Domain::Sphere),
        ("white noise", white(3000), Domain::Sphere),
        ("weighted", weighted(white(300)), Domain::Sphere),
        ("hemisphere", sample(Pattern::Jittered, 384, Domain::Hemisphere), Domain::Hemisphere),
    ];
    let mut hostile = weighted(white(100));
    for k in 0..100 {
        let p = hostile.points[k];
        hostile.points.push(if k % 2 == 0 { p } else { (p + 1e-7 * DVec3::X).normalize() });
        hostile.weights.push(-0.3 * hostile.weights[k]);
    }
    cases.push(("repeated and close", hostile, Domain::Sphere));
    for (name, set, domain) in cases {
        let direct = PairSums::direct(&set, domain, &()).unwrap();
        let fast = PairSums::fast(&set, domain, 1e-10, &()).unwrap();
        assert_near(&fast, &direct, 1e-10, name);
    }
}

/// The series over degrees, with the power of pairs by Legendre polynomials.
#[test]
fn worst_case_errors_match_their_series() {
    const LAST: usize = 4000;
    for (name, set) in [("white", weighted(white(12))), ("octahedron", PointSet::new(octahedron()))]
    {
        let total: f64 = (0..set.len()).map(|k| set.weights.get(k).unwrap_or(&1.0)).sum();
        let w = |k: usize| set.weights.get(k).unwrap_or(&1.0) / total;
        let mut power = vec![0.0; LAST + 1];
        let mut legendre = vec![0.0; LAST + 1];
        for j in 0..set.len() {
            for k in 0..set.len() {
                let x =
                    if j == k { 1.0 } else { set.points[j].dot(set.points[k]).clamp(-1.0, 1.0) };
                legendre_p_into(x, &mut legendre).unwrap();
                power.iter_mut().zip(&legendre).for_each(|(power, p)| *power += w(j) * w(k) * p);
            }
        }
        let got = PairSums::direct(&set, Domain::Sphere, &()).unwrap();
        for (i, s) in WORST_CASE_SMOOTHNESS.into_iter().enumerate() {
            let term = |l: usize| (2 * l + 1) as f64 * (1.0 + (l * (l + 1)) as f64).powf(-s);
            let sum: f64 = (1..=LAST).rev().map(|l| term(l) * power[l]).sum();
            let squares: f64 = (0..set.len()).map(|k| w(k) * w(k)).sum();
            let rest = squares * (LAST as f64 + 1.0).powf(2.0 - 2.0 * s) / (s - 1.0);
            let expected = (sum + rest).sqrt();
            let off = (got.worst_case_error[i] / expected - 1.0).abs();
            // The power at high degrees fluctuates about its mean.
            let tolerance = 1e-12 + rest / sum / 30.0;
            assert!(off < tolerance, "{name}, s = {s}: off by {off:.1e}, at most {tolerance:.1e}");
        }
    }
}

/// Closed forms by their definitions.
#[test]
fn discrepancies_and_energies_match_their_definitions() {
    let set = weighted(white(40));
    let total: f64 = set.weights.iter().sum();
    let (mut cap, mut cui_freeden, mut energies) = (0.0, 0.0, [0.0; 3]);
    for (j, p) in set.points.iter().enumerate() {
        for (k, q) in set.points.iter().enumerate() {
            let w = set.weights[j] * set.weights[k] / (total * total);
            let r = p.distance(*q);
            cap += w * (4.0 / 3.0 - r) / 4.0;
            cui_freeden += w * (1.0 - 2.0 * (0.5 * r).ln_1p()) / (4.0 * PI);
            if k < j {
                let factor = w * set.n_effective().powi(2);
                energies[0] -= factor * r.ln();
                energies[1] += factor / r;
                energies[2] += factor / (r * r);
            }
        }
    }
    let got = PairSums::direct(&set, Domain::Sphere, &()).unwrap();
    assert!((got.cap_discrepancy_l2 / cap.sqrt() - 1.0).abs() < 1e-13);
    assert!((got.generalized_discrepancy / cui_freeden.sqrt() - 1.0).abs() < 1e-13);
    for (got, expected) in got.riesz_energy.into_iter().zip(energies) {
        assert!((got.unwrap() - expected).abs() < 1e-12 * expected.abs().max(1.0));
    }
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let set = sample(Pattern::WhiteNoise, 60, domain);
        let got = PairSums::direct(&set, domain, &()).unwrap().riesz_energy;
        for (s, got) in RIESZ_EXPONENTS.into_iter().zip(got) {
            let expected = riesz_energy(&set.points, domain, s);
            assert!((got.unwrap() / expected - 1.0).abs() < 1e-12, "{domain}, s = {s}");
        }
    }
}

#[test]
fn published_values_are_reproduced() {
    let sums = |set: &PointSet| PairSums::new(set, Domain::Sphere, &()).unwrap();
    // Thomson's problem (Wales and Ulker 2006): tetrahedron, octahedron, icosahedron.
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut icosahedron = Vec::new();
    for (a, b) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
        icosahedron.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
    }
    let tetrahedron = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let tetrahedron = tetrahedron.map(|(x, y)| DVec3::new(x, y, x * y));
    for (points, expected) in [
        (tetrahedron.to_vec(), 3.674234614),
        (octahedron(), 9.985281374),
        (icosahedron, 49.165253058),
    ] {
        let set = PointSet::new(points.into_iter().map(DVec3::normalize).collect());
        let got = sums(&set).riesz_energy[1].unwrap();
        assert!((got - expected).abs() < 1e-9, "{got}, {expected}");
    }
    // One point: D^2 = K(0). The series of s = 2 is 1 + 1/3 + ... = 0.4 less degree 0.
    let one = sums(&PointSet::new(vec![DVec3::X]));
    assert!((one.cap_discrepancy_l2 - 3f64.sqrt().recip()).abs() < 1e-15);
    assert!((one.generalized_discrepancy - (4.0 * PI).sqrt().recip()).abs() < 1e-15);
    assert_eq!(one.riesz_energy, [Some(0.0), Some(0.0), Some(0.0)]);
    // 0.4506 N^(-3/4), theory.md; Brauchart et al. 2014 have 0.45 for quasi-Monte Carlo designs.
    let lattice = sums(&fibonacci(2048));
    let scaled = lattice.cap_discrepancy_l2 * 2048f64.powf(0.75);
    assert!((scaled - 0.4506).abs() < 1e-4, "{scaled}");
    // Near the conjectured constants -0.0278, -0.5530 and -0.0429 from above.
    let constants = lattice.riesz_constants(2048.0, Domain::Sphere).map(Option::unwrap);
    for (got, least) in constants.into_iter().zip([-0.0278, -0.5530, -0.0429]) {
        assert!((least..least + 0.008).contains(&got), "{got}, at least {least}");
    }
}

#[test]
fn hemisphere_sums_are_those_of_the_antipodal_set() {
    for n in [1, 2, 70] {
        let half = sample(Pattern::WhiteNoise, n, Domain::Hemisphere);
        let both = half.points.iter().flat_map(|p| [*p, -*p]).collect();
        let on_sphere = PairSums::direct(&PointSet::new(both), Domain::Sphere, &()).unwrap();
        let got = PairSums::direct(&half, Domain::Hemisphere, &()).unwrap();
        for (a, b) in finite(&got).into_iter().zip(finite(&on_sphere)) {
            assert!((a / b - 1.0).abs() < 1e-13, "{n}: {a}, {b}");
        }
        let constants = got.riesz_constants(n as f64, Domain::Hemisphere);
        let expected = on_sphere.riesz_constants(2.0 * n as f64, Domain::Sphere);
        for (a, b) in constants.into_iter().zip(expected) {
            assert!((a.unwrap() - b.unwrap()).abs() < 1e-12, "{n}: {a:?}, {b:?}");
        }
    }
}

#[test]
fn results_depend_neither_on_order_nor_on_scale_nor_on_threads() {
    let set = weighted(white(500));
    let expected = PairSums::fast(&set, Domain::Sphere, 1e-10, &()).unwrap();
    let mut other = set.clone();
    other.points.reverse();
    other.weights.reverse();
    // A power of two changes no digit.
    other.weights.iter_mut().for_each(|w| *w *= 2f64.powi(-1000));
    // Points without weight do not count.
    other.points.extend([DVec3::Z; 2]);
    other.weights.extend([0.0; 2]);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let got = pool.install(|| PairSums::fast(&other, Domain::Sphere, 1e-10, &())).unwrap();
    assert_near(&got, &expected, 1e-13, "reversed");
    let again = pool.install(|| PairSums::fast(&set, Domain::Sphere, 1e-10, &())).unwrap();
    assert_eq!(again, expected);
}

#[test]
fn identical_points_are_one_point_of_their_weight() {
    let many = PointSet::new(vec![DVec3::Z; 300_000]);
    let got = PairSums::new(&many, Domain::Sphere, &()).unwrap();
    let one = PairSums::new(&PointSet::new(vec![DVec3::Z]), Domain::Sphere, &()).unwrap();
    for (a, b) in finite(&got).into_iter().zip(finite(&one)) {
        assert!((a / b - 1.0).abs() < 1e-10, "{a}, {b}");
    }
    assert_eq!(got.riesz_energy, [None; 3]);
    assert_eq!(got.riesz_constants(3e5, Domain::Sphere), [None; 3]);
    // Equal up to rounding.
    let p = DVec3::new(0.6, 0.48, 0.64);
    let close = PointSet::new(vec![p, p + f64::EPSILON * DVec3::X, DVec3::NEG_X]);
    for sums in
        [PairSums::direct(&close, Domain::Sphere, &()), PairSums::new(&close, Domain::Sphere, &())]
    {
        assert_eq!(sums.unwrap().riesz_energy, [None; 3]);
    }
    // A point of the equator and its antipode are one line.
    let line = PointSet::new(vec![DVec3::X, DVec3::NEG_X]);
    let sums = PairSums::direct(&line, Domain::Hemisphere, &()).unwrap();
    assert_eq!(sums.riesz_energy, [None; 3]);
}

#[test]
fn invalid_sets_and_settings_are_errors() {
    let sums = |points: Vec<DVec3>, weights: Vec<f64>| {
        PairSums::new(&PointSet { points, weights }, Domain::Sphere, &())
    };
    let (x, y) = (DVec3::X, DVec3::Y);
    for (points, weights, part) in [
        (vec![], vec![], "no points"),
        (vec![x, y], vec![1.0], "1 weights"),
        (vec![x, y], vec![1.0, -1.0], "sum of the weights is 0"),
        (vec![x, y], vec![1.0, f64::NAN], "not finite"),
        (vec![x, DVec3::ZERO], vec![], "no direction"),
    ] {
        let message = sums(points, weights).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
    for accuracy in [f64::NAN, 0.0, 1e-12, 0.1] {
        let result = PairSums::fast(&white(5), Domain::Sphere, accuracy, &());
        assert!(matches!(result, Err(Error::Setting { .. })), "{accuracy}: {result:?}");
    }
    // 3e5 points within 0.001 of a pole have 4.5e10 pairs.
    let mut cluster = white(300_000);
    cluster.points.iter_mut().for_each(|p| *p = (DVec3::Z + 1e-3 * *p).normalize());
    let result = PairSums::new(&cluster, Domain::Sphere, &());
    let Err(Error::NearPairs { pairs, .. }) = result else { panic!("{result:?}") };
    assert!((pairs / 4.5e10 - 1.0).abs() < 0.01, "{pairs}");
    // The other measures are available.
    let quality = SetQuality::new(&cluster, Domain::Sphere, &[], &()).unwrap();
    assert!(quality.sums.is_err() && quality.separation.is_some());
    assert_eq!(Measure::CapDiscrepancy.scaled(&quality), None);
    assert_eq!(Measure::RieszEnergy(1).scaled(&quality), None);
}

/// Points in a cap of some degrees take more degrees than evenly spread ones.
#[test]
fn clusters_raise_the_degree() {
    let n = 200_000;
    let mut cluster = white(n);
    cluster.points.iter_mut().for_each(|p| *p = (DVec3::Z + 0.1 * *p).normalize());
    let split = super::Split::new(n, 1e-10);
    let nodes = Nodes::new(&cluster, Domain::Sphere, split.radius() / 3.0).unwrap();
    let before = nodes.estimated_pairs(split.radius());
    let radius = split.radius();
    let (split, pairs) = split.for_near_pairs(&nodes);
    assert!(before > 5e9 && pairs < 0.5 * before, "{before:e}, {pairs:e}");
    assert!(split.radius() < 0.51 * radius);
}

#[test]
fn the_work_can_be_stopped_and_is_announced() {
    struct Stop;
    impl Progress for Stop {
        fn tick(&self, _: f64) -> Result<(), Stopped> {
            Err(Stopped)
        }
    }
    for result in [
        PairSums::direct(&white(100), Domain::Sphere, &Stop),
        PairSums::fast(&white(100), Domain::Sphere, 1e-10, &Stop),
    ] {
        assert_eq!(result, Err(Stopped.into()));
    }

    #[derive(Default)]
    struct Count(std::sync::Mutex<[f64; 2]>);
    impl Progress for Count {
        fn tick(&self, work: f64) -> Result<(), Stopped> {
            self.0.lock().unwrap()[0] += work;
            Ok(())
        }
        fn expect(&self, work: f64) {
            self.0.lock().unwrap()[1] += work;
        }
    }
    for n in [3, 5000, 40_000] {
        let count = Count::default();
        PairSums::new(&fibonacci(n), Domain::Sphere, &count).unwrap();
        let [done, expected] = *count.0.lock().unwrap();
        assert!((done / expected - 1.0).abs() < 0.05, "{n}: {done} of {expected}");
    }
}

/// Degree 1 against a compensated sum of heights; sums in sorted order are off by 5e-18.
#[test]
fn rounding_does_not_hide_low_coefficients() {
    let nodes = Nodes::new(&fibonacci(50_000), Domain::Sphere, 0.1).unwrap();
    let heights = nodes.z.iter().zip(&nodes.w).map(|(z, w)| z * w);
    let expected = (0.75 / PI).sqrt() * heights.collect::<CompensatedSum>().value();
    let got = super::split::exact(&nodes, 1, &()).unwrap().coefficient(1, 0).re;
    assert!((got - expected).abs() < 1e-18, "{got:e}, {expected:e}");
}
