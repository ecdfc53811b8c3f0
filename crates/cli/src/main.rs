//! The command `sphvar`; its implementation is in the library of this crate.

use std::process::ExitCode;

fn main() -> ExitCode {
    sphvar_cli::run()
}
