//! A process that transforms points on request, timed by `benches/peers/transforms.py` together
//! with ducc0.
//!
//! Reads one command per line from standard input and answers each with one line. A command that
//! fails ends the process with a message. Points are unit vectors, three little-endian f64 each.
//!
//! ```text
//! load PATH N                                 loads a file of exactly N points        -> ok
//! weigh N                                     uses only the first N until the next load -> ok
//! plan LMAX EPSILON                           plans a fast transform and runs it once -> ok
//! run                                         runs it again                           -> seconds
//! exact LMAX                                  transforms the points by the definition -> seconds
//! ensemble SETS POINTS LMAX EPSILON THREADS   transforms SETS sets, keeps the first   -> seconds
//! write PATH                                  writes coefficients in `LmIndex` order  -> ok
//! ```
//!
//! The time of `run` excludes planning and allocation and includes the computation of angles from
//! the vectors. The time of `ensemble` includes planning, threads and allocation.

use std::error::Error;
use std::fs::{self, File};
use std::io::{BufRead, BufWriter, Write};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Number of sets that a thread of an ensemble transforms together; they share a recurrence.
const BATCH: usize = 4;

fn main() -> Result<()> {
    let mut server = Server::default();
    let mut out = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let answer = server.answer(&words).map_err(|error| format!("`{line}`: {error}"))?;
        match answer {
            Some(seconds) => writeln!(out, "{seconds:e}")?,
            None => writeln!(out, "ok")?,
        }
        out.flush()?;
    }
    Ok(())
}

#[derive(Default)]
struct Server {
    points: Vec<DVec3>,
    /// 1 for points in use, 0 for others; `None` if all are in use.
    weights: Option<Vec<f64>>,
    plan: Option<FastTransform>,
    workspace: FastWorkspace,
    result: Option<Alm>,
}

impl Server {
    /// Executes a command. Returns the seconds if the command is timed.
    fn answer(&mut self, words: &[&str]) -> Result<Option<f64>> {
        match *words {
            ["load", path, n] => {
                self.points = load(path, n.parse()?)?;
                self.weights = None;
            }
            ["weigh", n] => {
                let mut weights = vec![1.0; n.parse()?];
                if weights.len() > self.points.len() {
                    return Err(format!("only {} points are loaded", self.points.len()).into());
                }
                weights.resize(self.points.len(), 0.0);
                self.weights = Some(weights);
            }
            ["plan", lmax, epsilon] => {
                let lmax = lmax.parse()?;
                self.plan = Some(FastTransform::new(lmax, epsilon.parse()?)?);
                self.workspace = FastWorkspace::default();
                self.result = Some(Alm::zeros(lmax)?);
                self.run()?;
            }
            ["run"] => return self.run().map(Some),
            ["exact", lmax] => {
                let transform = ExactTransform::new(lmax.parse()?)?;
                let mut alm = Alm::zeros(transform.lmax())?;
                let mut workspace = ExactWorkspace::default();
                let n = self.weights.as_ref().map_or(self.points.len(), |weights| {
                    weights.iter().take_while(|&&weight| weight > 0.0).count()
                });
                let start = Instant::now();
                transform.adjoint_into(&self.points[..n], None, &mut workspace, &mut alm);
                let seconds = start.elapsed().as_secs_f64();
                // `run` must not write to coefficients of a different degree.
                self.plan = None;
                self.result = Some(alm);
                return Ok(Some(seconds));
            }
            ["ensemble", sets, n_points, lmax, epsilon, threads] => {
                let (sets, n_points): (usize, usize) = (sets.parse()?, n_points.parse()?);
                if n_points == 0 || sets.checked_mul(n_points) != Some(self.points.len()) {
                    return Err(format!("only {} points are loaded", self.points.len()).into());
                }
                let (lmax, epsilon) = (lmax.parse()?, epsilon.parse()?);
                let start = Instant::now();
                let first = ensemble(&self.points, n_points, lmax, epsilon, threads.parse()?)?;
                let seconds = start.elapsed().as_secs_f64();
                self.plan = None;
                self.result = Some(first);
                return Ok(Some(seconds));
            }
            ["write", path] => {
                write(path, self.result.as_ref().ok_or("no coefficients computed")?)?;
            }
            _ => return Err("unknown command or wrong number of arguments".into()),
        }
        Ok(None)
    }

    fn run(&mut self) -> Result<f64> {
        let (Some(plan), Some(alm)) = (&self.plan, &mut self.result) else {
            return Err("no plan; use `plan` first".into());
        };
        let start = Instant::now();
        plan.adjoint_into(&self.points, self.weights.as_deref(), &mut self.workspace, alm);
        Ok(start.elapsed().as_secs_f64())
    }
}

/// Transforms all sets; each thread takes the next batch when it is idle. Returns the coefficients
/// of the first set.
fn ensemble(
    points: &[DVec3],
    n_points: usize,
    lmax: usize,
    epsilon: f64,
    threads: usize,
) -> Result<Alm> {
    let plan = FastTransform::new(lmax, epsilon)?;
    let empty = Alm::zeros(lmax)?;
    let first = Mutex::new(empty.clone());
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                let mut workspace = FastWorkspace::default();
                let mut outs = vec![empty.clone(); BATCH];
                let mut sets = Vec::with_capacity(BATCH);
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(batch) = points.chunks(BATCH * n_points).nth(i) else { break };
                    sets.clear();
                    sets.extend(batch.chunks(n_points).map(|set| (set, None)));
                    plan.adjoint_batch_into(&sets, &mut workspace, &mut outs[..sets.len()]);
                    if i == 0 {
                        first
                            .lock()
                            .expect("no thread panics while holding the lock")
                            .clone_from(&outs[0]);
                    }
                }
            });
        }
    });
    Ok(first.into_inner()?)
}

fn load(path: &str, n: usize) -> Result<Vec<DVec3>> {
    let bytes = fs::read(path)?;
    let (numbers, rest) = bytes.as_chunks();
    let numbers: Vec<f64> = numbers.iter().map(|&bytes| f64::from_le_bytes(bytes)).collect();
    let (points, lone) = numbers.as_chunks();
    if points.len() != n || !lone.is_empty() || !rest.is_empty() {
        return Err(format!("{} bytes are not {n} points of 24 bytes", bytes.len()).into());
    }
    Ok(points.iter().map(|&xyz| DVec3::from_array(xyz)).collect())
}

/// Writes real and imaginary parts alternately, as little-endian f64.
fn write(path: &str, alm: &Alm) -> Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    for a in alm.values() {
        file.write_all(&a.re.to_le_bytes())?;
        file.write_all(&a.im.to_le_bytes())?;
    }
    Ok(file.flush()?)
}
