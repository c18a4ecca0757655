//! Sequences of demands for the benches, and the question to a planner with each.

use std::f64::consts::PI;
use std::sync::Arc;

use modboat::distance::DistanceToCollision;
use modboat::motion::{Swing, Wrench};
use modboat::parameters::Parameters;
use modboat::plan::Plan;
use modboat::planner::Planner;
use modboat::planner_config::PlannerConfig;
use modboat::planner_kind::PlannerKind;
use modboat::structure::Structure;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// The structures that are measured: 3, 9 and 25 modules.
pub const SHAPES: [&str; 3] = ["3x1", "3x3", "5x5"];

/// How demands follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sequence {
    /// Each drifts away from the one before, and the planner knows the cycle before: a closed loop.
    Correlated,
    /// Each has nothing to do with the one before, nor does the planner know it.
    Uncorrelated,
}

impl Sequence {
    pub const BOTH: [Self; 2] = [Self::Correlated, Self::Uncorrelated];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Correlated => "correlated",
            Self::Uncorrelated => "uncorrelated",
        }
    }
}

/// So many demands, each of which the structure can meet: the sum of thrusts of at most 0.6 of the greatest.
pub fn demands(structure: &Structure, sequence: Sequence, count: usize) -> Vec<Wrench> {
    let parameters = Parameters::default();
    let positions_m = structure.positions_m(parameters.pitch_m);
    let most_n = 0.6 * parameters.thrust_n(parameters.amplitude_max_rad);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut fresh = || {
        positions_m.iter().fold(Wrench::default(), |sum, [x_m, y_m]| {
            let (thrust_n, angle) = (most_n * rng.random_range(0.0..1.0), rng.random_range(-PI..PI));
            let (fx_n, fy_n) = (thrust_n * f64::cos(angle), thrust_n * f64::sin(angle));
            sum + Wrench { fx_n, fy_n, tau_nm: x_m * fy_n - y_m * fx_n }
        })
    };
    let mut now = fresh();
    (0..count)
        .map(|_| {
            let (before, next) = (now.to_array(), fresh().to_array());
            now = Wrench::from_array(match sequence {
                Sequence::Correlated => [0, 1, 2].map(|k| 0.8 * before[k] + 0.2 * next[k]),
                Sequence::Uncorrelated => next,
            });
            now
        })
        .collect()
}

/// One question to a planner.
pub struct Question {
    pub demand: Wrench,
    pub tails: Option<Vec<f64>>,
    pub previous: Option<Vec<Swing>>,
}

impl Question {
    pub fn ask(&self, planner: &mut Planner) -> Plan {
        planner.plan(self.demand, self.tails.as_deref(), self.previous.as_deref())
    }
}

/// Asks `planner` for a plan for each demand, each from where the one before ends, and hands `look` every question with
/// the means to ask it.
pub fn stream(
    planner: &mut Planner,
    demands: &[Wrench],
    sequence: Sequence,
    mut look: impl FnMut(&Question, &mut Planner) -> Plan,
) {
    let (mut tails, mut previous): (Option<Vec<f64>>, _) = (None, None);
    for &demand in demands {
        let known = if sequence == Sequence::Correlated { previous } else { None };
        let question = Question { demand, tails, previous: known };
        let plan = look(&question, planner);
        tails = Some(match (&plan.transition, question.tails) {
            (Some(turns), _) => turns.iter().map(|turn| turn.to_rad).collect(),
            (None, Some(tails)) => tails,
            (None, None) => plan.cycle.iter().map(|swing| swing.start_rad()).collect(),
        });
        previous = Some(plan.cycle);
    }
}

/// A planner by the collision regions.
pub fn planner(kind: PlannerKind, structure: &Structure, distance: &Arc<DistanceToCollision>) -> Planner {
    let config = PlannerConfig { kind, ..PlannerConfig::default() };
    Planner::with_distance(structure, &Parameters::default(), &config, Arc::clone(distance))
}
