//! `sphvar healpix`: converts lists of directions, angles and pixels into each other.

use std::borrow::Cow;
use std::f64::consts::PI;
use std::io;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::DVec3;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Serialize, Serializer};
use serde_json::json;
use sphvar_healpix::{Nested, Nside, PixelOrder, Ring, unit_direction};

use crate::error::CliError;
use crate::files::{Columns, Fault, FileError, ListWriter, Number, Written, read_list};
use crate::global::Global;
use crate::report::{Document, Provenance, is_stdout};

#[cfg(test)]
mod tests;

pub(crate) const EXAMPLES: &str = "Lists:
  CSV with a header that names the columns x,y,z | theta,phi | pixel (with --degrees lon,lat),
  or without a header in this order, separated by commas or blanks; NPY of shape (N, 3) | (N, 2) |
  (N,). Vectors may have any length. Angles are colatitude and longitude in radians.

Examples:
  sphvar healpix vec2pix --nside 64 points.npy -o pixels.npy
  sphvar healpix pix2ang --nside 1024 --nested pixels.csv
  echo 13.4 52.5 | sphvar healpix ang2pix --nside 256 --degrees -
  seq 0 47 | sphvar healpix ring2nest --nside 2 - --json";

/// Tolerance above pi within which a colatitude is taken as pi: a number with seven digits, such as
/// pi in `f32`, is rounded up by that much.
const THETA_SLACK: f64 = 1e-6;

const VECTOR: Columns<3> = Columns { names: ["x", "y", "z"], remark: "components of vectors" };
const RADIANS: Columns<2> = Columns {
    names: ["theta", "phi"],
    remark: "colatitude and longitude in radians; --degrees takes lon,lat",
};
const DEGREES: Columns<2> =
    Columns { names: ["lon", "lat"], remark: "longitude and latitude in degrees" };
const PIXEL: Columns<1> = Columns { names: ["pixel"], remark: "integers" };

/// The conversions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Conversion {
    /// Vectors to the pixels that contain them
    #[value(name = "vec2pix")]
    VecToPix,
    /// Pixels to the unit vectors of their centres
    #[value(name = "pix2vec")]
    PixToVec,
    /// Angles to the pixels that contain them
    #[value(name = "ang2pix")]
    AngToPix,
    /// Pixels to the angles of their centres
    #[value(name = "pix2ang")]
    PixToAng,
    /// Pixel numbers in ring order to nested order
    #[value(name = "ring2nest")]
    RingToNest,
    /// Pixel numbers in nested order to ring order
    #[value(name = "nest2ring")]
    NestToRing,
}

impl Conversion {
    fn name(self) -> &'static str {
        match self {
            Self::VecToPix => "vec2pix",
            Self::PixToVec => "pix2vec",
            Self::AngToPix => "ang2pix",
            Self::PixToAng => "pix2ang",
            Self::RingToNest => "ring2nest",
            Self::NestToRing => "nest2ring",
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct HealpixArgs {
    /// Conversion of each row
    #[arg(value_enum, value_name = "CONVERSION")]
    pub(crate) conversion: Conversion,
    /// Resolution: the sphere has 12 K^2 pixels; K is from 1 to 2^29, and a power of two in nested order
    #[arg(long, value_name = "K", value_parser = parse_nside, allow_negative_numbers = true)]
    pub(crate) nside: Nside,
    /// Number pixels in nested order instead of ring order; ring2nest and nest2ring need no flag
    #[arg(long)]
    pub(crate) nested: bool,
    /// Interpret angles as longitude and latitude in degrees, columns lon,lat
    #[arg(long)]
    pub(crate) degrees: bool,
    /// List to convert, CSV or NPY; - is standard input
    #[arg(value_name = "FILE")]
    pub(crate) input: PathBuf,
    /// Write the results to a file: .csv or .npy; - is CSV on standard output
    #[arg(short, long, default_value = "-", value_name = "FILE")]
    pub(crate) out: PathBuf,
}

fn parse_nside(text: &str) -> Result<Nside, String> {
    let nside = text.parse::<u32>().ok().and_then(|nside| Nside::new(nside).ok());
    nside.ok_or_else(|| format!("expected an integer from 1 to {}", Nside::MAX))
}

pub(crate) fn run(args: &HealpixArgs, global: &Global) -> Result<(), CliError> {
    let nside = args.nside;
    let conversion = args.conversion;
    if args.degrees && !matches!(conversion, Conversion::AngToPix | Conversion::PixToAng) {
        return Err(CliError::Usage(format!(
            "--degrees requires ang2pix or pix2ang, got {}",
            conversion.name()
        )));
    }
    let order: &dyn PixelOrder =
        if args.nested { &Nested::new(nside).map_err(CliError::usage)? } else { &Ring::new(nside) };
    let order_name = if args.nested { "nested" } else { "ring" };
    let job = Job { args, global, order: order_name };
    match conversion {
        Conversion::VecToPix => job.convert(&VECTOR, &PIXEL, |[x, y, z]| {
            let dir = unit_direction(DVec3::new(x, y, z))
                .map_err(|_| Fault::Row("a vector other than zero".to_owned()))?;
            Ok([written(order.pixel(dir))])
        }),
        Conversion::PixToVec => job.convert(&PIXEL, &VECTOR, |[pixel]| {
            Ok(order.centre(checked(nside, pixel)?).to_array())
        }),
        Conversion::AngToPix if args.degrees => {
            job.convert(&DEGREES, &PIXEL, |[lon, lat]: [f64; 2]| {
                // The list contains only finite numbers, so every longitude is valid.
                let [theta, phi] = angles_of_degrees(lon, lat).ok_or_else(|| {
                    Fault::Column(1, "a latitude from -90 to 90 degrees".to_owned())
                })?;
                pixel_of_angles(order, theta, phi)
            })
        }
        Conversion::AngToPix => {
            job.convert(&RADIANS, &PIXEL, |[theta, phi]| pixel_of_angles(order, theta, phi))
        }
        Conversion::PixToAng if args.degrees => job.convert(&PIXEL, &DEGREES, |[pixel]| {
            let (theta, phi) = order.centre_angles(checked(nside, pixel)?);
            Ok(degrees_of_angles(theta, phi))
        }),
        Conversion::PixToAng => job.convert(&PIXEL, &RADIANS, |[pixel]| {
            Ok(<[f64; 2]>::from(order.centre_angles(checked(nside, pixel)?)))
        }),
        Conversion::RingToNest => {
            let nested = Nested::new(nside).map_err(CliError::usage)?;
            let job = Job { order: "nested", ..job };
            job.convert(&PIXEL, &PIXEL, |[pixel]| {
                Ok([written(nested.from_ring(checked(nside, pixel)?))])
            })
        }
        Conversion::NestToRing => {
            let nested = Nested::new(nside).map_err(CliError::usage)?;
            let job = Job { order: "ring", ..job };
            job.convert(&PIXEL, &PIXEL, |[pixel]| {
                Ok([written(nested.to_ring(checked(nside, pixel)?))])
            })
        }
    }
}

/// Returns the colatitude, which is pi for numbers that exceed pi by no more than rounding to `f32`
/// does.
#[must_use]
pub fn rounded_colatitude(theta: f64) -> f64 {
    if (PI..=PI + THETA_SLACK).contains(&theta) { PI } else { theta }
}

/// Returns the colatitude and the longitude in radians of a longitude and a latitude in degrees, or
/// `None` if the longitude is not finite or the latitude is not from -90 to 90.
#[must_use]
pub fn angles_of_degrees(lon: f64, lat: f64) -> Option<[f64; 2]> {
    // The remainder is exact, so longitudes of many periods lose no accuracy.
    let angles = || [(90.0 - lat).to_radians(), (lon % 360.0).to_radians()];
    (lon.is_finite() && (-90.0..=90.0).contains(&lat)).then(angles)
}

/// Returns the longitude and the latitude in degrees of a colatitude and a longitude in radians.
#[must_use]
pub fn degrees_of_angles(theta: f64, phi: f64) -> [f64; 2] {
    [phi.to_degrees(), 90.0 - theta.to_degrees()]
}

fn pixel_of_angles(order: &dyn PixelOrder, theta: f64, phi: f64) -> Result<[i64; 1], Fault> {
    let theta = rounded_colatitude(theta);
    // The list contains only finite numbers, so every longitude is valid.
    let pixel = order.pixel_of_angles(theta, phi).map_err(|_| {
        let expected = "a colatitude from 0 to pi radians (degrees are lon,lat, with --degrees)";
        Fault::Column(0, expected.to_owned())
    })?;
    Ok([written(pixel)])
}

fn checked(nside: Nside, pixel: i128) -> Result<u64, Fault> {
    let found = u64::try_from(pixel).ok().and_then(|pixel| nside.check_pixel(pixel).ok());
    found.ok_or_else(|| {
        let last = nside.n_pixels() - 1;
        Fault::Column(0, format!("a pixel from 0 to {last} (nside {nside})"))
    })
}

/// Returns a pixel as it is written to files: the largest, 12 * 2^58 - 1, is below 2^63.
fn written(pixel: u64) -> i64 {
    pixel.cast_signed()
}

/// One run of the command.
struct Job<'a> {
    args: &'a HealpixArgs,
    global: &'a Global,
    /// The order of the output pixels, or of the input pixels if there are no output pixels.
    order: &'static str,
}

impl Job<'_> {
    fn convert<A: Number, B: Written + Serialize, const M: usize, const N: usize>(
        &self,
        from: &Columns<M>,
        to: &Columns<N>,
        row: impl FnMut([A; M]) -> Result<[B; N], Fault>,
    ) -> Result<(), CliError> {
        let Self { args, global, order } = *self;
        let to_stdout = is_stdout(&args.out);
        let writer = match to_stdout && global.json {
            true => None,
            false => Some(ListWriter::create(&args.out)?),
        };
        let rows = read_list(&args.input, from, row)?;
        if let Some(writer) = writer {
            writer.write(&to.names, &rows).map_err(output_error)?;
        }
        if global.json {
            let body = HealpixBody::new(args, order, &to.names, &rows);
            return Document::new(&body, &Provenance::new(&global.session, global.seed))
                .print(&global.session);
        }
        Ok(())
    }
}

/// A reader of standard output that closes early, such as `head`, is not an error.
fn output_error(error: FileError) -> CliError {
    match error {
        FileError::Write { source, .. } if source.kind() == io::ErrorKind::BrokenPipe => {
            CliError::ClosedPipe
        }
        error => error.into(),
    }
}

/// Converted directions or pixels, an array for each column: `healpix --json`.
#[derive(Serialize, JsonSchema)]
pub(crate) struct HealpixBody<'a, T: Serialize, const N: usize> {
    /// The conversion, such as `vec2pix`.
    conversion: &'static str,
    /// The resolution: the sphere has 12 nside^2 pixels.
    nside: u32,
    /// The pixel order: `ring` or `nested`.
    order: &'static str,
    #[serde(flatten)]
    lists: Lists<'a, T, N>,
}

impl<'a, T: Serialize, const N: usize> HealpixBody<'a, T, N> {
    fn new(
        args: &HealpixArgs,
        order: &'static str,
        names: &'a [&'static str; N],
        rows: &'a [[T; N]],
    ) -> Self {
        let lists = Lists { names, rows };
        Self { conversion: args.conversion.name(), nside: args.nside.value(), order, lists }
    }
}

/// The columns of the output.
struct Lists<'a, T, const N: usize> {
    names: &'a [&'static str; N],
    rows: &'a [[T; N]],
}

impl<T: Serialize, const N: usize> Serialize for Lists<'_, T, N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let column = |column| Column { rows: self.rows, column };
        serializer.collect_map(self.names.iter().zip((0..N).map(column)))
    }
}

impl<T, const N: usize> JsonSchema for Lists<'_, T, N> {
    fn schema_name() -> Cow<'static, str> {
        "Lists".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let all = [
            (&VECTOR.names[..], VECTOR.remark),
            (&RADIANS.names, "colatitude and longitude in radians"),
            (&DEGREES.names, DEGREES.remark),
        ];
        let mut properties = serde_json::Map::new();
        for (names, remark) in all {
            let list =
                json!({ "description": remark, "type": "array", "items": { "type": "number" } });
            properties.extend(names.iter().map(|&name| (name.to_owned(), list.clone())));
        }
        let pixels = json!({
            "description": "numbers of pixels, from 0",
            "type": "array",
            "items": { "type": "integer" },
        });
        properties.extend(PIXEL.names.map(|name| (name.to_owned(), pixels.clone())));
        json_schema!({ "type": "object", "properties": properties })
    }
}

struct Column<'a, T, const N: usize> {
    rows: &'a [[T; N]],
    column: usize,
}

impl<T: Serialize, const N: usize> Serialize for Column<'_, T, N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.rows.iter().map(|row| &row[self.column]))
    }
}
