//! A fresh environment with the wheel in it, below `target`, and what runs there.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// `flotilla`.
const FLOTILLA: &str = env!("CARGO_BIN_EXE_flotilla-for-python");

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn run(command: &mut Command) {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let said = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, err) = (said(&output.stdout), said(&output.stderr));
    assert!(output.status.success(), "{command:?}: {}\n{out}{err}", output.status);
    println!("{out}");
}

/// The Python of an environment with the packages that are asked for, and nothing of ours.
fn peers(name: &str, requirements: &Path) -> PathBuf {
    let folder = here().join("../../target").join(name);
    run(Command::new(here().join("../environment")).arg(&folder).arg(requirements));
    folder.join("bin/python")
}

/// The Python of an environment with the wheel, which is built and installed once a run of these tests.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let wheels = Path::new(env!("CARGO_TARGET_TMPDIR")).join("wheels");
        let _ = std::fs::remove_dir_all(&wheels);
        let mut build = Command::new(here().join("../../host/python/build"));
        // The profile of tests under its other name (`test` is no profile of a library): what has the same features is compiled already.
        run(build.args(["--profile", "dev", "--out"]).arg(&wheels).arg("native"));
        let wheel = std::fs::read_dir(&wheels).expect("a folder").find_map(|entry| {
            let path = entry.expect("an entry").path();
            path.extension().is_some_and(|extension| extension == "whl").then_some(path)
        });
        let python = peers("python", &here().join("requirements.txt"));
        let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--force-reinstall"];
        run(Command::new(&python).args(install).arg("--no-deps").arg(wheel.expect("a wheel")));
        python
    })
}

/// Runs a file of tests.
pub fn pytest(file: &str) {
    let mut command = Command::new(python());
    command.args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--durations=3", file]);
    command.current_dir(here()).env("FLOTILLA_PROGRAM", FLOTILLA).env("PYTHONDONTWRITEBYTECODE", "1");
    run(&mut command);
}
