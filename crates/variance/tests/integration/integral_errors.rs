//! Integration to a tolerance: coverage of its errors, and numbers of points beside those of
//! oracles.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rand::{Rng, RngExt};
use sphvar_integrands::{Cap, Harmonic, Integrand, PhongLobe, VonMisesFisher};
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams, rotate, uniform_rotation};
use sphvar_variance::{Integral, IntegrationOptions, integrate, measure, student_quantile};

use crate::integrals::{atol, holds, rtol};

const AREA: f64 = 4.0 * PI;

/// A function with its exact integral and its tolerance.
struct Problem {
    f: Box<dyn Integrand>,
    exact: f64,
    rtol: f64,
    atol: f64,
}

impl Problem {
    fn options(&self, seed: u64) -> IntegrationOptions<'static> {
        let Self { rtol, atol, .. } = *self;
        IntegrationOptions { rtol, atol, seed, max_points: 1 << 28, ..Default::default() }
    }

    fn tolerance(&self) -> f64 {
        self.atol.max(self.rtol * self.exact.abs())
    }
}

const KINDS: [&str; 10] = [
    "cap",
    "von Mises-Fisher lobe",
    "Phong lobe",
    "harmonic",
    "exponential",
    "kinks",
    "two caps",
    "polynomial",
    "cap times exponential",
    "octant",
];

/// Returns a function of a kind with random parameters and a relative tolerance between 1e-2 and
/// 1e-3 if it has jumps, otherwise 1e-5; relative to the root mean square where the integral is 0.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "degrees and orders are at most 40"
)]
fn problem(kind: usize, rng: &mut dyn Rng) -> Problem {
    let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let has_jumps = matches!(kind, 0 | 6 | 8 | 9);
    let tolerance = 10f64.powf(between(if has_jumps { -3.0 } else { -5.0 }, -2.0));
    let log = between(0.0, 1.0);
    let angle = between(10.0, 150.0);
    let degree = (1.0 + 39.0 * between(0.0, 1.0)) as usize;
    let order = (between(0.0, 1.0) * (degree as f64 + 1.0)) as i64;
    let weight = between(-2.0, 2.0);
    let mut axes = [DVec3::X; 6];
    for axis in &mut axes {
        rotate(uniform_rotation(rng), Domain::Sphere, std::slice::from_mut(axis));
    }
    let cap = |degrees: f64| Cap::from_degrees(degrees).unwrap();
    let relative = |f: Box<dyn Integrand>, exact| Problem { f, exact, rtol: tolerance, atol: 0.0 };
    let named = |f: Box<dyn Integrand>| {
        let exact = f.exact(Domain::Sphere).unwrap();
        relative(f, exact)
    };
    match kind {
        0 => named(Box::new(cap(angle))),
        1 => named(Box::new(VonMisesFisher::new(2.0 * 150f64.powf(log)).unwrap())),
        2 => named(Box::new(PhongLobe::new(60f64.powf(log)).unwrap())),
        3 => {
            let f = Box::new(Harmonic::new(degree, order).unwrap());
            Problem { f, exact: 0.0, rtol: 0.0, atol: tolerance * AREA.sqrt() }
        }
        4 => {
            let a = 0.3 * 20f64.powf(log);
            relative(Box::new(move |d: DVec3| (a * d.dot(axes[0])).exp()), AREA * a.sinh() / a)
        }
        5 => {
            let f = move |d: DVec3| axes[..3].iter().map(|a| d.dot(*a).abs()).sum();
            relative(Box::new(f), 3.0 * TAU)
        }
        6 => {
            let (first, second) = (cap(angle), cap(30.0));
            let exact = first.exact(Domain::Sphere).unwrap()
                + weight * second.exact(Domain::Sphere).unwrap();
            let second_axis = axes[0];
            let f = move |d: DVec3| {
                first.eval(d) + weight * f64::from(u8::from(d.dot(second_axis) >= 0.75f64.sqrt()))
            };
            let atol = tolerance * 0.1 * AREA;
            Problem { f: Box::new(f), exact, rtol: 0.0, atol }
        }
        7 => {
            // Even powers up to 8 of linear functions.
            let f =
                move |d: DVec3| axes.iter().zip([2, 4, 6, 8]).map(|(a, k)| d.dot(*a).powi(k)).sum();
            let exact = (0..4).map(|i| AREA / (2.0 * f64::from(i) + 3.0)).sum();
            relative(Box::new(f), exact)
        }
        8 => {
            let (edge, a) = (angle.to_radians().cos(), weight);
            let f = move |d: DVec3| {
                let z = d.dot(axes[0]);
                if z >= edge { (a * z).exp() } else { 0.0 }
            };
            let exact = TAU * ((a).exp() - (a * edge).exp()) / a;
            relative(Box::new(f), exact)
        }
        _ => {
            let f = move |d: DVec3| f64::from(u8::from(d.min_element() >= 0.0)) * d.z;
            relative(Box::new(f), PI / 4.0)
        }
    }
}

/// Returns the smallest of the numbers of points for which the true standard error of the mean of
/// `copies` sets, times the normal quantile of 95 %, is within the tolerance.
fn oracle(problem: &Problem, copies: f64, counts: impl Iterator<Item = usize>) -> usize {
    let quantile = student_quantile(0.975, f64::INFINITY);
    let is_met = |&n: &usize| {
        let sampler = Pattern::FIBONACCI.build(n, Domain::Sphere).unwrap();
        let sets = Realizations::rotated(&*sampler, Streams::new(1, Purpose::Trial, n));
        let measured = measure(&sets, &*problem.f, 100, &()).unwrap();
        quantile * (measured.variance() / copies).sqrt() <= problem.tolerance()
    };
    let mut counts = counts.peekable();
    let mut last = *counts.peek().unwrap();
    for n in counts {
        last = n;
        if is_met(&n) {
            break;
        }
    }
    last
}

/// Numbers of points of oracles.
struct Oracles {
    /// N of 16 copies, doubled from 32 as the integration does.
    doubled: f64,
    /// N of 16 copies, any number.
    any: f64,
    /// N of a single set, doubled.
    single: f64,
}

impl Oracles {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "numbers of points below 2^32"
    )]
    fn new(problem: &Problem) -> Self {
        let doubled = oracle(problem, COPIES, (0..16).map(|k| 32 << k));
        // Quarters of an octave, from half the number: errors need not fall steadily.
        let quarter = |k: i32| ((doubled / 2) as f64 * 2f64.powf(f64::from(k) / 4.0)) as usize;
        let any = oracle(problem, COPIES, (1..=4).map(quarter));
        let single = oracle(problem, 1.0, (0..20).map(|k| 32 << k));
        Self { doubled: doubled as f64, any: any as f64, single: single as f64 }
    }
}

const COPIES: f64 = 16.0;

/// Sums over integrals.
#[derive(Clone, Copy, Default)]
struct Tally {
    runs: f64,
    held: f64,
    /// N over that of the oracle that doubles.
    points: f64,
    /// N over that of the oracle that takes any number.
    points_of_any: f64,
    /// The evaluations at all levels over those of the oracle that doubles.
    evaluations: f64,
    /// The same for the oracle that takes any number.
    evaluations_of_any: f64,
    /// The same for the oracle of a single set.
    evaluations_of_single: f64,
}

impl Tally {
    fn add(&mut self, problem: &Problem, oracles: &Oracles, integral: &Integral) {
        let (n, evaluations) = (integral.n_points as f64, integral.evaluations as f64);
        let deviation = (integral.value() - problem.exact).abs();
        self.runs += 1.0;
        self.held += f64::from(u8::from(deviation <= integral.error()));
        self.points += n / oracles.doubled;
        self.points_of_any += n / oracles.any;
        self.evaluations += evaluations / (COPIES * oracles.doubled);
        self.evaluations_of_any += evaluations / (COPIES * oracles.any);
        self.evaluations_of_single += evaluations / oracles.single;
    }

    fn coverage(&self) -> f64 {
        self.held / self.runs
    }

    fn line(&self) -> String {
        let mean = |sum: f64| sum / self.runs;
        format!(
            "{:6.3}  {:6.2} {:6.2}  {:6.2} {:6.2} {:6.2}",
            self.coverage(),
            mean(self.points),
            mean(self.points_of_any),
            mean(self.evaluations),
            mean(self.evaluations_of_any),
            mean(self.evaluations_of_single)
        )
    }
}

/// Integrates `each` functions of every kind with `seeds` seeds, and returns the results by kind.
fn study(each: u64, seeds: u64) -> [Tally; 10] {
    let streams = Streams::new(7, Purpose::Resample, 0);
    std::array::from_fn(|kind| {
        let mut tally = Tally::default();
        for i in 0..each {
            let problem = problem(kind, &mut streams.realization(1000 * kind as u64 + i));
            let oracles = Oracles::new(&problem);
            for seed in 0..seeds {
                let integral = integrate(&*problem.f, &problem.options(seed), &()).unwrap();
                assert!(integral.has_converged(), "{}: {integral:?}", KINDS[kind]);
                tally.add(&problem, &oracles, &integral);
            }
        }
        tally
    })
}

fn total(tallies: &[Tally]) -> Tally {
    tallies.iter().fold(Tally::default(), |a, b| Tally {
        runs: a.runs + b.runs,
        held: a.held + b.held,
        points: a.points + b.points,
        points_of_any: a.points_of_any + b.points_of_any,
        evaluations: a.evaluations + b.evaluations,
        evaluations_of_any: a.evaluations_of_any + b.evaluations_of_any,
        evaluations_of_single: a.evaluations_of_single + b.evaluations_of_single,
    })
}

/// 200 functions of ten kinds, ten integrals each: the errors hold in 97.7 % of all and in at least
/// 95 % of each kind, at a stated confidence of 95 %. With a coverage of exactly 95 %, a kind would fall
/// below the limit by chance in 3e-5 of seeds (4 standard errors of 200 runs).
#[test]
#[ignore = "statistics"]
#[expect(clippy::print_stdout, reason = "the test prints what it measures")]
fn errors_hold_and_points_are_near_those_of_an_oracle() {
    let tallies = study(20, 10);
    println!("{:22}  held   N: doubled, any; evaluations: doubled, any, single set", "");
    for (kind, tally) in KINDS.iter().zip(&tallies) {
        println!("{kind:22} {}", tally.line());
    }
    let all = total(&tallies);
    println!("{:22} {}", "all", all.line());
    let margin = 4.0 * (0.95 * 0.05 / 200.0_f64).sqrt();
    for (kind, tally) in KINDS.iter().zip(&tallies) {
        assert!(tally.coverage() >= 0.95 - margin, "{kind}: {}", tally.line());
        assert!(tally.points_of_any <= 2.5 * tally.runs, "{kind}: {}", tally.line());
    }
    // Wider intervals than necessary would hold nearly always.
    assert!((0.95..0.99).contains(&all.coverage()), "{}", all.line());
    assert!(all.evaluations <= 2.5 * all.runs, "{}", all.line());
}

/// 60 integrals: with a coverage of 95 %, fewer than 51 errors hold by chance in 0.1 % of seeds.
#[test]
fn errors_of_a_few_integrals_hold() {
    let streams = Streams::new(7, Purpose::Resample, 1);
    let seeds_of_kinds = (0..6).flat_map(|seed| (0..KINDS.len()).map(move |kind| (kind, seed)));
    let held = seeds_of_kinds.filter(|&(kind, seed)| {
        let problem = problem(kind, &mut streams.realization(1000 * kind as u64 + seed));
        let integral = integrate(&*problem.f, &problem.options(seed), &()).unwrap();
        assert!(integral.has_converged(), "{}, {seed}: {integral:?}", KINDS[kind]);
        holds(&integral, problem.exact)
    });
    let held = held.count();
    assert!(held >= 51, "{held} of 60");
}

/// Lobes that cover 1e-3 to 1e-4 of the sphere, and a cap of 5e-4, at tolerances that are met
/// before and after the pattern resolves them, without and with a constant background. With a
/// coverage of 95 %, one of eleven fails in 4e-4 of seeds.
#[test]
#[ignore = "statistics"]
#[expect(clippy::print_stdout, reason = "the test prints what it measures")]
fn errors_of_narrow_features_hold() {
    let cap = Cap::from_degrees(2.5).unwrap();
    let scale = cap.exact(Domain::Sphere).unwrap();
    let features: [(&str, Box<dyn Integrand>); 3] = [
        ("kappa 1e3", Box::new(VonMisesFisher::new(1e3).unwrap())),
        ("kappa 1e4", Box::new(VonMisesFisher::new(1e4).unwrap())),
        ("cap", Box::new(move |d: DVec3| cap.eval(d) / scale)),
    ];
    let background: Box<dyn Integrand> = Box::new(move |d: DVec3| 1.0 / AREA + cap.eval(d) / scale);
    let mut low = Vec::new();
    // The tolerances of the cap on a constant background are met with few hits of the cap.
    for rtol_of_background in [0.3, 0.1] {
        let held = (0..200).filter(|&seed| {
            let options = IntegrationOptions { seed, ..rtol(rtol_of_background) };
            holds(&integrate(&background, &options, &()).unwrap(), 2.0)
        });
        let coverage = held.count() as f64 / 200.0;
        println!("cap on a background, rtol {rtol_of_background}: {coverage}");
        if coverage < 0.95 - 4.0 * (0.95 * 0.05 / 200.0_f64).sqrt() {
            low.push(("cap on a background", rtol(rtol_of_background), coverage));
        }
    }
    for (name, f) in &features {
        for options in [rtol(0.3), rtol(0.05), atol(0.5)] {
            let held = (0..200).filter(|&seed| {
                holds(&integrate(f, &IntegrationOptions { seed, ..options }, &()).unwrap(), 1.0)
            });
            let coverage = held.count() as f64 / 200.0;
            println!("{name}, rtol {}, atol {}: {coverage}", options.rtol, options.atol);
            if coverage < 0.95 - 4.0 * (0.95 * 0.05 / 200.0_f64).sqrt() {
                low.push((name, options, coverage));
            }
        }
    }
    assert!(low.is_empty(), "{low:?}");
}
