//! Times whole transforms, from the plan to the result, for `benches/peers/python_overhead.py`.
//!
//! Arguments: the number of points and the largest degree. For every line of standard input it
//! prints the seconds of one transform, the adjoint and the synthesis alternately.

use std::io::{BufRead, Write};
use std::time::Instant;

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{Method, Transform, TransformWorkspace};

/// A Fibonacci lattice, shuffled by a stride, so that neighbours in memory are not neighbours.
fn points(n: usize) -> Vec<DVec3> {
    let stride = (n / 1000 * 618) | 1;
    let point = |i: usize| {
        let k = (i * stride % n) as f64;
        let (z, phi) = (1.0 - (2.0 * k + 1.0) / n as f64, 2.399_963_229_728_653 * k);
        let s = (1.0 - z * z).sqrt();
        DVec3::new(s * phi.cos(), s * phi.sin(), z).normalize()
    };
    (0..n).map(point).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut number = || arguments.next().unwrap_or_default().parse::<usize>();
    let (n, lmax) = (number()?, number()?);
    let points = points(n);
    let mut alm = Alm::zeros(lmax)?;
    alm.values_mut().iter_mut().for_each(|a| *a = 1.0.into());
    let mut is_adjoint = true;
    for line in std::io::stdin().lock().lines() {
        line?;
        let start = Instant::now();
        let transform = Transform::new(Method::Auto, lmax, n, 1e-12)?;
        let mut workspace = TransformWorkspace::default();
        if is_adjoint {
            let mut out = [Alm::zeros(lmax)?];
            transform.adjoint_batch_into(&[(&points, None)], &mut workspace, &mut out);
            drop(std::hint::black_box(out));
        } else {
            let mut values = vec![0.0; n];
            transform.synthesis_into(&alm, &points, &mut workspace, &mut values);
            drop(std::hint::black_box(values));
        }
        drop((transform, workspace));
        let seconds = start.elapsed().as_secs_f64();
        let mut out = std::io::stdout().lock();
        writeln!(out, "{seconds}")?;
        out.flush()?;
        is_adjoint = !is_adjoint;
    }
    Ok(())
}
