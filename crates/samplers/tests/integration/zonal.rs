//! Zonal patterns: the equal-area partition and the generalized spiral.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use sphvar_samplers::{
    Domain, EqualArea, GeneralizedSpiral, Placement, PointSet, Purpose, Region, Sampler, Streams,
};

const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

fn rng(index: u64) -> impl rand::Rng {
    Streams::new(11, Purpose::Pattern, 0).realization(index)
}

fn partition(n: u32, domain: Domain) -> EqualArea {
    EqualArea::new(n as usize, domain, Placement::Jittered).expect("a small number")
}

/// Returns the partition as the paper constructs it: fitting collars, ideal numbers of regions,
/// rounding with the remainder carried from collar to collar.
fn by_definition(n: u32) -> Vec<u32> {
    if n <= 2 {
        return vec![1; n as usize];
    }
    let n_real = f64::from(n);
    let cap = 2.0 * (1.0 / n_real.sqrt()).asin();
    let ideal_angle = (4.0 * PI / n_real).sqrt();
    let mut collars = 1;
    // The nearest number to the ideal one, found by counting.
    while (f64::from(collars) + 0.5) * ideal_angle <= PI - 2.0 * cap {
        collars += 1;
    }
    let fitting = (PI - 2.0 * cap) / f64::from(collars);
    let mut zones = vec![1];
    let mut carried = 0.0;
    for collar in 0..collars {
        let top = cap + f64::from(collar) * fitting;
        let ideal = n_real * (top.cos() - (top + fitting).cos()) / 2.0;
        // A small positive offset resolves the tie at the equator.
        let here = (1..).find(|&m| f64::from(m) + 0.5 > ideal + carried + 1e-7).expect("a number");
        carried += ideal - f64::from(here);
        zones.push(here);
    }
    zones.push(1);
    zones
}

#[test]
fn zones_match_the_definition() {
    for n in (1..2000).chain([10_007, 65_536, 1_000_000]) {
        let zones: Vec<u32> = partition(n, Domain::Sphere).zones().collect();
        assert_eq!(zones, by_definition(n), "N = {n}");
    }
}

#[test]
fn known_partitions() {
    // EQ(2, 10) is the example in Leopardi's own documentation; the others follow by hand.
    for (n, zones) in [
        (1, vec![1]),
        (2, vec![1, 1]),
        (3, vec![1, 1, 1]),
        (4, vec![1, 2, 1]),
        (10, vec![1, 4, 4, 1]),
        (12, vec![1, 5, 5, 1]),
        (33, vec![1, 6, 10, 9, 6, 1]),
    ] {
        assert_eq!(partition(n, Domain::Sphere).zones().collect::<Vec<_>>(), zones, "N = {n}");
    }
    let caps: Vec<f64> = partition(10, Domain::Sphere)
        .regions()
        .filter(|r| r.phi()[0] <= 0.0)
        .map(|r| r.theta()[1])
        .collect();
    for (theta, expected) in caps.iter().zip([0.6435, FRAC_PI_2, 2.4981, PI]) {
        assert!((theta - expected).abs() < 5e-5, "caps at {caps:?}");
    }
}

/// Returns the largest distance between points of a 5 by 17 grid over the region, edges included.
fn diameter(region: &Region) -> f64 {
    let mut grid = Vec::new();
    for u in [0.0, 0.25, 0.5, 0.75, 1.0] {
        for v in 0..=16 {
            grid.push(region.uniform_point(u, f64::from(v) / 16.0));
        }
    }
    grid.iter().flat_map(|p| grid.iter().map(move |q| p.distance(*q))).fold(0.0, f64::max)
}

#[test]
fn regions_are_equal_contiguous_and_small() {
    for domain in DOMAINS {
        for n in (1..400).chain([1000, 4096]) {
            let pattern = partition(n, domain);
            let ideal = domain.area() / f64::from(n);
            let regions: Vec<Region> = pattern.regions().collect();
            assert_eq!((regions.len(), pattern.n_points()), (n as usize, n as usize), "{domain}");
            let [mut parallel, mut meridian] = [1.0f64, TAU];
            for r in &regions {
                let ([bottom, top], [west, east]) = (r.z(), r.phi());
                // Four edges are rounded by EPSILON, against the region's extents.
                let tolerance = 4.0 * f64::EPSILON * (1.0 / (top - bottom) + TAU / (east - west));
                let off = r.area() / ideal - 1.0;
                assert!(off.abs() <= tolerance, "N = {n}: {r:?} is off by {off:e}");
                // Either the next region of the zone or the first one of the next zone; edges are
                // bit-identical.
                let begins = meridian.to_bits() == TAU.to_bits();
                let (start, upper) = if begins { (0.0, parallel) } else { (meridian, top) };
                assert_eq!(west.to_bits(), f64::to_bits(start), "N = {n}: {r:?}");
                assert_eq!(top.to_bits(), upper.to_bits(), "N = {n}: {r:?}");
                assert!(begins || bottom.to_bits() == parallel.to_bits(), "N = {n}: {r:?}");
                (parallel, meridian) = (bottom, east);
            }
            let end = if domain == Domain::Sphere { -1.0f64 } else { 0.0 };
            assert_eq!(parallel.to_bits(), end.to_bits(), "N = {n} {domain}");
            assert_eq!(meridian.to_bits(), TAU.to_bits(), "N = {n} {domain}");
            if !(100..390).contains(&n) {
                let largest = regions.iter().map(diameter).fold(0.0, f64::max);
                assert!(largest <= 7.0 / f64::from(n).sqrt(), "N = {n} {domain}: {largest}");
            }
        }
    }
}

#[test]
fn every_region_has_one_point() {
    for domain in DOMAINS {
        for n in [1, 2, 3, 4, 7, 33, 500] {
            for placement in [Placement::Jittered, Placement::Centred] {
                let pattern = EqualArea::new(n, domain, placement).expect("a small number");
                let points = pattern.sample(&mut rng(n as u64)).expect("no reason to fail").points;
                for (p, region) in points.iter().zip(pattern.regions()) {
                    let phi = p.y.atan2(p.x).rem_euclid(TAU);
                    let ([bottom, top], [west, east]) = (region.z(), region.phi());
                    // The longitude of a point near a pole is accurate to EPSILON/sin(theta).
                    let slack = 4.0 * f64::EPSILON / p.x.hypot(p.y).max(f64::EPSILON);
                    let inside = (bottom..=top).contains(&p.z)
                        && (west - slack..=east + slack).contains(&phi);
                    assert!(inside, "N = {n} {domain} {placement:?}: {p} outside {region:?}");
                }
            }
        }
    }
}

/// The fractions of height and longitude at which points lie are uniform: their means are 1/2 and
/// their mean squares 1/3.
#[test]
fn jittered_points_are_uniform_in_their_regions() {
    const M: u64 = 20_000;
    let pattern = partition(10, Domain::Sphere);
    let regions: Vec<Region> = pattern.regions().collect();
    let mut set = PointSet::default();
    let mut sums = [[[0.0; 2]; 2]; 10];
    for i in 0..M {
        pattern.sample_into(&mut rng(i), &mut set).expect("no reason to fail");
        for ((p, r), sum) in set.points.iter().zip(&regions).zip(&mut sums) {
            let ([bottom, top], [west, east]) = (r.z(), r.phi());
            let u = (p.z - bottom) / (top - bottom);
            let v = (p.y.atan2(p.x).rem_euclid(TAU) - west) / (east - west);
            for (powers, x) in sum.iter_mut().zip([u, v]) {
                powers[0] += x;
                powers[1] += x * x;
            }
        }
    }
    // Variances of x and x^2 are 1/12 and 4/45; |z| < 5 for 40 means fails for 2e-5 of seeds.
    let m = M as f64;
    for powers in sums.as_flattened() {
        let z = [
            (powers[0] / m - 0.5) * (12.0 * m).sqrt(),
            (powers[1] / m - 1.0 / 3.0) * (45.0 / 4.0 * m).sqrt(),
        ];
        assert!(z.iter().all(|z| z.abs() < 5.0), "{z:?} sigma in {sums:?}");
    }
}

fn spiral(n: usize, domain: Domain) -> Vec<DVec3> {
    let pattern = GeneralizedSpiral::new(n, domain).expect("a small number");
    pattern.sample(&mut rng(0)).expect("no reason to fail").points
}

#[test]
fn the_spiral_matches_its_definition() {
    for n in [2usize, 3, 12, 101] {
        let mut phi = 0.0;
        for (k, p) in spiral(n, Domain::Sphere).into_iter().enumerate() {
            let h = -1.0 + 2.0 * k as f64 / (n - 1) as f64;
            let inner = k > 0 && k + 1 < n;
            phi = if inner { phi + 3.6 / (n as f64 * (1.0 - h * h)).sqrt() } else { 0.0 };
            let s = if inner { (1.0 - h * h).sqrt() } else { 0.0 };
            let expected = DVec3::new(s * phi.cos(), s * phi.sin(), h);
            // The sum phi of up to n terms, and the plain 1 - h^2 near the poles.
            let tolerance = 8.0 * n as f64 * f64::EPSILON;
            assert!((p - expected).length() < tolerance, "N = {n}, k = {k}: {p}, {expected}");
        }
    }
    assert_eq!(spiral(1, Domain::Sphere), [DVec3::NEG_Z]);
    assert_eq!(spiral(2, Domain::Sphere), [DVec3::NEG_Z, DVec3::Z]);
}

/// Computed by hand: h = -9/11, sin(theta) = sqrt(40)/11, phi = 3.6 * 11/sqrt(480).
#[test]
fn the_second_of_twelve_spiral_points() {
    let p = spiral(12, Domain::Sphere)[1];
    let (s, phi) = (40f64.sqrt() / 11.0, 39.6 / 480f64.sqrt());
    let expected = DVec3::new(s * phi.cos(), s * phi.sin(), -9.0 / 11.0);
    assert!((p - expected).length() < 4.0 * f64::EPSILON, "{p}");
}

/// Neighbours along the spiral are 3.6/sqrt(N) apart and its turns about 3.5/sqrt(N); next to a
/// pole the first ring has radius 2/sqrt(N), and on the hemisphere 1.4/sqrt(2N). White noise has
/// pairs at about 2/N.
#[test]
fn spiral_points_keep_apart() {
    for n in [50, 500, 5000] {
        for (domain, per_sphere) in [(Domain::Sphere, n), (Domain::Hemisphere, 2 * n)] {
            let points = spiral(n, domain);
            let mut nearest = f64::INFINITY;
            for (i, p) in points.iter().enumerate() {
                for q in &points[..i] {
                    nearest = nearest.min(p.distance(*q));
                }
            }
            let scaled = nearest * (per_sphere as f64).sqrt();
            assert!(scaled > 1.9, "N = {n} {domain}: {scaled}");
        }
    }
}
