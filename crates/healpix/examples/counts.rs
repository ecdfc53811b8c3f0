//! Counts positions per pixel, one `longitude latitude` in degrees a line of standard input:
//! `cargo run --release -p sphvar-healpix --example counts -- 16 < positions.txt`.

use std::collections::BTreeMap;
use std::io::Write;

use glam::DVec3;
use sphvar_healpix::{Nside, PixelOrder, Ring};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let nside = std::env::args().nth(1).map_or(Ok(16), |nside| nside.parse())?;
    let order = Ring::new(Nside::new(nside)?);
    let mut counts = BTreeMap::new();
    for line in std::io::stdin().lines() {
        let line = line?;
        let degrees: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        let &[longitude, latitude] = degrees?.as_slice() else {
            return Err(format!("expected a longitude and a latitude, got {line:?}").into());
        };
        let (sin, cos) = latitude.to_radians().sin_cos();
        let (sin_phi, cos_phi) = longitude.to_radians().sin_cos();
        let pixel = order.pixel(DVec3::new(cos * cos_phi, cos * sin_phi, sin));
        *counts.entry(pixel).or_insert(0_u64) += 1;
    }
    let mut out = std::io::stdout().lock();
    writeln!(out, "pixel,count")?;
    for (pixel, count) in counts {
        writeln!(out, "{pixel},{count}")?;
    }
    Ok(())
}
