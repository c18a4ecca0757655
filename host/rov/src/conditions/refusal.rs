//! Errors of problems that are refused, with their messages.

use quantity::ParameterError;
use quantity::bounds::BoundsError;
use thiserror::Error;

/// Something of a problem, as its user counts: robots by id, tools and slots from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The robot of that id.
    Robot(u16),
    /// The tool of that index, from 0.
    Tool(usize),
    /// The slot of that index, from 0.
    Slot(usize),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Robot(id) => write!(f, "robot {id}"),
            Self::Tool(index) => write!(f, "tool {}", index + 1),
            Self::Slot(index) => write!(f, "slot {}", index + 1),
        }
    }
}

/// One of the two configurations that a problem gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Configuration {
    /// S_s (g5).
    Start,
    /// S_g (g6).
    Goal,
}

impl std::fmt::Display for Configuration {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Start => "start",
            Self::Goal => "goal",
        })
    }
}

/// Why a problem is refused.
#[derive(Clone, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ProblemError {
    /// A number among the rules.
    #[error("[rules] {0}")]
    Rule(#[from] ParameterError),
    /// Corners of the water that enclose none.
    #[error("[rules] bounds_m = {bounds_m:?} m: the first corner must be below the second in x, y and z")]
    Bounds { bounds_m: [[f64; 3]; 2] },
    /// A pose that no place has.
    #[error("{place}: {number}")]
    Pose { place: Place, number: ParameterError },
    /// A box without an inside.
    #[error("{place}: {name}: box_m = {box_m:?} m: must be finite and greater than zero")]
    Box { place: Place, name: String, box_m: [f64; 3] },
    /// A vehicle that is not there.
    #[error("{place}: vehicle {vehicle} of {vehicles}")]
    NoSuchVehicle { place: Place, vehicle: usize, vehicles: usize },
    /// No robots.
    #[error("a reconfiguration needs at least one robot")]
    NoRobots,
    /// An id of 0, which no robot has.
    #[error("robot id = 0: ids count from 1")]
    IdZero,
    /// A number that two robots have.
    #[error("robot id = {id} stands twice")]
    IdTwice { id: u16 },
    /// A robot that cannot move.
    #[error("robot {id}: {name} has no thrusters: it can only be a tool")]
    NoThrusters { id: u16, name: String },
    /// v1: more robots than slots.
    #[error("{slots} slots for {robots} robots: the goal needs at least one each")]
    TooFewSlots { slots: usize, robots: usize },
    /// v2: no robot has the capability that a slot requires.
    #[error("slot {} requires {capability:?}, which no robot brings", slot + 1)]
    MissingCapability { slot: usize, capability: String },
    /// v2: too many robots for the slots whose requirements they meet.
    #[error("robots {} fit only into {}: no one-to-one assignment", list(robots), only(slots))]
    NoAssignment { robots: Vec<u16>, slots: Vec<usize> },
    /// Something sticks out of the water.
    #[error(
        "{place} at {position_m:?} m does not fit into the water, {:?} m to {:?} m",
        bounds_m[0],
        bounds_m[1]
    )]
    OutsideWater { place: Place, position_m: [f64; 3], bounds_m: [[f64; 3]; 2] },
    /// The edge of the water is none.
    #[error("[bounds] edge_m: {0}")]
    Edge(BoundsError),
    /// Something is nearer to the edge of the water than its margin, or beyond it.
    #[error("{place} is {room_m:.3} m from the edge of [bounds]: {margin_m} m are asked")]
    NearEdge { place: Place, room_m: f64, margin_m: f64 },
    /// Two in one place.
    #[error("{first} and {second} are both at {position_m:?} m")]
    SamePlace { first: Place, second: Place, position_m: [f64; 3] },
    /// Two in each other.
    #[error("{first} and {second} overlap by {depth_m:.3} m")]
    Overlap { first: Place, second: Place, depth_m: f64 },
    /// v1: boxes of different kinds that no assignment keeps apart.
    #[error("every assignment of robots to slots leaves two boxes in each other")]
    NoFit,
    /// v4: a tool without a connection.
    #[error("tool {} is left alone: it has no connection at the {configuration}", tool + 1)]
    ToolAlone { tool: usize, configuration: Configuration },
    /// A robot or slot without a connection.
    #[error("{place} has no connection at the {configuration}")]
    Unconnected { place: Place, configuration: Configuration },
    /// More than one cluster.
    #[error("the {configuration} is not one cluster: no chain of connections from {first} to {second}")]
    Apart { configuration: Configuration, first: Place, second: Place },
}

fn list<T: ToString>(items: &[T]) -> String {
    items.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

fn only(slots: &[usize]) -> String {
    let numbers: Vec<usize> = slots.iter().map(|slot| slot + 1).collect();
    if numbers.is_empty() { "no slot".to_owned() } else { format!("slots {}", list(&numbers)) }
}
