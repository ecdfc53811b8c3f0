//! Prints the points of a pattern as CSV:
//! `cargo run --release -p sphvar-samplers --example points -- poisson-disk 256`.

use std::io::Write;

use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let pattern: Pattern = arguments.next().as_deref().unwrap_or("fibonacci").parse()?;
    let requested = arguments.next().map_or(Ok(100), |n| n.parse())?;
    let n_points = pattern.nearest_count(requested, Domain::Sphere);
    let sampler = pattern.build(n_points, Domain::Sphere)?;
    let seed = 0;
    let streams = Streams::new(seed, Purpose::Pattern, sampler.stream_group());
    let set = Realizations::rotated(&*sampler, streams).realize(0)?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "x,y,z")?;
    for p in &set.points {
        writeln!(out, "{},{},{}", p.x, p.y, p.z)?;
    }
    Ok(())
}
