//! Compares the two methods with each other, with sums over all strata and with finer quadrature.

use std::sync::Mutex;

use sphvar_healpix::{Cell, Nside};
use sphvar_samplers::{
    Domain, EqualArea, EqualAreaParameters, Pattern, Placement, Purpose, Realizations,
    SECONDS_PER_WORK, Strata, Streams,
};

use super::chord_moments::{self, ChordMoments};
use super::partition::Partition;
use super::quadrature::Quadrature;
use super::{ExactSpectrum, cell_means, strata};
use crate::{Error, Resolution, SpectrumAccumulator, accumulate};

const EQUAL_AREA: Pattern =
    Pattern::EqualArea(EqualAreaParameters { placement: Placement::Jittered });

fn healpix(nside: u32) -> Partition {
    Partition::Healpix(Nside::new(nside).unwrap())
}

fn zonal(n: usize, domain: Domain) -> Partition {
    let regions = EqualArea::new(n, domain, Placement::Jittered).unwrap();
    Partition::of(Strata::EqualArea(&regions), n).unwrap()
}

/// Returns partitions with every kind of stratum: poles, caps, cells split at |z| = 2/3, belts, odd
/// and even counts, collars of few and of many regions, with and without reflection.
fn partitions() -> Vec<(String, Partition)> {
    let cells = [1, 2, 3, 4, 5, 8].map(|n| (format!("nside {n}"), healpix(n)));
    let regions = [1, 2, 3, 4, 5, 7, 12, 33, 150].into_iter().flat_map(|n| {
        let of = |domain| (format!("{n} regions of the {domain}"), zonal(n, domain));
        [Domain::Sphere, Domain::Hemisphere].map(of)
    });
    cells.into_iter().chain(regions).collect()
}

fn by_chords(partition: &Partition, degree: usize, lmax: usize) -> Vec<f64> {
    let count = chord_moments::n_moments(lmax, partition.longest_chord_squared());
    ChordMoments::new(partition, degree, count, &()).unwrap().power(lmax)
}

fn by_means(partition: &Partition, degree: usize, lmax: usize) -> Vec<f64> {
    cell_means::power(partition, degree, lmax, &()).unwrap()
}

fn assert_near(got: &[f64], expected: &[f64], tolerance: impl Fn(f64) -> f64, what: &str) {
    assert_eq!(got.len(), expected.len());
    for (l, (a, b)) in got.iter().zip(expected).enumerate().skip(1) {
        assert!((a - b).abs() <= tolerance(*b), "{what}, degree {l}: {a:e}, expected {b:e}");
    }
}

/// Rounding of a sum of a few hundred weights, of which 10 to 50 terms of similar size remain.
const RELATIVE: f64 = 100.0 * f64::EPSILON;

/// Cell means come from a transform with an error of 1e-13 of the sum of the weights, squared.
const ABSOLUTE: f64 = 2.0 * super::EPSILON;

#[test]
fn both_ways_agree() {
    for (name, partition) in partitions() {
        let (chords, means) = (by_chords(&partition, 24, 24), by_means(&partition, 24, 24));
        assert_near(&chords, &means, |_| ABSOLUTE, &name);
    }
    // Strata many wavelengths wide, by the fast transform.
    for (name, partition, lmax) in
        [("nside 2", healpix(2), 90), ("60 regions", zonal(60, Domain::Sphere), 100)]
    {
        let (chords, means) = (by_chords(&partition, lmax, lmax), by_means(&partition, lmax, lmax));
        assert_near(&chords, &means, |_| 4.0 * ABSOLUTE, name);
    }
}

/// More nodes, up to twice the number along an edge, change the result only by rounding.
#[test]
fn the_quadrature_has_converged() {
    const LMAX: usize = 24;
    for (name, partition) in partitions() {
        let (got, finer) = (by_chords(&partition, LMAX, LMAX), by_chords(&partition, 60, LMAX));
        assert_near(&got, &finer, |p| RELATIVE * p, &name);
    }
    for (name, partition) in [("nside 1", healpix(1)), ("7 regions", zonal(7, Domain::Sphere))] {
        let (got, finer) = (by_means(&partition, 100, 100), by_means(&partition, 220, 100));
        assert_near(&got, &finer, |_| 2.0 * ABSOLUTE, name);
    }
}

/// Doubling the number of moments changes the result only by rounding.
#[test]
fn the_series_has_converged() {
    for (nside, lmax) in [(1, 3), (4, 20), (8, 100), (64, 8)] {
        let partition = healpix(nside);
        let count = chord_moments::n_moments(lmax, partition.longest_chord_squared());
        let power = |count| ChordMoments::new(&partition, lmax, count, &()).unwrap().power(lmax);
        assert_near(&power(count), &power(2 * count), |p| RELATIVE * p, &format!("nside {nside}"));
    }
}

/// Compares the classes and their sizes with all cells, each split along u + v = 1 even where this
/// is unnecessary, by the definition: Legendre polynomials of the angles between pairs of nodes.
#[test]
fn classes_stand_for_all_cells() {
    for nside in 1..=5 {
        let partition = healpix(nside);
        let shares: f64 =
            (0..partition.n_rows()).flat_map(|r| partition.row(r)).map(|c| c.share).sum();
        assert!((shares - 1.0).abs() < 64.0 * f64::EPSILON, "nside {nside}: {shares}");
        let resolution = Nside::new(nside).unwrap();
        let side = 0..nside;
        // An edge spans a phase of 1.5/nside * 4: the error of this number of nodes is below 1e-12.
        let nodes = if nside == 1 { 14 } else { 10 };
        let mut means = [0.0; 5];
        let mut n_cells = 0.0;
        for face in 0..12 {
            for (ix, iy) in side.clone().flat_map(|ix| side.clone().map(move |iy| (ix, iy))) {
                let cell = Cell::new(resolution, face, ix, iy).unwrap();
                let rule = Quadrature::of_cut_cell(cell, nodes).unwrap();
                add_legendre_means(&rule, &mut means);
                n_cells += 1.0;
            }
        }
        let expected = means.map(|mean| 1.0 - mean / n_cells);
        let got = by_chords(&partition, 4, 4);
        assert_near(&got, &expected, |_| 1e-12, &format!("nside {nside}"));
    }
}

/// The same for zones, whose classes are counted in a list of all regions.
#[test]
fn classes_stand_for_all_regions() {
    for (n, domain) in [1, 2, 3, 5, 9, 34, 35]
        .into_iter()
        .flat_map(|n| [(n, Domain::Sphere), (n, Domain::Hemisphere)])
    {
        let regions = EqualArea::new(n, domain, Placement::Jittered).unwrap();
        let mut means = [0.0; 5];
        for region in regions.regions() {
            // Enough nodes for the full circle and for half of it.
            let rule = Quadrature::of_region(&region, 12, 22).unwrap();
            add_legendre_means(&rule, &mut means);
        }
        let expected = means.map(|mean| 1.0 - mean / n as f64);
        let got = by_chords(&zonal(n, domain), 4, 4);
        assert_near(&got, &expected, |_| 1e-12, &format!("{n} regions of the {domain}"));
    }
}

/// Adds `E P_l(x.y)` for l from 0, by the addition theorem expressed in moments of the coordinates:
/// `P_l` is a polynomial in `x.y`, and `E (x.y)^p` the squared norm of the mean tensor `x^p`.
fn add_legendre_means(rule: &Quadrature, means: &mut [f64; 5]) {
    let tensor = |p: u32| -> f64 {
        let indices = (0..3_usize.pow(p)).map(|code| {
            let component = |x: glam::DVec3| {
                let factors = (0..p).map(|d| x.to_array()[code / 3_usize.pow(d) % 3]);
                factors.product::<f64>()
            };
            let nodes = rule.points.iter().zip(&rule.weights);
            nodes.map(|(x, w)| w * component(*x)).sum::<f64>().powi(2)
        });
        indices.sum()
    };
    let [p0, p1, p2, p3, p4] = [0, 1, 2, 3, 4].map(tensor);
    means[0] += p0;
    means[1] += p1;
    means[2] += 1.5 * p2 - 0.5 * p0;
    means[3] += 2.5 * p3 - 1.5 * p1;
    means[4] += (35.0 * p4 - 30.0 * p2 + 3.0 * p0) / 8.0;
}

/// The Chebyshev moments are defined on [-1, 1] only if the chord bound holds.
#[test]
fn no_chord_is_longer_than_the_bound() {
    for (name, partition) in partitions().into_iter().chain([("large".into(), healpix(40))]) {
        let bound = partition.longest_chord_squared();
        for class in (0..partition.n_rows()).flat_map(|row| partition.row(row)) {
            let points = class.quadrature(0).unwrap().points;
            let longest = points.iter().flat_map(|x| points.iter().map(|y| x.distance_squared(*y)));
            let longest = longest.fold(0.0, f64::max);
            assert!(longest <= bound, "{name}: {longest}, bound {bound}");
        }
    }
}

/// The work computed in advance equals the work ticked by the classes.
#[test]
fn ticks_add_up_to_the_work() {
    for (pattern, n, domain, lmax) in [
        (Pattern::Jittered, 12, Domain::Sphere, 5),
        (Pattern::Jittered, 12, Domain::Sphere, 60),
        (Pattern::Jittered, 6 * 49, Domain::Hemisphere, 40),
        (EQUAL_AREA, 35, Domain::Sphere, 50),
        (Pattern::FIBONACCI, 100, Domain::Sphere, 20),
        (Pattern::WhiteNoise, 100, Domain::Sphere, 20),
    ] {
        let reported = Mutex::new(0.0);
        let sampler = pattern.build(n, domain).unwrap();
        let exact = ExactSpectrum::of(&*sampler).unwrap();
        exact.to(lmax, &|work| *reported.lock().unwrap() += work).unwrap();
        let (reported, work) = (reported.into_inner().unwrap(), exact.work(lmax));
        assert!((reported - work).abs() <= 1e-12 * work, "{pattern}: {reported}, {work}");
    }
}

/// Compares the combination of both methods with chords for all degrees, at any cost.
#[test]
fn the_ways_are_joined_without_a_seam() {
    for (name, partition, lmax) in
        [("nside 1", healpix(1), 60), ("20 regions", zonal(20, Domain::Hemisphere), 80)]
    {
        assert!(
            cell_means::work(&partition, lmax) < chord_moments::work(&partition, lmax),
            "{name}"
        );
        let got = strata::power(&partition, lmax, &()).unwrap();
        assert_near(&got, &by_chords(&partition, lmax, lmax), |_| 4.0 * ABSOLUTE, name);
        assert_near(&got[..4], &by_chords(&partition, 3, 3), |p| RELATIVE * p, name);
    }
}

#[test]
fn patterns_of_known_distribution_have_an_exact_spectrum() {
    let centred = Pattern::EqualArea(EqualAreaParameters { placement: Placement::Centred });
    for pattern in Pattern::ALL.into_iter().chain([centred]) {
        let is_known = matches!(
            pattern,
            Pattern::WhiteNoise | Pattern::Jittered | Pattern::EqualArea { .. } | Pattern::Dpp
        );
        let n = pattern.nearest_count(12, Domain::Sphere);
        let sampler = pattern.build(n, Domain::Sphere).unwrap();
        let exact = ExactSpectrum::of(&*sampler);
        assert_eq!(exact.is_some(), is_known || !sampler.is_random(), "{pattern}");
        if let Some(exact) = exact {
            let spectrum = exact.to(4, &()).unwrap();
            assert!(spectrum.is_exact() && spectrum.lmax() == 4, "{spectrum:?}");
            assert_eq!(spectrum.realizations(), 0);
            // That of degree 0 is the effective number of points.
            let mut rng = Streams::new(0, Purpose::Pattern, 0).realization(0);
            let n_effective = sampler.sample(&mut rng).unwrap().n_effective();
            let off = spectrum.power()[0] - n_effective;
            assert!(off.abs() < 1e-13 * n_effective, "{pattern}: {off:e}");
        }
    }
}

#[test]
fn extreme_inputs_succeed_or_return_an_error() {
    let run = |pattern: &Pattern, n, lmax| -> Result<Vec<f64>, Error> {
        let sampler = pattern.build(n, Domain::Sphere)?;
        let exact = ExactSpectrum::of(&*sampler).expect("strata or a single set");
        Ok(exact.to(lmax, &())?.power().to_vec())
    };
    assert!(matches!(run(&Pattern::Jittered, 13, 4), Err(Error::Sampler(_))));
    assert!(matches!(run(&EQUAL_AREA, 0, 4), Err(Error::Sampler(_))));
    for pattern in [Pattern::Jittered, Pattern::WhiteNoise, Pattern::Healpix] {
        let error = run(&pattern, 12, usize::MAX).unwrap_err();
        assert!(matches!(error, Error::Transform(_)), "{error}");
        assert_eq!(run(&pattern, 12, 0), Ok(vec![12.0]), "{pattern}");
    }
    // One uniform point on the sphere is white noise.
    for p in &run(&EQUAL_AREA, 1, 30).unwrap()[1..] {
        assert!((p - 1.0).abs() < RELATIVE, "{p}");
    }
    // The work is estimated immediately even for very large patterns.
    let work = |pattern: &Pattern, n| {
        let sampler = pattern.build(n, Domain::Sphere).unwrap();
        ExactSpectrum::of(&*sampler).unwrap().work(100)
    };
    assert!(SECONDS_PER_WORK * work(&Pattern::Jittered, 12 << 58) > 1e6);
    assert!(work(&EQUAL_AREA, u32::MAX as usize) > 0.0);
}

/// The mean power of 400 sets of 100 points, not rotated, against the closed form. The powers of
/// different degrees are nearly independent: over 600 degrees (300 on the hemisphere), chi2/dof has
/// the standard deviation 0.06 (0.08), so that a correct program is outside [0.85, 1.15] with 1 %
/// (7 %) of all seeds, and has one of the 900 scores beyond 4.7 with 0.3 %.
#[test]
#[ignore = "statistics"]
fn the_spherical_ensemble_has_the_power_of_the_closed_form() {
    const LMAX: usize = 600;
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let sampler = Pattern::Dpp.build(100, domain).unwrap();
        let exact = ExactSpectrum::of(&*sampler).unwrap().to(LMAX, &()).unwrap();
        let sets = Realizations::unrotated(&*sampler, Streams::new(4, Purpose::Pattern, 100));
        let empty = SpectrumAccumulator::new(domain, 100, LMAX);
        let got = accumulate(&sets, Resolution::new(LMAX, 100), 0..400, &empty, &());
        let got = got.unwrap().finish().unwrap();
        let scores: Vec<f64> = got
            .rows()
            .filter(|&(l, ..)| l > 0)
            .map(|(l, power, stderr)| (power - exact.power()[l]) / stderr)
            .collect();
        let chi2 = scores.iter().map(|z| z * z).sum::<f64>() / scores.len() as f64;
        assert!((0.85..1.15).contains(&chi2), "{domain}: chi2/dof = {chi2}");
        let worst = scores.iter().fold(0.0, |worst: f64, z| worst.max(z.abs()));
        assert!(worst < 4.7, "{domain}: {worst} standard errors");
    }
}
