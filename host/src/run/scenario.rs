//! Scenarios: what is run, from a TOML file. A mistake in one is reported with its file, line, value and unit.

use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use link::faults::FaultParameters;
use modboat::bounds::{Place, centres_m};
use modboat::control::ControlConfig;
use modboat::observer::ObserverParameters;
use modboat::parameters::Parameters;
use modboat::planner_config::PlannerConfig;
use modboat::structure::Structure;
use quantity::bounds::Bounds;
use quantity::{ParameterError, check_within};
use reader::file::{self, Source};
use reader::{Document, FileError, Mistake};
use record::PoseSample;
use serde::{Deserialize, Serialize};
use sim::clock::ClockParameters;
use sim::mocap::MocapParameters;
use sim::motor::MotorParameters;
use sim::tank::TankParameters;

pub use built_in::BUILT_IN;
pub use experiment::DURATION_S as EXPERIMENT_S;
use leg::LegTable;
pub use leg::{Demand, Leg};
pub use pose::{LengthUnit, PoseParameters, UpAxis};
use tracking::tail_is_kept;

mod built_in;
mod document;
mod experiment;
mod leg;
mod pose;
mod tracking;

/// Everything a run needs to know.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Name, also of the output folder.
    pub name: String,
    /// One line.
    pub description: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Which modules are docked where.
    pub structure: Structure,
    /// What is demanded, in order.
    pub legs: Vec<Leg>,
    /// Where the structure starts.
    pub start: Start,
    /// The modules.
    pub modboat: Parameters,
    /// The planner.
    pub planner: PlannerConfig,
    /// The controller.
    pub control: ControlConfig,
    /// The observer.
    pub observer: ObserverParameters,
    /// When decisions are made.
    pub timing: Timing,
    /// Where poses come from, and what is done without them.
    pub pose: PoseParameters,
    /// The edge of the water, if the structure is to keep off it.
    pub bounds: Option<Bounds>,
    /// The water, and the boat as it is in it. Only `sim` reads it.
    pub tank: TankParameters,
    /// The motors.
    pub motor: MotorParameters,
    /// The modules' clocks.
    pub clock: ClockParameters,
    /// The cameras.
    pub mocap: MocapParameters,
    /// The medium between host and modules.
    pub radio: FaultParameters,
}

/// Pose at time zero; the structure starts at rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Start {
    /// Centre of mass in the world, m.
    pub position_m: [f64; 2],
    /// Heading Θ, rad; that of the first leg if it is not given.
    pub heading_rad: Option<f64>,
    /// Where every tail points, rad from the sway axis.
    pub tail_rad: f64,
}

/// When decisions are made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Timing {
    /// A cycle is planned and first sent at least this long before it starts, s. *Assumed*: fifteen sends at 20 ms.
    pub lead_s: f64,
    /// Give up on modules that have not joined after this long, s.
    pub join_s: f64,
    /// Swim with so many modules at least, the others' tails taken to be anywhere; 0: all of them.
    pub require: u32,
    /// A module that has been silent for this long is missing, s. *Assumed*: several reports and announcements in a row.
    pub missing_after_s: f64,
}

impl Default for Timing {
    fn default() -> Self {
        Self { lead_s: 0.3, join_s: 10.0, require: 0, missing_after_s: 3.0 }
    }
}

const NO_LEG: &str = "a scenario needs at least one [[leg]]";

/// The file's own shape; [`Scenario`] is what becomes of it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    name: String,
    #[serde(default)]
    description: String,
    #[serde(default = "one")]
    seed: u64,
    structure: Shape,
    #[serde(rename = "leg", default)]
    legs: Option<Vec<LegTable>>,
    #[serde(default)]
    start: Start,
    #[serde(default)]
    modboat: Parameters,
    #[serde(default)]
    planner: PlannerConfig,
    #[serde(default)]
    control: ControlConfig,
    #[serde(default)]
    observer: ObserverParameters,
    #[serde(default)]
    timing: Timing,
    #[serde(default)]
    pose: PoseParameters,
    bounds: Option<Bounds>,
    #[serde(default)]
    tank: TankParameters,
    #[serde(default)]
    motor: MotorParameters,
    #[serde(default)]
    clock: ClockParameters,
    #[serde(default)]
    mocap: MocapParameters,
    #[serde(default)]
    radio: FaultParameters,
}

const fn one() -> u64 {
    1
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Shape {
    /// `W×H`: columns and rows.
    size: Option<String>,
    /// Cells `[col, row]`, module 1 first.
    cells: Option<Vec<[i32; 2]>>,
    /// Drawn: `#` is a module.
    picture: Option<String>,
}

impl Scenario {
    /// Reads a scenario file, or takes the built-in one of that name, or makes the experiment `identify-SHAPE`.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn open(name: &str) -> Result<Self, FileError> {
        if !Path::new(name).is_file()
            && let Some(experiment) = experiment::named(name)
        {
            return experiment;
        }
        let Source { file, text, .. } = file::open(name, "scenario", &BUILT_IN)?;
        let scenario = Self::parse(&file, &text)?;
        if scenario.legs.is_empty() {
            let document = Document::toml(&text).map_err(|mistake| mistake.in_file(&file))?;
            return Err(document.mistake(&["leg"], NO_LEG).in_file(&file));
        }
        Ok(scenario)
    }

    /// Reads a scenario from `text`; `file` is its name in error messages. It may have no legs, as the log of a run has it that waited for
    /// targets.
    ///
    /// # Errors
    /// [`FileError::Invalid`].
    pub fn parse(file: &str, text: &str) -> Result<Self, FileError> {
        let document = Document::toml(text).map_err(|mistake| mistake.in_file(file))?;
        Self::of(&document).map_err(|mistake| mistake.in_file(file))
    }

    fn of(document: &Document<'_>) -> Result<Self, Mistake> {
        let parsed: Tables = document.read()?;
        let number = |table: &str, error: ParameterError| {
            let table: Vec<&str> = table.split('.').collect();
            document.mistake_in(&table, error.key, &error)
        };

        if let Some(message) = unfit(&parsed.name) {
            return Err(document.mistake(&["name"], message));
        }

        let shape = &parsed.structure;
        let (key, structure) = match (&shape.size, &shape.cells, &shape.picture) {
            (Some(word), None, None) => ("size", Structure::from_word(word)),
            (None, Some(cells), None) => ("cells", Structure::from_cells(cells)),
            (None, None, Some(picture)) => ("picture", Structure::from_picture(picture)),
            _ => {
                let message = "[structure] takes exactly one of size, cells and picture";
                return Err(document.mistake(&["structure"], message));
            }
        };
        let structure =
            structure.map_err(|error| document.mistake_in(&["structure"], key, format!("{key}: {error}")))?;

        parsed.modboat.validate().map_err(|error| number("modboat", error))?;
        parsed.modboat.validate_shares(structure.len()).map_err(|error| number("modboat", error))?;
        parsed.planner.validate().map_err(|error| number("planner", error))?;
        parsed.control.validate().map_err(|error| number("control", error))?;
        parsed.observer.validate().map_err(|error| number("observer", error))?;
        parsed.pose.validate().map_err(|error| number("pose", error))?;
        parsed.tank.validate(structure.len()).map_err(|(table, error)| number(table, error))?;
        parsed.motor.validate().map_err(|error| number("motor", error))?;
        parsed.clock.validate().map_err(|error| number("clock", error))?;
        parsed.mocap.validate().map_err(|error| number("mocap", error))?;
        parsed.radio.validate().map_err(|error| number("radio", error))?;
        tail_is_kept(&parsed.modboat, &parsed.motor, &parsed.planner)
            .map_err(|message| document.mistake(&["motor"], message))?;
        let shortest_s = parsed.modboat.period_s;
        let ranges = [
            (
                "timing",
                "lead_s",
                parsed.timing.lead_s,
                0.02..=shortest_s,
                "must lie between 0.02 and the period",
            ),
            ("timing", "join_s", parsed.timing.join_s, 0.1..=3600.0, "must lie between 0.1 and 3600"),
            (
                "timing",
                "missing_after_s",
                parsed.timing.missing_after_s,
                0.5..=3600.0,
                "must lie between 0.5 and 3600",
            ),
        ];
        for (table, key, value, range, reason) in ranges {
            if !range.contains(&value) {
                return Err(number(table, ParameterError { key, value, unit: "s", reason }));
            }
        }
        let [x, y] = parsed.start.position_m;
        let heading = parsed.start.heading_rad.unwrap_or(0.0);
        for (key, value, unit, limit) in [
            ("position_m", x, "m", 1e6),
            ("position_m", y, "m", 1e6),
            ("heading_rad", heading, "rad", 1e3),
            ("tail_rad", parsed.start.tail_rad, "rad", 1e3),
        ] {
            if !(-limit..=limit).contains(&value) {
                return Err(number("start", ParameterError { key, value, unit, reason: "is out of range" }));
            }
        }
        // An empty list, `leg = []`, says that there are to be none.
        let Some(tables) = &parsed.legs else {
            return Err(document.mistake(&["leg"], NO_LEG));
        };
        let mut legs = Vec::with_capacity(tables.len());
        for (index, leg) in tables.iter().enumerate() {
            let leg = leg
                .check()
                .map_err(|(key, message)| document.mistake_in(&["leg", &index.to_string()], key, message))?;
            legs.push(leg);
        }
        if let Some(bounds) = &parsed.bounds {
            within(document, bounds, &parsed.start, &legs, &structure.positions_m(parsed.modboat.pitch_m))?;
        }
        Ok(Self {
            name: parsed.name,
            description: parsed.description,
            seed: parsed.seed,
            structure,
            legs,
            start: parsed.start,
            modboat: parsed.modboat,
            planner: parsed.planner,
            control: parsed.control,
            observer: parsed.observer,
            timing: parsed.timing,
            pose: parsed.pose,
            bounds: parsed.bounds,
            tank: parsed.tank,
            motor: parsed.motor,
            clock: parsed.clock,
            mocap: parsed.mocap,
            radio: parsed.radio,
        })
    }

    /// Length of all legs, s; 0 where there are none, and the run waits for targets.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        // The sum of nothing is −0.
        self.legs.iter().map(|leg| leg.duration_s).sum::<f64>() + 0.0
    }

    /// When it is over, s; never where it waits for targets.
    #[must_use]
    pub fn ends_s(&self) -> f64 {
        if self.legs.is_empty() { f64::INFINITY } else { self.duration_s() }
    }

    /// The same without legs: what is to be done is told while it goes on.
    #[must_use]
    pub fn without_legs(mut self) -> Self {
        self.start.heading_rad = Some(self.start_heading_rad());
        self.legs.clear();
        self
    }

    /// Index of the leg that runs at `t_s` after the start; the last one from its end on.
    #[must_use]
    pub fn leg_at(&self, t_s: f64) -> usize {
        let mut end_s = 0.0;
        let running = self.legs.iter().position(|leg| {
            end_s += leg.duration_s;
            t_s < end_s
        });
        running.unwrap_or(self.legs.len().saturating_sub(1))
    }

    /// Heading at the start, rad: north where nothing says another.
    #[must_use]
    pub fn start_heading_rad(&self) -> f64 {
        let first = self.legs.first().map_or(FRAC_PI_2, |leg| leg.heading_rad);
        self.start.heading_rad.unwrap_or(first)
    }

    /// Where the structure rests at the start.
    #[must_use]
    pub fn start_pose(&self) -> PoseSample {
        PoseSample {
            position_m: self.start.position_m,
            heading_rad: self.start_heading_rad(),
            ..PoseSample::default()
        }
    }
}

/// Refuses bounds that are none.
pub(super) fn sound(document: &Document<'_>, bounds: &Bounds) -> Result<(), Mistake> {
    bounds
        .validate()
        .map_err(|error| document.mistake_in(&["bounds"], "edge_m", format!("edge_m: {error}")))?;
    let reason = "must lie between 0 and 1000000";
    check_within(&[("margin_m", bounds.margin_m, "m", 0.0..=1e6, reason)])
        .map_err(|error| document.mistake_in(&["bounds"], error.key, &error))
}

/// Refuses bounds that are none, and a structure that starts, or a station that lies, outside of them.
fn within(
    document: &Document<'_>,
    bounds: &Bounds,
    start: &Start,
    legs: &[Leg],
    positions_m: &[[f64; 2]],
) -> Result<(), Mistake> {
    sound(document, bounds)?;
    let first = legs.first().map_or(FRAC_PI_2, |leg| leg.heading_rad);
    let heading_rad = start.heading_rad.unwrap_or(first);
    let place = Place { position_m: start.position_m, heading_rad };
    for (module, [x, y]) in centres_m(positions_m, place).enumerate() {
        if !bounds.contains([x, y]) {
            let message = format!("module {} starts at [{x:.3}, {y:.3}] m, outside of it", module + 1);
            return Err(document.mistake_in(&["bounds"], "edge_m", message));
        }
    }
    for (index, leg) in legs.iter().enumerate() {
        if let Demand::Station([x, y]) = leg.demand
            && !bounds.contains([x, y])
        {
            let message = format!("position_m = [{x}, {y}] m: lies outside of [bounds]");
            return Err(document.mistake_in(&["leg", &index.to_string()], "position_m", message));
        }
    }
    Ok(())
}

/// What is wrong with the name of a scenario, if anything is.
pub(super) fn unfit(name: &str) -> Option<String> {
    let fit = |c: char| !c.is_control() && !r#"/\:*?"<>|"#.contains(c);
    let fits = (1..=100).contains(&name.chars().count()) && !name.starts_with('.') && name.chars().all(fit);
    (!fits).then(|| {
        format!(
            r#"name = {name:?}: names the output folder too: 1 to 100 characters, no dot first, none of /\:*?"<>|"#
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "name = \"t\"\n[structure]\nsize = \"3x1\"\n[[leg]]\nduration_s = 5.0\n\
                        velocity_m_s = [0.04, 0.0]\nheading_rad = 1.5\n";

    fn complaint(text: &str) -> String {
        Scenario::parse("t.toml", text).expect_err(text).to_string()
    }

    #[test]
    fn built_in_scenarios_parse_and_bear_their_names() {
        for (name, _) in BUILT_IN {
            assert_eq!(Scenario::open(name).expect(name).name, name);
        }
    }

    #[test]
    fn legs_follow_each_other() {
        let leg = "[[leg]]\nduration_s = 2.0\nvelocity_m_s = [0.0, 0.0]\nheading_rad = 0.0\n";
        let scenario = Scenario::parse("t.toml", &format!("{GOOD}{leg}")).unwrap();
        assert!((scenario.duration_s() - 7.0).abs() < 1e-12);
        for (t_s, heading_rad) in [(0.0, 1.5), (4.999, 1.5), (5.0, 0.0), (100.0, 0.0)] {
            assert!(
                (scenario.legs[scenario.leg_at(t_s)].heading_rad - heading_rad).abs() < 1e-12,
                "at {t_s} s"
            );
        }
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        for (text, expected) in [
            (GOOD.replace("duration_s = 5.0", "duration_s = -5.0"), "t.toml:5: [[leg]] 1: duration_s = -5 s"),
            (format!("{GOOD}[modboat]\nperiod_s = -1.5\n"), "t.toml:9: [modboat] period_s = -1.5 s"),
            (format!("{GOOD}[modboat]\nperiod = 1.5\n"), "t.toml:9: [modboat] unknown field `period`"),
            (format!("{GOOD}[radio]\n\nloss = 1.5\n"), "t.toml:10: [radio] loss = 1.5"),
            (GOOD.replace("\"3x1\"", "\"0x1\""), "t.toml:3: [structure] size"),
            (GOOD.replace("size = \"3x1\"", "cells = [[0,0],[2,0]]"), "t.toml:3: [structure] cells"),
            (GOOD.replace("size = \"3x1\"\n", ""), "t.toml:2: [structure] takes exactly one"),
            ("name = \"t\"\nleg = 5\n[structure]\nsize = \"3x1\"\n".to_owned(), "t.toml:2: "),
            (GOOD.replace("1.5\n", "nan\n"), "t.toml:7: [[leg]] 1: heading_rad = NaN rad"),
            (GOOD.replace("\"t\"", "\"../t\""), "t.toml:1: name = \"../t\""),
            (
                GOOD.replace("1.5\n", "\"east\"\n"),
                "t.toml:7: [[leg]] 1: heading_rad = \"east\": must be a number",
            ),
            (
                format!("{GOOD}[tank.thrust]\nrest_speed_rad_s = -1.0\n"),
                "t.toml:9: [tank.thrust] rest_speed_rad_s",
            ),
            (
                GOOD[..GOOD.find("[[leg]]").unwrap()].to_owned(),
                "t.toml:1: a scenario needs at least one [[leg]]",
            ),
        ] {
            let complaint = complaint(&text);
            assert!(complaint.starts_with(expected), "{complaint}\nexpected {expected}");
        }
    }
}
