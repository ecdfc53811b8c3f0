use std::sync::{Arc, OnceLock};

use glam::DVec3;
use sphvar_samplers::{Domain, Pattern, Purpose, Streams, riesz_energy};

use crate::reference::DoubleDouble;
use crate::{Area, Errors, HardCase, Subject, Trial};

/// The documented accuracy of energies, relative to the sum of the magnitudes of those of pairs.
const ACCURACY: f64 = 1e-11;

/// The logarithmic energy, and exponents for which the kernel is split; others are summed over all
/// pairs.
const EXPONENTS: [f64; 6] = [0.0, 0.5, 1.0, 2.0, 3.0, 4.0];

/// Returns the trials of energies of sets of some thousand points, whose kernel is split into a near
/// and a smooth far part.
pub(super) fn trials(n: usize) -> Vec<Trial> {
    let mut trials = Vec::new();
    for (pattern, domain) in [
        (Pattern::WhiteNoise, Domain::Sphere),
        (Pattern::FIBONACCI, Domain::Sphere),
        (Pattern::WhiteNoise, Domain::Hemisphere),
    ] {
        let points = Arc::new(points(&pattern, n, domain));
        trials.extend(EXPONENTS.map(|s| Trial {
            area: Area::Quality,
            method: format!("Riesz energy, {}", pattern.name()),
            case: format!("{n} {}, {domain}, s = {s}", pattern.name()),
            count: n as f64,
            unit: "points",
            relative_to: "the sum of the magnitudes of the energies of pairs",
            bound: ACCURACY,
            reference: "sum over all pairs",
            subject: Box::new(Energy::new(Arc::clone(&points), domain, s)),
        }));
    }
    trials
}

/// Returns the hard cases of energies.
pub(super) fn hard_cases() -> [HardCase; 1] {
    [HardCase {
        name: "riesz_energies_of_clusters_and_close_pairs",
        what: "energies of 2100 points, half of them within 0.01, in pairs 1e-7 apart, and at a pole and \
               the equator but for 1e-3; relative to the sum of the magnitudes of the energies of pairs",
        bound: ACCURACY,
        reason: "the documented accuracy",
        measure: hostile,
    }]
}

fn points(pattern: &Pattern, n: usize, domain: Domain) -> Vec<DVec3> {
    let sampler = pattern.build(n, domain).expect("the number of points is valid");
    let mut rng = Streams::new(5, Purpose::Pattern, n).realization(0);
    sampler.sample(&mut rng).expect("a feasible pattern").points
}

/// Returns the energy of a set by its definition, and the sum of the magnitudes of its terms.
fn definition(points: &[DVec3], domain: Domain, s: f64) -> [DoubleDouble; 2] {
    let mut sums = [DoubleDouble::ZERO; 2];
    let energy = |square: f64| {
        if s > 0.0 { square.powf(-0.5 * s) } else { -0.5 * square.ln() }
    };
    let images = if domain == Domain::Hemisphere { 2 } else { 1 };
    for (k, p) in points.iter().enumerate() {
        // Terms are accurate to some EPSILON, since differences of coordinates are, and the sum over
        // some thousand of them to 1e-13 of their magnitudes.
        let mut of_point = [0.0; 2];
        for q in &points[..k] {
            for term in [*p - *q, *p + *q].iter().take(images).map(|d| energy(d.length_squared())) {
                of_point[0] += term;
                of_point[1] += term.abs();
            }
        }
        for (sum, of_point) in sums.iter_mut().zip(of_point) {
            *sum += DoubleDouble::from(of_point);
        }
    }
    sums
}

/// The energy of a set.
#[derive(Debug)]
struct Energy {
    points: Arc<Vec<DVec3>>,
    domain: Domain,
    s: f64,
    reference: OnceLock<[DoubleDouble; 2]>,
    energy: f64,
}

impl Energy {
    fn new(points: Arc<Vec<DVec3>>, domain: Domain, s: f64) -> Self {
        Self { points, domain, s, reference: OnceLock::new(), energy: f64::NAN }
    }
}

impl Subject for Energy {
    fn run(&mut self) {
        self.energy = riesz_energy(&self.points, self.domain, self.s);
    }

    fn errors(&mut self) -> Errors {
        let definition = || definition(&self.points, self.domain, self.s);
        let [exact, magnitude] = *self.reference.get_or_init(definition);
        let mut errors = Errors::default();
        let off = (DoubleDouble::from(self.energy) - exact).value();
        errors.push(off / magnitude.value(), || format!("s = {}, {}", self.s, self.domain));
        errors
    }
}

fn hostile() -> Errors {
    const N: usize = 2100;
    let mut errors = Errors::default();
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let noise = points(&Pattern::WhiteNoise, N, domain);
        let near = |centre: DVec3, p: DVec3, size: f64| {
            domain.representative((centre + size * p).normalize())
        };
        let clustered = |centre: DVec3, size: f64| -> Vec<DVec3> {
            let (some, others) = noise.split_at(N / 2);
            let cluster = some.iter().map(|p| near(centre, *p, size));
            cluster.chain(others.iter().copied()).collect()
        };
        let pairs = (0..N).map(|k| {
            let p = noise[k / 2];
            if k % 2 == 0 { p } else { near(p, p.any_orthonormal_vector(), 1e-7) }
        });
        let sets = [
            ("cluster", clustered(DVec3::new(0.6, 0.0, 0.8), 1e-2)),
            ("pole", clustered(DVec3::Z, 1e-3)),
            ("close pairs", pairs.collect()),
            (
                "equator",
                noise.iter().map(|p| near(DVec3::ZERO, p.with_z(1e-3 * p.z), 1.0)).collect(),
            ),
        ];
        for (name, points) in sets {
            let points = Arc::new(points);
            for s in [0.0, 1.0, 3.0] {
                let mut energy = Energy::new(Arc::clone(&points), domain, s);
                energy.run();
                let of_set = energy.errors();
                errors.push(of_set.max(), || format!("{name}, {}", of_set.worst()));
            }
        }
    }
    errors
}
