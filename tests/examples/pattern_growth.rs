//! Prints the time to generate one set of every pattern over a range of numbers of points, and how
//! it grows.
//!
//! ```text
//! cargo run --release -p sphvar-tests --example pattern_growth -- [PATTERN | N]...
//! ```
//!
//! The default patterns are `Pattern::ALL`; name others as in `step:flat=0,core=0`. Numbers replace
//! the default numbers of points, and then no row is skipped for its time. Everything runs on one
//! thread with warm buffers, on the sphere. The last column is the least-squares slope of log(time)
//! over log(N) for the last four rows of the pattern.

use std::io::{self, Write};
use std::time::Instant;

use sphvar_samplers::{Domain, Error, Pattern, PointSet, Purpose, Streams};

/// Factors of 4, from 256 points to a million.
const LADDER: [usize; 7] = [256, 1024, 4096, 16_384, 65_536, 262_144, 1_048_576];

/// Time limit per pattern, in seconds, so that the whole table takes less than a minute.
const SECONDS_PER_PATTERN: f64 = 8.0;

/// Minimum and maximum number of timed sets; beyond the minimum, timing stops after
/// `SECONDS_PER_ROW`.
const SETS: [usize; 2] = [3, 25];
const SECONDS_PER_ROW: f64 = 0.3;

/// Overheads dominate for few points, so only the last rows enter the exponent.
const MAX_FITTED: usize = 4;

/// One row of the table.
struct Row {
    n_points: usize,
    seconds: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut patterns, mut counts) = (Vec::new(), Vec::new());
    for argument in std::env::args().skip(1) {
        if let Ok(n) = argument.parse() {
            counts.push(n);
            continue;
        }
        patterns.push(argument.parse()?);
    }
    if patterns.is_empty() {
        patterns = Pattern::ALL.into();
    }

    let mut out = io::stdout().lock();
    writeln!(out, "| pattern | N | ms a set | sets | million points/s | exponent |")?;
    writeln!(out, "|---|--:|--:|--:|--:|--:|")?;
    for pattern in &patterns {
        print_growth(&mut out, pattern, &counts)?;
    }
    Ok(())
}

/// Prints the rows of one pattern as they are measured, with the exponent in the last.
fn print_growth(
    out: &mut impl Write,
    pattern: &Pattern,
    counts: &[usize],
) -> Result<(), Box<dyn std::error::Error>> {
    let ladder = if counts.is_empty() { &LADDER } else { counts };
    let start = Instant::now();
    let mut rows: Vec<Row> = Vec::new();
    let mut requests = ladder.iter().copied().peekable();
    while let Some(requested) = requests.next() {
        let n_points = pattern.nearest_count(requested, Domain::Sphere);
        let (seconds, sets) = time(pattern, n_points)?;
        rows.push(Row { n_points, seconds });
        let next = requests.peek().map(|&next| seconds_at(&rows, next));
        let left = SECONDS_PER_PATTERN - start.elapsed().as_secs_f64();
        let is_last = next.is_none_or(|next| {
            // The first set is not timed.
            counts.is_empty() && (SETS[0] + 1) as f64 * next > left
        });
        let exponent = exponent(&rows)
            .filter(|_| is_last)
            .map_or_else(String::new, |exponent| format!("{exponent:.2}"));
        writeln!(
            out,
            "| {pattern} | {n_points} | {:.*} | {sets} | {:.*} | {exponent} |",
            decimals(1e3 * seconds),
            1e3 * seconds,
            decimals(1e-6 * n_points as f64 / seconds),
            1e-6 * n_points as f64 / seconds,
        )?;
        out.flush()?;
        if is_last {
            break;
        }
    }
    Ok(())
}

/// Returns the median time for a set, and the number of sets timed.
fn time(pattern: &Pattern, n_points: usize) -> Result<(f64, usize), Error> {
    let sampler = pattern.build(n_points, Domain::Sphere)?;
    let streams = Streams::new(0, Purpose::Pattern, n_points);
    let mut set = PointSet::default();
    let mut sample = |realization| -> Result<f64, Error> {
        let start = Instant::now();
        sampler.sample_into(&mut streams.realization(realization), &mut set)?;
        Ok(start.elapsed().as_secs_f64())
    };
    // The first set allocates the memory that the others reuse.
    sample(0)?;
    let mut times = Vec::new();
    let start = Instant::now();
    for realization in 1..=SETS[1] as u64 {
        times.push(sample(realization)?);
        if times.len() >= SETS[0] && start.elapsed().as_secs_f64() > SECONDS_PER_ROW {
            break;
        }
    }
    times.sort_by(f64::total_cmp);
    Ok((times[times.len() / 2], times.len()))
}

/// Returns the expected time for a set of `n_points`, extrapolated from the last two rows, or
/// quadratically from a single one.
fn seconds_at(rows: &[Row], n_points: usize) -> f64 {
    let [.., last] = rows else { return 0.0 };
    let exponent = match rows {
        [.., before, _] => slope([before, last].into_iter()).clamp(1.0, 2.5),
        _ => 2.0,
    };
    last.seconds * (n_points as f64 / last.n_points as f64).powf(exponent)
}

/// Returns the exponent of the last rows, if there are at least two.
fn exponent(rows: &[Row]) -> Option<f64> {
    let fitted = &rows[rows.len().saturating_sub(MAX_FITTED)..];
    (fitted.len() >= 2).then(|| slope(fitted.iter()))
}

/// Returns the least-squares slope of log(seconds) over log(N).
fn slope<'a>(rows: impl Iterator<Item = &'a Row> + Clone) -> f64 {
    let logs = rows.map(|row| ((row.n_points as f64).ln(), row.seconds.ln()));
    let count = logs.clone().count() as f64;
    let x_mean = logs.clone().map(|(x, _)| x).sum::<f64>() / count;
    let covariance: f64 = logs.clone().map(|(x, y)| (x - x_mean) * y).sum();
    let variance: f64 = logs.map(|(x, _)| (x - x_mean).powi(2)).sum();
    covariance / variance
}

/// Returns the number of decimals that shows three significant digits.
fn decimals(x: f64) -> usize {
    match x {
        100.0.. => 0,
        10.0.. => 1,
        1.0.. => 2,
        _ => 3,
    }
}
