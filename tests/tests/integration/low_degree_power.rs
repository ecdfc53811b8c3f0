//! The behaviour at low degrees and the peaks of Poisson disks, capacity-constrained tessellations
//! and equal-area partitions, compared with measurements of independent programs.

use std::f64::consts::PI;
use std::ops::RangeInclusive;

use sphvar_samplers::{
    CcvtParameters, DiskMode, Domain, EqualArea, EqualAreaParameters, MassPoints, Pattern,
    Placement, PoissonDiskParameters, Purpose, Realizations, Streams,
};
use sphvar_spectrum::{Spectrum, estimate};
use sphvar_tests::{Family, chi2_interval, sidak_z};

const SEED: u64 = 17;
/// The probability that a family of comparisons fails by chance (nominal).
const ALPHA: f64 = 1e-4;

fn spectrum(pattern: &Pattern, n: usize, lmax: usize, realizations: u64) -> Spectrum {
    let sampler = pattern.build(n, Domain::Sphere).unwrap();
    let streams = Streams::new(SEED, Purpose::Pattern, n);
    let ensemble = Realizations::rotated(&*sampler, streams);
    estimate(&ensemble, lmax, realizations, &()).unwrap()
}

/// `x^2 = l(l+1)/N`.
fn x_squared(l: usize, n: usize) -> f64 {
    (l * (l + 1)) as f64 / n as f64
}

/// Returns a mean over degrees with weights 2l+1, and its standard error: degrees of isotropic sets
/// vary apart.
fn pooled(
    spectrum: &Spectrum,
    degrees: RangeInclusive<usize>,
    ratio: impl Fn(usize) -> f64,
) -> (f64, f64) {
    let (mut sum, mut squares, mut weights) = (0.0, 0.0, 0.0);
    for l in degrees {
        let weight = (2 * l + 1) as f64;
        weights += weight;
        sum += weight * spectrum.power()[l] / ratio(l);
        squares += (weight * spectrum.stderr()[l] / ratio(l)).powi(2);
    }
    (sum / weights, squares.sqrt() / weights)
}

/// A straight line `P = intercept + slope x^2`.
#[derive(Debug)]
struct Line {
    intercept: (f64, f64),
    slope: (f64, f64),
    chi2: f64,
    dof: usize,
}

/// Returns the line through `omega <= 0.5`. The relative error of P is the same but for 2l+1, which
/// is the weight: measured errors, which grow with the measured values, would bias it.
fn fit_low_degrees(spectrum: &Spectrum) -> Line {
    let n = spectrum.n_points();
    let last = n.isqrt() / 2;
    let rows: Vec<(f64, f64, f64, f64)> = spectrum
        .rows()
        .skip(1)
        .take(last)
        .map(|(l, p, e)| (x_squared(l, n), p, e, (2 * l + 1) as f64))
        .collect();
    let sum = |f: &dyn Fn(f64, f64, f64, f64) -> f64| -> f64 {
        rows.iter().map(|&(x, p, e, w)| f(x, p, e, w)).sum()
    };
    let weights = sum(&|_, _, _, w| w);
    let centre = sum(&|x, _, _, w| w * x) / weights;
    let spread = sum(&|x, _, _, w| w * (x - centre).powi(2));
    let slope = sum(&|x, p, _, w| w * (x - centre) * p) / spread;
    let intercept = sum(&|_, p, _, w| w * p) / weights - slope * centre;
    // Both are sums of P(l) times a factor.
    let of_slope = |x: f64, w: f64| w * (x - centre) / spread;
    let of_intercept = |x: f64, w: f64| w / weights - centre * of_slope(x, w);
    Line {
        intercept: (intercept, sum(&|x, _, e, w| (of_intercept(x, w) * e).powi(2)).sqrt()),
        slope: (slope, sum(&|x, _, e, w| (of_slope(x, w) * e).powi(2)).sqrt()),
        chi2: sum(&|x, p, e, _| ((p - intercept - slope * x) / e).powi(2)),
        dof: rows.len() - 2,
    }
}

/// Compares a number with an earlier measurement; both are uncertain.
fn compare(family: &mut Family, got: (f64, f64), recorded: (f64, f64), label: &str) {
    family.compare(got.0, recorded.0, got.1.hypot(recorded.1), || label.to_owned());
}

/// `P0 + c x^2` at low degrees and the mean of three degrees at omega = 2. The peak over all
/// degrees, 1.709(6) and 1.758(6), is a little higher because the largest of noisy numbers was
/// taken.
fn check_disks(mode: DiskMode, constant: (f64, f64), slope: (f64, f64), peak: (f64, f64)) {
    const N: usize = 4096;
    const REALIZATIONS: u64 = 300;
    let got = spectrum(
        &Pattern::PoissonDisk(PoissonDiskParameters { mode, ..PoissonDiskParameters::DEFAULT }),
        N,
        129,
        REALIZATIONS,
    );
    let line = fit_low_degrees(&got);
    let mut family = Family::new("power of Poisson disks at low degrees");
    compare(&mut family, line.intercept, constant, "P0");
    compare(&mut family, line.slope, slope, "c");
    let at_two = pooled(&got, 127..=129, |_| 1.0);
    compare(&mut family, at_two, peak, "P(omega = 2)");
    family.assert_null(ALPHA);
    let (low, high) = chi2_interval(line.dof, ALPHA);
    let chi2 = line.chi2 / line.dof as f64;
    assert!((low..=high).contains(&chi2), "{mode}: chi2/dof = {chi2}, {line:?}");
}

#[test]
#[ignore = "statistics"]
fn exact_poisson_disks_have_the_predicted_power() {
    check_disks(DiskMode::Exact, (0.0596, 0.0002), (0.038, 0.002), (1.701, 0.003));
}

/// The limit of the power at degree 0 is also the variance of the number of points, 0.058 N.
#[test]
#[ignore = "statistics"]
fn saturated_poisson_disks_have_the_predicted_power() {
    check_disks(DiskMode::Saturated, (0.0578, 0.0002), (0.034, 0.002), (1.751, 0.004));
}

/// The peak of 1024 exact disks: the largest mean of three neighbouring degrees, and where it is.
#[test]
#[ignore = "statistics"]
fn poisson_disks_peak_at_twice_the_root_of_n() {
    const N: usize = 1024;
    let disks = Pattern::PoissonDisk(PoissonDiskParameters::DEFAULT);
    let got = spectrum(&disks, N, 81, 500);
    let means = (48..=80).map(|l| (l, pooled(&got, l - 1..=l + 1, |_| 1.0)));
    let (l, peak) = means.max_by(|a, b| a.1.0.total_cmp(&b.1.0)).unwrap();
    let mut family = Family::new("the peak of Poisson disks");
    compare(&mut family, peak, (1.709, 0.006), "peak");
    family.assert_null(ALPHA);
    let omega = l as f64 / (N as f64).sqrt();
    assert!((omega - 2.0).abs() <= 0.1, "the peak is at omega = {omega}");
}

/// White mass points add their own noise: `P(l) capacity -> 1`.
#[test]
#[ignore = "statistics"]
fn tessellations_of_white_mass_keep_its_noise() {
    const N: usize = 1024;
    const CAPACITY: usize = 64;
    let ccvt = Pattern::Ccvt(CcvtParameters { capacity: CAPACITY, mass: MassPoints::White });
    let got = spectrum(&ccvt, N, 6, 60);
    // The quartic part 0.031 x^4 that theory.md fits is 0.3 % of 1/64 at degree 6.
    let formula = |l: usize| 1.0 / CAPACITY as f64 + 0.031 * x_squared(l, N).powi(2);
    let mut family = Family::new("P(l) m of white mass points");
    let mean = pooled(&got, 1..=6, formula);
    compare(&mut family, mean, (1.0, 0.006), "mean of P m");
    for (l, p, e) in got.rows().skip(1) {
        compare(&mut family, (p / formula(l), e / formula(l)), (1.0, 0.006), &format!("l = {l}"));
    }
    family.assert_null(ALPHA);
}

/// Mass points on a lattice give the quartic spectrum of sites at the means of their cells. The
/// coefficients are known to 1.5 and 4 %; starts from recursive bisection instead of random sites
/// add up to 2 % at degree 6.
#[test]
#[ignore = "statistics"]
fn tessellations_of_lattice_mass_are_quartic() {
    const N: usize = 1024;
    const ALLOWANCE: f64 = 0.02;
    let ccvt = Pattern::Ccvt(CcvtParameters { capacity: 64, mass: MassPoints::Fibonacci });
    let got = spectrum(&ccvt, N, 6, 80);
    let formula = |l: usize| {
        let (l, n) = (l as f64, N as f64);
        let traceless = (l - 1.0) * l * (l + 1.0) * (l + 2.0);
        (0.0145 * traceless + 0.00126 * (l * (l + 1.0)).powi(2)) / (n * n)
    };
    let (ratio, error) = pooled(&got, 2..=6, formula);
    // Of the sum, 0.0145 in 0.01576 comes from the first coefficient.
    let of_constant = (0.0002_f64.hypot(0.00007)) / 0.01576;
    let limit = sidak_z(ALPHA, 1) * error.hypot(of_constant) + ALLOWANCE;
    assert!((ratio - 1.0).abs() < limit, "P/formula = {ratio} +- {error}, limit {limit}");
}

/// `P(1)` of one point in each region: `1 - (1/N) sum_k |E_k x|^2`, with the mean direction of a
/// zonal rectangle in closed form.
fn power_at_degree_1(n: usize) -> f64 {
    let regions = EqualArea::new(n, Domain::Sphere, Placement::Jittered).unwrap();
    // int sqrt(1 - z^2) dz.
    let primitive = |theta: f64| 0.5 * (theta - theta.sin() * theta.cos());
    let squares = regions.regions().map(|region| {
        let ([z_min, z_max], [top, bottom]) = (region.z(), region.theta());
        let half = 0.5 * (region.phi()[1] - region.phi()[0]);
        assert!(half > 0.0 && half <= PI + 1e-15, "{region:?}");
        let radial = (primitive(bottom) - primitive(top)) / (z_max - z_min) * half.sin() / half;
        (0.5 * (z_min + z_max)).powi(2) + radial * radial
    });
    1.0 - squares.sum::<f64>() / n as f64
}

/// Strata of equal area have less power than white noise at every degree, and `c l(l+1)/N` at low
/// ones, with c = 1.0476 at degree 1 for 1024 zonal rectangles, nearly squares (pi/3 = 1.0472;
/// HEALPix 1.119).
#[test]
fn equal_area_strata_have_the_predicted_power_at_low_degrees() {
    const N: usize = 1024;
    const REALIZATIONS: u64 = 500;
    let equal_area = Pattern::EqualArea(EqualAreaParameters { placement: Placement::Jittered });
    let got = spectrum(&equal_area, N, 128, REALIZATIONS);
    let exact = power_at_degree_1(N) / x_squared(1, N);
    let mut family = Family::new("P(1) of equal-area strata");
    compare(&mut family, (got.power()[1], got.stderr()[1]), (exact * x_squared(1, N), 0.0), "P(1)");
    family.assert_null(ALPHA);
    let (c, error) = pooled(&got, 1..=4, |l| x_squared(l, N));
    assert!((1.0..=1.3).contains(&exact) && (1.0..=1.3).contains(&c), "c = {c}, {exact}");
    // The next order reduces this by less than x^2/2, 1 % at degree 4.
    let limit = sidak_z(ALPHA, 1) * error + 0.01;
    assert!((c - exact).abs() < limit, "c = {c} +- {error}, at degree 1 {exact}");
    // The mean is below 1 exactly; estimates may exceed it by chance.
    let limit = sidak_z(2.0 * ALPHA, 128);
    for (l, p, e) in got.rows().skip(1) {
        assert!(p < 1.0 + limit * e, "l = {l}: P = {p} +- {e}");
    }
    let weighted = pooled(&got, 1..=128, |_| 1.0);
    assert!(weighted.0 < 1.0, "mean power to degree 128: {weighted:?}");
}
