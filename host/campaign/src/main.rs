//! The `flotilla-campaign` program. Everything is in [`campaign`].

use std::process::ExitCode;

fn main() -> ExitCode {
    campaign::main()
}
