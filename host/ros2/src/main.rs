//! The `flotilla-ros2` program. Everything is in [`flotilla_ros2::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    flotilla_ros2::cli::main()
}
