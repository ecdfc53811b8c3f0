//! Writes sets of rotations as CSV, NPY or NPZ.

use std::io::{self, Write};
use std::path::Path;

use clap::ValueEnum;
use glam::{DMat3, DQuat};
use serde::Serialize;
use sphvar_samplers::{RotationSet, euler_zyz};

use super::array_archive::ArrayArchive;
use super::atomic::AtomicFile;
use super::file_error::FileError;
use super::npy::write_npy;

/// The file that rotations are written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RotationFile {
    Csv,
    Npy,
    Npz,
}

/// How rotations are written as numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RotationFormat {
    /// Unit quaternions w, x, y, z with w >= 0
    Quaternions,
    /// Matrices by rows, which are multiplied by column vectors
    Matrices,
    /// Euler angles alpha, beta, gamma in radians: Rz(alpha) Ry(beta) Rz(gamma), intrinsic z-y'-z''
    Euler,
    /// The same in degrees
    EulerDegrees,
}

impl RotationFormat {
    /// Returns the names of the numbers.
    pub(crate) fn columns(self) -> &'static [&'static str] {
        match self {
            Self::Quaternions => &["w", "x", "y", "z"],
            Self::Matrices => &["r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"],
            Self::Euler | Self::EulerDegrees => &["alpha", "beta", "gamma"],
        }
    }

    /// Returns the numbers of a rotation.
    #[must_use]
    pub fn numbers(self, rotation: DQuat) -> Vec<f64> {
        match self {
            Self::Quaternions => {
                let DQuat { w, x, y, z } = rotation;
                // Of q and -q, the one whose first number other than 0 is positive.
                let all = [w, x, y, z];
                let is_negative = all.into_iter().find(|c| *c != 0.0).is_some_and(|c| c < 0.0);
                all.map(|c| if is_negative { -c } else { c } + 0.0).to_vec()
            }
            Self::Matrices => DMat3::from_quat(rotation).transpose().to_cols_array().to_vec(),
            Self::Euler => euler_zyz(rotation).to_vec(),
            Self::EulerDegrees => euler_zyz(rotation).map(f64::to_degrees).to_vec(),
        }
    }

    /// Returns the shape of a rotation in an array.
    fn shape(self) -> &'static [u64] {
        match self {
            Self::Quaternions => &[4],
            Self::Matrices => &[3, 3],
            Self::Euler | Self::EulerDegrees => &[3],
        }
    }
}

/// Writes sets of rotations; `-` is standard output.
///
/// - CSV: the names of the numbers as header, with a column `weight` if the sets have weights, and a
///   last column `set` (counted from 0) for several sets. Every number has the shortest digits that
///   are read back as the same number.
/// - `.npy`: `(N, 4)`, `(N, 3, 3)` or `(N, 3)`, with M before N for several sets; 8-byte floats, little-endian,
///   C order, without weights.
/// - `.npz`: this array as `rotations` and, if the sets have weights, `(N,)` or `(M, N)` as `weights`; uncompressed.
///
/// The file appears when it is complete.
///
/// # Errors
///
/// If the file cannot be written.
pub(crate) fn write_rotations(
    path: &Path,
    file: RotationFile,
    format: RotationFormat,
    sets: &[RotationSet],
) -> Result<(), FileError> {
    let mut out = AtomicFile::create(path)?;
    let written = match file {
        RotationFile::Csv => write_csv(&mut out, format, sets),
        RotationFile::Npy => write_array(&mut out, format, sets),
        RotationFile::Npz => write_archive(&mut out, format, sets),
    };
    written.map_err(|source| out.error(source))?;
    out.commit()
}

fn write_array(
    out: &mut impl Write,
    format: RotationFormat,
    sets: &[RotationSet],
) -> io::Result<()> {
    let shape = [shape_of(sets), format.shape().to_vec()].concat();
    let numbers = sets.iter().flat_map(|set| &set.points).flat_map(|q| format.numbers(*q));
    write_npy(out, "<f8", &shape, numbers)
}

fn write_archive(
    out: &mut impl Write,
    format: RotationFormat,
    sets: &[RotationSet],
) -> io::Result<()> {
    let rotations: usize = sets.iter().map(RotationSet::len).sum();
    let mut archive = ArrayArchive::new((format.columns().len() * rotations) as u64);
    write_array(archive.start("rotations")?, format, sets)?;
    if sets.iter().any(|set| !set.weights.is_empty()) {
        let weights = sets.iter().flat_map(|set| set.weights.iter().copied());
        write_npy(archive.start("weights")?, "<f8", &shape_of(sets), weights)?;
    }
    archive.write(out)
}

/// Returns the shape of an array with a number for each rotation.
fn shape_of(sets: &[RotationSet]) -> Vec<u64> {
    let n = sets.first().map_or(0, RotationSet::len) as u64;
    let several = (sets.len() > 1).then_some(sets.len() as u64);
    several.into_iter().chain([n]).collect()
}

fn write_csv(out: &mut impl Write, format: RotationFormat, sets: &[RotationSet]) -> io::Result<()> {
    let has_weights = sets.iter().any(|set| !set.weights.is_empty());
    let mut heading = format.columns().to_vec();
    heading.extend(has_weights.then_some("weight"));
    heading.extend((sets.len() > 1).then_some("set"));
    writeln!(out, "{}", heading.join(","))?;
    for (index, set) in sets.iter().enumerate() {
        for (k, q) in set.points.iter().enumerate() {
            let numbers = format.numbers(*q).into_iter().chain(set.weights.get(k).copied());
            let mut row: Vec<String> = numbers.map(|x| format!("{x:?}")).collect();
            row.extend((sets.len() > 1).then(|| index.to_string()));
            writeln!(out, "{}", row.join(","))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use sphvar_samplers::RotationSet;

    use super::{RotationFormat, write_csv};

    #[test]
    fn numbers_follow_the_conventions() {
        let quarter = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
        let half = 0.5f64.sqrt();
        for q in [quarter, -quarter] {
            let numbers = |format: RotationFormat| format.numbers(q);
            let close = |got: Vec<f64>, expected: &[f64]| {
                let off = got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15);
                assert!(got.len() == expected.len() && off, "{got:?} and {expected:?}");
            };
            close(numbers(RotationFormat::Quaternions), &[half, 0.0, 0.0, half]);
            // A quarter turn about z takes x to y: the first column of the matrix is y.
            let rows = [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
            close(numbers(RotationFormat::Matrices), &rows);
            let degrees = numbers(RotationFormat::EulerDegrees);
            assert!((degrees[0] - 90.0).abs() < 1e-13 && degrees[1] == 0.0 && degrees[2] == 0.0);
        }
        let half_turn = RotationFormat::Quaternions.numbers(DQuat::from_xyzw(0.0, -1.0, 0.0, -0.0));
        assert_eq!(format!("{half_turn:?}"), "[0.0, 0.0, 1.0, 0.0]");
    }

    #[test]
    fn csv_has_weights_and_sets() {
        let set = RotationSet { points: vec![DQuat::IDENTITY], weights: vec![0.5] };
        let mut text = Vec::new();
        write_csv(&mut text, RotationFormat::Quaternions, &[set.clone(), set]).unwrap();
        let expected = "w,x,y,z,weight,set\n1.0,0.0,0.0,0.0,0.5,0\n1.0,0.0,0.0,0.0,0.5,1\n";
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }
}
