//! Three `flotilla module` processes and one `flotilla run --radio udp` over real sockets, in real time. Nothing is asked
//! that does not hold on a machine that is slow and has much else to do; how well a fleet swims is asked in simulated time
//! (`run.rs`) and of emulated modules in lock step.

use std::path::Path;

use crate::common::{Finished, PATIENCE, Process};
use crate::interrupt::{end, send};
use crate::keys::{KEY, keygen};
use serde_json::Value;
use tempfile::tempdir;

/// One leg of `duration_s`. Cycles are sent a second ahead, so that a process that waits for its turn on the
/// processor still hears of them in time.
fn scenario(duration_s: f64) -> String {
    format!(
        "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = {duration_s}\n\
         velocity_m_s = [0.04, 0]\nheading_rad = 1.5\n[timing]\nlead_s = 1.0\njoin_s = 60\n"
    )
}

/// A host on a port of the system's choice, and its address.
fn host(folder: &Path, more: &[&str]) -> (Process, String) {
    let arguments = ["run", "t.toml", "--radio", "udp", "--listen", "127.0.0.1:0", "--key", KEY];
    let host = Process::start(folder, &[&arguments[..], &["--json", "--out", "results"], more].concat());
    let line = host.err.recv_timeout(PATIENCE).expect("a line about the port");
    let address =
        line.strip_prefix("listening on ").and_then(|rest| rest.split_once(' ')).expect("an address").0;
    let address = address.to_owned();
    (host, address)
}

fn module(folder: &Path, id: &str, host: &str) -> Process {
    // Should this test be killed, they end by themselves.
    let arguments = ["module", "--id", id, "--host", host, "--scenario", "t.toml", "--duration", "3600"];
    Process::start(folder, &[&arguments[..], &["--key", KEY]].concat())
}

/// The summary that a run printed, which is the one it wrote, with its pictures beside it.
fn summary(folder: &Path, finished: &Finished) -> Value {
    let text = finished.out.join("\n");
    let summary: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {finished:?}"));
    let results = folder.join("results");
    let written = std::fs::read_to_string(results.join("summary.json")).expect("a summary");
    assert_eq!(written.trim_end(), text);
    for picture in ["trajectory.svg", "wrench.svg", "tails.svg", "phase-space.svg"] {
        let text = std::fs::read_to_string(results.join(picture)).expect(picture);
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"), "{picture}");
    }
    summary
}

/// The sums of one module's link.
fn assert_exact(link: &Value) {
    let sum = |of: &Value, names: &[&str]| -> u64 {
        names.iter().map(|&name| of[name].as_u64().unwrap_or_else(|| panic!("no {name}: {link}"))).sum()
    };
    let classes = ["accepted", "duplicate", "stale", "corrupt", "forged", "foreign"];
    for received in [&link["from_module"], &link["module_received"]] {
        assert_eq!(received["received"].as_u64(), Some(sum(received, &classes)), "{link}");
    }
    let to_module = &link["to_module"];
    let (sent, told) = (sum(to_module, &["sent"]), sum(to_module, &["acknowledged", "late", "lost"]));
    // What is under way when the run ends is what was sent last.
    assert!(told <= sent && sent - told <= 20, "{link}");
    let (cycles, told) =
        (sum(link, &["cycles"]), sum(link, &["acknowledged", "late", "refused", "unanswered"]));
    assert!(told <= cycles && cycles - told <= 1, "{link}");
}

/// The run went on to its end. A tail that stops in mid-swing, as its process waits for the processor, may be touched by those that swim
/// on: whether it was must be told.
fn assert_ended(finished: &Finished, summary: &Value) {
    assert_eq!(summary["complete"], true, "{summary}");
    assert_said(finished, summary);
}

/// How it ended is what the summary says: a line for tails that touched, or an early end, and a line for each shortfall.
fn assert_said(finished: &Finished, summary: &Value) {
    let contacts = summary["contacts"].as_array().expect("a list").len();
    let shortfalls = summary["shortfalls"].as_array().expect("a list").len();
    let ended = contacts > 0 || summary["complete"] == false;
    let lines = usize::from(ended) + shortfalls;
    assert_eq!(summary["failure"].is_null(), lines == 0, "{summary}");
    assert_eq!((finished.code, finished.err.len()), (Some(i32::from(lines > 0)), lines), "{finished:?}");
}

/// Waits until a module says that it swims.
fn await_swimming(module: &Process) {
    loop {
        let line = module.err.recv_timeout(PATIENCE).expect("a line about its state");
        if line.contains("Executing") {
            return;
        }
    }
}

#[test]
fn three_processes_swim_a_leg() {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    std::fs::write(folder.path().join("t.toml"), scenario(12.0)).expect("a file");
    let (host, address) = host(folder.path(), &[]);
    let _modules = ["1", "2", "3"].map(|id| module(folder.path(), id, &address));
    let finished = host.finish();
    let summary = summary(folder.path(), &finished);
    assert_ended(&finished, &summary);
    let links = summary["link"].as_array().expect("a list");
    assert_eq!(links.len(), 3);
    for (index, link) in links.iter().enumerate() {
        assert_eq!(link["module"], index + 1);
        assert!(link["acknowledged"].as_u64() >= Some(1), "{summary}");
        assert_eq!(link["boots"], 1, "{summary}");
        assert_exact(link);
    }
    assert_eq!(summary["strays"]["received"], 0, "{summary}");
    println!("{} cycles, at {} m/s", summary["cycles"]["total"], summary["legs"][0]["mean_m_s"]);
}

#[test]
fn a_module_that_dies_and_comes_back_is_taken_in_again() {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    std::fs::write(folder.path().join("t.toml"), scenario(600.0)).expect("a file");
    let (host, address) = host(folder.path(), &[]);
    let _others = ["1", "2"].map(|id| module(folder.path(), id, &address));
    let first_life = module(folder.path(), "3", &address);
    await_swimming(&first_life);
    drop(first_life);
    let second_life = module(folder.path(), "3", &address);
    await_swimming(&second_life);
    end(&host, "INT");

    let finished = host.finish();
    let summary = summary(folder.path(), &finished);
    // Its tail stopped in mid-swing while the others swam on: whether two of them met is luck, and is told first.
    let contacts = summary["contacts"].as_array().expect("a list").len();
    let why = if contacts == 0 { ": interrupted" } else { "the structure would have come apart" };
    assert_said(&finished, &summary);
    assert!(finished.err[0].ends_with(why), "{finished:?}");
    assert!(summary["cycles"]["reboots"].as_u64() >= Some(1), "{summary}");
    let links = summary["link"].as_array().expect("a list");
    links.iter().for_each(assert_exact);
    assert_eq!(links.iter().map(|link| link["boots"].as_u64()).collect::<Vec<_>>(), [1, 1, 2].map(Some));
    assert!(links.iter().all(|link| link["acknowledged"].as_u64() >= Some(1)), "{summary}");
}

/// Two of three are enough where two are required: the third gets nothing, and fails nothing.
#[test]
fn two_modules_swim_where_two_are_required() {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    std::fs::write(folder.path().join("t.toml"), scenario(12.0)).expect("a file");
    let (host, address) = host(folder.path(), &["--require", "2"]);
    let _modules = ["1", "2"].map(|id| module(folder.path(), id, &address));
    let finished = host.finish();
    let summary = summary(folder.path(), &finished);
    assert_eq!(summary["complete"], true, "{summary}");
    let contacts = summary["contacts"].as_array().expect("a list").len();
    assert_eq!(finished.code, Some(i32::from(contacts > 0)), "{finished:?}");
    let links = summary["link"].as_array().expect("a list");
    let taken = links.iter().map(|link| link["acknowledged"].as_u64().expect("a number"));
    let taken: Vec<u64> = taken.collect();
    assert!(taken[0] >= 1 && taken[1] >= 1 && taken[2] == 0, "{summary}");
    assert_eq!((&links[2]["cycles"], &links[2]["boots"]), (&0.into(), &0.into()), "{summary}");
}

/// The same fleet where all are required: the run is not begun, and says which module is missing and how it is started.
#[test]
fn two_of_three_modules_are_not_enough_where_all_are_required() {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    let text = scenario(12.0).replace("join_s = 60", "join_s = 5\nrequire = 2");
    std::fs::write(folder.path().join("t.toml"), text).expect("a file");
    // The command line goes before the file.
    let (host, address) = host(folder.path(), &["--require", "all"]);
    let _modules = ["1", "2"].map(|id| module(folder.path(), id, &address));
    let finished = host.finish();
    assert_eq!((finished.code, finished.out.len(), finished.err.len()), (Some(2), 0, 1), "{finished:?}");
    assert!(finished.err[0].starts_with("flotilla: module 3 did not answer within 5 s"), "{finished:?}");
}

/// It is dead for more than a quarter of the leg, whatever the machine does meanwhile.
#[test]
fn a_module_that_dies_for_good_is_named() {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    std::fs::write(folder.path().join("t.toml"), scenario(20.0)).expect("a file");
    let (host, address) = host(folder.path(), &[]);
    let _others = ["1", "3"].map(|id| module(folder.path(), id, &address));
    let victim = module(folder.path(), "2", &address);
    await_swimming(&victim);
    // Its first cycle only turns: the run has begun when the swim after it has.
    std::thread::sleep(std::time::Duration::from_secs(6));
    drop(victim);
    let finished = host.finish();
    let summary = summary(folder.path(), &finished);
    assert_ended(&finished, &summary);
    assert_eq!(finished.code, Some(1), "{finished:?}");
    let named = |line: &String| {
        line.contains("leg 1: module 2 took no part for ") && line.ends_with("it does not answer")
    };
    assert!(finished.err.iter().any(named), "{finished:?}");
    assert!(finished.err.iter().any(|line| line.contains("leg 1: the fleet held for ")), "{finished:?}");
    let absences = summary["absences"].as_array().expect("a list");
    let away_s =
        absences.iter().filter(|absence| absence["module"] == 2).map(|a| a["time_s"].as_f64().expect("s"));
    assert!(away_s.sum::<f64>() > 5.0, "{summary}");
}

/// A host that is stopped in mid-swim (Ctrl-Z, a machine that sleeps) says so, and nothing is told of the time in which it did not look.
#[test]
fn a_host_that_is_stopped_tells_the_gap() {
    const STOPPED: std::time::Duration = std::time::Duration::from_secs(4);
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    std::fs::write(folder.path().join("t.toml"), scenario(600.0)).expect("a file");
    let (host, address) = host(folder.path(), &[]);
    let modules = ["1", "2", "3"].map(|id| module(folder.path(), id, &address));
    modules.iter().for_each(await_swimming);
    send(&host, "STOP");
    std::thread::sleep(STOPPED);
    send(&host, "CONT");
    // Each holds meanwhile, and swims again when the host is back.
    for module in &modules {
        while !module.err.recv_timeout(PATIENCE).expect("a line about its state").contains("Holding") {}
        await_swimming(module);
    }
    end(&host, "INT");
    let finished = host.finish();
    let summary = summary(folder.path(), &finished);
    assert_said(&finished, &summary);
    let gaps = summary["gaps"].as_array().expect("a list");
    let lengths_s = gaps.iter().map(|gap| gap["length_s"].as_f64().expect("s"));
    assert!(lengths_s.clone().any(|length_s| length_s >= STOPPED.as_secs_f64() - 0.6), "{summary}");
    assert!(lengths_s.clone().all(|length_s| length_s >= 0.5), "{summary}");
    // Contacts are drawn from what was seen: none begins in a gap.
    for contact in summary["contacts"].as_array().expect("a list") {
        let t_s = contact["t_s"].as_f64().expect("s");
        let within = |gap: &Value| {
            let [start_s, length_s] = ["start_s", "length_s"].map(|key| gap[key].as_f64().expect("s"));
            (start_s + 0.001..start_s + length_s - 0.001).contains(&t_s)
        };
        assert!(!gaps.iter().any(within), "{summary}");
    }
}

/// A process that was left over, with the number of another. Both are there, neither is used, and the run does not end well.
#[test]
fn two_modules_with_one_number_are_named() {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    let text = scenario(12.0).replace("join_s = 60", "join_s = 8");
    std::fs::write(folder.path().join("t.toml"), text).expect("a file");
    let (host, address) = host(folder.path(), &[]);
    let _modules = ["1", "2", "3", "2"].map(|id| module(folder.path(), id, &address));
    let finished = host.finish();
    assert_eq!(finished.code, Some(1), "{finished:?}");
    assert!(finished.err[0].starts_with("flotilla: "), "{finished:?}");
    let named = |line: &String| {
        line.contains("module 2 is there twice, at 127.0.0.1:")
            || line.contains("module 2 took no part for ")
                && line.ends_with("two modules have its number, and neither is used")
    };
    assert!(finished.err.iter().any(named), "{finished:?}");
}
