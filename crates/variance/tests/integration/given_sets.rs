//! Predictions and measurements for given point sets, with weights and with different numbers of
//! points.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use sphvar_integrands::{Cap, Disk, Harmonic, Integrand};
use sphvar_samplers::{
    Domain, Error as SamplerError, Pattern, PointSet, PointSets, Progress, Purpose, Sampler,
    SamplerFamily, Square, SquarePattern, Stopped, Streams,
};
use sphvar_spectrum::Error as SpectrumError;
use sphvar_variance::{
    Candidate, Energy, Error, Goal, PredictionBudget, Predictor, SpectrumOptions, SquarePredictor,
    Trials,
};

fn predictor(integrand: &dyn Integrand) -> Predictor<'_> {
    Predictor::new(integrand, Domain::Sphere, 5, PredictionBudget::DEFAULT).unwrap()
}

/// Returns the six vertices of an octahedron with weight 1/15 each and the eight of a cube with
/// 3/40 each, Lebedev's rule of 14 points, which is exact to degree 5.
fn rule(scale: f64) -> PointSet {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|p| [p, -p]);
    let signs = (0..8).map(|k| [1, 2, 4].map(|bit| if k & bit == 0 { 1.0 } else { -1.0 }));
    let corners = signs.map(|[x, y, z]| DVec3::new(x, y, z).normalize());
    let weights = (0..14).map(|k| if k < 6 { scale / 15.0 } else { scale * 3.0 / 40.0 });
    PointSet { points: axes.chain(corners).collect(), weights: weights.collect() }
}

/// `4 pi sum_jk w_j w_k P_l(x_j . x_k)/((2l+1) (sum w)^2) E_l` for a harmonic of energy 1.
fn by_pairs(set: &PointSet, l: usize) -> f64 {
    let weight = |k: usize| set.weights.get(k).copied().unwrap_or(1.0);
    let (mut sum, mut total) = (0.0, 0.0);
    for (j, a) in set.points.iter().enumerate() {
        total += weight(j);
        for (k, b) in set.points.iter().enumerate() {
            let cos = a.dot(*b).clamp(-1.0, 1.0);
            sum += weight(j) * weight(k) * sphvar_sh::legendre_p(l, cos).unwrap();
        }
    }
    4.0 * std::f64::consts::PI * sum / (total * total)
}

#[test]
fn weighted_rules_have_the_variance_of_their_pairs() {
    for scale in [1.0, 7.0, 1e200, 1e-310] {
        let sets = PointSets::new(vec![rule(scale)], Domain::Sphere).unwrap();
        for (l, m) in [(1, 0), (4, 2), (5, -3), (6, 1), (9, 9)] {
            let harmonic = Harmonic::new(l, m).unwrap();
            let got = predictor(&harmonic).compare(&sets, Trials::new(500), &()).unwrap();
            let expected = by_pairs(&rule(1.0), l);
            // 1e-310 has 14 fewer digits.
            let tolerance = if scale < 1e-300 { 1e-9 } else { 1e-12 };
            let predicted = got.prediction;
            let off = (predicted.variance - expected).abs();
            assert!(off <= tolerance, "Y_{l},{m} {scale:e}: {predicted:?}, {expected}");
            assert!(predicted.stderr <= 0.0);
            if l <= 5 {
                assert!(expected.abs() < 1e-14, "degree {l} is exact");
            } else {
                // 10 scores; one exceeds 4.5 by chance for 7e-5 of seeds.
                assert!(got.z_score().abs() < 4.5, "Y_{l},{m} {scale:e}: {}", got.z_score());
            }
        }
    }
}

/// An ensemble of equally likely sets has the mean of their variances, whatever their sizes.
#[test]
fn several_sets_have_the_mean_variance() {
    let cap = Cap::from_degrees(60.0).unwrap();
    let of = |pattern: Pattern, n: usize| {
        let sampler = pattern.build(n, Domain::Sphere).unwrap();
        sampler.sample(&mut Streams::new(1, Purpose::Pattern, n).realization(0)).unwrap()
    };
    let all = vec![rule(1.0), of(Pattern::WhiteNoise, 40), of(Pattern::FIBONACCI, 25)];
    let single = |set: &PointSet| {
        let sets = PointSets::new(vec![set.clone()], Domain::Sphere).unwrap();
        // To the same degree as the three together, whose number of points is the mean.
        let options = SpectrumOptions { lmax: Some(300), ..Default::default() };
        predictor(&cap).with_options(options).predict(&sets, &()).unwrap().prediction.variance
    };
    let expected = all.iter().map(single).sum::<f64>() / 3.0;
    let sets = PointSets::new(all, Domain::Sphere).unwrap();
    assert!(sets.is_random() && sets.n_points() == 26);
    let options = SpectrumOptions { lmax: Some(300), ..Default::default() };
    let mut predictor = predictor(&cap).with_options(options);
    let got = predictor.compare(&sets, Trials::new(4000), &()).unwrap();
    let predicted = got.prediction;
    assert!((predicted.variance / expected - 1.0).abs() < 1e-12, "{predicted:?}, {expected}");
    assert!(predicted.stderr <= 0.0);
    assert!(got.z_score().abs() < 4.5, "{}", got.z_score());
}

/// Returns points of white noise in the square the first `coincident` of
/// which are equal, with the first weight.
fn unequal(n_points: usize, first: f64, rest: f64, coincident: usize) -> PointSet<[f64; 2]> {
    let white = SquarePattern::WhiteSquare.build(n_points).unwrap();
    let mut set = white.sample(&mut Streams::new(3, Purpose::Pattern, 0).realization(0)).unwrap();
    let at = set.points[0];
    set.points[..coincident].fill(at);
    let weight = |k: usize| if k < coincident { first } else { rest };
    set.weights = (0..n_points).map(weight).collect();
    set
}

/// Returns directions of an equal-area map of the square.
fn on_sphere(set: &PointSet<[f64; 2]>) -> PointSet {
    let direction = |&[u, v]: &[f64; 2]| {
        let (z, azimuth) = (2.0 * v - 1.0, u * std::f64::consts::TAU);
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * azimuth.cos(), radius * azimuth.sin(), z)
    };
    PointSet { points: set.points.iter().map(direction).collect(), weights: set.weights.clone() }
}

/// Trials that see only points without influence measure nothing: most of the variance comes from
/// points that fewer than one of them is expected to place in the integrand's support.
#[test]
fn unseen_points_of_large_weight_leave_a_variance_unknown() {
    let cap = Cap::from_degrees(0.2).unwrap();
    let disk = Disk::new(0.001, [0.5, 0.5]).unwrap();
    for sets in [
        // One weight, also negative, exceeds all others together.
        vec![unequal(1001, 5.0, 1e-4, 1)],
        vec![unequal(1001, -7.0, 1e-3, 1)],
        // Coincident points of the same weight as others.
        vec![unequal(1500, 1.0, 1.0, 500)],
        // A tenth of the sets has a few points.
        (0..10).map(|i| unequal(if i == 0 { 2 } else { 1000 }, 1.0, 1.0, 1)).collect(),
    ] {
        let directions = sets.iter().map(on_sphere).collect();
        let directions = PointSets::new(directions, Domain::Sphere).unwrap();
        let options = SpectrumOptions { lmax: Some(32), ..Default::default() };
        let mut on_sphere = predictor(&cap).with_options(options);
        let sphere = on_sphere.compare(&directions, Trials::new(4000), &()).unwrap();
        let points = PointSets::new(sets, Square).unwrap();
        let on_square = SquarePredictor::new(&disk, 5, PredictionBudget::DEFAULT).unwrap();
        let mut on_square = on_square.with_options(options);
        let square = on_square.compare(&points, Trials::new(4000), &()).unwrap();
        for (z, bias, interval) in [
            (sphere.z_score(), sphere.bias(), sphere.measured_interval(0.95)),
            (square.z_score(), square.bias(), square.measured_interval(0.95)),
        ] {
            assert!(
                z.is_nan() && bias.is_none() && interval.is_none(),
                "{z}, {bias:?}, {interval:?}"
            );
        }
    }
}

/// The tail and its error count sets as the variance does, by the mean of `1/N_eff`.
#[test]
fn tails_of_several_sets_count_each_by_its_effective_number() {
    let cap = Cap::from_degrees(10.0).unwrap();
    let predict = |sets: Vec<PointSet>| {
        let sets = PointSets::new(sets, Domain::Sphere).unwrap();
        let options = SpectrumOptions { lmax: Some(60), ..Default::default() };
        predictor(&cap).with_options(options).predict(&sets, &()).unwrap().prediction
    };
    let white = |seed: u64, weights: &dyn Fn(usize) -> f64| {
        let sampler = Pattern::WhiteNoise.build(40, Domain::Sphere).unwrap();
        let mut rng = Streams::new(seed, Purpose::Pattern, 40).realization(0);
        let points = sampler.sample(&mut rng).unwrap().points;
        PointSet { points, weights: (0..40).map(weights).collect() }
    };
    let (heavy, plain) = (white(1, &|k| if k == 0 { 1.0 } else { 1e-3 }), white(2, &|_| 1.0));
    let singles = [heavy.clone(), plain.clone()].map(|set| predict(vec![set]));
    let is_near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
    let twice = predict(vec![heavy.clone(), heavy.clone()]);
    assert!(is_near(twice.tail, singles[0].tail), "{twice:?}, {singles:?}");
    assert!(is_near(twice.tail_error, singles[0].tail_error), "{twice:?}, {singles:?}");
    let both = predict(vec![heavy, plain]);
    let mean = 0.5 * (singles[0].tail + singles[1].tail);
    assert!(singles[0].tail > 30.0 * singles[1].tail, "{singles:?}");
    assert!(is_near(both.tail, mean), "{both:?}, {singles:?}");
    let largest = 0.5 * (singles[0].tail_error + singles[1].tail_error) * (1.0 + 1e-12);
    assert!(both.tail_error > 0.0 && both.tail_error <= largest, "{both:?}, {singles:?}");
}

#[test]
fn unpredictable_sets_return_an_explaining_error() {
    let cap = Cap::from_degrees(60.0).unwrap();
    let nothing = PointSet { points: vec![DVec3::X, DVec3::Y], weights: vec![1.0, -1.0] };
    let nothing = PointSets::new(vec![rule(1.0), nothing], Domain::Sphere).unwrap();
    let message = predictor(&cap).predict(&nothing, &()).unwrap_err().to_string();
    assert!(message.contains("set 1") && message.contains("sum is 0"), "{message}");
    let above = Pattern::FIBONACCI.build(10, Domain::Hemisphere).unwrap();
    let elsewhere = predictor(&cap).predict(&*above, &()).unwrap_err();
    assert!(matches!(elsewhere, Error::OtherDomain { .. }), "{elsewhere}");
}

/// Every stage returns an error if the progress stops the work.
#[test]
fn work_can_be_stopped() {
    struct Never;
    impl Progress for Never {
        fn tick(&self, _: f64) -> Result<(), Stopped> {
            Err(Stopped)
        }
    }
    let cap = Cap::from_degrees(60.0).unwrap();
    let stopped = Err(Error::Spectrum(SpectrumError::Sampler(SamplerError::Stopped(Stopped))));
    for name in ["poisson-disk", "jittered", "fibonacci", "step"] {
        let pattern = name.parse::<Pattern>().unwrap();
        let sampler = pattern.build(48, Domain::Sphere).unwrap();
        assert_eq!(predictor(&cap).predict(&*sampler, &Never).map(|_| ()), stopped, "{name}");
        let mut predictor = predictor(&cap);
        let known = predictor.predict(&*sampler, &()).unwrap();
        let measured = predictor.measure(known.prediction, &*sampler, Trials::new(10), &Never);
        assert_eq!(measured.map(|_| ()), stopped, "{name}");
    }
}

/// An integrand whose evaluation fails causes an error instead of a result.
#[test]
fn values_that_fail_are_errors() {
    struct Failing(Cap);
    impl Integrand for Failing {
        fn eval(&self, dir: DVec3) -> f64 {
            self.0.eval(dir)
        }
        fn eval_into(&self, _: &[DVec3], _: &mut [f64]) -> Result<(), sphvar_integrands::Error> {
            Err(sphvar_integrands::Error::Evaluation { reason: "the file ended".to_owned() })
        }
        fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, sphvar_integrands::Error> {
            self.0.energy(domain, lmax)
        }
    }
    let failing = Failing(Cap::from_degrees(60.0).unwrap());
    let sampler = Pattern::Jittered.build(48, Domain::Sphere).unwrap();
    let message =
        predictor(&failing).compare(&*sampler, Trials::new(10), &()).unwrap_err().to_string();
    assert!(message.contains("the file ended"), "{message}");
}

/// A user's family that builds a number of points other than the requested one would be ranked at
/// the wrong N.
#[test]
fn families_build_the_requested_count() {
    #[derive(Clone, Debug)]
    struct OneMore;
    impl std::fmt::Display for OneMore {
        fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("one-more")
        }
    }
    impl SamplerFamily for OneMore {
        fn build(&self, n: usize, domain: Domain) -> Result<Box<dyn Sampler>, SamplerError> {
            Pattern::FIBONACCI.build(n + 1, domain)
        }
    }
    let cap = Cap::from_degrees(60.0).unwrap();
    for goal in [Goal::Points(10), Goal::Variance { variance: 0.1, max_points: 100 }] {
        let message =
            Candidate::new(OneMore, goal, &mut predictor(&cap), &()).unwrap_err().to_string();
        assert!(message.contains("one-more") && message.contains("was built with"), "{message}");
    }
}

/// A search that is stopped at any point returns an error, since a partial result would be mistaken
/// for the answer.
#[test]
fn searches_can_be_stopped_anywhere() {
    struct After(AtomicU64, u64);
    impl Progress for After {
        fn tick(&self, _: f64) -> Result<(), Stopped> {
            if self.0.fetch_add(1, Ordering::Relaxed) < self.1 { Ok(()) } else { Err(Stopped) }
        }
    }
    let cap = Cap::from_degrees(60.0).unwrap();
    let stopped = Error::Spectrum(SpectrumError::Sampler(SamplerError::Stopped(Stopped)));
    let pattern = "spiral".parse::<Pattern>().unwrap();
    for goal in [Goal::Points(100), Goal::Variance { variance: 0.02, max_points: 1000 }] {
        let mut ends = [0, 0];
        // Every one of the first ticks, then steps of a tenth.
        let limits = std::iter::successors(Some(0), |allowed| Some(allowed + 1 + allowed / 10));
        for allowed in limits.take_while(|&allowed| allowed < 1000) {
            let progress = After(AtomicU64::new(0), allowed);
            let got = Candidate::new(pattern.clone(), goal, &mut predictor(&cap), &progress);
            let is_stopped = progress.0.into_inner() > allowed;
            assert_eq!(got.err(), is_stopped.then(|| stopped.clone()), "{goal:?} {allowed}");
            ends[usize::from(!is_stopped)] += 1;
            if !is_stopped {
                break;
            }
        }
        assert!(ends[0] > 2 && ends[1] == 1, "{goal:?} {ends:?}");
    }
}

/// A user's points are ranked beside patterns. The points of a pattern have its predicted variance.
#[test]
fn given_sets_are_ranked_beside_patterns() {
    let cap = Cap::from_degrees(60.0).unwrap();
    let fibonacci = Pattern::FIBONACCI.build(333, Domain::Sphere).unwrap();
    let set = fibonacci.sample(&mut Streams::new(0, Purpose::Pattern, 0).realization(0)).unwrap();
    let sets = PointSets::new(vec![set], Domain::Sphere).unwrap().with_name("mine");
    let families: [&dyn SamplerFamily; 3] = [&Pattern::Jittered, &sets, &Pattern::FIBONACCI];
    let (mut predictor, goal) = (predictor(&cap), Goal::Points(333));
    let mut candidates: Vec<_> = families
        .into_iter()
        .map(|family| Candidate::new(family, goal, &mut predictor, &()).unwrap())
        .collect();
    sphvar_variance::rank(&mut candidates, goal);
    let names: Vec<String> = candidates.iter().map(|c| c.curve.pattern().to_string()).collect();
    assert_eq!(names[2], "jittered");
    let [first, second] = [0, 1].map(|i| candidates[i].variance.unwrap().0);
    assert!((first / second - 1.0).abs() < 1e-12, "{names:?}: {first}, {second}");
    // A single number of points has no rate, and no other number that an error could need.
    let mine = candidates.iter().find(|c| c.curve.pattern().to_string() == "mine").unwrap();
    assert!(mine.n_points == Some(333) && mine.curve.points().len() == 1);
    for (variance, needed) in [(2.0 * first, Some(333)), (0.5 * first, None)] {
        let goal = Goal::Variance { variance, max_points: 10_000 };
        let candidate = Candidate::new(&sets, goal, &mut predictor, &()).unwrap();
        assert_eq!(candidate.n_points, needed);
    }
}
