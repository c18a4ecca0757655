//! Messages about how a run stands: what modules do, what it is steered by, what was ordered.

use super::super::message::messages;
use super::super::ros::Time;

messages! {
    /// One module as it last said.
    ModuleStatus = "flotilla_msgs" {
        /// Its number.
        module: u16,
        /// What it was doing; empty before its first report.
        state: String,
        /// What was wrong with it.
        faults: Vec<String>,
        /// Battery voltage, where it is measured, V.
        battery_v: Option<f64>,
        /// How long ago it was heard, if ever, s.
        silent_s: Option<f64>,
        /// Its tail as reported, unwrapped, rad.
        tail_rad: Option<f64>,
        /// That less where its cycle has it at the time of the report, rad.
        tail_error_rad: Option<f64>,
    }

    /// How the run stands.
    Status = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// What the fleet does, in a sentence.
        fleet: String,
        /// stop or hold, while one is in force; empty otherwise.
        order: String,
        /// Why it holds though no one ordered it to, while a velocity is not refreshed; empty otherwise.
        deadman: String,
        /// By place.
        modules: Vec<ModuleStatus>,
        /// What neither wrench nor drag explains, east and north, m/s2. Nothing before it is known.
        unknown_m_s2: Vec<f64>,
        /// The same of yaw, rad/s2.
        unknown_rad_s2: Vec<f64>,
        /// Why there are no poses; empty where there are.
        poses: String,
    }

    /// What the fleet is steered by. Told again when it changes.
    Goal = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// velocity, station, waypoints, or none while a target is waited for.
        kind: String,
        /// leg: as the scenario has it; console: as an operator has it.
        source: String,
        /// East, north, m/s.
        velocity_m_s: Vec<f64>,
        /// Where to now, east and north, m.
        station_m: Vec<f64>,
        /// Heading, rad.
        heading_rad: f64,
        /// Waypoints that are left, the one that is swum to first: east, m.
        waypoints_x_m: Vec<f64>,
        /// North, m.
        waypoints_y_m: Vec<f64>,
    }

    /// What was ordered while the run went on.
    Order = "flotilla_msgs" {
        /// Fleet time at which it was followed.
        stamp: Time,
        /// Who gave it.
        by: String,
        /// What.
        what: String,
        /// Whether it is a target, or the end of one.
        steers: bool,
        /// Whether it was followed.
        followed: bool,
        /// What came of it, in words.
        text: String,
    }

    /// One body as a motion capture sees it, in the world.
    Body = "flotilla_msgs" {
        /// Its name or number there.
        name: String,
        /// The module that it sits on; 0 for none.
        module: u16,
        /// East, north, m.
        position_m: [f64; 2],
        /// Of its x axis, counter-clockwise from east, rad.
        heading_rad: f64,
        /// Whether the pose of the structure is made of it.
        used: bool,
    }

    /// All of a frame.
    Bodies = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// As they came.
        bodies: Vec<Body>,
    }
}
