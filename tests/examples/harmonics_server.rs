//! A process that evaluates associated Legendre functions on request, timed by
//! `benches/peers/accuracy.py` together with scipy and ducc0.
//!
//! Reads one command per line from standard input and answers each with one line. A command that
//! fails ends the process with a message. Files are little-endian f64.
//!
//! ```text
//! places PATH    loads triples of degree, order, colatitude                      -> ok
//! one            evaluates the function of each place separately                 -> seconds
//! below          the same for the degree below; 0 where it does not exist        -> seconds
//! order          evaluates the function of the degree and order of the first
//!                place at every colatitude                                       -> seconds
//! degrees        evaluates all degrees, up to that of the first place, for its
//!                order at every colatitude; keeps the last degree                -> seconds
//! all            evaluates all degrees and orders up to the degree of the first
//!                place at every colatitude; keeps the value of each place        -> seconds
//! write PATH     writes one value per place                                      -> ok
//! ```
//!
//! The times include the computation of plans and coefficients; tables are kept allocated.

use std::error::Error;
use std::fs;
use std::io::{BufRead, Write};
use std::time::Instant;

use sphvar_sh::{Colatitude, LegendrePlan, Recurrence, lambda};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

struct Place {
    l: usize,
    m: usize,
    colatitude: Colatitude,
}

fn main() -> Result<()> {
    let mut places = Vec::new();
    let mut values = Vec::new();
    let mut table = Vec::new();
    let mut out = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let start = Instant::now();
        match *words {
            ["places", path] => places = load(path)?,
            ["one"] => fill(&mut values, &places, |p| lambda(p.l, p.m, p.colatitude)),
            ["below"] => fill(&mut values, &places, |p| {
                p.l.checked_sub(1).map_or(0.0, |l| lambda(l, p.m, p.colatitude))
            }),
            ["order"] => order(&mut values, &places)?,
            ["degrees"] => degrees(&mut values, &mut table, &places)?,
            ["all"] => all(&mut values, &places)?,
            ["write", path] => {
                let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
                fs::write(path, bytes)?;
            }
            _ => return Err(format!("`{line}` is not a command").into()),
        }
        let seconds = start.elapsed().as_secs_f64();
        match *words {
            ["places" | "write", _] => writeln!(out, "ok")?,
            _ => writeln!(out, "{seconds:e}")?,
        }
        out.flush()?;
    }
    Ok(())
}

fn fill(values: &mut Vec<f64>, places: &[Place], value: impl FnMut(&Place) -> f64) {
    values.clear();
    values.extend(places.iter().map(value));
}

fn order(values: &mut Vec<f64>, places: &[Place]) -> Result<()> {
    let first = places.first().ok_or("no places")?;
    let colatitudes: Vec<_> = places.iter().map(|place| place.colatitude).collect();
    values.clear();
    values.resize(places.len(), 0.0);
    Recurrence::new(first.m, first.l).degree_into(first.l, &colatitudes, values);
    Ok(())
}

fn degrees(values: &mut Vec<f64>, table: &mut Vec<f64>, places: &[Place]) -> Result<()> {
    let first = places.first().ok_or("no places")?;
    let colatitudes: Vec<_> = places.iter().map(|place| place.colatitude).collect();
    table.resize((first.l + 1 - first.m) * places.len(), 0.0);
    Recurrence::new(first.m, first.l).table_into(&colatitudes, table);
    values.clear();
    values.extend_from_slice(&table[table.len() - places.len()..]);
    Ok(())
}

fn all(values: &mut Vec<f64>, places: &[Place]) -> Result<()> {
    let plan = LegendrePlan::new(places.first().ok_or("no places")?.l)?;
    let index = plan.index();
    let mut functions = plan.eval(Colatitude::from_theta(0.0)?);
    fill(values, places, |place| {
        plan.eval_into(place.colatitude, &mut functions);
        functions[index.at(place.l, place.m)]
    });
    Ok(())
}

fn load(path: &str) -> Result<Vec<Place>> {
    let bytes = fs::read(path)?;
    let (numbers, rest) = bytes.as_chunks();
    let numbers: Vec<f64> = numbers.iter().map(|&bytes| f64::from_le_bytes(bytes)).collect();
    let (triples, lone) = numbers.as_chunks();
    if !lone.is_empty() || !rest.is_empty() {
        return Err(format!("{} bytes are not a multiple of 24", bytes.len()).into());
    }
    let places: Vec<Place> = triples
        .iter()
        .map(|&[l, m, theta]| {
            Ok(Place { l: whole(l)?, m: whole(m)?, colatitude: Colatitude::from_theta(theta)? })
        })
        .collect::<Result<_>>()?;
    match places.iter().find(|place| place.m > place.l) {
        Some(place) => Err(format!("no order {} at degree {}", place.m, place.l).into()),
        None => Ok(places),
    }
}

fn whole(number: f64) -> Result<usize> {
    Ok(format!("{number}").parse()?)
}
