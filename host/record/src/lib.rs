//! Record of a run, in memory: the input of `summary.json` and of every plot.

use modboat::motion::{Swing, Turn, Wrench};
use modboat::parameters::Parameters;

pub mod reconfigure;

/// One leg of a scenario: what was demanded, and when. Time 0 is the start of the first cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct LegRecord {
    /// First instant, s.
    pub start_s: f64,
    /// Last instant, s.
    pub end_s: f64,
    /// Demanded velocity in the world (x east, y north), m/s; zero where a station is to be kept.
    pub velocity_m_s: [f64; 2],
    /// The station to be kept, if that is what is demanded, m.
    pub station_m: Option<[f64; 2]>,
    /// Demanded heading Θ of the surge axis, rad counter-clockwise from world x.
    pub heading_rad: f64,
}

/// The structure's true pose and velocity at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseSample {
    /// Time, s.
    pub t_s: f64,
    /// Centre of mass in the world, m.
    pub position_m: [f64; 2],
    /// Heading Θ, rad (unwrapped).
    pub heading_rad: f64,
    /// Velocity in the world, m/s.
    pub velocity_m_s: [f64; 2],
    /// Angular velocity Ω, rad/s.
    pub yaw_rate_rad_s: f64,
}

/// All tails at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct TailSample {
    /// Time, s.
    pub t_s: f64,
    /// Actual angle of each tail, rad (unwrapped), by module.
    pub actual_rad: Vec<f64>,
}

/// One decision: transition and swim cycle of every module.
#[derive(Clone, Debug, PartialEq)]
pub struct CycleRecord {
    /// Cycle number k.
    pub number: u32,
    /// Start of its transition, s.
    pub start_s: f64,
    /// Length of its transition, s, with both steps and the rest between them where it has two (0: none needed).
    pub transition_s: f64,
    /// Length of each ramp from and to rest in each step of it, s; zero at constant speed.
    pub ramps_s: [f64; 2],
    /// Length of its swim cycle, s.
    pub period_s: f64,
    /// "planned", "repeated" or "held".
    pub outcome: &'static str,
    /// Wrench the controller asked for.
    pub demand: Wrench,
    /// Whether it asked for less than the leg, to keep off the edge of the water.
    pub bounded: bool,
    /// Wrench the plan yields by law (7).
    pub commanded: Wrench,
    /// Mean wrench of the tails on the water over the swim cycle, as simulated from the actual tail angles; `None` where the water is
    /// real, and nothing measures it.
    pub achieved: Option<Wrench>,
    /// ‖w∘(demand − commanded)‖ / ‖w∘demand‖.
    pub error: f64,
    /// Total tail travel of the transition, rad.
    pub travel_rad: f64,
    /// Whether the demand lay outside the envelope, so that nothing could have met it.
    pub outside_envelope: bool,
    /// Least distance between the surfaces of two tails over transition and cycle as planned, m.
    pub clearance_m: f64,
    /// The same for tails as far off their planned angles as modules let them be, m; `None` where nothing is guaranteed.
    pub guarantee_m: Option<f64>,
    /// Time the planner took, µs.
    pub solve_us: u64,
    /// Each module's swim cycle.
    pub swings: Vec<Swing>,
    /// Each module's transition; where a tail does not move, from = to.
    pub turns: Vec<Turn>,
    /// The first of two steps of the transition, where it has two.
    pub via: Option<ViaRecord>,
    /// Whether any modules may miss it without a collision.
    pub loss_tolerant: bool,
    /// Whether any module may lose its power in it.
    pub power_tolerant: bool,
}

/// The first step of a transition in two.
#[derive(Clone, Debug, PartialEq)]
pub struct ViaRecord {
    /// Where each tail is after it, rad (unwrapped).
    pub via_rad: Vec<f64>,
    /// How long it turns, s.
    pub turning_s: f64,
    /// How long it rests then, s.
    pub rest_s: f64,
}

/// Everything that was measured in one run.
#[derive(Clone, Debug)]
pub struct RunRecord {
    /// Scenario name, such as `holonomic-1`.
    pub name: String,
    /// One line about the scenario.
    pub description: String,
    /// Module parameters of the run.
    pub parameters: Parameters,
    /// Lattice cells [col, row] by module.
    pub cells: Vec<[i32; 2]>,
    /// Module centres in S, m, by module.
    pub positions_m: Vec<[f64; 2]>,
    /// Legs in order.
    pub legs: Vec<LegRecord>,
    /// Spans [start, end] of which nothing is known, s: the host did not run. Nothing is joined over one.
    pub gaps: Vec<[f64; 2]>,
    /// True poses at some 20 Hz.
    pub poses: Vec<PoseSample>,
    /// Tail angles at some 50 Hz.
    pub tails: Vec<TailSample>,
    /// Cycles in order.
    pub cycles: Vec<CycleRecord>,
}

impl RunRecord {
    /// Whether two instants lie on different sides of a gap, or in one, s.
    #[must_use]
    pub fn is_apart(&self, from_s: f64, to_s: f64) -> bool {
        self.gaps.iter().any(|&[start_s, end_s]| from_s < end_s && start_s < to_s)
    }

    /// `samples`, in the order of their times, in the pieces between gaps.
    pub fn pieces<'a, T>(
        &'a self,
        samples: &'a [T],
        time_s: impl Fn(&T) -> f64 + 'a,
    ) -> impl Iterator<Item = &'a [T]> {
        samples.chunk_by(move |a, b| !self.is_apart(time_s(a), time_s(b)))
    }

    /// Mean time from the start of one decision's transition to the end of its swim cycle, s.
    #[must_use]
    pub fn mean_interval_s(&self) -> f64 {
        match self.cycles.len() {
            0 => self.parameters.period_s,
            n => self.cycles.iter().map(|cycle| cycle.transition_s + cycle.period_s).sum::<f64>() / n as f64,
        }
    }
}
