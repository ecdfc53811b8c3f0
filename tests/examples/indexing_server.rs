//! A process that converts directions and pixels on request, timed by `benches/peers/accuracy.py`
//! together with healpy.
//!
//! Reads one command per line from standard input and answers each with one line. A command that
//! fails ends the process with a message. Files are little-endian 64-bit numbers: three per vector,
//! two per pair of angles (colatitude and longitude for sphvar, longitude and latitude for
//! cdshealpix), one per pixel.
//!
//! ```text
//! nside K                   sets the resolution, a power of two from 1 to 2^29        -> ok
//! vectors PATH              loads unit vectors                                        -> ok
//! angles PATH               loads colatitudes and longitudes                          -> ok
//! lonlat PATH               loads longitudes and latitudes                            -> ok
//! pixels PATH               loads pixels                                              -> ok
//! run CODE WHAT ORDER       converts; ORDER is ring or nested                         -> seconds
//! write PATH                writes the pixels or vectors of the last run              -> ok
//! edges PATH                writes the distance of each vector from an edge, in pixels -> ok
//! ```
//!
//! `run sphvar`: `vec2pix` and `ang2pix` convert the whole list; `vec2pix-one` and `ang2pix-one`
//! convert one by one; `pix2vec`. `run cdshealpix`: `lonlat2pix`, with its native input; `vec2pix`,
//! including the computation of angles; `pix2vec`, including the computation of vectors from
//! angles. The times exclude allocation.

use std::error::Error;
use std::fs;
use std::hint::black_box;
use std::io::{BufRead, Write};
use std::time::Instant;

use glam::DVec3;
use sphvar_healpix::{Nested, Nside, PixelOrder, Ring};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let mut server = Server {
        nside: Nside::new(1)?,
        vectors: Vec::new(),
        angles: Vec::new(),
        lonlat: Vec::new(),
        pixels: Vec::new(),
        pixels_out: Vec::new(),
        vectors_out: Vec::new(),
        last: Last::None,
    };
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

/// The output of the last run.
enum Last {
    None,
    Pixels,
    Vectors,
}

struct Server {
    nside: Nside,
    vectors: Vec<DVec3>,
    angles: Vec<[f64; 2]>,
    lonlat: Vec<[f64; 2]>,
    pixels: Vec<u64>,
    pixels_out: Vec<u64>,
    vectors_out: Vec<DVec3>,
    last: Last,
}

impl Server {
    /// Executes a command. Returns the seconds if the command is timed.
    fn answer(&mut self, words: &[&str]) -> Result<Option<f64>> {
        match *words {
            ["nside", k] => self.nside = Nside::new(k.parse()?)?,
            ["vectors", path] => self.vectors = load(path, f64::from_le_bytes, DVec3::from_array)?,
            ["angles", path] => self.angles = load(path, f64::from_le_bytes, |pair| pair)?,
            ["lonlat", path] => self.lonlat = load(path, f64::from_le_bytes, |pair| pair)?,
            ["pixels", path] => self.pixels = load(path, u64::from_le_bytes, |[pixel]| pixel)?,
            ["run", code, what, "ring"] => {
                let order = Ring::new(self.nside);
                let nside = self.nside.value();
                return match code {
                    "sphvar" => self.ours(&order, what),
                    "cdshealpix" => self.theirs(
                        what,
                        |lon, lat| cdshealpix::ring::hash(nside, lon, lat),
                        |pixel| cdshealpix::ring::center(nside, pixel),
                    ),
                    _ => Err("unknown code".into()),
                };
            }
            ["run", code, what, "nested"] => {
                let order = Nested::new(self.nside)?;
                let layer = cdshealpix::nested::get(u8::try_from(self.nside.value().ilog2())?);
                return match code {
                    "sphvar" => self.ours(&order, what),
                    "cdshealpix" => {
                        self.theirs(what, |lon, lat| layer.hash(lon, lat), |p| layer.center(p))
                    }
                    _ => Err("unknown code".into()),
                };
            }
            ["write", path] => match self.last {
                Last::None => return Err("no run to write".into()),
                Last::Pixels => store(path, self.pixels_out.iter().map(|p| p.to_le_bytes()))?,
                Last::Vectors => {
                    let components = self.vectors_out.iter().flat_map(|v| v.to_array());
                    store(path, components.map(f64::to_le_bytes))?;
                }
            },
            ["edges", path] => {
                let order = Ring::new(self.nside);
                let distances = self.vectors.iter().map(|&dir| {
                    let (_, u, v) = order.invert_uniform_point(dir);
                    u.min(v).min(1.0 - u).min(1.0 - v)
                });
                store(path, distances.map(f64::to_le_bytes))?;
            }
            _ => return Err("unknown command or wrong number of arguments".into()),
        }
        Ok(None)
    }

    fn ours<O: PixelOrder>(&mut self, order: &O, what: &str) -> Result<Option<f64>> {
        match what {
            "vec2pix" => Ok(Some(self.time_pixels(self.vectors.len(), |server| {
                order.pixels_into(&server.vectors, &mut server.pixels_out);
            }))),
            "vec2pix-one" => Ok(Some(self.time_pixels(self.vectors.len(), |server| {
                each(&server.vectors, &mut server.pixels_out, |dir| order.pixel(*black_box(dir)));
            }))),
            "ang2pix" => {
                let mut done = Ok(());
                let seconds = self.time_pixels(self.angles.len(), |server| {
                    done = order.pixels_of_angles_into(&server.angles, &mut server.pixels_out);
                });
                Ok(done.map(|()| Some(seconds))?)
            }
            "ang2pix-one" => {
                let mut result = Ok(());
                let seconds = self.time_pixels(self.angles.len(), |server| {
                    each(&server.angles, &mut server.pixels_out, |angles| {
                        let [theta, phi] = *black_box(angles);
                        order.pixel_of_angles(theta, phi).unwrap_or_else(|error| {
                            result = Err(error);
                            0
                        })
                    });
                });
                Ok(result.map(|()| Some(seconds))?)
            }
            "pix2vec" => {
                for &pixel in &self.pixels {
                    self.nside.check_pixel(pixel)?;
                }
                Ok(Some(self.time_vectors(|pixel| order.centre(pixel))))
            }
            _ => Err("unknown conversion".into()),
        }
    }

    fn theirs(
        &mut self,
        what: &str,
        hash: impl Fn(f64, f64) -> u64,
        center: impl Fn(u64) -> (f64, f64),
    ) -> Result<Option<f64>> {
        match what {
            "lonlat2pix" => Ok(Some(self.time_pixels(self.lonlat.len(), |server| {
                each(&server.lonlat, &mut server.pixels_out, |&[lon, lat]| hash(lon, lat));
            }))),
            "vec2pix" => Ok(Some(self.time_pixels(self.vectors.len(), |server| {
                each(&server.vectors, &mut server.pixels_out, |dir| {
                    hash(dir.y.atan2(dir.x), dir.z.atan2(dir.x.hypot(dir.y)))
                });
            }))),
            "pix2vec" => Ok(Some(self.time_vectors(|pixel| {
                let (lon, lat) = center(pixel);
                let ((sin_lon, cos_lon), (sin_lat, cos_lat)) = (lon.sin_cos(), lat.sin_cos());
                DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)
            }))),
            _ => Err("unknown conversion".into()),
        }
    }

    /// Returns the seconds of a conversion to `n` pixels.
    fn time_pixels(&mut self, n: usize, convert: impl FnOnce(&mut Self)) -> f64 {
        self.pixels_out.resize(n, 0);
        self.last = Last::Pixels;
        let start = Instant::now();
        convert(self);
        start.elapsed().as_secs_f64()
    }

    /// Returns the seconds of a conversion of the pixels.
    fn time_vectors(&mut self, convert: impl Fn(u64) -> DVec3) -> f64 {
        self.vectors_out.resize(self.pixels.len(), DVec3::ZERO);
        self.last = Last::Vectors;
        let start = Instant::now();
        each(&self.pixels, &mut self.vectors_out, |&pixel| convert(pixel));
        start.elapsed().as_secs_f64()
    }
}

fn each<A, B>(from: &[A], to: &mut [B], mut convert: impl FnMut(&A) -> B) {
    for (a, b) in from.iter().zip(to) {
        *b = convert(a);
    }
}

fn load<N: Copy + Default, T, const K: usize>(
    path: &str,
    number: impl Fn([u8; 8]) -> N,
    item: impl Fn([N; K]) -> T,
) -> Result<Vec<T>> {
    let bytes = fs::read(path)?;
    let (numbers, rest) = bytes.as_chunks();
    let numbers: Vec<N> = numbers.iter().map(|&bytes| number(bytes)).collect();
    let (items, lone) = numbers.as_chunks();
    if !lone.is_empty() || !rest.is_empty() {
        return Err(format!("{} bytes are not a multiple of {}", bytes.len(), 8 * K).into());
    }
    Ok(items.iter().map(|&numbers| item(numbers)).collect())
}

fn store(path: &str, numbers: impl Iterator<Item = [u8; 8]>) -> Result<()> {
    Ok(fs::write(path, numbers.flatten().collect::<Vec<u8>>())?)
}
