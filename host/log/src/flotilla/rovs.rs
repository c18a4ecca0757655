//! Messages about ROVs: their states, the moves of a plan, and what those cost.

use super::super::message::messages;
use super::super::ros::Time;

/// Number of the slot in a [`Move`] that parks.
pub const PARKED: u32 = u32::MAX;

messages! {
    /// A pose: NED, m, rad.
    Place = "flotilla_msgs" {
        /// North, m.
        x_m: f64,
        /// East, m.
        y_m: f64,
        /// Down, m.
        z_m: f64,
        /// Clockwise from north as seen from above, rad.
        yaw_rad: f64,
    }

    /// One ROV: NED, body x forward, y right, z down.
    Robot = "flotilla_msgs" {
        /// Its number.
        id: u16,
        /// Position, m; roll, pitch, yaw, rad.
        eta: [f64; 6],
        /// Velocity, body, m/s; rates, rad/s.
        nu: [f64; 6],
        /// Wrench of its thrusters, body origin, N, N m.
        tau: [f64; 6],
        /// As the water feels it, N.
        thrusts_n: Vec<f64>,
        /// Pulse widths, us.
        pulses_us: Vec<f64>,
        /// Of its thrusters, W.
        power_w: f64,
        /// Where it is to be, while it moves.
        reference: Option<Place>,
        /// It has reached its slot.
        arrived: bool,
    }

    /// All ROVs at one instant.
    Robots = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// Since the beginning of the plan, s.
        t_s: f64,
        /// Which move is under way, from 0; -1 for none.
        moving: i32,
        /// Restoring moments K and M on the waiting cluster, N m.
        restoring_nm: [f64; 2],
        /// In the order of the problem.
        robots: Vec<Robot>,
    }

    /// One ROV as a motion capture saw it: NED.
    Sighted = "flotilla_msgs" {
        /// Its number.
        id: u16,
        /// Position, m; roll, pitch, yaw, rad.
        eta: [f64; 6],
    }

    /// All ROVs that one frame of a motion capture shows.
    Sighting = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// When it was captured, fleet time, s.
        captured_s: f64,
        /// Those that it shows.
        robots: Vec<Sighted>,
    }

    /// Energies and the time they were drawn in.
    Energy = "flotilla_msgs" {
        /// Of the mover, J.
        navigate_j: f64,
        /// Of the waiting robots, J.
        balance_j: f64,
        /// Their sum, J.
        total_j: f64,
        /// How long, s.
        time_s: f64,
    }

    /// One move so far.
    Move = "flotilla_msgs" {
        /// The robot's number.
        robot: u16,
        /// Its slot, from 0; 4294967295 where it parks.
        slot: u32,
        /// As the plan has it.
        planned: Energy,
        /// With acceleration and hand-over.
        expected: Energy,
        /// As it was, by the plan's law of power.
        executed: Energy,
        /// As it was, by the measured table.
        by_table: Energy,
        /// Greatest distance from the path, m.
        cross_track_m: f64,
        /// Least gap to another hull, m.
        least_gap_m: Option<f64>,
        /// Distance from the slot when drawn in, m.
        end_m: Option<f64>,
        /// Angle then, rad.
        end_rad: Option<f64>,
    }

    /// Every move that was begun, so far.
    Moves = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// In order.
        moves: Vec<Move>,
    }

    /// Spans of a plan in which the host did not run, so far.
    Pauses = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// When each began, s of the plan's time.
        start_s: Vec<f64>,
        /// How long it was, s.
        length_s: Vec<f64>,
    }

    /// Thrusters that were found to give nothing, so far.
    DeadThrusters = "flotilla_msgs" {
        /// Fleet time.
        stamp: Time,
        /// The robot of each, by its id.
        robot: Vec<u16>,
        /// Which of it, from 1.
        thruster: Vec<u16>,
        /// When it was found, s of the plan's time.
        at_s: Vec<f64>,
    }
}
