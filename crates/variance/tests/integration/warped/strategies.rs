//! Several densities, each with points of its own.

use glam::DVec3;
use sphvar_integrands::{Domain, Heuristic, Integrand, Strategy};
use sphvar_samplers::Purpose;
use sphvar_variance::{
    Candidate, Error, Goal, PredictionBudget, SquarePredictor, Trials, WarpedPattern,
    WarpedPredictor, WarpedRealizations, best_shares,
};

use super::{Map, integrand, pulled_back, warped};

const BUDGET: PredictionBudget = PredictionBudget::DEFAULT;
const FUNCTION: &str = "vmf:kappa=6 @ 60/0 + 0.1 * cap:degrees=180";

/// Returns `int w_i^2 f^2/p_i - (int w_i f)^2` of every strategy, the variances of single points,
/// by a sum over directions that knows nothing of the maps.
fn variances_of_points(
    function: &dyn Integrand,
    strategies: &[Strategy],
    heuristic: Heuristic,
) -> Vec<f64> {
    let (rows, columns) = (200, 200);
    let area = 4.0 * std::f64::consts::PI / f64::from(rows * columns);
    let exponent = if heuristic == Heuristic::Balance { 1 } else { 2 };
    let mut sums = vec![(0.0, 0.0); strategies.len()];
    for i in 0..rows {
        let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(rows);
        for j in 0..columns {
            let phi = std::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(columns);
            let radius = (1.0 - z * z).sqrt();
            let dir = DVec3::new(radius * phi.cos(), radius * phi.sin(), z);
            let density: Vec<f64> = strategies.iter().map(|s| s.warp.density(dir)).collect();
            let powers = |k: usize| (strategies[k].share * density[k]).powi(exponent);
            let all: f64 = (0..strategies.len()).map(powers).sum();
            let value = function.eval(dir);
            for (k, (square, mean)) in sums.iter_mut().enumerate() {
                let weighted = powers(k) / all * value;
                *square += area * weighted * weighted / density[k];
                *mean += area * weighted;
            }
        }
    }
    sums.into_iter().map(|(square, mean)| square - mean * mean).collect()
}

/// White noise has the variance `sum_i (int w_i^2 f^2/p_i - (int w_i f)^2)/N_i` (Veach 1997,
/// equation 9.5). The sum over directions is accurate to 3e-4.
#[test]
fn independent_points_have_the_variance_of_veach() {
    for heuristic in ["balance", "power"] {
        for warp in
            ["0.3 * cylinder + 0.7 * vmf:kappa=4 @ 60/0", "cylinder + octahedral + vmf:kappa=1"]
        {
            let text = format!("white-square:warp=\"{warp}\",heuristic={heuristic}");
            let pattern = warped(&text);
            let function = integrand(FUNCTION);
            let functions = pulled_back(&*function, Domain::Sphere, &pattern);
            let mut predictor = WarpedPredictor::new(&functions, 0, BUDGET).unwrap();
            let strategies = pattern.warp.strategies(Domain::Sphere, &Map).unwrap();
            let points = variances_of_points(&*function, &strategies, pattern.heuristic);
            for n in [10, 100] {
                let n = pattern.nearest_count(n);
                let counts = pattern.counts(n);
                let each = points.iter().zip(&counts).map(|(variance, n)| variance / *n as f64);
                let expected: f64 = each.sum();
                let got = predictor.predict(&pattern, n, &()).unwrap().prediction;
                let error = 1e-3 * expected + 3.0 * got.total_stderr();
                assert!((got.variance - expected).abs() < error, "{text}: {got:?}, {expected}");
                assert!(got.total_stderr() < 0.01 * expected, "{text}: {got:?}");
            }
            let shares = pattern.warp.shares();
            let white: f64 = points.iter().zip(&shares).map(|(v, share)| v / (share * 50.0)).sum();
            let got = predictor.white_variance(&pattern, 50);
            assert!((got / white - 1.0).abs() < 1e-2, "{text}: {got}, {white}");
        }
    }
}

/// The variance is the sum of those of the strategies, and the trials agree with it, also where the
/// shares are no valid counts: scores of six comparisons, of which one exceeds 5 by chance in about
/// 1 of 10^5 sets of seeds.
#[test]
fn strategies_add_their_variances() {
    for (text, n) in [
        ("jittered-square:warp=\"1 * cylinder + 3 * vmf:kappa=4 @ 60/0\"", 106),
        ("sobol:warp=\"1 * cylinder + 3 * vmf:kappa=4 @ 60/0\",heuristic=power", 50),
        ("white-square:warp=\"cylinder + octahedral\"", 2),
        ("fibonacci-lattice:warp=\"cylinder + octahedral\"", 110),
        ("jittered-square:warp=\"cylinder + octahedral + vmf:kappa=1\",heuristic=power", 48),
        // Two copies of one density.
        ("sobol:warp=\"cylinder + cylinder\"", 32),
    ] {
        let pattern = warped(text);
        assert_eq!(pattern.nearest_count(n), n, "{text}");
        let function = integrand(FUNCTION);
        let functions = pulled_back(&*function, Domain::Sphere, &pattern);
        let budget = PredictionBudget { relative: 0.04, work: 1e6 };
        let mut predictor = WarpedPredictor::new(&functions, 3, budget).unwrap();
        let point = predictor.predict(&pattern, n, &()).unwrap();
        let mut sum = 0.0;
        for (i, n) in pattern.counts(n).into_iter().enumerate() {
            let mut alone = SquarePredictor::new(&functions[i], 3, budget).unwrap();
            let sampler = pattern.pattern.build(n).unwrap();
            let own = alone.predict(&*sampler, &()).unwrap().prediction;
            let got = point.strategies[i].prediction;
            // Other realizations of a spectrum that is estimated.
            let error = 5.0 * own.stderr.hypot(got.stderr) + 1e-12 * own.variance;
            assert!((own.variance - got.variance).abs() <= error, "{text}: {own:?}, {got:?}");
            sum += got.variance;
        }
        assert!((point.prediction.variance / sum - 1.0).abs() < 1e-12, "{text}");
        let got = predictor.measure(&point.prediction, &pattern, n, Trials::new(300), &()).unwrap();
        let (z, bias) = (got.comparison.z_score(), got.comparison.bias());
        assert!(z.abs() < 5.0, "{text}: z {z}, {:?}", got.comparison.ratio());
        assert_eq!(got.comparison.n_points, n);
        assert!(bias.is_none_or(|bias| bias.p_value > 1e-5), "{text}: {bias:?}");
    }
}

/// Two strategies with the same density, shared equally, are two independent halves.
#[test]
fn equal_densities_are_independent_halves() {
    let function = integrand("cosine");
    let [one, two] =
        ["white-square:warp=cylinder", "white-square:warp=\"cylinder + cylinder\""].map(warped);
    let domain = Domain::Hemisphere;
    let functions = [pulled_back(&*function, domain, &one), pulled_back(&*function, domain, &two)];
    let mut variances = [0.0; 2];
    for ((pattern, functions), variance) in [one, two].iter().zip(&functions).zip(&mut variances) {
        let predictor = WarpedPredictor::new(functions, 0, BUDGET).unwrap();
        let mut predictor = predictor.with_integral(Some(std::f64::consts::PI));
        *variance = predictor.predict(pattern, 20, &()).unwrap().prediction.variance;
        // Independent sets: the variance of the trials is not that of one set counted twice.
        let got = predictor.compare(pattern, 20, Trials::new(1000), &()).unwrap().comparison;
        assert!(got.z_score().abs() < 5.0, "{pattern}: {}", got.z_score());
        assert!(got.bias().unwrap().p_value > 1e-5, "{pattern}");
    }
    assert!((variances[0] / variances[1] - 1.0).abs() < 1e-9, "{variances:?}");
}

/// The sets of directions give the estimates of the trials.
#[test]
fn sets_of_directions_have_the_weights_of_the_estimates() {
    for (text, n) in [
        ("sobol:warp=\"env:a.exr,interpolation=constant\"", 16),
        ("jittered-square:warp=\"1 * cylinder + 3 * vmf:kappa=4 @ 60/0\",heuristic=power", 106),
    ] {
        let pattern = warped(text);
        let function = integrand(FUNCTION);
        let functions = pulled_back(&*function, Domain::Sphere, &pattern);
        let predictor = WarpedPredictor::new(&functions, 5, BUDGET).unwrap();
        let none = WarpedPredictor::new(&functions, 5, BUDGET).unwrap().predict(&pattern, n, &());
        let prediction = none.unwrap().prediction;
        let trials = Trials::new(200);
        let got = predictor.measure(&prediction, &pattern, n, trials, &()).unwrap().comparison;
        let strategies = pattern.warp.strategies(Domain::Sphere, &Map).unwrap();
        let samplers = pattern.samplers(n).unwrap();
        let heuristic = pattern.heuristic;
        let sets = WarpedRealizations::new(&strategies, heuristic, &samplers, 5, Purpose::Trial);
        let mut areas = 0.0;
        for (i, estimate) in (0..).zip(got.measurement.estimates()) {
            let set = sets.realize(i).unwrap();
            assert_eq!(set.len(), n);
            let pairs = set.points.iter().zip(&set.weights);
            let sum: f64 = pairs.map(|(dir, w)| w * function.eval(*dir)).sum();
            assert!((sum / estimate - 1.0).abs() < 1e-12, "{text}, {i}: {sum}, {estimate}");
            areas += set.weights.iter().sum::<f64>();
        }
        // The weights sum to 4 pi on average, here to better than 2 %.
        let mean = areas / 200.0 / (4.0 * std::f64::consts::PI);
        assert!((mean - 1.0).abs() < 0.02, "{text}: {mean}");
    }
}

#[test]
fn densities_of_another_number_are_an_error() {
    let function = integrand("cosine");
    let one = warped("sobol:warp=cylinder");
    let functions = pulled_back(&*function, Domain::Hemisphere, &one);
    let mut predictor = WarpedPredictor::new(&functions, 0, BUDGET).unwrap();
    let two = warped("sobol:warp=\"cylinder + cosine\"");
    let error = predictor.predict(&two, 8, &()).unwrap_err();
    assert!(matches!(error, Error::Strategies { expected: 2, got: 1, .. }), "{error}");
    let error = WarpedPredictor::new(&[], 0, BUDGET).unwrap_err().to_string();
    assert!(error.contains("at least 1"), "{error}");
}

/// Of two densities, of which either alone suits one of two lobes, a split is best that the search
/// finds among all multiples of 0.05; more points are needed with equal shares.
#[test]
fn the_best_shares_are_those_of_all_shares() {
    let function = integrand("vmf:kappa=20 @ 60/0 + 4 * vmf:kappa=5 @ 120/90");
    let pattern = warped("white-square:warp=\"vmf:kappa=20 @ 60/0 + vmf:kappa=5 @ 120/90\"");
    let mut variance = |pattern: &WarpedPattern| {
        let strategies = pattern.warp.strategies(Domain::Sphere, &Map)?;
        let points = variances_of_points(&*function, &strategies, pattern.heuristic);
        Ok(points.iter().zip(&strategies).map(|(v, s)| v / (100.0 * s.share)).sum())
    };
    let all: Vec<f64> = (1..20)
        .map(|i| {
            let shares = [f64::from(i) / 20.0, f64::from(20 - i) / 20.0];
            let warp = pattern.warp.with_shares(&shares).unwrap();
            variance(&WarpedPattern { warp, ..pattern.clone() }).unwrap()
        })
        .collect();
    let minimum = all.iter().copied().fold(f64::INFINITY, f64::min);
    let (best, got) = best_shares(&pattern, &mut variance).unwrap();
    assert!((got / minimum - 1.0).abs() < 1e-12, "{best}: {all:?}");
    assert!(all[9] > minimum, "{all:?}");
    // The text has exactly these shares.
    let again: WarpedPattern = best.to_string().parse().unwrap();
    assert!((variance(&again).unwrap() / got - 1.0).abs() < 1e-12);
    let error = best_shares(&pattern, &mut |_| Err(Error::Heuristic { text: String::new() }));
    assert!(error.is_err());
    let many = vec!["cylinder"; 64].join(" + ");
    let many = warped(&format!("sobol:warp=\"{many}\""));
    let (best, _) = best_shares(&many, &mut |_| Ok(1.0)).unwrap();
    assert!((best.warp.shares().iter().sum::<f64>() - 1.0).abs() < 1e-12);
}

/// A merit with a shallow minimum at equal shares and a deep one at the end, of two and of three
/// warps.
#[test]
fn the_search_of_shares_leaves_local_minima() {
    for (text, least) in [("cosine + cylinder", 0.95), ("cosine + cylinder + octahedral", 0.9)] {
        let n_warps = text.split('+').count();
        for main in 0..n_warps {
            let mut merit = |pattern: &WarpedPattern| {
                let share = pattern.warp.shares()[main];
                Ok((share - 1.0 / n_warps as f64).abs().min(3.0 * (least - share) - 0.1))
            };
            let pattern = warped(&format!("sobol:warp=\"{text}\""));
            let (best, got) = best_shares(&pattern, &mut merit).unwrap();
            assert!((best.warp.shares()[main] - least).abs() < 1e-12, "{best}");
            assert!((got + 0.1).abs() < 1e-12, "{best}: {got}");
        }
    }
}

/// Several strategies are ranked with single ones.
#[test]
fn several_strategies_have_curves_and_required_points() {
    let function = integrand("cosine");
    let pattern = warped("white-square:warp=\"cylinder + cosine\"");
    let functions = pulled_back(&*function, Domain::Hemisphere, &pattern);
    let mut predictor = WarpedPredictor::new(&functions, 0, BUDGET).unwrap();
    let variance = 1e-3;
    let goal = Goal::Variance { variance, max_points: 100_000 };
    let got = Candidate::new(pattern.clone(), goal, &mut predictor, &()).unwrap();
    let n = got.n_points.unwrap();
    let mut at = |n: usize| predictor.predict(&pattern, n, &()).unwrap().prediction.variance;
    assert!(at(n) <= variance && at(n - 1) > variance, "{n}");
    let got = Candidate::new(pattern.clone(), Goal::Points(101), &mut predictor, &()).unwrap();
    assert_eq!(got.n_points, Some(101));
    assert_eq!(got.curve.at(101).unwrap().strategies[0].n_points(), 51);
}
