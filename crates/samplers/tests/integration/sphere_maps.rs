//! Patterns of the sphere that are mapped from the square: pixels, uniformity and unbiased means.

use std::collections::HashSet;

use glam::DVec3;
use sphvar_healpix::{Cell, Nside};
use sphvar_samplers::{Domain, Pattern, Purpose, Sampler, Streams};

use crate::sequences::{DOMAINS, combinations};

const NAMES: [&str; 5] = ["sobol", "halton", "hammersley", "r2", "pmj02"];

fn rng(index: u64) -> impl rand::Rng {
    Streams::new(29, Purpose::Pattern, 5).realization(index)
}

/// Returns every random combination of randomization and map.
fn random_patterns() -> impl Iterator<Item = Pattern> {
    let of = |name: &str| {
        let pattern: Pattern = name.parse().unwrap();
        combinations(name, &pattern.parameters())
    };
    let patterns = NAMES.into_iter().flat_map(of).map(|text| text.parse::<Pattern>().unwrap());
    patterns.filter(|pattern| !pattern.is_deterministic())
}

#[test]
fn patterns_without_randomization_are_the_only_deterministic_ones() {
    for name in NAMES {
        let pattern: Pattern = name.parse().unwrap();
        for text in combinations(name, &pattern.parameters()) {
            let pattern: Pattern = text.parse().unwrap();
            assert_eq!(pattern.is_deterministic(), text.contains("=none"), "{text}");
        }
    }
}

/// The number of the pixel of a direction, or of its antipodal pair.
fn pixel(nside: Nside, direction: DVec3, domain: Domain) -> Cell {
    let cell = Cell::containing(nside, direction);
    if domain == Domain::Hemisphere && cell.face() >= 6 { cell.antipode() } else { cell }
}

/// The first 12 * 4^k points lie one in each pixel.
#[test]
fn sequences_on_the_faces_are_nested_healpix() {
    for text in ["sobol", "sobol:randomization=digital", "pmj02"] {
        let separator = if text.contains(':') { ',' } else { ':' };
        let pattern: Pattern = format!("{text}{separator}map=healpix").parse().unwrap();
        for (domain, n_faces) in [(Domain::Sphere, 12), (Domain::Hemisphere, 6)] {
            for index in 0..4 {
                let sampler = pattern.build(n_faces << 12, domain).unwrap();
                let points = sampler.sample(&mut rng(index)).unwrap().points;
                for k in 0..=6 {
                    let nside = Nside::new(1 << k).unwrap();
                    let n = n_faces << (2 * k);
                    let pixels: HashSet<_> =
                        points[..n].iter().map(|&p| pixel(nside, p, domain)).collect();
                    assert_eq!(pixels.len(), n, "{pattern} on the {domain}, nside {nside:?}");
                }
            }
        }
    }
}

/// The faces of prefixes are in turn, with any randomization.
#[test]
fn faces_are_in_turn() {
    for name in NAMES {
        let pattern: Pattern = format!("{name}:map=healpix").parse().unwrap();
        for (domain, n_faces) in [(Domain::Sphere, 12), (Domain::Hemisphere, 6)] {
            for n in [1, 5, 12, 13, 40] {
                let points = pattern.build(n, domain).unwrap().sample(&mut rng(3)).unwrap().points;
                let face = |p: &DVec3| pixel(Nside::nearest(12), *p, domain).face();
                let faces: Vec<u8> = points.iter().map(face).collect();
                let distinct: HashSet<u8> = faces[..n.min(n_faces)].iter().copied().collect();
                assert_eq!(distinct.len(), n.min(n_faces), "{pattern}, N = {n}");
                assert!((n_faces..n).all(|i| faces[i] == faces[i - n_faces]), "{pattern}");
            }
        }
    }
}

#[test]
fn directions_are_unit_vectors_of_the_domain() {
    for name in NAMES {
        let pattern: Pattern = name.parse().unwrap();
        for text in combinations(name, &pattern.parameters()) {
            for domain in DOMAINS {
                for n in [1, 2, 3, 12, 13, 100] {
                    let sampler = text.parse::<Pattern>().unwrap().build(n, domain).unwrap();
                    let set = sampler.sample(&mut rng(1)).unwrap();
                    assert_eq!((set.len(), sampler.n_points()), (n, n), "{text}");
                    for p in set.points {
                        assert!((p.length() - 1.0).abs() < 1e-15, "{text}: {p}");
                        assert!(domain == Domain::Sphere || p.z >= 0.0, "{text}: {p}");
                    }
                }
            }
        }
    }
}

/// Every single direction is uniform on the domain without any rotation.
#[test]
fn every_direction_is_uniform() {
    const M: u64 = 1800;
    const BINS: usize = 18;
    const POINTS: [usize; 5] = [0, 1, 4, 13, 27];
    for pattern in random_patterns() {
        for domain in DOMAINS {
            let sampler = pattern.build(28, domain).unwrap();
            let mut counts = [[0.0; BINS]; POINTS.len()];
            for index in 0..M {
                let points = sampler.sample(&mut rng(index)).unwrap().points;
                for (counts, i) in counts.iter_mut().zip(POINTS) {
                    counts[bin(points[i], domain)] += 1.0;
                }
            }
            let expected = M as f64 / BINS as f64;
            for (counts, i) in counts.iter().zip(POINTS) {
                let chi2: f64 = counts.iter().map(|c| (c - expected).powi(2) / expected).sum();
                // 17 degrees of freedom: beyond 66 in 1e-7 of seeds, 4e-5 of all 370.
                assert!(chi2 < 66.0, "{pattern} on the {domain}: point {i}, {chi2}");
            }
        }
    }
}

/// Returns the one of 3 x 6 parts of equal areas, by height and longitude.
fn bin(p: DVec3, domain: Domain) -> usize {
    let drop = if domain == Domain::Sphere { 0.5 * (1.0 - p.z) } else { 1.0 - p.z };
    let turn = p.y.atan2(p.x).rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU;
    let part = |x: f64, n: usize| (1..n).filter(|k| n as f64 * x >= *k as f64).count();
    6 * part(drop, 3) + part(turn, 6)
}

/// Means over a realization are unbiased without any rotation, at numbers of points that leave strata
/// and faces incomplete.
#[test]
fn means_are_unbiased() {
    const M: u64 = 1500;
    for pattern in random_patterns() {
        for domain in DOMAINS {
            for n in [1, 5, 17] {
                let sampler = pattern.build(n, domain).unwrap();
                let (mut sums, mut squares) = ([0.0; 5], [0.0; 5]);
                for index in 0..M {
                    let means = means(&*sampler, index);
                    for (k, mean) in means.into_iter().enumerate() {
                        sums[k] += mean;
                        squares[k] += mean * mean;
                    }
                }
                for (k, (sum, square)) in sums.iter().zip(squares).enumerate() {
                    let exact = if domain == Domain::Hemisphere && k == 0 { 0.5 } else { 0.0 };
                    let mean = sum / M as f64;
                    let error = ((square / M as f64 - mean * mean).max(0.0) / M as f64).sqrt();
                    // 1110 comparisons at 5.5 sigma: 4e-5 of seeds. Shifted heights in an
                    // arithmetic progression integrate z up to rounding.
                    assert!(
                        (mean - exact).abs() < 5.5 * error + 1e-13,
                        "{pattern} on the {domain}, N = {n}: moment {k} is {mean} +- {error}"
                    );
                }
            }
        }
    }
}

/// Returns the means of z, x, x y, y z and z^2 - 1/3.
fn means(sampler: &dyn Sampler, index: u64) -> [f64; 5] {
    let points = sampler.sample(&mut rng(index)).unwrap().points;
    let mut means = [0.0; 5];
    for DVec3 { x, y, z } in &points {
        let values = [*z, *x, x * y, y * z, z * z - 1.0 / 3.0];
        for (mean, value) in means.iter_mut().zip(values) {
            *mean += value / points.len() as f64;
        }
    }
    means
}
