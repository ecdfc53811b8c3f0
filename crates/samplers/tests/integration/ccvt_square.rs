//! Capacity-constrained Voronoi tessellations of the square: the stopping criterion, the energy and
//! the spectrum, and the limits of the parameters.

use std::f64::consts::TAU;

use rand::Rng;
use sphvar_samplers::{
    CcvtSquare, Error, Purpose, SquareMassPoints, SquareSampler, Streams, Tessellation, WhiteSquare,
};

type Point = [f64; 2];

fn rng(group: usize, realization: u64) -> impl Rng {
    Streams::new(11, Purpose::Pattern, group).realization(realization)
}

fn tessellate(ccvt: &CcvtSquare, realization: u64) -> Tessellation<Point> {
    ccvt.tessellate(&mut rng(ccvt.n_points(), realization)).unwrap()
}

/// Returns the shortest step from one point to another.
fn step(from: Point, to: Point) -> Point {
    [0, 1].map(|axis| {
        let d = to[axis] - from[axis];
        d - d.round()
    })
}

fn squared(a: Point, b: Point) -> f64 {
    step(a, b).iter().map(|d| d * d).sum()
}

/// Returns the largest reduction of the sum of squared distances by an exchange of two points, over
/// all pairs of points of all pairs of sites.
fn best_exchange(tessellation: &Tessellation<Point>) -> f64 {
    let sites = tessellation.sites();
    let reduction = |from: usize, to: usize| {
        let of = |p| squared(p, sites[from]) - squared(p, sites[to]);
        tessellation.cell(from).map(of).fold(f64::NEG_INFINITY, f64::max)
    };
    let pairs = (0..sites.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
    pairs.map(|(i, j)| reduction(i, j) + reduction(j, i)).fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn a_settled_tessellation_has_no_exchange_left_and_sites_at_their_means() {
    for (n, capacity, mass_points) in [
        (64, 16, SquareMassPoints::White),
        (64, 16, SquareMassPoints::Lattice),
        (200, 64, SquareMassPoints::White),
        (12, 500, SquareMassPoints::Lattice),
        (2, 101, SquareMassPoints::White),
        (3, 40, SquareMassPoints::Lattice),
        (5, 1000, SquareMassPoints::White),
        (40, 3, SquareMassPoints::White),
        (30, 1, SquareMassPoints::White),
    ] {
        let ccvt = CcvtSquare::new(n, capacity, mass_points).unwrap();
        for realization in 0..3 {
            let tessellation = tessellate(&ccvt, realization);
            let what = format!("{ccvt:?}, realization {realization}");
            assert!(tessellation.is_settled(), "{what}");
            let mut mean_square = 0.0;
            for (k, &site) in tessellation.sites().iter().enumerate() {
                let mut sum = [0.0; 2];
                for p in tessellation.cell(k) {
                    mean_square += squared(site, p) / (n * capacity) as f64;
                    let step = step(site, p);
                    sum = [sum[0] + step[0], sum[1] + step[1]];
                }
                // Two roundings of coordinates for every point, and the remaining distance.
                let off = sum[0].hypot(sum[1]) / capacity as f64;
                assert!(off < 2e-13, "{what}: site {k} is {off} from its mean");
            }
            let energy = n as f64 * mean_square;
            let off = (tessellation.energy() - energy).abs();
            assert!(off <= 1e-12 * energy, "{what}: {energy} is off by {off}");
            // The tolerance of exchanges, and the rounding of four squared distances.
            let best = best_exchange(&tessellation);
            let tolerance = 1e-12 / n as f64 + 1e-14;
            assert!(best < tolerance, "{what}: an exchange would reduce the energy by {best}");
        }
    }
}

#[test]
fn every_mass_point_has_one_site() {
    let (n, capacity) = (60, 33);
    let tessellation =
        tessellate(&CcvtSquare::new(n, capacity, SquareMassPoints::White).unwrap(), 0);
    let mut owned: Vec<Point> = Vec::new();
    for k in 0..n {
        assert_eq!(tessellation.cell(k).len(), capacity);
        owned.extend(tessellation.cell(k));
    }
    // White mass points use the first numbers of the stream.
    let white = WhiteSquare::new(n * capacity).unwrap();
    let mut drawn = white.sample(&mut rng(n, 0)).unwrap().points;
    for points in [&mut owned, &mut drawn] {
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    }
    assert_eq!(owned, drawn);
}

/// Regular hexagons have the energy 5/(18 sqrt 3) = 0.1604. Means over 20 sets of 200 sites, whose
/// standard deviation is about 0.02/sqrt(200) each: the margins are more than ten standard errors.
#[test]
fn energies_are_near_that_of_hexagons() {
    for mass_points in [SquareMassPoints::White, SquareMassPoints::Lattice] {
        let ccvt = CcvtSquare::new(200, 64, mass_points).unwrap();
        let mean = (0..20).map(|i| tessellate(&ccvt, i).energy()).sum::<f64>() / 20.0;
        assert!((0.168..0.180).contains(&mean), "{mass_points:?}: {mean}");
    }
}

/// Returns the mean power at the frequencies with |k|^2 from 1 to 8 of 40 sets.
fn low_power(ccvt: &CcvtSquare) -> f64 {
    let frequencies: Vec<Point> = (-2..=2)
        .flat_map(|k1| (0..=2).map(move |k2| [f64::from(k1), f64::from(k2)]))
        .filter(|k| k[1] > 0.0 || k[0] > 0.0)
        .collect();
    let mut sum = 0.0;
    for realization in 0..40 {
        let points = ccvt.sample(&mut rng(7, realization)).unwrap().points;
        for k in &frequencies {
            let terms = points.iter().map(|p| (TAU * (k[0] * p[0] + k[1] * p[1])).sin_cos());
            let (sin, cos) = terms.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
            sum += (sin * sin + cos * cos) / points.len() as f64;
        }
    }
    sum / (40 * frequencies.len()) as f64
}

/// White mass points leave 1/64 = 0.0156; a lattice leaves nothing of its own. The mean over 480
/// exponential powers is known to 5 %, so a bound of half the value is ten standard errors away.
#[test]
fn mass_points_determine_the_power_at_low_frequencies() {
    let of = |mass| low_power(&CcvtSquare::new(256, 64, mass).unwrap());
    let [white, lattice] = [of(SquareMassPoints::White), of(SquareMassPoints::Lattice)];
    assert!((0.0078..0.024).contains(&white), "{white}");
    assert!(lattice < 0.001, "{lattice}");
}

#[test]
fn a_single_site_is_uniform_and_large_parameters_are_rejected() {
    for capacity in [1, 2, 50] {
        let one = CcvtSquare::new(1, capacity, SquareMassPoints::White).unwrap();
        let site = |i| one.sample(&mut rng(1, i)).unwrap().points;
        assert!(site(0).len() == 1 && site(0) != site(1), "capacity {capacity}");
    }
    for (n, capacity) in [(0, 64), (10, 0), (1 << 20, 1 << 12), (usize::MAX, 2)] {
        let rejected = CcvtSquare::new(n, capacity, SquareMassPoints::White).unwrap_err();
        assert!(matches!(rejected, Error::Parameter { .. }), "{n}, {capacity}");
    }
}
