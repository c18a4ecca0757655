//! A plan, the answer of a planner: one decision, a transition and a swim cycle for every module.
//!
//! There is always an answer. If no cycle can be reached, the one before is done again, if it starts where the
//! tails are; if that will not do either, all modules hold still.
//!
//! A plan is *loss tolerant* if no tails collide when any subset of the modules never receives it and stays as it is.
//! Collisions are between two modules, so that it suffices to look at each pair with both moving, only i, only j.

use super::motion::{StepTime, Swing, Turn, Wrench};
use super::reason::Reason;
use super::way::Steps;

/// The decision before a plan: modules may still be carrying it out, and one that lost its power stands anywhere in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Previous<'a> {
    /// Each module's swim cycle.
    pub cycle: &'a [Swing],
    /// Each module's rotation before it; one that is certainly through turns from where it turns to. `None` if no module may have
    /// stopped in one.
    pub transition: Option<&'a [Turn]>,
    /// Where the tails are between the two steps of a transition that has two, rad by module.
    pub via_rad: Option<&'a [f64]>,
    /// Whether every module has said since where it rests: none has stopped anywhere else.
    pub is_over: bool,
}

impl<'a> Previous<'a> {
    /// A cycle that no turn came before.
    #[must_use]
    pub const fn cycle(cycle: &'a [Swing]) -> Self {
        Self { cycle, transition: None, via_rad: None, is_over: false }
    }

    /// Whether it is of so many modules.
    pub(crate) fn is_of(&self, modules: usize) -> bool {
        let other = |length: Option<usize>| length.is_some_and(|length| length != modules);
        self.cycle.len() == modules
            && !other(self.transition.map(<[Turn]>::len))
            && !other(self.via_rad.map(<[f64]>::len))
    }

    /// The steps of its transition.
    pub(crate) fn steps(&self) -> Steps<'a> {
        self.transition.map_or(Steps::default(), |turns| Steps { turns, via_rad: self.via_rad })
    }
}

/// Outcome of planning: a new cycle, the previous one again, or hold.
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

/// A plan for one decision, with what its examination found.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What kind of decision it is.
    pub outcome: Outcome,
    /// Each module's swim cycle.
    pub cycle: Vec<Swing>,
    /// Each module's rotation before it; `None` if no module needs one, or if the tails' angles are unknown.
    pub transition: Option<Vec<Turn>>,
    /// Where the tails are between the two steps of a transition that needs two, rad by module.
    pub via_rad: Option<Vec<f64>>,
    /// How long the transition takes, s: both steps of it where it has two, zero if no module turns.
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

impl Plan {
    /// The same as the decision before another one.
    #[must_use]
    pub fn as_previous(&self) -> Previous<'_> {
        Previous {
            cycle: &self.cycle,
            transition: self.transition.as_deref(),
            via_rad: self.via_rad.as_deref(),
            is_over: false,
        }
    }
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
