//! Every kind of file that a person writes, with every kind of mistake that a reader of files finds: the exact line.

use std::fs;

use tempfile::tempdir;

use super::{GOOD, refusal};
use crate::common::Process;
use crate::keys::{KEY, keygen};

/// A byte order mark.
const MARK: &str = "\u{feff}";

/// A reconfiguration without a mistake; line 3 is the robot's id, 5 its start, 7 the slot.
const RECONFIGURATION: &str = "name = \"t\"\n[[robot]]\nid = 1\nvehicle = \"bluerov1\"\nstart = [0, 0, 1, 0]\n\
                               [[slot]]\npose = [0.6, 0, 1, 0]\n";
/// A vehicle without a mistake; line 3 is its mass, 6 and 7 are its thruster.
const VEHICLE: &str = "name = \"v\"\nbox_m = [0.4, 0.3, 0.2]\nmass_kg = 4\ninertia_kg_m2 = [0.1, 0.1, 0.1]\n\
                       [[thrusters]]\nposition_m = [0, 0, 0]\ndirection = [1, 0, 0]\n";
/// A module without a mistake; line 4 is the only number.
const MODULE: &str = "[network]\nhost = \"192.168.4.1:4870\"\n[modboat.encoder]\ncounts_per_turn = 4800\n";
/// A roster without a mistake; line 3 is the first module's id, 6 the second's.
const ROSTER: &str = "name = \"r\"\n[[module]]\nid = 1\ncell = [0, 0]\n[[module]]\nid = 2\ncell = [1, 0]\n";

/// One mistake: what is replaced by what, and what is said after the name of the file.
type Mistake<'a> = (&'a str, &'a str, &'a str);

/// Each mistake in `good` is refused in exactly one line; and so it is behind a byte order mark.
fn refuses(file: &str, good: &str, others: &[(&str, &str)], arguments: &[&str], mistakes: &[Mistake<'_>]) {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    for (name, text) in others {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    for (from, to, expected) in mistakes {
        assert!(good.contains(from), "{from}");
        let text = good.replacen(from, to, 1);
        for text in [text.clone(), format!("{MARK}{text}")] {
            fs::write(folder.path().join(file), &text).expect("a file");
            let finished = Process::given(folder.path(), arguments, "");
            assert_eq!(refusal(&finished), format!("{file}:{expected}"), "{text}");
        }
    }
}

/// The same text with a mark, and with whole numbers that have a point, does what it does without.
fn takes(
    file: &str,
    good: &str,
    others: &[(&str, &str)],
    arguments: &[&str],
    pointed: &[(&str, &str)],
    input: &str,
) {
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    for (name, text) in others {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    let mut said = Vec::new();
    let with_points = pointed.iter().fold(good.to_owned(), |text, (whole, point)| {
        assert!(text.contains(whole), "{whole}");
        text.replacen(whole, point, 1)
    });
    for text in [good.to_owned(), format!("{MARK}{with_points}")] {
        fs::write(folder.path().join(file), &text).expect("a file");
        let finished = Process::given(folder.path(), arguments, input);
        assert_eq!(finished.code, Some(0), "{text}\n{finished:?}");
        said.push(finished.out);
    }
    assert!(said[0] == said[1], "{said:?}");
}

#[test]
fn a_scenario() {
    refuses(
        "t.toml",
        GOOD,
        &[],
        &["run", "t.toml"],
        &[
            (
                "name",
                "nmae",
                "1: unknown field `nmae`, expected one of `name`, `description`, `seed`, `structure`, `leg`, `start`, `modboat`, `planner`, `control`, `observer`, `timing`, `pose`, `bounds`, `tank`, `motor`, `clock`, `mocap`, `radio`; did you mean `name`?",
            ),
            (
                "heading_rad",
                "heading",
                "7: [[leg]] 1: unknown field `heading`, expected one of `duration_s`, `velocity_m_s`, `position_m`, `heading_rad`; did you mean `heading_rad`?",
            ),
            ("= 6", "= \"6 s\"", "5: [[leg]] 1: duration_s = \"6 s\": must be a number"),
            ("[0.04, 0]", "[0.04, \"0\"]", "6: [[leg]] 1: velocity_m_s[1] = \"0\": must be a number"),
            (
                "1.5\n",
                "1.5\n[planner]\nepochs = 4.5\n",
                "9: [planner] epochs = 4.5: must be a whole number from 0 to 4294967295",
            ),
            (
                "1.5\n",
                "1.5\n[planner]\nkind = \"exat\"\n",
                "9: [planner] kind = \"exat\": unknown name, expected `exact` or `potential-field`; did you mean `exact`?",
            ),
            (
                "1.5\n",
                "1.5\n[tank.thrust]\nrest = 1\n",
                "9: [tank.thrust] unknown field `rest`, expected `rest_speed_rad_s`",
            ),
            (
                "1.5\n",
                "1.5\n[motor]\nreset_brakes = 1\n",
                "9: [motor] reset_brakes = 1: must be true or false",
            ),
            (
                "[structure]",
                "seed = -1\n[structure]",
                "2: seed = -1: must be a whole number, zero or greater",
            ),
            ("[structure]", "motor = 3\n[structure]", "2: motor = 3: must be a table of keys and values"),
            ("[[leg]]", "[leg]", "4: leg: must be a list"),
            ("heading_rad", "duration_s", "7: duplicate key `duration_s`"),
        ],
    );
}

#[test]
fn a_reconfiguration() {
    let arguments = ["reconfigure", "t.toml", "--criterion", "energy", "--json"];
    refuses(
        "t.toml",
        RECONFIGURATION,
        &[],
        &arguments,
        &[
            (
                "start",
                "strat",
                "5: [[robot]] 1: unknown field `strat`, expected one of `id`, `vehicle`, `start`, `capabilities`, `failed`; did you mean `start`?",
            ),
            (
                "bluerov1",
                "bluerov",
                "4: [[robot]] 1: vehicle = \"bluerov\": no such file, and no built-in vehicle of that name (there are bluerov1, bluerov2, bluerov2-heavy, tool-20n; did you mean bluerov1?)",
            ),
            ("id = 1", "id = 1.5", "3: [[robot]] 1: id = 1.5: must be a whole number from 0 to 65535"),
            (
                "[0, 0, 1, 0]",
                "[0, 0, 1]",
                "5: [[robot]] 1: start = [0, 0, 1]: a list of 3 where 4 are asked for",
            ),
            (
                "1, 0]\n[[",
                "1, 0]\n[rules]\nbounds_m = [[0, 0, 0], [1, 1]]\n[[",
                "7: [rules] bounds_m[1] = [1, 1]: a list of 2 where 3 are asked for",
            ),
            (
                "1, 0]\n[[",
                "1, 0]\n[rules]\nbattery_v = 9\n[[",
                "7: [rules] battery_v = 9 V: the table of the thrusters covers 10 to 20 V",
            ),
        ],
    );
    let pointed = [("id = 1", "id = 1.0"), ("[0, 0, 1, 0]", "[0.0, 0, 1.0, 0]")];
    takes("t.toml", RECONFIGURATION, &[], &arguments, &pointed, "");
}

#[test]
fn a_vehicle() {
    let keys = "`name`, `box_m`, `mass_kg`, `weight_in_water_n`, `r_g_m`, `r_b_m`, `inertia_kg_m2`, `added_mass`, `linear_damping`, `quadratic_damping`, `thrusters`, `connectors`, `capabilities`";
    let unknown = |key: &str, near: &str| {
        format!("unknown field `{key}`, expected one of {keys}; did you mean `{near}`?")
    };
    refuses(
        "v.toml",
        VEHICLE,
        &[],
        &["simulate", "v.toml"],
        &[
            ("mass_kg", "mass", &format!("3: {}", unknown("mass", "mass_kg"))),
            ("thrusters", "thruster", &format!("5: {}", unknown("thruster", "thrusters"))),
            ("= 4", "= \"4 kg\"", "3: mass_kg = \"4 kg\": must be a number"),
            ("= 4", "= -4", "3: mass_kg = -4 kg: must be a finite number greater than zero"),
            ("mass_kg = 4\n", "", "1: missing field `mass_kg`"),
            (
                "[0, 0, 0]",
                "[0, 0]",
                "6: [[thrusters]] 1: position_m = [0, 0]: a list of 2 where 3 are asked for",
            ),
            (
                "direction",
                "directon",
                "7: [[thrusters]] 1: unknown field `directon`, expected one of `position_m`, `direction`, `reversed`, `failed`; did you mean `direction`?",
            ),
            ("[[", "capabilities = [\"sonar\", 3]\n[[", "5: capabilities[1] = 3: must be a text in quotes"),
        ],
    );
    let request = "{\"eta\":[0,0,0,0,0,0],\"nu\":[0,0,0,0,0,0],\"tau\":[10,0,0,0,0,0],\"at_s\":[1]}\n";
    let pointed = [("= 4", "= 4.0"), ("[0, 0, 0]", "[0.0, 0, 0]")];
    takes("v.toml", VEHICLE, &[], &["simulate", "v.toml"], &pointed, request);
}

#[test]
fn a_module() {
    let arguments = ["provision", "--id", "3", "--from", "m.toml", "--key", KEY, "--out", "m.bin", "--force"];
    refuses(
        "m.toml",
        MODULE,
        &[],
        &arguments,
        &[
            ("4800", "4800.5", "4: [modboat.encoder] counts_per_turn = 4800.5: must be a whole number"),
            (
                "4800",
                "-1.0",
                "4: [modboat.encoder] counts_per_turn = -1: must be a whole number from 0 to 16777216",
            ),
            (
                "counts_per_turn",
                "counts",
                "4: [modboat.encoder] unknown field `counts`, expected one of `counts_per_turn`, `zero_counts`, `reversed`, `homing_speed_rad_s`, `homing_after_s`; did you mean `counts_per_turn`?",
            ),
            (
                "modboat",
                "modbot",
                "3: unknown field `modbot`, expected one of `network`, `report`, `supply`, `modboat`, `rov`; did you mean `modboat`?",
            ),
            ("[mod", "[report]\nevery_ms = \"20\"\n[mod", "4: [report] every_ms = \"20\": must be a number"),
            (
                "[mod",
                "[rov]\n[[rov.thruster]]\noutput = 0\n[[rov.thruster]]\n[mod",
                "6: [[rov.thruster]] 2: missing field `output`",
            ),
        ],
    );
    takes("m.toml", MODULE, &[], &arguments, &[("4800", "4800.0")], "");
}

#[test]
fn a_roster() {
    let scenario = format!("{}[timing]\njoin_s = 0.2\n", GOOD.replace("3x1", "2x1"));
    let others = [("t.toml", scenario.as_str())];
    let arguments =
        ["run", "t.toml", "--radio", "udp", "--listen", "127.0.0.1:0", "--roster", "r.toml", "--key", KEY];
    refuses(
        "r.toml",
        ROSTER,
        &others,
        &arguments,
        &[
            ("id = 2", "id = 2.5", "6: [[module]] 2: id = 2.5: must be a whole number"),
            (
                "id = 2",
                "number = 2",
                "6: [[module]] 2: unknown field `number`, expected one of `id`, `name`, `kind`, `cell`, `body`, `body_offset_m`, `body_turn_rad`",
            ),
            (
                "id = 2",
                "id = 2\nkind = \"modbot\"",
                "7: [[module]] 2: kind = \"modbot\": unknown name, expected `modboat` or `rov`; did you mean `modboat`?",
            ),
            (
                "[1, 0]",
                "[1, 0.5]",
                "7: [[module]] 2: cell[1] = 0.5: must be a whole number from -2147483648 to 2147483647",
            ),
            ("id = 2", "id = 1.0", "6: [[module]] 2: id = 1: [[module]] 1 has it already"),
        ],
    );
    // Taken, and then no module answers.
    let folder = tempdir().expect("a folder");
    keygen(folder.path());
    fs::write(folder.path().join("t.toml"), &scenario).expect("a file");
    fs::write(folder.path().join("r.toml"), format!("{MARK}{}", ROSTER.replace("id = 2", "id = 2.0")))
        .expect("a file");
    let finished = Process::given(folder.path(), &arguments, "");
    assert_eq!(finished.code, Some(2), "{finished:?}");
    let said = finished.err.last().expect("a line");
    assert!(said.starts_with("flotilla: modules 1, 2 did not answer within 0.2 s"), "{said}");
}

#[test]
fn a_plan() {
    let folder = tempdir().expect("a folder");
    fs::write(folder.path().join("t.toml"), RECONFIGURATION).expect("a file");
    let planned =
        Process::given(folder.path(), &["reconfigure", "t.toml", "--criterion", "energy", "--json"], "");
    // One key a line, so that lines tell something.
    let plan = planned.out[0].replace(",\"", ",\n\"");
    let line = |key: &str| plan.lines().position(|line| line.contains(key)).expect(key) + 1;
    let others = [("t.toml", RECONFIGURATION)];
    let arguments = ["reconfigure", "t.toml", "--verify", "p.json"];
    let top = "`problem`, `criterion`, `manner`, `robots`, `slots`, `moves`, `intervals`, `energy_navigate_j`, `energy_balance_j`, `energy_total_j`, `time_s`, `lower_bound_j`, `gap`, `proved`";
    let mistakes = [
        (
            "\"slot\":0",
            "\"slot\":0.5",
            "\"slot\"",
            "moves[0].slot = 0.5: must be a whole number, zero or greater",
        ),
        (
            "\"leg\"",
            "\"legg\"",
            "\"leg\"",
            "moves[0].actions[1].kind = \"legg\": unknown name, expected one of `undock`, `turn`, `leg`, `dock`; did you mean `leg`?",
        ),
        (
            "\"acceleration\"",
            "\"accelaration\"",
            "\"acceleration\"",
            "moves[0].actions[0]: unknown field `accelaration`, expected one of `kind`, `start_s`, `duration_s`, `from`, `to`, `speed`, `acceleration`, `energy_j`; did you mean `acceleration`?",
        ),
        (
            "\"time_s\"",
            "\"time\"",
            "\"time_s\"",
            &format!("unknown field `time`, expected one of {top}; did you mean `time_s`?"),
        ),
        (
            "\"balance_w\":0.0",
            "\"balance_w\":\"0 W\"",
            "\"balance_w\"",
            "moves[0].balance_w = \"0 W\": must be a number",
        ),
    ];
    let mistakes =
        mistakes.map(|(from, to, key, said)| (from, to, format!("{}: not a plan: {said}", line(key))));
    let mistakes: Vec<Mistake<'_>> =
        mistakes.iter().map(|(from, to, said)| (*from, *to, said.as_str())).collect();
    refuses("p.json", &plan, &others, &arguments, &mistakes);
    let pointed = [("\"slot\":0", "\"slot\":0.0"), ("\"balance_w\":0.0", "\"balance_w\":0")];
    takes("p.json", &plan, &others, &arguments, &pointed, "");
}

#[test]
fn requests() {
    let folder = tempdir().expect("a folder");
    let good = "{\"cells\":[[0,0],[1.0,0]],\"demand\":{\"fx_n\":0,\"fy_n\":0.01,\"tau_nm\":0}}";
    let answer = Process::given(folder.path(), &["plan"], &format!("{MARK}{good}\n"));
    assert_eq!((answer.code, answer.out.len()), (Some(0), 1), "{answer:?}");
    let body = "{\"eta\":[0,0,0,0,0,0],\"nu\":[0,0,0,0,0,0],\"tau\":[0,0,0,0,0,0],\"at_s\":[],\"vehicle\":";
    for (command, request, expected) in [
        (
            "plan",
            good.replace("1.0", "1.5"),
            "column 18: cells[1][0] = 1.5: must be a whole number from -2147483648 to 2147483647",
        ),
        (
            "plan",
            good.replace("cells", "cell"),
            "column 2: unknown field `cell`, expected one of `cells`, `demand`, `tail_rad`; did you mean `cells`?",
        ),
        (
            "plan",
            good.replace("}}", "},\"tail_rad\":\"next\"}"),
            "column 80: tail_rad = \"next\": must be a list of angles, null or \"previous\"",
        ),
        (
            "simulate",
            format!("{body}\"bluerov\"}}"),
            "column 81: vehicle = \"bluerov\": there are bluerov1, bluerov2, bluerov2-heavy, tool-20n; did you mean bluerov1?",
        ),
        ("simulate", format!("{body}3}}"), "column 81: vehicle = 3: must be a name or an object"),
        (
            "simulate",
            format!("{body}{{\"mass_kg\":\"4 kg\"}}}}"),
            "column 92: vehicle.mass_kg = \"4 kg\": must be a number",
        ),
    ] {
        let finished = Process::given(folder.path(), &[command], &format!("{request}\n"));
        assert_eq!(finished.err, [format!("flotilla: line 1: {expected}")], "{request}");
        assert_eq!(finished.code, Some(2));
    }
}

#[test]
fn maps_may_have_a_mark() {
    let folder = tempdir().expect("a folder");
    let map = format!("{MARK}type octile\nheight 3\nwidth 3\nmap\n...\n...\n...\n");
    fs::write(folder.path().join("m.map"), map).expect("a file");
    let finished =
        Process::given(folder.path(), &["path", "m.map", "--from", "0,0", "--to", "2,2", "--json"], "");
    assert_eq!((finished.code, finished.out.len()), (Some(0), 1), "{finished:?}");
}
