//! Bad input gets one clear line on standard error, exit code 2, and leaves nothing behind. All through the binary.

mod files;
mod requests;

use std::net::UdpSocket;
use std::path::Path;

use crate::common::{Finished, PATIENCE, Process};
use crate::keys::{KEY, keygen};
use crate::ports::port;
use tempfile::{TempDir, tempdir};

/// A scenario without a mistake; line 3 is the structure's size, 5 to 7 are the leg.
const GOOD: &str = "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 6\n\
                    velocity_m_s = [0.04, 0]\nheading_rad = 1.5\n";

/// The one line with which `flotilla` refuses, without its first word.
fn refusal(finished: &Finished) -> &str {
    assert_eq!(finished.code, Some(2), "{finished:?}");
    assert_eq!(finished.err.len(), 1, "one line: {finished:?}");
    assert!(finished.out.is_empty(), "{finished:?}");
    let line = finished.err[0].strip_prefix("flotilla: ").expect("says who speaks");
    assert!(!line.contains("panicked"), "{line}");
    line
}

fn refused(folder: &Path, arguments: &[&str]) -> String {
    refusal(&Process::start(folder, arguments).finish()).to_owned()
}

/// A folder with `t.toml` in it.
fn with_scenario(text: impl AsRef<[u8]>) -> TempDir {
    let folder = tempdir().expect("a folder");
    std::fs::write(folder.path().join("t.toml"), text).expect("a file");
    folder
}

/// The same with a key, for what goes over a radio.
fn with_key(text: impl AsRef<[u8]>) -> TempDir {
    let folder = with_scenario(text);
    keygen(folder.path());
    folder
}

/// `arguments`, and the key.
fn keyed<'a>(arguments: &[&'a str]) -> Vec<&'a str> {
    [arguments, &["--key", KEY]].concat()
}

#[track_caller]
fn assert_left_alone(folder: &Path) {
    let mut left: Vec<_> =
        std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("it").file_name()).collect();
    left.retain(|name| name != "t.toml" && name != KEY);
    // The parent of all runs may stay; a run that was not to be has no place in it.
    if left == ["runs"] {
        left = std::fs::read_dir(folder.join("runs"))
            .expect("a folder")
            .map(|e| e.expect("it").file_name())
            .collect();
    }
    assert!(left.is_empty(), "left behind: {left:?}");
}

#[test]
fn mistakes_in_a_scenario_are_named_with_line_value_and_unit() {
    let with = |more: &str| format!("{GOOD}{more}\n");
    let shaped = |shape: &str| GOOD.replace("size = \"3x1\"", shape);
    let cases: Vec<(String, &str, &[&str])> = vec![
        (with("[modboat]\nperiod = 1.5"), "9", &["unknown field `period`", "`period_s`"]),
        (with("[boat]\nperiod_s = 1.5"), "8", &["unknown field `boat`"]),
        (GOOD.replace("heading_rad", "heading_deg"), "7", &["unknown field `heading_deg`"]),
        (with("[modboat]\nperiod_s = -1.5"), "9", &["[modboat] period_s = -1.5 s", "greater than zero"]),
        (with("[modboat]\nperiod_s = nan"), "9", &["[modboat] period_s = NaN s"]),
        (with("[modboat]\nperiod_s = 1e300"), "9", &["[modboat] period_s = 1", "at most 1000"]),
        (
            with("[modboat]\namplitude_min_rad = 2.0\namplitude_max_rad = 1.0"),
            "9",
            &["[modboat] amplitude_min_rad = 2 rad", "reversed"],
        ),
        // Reversed against a default.
        (
            with("[modboat]\namplitude_max_rad = 0.5"),
            "8",
            &["[modboat] amplitude_min_rad = 0.9 rad", "reversed"],
        ),
        (with("[tank.thrust]\nrest_speed_rad_s = -1"), "9", &["[tank.thrust] rest_speed_rad_s = -1 rad/s"]),
        (
            with("[planner]\nepochs = -1"),
            "9",
            &["[planner] epochs = -1: must be a whole number from 0 to 4294967295"],
        ),
        (with("[timing]\njoin_s = 0"), "9", &["[timing] join_s = 0 s", "between 0.1 and 3600"]),
        (with("[start]\ntail_rad = inf"), "9", &["[start] tail_rad = inf rad"]),
        (with("[radio]\nloss = 1.5"), "9", &["[radio] loss = 1.5", "between 0 and 1"]),
        (GOOD.replace("= 6", "= \"long\""), "5", &["[[leg]] 1: duration_s = \"long\": must be a number"]),
        (GOOD.replace("[0.04, 0]", "0.04"), "6", &["[[leg]] 1: velocity_m_s = 0.04: must be a list of 2"]),
        (
            GOOD.replace("[0.04, 0]", "[0.04, 0, 1]"),
            "6",
            &["velocity_m_s = [0.04, 0, 1]: a list of 3 where 2 are asked for"],
        ),
        (
            GOOD.replace("[0.04, 0]", "[0.04]"),
            "6",
            &["velocity_m_s = [0.04]: a list of 1 where 2 are asked for"],
        ),
        (
            shaped("cells = [\n[0,0],\n[1,0,0]]"),
            "5",
            &["[structure] cells[1] = [1,0,0]: a list of 3 where 2 are asked for"],
        ),
        (
            with("[planner]\nweights = [1, 1, 10, 1]"),
            "9",
            &["[planner] weights = [1, 1, 10, 1]: a list of 4 where 3 are"],
        ),
        (GOOD.replace("= 6", "= -6"), "5", &["[[leg]] 1: duration_s = -6 s"]),
        (
            with("[[leg]]\nduration_s = 1\nvelocity_m_s = [99, 0]\nheading_rad = 0"),
            "10",
            &["[[leg]] 2: velocity_m_s = 99 m/s"],
        ),
        (GOOD.replace("heading_rad = 1.5\n", ""), "4", &["missing field `heading_rad`"]),
        (GOOD[..GOOD.find("[[leg]]").expect("a leg")].to_owned(), "1", &["at least one [[leg]]"]),
        (GOOD.replace("name = \"t\"\n", ""), "1", &["missing field `name`"]),
        (GOOD.replace("\"t\"", "\"../t\""), "1", &["name = \"../t\"", "folder"]),
        (GOOD.replace("\"t\"", "\"\""), "1", &["name = \"\""]),
        (GOOD.replace("\"t\"", "\"a\\u001b[2J\\nb\""), "1", &["name = "]),
        (GOOD.replace("= 6", "= = 6"), "5", &[]),
        (GOOD.replace("[structure]", "[structure"), "2", &[]),
        (format!("{GOOD}x = \"never closed"), "8", &[]),
        (with("\"\\u001b[2J\\n\" = 1"), "8", &["unknown field"]),
        (String::new(), "1", &["missing field"]),
        (shaped("size = \"0x1\""), "3", &["[structure] size", "at least one module"]),
        (shaped("size = \"three\""), "3", &["[structure] size", "\"three\"", "3x1"]),
        (shaped("size = \"3x1x1\""), "3", &["[structure] size", "\"3x1x1\""]),
        (shaped("size = \"99x99\""), "3", &["[structure] size", "9801 modules", "1024"]),
        (shaped("cells = []"), "3", &["[structure] cells", "at least one module"]),
        (shaped("cells = [[0,0],[1,0],[1,0]]"), "3", &["[structure] cells", "[1, 0]", "twice"]),
        (shaped("cells = [[0,0],[2,0]]"), "3", &["[structure] cells", "pieces", "[2, 0]"]),
        (shaped("cells = [[0,0],[1,1]]"), "3", &["pieces", "[1, 1]"]),
        (shaped("cells = [[0,0],[2147483647,0]]"), "3", &["[structure] cells", "[2147483647, 0]", "10000"]),
        (
            shaped("cells = [[0,0],[2147483648,0]]"),
            "3",
            &["[structure] cells[1][0] = 2147483648: must be a whole number from -2147483648"],
        ),
        (shaped("picture = \"\"\"\n##.##\n##.##\n\"\"\""), "3", &["[structure] picture", "pieces"]),
        (shaped("picture = \"#o#\""), "3", &["[structure] picture", "line 1, column 2: 'o'"]),
        (shaped("picture = \"...\""), "3", &["[structure] picture", "at least one module"]),
        (shaped("picture = \"#\"\nsize = \"1x1\""), "2", &["exactly one of size, cells and picture"]),
        (shaped(""), "2", &["exactly one of size, cells and picture"]),
        (shaped("size = 3"), "3", &["[structure] size = 3: must be a text in quotes"]),
    ];
    for (text, line, expected) in cases {
        let folder = with_scenario(&text);
        // Shown if one of the assertions in it fails.
        println!("{text}\n----");
        let said = refused(folder.path(), &["run", "t.toml"]);
        assert!(said.starts_with(&format!("t.toml:{line}: ")), "{said}\nexpected line {line} of\n{text}");
        for &part in expected {
            assert!(said.contains(part), "{said}\ndoes not say {part:?} of\n{text}");
        }
        assert!(!said.contains('\u{1b}'), "{said:?}");
        assert_left_alone(folder.path());
    }
}

/// A ring of modules may have a hole: only pieces are refused. The counterpart of the cases above.
#[test]
fn a_hole_that_cuts_nothing_off_is_a_structure() {
    let folder = with_scenario(
        GOOD.replace("size = \"3x1\"", "picture = \"\"\"\n###\n#.#\n###\"\"\"").replace("= 6", "= 0.5"),
    );
    let finished = Process::start(folder.path(), &["run", "t.toml"]).finish();
    assert_eq!(finished.code, Some(0), "{finished:?}");
}

#[test]
fn what_is_no_scenario_file_is_named() {
    let folder = with_scenario(b"name = \"t\"\n\xff\xfe\n");
    std::fs::create_dir(folder.path().join("d")).expect("a folder");
    for (name, expected) in [
        ("t.toml", "t.toml:2: is not a text in UTF-8"),
        ("d", "d: Is a directory"),
        (
            "holonomic-5",
            "holonomic-5: no such file, and no built-in scenario of that name (there are holonomic-1, ",
        ),
        ("", ": no such file"),
        ("t.toml/x", "t.toml/x: "),
        ("/dev/zero", "/dev/zero: is longer than"),
    ] {
        for command in
            [&["run", name][..], &["plan", "--scenario", name], &["module", "--id", "1", "--scenario", name]]
        {
            let said = refused(folder.path(), command);
            assert!(said.starts_with(expected), "{command:?}: {said}");
        }
    }
}

/// A byte order mark, Windows line ends and whole numbers are no mistakes.
#[test]
fn what_editors_do_is_no_mistake() {
    let folder = with_scenario(format!("\u{feff}{}", GOOD.replace('\n', "\r\n").replace("= 6", "= 1")));
    let finished = Process::start(folder.path(), &["run", "t.toml"]).finish();
    assert_eq!(finished.code, Some(0), "{finished:?}");
}

/// The usage errors are the argument parser's: more than one line, but the same exit code.
#[test]
fn wrong_usage_has_exit_code_two() {
    let folder = tempdir().expect("a folder");
    for arguments in [
        &[][..],
        &["swim"],
        &["run", "--radio", "smoke"],
        &["run", "--planner", "best"],
        &["run", "--seed", "-1"],
        &["run", "--loss", "much"],
        &["run", "--out", ""],
        &["run", "one", "two"],
        &["plan", "--planner", "best"],
        &["plan", "request.json"],
        &["module"],
        &["module", "--id", "0"],
        &["module", "--id", "1025"],
        &["module", "--id", "-1"],
        &["module", "--id", "one"],
    ] {
        let finished = Process::start(folder.path(), arguments).finish();
        assert_eq!(finished.code, Some(2), "{arguments:?}: {finished:?}");
        assert!(finished.out.is_empty(), "{arguments:?}: {finished:?}");
        assert!(!finished.err.concat().contains("panicked"), "{finished:?}");
        assert_left_alone(folder.path());
    }
}

#[test]
fn options_that_cannot_be_are_named_with_their_value() {
    let folder = with_key(GOOD);
    for (arguments, expected) in [
        (&["run", "--loss", "1.5"][..], "--loss: loss = 1.5"),
        (&["run", "--loss", "nan"], "--loss: loss = NaN"),
        (&["run", "--loss=-0.1"], "--loss: loss = -0.1"),
        (&["run", "--radio", "udp", "--listen", "nonsense"], "cannot listen on UDP nonsense: "),
        (&["run", "--radio", "udp", "--listen", "127.0.0.1:99999"], "cannot listen on UDP 127.0.0.1:99999: "),
        (&["run", "--radio", "udp", "--listen", "192.0.2.1:0"], "cannot listen on UDP 192.0.2.1:0: "),
        (&["module", "--id", "1", "--host", "nonsense"], "--host nonsense: "),
        (&["module", "--id", "1", "--host", "127.0.0.1"], "--host 127.0.0.1: "),
        (&["module", "--id", "1", "--host", "127.0.0.1:0"], "--host 127.0.0.1:0: "),
        (&["module", "--id", "1", "--listen", "nonsense"], "cannot listen on UDP nonsense: "),
        (&["module", "--id", "1", "--duration", "nan"], "--duration = NaN s: "),
        (&["module", "--id", "1", "--duration", "0"], "--duration = 0 s: "),
        (&["module", "--id", "4", "--scenario", "t.toml"], "--id 4: there are only 3 modules in t.toml"),
    ] {
        let said = refused(folder.path(), &keyed(arguments));
        assert!(said.starts_with(expected), "{arguments:?}: {said}");
        assert_left_alone(folder.path());
    }
}

/// No program talks on a radio without a key, or with another's.
#[test]
fn a_key_that_cannot_be_is_named() {
    let folder = with_key(GOOD);
    let made = Process::start(folder.path(), &["keygen", "--module", "2", "--from", KEY, "--out", "t.key"]);
    assert_eq!(made.finish().code, Some(0));
    for (arguments, expected) in [
        (&["run", "--radio", "udp", "--key", "none.key"][..], "none.key: no such key file"),
        (&["module", "--id", "1", "--key", "none.key"], "none.key: no such key file"),
        (&["run", "--radio", "udp", "--key", "t.toml"], "t.toml: mode 0644 lets others"),
        // A module's key makes no host, and no other module.
        (&["run", "--radio", "udp", "--key", "t.key"], "t.key: is the key of module 2 alone"),
        (&["module", "--id", "1", "--key", "t.key"], "t.key: is the key of module 2, not of module 1"),
    ] {
        let said = refused(folder.path(), arguments);
        assert!(said.starts_with(expected), "{arguments:?}: {said}");
    }
    std::fs::remove_file(folder.path().join("t.key")).expect("a file");
    assert_left_alone(folder.path());
}

/// The places of a structure need modules of the roster.
#[test]
fn a_roster_that_does_not_fit_is_named() {
    let folder = with_key(GOOD);
    let roster = folder.path().join("r.toml");
    let arguments = ["run", "t.toml", "--radio", "udp", "--listen", "127.0.0.1:0", "--roster", "r.toml"];
    for (text, expected) in [
        (
            "name = \"r\"\n[[module]]\nid = 4\n[[module]]\nid = 2\n",
            "roster \"r\" has 2 Modboats for 3 places",
        ),
        (
            "[[module]]\nid = 4\n[[module]]\nid = 4\n",
            "r.toml:4: [[module]] 2: id = 4: [[module]] 1 has it already",
        ),
        ("[[module]]\nid = 0\n", "r.toml:2: [[module]] 1: id = 0: must be from 1 to 1024"),
        ("name = \"r\"\n[[module]]\nid = 1\ncell = [0, 0]\n", "roster \"r\" has no module for cell [1, 0]"),
    ] {
        std::fs::write(&roster, text).expect("a file");
        let said = refused(folder.path(), &keyed(&arguments));
        assert!(said.starts_with(expected), "{said}\nexpected {expected}");
    }
    std::fs::remove_file(roster).expect("a file");
    let said = refused(folder.path(), &keyed(&arguments));
    assert!(said.starts_with("r.toml: no such file"), "{said}");
    assert_left_alone(folder.path());
}

/// Tests may run as root, to whom permissions mean nothing: below a file and in /proc no user can write.
#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let folder = with_scenario(GOOD);
    for out in ["t.toml/results", "t.toml", "/proc/flotilla"] {
        let said = refused(folder.path(), &["run", "t.toml", "--out", out]);
        assert!(said.starts_with(&format!("cannot write to {out}: ")), "{said}");
        assert_left_alone(folder.path());
    }
    // The default folder has nowhere to be.
    std::fs::write(folder.path().join("runs"), "").expect("a file");
    let said = refused(folder.path(), &["run", "t.toml"]);
    assert!(said.starts_with("cannot write to runs/t: "), "{said}");
}

/// Of Modboats and of ROVs.
#[test]
fn a_tank_cannot_end_before_it_begins() {
    let folder = tempdir().expect("a folder");
    for scenario in ["holonomic-1", "i-to-l"] {
        for seconds in ["0", "-1", "NaN", "100000000"] {
            let said = refused(folder.path(), &["tank", scenario, &format!("--duration={seconds}")]);
            assert_eq!(
                said,
                format!("--duration = {seconds} s: must lie between 0 and 10000000"),
                "{scenario}"
            );
        }
    }
}

#[test]
fn a_busy_port_is_named() {
    let folder = with_key(GOOD);
    let taken = UdpSocket::bind("127.0.0.1:0").expect("a port");
    let address = taken.local_addr().expect("an address").to_string();
    let said = refused(folder.path(), &keyed(&["run", "t.toml", "--radio", "udp", "--listen", &address]));
    assert!(said.starts_with(&format!("cannot listen on UDP {address}: Address already in use")), "{said}");
    assert_left_alone(folder.path());
    let said = refused(folder.path(), &keyed(&["module", "--id", "1", "--listen", &address]));
    assert!(said.starts_with(&format!("cannot listen on UDP {address}: Address already in use")), "{said}");
}

#[test]
fn no_module_answers() {
    let folder = with_key(format!("{GOOD}[timing]\njoin_s = 1\n"));
    let free = format!("127.0.0.1:{}", port());
    let said = refused(folder.path(), &keyed(&["run", "t.toml", "--radio", "udp", "--listen", &free]));
    let expected = format!(
        "modules 1, 2, 3 did not answer within 1 s \
         (start it with: flotilla module --id 1 --host {free} --scenario t.toml --key fleet.key)"
    );
    assert_eq!(said, expected);
    assert_left_alone(folder.path());
    // The same over a medium that lets nothing through.
    let said = refused(folder.path(), &["run", "t.toml", "--loss", "1"]);
    assert_eq!(said, "modules 1, 2, 3 did not answer within 1 s");
    assert_left_alone(folder.path());
}

#[test]
fn one_module_of_three_never_answers() {
    let folder = with_key(format!("{GOOD}[timing]\njoin_s = 5\n"));
    let arguments = ["run", "t.toml", "--radio", "udp", "--listen", "127.0.0.1:0"];
    let run = Process::start(folder.path(), &keyed(&arguments));
    // The system chose the port, so it is told.
    let first = run.err.recv_timeout(PATIENCE).expect("a line");
    let host =
        first.strip_prefix("listening on ").and_then(|rest| rest.split_once(' ')).expect("an address").0;
    let _modules = ["1", "2"].map(|id| {
        let arguments = ["module", "--id", id, "--host", host, "--scenario", "t.toml", "--duration", "60"];
        Process::start(folder.path(), &keyed(&arguments))
    });
    let said = refusal(&run.finish()).to_owned();
    assert!(
        said.starts_with("module 3 did not answer within 5 s (start it with: flotilla module --id 3 "),
        "{said}"
    );
    assert_left_alone(folder.path());
}

/// One that has another fleet's key is named as that, and not taken in.
#[test]
fn a_module_of_another_fleet_is_not_taken_in() {
    let folder = with_key(format!("{GOOD}[timing]\njoin_s = 5\n"));
    let others = tempdir().expect("a folder");
    keygen(others.path());
    let other = others.path().join(KEY).display().to_string();
    let arguments = ["run", "t.toml", "--radio", "udp", "--listen", "127.0.0.1:0"];
    let run = Process::start(folder.path(), &keyed(&arguments));
    let first = run.err.recv_timeout(PATIENCE).expect("a line");
    let host =
        first.strip_prefix("listening on ").and_then(|rest| rest.split_once(' ')).expect("an address").0;
    let _modules = [("1", KEY), ("2", KEY), ("3", &other)].map(|(id, key)| {
        let arguments = ["module", "--id", id, "--host", host, "--scenario", "t.toml", "--duration", "60"];
        Process::start(folder.path(), &[&arguments[..], &["--key", key]].concat())
    });
    let said = refusal(&run.finish()).to_owned();
    assert_eq!(said, "module 3 seems to have another fleet's key");
    assert_left_alone(folder.path());
}
