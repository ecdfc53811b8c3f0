mod differentials;

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use rand::RngExt;
use sphvar_samplers::{
    Domain, Pattern, PointSet, PointSets, Progress, Purpose, Realizations, Stopped, Streams,
};
use sphvar_sh::legendre_p;

use super::angle_bins::ChordBins;
use super::{AngleBins, HeatSmoothing, PairCorrelation, PairCorrelationAccumulator};
use crate::{Ensemble, ExactSpectrum, Resolution, accumulate};

const BOTH: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

/// Returns the pair correlation of `count` sets.
fn pairs_of(sets: &dyn Ensemble, bins: AngleBins, lmax: usize, count: u64) -> PairCorrelation {
    let empty = PairCorrelationAccumulator::new(bins, lmax, &()).unwrap();
    let sums = accumulate(sets, Resolution::new(lmax, 100), 0..count, &empty, &()).unwrap();
    sums.finish().unwrap()
}

fn given(set: PointSet, domain: Domain) -> PointSets {
    PointSets::new(vec![set], domain).unwrap()
}

fn streams(group: usize) -> Streams {
    Streams::new(5, Purpose::Pattern, group)
}

/// Sets that a grid may get wrong: axes, repeated and antipodal points, a cluster, one point.
fn hostile_sets() -> Vec<PointSet> {
    let mut axes = DVec3::AXES.to_vec();
    axes.extend(DVec3::AXES.map(|p| -p));
    let mut repeated = axes.clone();
    repeated.extend_from_slice(&axes[2..]);
    let cluster = (0..50).map(|i| {
        let x = 1e-5 * f64::from(i);
        DVec3::new(x, 0.3 * x, 1.0).normalize()
    });
    let mut rng = streams(0).realization(0);
    let mut random: Vec<DVec3> = cluster.collect();
    for _ in 0..300 {
        random.push(sphvar_samplers::uniform_rotation(&mut rng).z_axis);
    }
    let weights = (0..random.len()).map(|_| rng.random::<f64>() - 0.2).collect();
    vec![
        PointSet::new(vec![DVec3::Z]),
        PointSet::new(vec![DVec3::Z, DVec3::NEG_Z]),
        PointSet::new(axes),
        PointSet::new(repeated),
        PointSet { points: random, weights },
    ]
}

/// Returns the angle between two points, or lines on the hemisphere.
fn angle(a: DVec3, b: DVec3, domain: Domain) -> f64 {
    let angle = a.cross(b).length().atan2(a.dot(b));
    if domain == Domain::Hemisphere { angle.min(PI - angle) } else { angle }
}

/// Slow definition: every pair. Bins have edges that no angle between axes is near, because those
/// angles are rounded differently.
#[test]
fn histograms_are_those_of_all_pairs() {
    for domain in BOTH {
        let limit = if domain == Domain::Sphere { PI } else { FRAC_PI_2 };
        for set in hostile_sets() {
            let sets = given(set, domain);
            let set = &sets.sets()[0];
            let weight = |k: usize| set.weights.get(k).copied().unwrap_or(1.0);
            for max_angle in [limit, 0.83, 0.11, 3e-4] {
                let bins = AngleBins::new(domain, max_angle, 7).unwrap();
                let mut sums = [0.0; 7];
                for j in 0..set.len() {
                    for k in 0..j {
                        let gamma = angle(set.points[j], set.points[k], domain);
                        if let Some(bin) = bins.bin(gamma) {
                            sums[bin] += 2.0 * weight(j) * weight(k);
                        }
                    }
                }
                let total: f64 = (0..set.len()).map(weight).sum();
                let squares: f64 = (0..set.len()).map(|k| weight(k).powi(2)).sum();
                let got = pairs_of(&sets, bins, 8, 1);
                let edges = bins.upper_edges();
                let mut below = 0.0;
                for (i, sum) in sums.into_iter().enumerate() {
                    let low = if i == 0 { 0.0 } else { edges[i - 1] };
                    let cap = |angle: f64| domain.area() - 2.0 * PI * (1.0 + angle.cos());
                    let cap = |angle: f64| match domain {
                        Domain::Sphere => cap(angle) / (4.0 * PI),
                        Domain::Hemisphere => (cap(angle) + 2.0 * PI) / (2.0 * PI),
                    };
                    let expected = sum / (total * total * (cap(edges[i]) - cap(low)));
                    // The share of a bin of 4e-5 radians, by cosines here, has eight digits.
                    let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * b.abs();
                    assert!(close(got.g[i], expected), "{domain} {}: {i}", set.len());
                    below += sum;
                    let k = domain.area() * below / (total * total - squares);
                    let both_missing = set.len() == 1 && got.k[i].is_nan();
                    assert!(both_missing || close(got.k[i], k), "{domain}: {}, {k}", got.k[i]);
                }
            }
        }
    }
}

/// All pairs: K is the area, and g has the mean 1 - 1/N.
#[test]
fn pairs_at_all_angles_add_up() {
    for domain in BOTH {
        for set in hostile_sets().split_off(1) {
            let sets = given(set, domain);
            let set = &sets.sets()[0];
            let limit = if domain == Domain::Sphere { PI } else { FRAC_PI_2 };
            let bins = AngleBins::new(domain, limit, 30).unwrap();
            let got = pairs_of(&sets, bins, 8, 1);
            let mean: f64 = got.g.iter().zip(bins.shares()).map(|(g, share)| g * share).sum();
            let expected = 1.0 - 1.0 / set.n_effective();
            assert!((mean - expected).abs() < 1e-12, "{domain}: {mean}, {expected}");
            let (k, l) = (got.k[29], got.l[29]);
            assert!((k / domain.area() - 1.0).abs() < 1e-12 && (l - limit).abs() < 1e-6, "{k} {l}");
            let shares: f64 = bins.shares().iter().sum();
            assert!((shares - 1.0).abs() < 1e-14);
        }
    }
}

/// Slow definition: the series of every pair, from the addition theorem.
#[test]
fn smoothed_correlations_are_sums_over_pairs() {
    const LMAX: usize = 24;
    for domain in BOTH {
        for mut set in hostile_sets() {
            // Some points of the cluster and some random ones.
            let mut nth = 0..set.len();
            set.points.retain(|_| nth.next().is_some_and(|k| k < 12 || k % 11 == 0));
            set.weights.truncate(set.points.len());
            let sets = given(set, domain);
            let set = &sets.sets()[0];
            let bins = AngleBins::new(domain, 1.5, 6).unwrap();
            let got = pairs_of(&sets, bins, LMAX, 1);
            let smoothing = HeatSmoothing::new(LMAX, &bins.centres()).unwrap();
            let weight = |k: usize| set.weights.get(k).copied().unwrap_or(1.0);
            let total: f64 = (0..set.len()).map(weight).sum();
            for (gamma, g) in bins.centres().into_iter().zip(got.g_smooth) {
                let mut sum = 0.0;
                for l in (0..=LMAX).step_by(domain.degree_step()) {
                    let damping = (-((l * (l + 1)) as f64) * smoothing.time()).exp();
                    let at = (2 * l + 1) as f64 * damping * legendre_p(l, gamma.cos()).unwrap();
                    for j in 0..set.len() {
                        for k in (0..set.len()).filter(|k| *k != j) {
                            let cos = set.points[j].dot(set.points[k]).clamp(-1.0, 1.0);
                            sum += weight(j) * weight(k) * at * legendre_p(l, cos).unwrap();
                        }
                    }
                }
                let expected = sum / (total * total);
                // Peaks of coinciding points are of the order lmax^2.
                assert!((g - expected).abs() < 1e-9, "{domain} {}: {g}, {expected}", set.len());
            }
        }
    }
}

/// The z-scores of 2 x 25 bins of 8000 and more pairs, nearly normal: |z| < 4.5 fails by chance in
/// 50 x 7e-6 = 3.4e-4 of seeds. With independent weights the same holds for their effective number.
#[test]
fn white_noise_is_uncorrelated() {
    const SETS: u64 = 60;
    for (domain, weighted) in [(Domain::Sphere, false), (Domain::Hemisphere, true)] {
        let sampler = Pattern::WhiteNoise.build(400, domain).unwrap();
        let unweighted = Realizations::unrotated(&*sampler, streams(1));
        let mut sets = Vec::new();
        for i in 0..SETS {
            let mut set = unweighted.realize(i).unwrap();
            if weighted {
                let mut rng = streams(2).realization(i);
                set.weights = set.points.iter().map(|_| rng.random::<f64>() - 0.1).collect();
            }
            sets.push(set);
        }
        let expected = |set: &PointSet| 1.0 - 1.0 / set.n_effective();
        let mean = sets.iter().map(expected).sum::<f64>() / SETS as f64;
        let ensemble = PointSets::new(sets, domain).unwrap();
        let limit = if domain == Domain::Sphere { PI } else { FRAC_PI_2 };
        let bins = AngleBins::new(domain, limit, 25).unwrap();
        let got = pairs_of(&ensemble, bins, 60, SETS);
        let mut square = 0.0;
        for (g, sd) in got.g.iter().zip(&got.g_uniform_stderr) {
            let z = (g - mean) / sd;
            assert!(z.abs() < 4.5, "{domain}: {z}");
            square += z * z;
        }
        // Chi-square with about 24 degrees of freedom: outside of 6.5 to 60 in 2e-4 of seeds.
        assert!((6.5..60.0).contains(&square), "{domain}: {square}");
        // Measured errors of K agree with the exact ones to 60 %, six standard errors of 1/sqrt(118).
        let ratios = got.k_stderr.iter().zip(&got.k_uniform_stderr).take(20).skip(3);
        for (measured, exact) in ratios {
            assert!((0.45..1.6).contains(&(measured / exact)), "{domain}: {measured}, {exact}");
        }
        let errors = got.l.iter().zip(bins.upper_edges()).zip(&got.l_stderr).take(20);
        for ((l, radius), error) in errors {
            assert!((l - radius).abs() < 6.0 * error, "{domain}: {l}, {radius}, {error}");
        }
        // The standard error of the sum rule is about 1/sqrt(degrees of freedom x sets).
        let z = got.sum_rule / got.sum_rule_stderr;
        assert!(z.abs() < 5.0, "{domain}: {} +- {}", got.sum_rule, got.sum_rule_stderr);
    }
}

/// Saturated disks against an independent count of pairs by arccosines, the hard core and the sum
/// rule.
#[test]
fn disks_keep_their_distance() {
    const SETS: u64 = 6;
    let disks = "poisson-disk:mode=saturated".parse::<Pattern>().unwrap();
    let sampler = disks.build(256, Domain::Sphere).unwrap();
    let ensemble = Realizations::rotated(&*sampler, streams(3));
    let bins = AngleBins::new(Domain::Sphere, 0.5, 50).unwrap();
    let got = pairs_of(&ensemble, bins, 128, SETS);
    let mut counts = vec![0.0; 50];
    let mut closest = PI;
    for i in 0..SETS {
        let set = ensemble.realize(i).unwrap();
        let n = set.len() as f64;
        for (j, p) in set.points.iter().enumerate() {
            for q in &set.points[..j] {
                let gamma = p.dot(*q).clamp(-1.0, 1.0).acos();
                closest = f64::min(closest, gamma);
                if let Some(bin) = bins.bin(gamma) {
                    counts[bin] += 2.0 / (n * n * SETS as f64);
                }
            }
        }
    }
    let edge = |i: usize| 0.5 * (i as f64 / 50.0);
    for (i, count) in counts.into_iter().enumerate() {
        let expected = count / (0.5 * (edge(i).cos() - edge(i + 1).cos()));
        assert!((got.g[i] - expected).abs() <= 1e-9 * expected, "{i}: {}, {expected}", got.g[i]);
        // The diameter is about 2.958/sqrt(N); no pair is closer.
        assert!(edge(i + 1) > closest || got.g[i] == 0.0, "{i}: {}", got.g[i]);
    }
    assert!((2.8..3.1).contains(&(closest * 16.0)), "{closest}");
    // Disks touch: the density of pairs at contact is above 2 (Torquato 2002: it diverges).
    let contact = got.g.iter().copied().fold(0.0, f64::max);
    assert!(contact > 2.0, "{contact}");
    // Without pairs in the reach of the kernel; what is left is e^(-d^2/4t) at the distance d.
    assert!((got.sum_rule - 1.0).abs() < 2e-3, "{}", got.sum_rule);
}

/// Jittered points: the mean over sets agrees with the closed form of the spectrum, and pairs with
/// the spectrum. |z| < 5 in 2 x 20 bins fails by chance in 2e-5 of seeds.
#[test]
fn jittered_points_have_the_correlation_of_their_exact_spectrum() {
    const LMAX: usize = 90;
    for domain in BOTH {
        let n = if domain == Domain::Sphere { 48 } else { 24 };
        let sampler = Pattern::Jittered.build(n, domain).unwrap();
        let exact = ExactSpectrum::of(&*sampler).unwrap().to(LMAX, &()).unwrap();
        let bins = AngleBins::new(domain, 1.2, 20).unwrap();
        let smoothing = HeatSmoothing::new(LMAX, &bins.centres()).unwrap();
        let expected = smoothing.pair_correlation(&exact).unwrap();
        let sum_rule = smoothing.sum_rule(&exact).unwrap();
        let ensemble = Realizations::rotated(&*sampler, streams(4));
        let got = pairs_of(&ensemble, bins, LMAX, 400);
        assert!((got.smoothing_width - smoothing.width()).abs() < 1e-15);
        let z = (got.sum_rule - sum_rule) / got.sum_rule_stderr;
        assert!(z.abs() < 5.0, "{domain}: {z}");
        for (i, expected) in expected.into_iter().enumerate() {
            let z = (got.g_smooth[i] - expected) / got.g_smooth_stderr[i];
            assert!(z.abs() < 5.0, "{domain} {i}: {z}");
            // g rises from 0 to 1 over a cell; smoothing by a twentieth of it and the mean over a
            // bin change it by about 1 %.
            let off = (got.g[i] - expected).abs();
            assert!(off < 0.02 + 5.0 * got.g_stderr[i], "{domain} {i}: {}, {expected}", got.g[i]);
        }
        assert!(got.g[0] < 0.2 && (got.g[19] - 1.0).abs() < 0.1, "{domain}");
    }
}

/// Bins by squared chords are those by angles, except at edges.
#[test]
fn chords_have_the_bins_of_their_angles() {
    for (domain, limit) in [(Domain::Sphere, PI), (Domain::Hemisphere, FRAC_PI_2)] {
        for (max_angle, count) in [(limit, 1), (limit, 1000), (0.3, 100), (1e-5, 10_000)] {
            let bins = AngleBins::new(domain, max_angle, count).unwrap();
            let by_chord = ChordBins::new(&bins);
            for i in 0..3001 {
                // 0.3 of a bin from every edge, beyond the last edge too.
                let place = f64::from(i) / 3000.0 * (count as f64 + 2.0);
                let inside = place.floor() + (place.fract().clamp(0.3, 0.7));
                let angle = max_angle * inside / count as f64;
                let square = 4.0 * (0.5 * angle.min(PI)).sin().powi(2);
                let expected = if angle > PI { None } else { bins.bin(angle) };
                assert!(angle > PI || by_chord.bin(square) == expected, "{max_angle} {angle}");
            }
            let last = 4.0 * (0.5 * max_angle).sin().powi(2);
            assert_eq!((by_chord.bin(0.0), by_chord.bin(last)), (Some(0), Some(count - 1)));
        }
    }
}

/// Weights whose sum is 0 have no pair correlation, a single weight has no K.
#[test]
fn numbers_without_meaning_are_nan() {
    let points = vec![DVec3::X, DVec3::X, DVec3::Z];
    let bins = AngleBins::new(Domain::Sphere, 1.0, 2).unwrap();
    let of = |weights: &[f64]| {
        let set = PointSet { points: points.clone(), weights: weights.to_vec() };
        pairs_of(&given(set, Domain::Sphere), bins, 4, 1)
    };
    let empty = of(&[1.0, -2.0, 1.0]);
    let all = [&empty.g, &empty.k, &empty.l, &empty.g_smooth].into_iter().flatten();
    assert!(all.copied().chain([empty.sum_rule]).all(f64::is_nan), "{empty:?}");
    let single = of(&[1.0, 1e-300, 0.0]);
    let all = single.k.iter().chain(&single.l).copied().chain([single.sum_rule]);
    assert!(all.clone().all(f64::is_nan) && single.g[1].abs() <= 0.0, "{single:?}");
}

#[test]
fn correlations_do_not_depend_on_threads() {
    let mut sets = hostile_sets();
    for (i, set) in sets.iter_mut().enumerate() {
        set.weights = (0..set.len()).map(|k| 1.0 / (1.0 + k as f64 + i as f64)).collect();
    }
    let ensemble = PointSets::new(sets, Domain::Hemisphere).unwrap();
    let bins = AngleBins::new(Domain::Hemisphere, 1.0, 11).unwrap();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        // NaN of the single point compares by its text.
        pool.install(|| format!("{:?}", pairs_of(&ensemble, bins, 12, 5)))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn settings_out_of_range_are_errors() {
    for (domain, angle, count) in [
        (Domain::Sphere, 3.2, 5),
        (Domain::Sphere, 0.0, 5),
        (Domain::Sphere, f64::NAN, 5),
        (Domain::Hemisphere, 1.6, 5),
        (Domain::Sphere, 1.0, 0),
        (Domain::Sphere, 1.0, 10_001),
    ] {
        assert!(AngleBins::new(domain, angle, count).is_err(), "{angle}, {count}");
    }
    assert!(HeatSmoothing::new(0, &[0.1]).is_err() && HeatSmoothing::new(4, &[-0.1]).is_err());
    let spectrum = crate::Spectrum::exact(Domain::Sphere, 5, vec![1.0; 4]);
    assert!(HeatSmoothing::new(4, &[0.1]).unwrap().pair_correlation(&spectrum).is_err());
}

/// Work between pairs is stopped too.
#[test]
fn pairs_can_be_stopped() {
    struct After(std::sync::atomic::AtomicU32);
    impl Progress for After {
        fn tick(&self, _: f64) -> Result<(), Stopped> {
            let before = self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            if before < 3 { Ok(()) } else { Err(Stopped) }
        }
    }
    let sampler = Pattern::WhiteNoise.build(3000, Domain::Sphere).unwrap();
    let sets = Realizations::rotated(&*sampler, streams(8));
    let bins = AngleBins::new(Domain::Sphere, PI, 9).unwrap();
    let progress = After(std::sync::atomic::AtomicU32::new(0));
    let empty = PairCorrelationAccumulator::new(bins, 4, &progress).unwrap();
    let error = accumulate(&sets, Resolution::new(4, 3000), 0..2, &empty, &progress).unwrap_err();
    assert_eq!(error, Stopped.into());
}
