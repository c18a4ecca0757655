//! What a planner answers: one decision, a transition and a swim cycle for every module.
//!
//! There is always an answer. If no cycle can be reached, the one before is done again, if it starts where the
//! tails are; if that will not do either, everybody holds still.
//!
//! A plan is *loss tolerant* if nobody collides when any subset of the modules never hears of it and stays as it is.
//! Collisions are between two modules, so that it suffices to look at each pair with both moving, only i, only j.

use super::motion::{StepTime, Swing, Turn, Wrench};
use super::reason::Reason;

/// What kind of decision a plan is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// A cycle made for the demand.
    Planned,
    /// The cycle before once more.
    Repeated,
    /// Nothing moves.
    Held,
}

impl Outcome {
    /// `planned`, `repeated` or `held`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Planned => "planned",
            Self::Repeated => "repeated",
            Self::Held => "held",
        }
    }
}

/// One decision.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What kind of decision it is.
    pub outcome: Outcome,
    /// Each module's swim cycle.
    pub cycle: Vec<Swing>,
    /// Each module's rotation before it; `None` if nobody needs one, or if the tails' angles are not known.
    pub transition: Option<Vec<Turn>>,
    /// Where the tails are between the two steps of a transition that needs two, rad by module.
    pub via_rad: Option<Vec<f64>>,
    /// How long the transition takes, s: both steps of it where it has two, zero where nobody moves.
    pub transition_s: f64,
    /// The times of each of its steps; the second counts only where there are two.
    pub step_times: [StepTime; 2],
    /// The wrench of the cycle by (7).
    pub wrench: Wrench,
    /// ‖w∘(F_des − F)‖ / ‖w∘F_des‖; for a zero demand ‖w∘F‖, N.
    pub error: f64,
    /// Σ |rotation| of the transition, rad.
    pub travel_rad: f64,
    /// Least distance between the surfaces of two tails over transition and cycle, m; +∞ if no two tails can meet.
    pub clearance_m: f64,
    /// The same for tails that are as far off their planned angles as modules let them be (see [`tube`](super::tube)), m. `None`
    /// where nothing is guaranteed: transitions at constant speed, angles that are not known. Not above zero only where tails that
    /// stopped too near each other part.
    pub guarantee_m: Option<f64>,
    /// True if the demand lies outside the envelope, so that nothing could have met it; the wrench is then the farthest
    /// found in its direction.
    pub outside_envelope: bool,
    /// True if any subset of the modules may miss the plan and stay as it is; false with unknown angles.
    pub loss_tolerant: bool,
    /// True if moreover any module may stop anywhere in its motion while the others go on, as one does that loses its power.
    pub power_tolerant: bool,
    /// Why nothing moves, where the planner holds.
    pub reason: Option<Reason>,
}

impl Default for Plan {
    /// A plan of no modules, for a planner to write into.
    fn default() -> Self {
        Self {
            outcome: Outcome::Held,
            cycle: Vec::new(),
            transition: None,
            via_rad: None,
            transition_s: 0.0,
            step_times: <[StepTime; 2]>::default(),
            wrench: Wrench::default(),
            error: 0.0,
            travel_rad: 0.0,
            clearance_m: f64::INFINITY,
            guarantee_m: None,
            outside_envelope: false,
            loss_tolerant: false,
            power_tolerant: false,
            reason: None,
        }
    }
}
