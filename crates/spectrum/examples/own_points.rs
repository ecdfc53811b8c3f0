//! Prints the power spectrum of points from standard input, one `x,y,z` a line:
//! `cargo run --release -p sphvar-spectrum --example own_points -- 32 < points.csv`.
//!
//! Lines that are not three numbers, such as headings, are skipped. White noise has power 1.

use std::io::Write;

use glam::DVec3;
use sphvar_samplers::{Domain, PointSet, PointSets, Purpose, Realizations, Streams};
use sphvar_spectrum::estimate;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let lmax = std::env::args().nth(1).map_or(Ok(32), |lmax| lmax.parse())?;
    let mut points = Vec::new();
    for line in std::io::stdin().lines() {
        let line = line?;
        let numbers: Result<Vec<f64>, _> = line.split(',').map(|x| x.trim().parse()).collect();
        if let Ok([x, y, z]) = numbers.as_deref() {
            points.push(DVec3::new(*x, *y, *z));
        }
    }
    let sets = PointSets::new(vec![PointSet::new(points)], Domain::Sphere)?;
    let ensemble = Realizations::unrotated(&sets, Streams::new(0, Purpose::Pattern, 0));
    let spectrum = estimate(&ensemble, lmax, 1, &())?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "l,power")?;
    for (l, power) in spectrum.power().iter().enumerate().skip(1) {
        writeln!(out, "{l},{power}")?;
    }
    Ok(())
}
