//! `flotilla-ros2`, for the tests of this package: cargo gives them the path of a program of their own package alone.

fn main() -> std::process::ExitCode {
    flotilla_ros2::cli::main()
}
