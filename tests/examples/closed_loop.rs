//! Predicted over measured variance of every pattern: two integrands, ten numbers of points, sphere
//! and hemisphere, with spectra and trials that share no random numbers. Prints Markdown.
//!
//! `closed_loop [SECONDS]` spends about that many core seconds (default: 1) on the trials of a cell
//! and four times that on its spectrum, more where that would be too few sets; cells that still
//! take too long are skipped and listed.

use std::io::Write;

use sphvar_integrands::{Cap, ClampedCosine, Harmonic, Integrand};
use sphvar_samplers::{
    Domain, Pattern, PoissonDiskParameters, Purpose, Realizations, SECONDS_PER_WORK,
    SpectralControl, StepParameters, Streams,
};
use sphvar_spectrum::{Method, Spectrum, estimate};
use sphvar_tests::{ks_distance, ks_p_value};
use sphvar_variance::{
    Comparison, Crossover, PredictionBudget, Predictor, Trials, VariancePoint, crossover, fit_rate,
    measure, predict,
};
use statrs::distribution::{ContinuousCDF, Normal};

const SEED: u64 = 2026;
const COUNTS: [usize; 10] = [12, 48, 108, 192, 432, 768, 1452, 3072, 6348, 12288];
/// Fewer trials give imprecise variances with scores that are not normal.
const MIN_TRIALS: u64 = 200;
const MIN_SETS: u64 = 40;
/// A cell is skipped if the minimum of both would exceed this multiple of the requested time.
const PATIENCE: f64 = 12.0;
/// The rounding of an estimate, below which it resolves nothing.
const NOTHING: f64 = 1e-20;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

struct Cell {
    pattern: Pattern,
    integrand: &'static str,
    domain: Domain,
    comparison: Comparison,
}

fn main() -> Outcome<()> {
    let seconds: f64 = std::env::args().nth(1).map_or(Ok(1.0), |s| s.parse())?;
    let mut out = std::io::stdout().lock();
    let cap = Cap::from_degrees(60.0)?;
    let harmonic = Harmonic::new(4, 0)?;
    let sphere: [(&'static str, &dyn Integrand); 2] = [("Y_40", &harmonic), ("cap", &cap)];
    let hemisphere: [(&'static str, &dyn Integrand); 2] =
        [("double cap", &cap), ("|x.d|", &ClampedCosine)];
    let mut cells = Vec::new();
    writeln!(
        out,
        "| pattern | N | integrand | trials | predicted | measured/predicted | z | bias z |"
    )?;
    writeln!(out, "|---|--:|---|--:|--:|--:|--:|--:|")?;
    for (domain, integrands) in [(Domain::Sphere, sphere), (Domain::Hemisphere, hemisphere)] {
        for pattern in Pattern::ALL {
            for requested in COUNTS {
                match study(&pattern, requested, domain, integrands, seconds)? {
                    Ok(found) => {
                        for cell in found {
                            write_row(&mut out, &cell)?;
                            cells.push(cell);
                        }
                    }
                    Err(reason) => {
                        writeln!(out, "| {pattern} | {requested} | {domain}: skipped, {reason} |")?;
                    }
                }
                out.flush()?;
            }
        }
    }
    judge(&mut out, &cells)?;
    rates(&mut out, &cells)?;
    steps(&mut out, &harmonic)?;
    for (integrand, name) in [(sphere[0].1, sphere[0].0), (sphere[1].1, sphere[1].0)] {
        overtaking(&mut out, integrand, name, seconds)?;
    }
    Ok(())
}

/// Returns the cells of both integrands for one pattern and number of points, or the reason for
/// skipping them.
fn study(
    pattern: &Pattern,
    requested: usize,
    domain: Domain,
    integrands: [(&'static str, &dyn Integrand); 2],
    seconds: f64,
) -> Outcome<Result<Vec<Cell>, String>> {
    let n = pattern.nearest_count(requested, domain);
    let set = SECONDS_PER_WORK * pattern.nominal_work(n);
    let trials = count(seconds / (set + 80e-9 * n as f64), 20_000).max(MIN_TRIALS);
    let sampler = pattern.build(n, domain)?;
    // Lattices have peaks at all degrees.
    let lmax = roots(domain.count_on_sphere(n), if sampler.is_random() { 8 } else { 40 });
    let realization = set + SECONDS_PER_WORK * Method::Auto.nominal_work(n, lmax);
    let sets = count(4.0 * seconds / realization, 4000).max(MIN_SETS);
    let sets = if sampler.is_random() { sets } else { 1 };
    let needed = 2.0 * MIN_TRIALS as f64 * set + sets.min(MIN_SETS) as f64 * realization;
    if needed > PATIENCE * seconds {
        return Ok(Err(format!("a set takes {set:.1e} s")));
    }
    let streams = Streams::new(SEED, Purpose::Pattern, pattern.stream_group(n));
    let spectrum = estimate(&Realizations::rotated(&*sampler, streams), lmax, sets, &())?;
    let mut cells = Vec::new();
    for (i, (name, integrand)) in integrands.into_iter().enumerate() {
        let comparison = run(pattern, n, domain, integrand, spectrum.clone(), trials, i as u64)?;
        cells.push(Cell { pattern: pattern.clone(), integrand: name, domain, comparison });
    }
    Ok(Ok(cells))
}

/// Returns a multiple of the root of a number of points, at least 32.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small number")]
fn roots(n_points: f64, multiple: usize) -> usize {
    (multiple * n_points.sqrt().ceil() as usize).max(32)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a positive number")]
fn count(x: f64, max: u64) -> u64 {
    (x as u64).min(max)
}

/// Returns the comparison with independent trials; `seed` distinguishes the integrands.
fn run(
    pattern: &Pattern,
    n: usize,
    domain: Domain,
    integrand: &dyn Integrand,
    spectrum: Spectrum,
    trials: u64,
    seed: u64,
) -> Outcome<Comparison> {
    let sampler = pattern.build(n, domain)?;
    let energy = integrand.energy(domain, spectrum.lmax())?;
    let prediction = predict(&spectrum, &energy);
    let predictor = Predictor::new(integrand, domain, SEED + 1 + seed, PredictionBudget::DEFAULT)?;
    Ok(predictor.measure(prediction, &*sampler, Trials::new(trials), &())?)
}

fn write_row(out: &mut impl Write, cell: &Cell) -> Outcome<()> {
    let c = &cell.comparison;
    let (ratio, error) = c.ratio();
    let bias = c.bias().map_or(f64::NAN, |b| b.z);
    writeln!(
        out,
        "| {} | {} | {} | {} | {:.3e} | {ratio:.3} +- {error:.3} | {:+.1} | {bias:+.1} |",
        cell.pattern,
        c.n_points,
        cell.integrand,
        c.measurement.estimates().len(),
        c.prediction.variance,
        c.z_score(),
    )?;
    Ok(())
}

/// Writes whether the loop is closed: ratios, z-scores and their distribution.
fn judge(out: &mut impl Write, cells: &[Cell]) -> Outcome<()> {
    let normal = Normal::standard();
    let (some, none): (Vec<&Cell>, Vec<&Cell>) =
        cells.iter().partition(|c| c.comparison.prediction.variance > NOTHING);
    let resolved = none.iter().filter(|c| c.comparison.measurement.variance() < NOTHING).count();
    writeln!(
        out,
        "\n{resolved} of {} cells predicted below {NOTHING:e} are measured so.",
        none.len()
    )?;
    let scores: Vec<f64> = some.iter().map(|c| c.comparison.z_score()).collect();
    let biases: Vec<f64> = some.iter().filter_map(|c| c.comparison.bias()).map(|b| b.z).collect();
    for (name, z) in [("variance", &scores), ("bias", &biases)] {
        let d = ks_distance(z, |x| normal.cdf(x));
        let mean = z.iter().sum::<f64>() / z.len() as f64;
        let chi2 = z.iter().map(|x| x * x).sum::<f64>() / z.len() as f64;
        let worst = z.iter().map(|x| x.abs()).fold(0.0, f64::max);
        writeln!(
            out,
            "{name}: {} z-scores, mean {mean:+.3}, chi2/dof {chi2:.3}, largest {worst:.2}, KS p = {:.3}",
            z.len(),
            ks_p_value(z.len(), d)
        )?;
    }
    let beyond: Vec<String> = some
        .iter()
        .filter(|c| {
            let (ratio, error) = c.comparison.ratio();
            (ratio - 1.0).abs() > 0.01 + 3.0 * error
        })
        .map(|c| format!("{} {} {}", c.pattern, c.comparison.n_points, c.integrand))
        .collect();
    writeln!(out, "beyond 1 % +- 3 sigma: {} of {}: {beyond:?}", beyond.len(), some.len())?;
    Ok(())
}

/// Rates on the sphere from 768 points on.
fn rates(out: &mut impl Write, cells: &[Cell]) -> Outcome<()> {
    writeln!(out, "\n| pattern | integrand | rate | 95 % | predicted | pre-asymptotic |")?;
    writeln!(out, "|---|---|--:|---|--:|---|")?;
    for pattern in Pattern::ALL {
        for integrand in ["Y_40", "cap"] {
            let of = |f: &dyn Fn(&Comparison) -> VariancePoint| -> Vec<VariancePoint> {
                cells
                    .iter()
                    .filter(|c| {
                        c.domain == Domain::Sphere
                            && c.pattern == pattern
                            && c.integrand == integrand
                            && c.comparison.n_points >= 768
                    })
                    .map(|c| f(&c.comparison))
                    .collect()
            };
            let measured = fit_rate(&of(&Comparison::measured_point));
            let predicted = fit_rate(&of(&Comparison::predicted_point));
            let (Some(m), Some(p)) = (measured, predicted) else {
                writeln!(out, "| {pattern} | {integrand} | - |")?;
                continue;
            };
            writeln!(
                out,
                "| {pattern} | {integrand} | {:.3} | {:.3} to {:.3} | {:.3} | {} |",
                m.slope,
                m.interval.0,
                m.interval.1,
                p.slope,
                if m.is_pre_asymptotic() { "yes" } else { "no" }
            )?;
        }
    }
    Ok(())
}

/// Writes the variance of the harmonic with sets that have no power in its degree; a few trials
/// suffice.
fn steps(out: &mut impl Write, harmonic: &Harmonic) -> Outcome<()> {
    const TRIALS: u64 = 20;
    let step =
        Pattern::Step(StepParameters { alpha: None, flat: None, core: SpectralControl::STEP_CORE });
    for n in [48, 192, 768] {
        let sampler = step.build(n, Domain::Sphere)?;
        let streams = Streams::new(SEED, Purpose::Trial, step.stream_group(n));
        let sets = Realizations::rotated(&*sampler, streams);
        let variance = measure(&sets, harmonic, TRIALS, &())?.variance();
        let verdict = if variance < NOTHING { "below" } else { "NOT below" };
        writeln!(
            out,
            "\nY_40 with {step}, N = {n}: variance {variance:.1e}, {verdict} {NOTHING:e}"
        )?;
    }
    Ok(())
}

/// Returns where jitter overtakes Poisson disks of exactly N points, from predicted variances at
/// many N.
fn overtaking(
    out: &mut impl Write,
    integrand: &dyn Integrand,
    name: &str,
    seconds: f64,
) -> Outcome<()> {
    let disks = Pattern::PoissonDisk(PoissonDiskParameters::DEFAULT);
    let curve = |pattern: &Pattern, counts: &[usize]| -> Outcome<Vec<VariancePoint>> {
        let mut points = Vec::new();
        for &n in counts {
            let sampler = pattern.build(n, Domain::Sphere)?;
            let band = integrand.band_limit();
            let lmax = band.unwrap_or_else(|| roots(n as f64, 8));
            let work = pattern.nominal_work(n) + Method::Auto.nominal_work(n, lmax);
            let realization = SECONDS_PER_WORK * work;
            let sets = count(5.0 * seconds / realization, 40_000).max(MIN_SETS);
            let streams = Streams::new(SEED + 9, Purpose::Pattern, pattern.stream_group(n));
            let spectrum = estimate(&Realizations::rotated(&*sampler, streams), lmax, sets, &())?;
            let energy = integrand.energy(Domain::Sphere, lmax)?;
            let prediction = predict(&spectrum, &energy);
            points.push(VariancePoint {
                n_points: n as f64,
                variance: prediction.variance,
                stderr: prediction.total_stderr(),
            });
        }
        Ok(points)
    };
    let jitter = curve(&Pattern::Jittered, &[48, 108, 192, 300, 432, 588, 768])?;
    let disk = curve(&disks, &[60, 108, 150, 192, 240, 300, 346, 400, 500, 768])?;
    match crossover(&jitter, &disk, Streams::new(SEED, Purpose::Resample, 0)) {
        Some(Crossover { n_points, interval: (low, high), confidence, .. }) => writeln!(
            out,
            "\n{name}: jitter overtakes {disks} at N = {n_points:.0} ({low:.0} to {high:.0}), share {confidence}"
        )?,
        None => writeln!(out, "\n{name}: jitter and {disks} do not cross")?,
    }
    Ok(())
}
