//! A process that runs transforms on the torus on request, timed by `benches/peers/torus.py` together
//! with FINUFFT.
//!
//! Reads one command per line from standard input and answers each with one line. A command that
//! fails ends the process with a message. Files hold little-endian f64; complex numbers are pairs.
//!
//! ```text
//! points PATH                  loads points, two coordinates each                   -> ok
//! numbers PATH                 loads weights, or coefficients in the order of values -> ok
//! plan TYPE KMAX EPSILON       plans a transform and runs it once                   -> ok
//! run COUNT                    runs it COUNT times                                  -> seconds
//! write PATH                   writes the result                                    -> ok
//! ```
//!
//! TYPE is `1`, `1-complex`, `2` or `2-complex`; weights of type 1 are real, and so are functions of
//! type 2, of which half of the coefficients are given. The time excludes planning and allocation.

use std::error::Error;
use std::fs;
use std::io::{BufRead, Write};
use std::time::Instant;

use num_complex::Complex;
use sphvar_nufft::{ComplexTorusCoefficients, TorusCoefficients, TorusTransform, TorusWorkspace};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

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
    points: Vec<[f64; 2]>,
    numbers: Vec<f64>,
    job: Option<Job>,
    workspace: TorusWorkspace,
}

struct Job {
    plan: TorusTransform,
    data: Data,
}

/// Input and output of a transform.
enum Data {
    Coefficients { weights: Vec<f64>, out: TorusCoefficients },
    ComplexCoefficients { weights: Vec<Complex<f64>>, out: ComplexTorusCoefficients },
    Values { series: TorusCoefficients, out: Vec<f64> },
    ComplexValues { series: ComplexTorusCoefficients, out: Vec<Complex<f64>> },
}

impl Server {
    /// Executes a command. Returns the seconds if the command is timed.
    fn answer(&mut self, words: &[&str]) -> Result<Option<f64>> {
        match *words {
            ["points", path] => self.points = load(path)?.as_chunks::<2>().0.to_vec(),
            ["numbers", path] => self.numbers = load(path)?,
            ["plan", kind, kmax, epsilon] => {
                let kmax = kmax.parse()?;
                let plan = TorusTransform::new(kmax, epsilon.parse()?)?;
                let data = self.data(kind, kmax)?;
                self.job = Some(Job { plan, data });
                self.run()?;
            }
            ["run", count] => {
                let count: usize = count.parse()?;
                let start = Instant::now();
                for _ in 0..count {
                    self.run()?;
                }
                return Ok(Some(start.elapsed().as_secs_f64()));
            }
            ["write", path] => {
                let job = self.job.as_ref().ok_or("nothing was computed")?;
                fs::write(path, job.data.bytes())?;
            }
            _ => return Err("unknown command or wrong number of arguments".into()),
        }
        Ok(None)
    }

    fn data(&self, kind: &str, kmax: usize) -> Result<Data> {
        let complex = complex_numbers(&self.numbers);
        Ok(match kind {
            "1" => {
                let out = TorusCoefficients::zeros(kmax)?;
                Data::Coefficients { weights: self.numbers.clone(), out }
            }
            "1-complex" => {
                let out = ComplexTorusCoefficients::zeros(kmax)?;
                Data::ComplexCoefficients { weights: complex, out }
            }
            "2" => {
                let mut series = TorusCoefficients::zeros(kmax)?;
                fill(series.values_mut(), &complex)?;
                Data::Values { series, out: vec![0.0; self.points.len()] }
            }
            "2-complex" => {
                let mut series = ComplexTorusCoefficients::zeros(kmax)?;
                fill(series.values_mut(), &complex)?;
                Data::ComplexValues { series, out: vec![Complex::ZERO; self.points.len()] }
            }
            _ => return Err("unknown type".into()),
        })
    }

    fn run(&mut self) -> Result<()> {
        let Self { points, job, workspace, .. } = self;
        let Job { plan, data } = job.as_mut().ok_or("no plan; use `plan` first")?;
        match data {
            Data::Coefficients { weights, out } => {
                plan.adjoint_into(points, Some(weights), workspace, out)?;
            }
            Data::ComplexCoefficients { weights, out } => {
                plan.adjoint_complex_into(points, weights, workspace, out)?;
            }
            Data::Values { series, out } => plan.evaluate_into(series, points, workspace, out)?,
            Data::ComplexValues { series, out } => {
                plan.evaluate_complex_into(series, points, workspace, out)?;
            }
        }
        Ok(())
    }
}

impl Data {
    fn bytes(&self) -> Vec<u8> {
        let of_complex = |values: &[Complex<f64>]| -> Vec<u8> {
            values.iter().flat_map(|c| [c.re, c.im]).flat_map(f64::to_le_bytes).collect()
        };
        match self {
            Self::Coefficients { out, .. } => of_complex(out.values()),
            Self::ComplexCoefficients { out, .. } => of_complex(out.values()),
            Self::Values { out, .. } => out.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::ComplexValues { out, .. } => of_complex(out),
        }
    }
}

fn load(path: &str) -> Result<Vec<f64>> {
    let bytes = fs::read(path)?;
    Ok(bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect())
}

fn complex_numbers(numbers: &[f64]) -> Vec<Complex<f64>> {
    numbers.as_chunks::<2>().0.iter().map(|[re, im]| Complex::new(*re, *im)).collect()
}

fn fill(values: &mut [Complex<f64>], numbers: &[Complex<f64>]) -> Result<()> {
    if values.len() != numbers.len() {
        return Err(format!("{} coefficients for {}", numbers.len(), values.len()).into());
    }
    values.copy_from_slice(numbers);
    Ok(())
}
