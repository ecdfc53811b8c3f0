//! The command `sphvar`; what it does is in the library beside it.

use std::process::ExitCode;

fn main() -> ExitCode {
    sphvar_cli::run()
}
