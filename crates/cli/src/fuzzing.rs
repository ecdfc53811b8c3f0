//! Readers and grammars as functions of bytes, for the fuzzer of the repository. This module is not
//! part of the stable interface of the crate.

mod grammars;
mod seeds;

use std::ffi::OsStr;
use std::fs;
use std::path::Path;

use clap::Parser;
use glam::DVec3;
use sphvar_samplers::PointSet;
use sphvar_scene::Mesh;

use crate::args::{Cli, Command};
use crate::error::CliError;
use crate::files::{
    ChannelChoice, Columns, FitsField, HduChoice, ReadOptions, read_fits_map, read_image,
    read_list, read_points, read_spectrum, write_points,
};
use crate::message;

/// A reader or grammar.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name.
    pub name: &'static str,
    /// The extension of its files.
    pub extension: &'static str,
    /// Whether its inputs are text, of which more are tried.
    pub is_text: bool,
    seeds: fn(&Path) -> Vec<Vec<u8>>,
    read: fn(&[u8], &Path) -> Result<(), CliError>,
}

impl Target {
    /// Returns valid inputs; `scratch` is a file that may be written.
    #[must_use]
    pub fn seeds(&self, scratch: &Path) -> Vec<Vec<u8>> {
        (self.seeds)(scratch)
    }

    /// Returns whether an input is accepted; `scratch` is a file that may be overwritten.
    ///
    /// # Panics
    ///
    /// If an error message is long or contains control characters, which counts as a
    /// finding like any other panic.
    #[must_use]
    pub fn read(&self, input: &[u8], scratch: &Path) -> bool {
        let Err(error) = (self.read)(input, scratch) else { return true };
        let shown = message::clean(&error.to_string());
        assert!(shown.len() < 8000 && !shown.chars().any(char::is_control), "message: {shown}");
        false
    }
}

/// The name of the target with planted faults.
pub const PLANTED: &str = "planted";

/// All readers and grammars.
pub const TARGETS: [Target; 19] = [
    Target {
        name: "points-text",
        extension: "csv",
        is_text: true,
        seeds: point_texts,
        read: points,
    },
    Target {
        name: "points-columns",
        extension: "csv",
        is_text: true,
        seeds: columns_seeds,
        read: columns,
    },
    Target {
        name: "points-npy",
        extension: "npy",
        is_text: false,
        seeds: written_points,
        read: points,
    },
    Target {
        name: "points-npz",
        extension: "npz",
        is_text: false,
        seeds: archives,
        read: archived_points,
    },
    Target {
        name: "points-ply",
        extension: "ply",
        is_text: false,
        seeds: written_points,
        read: points,
    },
    Target {
        name: "points-fits",
        extension: "fits",
        is_text: false,
        seeds: |_| seeds::point_tables(),
        read: points,
    },
    Target {
        name: "map-fits",
        extension: "fits",
        is_text: false,
        seeds: |_| seeds::maps(),
        read: fits_map,
    },
    Target {
        name: "image-exr",
        extension: "exr",
        is_text: false,
        seeds: |_| seeds::exr_pictures(),
        read: environment,
    },
    Target {
        name: "image-hdr",
        extension: "hdr",
        is_text: false,
        seeds: |_| seeds::radiance_pictures(),
        read: environment,
    },
    Target { name: "mesh-obj", extension: "obj", is_text: true, seeds: meshes, read: mesh },
    Target { name: "list-text", extension: "csv", is_text: true, seeds: lists, read: list },
    Target {
        name: "spectrum-text",
        extension: "csv",
        is_text: true,
        seeds: spectra,
        read: spectrum,
    },
    Target { name: "shard", extension: "shard", is_text: false, seeds: shards, read: shard },
    Target {
        name: "samplers",
        extension: "txt",
        is_text: true,
        seeds: grammars::sampler_names,
        read: grammars::samplers,
    },
    Target {
        name: "integrands",
        extension: "txt",
        is_text: true,
        seeds: grammars::integrand_names,
        read: grammars::integrand,
    },
    Target {
        name: "warps",
        extension: "txt",
        is_text: true,
        seeds: grammars::warp_names,
        read: grammars::warps,
    },
    Target {
        name: "warped-patterns",
        extension: "txt",
        is_text: true,
        seeds: grammars::warped_names,
        read: grammars::warped_pattern,
    },
    Target {
        name: "arguments",
        extension: "txt",
        is_text: true,
        seeds: grammars::argument_lists,
        read: grammars::arguments,
    },
    // Not a reader: it has one fault of each kind, to verify that they are detected.
    Target { name: PLANTED, extension: "txt", is_text: true, seeds: planted_seeds, read: planted },
];

fn texts(texts: &[&str]) -> Vec<Vec<u8>> {
    texts.iter().map(|text| text.as_bytes().to_vec()).collect()
}

/// Returns an input as the grammars receive it.
fn text(input: &[u8]) -> String {
    String::from_utf8_lossy(input).into_owned()
}

fn write(input: &[u8], scratch: &Path) -> Result<(), CliError> {
    fs::write(scratch, input).map_err(CliError::failed)
}

fn point_texts(_: &Path) -> Vec<Vec<u8>> {
    texts(&[
        "x,y,z\n1,0,0\n0,1,0\n0,0,-1\n",
        "# a remark\nx,y,z,w,set\n1,0,0,0.5,0\n0,1,0,1.5,0\n0.6,0.8,0,-2,1\n",
        "theta,phi\n0.5,1\n3,-6.5\n",
        "ra,dec,weight,value\n10.25,-45,1,2\n359.9,89.9,0,1e-3\n",
        "\"RAJ2000\";\"DEJ2000\";\"WEIGHT\";\"Z\"\n10,20,1,0.1\n",
        "1 0 0\n0\t1 0\n#\n0 0 1\n1 0 0\n",
        "lon lat\r\n-180 90\r\n180 -90\r\n",
        "\u{feff}x,y,z\n1,0,0\n",
        "u,v,w\n0,0.5,1\n0.25,0.999,-2\n",
        "0.5 0.25\n#\n0.75 0\n",
    ])
}

fn points(input: &[u8], scratch: &Path) -> Result<(), CliError> {
    write(input, scratch)?;
    either_space(scratch, &ReadOptions::default())
}

/// Reads directions and points of the square; a valid file has one of them.
fn either_space(scratch: &Path, options: &ReadOptions) -> Result<(), CliError> {
    let directions = read_points::<DVec3>(scratch, options).map(drop);
    let square = read_points::<[f64; 2]>(scratch, options).map(drop);
    Ok(directions.or(square)?)
}

fn columns_seeds(_: &Path) -> Vec<Vec<u8>> {
    texts(&[
        "ra,dec,w\n1,2,3\n4,5,6\n",
        "ra=RAJ2000,dec=DEJ2000,w=WEIGHT\nRAJ2000,DEJ2000,WEIGHT,Z\n1,2,3,4\n",
        "x,_,y,z\n1,7,0,0\n0,7,1,0\n",
        "phi,theta\n1 2\n3 1\n",
        "v,_,u\n0.5 7 0\n",
    ])
}

/// Uses the first line as the value of `--columns`.
fn columns(input: &[u8], scratch: &Path) -> Result<(), CliError> {
    let end = input.iter().position(|&b| b == b'\n').unwrap_or(input.len());
    write(input.get(end + 1..).unwrap_or_default(), scratch)?;
    let columns = Some(text(&input[..end]).parse().map_err(CliError::Usage)?);
    either_space(scratch, &ReadOptions { columns, ..ReadOptions::default() })
}

fn written_points(scratch: &Path) -> Vec<Vec<u8>> {
    let points = vec![DVec3::X, DVec3::new(0.6, 0.0, -0.8), DVec3::NEG_Z];
    let set = PointSet::new(points.clone());
    let weighted = PointSet { points, weights: vec![1.0, -0.5, 1e300] };
    let written = |sets: &[PointSet]| {
        write_points(scratch, None, sets, Some("a remark"))
            .ok()
            .and_then(|()| fs::read(scratch).ok())
    };
    [written(std::slice::from_ref(&set)), written(&[set.clone(), set]), written(&[weighted])]
        .into_iter()
        .flatten()
        .collect()
}

fn archives(scratch: &Path) -> Vec<Vec<u8>> {
    let array = written_points(&scratch.with_extension("npy")).into_iter().next();
    let _ = fs::remove_file(scratch.with_extension("npy"));
    seeds::archives(&array.unwrap_or_default())
}

fn archived_points(input: &[u8], scratch: &Path) -> Result<(), CliError> {
    points(&seeds::with_checksums(input.to_vec()), scratch)
}

fn fits_map(input: &[u8], scratch: &Path) -> Result<(), CliError> {
    write(input, scratch)?;
    read_fits_map(scratch, &HduChoice::First, &FitsField::Number(0))?;
    Ok(())
}

fn environment(input: &[u8], scratch: &Path) -> Result<(), CliError> {
    write(input, scratch)?;
    read_image(scratch, &ChannelChoice::default())?;
    Ok(())
}

fn meshes(_: &Path) -> Vec<Vec<u8>> {
    texts(&[
        "# a square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n",
        "o a\nv 0 0 0 1.0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\nf -3/1/1 -2//1 -1/1\ng b\nusemtl c\ns off\n",
        "v 0 0 0\nv 1 0 -1\nv 0 0 1\nv -1 0 -1\nf 2 3 \\\n4 1\nfo 1 2 3\nl 1 2\n",
    ])
}

fn mesh(input: &[u8], _: &Path) -> Result<(), CliError> {
    Mesh::from_obj(input).map(drop).map_err(CliError::failed)
}

fn lists(_: &Path) -> Vec<Vec<u8>> {
    texts(&["pixel\n0\n17\n", "12\n3\n", "x,y,z\n1,0,0\n0.1,-2e3,4\n", "1 0 0\n"])
}

/// Lists of pixels and of vectors.
fn list(input: &[u8], scratch: &Path) -> Result<(), CliError> {
    write(input, scratch)?;
    let pixels = Columns { names: ["pixel"], remark: "" };
    let vectors = Columns { names: ["x", "y", "z"], remark: "" };
    let first = read_list(scratch, &pixels, |row: [i128; 1]| Ok(row));
    let second = read_list(scratch, &vectors, |row: [f64; 3]| Ok(row));
    first.map(drop).or(second.map(drop)).map_err(CliError::from)
}

fn spectra(_: &Path) -> Vec<Vec<u8>> {
    texts(&[
        "# a remark\nl,omega,power,stderr,realizations\n0,0,12,0,1\n1,0.28,0,0,1\n2,0.57,1.5,0.1,1\n",
        "0 12\n1 0.5\n2 1\n",
    ])
}

fn spectrum(input: &[u8], scratch: &Path) -> Result<(), CliError> {
    write(input, scratch)?;
    read_spectrum(scratch)?;
    Ok(())
}

fn shards(scratch: &Path) -> Vec<Vec<u8>> {
    ["white-noise -n 5 --lmax 2", "white-square --square -n 5 --kmax 2"]
        .into_iter()
        .filter_map(|pattern| saved_sums(pattern, scratch))
        .collect()
}

/// Returns the file of the sums of a pattern.
fn saved_sums(pattern: &str, scratch: &Path) -> Option<Vec<u8>> {
    let out = scratch.with_extension("csv");
    let words = format!("sphvar spectrum {pattern} -m 4 --shard 1/2 --quiet --save");
    let words = words.split(' ').map(OsStr::new);
    let words = words.chain([scratch.as_os_str(), OsStr::new("-o"), out.as_os_str()]);
    if let Ok(Cli { command: Command::Spectrum(arguments), global }) = Cli::try_parse_from(words) {
        // Without a seed nothing is accepted, which the statistics show.
        let _ = crate::commands::spectrum::run(&arguments, &global);
        let _ = fs::remove_file(out);
    }
    fs::read(scratch).ok()
}

/// Corrects the checksums, because otherwise no code after their check would be reached, and reports
/// the results of the file.
fn shard(input: &[u8], scratch: &Path) -> Result<(), CliError> {
    let mut input = input.to_vec();
    // Records follow the first line: length, checksum, content.
    let mut next = input.iter().position(|&b| b == b'\n').map_or(0, |end| end + 1);
    while let Some((head, rest)) = input.get_mut(next..).and_then(|r| r.split_at_mut_checked(12)) {
        let (length, checksum) = head.split_at_mut(8);
        let length: [u8; 8] = length.try_into().unwrap_or_default();
        let length = usize::try_from(u64::from_le_bytes(length)).unwrap_or(usize::MAX);
        let Some(body) = rest.get(..length) else { break };
        checksum.copy_from_slice(&crc32fast::hash(body).to_le_bytes());
        next += 12 + length;
    }
    write(&input, scratch)?;
    let words = [OsStr::new("sphvar"), OsStr::new("merge"), scratch.as_os_str()];
    let words = words.into_iter().chain(["--partial", "--quiet"].map(OsStr::new));
    match Cli::try_parse_from(words).map(|cli| (cli.command, cli.global)) {
        Ok((Command::Merge(arguments), global)) => crate::commands::merge::run(&arguments, &global),
        _ => Ok(()),
    }
}

fn planted_seeds(_: &Path) -> Vec<Vec<u8>> {
    texts(&["x"])
}

/// Panics, aborts, or exhausts the memory on inputs that differ by one bit from the seed.
fn planted(input: &[u8], _: &Path) -> Result<(), CliError> {
    match input.first() {
        Some(b'p') => panic!("planted"),
        Some(b'h') => std::process::abort(),
        Some(b'X') => {
            let memory = vec![1_u8; 1 << 40];
            Err(CliError::Failed(format!("{} bytes", memory.len())))
        }
        _ => Ok(()),
    }
}
