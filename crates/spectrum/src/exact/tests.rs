//! The two ways against each other, against sums over all strata and against finer quadrature.

use sphvar_healpix::{Cell, Nside};
use sphvar_samplers::{Domain, EqualArea, Pattern, Placement};

use super::chords::{self, ChordMoments};
use super::partition::Partition;
use super::quadrature::Quadrature;
use super::{cell_means, exact_spectrum, exact_spectrum_cost, has_exact_spectrum, strata};
use crate::Error;

const EQUAL_AREA: Pattern = Pattern::EqualArea { placement: Placement::Jittered };

fn healpix(nside: u32) -> Partition {
    Partition::Healpix(Nside::new(nside).unwrap())
}

fn zonal(n: usize, domain: Domain) -> Partition {
    Partition::of(&EQUAL_AREA, n, domain).unwrap().unwrap()
}

/// Partitions with every kind of stratum: poles, caps, cells cut at |z| = 2/3, belts, odd and even, collars of few
/// and of many regions, mirrored and not.
fn partitions() -> Vec<(String, Partition)> {
    let cells = [1, 2, 3, 4, 5, 8].map(|n| (format!("nside {n}"), healpix(n)));
    let regions = [1, 2, 3, 4, 5, 7, 12, 33, 150].into_iter().flat_map(|n| {
        [Domain::Sphere, Domain::Hemisphere].map(|d| (format!("{n} regions of the {d}"), zonal(n, d)))
    });
    cells.into_iter().chain(regions).collect()
}

fn by_chords(partition: &Partition, degree: usize, lmax: usize) -> Vec<f64> {
    let count = chords::n_moments(lmax, partition.longest_chord_squared());
    ChordMoments::new(partition, degree, count, &|_| ()).unwrap().power(lmax)
}

fn by_means(partition: &Partition, degree: usize, lmax: usize) -> Vec<f64> {
    cell_means::power(partition, degree, lmax, &|_| ()).unwrap()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).skip(1).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn largest_ratio(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).skip(1).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn debug_print() {
    for (name, partition) in partitions() {
        let lmax = 24;
        let t = std::time::Instant::now();
        let c = by_chords(&partition, lmax, lmax);
        let tc = t.elapsed().as_secs_f64();
        let t = std::time::Instant::now();
        let m = by_means(&partition, lmax, lmax);
        let tm = t.elapsed().as_secs_f64();
        let cf = by_chords(&partition, 2 * lmax + 40, lmax);
        let mf = by_means(&partition, 2 * lmax + 40, lmax);
        eprintln!("{name}: K {} diff {:.1e} finer {:.1e} rel, {:.1e} times {tc:.3} {tm:.3} P1 {:e}",
            chords::n_moments(lmax, partition.longest_chord_squared()),
            largest_difference(&c, &m), largest_ratio(&c, &cf), largest_difference(&m, &mf), c[1]);
    }
}
