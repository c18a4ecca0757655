//! Fidelity `cycle`: the structure under the mean wrench of each cycle, which is what the planner believes of it.
//!
//! ```text
//! lead_s              t_trans        T − lead_s
//! wrench before       none           Σᵢ of (7)          → Hull, in steps of at most STEP_S
//! ```
//!
//! Contacts are pairs of neighbours whose motion, a straight segment in phase space, meets a collision region: one for the turn, one for
//! the swing.
//!
//! Assumptions and limits: tails are exactly where they were told. What a mean wrench cannot show is refused ([`Hull`]).

use std::sync::Arc;

use modboat::distance::DistanceToCollision;
use modboat::motion::{Wrench, ends};
use modboat::parameters::Parameters;
use modboat::structure::Structure;
use quantity::ParameterError;
use record::PoseSample;
use sim::tank::{Hull, TankParameters};

use crate::command::{Command, seconds};

/// Longest step of the integration, s; a longer one would cost accuracy (see [`Hull`]).
pub const STEP_S: f64 = 0.5;

/// Two neighbours: by offset index, and who they are.
type Pair = (usize, [usize; 2]);

/// See the module's documentation.
#[derive(Clone, Debug)]
pub struct Mean {
    hull: Hull,
    distance: Arc<DistanceToCollision>,
    pairs: Vec<Pair>,
    lead_s: f64,
    /// Mean wrench of the running cycle.
    wrench: Wrench,
    rests_rad: Vec<f64>,
    starts_s: f64,
}

impl Mean {
    /// A structure in the water of `tank`, of which tails meet by `distance`; commands come `lead_s` before their cycle starts.
    ///
    /// # Errors
    /// As [`Hull::new`].
    pub fn new(
        structure: &Structure,
        parameters: &Parameters,
        tank: &TankParameters,
        lead_s: f64,
        distance: Arc<DistanceToCollision>,
    ) -> Result<Self, ParameterError> {
        let offsets = distance.offsets().iter().enumerate();
        let pairs = offsets.flat_map(|(index, &offset)| {
            structure.neighbours(offset).map(move |(one, other)| (index, [one, other]))
        });
        Ok(Self {
            hull: Hull::new(structure, parameters, tank, &PoseSample::default())?,
            pairs: pairs.collect(),
            distance,
            lead_s,
            wrench: Wrench::default(),
            rests_rad: vec![0.0; structure.len()],
            starts_s: 0.0,
        })
    }

    /// Begins again from `start`, all tails at `tail_rad`.
    pub fn place(&mut self, start: &PoseSample, tail_rad: f64) {
        self.hull.place(start);
        self.wrench = Wrench::default();
        self.rests_rad.fill(tail_rad);
        self.starts_s = 0.0;
    }

    /// Carries out `command`, of which `wrench` is the mean, until the next one is due; how many motions of pairs meet.
    pub fn run(&mut self, command: &Command, wrench: Wrench) -> usize {
        let (turning_s, period_s) = (seconds(command.transition), seconds(command.period));
        let before = std::mem::replace(&mut self.wrench, wrench);
        self.push(self.lead_s, before);
        self.push(turning_s, Wrench::default());
        self.push(period_s - self.lead_s, wrench);
        self.starts_s += turning_s + period_s;
        for (rest_rad, turn) in self.rests_rad.iter_mut().zip(&command.turns) {
            *rest_rad = turn.to_rad;
        }
        self.contacts(command)
    }

    /// Pose and velocity now.
    #[must_use]
    pub fn pose(&self) -> PoseSample {
        self.hull.pose()
    }

    /// Where each tail rests when the running cycle ends, rad.
    #[must_use]
    pub fn rests_rad(&self) -> &[f64] {
        &self.rests_rad
    }

    /// When the next cycle starts, from the start of the first, s.
    #[must_use]
    pub fn starts_s(&self) -> f64 {
        self.starts_s
    }

    /// `span_s` under `wrench`, in equal steps.
    fn push(&mut self, span_s: f64, wrench: Wrench) {
        let steps = (span_s / STEP_S).ceil().max(0.0);
        for _ in 0..steps as u32 {
            self.hull.step(span_s / steps, wrench);
        }
    }

    fn contacts(&self, command: &Command) -> usize {
        let turns = command.transition.0 > 0;
        let meets = |&(offset, [i, j]): &Pair| {
            let (one, other) = (command.turns[i], command.turns[j]);
            let (from, to) = ([one.from_rad, other.from_rad], [one.to_rad, other.to_rad]);
            let turn = turns && !self.distance.clear(offset, from, to, 0.0);
            let [from, to] = ends(command.cycle[i], command.cycle[j]);
            usize::from(turn) + usize::from(!self.distance.clear(offset, from, to, 0.0))
        };
        self.pairs.iter().map(meets).sum()
    }
}
