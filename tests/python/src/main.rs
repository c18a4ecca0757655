//! `flotilla`, for the tests of this package: cargo gives them the path of a program of their own package alone.

fn main() -> std::process::ExitCode {
    host::cli::main()
}
