//! Record of an executed reconfiguration, for pictures and figures.

use reconfiguration::plan::Plan;
use reconfiguration::pose::Pose;
use reconfiguration::problem::Problem;

/// One executed plan: problem, plan, and samples of its execution.
#[derive(Clone, Debug)]
pub struct Record {
    /// What was asked.
    pub problem: Problem,
    /// What was planned.
    pub plan: Plan,
    /// What happened, evenly spaced in time from the beginning of the plan.
    pub samples: Vec<Sample>,
}

/// The state of all robots at one instant.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Time since the beginning of the plan, s.
    pub t_s: f64,
    /// Which move is under way, of several the first: index into the plan's moves. Robots that are under way have a reference.
    pub moving: Option<usize>,
    /// Restoring moments K and M on the waiting cluster (5), body of the tool, N·m.
    pub restoring_nm: [f64; 2],
    /// Every robot, in the order of the problem.
    pub robots: Vec<RobotSample>,
}

/// One robot at one instant.
#[derive(Clone, Debug)]
pub struct RobotSample {
    /// Pose η.
    pub eta: [f64; 6],
    /// Velocity ν, body.
    pub nu: [f64; 6],
    /// Wrench τ of its thrusters, body origin; N, N·m.
    pub tau: [f64; 6],
    /// Thrust of each thruster as the water feels it, N.
    pub thrusts_n: Vec<f64>,
    /// Pulse width of each thruster, µs.
    pub pulses_us: Vec<f64>,
    /// Electric power of its thrusters, W.
    pub power_w: f64,
    /// Where it is to be, while it moves.
    pub reference: Option<Pose>,
    /// Whether it has reached its slot.
    pub arrived: bool,
}
