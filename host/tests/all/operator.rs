//! `flotilla stop`, `hold`, `release` and `status` to a run with three `flotilla module` processes, and to modules alone. Nothing is
//! asked of how fast it goes, only of what becomes of it.

use std::path::Path;

use crate::common::{Finished, PATIENCE, Process};
use crate::interrupt::end;
use crate::keys::{KEY, keygen};
use crate::ports::port;
use serde_json::Value;
use tempfile::{TempDir, tempdir};

/// Cycles are sent a second ahead, so that a process that waits for its turn on the processor still hears of them in time.
const SCENARIO: &str = "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 3000\nvelocity_m_s = [0.04, 0]\n\
     heading_rad = 1.5\n[timing]\nlead_s = 1.0\njoin_s = 60\n";

/// A folder with a key and a scenario.
fn tank() -> TempDir {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    std::fs::write(folder.path().join("t.toml"), SCENARIO).expect("a file");
    folder
}

fn run(folder: &Path) -> (Process, String) {
    let arguments =
        ["run", "t.toml", "--radio", "udp", "--listen", "127.0.0.1:0", "--key", KEY, "--out", "results"];
    let run = Process::reachable(folder, &arguments);
    let line = run.err.recv_timeout(PATIENCE).expect("a line about the port");
    let address =
        line.strip_prefix("listening on ").and_then(|rest| rest.split_once(' ')).expect("an address");
    let address = address.0.to_owned();
    (run, address)
}

fn module(folder: &Path, id: &str, host: &str) -> Process {
    Process::reachable(folder, &["module", "--id", id, "--host", host, "--duration", "3600", "--key", KEY])
}

/// What an operator's command says, as JSON, and its exit code.
fn operator(folder: &Path, arguments: &[&str]) -> (Value, Option<i32>) {
    let Finished { code, out, err } =
        Process::reachable(folder, &[arguments, &["--json", "--wait", "120"]].concat()).finish();
    let line = out.first().unwrap_or_else(|| panic!("{arguments:?}: {err:?}"));
    (serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}")), code)
}

fn states(said: &Value) -> Vec<&str> {
    let modules = said["modules"].as_array().expect("a list");
    modules.iter().map(|module| module["state"].as_str().unwrap_or("never heard")).collect()
}

/// Waits until a module's own process says that it is in `state`.
fn await_state(module: &Process, state: &str) {
    while !module.err.recv_timeout(PATIENCE).expect("a line about its state").contains(state) {}
}

#[test]
fn a_run_is_stopped_held_and_released() {
    let folder = tank();
    let (run, address) = run(folder.path());
    let modules = ["1", "2", "3"].map(|id| module(folder.path(), id, &address));
    modules.iter().for_each(|module| await_state(module, "Executing"));

    let (said, code) = operator(folder.path(), &["stop"]);
    assert_eq!((states(&said), code), (vec!["Stopped"; 3], Some(0)), "{said}");
    modules.iter().for_each(|module| await_state(module, "Stopped"));
    // A hold does not end a stop.
    let (said, _) = operator(folder.path(), &["hold"]);
    assert_eq!(states(&said), ["Stopped"; 3], "{said}");
    let (said, code) = operator(folder.path(), &["release"]);
    assert_eq!(code, Some(0), "{said}");
    modules.iter().for_each(|module| await_state(module, "Executing"));

    let (said, code) = operator(folder.path(), &["status", "--module", "2"]);
    assert_eq!((states(&said).len(), code), (1, Some(0)), "{said}");
    // One that is not stopped has nothing to be released from, and swims on.
    let (said, code) = operator(folder.path(), &["release", "--module", "2"]);
    assert_eq!((states(&said).len(), code), (1, Some(0)), "{said}");

    let (said, code) = operator(folder.path(), &["hold"]);
    assert_eq!((states(&said), code), (vec!["Holding"; 3], Some(0)), "{said}");
    let (_, code) = operator(folder.path(), &["release"]);
    assert_eq!(code, Some(0));
    modules.iter().for_each(|module| await_state(module, "Executing"));

    end(&run, "INT");
    let finished = run.finish();
    assert_eq!(finished.code, Some(1), "{finished:?}");
    assert!(finished.err.iter().any(|line| line.contains("interrupted")), "{finished:?}");
    assert!(folder.path().join("results/summary.json").exists());
    let left = std::fs::read_dir(folder.path().join("sockets/flotilla")).expect("a folder").count();
    assert_eq!(left, 0, "its socket is gone");
}

#[test]
fn a_second_interrupt_is_an_emergency_stop() {
    let folder = tank();
    let (run, address) = run(folder.path());
    let modules = ["1", "2", "3"].map(|id| module(folder.path(), id, &address));
    modules.iter().for_each(|module| await_state(module, "Executing"));
    end(&run, "INT");
    end(&run, "INT");
    // Two signals may be taken for one; a third would end the program at once.
    let finished = run.finish();
    assert_eq!(finished.code, Some(1), "{finished:?}");
    let stopped = finished.err.iter().any(|line| line.contains("emergency stop"));
    if stopped {
        modules.iter().for_each(|module| await_state(module, "Stopped"));
    }
    assert!(folder.path().join("results/summary.json").exists());
}

#[test]
fn modules_without_a_run_are_stopped_and_released_one_by_one() {
    let folder = tank();
    // The operator listens there.
    let address = format!("127.0.0.1:{}", port());
    let modules = ["1", "2"].map(|id| module(folder.path(), id, &address));
    let direct = |arguments: &[&str]| {
        operator(folder.path(), &[arguments, &["--listen", &address, "--key", KEY]].concat())
    };
    let (said, code) = direct(&["stop"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(!states(&said).is_empty() && states(&said).iter().all(|state| *state == "Stopped"), "{said}");
    // Each, by name: that one module is slow to join is no failure of the order to those that are there.
    for id in ["1", "2"] {
        let (said, code) = direct(&["stop", "--module", id]);
        assert_eq!((states(&said), code), (vec!["Stopped"], Some(0)), "{said}");
    }
    let (said, code) = direct(&["release", "--module", "2"]);
    assert_eq!(code, Some(0), "{said}");
    assert_ne!(states(&said), ["Stopped"], "{said}");
    let (said, code) = direct(&["status", "--module", "1"]);
    assert_eq!(
        (states(&said), code),
        (vec!["Stopped"], Some(0)),
        "another's release is none of its own: {said}"
    );
    drop(modules);
}

#[test]
fn what_cannot_be_reached_is_said() {
    let folder = tank();
    let arguments = ["status", "--listen", "127.0.0.1:0", "--key", KEY, "--wait", "0.3"];
    let finished = Process::reachable(folder.path(), &arguments).finish();
    assert_eq!(finished.code, Some(1), "{finished:?}");
    assert!(
        finished.err.iter().any(|line| line.contains("no module was heard within 0.3 s")),
        "{finished:?}"
    );
    let finished = Process::reachable(folder.path(), &["stop", "--run", "1"]).finish();
    assert_eq!(finished.code, Some(2), "{finished:?}");
    // A folder that others could write to is not used.
    let open = folder.path().join("sockets/flotilla");
    std::fs::remove_dir(&open).expect("an empty folder");
    std::fs::create_dir(&open).expect("a folder");
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o777);
    std::fs::set_permissions(&open, mode).expect("a folder");
    let finished = Process::reachable(folder.path(), &["stop"]).finish();
    assert_eq!(finished.code, Some(1), "{finished:?}");
    assert!(finished.err.iter().any(|line| line.contains("closed to others")), "{finished:?}");
}
