use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DQuat, DVec3};
use num_complex::Complex;
use sphvar_integrands::{
    Cap, ClampedCosine, Domain, EnvironmentMap, Error, Heuristic, Integrand, PulledBack, Rotated,
    SquareIntegrand, Strategy, Tolerance, VonMisesFisher,
};
use sphvar_sh::{Frequencies, TailClasses};
use sphvar_warps::{
    CosineHemisphere, DensityMap, Interpolation, OctahedralSphere, Oriented, PhongLobe, UniformCap,
    VonMisesFisherLobe, Warp,
};

const SMALL: Tolerance =
    Tolerance { relative: 1e-5, min_evaluations: 1 << 14, max_evaluations: 1 << 18 };

fn pull<'a>(f: &'a dyn Integrand, domain: Domain, warp: impl Warp + 'static) -> PulledBack<'a> {
    PulledBack::new(f, domain, Arc::new(warp), SMALL).unwrap()
}

/// Texels from 0.3 to 6, of which one is bright.
fn texels() -> Vec<f64> {
    let mut texels: Vec<f64> =
        (0..16 * 8).map(|i| 0.3 + (f64::from(i) * 0.618).fract().powi(3)).collect();
    texels[16 * 2 + 5] = 6.0;
    texels
}

fn map(interpolation: Interpolation) -> DensityMap {
    DensityMap::new(16, 8, texels(), interpolation).unwrap()
}

fn environment() -> EnvironmentMap {
    EnvironmentMap::new(16, 8, texels()).unwrap()
}

/// The energies `2 |G_k|^2` of frequencies with |k1|, |k2| <= 4 by the definition, the mean and the
/// mean square, on a grid of n x n points.
fn definition(g: &dyn SquareIntegrand, n: u32) -> (Vec<([i32; 2], f64)>, f64, f64) {
    let place = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
    let wave = |k: i32, u: f64| Complex::cis(-TAU * f64::from(k) * u);
    let mut sums = vec![Complex::ZERO; 81];
    let (mut mean, mut square) = (0.0, 0.0);
    for i in 0..n {
        let points: Vec<[f64; 2]> = (0..n).map(|j| [place(i), place(j)]).collect();
        let mut values = vec![0.0; points.len()];
        g.eval_into(&points, &mut values).unwrap();
        let mut line = [Complex::<f64>::ZERO; 9];
        for (j, value) in (0..n).zip(&values) {
            mean += value;
            square += value * value;
            (-4..=4).zip(&mut line).for_each(|(k, sum)| *sum += *value * wave(k, place(j)));
        }
        for (k, sums) in (-4..=4).zip(sums.chunks_exact_mut(9)) {
            let along_u = wave(k, place(i));
            sums.iter_mut().zip(line).for_each(|(sum, x)| *sum += x * along_u);
        }
    }
    let count = f64::from(n).powi(2);
    let energy =
        |(i, sum): (i32, &Complex<f64>)| ([i / 9 - 4, i % 9 - 4], 2.0 * (sum / count).norm_sqr());
    ((0..).zip(&sums).map(energy).collect(), mean / count, square / count)
}

/// Compares the energies to those by the definition: within four stated errors and a fraction
/// `rounding` of the variance, the error of the definition.
fn compare(name: &str, g: &dyn SquareIntegrand, n: u32, rounding: f64) {
    let (expected, mean, square) = definition(g, n);
    let energy = g.energy(&Frequencies::new(6).unwrap()).unwrap();
    let variance = square - mean * mean;
    let (total, error) = (energy.centred().sum(), energy.centred_stderr().sum());
    assert!(
        (total - variance).abs() <= 4.0 * error + rounding * variance,
        "{name}: variance {total} +- {error}, {variance} by definition"
    );
    assert!(error < 0.05 * total, "{name}: {total} +- {error}");
    for (k, expected) in expected {
        let Some(band) = energy.bands().band_of(k).filter(|band| *band > 0) else { continue };
        let (got, error) =
            (energy.per_band()[band], energy.per_band_stderr().map_or(0.0, |e| e[band]));
        assert!(
            (got - expected).abs() <= 4.0 * error + rounding * variance,
            "{name}, k = {k:?}: {got:e} +- {error:e}, {expected:e} by definition"
        );
    }
}

/// Closures hide all properties but the values.
#[test]
fn energies_are_those_of_the_definition() {
    let tilted = DQuat::from_rotation_x(0.7);
    let cap = Rotated::new(Cap::from_degrees(40.0).unwrap(), tilted).unwrap();
    let (env, sphere) = (environment(), Domain::Sphere);
    let lit = |dir: DVec3| env.eval(dir) * dir.z.max(0.0);
    let smooth = |dir: DVec3| (dir.x + 2.0 * dir.z).exp() * dir.z;
    let upper = Domain::Hemisphere;
    let [constant, bilinear] = [Interpolation::Constant, Interpolation::Bilinear];
    // The definition is accurate to a few 1/n at jumps of few directions, and to 1/n^2 elsewhere.
    compare("cap, cylinder", &pull(&cap, sphere, UniformCap::SPHERE), 300, 1e-2);
    compare("cap, octahedral", &pull(&cap, sphere, OctahedralSphere), 300, 1e-2);
    compare("cap, bilinear map", &pull(&cap, sphere, map(bilinear)), 300, 3e-2);
    compare("map, cylinder", &pull(&env, sphere, UniformCap::SPHERE), 300, 2e-3);
    compare("map, constant map", &pull(&env, sphere, map(constant)), 400, 6e-2);
    compare("smooth, concentric", &pull(&smooth, upper, CosineHemisphere), 300, 3e-4);
    compare("map and cosine, concentric", &pull(&lit, upper, CosineHemisphere), 300, 2e-3);
    let rotated = Oriented::new(map(bilinear), tilted);
    compare("map, rotated map", &pull(&env, sphere, rotated), 300, 3e-2);
    let lit_map = map(constant).times_cosine().unwrap().with_floor(0.2).unwrap();
    compare("map and cosine, with floor", &pull(&lit, upper, lit_map), 300, 3e-2);
    compare("smooth, phong", &pull(&smooth, upper, PhongLobe::new(0.7).unwrap()), 300, 3e-4);
}

#[test]
fn proportional_densities_leave_no_variance() {
    let env = environment();
    let lobe = VonMisesFisher::new(50.0).unwrap();
    let lit = |dir: DVec3| env.eval(dir) * dir.z.max(0.0);
    let bilinear = map(Interpolation::Bilinear);
    let cases: [(&dyn Integrand, Domain, Arc<dyn Warp>); 4] = [
        (&ClampedCosine, Domain::Hemisphere, Arc::new(CosineHemisphere)),
        (&lobe, Domain::Sphere, Arc::new(VonMisesFisherLobe::new(50.0).unwrap())),
        (&env, Domain::Sphere, Arc::new(bilinear.clone())),
        (&lit, Domain::Hemisphere, Arc::new(bilinear.times_cosine().unwrap())),
    ];
    for (f, domain, warp) in cases {
        let g = PulledBack::new(f, domain, warp, SMALL).unwrap();
        let energy = g.energy(&Frequencies::new(9).unwrap().with_axes(99).unwrap()).unwrap();
        let integral = energy.per_band()[0];
        assert!(energy.centred().sum() < 1e-24 * integral, "{g:?}: {:?}", energy.centred());
        assert!(g.kurtosis().is_none());
    }
}

/// The cosine by uniform directions is 2 pi u, and x is a single wave of v.
#[test]
fn energies_of_closed_forms() {
    let g = pull(&ClampedCosine, Domain::Hemisphere, UniformCap::HEMISPHERE);
    let bands = Frequencies::new(3).unwrap().with_axes(5000).unwrap();
    let energy = g.energy(&bands).unwrap();
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-11 * b;
    assert!(close(energy.centred().u, PI * PI / 3.0) && energy.centred().v < 1e-20);
    for k in [1, 2, 77, 5000] {
        let band = bands.band_of([k, 0]).unwrap();
        assert!(close(energy.per_band()[band], 2.0 / f64::from(k).powi(2)), "{k}");
    }
    assert!((g.kurtosis().unwrap() - 1.8).abs() < 1e-9);
    let largest = g.largest_ratio();
    assert!((largest.ratio / TAU - 1.0).abs() < 0.01 && (largest.area - 0.5).abs() < 0.01);
    assert!(largest.direction.z > 0.99);

    let x = |dir: DVec3| dir.x;
    let energy = pull(&x, Domain::Sphere, UniformCap::SPHERE).energy(&bands).unwrap();
    // 4 pi int x^2.
    assert!((energy.centred().sum() / ((4.0 * PI).powi(2) / 3.0) - 1.0).abs() < 1e-4);
    // int_0^1 sqrt(1 - (1 - 2u)^2) du = pi/4 is the part of k1 = 0.
    let band = bands.band_of([0, 1]).unwrap();
    let expected = 2.0 * (4.0 * PI * PI / 8.0).powi(2);
    assert!((energy.per_band()[band] / expected - 1.0).abs() < 1e-4);
}

/// Jumps along a line of u, whose energies fall slowly on the axis alone.
#[test]
fn energies_on_the_axes_are_known_far_beyond_those_off_them() {
    let cap = Cap::from_degrees(50.0).unwrap();
    let g = pull(&cap, Domain::Sphere, UniformCap::SPHERE);
    let bands = Frequencies::new(20).unwrap().with_axes(20_000).unwrap();
    let energy = g.energy(&bands).unwrap();
    let edge = 0.5 * (1.0 - 50f64.to_radians().cos());
    let errors = energy.per_band_stderr().unwrap();
    for k in [1, 7, 300, 1000] {
        let band = bands.band_of([k, 0]).unwrap();
        // The indicator of u < edge, times 4 pi.
        let wave = (PI * f64::from(k) * edge).sin() / (PI * f64::from(k));
        let expected = 2.0 * (4.0 * PI * wave).powi(2);
        let (got, error) = (energy.per_band()[band], errors[band]);
        assert!(
            (got - expected).abs() <= 4.0 * error + 1e-8 * expected + 1e-12,
            "{k}: {got} +- {error}, {expected}"
        );
    }
    let total = 16.0 * PI * PI * edge * (1.0 - edge);
    assert!((energy.centred().sum() / total - 1.0).abs() < 1e-12);
    assert!(energy.centred().v < 1e-3 * total && energy.beyond(bands.len() - 1) < 1e-3 * total);
}

/// `int f^2/p` over quarters of texels, in which f is bilinear and p constant.
#[test]
fn dark_texels_beside_bright_ones_count() {
    let (h, w) = (8usize, 16usize);
    // A map of which dark texels have f/p of some hundred times the mean.
    let mut texels = texels();
    texels.iter_mut().for_each(|x| *x -= 0.25);
    let at = |i: usize, j: usize| texels[i.min(h - 1) * w + j % w];
    let env = EnvironmentMap::new(w, h, texels.clone()).unwrap();
    let density = DensityMap::new(w, h, texels.clone(), Interpolation::Constant).unwrap();
    let g = pull(&env, Domain::Sphere, density);
    let omega = |i: usize| {
        let edge = |i: usize| (PI * i as f64 / h as f64).cos();
        TAU / w as f64 * (edge(i) - edge(i + 1))
    };
    let total: f64 =
        (0..h).flat_map(|i| (0..w).map(move |j| (i, j))).map(|(i, j)| omega(i) * at(i, j)).sum();
    let n = 24;
    let mut square = 0.0;
    for i in 0..h {
        for j in 0..w {
            for (a, b) in (0..n).flat_map(|a| (0..n).map(move |b| (a, b))) {
                let place = |a: i32| (f64::from(a) + 0.5) / f64::from(n);
                let theta = PI * (i as f64 + place(a)) / h as f64;
                let phi = TAU * (j as f64 + place(b)) / w as f64;
                let (sin, cos) = theta.sin_cos();
                let f = env.eval(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos));
                let area = sin * PI * TAU / (h * w) as f64 / f64::from(n * n);
                square += area * f * f * total / at(i, j);
            }
        }
    }
    let integral = env.exact(Domain::Sphere).unwrap();
    let expected = square - integral * integral;
    let energy = g.energy(&Frequencies::new(4).unwrap()).unwrap();
    let (got, error) = (energy.centred().sum(), energy.centred_stderr().sum());
    assert!(
        (got - expected).abs() <= 4.0 * error + 2e-3 * expected,
        "{got} +- {error}, {expected}"
    );
    assert!(error < 0.02 * got);
    assert_eq!(g.exact(), Some(integral));
}

#[test]
fn strategies_divide_the_integral() {
    let env = environment();
    let lit = |dir: DVec3| env.eval(dir) * dir.z.max(0.0);
    let upper = map(Interpolation::Bilinear).times_cosine().unwrap();
    let strategies = [
        Strategy { warp: Arc::new(CosineHemisphere), share: 3.0 },
        Strategy { warp: Arc::new(upper), share: 1.0 },
        // 0 on most of the hemisphere, where the others sample.
        Strategy { warp: Arc::new(UniformCap::new(0.5).unwrap()), share: 1.0 },
    ];
    let alone = pull(&lit, Domain::Hemisphere, CosineHemisphere).integral_estimate().unwrap().0;
    for heuristic in [Heuristic::Balance, Heuristic::Power] {
        let parts =
            PulledBack::of_strategies(&lit, Domain::Hemisphere, &strategies, heuristic, SMALL)
                .unwrap();
        assert_eq!(parts.len(), 3);
        let sum: f64 = parts.iter().map(|part| part.integral_estimate().unwrap().0).sum();
        assert!((sum / alone - 1.0).abs() < 1e-3, "{heuristic}: {sum} and {alone}");
        for (i, part) in parts.iter().enumerate() {
            assert!(part.exact().is_none());
            compare(&format!("{heuristic}, strategy {i}"), part, 300, 2e-2);
        }
        assert_eq!(heuristic.to_string().parse::<Heuristic>().unwrap(), heuristic);
    }
    let error = "veach".parse::<Heuristic>().unwrap_err().to_string();
    assert!(error.contains("balance") && error.contains("power"), "{error}");
}

#[test]
fn densities_that_miss_the_integrand_are_errors() {
    let one = |_: DVec3| 1.0;
    let new = |f: &dyn Integrand, domain, warp: Arc<dyn Warp>| {
        PulledBack::new(f, domain, warp, SMALL).map(|_| ())
    };
    let lost = |result: Result<(), Error>| match result {
        Err(Error::ZeroDensity { share, theta, .. }) => (share, theta),
        other => panic!("{other:?}"),
    };
    let hemisphere = Arc::new(CosineHemisphere);
    let (share, theta) = lost(new(&one, Domain::Sphere, hemisphere.clone()));
    assert!((share - 0.5).abs() < 1e-3 && theta >= 90.0);
    assert!(new(&one, Domain::Hemisphere, hemisphere).is_ok());
    // A cap of 60 degrees has half of the hemisphere.
    let cap = Arc::new(UniformCap::new(PI / 3.0).unwrap());
    let (share, theta) = lost(new(&one, Domain::Hemisphere, cap.clone()));
    assert!((share - 0.5).abs() < 1e-3 && theta > 60.0);
    let inside = Cap::from_degrees(50.0).unwrap();
    assert!(new(&inside, Domain::Sphere, cap).is_ok());
    // A density that underflows.
    let lobe = Arc::new(VonMisesFisherLobe::new(1e4).unwrap());
    assert!(lost(new(&one, Domain::Sphere, lobe)).0 > 0.9);
    let mut dark = texels();
    dark[40..44].fill(0.0);
    let dark = Arc::new(DensityMap::new(16, 8, dark, Interpolation::Constant).unwrap());
    let (share, _) = lost(new(&one, Domain::Sphere, dark.clone()));
    assert!(share > 0.001 && share < 0.1, "{share}");
    let floor = (*dark).clone().with_floor(0.1).unwrap();
    assert!(new(&one, Domain::Sphere, Arc::new(floor)).is_ok());
}

#[test]
fn invalid_input_is_an_error() {
    let new = |f: &dyn Integrand, strategies: &[Strategy]| {
        let (domain, heuristic) = (Domain::Sphere, Heuristic::Balance);
        PulledBack::of_strategies(f, domain, strategies, heuristic, SMALL).map(|_| ())
    };
    let sphere = |share| Strategy { warp: Arc::new(UniformCap::SPHERE), share };
    let one = |_: DVec3| 1.0;
    assert!(matches!(new(&one, &[]), Err(Error::Parameter { .. })));
    for share in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(new(&one, &[sphere(share)]), Err(Error::Parameter { .. })), "{share}");
    }
    let disk = Strategy { warp: Arc::new(sphvar_warps::ConcentricDisk), share: 1.0 };
    assert!(matches!(new(&one, &[disk]), Err(Error::Evaluation { .. })));
    let invalid = |dir: DVec3| if dir.x > 0.9 { f64::NAN } else { 1.0 };
    assert!(matches!(new(&invalid, &[sphere(1.0)]), Err(Error::Evaluation { .. })));
    assert!(new(&|_: DVec3| 1e200, &[sphere(1.0)]).is_err());
    assert!(new(&|_: DVec3| 0.0, &[sphere(1.0)]).is_ok());
    // No value is taken inside a cap of 0.0001 degrees unless its place is known.
    let tiny = Rotated::new(Cap::from_degrees(1e-4).unwrap(), DQuat::from_rotation_y(1.0)).unwrap();
    let hidden = |dir: DVec3| tiny.eval(dir);
    assert!(new(&hidden, &[sphere(1.0)]).is_ok());
    let energy = pull(&tiny, Domain::Sphere, OctahedralSphere);
    let (found, _) = energy.integral_estimate().unwrap();
    assert_eq!(Some(found), tiny.exact(Domain::Sphere));
}
