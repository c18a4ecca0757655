//! Reconfiguration scenarios: a problem from a TOML file. A mistake in one is reported with its file, line and value.

use std::path::Path;

use quantity::bounds::Bounds;
use reader::file::{self, Source, WRITTEN_MAX, text_of};
use reader::{Document, FileError, Mistake};
use reconfiguration::pose::Pose;
use reconfiguration::problem::{Problem, Robot, Rules, Slot, Tool};
use reconfiguration::vehicle::{self, Vehicle};
use rov::conditions::{Conditions, Place, ProblemError};
use serde::Deserialize;

use super::super::scenario::{PoseParameters, sound, unfit};

/// The reconfigurations that come with the program, by name.
pub const BUILT_IN: [(&str, &str); 4] = [
    ("t-to-i-far", include_str!("../../../scenarios/reconfigure/t-to-i-far.toml")),
    ("t-to-i-below", include_str!("../../../scenarios/reconfigure/t-to-i-below.toml")),
    ("i-to-l", include_str!("../../../scenarios/reconfigure/i-to-l.toml")),
    ("sonar-to-bow", include_str!("../../../scenarios/reconfigure/sonar-to-bow.toml")),
];

/// No scenario has more robots, or more tools, or more slots; *assumed*.
const BODIES_MAX: usize = 1000;

/// Everything that planning and executing a reconfiguration needs to know.
#[derive(Clone, Debug, PartialEq)]
pub struct ReconfigureScenario {
    /// What is to be planned; it has passed [`Problem::check`].
    pub problem: Problem,
    /// Seed of everything random in its execution.
    pub seed: u64,
    /// Poses from a motion capture.
    pub pose: PoseParameters,
}

/// The file's own shape; [`ReconfigureScenario`] is what becomes of it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    name: String,
    #[serde(default)]
    description: String,
    #[serde(default = "one")]
    seed: u64,
    #[serde(rename = "robot", default)]
    robots: Vec<RobotTable>,
    #[serde(rename = "tool", default)]
    tools: Vec<ToolTable>,
    #[serde(rename = "slot", default)]
    slots: Vec<SlotTable>,
    #[serde(default)]
    rules: Rules,
    bounds: Option<Bounds>,
    #[serde(default)]
    pose: PoseParameters,
}

const fn one() -> u64 {
    1
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotTable {
    id: u16,
    vehicle: String,
    start: Pose,
    #[serde(default)]
    capabilities: Vec<String>,
    /// Thrusters out of order, from 1.
    #[serde(default)]
    failed: Vec<usize>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ToolTable {
    vehicle: String,
    pose: Pose,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SlotTable {
    pose: Pose,
    #[serde(default)]
    requires: Vec<String>,
}

impl ReconfigureScenario {
    /// Reads a scenario file, or takes the built-in one of that name.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn open(name: &str) -> Result<Self, FileError> {
        let Source { file, folder, text } = file::open(name, "reconfiguration", &BUILT_IN)?;
        Self::parse(&file, &text, &folder)
    }

    /// Reads a scenario from `text`; `file` is its name in error messages, and files of vehicles are looked for in
    /// `folder`.
    ///
    /// # Errors
    /// [`FileError`], of a file of a vehicle too.
    pub fn parse(file: &str, text: &str, folder: &Path) -> Result<Self, FileError> {
        let invalid = |mistake: Mistake| mistake.in_file(file);
        let document = Document::toml(text).map_err(invalid)?;
        let tables: Tables = document.read().map_err(invalid)?;
        let at = |path: &[&str], message: String| invalid(document.mistake(path, message));
        if let Some(message) = unfit(&tables.name) {
            return Err(at(&["name"], message));
        }
        for (key, count) in
            [("robot", tables.robots.len()), ("tool", tables.tools.len()), ("slot", tables.slots.len())]
        {
            if count > BODIES_MAX {
                return Err(at(&[key], format!("{count} times [[{key}]]: at most {BODIES_MAX}")));
            }
        }

        // A robot with a thruster out of order is a kind of its own.
        let mut known: Vec<((String, Vec<usize>), Vehicle)> = Vec::new();
        let mut kind =
            |table: &str, index: usize, name: &str, mut failed: Vec<usize>| -> Result<usize, FileError> {
                failed.sort_unstable();
                failed.dedup();
                let key = (name.to_owned(), failed);
                if let Some(kind) = known.iter().position(|(known, _)| *known == key) {
                    return Ok(kind);
                }
                let vehicle = vehicle(name, folder)?.ok_or_else(|| {
                    let known = vehicle::there_are(name);
                    let message = format!(
                        "vehicle = {name:?}: no such file, and no built-in vehicle of that name ({known})"
                    );
                    invalid(document.mistake_in(&[table, &index.to_string()], "vehicle", message))
                })?;
                let (_, failed) = &key;
                let vehicle = without(vehicle, failed).map_err(|message| {
                    invalid(document.mistake_in(&[table, &index.to_string()], "failed", message))
                })?;
                known.push((key, vehicle));
                Ok(known.len() - 1)
            };
        let mut robots = Vec::new();
        for (index, robot) in tables.robots.into_iter().enumerate() {
            let RobotTable { id, vehicle, start, capabilities, failed } = robot;
            let vehicle = kind("robot", index, &vehicle, failed)?;
            robots.push(Robot { id, vehicle, start, capabilities });
        }
        let mut tools = Vec::new();
        for (index, tool) in tables.tools.into_iter().enumerate() {
            tools.push(Tool { vehicle: kind("tool", index, &tool.vehicle, Vec::new())?, pose: tool.pose });
        }
        let vehicles: Vec<Vehicle> = known.into_iter().map(|(_, vehicle)| vehicle).collect();
        for robot in &mut robots {
            robot.capabilities.extend(vehicles[robot.vehicle].capabilities.iter().cloned());
        }
        let slots =
            tables.slots.into_iter().map(|SlotTable { pose, requires }| Slot { pose, requires }).collect();
        let Tables { name, description, seed, rules, bounds, pose, .. } = tables;
        if let Some(bounds) = &bounds {
            sound(&document, bounds).map_err(invalid)?;
        }
        let problem = Problem { name, description, vehicles, robots, tools, slots, rules, bounds };
        problem.check().map_err(|error| {
            let path = key(&error, &problem);
            let path: Vec<&str> = path.iter().map(String::as_str).collect();
            at(&path, error.to_string())
        })?;
        pose.validate().map_err(|error| at(&["pose", error.key], format!("[pose] {error}")))?;
        Ok(Self { problem, seed, pose })
    }
}

/// What a refusal speaks of, as keys of the file.
fn key(error: &ProblemError, problem: &Problem) -> Vec<String> {
    use ProblemError as E;
    let robot = |id: u16| problem.robots.iter().rposition(|robot| robot.id == id).unwrap_or(0);
    let keys =
        |table: &str, index: usize, key: &str| vec![table.to_owned(), index.to_string(), key.to_owned()];
    let place = |place: Place| match place {
        Place::Robot(id) => keys("robot", robot(id), "start"),
        Place::Tool(tool) => keys("tool", tool, "pose"),
        Place::Slot(slot) => keys("slot", slot, "pose"),
    };
    match *error {
        E::Rule(ref number) => vec!["rules".to_owned(), number.key.to_owned()],
        E::Edge(_) => vec!["bounds".to_owned(), "edge_m".to_owned()],
        E::Bounds { .. } => vec!["rules".to_owned(), "bounds_m".to_owned()],
        E::Pose { place: of, .. }
        | E::Box { place: of, .. }
        | E::NoSuchVehicle { place: of, .. }
        | E::OutsideWater { place: of, .. }
        | E::NearEdge { place: of, .. }
        | E::SamePlace { second: of, .. }
        | E::Overlap { second: of, .. }
        | E::Unconnected { place: of, .. }
        | E::Apart { second: of, .. } => place(of),
        E::ToolAlone { tool, .. } => place(Place::Tool(tool)),
        E::NoRobots => vec!["robot".to_owned()],
        E::IdZero => keys("robot", robot(0), "id"),
        E::IdTwice { id } => keys("robot", robot(id), "id"),
        E::NoThrusters { id, .. } => keys("robot", robot(id), "vehicle"),
        E::TooFewSlots { .. } | E::NoFit => vec!["slot".to_owned()],
        E::MissingCapability { slot, .. } => keys("slot", slot, "requires"),
        E::NoAssignment { ref robots, .. } => {
            keys("robot", robots.first().map_or(0, |&id| robot(id)), "capabilities")
        }
    }
}

/// The vehicle with those of its thrusters out of order, counted from 1.
fn without(mut vehicle: Vehicle, failed: &[usize]) -> Result<Vehicle, String> {
    let count = vehicle.thrusters.len();
    for &number in failed {
        let thruster = number.checked_sub(1).and_then(|index| vehicle.thrusters.get_mut(index));
        let thruster = thruster
            .ok_or_else(|| format!("failed = {failed:?}: {} has thrusters 1 to {count}", vehicle.name))?;
        thruster.failed = true;
    }
    if !failed.is_empty() {
        let numbers: Vec<String> = failed.iter().map(ToString::to_string).collect();
        let plural = if failed.len() == 1 { "" } else { "s" };
        vehicle.name = format!("{} without thruster{plural} {}", vehicle.name, numbers.join(", "));
    }
    Ok(vehicle)
}

/// The built-in vehicle of that name, or that of a file in `folder`; `None` if there is neither.
fn vehicle(name: &str, folder: &Path) -> Result<Option<Vehicle>, FileError> {
    if let Some(vehicle) = Vehicle::built_in(name) {
        return Ok(Some(vehicle));
    }
    let path = folder.join(name);
    let Some(text) = text_of(&path, WRITTEN_MAX)? else { return Ok(None) };
    Vehicle::parse(&path.display().to_string(), &text).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "name = \"t\"\n[[tool]]\nvehicle = \"tool-20n\"\npose = [0.0, 0.0, 0.0, 0.0]\n\
                        [[robot]]\nid = 1\nvehicle = \"bluerov1\"\nstart = [-0.483, 0.0, 0.0, 0.0]\n\
                        [[slot]]\npose = [0.483, 0.0, 0.0, 0.0]\n";

    #[test]
    fn built_in_reconfigurations_are_sound_and_bear_their_names() {
        let expected =
            [("t-to-i-far", 4, 1), ("t-to-i-below", 4, 1), ("i-to-l", 3, 0), ("sonar-to-bow", 3, 0)];
        assert_eq!(BUILT_IN.map(|(name, _)| name), expected.map(|(name, ..)| name));
        for (name, robots, tools) in expected {
            let ReconfigureScenario { problem, seed, .. } = ReconfigureScenario::open(name).expect(name);
            assert_eq!((problem.name.as_str(), seed), (name, 1));
            assert_eq!(
                (problem.robots.len(), problem.tools.len(), problem.slots.len()),
                (robots, tools, robots)
            );
        }
        let error = ReconfigureScenario::open("t-to-o").expect_err("unknown").to_string();
        assert!(
            error.starts_with("t-to-o: no such file")
                && error.ends_with("sonar-to-bow; did you mean t-to-i-below?)"),
            "{error}"
        );
    }

    #[test]
    fn vehicles_are_shared_and_bring_their_services() {
        let folder = tempfile::tempdir().expect("a folder");
        let own = include_str!("../../../data/vehicles/bluerov1.toml")
            .replace("mass_kg", "capabilities = [\"sonar\"]\nmass_kg");
        std::fs::write(folder.path().join("own.toml"), own).expect("written");
        let text = GOOD.replace("\"bluerov1\"", "\"own.toml\"\ncapabilities = [\"camera\"]")
            + "[[robot]]\nid = 2\nvehicle = \"own.toml\"\nstart = [0.0, 0.33, 0.0, 0.0]\n\
               [[slot]]\npose = [0.0, 0.33, 0.0, 0.0]\nrequires = [\"sonar\"]\n";
        std::fs::write(folder.path().join("s.toml"), &text).expect("written");
        let path = folder.path().join("s.toml");
        let problem = ReconfigureScenario::open(path.to_str().expect("UTF-8")).expect("parses").problem;
        assert_eq!(problem.vehicles.len(), 2);
        assert_eq!(problem.robots[0].capabilities, ["camera", "sonar"]);
        assert_eq!(problem.robots[1].capabilities, ["sonar"]);
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        ReconfigureScenario::parse("t.toml", GOOD, Path::new("")).expect("good");
        for (text, expected) in [
            (GOOD.replace("-0.483", "nan"), "t.toml:8: robot 1: x = NaN m"),
            (GOOD.replace("-0.483", "-0.5"), "t.toml:4: tool 1 is left alone"),
            (
                GOOD.replace("-0.483", "\"west\""),
                "t.toml:8: [[robot]] 1: start[0] = \"west\": must be a number",
            ),
            (
                GOOD.replace("pose = [0.483,", "pose = [0.483, 1.0,"),
                "t.toml:10: [[slot]] 1: pose = [0.483, 1.0, 0.0, 0.0, 0.0]: a list of 5",
            ),
            (GOOD.replace("id = 1", "id = 0"), "t.toml:6: robot id = 0"),
            (GOOD.replace("id = 1", "number = 1"), "t.toml:6: [[robot]] 1: unknown field `number`"),
            (
                GOOD.replace("bluerov1", "bluerov9"),
                "t.toml:7: [[robot]] 1: vehicle = \"bluerov9\": no such file",
            ),
            (GOOD.replace("bluerov1", "tool-20n"), "t.toml:7: robot 1: 20 N tool has no thrusters"),
            (format!("{GOOD}requires = [\"sonar\"]\n"), "t.toml:11: slot 1 requires \"sonar\""),
            (format!("{GOOD}[rules]\nbattery_v = 9.0\n"), "t.toml:12: [rules] battery_v = 9 V"),
            (format!("{GOOD}[rules]\nbounds_m = [[0, 0, 0], [0.3, 1, 1]]\n"), "t.toml:8: robot 1 at [-0.483"),
            (
                format!("{GOOD}[bounds]\nedge_m = [[-1.0, -1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, 1.0]]\n"),
                "t.toml:12: [bounds] edge_m: its edge 1 crosses or touches its edge 3",
            ),
            (
                format!("{GOOD}[bounds]\nedge_m = [[-0.8, -1], [2, -1], [2, 1], [-0.8, 1]]\n"),
                "t.toml:8: robot 1 is 0.076 m from the edge of [bounds]: 0.1 m are asked",
            ),
            (
                format!("{GOOD}[bounds]\nmargin_m = -1.0\nedge_m = [[-2, -2], [2, -2], [0, 2]]\n"),
                "t.toml:12: [bounds] margin_m = -1 m",
            ),
            (format!("{GOOD}[rules]\nspeed = 1.0\n"), "t.toml:12: [rules] unknown field `speed`"),
            (GOOD[..GOOD.find("[[slot]]").unwrap()].to_owned(), "t.toml:1: 0 slots for 1 robots"),
            (GOOD.replace("\"t\"", "\"../t\""), "t.toml:1: name = \"../t\""),
        ] {
            let said =
                ReconfigureScenario::parse("t.toml", &text, Path::new("")).expect_err(&text).to_string();
            assert!(said.starts_with(expected), "{said}\nexpected {expected}");
        }
        let many = format!("{GOOD}{}", "[[slot]]\npose = [0.0, 0.0, 0.0, 0.0]\n".repeat(1000));
        let said =
            ReconfigureScenario::parse("t.toml", &many, Path::new("")).expect_err("too many").to_string();
        assert!(said.ends_with("1001 times [[slot]]: at most 1000"), "{said}");
    }

    #[test]
    fn a_vehicle_file_that_is_none_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("own.toml"), "name = \"own\"\nbox = 1\n").expect("written");
        let text = GOOD.replace("bluerov1", "own.toml");
        let said =
            ReconfigureScenario::parse("t.toml", &text, folder.path()).expect_err("no vehicle").to_string();
        assert!(said.contains("own.toml:2: unknown field `box`"), "{said}");
    }
}
