//! The self-reconfiguration problem, section VII of the paper: what is given (g1–g7) and under which rules (g8).
//!
//! | given | here |
//! |---|---|
//! | g1, g7 task and services | [`Slot::requires`] |
//! | g2, g3, g4 robots, thrusters, connectors | [`Robot`], its [`Vehicle`] |
//! | g5, g6 start and goal configuration | the poses of robots, tools and slots; adjacency (18) follows from the connectors |
//! | g8 conditions v1–v6 | [`Rules`] holds their numbers |

use quantity::bounds::Bounds;
use serde::{Deserialize, Serialize};

use super::pose::Pose;
use super::vehicle::Vehicle;

/// A robot at its start (g2, g5).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    /// Its number in the fleet, from 1.
    pub id: u16,
    /// What it is: index into [`Problem::vehicles`].
    pub vehicle: usize,
    /// Where it starts.
    pub start: Pose,
    /// What it brings, its vehicle's services included.
    pub capabilities: Vec<String>,
}

/// A tool: carried, never moved by itself (v4 asks that it keeps a connection).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tool {
    /// What it is: index into [`Problem::vehicles`].
    pub vehicle: usize,
    /// Where it stays.
    pub pose: Pose,
}

/// A place in the goal configuration (g6).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slot {
    /// Where a robot is to end.
    pub pose: Pose,
    /// What that robot must bring (v2).
    pub requires: Vec<String>,
}

/// Rules of a problem: numbers in the conditions, the grid, and speeds of robots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Rules {
    /// Clearance d in multiples of max(L, W, H) of the mover (19).
    pub clearance_factor: f64,
    /// Grid cells in the length, width and height of the first robot's box.
    pub grid_divisions: [u32; 3],
    /// Corners of the water, m; around everything by twice the clearance if not given.
    pub bounds_m: Option<[[f64; 3]; 2]>,
    /// Constant speed of the paper's rules, m/s.
    pub speed_m_s: f64,
    /// Constant yaw rate of the paper's rules, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Least and greatest speed that a leg may be given, m/s. *Assumed*: slower, a robot is carried off by any current.
    pub speeds_m_s: [f64; 2],
    /// Least and greatest yaw rate that a turn may be given, rad/s. *Assumed*.
    pub yaw_rates_rad_s: [f64; 2],
    /// Acceleration along a leg, m/s². *Assumed*.
    pub acceleration_m_s2: f64,
    /// Yaw acceleration, rad/s². *Assumed*.
    pub yaw_acceleration_rad_s2: f64,
    /// What undocking takes at least, s.
    pub undock_s: f64,
    /// What docking takes, s.
    pub dock_s: f64,
    /// Battery voltage, V.
    pub battery_v: f64,
    /// Velocity of the water that is expected, world, m/s: what it costs to swim and to wait in it is part of the plan's energies.
    #[serde(skip_serializing_if = "is_still")]
    pub current_m_s: [f64; 3],
    /// How often a robot may move. Robots that exchange places or face about in one place move out and back; by the paper's
    /// manner every robot moves once.
    pub moves_per_robot: u32,
    /// Whether the robots that wait have to stay one cluster, tools included. The paper's text does not ask for it.
    pub one_cluster: bool,
    /// Greatest roll or pitch at which the restoring moment may take what thrusters cannot, rad. *Assumed*, 10°.
    pub tilt_limit_rad: f64,
}

/// Whether water rests that has this velocity.
#[must_use]
pub fn is_still(current_m_s: &[f64; 3]) -> bool {
    current_m_s.iter().all(|component| *component == 0.0)
}

impl Default for Rules {
    fn default() -> Self {
        Self {
            clearance_factor: 1.5,
            grid_divisions: [4, 3, 2],
            bounds_m: None,
            speed_m_s: 0.311,
            yaw_rate_rad_s: 1.31,
            speeds_m_s: [0.1, 0.5],
            yaw_rates_rad_s: [0.2, 1.5],
            acceleration_m_s2: 0.2,
            yaw_acceleration_rad_s2: 1.0,
            undock_s: 0.0,
            dock_s: 0.0,
            battery_v: 16.0,
            current_m_s: [0.0; 3],
            moves_per_robot: 2,
            one_cluster: false,
            tilt_limit_rad: 0.17,
        }
    }
}

/// A reconfiguration problem: vehicles, start, goal and rules.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Problem {
    /// Its name.
    pub name: String,
    /// One line.
    pub description: String,
    /// The kinds of robots and tools in it.
    pub vehicles: Vec<Vehicle>,
    /// The robots.
    pub robots: Vec<Robot>,
    /// What is carried.
    pub tools: Vec<Tool>,
    /// Where to.
    pub slots: Vec<Slot>,
    /// Under which rules.
    pub rules: Rules,
    /// The edge of the water, seen from above: no part of a hull comes nearer to it than its margin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounds: Option<Bounds>,
}
