//! The native half of the package `sphvar` for Python: arrays in, arrays out, on the libraries of
//! sphvar. `python/sphvar` is the other half, which names the functions and describes them.

mod arrays;
mod command;
mod errors;
mod function;
mod healpix;
mod sampler;
mod session;
mod spectrum;
mod transforms;
mod work;

use pyo3::prelude::*;

#[pymodule]
fn _sphvar(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    arrays::register(module)?;
    command::register(module)?;
    spectrum::register(module)?;
    transforms::register(module)?;
    healpix::register(module)?;
    sampler::register(module)?;
    session::register(module)?;
    work::register(module)
}
