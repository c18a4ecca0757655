//! `flotilla`, for the tests of this package, as `main.rs` is `flotilla-campaign`.

fn main() -> std::process::ExitCode {
    host::cli::main()
}
