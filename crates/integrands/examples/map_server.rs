//! A process that computes the coefficients of HEALPix maps on request, timed by
//! `benches/peers/map_coefficients.py` together with healpy.
//!
//! Reads one command per line from standard input and answers each with one line. A command that
//! fails ends the process with a message. Values are little-endian f64 in ring order.
//!
//! ```text
//! threads T        sets the number of threads, once  -> ok
//! load PATH NSIDE  loads a map                       -> ok
//! run LMAX         computes its coefficients         -> seconds
//! write PATH       writes them in `LmIndex` order    -> ok
//! ```

use std::error::Error;
use std::fs::{self, File};
use std::io::{BufRead, BufWriter, Write};
use std::time::Instant;

use sphvar_healpix::Nside;
use sphvar_integrands::{Domain, HealpixMap};
use sphvar_sh::Alm;

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
    map: Option<HealpixMap>,
    result: Option<Alm>,
}

impl Server {
    fn answer(&mut self, words: &[&str]) -> Result<Option<f64>> {
        match words {
            ["threads", count] => {
                rayon::ThreadPoolBuilder::new().num_threads(count.parse()?).build_global()?;
                Ok(None)
            }
            ["load", path, nside] => {
                let bytes = fs::read(path)?;
                let values = bytes.as_chunks().0.iter().map(|&b| f64::from_le_bytes(b)).collect();
                self.map = Some(HealpixMap::new(Nside::new(nside.parse()?)?, values)?);
                Ok(None)
            }
            ["run", lmax] => {
                let map = self.map.as_ref().ok_or("no map")?;
                let lmax = lmax.parse()?;
                let start = Instant::now();
                self.result = Some(map.alm(Domain::Sphere, lmax)?);
                Ok(Some(start.elapsed().as_secs_f64()))
            }
            ["write", path] => {
                let alm = self.result.as_ref().ok_or("no coefficients")?;
                let mut file = BufWriter::new(File::create(path)?);
                for a in alm.values() {
                    file.write_all(&a.re.to_le_bytes())?;
                    file.write_all(&a.im.to_le_bytes())?;
                }
                file.flush()?;
                Ok(None)
            }
            _ => Err("no such command".into()),
        }
    }
}
